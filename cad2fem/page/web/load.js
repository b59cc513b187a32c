// Simulations: bodies under load, one, or two beside or over each other.

import * as THREE from 'three';
import { numbers } from 'page/arrays';
import { HEAT_RAMP, PALETTE, daily, digits } from 'page/color';
import { button, check, fieldset, output, row, select, slider } from 'page/controls';
import { Reinforcement, families, familyColor } from 'page/reinforcement';
import { Solid, coordinates, wallText } from 'page/solid';

const AXES = ['x', 'y', 'z'];
/** Components of a tensor, row by row; it is symmetric, so that those below its diagonal are there already. */
const TENSOR = ['xx', 'xy', 'xz', null, 'yy', 'yz', null, null, 'zz'];

export class Load {
  title = 'Under load';

  constructor(stage, runs, look, changed) {
    Object.assign(this, { stage, runs, look, changed, solids: new Map(), ranges: new Map() });
    const last = runs.length - 1;
    this.set = { shown: last > 0 ? 'beside' : 'one', a: 0, b: last, at: runs[0].states.length, field: 'displacement', factor: 1, mark: true, wall: true, threads: true, fibres: [] };
    this.families = [...new Set(runs.flatMap(families))];
    if (!this.fields().some(([value]) => value === this.set.field)) this.set.field = 'tags';
  }

  /** What can colour a body: fields, and components of vectors and tensors. Those of points come before those of cells. */
  fields() {
    const found = new Map();
    for (const { name, values: { components } } of this.runs[0].states.at(-1).fields) {
      if (found.has(name)) continue;
      const words = name.replaceAll('_', ' ');
      found.set(name, words);
      const of = { 3: AXES, 9: TENSOR }[components] ?? [...Array(components > 1 ? components : 0).keys()];
      of.forEach((axis, c) => axis !== null && found.set(`${name}/${c}`, `${words} ${axis}`));
    }
    return [...found, ['tags', 'tags']];
  }

  get steps() {
    return this.runs[this.set.a].states.length;
  }

  panel() {
    const change = (key, as = (v) => v) => (value) => {
      this.set[key] = as(value);
      this.refresh();
    };
    const names = this.runs.map(({ name }, i) => [i, name]);
    const two = this.runs.length > 1;
    this.step = slider(this.runs[this.set.a].inTime ? 'time' : 'load', { min: 0, max: this.steps, step: 0.02, value: this.set.at }, change('at'));
    this.step.input.id = 'step';
    this.said = output();
    this.second = two ? select('and', names, this.set.b, change('b', Number)) : null;
    return [
      two && fieldset(null,
        select('show', [['one', 'one'], ['beside', 'beside each other'], ['over', 'over each other']], this.set.shown, change('shown')),
        select('simulation', names, this.set.a, (i) => this.choose(Number(i))),
        this.second),
      fieldset('state', this.step,
        row(button('◂ step', () => this.go(-1)), button('step ▸', () => this.go(1)), this.playing = button('play', () => this.play())),
        this.said,
        slider('exaggerate', { min: 0, max: 5, step: 0.1, value: this.set.factor }, change('factor'))),
      fieldset('colour', select('by', this.fields(), this.set.field, change('field')),
        this.runs.some((run) => run.stretch) && check('mark the largest stretch', this.set.mark, change('mark')),
        this.runs.some((run) => run.wall) && check('mark the thinnest wall', this.set.wall, change('wall'))),
      this.reinforcementPanel(change),
    ];
  }

  /** Switches of threads and of each family of fibres, where there are any. */
  reinforcementPanel(change) {
    const threads = this.runs.some((run) => run.threads);
    if (!threads && this.families.length === 0) return null;
    const toggled = (name) => (on) => {
      const others = this.set.fibres.filter((other) => other !== name);
      return on ? [...others, name] : others;
    };
    return fieldset('threads and fibres',
      threads && named('threads', check('threads', this.set.threads, change('threads'))),
      ...this.families.map((name, i) => named(`fibres-${i}`,
        check(`fibres ${name}`, this.set.fibres.includes(name), (on) => change('fibres', toggled(name))(on), familyColor(i)))));
  }

  async choose(i) {
    const part = this.set.at / this.steps;
    this.set.a = i;
    this.step.input.max = this.steps;
    this.to(part * this.steps);
    await this.refresh();
  }

  to(at) {
    this.set.at = Math.min(Math.max(at, 0), this.steps);
    this.step.input.value = this.set.at;
  }

  /** To the computed state before or after. */
  go(by) {
    this.to(by > 0 ? Math.floor(this.set.at + 1e-6) + 1 : Math.ceil(this.set.at - 1e-6) - 1);
    return this.refresh();
  }

  async play() {
    if (this.running) {
      this.running = false;
      return;
    }
    this.running = true;
    this.playing.textContent = 'stop';
    if (this.set.at >= this.steps) this.to(0);
    while (this.running && this.set.at < this.steps) {
      this.to(this.set.at + Math.max(this.steps / 120, 0.02));
      await this.refresh();
      await new Promise(requestAnimationFrame);
    }
    this.running = false;
    this.playing.textContent = 'play';
  }

