// A solid on the stage: its surface, the chambers in it, and the face where it is cut.

import * as THREE from 'three';
import { numbers } from 'page/arrays';
import { CAST, PALETTE, UNTAGGED, digits, rgb, viridis } from 'page/color';
import { cut, outline } from 'page/section';
import { around, shade } from 'page/surface';

/** The page's unit of length is the millimetre. */
export const MM = 1e3;

// The triangles of a facet: of a quadratic one, whose middles come after its corners, there are four.
const DIVIDED = { 3: [[0, 1, 2]], 6: [[0, 3, 5], [3, 1, 4], [5, 4, 2], [3, 4, 5]] };
const INLET = '#d6336c';
const [DARK, GHOST, OTHER] = ['#10161d', '#9aa4ae', '#e8590c'];

/** A point as people read it. */
export function coordinates({ x, y, z }) {
  return `(${[x, y, z].map((v) => (v + 0).toFixed(2)).join(', ')}) mm`;
}

/** A thinnest wall in words. */
export function wallText({ thickness }) {
  return `thinnest wall ${digits(MM * thickness)} mm`;
}

export class Solid {
  /** From what `solid.rs` packed; `chambers` are the tags of their walls. */
  static async of(packed, chambers) {
    const [nodes, facets, tagOfFacet, cells, cellOfFacet] = await Promise.all(
      ['nodes', 'facets', 'tagOfFacet', 'cells', 'cellOfFacet'].map((key) => packed[key] && numbers(packed[key])),
    );
    return new Solid({ packed, nodes, facets, tagOfFacet, cells, cellOfFacet }, chambers);
  }

  constructor({ packed, nodes, facets, tagOfFacet, cells, cellOfFacet }, chambers) {
    Object.assign(this, { facets, tagOfFacet, cells, cellOfFacet, tags: packed.tags });
    this.perFacet = packed.facets.components;
    this.perCell = packed.cells?.components;
    this.rest = nodes.map((x) => MM * x);
    this.points = this.rest.slice();
    this.isChamber = packed.tags.map((tag) => chambers.some((name) => name === tag || name.endsWith(`.${tag}`)));
    this.divide();
    this.around = around(nodes.length / 3, this.triangles);
    this.build();
    this.move(null, 0);
  }

  get facetCount() {
    return this.tagOfFacet.length;
  }

  inChamber(facet) {
    return this.isChamber[this.tagOfFacet[facet]] ?? false;
  }

  /** Triangles of all facets, those of chambers last. */
  divide() {
    const all = [...this.tagOfFacet.keys()];
    const order = [...all.filter((f) => !this.inChamber(f)), ...all.filter((f) => this.inChamber(f))];
    const divided = DIVIDED[this.perFacet];
    this.triangles = new Uint32Array(3 * divided.length * order.length);
    this.facetOf = new Uint32Array(divided.length * order.length);
    let next = 0;
    for (const f of order) {
      for (const corners of divided) {
        this.facetOf[next] = f;
        for (let i = 0; i < 3; i++) this.triangles[3 * next + i] = this.facets[f * this.perFacet + corners[i]];
        next += 1;
      }
    }
    this.outside = divided.length * order.filter((f) => !this.inChamber(f)).length;
  }

