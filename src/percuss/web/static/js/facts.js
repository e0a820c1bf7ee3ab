// Facts about a motion, in a line of cards.

import { element, shape, shown } from "./dom.js";

const STABLE = { asymptotic: "stable", elliptic: "elliptic (neighbours stay near)", parabolic: "parabolic (on the edge)", unstable: "unstable" };
const KINDS = {
  eigenset: "on the eigenset",
  eigenset_subset: "on a subset of the eigenset",
  periodic: "periodic",
  settling: "settling",
  approaching_eigenset: "approaching the eigenset",
  too_few: "too few to tell",
  no_period_found: "no period found",
};
const NEEDED = "percuss on your machine tells it: percuss serve";
// Names on the page.
export const OUTCOMES = {
  "the run reached t_end": "followed to its end",
  "the run reached max_impacts (impacts and entries into soft stops)": "followed to its last impact",
};

/** The line of facts. */
export class Facts {
  constructor() {
    this.outcome = card("Outcome", "how the run ended");
    this.times = card("Impact times", "whether they repeat; the eigenset: times of the free motion from impact to impact; largest exponent: how fast neighbours part (+) or meet (−), after 200 periods and over 1000");
    this.contacts = card("Contacts", "where the mass stays at a stop for a while");
    // Its text may be of an earlier motion for a while.
    this.orbit = card("Nearest periodic orbit", "what the motion settles to, or passes by");
    // On narrow pages it stays in sight while a slider is dragged.
    this.summary = element("p", { class: "summary", "aria-hidden": "true" });
    this.root = element("dl", { class: "facts" }, ...[this.outcome, this.times, this.orbit, this.contacts].map((it) => it.root));
    this.showOrbit(undefined);
  }

  showMotion(header) {
    // Without walls only entries are counted, also in the pattern of the times.
    const events = header.n_impacts > 0 || header.n_entries === 0 ? [count(header.n_impacts, "impact")] : [];
    if (header.n_entries) events.push(hits(header.n_entries, ["entry"]));
    if (header.n_grazes) events.push(count(header.n_grazes, "graze"));
    const patience = header.is_cut ? "; the page follows a second of computing or 50,000 impacts" : "";
    this.outcome.show(OUTCOMES[header.outcome] ?? header.outcome, `${events.join(", ")}; computed in ${shown(header.milliseconds, 2)} ms${patience}`);
    this.#showContacts(header);
    this.#showTimes(header, events);
  }

  /** Without a server the kinds of impact times and the orbit are not told, and the exponent is only while it is known. */
  showMissing() {
    this.kind = "missing";
    this.times.root.classList.remove("stale");
    this.times.show("not told here", NEEDED);
    this.orbit.show("not told here", NEEDED);
  }

  /** Without a server the exponent stands alone. */
  showAlone({ exponent }) {
    if (!exponent) {
      this.showMissing();
      return;
    }
    const name = exponent.is_chaotic ? "chaotic" : exponent.is_settling || exponent.value === null ? "not chaotic" : "chaotic or not: too close to tell";
    this.times.root.classList.remove("stale");
    this.times.show(name, `${exponentText(exponent)}; whether they repeat, ${NEEDED}`);
  }

  #showTimes(header, events) {
    // The server tells it once a slider rests; until then what is told is of an earlier motion.
    this.times.root.classList.toggle("stale", header.impact_times === null);
    if (header.impact_times === null) {
      if (this.kind === undefined) this.times.show("…", "");
      this.#summarise(...events);
      return;
    }
    const { kind, n_impacts: impacts, n_periods: periods, rate } = header.impact_times;
    const repeated = impacts ? `${hits(impacts, header.n_impacts > 0 ? ["impact"] : ["entry"])} in ${count(periods, "forcing period")}` : "";
    const pattern = kind === "settling" ? `towards ${repeated}, the rest falls as exp(−${shown(rate, 2)} t)` : repeated;
    this.kind = kind;
    this.pattern = pattern;
    this.times.show(KINDS[kind] ?? kind, pattern);
    this.#summarise(KINDS[kind] ?? kind, pattern || events[0]);
  }

  #showContacts(header) {
    const first = header.contacts[0];
    const text = header.n_contacts === 0 ? "none" : count(header.n_contacts, "contact");
    const until = first?.[1] === null ? "for good" : `to ${shown(first?.[1])}`;
    this.contacts.show(text, first ? `the first from t = ${shown(first[0])} ${until}` : "");
  }

  #summarise(...parts) {
    this.summary.textContent = parts.filter((part) => part).join("; ");
  }

  /** Show how fast neighbours separate, and without a period of the impacts whether that is chaos. */
  showExponent({ exponent, orbit }) {
    const parts = this.pattern ? [this.pattern] : [];
    let name = KINDS[this.kind] ?? this.kind;
    if (this.kind === "no_period_found") {
      if (exponent?.is_chaotic) name = "chaotic";
      else if (exponent?.value === null) {
        name = "settles from contact to contact";
        parts.push("its impact times show no period yet: follow it longer");
      } else if (exponent?.is_settling) {
        name = "not settled yet";
        parts.push("neighbours meet, so there is no chaos: follow it longer");
      } else if (exponent) parts.push("neighbours neither part nor meet fast enough to tell");
    }
    if (exponent) parts.push(exponentText(exponent));
    this.times.show(name, parts.join("; "));
    const near = orbit ? `near ${nameOf(orbit)}, ${STABLE[orbit.stability] ?? orbit.stability}` : "";
    this.#summarise(name, near, parts[0]);
  }

  /** Grey the facts of an earlier motion. */
  isKnown(isKnown) {
    this.orbit.root.classList.toggle("stale", !isKnown && this.kind !== "missing");
  }

  /** undefined: not known yet; null: none found. */
  showOrbit(orbit, counted) {
    this.isKnown(true);
    if (orbit === undefined || orbit === null) {
      this.orbit.show(orbit === null ? "none found" : "…", "");
      return;
    }
    const name = nameOf(orbit);
    const clearance = orbit.grazes ? "grazes" : orbit.grazing_margin === null ? "no turning point near a stop" : `clearance ${shown(orbit.grazing_margin, 3)}`;
    const formal = orbit.admissible ? "" : "formal, no motion follows it: it passes through a stop; ";
    const passed = orbit.stability === "unstable" ? "the motion cannot stay on it; " : "";
    this.orbit.show(`${name} ${STABLE[orbit.stability] ?? orbit.stability}`, `${countsOf(orbit, counted)}; ${passed}${formal}multipliers ${multipliersText(orbit.multipliers)}; ${clearance}`, unitCircle(orbit.multipliers));
  }
}

