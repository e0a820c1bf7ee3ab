// The points of a diagram, computed by the kernels: some of its values, in one worker of several.

import { exactBetween } from "./exact.js";
import { instantOf, lawOf } from "./local_motion.js";
import { readStudy } from "./local_study.js";
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
  kernels.clear();
  const read = readStudy(study, kernels);
  if (read === null || read.harmonics.length !== 1) return null;
  const at = kernels.columns;
  const law = lawOf(kernels, read).rows;
  const t0 = instantOf(kernels, read, [0, 0, 0], read.t0);
  const [start, asked, values] = [kernels.floats(3), kernels.zeros(at.ASKED_ENTRIES), kernels.zeros(at.N_OBSERVABLES)];
  kernels.view(start).set([read.x0, read.v0, t0]);
  const wanted = kernels.view(asked);
  wanted[at.ASKED_SECTION] = at[kind];
  wanted[at.ASKED_TRANSIENT] = SETTLING;
  wanted[at.ASKED_PERIODS] = points - 1;
  wanted[at.ASKED_CYCLE] = section === "cycle" ? cycle : -1;
  wanted[at.ASKED_LEVEL] = section === "place" ? level : 0;
  wanted[at.ASKED_WAY] = section === "place" ? WAYS[direction ?? "up"] : 0;
  const out = kernels.floats(points, at.POINT_COLUMNS);
  const status = kernels.call(
    "attractor", law, kernels.floats(at.STATE_ENTRIES), kernels.integers(at.COUNTERS), kernels.zeros(3, 1, 2),
    kernels.floats(at.BUFFER, at.EVENT_COLUMNS), kernels.integers(at.BUFFER, at.MARK_COLUMNS), kernels.floats(at.GRAZES, at.GRAZE_COLUMNS),
    start, asked, kernels.zeros(at.PLAN_ENTRIES), values, kernels.floats(points, at.POINT_COLUMNS), kernels.floats(0, at.STOP_COLUMNS),
    kernels.floats(4), kernels.zeros(5, 1, 2), out,
  );
  return { status, values: kernels.view(values), view: kernels.view(out) };
}
