// Downloads: the picture that is shown with its legend, and tables of numbers.

import { RAMP, digits } from 'page/color';
import { make } from 'page/controls';

/** Gives the reader a file. */
export function download(name, blob) {
  const link = make('a', { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** A name of a file of letters, digits and strokes. */
export function fileName(...words) {
  return words.join('-').replaceAll(/[^\p{L}\p{N}.-]+/gu, '-').replaceAll(/^[-.]+|-+$/g, '') || 'results';
}

/** Rows as a table with commas. Text is never a formula of a spreadsheet. */
export function csv(rows) {
  const cell = (value) => {
    if (typeof value === 'number') return Number.isFinite(value) ? String(value) : '';
    const text = String(value).replace(/^(?=[=+\-@\t\r])/, ' ');
    return /[",\n\r]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
  };
  return new Blob([rows.map((row) => `${row.map(cell).join(',')}\r\n`).join('')], { type: 'text/csv' });
}

/** Room for the legend beside what is shown [px]. */
const KEY = 128;

/** What the stage shows, on white, with title and legend: a promise of a PNG file. */
export function picture(stage, title, legend) {
  stage.draw();
  const source = stage.canvas;
  const scale = source.width / source.clientWidth;
  const [shown, height] = [source.clientWidth, source.clientHeight];
  const width = shown + KEY;
  const made = make('canvas', { width: Math.round(scale * width), height: source.height });
  const pen = made.getContext('2d');
  pen.scale(scale, scale);
  pen.fillStyle = '#ffffff';
  pen.fillRect(0, 0, width, height);
  pen.drawImage(source, 0, 0, shown, height);
  pen.fillStyle = '#1c2430';
  pen.textBaseline = 'middle';
  pen.font = '600 16px system-ui, sans-serif';
  pen.fillText(title, 14, 20, 0.55 * width);
  pen.font = '600 12px system-ui, sans-serif';
  const { at } = stage.layout();
  stage.panes.forEach(({ name }, i) => name && pen.fillText(name, at(i)[0] + 14, at(i)[1] + 42));
  pen.font = '12px system-ui, sans-serif';
  if (legend.names) swatches(pen, legend.names, width);
  else ramp(pen, legend, width, 40);
  if (legend.also) ramp(pen, legend.also, width, legend.names ? 60 + 18 * legend.names.length : 220);
  bar(pen, stage, height);
  return new Promise((resolve) => {
    made.toBlob(resolve, 'image/png');
  });
}

function swatches(pen, names, width) {
  const wide = Math.max(0, ...names.map(([name]) => pen.measureText(name).width));
  names.forEach(([name, color], i) => {
    pen.fillStyle = color;
    pen.fillRect(width - wide - 34, 14 + 18 * i, 12, 12);
    pen.fillStyle = '#1c2430';
    pen.fillText(name, width - wide - 16, 20 + 18 * i);
  });
}

function ramp(pen, { title, unit, range, ramp: map = RAMP }, width, y) {
  const [x, length] = [width - 96, 130];
  const heading = unit ? `${title} [${unit}]` : title;
  pen.fillText(heading, width - 12 - Math.max(pen.measureText(heading).width, 84), y - 20);
  const colors = pen.createLinearGradient(0, y + length, 0, y);
  const stops = map.split(', ');
  stops.forEach((color, i) => colors.addColorStop(i / (stops.length - 1), color));
  pen.fillStyle = colors;
  pen.fillRect(x, y, 16, length);
  pen.fillStyle = '#1c2430';
  for (let i = 0; i <= 4; i++) pen.fillText(digits(range[0] + (i / 4) * (range[1] - range[0])), x + 22, y + length * (1 - i / 4));
}

/** The scale bar of the stage. */
function bar(pen, stage, height) {
  const { length, text } = stage.scale;
  pen.strokeStyle = '#1c2430';
  pen.lineWidth = 1.5;
  pen.beginPath();
  pen.moveTo(16, height - 28);
  pen.lineTo(16, height - 22);
  pen.lineTo(16 + length, height - 22);
  pen.lineTo(16 + length, height - 28);
  pen.stroke();
  pen.fillText(text, 16, height - 11);
}
