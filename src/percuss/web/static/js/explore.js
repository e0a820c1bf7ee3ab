// One motion: its picture, x(t), phase portrait, impacts, v(t), forces, spectrum, and facts about it.

import { Certify } from "./certify.js";
import { Panel } from "./controls.js";
import { button, element, shown } from "./dom.js";
import { Facts } from "./facts.js";
import { axesOf, differences } from "./models.js";
import { OscillatorPicture } from "./oscillator_picture.js";
import { MOTION, PORTRAIT, Plot } from "./plots.js";
import { after, between, endsOf } from "./scales.js";
import { put } from "./state.js";
import { FORCES, IMPACTS, showForces } from "./stop_forces.js";

const POINTS = 4000;
// The facts are requested once a slider has rested so long [ms].
const RESTED = 250;
// After so long without a first answer the server is taken to compile [ms].
const COMPILING = 1500;

/** Build the view. */
export class Explore {
  constructor(app) {
    this.app = app;
    this.store = app.store;
    this.panel = new Panel(this.store, app.prefix, () => this.#settle(), (csv, columns, handlers) => app.requests.put("record", { kind: "record", study: this.store.value.study, csv, ...columns }, handlers));
    this.facts = new Facts();
    if (app.options.isStatic) this.facts.showMissing();
    this.general = element("p", { class: "fault", role: "alert" });
    this.window = null;
    this.orbit = null;
    this.#plots();
    this.kept = null;
    this.keeper = button("keep", () => this.#keep(), { "aria-pressed": "false", title: "keep this motion, pale behind the next ones, to compare two settings" });
    this.motion.root.querySelector("figcaption").append(this.keeper);
    this.drawing = new OscillatorPicture({
      onTime: (time) => this.#mark(time),
      start: (x0) => this.store.set({ study: put(this.store.value.study, "start.x0", x0) }, "study"),
      x0: () => this.store.value.study.start.x0,
    });
    this.#takeZooms();
    if (app.options.facts.certified) {
      this.certify = new Certify(app, () => this.#drawMotion());
      this.facts.outcome.root.append(element("dd", { class: "act" }, this.certify.opener));
    }
    this.aside = element("aside", {}, this.panel.root);
    this.root = element(
      "section",
      { class: "explore", "aria-label": "Explore" },
      this.aside,
      element(
        "div",
        { class: "stage" },
        this.general,
        this.facts.summary,
        this.facts.root,
        this.certify?.root,
        element("div", { class: "plots" }, this.motion.root, this.drawing.root, ...this.plots.slice(1).map((plot) => plot.root)),
      ),
    );
    this.store.watch((state, why) => {
      if (why === "study" || why === "all") this.ask(why === "all");
    });
  }

  #plots() {
    this.motion = new Plot({
      ...MOTION, isTime: true,
      about: "x(t); dashed: the stops",
      onZoom: (zoom) => this.#zoomTime(zoom),
      onHover: (index) => this.#peek("t", index),
    });
    this.portrait = new Plot({
      ...PORTRAIT,
      about: "velocity over displacement, pale in the first half of the run; at an impact the velocity jumps",
      onZoom: (zoom) => this.app.keepZoom("portrait", zoom),
      onHover: (index) => this.#peek("portrait_t", index),
    });
    this.section = new Plot({
      ...IMPACTS, names: [...IMPACTS.names],
      about: "each impact, pale in the first half of the run: when in the forcing period, or without one at which time, and how fast; few points: periodic, a cloud: chaotic",
      onZoom: (zoom) => this.app.keepZoom("section", zoom),
      onHover: (index) => this.#peek("event_t", index),
    });
    // Both show the times that the displacement shows.
    const follows = (zoom, plot) => {
      this.zoomed = plot;
      if (zoom === null) this.motion.reset();
      else this.motion.setZoom(zoom.x, this.motion.limits.y);
      this.zoomed = undefined;
    };
    this.velocity = new Plot({
      title: "Velocity", x: "time t", y: "velocity v", kind: "line", names: ["t", "v"], isTime: true, isFollower: true,
      about: "v(t); at an impact it jumps",
      onZoom: (zoom) => follows(zoom, this.velocity),
      onHover: (index) => this.#peek("velocity_t", index),
    });
    this.forces = new Plot({
      ...FORCES, isTime: true, isFollower: true,
      onZoom: (zoom) => follows(zoom, this.forces),
      onHover: (index) => this.drawing.player.peek(index === null ? null : (this.forces.layers[0]?.x[index] ?? null)),
    });
    this.spectrum = new Plot({
      title: "Spectrum", x: "angular frequency omega", y: "amplitude", kind: "line", logY: true, names: ["omega", "amplitude"],
      about: "amplitudes of x(t) in the later part of the run; a periodic motion has lines, a chaotic one a carpet",
      onZoom: (zoom) => this.app.keepZoom("spectrum", zoom),
    });
    this.spectrum.root.classList.add("broad");
    this.plots = [this.motion, this.portrait, this.section, this.velocity, this.forces, this.spectrum];
  }

  /** Another part of the time is seen, in all plots over time. */
  #zoomTime(zoom) {
    this.window = zoom === null ? null : zoom.x;
    for (const plot of [this.velocity, this.forces]) if (plot !== this.zoomed) plot.take(null);
    this.app.keepZoom("motion", zoom);
    this.ask(false);
  }

  /** Zoom to the parts that a link holds. */
  #takeZooms() {
    const { zooms = {} } = this.store.value;
    for (const name of ["motion", "portrait", "section", "spectrum"]) this[name].take(zooms[name] ?? null);
    this.window = zooms.motion?.x ?? null;
  }

