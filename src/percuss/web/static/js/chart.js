// Families of periodic orbits over a parameter: layers, legend, and the orbit under the cursor.

const COLOURS = ["--curve", "--orbit", "--c3", "--c4", "--c5", "--c6"];
const SPECIAL = {
  fold: "fold", period_doubling: "period doubling", symmetry_breaking: "symmetry breaking", grazing: "graze",
  chatter: "chatter", corner: "corner", strong_resonance: "strong resonance", torus: "torus",
  border_collision: "border collision",
};

/** Return the families of an answer: layers to draw, kinds for the legend, points to read out. */
export function familiesOf(header, arrays, of) {
  const kinds = new Map();
  const layers = [];
  const marks = [];
  const rows = header.families.map((family, i) => {
    const part = (name) => arrays[`${name}${i}`];
    return { family, value: part("value"), y: part(of), impacts: part("impacts"), periods: part("periods"), stable: part("stable"), real: part("admissible"), x0: part("x"), v0: part("v"), t0: part("t") };
  });
  for (const it of rows) {
    const names = Array.from(it.value, (_, k) => kindOf(it, k));
    // Families of formal orbits only are not drawn.
    for (const name of new Set(names.filter((_, k) => it.real[k] > 0))) {
      if (!kinds.has(name)) kinds.set(name, COLOURS[kinds.size % COLOURS.length]);
      const colour = kinds.get(name);
      const kept = (test) => masked(it.y, (k) => names[k] === name && it.real[k] > 0 && test(k));
      layers.push({ x: it.value, y: kept((k) => it.stable[k] === 0), colour, width: 1.5, dash: [5, 4] });
      layers.push({ x: it.value, y: kept((k) => it.stable[k] > 0), colour, width: 2.5 });
    }
    for (const [kind, value, row] of it.family.special) {
      if (it.real[row] > 0 && Number.isFinite(it.y[row])) marks.push({ kind: SPECIAL[kind] ?? kind, x: value, y: it.y[row], at: { it, k: row } });
    }
  }
  layers.push({ kind: "points", x: marks.map((mark) => mark.x), y: marks.map((mark) => mark.y), colour: "--ink", size: 7 });
  layers.push({ kind: "points", x: marks.map((mark) => mark.x), y: marks.map((mark) => mark.y), colour: "--paper", size: 4 });
  return { layers, kinds, rows, marks };
}

/** Return the orbit nearest to a place, {row of families, k}; null if none is near. */
export function nearestOrbit(rows, { x, y }, limits) {
  const [width, height] = [limits.x[1] - limits.x[0], limits.y[1] - limits.y[0]];
  let best = null;
  let least = 0.06;
  for (const it of rows) {
    for (let k = 0; k < it.value.length; k += 1) {
      if (!(it.real[k] > 0)) continue;
      const apart = Math.hypot((it.value[k] - x) / width, (it.y[k] - y) / height);
      if (apart < least) {
        least = apart;
        best = { it, k };
      }
    }
  }
  return best;
}

/** Return the bifurcation or graze whose square is under a place; null if none is. */
export function nearestMark(marks, { x, y }, limits) {
  const apart = (mark) => Math.hypot((mark.x - x) / (limits.x[1] - limits.x[0]), (mark.y - y) / (limits.y[1] - limits.y[0]));
  const best = marks.reduce((least, mark) => (least === null || apart(mark) < apart(least) ? mark : least), null);
  return best !== null && apart(best) < 0.015 ? best : null;
}

/** Return the text of an orbit. */
export function orbitText({ it, k }) {
  return `${kindOf(it, k)} ${it.stable[k] > 0 ? "stable" : "not stable"}`;
}

function kindOf({ impacts, periods }, k) {
  return `(${Number.isFinite(impacts[k]) ? impacts[k] : "∞"}, ${periods[k]})`;
}

/** Return values where a test holds, and one beside, so that pieces meet; NaN elsewhere. */
function masked(y, keep) {
  return Float32Array.from(y, (value, k) => (keep(k) || (k > 0 && keep(k - 1)) ? value : Number.NaN));
}
