// The study that a picture was computed from, and what has been changed since.

import { numberOf, sameMotion } from "./models.js";
import { get, put } from "./state.js";

/**
 * Say in a note what differs between the study of a request, or null, and the one that is set.
 *
 * paths: parameters that the request goes over, which may be any; parts: those of the start that matter.
 */
export function noteChanges(note, request, study, scope) {
  const what = request && changed(request.study, study, scope);
  note.textContent = what ? `The ${what} has been changed since; files and code are of what is shown. Compute again for what is set now.` : "";
  note.hidden = !what;
}

function changed(made, now, { paths = [], parts = ["x0", "v0", "t0"] }) {
  if (paths.some((it) => get(now, it) === undefined && !it.startsWith("start."))) return "motion";
  const at = (study) => paths.reduce((made, it) => put(made, it, 0), study);
  const [one, other] = [at(made), at(now)];
  if (!sameMotion(one, other)) return "motion";
  const value = (study, part) => numberOf(study.start?.[part] ?? 0);
  return parts.every((part) => value(one, part) === value(other, part)) ? "" : "start";
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
