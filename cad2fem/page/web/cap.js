// The face that a plane leaves on a closed surface.

import * as THREE from 'three';

/** The plane n·p = offset across an axis at a part of a box; null without an axis. */
export function planeAcross(box, { axis, at, sign }) {
  const c = ['x', 'y', 'z'].indexOf(axis);
  if (c < 0) return null;
  const [low, high] = [box.min.getComponent(c), box.max.getComponent(c)];
  const normal = [0, 0, 0];
  normal[c] = sign;
  return { normal, offset: sign * (low + at * (high - low)) };
}

/** Three meshes that cap a closed surface where a plane cuts it: where the stencil counts more back than front faces. */
export class Cap {
  constructor(shape, color, order) {
    this.shape = shape;
    this.counters = [[THREE.BackSide, THREE.IncrementWrapStencilOp], [THREE.FrontSide, THREE.DecrementWrapStencilOp]].map(([side, op]) => {
      const material = new THREE.MeshBasicMaterial({
        side, depthWrite: false, depthTest: false, colorWrite: false, stencilWrite: true, stencilFunc: THREE.AlwaysStencilFunc,
        stencilFail: op, stencilZFail: op, stencilZPass: op,
      });
      const mesh = new THREE.Mesh(shape, material);
      mesh.renderOrder = order + 0.1;
      mesh.raycast = () => {};
      return mesh;
    });
    const material = new THREE.MeshBasicMaterial({
      color, side: THREE.DoubleSide, stencilWrite: true, stencilRef: 0, stencilFunc: THREE.NotEqualStencilFunc,
      stencilFail: THREE.ReplaceStencilOp, stencilZFail: THREE.ReplaceStencilOp, stencilZPass: THREE.ReplaceStencilOp,
    });
    this.face = new THREE.Mesh(new THREE.PlaneGeometry(1, 1), material);
    this.face.renderOrder = order + 0.2;
    this.face.raycast = () => {};
    this.face.onAfterRender = (renderer) => renderer.clearStencil();
    this.meshes = [...this.counters, this.face];
  }

  /** Follows the plane n·p = offset; the surface is moved by `shift`. */
  relook(plane, hidden, shift) {
    const planes = plane ? [new THREE.Plane(new THREE.Vector3(...plane.normal).negate(), plane.offset)] : [];
    for (const mesh of this.counters) mesh.material.clippingPlanes = planes;
    for (const mesh of this.meshes) mesh.visible = Boolean(plane) && !hidden;
    if (!plane) return;
    const normal = new THREE.Vector3(...plane.normal);
    const centre = this.shape.boundingBox.getCenter(new THREE.Vector3());
    centre.addScaledVector(normal, plane.offset - normal.dot(shift) - normal.dot(centre));
    this.face.position.copy(centre);
    this.face.quaternion.setFromUnitVectors(new THREE.Vector3(0, 0, 1), normal);
    this.face.scale.setScalar(2 * this.shape.boundingBox.getSize(new THREE.Vector3()).length());
  }
}
