// The panel: tags, proposals, what is seen, and the file.

import { button, check, fieldset, make, row, select, slider } from 'page/controls';
import { areaText, count, facing, remarks, written } from 'pick/toml';
import { NONE } from 'pick/tags';

const AXES = ['x', 'y', 'z'];

/** Names that most bodies need, as `cad2fem new` writes them into sim.toml; a chamber is the wall of an air space. */
const USUAL = [['fixed', 'what is held', {}], ['cavity', 'the wall of a chamber', { chamber: true }], ['tip', 'the free end', {}], ['skin', 'the outside', {}]];

/** The page that this one is embedded in, such as that of puffer studio, takes the file in place of a download. */
const embedded = parent !== window;

const number = (value) => String(Number(value.toPrecision(4))).replace('-', '−');

export class Panel {
  /** `on` has: look(faces) to mark some, view() after a change of what is seen, say(text). */
  constructor(root, tags, data, look, on) {
    Object.assign(this, { root, tags, data, look, on });
    this.list = make('div', { id: 'tags', role: 'list' });
    this.usual = row();
    this.usual.id = 'usual';
    this.left = make('p', { className: 'left' });
    this.found = make('div', { id: 'found' });
    this.remarks = make('ul', { id: 'remarks' });
    this.text = make('pre', { id: 'toml', tabIndex: 0 });
    this.download = button(`${embedded ? 'Save' : 'Download'} tags.toml`, () => this.save());
    this.download.id = 'download';
    this.copy = button('Copy', () => this.copied());
    root.append(
      fieldset('Tags: the next click goes to the one that is marked', this.list, this.usual, this.left),
      this.proposals(),
      this.seen(),
      make('div', { id: 'file' },
        this.remarks,
        row(this.download, this.copy),
        make('details', {}, make('summary', { textContent: 'see the file' }), this.text)),
    );
    root.firstChild.className = 'first';
    root.addEventListener('submit', (event) => event.preventDefault());
  }

  /** After any change but that of a name, which is being typed. */
  refresh() {
    const { tags } = this;
    this.list.replaceChildren(...tags.list.map((tag, i) => this.tag(tag, i)));
    const known = new Set(tags.list.map((tag) => tag.name));
    const usual = USUAL.filter(([name]) => !known.has(name)).map(([name, meaning, how]) => {
      const made = button(`+ ${name}`, () => this.add(name, how));
      made.title = meaning;
      return made;
    });
    this.usual.replaceChildren(...usual, button('+ other', () => this.named()));
    const proposals = [...this.found.children];
    proposals.forEach((proposal) => proposal.refresh?.());
    this.found.parentElement.hidden = proposals.every((proposal) => proposal.hidden);
    this.told();
  }

  /** What is left, the file, and what is to be said of it: all that a name changes. */
  told() {
    const { tags } = this;
    const bare = this.bare();
    this.left.replaceChildren(bare.length === 0
      ? 'Every face has a tag.'
      : `${count(bare.length, 'face')} of ${this.tags.faces.filter((f) => f.file && !f.inside).length} without a tag. `);
    if (bare.length > 0 && tags.list.length > 0) this.left.append(this.rest(bare));
    const found = [...(this.data.given?.remarks ?? []).map((text) => ({ text: `tags.toml: ${text}` })), ...remarks(tags)];
    this.remarks.replaceChildren(...found.map(({ text, faces }) => {
      const line = make('li', {}, text);
      if (faces) line.append(' ', button('show', () => this.on.look(faces)));
      return line;
    }));
    this.text.textContent = written(tags, this.data);
    const ready = tags.list.some((_, i) => tags.facesOf(i).length > 0) && !found.some((remark) => remark.bad);
    this.download.disabled = !ready;
    this.copy.disabled = !ready;
  }

  /** Gives all faces without a tag one, which a chamber is seldom. */
  rest(faces) {
    const { tags } = this;
    const active = tags.list[tags.active];
    if (active && !active.chamber && !active.kept) {
      return button(`give them to ${active.name || 'this tag'}`, () => {
        tags.keep();
        tags.give(faces, tags.active);
      });
    }
    return button('name them skin', () => this.add('skin', { faces }));
  }

