// A bifurcation diagram or a response chart over one parameter.

import { Beside } from "./beside.js";
import { familiesOf, nearestMark, nearestOrbit, orbitText } from "./chart.js";
import { element, say, shown } from "./dom.js";
import { checkField, checkRange, choiceField, numberField } from "./fields.js";
import { JobView } from "./job_view.js";
import { limitsOf, named, numberOf, pathsOf, startAt, unitsOf } from "./models.js";
import { sampledAt } from "./provenance.js";
import { digitsOf } from "./scales.js";
import { get, put } from "./state.js";

const KINDS = [
  ["diagram", "bifurcation diagram"],
  ["response", "response chart"],
];
const OF = {
  diagram: [["x", "displacement"], ["v", "velocity"]],
  response: [["amplitude", "amplitude"], ["speed", "impact speed"]],
};
const LABELS = { x: "x", v: "v", cycle: "cycle", v_after: "velocity after the impact", amplitude: "amplitude", speed: "largest impact speed" };
// Where points are taken, and what each has.
const SECTIONS = [["strobes", "whole periods"], ["cycle", "a cycle"], ["place", "a place"], ["impacts", "impacts"]];
const AT_SECTION = {
  strobes: OF.diagram,
  cycle: OF.diagram,
  place: [["v", "velocity"], ["cycle", "cycle"]],
  impacts: [["v_after", "velocity after"], ["cycle", "cycle"]],
};
const DIRECTIONS = [["up", "upwards"], ["down", "downwards"], ["both", "either way"]];
const ABOUT = {
  diagram: "Where the motion is once a forcing period after settling: one point is an orbit of one period, two of two, a cloud is chaos or a long transient.",
  cycle: "Where the motion is at that cycle of each forcing period after settling: one point is an orbit of one period, two of two, a cloud is chaos or a long transient.",
  place: "How fast the motion passes that place, and when, after settling: a few points are a periodic orbit, a cloud is chaos or a long transient.",
  impacts: "How the impacts are after settling: a few points are a periodic orbit, a cloud is chaos or a long transient.",
  response: "All periodic orbits that are found, stable solid and unstable dashed, (impacts, forcing periods); squares are bifurcations and grazes.",
};
const FOLLOWS = [["start", "the start of Explore"], ["forward", "the value before, upwards"], ["backward", "the value above, downwards"], ["both", "both, upwards and downwards"]];
// Values and points while a slider moves; all are computed once it has rested so long [ms].
const COARSE = { values: 256, points: 64 };
const RESTED = 400;
// Forcing periods before the motion beside a point that is no start of it.
const SETTLING = 60;
const DEFAULTS = { kind: "diagram", path: "", low: 1, high: 4, values: 1600, points: 128, of: "x", max_impacts: 3, max_periods: 2, follow: "start", section: "strobes", at: 0, direction: "up", cycle: 0, isLive: false, isComputed: false };

export class Diagram extends JobView {
  constructor(app) {
    super(app, { name: "diagram", title: "Diagram", defaults: DEFAULTS, x: "parameter", y: "x" });
    this.levels = [];
    this.job.mark = (fault) => this.#mark(fault);
    this.beside = new Beside(app);
    this.aside = element("aside", { hidden: true });
    this.sides = element("div", { class: "sides" });
    this.plot.root.replaceWith(this.sides);
    this.sides.append(this.aside, this.plot.root, this.beside.root);
    this.root.classList.add("diagram");
    this.restore(app.store.value);
  }

  recolour() {
    super.recolour();
    this.beside.recolour();
  }

  close() {
    clearTimeout(this.resting);
    super.close();
    this.beside.close();
  }

  shown() {
    this.#place();
    const isDue = super.shown();
    if (!isDue && this.isFollowing && !this.stale.hidden) this.#follow();
    return isDue;
  }

  /** Whether the diagram follows the sliders: it is one of points, computed once, and seen. */
  get isFollowing() {
    return this.settings.isLive && this.settings.kind === "diagram" && this.current?.kind === "diagram" && !this.root.hidden;
  }

