// The forces and impulses of stops over time, of one mass or of several.

import { element } from "./dom.js";
import { STOP_COLOURS } from "./mechanism_picture.js";
import { extentOf } from "./scales.js";

/** The options of the plots of impacts and of forces. */
export const IMPACTS = { title: "Impacts", x: "cycle (t / period) mod 1", y: "speed before the impact", kind: "points", names: ["cycle", "speed before"] };
export const FORCES = {
  title: "Forces at stops", x: "time t", y: "force", kind: "line", names: ["t", "force"],
  about: "lines: forces of soft stops, and of walls in contact; squares: impulses of impacts on walls",
};

/** Return whether a direction is that of one mass. */
export const isOne = (on) => on.filter((part) => part !== 0).length === 1;

/** Return what a stop is called among the others. */
export function stopName(stops, k) {
  const { type, on, side } = stops[k];
  const same = stops.filter((stop) => stop.type === type).length > 1;
  const where = same && (!isOne(on) || on.length === 1) ? (side === "below" ? " left" : " right") : same ? ` ${k + 1}` : "";
  return `${type === "wall" ? "wall" : "soft stop"}${where}`;
}

/** Return two columns of the events at a stop. */
export const ofStop = ({ event_stop: stop }, k, ...columns) => columns.map((column) => column.filter((_, i) => stop[i] === k));

/** Put names in their colours into the caption of a plot. */
export function legend(plot, rows) {
  const texts = rows.map(([name, colour]) => {
    const text = element("span", {}, `■ ${name}`);
    text.style.color = `var(${colour})`;
    return text;
  });
  plot.key.replaceChildren(...texts.flatMap((text) => [text, " "]));
  plot.key.title = plot.key.textContent;
}

/**
 * Show in a plot the forces of stops as lines, and the impulses of impacts as squares.
 *
 * curve: t; force0, … of the stops, over t or over force_t0, …; event_t, event_stop, impulse.
 * names: the labels of time, force and impulse.
 */
export function showForces(plot, curve, stops, names, isHeld = false) {
  const [low, high] = [curve.t[0], curve.t.at(-1)];
  const colourOf = (k) => STOP_COLOURS[k % STOP_COLOURS.length];
  // A wall that only hits has no force.
  const lines = stops
    .map((_, k) => ({ x: curve[`force_t${k}`] ?? curve.t, y: curve[`force${k}`], colour: colourOf(k) }))
    .filter(({ y }, k) => y !== undefined && (stops[k].type === "soft" || y.some((value) => value !== 0)));
  const impulses = stops.map((_, k) => {
    const [x, y] = ofStop(curve, k, curve.event_t, curve.impulse);
    const seen = (values) => values.filter((_, i) => x[i] >= low && x[i] <= high);
    return { kind: "points", x: seen(x), y: seen(y), colour: colourOf(k), size: 4 };
  });
  const hasWall = stops.some((stop) => stop.type === "wall");
  const both = ["Forces and impulses at stops", `${names.force} (line), ${names.impulse} (squares)`];
  const [title, label] = lines.length === 0 ? ["Impulses at stops", names.impulse] : hasWall ? both : ["Forces at stops", names.force];
  plot.rename(title);
  plot.label(names.t, label);
  legend(plot, stops.map((_, k) => [stopName(stops, k), colourOf(k)]));
  // All times that the other plots show, and 0.
  const layers = [...lines, ...impulses];
  plot.show(layers, [], { ...extentOf([...layers, { x: [low], y: [0] }], [], { logY: false, tight: true }), x: [low, high] }, isHeld);
  if (curve.event_t.length === 0 && lines.length === 0) plot.say("no stop is met");
  return lines;
}
