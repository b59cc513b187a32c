// The page: a body, tags, and what joins them.

import * as THREE from 'three';
import { numbers } from 'page/arrays';
import { planeAcross } from 'page/cap';
import { button, row } from 'page/controls';
import { Stage, VIEWS } from 'page/stage';
import { Body } from 'pick/body';
import { Hand } from 'pick/hand';
import { Labels } from 'pick/labels';
import { Panel } from 'pick/panel';
import { NONE, Tags } from 'pick/tags';
import { written } from 'pick/toml';

const at = (id) => document.getElementById(id);
const data = JSON.parse(at('data').textContent);
const faces = data.body.faces;

/** What is seen, and what a click takes. */
const look = {
  axis: 'none', at: 0.5, sign: 1, hides: false, through: false, how: 'face',
  plane(box) {
    return planeAcross(box, this);
  },
};

/** Where the browser keeps what was chosen, by what was chosen from. */
const place = `puffer pick ${data.title} ${data.given ? JSON.stringify(data.given) : ''}${faces.map((face) => [face.name, face.area.toPrecision(5)]).join()}`;

const tags = new Tags(faces, data.body.borders, data.given, () => refresh());
let stage, body, hand, panel, labels;
let stroke = NONE;
let firstPicture = null;

function refresh() {
  body.paint(tags);
  view();
  panel.refresh();
  at('undo').disabled = tags.done.length === 0;
  at('redo').disabled = tags.undone.length === 0;
  kept();
}

/** Keeps the state, where the browser lets a page do so. */
function kept() {
  try {
    localStorage.setItem(place, tags.text());
  } catch { /* then it is lost when the page is closed */ }
}

function view() {
  const hidden = new Set(look.hides ? faces.flatMap((_, i) => (tags.of[i] !== NONE ? [i] : [])) : []);
  const ghosts = new Set(look.through ? faces.flatMap((_, i) => (tags.of[i] === NONE ? [i] : [])) : []);
  body.show(look.plane(body.shape.boundingBox), hidden, ghosts);
  stage.invalidate();
}

/** Clicks go to a tag; without one that is made of faces there is a new one. */
function target() {
  if (tags.active === NONE || tags.list[tags.active].kept) tags.add('tag');
  return tags.active;
}

function click(face) {
  if (!faces[face].file) return say(`${faces[face].name}: no file of patches holds it`);
  const before = tags.list.length;
  const all = tags.grow(face, look.how);
  const tag = target();
  tags.keep();
  const back = all.every((f) => tags.of[f] === tag);
  const given = tags.give(all, back ? NONE : tag);
  if (given.length > 0) say(`${given.length} ${given.length === 1 ? 'face' : 'faces'} ${back ? 'given back by' : 'to'} ${tags.list[tag].name}`);
  if (tags.list.length > before) panel.focus(tag);
  mark(hand.hovered, null, true);
}

/** A stroke gives all its faces what it gives the first. */
function painted(face, first) {
  const tag = target();
  if (first) {
    tags.keep();
    stroke = tags.of[face] === tag ? NONE : tag;
  }
  tags.give(tags.grow(face, look.how), stroke);
  mark(face);
}

/** Marks what a click on a face takes, and says what the face is, beside the pointer, too. */
function mark(face, pointer, quiet) {
  const tip = at('tip');
  const text = face === null ? '' : Panel.described(faces[face], tags.list[tags.of[face]]?.name);
  body.mark(face === null ? [] : tags.grow(face, look.how));
  stage.invalidate();
  stage.canvas.style.cursor = face === null ? 'grab' : 'pointer';
  if (face !== null && !quiet) say(text);
  tip.hidden = face === null || !pointer;
  if (tip.hidden) return;
  tip.textContent = text;
  const { left, top, width } = stage.root.getBoundingClientRect();
  const x = pointer.clientX - left;
  tip.style.left = x < 0.6 * width ? `${x + 16}px` : 'auto';
  tip.style.right = x < 0.6 * width ? 'auto' : `${width - x + 16}px`;
  tip.style.top = `${Math.max(pointer.clientY - top - 30, 4)}px`;
}

function say(text) {
  at('said').textContent = text;
}

const HOWS = [['face', 'face'], ['tangent', 'tangent faces'], ['all', 'all connected']];
const DRAGS = [['turn', 'turns'], ['paint', 'paints']];

function tools() {
  const group = (title, options, now, choose) => {
    const label = document.createElement('span');
    label.textContent = title;
    const made = row(label, ...options.map(([value, text]) => {
      const one = button(text, () => choose(value));
      one.setAttribute('aria-pressed', value === now);
      one.dataset.value = value;
      return one;
    }));
    return made;
  };
  at('tools').replaceChildren(
    group('a click takes', HOWS, look.how, (value) => { look.how = value; tools(); }),
    group('a drag', DRAGS, hand.drag, (value) => { hand.drag = value; tools(); }),
  );
}

