// The points of a diagram, computed by the kernels: some of its values, in one worker of several.

import { exactBetween } from "./exact.js";
import { filled, spaceOf } from "./local_space.js";
import { put } from "./state.js";

// Forcing periods that are left out, as percuss.web.view_study has it.
const SETTLING = 200;
// The sections, by the kinds of points of the kernels.
const SECTIONS = { strobes: "STROBES", cycle: "STROBES", impacts: "IMPACT_POINTS", place: "PASSAGES" };
const WAYS = { up: 1, down: -1, both: 0 };
const NAMES = { STROBES: ["x", "v"], IMPACT_POINTS: ["cycle", "v_after"], PASSAGES: ["cycle", "v"] };
const FAULTS = {
  OVERFLOW: "the motion grew beyond 1e150",
  REACHED_LIMIT: "more than 1000000 impacts before the end",
  SPENT: "not at its end after a million searches",
  NO_MORE: "not at its end after a million searches",
};

/**
 * Return {columns, failed, reason} of the values that have these numbers; null where they need Python.
 *
 * request: as of the view; columns: the points of each value one after another, by their names.
 */
export function diagramPart(kernels, request, numbers) {
  const { section = "strobes", points } = request;
  const kind = SECTIONS[section];
  const names = NAMES[kind];
  const columns = Object.fromEntries(names.map((name) => [name, new Float64Array(numbers.length * points).fill(Number.NaN)]));
  let [failed, reason] = [0, ""];
  for (const [place, number] of numbers.entries()) {
    const { study, path, low, high, values } = request;
    const found = attractorOf(kernels, put(study, path, exactBetween(low, high, number, values)), request, kind);
    if (found === null) return null;
    const fault = faultOf(kernels, found.status);
    if (fault) {
      failed += 1;
      reason ||= fault;
      continue;
    }
    const { POINT_COLUMNS } = kernels.columns;
    names.forEach((name, column) => {
      for (let k = 0; k < points; k += 1) columns[name][place * points + k] = found.view[k * POINT_COLUMNS + column];
    });
  }
  return { columns, failed, reason };
}

/** Return why a motion that ended so has no answer. */
export const faultOf = (kernels, status) => Object.entries(FAULTS).find(([name]) => kernels.columns[name] === status)?.[1];

/** Follow a motion; return its status, its observables and its points; null where it needs Python. */
export function attractorOf(kernels, study, { points, cycle, at: level, direction, section }, kind) {
  const found = spaceOf(kernels, study);
  if (found === null) return null;
  const at = kernels.columns;
  const { motion, measured, stops, start } = found;
  const asked = kernels.zeros(at.ASKED_ENTRIES);
  const wanted = kernels.view(asked);
  wanted[at.ASKED_SECTION] = at[kind];
  wanted[at.ASKED_TRANSIENT] = SETTLING;
  wanted[at.ASKED_PERIODS] = points - 1;
  wanted[at.ASKED_CYCLE] = section === "cycle" ? cycle : -1;
  wanted[at.ASKED_LEVEL] = section === "place" ? level : 0;
  wanted[at.ASKED_WAY] = section === "place" ? WAYS[direction ?? "up"] : 0;
  const rows = () => kernels.floats(points, at.POINT_COLUMNS);
  const out = rows();
  const status = kernels.call("attractor", ...motion, filled(kernels, start, 3), asked, ...measured, rows(), ...stops, out);
  return { status, values: kernels.view(measured[1]), view: kernels.view(out) };
}