  build() {
    const corners = this.triangles.length;
    this.surface = new THREE.BufferGeometry();
    for (const name of ['position', 'normal', 'color']) {
      this.surface.setAttribute(name, new THREE.BufferAttribute(new Float32Array(3 * corners), 3));
    }
    const part = (start, count) => {
      const geometry = new THREE.BufferGeometry();
      for (const [name, attribute] of Object.entries(this.surface.attributes)) geometry.setAttribute(name, attribute);
      geometry.setDrawRange(3 * start, 3 * count);
      const material = new THREE.MeshLambertMaterial({ vertexColors: true, side: THREE.DoubleSide });
      const mesh = new THREE.Mesh(geometry, material);
      mesh.frustumCulled = false;
      mesh.userData.solid = this;
      return mesh;
    };
    this.outer = part(0, this.outside);
    this.chamber = part(this.outside, corners / 3 - this.outside);
    this.face = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({
      vertexColors: true, side: THREE.DoubleSide, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 2,
    }));
    this.face.frustumCulled = false;
    this.face.userData.solid = this;
    this.outline = lines([], { color: DARK });
    const { edges, rims } = this.sides();
    this.edges = lines(edges, { color: DARK, transparent: true, opacity: 0.35 });
    this.inlets = new THREE.Mesh(new THREE.BufferGeometry(), new THREE.MeshBasicMaterial({ color: INLET, side: THREE.DoubleSide }));
    this.inlets.frustumCulled = false;
    this.inlets.raycast = () => {};
    this.rims = loops(rims);
    this.group = new THREE.Group();
    this.group.add(this.outer, this.chamber, this.face, this.edges.object, this.inlets, this.outline.object);
  }

  /** Sides of facets, each once, and those where a chamber opens: pairs of nodes. */
  sides() {
    const seen = new Map();
    const count = this.rest.length / 3;
    const k = this.perFacet;
    for (let f = 0; f < this.facetCount; f++) {
      for (let i = 0; i < 3; i++) {
        const [a, b] = [this.facets[f * k + i], this.facets[f * k + ((i + 1) % 3)]];
        const key = Math.min(a, b) * count + Math.max(a, b);
        const pairs = k === 6 ? [a, this.facets[f * k + 3 + i], this.facets[f * k + 3 + i], b] : [a, b];
        const known = seen.get(key);
        if (known) known.chambers += this.inChamber(f);
        else seen.set(key, { pairs, chambers: Number(this.inChamber(f)) });
      }
    }
    const all = [...seen.values()];
    const rims = all.filter(({ chambers }) => chambers === 1);
    return { edges: all.flatMap(({ pairs }) => pairs), rims: rims.flatMap(({ pairs }) => pairs) };
  }

  /** Moves the points by a displacement [m] times a factor; without one to rest. */
  move(displacement, factor) {
    this.points.set(this.rest);
    if (displacement) for (let i = 0; i < this.points.length; i++) this.points[i] += MM * factor * displacement[i];
    const { position, normal } = this.surface.attributes;
    shade(this.points, this.triangles, this.around, position.array, normal.array);
    position.needsUpdate = true;
    normal.needsUpdate = true;
    // where rays meet them
    for (const { geometry } of [this.outer, this.chamber]) geometry.boundingSphere = null;
    const { nodes, object } = this.edges;
    const ends = object.geometry.attributes.position;
    nodes.forEach((v, i) => {
      for (let c = 0; c < 3; c++) ends.array[3 * i + c] = this.points[3 * v + c];
    });
    ends.needsUpdate = true;
    replace(this.inlets, new Float32Array(this.rims.flatMap((rim) => this.fan(rim))));
  }

  /** Triangles between the sides of a rim and its middle. */
  fan(rim) {
    const at = (v) => [0, 1, 2].map((c) => this.points[3 * v + c]);
    const middle = [0, 1, 2].map((c) => rim.reduce((sum, v) => sum + this.points[3 * v + c], 0) / rim.length);
    const found = [];
    for (let i = 0; i < rim.length; i += 2) found.push(...at(rim[i]), ...at(rim[i + 1]), ...middle);
    return found;
  }

  /** Colours by values at `nodes`, `cells` or `facets` in a range; by tags without values. */
  paint(field) {
    this.field = field;
    const colors = this.surface.attributes.color;
    const tags = [...this.tags.keys()].map((i) => rgb(PALETTE[i % PALETTE.length]));
    const untagged = rgb(UNTAGGED);
    const cornerColor = (i) => {
      const facet = this.facetOf[Math.floor(i / 3)];
      if (!field) return tags[this.tagOfFacet[facet]] ?? untagged;
      if (field.at === 'nodes') return viridis(field.values[this.triangles[i]], field.range);
      return viridis(field.values[field.at === 'cells' ? this.cellOfFacet[facet] : facet], field.range);
    };
    for (let i = 0; i < this.triangles.length; i++) colors.array.set(cornerColor(i), 3 * i);
    colors.needsUpdate = true;
  }

  tint(color) {
    const colors = this.surface.attributes.color;
    const one = rgb(color);
    for (let i = 0; i < this.triangles.length; i++) colors.array.set(one, 3 * i);
    colors.needsUpdate = true;
  }

  /** What three.js is told of a plane n·p = offset; nothing where there is none. */
  planes(plane) {
    return plane ? [new THREE.Plane(new THREE.Vector3(...plane.normal).negate(), plane.offset)] : [];
  }

  /** Removes what is beyond a plane n·p = offset, and shows the face of the cut. */
  cut(plane) {
    const planes = this.planes(plane);
    for (const object of [this.outer, this.chamber, this.inlets, this.edges.object]) {
      object.material.clippingPlanes = planes;
    }
    this.outline.object.visible = Boolean(plane);
    if (plane) replace(this.outline.object, outline(this.points, this.triangles, plane));
    this.face.visible = Boolean(plane && this.cells);
    if (!this.face.visible) return;
    const source = this.field?.at === 'facets' ? null : this.field?.values;
    const { positions, values } = cut(this.points, this.cells, this.perCell, plane, source, this.field?.at === 'cells');
    this.faceValues = source ? values : null;
    const colors = new Float32Array(positions.length);
    const plain = rgb(CAST);
    for (let i = 0; i < colors.length / 3; i++) colors.set(source ? viridis(values[i], this.field.range) : plain, 3 * i);
    replace(this.face, positions).setAttribute('color', new THREE.BufferAttribute(colors, 3));
  }

  /** What is at a point of it that a ray met: the value of the field, the tag, and where the point goes with the body. */
  read({ object, face, point }) {
    const corners = [face.a, face.b, face.c];
    const { position } = object.geometry.attributes;
    const triangle = corners.map((i) => new THREE.Vector3().fromBufferAttribute(position, i));
    const weights = THREE.Triangle.getBarycoord(point, ...triangle, new THREE.Vector3())?.toArray() ?? [1, 0, 0];
    const mixed = (values) => values.reduce((sum, v, i) => sum + weights[i] * v, 0);
    if (object === this.face) {
      return { value: this.faceValues ? mixed(corners.map((i) => this.faceValues[i])) : null, anchor: () => point };
    }
    const nodes = corners.map((i) => this.triangles[i]);
    const facet = this.facetOf[Math.floor(face.a / 3)];
    const { at, values } = this.field ?? {};
    const own = { cells: () => values[this.cellOfFacet[facet]], facets: () => values[facet], nodes: () => mixed(nodes.map((v) => values[v])) };
    return {
      value: this.field ? own[at]() : null,
      tag: this.tags[this.tagOfFacet[facet]],
      anchor: () => new THREE.Vector3(...[0, 1, 2].map((c) => mixed(nodes.map((v) => this.points[3 * v + c])))),
    };
  }

  /** The node that is nearest to a place at rest [m]. */
  nearest(place) {
    let [best, least] = [0, Infinity];
    for (let v = 0; v < this.rest.length / 3; v++) {
      const apart = Math.hypot(...[0, 1, 2].map((c) => this.rest[3 * v + c] - MM * place[c]));
      if (apart < least) [best, least] = [v, apart];
    }
    return best;
  }

  /** Where a node is. */
  point(v) {
    return new THREE.Vector3(...this.points.subarray(3 * v, 3 * v + 3));
  }

  /** How much the outside hides, and whether the sides of facets are drawn. */
  look({ opacity, lines }) {
    const seeThrough = opacity < 1;
    glaze(this.outer, opacity);
    glaze(this.chamber, 1);
    this.outer.visible = opacity > 0;
    this.inlets.visible = seeThrough;
    this.edges.object.visible = lines;
    this.outline.object.material.color.set(DARK);
  }

  /** As one that is only there to be compared with: grey glass, and where it is cut an outline. */
  fade(plane) {
    this.tint(GHOST);
    this.cut(plane);
    this.look({ opacity: 0.3, lines: false });
    glaze(this.chamber, 0.3);
    // what is in the same place is that which it is compared with
    for (const { material } of [this.outer, this.chamber]) Object.assign(material, { polygonOffset: true, polygonOffsetFactor: 2, polygonOffsetUnits: 4 });
    this.outline.object.material.color.set(OTHER);
    for (const object of [this.face, this.inlets]) object.visible = false;
  }

  get sectionTriangles() {
    const { position } = this.face.geometry.attributes;
    return this.face.visible && position ? position.count / 3 : 0;
  }

  box() {
    return new THREE.Box3().setFromArray(this.points);
  }

  /** The diagonal of the box around it at rest [mm]. */
  size() {
    return new THREE.Box3().setFromArray(this.rest).getSize(new THREE.Vector3()).length();
  }
}

