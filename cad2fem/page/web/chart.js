// Lines through points in SVG. Points can be picked, by keys too.

import { digits } from 'page/color';

const SVG = 'http://www.w3.org/2000/svg';
const HEIGHT = 320;
const ROOM = { left: 74, right: 16, top: 14, bottom: 42 };

function element(name, attributes = {}, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** Round numbers in a range, about `count` of them. */
function ticks([low, high], count) {
  const power = 10 ** Math.floor(Math.log10((high - low) / count));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => (high - low) / s <= count);
  const first = Math.ceil(low / step);
  const found = [];
  for (let i = first; i * step <= high + 1e-9 * step; i++) found.push(Number((i * step).toPrecision(12)));
  return found;
}

/** 1, 2 and 5 times powers of ten in a range, or the powers alone where these are many. */
function logTicks([low, high]) {
  const [first, last] = [low, high].map((v) => Math.floor(Math.log10(v)));
  const each = last - first > 3 ? [1] : [1, 2, 5];
  const found = [];
  for (let p = first; p <= last; p++) for (const m of each) found.push(m * 10 ** p);
  return found.filter((v) => v >= low && v <= high);
}

function extent(values, log) {
  const good = values.filter((v) => Number.isFinite(v) && (!log || v > 0));
  let [low, high] = [Math.min(...good), Math.max(...good)];
  if (log) return [low / 1.15, high * 1.15];
  const margin = 0.05 * (high - low || Math.abs(high) || 1);
  return [low - margin, high + margin];
}

/**
 * A chart of `series`: name, color and points { x, y, off?, large?, shown?, label?, pick? }, where
 * `off` is half the length of an error bar. Of `marks` no line is drawn. `bands` are [from, to, text] along x.
 */
export function chart({ series, x, y, log = false, bands = [], read }) {
  // as wide as the screen, so that letters keep their size
  const width = Math.min(1000, Math.max(360, document.documentElement.clientWidth - 28));
  const points = series.flatMap((s) => s.points);
  const xs = extent(points.map((p) => p.x), false);
  const ys = extent(points.flatMap((p) => [p.y - (p.off ?? 0), p.y + (p.off ?? 0)]), log);
  const across = (v) => ROOM.left + ((v - xs[0]) / (xs[1] - xs[0])) * (width - ROOM.left - ROOM.right);
  const part = log ? (v) => Math.log(v / ys[0]) / Math.log(ys[1] / ys[0]) : (v) => (v - ys[0]) / (ys[1] - ys[0]);
  const up = (v) => HEIGHT - ROOM.bottom - part(v) * (HEIGHT - ROOM.top - ROOM.bottom);
  const svg = element('svg', { viewBox: `0 0 ${width} ${HEIGHT}`, class: 'chart', role: 'group', 'aria-label': `${y} over ${x}` });
  bands.forEach(([from, to, text], i) => {
    const [a, b] = [from, to].map((v) => across(Math.min(Math.max(v, xs[0]), xs[1])));
    if (i % 2 === 0) svg.append(element('rect', { x: a, y: ROOM.top, width: b - a, height: HEIGHT - ROOM.top - ROOM.bottom, class: 'band' }));
    const short = b - a < 56 ? text.split(' ').at(-1) : text;
    svg.append(element('text', { x: (a + b) / 2, y: ROOM.top + 12, 'text-anchor': 'middle' }, short));
  });
  for (const v of log ? logTicks(ys) : ticks(ys, 6)) {
    svg.append(element('line', { x1: ROOM.left, x2: width - ROOM.right, y1: up(v), y2: up(v), class: 'grid' }));
    svg.append(element('text', { x: ROOM.left - 8, y: up(v) + 4, 'text-anchor': 'end' }, Number(v.toPrecision(6))));
  }
  for (const v of ticks(xs, Math.round(width / 100))) svg.append(element('text', { x: across(v), y: HEIGHT - ROOM.bottom + 18, 'text-anchor': 'middle' }, v));
  svg.append(element('text', { x: (ROOM.left + width) / 2, y: HEIGHT - 6, 'text-anchor': 'middle' }, x));
  svg.append(element('text', { x: 14, y: HEIGHT / 2, 'text-anchor': 'middle', transform: `rotate(-90 14 ${HEIGHT / 2})` }, y));
  for (const { points, color, marks } of series) {
    const seen = points.filter((p) => Number.isFinite(p.x) && Number.isFinite(p.y) && (!log || p.y > 0));
    if (!marks) svg.append(element('polyline', { points: seen.map((p) => `${across(p.x)},${up(p.y)}`).join(' '), fill: 'none', stroke: color, 'stroke-width': 2 }));
    for (const p of seen) {
      if (p.off) svg.append(element('path', { d: bar(across(p.x), up(p.y - p.off), up(p.y + p.off)), stroke: color, 'stroke-width': 2, fill: 'none' }));
      svg.append(dot(p, across(p.x), up(p.y), color, read));
    }
  }
  return svg;
}

function bar(x, low, high) {
  return `M${x - 6},${low}h12M${x - 6},${high}h12M${x},${low}V${high}`;
}

function dot(p, cx, cy, color, read) {
  const kind = [p.pick && p.large ? 'shape' : 'dot', p.shown ? 'shown' : ''].join(' ');
  const label = p.label ?? digits(p.y);
  const made = element('circle', { cx, cy, r: p.large ? 7 : 3.5, fill: color, class: kind });
  made.append(element('title', {}, label));
  if (p.pick) {
    for (const [key, value] of Object.entries({ tabindex: 0, role: 'button', 'aria-label': label })) made.setAttribute(key, value);
    made.addEventListener('click', p.pick);
    made.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' && event.key !== ' ') return;
      event.preventDefault();
      p.pick();
    });
  }
  for (const event of ['pointerenter', 'focus']) made.addEventListener(event, () => read?.(label));
  return made;
}
