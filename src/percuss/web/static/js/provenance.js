// The study that a picture was computed from, and what has been changed since.

import { numberOf, sameMotion } from "./models.js";
import { get, put } from "./state.js";

const MOTION = "The motion has been changed since";
const START = "The start has been changed since";
const REST = "files, code and link are of the picture that is shown. Compute again for what is set now.";

/**
 * Say what differs between the study a picture was made of and the one that is set; "" if nothing.
 *
 * path, path2: parameters that the picture goes over, which may be any; parts: those of the start that
 * matter to it.
 */
export function changedSince(made, now, { path = null, path2 = null, parts = ["x0", "v0", "t0"] } = {}) {
  const paths = [path, path2].filter((it) => it !== null);
  if (paths.some((it) => get(now, it) === undefined && !it.startsWith("start."))) return `${MOTION}; ${REST}`;
  const at = (study) => paths.reduce((made, it) => put(made, it, 0), study);
  const [one, other] = [at(made), at(now)];
  if (!sameMotion(one, other)) return `${MOTION}; ${REST}`;
  const value = (study, part) => numberOf(study.start?.[part] ?? 0);
  return parts.every((part) => value(one, part) === value(other, part)) ? "" : `${START}; ${REST}`;
}

const timeOf = (study) => Number(numberOf(study?.start?.t0 ?? 0).toPrecision(4));

/** Return at which times a picture samples the motion once a forcing period. */
export function sampledAt(study) {
  const t0 = timeOf(study);
  return t0 === 0 ? "at whole periods" : `at t = ${t0} + whole periods`;
}

/** Return when the motions of a picture start. */
export function startsAt(study) {
  const t0 = timeOf(study);
  return t0 === 0 ? "at the start" : `at the start, t0 = ${t0}`;
}
