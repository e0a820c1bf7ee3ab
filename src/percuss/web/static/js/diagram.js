// A bifurcation diagram or a response chart over one parameter.

import { element, say, shown } from "./dom.js";
import { choiceField, numberField } from "./fields.js";
import { Job } from "./job.js";
import { numberOf, pathsOf } from "./models.js";
import { Plot } from "./plots.js";
import { get, put } from "./state.js";

const KINDS = [
  ["diagram", "bifurcation diagram (all points of the attractor)"],
  ["response", "response chart (periodic orbits, stable and unstable)"],
];
const COLOURS = ["--curve", "--orbit", "--c3", "--c4", "--c5", "--c6"];

export class Diagram {
  constructor(app) {
    this.app = app;
    this.settings = { kind: "diagram", path: "", low: 1, high: 4, values: 1600, points: 128, of: "x" };
    Object.assign(this.settings, app.store.value.diagram ?? {});
    this.form = element("form", { class: "settings", onsubmit: (event) => event.preventDefault() });
    this.job = new Job(app, () => this.#question(), (header, arrays, isFirst) => this.#take(header, arrays, isFirst));
    this.plot = new Plot({
      title: "Diagram", x: "parameter", y: "x", kind: "points",
      read: (x, y) => `${this.settings.path} = ${shown(x, 6)}, ${this.#what()} = ${shown(y, 5)}`,
      onClick: (x, y) => this.#open(x, y),
    });
    this.legend = element("p", { class: "hint" });
    this.root = element(
      "section",
      { class: "wide", "aria-label": "Diagram" },
      this.form, this.job.root, this.plot.root, this.legend,
    );
    this.levels = [];
    app.store.watch(() => this.#fields());
    this.#fields();
  }

  recolour() {
    this.plot.recolour();
  }

  /** Build the form anew where the motion has other parameters. */
  #fields() {
    const { study } = this.app.store.value;
    const paths = pathsOf(study);
    const key = paths.map((it) => it.path).join() + this.settings.kind;
    if (key === this.key) return;
    this.key = key;
    const known = paths.some((it) => it.path === this.settings.path);
    if (!known) {
      const first = paths.find((it) => it.path.endsWith("omega")) ?? paths[0];
      this.#range(first.path);
    }
    const set = (name) => (value) => {
      this.settings[name] = value;
      this.app.store.set({ diagram: { ...this.settings } }, "diagram");
      this.key = "";
      this.#fields();
    };
    const isDiagram = this.settings.kind === "diagram";
    this.form.replaceChildren(
      choiceField("kind", KINDS, this.settings.kind, set("kind")),
      choiceField("over", paths.map((it) => [it.path, it.name]), this.settings.path, (path) => {
        this.#range(path);
        set("path")(path);
      }),
      numberField("from", this.settings.low, set("low")),
      numberField("to", this.settings.high, set("high")),
      ...(isDiagram
        ? [
            numberField("values", this.settings.values, set("values"), { min: 2, max: 8192, step: 1 }),
            numberField("points at each", this.settings.points, set("points"), { min: 2, max: 1024, step: 1 }),
            choiceField("of", [["x", "displacement"], ["v", "velocity"]], this.settings.of, (of) => {
              set("of")(of);
              this.#draw();
            }),
          ]
        : [
            choiceField("of", [["amplitude", "amplitude"], ["speed", "impact speed"]], this.settings.of, (of) => {
              set("of")(of);
              this.#draw();
            }),
          ]),
    );
  }

  /** Set a range around the value that a parameter has. */
  #range(path) {
    const value = numberOf(get(this.app.store.value.study, path));
    const size = Math.abs(value) || 1;
    Object.assign(this.settings, { path, low: round(value - 0.4 * size), high: round(value + 0.4 * size) });
    if (path.endsWith("restitution")) Object.assign(this.settings, { low: 0, high: 1 });
    if (path.endsWith("omega")) this.settings.low = Math.max(0.05, this.settings.low);
  }

