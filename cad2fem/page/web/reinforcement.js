// What is in a body beside its silicone: threads, and families of fibres.

import { numbers } from 'page/arrays';
import { Strokes } from 'page/strokes';
import { Threads } from 'page/threads';

/** Colours of families, apart from those of fields and tags. */
const COLORS = ['#ffffff', '#10161d', '#ff922b', '#e64980', '#22b8cf'];
const FIELD = /^fibre_(.+)_direction$/;

/** Names of the families of a run; none where the page has no cells. */
export function families(run) {
  if (!run.body.cells) return [];
  return run.states.at(-1).fields.map(({ name }) => name.match(FIELD)?.[1]).filter(Boolean);
}

/** The colour of a family by its place among all. */
export function familyColor(i) {
  return COLORS[i % COLORS.length];
}

export class Reinforcement {
  static async of(run, solid) {
    return new Reinforcement(run, solid, await Threads.of(run.threads, solid));
  }

  constructor(run, solid, threads) {
    Object.assign(this, { run, solid, threads, strokes: new Map(), planes: [] });
    if (threads) solid.group.add(threads.bars.object);
  }

  get layers() {
    return [this.threads, ...this.strokes.values()].filter(Boolean);
  }

  /** Shows the threads or not, and those families whose names are keys of `shown`, with their colours. */
  async show(threads, shown) {
    if (this.threads) this.threads.bars.object.visible = threads;
    const missing = families(this.run).filter((name) => shown.has(name) && !this.strokes.has(name));
    for (const name of missing) {
      const field = this.run.states.at(-1).fields.find((f) => f.name === `fibre_${name}_direction`);
      const strokes = new Strokes(this.solid, await numbers(field.values), shown.get(name));
      if (this.strokes.has(name)) continue;
      this.strokes.set(name, strokes);
      this.solid.group.add(strokes.bars.object);
    }
    for (const [name, strokes] of this.strokes) strokes.bars.object.visible = shown.has(name);
  }

  hide() {
    for (const { bars } of this.layers) bars.object.visible = false;
  }

  /** Follows the solid; the forces of threads are those of the last state. */
  move(isLast) {
    for (const layer of this.layers) if (layer.bars.object.visible) layer.move();
    this.threads?.paint(isLast);
  }

  clip(plane) {
    for (const { bars } of this.layers) bars.clip(this.solid.planes(plane));
  }

  /** For tests. */
  state() {
    const shown = (layer) => layer?.bars.object.visible;
    return {
      threads: shown(this.threads) ? { segments: this.threads.forces.length, length: this.threads.length() } : null,
      strokes: Object.fromEntries([...this.strokes].filter(([, s]) => shown(s)).map(([name, s]) => [name, { count: s.sites.length, stretch: s.stretch }])),
    };
  }
}
