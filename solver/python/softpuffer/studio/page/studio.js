// The page of `puffer studio`: it shows what the folder has, and asks the server for each change.

const at = (id) => document.getElementById(id);
const step = (name) => document.querySelector(`[data-step=${name}]`);
const part = (name, of) => step(name).querySelector(of);
/** Where a step answers; how a run ended is said elsewhere in it. */
const told = (name) => part(name, ':scope > .said');
const BUSY = 1000, IDLE = 4000;

let home = { folder: '', bodies: [], largest: 0 };
let state = null, silicones = null, cad = null, waiting = null, kept = false;
/** What parts of the page show, so that none is made again as it was; and the text that is edited. */
const drawn = {}, edited = { name: '', text: '', version: '' };

function make(tag, properties, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

async function ask(path, options) {
  const answer = await fetch(path, options).catch(() => { throw new Error('puffer studio has ended. Start it again in a terminal, and open the address that it prints.'); });
  if (!answer.ok) throw new Error((await answer.json().catch(() => ({}))).message ?? `${answer.status} ${answer.statusText}`);
  return answer;
}

/** A change, after which the page shows what is there; whether it was made. */
async function change(path, body, said, done, version) {
  said.className = 'said';
  said.textContent = 'one moment …';
  try {
    const headers = { 'X-Puffer': 'studio', ...(version ? { 'If-Match': version } : {}) };
    state = await (await ask(path, { method: 'POST', body, headers })).json();
    said.textContent = done;
    said.classList.add('good');
    return true;
  } catch (error) {
    said.textContent = error.message;
    said.classList.add('bad');
    return false;
  } finally {
    await refresh();
  }
}

const post = (verb, body, of, done = '', version = '') => change(`bodies/${state.name}/${verb}`, body, told(of), done, version);
const set = (file, what) => post(`set/${file}`, JSON.stringify(what), 'settings', `${state.name}/${file} is saved`, state.files[file]);

/** Reads all again: often while something is made. */
async function refresh() {
  clearTimeout(waiting);
  const name = decodeURIComponent(location.hash.slice(1));
  let wait = BUSY;
  try {
    if (name) state = await (await ask(`bodies/${encodeURIComponent(name)}`)).json();
    else home = await (await ask('bodies')).json();
    if (!name || !state.run.running) wait = IDLE;
    at('lost').hidden = true;
    at('home').hidden = Boolean(name);
    at('body').hidden = !name;
    at('name').textContent = name;
    document.title = name ? `${name} – puffer studio` : 'puffer studio';
    if (!name) showHome();
    else {
      show();
      // a program lists them: all else is shown before
      if (!silicones) { silicones = await (await ask('silicones')).json(); show(); }
    }
  } catch (error) {
    at('lost').hidden = false;
    at('lost').textContent = error.message;
  }
  waiting = setTimeout(refresh, wait);
}

/** Makes a part of the page again if what it shows has changed. */
function once(name, what, draw) {
  const now = JSON.stringify(what);
  if (drawn[name] === now) return;
  drawn[name] = now;
  draw(what);
}

function showHome() {
  at('place').textContent = `in ${home.folder}`;
  at('there').hidden = home.bodies.length === 0;
  once('bodies', home.bodies, (bodies) => at('bodies').replaceChildren(...bodies.map(({ name, running }) =>
    make('li', {}, make('a', { href: `#${name}`, textContent: name }), running ? ' is being made' : ''))));
  const name = at('called').value || 'NAME';
  at('of-new').textContent = cad ? `puffer new ${name} && rm ${name}/model.toml ${name}/sim.blocked.toml ${name}/tags.toml && cp '${cad.name}' ${name}/model.${ending(cad)}` : `puffer new ${name}`;
}

const ending = (file) => file.name.split('.').pop().toLowerCase().replace(/^igs$/, 'iges');

function show() {
  const { run, name, models, files } = state;
  const picks = run.command.startsWith('cad2fem pick');
  const ready = state.page > 0 && !(picks && run.running);
  const tagged = files['tags.toml'] !== '0';
  const sound = tagged && state.missing.length === 0 && state.unfilled.length === 0;
  at('place').textContent = `in ${state.above}, as are the commands below`;
  const marks = { model: [ready, true], faces: [tagged, ready], settings: [sound, tagged], make: [state.report && !state.old && !run.running, sound], results: [state.report, state.report], files: [false, true] };
  for (const [key, [done, open]] of Object.entries(marks)) {
    step(key).classList.toggle('done', Boolean(done));
    step(key).classList.toggle('later', !open);
  }
  at('model').textContent = models.length === 1 ? `${name}/${models[0]}` : models.length ? `${models.join(' and ')}: remove all but one` : 'There is no model yet.';
  at('again').hidden = models.some((model) => /\.(toml|geo)$/.test(model));
  once('pick', [name, ready && state.page], ([, page]) => {
    at('pick').hidden = !page;
    if (page && !kept) at('pick').src = `bodies/${name}/files/build/pick.html?${page}`;
  });
  part('faces', '.command').textContent = state.pick;
  at('wanted').textContent = tagged ? '' : ` sim.toml and mold.toml speak of ${[...new Set(state.missing.map((one) => one.name))].join(', ')}.`;
  at('read').hidden = run.running ? !picks : ready || models.length !== 1;
  at('read').textContent = run.running ? 'Stop' : 'Read it, to click its faces';
  once('settings', [name, tagged, state.tags, state.missing, state.chambers, state.unfilled, state.silicone, state.cast, files, silicones], () => tagged && silicones && settings());
  const made = run.running && !picks;
  at('make').textContent = made ? 'Stop' : state.report ? 'Make again what has changed' : 'Make all of it';
  at('make').disabled = !made && (run.running || !tagged);
  at('why').textContent = made || sound ? '' : tagged ? 'What is red above will stop it.' : 'Save tags.toml first.';
  part('make', '.command').textContent = `puffer make -C ${name}`;
  for (const [key, mine] of [['model', picks], ['make', !picks]]) once(`run ${key}`, mine ? [name, run] : null, () => running(part(key, '.runs'), mine && run.command ? run : null));
  once('report', [name, state.report], ([, report]) => {
    at('report').hidden = !report;
    if (report) at('report').src = `bodies/${name}/files/build/report.html?${report}`;
  });
  once('results', [name, state.report, state.old, state.pictures, state.parts, state.zip], results);
  once('files', [name, files, state.shown], listed);
}

/** What runs, or how it ended. */
function running(root, run) {
  const before = root.querySelector('.log');
  const open = root.querySelector('details')?.open ?? true;
  root.replaceChildren();
  if (!run) return;
  const ended = run.running ? '' : run.code === 0 ? 'Done.' : run.code === null ? 'It was stopped. Make it again: it goes on where it was.' : `It failed. ${run.why}`;
  const where = `${run.step}${run.steps > 1 ? `, ${run.done} of ${run.steps}` : ''}`;
  root.append(run.running ? make('p', {}, make('progress', { max: Math.max(run.steps, 1), ...(run.steps > 1 ? { value: Math.max(run.done - 0.5, 0) } : {}) }), ` ${where}`)
    : make('p', { className: run.code === 0 ? 'good said' : 'bad said', textContent: ended }));
  if (run.why.includes(' --subtract ')) root.append(solids(run.why));
  const log = make('pre', { className: 'log', textContent: run.log });
  root.append(make('details', { open: run.code !== 0 && open }, make('summary', { textContent: 'what it says' }), log));
  log.scrollTop = before && before.scrollTop + before.clientHeight < before.scrollHeight - 30 ? before.scrollTop : log.scrollHeight;
}

/** What becomes of the solids of a file, of which a message tells. */
function solids(why) {
  const boxes = [...why.matchAll(/^ {2}solid (\d+)/gm)].map(([text, value]) => make('label', {}, make('input', { type: 'checkbox', value }), text));
  const read = (how) => post('pick', how, 'model');
  const air = make('button', { textContent: 'Take out what is marked: it is air', onclick: () => read(['--subtract', ...boxes.map((box) => box.firstChild).filter((box) => box.checked).map((box) => box.value)].join(' ')) });
  return make('p', { className: 'row' }, ...boxes, air, make('button', { textContent: 'All are one body', onclick: () => read('--unite') }));
}

/** Lists of silicones, pressures, and what names tags that are not there. */
function settings() {
  const list = (options, now, chosen) => {
    const made = make('select', {}, ...options.map(([value, text]) => make('option', { value, textContent: text, selected: value === now })));
    made.addEventListener('change', () => chosen(made.value));
    return made;
  };
  const rows = [];
  const row = (text, ...what) => rows.push(make('span', {}, text), make('span', { className: 'row' }, ...what));
  const names = silicones.map(({ name, about }) => [name, `${about.split(';')[0]} (${name})`]);
  if (state.silicone) {
    const now = state.silicone.name;
    const known = names.some(([name]) => name === now) ? names : [[now, `${now} – not in the library`], ...names];
    row('silicone', list(known, now, async (value) => {
      if (!await set('sim.toml', { number: state.silicone.number, key: 'material', value }) || !state.cast) return;
      await set('mold.toml', { number: state.cast.number, key: 'silicone', value });
    }), make('span', { className: 'about', textContent: silicones.find(({ name }) => name === now)?.about ?? '' }));
  } else row('silicone', 'sim.toml has a table [material]: change it below');
  for (const { on, number, pressure } of state.chambers) {
    if (pressure === null) { row(`pressure in ${on}`, 'sim.toml has more than a number: change it below'); continue; }
    const value = make('input', { type: 'text', inputMode: 'decimal', size: 8, value: Number((pressure / 1000).toPrecision(6)) });
    value.setAttribute('list', 'pressures');
    value.setAttribute('aria-label', `pressure in ${on} [kPa]`);
    value.addEventListener('change', () => {
      const pascals = Number((1000 * Number(value.value.replace(',', '.'))).toPrecision(9));
      if (value.value.trim() && Number.isFinite(pascals)) return set('sim.toml', { number, key: 'pressure', value: pascals });
      Object.assign(told('settings'), { className: 'said bad', textContent: `${value.value}: a pressure is a number, in kPa` });
    });
    row(`pressure in ${on}`, value, 'kPa above that around it');
  }
  const tags = state.tags.map(({ name }) => [name, name]);
  for (const { file, table, number, key, name } of state.missing) {
    rows.push(make('p', { className: 'bad said', textContent: `${file}: ${table ? `[[${table}]] ` : ''}${key} = "${name}", but no tag is called that.` }));
    const other = list([['', 'choose the tag that is meant'], ...tags], '', (value) => set(file, { number, key, value }));
    const leave = make('button', { textContent: `leave this [[${table}]] out`, hidden: !table });
    leave.addEventListener('click', () => set(file, { leave: number }));
    row('', other, leave);
  }
  for (const tag of state.unfilled) {
    rows.push(make('p', { className: 'bad said', textContent: `${tag} is the wall of an air chamber, but sim.toml lets no air in there.` }));
    const fill = make('button', { textContent: `let air into ${tag}` });
    fill.addEventListener('click', () => set('sim.toml', { chamber: tag, pressure: state.chambers[0]?.pressure ?? 5e3 }));
    row('', fill);
  }
  at('settings').replaceChildren(...rows);
  part('settings', '.command').textContent = `solver list --silicones    # a name is a line of ${state.name}/sim.toml and of mold.toml, the pressure one of sim.toml`;
}

function results([name, report, old, pictures, parts, zip]) {
  const file = (path, text = path) => make('a', { href: `bodies/${name}/files/${path.split('/').map(encodeURIComponent).join('/')}`, textContent: text, target: '_blank' });
  at('result').replaceChildren(...(report ? [old ? 'These are older than what is above: make again. ' : '', file('build/report.html', 'The page by itself'), zip ? ' · ' : '', ...(zip ? [make('a', { ...{ textContent: `${zip.split('/').pop()}, all of it to send` }, href: file(zip).href, download: '' })] : [])] : ['Nothing is made yet.']));
  document.querySelectorAll('.mold').forEach((line) => { line.hidden = parts.length === 0; });
  at('pictures').replaceChildren(...pictures.map((path) => make('img', { src: `${file(path).href}?${report}`, alt: path })));
  at('parts').replaceChildren(...parts.map((path) => make('li', {}, file(path, path.replace('build/mold/', '')))));
  part('results', '.command').textContent = report ? `xdg-open ${name}/build/report.html` : '';
}

/** The files, and that which is edited. */
async function listed([name, files, shown]) {
  const all = [...Object.keys(files).filter((file) => files[file] !== '0'), ...shown];
  at('files').replaceChildren(...all.map((file) => {
    const made = make('button', { textContent: file });
    made.setAttribute('aria-pressed', file === edited.name);
    made.addEventListener('click', () => (at('text').value === edited.text || confirm(`Discard what you changed in ${edited.name}?`)) && load(file));
    return made;
  }));
  if (edited.body !== name || !all.includes(edited.name)) await load(all.includes('sim.toml') ? 'sim.toml' : all[0]);
  else if (files[edited.name] !== edited.version && at('text').value === edited.text) await load(edited.name);
}

async function load(file) {
  const answer = await ask(`bodies/${state.name}/files/${encodeURIComponent(file)}`);
  Object.assign(at('text'), { value: await answer.text(), readOnly: state.shown.includes(file) });
  Object.assign(edited, { body: state.name, name: file, text: at('text').value, version: answer.headers.get('ETag') });
  at('stands').textContent = at('text').readOnly ? 'A Makefile is a program: change it in an editor.' : '';
  at('save').disabled = true;
  for (const button of at('files').children) button.setAttribute('aria-pressed', button.textContent === file);
}

function droppable(root, taken) {
  const input = root.querySelector('input');
  const take = (file) => file && (file.size > home.largest ? alert(`${file.name} has ${Math.round(file.size / 1e6)} MB. At most ${Math.round(home.largest / 1e6)} MB are taken: copy it into the folder of the body, as model.${ending(file)}.`) : taken(file));
  input.addEventListener('change', () => take(input.files[0]));
  for (const kind of ['dragover', 'dragleave', 'drop']) {
    root.addEventListener(kind, (event) => {
      event.preventDefault();
      root.classList.toggle('over', kind === 'dragover');
      if (kind === 'drop') take(event.dataTransfer.files[0]);
    });
  }
}

/** The file of a new body, or none. */
function taken(file) {
  cad = file;
  at('first').classList.toggle('full', Boolean(file));
  at('first').querySelector('span').textContent = file?.name ?? 'Drop a file here, or choose one';
  at('called').value = file ? at('called').value || file.name.replace(/\.[^.]*$/, '').replace(/[^A-Za-z0-9_-]+/g, '-').replace(/^-+|-+$/g, '').slice(0, 64) : '';
  showHome();
}
droppable(at('first'), taken);
droppable(at('again'), (file) => confirm(`Take ${file.name} in place of ${state.models.join(', ') || 'no model'}?`) && post(`model/${ending(file)}`, file, 'model'));

async function begin(file) {
  const name = at('called').value.trim();
  if (!name) return at('called').reportValidity();
  if (await change(`bodies/${encodeURIComponent(name)}/new${file ? `/${ending(file)}` : ''}`, file ?? '', at('said-new'), '')) {
    location.hash = name;
    taken(null);
  }
}
at('new').addEventListener('submit', (event) => {
  event.preventDefault();
  if (cad) return begin(cad);
  Object.assign(at('said-new'), { className: 'said bad', textContent: 'Drop a CAD file first, or begin with the sample.' });
});
at('sample').addEventListener('click', () => begin(null));
at('called').addEventListener('input', showHome);
at('read').addEventListener('click', () => post(state.run.running ? 'stop' : 'pick', '', 'model'));
at('make').addEventListener('click', () => post(state.run.running ? 'stop' : 'make', '', 'make'));
at('text').addEventListener('input', () => { at('save').disabled = at('text').readOnly || at('text').value === edited.text; });
at('save').addEventListener('click', async () => {
  const { name } = edited;
  if (await post(`save/${name}`, at('text').value, 'files', `${state.name}/${name} is saved`, edited.version)) load(name);
});
addEventListener('message', async ({ source, data }) => {
  if (source !== at('pick').contentWindow || typeof data?.tags !== 'string') return;
  // the page of the faces stays as it is: it shows these tags already
  kept = true;
  if (await post('save/tags.toml', data.tags, 'faces', `${state.name}/tags.toml is saved`, state.files['tags.toml'])) {
    step('settings').scrollIntoView({ behavior: 'smooth' });
  }
  kept = false;
});
addEventListener('hashchange', () => { Object.keys(drawn).forEach((key) => delete drawn[key]); refresh(); });
refresh();
