// A force by its samples: a table in a file, which the server reads.

import { button, element, fileField, textOf } from "./dom.js";
import { choiceField } from "./fields.js";

/** A form that takes a table from a file, its columns by name, and gives `take` the samples. */
export class RecordForm {
  /** `ask(csv, columns, handlers)` asks the server for the samples of a table. */
  constructor(ask, take) {
    this.ask = ask;
    this.take = take;
    this.file = fileField("table of a record", (file) => this.read(file));
    this.message = element("p", { class: "fault", role: "alert" });
    this.form = element("div", { class: "record" });
    this.root = element("div", {}, this.file, this.form, this.message);
  }

  /** Ask for a file. */
  open() {
    this.file.click();
  }

  async read(file) {
    this.#clear();
    this.name = file.name;
    this.csv = await textOf(file);
    this.#request({});
  }

  #request(columns) {
    this.ask(this.csv, columns, {
      answer: (header) => this.#show(header),
      fault: (faults) => {
        this.#clear();
        this.message.textContent = `${this.name}: ${faults.map(({ reason }) => reason).join("; ")}`;
      },
    });
  }

  /** Show the columns to choose from, and what is in the two that are chosen. */
  #show({ names, time, force, fault, note, t, f }) {
    const choice = (of, label) => choiceField(label, names.map((name) => [name, name]), { time, force }[of], (name) => this.#request({ time, force, [of]: name }));
    const count = fault ? "" : `${t.length} samples from t = ${t[0]} to ${t.at(-1)}${note ? `; ${note}` : ""}`;
    this.message.textContent = fault ? `${this.name}: ${fault}` : "";
    const use = button("use it", () => {
      this.#clear();
      this.take({ t, f, kind: "linear", repeat: false });
    }, { disabled: Boolean(fault) });
    this.form.replaceChildren(choice("time", "instants"), choice("force", "forces"), element("p", { class: "hint" }, count), use, button("cancel", () => this.#clear()));
  }

  #clear() {
    this.form.replaceChildren();
    this.message.textContent = "";
  }
}
