// Diagrams and basins in workers on all cores, in growing resolution.

import { centreOf } from "./exact.js";

// As percuss.web.jobs has it: values of the first level, and how many times those of the next.
const [FIRST_VALUES, FINER] = [64, 4];
// Starts along a side of the first level of basins at most.
const FIRST_STARTS = 64;
// Values, and starts, that a worker computes between two messages.
const [AT_ONCE, STARTS_AT_ONCE, CELLS_AT_ONCE] = [8, 512, 16];

/** A long answer of `total` values that is being computed, in pieces by whichever worker is free. */
class LocalJob {
  /** `workers`: kernels, each with answer(request); `handlers`: as of a request. */
  constructor(workers, request, handlers) {
    Object.assign(this, { workers, request, handlers, isCancelled: false, done: 0, keeper: null, failed: 0, reason: "" });
  }

  cancel() {
    this.isCancelled = true;
  }

  /** How far it is, as headers say it. */
  get state() {
    return { share: this.done / this.total, done: this.done === this.total };
  }

  /** Return the columns for numbers in order, so many at once; null where one needs Python. */
  async inParts(kind, numbers, most) {
    const pieces = piecesOf(numbers, most);
    const parts = await this.inPieces(pieces.map((piece) => ({ kind, numbers: piece })), pieces.map((it) => it.length));
    if (parts === null || this.isCancelled) return null;
    return Object.fromEntries(Object.keys(parts[0].columns).map((name) => [name, joined(parts.map((part) => part.columns[name]))]));
  }

  /** Return the answers to requests of so many values each in order, null where one needs Python. */
  async inPieces(requests, counts) {
    const parts = [];
    let next = 0;
    let isLocal = true;
    const serve = async (worker) => {
      while (next < requests.length && isLocal && !this.isCancelled) {
        const k = next;
        next += 1;
        const part = await worker.answer({ of: this.request, ...requests[k] });
        if (part === null) {
          isLocal = false;
          return;
        }
        parts[k] = part;
        this.done += counts[k];
        this.failed += part.failed ?? 0;
        this.reason ||= part.reason;
        if (!this.isCancelled) this.handlers.progress?.(this.state.share);
      }
    };
    // One piece waits at each worker while it works on another.
    await Promise.all([...this.workers, ...this.workers].map(serve));
    return isLocal ? parts : null;
  }
}

/** One diagram. */
export class LocalDiagram extends LocalJob {
  get total() {
    return this.request.values;
  }

  /** Compute all levels; return false where Python is needed. */
  async run() {
    const { low, high, points, path, values } = this.request;
    for (const level of levelsOf(values, FIRST_VALUES)) {
      const arrays = await this.inParts("part", level, AT_ONCE);
      if (arrays === null) return this.isCancelled;
      arrays.value = Float64Array.from(level, (k) => low + (k / (values - 1)) * (high - low));
      const header = { kind: "diagram", path, low, high, n_points: points, failed: this.failed, reason: this.reason, ...this.state };
      this.handlers.answer(header, arrays);
    }
    return true;
  }
}

/** A chart of two parameters: a square of cells, whose coarser levels are some of them. */
export class LocalChart extends LocalJob {
  values = new Map();

  get total() {
    return this.request.size ** 2;
  }

  /** Compute all levels; return false where Python is needed. */
  async run() {
    const { study: _, ...about } = this.request;
    for (const places of placesOf(about.size)) {
      const cells = cellsOf(places, about.size);
      const asked = cells.filter((cell) => !this.values.has(cell));
      const found = await this.inParts("cells", asked, CELLS_AT_ONCE);
      if (found === null) return this.isCancelled;
      asked.forEach((cell, k) => this.values.set(cell, found.value[k]));
      const header = { ...about, size: places.length, ...this.state };
      this.handlers.answer(header, { value: Float64Array.from(cells, (cell) => this.values.get(cell)) });
    }
    return true;
  }
}

