// A study as the numbers that the kernels take; null where it needs Python.

import { exactNumber, exactPhase } from "./exact.js";

// The keys that the kernels know; with any other one the server answers.
const KEYS = {
  study: ["oscillator", "forcing", "start", "run", "parameters"],
  oscillator: ["stiffness", "damping", "mass", "damping_coefficient", "units", "stops"],
  wall: ["type", "at", "side", "restitution"],
  soft: ["type", "at", "side", "stiffness", "damping"],
  forcing: ["constant", "harmonics", "per_mass"],
  harmonic: ["amplitude", "omega", "phase"],
  start: ["x0", "v0", "t0"],
  run: ["periods", "t_end", "max_impacts"],
};
const MOST = { stops: 16, harmonics: 64, periods: 20_000 };
const ZERO = [0, 0, 0];

/**
 * Return {given, stops, start, end, ...} of a study: the rows that `fill_law` takes, and the rest of the run.
 *
 * A study with a fault is null, too: its sentence is Python's.
 */
export function readStudy(study, kernels) {
  try {
    return read(study, kernels.columns);
  } catch (error) {
    if (error instanceof NeedsPython) return null;
    throw error;
  }
}

class NeedsPython extends Error {}

function read(study, at) {
  known(study, "study");
  const { oscillator = {}, forcing = {}, start = {}, run = {} } = study;
  known(oscillator, "oscillator");
  known(forcing, "forcing");
  known(start, "start");
  known(run, "run");
  const { stops = [], mass, units } = oscillator;
  const { harmonics = [] } = forcing;
  need(stops.length <= MOST.stops && harmonics.length <= MOST.harmonics);
  // Without a mass the units of one are a fault, and c has no meaning.
  need(mass !== undefined || (units?.mass === undefined && !("damping_coefficient" in oscillator)));
  need(mass === undefined || !("damping" in oscillator));
  need(forcing.per_mass === undefined || (forcing.per_mass === true && mass !== undefined));
  const given = Array.from({ length: 1 + stops.length + harmonics.length }, () => new Float64Array(at.GIVEN_COLUMNS));
  const put = (row, column, numbers) => given[row].set(numbers, column);
  put(0, at.GIVEN_STIFFNESS, number(oscillator.stiffness ?? 1));
  put(0, at.GIVEN_DAMPING, number((mass === undefined ? oscillator.damping : oscillator.damping_coefficient) ?? 0));
  put(0, at.GIVEN_CONSTANT, number(forcing.constant ?? 0));
  if (mass !== undefined) put(0, at.GIVEN_MASS, positive(mass));
  put(0, at.GIVEN_STOPS, [stops.length, harmonics.length, forcing.per_mass === true ? 1 : 0]);
  stops.forEach((stop, i) => putStop(stop, (column, numbers) => put(1 + i, column, numbers), at));
  harmonics.forEach((harmonic, j) => putHarmonic(harmonic, (column, numbers) => put(1 + stops.length + j, column, numbers), at));
  const places = stops.map((_, i) => given[1 + i][at.STOP_AT]);
  const begin = { x0: number(start.x0)[0], v0: number(start.v0)[0], t0: phase(start.t0 ?? 0) };
  checkStops(stops, places, begin.x0);
  return { given, stops, places, harmonics, mass: mass === undefined ? null : number(mass)[0], ...begin, ...endOf(run, harmonics) };
}

function putStop(stop, put, at) {
  const isWall = stop?.type === "wall";
  known(stop, isWall ? "wall" : "soft");
  need((isWall || stop.type === "soft") && (stop.side === "above" || stop.side === "below"));
  put(at.STOP_AT, number(stop.at));
  put(at.STOP_SIDE, [stop.side === "above" ? 1 : -1]);
  if (isWall) {
    const [restitution] = number(stop.restitution ?? 1);
    need(restitution >= 0 && restitution <= 1);
    put(at.STOP_RESTITUTION, [restitution]);
    put(at.STOP_IS_WALL, [1]);
    return;
  }
  put(at.STOP_STIFFNESS, number(stop.stiffness));
  put(at.STOP_DAMPING, number(stop.damping ?? 0));
}

function putHarmonic(harmonic, put, at) {
  known(harmonic, "harmonic");
  put(at.WAVE_OMEGA, positive(harmonic.omega));
  put(at.WAVE_AMPLITUDE, number(harmonic.amplitude));
  const { times, plus } = phase(harmonic.phase ?? 0);
  put(at.WAVE_TIMES, times);
  put(at.WAVE_PLUS, plus);
  // A whole number is exact in JSON, any other one the double that it is.
  if (typeof harmonic.phase === "number" && !Number.isInteger(harmonic.phase)) put(at.WAVE_IS_DOUBLE, [1]);
}

/** There is one wall at each side, the soft stops lie between, and so does the start. */
function checkStops(stops, places, x0) {
  for (const side of ["below", "above"]) {
    const sign = side === "above" ? 1 : -1;
    const walls = places.filter((_, i) => stops[i].type === "wall" && stops[i].side === side);
    need(walls.length <= 1);
    if (walls.length === 0) continue;
    need(sign * x0 <= sign * walls[0]);
    places.forEach((place, i) => need(place === walls[0] ? stops[i].type === "wall" && stops[i].side === side : sign * place < sign * walls[0]));
  }
}

function endOf(run, harmonics) {
  const { periods, t_end: end, max_impacts: most } = run;
  need((periods === undefined) !== (end === undefined));
  need(most === undefined || (Number.isInteger(most) && most >= 1));
  if (end !== undefined) return { periods: ZERO, end: phase(end), most };
  need(harmonics.length === 1);
  const count = positive(periods);
  need(count[0] <= MOST.periods);
  return { periods: count, end: null, most };
}

function known(table, name) {
  need(table !== null && typeof table === "object" && Object.keys(table).every((key) => KEYS[name].includes(key)));
}

function number(value) {
  const found = exactNumber(value);
  need(found !== null);
  return found;
}

function positive(value) {
  const found = number(value);
  need(found[0] > 0);
  return found;
}

function phase(value) {
  const found = exactPhase(value);
  need(found !== null);
  return found;
}

function need(isSo) {
  if (!isSo) throw new NeedsPython();
}
