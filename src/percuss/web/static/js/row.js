// One parameter: a slider, a box, and the range of the slider.

import { button, element, whileHeld } from "./dom.js";
import { numberOf } from "./models.js";

// With Shift a slider follows the pointer so many times slower.
const FINER = 20;

export class Row {
  /**
   * spec: path, label, range, step, about; prefix makes its ids its own; set(value) and
   * setRange(range or null) tell what the user does.
   */
  constructor({ path, label, range, step, about }, { prefix, set, setRange }) {
    Object.assign(this, { path, step, set, setRange, home: range, base: range, range: [...range] });
    const id = `${prefix}-${path.replaceAll(".", "-")}`;
    this.slider = element("input", {
      type: "range", min: "0", max: "1000", step: "1", "aria-label": `${label}, slider`,
      title: "with Shift it moves more finely",
      oninput: () => set(this.#ofShare(Number(this.slider.value) / 1000)),
      onpointerdown: (event) => this.#finely(event),
    });
    this.box = element("input", {
      type: "text", id, spellcheck: "false", autocomplete: "off", inputmode: "text",
      "aria-describedby": `${id}-fault`, "data-path": path,
      oninput: () => set(typed(this.box.value)),
      onblur: () => this.show(this.value),
      onkeydown: (event) => this.#key(event, set),
    });
    this.message = element("p", { class: "fault", id: `${id}-fault`, role: "alert" });
    this.more = button("↔", () => this.#showRange(this.ends.hidden), {
      class: "more", title: "range of the slider", "aria-label": `range of the slider of ${label}`, "aria-expanded": "false", "aria-controls": `${id}-range`,
    });
    this.ends = this.#makeEnds(`${id}-range`);
    this.root = element("div", { class: "row", title: about }, element("label", { for: id }, label), this.slider, this.box, this.more, this.ends, this.message);
  }

  show(value, range) {
    this.value = value;
    const text = String(value ?? 0);
    if (document.activeElement !== this.box) this.box.value = text;
    this.box.title = text;
    const number = numberOf(value ?? 0);
    this.slider.disabled = isExpression(text);
    if (range !== undefined) this.base = range;
    if (range !== undefined || document.activeElement !== this.slider) this.range = [...this.base];
    if (Number.isFinite(number) && document.activeElement !== this.slider) {
      if (text === this.accepted) this.#widen(number);
      const share = (number - this.range[0]) / (this.range[1] - this.range[0]);
      this.slider.value = String(Math.round(1000 * share));
    }
    [this.low, this.high].forEach((box, k) => {
      if (document.activeElement !== box) box.value = tidy(this.range[k], this.range[1] - this.range[0]);
      box.style.width = `max(6em, ${box.value.length + 5}ch)`;
    });
    this.#fit(text);
    this.slider.setAttribute("aria-valuetext", text);
  }

  /** The server has accepted a value. */
  accept(value) {
    const text = String(value ?? 0);
    if (text === this.accepted) return;
    this.accepted = text;
    this.show(this.value);
  }

