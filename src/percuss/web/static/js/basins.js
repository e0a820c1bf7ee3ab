// Which attractor each start goes to.

import { basinLayers, legendOf, nameOf, pictureOf } from "./basin_picture.js";
import { element, say, shown } from "./dom.js";
import { checkField, checkRange, numberField } from "./fields.js";
import { JobView } from "./job_view.js";
import { limitsOf, named, unitsOf } from "./models.js";
import { startsAt } from "./provenance.js";
import { Saddles } from "./saddles.js";
import { endsOf, rounded } from "./scales.js";

const DEFAULTS = { x_low: -2, x_high: 2, v_low: -2, v_high: 2, starts: 256, manifolds: true, isComputed: false };
const LABELS = { x_low: "x from", x_high: "x to", v_low: "v from", v_high: "v to", starts: "starts along a side" };
const HINT = "Each start (x, v) has the colour of the attractor that it goes to; squares are the attractors, seen once a forcing period. Crosses are saddles, and lines their stable manifolds, which part the basins. Click a start to follow it in Explore.";

export class Basins extends JobView {
  constructor(app) {
    super(app, { name: "basins", title: "Basins", defaults: DEFAULTS, x: "displacement x at the start", y: "velocity v at the start" });
    this.hint.textContent = HINT;
    this.saddles = new Saddles(app, () => this.#draw());
    this.restore(app.store.value);
  }

  get hasPicture() {
    return this.header !== undefined;
  }

  /** The section of the basins is at the time of the start; they do not depend on its x and v. */
  scope() {
    return { parts: ["t0"] };
  }

  recolour() {
    this.#paint();
    this.#draw();
  }

  /** Make the picture in the colours of the theme. */
  #paint() {
    if (this.header) this.image = pictureOf(this.header, this.arrays.basin, this.app.root.dataset.theme);
  }

  restore(state) {
    super.restore(state);
    this.isChosen = state.basins !== undefined;
    this.#fields();
  }

  begin(state) {
    this.saddles.clear();
    this.header = undefined;
    super.begin(state);
  }

  /** Without a picture in the link, choose the part of the plane where the motion is. */
  shown() {
    if (super.shown()) return true;
    if (!this.isChosen && !this.header) this.#choose();
    return false;
  }

  /** The manifolds are drawn over a picture or not, and belong to its files. */
  request() {
    return { ...super.request(), manifolds: this.settings.manifolds };
  }

  requestOf(study) {
    const { isComputed: _, ...settings } = this.settings;
    return { kind: "basins", study, ...settings };
  }

  /** The ends of the square of starts, chosen about the motion where none is set. */
  square() {
    if (!this.isChosen && !this.header) this.#choose();
    const { x_low, x_high, v_low, v_high } = this.settings;
    return { x_low, x_high, v_low, v_high };
  }

  isComputed(request) {
    return Object.keys(LABELS).every((name) => request[name] === this.settings[name]);
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
      this.keep();
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
    this.keep();
    if (isOn && this.header?.done) this.saddles.find(this.current.study);
    else if (!isOn) this.saddles.clear();
    this.#draw();
  }

  #wait() {
    const { x_low, x_high, v_low, v_high } = this.settings;
    if (!this.header && x_low < x_high && v_low < v_high) this.plot.wait("Compute shows to which attractor each start goes", { x: [x_low, x_high], y: [v_low, v_high] });
  }

  refine() {
    const { x, y } = this.plot.limits;
    const [[x_low, x_high], [v_low, v_high]] = [x, y].map(rounded);
    Object.assign(this.settings, { x_low, x_high, v_low, v_high });
    this.#fields();
    this.run(this.current.study);
  }

  receive(header, arrays, isFirst) {
    if (isFirst) {
      this.saddles.clear();
      this.isChosen = true;
      const at = startsAt(this.current.study);
      const { length, velocity } = unitsOf(this.current?.study ?? this.app.store.value.study);
      this.plot.label(named(`displacement x ${at}`, length), named(`velocity v ${at}`, velocity));
    }
    this.header = header;
    this.arrays = arrays;
    this.#paint();
    this.#draw();
    if (header.done && this.settings.manifolds) this.saddles.find(this.current.study);
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

  read(x, y) {
    const place = `x = ${shown(x, 4)}, v = ${shown(y, 4)}`;
    const label = this.header ? this.#at(x, y) : null;
    if (label === null) return place;
    if (label === -1) return `${place}: not decided`;
    return `${place}: ${label < 0 ? "inside a wall" : nameOf(this.header.attractors[label])}`;
  }

  open(x, y) {
    if (!this.header) return;
    if (this.#at(x, y) === -2) {
      say(this.app.root, "no motion starts inside a wall");
      return;
    }
    const { study } = this.current;
    const start = { ...study.start, x0: String(Number(x.toPrecision(6))), v0: String(Number(y.toPrecision(6))) };
    this.app.open({ ...study, start });
    say(this.app.root, `starts at x = ${shown(x)}, v = ${shown(y)}`);
  }
}

/** Return a range with room around values, within limits, of few digits. */
function around(values, [least, most]) {
  let [low, high] = endsOf(values);
  if (!(high > low)) [low, high] = [low - 1, high + 1];
  const width = high - low;
  const unit = 10 ** Math.floor(Math.log10(width) - 0.5);
  const rounded = (value, round) => Number((round(value / unit) * unit).toPrecision(6));
  return [Math.max(least, rounded(low - 0.4 * width, Math.floor)), Math.min(most, rounded(high + 0.4 * width, Math.ceil))];
}
