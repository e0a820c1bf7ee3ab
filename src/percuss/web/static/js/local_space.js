// The arrays in which kernels follow motions that are no more than compared.

import { instantOf, lawOf } from "./local_motion.js";
import { readStudy } from "./local_study.js";

/**
 * Return {space, start}: the arrays, and (x0, v0, t0) of a study with one harmonic; null where it needs Python.
 * Of the arrays, too: `motion`, those in which one is followed, `measured` and `stops`.
 */
export function spaceOf(kernels, study) {
  kernels.clear();
  const read = readStudy(study, kernels);
  if (read === null || read.harmonics.length !== 1) return null;
  const at = kernels.columns;
  const motion = [
    lawOf(kernels, read).rows, kernels.zeros(at.STATE_ENTRIES), kernels.integers(at.COUNTERS), kernels.zeros(3, 1, 2),
    kernels.floats(at.BUFFER, at.EVENT_COLUMNS), kernels.integers(at.BUFFER, at.MARK_COLUMNS), kernels.floats(at.GRAZES, at.GRAZE_COLUMNS),
  ];
  const start = [read.x0, read.v0, instantOf(kernels, read, [0, 0, 0], read.t0)];
  const measured = [kernels.zeros(at.PLAN_ENTRIES), kernels.zeros(at.N_OBSERVABLES)];
  const strobes = (columns) => kernels.floats(at.MOST_STROBES, columns);
  const stops = [kernels.floats(0, at.STOP_COLUMNS), kernels.floats(4), kernels.zeros(5, 1, 2)];
  const space = [
    ...motion, ...measured, strobes(at.POINT_COLUMNS), strobes(at.POINT_COLUMNS), strobes(2), strobes(2), strobes(2), ...stops,
    kernels.floats(at.BLOCKS), kernels.floats(at.EXPONENT_COLUMNS), kernels.floats(2, 2), kernels.integers(at.SIDE, at.SIDE),
  ];
  return { space, motion, measured, stops, start };
}

/** Return a new array of kernels with these numbers. */
export function filled(kernels, values, ...shape) {
  const array = kernels.floats(...shape);
  kernels.view(array).set(values);
  return array;
}
