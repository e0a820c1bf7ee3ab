// A long request: its buttons and its progress.

import { button, element } from "./dom.js";

/** Start, cancel and progress of one kind of long request. */
export class Job {
  /**
   * `request(isLive)` returns the request, `show(header, arrays, isFirst)` is called with each frame, form:
   * the fields of the view, of which none may have a fault.
   */
  constructor(app, request, show, form = null) {
    this.app = app;
    this.form = form;
    this.request = request;
    this.show = show;
    this.start = button("Compute", () => this.run(), { class: "primary" });
    this.stop = button("Cancel", () => this.cancel(), { hidden: true });
    this.bar = element("progress", { max: 1, hidden: true, "aria-label": "Progress" });
    this.status = element("output", { class: "status", role: "status" });
    // What is called with the first answer of a run that follows a slider.
    this.followed = null;
    this.root = element("div", { class: "job" }, this.start, this.stop, this.bar, this.status);
  }

  /** Compute; with `followed`, which is called at the first answer, quietly: a slider moves. */
  run(followed = null) {
    const wrong = this.form?.querySelector("[aria-invalid=true]");
    if (wrong) {
      wrong.focus();
      this.#say("not computed: see the marked field", true);
      return;
    }
    let isFirst = true;
    this.app.supersede(this);
    const began = performance.now();
    const took = () => `${((performance.now() - began) / 1000).toFixed(1)} s`;
    const isLive = followed !== null;
    this.followed = followed;
    this.#busy(!isLive);
    this.bar.removeAttribute("value");
    if (!isLive) this.#say("computing …");
    let share = 0;
    const report = (next) => {
      if (isLive) return;
      share = Math.max(share, next);
      this.bar.value = share;
      // Each per cent need not be read out.
      this.status.ariaLive = "off";
      this.status.textContent = `${Math.round(100 * share)} %, ${took()}`;
    };
    this.app.requests.replace("job", this.request(isLive), {
      answer: (header, arrays) => {
        this.show(header, arrays, isFirst);
        isFirst = false;
        report(header.share);
        if (header.done && isLive) this.#say(`live: ${Math.round(performance.now() - began)} ms`);
        else if (header.done) {
          this.#say(`done in ${took()}`);
          this.#busy(false);
        }
        this.#follow();
      },
      progress: report,
      fault: (faults) => {
        for (const fault of faults) this.mark?.(fault);
        this.#say(faults.map((fault) => (fault.path ? `${nameOf(fault.path)}: ${fault.reason}` : fault.reason)).join("; "), true);
        this.#busy(false);
        this.#follow();
      },
    });
  }

  /** Tell what follows a slider that it may go on. */
  #follow() {
    const { followed } = this;
    this.followed = null;
    followed?.();
  }

  cancel() {
    this.followed = null;
    this.app.requests.cancel("job");
    this.#say("cancelled");
    this.#busy(false);
  }

  /** Cancel the request, and forget its status. */
  clear() {
    if (!this.stop.hidden) this.cancel();
    this.#say("");
  }

  /** Say why no answer will come any more. */
  lost(reason) {
    this.followed = null;
    if (this.stop.hidden) return;
    this.#say(reason, true);
    this.#busy(false);
  }

  #say(text, isFault = false) {
    this.status.ariaLive = "polite";
    this.status.textContent = text;
    this.status.classList.toggle("fault", isFault);
  }

  #busy(isBusy) {
    // The keys go on where they were.
    if (!isBusy && this.stop.matches(":focus")) this.start.focus();
    this.stop.hidden = !isBusy;
    this.bar.hidden = !isBusy;
  }
}

/** Return the name of a parameter without its table. */
const nameOf = (path) => path.split(".").filter((part) => !/^\d+$/.test(part)).at(-1);
