// The cells of a chart of two parameters by the kernels: some of them, in one worker of several.

import { centreOf } from "./exact.js";
import { periodOf } from "./local_basins.js";
import { attractorOf, faultOf } from "./local_diagram.js";
import { answerExponent } from "./local_exponent.js";
import { spaceOf } from "./local_space.js";
import { put } from "./state.js";

// Forcing periods in which a motion is measured, as `percuss.sweep` has it.
const MEASURED = 64;
// Undefined where there is no motion.
const VALUES = {
  period: (kernels, study) => periodOf(kernels, study) ?? undefined,
  largest_lyapunov_exponent: (kernels, study) => {
    const { exponent } = answerExponent(kernels, { study })?.header ?? {};
    // After a contact it is minus infinity.
    return exponent ? (exponent.value ?? -Infinity) : undefined;
  },
  peak_impact_velocity: (kernels, study) => {
    const found = attractorOf(kernels, study, { points: MEASURED + 1 }, "STROBES");
    return found && !faultOf(kernels, found.status) ? found.values[kernels.columns.PEAK_SPEED] : undefined;
  },
};

/** Return {columns}: `value` of the cells that have these numbers; null where all need Python. */
export function chartPart(kernels, { study, path, low, high, path2, low2, high2, size, of }, numbers) {
  if (spaceOf(kernels, study) === null) return null;
  const value = Float64Array.from(numbers, (cell) => {
    const across = put(study, path, centreOf(low, high, Math.floor(cell / size), size));
    return VALUES[of](kernels, put(across, path2, centreOf(low2, high2, cell % size, size)));
  });
  return { columns: { value } };
}
