// The workbench: views over one state.

import { Basins } from "./basins.js";
import { Design } from "./design.js";
import { Diagram } from "./diagram.js";
import { button, element, isStudyFile, say, watchDrops } from "./dom.js";
import { Explore } from "./explore.js";
import { Fit } from "./fit.js";
import { Gallery } from "./gallery.js";
import { makeHelp, makeMenu, makeTabs } from "./head.js";
import { Mechanism } from "./mechanism.js";
import { Paper } from "./paper.js";
import { rounded } from "./scales.js";
import { decodeLink, encode, StudyHistory, Store } from "./state.js";
import { Tour } from "./tour.js";

export { Requests } from "./transport.js";

// Least time between two changes of the address [ms]: browsers allow few a second.
const LINKING = 250;

// What belongs to one motion, before it is set.
const NOTHING = { ranges: {}, zooms: {}, diagram: undefined, basins: undefined, design: undefined, digits: undefined };

/**
 * Put the workbench into an element.
 *
 * connect(onState) returns the requests; facts: {version, presets, report, figures};
 * file(extension, request) resolves to {name, blob}; hasLinks: whether the address holds the state; isStatic: no server;
 * prefix makes the ids unique; study: what to begin with; onStudy(study) is called at every change.
 */
export function mount(root, options) {
  return new App(root, { prefix: "p", ...options });
}

