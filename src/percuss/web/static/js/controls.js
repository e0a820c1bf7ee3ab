// The panel of parameters: a slider and a box for each.

import { button, element } from "./dom.js";
import { MODELS, equationOf, modelOf, newHarmonic, newStop, parametersOf, withModel, withoutHarmonic } from "./models.js";
import { Row } from "./row.js";
import { get, put } from "./state.js";

/** Build the panel; it follows the store, and writes what the user sets into it. */
export class Panel {
  /** `prefix` makes the ids unique, `onRelease` is called when a slider is released. */
  constructor(store, prefix, onRelease) {
    this.store = store;
    this.prefix = prefix;
    this.isHeld = false;
    this.rows = new Map();
    this.root = element("form", { class: "panel", "aria-label": "Parameters", onsubmit: (event) => event.preventDefault() });
    this.shape = "";
    this.#watchHands(onRelease);
    store.watch(() => this.update());
    this.update();
  }

  #watchHands(onRelease) {
    const isSlider = (event) => event.target.type === "range";
    const release = () => {
      if (!this.isHeld) return;
      this.isHeld = false;
      onRelease();
    };
    for (const name of ["pointerdown", "keydown"]) this.root.addEventListener(name, (event) => (this.isHeld ||= isSlider(event)));
    for (const name of ["keyup", "focusout", "change"]) this.root.addEventListener(name, (event) => isSlider(event) && release());
    this.release = release;
    for (const name of ["pointerup", "pointercancel"]) addEventListener(name, release);
  }

  /** Remove its listeners. */
  close() {
    for (const name of ["pointerup", "pointercancel"]) removeEventListener(name, this.release);
  }

  /** Show the values; rebuild the rows where the parameters have changed. */
  update() {
    const { study } = this.store.value;
    const groups = parametersOf(study);
    const shape = JSON.stringify(groups.map((group) => [group.title, group.rows.map((it) => [it.path, it.label])])) + sides(study);
    if (shape !== this.shape) {
      this.shape = shape;
      this.#build(groups);
    }
    this.select.value = modelOf(study);
    const ranges = this.store.value.ranges ?? {};
    for (const row of this.rows.values()) row.show(get(study, row.path), this.ranges === ranges ? undefined : (ranges[row.path] ?? row.home));
    this.ranges = ranges;
  }

  /** The server has accepted a study: its values may widen the sliders. */
  accept(study) {
    for (const row of this.rows.values()) row.accept(get(study, row.path));
  }

  /** Show faults beside their fields; return those that belong to none. */
  showFaults(faults) {
    for (const row of this.rows.values()) row.fault("");
    const rest = [];
    for (const fault of faults) {
      const row = this.rows.get(fault.path);
      if (row) row.fault(fault.reason);
      else rest.push(fault.path ? `${fault.path}: ${fault.reason}` : fault.reason);
    }
    return rest;
  }

  #build(groups) {
    this.rows.clear();
    this.ranges = null;
    const study = () => this.store.value.study;
    const change = (next) => this.store.set({ study: next }, "study");
    const kind = modelOf(study());
    this.select = element(
      "select",
      { "aria-label": "Model", onchange: (event) => change(withModel(study(), event.target.value)) },
      ...Object.entries(MODELS).map(([value, { label }]) => element("option", { value, selected: value === kind, disabled: value === "own" && kind !== "own" }, label)),
    );
    const parts = [element("label", { class: "model" }, element("span", {}, "Model"), this.select), element("p", { class: "hint" }, equationOf(study()))];
    for (const group of groups) parts.push(this.#group(group, study, change));
    this.root.replaceChildren(...parts);
  }

  #group(group, study, change) {
    const body = element("fieldset", {}, element("legend", {}, group.title));
    if (group.stop !== undefined) {
      const path = `oscillator.stops.${group.stop}.side`;
      const side = get(study(), path);
      body.append(
        element(
          "div",
          { class: "tools" },
          element(
            "select",
            { "aria-label": `side of ${group.title}`, onchange: (event) => change(put(study(), path, event.target.value)) },
            ...["below", "above"].map((name) => element("option", { value: name, selected: name === side }, `${name} the motion`)),
          ),
          button("remove", () => change(without(study(), "oscillator.stops", group.stop))),
        ),
      );
    }
    if (group.harmonic !== undefined) {
      body.append(
        element("div", { class: "tools" }, button("remove", () => change(withoutHarmonic(study(), group.harmonic)))),
      );
    }
    for (const spec of group.rows) {
      const row = new Row(spec, {
        prefix: this.prefix,
        set: (value) => change(put(study(), spec.path, value)),
        setRange: (range) => this.#setRange(spec.path, range),
      });
      this.rows.set(spec.path, row);
      body.append(row.root);
    }
    if (group.title === "Oscillator" || group.title === "Forcing") body.append(this.#adders(group.title, study, change));
    return body;
  }

  #setRange(path, range) {
    const { [path]: _, ...rest } = this.store.value.ranges ?? {};
    this.store.set({ ranges: range === null ? rest : { ...rest, [path]: range } }, "ranges");
  }

  #adders(title, study, change) {
    const tools = element("div", { class: "tools" });
    const add = (path, made) => change(put(study(), path, [...(get(study(), path) ?? []), made]));
    if (title === "Forcing") tools.append(button("add a harmonic", () => add("forcing.harmonics", newHarmonic())));
    else {
      tools.append(button("add a wall", () => add("oscillator.stops", newStop("wall"))));
      tools.append(button("add a soft stop", () => add("oscillator.stops", newStop("soft"))));
    }
    return tools;
  }
}

function sides(study) {
  return (study.oscillator.stops ?? []).map((stop) => stop.side + stop.type).join();
}

function without(study, path, index) {
  return put(study, path, get(study, path).filter((_, i) => i !== index));
}
