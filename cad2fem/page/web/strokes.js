// Directions of fibres as strokes, which turn and lengthen with the body.
//
// A stroke stands at a facet of the boundary whose cell has fibres, and where no such facet has any, at the middle of
// a cell. It is along F a₀: a₀ at rest, from the file, and F of the cell from its corners, D D₀⁻¹ with the three edges
// that leave its first corner as columns.

import { Bars, cross } from 'page/bars';
import { rgb } from 'page/color';

/** Most strokes of a family. */
const MOST = 3000;
/** Length of a stroke at rest over the distance between strokes, at most, and over the size of the body. */
const [OF_GAP, OF_SIZE] = [0.75, 0.03];
/** Radius over the length. */
const SLIM = 0.045;

export class Strokes {
  /** Strokes of a family on a solid with cells; `directions` has a₀ of every cell, zero where the family is not. */
  constructor(solid, directions, color) {
    Object.assign(this, { solid, directions });
    const [sites, gap] = thinned(this.places());
    this.sites = sites;
    this.length = Math.min(OF_GAP * gap, OF_SIZE * solid.size());
    this.bars = new Bars(sites.length, SLIM * this.length);
    this.bars.nearer = 0.3 * this.length;
    const one = rgb(color);
    this.bars.paint(() => one);
  }

  has(cell) {
    return this.directions[3 * cell] !== 0 || this.directions[3 * cell + 1] !== 0 || this.directions[3 * cell + 2] !== 0;
  }

  /** Where strokes may stand: the cell, and the nodes whose mean the place is. */
  places() {
    const { facets, perFacet, facetCount, cellOfFacet, cells, perCell } = this.solid;
    const found = [];
    for (let f = 0; f < facetCount; f++) {
      if (!this.has(cellOfFacet[f])) continue;
      // the middle one of the four triangles of a quadratic facet has the middles of its sides as corners
      found.push({ cell: cellOfFacet[f], nodes: facets.subarray(f * perFacet + perFacet - 3, (f + 1) * perFacet) });
    }
    if (found.length > 0) return this.measured(found);
    for (let cell = 0; cell * perCell < cells.length; cell++) {
      if (this.has(cell)) found.push({ cell, nodes: cells.subarray(cell * perCell, cell * perCell + 4) });
    }
    return this.measured(found);
  }

  measured(found) {
    return found.map((site) => ({ ...site, at: mean(this.solid.rest, site.nodes) }));
  }

  /** Follows the solid. */
  move() {
    const { rest, points, cells, perCell } = this.solid;
    /** Smallest and largest stretch along the strokes. */
    this.stretch = [Infinity, -Infinity];
    this.sites.forEach(({ cell, nodes }, i) => {
      const corners = cells.subarray(cell * perCell, cell * perCell + 4);
      const along = pushed(edges(rest, corners), edges(points, corners), this.directions.subarray(3 * cell, 3 * cell + 3));
      const stretch = Math.hypot(...along);
      this.stretch = [Math.min(this.stretch[0], stretch), Math.max(this.stretch[1], stretch)];
      const middle = mean(points, nodes);
      const half = along.map((x) => 0.5 * this.length * x);
      this.bars.put(i, middle.map((x, c) => x - half[c]), middle.map((x, c) => x + half[c]));
    });
    this.bars.moved();
  }
}

/** The three edges from the first corner. */
function edges(points, [o, ...others]) {
  return others.map((v) => [0, 1, 2].map((c) => points[3 * v + c] - points[3 * o + c]));
}

/** F a, where F takes three edges at rest to three others: the parts of a along the first, of the others. */
export function pushed([p, q, r], now, a) {
  const volume = dot(p, cross(q, r));
  const parts = [dot(a, cross(q, r)) / volume, dot(a, cross(r, p)) / volume, dot(a, cross(p, q)) / volume];
  return [0, 1, 2].map((c) => parts[0] * now[0][c] + parts[1] * now[1][c] + parts[2] * now[2][c]);
}

function mean(points, nodes) {
  return [0, 1, 2].map((c) => nodes.reduce((sum, v) => sum + points[3 * v + c], 0) / nodes.length);
}

/** At most so many places, evenly in space: one in each box of a grid. Also the distance between them, about. */
function thinned(places) {
  if (places.length === 0) return [places, 0];
  const low = [0, 1, 2].map((c) => places.reduce((least, { at }) => Math.min(least, at[c]), Infinity));
  const high = [0, 1, 2].map((c) => places.reduce((most, { at }) => Math.max(most, at[c]), -Infinity));
  let side = Math.hypot(...low.map((x, c) => high[c] - x)) / 35 || 1;
  for (;;) {
    const boxes = new Map();
    for (const place of places) {
      const key = place.at.map((x, c) => Math.floor((x - low[c]) / side)).join();
      if (!boxes.has(key)) boxes.set(key, place);
    }
    if (boxes.size <= MOST) return [[...boxes.values()], side];
    side *= 1.15;
  }
}

function dot(a, b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
