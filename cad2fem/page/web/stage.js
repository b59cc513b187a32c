// Where things are drawn: panes side by side with one camera, axes and a scale bar.

import * as THREE from 'three';
import { OrbitControls } from 'three/orbit';

const AXES = [['x', '#d64545'], ['y', '#3f9b4f'], ['z', '#4a7fd6']];
const SVG = 'http://www.w3.org/2000/svg';

/** Directions from which to look: azimuth and elevation in degrees. */
export const VIEWS = { iso: [-60, 22], front: [-90, 0], side: [0, 0], top: [-90, 89.9], under: [-90, -89.9] };

export class Stage {
  /** Throws where there is no WebGL. */
  constructor(root, drawn) {
    this.root = root;
    this.drawn = drawn;
    this.canvas = root.querySelector('canvas');
    this.renderer = new THREE.WebGLRenderer({ canvas: this.canvas, antialias: true, alpha: true, stencil: true });
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.localClippingEnabled = true;
    this.renderer.autoClear = false;
    this.renderer.setClearColor('#000000', 0);
    this.camera = new THREE.OrthographicCamera();
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', () => this.invalidate());
    this.panes = [];
    /** What draws over the canvas, after each picture: lists of elements of SVG. */
    this.drawings = [];
    this.ray = new THREE.Raycaster();
    this.radius = 1;
    this.extent = [1, 1];
    this.look(...VIEWS.iso.map((a) => (a * Math.PI) / 180));
    new ResizeObserver(() => this.resize()).observe(this.canvas);
    this.canvas.addEventListener('keydown', (event) => this.key(event));
  }

  /** Shows panes: objects and the name of each. */
  show(panes) {
    this.panes = panes.map(({ objects, name }) => {
      const scene = new THREE.Scene();
      const lamp = new THREE.DirectionalLight('#ffffff', 1.5);
      scene.add(...objects, lamp, new THREE.HemisphereLight('#ffffff', '#c3cad2', 2.2));
      return { scene, lamp, name };
    });
    this.resize();
  }

