// The mechanical picture of masses in a row: boxes, springs, dashpots and stops, where they are.

import { shape } from "./dom.js";
import { count } from "./facts.js";

// Colours of the masses and of the stops, here and in the plots.
export const MASS_COLOURS = ["--curve", "--orbit", "--c3"];
export const STOP_COLOURS = ["--c4", "--stop"];

// Heights of the masses, springs, dashpots, stops and the ground [units of the picture].
const TOP = 46, BOTTOM = 126, GROUND = 134;
const SPRING = 66, DASHPOT = 88, STOP = 112;
const WIDTH = 76, INNER = 46, BETWEEN = 120, WALL = 11;
// The distance of masses in small pictures.
export const COMPACT = 74;
// The largest displacement and the largest gap in the picture.
const SWING = 40, CLEARANCE = 46;

/** Return where everything stands at rest, for elements of a structure and its largest displacement. */
function layoutOf(elements, largest, between) {
  const gaps = elements.stops.map((stop) => Math.abs(stop.at));
  const scale = (between / BETWEEN) * Math.min(SWING / Math.max(largest, 1e-9), CLEARANCE / Math.max(...gaps, 1e-9));
  const cavities = cavitiesOf(elements);
  const boxes = [];
  let right = between * 0.8;
  for (let i = 0; i < elements.n; i += 1) {
    const outer = cavities.find((it) => it.inner === i);
    if (outer) continue;
    const cavity = cavities.find((it) => it.outer === i);
    if (cavity) {
      const [low, high] = [-cavity.low * scale, cavity.high * scale];
      boxes[i] = { left: right, width: 2 * WALL + low + INNER + high, isFrame: true };
      boxes[cavity.inner] = { left: right + WALL + low, width: INNER, isInner: true };
    } else boxes[i] = { left: right, width: WIDTH };
    right += boxes[i].width + between;
  }
  return { elements, scale, cavities, boxes, between, width: right - between * 0.2 };
}

/** Return pairs {outer, inner, low, high}: of a mass with a stop on either side of its distance to another. */
function cavitiesOf({ n, stops }) {
  const found = [];
  for (let outer = 0; outer + 1 < n; outer += 1) {
    const inner = outer + 1;
    const ends = [];
    for (const stop of stops) {
      const sign = signOf(stop, inner, outer);
      if (sign !== 0) ends.push(sign * stop.at);
    }
    if (ends.length === 2 && Math.min(...ends) < 0 && Math.max(...ends) > 0) found.push({ outer, inner, low: Math.min(...ends), high: Math.max(...ends) });
  }
  return found;
}

/** Return 1 if a stop acts on x_i - x_j, -1 on the reverse, 0 on neither. */
function signOf({ on }, i, j) {
  const others = on.some((part, k) => k !== i && k !== j && part !== 0);
  return others || on[i] === 0 || on[i] !== -on[j] ? 0 : Math.sign(on[i]);
}

/** The picture, an SVG that follows displacements. */
export class MechanismPicture {
  constructor() {
    this.svg = shape("svg", { class: "mechanism", role: "img" });
  }

  /** Take a structure; its largest displacement fits between its masses, so far apart at rest. */
  take(elements, largest, between = BETWEEN) {
    this.layout = layoutOf(elements, largest, between);
    const { n, springs, dashpots, stops } = elements;
    this.svg.setAttribute("viewBox", `0 0 ${this.layout.width} ${GROUND + 14}`);
    this.svg.setAttribute("aria-label", `${n} masses, ${count(springs.length, "spring")}, ${count(dashpots.length, "dashpot")}, ${count(stops.length, "stop")}`);
  }

  /** Draw the masses at displacements x. */
  draw(x) {
    const { elements, boxes, scale, width } = this.layout;
    const places = boxes.map((box, i) => ({ ...box, left: box.left + scale * x[i], right: box.left + box.width + scale * x[i] }));
    const parts = [ground(0, GROUND, width), ...this.#joints(places)];
    places.forEach((box, i) => parts.push(...mass(box, i)));
    parts.push(...this.#stops(places));
    elements.loads.forEach((on) => on.forEach((part, i) => part !== 0 && parts.push(...force(places[i], Math.sign(part)))));
    this.svg.replaceChildren(...parts);
    this.svg.dataset.x = JSON.stringify(Array.from(x));
  }

  #joints(places) {
    const { elements, width, cavities } = this.layout;
    const between = (i, j) => {
      if (i >= 0 && cavities.some((it) => it.outer === i && it.inner === j)) return [places[i].left + WALL, places[j].left];
      // What lies in a cavity is held through the wall of the picture at its side.
      if (i < 0) return j === 0 && elements.n > 0 ? [8, places[j].left] : [places[j].right, width - 8];
      return [places[i].right, places[j].left];
    };
    const parts = [];
    for (const [kind, rows, y] of [["spring", elements.springs, SPRING], ["dashpot", elements.dashpots, DASHPOT]]) {
      for (const [i, j] of rows) {
        const [from, to] = between(i, j);
        parts.push(shape("path", { class: kind, d: (kind === "spring" ? zigzag : dashpot)(from, to, y) }));
        if (i < 0) parts.push(j === 0 ? ground(8, TOP, BOTTOM, true, -1) : ground(width - 8, TOP, BOTTOM, true, 1));
      }
    }
    return parts;
  }

  #stops(places) {
    const { elements, boxes, scale, between } = this.layout;
    return elements.stops.flatMap((stop, k) => {
      const colour = STOP_COLOURS[k];
      const isSoft = stop.type === "soft";
      const i = stop.on.findIndex((part) => part !== 0);
      const j = stop.on.findLastIndex((part) => part !== 0);
      if (i !== j) {
        // On a distance: in a cavity its walls are the stops, elsewhere a peg of the right mass.
        if (boxes[i].isFrame && boxes[j].isInner) {
          const isLeft = (stop.side === "above" ? 1 : -1) * stop.on[j] < 0;
          return [coloured("wall", `M${isLeft ? places[i].left + WALL : places[i].right - WALL} ${TOP}V${BOTTOM - 20}`, colour)];
        }
        const reach = between - scale * Math.abs(stop.at);
        return [bumper(places[j].left - reach, places[j].left, places[i].right, isSoft, 1, colour)];
      }
      const side = (stop.side === "above" ? 1 : -1) * Math.sign(stop.on[i]);
      const edge = side > 0 ? boxes[i].left + boxes[i].width : boxes[i].left;
      const face = edge + (scale * stop.at) / stop.on[i];
      const root = face + side * (isSoft ? 32 : 22);
      return [bumper(face, root, side > 0 ? places[i].right : places[i].left, isSoft, side, colour), ground(root, STOP - 16, GROUND, true, side)];
    });
  }
}

