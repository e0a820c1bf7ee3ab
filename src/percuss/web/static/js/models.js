// The parameters of a study: their names and the ranges of their sliders.

import { get } from "./state.js";

const HARMONIC = { amplitude: 1, omega: 2, phase: 0 };
const WALL = { type: "wall", at: 0, side: "below", restitution: "0.8" };
const SOFT = { type: "soft", at: 0, side: "above", stiffness: 10, damping: 0 };

/** The kinds of models, and the stops that make each. */
export const MODELS = {
  impact: { label: "Impact oscillator", stiffness: 1, stops: [WALL] },
  bilinear: { label: "Bilinear oscillator", stiffness: 1, stops: [SOFT] },
  backlash: {
    label: "Backlash",
    stiffness: 0,
    stops: [
      { ...SOFT, at: -1, side: "below", stiffness: 25 },
      { ...SOFT, at: 1, side: "above", stiffness: 25 },
    ],
  },
  ball: { label: "Ball on a table", stiffness: 0, damping: 0, constant: -1, stops: [WALL] },
  own: { label: "Own stops (set below)" },
};

/** Return the kind of model that a study is. */
export function modelOf(study) {
  const { stiffness = 1, stops = [] } = study.oscillator;
  const kinds = stops.map((stop) => stop.type).join(" ");
  const isFree = numberOf(stiffness) === 0;
  if (kinds === "wall") return isFree ? "ball" : "impact";
  if (kinds === "soft" && !isFree) return "bilinear";
  if (kinds === "soft soft" && isFree) return "backlash";
  return "own";
}

/** Return a study with the stops of a model. */
export function withModel(study, kind) {
  const model = MODELS[kind];
  if (model.stops === undefined) return study;
  const stops = model.stops.map((stop) => ({ ...stop }));
  // A ball flies without a dashpot.
  const oscillator = { damping: model.damping ?? study.oscillator.damping ?? 0, stiffness: model.stiffness, stops };
  const forcing = { ...study.forcing, constant: model.constant ?? 0 };
  const at = numberOf(stops[0].at);
  const x0 = stops.length === 1 && stops[0].type === "wall" ? String(at + (stops[0].side === "below" ? 0.5 : -0.5)) : 0;
  return { ...study, oscillator, forcing, start: { ...study.start, x0, v0: 0 } };
}

/** Return a study of unit mass with that mass written: its motion stays, dashpots are c in place of c/2. */
export function withMass(study) {
  const { damping = 0, stiffness = 1, stops = [], units, ...rest } = study.oscillator;
  const soft = (stop) => (stop.type === "soft" ? { ...stop, damping: twice(stop.damping ?? 0) } : stop);
  const named = units && Object.keys(units).length > 0 ? { units: { ...units, mass: "kg" } } : {};
  return { ...study, oscillator: { ...rest, mass: 1, stiffness, damping_coefficient: twice(damping), stops: stops.map(soft), ...named } };
}

/** Return twice a number, exactly. */
function twice(value) {
  if (typeof value === "number") return 2 * value;
  return /^[-+\d.eE]+$/.test(value) ? String(2 * Number(value)) : `2*(${value})`;
}

/** Names of units to choose from, by what they measure. */
export const UNITS = { length: ["m", "mm", "cm", "um"], time: ["s", "ms", "min"], mass: ["kg", "g", "t"] };

/** Return a study with the name of a unit, none where it is empty. */
export function withUnit(study, quantity, name) {
  const { units: { [quantity]: _, ...others } = {}, ...oscillator } = study.oscillator;
  const units = name === "" ? others : { ...others, [quantity]: name };
  return { ...study, oscillator: Object.keys(units).length > 0 ? { ...oscillator, units } : oscillator };
}

export const newStop = (type) => ({ ...(type === "wall" ? WALL : SOFT) });
export const newHarmonic = () => ({ ...HARMONIC });

/** Return a study without one of its harmonics; without any it is followed for a time, not for periods. */
export function withoutHarmonic(study, index) {
  const { harmonics } = study.forcing;
  const rest = harmonics.filter((_, i) => i !== index);
  const forcing = { ...study.forcing, harmonics: rest };
  if (rest.length > 0 || !("periods" in study.run)) return { ...study, forcing };
  const { periods, ...run } = study.run;
  const time = (numberOf(periods) * 2 * Math.PI) / numberOf(harmonics[index].omega);
  return { ...study, forcing, run: { ...run, t_end: Number.isFinite(time) && time > 0 ? Number(time.toPrecision(3)) : 100 } };
}

