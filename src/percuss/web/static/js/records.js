// A force by its samples: a table of comma-separated values, read and checked by line.

import { button, element } from "./dom.js";
import { choiceField } from "./fields.js";

// The server takes 65,536 bytes with the rest of the study.
const MOST_BYTES = 56_000;
const MOST_TOLD = 8;

const SEPARATORS = [",", ";", "\t"];

/** Return the text of a file, as spreadsheets of any age encode it. */
async function textOf(file) {
  const bytes = new Uint8Array(await file.arrayBuffer());
  const wide = { "255,254": "utf-16le", "254,255": "utf-16be" }[bytes.subarray(0, 2)];
  try {
    return new TextDecoder(wide ?? "utf-8", { fatal: true }).decode(bytes);
  } catch {
    return new TextDecoder("windows-1252").decode(bytes);
  }
}

/** Return the names of the columns of a table and its rows with their lines; `fault` says why there are none. */
export function readTable(text) {
  const tables = SEPARATORS.map((separator) => rowsOf(text, separator));
  // That with most columns of numbers; of equal ones the first.
  const rows = tables.reduce((best, other) => (widthOf(other) > widthOf(best) ? other : best));
  if (rows.length === 0) return { fault: "the table is empty" };
  // What stands above the names are notes of the instrument.
  const width = widthOf(rows);
  const first = rows.findIndex(({ cells }) => cells.every(isNumber));
  const head = Math.max(0, rows.slice(0, Math.max(first, 1)).findLastIndex(({ cells }) => cells.length >= width && !cells.some(isNumber)));
  const names = rows[head].cells;
  if (names.every(isNumber)) return { fault: "its first line holds numbers; write the names of the columns above them" };
  if (names.length < 2) return { fault: "it has one column; a record needs instants and forces" };
  return { names, rows: rows.slice(head + 1) };
}

/** Return the rows of a table with the numbers of their lines; decimal commas are points. */
function rowsOf(text, separator) {
  const rows = [];
  text.replace(/^\uFEFF/, "").split(/\r\n|\n|\r/).forEach((line, k) => {
    const plain = line.split(separator).map((cell) => cell.trim().replace(/^"(.*)"$/, "$1"));
    const cells = separator === "," ? plain : plain.map((cell) => (/^[-+\d.,eE]+$/.test(cell) ? cell.replace(",", ".") : cell));
    if (cells.some((cell) => cell !== "") && !cells[0].startsWith("#")) rows.push({ line: k + 1, cells });
  });
  return rows;
}

/** Return how many columns the first line of numbers has; 0 without one. */
function widthOf(rows) {
  return rows.find(({ cells }) => cells.every(isNumber))?.cells.length ?? 0;
}

/** Return the samples in two columns of a table, and the faults of its lines. */
export function samplesOf({ names, rows }, time, force) {
  const t = [];
  const f = [];
  const faults = [];
  const at = [names.indexOf(time), names.indexOf(force)];
  for (const { line, cells } of rows) {
    const [when, what] = at.map((k) => cells[k] ?? "");
    for (const [name, cell] of [[time, when], [force, what]]) if (!isNumber(cell)) faults.push(`line ${line}: ${name} = "${cell}" is no finite number`);
    const before = t.at(-1);
    t.push(Number(when));
    f.push(Number(what));
    if (!(t.length > 1) || !isNumber(when)) continue;
    if (t.at(-1) === before) faults.push(`line ${line}: ${time} = ${when} is there twice`);
    else if (t.at(-1) < before) faults.push(`line ${line}: ${time} = ${when} comes after ${before}; instants must rise`);
  }
  if (t.length < 2) faults.push("a record needs two samples at least");
  else if (t.every((value, k) => k === 0 || value < t[k - 1])) faults.splice(0, Infinity, "the samples are in reverse order, the last one first; turn the lines round");
  const size = JSON.stringify([t, f]).length;
  if (faults.length === 0 && size > MOST_BYTES) {
    const most = Math.floor((t.length * MOST_BYTES) / size);
    faults.push(`${t.length} samples make ${Math.ceil(size / 1000)} kB; links of the page hold ${MOST_BYTES / 1000} kB, some ${most} of these samples: take fewer, or "percuss run" with all, as [forcing.record] of a study`);
  }
  return { t, f, faults };
}

const isNumber = (cell) => cell !== "" && Number.isFinite(Number(cell));

/** A form that takes a table from a file, its columns by name, and gives `take` the samples. */
export class RecordForm {
  constructor(take) {
    this.take = take;
    this.file = element("input", { type: "file", accept: ".csv,.txt,text/csv,text/plain", "aria-label": "table of a record", hidden: true, onchange: () => this.read(this.file.files[0]) });
    this.message = element("p", { class: "fault", role: "alert" });
    this.form = element("div", { class: "record" });
    this.root = element("div", {}, this.file, this.form, this.message);
  }

  /** Ask for a file. */
  open() {
    this.file.value = "";
    this.file.click();
  }

  async read(file) {
    if (!file) return;
    this.form.replaceChildren();
    const table = readTable(await textOf(file));
    this.message.textContent = table.fault ? `${file.name}: ${table.fault}` : "";
    if (table.fault) return;
    const usual = (name, k) => (table.names.includes(name) ? name : table.names[k]);
    this.chosen = { time: usual("t", 0), force: usual("f", 1) };
    const choice = (of, label) => choiceField(label, table.names.map((name) => [name, name]), this.chosen[of], (name) => {
      this.chosen[of] = name;
      check();
    });
    const count = element("p", { class: "hint" });
    const use = button("use it", () => {
      const { t, f } = this.samples;
      this.form.replaceChildren();
      this.take({ t, f, kind: "linear", repeat: false });
    });
    const check = () => {
      this.samples = samplesOf(table, this.chosen.time, this.chosen.force);
      const { t, faults } = this.samples;
      const more = faults.length > MOST_TOLD ? `; and ${faults.length - MOST_TOLD} more` : "";
      this.message.textContent = faults.length > 0 ? `${file.name}: ${faults.slice(0, MOST_TOLD).join("; ")}${more}` : "";
      count.textContent = faults.length > 0 ? "" : `${t.length} samples from t = ${t[0]} to ${t.at(-1)}`;
      use.disabled = faults.length > 0;
    };
    this.form.append(choice("time", "instants"), choice("force", "forces"), count, use, button("cancel", () => this.#clear()));
    check();
  }

  #clear() {
    this.form.replaceChildren();
    this.message.textContent = "";
  }
}
