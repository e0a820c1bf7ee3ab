// The panel of parameters: a slider and a box for each.

import { button, element } from "./dom.js";
import { MODELS, modelOf, newHarmonic, newStop, numberOf, parametersOf, withModel } from "./models.js";
import { get, put } from "./state.js";

/** Build the panel; it follows the store, and puts what the user sets into it. */
export class Panel {
  constructor(store) {
    this.store = store;
    this.rows = new Map();
    this.root = element("form", { class: "panel", "aria-label": "Parameters", onsubmit: (event) => event.preventDefault() });
    this.shape = "";
    store.watch(() => this.update());
    this.update();
  }

  /** Show the values; build the rows anew where there are others. */
  update() {
    const { study } = this.store.value;
    const groups = parametersOf(study);
    const shape = JSON.stringify(groups.map((group) => [group.title, group.rows.map((it) => it.path)])) + sides(study);
    if (shape !== this.shape) {
      this.shape = shape;
      this.#build(groups);
    }
    for (const row of this.rows.values()) row.show(get(study, row.path));
  }

  /** Show what is wrong beside the fields; return what belongs to none. */
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
    const study = () => this.store.value.study;
    const change = (next) => this.store.set({ study: next }, "study");
    const kind = modelOf(study());
    const select = element(
      "select",
      { "aria-label": "Model", onchange: (event) => change(withModel(study(), event.target.value)) },
      ...Object.entries(MODELS).map(([value, { label }]) => element("option", { value, selected: value === kind }, label)),
    );
    const parts = [element("label", { class: "model" }, element("span", {}, "Model"), select)];
    for (const group of groups) parts.push(this.#group(group, study, change));
    this.root.replaceChildren(...parts);
  }

  #group(group, study, change) {
    const body = element("fieldset", {}, element("legend", {}, group.title));
    if (group.stop !== undefined) {
      const path = `oscillator.stops.${group.stop}.side`;
      const side = get(study(), path);
      const other = side === "below" ? "above" : "below";
      body.append(
        element(
          "div",
          { class: "tools" },
          button(`${side} the motion`, () => change(put(study(), path, other)), { title: `put it ${other}` }),
          button("remove", () => change(without(study(), "oscillator.stops", group.stop))),
        ),
      );
    }
    if (group.harmonic !== undefined) {
      body.append(
        element("div", { class: "tools" }, button("remove", () => change(without(study(), "forcing.harmonics", group.harmonic)))),
      );
    }
    for (const spec of group.rows) {
      const row = new Row(spec, (value) => change(put(study(), spec.path, value)));
      this.rows.set(spec.path, row);
      body.append(row.root);
    }
    if (group.title === "Oscillator" || group.title === "Forcing") body.append(this.#adders(group.title, study, change));
    return body;
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

/** One parameter. */
class Row {
  constructor({ path, label, range, step }, set) {
    this.path = path;
    this.range = [...range];
    this.step = step;
    this.value = undefined;
    const id = `p-${path.replaceAll(".", "-")}`;
    this.slider = element("input", {
      type: "range", min: "0", max: "1000", step: "1", "aria-label": `${label}, slider`,
      oninput: () => set(this.#ofSlider()),
    });
    this.box = element("input", {
      type: "text", id, spellcheck: "false", autocomplete: "off", "aria-describedby": `${id}-fault`,
      oninput: () => set(typed(this.box.value)),
      onkeydown: (event) => this.#key(event, set),
    });
    this.message = element("p", { class: "fault", id: `${id}-fault`, role: "alert" });
    this.root = element("div", { class: "row" }, element("label", { for: id }, label), this.slider, this.box, this.message);
  }

  show(value) {
    const text = String(value ?? 0);
    if (typed(this.box.value) !== value && document.activeElement !== this.box) this.box.value = text;
    else if (document.activeElement !== this.box) this.box.value = text;
    const number = numberOf(value ?? 0);
    if (Number.isNaN(number)) return;
    // A value beyond the slider's end moves the end, unless a hand is on it.
    if (document.activeElement !== this.slider) {
      if (number > this.range[1]) this.range[1] = 1.5 * number;
      if (number < this.range[0]) this.range[0] = number < 0 ? 1.5 * number : 0;
      const share = (number - this.range[0]) / (this.range[1] - this.range[0]);
      this.slider.value = String(Math.round(1000 * share));
    }
    this.slider.setAttribute("aria-valuetext", text);
  }

  fault(reason) {
    this.message.textContent = reason;
    this.box.setAttribute("aria-invalid", reason ? "true" : "false");
  }

  #ofSlider() {
    const [low, high] = this.range;
    const width = high - low;
    const unit = this.step ?? 10 ** (Math.floor(Math.log10(width)) - 3);
    const value = Math.round((low + (width * Number(this.slider.value)) / 1000) / unit) * unit;
    const digits = Math.max(0, -Math.floor(Math.log10(unit)));
    return typed(String(Number(value.toFixed(digits))));
  }

  /** The arrow keys in a box change its last digit. */
  #key(event, set) {
    if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
    const match = /^(-?\d+)(?:\.(\d+))?$/.exec(this.box.value.trim());
    if (match === null) return;
    event.preventDefault();
    const digits = match[2]?.length ?? 0;
    const next = Number(this.box.value) + (event.key === "ArrowUp" ? 1 : -1) * 10 ** -digits;
    this.box.value = next.toFixed(digits);
    set(typed(this.box.value));
  }
}

/** Return what was typed as a study file holds it: whole numbers bare, the rest as exact texts. */
export function typed(text) {
  const bare = text.trim();
  return /^[+-]?\d{1,15}$/.test(bare) ? Number(bare) : bare;
}

function sides(study) {
  return (study.oscillator.stops ?? []).map((stop) => stop.side + stop.type).join();
}

function without(study, path, index) {
  return put(study, path, get(study, path).filter((_, i) => i !== index));
}
