// The page of a sweep. Texts of others come into the page as text only: textContent, or on a canvas.
"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const at = (id) => document.getElementById(id);
const column = (name) => data.columns.indexOf(name);
const value = (row, name) => data.rows[row][column(name)];
// A name may be that of anything that objects have by themselves.
const own = (of, name) => (Object.hasOwn(of, name) ? of[name] : "");
const withUnit = (name, unit) => (unit ? `${name} [${unit}]` : name);
const title = (name) => withUnit(name, own(data.units, name));
const curveTitle = (name) => withUnit(name, own(data.curve_units, name));
const failed = (row) => value(row, "status") === "failed";
const all = data.rows.map((_, row) => row);
const MOST = { lines: 300, rows: 200, axes: 5 };
const RED = "#d3443b";
const short = (v) => (typeof v === "number" ? String(Number(v.toPrecision(4))) : v === null ? "" : String(v));

// Columns that differ between cases.
const varied = data.columns.filter((name) => {
  const seen = new Set(data.rows.map((row) => row[column(name)]).filter((v) => v !== null));
  return seen.size > 1;
});
const isParameter = (name) => data.parameters.some((p) => p.name === name);
const isText = (name) => data.rows.some((row) => typeof row[column(name)] === "string" || typeof row[column(name)] === "boolean");
const OWN = ["case", "status", "failure", "folder"];
const parameters = varied.filter((n) => isParameter(n));
const results = varied.filter((n) => !isParameter(n) && !OWN.includes(n) && !isText(n));
const first = [...results.filter((n) => /^(probes|objective|terms)/.test(n)), ...results.filter((n) => /volume$|^stretch/.test(n))];
const shown = new Set([...parameters, ...first.slice(0, MOST.axes)]);

function element(name, text, parent) {
  const made = document.createElement(name);
  if (text !== undefined) made.textContent = text;
  if (parent) parent.append(made);
  return made;
}
function choices(select, names, chosen, titled = title) {
  for (const name of names) element("option", titled(name), select).value = name;
  if (names.includes(chosen)) select.value = chosen;
}

// Viridis at five places, as in the pictures.
const RAMP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
function ramp(t) {
  const x = Math.min(Math.max(t, 0), 1) * (RAMP.length - 1), i = Math.min(Math.floor(x), RAMP.length - 2);
  return `rgb(${RAMP[i].map((c, k) => Math.round(c + (x - i) * (RAMP[i + 1][k] - c)))})`;
}
function colors() {
  const name = at("color").value;
  const values = all.map((row) => value(row, name));
  if (isText(name)) {
    const kinds = [...new Set(values)].sort();
    return values.map((v, row) => (failed(row) ? RED : ramp(kinds.indexOf(v) / Math.max(kinds.length - 1, 1))));
  }
  const numbers = values.filter((v) => v !== null);
  const low = numbers.reduce((a, b) => Math.min(a, b), Infinity), high = numbers.reduce((a, b) => Math.max(a, b), -Infinity);
  return values.map((v, row) => (failed(row) || v === null ? RED : ramp(high > low ? (v - low) / (high - low) : 0.5)));
}

const parallel = echarts.init(at("parallel"), null, { renderer: "canvas" });
// hidden, it has no size to draw in
at("curves").hidden = !data.curves.length;
const lines = data.curves.length ? echarts.init(at("lines"), null, { renderer: "canvas" }) : null;
let chosen = all;

function drawParallel() {
  const names = varied.filter((n) => shown.has(n)), color = colors();
  const axis = (name, dim) => ({
    dim, name: title(name), nameTextStyle: { fontSize: 12, color: "#1c2430" },
    ...(isText(name) ? { type: "category", data: [...new Set(all.map((r) => short(value(r, name))))].sort() }
      : { type: "value", scale: true, axisLabel: { formatter: short } }),
  });
  const line = (row) => ({
    value: names.map((n) => (value(row, n) === null ? "-" : isText(n) ? short(value(row, n)) : value(row, n))),
    lineStyle: { color: color[row] },
  });
  parallel.setOption({
    animation: false,
    parallel: { left: 60, right: 80, top: 40, bottom: 24,
      parallelAxisDefault: { areaSelectStyle: { width: 16 }, nameGap: 14 } },
    parallelAxis: names.map(axis),
    series: [{ type: "parallel", lineStyle: { width: 1.3, opacity: all.length > 1000 ? 0.25 : 0.65 }, inactiveOpacity: 0.04,
      activeOpacity: 0.9, progressive: 1000, data: all.map(line) }],
  }, true);
  choose(all);
}

function choose(rows) {
  chosen = rows;
  const bad = rows.filter(failed).length;
  at("count").textContent = `${all.length} cases, ${all.filter(failed).length} failed`
    + (rows.length < all.length ? `; ${rows.length} chosen, ${bad} of them failed` : "");
  drawCurves();
  drawPictures();
  drawTable();
}

