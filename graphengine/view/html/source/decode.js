// Unpacks the data of the page: the counterpart of payload.py.

const TYPES = { Float32Array, Float64Array, Uint8Array, Uint16Array, Uint32Array };

// Returns the values of the page with their arrays.
export async function decode(text) {
  const packed = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  const end = 4 + new DataView(bytes.buffer).getUint32(0, true);
  const parts = bytes.subarray(end);
  const revive = (_, value) => (value?.array ? numbers(parts, value) : value);
  return JSON.parse(new TextDecoder().decode(bytes.subarray(4, end)), revive);
}

// Returns an array whose numbers were split into planes of their first bytes, second bytes and so on.
function numbers(parts, { array, at, count, steps }) {
  const made = new TYPES[array](count);
  const bytes = new Uint8Array(made.buffer);
  const size = made.BYTES_PER_ELEMENT;
  for (let place = 0; place < size; place++) {
    for (let index = 0; index < count; index++) bytes[index * size + place] = parts[at + place * count + index];
  }
  if (steps) {
    const patterns = new Uint32Array(made.buffer);
    for (let index = 1; index < count; index++) patterns[index] += patterns[index - 1];
  }
  return made;
}

// Returns the index of the last of some ascending times that is not after `time`, or -1.
export function lastBefore(times, time) {
  let low = 0;
  let high = times.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle + 1;
    else high = middle;
  }
  return low - 1;
}
