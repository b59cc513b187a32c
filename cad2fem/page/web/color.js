// Colours, and numbers with units as people read them.

// Viridis at 0, 0.1, ..., 1 (the public-domain map of matplotlib) and the palette of `cad2fem picture`.
const VIRIDIS = ['#440154', '#482475', '#414487', '#355f8d', '#2a788e', '#21918c', '#22a884', '#44bf70', '#7ad151', '#bddf26', '#fde725'];
export const PALETTE = ['#5b8db8', '#e8a33d', '#6aa564', '#cf5f53', '#8fc1c9', '#9a76b3', '#d9cf6a', '#8a6a52', '#e7a6b4', '#7d8791'];
export const CAST = '#f3ead6';
export const UNTAGGED = '#c9ccd1';
/** Of the force in threads: white to dark red, which stand out from Viridis. */
const HEAT = ['#ffffff', '#ffd9a0', '#ff8a3d', '#d6336c', '#5c0a3a'];
/** Stops of both colour maps for a gradient. */
export const RAMP = VIRIDIS.join(', ');
export const HEAT_RAMP = HEAT.join(', ');

const linear = (v) => (v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);

/** Linear red, green and blue of #rrggbb. */
export function rgb(hex) {
  return [1, 3, 5].map((i) => linear(parseInt(hex.slice(i, i + 2), 16) / 255));
}

const MISSING = rgb('#8b8b8b');
const [TABLE, HEAT_TABLE] = [VIRIDIS, HEAT].map((stops) => Array.from({ length: 257 }, (_, i) => {
  const at = (i / 256) * (stops.length - 1);
  const k = Math.min(Math.floor(at), stops.length - 2);
  // between two entries as the gradient of the legend does it: in sRGB
  return [1, 3, 5].map((c) => {
    const [a, b] = [k, k + 1].map((j) => parseInt(stops[j].slice(c, c + 2), 16) / 255);
    return linear(a + (at - k) * (b - a));
  });
}));

function inTable(table, value, [low, high]) {
  if (!Number.isFinite(value)) return MISSING;
  const t = high > low ? (value - low) / (high - low) : 0;
  return table[Math.round(256 * Math.min(Math.max(t, 0), 1))];
}

/** Linear colour of a value in a range. */
export function viridis(value, range) {
  return inTable(TABLE, value, range);
}

/** The same for the force in a thread. */
export function heat(value, range) {
  return inTable(HEAT_TABLE, value, range);
}

const DAILY = { m: [1e3, 'mm'], m3: [1e6, 'mL'], 'm³': [1e6, 'mL'], Pa: [1e-3, 'kPa'], rad: [180 / Math.PI, '°'], 1: [1, ''] };

/** Factor and name of the unit in which people read numbers of this unit. */
export function daily(unit) {
  return DAILY[unit] ?? [1, unit ?? ''];
}

/** A number with four digits that count. */
export function digits(value) {
  if (value === 0) return '0';
  const order = Math.floor(Math.log10(Math.abs(value)));
  if (order < -4 || order >= 6) return value.toExponential(3);
  return value.toFixed(Math.max(0, Math.min(3 - order, 6)));
}
