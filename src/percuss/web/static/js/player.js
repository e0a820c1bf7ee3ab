// The time of a moving picture: a slider, a button that lets it run, its speed and its sound.

import { Clicks } from "./clicks.js";
import { button, element, shown } from "./dom.js";
import { choiceField } from "./fields.js";

// A forcing period lasts so long in the picture [s].
const SLOW = 1.5;
const STEPS = 1000;
const SPEEDS = [["0.1", "1/10"], ["0.25", "1/4"], ["0.5", "1/2"], ["1", "1"], ["2", "2"], ["4", "4"]];

/** A player that calls show(time). */
export class Player {
  constructor(show) {
    this.show = show;
    this.factor = 1;
    this.isNew = true;
    this.clicks = new Clicks();
    this.readout = element("output", { class: "readout", "aria-live": "off" });
    this.button = button("▶ Play", () => this.#toggle(), { "aria-pressed": "false" });
    this.slider = element("input", {
      type: "range", min: "0", max: String(STEPS), step: "1", value: "0", "aria-label": "time of the picture",
      oninput: () => {
        this.stop();
        this.go(this.low + (Number(this.slider.value) / STEPS) * (this.high - this.low));
      },
    });
    this.speed = choiceField("speed", SPEEDS, "1", (value) => {
      this.factor = Number(value);
    });
    this.speed.className = "speed";
    this.speed.title = `1: a forcing period in ${SLOW} s`;
    this.root = element("div", { class: "player" }, this.button, this.slider, this.speed, this.clicks.button);
    this.take(0, 0, null);
  }

  /** Take the times of a motion; the picture stays at its time, if that is among them. */
  take(low, high, period) {
    Object.assign(this, { low, high, usual: (period ?? 2 * Math.PI) / SLOW });
    this.slider.disabled = this.button.disabled = !(high > low);
    this.go(this.isNew ? low : Math.min(Math.max(this.time, low), high));
    this.isNew = false;
  }

  /** The next times are those of another motion, which is seen from its start. */
  rewind() {
    this.isNew = true;
  }

  /** Show another time for a while; null for that of the slider again. */
  peek(time) {
    if (this.moving === undefined) this.#shown(time ?? this.time);
  }

  /** Move to a time. */
  go(time) {
    this.time = time;
    const share = this.high > this.low ? (time - this.low) / (this.high - this.low) : 0;
    this.slider.value = String(Math.round(STEPS * share));
    this.#shown(time);
  }

  stop() {
    cancelAnimationFrame(this.moving);
    this.moving = undefined;
    this.#label("▶ Play", false);
  }

  close() {
    this.stop();
    this.clicks.close();
  }

  #shown(time) {
    const text = `t = ${shown(time, 5)}`;
    this.readout.textContent = text;
    this.slider.setAttribute("aria-valuetext", text);
    this.show(time);
  }

  #toggle() {
    if (this.moving !== undefined) {
      this.stop();
      return;
    }
    this.#label("❚❚ Pause", true);
    // A motion that is at its end begins again.
    if (this.time >= this.high) this.go(this.low);
    let before = null;
    const step = (now) => {
      const passed = before === null ? 0 : Math.min(0.1, (now - before) / 1000);
      before = now;
      // A picture that is not seen waits.
      if (this.root.offsetParent !== null && this.high > this.low) this.#pass(passed);
      this.moving = requestAnimationFrame(step);
    };
    this.moving = requestAnimationFrame(step);
  }

  /** Let some seconds pass; at the end it begins again. */
  #pass(seconds) {
    const rate = this.usual * this.factor;
    const next = this.time + seconds * rate;
    this.clicks.pass(this.time, Math.min(next, this.high), rate);
    this.go(next > this.high ? this.low : next);
  }

  #label(text, isPressed) {
    this.button.textContent = text;
    this.button.setAttribute("aria-pressed", String(isPressed));
  }
}