  /** Places the camera so that all of some lists of points is seen, from the direction that it has. */
  fit(lists) {
    const box = new THREE.Box3();
    for (const points of lists) box.union(new THREE.Box3().setFromArray(points));
    const direction = this.camera.position.clone().sub(this.controls.target).normalize();
    box.getCenter(this.controls.target);
    this.radius = Math.max(0.5 * box.getSize(new THREE.Vector3()).length(), 1e-9);
    this.camera.position.copy(this.controls.target).addScaledVector(direction, 4 * this.radius);
    Object.assign(this.camera, { near: 0.1 * this.radius, far: 10 * this.radius, zoom: 1 });
    this.controls.update();
    this.camera.updateMatrixWorld();
    this.extent = [0, 1].map((i) => reach(lists, this.controls.target, new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, i)));
    this.resize();
  }

  /** The same from a direction by its name. */
  view(name, lists) {
    const [azimuth, elevation] = VIEWS[name].map((a) => (a * Math.PI) / 180);
    this.look(azimuth, elevation);
    this.fit(lists);
  }

  look(azimuth, elevation) {
    const flat = Math.cos(elevation);
    const direction = new THREE.Vector3(flat * Math.cos(azimuth), flat * Math.sin(azimuth), Math.sin(elevation));
    this.camera.position.copy(this.controls.target).addScaledVector(direction, 4 * this.radius);
    this.controls.update();
    this.invalidate();
  }

  key(event) {
    const turn = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] }[event.key];
    const zoom = { '+': 1.15, '=': 1.15, '-': 1 / 1.15 }[event.key];
    if (turn) {
      const { x, y, z } = this.camera.position.clone().sub(this.controls.target).normalize();
      const limit = 1.569;
      this.look(Math.atan2(y, x) + 0.1 * turn[0], Math.min(Math.max(Math.asin(z) + 0.1 * turn[1], -limit), limit));
    } else if (zoom) {
      this.camera.zoom *= zoom;
      this.resize();
    } else {
      return;
    }
    event.preventDefault();
  }

  /** Panes beside each other where there is room, else one above the other. */
  layout() {
    const [width, height] = [this.canvas.clientWidth, this.canvas.clientHeight];
    const n = Math.max(this.panes.length, 1);
    const across = width >= height;
    const size = across ? [width / n, height] : [width, height / n];
    const at = (i) => (across ? [i * size[0], 0] : [0, i * size[1]]);
    return { size, at };
  }

  resize() {
    this.renderer.setSize(this.canvas.clientWidth, this.canvas.clientHeight, false);
    const { size: [width, height] } = this.layout();
    const aspect = width / height;
    const half = 1.18 * Math.max(this.extent[1], this.extent[0] / aspect);
    Object.assign(this.camera, { left: -half * aspect, right: half * aspect, top: half, bottom: -half });
    this.camera.updateProjectionMatrix();
    this.invalidate();
  }

  /** Where a point is on the canvas in a pane [px]. */
  project(point, pane) {
    const { size: [width, height], at } = this.layout();
    const { x, y } = point.clone().project(this.camera);
    const [left, top] = at(pane);
    return [left + 0.5 * (1 + x) * width, top + 0.5 * (1 - y) * height];
  }

  /** The nearest that is seen at a place on the canvas [px]: three's hit with the pane; null for nothing. */
  pick(x, y) {
    const { size: [width, height], at } = this.layout();
    const pane = this.panes.findIndex((_, i) => {
      const [left, top] = at(i);
      return x >= left && x < left + width && y >= top && y < top + height;
    });
    if (pane < 0) return null;
    const [left, top] = at(pane);
    this.ray.setFromCamera(new THREE.Vector2((2 * (x - left)) / width - 1, 1 - (2 * (y - top)) / height), this.camera);
    const hits = this.ray.intersectObjects(this.panes[pane].scene.children, true);
    const hit = hits.find(({ object, point }) => isShown(object) && !isCutAway(object, point));
    return hit ? { ...hit, pane } : null;
  }

  invalidate() {
    this.waiting ??= requestAnimationFrame(() => {
      this.waiting = null;
      this.draw();
    });
  }

  draw() {
    const { size: [width, height], at } = this.layout();
    const { renderer, camera } = this;
    renderer.setScissorTest(true);
    camera.updateMatrixWorld();
    const [right, up, back] = [0, 1, 2].map((i) => new THREE.Vector3().setFromMatrixColumn(camera.matrixWorld, i));
    this.panes.forEach(({ scene, lamp }, i) => {
      const [x, y] = at(i);
      const bottom = this.canvas.clientHeight - y - height;
      renderer.setViewport(x, bottom, width, height);
      renderer.setScissor(x, bottom, width, height);
      renderer.clear(true, true, true);
      lamp.position.copy(back).addScaledVector(up, 0.7).addScaledVector(right, 0.45);
      renderer.render(scene, camera);
    });
    this.annotate(right, up, at, height);
    this.drawn();
  }

  annotate(right, up, at, height) {
    const names = this.root.querySelector('#names');
    names.replaceChildren(...this.panes.filter((p) => p.name).map((pane, i) => {
      const span = document.createElement('span');
      span.textContent = pane.name;
      const [x, y] = at(i);
      Object.assign(span.style, { left: `${x + 12}px`, top: `${y + 10}px` });
      return span;
    }));
    const axes = this.root.querySelector('#axes');
    axes.replaceChildren(...AXES.flatMap(([name, color], c) => {
      const [x, y] = [32 * right.getComponent(c), -32 * up.getComponent(c)];
      const line = element('line', { x1: 0, y1: 0, x2: x, y2: y, stroke: color, 'stroke-width': 3, 'stroke-linecap': 'round' });
      const text = element('text', { x: 1.35 * x, y: 1.35 * y, fill: color, 'text-anchor': 'middle', 'dominant-baseline': 'central' });
      text.textContent = name;
      return [line, text];
    }));
    const perPixel = (this.camera.top - this.camera.bottom) / this.camera.zoom / height;
    this.perPixel = perPixel;
    const power = 10 ** Math.floor(Math.log10(120 * perPixel));
    const length = [5, 2, 1].map((m) => m * power).find((l) => l <= 120 * perPixel);
    const bar = this.root.querySelector('#scale span');
    bar.style.width = `${length / perPixel}px`;
    bar.textContent = `${Number(length.toPrecision(1))} mm`;
    this.scale = { length: length / perPixel, text: bar.textContent };
    if (this.drawings.length) this.root.querySelector('#over').replaceChildren(...this.drawings.flatMap((drawing) => drawing()));
  }
}

function isShown(object) {
  return object.visible && (!object.parent || isShown(object.parent));
}

function isCutAway({ material }, point) {
  return (material.clippingPlanes ?? []).some((plane) => plane.distanceToPoint(point) < 0);
}

/** How far points are from a centre along an axis, at most. */
function reach(lists, centre, { x, y, z }) {
  const middle = x * centre.x + y * centre.y + z * centre.z;
  let most = 1e-9;
  for (const points of lists) {
    for (let i = 0; i < points.length; i += 3) {
      most = Math.max(most, Math.abs(x * points[i] + y * points[i + 1] + z * points[i + 2] - middle));
    }
  }
  return most;
}

function element(name, attributes) {
  const made = document.createElementNS(SVG, name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}
