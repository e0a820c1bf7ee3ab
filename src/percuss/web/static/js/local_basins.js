// Basins by the kernels, in a worker: the classes of starts, and the attractors where they go.

import { filled, spaceOf } from "./local_space.js";

// As percuss.basins has them: forcing periods until a start stays undecided, and what is far.
const [PERIODS, ESCAPE] = [1000, 1e6];
const KINDS = { PERIODIC: "periodic", CHAOTIC: "chaotic", REST: "rest", UNBOUNDED: "unbounded" };

/** Return the classes of starts, x and v of one after another; null where they need Python. */
export function classesOf(kernels, study, starts) {
  const ground = groundOf(kernels, study)?.arrays;
  if (ground === undefined) return null;
  const n = starts.length / 2;
  const given = filled(kernels, starts, n, 2);
  const classes = kernels.floats(n, kernels.columns.CLASS_ENTRIES);
  const status = kernels.call("classify", ...ground, given, classes);
  return status === kernels.columns.NEEDS_PYTHON ? null : { arrays: { classes: kernels.view(classes).slice() } };
}

/** Return the period of the motion of a study, 0 for none, -1 chaotic, -2 at rest, -3 unbounded; null where it needs Python. */
export function periodOf(kernels, study) {
  const ground = groundOf(kernels, study);
  if (ground === null) return null;
  const at = kernels.columns;
  const out = kernels.floats(1, at.CLASS_ENTRIES);
  const status = kernels.call("classify", ...ground.arrays, filled(kernels, ground.start.slice(0, 2), 1, 2), out);
  if (status === at.NEEDS_PYTHON) return null;
  const found = kernels.view(out);
  const kind = found[at.CLASS_KIND];
  return kind === at.PERIODIC ? found[at.CLASS_PERIODS] : -1 - [at.CHAOTIC, at.REST, at.UNBOUNDED].indexOf(kind);
}

/** Return {attractors, arrays} from the classes of all starts: `basin`, and points of the k-th in `x{k}`, `v{k}`. */
export function basinsOf(kernels, study, given) {
  const ground = groundOf(kernels, study).arrays;
  const at = kernels.columns;
  const n = given.length / at.CLASS_ENTRIES;
  const classes = filled(kernels, given, n, at.CLASS_ENTRIES);
  const labels = kernels.integers(n);
  const found = kernels.floats(at.MOST_FOUND, at.FOUND_ENTRIES);
  const drawn = kernels.floats(at.MOST_POINTS, 2);
  const count = kernels.call("label", ...ground, classes, labels, found, drawn);
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

/** Return {arrays, start}: those in which the motions of a study are followed with the rules of its basins, and its own; null where it needs Python. */
function groundOf(kernels, study) {
  const found = spaceOf(kernels, study);
  if (found === null) return null;
  const at = kernels.columns;
  const rules = kernels.floats(at.RULES_ENTRIES);
  const view = kernels.view(rules);
  [view[at.RULES_T0], view[at.RULES_PERIODS], view[at.RULES_ESCAPE]] = [found.start[2], PERIODS, ESCAPE];
  return { arrays: [...found.space, rules], start: found.start };
}
