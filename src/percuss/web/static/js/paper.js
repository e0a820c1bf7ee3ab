// The report of `percuss paper`, and its figures in Explore.

import { button, element } from "./dom.js";

export class Paper {
  constructor(app, { report, figures, presets }) {
    const byName = new Map(presets.map((preset) => [preset.name, preset]));
    const open = Object.entries(figures).map(([figure, name]) =>
      button(figure.replace("fig", ""), () => app.begin(byName.get(name).study), { "data-figure": figure, "aria-label": `figure ${figure.replace("fig", "")}`, title: byName.get(name).title }),
    );
    const missing = element(
      "p",
      { class: "hint" },
      "The report is not here. Write it with ", element("code", {}, "percuss paper --out report"),
      " and open the page with ", element("code", {}, "percuss serve --report report"), ".",
    );
    this.root = element(
      "section",
      { class: "paper", "aria-label": "Paper" },
      open.length > 0 ? element("div", { class: "tools" }, element("span", {}, "Open a figure in Explore:"), ...open) : null,
      report ? element("iframe", { src: "/report/index.html", title: "Report of the paper" }) : missing,
    );
  }

  recolour() {}
}
