// A motion computed by the kernels, as percuss.web.explore answers it.

import { readStudy } from "./local_study.js";

// A slider waits no longer [ms], and for no more impacts; searches between two looks at the clock.
const [PATIENCE, MOST_IMPACTS, SEARCHES] = [1000, 50_000, 20_000];
// Terms of formulas for a curve; points of a spectrum, and its reach over the highest frequency.
const [MOST_TERMS, TRANSFORMED, REACH] = [1_600_000, 4096, 8];
const [FEWEST_POINTS, POINTS_PER_CYCLE] = [33, 64];
const [SHOWN_IMPACTS, SHOWN_CONTACTS] = [4000, 8];
const LARGEST = 1e150;

/** Return {header, arrays} of a motion, null where it needs Python. */
export function answerMotion(kernels, { study, points = 4000, window = null }) {
  const began = performance.now();
  const read = readStudy(study, kernels);
  if (read === null) return null;
  kernels.clear();
  const run = follow(kernels, read);
  if (run === null) return null;
  const milliseconds = performance.now() - began;
  const shown = windowOf(window, run);
  const { forced, ...curves } = curvesOf(kernels, run, shown, points);
  const crossings = run.crossings();
  const contacts = run.contacts();
  const header = {
    kind: "explore", t0: run.t0, t_end: run.end, window: shown, period: run.period || null, outcome: run.outcome,
    is_cut: run.isInterrupted || (run.isFull && (read.most === undefined || read.most > MOST_IMPACTS)),
    n_impacts: run.impacts.length, n_crossings: crossings.length, n_entries: crossings.filter((it) => it.isEntry).length,
    n_contacts: contacts.length, n_grazes: run.nGrazes, impact_times: null, contacts: contacts.slice(0, SHOWN_CONTACTS),
    elements: elementsOf(study), milliseconds,
  };
  return { header, arrays: { ...curves, ...forced, ...sectionOf(kernels, run, crossings), ...spectrumOf(kernels, run) } };
}

/** Follow a motion to its end, for as long as a slider can wait. */
export function follow(kernels, read) {
  const at = kernels.columns;
  const law = lawOf(kernels, read);
  const n = read.harmonics.length;
  const [t0, end] = [instantOf(kernels, read, [0, 0, 0], read.t0), instantOf(kernels, read, read.periods, read.end ?? read.t0)];
  if (!(end > t0)) return null;
  const limit = Math.min(read.most ?? MOST_IMPACTS, MOST_IMPACTS);
  const state = kernels.zeros(at.STATE_ENTRIES);
  const counters = kernels.integers(at.COUNTERS);
  kernels.view(counters).fill(0n);
  const arrays = [law.rows, state, counters, ...[0, 1, 2].map(() => kernels.zeros(n, 2))];
  let record = recordOf(kernels, Math.min(2 * limit, 4096) + 16, 64);
  const begin = kernels.view(state);
  [begin[at.T], begin[at.X], begin[at.V]] = [t0, read.x0, read.v0];
  const began = performance.now();
  let status = at.SPENT;
  while (status === at.SPENT || status === at.FULL) {
    if (status === at.FULL) record = longer(kernels, record, counters);
    status = kernels.call("march", ...arrays, record.events, record.marks, record.grazes, end, limit, SEARCHES);
    if (status === at.SPENT && performance.now() - began > PATIENCE) break;
  }
  const counted = kernels.view(counters);
  const isFlying = counted[at.TOUCHED] === 0n;
  const growth = kernels.view(law.rows)[Number(counted[0]) * at.COLUMNS + at.GROWTH];
  // Where a motion may grow beyond all numbers Python finds out when.
  if (status === at.OVERFLOW || (status === at.REACHED_END && isFlying && growth > 0)) return null;
  return new LocalRun(kernels, read, law, record, counted, { t0, end, status, last: kernels.view(state)[at.T] });
}

function recordOf(kernels, n, grazes) {
  const { EVENT_COLUMNS, MARK_COLUMNS, GRAZE_COLUMNS } = kernels.columns;
  return { events: kernels.floats(n, EVENT_COLUMNS), marks: kernels.integers(n, MARK_COLUMNS), grazes: kernels.floats(grazes, GRAZE_COLUMNS) };
}

/** Return arrays of the double length with the same record. */
function longer(kernels, record, counters) {
  const more = recordOf(kernels, 2 * record.events.shape[0], 2 * record.grazes.shape[0]);
  for (const name of Object.keys(record)) kernels.view(more[name]).set(kernels.view(record[name]));
  return more;
}

