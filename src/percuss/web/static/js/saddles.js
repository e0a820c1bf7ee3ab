// Saddle orbits and their stable manifolds, computed once the basins are there.

import { element } from "./dom.js";

export class Saddles {
  /** `onChange` is called when another one has come. */
  constructor(app, onChange) {
    this.app = app;
    this.onChange = onChange;
    this.found = [];
    this.text = "";
    this.isBusy = false;
  }

  /** Find them; each is drawn as soon as it has come. */
  find(study) {
    this.clear();
    this.isBusy = true;
    this.text = "looking for saddles …";
    this.onChange();
    this.app.requests.replace("saddles", { kind: "saddles", study }, {
      answer: (header, arrays) => {
        if (!header.done) this.found.push({ header, arrays });
        else this.#finish(header);
        this.onChange();
      },
      fault: (faults) => {
        this.isBusy = false;
        this.text = `no saddles: ${faults.map((fault) => fault.reason).join("; ")}`;
        this.onChange();
      },
    });
  }

  /** Forget them, and cancel the search. */
  clear() {
    if (this.isBusy) this.app.requests.cancel("saddles");
    this.isBusy = false;
    this.found = [];
    this.text = "";
  }

  /** Return their rows of the legend. */
  legend() {
    const names = this.found.map(({ header: it }) => `(${it.n_impacts}, ${it.n_periods})${it.reason ? ` without manifold: ${it.reason}` : ""}`);
    const rows = names.length > 0 ? [element("li", { "data-saddles": String(names.length) }, element("b", { class: "cross" }, "×"), `saddles ${names.join(", ")} and their stable manifolds`)] : [];
    return this.text ? [...rows, element("li", { class: "note" }, this.text)] : rows;
  }

  #finish({ n_saddles: count, late }) {
    this.isBusy = false;
    this.text = late ? `the time was up after ${this.found.length} of ${count} saddles` : count === 0 ? "no saddles of up to two impacts and two periods" : "";
  }
}
