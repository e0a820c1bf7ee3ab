// The workbench as a static site: no server, so that what the kernels alone can answer is answered.

import { KernelsInWorker, LocalRequests } from "./local_requests.js";
import { mount } from "./main.js";

const NEEDED = "percuss on your machine: percuss serve";
const NAMES = {
  diagram: "this diagram needs", sweep: "this chart needs pc.sweep, in", response: "response charts need", basins: "basins need", saddles: "saddles need",
  mechanism: "structures need", certify: "proofs need", record: "records need", measured: "fits need", fit: "fits need",
  design: "designs need", study_file: "study files need", explore: "this motion has numbers that need",
};

/** Return why a request has no answer here. */
const refuse = ({ kind }) => `${NAMES[kind] ?? "this needs"} ${NEEDED}`;

/** Begin; `facts` as of the server's page data, `worker` the text of the worker's script, `kernels` their file in base 64. */
export function begin(root, { facts, worker, kernels }) {
  const bytes = Uint8Array.from(atob(kernels), (letter) => letter.charCodeAt(0));
  const address = URL.createObjectURL(new Blob([worker], { type: "text/javascript" }));
  const beginKernels = () => new KernelsInWorker(new Worker(address), Promise.resolve(bytes.buffer));
  const connect = (onState) => {
    queueMicrotask(() => onState(true));
    return new LocalRequests(beginKernels, null, refuse);
  };
  const file = () => Promise.reject(new Error(`files and Python need ${NEEDED}`));
  return mount(root, { connect, facts, file, hasLinks: true, isStatic: true });
}