export function lawOf(kernels, { given, stops, harmonics }) {
  const at = kernels.columns;
  const table = kernels.floats(given.length, at.GIVEN_COLUMNS);
  const view = kernels.view(table);
  given.forEach((row, i) => view.set(row, i * at.GIVEN_COLUMNS));
  const bounds = kernels.integers(stops.length + 2);
  const n = harmonics.length;
  const rows = kernels.zeros(1 + n + (stops.length + 1) * (1 + n), at.COLUMNS);
  const used = kernels.call("fill_law", table, bounds, rows);
  return { given: table, bounds, rows: kernels.rows(rows, used) };
}

/** Return the instant so many periods after a phase. */
export function instantOf(kernels, { given, stops }, periods, { times, plus }) {
  const numbers = kernels.zeros(5, 3);
  const omega = given[1 + stops.length]?.subarray(0, 3) ?? [0, 0, 0];
  kernels.view(numbers).set([...omega, ...periods, ...times, ...plus]);
  kernels.call("instant", numbers);
  return kernels.view(numbers)[12];
}

/** The record of a motion, and what the page asks of it. */
class LocalRun {
  constructor(kernels, read, law, record, counted, { t0, end, status, last }) {
    const at = kernels.columns;
    const n = Number(counted[at.N_EVENTS]);
    Object.assign(this, { kernels, read, law, t0 });
    this.events = kernels.rows(record.events, n);
    this.marks = kernels.rows(record.marks, n);
    this.nGrazes = Number(counted[at.N_GRAZES]);
    this.isFull = status === at.REACHED_LIMIT;
    this.isInterrupted = status === at.SPENT;
    this.end = status === at.REACHED_END || status === at.AT_REST ? end : last;
    this.outcome = OUTCOMES.find(([name]) => at[name] === status)[1];
    this.period = kernels.view(law.rows)[at.PERIOD];
    this.rows = { events: kernels.view(this.events).slice(), marks: Array.from(kernels.view(this.marks), Number), bounds: Array.from(kernels.view(law.bounds), Number) };
    this.kinds = Array.from({ length: n }, (_, i) => this.rows.marks[i * at.MARK_COLUMNS + at.KIND]);
    this.impacts = this.#ofKind(at.IMPACT);
    const { harmonics, given, stops } = read;
    this.omegas = harmonics.map((_, j) => given[1 + stops.length + j][at.WAVE_OMEGA]);
  }

  get record() {
    return [this.law.rows, this.read.x0, this.events, this.marks];
  }

  event(i, column) {
    return this.rows.events[i * this.kernels.columns.EVENT_COLUMNS + this.kernels.columns[column]];
  }

  /** Return the bound of an event. */
  bound(i) {
    const { MARK_COLUMNS, BOUND } = this.kernels.columns;
    return this.rows.marks[i * MARK_COLUMNS + BOUND];
  }

  #ofKind(kind) {
    return this.kinds.flatMap((it, i) => (it === kind ? [i] : []));
  }

  /** Return the crossings of edges, one for each stop: one enters. */
  crossings() {
    const { stops, places } = this.read;
    return this.#ofKind(this.kernels.columns.CROSSING).flatMap((i) => {
      const edge = places[this.rows.bounds[this.bound(i)]];
      const v = this.event(i, "V_AFTER");
      const here = stops.flatMap((stop, k) => (stop.type === "soft" && places[k] === edge ? [k] : []));
      let n = 0;
      return here.map((stop) => ({ t: this.event(i, "EVENT_T"), v, stop, isEntry: v > 0 === (stops[stop].side === "above") && !n++ }));
    });
  }

  /** Return start and release of each contact. */
  contacts() {
    return this.#ofKind(this.kernels.columns.CONTACT).map((i) => [this.event(i, "EVENT_T"), i + 1 < this.kinds.length ? this.event(i + 1, "EVENT_T") : null]);
  }

  /** Return the times at which one formula of the motion ends and another begins. */
  cuts() {
    const { IMPACT, CROSSING, CONTACT } = this.kernels.columns;
    return this.kinds.flatMap((kind, i) => ([IMPACT, CROSSING, CONTACT].includes(kind) ? [this.event(i, "EVENT_T")] : []));
  }

  /** The highest frequency of forcing and spring. */
  get fastest() {
    const stiffness = this.read.given[0][this.kernels.columns.GIVEN_STIFFNESS] / (this.read.mass ?? 1);
    return Math.max(stiffness > 0 ? Math.sqrt(stiffness) : 0, ...this.omegas) || 1;
  }
}

// As percuss.motion.trajectory.Outcome says it.
const OUTCOMES = [
  ["REACHED_END", "the run reached t_end"],
  ["REACHED_LIMIT", "the run reached max_impacts (impacts and entries into soft stops)"],
  ["AT_REST", "the mass came to rest at a stop for good"],
  ["NO_MORE", "the motion provably meets no stop again, and there is no t_end to run to"],
  ["SPENT", "the run was interrupted; it holds what was done"],
];

