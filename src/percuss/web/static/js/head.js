// The head of the page: tabs, tools, the menu of files and the help.

import { button, element } from "./dom.js";

const HELP = [
  ["Sliders", "Drag. With Shift held, or arrow keys, they move finely; ↔ beside a box sets their range. Boxes take 0.45, 1/3 and -pi/2 exactly."],
  ["Zoom", "Drag over a plot; or Ctrl and wheel; or + and − on the plot; or two fingers. Double-click, 0 or Escape shows all."],
  ["Pan", "Shift and drag; Shift and wheel; arrow keys on the plot; two fingers."],
  ["Read", "Hover over any plot. Its time is marked in all the others, and the picture shows the mass there."],
  ["Picture", "Play lets the mass move; the slider beside it sets the time. Drag the mass, or move it by arrow keys, to set its start x0. Sound makes a click at each impact."],
  ["Diagram", "Choose a parameter and Compute. Click a point to open that motion in Explore."],
  ["Basins", "Colours tell which attractor a start goes to. Crosses are saddles; their stable manifolds, the lines, part the basins. Click to start there."],
  ["Fit", "Load a record, tick what is not known, Fit: values with errors, residuals, and the sliders set by them."],
  ["Design", "Tick what may change, choose which outcome shall be least or largest, and Search: the best setting, or a front between two outcomes."],
  ["Structure", "Two or three masses with stops: choose one, move its sliders; Play, or hover over Displacements, moves the picture."],
  ["Certify", "In the card Outcome: proves the run in ball arithmetic, each impact with a radius that is certain."],
  ["Words", "(2, 4): two impacts in four forcing periods. Multipliers inside the unit circle: stable. Clearance: how far the orbit is from touching a stop in passing. Formal: it solves the equations, but passes through a stop; no motion follows it."],
  ["Eigenset", "The times 0, s, 2 s, … at which the oscillator without a force would meet its wall again. Dyskin et al. (2012) show that a forced motion can keep to them: on the eigenset one impact at each, on a subset of it at some of them."],
  ["Exponent", "How fast neighbours part, as exp(exponent · t): above 0 chaos, below 0 an attractor that they share."],
  ["Drop", "Drop a study (.toml) on the page to see it; a table of a force on the sliders; a table of measurements on Fit."],
  ["Keys", "Ctrl+Z takes back a change, Ctrl+Shift+Z makes it again. ? shows this. Arrow keys move between tabs. The link in the address holds all that is set."],
];

/** Return the tabs of views; `choose(name)` is called with the chosen one. */
export function makeTabs(names, prefix, choose) {
  const tabs = new Map(
    names.map((name) => [
      name,
      button(name[0].toUpperCase() + name.slice(1), () => choose(name), {
        role: "tab", id: `${prefix}-tab-${name}`, "aria-controls": `${prefix}-view-${name}`, "data-view": name,
      }),
    ]),
  );
  const root = element("nav", { role: "tablist", "aria-label": "Views" }, ...tabs.values());
  root.addEventListener("keydown", (event) => {
    const now = names.findIndex((name) => tabs.get(name) === document.activeElement);
    const next = { ArrowRight: now + 1, ArrowLeft: now - 1, Home: 0, End: names.length - 1 }[event.key];
    if (now < 0 || next === undefined) return;
    event.preventDefault();
    const name = names[(next + names.length) % names.length];
    choose(name);
    tabs.get(name).focus();
  });
  return {
    root,
    show(chosen) {
      for (const [name, tab] of tabs) {
        tab.setAttribute("aria-selected", String(name === chosen));
        tab.tabIndex = name === chosen ? 0 : -1;
        // On a phone the tabs are a row that scrolls.
        if (name === chosen) root.scrollLeft = tab.offsetLeft - root.offsetLeft - 40;
      }
    },
  };
}

/** Return the files of a kind of request: [extension, table or null, label]. */
function filesOf({ kind, study, digits, outcomes }) {
  const hasSoft = (study.oscillator.stops ?? []).some((stop) => stop.type === "soft");
  const tables = {
    motion: ["impacts", ...(hasSoft ? ["crossings"] : []), ...(digits ? ["certified"] : [])],
    diagram: ["diagram"],
    sweep: ["sweep"],
    response: ["response", "special_points"],
    basins: ["basins", "attractors"],
    fit: ["fit", "covariance", "residuals", "impacts"],
    design: outcomes?.length > 1 ? ["design"] : ["design", "best"],
  }[kind];
  return [
    ["toml", null, "study.toml, for percuss run"],
    ["py", null, "the same in Python"],
    ["png", null, `${kind}.png`],
    ["svg", null, `${kind}.svg`],
    ...tables.map((table) => ["csv", table, `${table}.csv`]),
    ["nc", null, `${kind}.nc (NetCDF)`],
  ];
}

/** Return how the tables are read. */
function readingOf(kind) {
  const nc = kind === "motion" ? 'xarray.open_dataset("motion.nc"): x and v; xarray.open_datatree: impacts, … are its groups' : `xarray.open_dataset("${kind}.nc")`;
  return [`csv: pandas.read_csv(name)`, `nc: ${nc}`];
}

const NOTES = { motion: "of the motion in Explore", diagram: "of the diagram", sweep: "of the chart", response: "of the response chart", basins: "of the basins", fit: "of the fit", design: "of the design" };

/**
 * Return the menu of files; it closes by Escape, by a choice and by a click elsewhere.
 *
 * requested() returns the request whose files are offered; a choice calls download(extension, table).
 */
export function makeMenu(requested, download) {
  const list = element("div", {});
  const summary = element("summary", {}, "Files");
  const root = element("details", { class: "menu" }, summary, list);
  root.addEventListener("toggle", () => {
    // A closed menu keeps no files: the event comes after the list is seen, which would show another study's.
    if (!root.open) {
      list.replaceChildren();
      return;
    }
    const request = requested();
    const items = filesOf(request).map(([extension, table, label]) =>
      button(label, () => download(extension, table), { "data-file": table ? `${table}.csv` : extension }),
    );
    const reading = readingOf(request.kind).map((text) => element("p", { class: "hint reading" }, text));
    list.replaceChildren(element("p", { class: "hint" }, NOTES[request.kind]), ...items, ...reading);
  });
  root.addEventListener("click", (event) => {
    if (event.target.tagName === "BUTTON") root.open = false;
  });
  root.addEventListener("keydown", (event) => {
    if (event.key !== "Escape" || !root.open) return;
    root.open = false;
    summary.focus();
    event.stopPropagation();
  });
  const outside = (event) => {
    if (!root.contains(event.target)) root.open = false;
  };
  document.addEventListener("pointerdown", outside);
  return {
    root,
    /** Another view has other files. */
    show() {
      root.open = false;
    },
    close: () => document.removeEventListener("pointerdown", outside),
  };
}

/** Return the help, a dialog. */
export function makeHelp() {
  const rows = HELP.flatMap(([name, text]) => [element("dt", {}, name), element("dd", {}, text)]);
  const dialog = element("dialog", { class: "help", "aria-label": "Help" });
  // It takes the focus, so that the help opens at its top.
  dialog.append(element("h2", { tabindex: "-1", autofocus: true }, "How to use the workbench"), element("dl", {}, ...rows), button("Close", () => dialog.close(), { class: "primary" }));
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });
  return dialog;
}