  /** A value beyond the end of the slider moves that end for its time, unless the slider is held. */
  #widen(number) {
    const beyond = Math.sign(number) * Math.min(1.5 * Math.abs(number), Number.MAX_VALUE);
    if (number > this.range[1]) this.range[1] = number > 0 ? beyond : 0;
    if (number < this.range[0]) this.range[0] = number < 0 ? beyond : 0;
  }

  /** Reserve the width of all digits that the slider can set, so that it does not move. */
  #fit(text) {
    const [low, high] = this.range;
    const unit = this.#unit((high - low) / FINER);
    const digits = Math.max(0, -Math.floor(Math.log10(unit) + 1e-9));
    const whole = Math.max(...this.range.map((end) => String(Math.trunc(end)).length + (end < 0 && end > -1 ? 1 : 0)));
    const most = Math.max(text.length, digits === 0 ? whole : whole + 1 + Math.min(15, digits));
    // Also for a fine range: a slider across the panel is finer, and does not move then.
    this.root.classList.toggle("long", most > 7 || !this.ends.hidden);
    this.box.classList.toggle("small", most > 20);
  }

  fault(reason) {
    this.message.textContent = reason;
    this.box.setAttribute("aria-invalid", reason ? "true" : "false");
  }

  #makeEnds(id) {
    const end = (name) => element("input", { type: "number", step: "any", "aria-label": name, onchange: () => this.#setEnds() });
    this.low = end("slider from");
    this.high = end("slider to");
    this.atEnd = element("span", { class: "note", role: "status" });
    return element(
      "div",
      { class: "ends", id, hidden: true },
      element("span", {}, "from"), this.low, element("span", {}, "to"), this.high,
      button("finer", () => this.#around(0.1), { title: "a tenth of the range, around the value" }),
      button("coarser", () => this.#around(10), { title: "ten times the range" }),
      button("reset", () => this.#reset(), { title: "the range of before; a value that was refused goes back to the last that was not" }),
      this.atEnd,
    );
  }

  #reset() {
    if (this.box.getAttribute("aria-invalid") === "true" && this.accepted !== undefined) this.set(typed(this.accepted));
    this.atEnd.textContent = "";
    this.setRange(null);
  }

  #showRange(isShown) {
    this.ends.hidden = !isShown;
    this.#fit(this.box.value);
    this.more.setAttribute("aria-expanded", String(isShown));
  }

  #setEnds() {
    const range = [this.low.valueAsNumber, this.high.valueAsNumber];
    if (range.every(Number.isFinite) && range[0] < range[1]) this.setRange(range);
    else this.show(this.value);
  }

  /** A range around the value, so many times as wide. */
  #around(factor) {
    const value = numberOf(this.value ?? 0);
    const width = factor * (this.range[1] - this.range[0]);
    const isLeast = (this.step !== null && width < 10 * this.step) || width < 1e-9 * Math.max(1, Math.abs(value));
    this.atEnd.textContent = !Number.isFinite(value) ? "no number to go around" : isLeast ? "no finer; type the value into its box" : width < 1e12 ? "" : "no coarser";
    if (this.atEnd.textContent !== "") return;
    const low = value - width / 2;
    // Where the slider begins at 0, so does a wider one.
    this.setRange([this.home[0] === 0 && low < 0 ? 0 : Number(tidy(low, width)), Number(tidy(value + width / 2, width))]);
  }

  /** Return the step of a slider that is so wide. */
  #unit(width) {
    return this.step ?? 10 ** (Math.floor(Math.log10(width)) - 3);
  }

  #ofShare(share) {
    const [low, high] = this.range;
    const width = high - low;
    const unit = this.#unit(width);
    const value = Math.round((low + width * Math.min(1, Math.max(0, share))) / unit) * unit;
    const digits = Math.max(0, -Math.floor(Math.log10(unit) + 1e-9));
    return typed(String(Number(value.toFixed(Math.min(digits, 15)))));
  }

  /** A slow slider: it follows a part of the distance that the pointer moves. */
  #finely(event) {
    if (!event.shiftKey) return;
    event.preventDefault();
    this.slider.focus();
    const width = this.slider.getBoundingClientRect().width;
    const [low, high] = this.range;
    const begin = (numberOf(this.value ?? 0) - low) / (high - low);
    const unit = this.#unit((high - low) / FINER);
    const follow = (now) => {
      const share = Math.min(1, Math.max(0, begin + (now.clientX - event.clientX) / width / FINER));
      this.slider.value = String(Math.round(1000 * share));
      this.set(typed(tidy(Math.round((low + share * (high - low)) / unit) * unit, 1000 * unit)));
    };
    whileHeld(follow);
  }

  /** The arrow keys in a box change its last digit. */
  #key(event, set) {
    if (event.key !== "ArrowUp" && event.key !== "ArrowDown") return;
    const match = /^(-?\d+)(?:\.(\d+))?$/.exec(this.box.value.trim());
    if (match === null) return;
    event.preventDefault();
    const digits = match[2]?.length ?? 0;
    const next = Number(this.box.value) + (event.key === "ArrowUp" ? 1 : -1) * 10 ** -digits;
    this.box.value = next.toFixed(digits);
    set(typed(this.box.value));
  }
}

/** Return whether a text has names in it besides pi: a slider would replace the expression. */
function isExpression(text) {
  return (text.match(/[A-Za-z_]\w*/g) ?? []).some((word) => word !== "pi" && !/^e\d*$/i.test(word));
}

/** Show faults beside the rows of their paths; return the sentences of those that belong to none. */
export function showFaults(rows, faults) {
  for (const row of rows.values()) row.fault("");
  const rest = [];
  for (const { path, reason } of faults) {
    const row = rows.get(path);
    if (row) row.fault(reason);
    else rest.push(path ? `${path}: ${reason}` : reason);
  }
  return rest;
}

/** Return a number with as many digits as tell a thousandth of a width. */
function tidy(value, width) {
  const digits = Math.min(15, Math.max(0, 3 - Math.floor(Math.log10(width) + 1e-9)));
  return String(Number(value.toFixed(digits)));
}

/** Return what was typed as a study file holds it: whole numbers bare, the rest as exact texts. */
export function typed(text) {
  const bare = text.trim();
  return /^[+-]?\d{1,15}$/.test(bare) ? Number(bare) : bare;
}
