// Tags: their names, and which face has which.

import { PALETTE } from 'page/color';

/** No tag. */
export const NONE = -1;
const LONGEST = 200;

export class Tags {
  /**
   * `borders` are [face, face, whether they meet smoothly]; `given` are tags of a file, or null; `changed`
   * is called after every change. A tag that is `kept` has its table in place of faces.
   */
  constructor(faces, borders, given, changed) {
    const { list = [], of = faces.map(() => NONE) } = given ?? {};
    Object.assign(this, { faces, changed, list, of, active: list.findIndex((tag) => !tag.kept), done: [], undone: [] });
    this.beside = faces.map(() => []);
    for (const [a, b, smooth] of borders) {
      this.beside[a].push([b, smooth]);
      this.beside[b].push([a, smooth]);
    }
  }

  /** What undo goes back to. */
  text() {
    const { list, of, active } = this;
    return JSON.stringify({ list, of, active });
  }

  /** Remembers how things are, before they change. */
  keep() {
    this.done.push(this.text());
    if (this.done.length > LONGEST) this.done.shift();
    this.undone = [];
  }

  undo() {
    this.back(this.done, this.undone);
  }

  redo() {
    this.back(this.undone, this.done);
  }

  back(from, to) {
    if (from.length === 0) return;
    to.push(this.text());
    this.restore(from.pop());
  }

  /** Takes over a state that `text` gave; whether it fits. */
  restore(text) {
    const { list, of, active } = JSON.parse(text);
    if (!Array.isArray(of) || of.length !== this.faces.length) return false;
    Object.assign(this, { list, of, active });
    this.changed();
    return true;
  }

  color(tag) {
    return PALETTE[tag % PALETTE.length];
  }

  /** A new tag, to which clicks go; a chamber is the wall of an air space. */
  add(name, { chamber = false, faces = [], joined = false } = {}) {
    if (!joined) this.keep();
    const taken = new Set(this.list.map((tag) => tag.name));
    let free = name;
    for (let i = 2; taken.has(free); i++) free = `${name} ${i}`;
    this.list.push({ name: free, chamber, plug: false });
    this.active = this.list.length - 1;
    for (const face of faces) this.of[face] = this.active;
    this.changed();
    return this.active;
  }

  remove(tag) {
    this.keep();
    this.list.splice(tag, 1);
    this.of = this.of.map((t) => (t === tag ? NONE : t > tag ? t - 1 : t));
    this.active = Math.min(this.active > tag ? this.active - 1 : this.active, this.list.length - 1);
    this.changed();
  }

  set(tag, what) {
    this.keep();
    Object.assign(this.list[tag], what);
    this.changed();
  }

  choose(tag) {
    if (tag >= this.list.length) return;
    this.active = tag;
    this.changed();
  }

  /** Gives faces a tag; those inside the body and those of its boundary have tags of their own. */
  give(faces, tag) {
    const own = tag === NONE ? null : this.facesOf(tag)[0];
    const fits = (face) => this.faces[face].file && (own === undefined || own === null || this.faces[own].inside === this.faces[face].inside);
    const given = faces.filter((face) => fits(face) && this.of[face] !== tag);
    for (const face of given) this.of[face] = tag;
    if (given.length > 0) this.changed();
    return given;
  }

  facesOf(tag) {
    return this.of.flatMap((t, face) => (t === tag && this.faces[face].file ? [face] : []));
  }

  area(tag) {
    return this.facesOf(tag).reduce((sum, face) => sum + this.faces[face].area, 0);
  }

  /** The faces that a click on one takes. */
  grow(start, how) {
    if (how === 'face') return [start];
    const same = this.of[start];
    const goes = how === 'tangent' ? (next, smooth) => smooth : (next) => this.of[next] === same;
    const found = new Set([start]);
    for (const face of found) {
      for (const [next, smooth] of this.beside[face]) if (goes(next, smooth)) found.add(next);
    }
    return [...found];
  }

  /** Names of the tags that hold the opening of a chamber: those around it, and kept ones of the file. */
  rim(tag) {
    const kept = this.list.filter(({ name, kept: text }) => text && this.list[tag].rim?.includes(name));
    return [...this.around(tag).tags.map((t) => this.list[t]), ...kept].map(({ name }) => name.trim());
  }

  /** What lies around a tag: tags by number, and faces without one. */
  around(tag) {
    const next = new Set(this.facesOf(tag).flatMap((face) => this.beside[face].map(([other]) => other)).filter((other) => this.of[other] !== tag));
    const tags = [...new Set([...next].map((face) => this.of[face]))].filter((t) => t !== NONE).sort((a, b) => a - b);
    return { tags, bare: [...next].filter((face) => this.of[face] === NONE) };
  }
}