/** The basins of a square of starts, whose coarser levels are some of its cells. */
export class LocalBasins extends LocalJob {
  constructor(workers, request, handlers) {
    super(workers, request, handlers);
    const size = request.starts;
    const { x_low, x_high, v_low, v_high } = request;
    this.axes = [centresOf(x_low, x_high, size), centresOf(v_low, v_high, size)];
    this.known = new Uint8Array(size * size);
    // So many numbers for each start, once the first ones are known.
    this.classes = null;
  }

  get total() {
    return this.known.length;
  }

  /** Compute all levels; return false where Python is needed. */
  async run() {
    const { starts: size, x_low, x_high, v_low, v_high } = this.request;
    if (this.axes.includes(null)) return false;
    for (const places of placesOf(size)) {
      const cells = cellsOf(places, size);
      const isLocal = await this.#classify(cells.filter((cell) => this.known[cell] === 0));
      if (this.isCancelled) return true;
      if (!isLocal) return false;
      // This takes long where motions are chaotic: whoever cancels ends the worker.
      [this.keeper] = this.workers;
      const found = await this.keeper.answer({ kind: "basins", of: this.request, classes: this.#classesOf(cells) });
      this.keeper = null;
      if (this.isCancelled) return true;
      if (found === null) return false;
      const header = { kind: "basins", x_low, x_high, v_low, v_high, size: places.length, attractors: found.attractors, ...this.state };
      this.handlers.answer(header, found.arrays);
    }
    return true;
  }

  /** Find the classes of the starts of cells; return false where Python is needed. */
  async #classify(cells) {
    const [x, v] = this.axes;
    const pieces = piecesOf(cells, STARTS_AT_ONCE);
    const startsOf = (piece) => Float64Array.from(piece.flatMap((cell) => [x[Math.floor(cell / x.length)], v[cell % v.length]]));
    const parts = await this.inPieces(pieces.map((piece) => ({ kind: "classes", starts: startsOf(piece) })), pieces.map((it) => it.length));
    if (parts === null || this.isCancelled) return parts !== null;
    parts.forEach(({ arrays: { classes } }, k) => {
      const entries = classes.length / pieces[k].length;
      this.classes ??= new Float64Array(entries * this.total);
      pieces[k].forEach((cell, i) => {
        this.known[cell] = 1;
        this.classes.set(classes.subarray(i * entries, (i + 1) * entries), cell * entries);
      });
    });
    return true;
  }

  #classesOf(cells) {
    if (cells.length === this.total) return this.classes;
    const entries = this.classes.length / this.total;
    return joined(cells.map((cell) => this.classes.subarray(cell * entries, (cell + 1) * entries)));
  }
}

/** Return the centres of n cells between two ends as doubles, each rounded once; null where one is too small. */
function centresOf(low, high, n) {
  const values = Array.from({ length: n }, (_, k) => {
    const value = centreOf(low, high, k, n);
    return typeof value === "number" ? value : value.parts?.[0];
  });
  return values.includes(undefined) ? null : values;
}

/** Return the places along a side at each level: one of so many in the middle, and all in the end. */
function placesOf(size) {
  const steps = [1];
  while (size / steps[0] > FIRST_STARTS) steps.unshift(steps[0] * FINER);
  return steps.map((step) => Array.from({ length: Math.ceil(size / step) }, (_, k) => Math.min(k * step + (step >> 1), size - 1)));
}

const cellsOf = (places, size) => places.flatMap((i) => places.map((j) => i * size + j));

/** Return the numbers of values in levels, each of which fills the gaps of those before. */
function levelsOf(n, first) {
  const steps = [1];
  while (n / steps[0] > first) steps.unshift(steps[0] * FINER);
  return steps.map((step, i) => Array.from({ length: Math.ceil(n / step) }, (_, k) => k * step).filter((k) => i === 0 || k % steps[i - 1] !== 0)).filter((level) => level.length > 0);
}

function piecesOf(values, most) {
  const pieces = [];
  for (let k = 0; k < values.length; k += most) pieces.push(values.slice(k, k + most));
  return pieces;
}

function joined(columns) {
  const whole = new Float64Array(columns.reduce((n, column) => n + column.length, 0));
  let at = 0;
  for (const column of columns) {
    whole.set(column, at);
    at += column.length;
  }
  return whole;
}
