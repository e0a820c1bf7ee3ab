// A record and the parameters fitted to it.

import { button, element, fileField, fillTable, isStudyFile, say, textOf, watchDrops, wordsOf } from "./dom.js";
import { count } from "./facts.js";
import { checkField, choiceField, numberField } from "./fields.js";
import { axesOf, named, startAt, unitsOf } from "./models.js";
import { Plot } from "./plots.js";
import { SearchView } from "./search_view.js";
import { isTable, put } from "./state.js";

const HINT = "A table with a column t (or time) and one of displacement (x), velocity (v), acceleration (a), stop_force or impact_times, as loggers write it: commas, semicolons or tabs; units such as Time (ms) are converted into those of the model. Tick what is not known: its slider is the guess, or give a range in which it is looked for.";
const COLOURS = { samples: "--faint", fit: "--curve", impacts: "--orbit" };
const COLUMNS = { t: "instants", noise: "noise of each value" };
// Of a table, in a link: longer ones are loaded anew.
const MOST_LINKED = 56_000;

export class Fit extends SearchView {
  constructor(app) {
    super(app, { title: "Fit", verb: "Fit", hasGuesses: true });
    // The table that is loaded, and whether its columns are a record.
    this.table = { name: "", csv: "" };
    this.columns = null;
    this.isRecord = false;
    this.noise = null;
    this.isStarted = false;
    this.quantity = "";
    this.choice = element("div", { class: "tools", hidden: true });
    this.file = fileField("table of measurements", (file) => this.#read(file));
    this.told = element("p", { class: "hint", role: "status" });
    this.chooser = element("details", { class: "columns", hidden: true });
    this.fault = element("p", { class: "fault", role: "alert" });
    this.take = button("put into the sliders", () => this.#take(), { hidden: true, title: "the fitted values and the start of the record become those of Explore" });
    this.job.root.append(this.take);
    this.#plots();
    this.place(HINT, this.choice);
    this.restore(app.store.value);
    watchDrops(this.root, (file) => {
      if (isStudyFile(file)) return false;
      this.#read(file);
      return true;
    });
  }

  isOfStart({ start } = { start: this.isStarted }) {
    return start;
  }

  #plots() {
    this.record = new Plot({ title: "Record", x: "time t", y: "", kind: "line", names: ["t", "sample"], about: "squares: samples; line: the fitted motion", onZoom: (zoom) => this.#follow(zoom) });
    this.impacts = new Plot({ title: "Impacts of the fit", x: "time t", y: "", kind: "points", names: ["t", "speed"], isFollower: true, about: "impacts and entries into soft stops of the fitted motion" });
    this.residuals = new Plot({ title: "Residuals", x: "time t", y: "residual (σ)", kind: "points", names: ["t", "residual"], isFollower: true, about: "sample less fit, in standard deviations of the noise; two thirds of them lie between -1 and 1" });
    this.record.root.classList.add("broad");
    this.plots = [this.record, this.impacts, this.residuals];
  }

  #wait() {
    for (const plot of this.plots) plot.wait(plot === this.record ? "load a record, or drop a file here" : "", { x: [0, 1], y: [0, 1] });
  }

  /** Another motion: what is fitted belongs to the one before; the record stays. */
  begin() {
    this.job.clear();
    this.kept = null;
    this.free.clear();
    this.forget();
  }

  /** Take the form of a link; its record is read when the view is shown. */
  restore({ fit }) {
    if (JSON.stringify(fit) === this.kept) return;
    this.kept = JSON.stringify(fit);
    const { csv, name, columns, noise, start, free } = isTable(fit) ? fit : {};
    this.table = { name: String(name ?? ""), csv: typeof csv === "string" ? csv : "" };
    this.columns = isTable(columns) ? columns : null;
    this.isRecord = false;
    this.isDue = this.table.csv !== "";
    this.noise = Number.isFinite(noise) ? noise : null;
    this.isStarted = start === true;
    this.free.restore(free);
    this.told.textContent = this.fault.textContent = "";
    this.chooser.hidden = true;
    this.forget();
    this.#wait();
    this.#fields();
  }

  /** Keep in the link what is set, and the record if it is not too long. */
  keep() {
    const { name, csv } = this.table;
    const record = csv.length <= MOST_LINKED && csv !== "" ? { name, csv, columns: this.columns } : {};
    const fit = { ...record, free: this.free.free, noise: this.noise, start: this.isStarted };
    this.kept = JSON.stringify(fit);
    this.app.store.set({ fit }, "fit");
  }

  shown() {
    super.shown();
    if (this.isDue && this.app.isOpen) this.#measure();
  }

  /** The request whose files are offered: of the fit that is shown, or of what is set. */
  request() {
    return this.isRecord ? (this.current ?? this.requested()) : null;
  }

  requested() {
    const { study } = this.app.store.value;
    const csv = this.isRecord ? this.table.csv : "";
    return { kind: "fit", study, csv, columns: this.columns, free: this.free.value, noise: this.noise, start: this.isStarted };
  }

  #fields() {
    const load = button("Load a record", () => this.file.click(), { title: "a table of measurements, as a file; or drop it here" });
    const noise = numberField("noise (empty: estimated)", this.noise ?? "", (value) => {
      this.noise = value;
      this.keep();
    }, { min: 1e-300, mayBeEmpty: true });
    const start = checkField("start as in Explore", this.isStarted, (isOn) => {
      this.isStarted = isOn;
      this.changed();
      this.keep();
    });
    start.title = "the start of the record is known; else it is unknown, too";
    this.free.build();
    this.form.replaceChildren(element("div", { class: "tools" }, load, this.file, this.told, noise, start), this.chooser, this.fault, this.free.root);
  }

  async #read(file) {
    this.job.clear();
    this.forget();
    this.isRecord = false;
    this.told.textContent = `reading ${file.name} …`;
    this.table = { name: file.name, csv: await textOf(file) };
    this.columns = null;
    this.#measure();
  }