function drawCurves() {
  if (!lines) return;
  const [x, y, color] = [at("x").value, at("y").value, colors()];
  const inside = new Set(chosen);
  const there = data.curves.filter(([row, c]) => inside.has(row) && c[x] && c[y]);
  const step = Math.max(1, Math.ceil(there.length / MOST.lines));
  const drawn = there.filter((_, i) => i % step === 0);
  at("drawn").textContent = drawn.length < chosen.length ? `${drawn.length} of ${chosen.length} chosen cases` : "";
  const axis = (name, gap) => ({ type: "value", scale: true, name, nameLocation: "middle", nameGap: gap, axisLabel: { formatter: short } });
  lines.setOption({
    animation: false,
    grid: { left: 80, right: 30, top: 20, bottom: 50 },
    tooltip: { renderMode: "richText", formatter: (p) => `case ${p.seriesName}\n${short(p.value[0])}, ${short(p.value[1])}` },
    xAxis: axis(curveTitle(x), 30), yAxis: axis(curveTitle(y), 60),
    series: drawn.map(([row, c]) => ({
      type: "line", name: String(value(row, "case")), data: c[x].map((v, i) => [v, c[y][i]]),
      symbolSize: 4, lineStyle: { color: color[row], width: 1.2 }, itemStyle: { color: color[row] },
    })),
  }, true);
}

function drawPictures() {
  const color = colors(), inside = new Set(chosen), grid = at("grid");
  grid.replaceChildren();
  for (const [row, picture] of data.pictures) {
    if (!inside.has(row)) continue;
    const figure = element("figure", undefined, grid), image = element("img", undefined, figure);
    figure.style.borderTopColor = color[row];
    image.loading = "lazy";
    image.src = `data:image/png;base64,${picture}`;
    const text = parameters.map((n) => `${n} ${short(value(row, n))} ${own(data.units, n)}`.trim()).join(", ");
    image.alt = `case ${value(row, "case")}: ${text}`;
    element("figcaption", image.alt, figure);
  }
  at("some").textContent = data.pictures.length < data.pictures_of
    ? `${data.pictures.length} of ${data.pictures_of} pictures, so that the page stays small; the others are in the folders of their cases` : "";
}

function fill(table, names, rows) {
  table.replaceChildren();
  const head = element("tr", undefined, element("thead", undefined, table)), body = element("tbody", undefined, table);
  names.forEach((n) => { element("th", title(n), head).scope = "col"; });
  for (const row of rows) {
    const line = element("tr", undefined, body);
    line.className = failed(row) ? "bad" : "";
    names.forEach((n) => element("td", short(value(row, n)), line));
  }
}
function drawTable() {
  fill(at("table"), ["case", ...varied.filter((n) => n !== "case" && n !== "failure")], chosen.slice(0, MOST.rows));
  at("rows").textContent = chosen.length > MOST.rows ? `The first ${MOST.rows} of ${chosen.length} chosen cases.` : "";
}

choices(at("color"), varied.filter((n) => shown.has(n) || results.includes(n)), first[0] ?? parameters[0]);
for (const name of [...parameters, ...results]) {
  const label = element("label", undefined, at("axes")), box = element("input", undefined, label);
  box.type = "checkbox";
  box.checked = shown.has(name);
  label.append(` ${title(name)}`);
  box.addEventListener("change", () => { box.checked ? shown.add(name) : shown.delete(name); drawParallel(); });
}
if (lines) {
  const names = [...new Set(data.curves.flatMap(([, c]) => Object.keys(c)))].sort();
  const find = (...patterns) => patterns.map((p) => names.find((n) => p.test(n))).find((n) => n);
  choices(at("x"), names, find(/pressure$/, /^t$/, /^iteration$/, /^load$/), curveTitle);
  choices(at("y"), names, find(/^probes/, /^objective$/, /volume$/), curveTitle);
}
at("pictures").hidden = !data.pictures.length;
const bad = all.filter(failed);
at("failures").hidden = !bad.length;
fill(at("failures").querySelector("table"), ["case", ...parameters, "failure", "folder"], bad.slice(0, MOST.rows));

parallel.on("axisareaselected", () => {
  const series = parallel.getModel().getSeriesByIndex(0);
  const active = series.getRawIndicesByActiveState("active");
  const free = series.getRawIndicesByActiveState("normal");
  choose(active.length || !free.length ? active : all);
});
at("color").addEventListener("change", drawParallel);
for (const id of ["x", "y"]) at(id).addEventListener("change", drawCurves);
addEventListener("resize", () => { parallel.resize(); lines?.resize(); });
drawParallel();
