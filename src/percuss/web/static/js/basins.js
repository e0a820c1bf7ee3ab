// Which attractor each start goes to.

import { element, say, shown } from "./dom.js";
import { asCanvas } from "./draw.js";
import { numberField } from "./fields.js";
import { Job } from "./job.js";
import { limitsOf, sameMotion } from "./models.js";
import { Plot } from "./plots.js";
import { settingsOf } from "./state.js";

// Colours that differ in lightness too; after them undecided and impossible starts.
const COLOURS = [[27, 94, 140], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66], [120, 120, 160]];
const UNDECIDED = [150, 150, 150];
const NO_START = [90, 90, 90];
const DEFAULTS = { x_low: -2, x_high: 2, v_low: -2, v_high: 2, starts: 256 };
const LABELS = { x_low: "x from", x_high: "x to", v_low: "v from", v_high: "v to", starts: "starts along a side" };

export class Basins {
  constructor(app) {
    this.app = app;
    this.job = new Job(app, () => this.#ask(), (header, arrays, isFirst) => this.#show(header, arrays, isFirst));
    this.plot = new Plot({
      title: "Basins", x: "displacement x at the start", y: "velocity v at the start", kind: "points",
      read: (x, y) => this.#read(x, y),
      onClick: (x, y) => this.#open(x, y),
      onZoom: (zoom) => (this.zoomed.hidden = zoom === null),
    });
    this.zoomed = element("button", { type: "button", hidden: true, onclick: () => this.#refine() }, "Compute what is shown");
    this.job.root.append(this.zoomed);
    this.legend = element("ul", { class: "legend" });
    this.stale = element("p", { class: "stale-note", hidden: true }, "The motion has been changed since; compute again for what is set now.");
    this.form = element("form", { class: "settings", onsubmit: (event) => event.preventDefault() });
    this.root = element(
      "section",
      { class: "wide", "aria-label": "Basins" },
      this.form, this.job.root, this.stale, this.plot.root, this.legend,
      element("p", { class: "hint" }, "Each start (x, v) has the colour of the attractor that it goes to; squares are the attractors, seen once a forcing period. Click a start to follow it in Explore."),
    );
    this.restore(app.store.value);
    app.store.watch((state) => (this.stale.hidden = this.study === undefined || sameMotion(this.study, state.study)));
  }

  recolour() {
    this.plot.recolour();
  }

  close() {
    this.plot.close();
  }

  /** Take the settings of a link. */
  restore({ basins }) {
    this.isChosen = basins !== undefined;
    this.settings = settingsOf(DEFAULTS, basins);
    this.#fields();
  }

  /** Another motion: nothing is known of it. */
  begin(state) {
    this.job.clear();
    this.header = this.study = undefined;
    this.stale.hidden = true;
    this.legend.replaceChildren();
    this.restore(state);
  }

  /** Unless the user has chosen a part of the plane: that where the motion is. */
  shown() {
    if (this.isChosen || this.header) return;
    const { curve, study } = this.app.views.explore;
    if (!curve || study !== this.app.store.value.study) return;
    const [x_low, x_high] = around(curve.portrait_x, limitsOf(study));
    const [v_low, v_high] = around(curve.portrait_v, [-Infinity, Infinity]);
    Object.assign(this.settings, { x_low, x_high, v_low, v_high });
    this.#fields();
  }

  /** Return what is asked, as the server knows it. */
  question() {
    return { kind: "basins", study: this.app.store.value.study, ...this.settings };
  }

  #fields() {
    const set = (name) => (value) => {
      this.settings[name] = value;
      this.isChosen = true;
      this.app.store.set({ basins: { ...this.settings } }, "basins");
      this.#wait();
    };
    const field = (name) => numberField(LABELS[name], this.settings[name], set(name), name === "starts" ? { min: 16, max: 1024, step: 1 } : {});
    this.form.replaceChildren(...Object.keys(DEFAULTS).map(field));
    this.#wait();
  }

  #wait() {
    const { x_low, x_high, v_low, v_high } = this.settings;
    if (!this.header && x_low < x_high && v_low < v_high) this.plot.wait("Compute tells to which attractor each start goes", { x: [x_low, x_high], y: [v_low, v_high] });
  }

  #ask() {
    const question = this.question();
    this.study = question.study;
    this.stale.hidden = true;
    // What is computed is kept in the link.
    if (!this.isChosen) this.app.store.set({ basins: { ...this.settings } }, "basins");
    this.isChosen = true;
    return question;
  }

