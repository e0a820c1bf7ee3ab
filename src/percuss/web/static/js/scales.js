// Ranges, ticks and distances of plots.

import { shown } from "./dom.js";

/** Return the index of the value in an increasing array that is nearest. */
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

/** Return how many digits tell values of a range apart that are a part of its width apart. */
export function digitsOf([low, high], part = 1e-4) {
  const size = Math.max(Math.abs(low), Math.abs(high)) / ((high - low) * part);
  return Number.isFinite(size) ? Math.min(16, Math.max(6, Math.ceil(Math.log10(size)) + 1)) : 6;
}

/** Return ticks with the digits that tell them apart. */
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

function widen(range, values) {
  let [low, high] = range;
  for (let i = 0; i < values.length; i += 1) {
    const value = values[i];
    if (value < low) low = value;
    if (value > high) high = value;
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
  if (!(high > 0)) return [1e-6, 1];
  return [high * 1e-7, high * 3];
}

const RAISED = Object.fromEntries([..."-0123456789"].map((digit, i) => [digit, [..."⁻⁰¹²³⁴⁵⁶⁷⁸⁹"][i]]));

/** Return the label of a tick of a logarithmic axis: whole powers of ten have one. */
export function power(tick) {
  if (tick === null || !(tick > 0)) return "";
  const exponent = Math.round(Math.log10(tick));
  if (Math.abs(tick / 10 ** exponent - 1) > 1e-6) return "";
  return `10${[...String(exponent)].map((digit) => RAISED[digit]).join("")}`;
}

/** Keep the ticks of a logarithmic axis that have a label. */
export const decadesOf = (_, splits) => splits.map((split) => (power(split) === "" ? null : split));
