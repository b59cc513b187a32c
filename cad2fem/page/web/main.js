// The page: what it holds, and who shows it.

import { planeAcross } from 'page/cap';
import { RAMP, digits } from 'page/color';
import { button, check, fieldset, make, row, select, slider } from 'page/controls';
import { History } from 'page/history';
import { Load } from 'page/load';
import { Grip } from 'page/grip';
import { Mold } from 'page/mold';
import { Pointer, drawn as mark, label } from 'page/pointer';
import { path } from 'page/path';
import { response } from 'page/response';
import { download, fileName, picture } from 'page/save';
import { Shapes, sets } from 'page/shapes';
import { Stage, VIEWS } from 'page/stage';

const at = (id) => document.getElementById(id);
const data = JSON.parse(at('data').textContent);
for (const design of data.designs) design.sets = sets(design);

/** What all views share: the cut, how much the outside hides, sides of facets. */
const look = {
  axis: 'none', at: 0.5, sign: 1, opacity: 1, lines: false,
  /** The plane n·p = offset of the cut through a box; what is beyond it is removed. */
  plane(box) {
    return planeAcross(box, this);
  },
};

function makeStage() {
  try {
    return new Stage(at('stage'), () => drawn());
  } catch (error) {
    document.body.classList.add('unseen');
    at('notice').hidden = false;
    at('notice').textContent = `There is no 3-D view here, as the browser has no WebGL (${error.message}). The pictures show the same.`;
    return null;
  }
}

/** When the first picture was complete, after the page was asked for [ms]. */
let firstPicture = null;
let complete = false;
function drawn() {
  if (complete) firstPicture ??= performance.now();
}

const stage = makeStage();
let shown = null;
const views = [];
if (stage) {
  const chambers = [...new Set(data.runs.flatMap((run) => run.chambers))];
  if (data.runs.length > 0) views.push(new Load(stage, data.runs, look, legend));
  const shaped = data.designs.filter((design) => design.sets.length > 0);
  if (shaped.length > 0) views.push(new Shapes(stage, shaped, chambers, look, () => {
    legend();
    const { design, shape } = views.find((v) => v instanceof Shapes).set;
    history.mark(shaped[design], shape);
  }));
  if (data.molds.length > 0) views.push(new Mold(stage, data.molds, look));
}

const pointer = stage && new Pointer(stage, () => shown, (text) => {
  at('said').textContent = text;
});
if (stage) {
  new Grip(stage, at('grip'), look, () => shown, (to) => {
    look.at = to;
    const place = at('place');
    if (place) place.value = to;
    shown.relook();
  });
  stage.drawings.push(() => (shown?.marks?.() ?? []).flatMap(({ text, point, pane }) => {
    const [x, y] = stage.project(point, pane);
    return [mark('circle', { cx: x, cy: y, r: 6, class: 'mark' }), label(stage, x, y, text)];
  }));
}

async function show(view) {
  shown = view;
  pointer.clear();
  stage.owner = null;
  at('viewer').hidden = false;
  panel();
  await view.enter();
  at('loading').hidden = true;
  stage.fit(view.points());
  legend();
  complete = true;
}

/** Shows a view, and what it is to show, and brings it into sight. */
async function go(kind, then) {
  const view = views.find((v) => v instanceof kind);
  if (!view) return;
  if (shown !== view) await show(view);
  await then(view);
  at('viewer').scrollIntoView({ behavior: 'smooth', block: 'nearest' });
}

const ruler = button('ruler', () => measure(!pointer.measuring));
ruler.setAttribute('aria-pressed', false);

function measure(on) {
  pointer.measure(on);
  ruler.setAttribute('aria-pressed', on);
}

at('views').append(
  ...Object.keys(VIEWS).map((name) => button(name, () => stage.view(name, shown.points()))),
  button('all', () => stage.fit(shown.points())),
  ruler,
  button('save picture', async () => download(fileName(data.title, shown.title, 'picture.png'), await picture(stage, data.title, shown.legend()))),
);

function panel() {
  const tabs = views.map((view) => {
    const tab = button(view.title, () => show(view));
    tab.setAttribute('aria-pressed', view === shown);
    return tab;
  });
  const relook = (key) => (value) => {
    look[key] = value;
    shown.relook();
  };
  const place = slider('place', { min: 0, max: 1, step: 0.005, value: look.at }, relook('at'));
  place.input.id = 'place';
  const axis = select('across', [['none', 'nothing'], ['x', 'x'], ['y', 'y'], ['z', 'z']], look.axis, (name) => {
    look.axis = name;
    // what is nearer goes
    const toward = stage.camera.position.clone().sub(stage.controls.target);
    if (name !== 'none') look.sign = toward[name] >= 0 ? 1 : -1;
    shown.relook();
  });
  axis.list.id = 'cut';
  at('panel').replaceChildren(
    make('fieldset', { className: 'first' }, make('div', { className: 'row tabs' }, ...tabs)),
    ...shown.panel().filter(Boolean),
    fieldset('cut', axis, place, row(button('other side', () => relook('sign')(-look.sign)))),
    fieldset('outside',
      slider('opacity', { min: 0, max: 1, step: 0.05, value: look.opacity }, relook('opacity')),
      check('sides of facets', look.lines, relook('lines'))),
  );
}

/** What colours mean. */
function legend() {
  const { names, also, ...field } = shown.legend();
  const swatches = (names ?? []).map(([name, color]) => {
    const swatch = make('i');
    swatch.style.background = color;
    return make('div', {}, swatch, name);
  });
  at('legend').replaceChildren(...(names ? swatches : [scale(field)]), ...(also ? [scale(also)] : []));
}

/** A colour map with its numbers. */
function scale({ title, unit, range, ramp = RAMP }) {
  const colors = make('div', { className: 'ramp' });
  colors.style.setProperty('--ramp', ramp);
  const ticks = [4, 3, 2, 1, 0].map((i) => make('span', { textContent: digits(range[0] + (i / 4) * (range[1] - range[0])) }));
  return make('div', { className: 'scale' },
    make('div', { textContent: unit ? `${title} [${unit}]` : title }),
    make('div', { className: 'bar' }, colors, make('div', { className: 'ticks' }, ...ticks)));
}

const history = new History(at('history'), data.designs, (design, set) => go(Shapes, (view) => view.choose(view.designs.indexOf(design), set)));
/** Shows a step of a run, or rest, which comes before the first. */
const pick = (run, step) => go(Load, async (view) => {
  const state = run.states.findIndex((s) => s.step === step);
  await view.choose(data.runs.indexOf(run));
  if (state >= 0 || step < 0) view.to(state + 1);
  await view.refresh();
});
path(at('path'), data.runs, pick);
response(at('response'), data.runs, pick, fileName(data.title, 'curve.csv'));

at('viewer').addEventListener('keydown', (event) => {
  const by = { ',': -1, '.': 1 }[event.key];
  if (by && shown instanceof Load) shown.go(by);
  if (event.key === '0') stage.fit(shown.points());
  if (event.key === 'r' && event.target === stage.canvas) measure(!pointer.measuring);
  if (event.key === 'Escape' && pointer.measuring) measure(false);
});
at('panel').addEventListener('submit', (event) => event.preventDefault());

/** What the page shows, for tests. */
window.puffer = {
  state: () => ({ title: data.title, view: shown?.title ?? null, cut: look.axis, firstPicture, ruler: pointer?.distance() ?? null, ...shown?.state() }),
};

if (views.length > 0) await show(views[0]);