  /** Ask the server what is in the columns of the table. */
  #measure() {
    this.isDue = false;
    const { name, csv } = this.table;
    const complain = (reason) => {
      this.isRecord = false;
      this.told.textContent = "";
      this.fault.textContent = `${name}: ${reason}`;
    };
    this.app.requests.put("measured", { kind: "measured", study: this.app.store.value.study, csv, columns: this.columns }, {
      answer: (header, arrays) => {
        this.#choose(header);
        if (header.fault) return complain(header.fault);
        this.isRecord = true;
        this.columns = header.columns;
        this.told.textContent = `${name}: ${count(header.n, "value")} of ${header.quantities.map(wordsOf).join(", ")}${csv.length > MOST_LINKED ? "; too long for a link" : ""}`;
        this.fault.textContent = "";
        this.keep();
        this.#draw(header, arrays);
      },
      fault: (faults) => {
        this.chooser.hidden = true;
        complain(faults.map(({ reason }) => reason).join("; "));
      },
    });
  }

  /** Offer the columns of the table for each quantity that they may hold. */
  #choose({ titles, columns, fault }) {
    const choices = [["", "none"], ...titles.map((title) => [title, title])];
    const choice = (quantity) => choiceField(COLUMNS[quantity] ?? wordsOf(quantity), choices, columns[quantity], (title) => {
      this.forget();
      // What was chosen while an answer was under way counts, too.
      this.columns = { ...columns, ...this.columns, [quantity]: title };
      this.#measure();
    });
    this.chooser.hidden = false;
    if (fault) this.chooser.open = true;
    this.chooser.replaceChildren(element("summary", {}, "Columns of the table"), element("div", { class: "tools" }, ...Object.keys(columns).map(choice)));
  }

  forget() {
    super.forget();
    this.take.hidden = true;
    this.fault.textContent = "";
  }

  receive(header, arrays) {
    this.header = header;
    const { values, notes, converged, reason, n_runs: runs } = header;
    this.verdict.textContent = converged ? `Converged in ${count(runs, "run")}.` : `Not converged: ${reason}. These are the best values found.`;
    const labels = this.paths().map((it) => [it.path, it.name]);
    const labelled = (text) => labels.reduce((now, [path, name]) => now.replaceAll(path, name), text);
    const rows = [...values.map(({ path, text }) => [path, text]), ...notes];
    fillTable(this.result, [], rows.map((row) => row.map(labelled)), (k) => ({ "data-fitted": values[k]?.path }));
    this.take.hidden = false;
    this.#draw(header, arrays);
  }

  /** Draw the chosen quantity of a record, the first at first, and of a fit what belongs to it. */
  #draw(header, arrays) {
    const { quantities } = header;
    if (!quantities.includes(this.quantity)) this.quantity = quantities[0];
    const choices = quantities.map((name) => [name, wordsOf(name)]);
    this.choice.hidden = quantities.length < 2;
    this.choice.replaceChildren(
      choiceField("drawn", choices, this.quantity, (name) => {
        this.quantity = name;
        this.#draw(header, arrays);
      }),
    );
    this.#drawOne(quantities.indexOf(this.quantity), arrays);
  }

  #drawOne(at, arrays) {
    const { study } = this.app.store.value;
    const name = this.quantity;
    const [t, y, curveT, curveY, residual] = ["t", "y", "curve_t", "curve", "residual"].map((of) => arrays[`${of}${at}`]);
    const axes = axesOf(study);
    const { time, length } = unitsOf(study);
    const labels = { displacement: axes.x, velocity: axes.v, acceleration: named("acceleration", length && time ? `${length}/${time}²` : ""), impact_times: named("flight before each impact", time) };
    const ofFlights = (values) => values.slice(1).map((value, k) => value - values[k]);
    const isTimes = name === "impact_times";
    const curve = (t, y) => ({ x: isTimes ? t.slice(1) : t, y: isTimes ? ofFlights(y) : y });
    const layers = [{ ...curve(t, y), kind: "points", colour: COLOURS.samples, size: 3 }];
    if (curveY) layers.push({ ...curve(curveT, curveY), kind: "line", colour: COLOURS.fit });
    this.record.label(axes.t, labels[name] ?? axes.force);
    this.impacts.label(axes.t, axes.speed);
    this.residuals.label(axes.t, `residual of ${wordsOf(name)} (σ)`);
    for (const plot of this.plots) plot.take(null);
    this.record.show(layers);
    this.root.dataset.quantity = name;
    const all = { x: this.record.home.x, y: [0, 1] };
    if (!curveY) {
      for (const plot of [this.impacts, this.residuals]) plot.wait("Fit shows them", all);
      return;
    }
    const { impact_t: hits, impact_v: speeds } = arrays;
    if (hits.length > 0) this.impacts.show([{ x: hits, y: speeds, kind: "points", colour: COLOURS.impacts, size: 5 }], [], { x: all.x, y: [0, 1.1 * Math.max(...speeds)] });
    else this.impacts.wait("none", all);
    const size = 1.1 * residual.reduce((most, value) => Math.max(most, Math.abs(value)), 1.5);
    this.residuals.show([{ x: t, y: residual, kind: "points", colour: COLOURS.samples, size: 3 }], [{ y: -1, colour: COLOURS.fit }, { y: 1, colour: COLOURS.fit }], { x: all.x, y: [-size, size] });
  }

  /** The other plots show the same time. */
  #follow(zoom) {
    for (const plot of [this.impacts, this.residuals]) {
      if (zoom === null) plot.reset();
      else plot.setZoom(zoom.x, plot.home.y);
    }
  }

  /** The fitted values, and the state at the first sample, become those of the motion. */
  #take() {
    let { study } = this.current;
    for (const { path, value, error } of this.header.values) {
      // Three digits more than its error.
      const digits = error > 0 ? Math.ceil(Math.log10(Math.abs(value) / error)) + 3 : 8;
      study = put(study, path, String(Number(value.toPrecision(Math.min(15, Math.max(4, digits || 4))))));
    }
    const [x, v, t0] = this.header.start;
    const own = Object.keys(this.current.free).some((path) => path.startsWith("start."));
    if (!this.current.start) study = { ...study, start: { ...study.start, ...startAt(study, x, v, t0) } };
    if (!this.current.start || own || this.current.study !== study) this.app.store.set({ study }, "study");
    say(this.app.root, "the fitted values are in Explore");
  }
}
