// One motion: x(t), phase portrait, impacts and spectrum, and what percuss knows of it.

import { Panel } from "./controls.js";
import { element } from "./dom.js";
import { Facts } from "./facts.js";
import { numberOf } from "./models.js";
import { Plot } from "./plots.js";
import { bisect } from "./scales.js";

const POINTS = 4000;
// A slider that rests so long asks for the orbit too [ms].
const RESTED = 250;
// The first answer of all may wait for the compiler [ms].
const COMPILING = 1500;

/** Build the view. */
export class Explore {
  constructor(app) {
    this.app = app;
    this.store = app.store;
    this.panel = new Panel(this.store, app.prefix, () => this.#settle());
    this.facts = new Facts();
    this.general = element("p", { class: "fault", role: "alert" });
    this.window = null;
    this.orbit = null;
    this.#plots();
    this.root = element(
      "section",
      { class: "explore", "aria-label": "Explore" },
      element("aside", {}, this.panel.root),
      element(
        "div",
        { class: "stage" },
        this.general,
        this.facts.root,
        element("div", { class: "plots" }, ...this.plots.map((plot) => plot.root)),
      ),
    );
    this.store.watch((state, why) => {
      if (why === "study" || why === "all") this.ask(why === "all");
    });
  }

  #plots() {
    this.motion = new Plot({
      title: "Displacement", x: "time t", y: "displacement x", kind: "line", names: ["t", "x"],
      about: "x(t); dashed: the stops",
      onZoom: (zoom) => {
        this.window = zoom === null ? null : zoom.x;
        this.ask(false);
      },
      onHover: (index) => this.#link(index === null ? null : this.curve?.t[index]),
    });
    this.portrait = new Plot({
      title: "Phase portrait", x: "displacement x", y: "velocity v", kind: "portrait", names: ["x", "v"],
      about: "velocity over displacement; at an impact the velocity jumps",
      onHover: (index) => this.#linkBack(index),
    });
    this.section = new Plot({
      title: "Impacts", x: "cycle (t / period) mod 1", y: "impact speed", kind: "points", names: ["cycle", "speed"],
      about: "each impact: when in the forcing period, and how fast; few points: periodic, a cloud: chaotic",
    });
    this.spectrum = new Plot({
      title: "Spectrum", x: "angular frequency omega", y: "amplitude", kind: "line", logY: true, names: ["omega", "amplitude"],
      about: "amplitudes of x(t) in the later part of the run; a periodic motion has lines, a chaotic one a carpet",
    });
    this.plots = [this.motion, this.portrait, this.section, this.spectrum];
  }

  recolour() {
    for (const plot of this.plots) plot.recolour();
  }

  /** No hand is on a slider any more. */
  #settle() {
    for (const plot of this.plots) plot.settle();
  }

  close() {
    clearTimeout(this.resting);
    clearTimeout(this.starting);
    this.panel.close();
    for (const plot of this.plots) plot.close();
  }

  /** Ask for the motion as it is set now. */
  ask(isNew) {
    if (isNew) {
      this.window = null;
      for (const plot of this.plots) plot.zoom = null;
    }
    const { study } = this.store.value;
    this.asked = performance.now();
    this.app.questions.ask(
      "explore",
      { kind: "explore", study, points: POINTS, window: this.window },
      { answer: (header, arrays) => this.#show(study, header, arrays), fault: (faults) => this.#faults(faults) },
    );
    if (!this.curve) {
      this.starting = setTimeout(() => {
        if (!this.curve) this.facts.outcome.show("starting", "the first start compiles the engine; some ten seconds, once");
      }, COMPILING);
    }
    clearTimeout(this.resting);
    this.resting = setTimeout(() => this.#askFacts(study), RESTED);
  }

  #askFacts(study) {
    this.app.questions.ask(
      "facts",
      { kind: "facts", study },
      {
        answer: (header, arrays) => {
          if (this.store.value.study !== study) return;
          this.orbit = header.orbit === null ? null : arrays;
          this.facts.showOrbit(header.orbit);
          if (this.curve) this.#drawPortrait();
        },
        fault: () => this.facts.showOrbit(null),
      },
    );
  }

  #faults(faults) {
    this.general.textContent = this.panel.showFaults(faults).join("; ");
    this.root.classList.add("stale");
  }

  #show(study, header, arrays) {
    this.panel.showFaults([]);
    this.general.textContent = "";
    this.root.classList.remove("stale");
    if (study !== this.study) this.orbit = null;
    this.study = study;
    this.curve = arrays;
    this.walls = (study.oscillator.stops ?? []).map((stop) => ({ at: numberOf(stop.at), colour: stop.type === "wall" ? "--wall" : "--stop" }));
    const isHeld = this.panel.isHeld;
    this.motion.show(
      [{ x: arrays.t, y: arrays.x, colour: "--curve" }],
      this.walls.map(({ at, colour }) => ({ y: at, colour })),
      null,
      isHeld,
    );
    this.#drawPortrait(isHeld);
    this.section.show([{ x: arrays.cycle, y: arrays.speed, kind: "points", colour: "--curve", size: arrays.cycle.length < 200 ? 5 : 2.5 }], [], sectionLimits(arrays), isHeld);
    if (arrays.cycle.length === 0) this.section.say("no impacts");
    this.spectrum.show([{ x: arrays.omega, y: arrays.amplitude, colour: "--curve" }], [], null, isHeld);
    if (!arrays.amplitude.some((value) => value > 0)) this.spectrum.say("nothing moves in the later part");
    this.facts.showMotion(header, study !== this.store.value.study);
    // For whoever measures how long a slider takes.
    this.root.dataset.drawn = String(performance.now());
    this.root.dispatchEvent(new CustomEvent("drawn", { detail: { asked: this.asked }, bubbles: true }));
  }

  #drawPortrait(isHeld = this.panel.isHeld) {
    const { portrait_x: x, portrait_v: v } = this.curve;
    const layers = [{ x, y: v, colour: "--curve" }];
    if (this.orbit?.orbit_x) layers.push({ x: this.orbit.orbit_x, y: this.orbit.orbit_v, colour: "--orbit", width: 2, dash: [5, 4], isAside: true });
    this.portrait.key.textContent = layers.length > 1 ? "dashed: nearest periodic orbit" : "";
    this.portrait.show(layers, this.walls.map(({ at, colour }) => ({ x: at, colour })), null, isHeld);
  }

  /** Mark in the portrait where the motion is at a time. */
  #link(time) {
    const curve = this.curve;
    if (time === null || !curve || curve.portrait_t.length === 0 || time < curve.portrait_t[0]) {
      this.portrait.point(null);
      return;
    }
    const index = bisect(curve.portrait_t, time);
    this.portrait.point(curve.portrait_x[index], curve.portrait_v[index]);
  }

  #linkBack(index) {
    const curve = this.curve;
    if (index === null || !curve) this.motion.point(null);
    else this.motion.point(curve.portrait_t[index], curve.portrait_x[index]);
  }
}

/** A cycle is from 0 to 1, a speed from 0 on. */
function sectionLimits({ speed }) {
  let high = 0;
  for (const value of speed) high = Math.max(high, value);
  // A little more, so that dots on the edge are seen whole.
  return { x: [-0.015, 1.015], y: [0, high > 0 ? 1.08 * high : 1] };
}
