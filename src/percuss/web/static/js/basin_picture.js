// Basins as layers of a plot, and their legend.

import { swatchOf } from "./dom.js";
import { asCanvas } from "./draw.js";

// The same colours as in the files, of the largest basin first; after them undecided and impossible starts.
const COLOURS = [[86, 180, 233], [230, 159, 0], [0, 158, 115], [204, 121, 167], [0, 114, 178], [213, 94, 0], [240, 228, 66]];
const OTHERS = [154, 154, 154];
const NO_START = [77, 77, 77];
// Basins are so much paler than the attractors in them, that lines are seen on them; in the dark
// they are as much darker.
const PALE = 0.45;
const PAPERS = { light: [255, 255, 255], dark: [22, 29, 37] };

/** Return the colours of the attractors, by the sizes of their basins. */
function coloursOf(attractors) {
  const order = attractors.map((_, k) => k).sort((one, other) => attractors[other].fraction - attractors[one].fraction);
  const colours = attractors.map(() => OTHERS);
  order.slice(0, COLOURS.length).forEach((k, rank) => (colours[k] = COLOURS[rank]));
  return colours;
}

const pale = (colour, theme) => colour.map((part, k) => Math.round(PAPERS[theme][k] + PALE * (part - PAPERS[theme][k])));
const css = (colour) => `rgb(${colour.join()})`;

/** Return the name of an attractor. */
export function nameOf({ kind, name, n_impacts: impacts, n_periods: periods }) {
  return kind === "periodic" ? `periodic ${name || `(${impacts ?? "∞"}, ${periods})`}` : kind;
}

/** Return the basins as a picture, a pixel for each start. */
export function pictureOf({ size, attractors }, basin, theme) {
  const image = new ImageData(size, size);
  const pixels = new Uint32Array(image.data.buffer);
  const table = coloursOf(attractors).map((it) => packed(pale(it, theme)));
  const colourOf = (label) => (label === -1 ? packed(PAPERS[theme]) : label < 0 ? packed(NO_START) : table[label]);
  for (let i = 0; i < size; i += 1) {
    for (let j = 0; j < size; j += 1) {
      pixels[(size - 1 - j) * size + i] = colourOf(basin[i * size + j]);
    }
  }
  return asCanvas(image);
}

/** Return the layers: the picture, the manifolds, the saddles and the attractors. */
export function basinLayers(header, arrays, image, box, saddles) {
  // Each on the paper's colour, so that it is seen on all others.
  const curves = saddles.flatMap(({ arrays: { curve_x: x, curve_v: y } }) =>
    x ? [{ x, y, colour: "--paper", width: 3 }, { x, y, colour: "--ink", width: 1.3 }] : [],
  );
  const crosses = saddles.flatMap(({ arrays: { x, v: y } }) =>
    x ? [{ kind: "crosses", x, y, colour: "--paper", size: 13, width: 5 }, { kind: "crosses", x, y, colour: "--ink", size: 11, width: 2 }] : [],
  );
  const colours = coloursOf(header.attractors);
  const marks = header.attractors.flatMap((it, k) => {
    const place = { x: arrays[`x${k}`], y: arrays[`v${k}`], kind: "points" };
    const isOrbit = it.kind === "periodic" || it.kind === "rest";
    return isOrbit
      ? [{ ...place, colour: "--paper", size: 12 }, { ...place, colour: "--ink", size: 9 }, { ...place, colour: css(colours[k]), size: 5 }]
      : [{ ...place, colour: "--ink", size: 2 }];
  });
  return [{ kind: "image", image, box, x: box.x, y: box.y }, ...curves, ...crosses, ...marks];
}

/** Return the rows that name the attractors. */
export function legendOf(header, basin, theme) {
  const colours = coloursOf(header.attractors);
  const starts = basin.reduce((sum, label) => sum + (label === -2 ? 0 : 1), 0);
  const rows = header.attractors.map((it, k) => swatchOf(css(pale(colours[k], theme)), nameOf(it), shareText(it, starts)));
  if (basin.includes(-1)) rows.push(swatchOf(css(PAPERS[theme]), "not decided in the time given"));
  if (basin.includes(-2)) rows.push(swatchOf(css(NO_START), "no start: inside a wall"));
  return rows;
}

const packed = ([r, g, b]) => ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;

/** Say what part of the starts goes there; that all of n do leaves, at 95 %, up to 3 / n for others. */
export function shareText({ fraction, error }, n) {
  if (fraction < 1) {
    // As many decimals as two digits of the error have.
    const places = Math.min(20, Math.max(0, 1 - Math.floor(Math.log10(100 * error))));
    return `${(100 * fraction).toFixed(places)} ± ${(100 * error).toFixed(places)} %`;
  }
  const digits = Math.max(0, Math.ceil(Math.log10(n / 300)));
  return `> ${Math.floor((100 - 300 / n) * 10 ** digits) / 10 ** digits} %`;
}
