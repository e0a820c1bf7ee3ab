// Diagrams in workers on all cores, in growing resolution.

// As percuss.web.jobs has it: values of the first level, and how many times those of the next.
const [FIRST_VALUES, FINER] = [64, 4];
// Values that a worker computes between two messages.
const AT_ONCE = 8;

/** One diagram that is being computed. */
export class LocalDiagram {
  /** `workers`: kernels, each with answer(request); `handlers`: as of a request. */
  constructor(workers, request, handlers) {
    Object.assign(this, { workers, request, handlers, isCancelled: false, done: 0, failed: 0, reason: "" });
  }

  cancel() {
    this.isCancelled = true;
  }

  /** Compute all levels; return false where Python is needed. */
  async run() {
    const { low, high, points, path, values } = this.request;
    for (const level of levelsOf(values, FIRST_VALUES)) {
      const parts = await this.#level(level);
      if (this.isCancelled) return true;
      if (parts === null) return false;
      const names = Object.keys(parts[0].columns);
      const arrays = Object.fromEntries(names.map((name) => [name, joined(parts.map((part) => part.columns[name]))]));
      arrays.value = Float64Array.from(level, (k) => low + (k / (values - 1)) * (high - low));
      const share = this.done / values;
      const header = { kind: "diagram", path, low, high, n_points: points, failed: this.failed, reason: this.reason, share, done: this.done === values };
      this.handlers.answer(header, arrays);
    }
    return true;
  }

  /** Return the parts of a level in order, null where one needs Python. */
  async #level(level) {
    const pieces = [];
    for (let k = 0; k < level.length; k += AT_ONCE) pieces.push(level.slice(k, k + AT_ONCE));
    const parts = [];
    let next = 0;
    let isLocal = true;
    const serve = async (worker) => {
      while (next < pieces.length && isLocal && !this.isCancelled) {
        const k = next;
        next += 1;
        const part = await worker.answer({ kind: "part", of: this.request, numbers: pieces[k] });
        if (part === null) isLocal = false;
        else this.#take(parts, k, part, pieces[k].length);
      }
    };
    await Promise.all(this.workers.map(serve));
    return isLocal ? parts : null;
  }

  #take(parts, k, part, count) {
    parts[k] = part;
    this.done += count;
    this.failed += part.failed;
    this.reason ||= part.reason;
    if (!this.isCancelled) this.handlers.progress?.(this.done / this.request.values);
  }
}

/** Return the numbers of values in levels, each of which fills the gaps of those before. */
function levelsOf(n, first) {
  const steps = [1];
  while (n / steps[0] > first) steps.unshift(steps[0] * FINER);
  return steps.map((step, i) => Array.from({ length: Math.ceil(n / step) }, (_, k) => k * step).filter((k) => i === 0 || k % steps[i - 1] !== 0)).filter((level) => level.length > 0);
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
