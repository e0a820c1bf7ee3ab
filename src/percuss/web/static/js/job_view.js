// A view of a long answer: its form, its job, the plot of what has come, and a note when it is stale.

import { element, form } from "./dom.js";
import { Job } from "./job.js";
import { Plot } from "./plots.js";
import { noteChanges } from "./provenance.js";
import { isStudy, settingsOf } from "./state.js";

/**
 * What diagrams and basins share. A view of its own says
 *
 * requestOf(study, isLive): what to compute with a study, quickly while a slider moves; hasPicture: whether an answer has come;
 * isComputed(request): whether it is of what is set now; receive(header, arrays, isFirst): takes a
 * frame; read(x, y): text of a point; open(x, y): shows a point in Explore; refine(): computes the
 * part that is zoomed into; scope(request): options of `noteChanges`.
 */
export class JobView {
  /** `name`: key of the view in the state and its link; `defaults`: of its settings. */
  constructor(app, { name, title, defaults, x, y }) {
    this.app = app;
    this.name = name;
    this.defaults = defaults;
    // The requests whose answer is shown, and whose answer is to come.
    this.current = null;
    this.pending = null;
    this.form = form("settings");
    this.job = new Job(app, (isLive) => this.#start(isLive), (header, arrays, isFirst) => this.#show(header, arrays, isFirst), this.form);
    this.zoomed = element("button", { type: "button", hidden: true, onclick: () => this.refine() }, "Compute what is shown");
    this.job.root.append(this.zoomed);
    this.plot = new Plot({
      title, x, y, kind: "points",
      read: (across, upwards) => this.read(across, upwards),
      onClick: (across, upwards) => this.open(across, upwards),
      onZoom: (zoom) => {
        this.zoomed.hidden = zoom === null;
        app.keepZoom(name, zoom);
      },
    });
    this.plots = [this.plot];
    this.stale = element("p", { class: "stale-note", role: "status", hidden: true });
    this.legend = element("ul", { class: "legend" });
    this.hint = element("p", { class: "hint" });
    this.root = element(
      "section",
      { class: "wide", "aria-label": title },
      this.form, this.job.root, this.stale, this.plot.root, this.legend, this.hint,
    );
    app.store.watch(() => this.changed());
  }

  /** Take the settings of a link; the picture that it holds is due when the view is shown. */
  restore({ [this.name]: given, zooms, study }) {
    this.settings = settingsOf(this.defaults, given);
    this.due = this.settings.isComputed ? { zoom: zooms?.[this.name] ?? null, study: isStudy(given.study) ? given.study : study } : null;
  }

  /** Begin with another motion: nothing is known of it. */
  begin(state) {
    this.job.clear();
    this.current = null;
    this.stale.hidden = true;
    this.legend.replaceChildren();
    this.restore(state);
  }

  /** Compute the picture of a link; return whether there was one. */
  shown() {
    if (this.due === null || !this.app.isOpen) return false;
    const { zoom, study } = this.due;
    this.due = null;
    if (this.hasPicture && JSON.stringify(this.current) === JSON.stringify(this.requestOf(study))) return true;
    this.firstZoom = zoom;
    this.run(study);
    return true;
  }

  /** Return the request of the picture that is shown, or of what is set: files are of that. */
  request() {
    return this.hasPicture && this.current ? this.current : this.requestOf(this.app.store.value.study);
  }

  /** Compute with another study than the one that is set. */
  run(study) {
    this.base = study;
    this.job.run();
    this.base = null;
  }

  /** Say what has changed since the picture was computed. */
  changed() {
    noteChanges(this.stale, this.current, this.app.store.value.study, this.current && this.scope(this.current));
  }

  /** Keep in the link what is set, and the study of the picture. */
  keep() {
    const computed = this.settings.isComputed && this.current ? { study: this.current.study } : {};
    this.app.store.set({ [this.name]: { ...this.settings, ...computed } }, this.name);
  }

  #start(isLive) {
    this.due = null;
    this.pending = this.requestOf(this.base ?? this.app.store.value.study, isLive);
    return this.pending;
  }

  #show(header, arrays, isFirst) {
    if (isFirst) {
      this.current = this.pending;
      // What is computed is kept in the link, unless something else is set by now.
      if (this.isComputed(this.current)) this.settings.isComputed = true;
      this.keep();
      this.changed();
      this.plot.take(this.firstZoom ?? null);
      this.zoomed.hidden = this.plot.zoom === null;
      if (this.plot.zoom === null) this.app.keepZoom(this.name, null);
      this.firstZoom = null;
    }
    this.receive(header, arrays, isFirst);
  }
}