  bare() {
    return this.tags.facesOf(NONE).filter((face) => !this.tags.faces[face].inside);
  }

  tag(tag, i) {
    const { tags } = this;
    const active = i === tags.active;
    const mark = make('input', { type: 'radio', name: 'active', checked: active, title: `key ${i + 1}` });
    mark.setAttribute('aria-label', `clicks go to ${tag.name}`);
    mark.addEventListener('change', () => tags.choose(i));
    const name = make('input', { type: 'text', value: tag.name, className: 'name', spellcheck: false });
    name.setAttribute('aria-label', 'name of the tag');
    name.addEventListener('focus', () => {
      if (tags.active === i) return;
      tags.choose(i);
      this.focus(i);
    });
    name.addEventListener('beforeinput', () => tags.keep(), { once: true });
    name.addEventListener('input', () => {
      tag.name = name.value;
      this.told();
      this.on.kept();
    });
    name.addEventListener('keydown', (event) => {
      if (event.key !== 'Enter' && event.key !== 'Escape') return;
      event.preventDefault();
      this.on.back();
    });
    name.readOnly = Boolean(tag.kept);
    const chamber = check('air chamber', tag.chamber, (on) => tags.set(i, { chamber: on }));
    chamber.title = 'air is let in: its faces are the wall of a chamber';
    const remove = button('✕', () => tags.remove(i));
    remove.setAttribute('aria-label', `remove ${tag.name}`);
    remove.className = 'remove';
    const swatch = make('i', { className: 'swatch' });
    swatch.style.background = tags.color(i);
    const size = make('span', { className: 'size', textContent: this.size(i) });
    if (tag.kept) size.title = tag.kept;
    const below = make('div', { className: 'below' }, size, tag.kept ? null : chamber);
    if (tag.chamber && !tag.kept) below.append(this.opening(tag, i));
    const made = make('div', { className: active ? 'tag active' : 'tag', role: 'listitem' }, make('div', { className: 'line' }, mark, swatch, name, remove), below);
    made.addEventListener('click', (event) => {
      if (['INPUT', 'BUTTON', 'SELECT', 'LABEL', 'SPAN'].includes(event.target.tagName) && event.target !== size) return;
      tags.choose(i);
    });
    return made;
  }

  /** How much a tag has. */
  size(i) {
    const faces = this.tags.facesOf(i);
    if (this.tags.list[i].kept) return 'kept as tags.toml has it, not shown';
    return faces.length > 0 ? `${count(faces.length, 'face')}, ${areaText(this.tags.area(i))}` : 'no face yet';
  }

  /** How the opening of a chamber is kept. */
  opening(tag, i) {
    const { tags } = this;
    const [rim, { bare }] = [tags.rim(i), tags.around(i)];
    if (rim.length + bare.length === 0) return make('span', { className: 'size', textContent: tags.facesOf(i).length > 0 ? 'closed all around' : '' });
    const held = rim.join(', ') || 'what is held';
    const list = select('its opening', [['held', `lies on ${held}`], ['plug', 'has a plug that moves along']], tag.plug ? 'plug' : 'held', (value) => tags.set(i, { plug: value === 'plug' }));
    list.className = 'opening';
    return list;
  }

  add(name, how = {}) {
    this.tags.add(name, how);
    this.on.back();
  }

  /** A tag whose name is to be typed. */
  named() {
    this.focus(this.tags.add('tag'));
  }

  focus(i) {
    const name = this.list.children[i]?.querySelector('.name');
    name?.focus();
    name?.select();
  }

