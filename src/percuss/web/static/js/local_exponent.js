// The largest Lyapunov exponent of a motion by the kernels, as percuss.web.facts answers it.

import { filled, spaceOf } from "./local_space.js";

/** Return {header, arrays} with `exponent`, null there where there is none; null where it needs Python. */
export function answerExponent(kernels, { study }) {
  const found = spaceOf(kernels, study);
  if (found === null) return null;
  const at = kernels.columns;
  const out = kernels.zeros(at.OUT_ENTRIES);
  const isThere = kernels.call("exponent", ...found.space, filled(kernels, found.start, 3), out) === 1;
  const [value, error, sign] = kernels.view(out);
  const finite = Number.isFinite(value) ? value : null;
  return { header: { kind: "facts", exponent: isThere ? { value: finite, error, is_chaotic: sign > 0, is_settling: sign < 0, n_periods: at.PERIODS } : null }, arrays: {} };
}
