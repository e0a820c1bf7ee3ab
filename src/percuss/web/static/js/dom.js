// Making elements.

/** Return an element; attributes that begin with "on" are listeners. */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) made.addEventListener(name.slice(2), value);
    else if (name === "class") made.className = value;
    else if (name in made && typeof value !== "string") made[name] = value;
    else if (value !== null && value !== undefined && value !== false) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

/** Return a form that is not sent. */
export const form = (name, label = null) => element("form", { class: name, "aria-label": label, onsubmit: (event) => event.preventDefault() });

/** Return an element of a picture. */
export function shape(name, attributes) {
  const made = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
  return made;
}

/** Return a number as it is shown: four digits, no more. */
export function shown(value, digits = 4) {
  if (value === null || value === undefined || Number.isNaN(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e5 || size < 1e-3) return value.toExponential(Math.max(0, digits - 2)).replace(/\.?0*e\+?/, "e");
  return String(Number(value.toPrecision(digits)));
}

/** Fill a table with its heads, none for no line of them, and rows of cells. */
export function fillTable(table, heads, rows, attributesOf = () => ({})) {
  const line = (tag, cells, attributes) => element("tr", attributes, ...cells.map((cell) => element(tag, {}, cell)));
  const head = heads.length > 0 ? [element("thead", {}, line("th", heads))] : [];
  table.replaceChildren(...head, element("tbody", {}, ...rows.map((cells, k) => line("td", cells, attributesOf(k)))));
}

/** Return a button. */
export function button(label, onclick, attributes = {}) {
  return element("button", { type: "button", onclick, ...attributes }, label);
}

/** Return a row of a legend, with a colour or the name of one. */
export function swatchOf(colour, name, note = "") {
  const swatch = element("span", { class: "swatch" });
  swatch.style.backgroundColor = colour.startsWith("--") ? `var(${colour})` : colour;
  return element("li", {}, swatch, element("span", {}, name), note && element("span", { class: "note" }, note));
}

/** Follow a pointer until it is let go. */
export function whileHeld(follow, then = () => {}) {
  const end = () => {
    removeEventListener("pointermove", follow);
    removeEventListener("pointerup", end);
    then();
  };
  addEventListener("pointermove", follow);
  addEventListener("pointerup", end);
}

let toast = null;

/** Show a message for a moment at the foot of a page. */
export function say(root, text) {
  toast?.remove();
  toast = element("div", { class: "toast", role: "status" }, text);
  root.append(toast);
  const mine = toast;
  setTimeout(() => mine.remove(), 3500);
}

/** Take files that are dropped on an element: `take(file)` returns whether the file is its own. Return what ends that. */
export function watchDrops(target, take) {
  const watching = new AbortController();
  const { signal } = watching;
  target.addEventListener("dragover", (event) => {
    if (event.dataTransfer?.types.includes("Files")) event.preventDefault();
  }, { signal });
  target.addEventListener("drop", (event) => {
    const file = event.dataTransfer?.files[0];
    if (file === undefined || event.defaultPrevented || !take(file)) return;
    event.preventDefault();
  }, { signal });
  return () => watching.abort();
}

/** Return whether a file is a study. */
export const isStudyFile = (file) => file.name.toLowerCase().endsWith(".toml");

/** Return a hidden field that asks for a file when it is clicked, for the same one again too; `take` gets it. */
export function fileField(label, take, accept = ".csv,.txt,.tsv,text/csv,text/plain") {
  const field = element("input", {
    type: "file", accept, hidden: true, "aria-label": label,
    onclick: () => (field.value = ""), onchange: () => field.files[0] && take(field.files[0]),
  });
  return field;
}

/** Return the text of a file, as spreadsheets of any age encode it. */
export async function textOf(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const wide = { "255,254": "utf-16le", "254,255": "utf-16be" }[bytes.subarray(0, 2)];
  try {
    return new TextDecoder(wide ?? "utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

/** Return the name of a quantity in words; stops are counted from 1. */
export const wordsOf = (name) => name.replaceAll("_", " ").replace("lyap", "Lyap").replace(/\d+$/, (k) => Number(k) + 1);
