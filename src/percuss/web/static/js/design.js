// The setting of free parameters at which an outcome is best, and the front between two outcomes.

import { button, element, fillTable, say, shown, wordsOf } from "./dom.js";
import { choiceField, numberField } from "./fields.js";
import { axesOf, pathsOf, startAt } from "./models.js";
import { MOTION, PORTRAIT, Plot } from "./plots.js";
import { SearchView } from "./search_view.js";
import { isTable, put, settingsOf } from "./state.js";

const HINT = "Tick what may change and give its range; choose what shall be best, and keep other outcomes within limits. SciPy's SLSQP searches with exact derivatives, from the setting of Explore and from others in the ranges. Two outcomes give a front: designs of which neither can be better without the other being worse.";
const GOALS = [["least", "least"], ["largest", "largest"], ["wanted", "a value"]];
const DEFAULTS = { outcome: "peak_impact_velocity", goal: "least", wanted: 1, second: "", secondGoal: "least", on: "orbit", restarts: 2, n: 8 };
const MOTIONS = [["orbit", "orbits that attract"], ["run", "the motion of Explore"]];

export class Design extends SearchView {
  constructor(app) {
    super(app, { title: "Design", verb: "Search", hasGuesses: false });
    this.outcomes = app.options.facts.outcomes ?? { orbit: [], run: [] };
    this.#plots();
    this.place(HINT);
    this.restore(app.store.value);
  }

  /** The start plays a part in a motion alone. */
  isOfStart({ on } = this.settings) {
    return on === "run";
  }