  /** What the body proposes by itself. */
  proposals() {
    const { chambers, pockets, sides } = this.data.found;
    const line = (text, faces, ...buttons) => {
      const made = make('div', { className: 'proposal' }, make('span', { textContent: text }), row(...buttons));
      made.addEventListener('pointerenter', () => this.on.look(faces));
      made.addEventListener('pointerleave', () => this.on.look([]));
      made.addEventListener('focusin', () => this.on.look(faces));
      made.addEventListener('focusout', () => this.on.look([]));
      // a proposal that has been taken goes
      made.refresh = () => { made.hidden = faces.length > 0 && faces.every((face) => this.tags.of[face] !== NONE); };
      return made;
    };
    const take = (name, title, how, faces) => {
      const made = button(name, () => {
        this.on.look([]);
        this.on.turn(faces[0]);
        this.add(name, { ...how, faces });
      });
      made.title = title;
      return made;
    };
    const chamber = (name, title, faces, lids) => {
      const made = button(name, () => {
        this.on.look([]);
        if (lids.length > 0) this.on.turn(lids[0]);
        this.through.input.checked || this.through.input.click();
        const open = lids.filter((lid) => this.tags.of[lid] === NONE && this.tags.faces[lid].file);
        if (open.length > 0) this.tags.add('fixed', { faces: open });
        this.add('cavity', { chamber: true, faces, joined: open.length > 0 });
      });
      made.title = title;
      return made;
    };
    for (const { volume, faces } of chambers) {
      this.found.append(line(`Closed chamber of ${number(volume / 1000)} mL`, faces, chamber('cavity', count(faces.length, 'face'), faces, [])));
    }
    for (const { volume, faces, lid } of pockets) {
      const name = this.tags.faces[lid].name;
      const title = `${count(faces.length, 'face')} as cavity, and ${name}, in which it opens, as fixed`;
      this.found.append(line(`Chamber of ${number(volume / 1000)} mL, open in ${name}`, faces, chamber('cavity + fixed', title, faces, [lid])));
    }
    for (const { axis, at, faces } of sides) {
      const area = areaText(faces.reduce((sum, face) => sum + this.tags.faces[face].area, 0));
      const plane = at === 0 ? [take('cut', 'a plane of symmetry: only half of the body is here', {}, faces)] : [];
      this.found.append(line(`Flat at ${AXES[axis]} = ${number(at)} mm, ${area}`, faces, take('fixed', 'what is held', {}, faces), ...plane));
    }
    return fieldset('Found in this body', this.found);
  }

  /** The cut, and what is hidden. */
  seen() {
    const { look } = this;
    const change = (key) => (value) => {
      look[key] = value;
      this.on.view();
    };
    const place = slider('place', { min: 0, max: 1, step: 0.005, value: look.at }, change('at'));
    place.input.id = 'place';
    const axis = select('cut across', [['none', 'nothing'], ['x', 'x'], ['y', 'y'], ['z', 'z']], look.axis, change('axis'));
    axis.list.id = 'cut';
    this.through = check('see through faces without a tag', look.through, change('through'));
    this.through.input.id = 'through';
    this.hides = check('hide faces that have a tag', look.hides, change('hides'));
    this.hides.input.id = 'hides';
    this.numbers = check('number the faces', false, (on) => this.on.number(on));
    this.numbers.input.id = 'numbers';
    return fieldset('See', axis, place, row(button('other side', () => change('sign')(-look.sign))), this.through, this.hides, this.numbers);
  }

  save() {
    // of no origin in a sandbox, and the file is no secret: names of faces
    if (embedded) return parent.postMessage({ tags: written(this.tags, this.data) }, '*');
    const url = URL.createObjectURL(new Blob([written(this.tags, this.data)], { type: 'application/toml' }));
    make('a', { href: url, download: 'tags.toml' }).click();
    setTimeout(() => URL.revokeObjectURL(url), 10_000);
    this.on.say('tags.toml is in your downloads');
  }

  async copied() {
    try {
      await navigator.clipboard.writeText(written(this.tags, this.data));
    } catch {
      // where the browser does not let a page write, it lets a person copy what is marked
      this.text.parentElement.open = true;
      getSelection().selectAllChildren(this.text);
      document.execCommand('copy');
    }
    this.on.say('tags.toml is copied');
  }

  /** One face in words. */
  static described(face, tag) {
    const parts = [face.name, face.file ? face.kind : null, areaText(face.area), facing(face.normal), face.inside ? 'a sheet inside' : null];
    return `${parts.filter(Boolean).join(' · ')}${tag ? ` → ${tag}` : ''}`;
  }
}
