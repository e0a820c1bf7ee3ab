// The worker that computes motions: it is sent the file of kernels first, then requests.

import { loadKernels } from "./kernels.js";
import { basinsOf, classesOf } from "./local_basins.js";
import { chartPart } from "./local_chart.js";
import { diagramPart } from "./local_diagram.js";
import { answerExponent } from "./local_exponent.js";
import { answerMotion } from "./local_motion.js";

// All other requests are for motions; these are for facts about one, or a part of a longer answer.
const ANSWERS = {
  facts: answerExponent,
  part: (kernels, { of, numbers }) => diagramPart(kernels, of, numbers),
  cells: (kernels, { of, numbers }) => chartPart(kernels, of, numbers),
  classes: (kernels, { of, starts }) => classesOf(kernels, of.study, starts),
  basins: (kernels, { of, classes }) => basinsOf(kernels, of.study, classes),
};

/** Return what the kernels answer, null where Python is needed. */
export const answerTo = (kernels, request) => (ANSWERS[request.kind] ?? answerMotion)(kernels, request);

/** Answer the messages to a worker's global object. */
export function serve(scope) {
  let kernels = null;
  scope.onmessage = async ({ data: { id, bytes, request } }) => {
    if (bytes !== undefined) kernels = loadKernels(bytes);
    if (request === undefined) return;
    try {
      const answer = answerTo(await kernels, request);
      const arrays = Object.values(answer?.arrays ?? answer?.columns ?? {});
      const buffers = [...new Set(arrays.map((array) => array.buffer))];
      scope.postMessage({ id, answer }, buffers);
    } catch (error) {
      // The server has an answer, or a sentence that says why there is none.
      scope.postMessage({ id, answer: null, failure: String(error) });
    }
  };
}

if (globalThis.document === undefined && globalThis.postMessage !== undefined) serve(globalThis);
