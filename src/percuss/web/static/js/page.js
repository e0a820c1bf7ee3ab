// The workbench as a page of its own.

import { KernelsInWorker, LocalRequests } from "./local_requests.js";
import { mount } from "./main.js";
import { overSocket } from "./transport.js";

const root = document.getElementById("percuss");

async function file(extension, request) {
  const response = await fetch(`/api/file/${extension}`, {
    method: "POST",
    headers: { "content-type": "application/json" },
    body: JSON.stringify(request),
  });
  if (!response.ok) throw new Error((await response.json().catch(() => ({}))).fault ?? "the server gave no file");
  const name = /filename="([^"]+)"/.exec(response.headers.get("content-disposition"))?.[1] ?? `motion.${extension}`;
  return { name, blob: await response.blob() };
}

const facts = await (await fetch("/api/presets")).json();
const scheme = location.protocol === "https:" ? "wss:" : "ws:";
const bytes = fetch("/static/kernels.wasm").then((response) => response.arrayBuffer());
// Kernels of a workbench that has ended, for the next one: to load them takes as long as all else.
const idle = [];
const beginKernels = () => idle.pop() ?? new KernelsInWorker(new Worker("/static/js/worker.js", { type: "module" }), bytes, (kernels) => idle.push(kernels));
const connect = (onState) => new LocalRequests(beginKernels, overSocket(`${scheme}//${location.host}/api/socket`, onState));

let workbench = null;

/** Begin as the address says; what was there before ends. */
export function begin() {
  workbench?.close();
  workbench = mount(root, { connect, facts, file, hasLinks: true });
}

begin();
