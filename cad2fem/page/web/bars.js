// Bars: what is drawn of lines in a body, as lines of WebGL are a pixel wide and lie in the surface that they are on.

import * as THREE from 'three';

/** Sides of a bar. */
const SIDES = 5;
const AROUND = Array.from({ length: SIDES }, (_, k) => [Math.cos((2 * Math.PI * k) / SIDES), Math.sin((2 * Math.PI * k) / SIDES)]);

export class Bars {
  /** Bars of a radius [mm]; each is nothing until it is put somewhere. */
  constructor(count, radius) {
    Object.assign(this, { count, radius });
    this.geometry = new THREE.BufferGeometry();
    for (const name of ['position', 'normal', 'color']) {
      this.geometry.setAttribute(name, new THREE.BufferAttribute(new Float32Array(6 * SIDES * count), 3));
    }
    const index = new Uint32Array(6 * SIDES * count);
    for (let i = 0; i < count; i++) {
      for (let k = 0; k < SIDES; k++) {
        const [a, b] = [2 * SIDES * i + k, 2 * SIDES * i + ((k + 1) % SIDES)];
        index.set([a, b, a + SIDES, b, b + SIDES, a + SIDES], 6 * (SIDES * i + k));
      }
    }
    this.geometry.setIndex(new THREE.BufferAttribute(index, 1));
    this.object = new THREE.Mesh(this.geometry, new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide }));
    this.object.frustumCulled = false;
    this.object.raycast = () => {};
    // the camera is parallel: what comes nearer to it stays where it is seen
    this.object.onBeforeRender = (renderer, scene, camera) => {
      const back = new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, 2);
      this.object.matrixWorld.setPosition(back.multiplyScalar(this.clipped ? this.radius : this.nearer));
    };
    this.nearer = radius;
    this.clipped = false;
  }

  /** Lays a bar from a to b, both [x, y, z] in mm. */
  put(i, a, b) {
    const along = [0, 1, 2].map((c) => b[c] - a[c]);
    const length = Math.hypot(...along) || 1;
    const t = along.map((x) => x / length);
    const least = Math.abs(t[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0];
    const across = cross(t, least);
    const size = Math.hypot(...across);
    const n = across.map((x) => x / size);
    const m = cross(t, n);
    const { position, normal } = this.geometry.attributes;
    AROUND.forEach(([cos, sin], k) => {
      const [start, end] = [3 * (2 * SIDES * i + k), 3 * (2 * SIDES * i + SIDES + k)];
      for (let c = 0; c < 3; c++) {
        const out = cos * n[c] + sin * m[c];
        normal.array[start + c] = out;
        normal.array[end + c] = out;
        position.array[start + c] = a[c] + this.radius * out;
        position.array[end + c] = b[c] + this.radius * out;
      }
    });
  }

  /** All bars lie where they should now. */
  moved() {
    this.geometry.attributes.position.needsUpdate = true;
    this.geometry.attributes.normal.needsUpdate = true;
  }

  /** Gives bar i the colour `color(i)`, linear red, green and blue. */
  paint(color) {
    const { color: colors } = this.geometry.attributes;
    for (let i = 0; i < this.count; i++) {
      const one = color(i);
      for (let k = 0; k < 2 * SIDES; k++) colors.array.set(one, 3 * (2 * SIDES * i + k));
    }
    colors.needsUpdate = true;
  }

  /** Removes what is beyond planes. Behind a cut nothing shows through what is in front of it. */
  clip(planes) {
    this.clipped = planes.length > 0;
    this.object.material.clippingPlanes = planes;
  }
}

export function cross([a, b, c], [x, y, z]) {
  return [b * z - c * y, c * x - a * z, a * y - b * x];
}