function glaze(mesh, opacity) {
  const seeThrough = opacity < 1;
  Object.assign(mesh.material, { opacity, transparent: seeThrough, depthWrite: !seeThrough, polygonOffset: false, needsUpdate: true });
  mesh.renderOrder = seeThrough ? 1 : 0;
}

/** Sides, as pairs of nodes, by what is connected. */
function loops(pairs) {
  const parent = new Map();
  const root = (v) => {
    let r = v;
    while ((parent.get(r) ?? r) !== r) r = parent.get(r);
    return r;
  };
  for (let i = 0; i < pairs.length; i += 2) parent.set(root(pairs[i]), root(pairs[i + 1]));
  const found = new Map();
  for (let i = 0; i < pairs.length; i += 2) {
    const key = root(pairs[i]);
    if (!found.has(key)) found.set(key, []);
    found.get(key).push(pairs[i], pairs[i + 1]);
  }
  return [...found.values()];
}

/** Gives an object other points. */
function replace(object, positions) {
  object.geometry.dispose();
  object.geometry = new THREE.BufferGeometry();
  object.geometry.setAttribute('position', new THREE.BufferAttribute(positions, 3));
  return object.geometry;
}

function lines(nodes, look) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute('position', new THREE.BufferAttribute(new Float32Array(3 * nodes.length), 3));
  const object = new THREE.LineSegments(geometry, new THREE.LineBasicMaterial(look));
  object.frustumCulled = false;
  object.raycast = () => {};
  return { nodes, object };
}