// Forces that have a name, by the units of mass, length and time.
const FORCES = { "kg m s": "N", "t m s": "kN", "t mm s": "N", "kg mm ms": "kN", "g mm ms": "N" };

/** Return the names of the units of a study, empty where it has none. */
export function unitsOf({ oscillator, forcing }) {
  const { length = "", time = "", mass = "" } = oscillator.units ?? {};
  const velocity = length && time ? `${length}/${time}` : "";
  const acceleration = length && time ? `${length}/${time}²` : "";
  const frequency = time ? `1/${time}` : "";
  if (oscillator.mass === undefined) return { length, time, velocity, frequency, force: acceleration, push: acceleration, impulse: velocity, stiffness: time ? `1/${time}²` : "", damping: frequency };
  const named = FORCES[`${mass} ${length} ${time}`];
  const isKnown = mass && length && time;
  return {
    length, time, mass, velocity, frequency,
    // What a stop pushes with, and in an impact gives.
    push: named ?? (isKnown ? `${mass} ${acceleration}` : ""),
    impulse: named ? `${named} ${time}` : isKnown ? `${mass} ${velocity}` : "",
    force: forcing?.per_mass ? acceleration : (named ?? (isKnown ? `${mass} ${acceleration}` : "")),
    stiffness: named ? `${named}/${length}` : isKnown ? `${mass}/${time}²` : "",
    damping: named ? `${named} ${time}/${length}` : isKnown ? `${mass}/${time}` : "",
  };
}

/** Return the equation of a study in a line. */
export function equationOf({ oscillator }) {
  return oscillator.mass === undefined ? "x″ + 2a x′ + k x = f(t) + stops, unit mass" : "m x″ + c x′ + k x = F(t) + stops";
}

/** Return the rows of an oscillator: with a mass in engineers' units. */
function oscillatorRows({ oscillator }, units) {
  const stiffness = (range) => row("oscillator.stiffness", named("stiffness k", units.stiffness), range, "of the spring; 0: free flight");
  if (oscillator.mass === undefined) return [stiffness([-1, 4]), row("oscillator.damping", named("damping a", units.damping), [0, 1], "the term is 2 a x′; a negative one feeds energy in")];
  const isRatio = "damping_ratio" in oscillator;
  const name = isRatio ? "damping_ratio" : "damping_coefficient";
  const about = isRatio ? "c over its critical value" : "the term is c x′; a negative one feeds energy in";
  const damping = isRatio ? "damping ratio" : named("damping c", units.damping);
  return [
    row("oscillator.mass", named("mass m", units.mass), rangeAround(oscillator.mass), "forces are those on it"),
    stiffness(rangeAround(oscillator.stiffness)),
    row(`oscillator.${name}`, damping, isRatio ? [0, 1] : rangeAround(oscillator[name]), about),
  ];
}

/** Return a label with the unit of its number, where there is one. */
export const named = (label, unit) => (unit ? `${label} (${unit})` : label);

/** Return the ranges of displacements and velocities: with a mass those of the size of its gaps. */
function rangesOf({ oscillator }) {
  const size = Math.max(0, ...(oscillator.stops ?? []).map(({ at }) => Math.abs(numberOf(at)) || 0));
  const rate = Math.sqrt(numberOf(oscillator.stiffness) / numberOf(oscillator.mass));
  if (oscillator.mass === undefined || size === 0) return { lengths: [-3, 3], speeds: [-3, 3] };
  const around = (number) => [-1, 1].map((sign) => Number((3 * sign * number).toPrecision(2)));
  return { lengths: around(size), speeds: rate > 0 ? around(size * rate) : [-3, 3] };
}

