// The motion at a place of a diagram: its phase portrait, and its displacement over time.

import { element } from "./dom.js";
import { axesOf } from "./models.js";
import { MOTION, PORTRAIT, Plot } from "./plots.js";

// Forcing periods that are seen of it.
const SHOWN = 12;
const POINTS = 3000;

/** Two small plots that follow a pointer. */
export class Beside {
  constructor(app) {
    this.app = app;
    this.portrait = new Plot({ ...PORTRAIT, about: "the phase portrait of the motion at the pointer" });
    this.motion = new Plot({ ...MOTION, about: "the end of the motion at the pointer" });
    this.root = element("div", { class: "beside" }, this.portrait.root, this.motion.root);
    this.clear();
  }

  /** Show a motion on an attractor or, with some settling, towards it. */
  show(study, name, settling = 0) {
    const asked = { ...study, run: { periods: settling + SHOWN } };
    const key = JSON.stringify(asked);
    if (key === this.key) return;
    this.key = key;
    const isNewest = () => this.key === key;
    this.app.requests.put("beside", { kind: "beside", study: asked, points: POINTS, window: null }, {
      // What comes late is still nearer to the pointer than what is shown.
      answer: (header, arrays) => this.#draw(asked, name, header, arrays),
      fault: (faults) => isNewest() && this.#wait(faults.map(({ reason }) => reason).join("; ")),
    });
  }

  /** Forget the motion. */
  clear() {
    this.key = "";
    this.portrait.rename("Motion at the pointer");
    this.#wait("shown while the pointer is over the diagram");
  }

  #wait(text) {
    for (const plot of [this.portrait, this.motion]) plot.wait(text, { x: [0, 1], y: [-1, 1] });
  }

  #draw(study, name, { t_end: end, period, elements }, { t, x, portrait_t: at, portrait_x: across, portrait_v: upwards }) {
    const axes = axesOf(study);
    const from = period === null ? t[0] : Math.max(t[0], end - SHOWN * period);
    const stops = elements.stops.map(({ at: place, type }) => ({ place, colour: type === "wall" ? "--wall" : "--stop" }));
    const tail = at.findIndex((time) => time >= from);
    this.portrait.rename(`Motion at ${name}`);
    this.portrait.label(axes.x, axes.v);
    this.portrait.show([{ x: across.subarray(tail), y: upwards.subarray(tail), colour: "--curve" }], stops.map(({ place, colour }) => ({ x: place, colour })));
    const first = t.findIndex((time) => time >= from);
    this.motion.label(axes.t, axes.x);
    this.motion.show([{ x: t.subarray(first), y: x.subarray(first), colour: "--curve" }], stops.map(({ place, colour }) => ({ y: place, colour })));
  }
}
