// Threads on and in a body, see threads.rs: they move with the facets that their segments end on.

import { numbers } from 'page/arrays';
import { Bars } from 'page/bars';
import { heat, rgb } from 'page/color';

const MM = 1e3;
/** Radius over the size of the body. */
const RADIUS = 2e-3;
/** Where no force is known. */
const PLAIN = '#d6336c';

export class Threads {
  /** The threads of a run on its solid; null where it has none. */
  static async of(packed, solid) {
    if (!packed) return null;
    const keys = ['facets', 'facetOfPoint', 'places', 'segments', 'forces'];
    const arrays = await Promise.all(keys.map((key) => numbers(packed[key])));
    return new Threads(packed, Object.fromEntries(keys.map((key, i) => [key, arrays[i]])), solid);
  }

  constructor(packed, arrays, solid) {
    Object.assign(this, arrays, { solid, perFacet: packed.facets.components, range: [0, packed.largest] });
    this.points = new Float32Array(3 * this.facetOfPoint.length);
    const size = solid.size();
    this.bars = new Bars(this.forces.length, RADIUS * size);
    // those below a skin are seen through it, and those on the far side of the body are not
    this.bars.nearer = this.bars.radius + 1.5 * MM * packed.depth;
  }

  /** Follows the solid. */
  move() {
    const { points } = this.solid;
    for (let p = 0; p < this.facetOfPoint.length; p++) {
      const shares = shape(this.places[2 * p], this.places[2 * p + 1], this.perFacet);
      const first = this.facetOfPoint[p] * this.perFacet;
      for (let c = 0; c < 3; c++) {
        let at = 0;
        for (let i = 0; i < this.perFacet; i++) at += shares[i] * points[3 * this.facets[first + i] + c];
        this.points[3 * p + c] = at;
      }
    }
    const at = (p) => this.points.subarray(3 * p, 3 * p + 3);
    for (let i = 0; i < this.forces.length; i++) this.bars.put(i, at(this.segments[2 * i]), at(this.segments[2 * i + 1]));
    this.bars.moved();
  }

  /** Colours by force, which is known in the last state alone. */
  paint(known) {
    const plain = rgb(PLAIN);
    this.bars.paint(known ? (i) => heat(this.forces[i], this.range) : () => plain);
  }

  /** Length of all threads as they are now [mm]. */
  length() {
    const at = (p) => this.points.subarray(3 * p, 3 * p + 3);
    let sum = 0;
    for (let i = 0; i < this.forces.length; i++) {
      const [a, b] = [at(this.segments[2 * i]), at(this.segments[2 * i + 1])];
      sum += Math.hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
    }
    return sum;
  }
}

/** Shape functions of a facet at the weights b and c of its second and third corner: corners, then middles of sides. */
function shape(b, c, perFacet) {
  const a = 1 - b - c;
  if (perFacet === 3) return [a, b, c];
  return [a * (2 * a - 1), b * (2 * b - 1), c * (2 * c - 1), 4 * a * b, 4 * b * c, 4 * c * a];
}
