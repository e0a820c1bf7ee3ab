// The head of the page: tabs, tools, the menu of files and the help.

import { button, element } from "./dom.js";

const FILES = [
  ["toml", "study.toml, for percuss run"],
  ["py", "the same in Python"],
  ["png", "motion.png"],
  ["svg", "motion.svg"],
  ["csv", "impacts.csv"],
  ["nc", "motion.nc (NetCDF)"],
];
// What the long views give: their own study and code.
const OF_VIEWS = ["toml", "py"];
const HELP = [
  ["Sliders", "Drag. With Shift held, or arrow keys, they move finely; ↔ beside a box sets their range. Boxes take 0.45, 1/3 and -pi/2 exactly."],
  ["Zoom", "Drag over a plot; or Ctrl and wheel; or + and − on the plot; or two fingers. Double-click, 0 or Escape shows all."],
  ["Pan", "Shift and drag; Shift and wheel; arrow keys on the plot; two fingers."],
  ["Read", "Hover over any plot. A time in Displacement is marked in the portrait, and the other way round."],
  ["Diagram", "Choose a parameter and Compute. Click a point to open that motion in Explore."],
  ["Basins", "Colours tell which attractor a start goes to. Click to start there."],
  ["Words", "(2, 4): two impacts in four forcing periods. Multipliers inside the unit circle: stable. Clearance: how far the orbit is from touching a stop in passing."],
  ["Keys", "? shows this. Arrow keys move between tabs. The link in the address holds all that is set."],
];

/** Return the tabs of views; `choose(name)` is called with the one that is wanted. */
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
      }
    },
  };
}

/** Return the menu of files; it closes by Escape, by a choice and by a click elsewhere. */
export function makeMenu(download) {
  const items = FILES.map(([extension, name]) => button(name, () => download(extension), { "data-file": extension }));
  const note = element("p", { class: "hint" });
  const summary = element("summary", {}, "Files");
  const root = element("details", { class: "menu" }, summary, element("div", {}, note, ...items));
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
    /** Offer what a view has. */
    show(view) {
      const isLong = view === "diagram" || view === "basins";
      note.textContent = isLong ? `of the ${view}` : "of the motion in Explore";
      for (const item of items) item.hidden = isLong && !OF_VIEWS.includes(item.dataset.file);
    },
    close: () => document.removeEventListener("pointerdown", outside),
  };
}

/** Return the help, a dialog. */
export function makeHelp() {
  const rows = HELP.flatMap(([name, text]) => [element("dt", {}, name), element("dd", {}, text)]);
  const dialog = element("dialog", { class: "help", "aria-label": "Help" });
  dialog.append(element("h2", {}, "How to use the workbench"), element("dl", {}, ...rows), button("Close", () => dialog.close(), { class: "primary" }));
  dialog.addEventListener("click", (event) => {
    if (event.target === dialog) dialog.close();
  });
  return dialog;
}
