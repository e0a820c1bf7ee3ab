// The tour: five steps through period doubling, chaos, grazing and chatter, each a motion to play with.

import { button, element } from "./dom.js";

const WALL = { type: "wall", at: 0, side: "below", restitution: "0.8" };
const OMEGA = "forcing.harmonics.0.omega";
// A wall where the mass rests. The start leads to the family that doubles; another motion goes beside it.
const cascade = (omega) => ({
  oscillator: { stiffness: 1, damping: 0, stops: [WALL] },
  forcing: { harmonics: [{ amplitude: 1, omega, phase: 0 }] },
  start: { x0: 0, v0: "0.4", t0: "2.37" },
  run: { periods: 120 },
});
// At resonance the free motion is ten times as large as the force: it reaches the wall at an amplitude of 0.1.
const GRAZE = {
  oscillator: { stiffness: 1, damping: "0.05", stops: [{ type: "wall", at: 1, side: "above", restitution: "0.8" }] },
  forcing: { harmonics: [{ amplitude: "0.102", omega: 1, phase: 0 }] },
  start: { x0: 0, v0: 0 },
  run: { periods: 150 },
};
const CHATTER = {
  oscillator: { stiffness: 1, damping: 0, stops: [{ ...WALL, restitution: "0.5" }] },
  forcing: { constant: "-0.6", harmonics: [{ amplitude: 1, omega: "0.8", phase: 0 }] },
  start: { x0: 1, v0: 0 },
  run: { periods: 12 },
};
const DIAGRAM = { kind: "diagram", path: OMEGA, low: 2.6, high: 2.8, values: 1600, points: 128, of: "x", isComputed: true };

const STEPS = [
  {
    title: "One impact in each period",
    text: "A mass on a spring is driven, and hits a wall where it rests: each impact keeps 0.8 of its speed. The motion settles to one impact in each forcing period: all its later impacts are one dot in Impacts. Play lets the mass move.",
    card: "The card of the nearest periodic orbit says (1, 1), stable.",
    state: { study: cascade("2.6"), view: "explore", ranges: { [OMEGA]: [2.6, 2.8] } },
  },
  {
    title: "The period doubles",
    text: "At omega = 2.6533 a multiplier of that orbit passes −1, and it loses its stability: now two impacts in two periods differ, two dots. Drag omega from 2.6 to 2.72 and watch the dots part; at 2.716 they double again.",
    state: { study: cascade("2.68"), view: "explore", ranges: { [OMEGA]: [2.6, 2.8] } },
  },
  {
    title: "Doubling after doubling, to chaos",
    text: "All of them at once: over each omega the places of the mass at whole periods. The doublings follow each other at distances that shrink by about 4.7 each time, up to 2.732. From 2.71 on the start goes in places to another attractor, which stands beside this family. Clouds are chaos, with windows of periodic motion between them: click into one to see such a motion in Explore.",
    state: { study: cascade("2.68"), view: "diagram", diagram: DIAGRAM },
  },
  {
    title: "A graze",
    text: "Here the wall stands where a weak force just carries the mass: at an amplitude of 0.1 it touches the wall with no speed, a graze. Drag the amplitude down from 0.102: the impacts become slower like a square root, and below 0.1 they are gone at once.",
    state: { study: GRAZE, view: "explore", ranges: { "forcing.harmonics.0.amplitude": [0.099, 0.103] } },
  },
  {
    title: "Chatter and sticking",
    text: "A steady push holds the mass at the wall. Its hops shrink by half each time: infinitely many impacts in a finite time, summed exactly, after which the mass stays until the force lifts it off. Zoom into the hops by dragging over them. The card Contacts lists where it stays.",
    state: { study: CHATTER, view: "explore", ranges: {} },
  },
];

export class Tour {
  constructor(app) {
    this.app = app;
    this.title = element("h2", {});
    this.text = element("p", { "aria-live": "polite" });
    this.back = button("Back", () => this.go(this.step - 1));
    this.next = button("Next", () => this.go(this.step + 1), { class: "primary" });
    this.root = element("aside", { class: "tour", "aria-label": "Tour", hidden: true }, this.title, this.text, element("div", { class: "tools" }, this.back, this.next, button("End", () => this.end())));
    this.step = -1;
    app.store.watch((state, why) => why === "all" && this.#show(state.tour));
    this.#show(app.store.value.tour);
  }

  /** Begin a step; behind the last one the tour ends. */
  go(step) {
    if (step >= STEPS.length) {
      this.end();
      return;
    }
    this.app.show({ ...STEPS[step].state, tour: step });
    // At the first step the keyboard comes from the head of the page, or from the button that has none to go back to.
    if (step === 0) this.next.focus();
  }

  end() {
    this.app.store.set({ tour: undefined }, "all");
    this.opener?.focus();
  }

  #show(step) {
    this.root.hidden = !Number.isInteger(step) || STEPS[step] === undefined;
    if (this.root.hidden) return;
    this.step = step;
    this.title.textContent = `${step + 1} of ${STEPS.length}: ${STEPS[step].title}`;
    // Without a server that card has no orbit.
    const { text, card } = STEPS[step];
    this.text.textContent = card && !this.app.options.isStatic ? `${text} ${card}` : text;
    this.back.disabled = step === 0;
    this.next.textContent = step === STEPS.length - 1 ? "Done" : "Next";
  }
}