  #plots() {
    this.front = new Plot({ title: "Front", x: "", y: "", kind: "points", names: ["first outcome", "second outcome"], about: "the designs of the front, the second outcome over the first" });
    this.motion = new Plot({ ...MOTION, title: "Motion at the best setting", about: "of an orbit one period; of a front its first design" });
    this.portrait = new Plot({ ...PORTRAIT, about: "velocity over displacement" });
    this.front.root.classList.add("broad");
    this.front.root.hidden = true;
    this.plots = [this.front, this.motion, this.portrait];
  }

  /** Another motion: what was found belongs to the one before. */
  begin(state) {
    this.job.clear();
    this.kept = null;
    this.restore(state);
  }

  /** Take the form of a link. */
  restore({ design }) {
    if (JSON.stringify(design) === this.kept) return;
    this.kept = JSON.stringify(design);
    this.settings = settingsOf(DEFAULTS, design);
    // Those of other outcomes: {outcome, low, high}, null for none.
    this.limits = (isTable(design) && Array.isArray(design.limits) ? design.limits : []).filter(isTable);
    this.free.restore(design?.free);
    this.forget();
    this.front.root.hidden = true;
    for (const plot of this.plots) plot.wait("Search shows it", { x: [0, 1], y: [0, 1] });
    this.#check();
    this.#fields();
  }

  /** Keep in the link what is set. */
  keep() {
    const design = { ...this.settings, free: this.free.free, limits: this.limits };
    this.kept = JSON.stringify(design);
    this.app.store.set({ design }, "design");
  }

  /** The request whose files are offered: of the design that is shown, or of what is set. */
  request() {
    return Object.keys(this.free.value).length === 0 ? null : (this.current ?? this.requested());
  }

  requested() {
    const { outcome, goal, wanted, second, secondGoal, on, restarts, n } = this.settings;
    const isFront = second !== "";
    const limits = Object.fromEntries(this.limits.map((it) => [it.outcome, [it.low, it.high]]));
    return {
      kind: "design", study: this.app.store.value.study, free: this.free.value, limits, on, restarts,
      outcomes: isFront ? [outcome, second] : [outcome],
      goals: isFront ? [goal, secondGoal] : [goal === "wanted" ? wanted : goal],
      ...(isFront && { n }),
    };
  }

  #set(parts) {
    Object.assign(this.settings, parts);
    this.#check();
    this.#fields();
    this.keep();
  }

  /** Set what no other field depends on. */
  #put(parts) {
    Object.assign(this.settings, parts);
    this.keep();
  }

  /** Leave out what does not belong together. */
  #check() {
    if (!(this.settings.on in this.outcomes)) this.settings.on = "orbit";
    const names = this.outcomes[this.settings.on];
    if (!names.includes(this.settings.outcome)) this.settings.outcome = "peak_impact_velocity";
    if (!names.includes(this.settings.second) || this.settings.second === this.settings.outcome) this.settings.second = "";
    // A front is between what is least or largest.
    if (this.settings.second !== "" && this.settings.goal === "wanted") this.settings.goal = "least";
    this.limits = this.limits.filter((it) => names.includes(it.outcome));
  }

  #fields() {
    const { outcome, goal, wanted, second, secondGoal, on, restarts, n } = this.settings;
    const isFront = second !== "";
    const names = this.outcomes[on].map((name) => [name, wordsOf(name)]);
    const ends = GOALS.slice(0, isFront ? 2 : 3);
    this.free.build();
    this.form.replaceChildren(
      choiceField("outcome", names, outcome, (name) => this.#set({ outcome: name })),
      choiceField("goal", ends, goal, (name) => this.#set({ goal: name })),
      ...(goal === "wanted" ? [numberField("value", wanted, (value) => this.#put({ wanted: value }))] : []),
      choiceField("against", [["", "no other outcome"], ...names.filter(([name]) => name !== outcome)], second, (name) => this.#set({ second: name })),
      ...(isFront
        ? [choiceField("its goal", ends, secondGoal, (name) => this.#set({ secondGoal: name })), numberField("designs", n, (value) => this.#put({ n: value }), { min: 2, max: 24, step: 1 })]
        : []),
      choiceField("of", MOTIONS, on, (name) => this.#set({ on: name })),
      numberField("restarts", restarts, (value) => this.#put({ restarts: value }), { min: 0, max: 16, step: 1 }),
      element("div", { class: "free limits" }, ...this.limits.map((it) => this.#limit(it, names))),
      element("div", { class: "tools" }, button("add a limit", () => this.#addLimit(), { title: "the least and the largest value of another outcome" })),
      this.free.root,
    );
  }

  #addLimit() {
    const taken = new Set(this.limits.map((it) => it.outcome));
    const outcome = this.outcomes[this.settings.on].find((name) => !taken.has(name) && name !== this.settings.outcome);
    if (outcome === undefined || this.limits.length === 8) return;
    this.limits = [...this.limits, { outcome, low: null, high: null }];
    this.#set({});
  }

  /** The limits of one outcome. */
  #limit(it, names) {
    const others = new Set(this.limits.filter((other) => other !== it).map((other) => other.outcome));
    const choice = choiceField("limit of", names.filter(([name]) => !others.has(name)), it.outcome, (name) => {
      it.outcome = name;
      this.#set({});
    });
    const end = (name, label) => numberField(label, it[name] ?? "", (value) => {
      it[name] = value;
      this.keep();
    }, { mayBeEmpty: true });
    const label = `limit of ${wordsOf(it.outcome)}`;
    const remove = button("remove", () => {
      this.limits = this.limits.filter((other) => other !== it);
      this.#set({});
    }, { "aria-label": `remove the ${label}` });
    return element("div", { role: "group", "aria-label": label }, element("span", { class: "ends" }, choice, end("low", "at least"), end("high", "at most"), remove));
  }

  receive(header, arrays) {
    const { designs, outcomes, report, told } = header;
    const isFront = outcomes.length > 1;
    const labels = new Map(pathsOf(this.current.study).map((it) => [it.path, it.name]));
    const labelOf = (name) => labels.get(name) ?? wordsOf(name);
    this.verdict.textContent = told;
    const take = (design) => button("put into the sliders", () => this.#take(design), { title: "these values, and the start of the orbit, become those of Explore" });
    const paths = Object.keys(designs[0].values);
    const head = isFront ? [...[...outcomes, ...paths].map(labelOf), ""] : [];
    const rows = isFront
      ? designs.map((it) => [...it.outcomes.map((value) => shown(value, 6)), ...paths.map((path) => shown(it.values[path], 6)), take(it)])
      : [...report.map(([name, text]) => [labelOf(name), text.replaceAll("_", " ")]), ["", take(designs[0])]];
    fillTable(this.result, head, rows);
    this.#draw(isFront ? header : null, arrays);
  }

  #draw(front, { t, x, portrait_x: px, portrait_v: pv }) {
    const { study } = this.current;
    const axes = axesOf(study);
    this.front.root.hidden = front === null;
    if (front !== null) {
      const column = (k) => Float64Array.from(front.designs, (it) => it.outcomes[k]);
      this.front.label(...front.outcomes);
      this.front.take(null);
      this.front.show([{ x: column(0), y: column(1), kind: "points", colour: "--curve", size: 6 }]);
    }
    this.motion.label(axes.t, axes.x);
    this.portrait.label(axes.x, axes.v);
    for (const plot of [this.motion, this.portrait]) plot.take(null);
    this.motion.show([{ x: t, y: x, colour: "--curve" }]);
    this.portrait.show([{ x: px, y: pv, colour: "--curve" }]);
  }

  /** The values of a design, and where its orbit starts, become those of the motion. */
  #take({ values, start: [x, v, t0] }) {
    let { study } = this.current;
    for (const [path, value] of Object.entries(values)) study = put(study, path, String(Number(value.toPrecision(10))));
    if (this.current.on === "orbit") study = { ...study, start: { ...study.start, ...startAt(study, x, v, t0) } };
    this.app.store.set({ study }, "study");
    say(this.app.root, "the design is in Explore");
  }
}
