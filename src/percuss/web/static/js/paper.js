// The report of `percuss paper`, and its figures in Explore.

import { button, element } from "./dom.js";

// Beside the page, on a server as in a folder.
const REPORT = "report/index.html";
// The grounds of a verdict.
const GRADES = { deduced: "a proof covers all cases", certified: "proven in ball arithmetic for the numbers of the paper", measured: "double precision, with its error" };

/** Return the heading: which paper it is, and what of it is checked. */
function about() {
  return [
    element("h2", {}, "The paper behind the package"),
    element(
      "p",
      {},
      "A. V. Dyskin, E. Pasternak and E. Pelinovsky, ", element("cite", {}, "Periodic motions and resonances of impact oscillators"),
      ", Journal of Sound and Vibration 331 (2012) 2856–2873: an oscillator that bounces at a stop, driven by a harmonic force. It asks at which times impacts can come: the eigenset of the free motion, subsets of it, or others, and when the motion grows for ever.",
    ),
    element(
      "p",
      {},
      "percuss computes its figures anew and judges each of its statements: deduced by a proof, certified in ball arithmetic, or measured in double precision. The figures below open in Explore with the parameters of the paper.",
    ),
  ];
}

/** A button that starts the report on the server, and shows its elapsed time. */
function makeReport() {
  const status = element("output", { role: "status" });
  const look = async (method) => {
    try {
      const { state, seconds, reason } = await (await fetch("/api/report", { method })).json();
      if (state === "done") location.reload();
      else if (state === "working") {
        start.disabled = true;
        status.textContent = ` computing for ${seconds} s …`;
        setTimeout(look, 1000, "GET");
      } else {
        start.disabled = false;
        status.textContent = ` ${reason ?? ""}`;
      }
    } catch {
      start.disabled = false;
      status.textContent = " the server does not answer";
    }
  };
  const start = button("Compute it now (half a minute)", () => look("POST"));
  return element("span", { class: "make-report" }, start, status);
}

export class Paper {
  constructor(app, { report, figures, presets, claims }) {
    const byName = new Map(presets.map((preset) => [preset.name, preset]));
    const open = Object.entries(figures).map(([figure, name]) =>
      button(figure.replace("fig", ""), () => app.begin(byName.get(name).study), { "data-figure": figure, "aria-label": `figure ${figure.replace("fig", "")}`, title: byName.get(name).title }),
    );
    const { isStatic } = app.options;
    const missing = element(
      "p",
      {},
      isStatic ? "The report of these checks is not here. " : "The report of these checks is not here yet. ", isStatic ? null : makeReport(),
      isStatic ? "" : " To keep it, ", element("code", {}, "percuss paper --out report"), " writes it and ", element("code", {}, `percuss ${isStatic ? "site" : "serve"} --report report`), isStatic ? " puts it here." : " opens this page with it.",
    );
    this.frame = report ? element("iframe", { src: REPORT, title: "Report of the paper" }) : null;
    this.root = element(
      "section",
      { class: "paper", "aria-label": "Paper" },
      ...(report ? [] : about()),
      open.length > 0 ? element("div", { class: "tools" }, element("span", {}, "Open a figure in Explore:"), ...open) : null,
      claims.length > 0 ? this.#verdicts(claims) : null,
      this.frame ?? missing,
    );
  }

  /** The counts of verdicts by their grounds, and the list of them. */
  #verdicts(claims) {
    const of = (grade) => claims.filter((it) => it.grade === grade);
    const counts = Object.entries(GRADES)
      .filter(([grade]) => of(grade).length > 0)
      .map(([grade, about]) => element("span", { class: `grade ${grade}`, title: about }, `${of(grade).length} ${grade}`));
    const rows = claims.map((it) =>
      element(
        "li",
        {},
        element("span", { class: `grade ${it.grade}`, title: GRADES[it.grade] ?? "" }, it.grade),
        button(it.reference, () => (this.frame.src = `${REPORT}#${it.id}`), { "aria-label": `${it.reference} in the report`, "data-claim": it.id }),
        element("span", {}, it.claim), element("span", { class: "note" }, it.verdict),
      ),
    );
    return element("details", { class: "verdicts" }, element("summary", {}, "Verdicts: ", ...counts), element("ul", {}, ...rows));
  }
}
