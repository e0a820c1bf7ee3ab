// The worker that computes motions: it is sent the file of kernels first, then requests.

import { loadKernels } from "./kernels.js";
import { diagramPart } from "./local_diagram.js";
import { answerMotion } from "./local_motion.js";

/** Answer the messages to a worker's global object. */
export function serve(scope) {
  let kernels = null;
  scope.onmessage = async ({ data: { id, bytes, request } }) => {
    if (bytes !== undefined) kernels = loadKernels(bytes);
    if (request === undefined) return;
    try {
      const isPart = request.kind === "part";
      const answer = isPart ? diagramPart(await kernels, request.of, request.numbers) : answerMotion(await kernels, request);
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
