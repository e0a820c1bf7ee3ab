// The state of the page, as one value that fits into a link.

/** A value that calls its watchers when it changes. */
export class Store {
  constructor(value) {
    this.value = value;
    this.watchers = new Set();
  }

  /** Replace parts of the value; `why` names the change for the watchers. */
  set(parts, why = "") {
    this.value = { ...this.value, ...parts };
    for (const watch of this.watchers) watch(this.value, why);
  }

  watch(watcher) {
    this.watchers.add(watcher);
    return () => this.watchers.delete(watcher);
  }
}

// Changes of the study within so long belong together, as those of a slider that moves [ms].
const TOGETHER = 800;
const MOST_KEPT = 200;

/** The studies before and after the one that is shown. */
export class StudyHistory {
  constructor(store) {
    this.store = store;
    this.past = [];
    this.future = [];
    this.now = store.value.study;
    this.changed = -Infinity;
    store.watch((state, why) => {
      if (state.study !== this.now && !this.isMoving) this.#keep(why);
      this.now = state.study;
    });
  }

  #keep(why) {
    const time = performance.now();
    if (why !== "study" || time - this.changed > TOGETHER) this.past = [...this.past, this.now].slice(-MOST_KEPT);
    this.changed = time;
    this.future = [];
  }

  /** Return to the study before, or with `isRedo` to the one after; tell whether there is one. */
  move(isRedo) {
    const [from, to] = isRedo ? [this.future, this.past] : [this.past, this.future];
    if (from.length === 0) return false;
    to.push(this.now);
    this.isMoving = true;
    this.store.set({ study: from.pop() }, "study");
    this.isMoving = false;
    this.changed = -Infinity;
    return true;
  }
}

/** Return the part of a nested value at a dotted path. */
export function get(tables, path) {
  return path.split(".").reduce((part, name) => part?.[name], tables);
}

/** Return a copy with another value at a dotted path. */
export function put(tables, path, value) {
  const [name, ...rest] = path.split(".");
  const copy = Array.isArray(tables) ? [...tables] : { ...tables };
  copy[name] = rest.length === 0 ? value : put(copy[name] ?? {}, rest.join("."), value);
  return copy;
}

/** Return defaults with those given instead that have the same names and types; words of all objects, such as toString, are none. */
export function settingsOf(defaults, given) {
  const found = { ...defaults };
  for (const [name, value] of Object.entries(isTable(given) ? given : {})) {
    if (typeof value === typeof defaults[name] && !(value in {}) && (typeof value !== "number" || Number.isFinite(value))) found[name] = value;
  }
  return found;
}

/** Return a state as the text of a link. */
export function encode(state) {
  const bytes = new TextEncoder().encode(JSON.stringify(state));
  let text = "";
  for (const byte of bytes) text += String.fromCharCode(byte);
  return btoa(text).replaceAll("+", "-").replaceAll("/", "_").replace(/=+$/, "");
}

/** Return the state of a link, null if it holds none. */
export function decodeLink(text) {
  try {
    const raw = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
    const bytes = Uint8Array.from(raw, (letter) => letter.charCodeAt(0));
    const { view, study, diagram, basins, fit, design, mechanism, ranges, zooms, digits, tour } = JSON.parse(new TextDecoder().decode(bytes));
    if (!isStudy(study)) return null;
    return { view: String(view), study, diagram, basins, fit, design, mechanism: isTable(mechanism) ? mechanism : undefined, ranges: rangesOf(ranges), zooms: zoomsOf(zooms), digits: Number.isInteger(digits) ? digits : undefined, tour: Number.isInteger(tour) ? tour : undefined };
  } catch {
    return null;
  }
}

export const isTable = (it) => it !== null && typeof it === "object" && !Array.isArray(it);
const isRows = (it) => Array.isArray(it) && it.every(isTable);

/** Return whether the panel can show a study; the server checks the rest. */
export function isStudy(study) {
  if (!isTable(study)) return false;
  const { parameters = {}, oscillator, forcing, start, run } = study;
  return [parameters, oscillator, forcing, start, run].every(isTable) && isRows(oscillator.stops ?? []) && isRows(forcing.harmonics ?? []);
}

export const isRange = (it) => Array.isArray(it) && it.length === 2 && it.every(Number.isFinite) && it[0] < it[1];
const kept = (rows, test) => Object.fromEntries(Object.entries(isTable(rows) ? rows : {}).filter(([, it]) => test(it)));
const rangesOf = (ranges) => kept(ranges, isRange);
const zoomsOf = (zooms) => kept(zooms, (it) => isTable(it) && isRange(it.x) && isRange(it.y));
