// Which attractor each start goes to.

import { basinLayers, legendOf, nameOf, pictureOf } from "./basin_picture.js";
import { element, say, shown } from "./dom.js";
import { checkField, checkRange, numberField } from "./fields.js";
import { Job } from "./job.js";
import { changedSince, startsAt } from "./made_of.js";
import { limitsOf } from "./models.js";
import { Plot } from "./plots.js";
import { Saddles } from "./saddles.js";
import { isStudy, settingsOf } from "./state.js";

const DEFAULTS = { x_low: -2, x_high: 2, v_low: -2, v_high: 2, starts: 256, manifolds: true, isComputed: false };
const LABELS = { x_low: "x from", x_high: "x to", v_low: "v from", v_high: "v to", starts: "starts along a side" };
const HINT = "Each start (x, v) has the colour of the attractor that it goes to; squares are the attractors, seen once a forcing period. Crosses are saddles, and lines their stable manifolds: motions that start on them go to the saddle, those on either side of them part. Click a start to follow it in Explore.";

export class Basins {
  constructor(app) {
    this.app = app;
    this.form = element("form", { class: "settings", onsubmit: (event) => event.preventDefault() });
    this.job = new Job(app, () => this.#ask(), (header, arrays, isFirst) => this.#take(header, arrays, isFirst), this.form);
    this.saddles = new Saddles(app, () => this.#draw());
    this.plot = new Plot({
      title: "Basins", x: "displacement x at the start", y: "velocity v at the start", kind: "points",
      read: (x, y) => this.#read(x, y),
      onClick: (x, y) => this.#open(x, y),
      onZoom: (zoom) => {
        this.zoomed.hidden = zoom === null;
        app.keepZoom("basins", zoom);
      },
    });
    this.zoomed = element("button", { type: "button", hidden: true, onclick: () => this.#refine() }, "Compute what is shown");
    this.job.root.append(this.zoomed);
    this.legend = element("ul", { class: "legend" });
    this.stale = element("p", { class: "stale-note", role: "status", hidden: true });
    this.root = element(
      "section",
      { class: "wide", "aria-label": "Basins" },
      this.form, this.job.root, this.stale, this.plot.root, this.legend, element("p", { class: "hint" }, HINT),
    );
    this.restore(app.store.value);
    app.store.watch(() => this.#changed());
  }

  /** Say whether the motion is another one by now; the section of the basins is at the start's time. */
  #changed() {
    this.stale.textContent = this.study === undefined ? "" : changedSince(this.study, this.app.store.value.study, { parts: ["t0"] });
    this.stale.hidden = this.stale.textContent === "";
  }

  recolour() {
    this.plot.recolour();
    this.#paint();
    this.#draw();
  }

  /** Make the picture in the colours of the theme. */
  #paint() {
    if (this.header) this.image = pictureOf(this.header, this.arrays.basin, this.app.root.dataset.theme);
  }

  close() {
    this.plot.close();
  }

  /** Take the settings of a link. */
  restore({ basins, zooms, study }) {
    this.isChosen = basins !== undefined;
    this.settings = settingsOf(DEFAULTS, basins);
    this.due = this.settings.isComputed ? { zoom: zooms?.basins ?? null, study: isStudy(basins.study) ? basins.study : study } : null;
    this.#fields();
  }

  /** Another motion: nothing is known of it. */
  begin(state) {
    this.job.clear();
    this.saddles.clear();
    this.header = this.study = this.asked = undefined;
    this.stale.hidden = true;
    this.legend.replaceChildren();
    this.restore(state);
  }

  /** A link shows the picture that it was made of; else the part of the plane where the motion is. */
  shown() {
    if (this.due !== null && this.app.isOpen) {
      const { zoom, study } = this.due;
      this.due = null;
      if (this.header && JSON.stringify(this.asked) === JSON.stringify(this.#questionOf(study))) return;
      this.firstZoom = zoom;
      this.#run(study);
    } else if (!this.isChosen && !this.header) this.#choose();
  }

  /** Return what the picture shows, or is to show, as the server knows it: files are of that. */
  question() {
    if (!this.header || !this.asked) return this.#questionOf(this.app.store.value.study);
    return { ...this.asked, manifolds: this.settings.manifolds };
  }

  #questionOf(study) {
    const { isComputed: _, ...settings } = this.settings;
    return { kind: "basins", study, ...settings };
  }

  /** Compute with another study than the one that is set. */
  #run(study) {
    this.base = study;
    this.job.run();
    this.base = null;
  }

  #choose() {
    const { curve, study } = this.app.views.explore;
    if (!curve || study !== this.app.store.value.study) return;
    const [x_low, x_high] = around(curve.portrait_x, limitsOf(study));
    const [v_low, v_high] = around(curve.portrait_v, [-Infinity, Infinity]);
    Object.assign(this.settings, { x_low, x_high, v_low, v_high });
    this.#fields();
  }

  #fields() {
    const set = (name) => (value) => {
      this.settings[name] = value;
      this.settings.isComputed = false;
      this.isChosen = true;
      const { x_low, x_high, v_low, v_high } = this.settings;
      if (name.startsWith("x")) checkRange(this.fields.x_high, x_low, x_high);
      if (name.startsWith("v")) checkRange(this.fields.v_high, v_low, v_high);
      this.#keep();
      this.#wait();
    };
    const field = (name) => numberField(LABELS[name], this.settings[name], set(name), name === "starts" ? { min: 16, max: 1024, step: 1 } : {});
    this.fields = Object.fromEntries(Object.keys(LABELS).map((name) => [name, field(name)]));
    this.form.replaceChildren(
      ...Object.values(this.fields),
      checkField("saddles and manifolds", this.settings.manifolds, (isOn) => this.#switch(isOn)),
    );
    this.#wait();
  }

  /** Draw the manifolds, or do not. */
  #switch(isOn) {
    this.settings.manifolds = isOn;
    this.#keep();
    if (isOn && this.header?.done) this.saddles.ask(this.study);
    else if (!isOn) this.saddles.clear();
    this.#draw();
  }

  #keep() {
    const made = this.settings.isComputed && this.study ? { study: this.study } : {};
    this.app.store.set({ basins: { ...this.settings, ...made } }, "basins");
  }

