// The body in 3-D: its faces in the colours of their tags, cut, and hit by rays.

import * as THREE from 'three';
import { Cap } from 'page/cap';
import { around, shade } from 'page/surface';
import { NONE } from 'pick/tags';

const BARE = '#d5d9de';
const NO_REGION = '#a9aeb5';
const INK = '#2c3540';

export class Body {
  constructor(nodes, triangles, faces) {
    Object.assign(this, { nodes, triangles, faces, hidden: new Set(), painted: [], plane: null });
    this.face = new Uint16Array(triangles.length / 3);
    faces.forEach(({ triangles: [from, to] }, i) => this.face.fill(i, from, to));
    this.shape = new THREE.BufferGeometry();
    const [positions, normals] = [0, 1].map(() => new Float32Array(3 * triangles.length));
    shade(nodes, triangles, around(nodes.length / 3, triangles), positions, normals);
    this.colors = new Float32Array(3 * triangles.length);
    const attributes = { position: positions, normal: normals, color: this.colors };
    for (const [name, array] of Object.entries(attributes)) this.shape.setAttribute(name, new THREE.BufferAttribute(array, 3));
    this.shape.computeBoundingBox();
    this.mesh = new THREE.Mesh(this.shape, new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
    this.mesh.renderOrder = 100;
    // faces that are seen through
    this.glass = new THREE.BufferGeometry();
    for (const name of ['position', 'normal']) this.glass.setAttribute(name, this.shape.attributes[name]);
    this.ghost = new THREE.Mesh(this.glass, new THREE.MeshLambertMaterial({ color: '#aeb8c4', side: THREE.DoubleSide, transparent: true, opacity: 0.16, depthWrite: false }));
    this.ghost.renderOrder = 101;
    this.lines = new THREE.LineSegments(this.rims(), new THREE.LineBasicMaterial({ color: INK, transparent: true, opacity: 0.55 }));
    this.lines.renderOrder = 101;
    // the face under the pointer, faintly also where it is hidden
    this.marks = [true, false].map((depthTest) => {
      const mark = new THREE.BufferGeometry();
      mark.setAttribute('position', this.shape.attributes.position);
      mark.setDrawRange(0, 0);
      const material = new THREE.MeshBasicMaterial({ color: '#0a84ff', side: THREE.DoubleSide, transparent: true, opacity: depthTest ? 0.55 : 0.25, depthTest, depthWrite: false });
      const mesh = new THREE.Mesh(mark, material);
      mesh.renderOrder = 102;
      return mesh;
    });
    // sheets inside have no inside of their own, so a cut through them has no face
    const closed = faces.filter((face) => !face.inside).reduce((most, { triangles: [, to] }) => Math.max(most, to), 0);
    const skin = new THREE.BufferGeometry();
    skin.setAttribute('position', this.shape.attributes.position);
    skin.setDrawRange(0, 3 * closed);
    skin.boundingBox = this.shape.boundingBox;
    this.cap = new Cap(skin, new THREE.Color('#f3ead6'), 0);
    this.ray = new THREE.Raycaster();
    this.boxes = faces.map(({ triangles: [from, to] }) => new THREE.Box3().setFromArray(positions.subarray(9 * from, 9 * to)));
    this.objects = [this.mesh, this.ghost, this.lines, ...this.marks, ...this.cap.meshes];
    this.show(null, new Set(), new Set());
  }

  /** The lines at which faces meet. */
  rims() {
    const { triangles, nodes } = this;
    const count = nodes.length / 3;
    const sides = new Map();
    const positions = [];
    for (let i = 0; i < triangles.length; i++) {
      const [u, v] = [triangles[i], triangles[i % 3 === 2 ? i - 2 : i + 1]];
      const key = Math.min(u, v) * count + Math.max(u, v);
      const own = this.face[Math.floor(i / 3)];
      const other = sides.get(key);
      if (other === undefined) sides.set(key, own);
      else if (other !== own) for (const p of [u, v]) positions.push(nodes[3 * p], nodes[3 * p + 1], nodes[3 * p + 2]);
    }
    const rims = new THREE.BufferGeometry();
    rims.setAttribute('position', new THREE.BufferAttribute(new Float32Array(positions), 3));
    return rims;
  }

  /** Colours faces by their tags. */
  paint(tags) {
    this.faces.forEach(({ triangles: [from, to], file }, i) => {
      const color = !file ? NO_REGION : tags.of[i] === NONE ? BARE : tags.color(tags.of[i]);
      if (this.painted[i] === color) return;
      this.painted[i] = color;
      const { r, g, b } = new THREE.Color(color);
      for (let k = 9 * from; k < 9 * to; k += 3) this.colors.set([r, g, b], k);
    });
    this.shape.attributes.color.needsUpdate = true;
  }

  /** Shows all but hidden faces, some as ghosts, up to a plane. */
  show(plane, hidden, ghosts) {
    this.plane = plane;
    this.hidden = hidden;
    const sets = [[...hidden], [...ghosts]].join(';');
    if (sets !== this.sets) {
      this.sets = sets;
      const all = this.faces.map((_, i) => i).filter((i) => !hidden.has(i));
      this.shape.setIndex(sets === ';' ? null : this.corners(all.filter((i) => !ghosts.has(i))));
      this.glass.setIndex(this.corners(all.filter((i) => ghosts.has(i))));
    }
    const planes = plane ? [new THREE.Plane(new THREE.Vector3(...plane.normal).negate(), plane.offset)] : [];
    for (const mesh of [this.mesh, this.ghost, this.lines, ...this.marks]) mesh.material.clippingPlanes = planes;
    this.cap.relook(plane, hidden.size + ghosts.size > 0, new THREE.Vector3());
    this.capped = plane !== null && hidden.size + ghosts.size === 0;
  }

  /** The corners of some faces, for an index. */
  corners(faces) {
    const ranges = faces.map((i) => this.faces[i].triangles);
    const index = new Uint32Array(ranges.reduce((sum, [from, to]) => sum + 3 * (to - from), 0));
    let next = 0;
    for (const [from, to] of ranges) for (let k = 3 * from; k < 3 * to; k++) index[next++] = k;
    return new THREE.BufferAttribute(index, 1);
  }

  /** Marks faces. */
  mark(faces) {
    const index = this.corners(faces);
    for (const { geometry } of this.marks) {
      geometry.setIndex(index);
      geometry.setDrawRange(0, index.count);
    }
  }

  /** The face that is seen at a place of the canvas, from -1 to 1; none beside the body and on the cut. */
  at(x, y, camera) {
    this.ray.setFromCamera(new THREE.Vector2(x, y), camera);
    const { ray } = this.ray;
    const corners = [0, 1, 2].map(() => new THREE.Vector3());
    const point = new THREE.Vector3();
    const normal = this.plane && new THREE.Vector3(...this.plane.normal);
    let nearest = { distance: Infinity, face: null, triangle: 0 };
    this.faces.forEach(({ triangles: [from, to] }, face) => {
      if (this.hidden.has(face) || !ray.intersectsBox(this.boxes[face])) return;
      for (let t = from; t < to; t++) {
        corners.forEach((corner, k) => corner.fromBufferAttribute(this.shape.attributes.position, 3 * t + k));
        if (!ray.intersectTriangle(...corners, false, point)) continue;
        if (normal && point.dot(normal) > this.plane.offset) continue;
        const distance = ray.origin.distanceToSquared(point);
        if (distance < nearest.distance) nearest = { distance, face, back: this.outward(t).dot(ray.direction) > 0 };
      }
    });
    // the back of a wall is behind the face of the cut
    return nearest.back && this.capped ? null : nearest.face;
  }

  /** The direction in which a triangle faces, of any length. */
  outward(t) {
    const [a, b, c] = [0, 1, 2].map((k) => this.corner(t, k));
    return b.sub(a).cross(c.sub(a));
  }

  corner(t, k) {
    return new THREE.Vector3().fromBufferAttribute(this.shape.attributes.position, 3 * t + k);
  }
}
