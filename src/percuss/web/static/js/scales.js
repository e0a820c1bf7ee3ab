// Ranges, ticks and distances of plots.

import { shown } from "./dom.js";

/** Return the index of the nearest value in an increasing array. */
export function bisect(values, wanted) {
  let low = 0;
  let high = values.length - 1;
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (values[middle] < wanted) low = middle;
    else high = middle;
  }
  return wanted - values[low] < values[high] - wanted ? low : high;
}

/** Return the index of the first value above one in an increasing array, its length if there is none. */
export function after(values, wanted) {
  let low = 0;
  let high = values.length;
  while (low < high) {
    const middle = (low + high) >> 1;
    if (values[middle] <= wanted) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Return a curve at a time, between its points; where two are at one time, after that. */
export function between(times, values, time) {
  const i = Math.max(0, after(times, time) - 1);
  const width = times[i + 1] - times[i];
  return width > 0 && time > times[i] ? values[i] + (values[i + 1] - values[i]) * ((time - times[i]) / width) : values[i];
}

/** Return how many digits distinguish values of a range that differ by a part of its width. */
export function digitsOf([low, high], part = 1e-4) {
  const size = Math.max(Math.abs(low), Math.abs(high)) / ((high - low) * part);
  return Number.isFinite(size) ? Math.min(16, Math.max(6, Math.ceil(Math.log10(size)) + 1)) : 6;
}

/** Return the ends of a range in as many digits as tell them apart. */
export const rounded = (ends) => ends.map((end) => Number(end.toPrecision(Math.max(8, digitsOf(ends)))));

/** Return ticks with the digits that distinguish them. */
export function tickTexts(ticks) {
  const digits = ticks.length > 1 ? digitsOf([ticks[0], ticks.at(-1)], 0.5 / (ticks.length - 1)) : 6;
  return ticks.map((tick) => shown(tick, digits));
}

/** Return the ends of all layers and lines but those aside, with some room around them. */
export function extentOf(layers, lines, { logY, tight }) {
  const x = [Infinity, -Infinity];
  const y = [Infinity, -Infinity];
  for (const layer of layers) {
    if (layer.isAside) continue;
    widen(x, layer.x);
    widen(y, layer.y);
  }
  for (const line of lines) {
    if (line.x !== undefined) widen(x, [line.x]);
    if (line.y !== undefined) widen(y, [line.y]);
  }
  return { x: padded(x, tight ? 0 : 0.04), y: logY ? decades(y) : padded(y, 0.06) };
}

/** Return a range moved by a part of its width, and scaled about one of its values. */
export function moved(range, part, factor, about, log) {
  const [to, from] = log ? [Math.log10, (value) => 10 ** value] : [(value) => value, (value) => value];
  const [low, high] = range.map(to);
  const centre = about === null ? (low + high) / 2 : to(about);
  return [low, high].map((end) => from(centre + (end - centre) * factor + part * (high - low)));
}

/** Return a range that holds another one too, with room to grow where it has to. */
export function grown(range, other, log) {
  const room = (value, sign) => (log ? value * 3 ** sign : value + sign * 0.1 * (other[1] - other[0]));
  return [
    other[0] < range[0] ? room(other[0], -1) : range[0],
    other[1] > range[1] ? room(other[1], 1) : range[1],
  ];
}

/** Return the least and the largest of values, of those that are finite. */
export function endsOf(values) {
  const ends = [Infinity, -Infinity];
  widen(ends, values);
  return ends;
}

/** Widen a range to hold values; those that are not finite take no part. */
function widen(range, values) {
  let [low, high] = range;
  for (let i = 0; i < values.length; i += 1) {
    const value = values[i];
    if (value < low && value > -Infinity) low = value;
    if (value > high && value < Infinity) high = value;
  }
  range[0] = low;
  range[1] = high;
}

function padded([low, high], part) {
  if (!(low <= high)) return [0, 1];
  const pad = high > low ? part * (high - low) : Math.abs(low) * 0.1 || 1;
  return [low - pad, high + pad];
}

function decades([, high]) {
  return high > 1e-290 && high < 1e290 ? [high * 1e-7, high * 3] : [1e-6, 1];
}

const RAISED = Object.fromEntries([..."-0123456789"].map((digit, i) => [digit, [..."⁻⁰¹²³⁴⁵⁶⁷⁸⁹"][i]]));

/** Return the label of a power of ten, "" of anything else. */
function power(tick) {
  const exponent = Math.round(Math.log10(tick));
  if (Math.abs(tick / 10 ** exponent - 1) > 1e-6) return "";
  return `10${[...String(exponent)].map((digit) => RAISED[digit]).join("")}`;
}

/** Return the labels of the ticks of a logarithmic axis. */
export const logTexts = (ticks) => (ticks.every((tick) => power(tick) !== "") ? ticks.map(power) : tickTexts(ticks));

/** Return whether an axis can have these ends. */
export const isAxis = ([low, high], log) => low < high && Number.isFinite(high - low) && (!log || (low >= 1e-300 && high <= 1e300));

// Ticks of an axis, at most.
const MOST_TICKS = 24;

/**
 * Return ticks within two ends, counted before they are made: steps added one by one may never pass
 * the end.
 *
 * Those of a logarithmic axis are powers of ten, in a range that holds fewer than two of them, and
 * on others, multiples of a step.
 */
export function ticksOf(low, high, log, step = 0) {
  if (!isAxis([low, high], log)) return [];
  if (log) {
    const [first, last] = [Math.ceil(Math.log10(low) - 1e-9), Math.floor(Math.log10(high) + 1e-9)];
    const every = [1, 2, 5, 10, 20, 50].find((n) => (last - first) / n < 12) ?? 100;
    if (last > first) return multiples(Math.ceil(first / every), Math.floor(last / every), (k) => Number(`1e${k * every}`));
  }
  const least = (high - low) / MOST_TICKS;
  // Steps of 1, 2 or 5 times a power of ten.
  const unit = 10 ** Math.floor(Math.log10((high - low) / 5));
  const wide = step >= least && step < high - low ? step : unit * ([1, 2, 5].find((k) => k * unit >= (high - low) / 8) ?? 10);
  return multiples(Math.ceil(low / wide - 1e-9), Math.floor(high / wide + 1e-9), (k) => Number((k * wide).toPrecision(15)));
}

const multiples = (first, last, of) => Array.from({ length: Math.min(MOST_TICKS + 2, Math.max(0, last - first + 1)) || 0 }, (_, i) => of(first + i));
