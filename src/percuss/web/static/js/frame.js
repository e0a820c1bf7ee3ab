// Answers of the server: a header in JSON and arrays of single precision after it.

const text = new TextDecoder();

/** Return {header, arrays} of an answer: see percuss.web.frame. */
export function decode(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const header = JSON.parse(text.decode(new Uint8Array(buffer, 4, size)));
  const arrays = {};
  let at = 4 + size;
  for (const [name, length] of header.arrays) {
    const column = new Float32Array(buffer, at, length);
    // Values of a parameter are offsets from the middle of their range.
    const isFrom = header.origin !== undefined && name.startsWith("value");
    arrays[name] = isFrom ? Float64Array.from(column, (value) => value + header.origin) : column;
    at += 4 * length;
  }
  return { header, arrays };
}