/** A stop from its face to its root, in front of the edge of a mass; a soft one is pressed in. */
function bumper(face, root, edge, isSoft, side, colour) {
  const at = !isSoft ? face : side > 0 ? Math.max(face, edge) : Math.min(face, edge);
  const stem = isSoft ? zigzag(at, root, STOP, 5, Math.abs(root - face) < 50 ? 6 : 12) : `M${at} ${STOP}H${root}`;
  return coloured(isSoft ? "soft" : "wall", `M${at} ${STOP - 9}V${STOP + 9}${stem}`, colour);
}

function coloured(name, d, colour) {
  const made = shape("path", { class: name, d });
  made.style.stroke = `var(${colour})`;
  return made;
}

function mass({ left, right, width, isFrame, isInner }, i) {
  const label = shape("text", { x: isFrame ? left + width / 2 : (left + right) / 2, y: isFrame ? BOTTOM - 6 : (isInner ? TOP + 40 : TOP + 28), "text-anchor": "middle" });
  label.append(`m${"₁₂₃"[i] ?? i + 1}`);
  const colour = `var(${MASS_COLOURS[i]})`;
  label.style.fill = colour;
  if (!isFrame) return [shape("rect", { class: "mass", x: left, y: isInner ? TOP + 8 : TOP, width, height: (isInner ? BOTTOM - 26 : BOTTOM) - (isInner ? TOP + 8 : TOP), rx: 3 }), label];
  const floor = BOTTOM - 20;
  const d = `M${left} ${TOP}h${WALL}V${floor}H${right - WALL}V${TOP}h${WALL}V${BOTTOM}H${left}Z`;
  return [shape("path", { class: "mass", d }), label];
}

/** An arrow over a mass. */
function force({ left, right, width }, sign) {
  const [from, to] = [(left + right) / 2 - sign * 22, (left + right) / 2 + sign * 22];
  const label = shape("text", { x: to + sign * 12, y: 29, "text-anchor": "middle" });
  label.append("F");
  return width ? [shape("path", { class: "load", d: `M${from} 24H${to}m${-sign * 8} -5l${sign * 8} 5l${-sign * 8} 5` }), label] : [];
}

function zigzag(from, to, y, high = 7, n = 12) {
  const span = to - from;
  const end = Math.sign(span) * Math.min(9, Math.abs(span) / 5);
  const step = (span - 2 * end) / n;
  let d = `M${from} ${y}h${end}`;
  for (let k = 0; k < n; k += 1) d += `l${step} ${(k % 2 ? -1 : 1) * (k === 0 || k === n - 1 ? 1 : 2) * high * 0.9}`;
  return `${d}H${to}`;
}

/** A cylinder that is fixed on the left, and a piston on the right. */
function dashpot(from, to, y) {
  const span = to - from;
  if (span < 10) return `M${from} ${y}H${to}`;
  const [back, front] = [from + 0.3 * span, from + 0.72 * span];
  const piston = from + 0.55 * span;
  return `M${from} ${y}H${back}M${front} ${y - 8}H${back}V${y + 8}H${front}M${piston} ${y - 6}V${y + 6}M${piston} ${y}H${to}`;
}

/** A line with hatches behind it: across at a height, or upright at x from a height to another. */
function ground(x, from, to, isUpright = false, side = 1) {
  let d = isUpright ? `M${x} ${from}V${to}` : `M${x} ${from}H${to}`;
  if (isUpright) for (let y = from + 8; y <= to; y += 8) d += `M${x} ${y}l${side * 7} ${-7}`;
  else for (let at = x + 10; at < to; at += 12) d += `M${at} ${from}l-8 8`;
  return shape("path", { class: "ground", d });
}