  /** The parameters may have been beside a diagram. */
  shown() {
    this.aside.append(this.panel.root);
  }

  /** Another motion is to come. */
  begin() {
    this.drawing.player.rewind();
  }

  /** All sliders are released. */
  #settle() {
    for (const plot of this.plots) plot.settle();
  }

  close() {
    clearTimeout(this.resting);
    clearTimeout(this.starting);
    this.panel.close();
    this.drawing.close();
  }

  /** Request the motion as it is set now. */
  ask(isNew) {
    if (isNew) this.#takeZooms();
    const { study } = this.store.value;
    this.asked = performance.now();
    this.app.requests.put(
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
    this.app.requests.put(
      "facts",
      { kind: "facts", study },
      {
        answer: (header, arrays) => {
          if (this.store.value.study !== study) return;
          this.known = { study, header, arrays };
          if (this.app.options.isStatic) {
            this.facts.showAlone(header);
            return;
          }
          this.facts.showOrbit(header.orbit, header.hits);
          if (this.study !== study) return;
          this.#takeOrbit();
          this.facts.showExponent(header);
          this.#drawPortrait();
        },
        fault: () => {
          if (this.app.options.isStatic) this.facts.showMissing();
          // After a wrong value the cards keep the facts of the motion before.
          else if (!this.root.classList.contains("stale")) this.facts.showOrbit(null);
        },
      },
    );
  }

  #faults(faults) {
    this.general.textContent = this.panel.showFaults(faults).join("; ");
    this.root.classList.add("stale");
    clearTimeout(this.starting);
    if (!this.curve) this.facts.outcome.show("no motion", "");
  }

  #show(study, header, arrays) {
    this.panel.showFaults([]);
    this.panel.accept(study);
    this.general.textContent = "";
    this.root.classList.remove("stale");
    this.study = study;
    this.span = [header.t0, header.t_end];
    const known = this.#takeOrbit();
    this.curve = arrays;
    const { stops } = header.elements;
    this.walls = stops.map(({ at, type }) => ({ at, colour: type === "wall" ? "--wall" : "--stop" }));
    const { isHeld } = this;
    const axes = axesOf(study);
    this.motion.label(axes.t, axes.x);
    this.portrait.label(axes.x, axes.v);
    this.velocity.label(axes.t, axes.v);
    // Without a period the impacts are shown over time.
    this.when = header.period === null ? "event_t" : "cycle";
    this.section.label(header.period === null ? axes.t : IMPACTS.x, axes.speed);
    this.section.options.names[0] = header.period === null ? "t" : "cycle";
    this.spectrum.label(axes.omega, axes.amplitude);
    this.#drawMotion(isHeld);
    this.#drawPortrait(isHeld);
    const impacts = { x: arrays[this.when], y: arrays.speed, since: this.#half(arrays.event_t), kind: "points", colour: "--curve", size: arrays.cycle.length < 200 ? 5 : 2.5 };
    this.section.show([impacts], [], sectionLimits(arrays, header.period === null ? this.span : [0, 1]), isHeld);
    if (arrays.cycle.length === 0) this.section.say("no impacts");
    this.velocity.show([{ x: arrays.velocity_t, y: arrays.v, colour: "--curve" }], [], null, isHeld);
    this.acting = showForces(this.forces, arrays, stops, axes, isHeld)[0];
    this.spectrum.show([{ x: arrays.omega, y: arrays.amplitude, colour: "--curve" }], [], null, isHeld);
    if (!arrays.amplitude.some((value) => value > 0)) this.spectrum.say("nothing moves in the later part");
    this.drawing.take(study, header, arrays, isHeld);
    this.facts.showMotion(header);
    this.facts.isKnown(known !== null);
    if (known !== null && !this.app.options.isStatic) this.facts.showExponent(known.header);
    // Tests measure the delay of a slider by this event.
    this.root.dataset.drawn = String(performance.now());
    this.root.dispatchEvent(new CustomEvent("drawn", { detail: { asked: this.asked }, bubbles: true }));
  }

  /** Return the first of some times in the second half of the run: what comes before is drawn pale. */
  #half(times) {
    return after(times, (this.span[0] + this.span[1]) / 2);
  }

  /** Keep the motion that is shown, to be seen pale behind others; or forget it. */
  #keep() {
    const { t, x, portrait_x: portraitX, portrait_v: portraitV } = this.curve ?? {};
    this.kept = this.kept || t === undefined ? null : { t, x, portraitX, portraitV, study: this.study };
    this.keeper.textContent = this.kept ? "forget" : "keep";
    this.keeper.setAttribute("aria-pressed", String(this.kept !== null));
    if (!this.curve) return;
    this.#drawMotion();
    this.#drawPortrait();
  }

  /** Take the orbit near the motion that is shown; its answer may come before the curve, or never. */
  #takeOrbit() {
    const known = this.known?.study === this.study ? this.known : null;
    this.orbit = known?.header.orbit ? known.arrays : null;
    this.isFormal = this.orbit !== null && !known.header.orbit.admissible;
    return known;
  }

  #drawMotion(isHeld = this.isHeld) {
    if (!this.curve) return;
    const { t, x } = this.curve;
    const lines = this.walls.map(({ at, colour }) => ({ y: at, colour }));
    // Where the proof ends, if it ends in the picture.
    const until = this.certify?.until ?? null;
    const isSeen = until !== null && t.length > 0 && until > t[0] && until < t[t.length - 1];
    const proven = isSeen ? [{ x: until, colour: "--c3" }] : [];
    const kept = this.kept ? ["pale: the kept motion", differences(this.kept.study, this.study)].filter(Boolean).join(", ") : "";
    this.motion.key.textContent = this.motion.key.title = [isSeen ? "proven up to the green line" : "", kept].filter(Boolean).join("; ");
    const before = this.kept ? [{ x: this.kept.t, y: this.kept.x, colour: "--pale", isAside: true, isBehind: true }] : [];
    this.motion.show([{ x: t, y: x, colour: "--curve" }, ...before], [...lines, ...proven], null, isHeld);
  }

  #drawPortrait(isHeld = this.isHeld) {
    const { portrait_t: t, portrait_x: x, portrait_v: v } = this.curve;
    const layers = [{ x, y: v, since: this.#half(t), colour: "--curve" }];
    if (this.kept) layers.push({ x: this.kept.portraitX, y: this.kept.portraitV, colour: "--pale", isAside: true, isBehind: true });
    // A formal orbit, which no motion follows, is drawn faintly.
    const look = this.isFormal ? { colour: "--faint", width: 1, dash: [2, 4] } : { colour: "--orbit", width: 2, dash: [5, 4] };
    if (this.orbit?.orbit_x) layers.push({ x: this.orbit.orbit_x, y: this.orbit.orbit_v, ...look, isAside: true });
    this.portrait.key.textContent = !this.orbit?.orbit_x ? "" : this.isFormal ? "dotted: a formal orbit" : "dashed: nearest orbit";
    const [from, to] = [this.curve.portrait_t[0], this.curve.portrait_t.at(-1)];
    const isPart = this.span !== undefined && (from > this.span[0] + 1e-3 || to < this.span[1] - 1e-3);
    this.portrait.rename(isPart ? `Phase portrait, t = ${shown(from, 3)} to ${shown(to, 3)}` : "Phase portrait");
    this.portrait.show(layers, this.walls.map(({ at, colour }) => ({ x: at, colour })), null, isHeld);
  }

  /** While a slider or the mass is held the axes stand still. */
  get isHeld() {
    return this.panel.isHeld || this.drawing.isDragged === true;
  }

  /** A time under the pointer is shown while it is there; then that of the player again. */
  #peek(name, index) {
    this.drawing.player.peek(index === null ? null : (this.curve?.[name][index] ?? null));
  }

  /** Mark the state at a time in all plots; among the impacts the last one until then. */
  #mark(time) {
    const { curve } = this;
    const [x, v] = [between(curve.t, curve.x, time), between(curve.velocity_t, curve.v, time)];
    this.motion.point(time, x);
    this.velocity.point(time, v);
    this.portrait.point(x, v);
    // Where no force acts the cursor has no dot.
    this.forces.point(time, this.acting ? between(this.acting.x, this.acting.y, time) : Number.NaN);
    const last = after(curve.event_t, time) - 1;
    this.section.point(last < 0 ? null : curve[this.when][last], curve.speed[last]);
  }
}

/** Limits of the impacts: a cycle is from 0 to 1, a time in the run, a speed from 0 on. */
function sectionLimits({ speed }, [from, to]) {
  const [, high] = endsOf(speed);
  // A margin, so that dots on the edge are not cut off.
  const margin = 0.015 * (to - from || 1);
  return { x: [from - margin, to + margin], y: [0, high > 0 ? 1.08 * high : 1] };
}
