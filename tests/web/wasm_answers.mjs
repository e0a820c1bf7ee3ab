// Answers of the kernels as WebAssembly to studies on standard input, for tests/web/test_wasm.py.

import { readFile } from "node:fs/promises";
import { text } from "node:stream/consumers";

const [folder, what] = process.argv.slice(2);
const { loadKernels } = await import(`file://${folder}/js/kernels.js`);
const { answerMotion, follow, lawOf } = await import(`file://${folder}/js/local_motion.js`);
const { diagramPart } = await import(`file://${folder}/js/local_diagram.js`);
const { LocalBasins, LocalChart } = await import(`file://${folder}/js/local_jobs.js`);
const { answerTo } = await import(`file://${folder}/js/worker.js`);
const { readStudy } = await import(`file://${folder}/js/local_study.js`);
const kernels = await loadKernels(await readFile(`${folder}/kernels.wasm`));

const bits = (values) => Buffer.from(values.buffer, values.byteOffset, values.byteLength).toString("base64");

/** The law of a study and its events, as bytes. */
function record(study) {
  kernels.clear();
  const read = readStudy(study, kernels);
  if (read === null) return null;
  const law = bits(kernels.view(lawOf(kernels, read).rows));
  kernels.clear();
  const run = follow(kernels, read);
  if (run === null) return { law };
  return { law, events: bits(run.rows.events), marks: run.rows.marks, end: run.end, outcome: run.outcome };
}

/** What the page is given. */
function answer(study) {
  const found = answerMotion(kernels, { study });
  if (found === null) return null;
  const { header, arrays } = found;
  return { header, arrays: Object.fromEntries(Object.entries(arrays).map(([name, values]) => [name, bits(Float64Array.from(values))])) };
}

/** The points of a diagram, by their names. */
function diagram(request) {
  const found = diagramPart(kernels, request, Array.from({ length: request.values }, (_, k) => k));
  return found && { ...found, columns: Object.fromEntries(Object.entries(found.columns).map(([name, values]) => [name, bits(values)])) };
}

/** The largest exponent of a motion. */
const exponent = (study) => answerTo(kernels, { kind: "facts", study })?.header.exponent;

// As the page sends requests to a worker.
const worker = { answer: async (asked) => answerTo(kernels, structuredClone(asked)) };

/** All levels of a chart of two parameters, null where Python is needed. */
async function chart(request) {
  const levels = [];
  const isLocal = await new LocalChart([worker, worker], request, { answer: (header, { value }) => levels.push({ ...header, value: bits(value) }) }).run();
  return isLocal ? levels : null;
}

/** All levels of basins as two workers compute them, null where Python is needed. */
async function basins(request) {
  const levels = [];
  const isLocal = await new LocalBasins([worker, worker], request, { answer: (header, { basin, ...points }) => levels.push({ ...header, basin: Array.from(basin), points: Object.fromEntries(Object.entries(points).map(([name, values]) => [name, bits(values)])) }) }).run();
  return isLocal ? levels : null;
}

const studies = JSON.parse(await text(process.stdin));
process.stdout.write(JSON.stringify(await Promise.all(studies.map({ record, answer, diagram, chart, basins, exponent }[what]))));
