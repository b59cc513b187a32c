// What simulations measured at every step: probes with error bars, chambers, forces, energies.

import { chart } from 'page/chart';
import { PALETTE, daily, digits } from 'page/color';
import { button, make, select } from 'page/controls';
import { csv, download } from 'page/save';

const UNITS = { pressure: 'Pa', volume: 'm3', volume_rest: 'm3', energies: 'J', mean_displacement: 'm', reactions: 'N', work_of_loads: 'J', t: 's' };

/** All numbers of a step by the path to them; of vectors the length. */
function numbersOf(value, path = [], found = {}) {
  if (typeof value === 'number') found[path.join(' · ')] = value;
  else if (Array.isArray(value) && value.every((v) => typeof v === 'number')) found[path.join(' · ')] = Math.hypot(...value);
  else if (value && typeof value === 'object' && !Array.isArray(value)) for (const [key, v] of Object.entries(value)) numbersOf(v, [...path, key], found);
  return found;
}

function unitOf(path, runs) {
  const keys = path.split(' · ');
  if (keys[0] === 'probes') return runs.map((run) => run.probes?.[keys[1]]?.unit).find(Boolean);
  return UNITS[keys.at(-1)] ?? UNITS[keys[0]];
}

/** Half the length of the error bar of a probe, which is that of the last step. */
function barOf(run, path, i) {
  const [group, probe] = path.split(' · ');
  const together = run.errorBars?.[probe]?.together;
  return group === 'probes' && i === run.steps.length - 1 && typeof together === 'number' ? together : undefined;
}

/** All numbers of all steps, with their units in the head: a row for each step. */
function table(runs, rows, all) {
  const units = all.map((path) => daily(unitOf(path, runs)));
  const head = all.map((path, c) => (units[c][1] ? `${path} [${units[c][1]}]` : path));
  const steps = runs.flatMap((run, k) => rows[k].map((row) => [run.name, ...all.map((path, c) => units[c][0] * (row[path] ?? NaN))]));
  return csv([['simulation', ...head], ...steps]);
}

/** Draws what the steps of simulations measured; `pick(run, step)` shows a step, `file` is the name of the download. */
export function response(section, runs, pick, file) {
  const with_steps = runs.filter((run) => run.steps?.length > 1);
  if (with_steps.length === 0) return;
  const rows = with_steps.map((run) => run.steps.map((step) => numbersOf(step)));
  const all = [...new Set(rows.flatMap((steps) => Object.keys(steps.at(-1))))];
  const first = (...wanted) => wanted.map((w) => all.find((name) => name.startsWith(w))).find(Boolean) ?? all[0];
  const chosen = { x: with_steps.some((run) => run.inTime) ? 't' : 'load', y: first('probes', 'chambers', 'mean_displacement') };
  const holder = make('div');
  const readout = make('p', { className: 'readout' });
  const draw = () => {
    const [[fx, ux], [fy, uy]] = [chosen.x, chosen.y].map((path) => daily(unitOf(path, with_steps)));
    const title = (path, unit) => (unit ? `${path} [${unit}]` : path);
    const series = with_steps.map((run, k) => ({
      color: PALETTE[k % PALETTE.length],
      points: rows[k].map((row, i) => ({
        x: fx * row[chosen.x],
        y: fy * row[chosen.y],
        off: fy * barOf(run, chosen.y, i) || undefined,
        label: `${run.name}: ${chosen.x} ${digits(fx * row[chosen.x])} ${ux}, ${chosen.y} ${digits(fy * row[chosen.y])} ${uy}`,
        pick: () => pick(run, i),
      })),
    }));
    holder.replaceChildren(chart({
      series, x: title(chosen.x, ux), y: title(chosen.y, uy), read: (text) => {
        readout.textContent = text;
      },
    }));
  };
  const axis = (key) => select(key, all.map((name) => [name, name]), chosen[key], (path) => {
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
