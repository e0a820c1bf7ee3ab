// The workbench: views over one state.

import { Basins } from "./basins.js";
import { Diagram } from "./diagram.js";
import { button, element, say } from "./dom.js";
import { Explore } from "./explore.js";
import { Gallery, Paper } from "./gallery.js";
import { decodeLink, encode, Store } from "./state.js";

export { Questions } from "./transport.js";

const VIEWS = ["explore", "diagram", "basins", "paper", "gallery"];
const FILES = [
  ["toml", "study.toml"],
  ["py", "motion.py, the same run in Python"],
  ["png", "motion.png"],
  ["svg", "motion.svg"],
  ["csv", "impacts.csv"],
  ["nc", "motion.nc (NetCDF)"],
];
const THEMES = ["system", "light", "dark"];

/**
 * Put the workbench into an element.
 *
 * connect(onState) returns the questions; facts: {version, presets, report, figures};
 * file(extension, study) resolves to {name, blob}; hasLinks: whether the address holds the state;
 * study: what to begin with; onStudy(study) hears of every change.
 */
export function mount(root, { connect, facts, file, hasLinks, study, onStudy }) {
  return new App(root, { connect, facts, file, hasLinks, study, onStudy });
}

class App {
  constructor(root, options) {
    this.root = root;
    this.options = options;
    root.classList.add("percuss");
    const first = { view: "explore", study: options.study ?? options.facts.presets[0].study };
    const linked = options.hasLinks ? decodeLink(location.hash.slice(1)) : null;
    this.store = new Store({ ...first, ...linked });
    this.questions = options.connect((isOpen) => this.#connection(isOpen));
    this.#build();
    this.store.watch((state, why) => {
      if (why === "view" || why === "all") this.#showView();
      if (why === "study" || why === "all") options.onStudy?.(state.study);
      this.#keepLink();
    });
    if (options.hasLinks) addEventListener("hashchange", () => this.#follow());
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#recolour());
    this.#showView();
  }

  /** Show a study in Explore. */
  open(study, isNew = true) {
    this.store.set({ study, view: "explore" }, isNew ? "all" : "study");
  }

  #build() {
    const { facts } = this.options;
    this.views = { explore: new Explore(this), diagram: new Diagram(this), basins: new Basins(this) };
    if (this.options.hasLinks) this.views.paper = new Paper(this, facts);
    this.views.gallery = new Gallery(this, facts.presets);
    this.tabs = new Map(
      VIEWS.filter((name) => this.views[name]).map((name) => [
        name,
        button(name[0].toUpperCase() + name.slice(1), () => this.store.set({ view: name }, "view"), { role: "tab", "data-view": name }),
      ]),
    );
    this.banner = element("p", { class: "banner", role: "alert", hidden: true }, "Connection lost; trying again …");
    this.root.replaceChildren(
      element(
        "header",
        { class: "top" },
        element("h1", {}, "percuss"),
        element("nav", { role: "tablist", "aria-label": "Views" }, ...this.tabs.values()),
        this.#tools(),
      ),
      this.banner,
      ...Object.values(this.views).map((view) => view.root),
    );
  }

  #tools() {
    const files = FILES.map(([extension, name]) => button(name, () => this.#download(extension), { "data-file": extension }));
    const menu = element("details", { class: "menu" }, element("summary", {}, "Files"), element("div", {}, ...files));
    menu.addEventListener("click", (event) => {
      if (event.target.tagName === "BUTTON") menu.open = false;
    });
    const tools = [
      button("Copy link", () => this.#copy(location.href, "link copied"), { hidden: !this.options.hasLinks }),
      button("Copy as Python", () => this.#copyPython()),
      menu,
      button("◐", () => this.#theme(), { title: "Light or dark", "aria-label": "Light or dark" }),
    ];
    return element("div", { class: "tools" }, ...tools);
  }

  #showView() {
    const { view } = this.store.value;
    const name = this.views[view] ? view : "explore";
    for (const [key, it] of Object.entries(this.views)) {
      it.root.hidden = key !== name;
      this.tabs.get(key).setAttribute("aria-selected", String(key === name));
    }
    this.views[name].shown?.();
  }

  #connection(isOpen) {
    if (this.banner) this.banner.hidden = isOpen;
    if (!isOpen) {
      this.views?.diagram.job.lost();
      this.views?.basins.job.lost();
      return;
    }
    // Also the first time, when the views may not be there yet.
    queueMicrotask(() => this.views.explore.ask(false));
  }

  #keepLink() {
    if (!this.options.hasLinks) return;
    clearTimeout(this.linking);
    this.linking = setTimeout(() => {
      this.written = `#${encode(this.store.value)}`;
      history.replaceState(null, "", this.written);
    }, 150);
  }

  /** Another link was put into the address. */
  #follow() {
    if (location.hash === this.written) return;
    const state = decodeLink(location.hash.slice(1));
    if (state === null) say(this.root, "the link holds no motion");
    else this.store.set(state, "all");
  }

  async #copyPython() {
    try {
      const { blob } = await this.options.file("py", this.store.value.study);
      await this.#copy(await blob.text(), "Python copied");
    } catch (error) {
      say(this.root, error.message);
    }
  }

  async #copy(text, done) {
    try {
      await navigator.clipboard.writeText(text);
      say(this.root, done);
    } catch {
      const box = element("textarea", { class: "copy", readonly: true, "aria-label": "Copy this" });
      box.value = text;
      box.addEventListener("blur", () => box.remove());
      this.root.append(box);
      box.select();
      say(this.root, "press Ctrl-C to copy");
    }
  }

  async #download(extension) {
    try {
      const { name, blob } = await this.options.file(extension, this.store.value.study);
      const address = URL.createObjectURL(blob);
      element("a", { href: address, download: name }).click();
      setTimeout(() => URL.revokeObjectURL(address), 10_000);
    } catch (error) {
      say(this.root, error.message);
    }
  }

  #theme() {
    const now = this.root.dataset.theme ?? "system";
    this.root.dataset.theme = THEMES[(THEMES.indexOf(now) + 1) % THEMES.length];
    say(this.root, `${this.root.dataset.theme} colours`);
    this.#recolour();
  }

  #recolour() {
    for (const view of Object.values(this.views)) view.recolour();
  }
}
