// A chart of two parameters as a picture, and its legend.

import { shown, swatchOf, wordsOf } from "./dom.js";
import { endsOf } from "./scales.js";

// The colours of the files: of periods, of longer ones, and of what has none.
const NAMES = { 0: "no period found", "-1": "chaotic", "-2": "at rest", "-3": "unbounded", "-Infinity": "minus infinity" };
const COLOURS = { 1: "#56b4e9", 2: "#0072b2", 3: "#f0e442", 4: "#e69f00", 5: "#009e73", 6: "#cc79a7", 7: "#d55e00", 8: "#8c510a", 9: "#b8b8b8", 0: "#5c5c5c", "-1": "#1a1a1a", "-2": "#8fcfb2", "-3": "#ffffff", "-Infinity": "#8fcfb2" };
const LONGER = 9;
// Of numbers, and of those of both signs.
const SHADES = ["#00224e", "#434e6c", "#7d7c78", "#bcaf6f", "#fee838"];
const SIGNED = ["#542788", "#998ec3", "#f7f7f7", "#f1a340", "#b35806"];

/** Return what a value is called. */
export function valueText(of, value) {
  if (Number.isNaN(value)) return "no motion";
  return of === "period" ? (NAMES[value] ?? `period ${value}`) : `${wordsOf(of)} = ${value === -Infinity ? NAMES[value] : shown(value)}`;
}

/** Return {image, rows}: a pixel for each value, clear without a motion, and the legend. */
export function chartOf({ size, of }, values) {
  const isPeriod = of === "period";
  let [low, high] = endsOf(values);
  const isSigned = low < 0 && high > 0;
  if (isSigned) [low, high] = [Math.min(low, -high), Math.max(high, -low)];
  const shades = isSigned ? SIGNED : SHADES;
  const colourOf = (value) => {
    if (isPeriod || value === -Infinity) return COLOURS[Math.min(value, LONGER)];
    const place = (4 * (value - low)) / (high - low || 1);
    const k = Math.min(3, Math.floor(place));
    return `color-mix(in srgb, ${shades[k]}, ${shades[k + 1]} ${Math.round(100 * (place - k))}%)`;
  };
  const rank = (value) => (value > 0 ? value : LONGER + 1 - value);
  const found = isPeriod ? values.map((value) => Math.min(value, LONGER)) : shades.map((_, k) => low + (k / 4) * (high - low));
  const marked = [...new Set(found)].filter((value) => value < Infinity);
  if (isPeriod) marked.sort((one, other) => rank(one) - rank(other));
  const named = (value, k) => (isPeriod ? (value < LONGER ? valueText(of, value) : "longer period") : k === 0 ? valueText(of, value) : shown(value));
  const rows = marked.map((value, k) => swatchOf(colourOf(value), named(value, k)));
  if (values.includes(-Infinity)) rows.push(swatchOf(colourOf(-Infinity), NAMES[-Infinity]));
  const image = Object.assign(document.createElement("canvas"), { width: size, height: size });
  const context = image.getContext("2d");
  values.forEach((value, cell) => {
    if (Number.isNaN(value)) return;
    context.fillStyle = colourOf(value);
    context.fillRect(Math.floor(cell / size), size - 1 - (cell % size), 1, 1);
  });
  return { image, rows };
}