  #refine() {
    const { x, y } = this.plot.limits;
    const ends = { x_low: x[0], x_high: x[1], v_low: y[0], v_high: y[1] };
    for (const [name, value] of Object.entries(ends)) this.settings[name] = Number(value.toPrecision(6));
    this.app.store.set({ basins: { ...this.settings } }, "basins");
    this.#fields();
    this.job.run();
  }

  #show(header, arrays, isFirst) {
    if (isFirst) {
      this.plot.zoom = null;
      this.zoomed.hidden = true;
    }
    this.header = header;
    this.basin = arrays.basin;
    const { size } = header;
    const image = new ImageData(size, size);
    const pixels = new Uint32Array(image.data.buffer);
    const colours = new Map();
    for (let i = 0; i < size; i += 1) {
      for (let j = 0; j < size; j += 1) {
        const label = arrays.basin[i * size + j];
        if (!colours.has(label)) colours.set(label, packed(colourOf(label)));
        pixels[(size - 1 - j) * size + i] = colours.get(label);
      }
    }
    const box = { x: [header.x_low, header.x_high], y: [header.v_low, header.v_high] };
    const marks = header.attractors.flatMap((it, k) => {
      const place = { x: arrays[`x${k}`], y: arrays[`v${k}`], kind: "points" };
      const isOrbit = it.kind === "periodic" || it.kind === "rest";
      return isOrbit
        ? [{ ...place, colour: "#ffffff", size: 12 }, { ...place, colour: "#000000", size: 9 }, { ...place, colour: `rgb(${colourOf(k).join()})`, size: 5 }]
        : [{ ...place, colour: "#ffffff", size: 2 }];
    });
    this.plot.show([{ kind: "image", image: asCanvas(image), box, x: box.x, y: box.y }, ...marks], [], box);
    this.#legend(header, arrays.basin);
  }

  #legend(header, basin) {
    const rows = header.attractors.map((it, k) => row(colourOf(k), nameOf(it), `${percent(it.fraction)} ± ${percent(it.error)}`));
    if (basin.includes(-1)) rows.push(row(UNDECIDED, "not decided in the time given", ""));
    if (basin.includes(-2)) rows.push(row(NO_START, "no start: inside a wall", ""));
    this.legend.replaceChildren(...rows);
  }

  #at(x, y) {
    const { size, x_low: left, x_high: right, v_low: low, v_high: high } = this.header;
    const i = Math.floor(((x - left) / (right - left)) * size);
    const j = Math.floor(((y - low) / (high - low)) * size);
    return i >= 0 && i < size && j >= 0 && j < size ? this.basin[i * size + j] : null;
  }

  #read(x, y) {
    const place = `x = ${shown(x, 4)}, v = ${shown(y, 4)}`;
    const label = this.header ? this.#at(x, y) : null;
    if (label === null) return place;
    if (label === -1) return `${place}: not decided`;
    return `${place}: ${label < 0 ? "inside a wall" : nameOf(this.header.attractors[label])}`;
  }

  #open(x, y) {
    if (!this.study || !this.header) return;
    if (this.#at(x, y) === -2) {
      say(this.app.root, "no motion starts inside a wall");
      return;
    }
    const start = { ...this.study.start, x0: String(Number(x.toPrecision(6))), v0: String(Number(y.toPrecision(6))) };
    this.app.open({ ...this.study, start });
    say(this.app.root, `starts at x = ${shown(x)}, v = ${shown(y)}`);
  }
}

/** Return a range with room around values, within limits, of few digits. */
function around(values, [least, most]) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    low = Math.min(low, value);
    high = Math.max(high, value);
  }
  if (!(high > low)) [low, high] = [low - 1, high + 1];
  const width = high - low;
  const unit = 10 ** Math.floor(Math.log10(width) - 0.5);
  const rounded = (value, round) => Number((round(value / unit) * unit).toPrecision(6));
  return [Math.max(least, rounded(low - 0.4 * width, Math.floor)), Math.min(most, rounded(high + 0.4 * width, Math.ceil))];
}

function colourOf(label) {
  if (label === -1) return UNDECIDED;
  if (label < 0) return NO_START;
  return COLOURS[label % COLOURS.length];
}

const packed = ([r, g, b]) => ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;

function nameOf({ kind, name, n_impacts: impacts, n_periods: periods }) {
  return kind === "periodic" ? `periodic ${name || `(${impacts ?? "∞"}, ${periods})`}` : kind;
}

const percent = (share) => `${shown(100 * share, 3)} %`;

function row(colour, name, note) {
  const swatch = element("span", { class: "swatch" });
  swatch.style.backgroundColor = `rgb(${colour.join()})`;
  return element("li", {}, swatch, element("span", {}, name), element("span", { class: "note" }, note));
}