  /** Put the parameters beside a diagram that follows them, when it is seen. */
  #place() {
    const { isLive, kind } = this.settings;
    this.aside.hidden = !(isLive && kind === "diagram");
    this.sides.classList.toggle("is-live", !this.aside.hidden);
    if (!this.root.hidden && !this.aside.hidden) this.aside.append(this.app.views.explore.panel.root);
  }

  /** Compute few points while a slider moves, one diagram after another, and all when it rests. */
  #follow() {
    clearTimeout(this.resting);
    this.stale.hidden = true;
    if (this.job.followed !== null) {
      this.isBehind = true;
      return;
    }
    this.isBehind = false;
    this.job.run(() => {
      if (this.isBehind && this.isFollowing) this.#follow();
      else this.resting = setTimeout(() => this.isFollowing && this.job.run(), RESTED);
    });
  }

  get hasPicture() {
    return this.levels.length > 0;
  }

  /** The parameter of the diagram may be any: it is marked in the picture. Orbits have no start. */
  scope({ kind, path }) {
    return { path, ...(kind === "response" && { parts: [] }) };
  }

  restore(state) {
    super.restore(state);
    if (!(this.settings.kind in OF)) this.settings.kind = "diagram";
    if (!(this.settings.section in AT_SECTION)) this.settings.section = "strobes";
    if (!FOLLOWS.some(([name]) => name === this.settings.follow)) this.settings.follow = "start";
    if (!this.#choices().some(([name]) => name === this.settings.of)) this.settings.of = this.#choices()[0][0];
    this.key = "";
    this.#fields(state.study);
    if (this.app.views) this.#place();
  }

  begin(state) {
    this.levels = [];
    this.families = null;
    clearTimeout(this.resting);
    this.pointer = null;
    this.beside.clear();
    super.begin(state);
  }

  requestOf(study, isLive = false) {
    const { kind, path, low, high, values, points, max_impacts, max_periods, follow, section, at, direction, cycle } = this.settings;
    const where = { strobes: {}, impacts: {}, cycle: { cycle }, place: { at, direction } }[section];
    const finest = isLive ? COARSE : { values, points };
    const sizes = kind === "diagram" ? { values: Math.min(values, finest.values), points: Math.min(points, finest.points), ...(follow !== "start" && { follow }), ...(section !== "strobes" && { section, ...where }) } : { max_impacts, max_periods };
    return { kind, study, path, low, high, ...sizes };
  }

  /** What can be drawn of the answer that is set now. */
  #choices(kind = this.settings.kind, section = this.settings.section) {
    return kind === "diagram" ? AT_SECTION[section] : OF[kind];
  }

  isComputed({ study: _, ...rest }) {
    // A picture of whole periods says nothing of a section.
    const { kind, section, follow } = this.settings;
    if (kind === "diagram" && ((rest.section ?? "strobes") !== section || (rest.follow ?? "start") !== follow)) return false;
    return Object.entries(rest).every(([name, value]) => value === this.settings[name]);
  }

  /** A value of the range that the parameter cannot have: mark the end that it is nearer to. */
  #mark({ path, reason }) {
    if (!this.pending || !path.startsWith("over.") || !path.includes(this.pending.path.replace("parameters.", ""))) return;
    const value = Number.parseFloat(reason);
    const { low, high } = this.pending;
    this.ends[Math.abs(value - low) <= Math.abs(value - high) ? "low" : "high"].complain(reason);
  }

  changed() {
    this.#fields(this.app.store.value.study);
    super.changed();
    if (this.current === null) return;
    if (this.isFollowing && !this.stale.hidden) this.#follow();
    this.plot.lines = this.#here();
    this.plot.redraw();
  }

  /** Build the form anew where the motion has other parameters. */
  #fields(study) {
    // Families of orbits do not depend on a start.
    const paths = pathsOf(study).filter((it) => this.settings.kind === "diagram" || !it.path.startsWith("start."));
    const key = paths.map((it) => it.path).join() + this.settings.kind;
    if (key === this.key) return;
    this.key = key;
    const { settings } = this;
    if (!paths.some((it) => it.path === settings.path)) this.#range((paths.find((it) => it.path.endsWith("omega")) ?? paths[0]).path, study);
    const number = (name, label, attributes) => numberField(label, settings[name], (value) => this.#set({ [name]: value }), attributes);
    const whole = (name, label, max) => number(name, label, { min: name.startsWith("max") ? 1 : 2, max, step: 1 });
    const isDiagram = settings.kind === "diagram";
    this.ends = { low: number("low", "from"), high: number("high", "to") };
    this.form.replaceChildren(
      choiceField("kind", KINDS, settings.kind, (kind) => this.#set({ kind, of: OF[kind][0][0] }, true)),
      choiceField("over", paths.map((it) => [it.path, it.name]), settings.path, (path) => {
        this.#range(path, this.app.store.value.study);
        this.#set({}, true);
      }),
      this.ends.low,
      this.ends.high,
      ...(isDiagram
        ? [whole("values", "values", 8192), whole("points", "points at each", 1024), choiceField("begin at", FOLLOWS, settings.follow, (follow) => this.#set({ follow })), ...this.#sectionFields(number)]
        : [whole("max_impacts", "impacts up to", 6), whole("max_periods", "periods up to", 6)]),
      choiceField("of", this.#choices(), settings.of, (of) => {
        this.#set({ of });
        this.#draw();
      }),
      ...(isDiagram ? [checkField("live: it follows the sliders", settings.isLive, (isLive) => this.#switch(isLive))] : []),
    );
    this.hint.textContent = (isDiagram ? ABOUT[settings.section] : null) ?? ABOUT[settings.kind];
    this.#wait();
  }

  /** Where the points are taken. */
  #sectionFields(number) {
    const { section, direction } = this.settings;
    const choice = choiceField("points at", SECTIONS, section, (name) => this.#set({ section: name, of: AT_SECTION[name][0][0] }, true));
    const own = {
      strobes: [],
      impacts: [],
      cycle: [number("cycle", "cycle", { min: 0, max: 1 })],
      place: [number("at", "x ="), choiceField("passed", DIRECTIONS, direction, (way) => this.#set({ direction: way }))],
    };
    return [choice, ...own[section]];
  }

  /** Show the sliders beside the diagram, which follows them, or do not. */
  #switch(isLive) {
    this.settings.isLive = isLive;
    clearTimeout(this.resting);
    this.keep();
    this.#place();
    if (this.isFollowing && !this.stale.hidden) this.#follow();
  }

  #set(parts, isOther = false) {
    // Another column of the same answer needs no computing.
    Object.assign(this.settings, parts, "of" in parts && !isOther ? {} : { isComputed: false });
    if (isOther) this.key = "";
    if ("low" in parts || "high" in parts) checkRange(this.ends.high, this.settings.low, this.settings.high);
    this.keep();
    this.#wait();
  }

  #wait() {
    const { low, high } = this.settings;
    if (this.levels.length > 0 || !(low < high)) return;
    this.plot.label(this.#name(this.settings.path), this.#quantity(this.settings.of, this.app.store.value.study));
    this.plot.wait(`Compute shows the ${KINDS.find(([kind]) => kind === this.settings.kind)[1]}`, { x: [low, high], y: [-1, 1] });
  }

  /** Set a range around the value that a parameter has. */
  #range(path, study) {
    const value = numberOf(get(study, path));
    const size = Math.abs(value) || 1;
    Object.assign(this.settings, { path, low: round(value - 0.4 * size), high: round(value + 0.4 * size) });
    if (path.endsWith("restitution")) Object.assign(this.settings, { low: 0, high: 1 });
    if (path.endsWith("omega")) this.settings.low = Math.max(0.05, this.settings.low);
    if (path.endsWith("damping") && value >= 0) this.settings.low = Math.max(0, this.settings.low);
    if (path === "start.x0") {
      const [least, most] = limitsOf(study);
      Object.assign(this.settings, { low: Math.max(least, this.settings.low), high: Math.min(most, this.settings.high) });
    }
  }

  refine() {
    const ends = this.plot.limits.x;
    const [low, high] = ends.map((end) => Number(end.toPrecision(Math.max(8, digitsOf(ends)))));
    Object.assign(this.settings, { low, high, path: this.current.path });
    this.key = "";
    this.#fields(this.app.store.value.study);
    this.run(this.current.study);
  }

  receive(header, arrays, isFirst) {
    if (isFirst || header.kind === "response") this.levels = [];
    this.levels.push({ header, arrays });
    this.#draw();
  }

  #draw() {
    if (this.levels.length === 0) return;
    const { header } = this.levels[0];
    // What is chosen may be of the other kind, which is not computed yet.
    const choices = this.#choices(header.kind, this.current.section ?? "strobes");
    const of = choices.some(([name]) => name === this.settings.of) ? this.settings.of : choices[0][0];
    this.drawn = of;
    this.plot.label(this.#name(header.path), this.#quantity(of, this.current.study));
    if (header.kind === "diagram") this.#drawPoints(header, of);
    else this.#drawFamilies(header, of);
    if (this.pointer) this.#showBeside(...this.pointer);
  }

  #drawPoints(header, of) {
    this.families = null;
    let low = Infinity;
    let high = -Infinity;
    const parts = this.levels.flatMap(({ header: it, arrays }) => [[it, arrays.value, arrays[of], "--curve"], [it, arrays.value, arrays[`${of}_backward`], "--orbit"]]).filter(([, , y]) => y);
    for (const [, , y] of parts) {
      for (const value of y) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    const pad = 0.05 * (high - low) || 1;
    const total = parts.reduce((sum, [, , y]) => sum + y.length, 0);
    const isSparse = this.levels.reduce((sum, { arrays }) => sum + arrays.value.length, 0) < 2000;
    this.plot.show(
      parts.map(([it, x, y, colour]) => ({ kind: "density", x, y, rows: it.n_points, isSparse, colour })),
      this.#here(),
      low <= high ? { x: [header.low, header.high], y: [low - pad, high + pad] } : { x: [header.low, header.high], y: [-1, 1] },
      this.app.views.explore.panel.isHeld,
    );
    if (!(low <= high)) this.plot.say("no motion stays within bounds");
    this.legend.replaceChildren(element("li", {}, `${total.toLocaleString("en")} points`), ...(this.current.follow === "both" ? [swatchOf("--curve", "upwards"), swatchOf("--orbit", "downwards")] : []), element("li", {}, "click a point to open it in Explore"), ...this.#legendHere());
    const { failed, reason } = this.levels.at(-1).header;
    const count = this.levels.reduce((sum, { arrays }) => sum + arrays.value.length, 0);
    if (failed > 0) this.legend.append(element("li", { class: "fault" }, `${failed} of ${count} values have no motion: ${reason}`));
  }

  #drawFamilies(header, of) {
    const { arrays } = this.levels[0];
    this.families = familiesOf(header, arrays, of);
    // For whoever cannot read pictures.
    this.plot.root.dataset.marks = JSON.stringify(this.families.marks.map(({ kind, x, y }) => ({ kind, x, y })));
    this.plot.show(this.families.layers, this.#here());
    if (this.families.kinds.size === 0) this.plot.say(header.done ? "no periodic orbits found" : "looking for periodic orbits …");
    const rows = [...this.families.kinds].map(([name, colour]) => swatchOf(colour, name));
    this.legend.replaceChildren(...rows, element("li", {}, "solid: stable, dashed: not stable; click an orbit to open it in Explore"), ...this.#legendHere());
    if (!header.done) this.legend.append(element("li", { class: "note" }, "the first families; others may follow"));
  }

  /** A line at the value that Explore shows. */
  #here() {
    const value = this.current ? numberOf(get(this.app.store.value.study, this.current.path)) : Number.NaN;
    return value >= this.current?.low && value <= this.current?.high ? [{ x: value, colour: "--faint" }] : [];
  }

  #legendHere() {
    return this.#here().length > 0 ? [element("li", { class: "note" }, "dashed vertical line: the value that Explore shows")] : [];
  }

  #name(path) {
    return pathsOf(this.current?.study ?? this.app.store.value.study).find((it) => it.path === path)?.name ?? path;
  }

  #quantity(of, study) {
    const { section = "strobes", cycle, at, direction } = this.current ?? this.settings;
    const { length, velocity } = unitsOf(study);
    const unit = { x: length, amplitude: length, cycle: "" }[of] ?? velocity;
    const way = direction === "both" ? "" : `, ${direction}`;
    const where = { strobes: sampledAt(study), cycle: `at cycle ${cycle}`, place: `at x = ${at}${way}`, impacts: "" }[section];
    return named(of in { x: 1, v: 1, cycle: 1 } ? `${LABELS[of]} ${where}`.trim() : LABELS[of], unit);
  }

  read(x, y) {
    this.#showBeside(x, y);
    const name = this.current?.path.split(".").at(-1) ?? "parameter";
    const place = (at) => `${name} = ${shown(at.x, digitsOf(this.plot.limits.x))}, ${this.drawn ?? "y"} = ${shown(at.y, 5)}`;
    if (!this.families) return place({ x, y });
    const mark = nearestMark(this.families.marks, { x, y }, this.plot.limits);
    if (mark) return `${mark.kind} at ${place(mark)}: ${orbitText(mark.at)}`;
    const near = nearestOrbit(this.families.rows, { x, y }, this.plot.limits);
    return near ? `${place({ x, y })}: ${orbitText(near)}` : place({ x, y });
  }

  open(x, y) {
    if (!this.current || this.levels.length === 0) return;
    const { study, value, start } = this.#motionAt(x, y);
    this.app.open(study);
    const from = start?.t0 && Number(start.t0) !== 0 ? `, on the orbit from t0 = ${start.t0} on` : "";
    say(this.app.root, `opened ${this.#nameOfValue(value)}${from}`);
  }

  /** Show the motion of the point that is nearest to the pointer beside the diagram. */
  #showBeside(x, y) {
    if (!this.current || this.levels.length === 0) return;
    this.pointer = [x, y];
    const { study, value, start } = this.#motionAt(x, y);
    this.beside.show(study, this.#nameOfValue(value), start?.x0 === undefined ? SETTLING : 0);
  }

  #nameOfValue(value) {
    return `${this.current.path.split(".").at(-1)} = ${shown(value, digitsOf(this.plot.limits.x))}`;
  }

  /** Return the study of the point or orbit nearest to a place, its value of the parameter and its start. */
  #motionAt(x, y) {
    const { path, study, low, high } = this.current;
    const found = this.families ? this.#orbitNear(x, y) : this.#pointNear(x, y);
    const value = found?.value ?? x;
    // Arrays hold seven digits of the range, bifurcations come in double.
    const digits = digitsOf([low, high], 1e-6);
    const next = put(study, path, String(Number(value.toPrecision(found?.isMark ? Math.max(12, digits) : digits))));
    const start = path.startsWith("start.") ? undefined : found?.start;
    return { study: start ? { ...next, start: { ...next.start, ...start } } : next, value, start };
  }

  #orbitNear(x, y) {
    const mark = nearestMark(this.families.marks, { x, y }, this.plot.limits);
    const near = mark?.at ?? nearestOrbit(this.families.rows, { x, y }, this.plot.limits);
    if (near === null) return null;
    const { it, k } = near;
    return { value: mark?.x ?? it.value[k], isMark: mark !== null, start: startAt(this.current.study, it.x0[k], it.v0[k], { t0: String(Number(it.t0[k].toPrecision(8))) }) };
  }

  /** Return value, x and v of the point of the diagram that is nearest. */
  #pointNear(x, y) {
    const [width, height] = [this.plot.limits.x, this.plot.limits.y].map((ends) => ends[1] - ends[0]);
    let best = null;
    let least = Infinity;
    for (const { header, arrays } of this.levels) {
      const n = header.n_points;
      arrays.value.forEach((value, i) => {
        const across = Math.abs(value - x) / width;
        if (across > 0.02) return;
        for (let k = i * n; k < (i + 1) * n; k += 1) {
          const apart = across + Math.abs(arrays[this.drawn][k] - y) / height;
          if (apart < least) {
            least = apart;
            // Of a section elsewhere a point is no start at the time of the start.
            best = { value, start: this.current.section === undefined ? startAt(this.current.study, arrays.x[k], arrays.v[k]) : {} };
          }
        }
      });
    }
    return best;
  }
}

const round = (value) => Number(value.toPrecision(3));

/** Return a row of the legend. */
function swatchOf(colour, name) {
  const swatch = element("span", { class: "swatch" });
  swatch.style.backgroundColor = `var(${colour})`;
  return element("li", {}, swatch, element("span", {}, name));
}