  solid(i) {
    const made = async (run) => {
      const solid = await Solid.of(run.body, run.chambers);
      solid.reinforcement = await Reinforcement.of(run, solid);
      return solid;
    };
    if (!this.solids.has(i)) this.solids.set(i, made(this.runs[i]));
    return this.solids.get(i);
  }

  /** The numbers of a field of a state; none at rest or where the state has none. */
  async values(run, state, name) {
    const field = run.states[state - 1]?.fields.find((f) => f.name === name);
    return field ? { field, numbers: await numbers(field.values) } : null;
  }

  /** Displacements at a place between states, in metres: linear in between. */
  async displacement(run, at) {
    const low = Math.floor(at);
    const part = at - low;
    const [a, b] = await Promise.all([low, part > 0 ? low + 1 : low].map((i) => this.values(run, i, 'displacement')));
    if (part === 0) return a?.numbers ?? null;
    return b.numbers.map((u, i) => (1 - part) * (a?.numbers[i] ?? 0) + part * u);
  }

  /**
   * What colours a body: values in the unit of people, and where they are. Only displacements are
   * known between states and at rest; other fields are those of the state that follows.
   */
  async coloring(run, at, u) {
    const [name, component] = this.set.field.split('/');
    if (name === 'tags') return null;
    const found = await this.values(run, Math.max(Math.ceil(at), 1), name);
    if (!found) return null;
    const { field } = found;
    const all = (value) => new Float32Array(found.numbers.length).fill(value);
    const source = name === 'displacement' ? u ?? all(0) : at > 0 ? found.numbers : all(NaN);
    const [factor] = daily(field.unit);
    return { at: field.at, values: scalars(source, field.values.components, component, factor), range: await this.range() };
  }

  /** Range of the chosen field over all states of what is shown. */
  async range() {
    const { field, a, b, shown } = this.set;
    const key = [field, a, shown === 'beside' ? b : a].join();
    if (!this.ranges.has(key)) this.ranges.set(key, this.extremes(shown === 'beside' ? [a, b] : [a]));
    return this.ranges.get(key);
  }

  async extremes(shown) {
    const [name, component] = this.set.field.split('/');
    let [low, high] = name === 'displacement' ? [0, 0] : [Infinity, -Infinity];
    for (const run of shown.map((i) => this.runs[i])) {
      for (let i = 1; i <= run.states.length; i++) {
        const { field, numbers } = (await this.values(run, i, name)) ?? {};
        if (!field) continue;
        for (const v of scalars(numbers, field.values.components, component, daily(field.unit)[0])) {
          if (v < low) low = v;
          if (v > high) high = v;
        }
      }
    }
    return [low, high];
  }

  async enter() {
    await this.refresh();
  }

  /** What is shown of each run: its place among the states, moved and coloured. */
  async refresh() {
    const turn = (this.turn = (this.turn ?? 0) + 1);
    const { shown, a, b, at, factor } = this.set;
    if (this.second) this.second.hidden = shown === 'one';
    const of = shown === 'one' || a === b ? [a] : [a, b];
    const ready = await Promise.all(of.map(async (i) => {
      const run = this.runs[i];
      const place = (at / this.steps) * run.states.length;
      const [solid, u] = [await this.solid(i), await this.displacement(run, place)];
      await solid.reinforcement.show(this.set.threads, this.shownFamilies());
      return { run, place, solid, u, coloring: await this.coloring(run, place, u) };
    }));
    if (turn !== this.turn) return;
    this.ready = ready;
    for (const { run, place, solid, u, coloring } of ready) {
      solid.move(u, factor);
      solid.paint(coloring);
      solid.reinforcement.move(place === run.states.length);
    }
    const key = of.map((i) => `${i}${shown}`).join();
    if (key !== this.key || this.stage.owner !== this) {
      this.key = key;
      this.stage.owner = this;
      const pane = ({ solid, run }) => ({ objects: [solid.group], name: this.runs.length > 1 ? run.name : '' });
      const over = () => ({ objects: ready.map(({ solid }) => solid.group), name: ready.map(({ run }) => run.name).join(', grey: ') });
      this.stage.show(shown === 'over' ? [over()] : ready.map(pane));
    }
    this.relook();
    this.changed();
  }

  /** The families that are shown, with their colours. */
  shownFamilies() {
    return new Map(this.set.fibres.map((name) => [name, familyColor(this.families.indexOf(name))]));
  }

  relook() {
    if (!this.ready) return;
    const plane = this.look.plane(this.box());
    this.ready.forEach(({ solid }, i) => {
      if (this.set.shown === 'over' && i === 1) {
        solid.fade(plane);
        solid.reinforcement.hide();
        return;
      }
      solid.cut(plane);
      solid.reinforcement.clip(plane);
      solid.look(this.look);
    });
    this.said.textContent = [...new Set(this.ready.map((r) => this.describe(r)))].join('\n');
    this.stage.invalidate();
  }

