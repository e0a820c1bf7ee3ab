// Which attractor each start goes to.

import { element, say, shown } from "./dom.js";
import { numberField } from "./fields.js";
import { Job } from "./job.js";
import { asCanvas, Plot } from "./plots.js";

// Colours that differ in lightness too; after them undecided and impossible starts.
const COLOURS = [[27, 94, 140], [230, 159, 0], [0, 158, 115], [204, 121, 167], [86, 180, 233], [213, 94, 0], [240, 228, 66], [120, 120, 160]];
const UNDECIDED = [150, 150, 150];
const NO_START = [90, 90, 90];

export class Basins {
  constructor(app) {
    this.app = app;
    this.settings = { x_low: -2, x_high: 2, v_low: -2, v_high: 2, starts: 384, ...(app.store.value.basins ?? {}) };
    const set = (name) => (value) => {
      this.settings[name] = value;
      app.store.set({ basins: { ...this.settings } }, "basins");
    };
    const field = (name, label, attributes) => numberField(label, this.settings[name], set(name), attributes);
    this.job = new Job(app, () => this.#question(), (header, arrays) => this.#show(header, arrays));
    this.plot = new Plot({
      title: "Basins", x: "x at the start", y: "v at the start", kind: "points",
      read: (x, y) => this.#read(x, y),
      onClick: (x, y) => this.#open(x, y),
    });
    this.legend = element("ul", { class: "legend" });
    this.root = element(
      "section",
      { class: "wide", "aria-label": "Basins" },
      element(
        "form",
        { class: "settings", onsubmit: (event) => event.preventDefault() },
        field("x_low", "x from"), field("x_high", "x to"), field("v_low", "v from"), field("v_high", "v to"),
        field("starts", "starts along a side", { min: 16, max: 1024, step: 1 }),
      ),
      this.job.root, this.plot.root, this.legend,
      element("p", { class: "hint" }, "Click a start to follow it in Explore. Drag to zoom, double-click for all."),
    );
  }

  recolour() {
    this.plot.recolour();
  }

  #question() {
    const { study } = this.app.store.value;
    this.study = study;
    return { kind: "basins", study, ...this.settings };
  }

  #show(header, arrays) {
    this.header = header;
    this.basin = arrays.basin;
    const size = header.size;
    const image = new ImageData(size, size);
    for (let i = 0; i < size; i += 1) {
      for (let j = 0; j < size; j += 1) {
        const colour = colourOf(arrays.basin[i * size + j]);
        image.data.set([...colour, 255], 4 * ((size - 1 - j) * size + i));
      }
    }
    const box = { x: [header.x_low, header.x_high], y: [header.v_low, header.v_high] };
    const marks = header.attractors.filter((it) => it.x !== null && it.v !== null);
    this.plot.show(
      [
        { kind: "image", image: asCanvas(image), box, x: box.x, y: box.y },
        { kind: "points", x: marks.map((it) => it.x), y: marks.map((it) => it.v), colour: "--paper", size: 11 },
        { kind: "points", x: marks.map((it) => it.x), y: marks.map((it) => it.v), colour: "--ink", size: 7 },
      ],
      [],
      box,
    );
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
    if (!this.header) return place;
    const label = this.#at(x, y);
    if (label === null || label < 0) return place;
    return `${place}: ${nameOf(this.header.attractors[label])}`;
  }

  #open(x, y) {
    if (!this.study) return;
    const start = { ...this.study.start, x0: String(Number(x.toPrecision(6))), v0: String(Number(y.toPrecision(6))) };
    this.app.open({ ...this.study, start });
    say(this.app.root, `starts at x = ${shown(x)}, v = ${shown(y)}`);
  }
}

function colourOf(label) {
  if (label === -1) return UNDECIDED;
  if (label < 0) return NO_START;
  return COLOURS[label % COLOURS.length];
}

function nameOf({ kind, n_impacts: impacts, n_periods: periods }) {
  return kind === "periodic" ? `periodic (${impacts ?? "∞"}, ${periods})` : kind;
}

const percent = (share) => `${shown(100 * share, 3)} %`;

function row(colour, name, note) {
  const swatch = element("span", { class: "swatch" });
  swatch.style.backgroundColor = `rgb(${colour.join()})`;
  return element("li", {}, swatch, element("span", {}, name), element("span", { class: "note" }, note));
}
