// The mold: its parts, closed or taken apart.

import * as THREE from 'three';
import { numbers } from 'page/arrays';
import { Cap } from 'page/cap';
import { CAST, PALETTE } from 'page/color';
import { check, fieldset, select, slider } from 'page/controls';
import { coordinates, wallText } from 'page/solid';
import { around, shade } from 'page/surface';

export class Mold {
  title = 'Mold';

  constructor(stage, molds, look) {
    Object.assign(this, { stage, molds, look, chosen: 0, apart: 1, parts: [], marked: true });
    this.hidden = new Set();
  }

  panel() {
    const { molds } = this;
    const which = molds.length > 1
      ? select('mold', molds.map((m, i) => [i, m.name]), this.chosen, (i) => this.choose(Number(i)))
      : null;
    this.list = fieldset('parts');
    this.slider = slider('apart', { min: 0, max: 1, step: 0.01, value: this.apart }, (t) => {
      this.apart = t;
      this.place();
    });
    this.slider.input.id = 'apart';
    return [
      fieldset(null, which, this.slider),
      this.list,
      molds.some((mold) => mold.wall) && fieldset(null, check('mark the thinnest wall', this.marked, (on) => {
        this.marked = on;
        this.stage.invalidate();
      })),
    ];
  }

  async enter() {
    const { parts } = this.molds[this.chosen];
    this.parts = await Promise.all(parts.map(async (part, i) => {
      const [nodes, triangles] = await Promise.all([numbers(part.nodes), numbers(part.triangles)]);
      return new Part(part, geometry(nodes, triangles), part.printed ? PALETTE[i % PALETTE.length] : CAST, i);
    }));
    this.hidden.clear();
    this.list.replaceChildren(this.list.firstChild, ...this.parts.map((part) => check(part.name, true, (on) => {
      if (on) this.hidden.delete(part); else this.hidden.add(part);
      this.place();
    }, part.color)));
    this.stage.show([{ objects: this.parts.map((part) => part.group) }]);
    this.place();
  }

  async choose(i) {
    this.chosen = i;
    await this.enter();
    this.stage.fit(this.points());
  }

  points() {
    return this.parts.map((part) => {
      const shift = part.shift(this.apart).toArray();
      return part.geometry.attributes.position.array.map((x, i) => x + shift[i % 3]);
    });
  }

  box() {
    const all = new THREE.Box3();
    for (const part of this.parts) all.union(part.geometry.boundingBox.clone().translate(part.shift(this.apart)));
    return all;
  }

  place() {
    for (const part of this.parts) {
      part.group.position.copy(part.shift(this.apart));
      part.group.visible = !this.hidden.has(part);
    }
    this.relook();
  }

  relook() {
    const plane = this.look.plane(this.box());
    this.parts.forEach((part) => part.relook(plane, this.look, this.hidden.has(part)));
    this.stage.invalidate();
  }

  /** What is at a point that a ray met; where it is in the closed mold. */
  read({ object, point }) {
    const { part } = object.userData;
    if (!part) return null;
    const closed = point.clone().sub(part.group.position);
    return { text: part.name, where: `${coordinates(closed)} in the closed mold`, anchor: () => closed.clone().add(part.group.position) };
  }

  /** Where the cast is thinnest. */
  marks() {
    const { wall } = this.molds[this.chosen];
    const cast = this.parts.find((part) => !part.printed);
    if (!this.marked || !wall || !cast || this.hidden.has(cast)) return [];
    return [{ text: wallText(wall), point: new THREE.Vector3(...wall.at).add(cast.group.position), pane: 0 }];
  }

  legend() {
    return { names: this.parts.map(({ name, color }) => [name, color]) };
  }

  state() {
    const triangles = this.parts.reduce((sum, part) => sum + part.geometry.attributes.position.count / 3, 0);
    const marks = this.marks().map(({ text }) => text);
    return { mold: this.molds[this.chosen].name, marks, parts: this.parts.map((p) => p.name), apart: this.apart, triangles };
  }
}

function geometry(nodes, triangles) {
  const made = new THREE.BufferGeometry();
  const [positions, normals] = [0, 1].map(() => new Float32Array(3 * triangles.length));
  shade(nodes, triangles, around(nodes.length / 3, triangles), positions, normals);
  made.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  made.setAttribute('normal', new THREE.BufferAttribute(normals, 3));
  made.computeBoundingBox();
  return made;
}

/** A closed surface whose cut is capped. */
class Part {
  constructor({ name, apart, printed }, shape, color, order) {
    Object.assign(this, { name, apart: new THREE.Vector3(...apart), printed, color, geometry: shape });
    this.mesh = new THREE.Mesh(shape, new THREE.MeshLambertMaterial({ color, side: THREE.DoubleSide }));
    this.mesh.renderOrder = 100;
    this.mesh.userData.part = this;
    this.cap = new Cap(shape, new THREE.Color(color).lerp(new THREE.Color('#fff6e6'), 0.45), order);
    this.group = new THREE.Group();
    this.group.add(this.mesh, ...this.cap.meshes);
  }

  /** Where it is when the mold is taken apart up to t. */
  shift(t) {
    return this.apart.clone().multiplyScalar(t);
  }

  relook(plane, { opacity }, hidden) {
    const planes = plane ? [new THREE.Plane(new THREE.Vector3(...plane.normal).negate(), plane.offset)] : [];
    this.mesh.material.clippingPlanes = planes;
    this.cap.relook(plane, hidden, this.group.position);
    // what is seen through the printed parts is the cast
    const alpha = this.printed ? opacity : 1;
    Object.assign(this.mesh.material, { opacity: alpha, transparent: alpha < 1, depthWrite: alpha === 1 });
    this.mesh.visible = alpha > 0;
    this.mesh.material.needsUpdate = true;
  }
}
