// What pointer and keys do to the body.

import * as THREE from 'three';
import { isStill } from 'page/pointer';

export class Hand {
  /**
   * `on` has: hover(face), click(face), stroke(face, first) and state for the tools; `drag` is
   * 'turn' or 'paint'.
   */
  constructor(stage, body, on) {
    Object.assign(this, { stage, body, on, drag: 'turn', hovered: null, down: null, touches: new Set() });
    const { root, canvas } = stage;
    const early = { capture: true };
    canvas.addEventListener('pointermove', (event) => this.move(event));
    canvas.addEventListener('pointerleave', () => {
      cancelAnimationFrame(this.waiting);
      this.waiting = null;
      this.hover(null);
    });
    root.addEventListener('pointerdown', (event) => event.target === canvas && this.press(event), early);
    root.addEventListener('pointerup', (event) => this.release(event), early);
    root.addEventListener('pointercancel', (event) => this.release(event, true), early);
    canvas.addEventListener('contextmenu', (event) => event.preventDefault());
  }

  /** The face under a pointer. */
  under({ clientX, clientY }) {
    const { left, top, width, height } = this.stage.canvas.getBoundingClientRect();
    return this.body.at((2 * (clientX - left)) / width - 1, 1 - (2 * (clientY - top)) / height, this.stage.camera);
  }

  hover(face, place) {
    this.hovered = face;
    this.on.hover(face, place);
  }

  press(event) {
    this.touches.add(event.pointerId);
    if (event.button !== 0) return;
    // what is meant is under the pointer now: a finger turns the body a little before it is lifted
    const face = this.under(event);
    this.down = { x: event.clientX, y: event.clientY, type: event.pointerType, id: event.pointerId, face, painted: null };
    const paints = this.drag === 'paint' || event.shiftKey;
    if (face === null || !paints || this.touches.size > 1) return;
    // this stroke paints, so the body stays where it is
    this.stage.controls.enabled = false;
    this.down.painted = face;
    this.stage.canvas.setPointerCapture(event.pointerId);
    this.on.stroke(face, true);
  }

  move(event) {
    const { down } = this;
    if (down && down.painted !== null && event.pointerId === down.id) {
      for (const part of event.getCoalescedEvents?.() ?? [event]) this.paint(part);
      this.paint(event);
      return;
    }
    if (event.buttons !== 0 || event.pointerType === 'touch') return;
    const place = { clientX: event.clientX, clientY: event.clientY };
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      this.hover(this.under(this.place), this.place);
    });
    this.place = place;
  }

  paint(event) {
    const face = this.under(event);
    if (face === null || face === this.down.painted) return;
    this.down.painted = face;
    this.on.stroke(face, false);
  }

  release(event, cancelled) {
    this.touches.delete(event.pointerId);
    const { down } = this;
    if (!down || event.pointerId !== down.id) return;
    this.down = null;
    if (down.painted !== null) {
      this.stage.controls.enabled = true;
      return;
    }
    if (!isStill(down, { x: event.clientX, y: event.clientY }) || cancelled || this.touches.size > 0) return;
    this.hover(down.face, event.pointerType === 'touch' ? null : event);
    if (down.face !== null) this.on.click(down.face);
  }

  /** Turns the body so that a face is seen from in front, if it looks away. */
  turnTo({ normal, middle }) {
    const { camera, controls } = this.stage;
    const toward = camera.position.clone().sub(controls.target).normalize();
    const out = normal ? new THREE.Vector3(...normal) : new THREE.Vector3(...middle).sub(controls.target).normalize();
    if (out.length() < 0.5 || out.dot(toward) > 0.3) return;
    const seen = out.clone().multiplyScalar(2).add(toward).normalize();
    this.stage.look(Math.atan2(seen.y, seen.x), Math.min(Math.max(Math.asin(seen.z), -1.4), 1.4));
  }
}