class App {
  constructor(root, options) {
    this.root = root;
    this.options = options;
    this.prefix = options.prefix;
    root.classList.add("percuss");
    this.theme = "system";
    this.darkness = matchMedia("(prefers-color-scheme: dark)");
    this.#paint();
    const first = { view: "explore", study: options.study ?? options.facts.presets[0].study, ranges: {}, zooms: {} };
    const linked = options.hasLinks ? decodeLink(location.hash.slice(1)) : null;
    this.store = new Store({ ...first, ...linked });
    this.history = new StudyHistory(this.store);
    this.ends = [];
    this.requests = options.connect((isOpen) => this.#connection(isOpen));
    this.#build();
    this.#listen();
    this.#showView();
    if (options.hasLinks && linked === null && location.hash.length > 1) say(root, "the link holds no motion");
  }

  /** Begin with another motion in Explore, without the settings and pictures of the one before. */
  begin(study) {
    const { fit } = this.store.value;
    // What is fitted belongs to the motion before; the record stays.
    const state = { ...NOTHING, study, view: "explore", fit: fit && { ...fit, free: {} } };
    for (const view of this.#all) view.begin?.(state);
    this.store.set(state, "all");
    // The gallery may be scrolled far down.
    this.root.scrollIntoView();
  }

  /** Show in Explore a motion picked in another view. */
  open(study) {
    const { diagram, basins } = this.store.value.zooms ?? {};
    this.store.set({ study, view: "explore", digits: undefined, zooms: { ...(diagram && { diagram }), ...(basins && { basins }) } }, "all");
    this.root.scrollIntoView();
  }

  /** Show a mechanism of several masses as it is set at first. */
  beginMechanism(name) {
    this.store.set({ view: "structure", mechanism: { name, values: {}, of: "" } }, "all");
    this.root.scrollIntoView();
  }

  /** Keep in the link which part a plot shows; null for all. */
  keepZoom(name, zoom) {
    const { [name]: _, ...rest } = this.store.value.zooms ?? {};
    this.store.set({ zooms: zoom === null ? rest : { ...rest, [name]: { x: rounded(zoom.x), y: rounded(zoom.y) } } }, "zoom");
  }

  /** Tell the other views that their long answers are cancelled by this job. */
  supersede(job) {
    for (const view of this.#all) if (view.job !== job) view.job?.lost("another computation has begun; compute again");
  }

  /** End the requests, and remove all listeners and elements. */
  close() {
    this.requests.close();
    for (const end of this.ends) end();
    for (const view of this.#all) view.close?.();
    for (const plot of this.#plots()) plot.close();
    clearTimeout(this.linking);
    this.root.replaceChildren();
  }

  #build() {
    const { facts } = this.options;
    this.views = { explore: new Explore(this), diagram: new Diagram(this), basins: new Basins(this), fit: new Fit(this), design: new Design(this), structure: new Mechanism(this) };
    if (this.options.hasLinks) this.views.paper = new Paper(this, facts);
    this.views.gallery = new Gallery(this, facts);
    for (const [name, view] of Object.entries(this.views)) {
      view.root.id = `${this.prefix}-view-${name}`;
      view.root.setAttribute("role", "tabpanel");
    }
    this.tabs = makeTabs(Object.keys(this.views), this.prefix, (name) => this.store.set({ view: name }, "view"));
    this.banner = element("p", { class: "banner", role: "alert", hidden: true }, this.options.hasLinks ? "Connection lost; trying again. If that does not help, start percuss serve again." : "The kernel has ended: run the cell again.");
    this.help = makeHelp();
    this.tour = new Tour(this);
    this.root.replaceChildren(
      element("header", { class: "top" }, element("h1", {}, "percuss"), this.tabs.root, this.#tools()),
      this.banner,
      this.tour.root,
      element("main", {}, ...this.#all.map((view) => view.root)),
      this.help,
    );
  }

  #tools() {
    this.menu = makeMenu(() => this.#request(), (extension, table) => this.#download(extension, table));
    this.ends.push(() => this.menu.close());
    this.tour.opener = button("Tour", () => this.tour.go(0), { title: "five steps: period doubling, chaos, grazing, chatter" });
    return element(
      "div",
      { class: "tools" },
      this.tour.opener,
      button("↶", () => this.undo(), { title: "undo (Ctrl+Z); again with Ctrl+Shift+Z", "aria-label": "Undo" }),
      button("Copy link", () => this.#copyLink(), { hidden: !this.options.hasLinks }),
      button("Copy as Python", () => this.#copyPython(), { class: "python" }),
      this.menu.root,
      button("◐", () => this.#theme(), { title: "light or dark", "aria-label": "Light or dark" }),
      button("?", () => this.help.showModal(), { title: "help (?)", "aria-label": "Help" }),
    );
  }

  #listen() {
    const { hasLinks, onStudy } = this.options;
    this.store.watch((state, why) => {
      if (why === "view" || why === "all") this.#showView();
      if (why === "study" || why === "all") onStudy?.(state.study);
      this.#keepLink(why);
    });
    const listen = (target, name, listener) => {
      target.addEventListener(name, listener);
      this.ends.push(() => target.removeEventListener(name, listener));
    };
    if (hasLinks) listen(globalThis, "hashchange", () => this.#follow());
    listen(this.darkness, "change", () => this.#paint());
    // Paper is light.
    listen(globalThis, "beforeprint", () => this.#paint("light"));
    listen(globalThis, "afterprint", () => this.#paint());
    // On a page of its own the key is heard wherever the focus is.
    listen(hasLinks ? document : this.root, "keydown", (event) => {
      if (event.key !== "?" || ["INPUT", "TEXTAREA", "SELECT"].includes(event.target.tagName) || this.help.open) return;
      event.preventDefault();
      this.help.showModal();
    });
    listen(hasLinks ? document : this.root, "keydown", (event) => {
      if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z" || event.target.type === "text") return;
      event.preventDefault();
      this.undo(event.shiftKey);
    });
    // The element may be the next workbench's.
    this.ends.push(watchDrops(this.root, (file) => {
      if (isStudyFile(file)) this.openStudy(file);
      else say(this.root, `${file.name}: drop a study (.toml) here, a table of a force on the sliders, one of measurements on Fit`);
      return true;
    }));
  }

  /** Take back the last change of the motion, or with `isRedo` make it again. */
  undo(isRedo = false) {
    if (!this.history.move(isRedo)) say(this.root, isRedo ? "nothing to do again" : "nothing to undo");
  }

  /** Show a state as a link holds it, in place of all that is set. */
  show(state) {
    const whole = { ...NOTHING, fit: undefined, mechanism: undefined, tour: undefined, ...state };
    for (const view of this.#all) view.begin?.(whole);
    for (const view of this.#all) view.restore?.(whole);
    this.store.set(whole, "all");
  }

  /** Show the study in a file. */
  async openStudy(file) {
    const toml = await file.text();
    this.requests.put("study_file", { kind: "study_file", toml }, {
      answer: ({ link }) => {
        this.show(decodeLink(link));
        say(this.root, `${file.name} is shown`);
      },
      fault: (faults) => this.#complain(`${file.name}: ${faults.map(({ path, reason }) => (path ? `${path} = ${reason}` : reason)).join("; ")}`),
    });
  }

  /** Say what is wrong until it is read. */
  #complain(text) {
    const dialog = element("dialog", { class: "help", "aria-label": "Faults of the file" });
    dialog.append(element("p", { class: "fault", role: "alert" }, text), button("Close", () => dialog.close(), { class: "primary" }));
    dialog.addEventListener("close", () => dialog.remove());
    this.root.append(dialog);
    dialog.showModal();
  }

  #showView() {
    const { view } = this.store.value;
    const name = Object.hasOwn(this.views, view) ? view : "explore";
    for (const [key, it] of Object.entries(this.views)) it.root.hidden = key !== name;
    this.tabs.show(name);
    // Of a structure there is the script alone.
    this.menu.root.hidden = name === "structure";
    this.menu.show();
    this.views[name].shown?.();
  }

  #connection(isOpen) {
    this.isOpen = isOpen;
    if (this.banner) this.banner.hidden = isOpen;
    if (!isOpen) {
      for (const view of this.#all) view.job?.lost("the connection was lost; compute again");
      this.views?.explore.certify?.lost();
      return;
    }
    // Also the first time, when the views may not be there yet.
    queueMicrotask(() => {
      this.views.explore.ask(false);
      this.views.structure.connected();
      this.views.explore.certify?.connected();
      this.#showView();
    });
  }

  /** Keep the address; another view or motion is one that "Back" comes back from. */
  #keepLink(why) {
    if (!this.options.hasLinks) return;
    if (why === "view" || why === "all") {
      this.#writeLink(this.isFollowing ? "replaceState" : "pushState");
      return;
    }
    this.linking ??= setTimeout(() => this.#writeLink("replaceState"), LINKING);
    // Tests wait until the address holds all that was set.
    this.root.dataset.linking = "";
  }

  #writeLink(how) {
    clearTimeout(this.linking);
    this.linking = null;
    delete this.root.dataset.linking;
    const link = `#${encode(this.store.value)}`;
    if (link === location.hash) return;
    this.written = link;
    history[how](null, "", link);
  }

  /** Another link was put into the address. */
  #follow() {
    if (location.hash === this.written) return;
    const state = decodeLink(location.hash.slice(1));
    if (state === null) {
      say(this.root, "the link holds no motion");
      return;
    }
    for (const view of this.#all) view.restore?.(state);
    this.isFollowing = true;
    this.store.set(state, "all");
    this.isFollowing = false;
  }

  /** Return the request whose files are offered: the motion, or the long request of the view. */
  #request() {
    const { view, study, digits } = this.store.value;
    return this.views[view]?.request?.() ?? { kind: "motion", study, digits };
  }

  #copyLink() {
    this.#writeLink("replaceState");
    this.#copy(location.href, "link copied");
  }

  #copyPython() {
    this.#make(async ({ blob }) => this.#copy(await blob.text(), "Python copied"), "py");
  }

  async #copy(text, done) {
    try {
      await navigator.clipboard.writeText(text);
      say(this.root, done);
    } catch {
      const box = element("textarea", { class: "copy", readonly: true, "aria-label": "Copy this", onblur: () => box.remove() }, text);
      this.root.append(box);
      box.focus();
      box.select();
      // Behind the help it has no focus.
      if (box.matches(":focus")) say(this.root, "press Ctrl-C to copy");
      else box.remove();
    }
  }

  #download(extension, table) {
    say(this.root, "making the file …");
    const keep = ({ name, blob }) => {
      const address = URL.createObjectURL(blob);
      element("a", { href: address, download: name }).click();
      setTimeout(() => URL.revokeObjectURL(address), 10_000);
      say(this.root, name);
    };
    this.#make(keep, extension, table);
  }

  async #make(take, extension, table) {
    try {
      await take(await this.options.file(extension, { ...this.#request(), ...(table && { table }) }));
    } catch (error) {
      say(this.root, error.message);
    }
  }

  #theme() {
    // The first click is to be seen: it leads away from the colours of the system.
    const themes = ["system", "light", "dark"];
    this.theme = themes[(themes.indexOf(this.theme) + (this.darkness.matches ? 1 : 2)) % 3];
    say(this.root, `${this.theme} colours`);
    this.#paint();
  }

  /** Put on the colours that are chosen, or those of the system. */
  #paint(theme = this.theme) {
    const system = this.darkness.matches ? "dark" : "light";
    this.root.dataset.theme = theme === "system" ? system : theme;
    // The report knows the system alone: see style.css.
    this.root.dataset.turned = String(this.root.dataset.theme !== system);
    for (const plot of this.#plots()) plot.recolour();
    for (const view of this.#all) view.recolour?.();
  }

  /** The views that there are. */
  get #all() {
    return Object.values(this.views ?? {});
  }

  /** All plots of the views. */
  #plots() {
    return this.#all.flatMap(({ plots = [] }) => plots);
  }
}