/** Return the part of a run that a window shows, null for all of it. */
function windowOf(window, { t0, end }) {
  if (window === null) return null;
  const [low, high] = [Math.max(window[0], t0), Math.min(window[1], end)];
  return low < high ? [low, high] : null;
}

function curvesOf(kernels, run, window, points) {
  const [low, high] = window ?? [run.t0, run.end];
  const cuts = run.cuts();
  const within = countBelow(cuts, high) - countBelow(cuts, low);
  const cycles = ((high - low) * run.fastest) / (2 * Math.PI);
  const affordable = Math.floor(MOST_TERMS / (1 + run.omegas.length));
  const isBand = FEWEST_POINTS * within + POINTS_PER_CYCLE * cycles > affordable;
  const curve = isBand ? bandOf(kernels, run, low, high, Math.floor(affordable / 4)) : traced(kernels, run, low, high);
  const end = isBand ? traced(kernels, run, ...endOf(run, cuts, low, high, points)) : curve;
  const drawn = (values) => toColumns(kernels, curve, values, points);
  const tail = kernels.floats(3, points);
  const kept = kernels.call("without_rests", end.t, end.x, end.v, points, tail);
  const row = (k) => kernels.view(kernels.part(tail, k * points, kept)).slice();
  const [t, x] = drawn(curve.x);
  const [velocityT, v] = drawn(curve.v);
  return { t, x, velocity_t: velocityT, v, portrait_t: row(0), portrait_x: row(1), portrait_v: row(2), forced: forcesOf(kernels, run, curve, drawn) };
}

/** Return the points of each piece of a motion in [low, high]. */
function traced(kernels, run, low, high) {
  const cuts = kernels.floats(run.kinds.length + 2);
  const pieces = kernels.rows(cuts, kernels.call("cut", ...run.record, low, high, cuts));
  const counts = kernels.integers(pieces.size - 1);
  const n = kernels.call("count_points", ...run.record, Math.max(0, ...run.omegas), pieces, counts);
  const curve = kernels.floats(3, n);
  const jumps = kernels.integers(n);
  const scratch = [kernels.floats(2, run.omegas.length, 2), kernels.floats(3, counts.size)];
  const kept = kernels.call("trace", ...run.record, pieces, counts, ...scratch, curve, jumps);
  return curveOf(kernels, curve, kept, jumps);
}

function curveOf(kernels, curve, kept, jumps) {
  const [t, x, v] = [0, 1, 2].map((k) => kernels.part(curve, k * curve.shape[1], kept));
  return { t, x, v, jumps: kernels.rows(jumps, kept) };
}

/** Return points at equidistant times: with more cycles than pixels any show it. */
function bandOf(kernels, run, low, high, n) {
  const curve = kernels.floats(3, n);
  const jumps = kernels.integers(n);
  kernels.view(jumps).fill(0n);
  const times = kernels.part(curve, 0, n);
  const view = kernels.view(times);
  for (let i = 0; i < n; i += 1) view[i] = i === n - 1 ? high : low + i * ((high - low) / (n - 1));
  evaluateAt(kernels, run, times, { ...curve, at: curve.at + 8 * n, shape: [2, n], size: 2 * n });
  return curveOf(kernels, curve, n, jumps);
}

function evaluateAt(kernels, run, instants, motion) {
  const n = run.omegas.length;
  kernels.call("evaluate", ...run.record, instants, kernels.floats(n, 2), kernels.floats(n, 2), motion);
}

/** Return the last part of a window that makes so many points. */
function endOf(run, cuts, low, high, points) {
  const first = countBelow(cuts, high) - Math.floor(points / FEWEST_POINTS) - 2;
  const duration = (2 * Math.PI * points) / (POINTS_PER_CYCLE * run.fastest);
  const begin = Math.max(low, high - duration, first >= 0 ? cuts[first] : low);
  return begin < high ? [begin, high] : [low, high];
}

