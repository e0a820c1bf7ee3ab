// Basins by the kernels, in a worker: the classes of starts, and the attractors where they go.

import { instantOf, lawOf } from "./local_motion.js";
import { readStudy } from "./local_study.js";

// As percuss.basins has them: forcing periods until a start stays undecided, and what is far.
const [PERIODS, ESCAPE] = [1000, 1e6];
const KINDS = { PERIODIC: "periodic", CHAOTIC: "chaotic", REST: "rest", UNBOUNDED: "unbounded" };

/** Return the classes of starts, x and v of one after another; null where they need Python. */
export function classesOf(kernels, study, starts) {
  const space = spaceOf(kernels, study);
  if (space === null) return null;
  const n = starts.length / 2;
  const given = filled(kernels, kernels.floats(n, 2), starts);
  const classes = kernels.floats(n, kernels.columns.CLASS_ENTRIES);
  const status = kernels.call("classify", ...space, given, classes);
  return status === kernels.columns.NEEDS_PYTHON ? null : { arrays: { classes: kernels.view(classes).slice() } };
}

/** Return {attractors, arrays} from the classes of all starts: `basin`, and points of the k-th in `x{k}`, `v{k}`. */
export function basinsOf(kernels, study, given) {
  const space = spaceOf(kernels, study);
  const at = kernels.columns;
  const n = given.length / at.CLASS_ENTRIES;
  const classes = filled(kernels, kernels.floats(n, at.CLASS_ENTRIES), given);
  const labels = kernels.integers(n);
  const found = kernels.floats(at.MOST_FOUND, at.FOUND_ENTRIES);
  const drawn = kernels.floats(at.MOST_POINTS, 2);
  const count = kernels.call("label", ...space, classes, labels, found, drawn);
  if (count === at.NEEDS_PYTHON) return null;
  const arrays = { basin: Int32Array.from(kernels.view(labels), Number) };
  const [rows, points] = [kernels.view(found), kernels.view(drawn)];
  const attractors = Array.from({ length: count }, (_, k) => {
    const row = rows.subarray(k * at.FOUND_ENTRIES, (k + 1) * at.FOUND_ENTRIES);
    const own = points.subarray(2 * row[at.FOUND_FIRST], 2 * (row[at.FOUND_FIRST] + row[at.FOUND_POINTS]));
    arrays[`x${k}`] = own.filter((_, i) => i % 2 === 0);
    arrays[`v${k}`] = own.filter((_, i) => i % 2 === 1);
    return attractorOf(at, row);
  });
  return { attractors, arrays };
}

function attractorOf(at, row) {
  const [, kind] = Object.entries(KINDS).find(([name]) => at[name] === row[at.FOUND_KIND]);
  const [impacts, periods] = [row[at.FOUND_IMPACTS], row[at.FOUND_PERIODS]];
  const name = kind === "periodic" ? `(${Number.isFinite(impacts) ? impacts : "inf"}, ${periods})` : kind;
  return { kind, name, n_periods: periods, n_impacts: impacts, fraction: row[at.FOUND_FRACTION], error: row[at.FOUND_ERROR] };
}

/** Return the arrays in which the motions of a study are followed, and the rules; null where it needs Python. */
function spaceOf(kernels, study) {
  kernels.clear();
  const read = readStudy(study, kernels);
  if (read === null || read.harmonics.length !== 1) return null;
  const at = kernels.columns;
  const law = lawOf(kernels, read).rows;
  const t0 = instantOf(kernels, read, [0, 0, 0], read.t0);
  const rules = kernels.floats(at.RULES_ENTRIES);
  const view = kernels.view(rules);
  [view[at.RULES_T0], view[at.RULES_PERIODS], view[at.RULES_ESCAPE]] = [t0, PERIODS, ESCAPE];
  const strobes = (columns) => kernels.floats(at.MOST_STROBES, columns);
  return [
    law, kernels.zeros(at.STATE_ENTRIES), kernels.integers(at.COUNTERS), kernels.zeros(3, 1, 2),
    kernels.floats(at.BUFFER, at.EVENT_COLUMNS), kernels.integers(at.BUFFER, at.MARK_COLUMNS), kernels.floats(at.GRAZES, at.GRAZE_COLUMNS),
    kernels.zeros(at.PLAN_ENTRIES), kernels.zeros(at.N_OBSERVABLES),
    strobes(at.POINT_COLUMNS), strobes(at.POINT_COLUMNS), strobes(2), strobes(2), strobes(2),
    kernels.floats(0, at.STOP_COLUMNS), kernels.floats(4), kernels.zeros(5, 1, 2),
    kernels.floats(at.BLOCKS), kernels.floats(at.EXPONENT_COLUMNS), kernels.floats(2, 2), kernels.integers(at.SIDE, at.SIDE), rules,
  ];
}

function filled(kernels, array, values) {
  kernels.view(array).set(values);
  return array;
}
