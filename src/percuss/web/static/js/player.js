// The time of a moving picture: a slider, and a button that lets it run.

import { button, element, shown } from "./dom.js";

// A forcing period lasts so long in the picture [s].
const SLOW = 1.5;
const STEPS = 1000;

/** A player that calls show(time). */
export class Player {
  constructor(show) {
    this.show = show;
    this.readout = element("output", { class: "readout" });
    this.button = button("▶ Play", () => this.#toggle(), { "aria-pressed": "false" });
    this.slider = element("input", {
      type: "range", min: "0", max: String(STEPS), step: "1", value: "0", "aria-label": "time of the picture",
      oninput: () => {
        this.#stop();
        this.#to(this.low + (Number(this.slider.value) / STEPS) * (this.high - this.low));
      },
    });
    this.root = element("div", { class: "player" }, this.button, this.slider);
    this.take(0, 0, null);
  }

  /** Take the times of a motion; the picture stays at its time, if that is among them. */
  take(low, high, period) {
    Object.assign(this, { low, high, rate: (period ?? 2 * Math.PI) / SLOW });
    this.slider.disabled = this.button.disabled = !(high > low);
    this.#to(Math.min(Math.max(this.time ?? low, low), high));
  }

  /** Show another time for a while; null for that of the slider again. */
  peek(time) {
    if (this.moving === undefined) this.#shown(time ?? this.time);
  }

  close() {
    this.#stop();
  }

  #to(time) {
    this.time = time;
    const share = this.high > this.low ? (time - this.low) / (this.high - this.low) : 0;
    this.slider.value = String(Math.round(STEPS * share));
    this.#shown(time);
  }

  #shown(time) {
    const text = `t = ${shown(time, 5)}`;
    this.readout.textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
    this.show(time);
  }

  #toggle() {
    if (this.moving !== undefined) {
      this.#stop();
      return;
    }
    this.#label("❚❚ Pause", true);
    let before = null;
    const step = (now) => {
      const passed = before === null ? 0 : Math.min(0.1, (now - before) / 1000);
      before = now;
      // A picture that is not seen waits.
      if (this.root.offsetParent !== null && this.high > this.low) {
        const next = this.time + passed * this.rate;
        this.#to(next > this.high ? this.low : next);
      }
      this.moving = requestAnimationFrame(step);
    };
    this.moving = requestAnimationFrame(step);
  }

  #stop() {
    cancelAnimationFrame(this.moving);
    this.moving = undefined;
    this.#label("▶ Play", false);
  }

  #label(text, isPressed) {
    this.button.textContent = text;
    this.button.setAttribute("aria-pressed", String(isPressed));
  }
}
