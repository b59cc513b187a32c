// The history of an optimisation: every accepted shape, those on disk to be picked.

import { chart } from 'page/chart';
import { PALETTE, digits } from 'page/color';
import { check, make, select } from 'page/controls';
import { inWords } from 'page/words';

/** Numbers of a history that can be drawn: a name and what gives it of a line. */
function quantities(history) {
  const last = history.at(-1);
  const of = (group, name, unit = 1) => [`term: ${name}`, (line) => (line[group]?.[name] ?? NaN) * unit];
  return [
    ['objective', (line) => line.objective],
    ...Object.keys(last.terms ?? {}).map((name) => of('terms', name)),
    ...Object.keys(last.mean_displacement ?? {}).map((tag) => {
      const [, read] = of('mean_displacement', tag, 1e3);
      return [`mean displacement of ${tag} [mm]`, read];
    }),
    ...['gradient_norm', 'motion_m', 'newton_iterations', 'time_s'].map((key) => [inWords([key]), (line) => line[key]]),
  ];
}

/** The set of shapes on disk that a line of the history has: what a level began with, or the design. */
export function shapeOf(design, i) {
  const { history, sets } = design;
  if (i === history.length - 1) {
    const last = sets.findIndex((set) => set.level === null);
    if (last >= 0) return last;
  }
  const line = history[i];
  return line.iteration === 0 ? sets.findIndex((set) => set.level === line.level) : -1;
}

/** Draws the history of every design into a section; `pick(design, set)` shows a shape. */
export class History {
  constructor(section, designs, pick) {
    this.charts = designs.filter(({ history }) => history.length > 0).map((design) => {
      const all = quantities(design.history);
      const chosen = { what: 'objective', log: false };
      const holder = make('div');
      const readout = make('p', { className: 'readout', textContent: 'Large points are shapes to look at.' });
      const draw = () => holder.replaceChildren(this.draw(design, all, chosen, pick, (text) => {
        readout.textContent = text;
      }));
      const picks = make('div', { className: 'picks' },
        select('y', all.map(([name]) => [name, name]), chosen.what, (what) => {
          chosen.what = what;
          draw();
        }),
        check('logarithmic', false, (log) => {
          chosen.log = log;
          draw();
        }));
      const heading = designs.length > 1 ? make('h3', { textContent: design.name }) : null;
      section.append(...[heading, picks, holder, readout].filter(Boolean));
      draw();
      return draw;
    });
    section.hidden = this.charts.length === 0;
  }

  /** Marks the shape that is shown. */
  mark(design, set) {
    this.shown = { design, set };
    this.charts.forEach((draw) => draw());
  }

  draw(design, all, { what, log }, pick, read) {
    const { history } = design;
    const value = all.find(([name]) => name === what)[1];
    const points = history.map((line, i) => {
      const set = shapeOf(design, i);
      const after = `level ${line.level}, iteration ${line.iteration}: ${what} ${digits(value(line))}`;
      const shape = set >= 0 ? { large: true, pick: () => pick(design, set) } : {};
      const shown = set >= 0 && this.shown?.design === design && this.shown.set === set;
      return { x: i, y: value(line), label: `${after}${set >= 0 ? `, ${design.sets[set].name}` : ''}`, shown, ...shape };
    });
    const starts = history.flatMap((line, i) => (i === 0 || line.level !== history[i - 1].level ? [i] : []));
    const bands = starts.map((start, k) => [start - 0.5, (starts[k + 1] ?? history.length) - 0.5, `level ${history[start].level}`]);
    return chart({ series: [{ color: PALETTE[0], points }], x: 'accepted shapes', y: what, log, bands, read });
  }
}
