// What is under the pointer, and a ruler between two points. The ruler goes with the body.

import { digits } from 'page/color';

const SVG = 'http://www.w3.org/2000/svg';
/** A click moves by less than this [px]; a finger, which is wide, by less than browsers let a tap move. */
const [STILL, STILL_FINGER] = [6, 15];
/** Whether there is a mouse, and with it most often a keyboard. */
const mouse = matchMedia('(hover: hover)').matches;

/** Whether a pointer that was pressed at a place is still there. */
export function isStill({ x, y, type }, now) {
  return Math.hypot(now.x - x, now.y - y) < (type === 'touch' ? STILL_FINGER : STILL);
}

/** An element of SVG with a text. */
export function drawn(name, attributes, text) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  if (text !== undefined) made.textContent = text;
  return made;
}

/** A label with a halo beside a point of a pane; on the left of it where there is no room on the right, else above it. */
export function label(stage, x, y, text) {
  const { size: [all] } = stage.layout();
  const [wide, left] = [16 + 7.5 * text.length, Math.floor(x / all) * all];
  if (x - left + wide < all) return drawn('text', { x: x + 10, y: y - 8, class: 'label' }, text);
  if (x - left > wide) return drawn('text', { x: x - 10, y: y - 8, class: 'label', 'text-anchor': 'end' }, text);
  return drawn('text', { x: left + all / 2, y: y - 14, class: 'label', 'text-anchor': 'middle' }, text);
}

export class Pointer {
  /** `view` gives what is shown now, `said` shows a text. */
  constructor(stage, view, said) {
    Object.assign(this, { stage, view, said, measuring: false, ends: [], at: null });
    const { canvas } = stage;
    const place = ({ offsetX, offsetY }) => [offsetX, offsetY];
    canvas.addEventListener('pointerdown', (event) => {
      // what is meant is under the pointer now: a finger turns the body a little before it is lifted
      const found = this.find(place(event));
      this.down = { x: event.clientX, y: event.clientY, type: event.pointerType, found };
    });
    canvas.addEventListener('pointermove', (event) => {
      if (event.buttons === 0) this.hover(place(event));
    });
    canvas.addEventListener('pointerleave', () => {
      this.at = null;
      if (!this.measuring) this.said('');
    });
    canvas.addEventListener('click', (event) => {
      const { down } = this;
      if (down && isStill(down, { x: event.clientX, y: event.clientY })) this.click(down.found);
    });
    canvas.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' || !this.measuring) return;
      event.preventDefault();
      this.click(this.find(this.middle()));
    });
    stage.drawings.push(() => this.drawing());
  }

  /** The middle of the first pane, where keys set points. */
  middle() {
    return this.stage.layout().size.map((length) => length / 2);
  }

  /** Once per frame, as finding what is there takes a while. */
  hover(at) {
    this.at = at;
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      if (this.at) this.tell(this.find(this.at));
    });
  }

  /** What is there: a text, and where the point is from then on. */
  find([x, y]) {
    const hit = this.stage.pick(x, y);
    const read = hit && this.view()?.read(hit);
    return read ? { ...read, pane: hit.pane } : null;
  }

  tell(found) {
    if (found) this.said(`${[found.text, found.where].filter(Boolean).join(' · ')}`);
    else this.said(this.measuring ? this.hint() : '');
  }

  click(found) {
    this.tell(found);
    if (!found || !this.measuring) return;
    if (this.ends.length === 2 || this.ends[0]?.pane !== found.pane) this.ends = [];
    this.ends.push(found);
    this.said(this.hint());
    this.stage.invalidate();
  }

  /** Begins or ends measuring. */
  measure(on) {
    this.measuring = on;
    this.clear();
    this.said(on ? this.hint() : '');
  }

  /** Another body is shown. */
  clear() {
    this.ends = [];
    this.stage.invalidate();
  }

  /** Distance of the two points [mm]. */
  distance() {
    if (this.ends.length < 2) return null;
    const [a, b] = this.ends.map((end) => end.anchor());
    return a.distanceTo(b);
  }

  hint() {
    const distance = this.distance();
    if (distance !== null) return `ruler: ${digits(distance)} mm`;
    const does = mouse ? 'click on' : 'tap';
    if (this.ends.length === 1) return `ruler: ${does} the second point`;
    return `ruler: ${does} the first point${mouse ? ', or press Enter for the middle' : ''}`;
  }

  drawing() {
    if (!this.measuring) return [];
    const places = this.ends.map(({ anchor, pane }) => this.stage.project(anchor(), pane));
    const found = places.map(([cx, cy]) => drawn('circle', { cx, cy, r: 4.5, class: 'end' }));
    if (places.length === 2) {
      const [[x1, y1], [x2, y2]] = places;
      found.unshift(drawn('line', { x1, y1, x2, y2, class: 'rule' }));
      found.push(label(this.stage, (x1 + x2) / 2, (y1 + y2) / 2 + 26, `${digits(this.distance())} mm`));
    }
    if (document.activeElement === this.stage.canvas && this.stage.canvas.matches(':focus-visible')) {
      const [x, y] = this.middle();
      found.push(drawn('path', { d: `M${x - 9},${y}h18M${x},${y - 9}v18`, class: 'cross' }));
    }
    return found;
  }
}
