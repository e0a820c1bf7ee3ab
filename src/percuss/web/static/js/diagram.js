// A bifurcation diagram or a response chart over one parameter, or a chart of two.

import { Beside } from "./beside.js";
import { familiesOf, nearestMark, nearestOrbit, orbitText } from "./chart.js";
import { element, say, shown, swatchOf, wordsOf } from "./dom.js";
import { checkField, checkRange, choiceField, numberField } from "./fields.js";
import { JobView } from "./job_view.js";
import { limitsOf, named, numberOf, pathsOf, startAt, unitsOf } from "./models.js";
import { chartOf, valueText } from "./parameter_chart.js";
import { sampledAt } from "./provenance.js";
import { digitsOf, endsOf, rounded } from "./scales.js";
import { get, put } from "./state.js";

const KINDS = [
  ["diagram", "bifurcation diagram"],
  ["response", "response chart"],
  ["sweep", "chart of two parameters"],
];
const OF = {
  diagram: [["x", "displacement"], ["v", "velocity"]],
  response: [["amplitude", "amplitude"], ["speed", "impact speed"]],
  sweep: ["period", "largest_lyapunov_exponent", "peak_impact_velocity"].map((name) => [name, wordsOf(name)]),
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
const CLOUD = "a cloud is chaos or a long transient.";
const ONE = `after settling: one point is an orbit of one period, two of two, ${CLOUD}`;
const FEW = `after settling: a few points are a periodic orbit, ${CLOUD}`;
const ABOUT = {
  diagram: `Where the motion is once a forcing period ${ONE}`,
  cycle: `Where the motion is at that cycle of each forcing period ${ONE}`,
  place: `How fast the motion passes that place, and when, ${FEW}`,
  impacts: `How the impacts are ${FEW}`,
  response: "All periodic orbits that are found, stable solid and unstable dashed, (impacts, forcing periods); squares are bifurcations and grazes.",
  sweep: "Each cell is a motion from the start of Explore; its colour tells where it settles, periods in forcing periods.",
};
const FOLLOWS = [["start", "the start of Explore"], ["forward", "the value before, upwards"], ["backward", "the value above, downwards"], ["both", "both, upwards and downwards"]];
// Values and points while a slider moves; all are computed once it has rested so long [ms].
const COARSE = { values: 256, points: 64 };
const RESTED = 400;
// Forcing periods before the motion beside a point that is no start of it.
const SETTLING = 60;
const DEFAULTS = { kind: "diagram", path: "", low: 1, high: 4, path2: "", low2: 0, high2: 1, size: 96, values: 1600, points: 128, of: "x", max_impacts: 3, max_periods: 2, follow: "start", section: "strobes", at: 0, direction: "up", cycle: 0, isLive: false, isComputed: false };

export class Diagram extends JobView {
  constructor(app) {
    super(app, { name: "diagram", title: "Diagram", defaults: DEFAULTS, x: "parameter", y: "x" });
    this.levels = [];
    this.job.mark = (fault) => this.#mark(fault);
    this.beside = new Beside(app);
    this.plots.push(this.beside.portrait, this.beside.motion);
    this.aside = element("aside", { hidden: true });
    this.sides = element("div", { class: "sides" });
    this.plot.root.replaceWith(this.sides);
    this.sides.append(this.aside, this.plot.root, this.beside.root);
    this.root.classList.add("diagram");
    this.restore(app.store.value);
  }

  close() {
    clearTimeout(this.resting);
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
  scope({ kind, path, path2 }) {
    return { paths: [path, path2].filter(Boolean), ...(kind === "response" && { parts: [] }) };
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
    const { kind, path, low, high, path2, low2, high2, size, of, values, points, max_impacts, max_periods, follow, section, at, direction, cycle } = this.settings;
    if (kind === "sweep") return { kind, study, path, low, high, path2, low2, high2, size, of };
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
    const paths = pathsOf(study).filter((it) => this.settings.kind !== "response" || !it.path.startsWith("start."));
    const key = paths.map((it) => it.path).join() + this.settings.kind;
    if (key === this.key) return;
    this.key = key;
    const { settings } = this;
    if (!paths.some((it) => it.path === settings.path)) this.#range((paths.find((it) => it.path.endsWith("omega")) ?? paths[0]).path, study);
    const number = (name, label, attributes) => numberField(label, settings[name], (value) => this.#set({ [name]: value }), attributes);
    const whole = (name, label, max) => number(name, label, { min: name.startsWith("max") ? 1 : 2, max, step: 1 });
    const isDiagram = settings.kind === "diagram";
    const isChart = settings.kind === "sweep";
    const others = paths.filter((it) => it.path !== settings.path);
    if (isChart && !others.some((it) => it.path === settings.path2)) this.#range((others.find((it) => it.path.endsWith("restitution")) ?? others[0]).path, study, "2");
    const choose = (label, among, end) => choiceField(label, among.map((it) => [it.path, it.name]), settings[`path${end}`], (path) => {
      this.#range(path, this.app.store.value.study, end);
      this.#set({}, true);
    });
    this.ends = { low: number("low", "from"), high: number("high", "to"), high2: number("high2", "and to") };
    this.form.replaceChildren(
      choiceField("kind", KINDS, settings.kind, (kind) => this.#set({ kind, of: OF[kind][0][0] }, true)),
      choose("over", paths, ""),
      this.ends.low,
      this.ends.high,
      ...(isChart
        ? [choose("and over", others, "2"), number("low2", "and from"), this.ends.high2, number("size", "cells along a side", { min: 16, max: 256, step: 1 })]
        : isDiagram
        ? [whole("values", "values", 8192), whole("points", "points at each", 1024), choiceField("begin at", FOLLOWS, settings.follow, (follow) => this.#set({ follow })), ...this.#sectionFields(number)]
        : [whole("max_impacts", "impacts up to", 6), whole("max_periods", "periods up to", 6)]),
      choiceField("of", this.#choices(), settings.of, (of) => {
        this.#set({ of });
        this.#draw();
      }),
      ...(isDiagram ? [checkField("live: it follows the sliders", settings.isLive, (isLive) => this.#switch(isLive))] : []),
    );
    this.#tell();
    this.#wait();
  }

  /** Say what the picture shows or, where there is none yet, is to show. */
  #tell() {
    const { kind, section } = this.hasPicture ? this.current : this.settings;
    this.hint.textContent = (kind === "diagram" ? ABOUT[section] : null) ?? ABOUT[kind];
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
    Object.assign(this.settings, parts, "of" in parts && !isOther && this.settings.kind !== "sweep" ? {} : { isComputed: false });
    if (isOther) this.key = "";
    for (const end of ["", "2"]) if (`low${end}` in parts || `high${end}` in parts) checkRange(this.ends[`high${end}`], this.settings[`low${end}`], this.settings[`high${end}`]);
    this.keep();
    this.#wait();
  }

  #wait() {
    const { kind, low, high, path, path2, low2, high2, of } = this.settings;
    const isChart = kind === "sweep";
    if (this.levels.length > 0 || !(low < high) || (isChart && !(low2 < high2))) return;
    this.plot.label(this.#name(path), isChart ? this.#name(path2) : this.#quantity(of, this.app.store.value.study));
    this.plot.wait(`Compute shows the ${KINDS.find(([it]) => it === kind)[1]}`, { x: [low, high], y: isChart ? [low2, high2] : [-1, 1] });
  }

  /** Set a range around the value that a parameter has. */
  #range(path, study, end = "") {
    const value = numberOf(get(study, path));
    const size = Math.abs(value) || 1;
    let [low, high] = path.endsWith("restitution") ? [0, 1] : [round(value - 0.4 * size), round(value + 0.4 * size)];
    if (path.endsWith("omega")) low = Math.max(0.05, low);
    if (path.endsWith("damping") && value >= 0) low = Math.max(0, low);
    if (path === "start.x0") {
      const [least, most] = limitsOf(study);
      [low, high] = [Math.max(least, low), Math.min(most, high)];
    }
    Object.assign(this.settings, { [`path${end}`]: path, [`low${end}`]: low, [`high${end}`]: high });
  }

  refine() {
    const { kind, path, path2 } = this.current;
    const [low, high] = rounded(this.plot.limits.x);
    Object.assign(this.settings, { low, high, path });
    if (kind === "sweep") {
      const [low2, high2] = rounded(this.plot.limits.y);
      Object.assign(this.settings, { kind, path2, low2, high2 });
    }
    this.key = "";
    this.#fields(this.app.store.value.study);
    this.run(this.current.study);
  }

  receive(header, arrays, isFirst) {
    if (isFirst || header.kind !== "diagram") this.levels = [];
    this.levels.push({ header, arrays });
    this.#draw();
  }

  #draw() {
    if (this.levels.length === 0) return;
    this.#tell();
    const { header } = this.levels[0];
    // What is chosen may be of the other kind, which is not computed yet.
    const choices = this.#choices(header.kind, this.current.section ?? "strobes");
    const of = choices.some(([name]) => name === this.settings.of) ? this.settings.of : choices[0][0];
    this.drawn = of;
    this.plot.label(this.#name(header.path), header.path2 ? this.#name(header.path2) : this.#quantity(of, this.current.study));
    if (header.path2) this.#drawChart();
    else if (header.kind === "diagram") this.#drawPoints(header, of);
    else this.#drawFamilies(header, of);
    if (this.pointer) this.#showBeside(...this.pointer);
  }

  #drawChart() {
    const [{ header, arrays: { value } }] = this.levels;
    const { low, high, low2, high2 } = header;
    this.families = null;
    const { image, rows } = chartOf(header, value);
    const box = { x: [low, high], y: [low2, high2] };
    this.plot.show([{ kind: "image", image, box, ...box }], this.#here(), box);
    this.legend.replaceChildren(...rows, element("li", {}, "click a cell to open it in Explore"), ...this.#legendHere());
    if (value.some(Number.isNaN)) this.legend.append(element("li", { class: "fault" }, "clear cells have no motion"));
  }

  #drawPoints(header, of) {
    this.families = null;
    const parts = this.levels.flatMap(({ header: it, arrays }) => [[it, arrays.value, arrays[of], "--curve"], [it, arrays.value, arrays[`${of}_backward`], "--orbit"]]).filter(([, , y]) => y);
    const [low, high] = endsOf(parts.flatMap(([, , y]) => endsOf(y)));
    const pad = 0.05 * (high - low) || 1;
    const total = parts.reduce((sum, [, , y]) => sum + y.length, 0);
    const count = this.levels.reduce((sum, { arrays }) => sum + arrays.value.length, 0);
    this.plot.show(
      parts.map(([it, x, y, colour]) => ({ kind: "density", x, y, rows: it.n_points, isSparse: count < 2000, colour })),
      this.#here(),
      { x: [header.low, header.high], y: low <= high ? [low - pad, high + pad] : [-1, 1] },
      this.app.views.explore.panel.isHeld,
    );
    if (!(low <= high)) this.plot.say("no motion stays within bounds");
    this.legend.replaceChildren(element("li", {}, `${total.toLocaleString("en")} points`), ...(this.current.follow === "both" ? [swatchOf("--curve", "upwards"), swatchOf("--orbit", "downwards")] : []), element("li", {}, "click a point to open it in Explore"), ...this.#legendHere());
    const { failed, reason } = this.levels.at(-1).header;
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
    if (!this.current) return [];
    const { path, low, high, path2, low2, high2 } = this.current;
    const within = (at, from, to, axis) => {
      const value = at ? numberOf(get(this.app.store.value.study, at)) : Number.NaN;
      return value >= from && value <= to ? [{ [axis]: value, colour: "--faint" }] : [];
    };
    return [...within(path, low, high, "x"), ...within(path2, low2, high2, "y")];
  }

  #legendHere() {
    return this.#here().length > 0 ? [element("li", { class: "note" }, "dashed: what Explore shows")] : [];
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
    if (this.levels[0]?.header.path2) {
      const [{ header, arrays }] = this.levels;
      const { i, j, value, value2 } = cellAt(header, x, y);
      return `${this.#nameOfValue(value, value2)}: ${valueText(header.of, arrays.value[i * header.size + j])}`;
    }
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
    const { study, value, value2, start } = this.#motionAt(x, y);
    this.app.open(study);
    const from = start?.t0 && Number(start.t0) !== 0 ? `, on the orbit from t0 = ${start.t0} on` : "";
    say(this.app.root, `opened ${this.#nameOfValue(value, value2)}${from}`);
  }

  /** Show the motion of the point that is nearest to the pointer beside the diagram. */
  #showBeside(x, y) {
    if (!this.current || this.levels.length === 0) return;
    this.pointer = [x, y];
    const { study, value, value2, start } = this.#motionAt(x, y);
    this.beside.show(study, this.#nameOfValue(value, value2), start?.x0 === undefined ? SETTLING : 0);
  }

  /** Return the name of a value, and of the second one of a chart. */
  #nameOfValue(value, value2) {
    const { path, path2 } = this.current;
    const text = (at, it, ends) => `${at.split(".").at(-1)} = ${shown(it, digitsOf(ends))}`;
    return [text(path, value, this.plot.limits.x), ...(path2 ? [text(path2, value2, this.plot.limits.y)] : [])].join(", ");
  }

  /** Return the study of the point or orbit nearest to a place, its value of the parameter and its start. */
  #motionAt(x, y) {
    const { path, study, low, high, path2 } = this.current;
    if (path2) {
      const { value, value2 } = cellAt(this.current, x, y);
      return { study: put(put(study, path, String(value)), path2, String(value2)), value, value2 };
    }
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
    return { value: mark?.x ?? it.value[k], isMark: mark !== null, start: startAt(this.current.study, it.x0[k], it.v0[k], it.t0[k]) };
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

/** Return the cell of a chart that is nearest to a place, and the values in its middle. */
function cellAt({ low, high, low2, high2, size }, x, y) {
  const along = (at, from, to) => {
    const k = Math.min(size - 1, Math.max(0, Math.floor(((at - from) / (to - from)) * size)));
    return [k, Number((from + ((k + 0.5) / size) * (to - from)).toPrecision(Math.max(8, digitsOf([from, to], 1e-6))))];
  };
  const [[i, value], [j, value2]] = [along(x, low, high), along(y, low2, high2)];
  return { i, j, value, value2 };
}
