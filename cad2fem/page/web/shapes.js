// Shapes at rest: what each level of an optimisation began with, and the design.

import * as THREE from 'three';
import { PALETTE } from 'page/color';
import { check, fieldset, select } from 'page/controls';
import { Solid, coordinates } from 'page/solid';

/** Shapes by the level that began with them; with several bodies there are several of each. */
export function sets(design) {
  const found = [];
  for (const shape of design.shapes) {
    const last = found.at(-1);
    if (last?.level === shape.level) last.shapes.push(shape);
    else found.push({ level: shape.level, shapes: [shape] });
  }
  for (const set of found) {
    set.name = set.level === null ? 'the design' : set.level === 1 ? 'the start' : `after level ${set.level - 1}`;
  }
  return found;
}

export class Shapes {
  title = 'Shapes';

  constructor(stage, designs, chambers, look, changed) {
    Object.assign(this, { stage, designs, chambers, look, changed, solids: new Map() });
    this.set = { design: 0, shape: designs[0].sets.length - 1, ghost: false };
  }

  panel() {
    const choices = this.designs.flatMap((design, d) => design.sets.map((set, s) => {
      const name = this.designs.length > 1 ? `${design.name}: ${set.name}` : set.name;
      return [`${d}/${s}`, name];
    }));
    this.list = select('shape', choices, this.value, (value) => this.choose(...value.split('/').map(Number)));
    this.list.list.id = 'shape';
    return [fieldset(null, this.list, check('the start over it, in grey', this.set.ghost, (on) => {
      this.set.ghost = on;
      this.refresh();
    }))];
  }

  get value() {
    return `${this.set.design}/${this.set.shape}`;
  }

  async choose(design, shape) {
    Object.assign(this.set, { design, shape });
    this.list.list.value = this.value;
    await this.refresh();
  }

  solidsOf(set) {
    if (!this.solids.has(set)) this.solids.set(set, Promise.all(set.shapes.map((s) => Solid.of(s.body, this.chambers))));
    return this.solids.get(set);
  }

  async enter() {
    await this.refresh();
  }

  async refresh() {
    const turn = (this.turn = (this.turn ?? 0) + 1);
    const { sets } = this.designs[this.set.design];
    const shown = sets[this.set.shape];
    const [solids, start] = await Promise.all([shown, sets[0]].map((set) => this.solidsOf(set)));
    if (turn !== this.turn) return;
    this.ready = solids;
    this.start = this.set.ghost && shown !== sets[0] ? start : [];
    this.ready.forEach((solid) => solid.paint(null));
    this.stage.owner = this;
    this.stage.show([{ objects: [...this.ready, ...this.start].map((solid) => solid.group), name: shown.name }]);
    this.relook();
    this.changed();
  }

  relook() {
    if (!this.ready) return;
    const plane = this.look.plane(this.box());
    this.start.forEach((solid) => solid.fade(plane));
    for (const solid of this.ready) {
      solid.cut(plane);
      solid.look(this.look);
    }
    this.stage.invalidate();
  }

  points() {
    return this.ready?.map((solid) => solid.points) ?? [];
  }

  box() {
    const all = new THREE.Box3();
    this.ready?.forEach((solid) => all.union(solid.box()));
    return all;
  }

  /** What is at a point that a ray met. */
  read(hit) {
    const solid = hit.object.userData.solid;
    if (!solid) return null;
    const { tag, anchor } = solid.read(hit);
    return { text: tag ?? '', where: coordinates(hit.point), anchor };
  }

  legend() {
    const tags = [...new Set(this.ready?.flatMap((solid) => solid.tags))];
    return { names: tags.map((tag, i) => [tag, PALETTE[i % PALETTE.length]]) };
  }

  state() {
    const { sets } = this.designs[this.set.design];
    const triangles = this.ready?.reduce((sum, s) => sum + s.triangles.length / 3, 0);
    const sectionTriangles = this.ready?.reduce((sum, s) => sum + s.sectionTriangles, 0);
    return { files: sets[this.set.shape].shapes.map((s) => s.file), shape: sets[this.set.shape].name, triangles, sectionTriangles };
  }
}
