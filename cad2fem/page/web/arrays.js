// Arrays of numbers that the page holds as compressed text, see store.rs.

const TYPES = { u8: Uint8Array, u16: Uint16Array, u32: Uint32Array };
const MISSING = 65535;
const unpacked = new Map();

async function bytes(blob) {
  const text = document.getElementById(`blob-${blob}`).textContent;
  const characters = atob(text);
  const packed = new Uint8Array(characters.length);
  for (let i = 0; i < packed.length; i++) packed[i] = characters.charCodeAt(i);
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('deflate'));
  return new Response(stream).arrayBuffer();
}

async function unpack({ blob, type, components, low, step }) {
  const integers = new TYPES[type](await bytes(blob));
  if (!low) return integers;
  const values = new Float32Array(integers.length);
  for (let i = 0; i < values.length; i++) {
    const c = i % components;
    values[i] = integers[i] === MISSING ? NaN : low[c] + step[c] * integers[i];
  }
  return values;
}

/** The numbers of an array: indices as they are, others as 32-bit numbers. */
export function numbers(packed) {
  if (!unpacked.has(packed.blob)) unpacked.set(packed.blob, unpack(packed));
  return unpacked.get(packed.blob);
}
