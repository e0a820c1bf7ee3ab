// The parameters of a motion, to be ticked as free: with a guess, or a range in which they are looked for.

import { button, element, shown } from "./dom.js";
import { checkField, checkRange, numberField } from "./fields.js";
import { numberOf, valueOf } from "./models.js";
import { isRange, isTable } from "./state.js";

/** Rows to tick; `paths()` returns the parameters there are. Without `hasGuesses` each has a range; `changed()` is called. */
export class FreeParameters {
  constructor(store, paths, { hasGuesses = true, changed = () => {} } = {}) {
    this.store = store;
    this.paths = paths;
    this.hasGuesses = hasGuesses;
    this.changed = changed;
    this.shape = "";
    // What is ticked: {path: null for a guess, or [low, high]}.
    this.free = {};
    this.root = element("div", { class: "free" });
  }

  clear() {
    this.free = {};
    this.build();
  }

  /** Take what a link says is ticked; of what it cannot say, nothing. */
  restore(free) {
    this.free = isTable(free) ? Object.fromEntries(Object.entries(free).filter(([, it]) => isRange(it) || (it === null && this.hasGuesses))) : {};
  }

  /** The guess or the range of each parameter that is ticked and is there. */
  get value() {
    const { study } = this.store.value;
    const known = new Set(this.paths().map(({ path }) => path));
    const entries = Object.entries(this.free).filter(([path]) => known.has(path));
    return Object.fromEntries(entries.map(([path, range]) => [path, range ?? numberOf(valueOf(study, path) ?? 0)]));
  }

  /** The parameters are others, or have other names and values. */
  update() {
    if (JSON.stringify(this.paths().map(({ path, name }) => [path, name])) !== this.shape) this.build();
    for (const [path, guess] of this.guesses) guess.textContent = this.free[path] ? "" : `guess ${shown(numberOf(valueOf(this.store.value.study, path) ?? 0), 6)}`;
  }

  build() {
    this.guesses = new Map();
    this.shape = JSON.stringify(this.paths().map(({ path, name }) => [path, name]));
    this.root.replaceChildren(...this.paths().map((it) => this.#row(it)));
  }

  /** One parameter: a tick, and once it is ticked its guess or its range. */
  #row({ path, name }) {
    const ends = element("span", { class: "ends" });
    const guess = element("span", { class: "hint" });
    this.guesses.set(path, guess);
    const fill = () => {
      const range = this.free[path];
      if (range === undefined) ends.replaceChildren();
      else if (range === null) ends.replaceChildren(guess, button("range", () => choose(this.#around(path)), { "aria-label": `range of ${name}` }));
      else {
        const set = (k) => (value) => {
          range[k] = value;
          if (checkRange(high, ...range)) this.changed();
        };
        const low = numberField("from", range[0], set(0));
        const high = numberField("to", range[1], set(1));
        ends.replaceChildren(low, high, ...(this.hasGuesses ? [button("guess", () => choose(null), { "aria-label": `guess of ${name}` })] : []));
      }
    };
    const choose = (range) => {
      this.free = { ...this.free, [path]: range };
      fill();
      this.update();
      this.changed();
    };
    const tick = checkField(name, path in this.free, (isOn) => {
      if (isOn) choose(this.hasGuesses ? null : this.#around(path));
      else {
        const { [path]: _, ...rest } = this.free;
        this.free = rest;
        fill();
        this.changed();
      }
    });
    tick.querySelector("input").dataset.free = path;
    fill();
    return element("div", { role: "group", "aria-label": name }, tick, ends);
  }

  /** A range about a guess: that of its slider, or half and twice of it. */
  #around(path) {
    const value = numberOf(valueOf(this.store.value.study, path) ?? 0);
    const own = this.store.value.ranges?.[path];
    if (own) return [...own];
    if (path.endsWith(".restitution")) return [0.1, 1];
    if (!Number.isFinite(value) || value === 0) return [-1, 1];
    return (value > 0 ? [value / 2, 2 * value] : [2 * value, value / 2]).map((end) => Number(end.toPrecision(4)));
  }
}