  /** Where among the states, and what the report says of it. */
  describe({ run, place }) {
    const computed = place === Math.round(place);
    if (place === 0) return 'at rest';
    const state = run.states[Math.ceil(place) - 1];
    const step = run.steps?.[state.step];
    const where = run.inTime ? `t = ${digits(step?.t ?? NaN)} s` : `load ${digits(step?.load ?? 1)}`;
    const chambers = Object.entries(step?.chambers ?? {}).map(([tag, c]) => `${tag} ${digits(1e-3 * c.pressure)} kPa`);
    return `${computed ? '' : 'interpolated, before '}${[where, ...chambers].join(' · ')}`;
  }

  points() {
    return this.ready?.map(({ solid }) => solid.points) ?? [];
  }

  box() {
    const all = new THREE.Box3();
    this.ready?.forEach(({ solid }) => all.union(solid.box()));
    return all;
  }

  legend() {
    const [name] = this.set.field.split('/');
    const coloring = this.ready?.[0].coloring;
    const also = this.threadLegend();
    if (!coloring) return { also, names: this.ready?.[0].solid.tags.map((tag, i) => [tag, PALETTE[i % PALETTE.length]]) ?? [] };
    const field = this.runs[this.set.a].states.at(-1).fields.find((f) => f.name === name);
    const [, unit] = daily(field.unit);
    const title = this.fields().find(([value]) => value === this.set.field)[1];
    return { title, unit, range: coloring.range, also };
  }

  /** What the colours of threads mean, where they are those of forces. */
  threadLegend() {
    const ready = this.ready?.find(({ run, place, solid }) => this.set.threads && solid.reinforcement.threads && place === run.states.length);
    return ready && { title: 'thread', unit: 'N', range: ready.solid.reinforcement.threads.range, ramp: HEAT_RAMP };
  }

  /** What is at a point that a ray met. */
  read(hit) {
    const solid = hit.object.userData.solid;
    if (!solid) return null;
    const { value, tag, anchor } = solid.read(hit);
    const { title, unit, names } = this.legend();
    const told = names || value === null ? null : `${title} ${Number.isFinite(value) ? `${digits(value)} ${unit}` : 'unknown'}`;
    return { text: [told, tag].filter(Boolean).join(' · '), where: coordinates(hit.point), value, anchor };
  }

  /** Places of each pane that a person should see: text, point and pane. */
  marks() {
    if (this.set.shown === 'over') return [];
    return (this.ready ?? []).flatMap((shown, pane) => [this.stretched(shown), this.thinnest(shown)].filter(Boolean).map((mark) => ({ ...mark, pane })));
  }

  /** Where the material is stretched most in the last state. */
  stretched({ run, place, solid }) {
    if (!this.set.mark || !run.stretch || place !== run.states.length) return null;
    const { largest, largest_at: at, at_break: most } = run.stretch;
    solid.stretched ??= solid.nearest(at);
    const text = `largest stretch ${digits(largest)}${most ? ` of ${digits(most)} at break` : ''}`;
    return { text, point: solid.point(solid.stretched) };
  }

  /** Where the body is thinnest at rest. */
  thinnest({ run, place, solid }) {
    if (!this.set.wall || !run.wall) return null;
    solid.thinnest ??= solid.nearest(run.wall.at);
    return { text: `${wallText(run.wall)}${place > 0 ? ' at rest' : ''}`, point: solid.point(solid.thinnest) };
  }

  state() {
    const each = (this.ready ?? []).map(({ run, place, solid, u }) => ({
      run: run.name,
      place,
      states: run.states.length,
      largestDisplacement: u ? largest(u, solid.facets) : 0,
      triangles: solid.triangles.length / 3,
      sectionTriangles: solid.sectionTriangles,
      tags: solid.tags,
      ...solid.reinforcement.state(),
    }));
    const marks = this.marks().map(({ text }) => text);
    return { ...this.set, each, marks, range: this.ready?.[0].coloring?.range };
  }
}

/** A control by the name under which it is found. */
function named(id, control) {
  control.input.id = id;
  return control;
}

/** One number per entry: a component, or the length. */
function scalars(source, components, component, factor) {
  const made = new Float32Array(source.length / components);
  const [first, last] = component === undefined ? [0, components] : [Number(component), Number(component) + 1];
  for (let i = 0; i < made.length; i++) {
    let sum = 0;
    for (let c = first; c < last; c++) sum += source[i * components + c] ** 2;
    made[i] = factor * (last - first === 1 ? source[i * components + first] : Math.sqrt(sum));
  }
  return made;
}

/** Length of the largest displacement of the nodes of a surface. */
function largest(u, nodes) {
  let most = 0;
  for (const v of nodes) most = Math.max(most, Math.hypot(u[3 * v], u[3 * v + 1], u[3 * v + 2]));
  return most;
}
