// tags.toml from what was chosen, and what is still to be done.

import { NONE } from 'pick/tags';

/** A text of TOML. */
export function quoted(text) {
  return JSON.stringify(text).replace(/\x7f/g, '\\u007f');
}

const AXES = ['x', 'y', 'z'];

/** The axis that a face looks along, or its normal. */
export function facing(normal) {
  if (!normal) return '';
  const axis = normal.findIndex((n) => Math.abs(n) > 0.9999);
  if (axis >= 0) return `facing ${normal[axis] > 0 ? '+' : '−'}${AXES[axis]}`;
  return `facing ${normal.map((n) => n.toFixed(2).replace('-', '−')).join(', ')}`;
}

/** An area [mm²] as people read it. */
export function areaText(area) {
  return area < 100 ? `${area.toPrecision(3)} mm²` : `${(area / 100).toPrecision(3)} cm²`;
}

export function count(number, what) {
  return `${number} ${what}${number === 1 ? '' : 's'}`;
}

/** A name as a comment shows it, on one line. */
const plain = (name) => quoted(name).slice(1, -1);

/** A list of texts, in lines that are not too long. */
function list(texts) {
  if (texts.length === 1) return texts[0];
  const lines = [''];
  for (const text of texts) {
    if (lines[lines.length - 1].length + text.length > 88) lines.push('');
    lines[lines.length - 1] += `${text}, `;
  }
  if (lines.length === 1) return `[${lines[0].slice(0, -2)}]`;
  return `[\n${lines.map((line) => `    ${line.trimEnd()}\n`).join('')}]`;
}

/** What a person should know or do before the file is used; `faces` are those that it is about. */
export function remarks(tags) {
  const found = [];
  const names = tags.list.map((tag) => tag.name.trim());
  tags.list.forEach((tag, i) => {
    if (names[i] === '') found.push({ tag: i, text: `Tag ${i + 1} has no name.`, bad: true });
    else if (names.indexOf(names[i]) < i) found.push({ tag: i, text: `Two tags are called ${names[i]}.`, bad: true });
    if (!tag.kept && tags.facesOf(i).length === 0) found.push({ tag: i, text: `${names[i] || `Tag ${i + 1}`} has no face yet: click one.`, bad: true });
    if (!tag.chamber || tag.plug || tag.kept) return;
    const { bare } = tags.around(i);
    if (bare.length > 0 && tags.rim(i).length === tags.around(i).tags.length) {
      found.push({ tag: i, faces: bare, text: `${names[i]} is open, and ${count(bare.length, 'face')} at its opening ${bare.length === 1 ? 'has' : 'have'} no tag. Give the face that is held there a tag.` });
    }
  });
  return found;
}

function about(tags, tag) {
  const faces = tags.facesOf(tag);
  const [first] = faces;
  const only = faces.length === 1 ? tags.faces[first] : null;
  const parts = [count(faces.length, 'face'), areaText(tags.area(tag)), only && only.kind, only && facing(only.normal)];
  return parts.filter(Boolean).join(', ');
}

function table(tags, tag) {
  const { name, chamber, plug, kept } = tags.list[tag];
  if (kept) return kept;
  const faces = tags.facesOf(tag);
  const files = faces.map((face) => quoted(tags.faces[face].file));
  const rim = tags.rim(tag).map(quoted);
  const lines = [`# ${about(tags, tag)}`];
  if (chamber) lines[0] += rim.length > 0 ? ': the wall of a chamber with an opening' : ': the wall of a closed chamber';
  lines.push('[[tag]]', `name = ${quoted(name.trim())}`, `patch = ${list(files)}`);
  if (tags.faces[faces[0]].inside) lines.push('inside = true             # a sheet in the body');
  if (chamber) {
    lines.push('pressure = true           # air is let in here');
    if (plug) lines.push('plug = true               # plugs close it, which move with the body');
    else if (rim.length > 0) lines.push(`rim = ${list(rim)}    # what holds its opening`);
  }
  return `${lines.join('\n')}\n`;
}

/** All faces as they are: where they have other numbers in a changed body, tagger finds them by what they measure. */
function measured(tags) {
  const numbers = (list) => `[${list.map((x) => Number(x.toPrecision(5))).join(', ')}]`;
  const one = ({ file, area, middle, facing }, i) => {
    const beside = tags.beside[i].map(([other]) => tags.faces[other].file).filter(Boolean).map(quoted);
    const parts = [
      `area = ${Number((1e-6 * area).toPrecision(5))}`,
      `middle = ${numbers(middle.map((x) => 1e-3 * Number(x.toFixed(5))))}`,
      `normal = ${numbers(facing.map((x) => Number(x.toFixed(5))))}`,
      `beside = [${beside.join(', ')}]`,
    ];
    return file ? `${quoted(file)} = { ${parts.join(', ')} }\n` : '';
  };
  return tags.faces.map(one).join('');
}

/** The file. */
export function written(tags, data) {
  const used = tags.list.map((_, i) => i).filter((i) => tags.list[i].kept || tags.facesOf(i).length > 0);
  const { head, tail } = data.given ?? { head: '', tail: '' };
  const left = tags.facesOf(NONE).filter((face) => !tags.faces[face].inside).length;
  return `# Parts of the boundary of ${plain(data.title)}, chosen on the page of cad2fem pick.
# A facet of the mesh belongs to the first tag here that has it:
#
#   tagger tag volume.msh --config tags.toml --patches ${plain(data.folder)}/patches -o tagged.msh

${head && `${head}
`}# The whole surface, so that no tag grows beyond its faces${left > 0 ? `: ${count(left, 'face')} ${left === 1 ? 'has' : 'have'} no tag` : ''}.
surface = "../model.stl"
${data.split ? `
# Faces end at edges sharper than this [deg]: make imports ${plain(data.title)} with it.
split = ${data.split}
` : ''}${used.map((tag) => `\n${table(tags, tag)}`).join('')}${tail}
# All faces as they were when these were chosen, for tagger to find them in a changed body.
[faces]
${measured(tags)}`;
}
