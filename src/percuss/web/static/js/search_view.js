// A view that searches for parameters: its form, its job, what it found, and a note if that is stale.

import { element, form } from "./dom.js";
import { FreeParameters } from "./free.js";
import { Job } from "./job.js";
import { pathsOf } from "./models.js";
import { noteChanges } from "./provenance.js";

/**
 * What fits and designs share. A view of its own says
 *
 * requested(): what to search for; receive(header, arrays): takes what was found; keep(): keeps in the
 * link what is set; isOfStart(request): whether the start that is set plays a part.
 */
export class SearchView {
  constructor(app, { title, verb, hasGuesses }) {
    this.app = app;
    // The requests whose answer is shown, and whose answer is to come; the form as the link has it.
    this.current = this.pending = this.kept = null;
    this.free = new FreeParameters(app.store, () => this.paths(), { hasGuesses, changed: () => this.keep() });
    this.form = form("settings");
    this.job = new Job(app, () => (this.pending = this.requested()), (header, arrays) => this.#show(header, arrays), this.form);
    this.job.start.textContent = verb;
    this.stale = element("p", { class: "stale-note", role: "status", hidden: true });
    this.verdict = element("p", { role: "status" });
    this.result = element("table", { class: "fitted", hidden: true });
    this.root = element("section", { class: "wide fit", "aria-label": title }, this.form, this.job.root, this.stale, this.verdict, this.result);
    app.store.watch((_, why) => {
      if (why === "study" || why === "all") this.changed();
    });
  }

  /** Put the plots below, and a hint. */
  place(hint, ...parts) {
    this.root.append(...parts, element("div", { class: "plots" }, ...this.plots.map((plot) => plot.root)), element("p", { class: "hint" }, hint));
  }

  /** The parameters that may be free. */
  paths() {
    return pathsOf(this.app.store.value.study).filter(({ path }) => !path.startsWith("start.") || this.isOfStart());
  }

  shown() {
    this.changed();
  }

  /** The parameters are others, or have other names and values. */
  changed() {
    if (!this.root.hidden) this.free.update();
    const { current } = this;
    noteChanges(this.stale, current, this.app.store.value.study, current && { paths: Object.keys(current.free), ...(!this.isOfStart(current) && { parts: [] }) });
  }

  /** Nothing is found. */
  forget() {
    this.current = null;
    this.result.hidden = true;
    this.verdict.textContent = "";
    this.changed();
  }

  #show(header, arrays) {
    this.current = this.pending;
    this.verdict.className = header.converged ? "" : "fault";
    this.result.hidden = false;
    this.changed();
    this.receive(header, arrays);
  }
}