/** Return the groups of parameters of a study, as the panel shows them. */
export function parametersOf(study) {
  const oscillator = study.oscillator;
  const units = unitsOf(study);
  // With a mass the numbers are of any size.
  const range = (value, usual) => (oscillator.mass === undefined ? usual : rangeAround(value));
  const { lengths: places, speeds } = rangesOf(study);
  const names = Object.keys(study.parameters ?? {});
  const own = names.map((name) => row(`parameters.${name}`, name, rangeAround(study.parameters[name]), "a parameter: what is an expression of it follows"));
  const groups = [
    ...(own.length > 0 ? [{ title: "Parameters", rows: own }] : []),
    { title: "Oscillator", rows: oscillatorRows(study, units) },
  ];
  (oscillator.stops ?? []).forEach((stop, i) => {
    const path = `oscillator.stops.${i}`;
    const rows = [row(`${path}.at`, named("at", units.length), places, "where the stop is")];
    const table = stop.type === "wall" && typeof stop.restitution === "object" ? stop.restitution : null;
    // Of a table of restitutions over the speed each value has a slider.
    if (table !== null) rows.push(...tableRows(`${path}.restitution`, table, units));
    else if (stop.type === "wall") rows.push(row(`${path}.restitution`, "restitution r", [0, 1], "1: no loss; 0: it stays"));
    else {
      rows.push(row(`${path}.stiffness`, named("stiffness", units.stiffness), range(stop.stiffness, [-0.9, 50]), "added to the spring's beyond the stop"));
      rows.push(row(`${path}.damping`, named("damping", units.damping), range(stop.damping, [0, 2]), "added beyond the stop"));
    }
    const number = oscillator.stops.length === 1 ? "" : ` ${i + 1}`;
    groups.push({ title: `${stop.type === "wall" ? "Wall" : "Soft stop"}${number}`, stop: i, rows });
  });
  groups.push({ title: "Forcing", rows: [row("forcing.constant", named("constant", units.force), range(study.forcing?.constant, [-2, 2]), "constant part of the force")] });
  const harmonics = study.forcing?.harmonics ?? [];
  harmonics.forEach((harmonic, i) => {
    const path = `forcing.harmonics.${i}`;
    groups.push({
      title: harmonics.length === 1 ? "Harmonic" : `Harmonic ${i + 1}`,
      harmonic: i,
      rows: [
        row(`${path}.amplitude`, named("amplitude", units.force), range(harmonic.amplitude, [0, 3])),
        row(`${path}.omega`, named("omega", units.frequency), range(harmonic.omega, [0.05, 6]), "angular frequency of the force"),
        row(`${path}.phase`, "phase", [-Math.PI, Math.PI], "radians: cos(omega t + phase); -pi/2 makes a sine"),
      ],
    });
  });
  const record = study.forcing?.record;
  if (record !== undefined) {
    const rows = [row("forcing.record.amplitude", "factor", rangeAround(record.amplitude ?? 1), "of the forces of the record")];
    if (record.omega !== undefined) rows.push(row("forcing.record.omega", named("omega", units.frequency), [0.05, 6], "frequency of the wave"));
    groups.push({ title: "Record", record: true, rows });
  }
  const lengths = {
    periods: row("run.periods", "periods", [2, 400], "how long it is followed, in forcing periods", 1),
    t_end: row("run.t_end", named("duration", units.time), [1, 500], "the time until which it is followed"),
    max_impacts: row("run.max_impacts", "impacts", [1, 1000], "how many impacts it is followed", 1),
  };
  groups.push({
    title: "Start and length",
    rows: [
      row("start.x0", named("x0", units.length), places, "displacement at the start"),
      row("start.v0", named("v0", units.velocity), speeds, "velocity at the start"),
      row("start.t0", named("t0", units.time), [0, 10], "time at the start: where in its period the force is then; orbits that are opened bring it along"),
      lengths[Object.keys(lengths).find((name) => name in study.run) ?? "t_end"],
    ],
  });
  return groups;
}

/** Return the rows of a restitution that is a table over the speed of impacts. */
function tableRows(path, { speeds = [], values = [] }, units) {
  const unit = units.velocity ? ` ${units.velocity}` : "";
  return values.map((_, k) => row(`${path}.values.${k}`, `r at speed ${speeds[k]}${unit}`, [0, 1], "restitution, linear between the speeds"));
}

/** Return a range of a slider about a value, from 0 where that is near. */
function rangeAround(value) {
  const number = numberOf(value);
  if (!Number.isFinite(number) || number === 0) return [-1, 1];
  return number > 0 ? [0, 2 * number] : [2 * number, 0];
}

/** Return a study with a record; one that does not repeat has no period to count in. */
export function withRecord(study, record) {
  const forcing = { harmonics: [], ...study.forcing, record: { amplitude: 1, ...record } };
  const { periods, ...run } = study.run;
  if (record.repeat || periods === undefined) return { ...study, forcing };
  return { ...study, forcing, run: { ...run, t_end: record.t.at(-1) } };
}

/** Return a study without its record. */
export function withoutRecord(study) {
  const { record: _, ...forcing } = study.forcing;
  return { ...study, forcing };
}

