// A handle on the cut that is dragged along its axis, by pointer or keys.

import * as THREE from 'three';

/** Of the pixels of a millimetre, what the axis must have on the screen for drags along it; else they are up and down. */
const SEEN = 0.2;

export class Grip {
  /** `look` is the cut that all views share, `to(at)` moves it. */
  constructor(stage, button, look, view, to) {
    Object.assign(this, { stage, button, look, view });
    button.addEventListener('pointerdown', (event) => {
      event.preventDefault();
      button.focus({ preventScroll: true });
      button.setPointerCapture(event.pointerId);
      this.from = { x: event.clientX, y: event.clientY, at: look.at, ...this.axis() };
    });
    button.addEventListener('pointermove', (event) => {
      if (!this.from || !button.hasPointerCapture(event.pointerId)) return;
      const { x, y, at, along, length, perPixel } = this.from;
      const [dx, dy] = [event.clientX - x, event.clientY - y];
      const squared = along[0] ** 2 + along[1] ** 2;
      const moved = squared > (SEEN / perPixel) ** 2 ? (dx * along[0] + dy * along[1]) / squared : -dy * perPixel;
      to(clamp(at + moved / length));
    });
    button.addEventListener('lostpointercapture', () => {
      this.from = null;
    });
    button.addEventListener('keydown', (event) => {
      const by = { ArrowLeft: -0.01, ArrowDown: -0.01, ArrowRight: 0.01, ArrowUp: 0.01, PageDown: -0.1, PageUp: 0.1 }[event.key];
      if (!by) return;
      event.preventDefault();
      event.stopPropagation();
      to(clamp(look.at + by));
    });
    stage.drawings.push(() => this.place());
  }

  /** The point of the handle, the axis on the screen [px/mm], and the length of the way [mm]. */
  axis() {
    const box = this.view().box();
    const c = ['x', 'y', 'z'].indexOf(this.look.axis);
    const [low, high] = [box.min.getComponent(c), box.max.getComponent(c)];
    const point = box.getCenter(new THREE.Vector3()).setComponent(c, low + this.look.at * (high - low));
    const [x, y] = this.stage.project(point, 0);
    const [nextX, nextY] = this.stage.project(point.clone().setComponent(c, point.getComponent(c) + 1), 0);
    return { screen: [x, y], along: [nextX - x, nextY - y], length: Math.max(high - low, 1e-9), perPixel: this.stage.perPixel };
  }

  place() {
    const { button, look } = this;
    button.hidden = look.axis === 'none' || !this.view();
    if (button.hidden) return [];
    const { screen: [x, y], along } = this.axis();
    const angle = Math.hypot(...along) * this.stage.perPixel > SEEN ? Math.atan2(along[1], along[0]) : Math.PI / 2;
    const { clientWidth, clientHeight } = this.stage.canvas;
    const inside = (v, most) => Math.min(Math.max(v, 16), most - 16);
    button.style.transform = `translate(${inside(x, clientWidth) - 16}px, ${inside(y, clientHeight) - 16}px) rotate(${angle}rad)`;
    button.setAttribute('aria-valuenow', Math.round(100 * look.at));
    return [];
  }
}

function clamp(at) {
  return Math.min(Math.max(at, 0), 1);
}