/** The next face that can be chosen, as Tab goes; none after the last one. */
function next(step) {
  const open = faces.flatMap((face, i) => (face.file && !body.hidden.has(i) ? [i] : []));
  const now = hand.hovered === null ? (step > 0 ? -1 : open.length) : open.indexOf(hand.hovered);
  return open[now + step] ?? null;
}

function key(event) {
  const { key: name } = event;
  if (event.target.matches('input, select, textarea')) return;
  const control = event.ctrlKey || event.metaKey;
  const how = { f: 'face', t: 'tangent', a: 'all' }[name.toLowerCase()];
  if (control && name.toLowerCase() === 'z') event.shiftKey ? tags.redo() : tags.undo();
  else if (control && name.toLowerCase() === 'y') tags.redo();
  else if (control || event.altKey) return;
  else if (how) { look.how = how; tools(); mark(hand.hovered); }
  else if (name.toLowerCase() === 'p') { hand.drag = hand.drag === 'turn' ? 'paint' : 'turn'; tools(); }
  else if (name.toLowerCase() === 'h') panel.hides.input.click();
  else if (name.toLowerCase() === 'x') panel.through.input.click();
  else if (name.toLowerCase() === 'l') panel.numbers.input.click();
  else if (name.toLowerCase() === 'n') panel.named();
  else if (/^[1-9]$/.test(name)) tags.choose(Number(name) - 1);
  else if (name === '0') stage.fit([body.nodes]);
  else if (event.target !== stage.canvas || !canvasKey(event)) return;
  event.preventDefault();
}

function canvasKey({ key: name, shiftKey }) {
  if (name === 'Tab') {
    const face = next(shiftKey ? -1 : 1);
    hand.hovered = face;
    mark(face);
    if (face !== null) hand.turnTo(faces[face]);
    return face !== null;
  }
  if ((name !== 'Enter' && name !== ' ') || hand.hovered === null) return false;
  click(hand.hovered);
  return true;
}

async function begin() {
  try {
    stage = new Stage(at('stage'), drawn);
  } catch (error) {
    document.body.classList.add('unseen');
    at('viewer').hidden = true;
    at('notice').hidden = false;
    at('notice').textContent = `There is no 3-D view here, as the browser has no WebGL (${error.message}).`;
    return;
  }
  const [nodes, triangles] = await Promise.all([numbers(data.body.nodes), numbers(data.body.triangles)]);
  body = new Body(nodes, triangles, faces);
  stage.show([{ objects: body.objects }]);
  stage.fit([nodes]);
  labels = new Labels(stage, body, at('labels'));
  hand = new Hand(stage, body, { hover: mark, click, stroke: painted });
  const on = {
    turn: (face) => hand.turnTo(faces[face]),
    look: (chosen) => { body.mark(chosen); stage.invalidate(); },
    view: () => {
      const toward = stage.camera.position.clone().sub(stage.controls.target);
      if (look.axis !== 'none' && look.axis !== look.before) look.sign = toward[look.axis] >= 0 ? 1 : -1;
      look.before = look.axis;
      view();
    },
    back: () => stage.canvas.focus({ preventScroll: true }),
    number: (on) => labels.set(on),
    say, kept,
  };
  panel = new Panel(at('panel'), tags, data, look, on);
  at('loading').hidden = true;
  at('views').append(
    ...Object.keys(VIEWS).map((name) => button(name, () => stage.view(name, [nodes]))),
    button('all', () => stage.fit([nodes])),
  );
  at('undo').addEventListener('click', () => tags.undo());
  at('redo').addEventListener('click', () => tags.redo());
  document.addEventListener('keydown', key);
  at('lead').hidden = parent !== window;
  tools();
  // before anything new is kept
  if (!restored()) refresh();
}

/** After each picture. */
function drawn() {
  if (body) firstPicture ??= performance.now();
  labels?.redraw();
}

/** Takes up what this browser kept of the same body; whether there was anything. */
function restored() {
  try {
    const before = localStorage.getItem(place);
    if (!before || JSON.parse(before).list.length === 0 || !tags.restore(before)) return false;
    say('taken up where you were');
    return true;
  } catch {
    return false; // nothing is kept, or not by this page
  }
}

/** Where a face is seen, for tests: a pixel of the page that shows it. */
function seen(face) {
  const { left, top, width, height } = stage.canvas.getBoundingClientRect();
  const [from, to] = faces[face].triangles;
  for (let t = from; t < to; t++) {
    const corners = [0, 1, 2].map((k) => new THREE.Vector3().fromArray(body.nodes, 3 * body.triangles[3 * t + k]));
    const p = corners[0].add(corners[1]).add(corners[2]).divideScalar(3).project(stage.camera);
    if (body.at(p.x, p.y, stage.camera) === face) return [left + ((p.x + 1) / 2) * width, top + ((1 - p.y) / 2) * height];
  }
  return null;
}

/** What the page shows, for tests. */
window.puffer = {
  state: () => ({ firstPicture, faces: faces.length, list: tags.list, of: tags.of, active: tags.active, hovered: hand?.hovered ?? null, how: look.how, drag: hand?.drag }),
  toml: () => written(tags, data),
  seen,
};

await begin();
