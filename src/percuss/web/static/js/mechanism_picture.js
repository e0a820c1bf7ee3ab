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

// The picture of one mass: room beside it for the spring, and the length of what it goes through.
const BESIDE = 78, TRAVEL = 116, BALL = 60, MARGIN = 36, TABLE = 44;
const MIDDLE = (TOP + BOTTOM) / 2;

/**
 * Return where everything stands at rest of one mass that moves through [low, high].
 *
 * Its stops are in that range, too; without a spring and with one stop it is a ball, upright.
 */
function layoutOfOne(elements, [low, high]) {
  const places = elements.stops.map((stop) => stop.at);
  const ends = [Math.min(low, ...places), Math.max(high, ...places)];
  const scale = TRAVEL / Math.max(ends[1] - ends[0], 1e-9);
  const centre = (ends[0] + ends[1]) / 2;
  const isUpright = elements.springs.length === 0 && elements.dashpots.length === 0 && elements.stops.length === 1;
  const [beside, size] = isUpright ? [MARGIN, BALL] : [BESIDE, WIDTH];
  const left = beside + TRAVEL / 2;
  // How far the mass goes beyond its place in the middle [units of the picture].
  const reach = [low, high].map((end) => scale * (end - centre));
  return { elements, scale, centre, reach, isUpright, cavities: [], boxes: [{ left, width: size }], between: beside, width: 2 * left + size };
}

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
  return { elements, scale, centre: 0, cavities, boxes, between, width: right - between * 0.2 };
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
    this.parts = shape("g", {});
    this.svg = shape("svg", { class: "mechanism", role: "img" });
    this.svg.append(this.parts);
  }

  /** Take a structure; its largest displacement fits between its masses, so far apart at rest. */
  take(elements, largest, between = BETWEEN) {
    this.#lay(layoutOf(elements, largest, between));
  }

  /** Take an oscillator, one mass that moves through a range. */
  takeOne(elements, range) {
    this.#lay(layoutOfOne(elements, range));
  }

  #lay(layout) {
    this.layout = layout;
    const { width, isUpright } = layout;
    const { n, springs, dashpots, stops } = layout.elements;
    const box = isUpright ? `${-TABLE} 0 ${GROUND + 14 + 2 * TABLE} ${width}` : `0 ${n === 1 ? 8 : 0} ${width} ${GROUND + 14 - (n === 1 ? 8 : 0)}`;
    this.svg.setAttribute("viewBox", box);
    // Along x is upwards where it stands upright.
    if (isUpright) this.parts.setAttribute("transform", `matrix(0 -1 1 0 0 ${width})`);
    else this.parts.removeAttribute("transform");
    this.svg.setAttribute("aria-label", `${n === 1 ? "1 mass" : `${n} masses`}, ${count(springs.length, "spring")}, ${count(dashpots.length, "dashpot")}, ${count(stops.length, "stop")}`);
  }

  /** Draw the masses at displacements x. */
  draw(x) {
    const { elements, boxes, scale, centre, width, isUpright } = this.layout;
    const places = boxes.map((box, i) => ({ ...box, left: box.left + scale * (x[i] - centre), right: box.left + box.width + scale * (x[i] - centre) }));
    const parts = [...(isUpright ? [] : [ground(0, GROUND, width)]), ...this.#joints(places)];
    places.forEach((box, i) => parts.push(...(isUpright ? ball(box) : mass(box, places.length === 1 ? "m" : `m${"₁₂₃"[i] ?? i + 1}`, MASS_COLOURS[i]))));
    parts.push(...this.#stops(places));
    elements.loads.forEach((on) => on.forEach((part, i) => part !== 0 && parts.push(...force(places[i], Math.sign(part)))));
    if (isUpright) for (const text of parts.filter((it) => it.tagName === "text")) text.setAttribute("transform", `rotate(90 ${text.getAttribute("x")} ${text.getAttribute("y")})`);
    this.parts.replaceChildren(...parts);
    this.svg.dataset.x = JSON.stringify(Array.from(x));
    this.places = places;
  }

  /** Return the box of a mass in the units of the picture: {x, y, width, height}. */
  boxOf(i) {
    const { left, right, width } = this.places[i];
    if (!this.layout.isUpright) return { x: left, y: TOP, width: right - left, height: BOTTOM - TOP };
    return { x: MIDDLE - width / 2, y: this.layout.width - right, width, height: width };
  }

  /** Return the displacement that a move of the pointer by so many pixels stands for. */
  displacement(right, down) {
    const { a: unit } = this.svg.getScreenCTM();
    return (this.layout.isUpright ? -down : right) / unit / this.layout.scale;
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
      const colour = STOP_COLOURS[k % STOP_COLOURS.length];
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
      const face = edge + scale * (stop.at / stop.on[i] - this.layout.centre);
      const at = side > 0 ? places[i].right : places[i].left;
      const root = this.#rootOf(face, edge, side, isSoft);
      if (!this.layout.isUpright) return [bumper(face, root, at, isSoft, side, colour), ground(root, STOP - 16, GROUND, true, side)];
      const table = isSoft ? bumper(face, root, at, true, side, colour, MIDDLE, 22) : coloured("wall", `M${face} ${TOP - TABLE}V${BOTTOM + TABLE}`, colour);
      return [table, ground(isSoft ? root : face, TOP - TABLE, BOTTOM + TABLE, true, side)];
    });
  }

  /** Return where a stop is held: behind the deepest that one mass goes into it. */
  #rootOf(face, edge, side, isSoft) {
    const { reach } = this.layout;
    const deepest = reach === undefined ? face : side > 0 ? Math.max(face, edge + reach[1]) : Math.min(face, edge + reach[0]);
    return isSoft ? side * Math.max(side * face + 32, side * deepest + 18) : face + side * 22;
  }
}

/** A stop from its face to its root, in front of the edge of a mass; a soft one is pressed in. */
function bumper(face, root, edge, isSoft, side, colour, y = STOP, half = 9) {
  const at = !isSoft ? face : side > 0 ? Math.max(face, edge) : Math.min(face, edge);
  const stem = isSoft ? zigzag(at, root, y, 5, Math.abs(root - face) < 50 ? 6 : 12) : `M${at} ${y}H${root}`;
  return coloured(isSoft ? "soft" : "wall", `M${at} ${y - half}V${y + half}${stem}`, colour);
}

function ball({ left, width }) {
  const label = shape("text", { x: left + width / 2, y: MIDDLE, "text-anchor": "middle", "dominant-baseline": "central" });
  label.append("m");
  label.style.fill = `var(${MASS_COLOURS[0]})`;
  return [shape("circle", { class: "mass", cx: left + width / 2, cy: MIDDLE, r: width / 2 }), label];
}

function coloured(name, d, colour) {
  const made = shape("path", { class: name, d });
  made.style.stroke = `var(${colour})`;
  return made;
}

function mass({ left, right, width, isFrame, isInner }, name, tint) {
  const label = shape("text", { x: isFrame ? left + width / 2 : (left + right) / 2, y: isFrame ? BOTTOM - 6 : (isInner ? TOP + 40 : TOP + 28), "text-anchor": "middle" });
  label.append(name);
  label.style.fill = `var(${tint})`;
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