/** Say why a name cannot be that of a new parameter, "" if it can. */
export function nameFault(study, name) {
  if (!/^[A-Za-z_]\w*$/.test(name)) return "a letter, then letters, digits and _";
  if (["pi", "sqrt", "sin", "cos"].includes(name)) return `${name} has a meaning already`;
  return Object.hasOwn(study.parameters ?? {}, name) ? "there is one of this name" : "";
}

/** Return a number of a study, or its default where it is left out. */
export function valueOf(study, path) {
  const isOne = path === "forcing.record.amplitude" || path === "oscillator.stiffness" || path.endsWith(".restitution");
  return get(study, path) ?? (isOne ? 1 : undefined);
}

/** Return the numbers of one motion that another has otherwise, as "omega = 2.8"; the first few of them. */
export function differences(one, other, most = 3) {
  const rows = parametersOf(one).flatMap((group) => group.rows).filter(({ path }) => String(valueOf(one, path)) !== String(valueOf(other, path)));
  const texts = rows.slice(0, most).map(({ path, label }) => `${label} = ${valueOf(one, path) ?? 0}`);
  return [...texts, ...(rows.length > most ? ["…"] : [])].join(", ");
}

/** Return the names of the axes of the plots of a motion, with their units. */
export function axesOf(study) {
  const { length, time, velocity, frequency, push, impulse } = unitsOf(study);
  return {
    t: named("time t", time),
    x: named("displacement x", length),
    v: named("velocity v", velocity),
    speed: named("speed before the impact", velocity),
    omega: named("angular frequency omega", frequency),
    amplitude: named("amplitude", length),
    force: named("force", push),
    impulse: named("impulse", impulse),
  };
}

/** Return whether a value is an expression of parameters, which a slider does not set. */
export function isTied(study, value) {
  const words = String(value ?? "").match(/[A-Za-z_]\w*/g) ?? [];
  return words.some((word) => Object.hasOwn(study.parameters ?? {}, word));
}

function row(path, label, range, about = null, step = null) {
  return { path, label, range, step, about };
}

/** Return the parameters of the motion, and of its start, that a diagram can go over. */
export function pathsOf(study) {
  const named = (title) => (it) => ({ ...it, name: `${title}: ${it.label}` });
  const groups = parametersOf(study);
  const starts = groups.at(-1).rows.filter((it) => it.path === "start.x0" || it.path === "start.v0");
  const all = [...groups.slice(0, -1).flatMap((group) => group.rows.map(named(group.title))), ...starts.map(named("Start"))];
  // A ratio stands for the coefficient that follows from it.
  return all.filter((it) => it.path !== "oscillator.damping_ratio" && !isTied(study, get(study, it.path)));
}

/** Return the number that a text stands for: 0.5, "1/3", "-pi/2", "3*pi/4"; NaN if none. */
export function numberOf(value) {
  if (typeof value === "number") return value;
  const text = String(value ?? "").replaceAll(" ", "");
  const match = /^([+-]?)(\d+\.?\d*(?:e[+-]?\d+)?|\.\d+)?(\*?pi)?(?:\/(\d+\.?\d*))?$/i.exec(text);
  if (match === null || (match[2] === undefined && match[3] === undefined)) return Number.NaN;
  const size = Number(match[2] ?? 1) * (match[3] ? Math.PI : 1);
  return ((match[1] === "-" ? -1 : 1) * size) / Number(match[4] ?? 1);
}

/** Return whether two studies differ in their starts and lengths alone. */
export function sameMotion(one, other) {
  const model = ({ parameters, oscillator, forcing }) => JSON.stringify([parameters, oscillator, forcing]);
  return one === other || model(one) === model(other);
}

/** Return the part of x that walls leave. */
export function limitsOf({ oscillator }) {
  const ends = [-Infinity, Infinity];
  for (const { type, side, at } of oscillator.stops ?? []) if (type === "wall") ends[side === "below" ? 0 : 1] = numberOf(at);
  return ends;
}

/** Return a start of few digits off the walls: frames hold single precision. */
export function startAt(study, x, v, t0 = null) {
  const [low, high] = limitsOf(study);
  const at = (side) => study.oscillator.stops.findLast((stop) => stop.type === "wall" && stop.side === side).at;
  const near = 1e-6 * Math.max(1, Math.abs(x));
  const x0 = x < low + near ? at("below") : x > high - near ? at("above") : String(Number(x.toPrecision(8)));
  return { x0, v0: String(Number(v.toPrecision(8))), ...(t0 !== null && { t0: String(Number(t0.toPrecision(8))) }) };
}
