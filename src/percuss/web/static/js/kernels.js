// The kernels of percuss as WebAssembly: numba's own code, in the page (docs/decisions/024-webassembly.md).

// Bytes between the begins of arrays.
const STEP = 16;
const PAGE = 65_536;

/** Return the kernels in the bytes of a file that `make wasm` has made. */
export async function loadKernels(bytes) {
  const module = await WebAssembly.compile(bytes);
  const [section] = WebAssembly.Module.customSections(module, "percuss");
  const about = JSON.parse(new TextDecoder().decode(section));
  const kernels = new Kernels(about);
  const instance = await WebAssembly.instantiate(module, { env: {
    fmod: (x, y) => x % y,
    numba_frexp: (x, at) => kernels.frexp(x, at),
  } });
  kernels.take(instance.exports);
  return kernels;
}

/** Kernels with the arrays that they work on. */
export class Kernels {
  constructor({ hash, columns, entries }) {
    this.hash = hash;
    /** Columns of arrays and values of states, by the names that they have in Python. */
    this.columns = columns;
    this.entries = new Map(Object.entries(entries).map(([name, [symbol, kinds]]) => [name, { symbol, kinds: kinds.split(" ") }]));
  }

  take(exports) {
    this.exports = exports;
    this.memory = exports.memory;
    this.base = Math.ceil(exports.__heap_base.value / STEP) * STEP;
    this.clear();
  }

  /** Forget all arrays. */
  clear() {
    this.top = this.base + 2 * STEP;
  }

  /** Return a new array of doubles, or of integers; its entries are anything. */
  floats(...shape) {
    return this.#array("F", shape);
  }

  integers(...shape) {
    return this.#array("I", shape);
  }

  /** Return an array as a typed one, valid until another is made. */
  view({ kind, at, size }) {
    return kind === "F" ? new Float64Array(this.memory.buffer, at, size) : new BigInt64Array(this.memory.buffer, at, size);
  }

  /** Return an array filled with zeros. */
  zeros(...shape) {
    const array = this.floats(...shape);
    this.view(array).fill(0);
    return array;
  }

  /** Return the first rows of an array. */
  rows(array, n) {
    const shape = [n, ...array.shape.slice(1)];
    return { ...array, shape, size: shape.reduce((a, b) => a * b, 1) };
  }

  /** Return a part of an array of one dimension, or of a row. */
  part(array, first, n) {
    return { ...array, at: array.at + 8 * first, shape: [n], size: n };
  }

  /** Call an entry; return its integer. */
  call(name, ...values) {
    const { symbol, kinds } = this.entries.get(name);
    const given = [this.base, this.base + STEP];
    kinds.forEach((kind, k) => {
      const value = values[k];
      if (kind === "f") given.push(value);
      else if (kind === "i") given.push(BigInt(value));
      else given.push(...described(value, kind));
    });
    this.exports[symbol](...given);
    return Number(new BigInt64Array(this.memory.buffer, this.base, 1)[0]);
  }

  /** Split a double into its mantissa in [1/2, 1) and its power of two, exactly. */
  frexp(x, at) {
    const view = new DataView(this.memory.buffer);
    if (x === 0 || !Number.isFinite(x)) {
      view.setInt32(at, 0, true);
      return x;
    }
    let power = Math.max(-1022, Math.floor(Math.log2(Math.abs(x))) + 1);
    let mantissa = (x / 2 ** (power >> 1)) / 2 ** (power - (power >> 1));
    for (; Math.abs(mantissa) >= 1; power += 1) mantissa /= 2;
    for (; Math.abs(mantissa) < 0.5; power -= 1) mantissa *= 2;
    view.setInt32(at, power, true);
    return mantissa;
  }

  #array(kind, shape) {
    const size = shape.reduce((a, b) => a * b, 1);
    const at = this.top;
    this.top = Math.ceil((at + 8 * size) / STEP) * STEP;
    const missing = this.top - this.memory.buffer.byteLength;
    if (missing > 0) this.memory.grow(Math.ceil(missing / PAGE) + 16);
    return { kind, at, shape, size };
  }
}

/** Return an array as numba hands it on: owner, parent, size, bytes an entry, address, shape and strides. */
function described({ kind, at, shape, size }, wanted) {
  if (kind !== wanted[0] || shape.length !== Number(wanted[1])) throw new TypeError(`an array ${kind}${shape.length} in place of ${wanted}`);
  const strides = [];
  let stride = 8;
  for (let k = shape.length - 1; k >= 0; k -= 1) {
    strides.unshift(BigInt(stride));
    stride *= shape[k];
  }
  return [0, 0, BigInt(size), 8n, at, ...shape.map(BigInt), ...strides];
}