  #question() {
    const { kind, path, low, high, values, points } = this.settings;
    const { study } = this.app.store.value;
    this.shown = { ...this.settings, study };
    return { kind, study, path, low, high, ...(kind === "diagram" ? { values, points } : {}) };
  }

  #what() {
    return { x: "x", v: "v", amplitude: "amplitude", speed: "impact speed" }[this.settings.of] ?? "x";
  }

  #take(header, arrays, isFirst) {
    if (isFirst) {
      this.levels = [];
      this.plot.zoom = null;
    }
    this.levels.push({ header, arrays });
    this.#draw();
  }

  #draw() {
    if (this.levels.length === 0) return;
    const { header } = this.levels[0];
    this.plot.options.x = header.path;
    if (header.kind === "diagram") this.#drawPoints(header);
    else this.#drawFamilies(header);
  }

  #drawPoints(header) {
    const of = this.settings.of === "v" ? "v" : "x";
    this.#label(header.path, of === "x" ? "x at whole periods" : "v at whole periods");
    let low = Infinity;
    let high = -Infinity;
    for (const { arrays } of this.levels) {
      for (const value of arrays[of]) {
        if (value < low) low = value;
        if (value > high) high = value;
      }
    }
    const pad = 0.05 * (high - low) || 1;
    this.plot.show(
      this.levels.map(({ header: it, arrays }) => ({ kind: "density", x: arrays.value, y: arrays[of], rows: it.n_points, colour: "--curve" })),
      [],
      { x: [header.low, header.high], y: [low - pad, high + pad] },
    );
    const total = this.levels.reduce((sum, { arrays }) => sum + arrays.x.length, 0);
    this.legend.textContent = `${total.toLocaleString("en")} points. Drag to zoom, double-click for all, click a point to open it in Explore.`;
  }

  #drawFamilies(header) {
    const { arrays } = this.levels[0];
    const of = this.settings.of === "speed" ? "speed" : "amplitude";
    this.#label(header.path, of === "speed" ? "largest impact speed" : "amplitude");
    const layers = [];
    header.families.forEach((_, i) => {
      const colour = COLOURS[i % COLOURS.length];
      const x = arrays[`value${i}`];
      const parts = { x, y: arrays[`${of}${i}`], stable: arrays[`stable${i}`], real: arrays[`admissible${i}`] };
      layers.push({ x, y: masked(parts, (s, r) => s && r), colour, width: 2 });
      layers.push({ x, y: masked(parts, (s, r) => !s && r), colour, width: 1.5, dash: [5, 4] });
    });
    this.plot.show(layers);
    const names = new Set(header.families.map(({ n_impacts: m, n_periods: n }) => `(${m ?? "∞"}, ${n})`));
    this.legend.textContent = `Families (impacts, periods): ${[...names].join(", ")}. Stable solid, unstable dashed. Click to open the parameter in Explore.`;
  }

  #label(x, y) {
    if (this.plot.options.x === x && this.plot.options.y === y) return;
    Object.assign(this.plot.options, { x, y });
    this.plot.recolour();
  }

  #open(value, height) {
    if (!this.shown) return;
    const { path, study } = this.shown;
    let next = put(study, path, String(Number(value.toPrecision(8))));
    const start = this.#startNear(value, height);
    if (start) next = { ...next, start: { ...next.start, ...start } };
    this.app.open(next);
    say(this.app.root, `opened ${path} = ${shown(value, 6)}`);
  }

  /** Return x and v of the point of the diagram that is nearest. */
  #startNear(value, height) {
    if (this.shown.kind !== "diagram") return null;
    let best = null;
    let least = Infinity;
    for (const { header, arrays } of this.levels) {
      const n = header.n_points;
      arrays.value.forEach((at, i) => {
        const across = Math.abs(at - value) / (header.high - header.low);
        if (across > 0.02) return;
        for (let k = i * n; k < (i + 1) * n; k += 1) {
          const apart = across + Math.abs(arrays[this.settings.of][k] - height) / (this.plot.home.y[1] - this.plot.home.y[0]);
          if (apart < least) {
            least = apart;
            best = { x0: String(arrays.x[k]), v0: String(arrays.v[k]) };
          }
        }
      });
    }
    return best;
  }
}

function masked({ y, stable, real }, keep) {
  return Float32Array.from(y, (value, i) => (keep(stable[i] > 0, real[i] > 0) ? value : Number.NaN));
}

const round = (value) => Number(value.toPrecision(3));
