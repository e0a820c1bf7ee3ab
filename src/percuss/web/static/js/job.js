// A long question: its button, its progress, and cancelling it.

import { button, element } from "./dom.js";

/** Start, cancel and progress of one kind of long question. */
export class Job {
  /** `question()` returns what to ask, `show(header, arrays, isFirst)` takes the frames. */
  constructor(app, question, show) {
    this.app = app;
    this.question = question;
    this.show = show;
    this.start = button("Compute", () => this.run(), { class: "primary" });
    this.stop = button("Cancel", () => this.cancel(), { hidden: true });
    this.bar = element("progress", { max: 1, hidden: true, "aria-label": "Progress" });
    this.status = element("output", { class: "status", role: "status" });
    this.root = element("div", { class: "job" }, this.start, this.stop, this.bar, this.status);
  }

  run() {
    let isFirst = true;
    this.app.supersede(this);
    const began = performance.now();
    this.#busy(true);
    this.bar.removeAttribute("value");
    this.status.textContent = "computing …";
    this.app.questions.replace("job", this.question(), {
      answer: (header, arrays) => {
        this.show(header, arrays, isFirst);
        isFirst = false;
        this.bar.value = header.share;
        const seconds = ((performance.now() - began) / 1000).toFixed(1);
        this.status.textContent = header.done ? `done in ${seconds} s` : `${Math.round(100 * header.share)} %, ${seconds} s`;
        if (header.done) this.#busy(false);
      },
      progress: (share) => {
        this.bar.value = share;
      },
      fault: (faults) => {
        this.status.textContent = faults.map((fault) => (fault.path ? `${fault.path}: ${fault.reason}` : fault.reason)).join("; ");
        this.#busy(false);
      },
    });
  }

  cancel() {
    this.app.questions.cancel("job");
    this.status.textContent = "cancelled";
    this.#busy(false);
  }

  /** Forget what was asked before. */
  clear() {
    if (!this.stop.hidden) this.cancel();
    this.status.textContent = "";
  }

  /** No answer will come any more: the reason is a sentence. */
  lost(reason) {
    if (this.stop.hidden) return;
    this.status.textContent = reason;
    this.#busy(false);
  }

  #busy(isBusy) {
    this.stop.hidden = !isBusy;
    this.bar.hidden = !isBusy;
  }
}
