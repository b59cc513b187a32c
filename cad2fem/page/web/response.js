// What simulations measured at every step: probes with error bars, chambers, forces, energies.

import { chart } from 'page/chart';
import { PALETTE, daily, digits } from 'page/color';
import { button, make, select } from 'page/controls';
import { csv, download } from 'page/save';
import { inWords } from 'page/words';

const UNITS = {
  pressure: 'Pa', volume: 'm3', volume_rest: 'm3', energies: 'J', mean_displacement: 'm', reactions: 'N', work_of_loads: 'J', t: 's',
  force_balance: 'N', residual: 'N', residual_wanted: 'N', rounding_floor: 'N', displacement: 'm', rotation: 'rad', momentum: 'kg m/s',
};

/** What stands between the keys of a path. */
const BETWEEN = ' · ';

/** The words for the number at a path. */
const called = (path) => inWords(path.split(BETWEEN));

/** All numbers of a step by the path to them; of vectors the length. */
function numbersOf(value, path = [], found = {}) {
  if (typeof value === 'number') found[path.join(BETWEEN)] = value;
  else if (Array.isArray(value) && value.every((v) => typeof v === 'number')) found[path.join(BETWEEN)] = Math.hypot(...value);
  else if (value && typeof value === 'object' && !Array.isArray(value)) for (const [key, v] of Object.entries(value)) numbersOf(v, [...path, key], found);
  return found;
}

function unitOf(path, runs) {
  const keys = path.split(BETWEEN);
  if (keys[0] === 'probes') return runs.map((run) => run.probes?.[keys[1]]?.unit).find(Boolean);
  return UNITS[keys.at(-1)] ?? UNITS[keys[0]];
}

/** States of a run: at rest, where that is known, and at the ends of its steps, of which each knows its number. */
function statesOf(run) {
  return [...(run.rest ? [{ numbers: numbersOf(run.rest), step: -1 }] : []), ...run.steps.map((step, i) => ({ numbers: numbersOf(step), step: i }))];
}

/** The pressure that changes most, of a run of load steps; else the time or the load. */
function abscissa(runs, rows, all) {
  if (runs.some((run) => run.inTime)) return 't';
  const extent = (path) => Math.max(...rows.map((states) => {
    const values = states.map(({ numbers }) => numbers[path]).filter(Number.isFinite);
    return Math.max(...values) - Math.min(...values);
  }));
  const pressures = all.filter((path) => path.startsWith('chambers') && path.endsWith('pressure') && extent(path) > 0);
  return pressures.sort((a, b) => extent(b) - extent(a))[0] ?? 'load';
}

/** Half the length of the error bar of a probe, which is that of the last step. */
function barOf(run, path, i) {
  const [group, probe] = path.split(BETWEEN);
  const together = run.errorBars?.[probe]?.together;
  return group === 'probes' && i === run.steps.length - 1 && typeof together === 'number' ? together : undefined;
}

/** All numbers of all states, with their units in the head: a row for each. */
function table(runs, rows, all) {
  const units = all.map((path) => daily(unitOf(path, runs)));
  const head = all.map((path, c) => (units[c][1] ? `${called(path)} [${units[c][1]}]` : called(path)));
  const value = (numbers, path, c) => Number((units[c][0] * (numbers[path] ?? NaN)).toPrecision(12));
  const steps = runs.flatMap((run, k) => rows[k].map(({ numbers }) => [run.name, ...all.map((path, c) => value(numbers, path, c))]));
  return csv([['simulation', ...head], ...steps]);
}

/** Draws what the steps of simulations measured; `pick(run, step)` shows a step, `file` is the name of the download. */
export function response(section, runs, pick, file) {
  const with_steps = runs.filter((run) => run.steps?.length > 1);
  if (with_steps.length === 0) return;
  const rows = with_steps.map(statesOf);
  const all = [...new Set(rows.flatMap((states) => Object.keys(states.at(-1).numbers)))];
  const chosen = { x: abscissa(with_steps, rows, all) };
  const first = (...wanted) => wanted.map((w) => all.find((path) => w.test(path) && path !== chosen.x)).find(Boolean) ?? all[0];
  chosen.y = first(/^probes/, /^chambers.* volume$/, /^mean_displacement/);
  const holder = make('div');
  const readout = make('p', { className: 'readout' });
  const draw = () => {
    const [[fx, ux], [fy, uy]] = [chosen.x, chosen.y].map((path) => daily(unitOf(path, with_steps)));
    const title = (path, unit) => (unit ? `${called(path)} [${unit}]` : called(path));
    const series = with_steps.map((run, k) => ({
      color: PALETTE[k % PALETTE.length],
      points: rows[k].map(({ numbers, step }) => ({
        x: fx * numbers[chosen.x],
        y: fy * numbers[chosen.y],
        off: fy * barOf(run, chosen.y, step) || undefined,
        label: `${run.name}: ${called(chosen.x)} ${digits(fx * numbers[chosen.x])} ${ux}, ${called(chosen.y)} ${digits(fy * numbers[chosen.y])} ${uy}`,
        pick: () => pick(run, step),
      })),
    }));
    holder.replaceChildren(chart({
      series, x: title(chosen.x, ux), y: title(chosen.y, uy), read: (text) => {
        readout.textContent = text;
      },
    }));
  };
  const axis = (key) => select(key, all.map((path) => [path, called(path)]), chosen[key], (path) => {
    chosen[key] = path;
    draw();
  });
  const keys = with_steps.map((run, k) => {
    const line = make('i');
    line.style.background = PALETTE[k % PALETTE.length];
    return make('span', { className: 'key' }, line, run.name);
  });
  section.append(make('div', { className: 'picks' }, axis('y'), axis('x'), ...keys, button('download CSV', () => download(file, table(with_steps, rows, all)))), holder, readout);
  section.hidden = false;
  draw();
}
