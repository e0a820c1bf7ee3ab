// The panel of parameters: a slider and a box for each.

import { button, element, form, isStudyFile, watchDrops } from "./dom.js";
import { choiceField, checkField } from "./fields.js";
import { MODELS, equationOf, modelOf, nameFault, newHarmonic, newStop, parametersOf, UNITS, valueOf, withMass, withModel, withRecord, withUnit, withoutHarmonic, withoutRecord } from "./models.js";
import { RecordForm } from "./records.js";
import { Row, showFaults } from "./row.js";
import { get, put } from "./state.js";

/** Build the panel; it follows the store, and writes what the user sets into it. */
export class Panel {
  /** `prefix` makes the ids unique, `onRelease` is called when a slider is released, `askRecord` for the samples of a table. */
  constructor(store, prefix, onRelease, askRecord) {
    this.store = store;
    this.prefix = prefix;
    this.isHeld = false;
    this.rows = new Map();
    this.root = form("panel", "Parameters");
    this.shape = "";
    this.record = new RecordForm(askRecord, (record) => store.set({ study: withRecord(store.value.study, record) }, "study"));
    this.#watchDrops();
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

  /** A table that is dropped on the panel is a record of the force. */
  #watchDrops() {
    watchDrops(this.root, (file) => {
      if (isStudyFile(file)) return false;
      this.record.read(file);
      this.record.root.scrollIntoView({ block: "nearest" });
      return true;
    });
  }

  /** Remove its listeners. */
  close() {
    for (const name of ["pointerup", "pointercancel"]) removeEventListener(name, this.release);
  }

  /** Show the values; rebuild the rows where the parameters have changed. */
  update() {
    const { study } = this.store.value;
    const groups = parametersOf(study);
    const shape = JSON.stringify(groups.map((group) => [group.title, group.rows.map((it) => [it.path, it.label])])) + sides(study) + kinds(study);
    if (shape !== this.shape) {
      this.shape = shape;
      this.#build(groups);
    }
    this.select.value = modelOf(study);
    const ranges = this.store.value.ranges ?? {};
    for (const row of this.rows.values()) row.show(valueOf(study, row.path), this.ranges === ranges ? undefined : (ranges[row.path] ?? row.home));
    this.ranges = ranges;
  }

  /** The server has accepted a study: its values may widen the sliders. */
  accept(study) {
    for (const row of this.rows.values()) row.accept(valueOf(study, row.path));
  }

  /** Show faults beside their fields; return those that belong to none. */
  showFaults(faults) {
    return showFaults(this.rows, faults);
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
    if (group.record) body.append(this.#ofRecord(study, change));
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

  /** What a record is, and what acts beyond it. */
  #ofRecord(study, change) {
    const record = study().forcing.record;
    const set = (parts) => change(withRecord(study(), { ...study().forcing.record, ...parts }));
    const { t = [], kind = "linear", repeat = false, outside = "end" } = record;
    return element(
      "div",
      { class: "tools" },
      element("span", { class: "hint" }, `${t.length} samples from t = ${t[0]} to ${t.at(-1)}`),
      choiceField("between them", [["linear", "linear"], ["hold", "held"]], kind, (value) => set({ kind: value })),
      checkField("repeated", repeat, (isOn) => set({ repeat: isOn })),
      repeat ? null : choiceField("outside", [["end", "its end values"], ["zero", "nothing"]], outside, (value) => set({ outside: value })),
      button("remove", () => change(withoutRecord(study()))),
    );
  }

  /** A field for the name of a new parameter, of which numbers can be expressions. */
  #newParameter(study, change) {
    const message = element("p", { class: "fault", role: "alert" });
    const name = element("input", { type: "text", class: "name", placeholder: "name", "aria-label": "name of a new parameter", spellcheck: "false", autocomplete: "off" });
    const add = () => {
      const given = name.value.trim();
      message.textContent = nameFault(study(), given);
      if (message.textContent === "") change({ ...study(), parameters: { ...study().parameters, [given]: 1 } });
    };
    name.addEventListener("keydown", (event) => {
      if (event.key !== "Enter") return;
      event.preventDefault();
      add();
    });
    const hint = "then write numbers as expressions of it, such as 0.15*w**2";
    return element("div", { class: "tools" }, name, button("add a parameter", add, { title: hint }), message);
  }

  #setRange(path, range) {
    const { [path]: _, ...rest } = this.store.value.ranges ?? {};
    this.store.set({ ranges: range === null ? rest : { ...rest, [path]: range } }, "ranges");
  }

  #adders(title, study, change) {
    const tools = element("div", { class: "tools" });
    const add = (path, made) => change(put(study(), path, [...(get(study(), path) ?? []), made]));
    if (title === "Forcing") {
      tools.append(button("add a harmonic", () => add("forcing.harmonics", newHarmonic())));
      tools.append(button("add a record", () => this.record.open(), { title: "a table of instants and forces, as a file with commas; or drop it here" }));
      return element("div", {}, tools, this.record.root, this.#newParameter(study, change));
    } else {
      tools.append(button("add a wall", () => add("oscillator.stops", newStop("wall"))));
      tools.append(button("add a soft stop", () => add("oscillator.stops", newStop("soft"))));
      const { mass } = study().oscillator;
      if (mass === undefined) tools.append(button("give it a mass", () => change(withMass(study())), { title: "m, c and k in place of a unit mass; the motion stays" }));
      return element("div", {}, tools, this.#units(study, change));
    }
  }

  /** Fields for the names of units; of mass where there is one. */
  #units(study, change) {
    const { mass, units = {} } = study().oscillator;
    const field = (quantity) => {
      const own = units[quantity] ?? "";
      const names = UNITS[quantity].includes(own) || own === "" ? UNITS[quantity] : [own, ...UNITS[quantity]];
      const choice = choiceField(quantity, [["", "–"], ...names.map((name) => [name, name])], own, (name) => change(withUnit(study(), quantity, name)));
      choice.title = `unit of ${quantity}`;
      return choice;
    };
    const quantities = ["length", "time", ...(mass === undefined ? [] : ["mass"])];
    return element("div", { class: "tools units", role: "group", "aria-label": "units" }, element("span", { class: "hint" }, "units"), ...quantities.map(field));
  }
}

function kinds({ forcing }) {
  const { kind, repeat, outside, t } = forcing?.record ?? {};
  return [kind, repeat, outside, t?.length].join();
}

function sides(study) {
  return (study.oscillator.stops ?? []).map((stop) => stop.side + stop.type).join();
}

function without(study, path, index) {
  return put(study, path, get(study, path).filter((_, i) => i !== index));
}
