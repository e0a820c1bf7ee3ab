// The sound of a moving picture: a click at each impact, louder for faster ones.

import { button } from "./dom.js";
import { after } from "./scales.js";

// Clicks that follow one another sooner are heard as one [s].
const APART = 0.012;
// The slowest impact that is heard, as a part of the fastest one.
const LEAST = 0.02;
const LOUDEST = 0.35;

/**
 * Return the clicks {time, delay, loudness} of the impacts in (from, to], of a motion that runs at a rate.
 *
 * delay: seconds until it is heard; loudness: the speed of the impact as a part of the fastest one.
 */
export function clicksBetween({ times, speeds, fastest }, from, to, rate) {
  const found = [];
  for (let i = after(times, from); i < times.length && times[i] <= to; i += 1) {
    const loudness = fastest > 0 ? speeds[i] / fastest : 0;
    if (loudness >= LEAST) found.push({ time: times[i], delay: (times[i] - from) / rate, loudness });
  }
  return found;
}

/** A button that lets impacts be heard; they are mute at first. */
export class Clicks {
  constructor() {
    this.isOn = false;
    this.last = -Infinity;
    this.impacts = { times: [], speeds: [], fastest: 0 };
    this.button = button("♪ Sound", () => this.#toggle(), { class: "sound", "aria-pressed": "false", title: "a click at each impact, louder for faster ones" });
  }

  /** Take the times of impacts, in order, and their speeds. */
  take(times, speeds) {
    let fastest = 0;
    for (const speed of speeds) fastest = Math.max(fastest, speed);
    this.impacts = { times, speeds, fastest };
  }

  /** The picture moves from a time to another at a rate [time per second]. */
  pass(from, to, rate) {
    if (!this.isOn) return;
    for (const { delay, loudness } of clicksBetween(this.impacts, from, to, rate)) this.#click(this.context.currentTime + delay, loudness);
  }

  close() {
    this.context?.close();
    this.context = undefined;
    this.isOn = false;
  }

  #toggle() {
    this.isOn = !this.isOn;
    // Browsers let a page sound after a click on it alone.
    if (this.isOn) this.context ??= new AudioContext();
    if (this.isOn) this.context.resume();
    this.button.setAttribute("aria-pressed", String(this.isOn));
  }

  /** A short tone that dies away at once. */
  #click(time, loudness) {
    if (time < this.last + APART) return;
    this.last = time;
    const { context } = this;
    const tone = context.createOscillator();
    const gain = context.createGain();
    tone.type = "triangle";
    tone.frequency.setValueAtTime(1400, time);
    tone.frequency.exponentialRampToValueAtTime(300, time + 0.03);
    gain.gain.setValueAtTime(LOUDEST * loudness, time);
    gain.gain.exponentialRampToValueAtTime(1e-4, time + 0.05);
    tone.connect(gain).connect(context.destination);
    tone.start(time);
    tone.stop(time + 0.06);
  }
}
