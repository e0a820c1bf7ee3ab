// A run proven in ball arithmetic: its digits, how far it is proven, and why no further; or chaos, all
// orbits, and basins.

import { button, element, shown } from "./dom.js";

const DIGITS = 12;
const MOST_DIGITS = 100;
const NAMES = { certified: "Proven", proof: "The proof", digits: "Digits", entropy: "Topological entropy" };

/** The strip under the cards; hidden until it is opened. */
export class Certify {
  /** `onProven` is called with the time up to which the motion is proven, null for no proof. */
  constructor(app, onProven) {
    this.app = app;
    this.onProven = onProven;
    this.until = null;
    this.isDue = app.store.value.digits !== undefined;
    const id = `${app.prefix}-digits`;
    this.box = element("input", { type: "number", id, min: 1, max: MOST_DIGITS, step: 1, value: String(app.store.value.digits ?? DIGITS) });
    this.stop = button("Cancel", () => this.#cancel(), { hidden: true });
    this.bar = element("progress", { max: 1, hidden: true, "aria-label": "Progress of the proof" });
    this.status = element("output", { class: "status", role: "status" });
    this.rows = element("dl", { class: "proof-rows" });
    this.root = element(
      "section",
      { class: "proof panel", "aria-label": "Certify this run", hidden: !this.isDue },
      element("form", { class: "job", onsubmit: (event) => this.#submit(event) },
        element("label", { for: id }, "Certify this run to"), this.box, element("span", {}, "digits"),
        element("button", { type: "submit", class: "primary" }, "Certify"),
        button("Prove chaos", () => this.#ask({ of: "chaos" }), { title: "prove that this system has chaotic motions, whatever the start that is set" }),
        button("Prove all orbits", () => this.#ask({ of: "orbits" }), { title: "find all orbits with one impact a forcing period, and prove that there are no others" }),
        button("Prove basins", () => this.#ask({ of: "basins", ...this.app.views.basins.square() }), { title: "prove which starts of the square in Basins go to which stable orbit" }), this.stop, this.bar, this.status),
      this.rows,
    );
    this.opener = button("certify …", () => this.#open(), { title: "prove this run in ball arithmetic", "aria-controls": `${app.prefix}-proof`, "aria-expanded": String(this.isDue) });
    this.root.id = `${app.prefix}-proof`;
    app.store.watch((state, why) => {
      if (why === "study" || why === "all") this.#forget(why === "all" ? state.digits : undefined);
    });
  }

  /** The connection is open: a link may hold a proof. */
  connected() {
    if (this.isDue) this.#run();
  }

  /** No answer will come any more. */
  lost() {
    if (!this.stop.hidden) this.#say("the connection was lost; certify again");
  }

  #open(isShown = this.root.hidden) {
    this.root.hidden = !isShown;
    this.opener.setAttribute("aria-expanded", String(isShown));
    if (isShown) this.box.focus();
  }

  #submit(event) {
    event.preventDefault();
    if (this.box.reportValidity()) this.#run();
  }

  #run() {
    this.isDue = false;
    const digits = this.box.valueAsNumber;
    // The digits are in the link, in study.toml and in the code from now on.
    this.app.store.set({ digits }, "digits");
    this.#ask({ digits });
  }

  #ask(options) {
    const { study } = this.app.store.value;
    this.#clear();
    this.status.textContent = "proving …";
    this.stop.hidden = this.bar.hidden = false;
    this.bar.removeAttribute("value");
    this.app.requests.replace("certify", { kind: "certify", study, ...options }, {
      answer: (header) => {
        if (this.app.store.value.study === study) this.#show(header);
      },
      progress: (share) => (this.bar.value = share),
      fault: (faults) => this.#say(faults.map((fault) => fault.reason).join("; ")),
    });
  }

  #cancel() {
    this.app.requests.cancel("certify");
    this.#say("cancelled");
  }

  /** Another motion: nothing is proven of it, unless a link asks for it. */
  #forget(digits) {
    if (!this.stop.hidden) this.app.requests.cancel("certify");
    // A slider moves: nothing is done where nothing is said.
    if (this.status.textContent !== "") {
      this.#clear();
      this.#say("");
    }
    if (this.app.store.value.digits !== digits) this.app.store.set({ digits }, "digits");
    if (digits === undefined) return;
    this.box.value = String(digits);
    this.#open(true);
    if (this.app.isOpen) this.#run();
  }

  #clear() {
    this.rows.replaceChildren();
    const wasProven = this.until !== null;
    this.until = null;
    if (wasProven) this.onProven(null);
  }

  #say(text) {
    this.status.textContent = text;
    this.stop.hidden = this.bar.hidden = true;
  }

  #show(header) {
    if (header.of !== "run") {
      this.#say(header.complete ? "proven" : header.some ? "proven in part" : "not proven");
      this.#list(Object.entries(header.report));
      return;
    }
    const isStopped = header.report.proof?.includes("interrupted");
    this.#say(header.complete ? "proven" : isStopped ? `stopped after ${shown(header.patience)} s` : "proven in part");
    const rows = Object.entries(header.report);
    const last = header.lines.map(([number, t, v]) => element("div", {}, element("b", {}, `${number}: `), `t = ${tidy(t)}, v = ${tidy(v)}`));
    if (last.length > 0) rows.push([last.length > 1 ? "Last impacts" : "Last impact", ...last]);
    if (header.followed) rows.push(["The plots", followedText(header)]);
    this.#list(rows);
    this.until = header.until;
    this.onProven(header.until);
  }

  #list(rows) {
    const tidied = (part) => (typeof part === "string" ? tidy(part) : part);
    this.rows.replaceChildren(...rows.flatMap(([name, ...parts]) => [element("dt", {}, NAMES[name] ?? name), element("dd", {}, ...parts.map(tidied))]));
  }
}

const tidy = (text) => text.replaceAll("+/-", "±");

/** Say how far double precision, which the plots show, agrees with the proof. */
function followedText({ followed: { n, t, whole }, n_impacts: proven }) {
  if (whole) return `double precision has all ${proven} impacts to a thousandth of a period`;
  if (n === 0) return "double precision misses the first impact already";
  return `double precision has ${n} of the ${proven} impacts to a thousandth of a period, until t = ${shown(t, 5)}`;
}
