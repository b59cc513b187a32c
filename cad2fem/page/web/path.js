// Paths of equilibria: the load over a volume or a displacement, and what lies on them.

import { chart } from 'page/chart';
import { PALETTE, daily, digits } from 'page/color';
import { make } from 'page/controls';

/** What is marked, and in which colour. */
const MARKS = { 'limit-point': ['limit point', '#cf5f53'], bifurcation: ['bifurcation', '#9a76b3'], burst: ['stretch at break', '#d6336c'] };

const sum = (values) => values.reduce((a, b) => a + b, 0);

/** Volume of all chambers of a state, or of a body without any the largest mean displacement of a tag. */
function across(state) {
  const volumes = Object.values(state.chambers ?? {}).map((chamber) => chamber.volume);
  if (volumes.length > 0) return [sum(volumes), 'm3'];
  const moved = Object.values(state.mean_displacement ?? {}).map((u) => Math.hypot(...u));
  return [Math.max(0, ...moved), 'm'];
}

/** The point of a path where the load is a value, on the line between two states. */
function between(points, load) {
  const next = points.findIndex((p, i) => i > 0 && (points[i - 1].y - load) * (p.y - load) <= 0);
  if (next < 0) return points.at(-1).x;
  const [a, b] = [points[next - 1], points[next]];
  return a.y === b.y ? b.x : a.x + ((load - a.y) / (b.y - a.y)) * (b.x - a.x);
}

/** Points of the steps and of the way to the limit, and what is marked on them. */
function pathOf(run, pick) {
  const point = (state, load) => ({ state, x: across(state)[0], y: load });
  const states = [...(run.rest ? [run.rest] : []), ...run.steps];
  const steps = states.map((step) => ({ ...point(step, step.load), pick: () => pick(run, run.steps.indexOf(step)) }));
  // the first state of the way is the last step
  const way = (run.limit?.path ?? []).slice(1).map((state) => point(state, state.factor));
  const marks = steps.flatMap(({ state }, i) => (state.path?.passed ?? []).map(({ kind, loads }) => {
    const before = steps[Math.max(i - 1, 0)];
    const turns = kind === 'limit-point';
    const y = turns ? (before.state.path?.load_rate < 0 ? Math.min(...loads) : Math.max(...loads)) : 0.5 * (loads[0] + loads[1]);
    return { kind, x: turns ? (y === before.y ? before.x : steps[i].x) : 0.5 * (before.x + steps[i].x), y, label: `between ${digits(loads[0])} and ${digits(loads[1])}` };
  }));
  const all = [...steps, ...way];
  const { factor, kind, burst } = run.limit ?? {};
  if (typeof factor === 'number') marks.push({ kind, x: all.at(-1).x, y: factor, label: `at ${digits(factor)}` });
  if (typeof burst === 'number') marks.push({ kind: 'burst', x: between(all, burst), y: burst, label: `at ${digits(burst)}` });
  return { points: all, marks };
}

/** A name with its colour, as a line or as a dot. */
function key(name, color, round) {
  const line = make('i');
  line.style.background = color;
  if (round) Object.assign(line.style, { width: '12px', height: '12px', borderRadius: '6px' });
  return make('span', { className: 'key' }, line, name);
}

/** Draws the paths of simulations that follow one, or that seek a limit; `pick(run, step)` shows a step. */
export function path(section, runs, pick) {
  const shown = runs.filter((run) => run.steps?.length > 0 && (run.limit || run.steps.some((step) => step.path)));
  if (shown.length === 0) return;
  const [, unit] = across(shown[0].steps.at(-1));
  const [factor, short] = daily(unit);
  const paths = shown.map((run) => pathOf(run, pick));
  const scaled = (p) => ({ ...p, x: factor * p.x });
  const series = paths.map(({ points }, k) => ({
    color: PALETTE[k % PALETTE.length],
    points: points.map((p) => ({ ...scaled(p), label: `${shown[k].name}: load ${digits(p.y)}, ${digits(factor * p.x)} ${short}` })),
  }));
  const found = Object.entries(MARKS).filter(([kind]) => paths.some(({ marks }) => marks.some((m) => m.kind === kind)));
  for (const [kind, [name, color]] of found) {
    const of = ({ marks }, k) => marks.filter((m) => m.kind === kind).map((m) => ({ ...scaled(m), large: true, label: `${shown[k].name}: ${name} ${m.label}` }));
    series.push({ color, marks: true, points: paths.flatMap(of) });
  }
  const readout = make('p', { className: 'readout' });
  const drawn = chart({
    series,
    x: unit === 'm3' ? `volume of the chambers [${short}]` : `largest mean displacement [${short}]`,
    y: 'load over the full load',
    read: (text) => {
      readout.textContent = text;
    },
  });
  const keys = [...shown.map((run, k) => key(run.name, PALETTE[k % PALETTE.length])), ...found.map(([, [name, color]]) => key(name, color, true))];
  section.append(make('div', { className: 'picks' }, ...keys), drawn, readout);
  section.hidden = false;
}
