// Requests that the kernels in the page answer; the rest goes to the server, where there is one.

import { LocalBasins, LocalChart, LocalDiagram } from "./local_jobs.js";

// Requests of these kinds are motions.
const MOTIONS = new Set(["explore", "thumb", "beside"]);
// What the kernels do not tell is asked of the server once a slider has rested so long [ms].
const RESTED = 250;

/** Kernels in a worker, a promise of the file's bytes given; `keep(kernels)` is called when idle ones are closed, which else end. */
export class KernelsInWorker {
  constructor(worker, bytes, keep = null) {
    this.worker = worker;
    this.keep = keep;
    this.waiting = new Map();
    this.lastId = 0;
    this.isLost = false;
    worker.onmessage = ({ data: { id, answer } }) => {
      this.waiting.get(id)?.(answer);
      this.waiting.delete(id);
    };
    worker.onerror = () => this.#lose();
    bytes.then((it) => worker.postMessage({ bytes: it }), () => this.#lose());
    this.ready = bytes;
  }

  /** Return a promise of {header, arrays}; of null where only Python has an answer. */
  async answer(request) {
    await this.ready.catch(() => {});
    if (this.isLost) return null;
    const id = (this.lastId += 1);
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.worker.postMessage({ id, request });
    });
  }

  /** End the worker, or keep one that is idle; what waits for it has no answer. */
  close() {
    if (this.keep !== null && this.waiting.size === 0 && !this.isLost) {
      this.keep(this);
      return;
    }
    this.worker.terminate();
    this.#lose();
  }

  #lose() {
    this.isLost = true;
    for (const resolve of this.waiting.values()) resolve(null);
    this.waiting.clear();
  }
}

/** Return whether a diagram is of a size that needs no sentence of the server. */
function isModerate({ low, high, values, points, follow }) {
  // A motion that is followed from value to value is the server's.
  return follow === undefined && low < high && Number.isInteger(values) && Number.isInteger(points) && values >= 2 && points >= 2 && values <= 8192 && values * points <= 2_000_000;
}

/** Return whether basins are of a size that needs no sentence of the server. */
function isSquare({ x_low, x_high, v_low, v_high, starts }) {
  return x_low < x_high && v_low < v_high && [x_low, x_high, v_low, v_high].every(Number.isFinite) && Number.isInteger(starts) && starts >= 16 && starts <= 1024;
}

// What is computed in workers on all cores, and whether a request is for them.
const JOBS = { diagram: [LocalDiagram, isModerate], basins: [LocalBasins, isSquare], sweep: [LocalChart, ({ size }) => size >= 16 && size <= 256] };

/** Requests as of transport.js: motions are computed here, with one in each queue and one that waits. */
export class LocalRequests {
  /**
   * `begin()` returns kernels in a worker of their own; `server`: the requests over a socket, or null;
   * `refuse(message)`: the sentence where it is null.
   */
  constructor(begin, server, refuse) {
    this.begin = begin;
    this.kernels = begin();
    this.pool = null;
    this.job = null;
    this.server = server;
    this.refuse = refuse;
    this.queues = new Map();
  }

  put(queue, message, handlers) {
    // Facts hold the nearest orbit, too, where a server tells it.
    if (!MOTIONS.has(message.kind) && (message.kind !== "facts" || this.server !== null)) {
      this.#elsewhere(queue, message, handlers);
      return;
    }
    const at = this.queues.get(queue) ?? { isBusy: false, waiting: null, count: 0 };
    this.queues.set(queue, at);
    at.count += 1;
    clearTimeout(at.resting);
    if (at.isBusy) at.waiting = { message, handlers };
    else this.#compute(queue, at, message, handlers);
  }

  replace(queue, message, handlers) {
    if (queue === "job") this.#cancelJob();
    const [Job, isLocal] = JOBS[message.kind] ?? [];
    if (isLocal?.(message)) {
      this.server?.cancel(queue);
      this.#work(Job, queue, message, handlers);
      return;
    }
    this.#replaceElsewhere(queue, message, handlers);
  }

  async #work(Job, queue, message, handlers) {
    // One for each core, made when the first job is asked for.
    this.pool ??= Array.from({ length: Math.max(1, navigator.hardwareConcurrency ?? 1) }, () => this.begin());
    const job = new Job(this.pool, message, handlers);
    this.job = job;
    const isAnswered = await job.run();
    if (!isAnswered && this.job === job && !job.isCancelled) this.#replaceElsewhere(queue, message, handlers);
  }

  #replaceElsewhere(queue, message, handlers) {
    if (this.server !== null) this.server.replace(queue, message, handlers);
    else this.#elsewhere(queue, message, handlers);
  }

  #cancelJob() {
    const { keeper = null } = this.job ?? {};
    this.job?.cancel();
    if (keeper === null) return;
    // A worker hears nothing before its answer is there.
    keeper.close();
    this.pool[this.pool.indexOf(keeper)] = this.begin();
    this.job.keeper = null;
  }

  cancel(queue) {
    if (queue === "job") this.#cancelJob();
    this.server?.cancel(queue);
  }

  /** End the workers and the connection. */
  close() {
    for (const at of this.queues.values()) {
      clearTimeout(at.resting);
      // No answer is the newest.
      Object.assign(at, { waiting: null, count: at.count + 1 });
    }
    this.job?.cancel();
    for (const kernels of [this.kernels, ...(this.pool ?? [])]) kernels.close();
    this.server?.close();
  }

  async #compute(queue, at, message, handlers) {
    at.isBusy = true;
    const { count } = at;
    const answer = await this.kernels.answer(message);
    at.isBusy = false;
    if (answer !== null) handlers.answer(answer.header, answer.arrays);
    if (at.waiting !== null) {
      const next = at.waiting;
      at.waiting = null;
      this.#compute(queue, at, next.message, next.handlers);
      return;
    }
    if (count !== at.count) return;
    if (answer === null) this.#elsewhere(queue, message, this.#whileNewest(at, count, handlers));
    else if (queue === "explore" && this.server !== null) {
      at.resting = setTimeout(() => this.#elsewhere(queue, message, this.#whileNewest(at, count, handlers)), RESTED);
    }
  }

  /** Hand on what the server says unless a newer request has come. */
  #whileNewest(at, count, handlers) {
    const isNewest = () => at.count === count;
    return {
      answer: (...given) => isNewest() && handlers.answer(...given),
      fault: (faults) => isNewest() && handlers.fault?.(faults),
      progress: handlers.progress,
    };
  }

  #elsewhere(queue, message, handlers) {
    if (this.server !== null) this.server.put(queue, message, handlers);
    else handlers.fault?.([{ path: "", reason: this.refuse(message) }]);
  }
}
