// Numbers of faces, drawn over the body at the middles of those that are seen.

import * as THREE from 'three';

/** How long the body has to stand still before its faces get numbers [ms]. */
const STILL = 120;
/** Height of a number, and width of each of its letters [px]. */
const [HIGH, WIDE] = [15, 8];

/** A face as its number says it: `12` of `face-12`, else its name. */
function short(name) {
  return name.replace(/^face-(?=\d+$)/, '');
}

export class Labels {
  constructor(stage, body, root) {
    Object.assign(this, { stage, body, root, on: false });
    this.places = body.faces.map((face) => place(body, face));
    // where there is room for one alone, the larger face has it
    this.order = body.faces.map((_, i) => i).sort((a, b) => body.faces[b].area - body.faces[a].area);
  }

  set(on) {
    this.on = on;
    this.stage.invalidate();
  }

  /** After each picture: the numbers go, and come back when the body stands still. */
  redraw() {
    clearTimeout(this.waiting);
    this.root.replaceChildren();
    if (this.on) this.waiting = setTimeout(() => this.show(), STILL);
  }

  show() {
    const taken = [];
    const free = ({ x, y, half }) => taken.every((other) => Math.abs(other.x - x) > other.half + half || Math.abs(other.y - y) > HIGH);
    for (const face of this.order) {
      const spot = this.spot(face);
      if (spot && free(spot) && this.isSeen(face)) taken.push(spot);
    }
    this.root.replaceChildren(...taken.map(({ x, y, text }) => {
      const span = document.createElement('span');
      span.textContent = text;
      Object.assign(span.style, { left: `${x}px`, top: `${y}px` });
      return span;
    }));
  }

  /** Where the number of a face would stand [px]; none where the face looks away. */
  spot(face) {
    const { point, normal } = this.places[face];
    const { camera, canvas } = this.stage;
    const inward = camera.getWorldDirection(new THREE.Vector3());
    if (!this.body.faces[face].inside && normal.dot(inward) > -0.05) return null;
    const text = short(this.body.faces[face].name);
    const [x, y] = this.stage.project(point, 0);
    const half = 0.5 * WIDE * text.length + 2;
    const within = x > half && y > HIGH && x < canvas.clientWidth - half && y < canvas.clientHeight - HIGH;
    return within ? { x, y, half, text } : null;
  }

  /** Whether nothing hides the middle of a face. */
  isSeen(face) {
    const { x, y } = this.places[face].point.clone().project(this.stage.camera);
    return this.body.at(x, y, this.stage.camera) === face;
  }
}

/** The middle of the triangle of a face that is nearest to the middle of the face, and its normal. */
function place(body, { middle, triangles: [from, to] }) {
  const centre = new THREE.Vector3(...middle);
  let nearest = { distance: Infinity };
  for (let t = from; t < to; t++) {
    const point = body.corner(t, 0).add(body.corner(t, 1)).add(body.corner(t, 2)).divideScalar(3);
    const distance = point.distanceToSquared(centre);
    if (distance < nearest.distance) nearest = { distance, point, t };
  }
  return { point: nearest.point, normal: body.outward(nearest.t).normalize() };
}