  #wait() {
    const { x_low, x_high, v_low, v_high } = this.settings;
    if (!this.header && x_low < x_high && v_low < v_high) this.plot.wait("Compute tells to which attractor each start goes", { x: [x_low, x_high], y: [v_low, v_high] });
  }

  #ask() {
    this.due = null;
    this.coming = this.#questionOf(this.base ?? this.app.store.value.study);
    return this.coming;
  }

  /** The first of another picture has come: from now on it is the one that is shown. */
  #begin() {
    this.asked = this.coming;
    this.study = this.asked.study;
    this.saddles.clear();
    // What is computed is kept in the link, unless something else is set by now.
    if (Object.keys(LABELS).every((name) => this.asked[name] === this.settings[name])) this.settings.isComputed = true;
    this.isChosen = true;
    const at = startsAt(this.study);
    this.plot.label(`displacement x ${at}`, `velocity v ${at}`);
    this.#keep();
    this.#changed();
  }

  #refine() {
    const { x, y } = this.plot.limits;
    const ends = { x_low: x[0], x_high: x[1], v_low: y[0], v_high: y[1] };
    for (const [name, value] of Object.entries(ends)) this.settings[name] = Number(value.toPrecision(6));
    this.#fields();
    this.#run(this.study);
  }

  #take(header, arrays, isFirst) {
    if (isFirst) {
      this.#begin();
      this.plot.take(this.firstZoom ?? null);
      this.zoomed.hidden = this.plot.zoom === null;
      if (this.plot.zoom === null) this.app.keepZoom("basins", null);
      this.firstZoom = null;
    }
    this.header = header;
    this.arrays = arrays;
    this.#paint();
    this.#draw();
    if (header.done && this.settings.manifolds) this.saddles.ask(this.study);
  }

  #draw() {
    if (!this.header) return;
    const box = { x: [this.header.x_low, this.header.x_high], y: [this.header.v_low, this.header.v_high] };
    this.plot.show(basinLayers(this.header, this.arrays, this.image, box, this.saddles.found), [], box);
    this.legend.replaceChildren(...legendOf(this.header, this.arrays.basin, this.app.root.dataset.theme), ...this.saddles.legend());
  }

  #at(x, y) {
    const { size, x_low: left, x_high: right, v_low: low, v_high: high } = this.header;
    const i = Math.floor(((x - left) / (right - left)) * size);
    const j = Math.floor(((y - low) / (high - low)) * size);
    return i >= 0 && i < size && j >= 0 && j < size ? this.arrays.basin[i * size + j] : null;
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
