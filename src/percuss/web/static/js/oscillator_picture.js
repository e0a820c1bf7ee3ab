// One mass that moves in its mechanical picture, and is put to its start by hand.

import { element, shape, shown } from "./dom.js";
import { MechanismPicture } from "./mechanism_picture.js";
import { isTied, limitsOf, named, numberOf, startAt, unitsOf } from "./models.js";
import { Player } from "./player.js";
import { typed } from "./row.js";
import { between, endsOf, grown } from "./scales.js";

// Keys move the mass by about this part of the range of the picture, with Shift by a tenth of it.
const STEP = 1 / 50;
const KEYS = { ArrowRight: 1, ArrowUp: 1, ArrowLeft: -1, ArrowDown: -1 };

export class OscillatorPicture {
  /**
   * onTime(time) is called when the picture moves, start(x0) when the mass is put elsewhere;
   * x0() returns the start as it is set now, which the motion that is drawn may not have yet.
   */
  constructor({ onTime, start, x0 }) {
    Object.assign(this, { onTime, start, x0 });
    this.picture = new MechanismPicture();
    // What is drawn is drawn anew all the time; this stays, and keeps the focus.
    this.handle = shape("rect", { class: "handle", rx: 3, tabindex: 0, role: "slider" });
    this.picture.svg.setAttribute("role", "group");
    this.picture.svg.append(this.handle);
    this.player = new Player((time) => this.#show(time));
    this.root = element(
      "figure", { class: "plot drawing" },
      element("figcaption", { title: "drag the mass, or move it by arrow keys, to set where it starts" }, element("strong", {}, "Picture"), element("span", { class: "key" }, "drag the mass: x0"), this.player.readout),
      this.picture.svg, this.player.root,
    );
    this.handle.addEventListener("pointerdown", (event) => this.#drag(event));
    this.handle.addEventListener("keydown", (event) => this.#key(event));
  }

  /** Take a motion; while something is held, what is seen only grows. */
  take(study, header, arrays, isHeld) {
    Object.assign(this, { study, header, curve: arrays });
    let [low, high] = endsOf(arrays.x);
    if (!(low <= high)) [low, high] = [-1, 1];
    if (low === high) [low, high] = [low - 0.5, high + 0.5];
    // Under the hand the mass keeps its scale.
    if (!this.isDragged) this.range = isHeld && this.range !== undefined ? grown(this.range, [low, high], false) : [low, high];
    this.picture.takeOne(header.elements, this.range);
    this.player.take(arrays.t[0], arrays.t.at(-1), header.period);
    this.player.clicks.take(arrays.event_t, arrays.speed);
    this.#describe();
  }

  close() {
    this.player.close();
    this.release?.();
  }

  #show(time) {
    if (this.curve === undefined) return;
    const { t, x } = this.curve;
    const now = this.isDragged ? this.dragged : between(t, x, time);
    // A motion that grows beyond all numbers leaves the picture as it was.
    if (!Number.isFinite(now)) return;
    this.#draw(now);
    this.onTime(time);
  }

  #draw(x) {
    this.x = x;
    this.picture.draw([x]);
    for (const [name, value] of Object.entries(this.picture.boxOf(0))) this.handle.setAttribute(name, value);
  }

  /** What the mass is as a slider of x0. */
  #describe() {
    const { start } = this.study;
    const isFree = !isTied(this.study, start.x0);
    const x0 = numberOf(start.x0 ?? 0);
    const [low, high] = this.#limits();
    this.handle.style.display = isFree ? "" : "none";
    const values = { "aria-label": `start ${named("x0", unitsOf(this.study).length)}: the mass`, "aria-valuemin": low, "aria-valuemax": high, "aria-valuenow": x0, "aria-valuetext": `x0 = ${shown(x0)}` };
    for (const [name, value] of Object.entries(values)) this.handle.setAttribute(name, value);
  }

  /** Return the ends of the starts in the picture: walls, or somewhat beyond what is passed through. */
  #limits() {
    const { stops } = this.header.elements;
    const room = this.range[1] - this.range[0];
    const ends = [this.range[0] - room, this.range[1] + room];
    for (const { type, side, at } of stops) if (type === "wall") ends[side === "below" ? 0 : 1] = at;
    return ends;
  }

  /** Set the start, in digits that the picture can tell, within the walls. */
  #put(x, step) {
    const unit = 10 ** Math.floor(Math.log10(step));
    const [low, high] = this.#limits();
    const rounded = Number((Math.round(x / unit) * unit).toPrecision(12));
    const within = Math.min(high, Math.max(low, rounded));
    const isWall = within !== rounded && limitsOf(this.study).some((end) => end === within);
    // A wall has exact words of its own, such as 1/3.
    const text = isWall ? startAt(this.study, within, 0).x0 : String(within);
    this.start(typed(String(text)));
    return within;
  }

  #key(event) {
    const sign = KEYS[event.key];
    if (sign === undefined || event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    event.stopPropagation();
    const step = 10 ** Math.floor(Math.log10((this.range[1] - this.range[0]) * STEP * (event.shiftKey ? 0.1 : 1)));
    this.player.stop();
    this.#put(numberOf(this.x0() ?? 0) + sign * step, step);
    this.player.go(this.player.low);
  }

  /** The mass is taken where it is, and begins where it is let go. */
  #drag(event) {
    if (event.button !== 0) return;
    event.preventDefault();
    this.handle.focus();
    this.player.stop();
    const from = this.x;
    const step = Math.abs(this.picture.displacement(1, 0) || this.picture.displacement(0, -1));
    const follow = (now) => {
      const moved = this.picture.displacement(now.clientX - event.clientX, now.clientY - event.clientY);
      // A touch of the mass does not move it.
      if (!this.isDragged && Math.abs(moved) < 2 * step) return;
      this.isDragged = true;
      this.dragged = this.#put(from + moved, step);
      this.player.go(this.player.low);
    };
    this.release = () => {
      for (const name of ["pointerup", "pointercancel"]) removeEventListener(name, this.release);
      removeEventListener("pointermove", follow);
      this.release = undefined;
      if (!this.isDragged) return;
      this.isDragged = false;
      // The range fits again.
      this.take(this.study, this.header, this.curve, false);
    };
    addEventListener("pointermove", follow);
    for (const name of ["pointerup", "pointercancel"]) addEventListener(name, this.release);
  }
}
