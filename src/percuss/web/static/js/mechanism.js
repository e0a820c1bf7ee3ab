// A structure of several masses: its mechanical picture, motions, a portrait, impacts and forces.

import { element, form, shown } from "./dom.js";
import { OUTCOMES, card, count, hits, multipliersText, unitCircle } from "./facts.js";
import { choiceField } from "./fields.js";
import { COMPACT, MASS_COLOURS, MechanismPicture, STOP_COLOURS } from "./mechanism_picture.js";
import { Player } from "./player.js";
import { PORTRAIT, Plot } from "./plots.js";
import { Row, showFaults } from "./row.js";
import { between, bisect, endsOf } from "./scales.js";
import { FORCES, IMPACTS, isOne, legend, ofStop, showForces, stopName } from "./stop_forces.js";

const POINTS = 4000, RESTED = 250, COMPILING = 1500, NARROW = 480;
// More impacts than these are not marked on the curves, which they would hide.
const MARKED = 40;

/** Build the view when it is first seen. */
export class Mechanism {
  constructor(app) {
    this.app = app;
    this.store = app.store;
    this.kinds = app.options.facts.mechanisms;
    this.plots = [];
    this.curve = null;
    this.window = null;
    this.root = element("section", { class: "structure", "aria-label": "Structure" });
    this.store.watch((_, why) => {
      if (this.panel === undefined) return;
      if (why === "mechanism" || why === "all") this.#changed();
      else if (why === "of") this.#draw();
    });
  }

  /** What is set: {name, kind, values, of}, of known kinds. */
  get state() {
    const { name, values, of } = this.store.value.mechanism ?? {};
    const kind = this.kinds.find((it) => it.name === name) ?? this.kinds[0];
    const kept = kind.rows.filter(({ path }) => ["string", "number"].includes(typeof values?.[path]));
    return { name: kind.name, kind, values: Object.fromEntries(kept.map(({ path }) => [path, values[path]])), of: String(of ?? "") };
  }