/** Return multipliers as they are shown, a conjugate pair as one. */
export function multipliersText(multipliers) {
  const isPair = ([re, im], [re2, im2] = []) => im !== 0 && Math.hypot(re2 - re, im2 + im) < 1e-9 * Math.hypot(re, im);
  const texts = multipliers.map((it, k) => {
    if (k > 0 && isPair(multipliers[k - 1], it)) return "";
    return it[1] ? `${shown(it[0], 3)} ${isPair(it, multipliers[k + 1]) ? "±" : it[1] > 0 ? "+" : "−"} ${shown(Math.abs(it[1]), 3)}i` : shown(it[0], 3);
  });
  return texts.filter((text) => text).join(", ");
}

const nameOf = ({ sticks, n_impacts: impacts, n_periods: periods }) => `(${sticks ? "∞" : impacts}, ${periods})`;

/** Return the counts of one period of an orbit. */
function countsOf({ sticks, n_impacts: impacts, n_periods: periods }, counted) {
  return `${sticks ? "chatter and contact" : hits(impacts, counted)} in ${count(periods, "forcing period")}`;
}

/** Count impacts on walls, entries into soft stops, or both together. */
export function hits(n, counted = ["impact"]) {
  const [one, many] = counted.includes("entry") ? ["entry into a stop", "entries into a stop"] : ["impact", "impacts"];
  const and = counted.length > 1 ? (n === 1 ? "impact or " : "impacts and ") : "";
  return `${n} ${and}${n === 1 ? one : many}`;
}

function exponentText({ value, error }) {
  if (value === null) return "largest exponent −∞: each contact ends all memory of the start";
  const sign = value > 0 ? "+" : value < 0 ? "−" : "";
  // An error far below the digits that are shown is left out.
  const doubt = error > 1e-3 * Math.abs(value) ? ` ± ${shown(error, 1)}` : "";
  return `largest exponent ${sign}${shown(Math.abs(value), 3)}${doubt}`;
}

export function card(title, about) {
  const value = element("dd", {});
  const note = element("dd", { class: "note" });
  const picture = element("dd", { class: "mini" });
  const root = element("div", { class: "card", title: about }, element("dt", {}, title), value, note, picture);
  return {
    root,
    show(text, more, drawn = null) {
      value.textContent = text;
      note.textContent = more;
      picture.replaceChildren(...(drawn ? [drawn] : []));
    },
  };
}

/** The multipliers in the unit circle; those outside stand at its edge. */
export function unitCircle(multipliers) {
  const svg = shape("svg", { viewBox: "-1.3 -1.3 2.6 2.6", role: "img", "aria-label": "multipliers in the unit circle" });
  svg.append(shape("circle", { r: 1, class: "unit" }), shape("path", { d: "M-1.3 0H1.3M0-1.3V1.3", class: "axes" }));
  for (const [re, im] of multipliers) {
    const size = Math.hypot(re, im);
    const scale = size > 1.2 ? 1.2 / size : 1;
    svg.append(shape("circle", { cx: re * scale, cy: -im * scale, r: 0.13, class: size > 1 + 1e-9 ? "outside" : "inside" }));
  }
  return svg;
}

export function count(n, what) {
  return `${n} ${what}${n === 1 ? "" : "s"}`;
}