function countBelow(sorted, value) {
  let [low, high] = [0, sorted.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (sorted[middle] < value) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Return the points that a picture so many points wide is drawn from. */
function toColumns(kernels, { t, jumps }, values, points) {
  const out = kernels.floats(2, Math.max(points, t.size) + 2);
  const kept = kernels.call("to_columns", t, values, jumps, Math.floor(points / 2), points, out);
  return [0, 1].map((k) => kernels.view(kernels.part(out, k * out.shape[1], kept)).slice());
}

/** Return the forces of the stops along a curve, of those that act. */
function forcesOf(kernels, run, curve, drawn) {
  const found = {};
  const { CROSSING, CONTACT } = kernels.columns;
  if (!run.kinds.some((kind) => kind === CROSSING || kind === CONTACT)) return found;
  const n = curve.t.size;
  const copy = kernels.floats(3, n);
  ["t", "x", "v"].forEach((name, k) => kernels.view(copy).set(kernels.view(curve[name]), k * n));
  const forces = kernels.floats(run.read.stops.length + 1, n);
  kernels.call("stop_forces", run.law.given, run.law.bounds, ...run.record, kernels.floats(run.omegas.length, 2), copy, forces);
  run.read.stops.forEach((_, i) => {
    const force = kernels.part(forces, i * n, n);
    if (kernels.view(force).some((value) => value !== 0)) [found[`force_t${i}`], found[`force${i}`]] = drawn(force);
  });
  return found;
}

/** Return the impacts, or without walls the entries into soft stops, as points. */
function sectionOf(kernels, run, crossings) {
  if (run.impacts.length === 0) {
    const entered = crossings.filter((it) => it.isEntry).slice(-SHOWN_IMPACTS);
    const t = Float64Array.from(entered, (it) => it.t);
    // The cycle is that of the double.
    const cycle = run.period ? t.map((it) => it / run.period - Math.floor(it / run.period)) : t.map(() => 0);
    return { cycle, speed: Float64Array.from(entered, (it) => Math.abs(it.v)), event_stop: Float64Array.from(entered, (it) => it.stop), impulse: t.map(() => Number.NaN), event_t: t };
  }
  const shown = run.impacts.slice(-SHOWN_IMPACTS);
  const column = (of) => Float64Array.from(shown, of);
  const [t, low, cycle] = [0, 1, 2].map(() => kernels.floats(shown.length));
  kernels.view(t).set(shown.map((i) => run.event(i, "EVENT_T")));
  kernels.view(low).set(shown.map((i) => run.event(i, "EVENT_T_LOW")));
  if (run.period) kernels.call("cycles", run.law.rows, t, low, cycle);
  else kernels.view(cycle).fill(Number.NaN);
  const mass = run.read.mass ?? 1;
  return {
    cycle: kernels.view(cycle).slice(),
    speed: column((i) => Math.abs(run.event(i, "V_BEFORE"))),
    event_stop: column((i) => run.rows.bounds[run.bound(i)]),
    impulse: column((i) => mass * (run.event(i, "V_AFTER") - run.event(i, "V_BEFORE"))),
    event_t: kernels.view(t).slice(),
  };
}

/** Return the amplitudes of the later half of the run, or of what the points can resolve. */
function spectrumOf(kernels, run) {
  const { fastest, end, t0 } = run;
  const longest = (TRANSFORMED * Math.PI) / (2 * REACH * fastest);
  const begin = Math.max(end - 0.5 * (end - t0), end - longest);
  if (!(end > t0)) return { omega: new Float64Array(0), amplitude: new Float64Array(0) };
  const [instants, motion] = [kernels.floats(TRANSFORMED), kernels.floats(2, TRANSFORMED)];
  const view = kernels.view(instants);
  for (let i = 0; i < TRANSFORMED; i += 1) view[i] = Math.min(begin + (i / TRANSFORMED) * (end - begin), end);
  evaluateAt(kernels, run, instants, motion);
  const values = kernels.part(motion, 0, TRANSFORMED);
  kernels.call("spectrum", values, kernels.floats(2, TRANSFORMED));
  const amplitudes = kernels.view(values).slice(0, TRANSFORMED / 2 + 1);
  // At zero the coefficient is twice the mean.
  const [low] = amplitudes;
  amplitudes[0] = 0.5 * low;
  const omega = amplitudes.map((_, k) => ((2 * Math.PI) / (end - begin)) * k);
  const isShown = (_, k) => omega[k] <= REACH * fastest && amplitudes[k] < LARGEST;
  return { omega: omega.filter(isShown), amplitude: amplitudes.filter(isShown) };
}

/** Return what the picture of the mass is drawn from: see percuss.web.mechanisms.elements_of_oscillator. */
function elementsOf({ oscillator, forcing = {} }) {
  const { stiffness = 1, stops = [] } = oscillator;
  const damping = oscillator.mass === undefined ? oscillator.damping : oscillator.damping_coefficient;
  const isThere = (value) => valueOf(value ?? 0) !== 0;
  const isMoving = (forcing.harmonics ?? []).length > 0;
  const constant = valueOf(forcing.constant ?? 0);
  return {
    n: 1,
    springs: isThere(stiffness) ? [[-1, 0]] : [],
    dashpots: isThere(damping) ? [[-1, 0]] : [],
    stops: stops.map(({ at, side, type }) => ({ on: [1], at: valueOf(at), side, type })),
    loads: isMoving || constant !== 0 ? [[constant < 0 && !isMoving ? -1 : 1]] : [],
  };
}

function valueOf(value) {
  const [number, over = "1"] = String(value).split("/");
  return Number(number) / Number(over);
}