  #set(parts, why = "mechanism") {
    const { name, values, of } = this.state;
    this.store.set({ mechanism: { name, values, of, ...parts } }, why);
  }

  /** The request whose script is copied. */
  request() {
    const { name, values } = this.state;
    return { kind: "mechanism", name, values };
  }

  /** The view is seen. */
  shown() {
    if (this.panel === undefined) {
      this.#build();
      this.ask();
    } else if (this.isDue) this.ask();
  }

  /** The connection is there, or there again. */
  connected() {
    if (this.panel !== undefined) this.ask();
  }

  close() {
    this.player?.close();
    clearTimeout(this.resting);
    clearTimeout(this.starting);
  }

  #build() {
    this.picture = new MechanismPicture();
    this.player = new Player((time) => this.#show(time));
    this.#plots();
    this.#cards();
    this.panel = form("panel", "Parameters of the structure");
    this.general = element("p", { class: "fault", role: "alert" });
    const drawing = element(
      "figure", { class: "plot drawing" },
      element("figcaption", {}, element("strong", {}, "Structure"), this.player.readout), this.picture.svg, this.player.root,
    );
    this.root.replaceChildren(
      element("aside", {}, this.panel),
      element("div", { class: "stage" }, this.general, this.summary, this.facts, element("div", { class: "plots" }, drawing, ...this.plots.map((plot) => plot.root))),
    );
    this.#fill();
  }

  #plots() {
    this.motion = new Plot({
      title: "Displacements", x: "time t", y: "displacement x", kind: "line", names: ["t", "x1"],
      about: "of each mass; squares: impacts and entries into soft stops, where there are few",
      onZoom: (zoom) => {
        this.window = zoom === null ? null : zoom.x;
        this.ask();
      },
      onHover: (index) => this.#hover(index === null ? null : this.curve?.t[index]),
    });
    this.portrait = new Plot({
      ...PORTRAIT, about: "of a mass, or of the distance of two",
      onHover: (index) => this.#hover(index === null ? null : this.curve?.portrait_t[index]),
    });
    this.section = new Plot({
      ...IMPACTS,
      about: "each impact or entry: when in the forcing period, and how fast the masses meet",
    });
    this.forces = new Plot({ ...FORCES });
    this.plots = [this.motion, this.portrait, this.section, this.forces];
  }

  #cards() {
    this.outcome = card("Outcome", "how the run ended");
    this.stops = card("Stops", "how often each is met, and its largest impulse or force");
    this.orbit = card("Periodic orbit", "what the motion settles to within 200 periods");
    this.energy = card("Mean power", "over the last 20 periods, or what Displacements shows");
    this.facts = element("dl", { class: "facts" }, ...[this.outcome, this.stops, this.orbit, this.energy].map((it) => it.root));
    this.summary = element("p", { class: "summary", "aria-hidden": "true" });
  }

  /** Fill the panel with the sliders of the kind, and the picture with its masses. */
  #fill() {
    const { kind, of } = this.state;
    this.shape = kind.name;
    this.curve = this.known = null;
    this.window = null;
    for (const plot of this.plots) plot.take(null);
    this.rows = new Map();
    const choice = choiceField("Preset", this.kinds.map(({ name, title }) => [name, title]), kind.name, (name) => this.#set({ name, values: {}, of: "" }));
    choice.className = "model";
    const groups = new Map();
    for (const spec of kind.rows) {
      if (!groups.has(spec.group)) groups.set(spec.group, element("fieldset", {}, element("legend", {}, spec.group)));
      const row = new Row(spec, {
        prefix: `${this.app.prefix}-structure`,
        set: (value) => this.#set({ values: { ...this.state.values, [spec.path]: value } }),
        setRange: (range) => row.show(this.#value(spec), range ?? spec.range),
      });
      row.show(this.#value(spec), spec.range);
      this.rows.set(spec.path, row);
      groups.get(spec.group).append(row.root);
    }
    // The choice keeps the focus where the keys have changed it.
    const isFocused = this.panel.contains(document.activeElement);
    this.panel.replaceChildren(choice, element("p", { class: "hint" }, kind.caption), ...groups.values());
    if (isFocused) choice.select.focus();
    this.directions = directionsOf(kind.elements.n);
    this.of = choiceField("of", this.directions.map((it) => [it.key, it.name]), of || this.directions[0].key, (key) => this.#set({ of: key }, "of"));
    this.of.className = "of";
    this.of.select.setAttribute("aria-label", "phase portrait of");
    this.portrait.root.querySelector(".of")?.remove();
    this.portrait.root.querySelector("figcaption strong").after(this.of);
    this.picture.take(kind.elements, 0);
    this.picture.draw(Array(kind.elements.n).fill(0));
    this.player.take(0, 0, null);
  }

  #value({ path, value }) {
    return this.state.values[path] ?? value;
  }

  #changed() {
    const { kind } = this.state;
    if (this.shape !== kind.name) this.#fill();
    for (const spec of kind.rows) this.rows.get(spec.path).show(this.#value(spec));
    this.isDue = this.store.value.view !== "structure";
    if (!this.isDue) this.ask();
  }

  /** Request the motion as it is set now. */
  ask() {
    this.isDue = false;
    const message = { ...this.request(), points: POINTS, window: this.window };
    const asked = keyOf(message);
    clearTimeout(this.starting);
    if (this.curve === null) this.starting = setTimeout(() => this.outcome.show("starting", "the first structure compiles the engine; up to a minute, once"), COMPILING);
    this.app.requests.put("mechanism", message, {
      answer: (header, arrays) => this.#take(asked, header, arrays),
      fault: (faults) => this.#faults(faults),
    });
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.#askOrbit(message, asked), RESTED);
  }

  #askOrbit(message, asked) {
    this.app.requests.put("mechanism_facts", { ...message, kind: "mechanism_facts" }, {
      answer: (header, arrays) => {
        if (asked !== keyOf(this.request())) return;
        this.known = { ...header, arrays, asked };
        if (this.asked === asked) this.#draw();
      },
      // The fault of the motion says what is wrong.
      fault: () => {},
    });
  }

  #faults(faults) {
    clearTimeout(this.starting);
    this.general.textContent = showFaults(this.rows, faults).join("; ");
    this.root.classList.toggle("stale", faults.length > 0);
    if (faults.length > 0 && this.curve === null) this.outcome.show("no motion", "");
  }

  #take(asked, header, arrays) {
    const { name, kind } = this.state;
    if (JSON.parse(asked)[0] !== name) return;
    this.#faults([]);
    for (const spec of kind.rows) this.rows.get(spec.path).accept(this.#value(spec));
    Object.assign(this, { header, asked, curve: arrays });
    let largest = 0;
    for (let i = 0; i < kind.elements.n; i += 1) for (const value of arrays[`x${i}`]) if (Number.isFinite(value)) largest = Math.max(largest, Math.abs(value));
    this.picture.take(header.elements, largest, this.picture.svg.clientWidth < NARROW ? COMPACT : undefined);
    this.#draw();
    this.player.take(arrays.t[0], arrays.t.at(-1), header.period);
    this.player.clicks.take(arrays.event_t, arrays.speed);
    this.root.dataset.drawn = String(performance.now());
  }

  #draw() {
    if (this.curve === null) return;
    const { of } = this.state;
    this.chosen = this.directions.find((it) => it.key === of) ?? this.directions[0];
    this.of.select.value = this.chosen.key;
    this.#drawMotion();
    this.#drawPortrait();
    this.#drawEvents();
    this.#drawForces();
    this.#showFacts();
    this.#showOrbit();
  }

  #drawMotion() {
    const { curve } = this;
    const { n, stops } = this.header.elements;
    const masses = Array.from({ length: n }, (_, i) => ({ x: curve.t, y: curve[`x${i}`], colour: MASS_COLOURS[i] }));
    const lines = stops.map((stop, k) => ({ stop, colour: STOP_COLOURS[k] })).filter(({ stop }) => isOne(stop.on));
    legend(this.motion, masses.map(({ colour }, i) => [`x${i + 1}`, colour]));
    this.motion.show([...masses, ...this.#eventMarks(n, stops)], lines.map(({ stop, colour }) => ({ y: stop.at / stop.on.find((part) => part !== 0), colour })));
  }

  /** Impacts and entries as squares on the curves of the masses that meet. */
  #eventMarks(n, stops) {
    const { curve } = this;
    const [low, high] = [curve.t[0], curve.t.at(-1)];
    if (curve.event_t.filter((t) => t >= low && t <= high).length > MARKED) return [];
    return Array.from({ length: n }, (_, i) => {
      const times = curve.event_t.filter((t, k) => t >= low && t <= high && stops[curve.event_stop[k]].on[i] !== 0);
      return { kind: "points", x: times, y: times.map((t) => curve[`x${i}`][bisect(curve.t, t)]), colour: "--ink", size: 4 };
    });
  }

  #drawPortrait() {
    const { curve, chosen } = this;
    const layers = [{ x: along(curve, "portrait_x", chosen.on), y: along(curve, "portrait_v", chosen.on), colour: "--curve" }];
    const known = this.known?.asked === this.asked && this.known.orbit ? this.known.arrays : null;
    if (known) layers.push({ x: along(known, "orbit_x", chosen.on), y: along(known, "orbit_v", chosen.on), colour: "--orbit", width: 2, dash: [5, 4], isAside: true });
    const isPart = curve.portrait_t[0] > curve.t[0] + 1e-3;
    legend(this.portrait, [...(isPart ? [["its end", "--curve"]] : []), ...(known ? [["orbit", "--orbit"]] : [])]);
    this.portrait.label(chosen.name, `velocity of ${chosen.name}`);
    this.portrait.show(layers, this.#stopsAlong(chosen.on));
  }

  /** Stops that act along a direction, as lines at their places. */
  #stopsAlong(on) {
    return this.header.elements.stops.flatMap((stop, i) => {
      const k = on.findIndex((part) => part !== 0);
      const factor = stop.on[k] / on[k];
      const isAlong = factor !== 0 && on.every((part, m) => stop.on[m] === factor * part);
      return isAlong ? [{ x: stop.at / factor, colour: STOP_COLOURS[i] }] : [];
    });
  }

  #drawEvents() {
    const { curve } = this;
    const { stops } = this.header.elements;
    const size = curve.cycle.length < 200 ? 5 : 2.5;
    const dots = stops.map((_, k) => {
      const [x, y] = ofStop(curve, k, curve.cycle, curve.speed);
      return { kind: "points", x, y, colour: STOP_COLOURS[k], size };
    });
    const [, fastest] = endsOf(curve.speed);
    legend(this.section, stops.map((_, k) => [stopName(stops, k), STOP_COLOURS[k]]));
    this.section.show(dots, [], { x: [-0.015, 1.015], y: [0, fastest > 0 ? 1.08 * fastest : 1] });
    if (curve.cycle.length === 0) this.section.say("no stop is met");
  }

  #drawForces() {
    showForces(this.forces, this.curve, this.header.elements.stops, { t: "time t", force: "force", impulse: "impulse" });
  }

  #showFacts() {
    const { header } = this;
    const { stops } = header.elements;
    const events = header.stops.reduce((sum, it) => sum + it.n_impacts + it.n_entries, 0);
    const more = [count(header.n_contacts, "contact"), count(header.n_grazes, "graze"), `computed in ${shown(header.milliseconds, 2)} ms`];
    if (header.is_cut) more.push("the page follows a second of computing or 50,000 impacts");
    this.outcome.show(OUTCOMES[header.outcome] ?? header.outcome, more.join(", "));
    const rows = header.stops.map((it, k) => {
      const met = stops[k].type === "wall" ? count(it.n_impacts, "impact") : `${it.n_entries} ${it.n_entries === 1 ? "entry" : "entries"}`;
      const most = stops[k].type === "wall" ? `impulse ${shown(it.largest_impulse, 3)}` : `force ${shown(it.largest_force, 3)}`;
      return `${stopName(stops, k)}: ${met}, largest ${most}`;
    });
    this.events = this.#hits(events);
    this.stops.show(this.events, rows.join("; "));
    const { loads, impacts, dashpots } = header.energy;
    const parts = [`impacts take ${shown(impacts, 3)}`, `dashpots ${shown(dashpots, 3)}`];
    this.energy.show(loads === null ? "–" : `the force gives ${shown(loads, 3)}`, loads === null ? "" : parts.join(", "));
    this.summary.textContent = this.events;
  }

  /** Count impacts on walls and entries into soft stops together. */
  #hits(n) {
    const kinds = this.header.elements.stops.map(({ type }) => (type === "wall" ? "impact" : "entry"));
    return hits(n, [...new Set(kinds)]);
  }

  #showOrbit() {
    const isKnown = this.known?.asked === this.asked;
    this.orbit.root.classList.toggle("stale", !isKnown);
    if (!isKnown) {
      if (!this.known) this.orbit.show("…", "");
      return;
    }
    const { orbit } = this.known;
    if (orbit === null) {
      this.orbit.show("none found", "the motion does not repeat within 12 forcing periods after 200 of them");
      return;
    }
    const name = `(${orbit.n_impacts}, ${orbit.n_periods}) ${orbit.is_stable ? "stable" : "not stable"}`;
    const counts = `${this.#hits(orbit.n_impacts)} in ${count(orbit.n_periods, "forcing period")}`;
    this.orbit.show(name, `${counts}, T = ${shown(orbit.period)}; multipliers ${multipliersText(orbit.multipliers)}`, unitCircle(orbit.multipliers));
    this.summary.textContent = `${name}; ${this.events}`;
  }

  /** A time under the pointer is shown while it is there; then that of the player again. */
  #hover(time) {
    this.player.peek(time ?? null);
  }

  /** Move the picture to a time, and mark it in the other plots. */
  #show(time) {
    const { curve } = this;
    if (curve === null) return;
    const { n } = this.header.elements;
    const x = Array.from({ length: n }, (_, i) => between(curve.t, curve[`x${i}`], time));
    // A motion that grows beyond all numbers leaves the picture as it was.
    if (!x.every(Number.isFinite)) return;
    this.picture.draw(x);
    this.motion.point(time, x[0]);
    const times = curve.portrait_t;
    const isSeen = time >= times[0] && time <= times.at(-1);
    const index = isSeen ? bisect(times, time) : 0;
    this.portrait.point(isSeen ? at(curve, "portrait_x", this.chosen.on, index) : null, at(curve, "portrait_v", this.chosen.on, index));
  }
}

const keyOf = ({ name, values }) => JSON.stringify([name, values]);

/** Directions of the portrait: each distance of neighbours, then each mass. */
function directionsOf(n) {
  const unit = (i, minus) => Array.from({ length: n }, (_, k) => (k === i ? 1 : k === minus ? -1 : 0));
  const rows = [];
  for (let i = 1; i < n; i += 1) rows.push({ key: `${i}-${i - 1}`, name: `x${i + 1} − x${i}`, on: unit(i, i - 1) });
  for (let i = 0; i < n; i += 1) rows.push({ key: `${i}`, name: `x${i + 1}`, on: unit(i, -1) });
  return rows;
}

/** Return one value along a direction. */
const at = (arrays, name, on, i) => on.reduce((sum, part, m) => (part === 0 ? sum : sum + part * arrays[`${name}${m}`][i]), 0);

/** Return the curve along a direction. */
function along(arrays, name, on) {
  const k = on.findIndex((part) => part !== 0);
  return arrays[`${name}${k}`].map((_, i) => at(arrays, name, on, i));
}
