// Drawing the layers of a plot: lines, curves, points, densities and pictures.

/** Draw a line across, {x or y, colour}. */
export function drawLine(context, { left, top, width, height, unit, px, py }, { x, y }, colour) {
  context.strokeStyle = colour;
  context.lineWidth = unit * 1.5;
  context.setLineDash([6 * unit, 4 * unit]);
  context.beginPath();
  if (x !== undefined) {
    context.moveTo(px(x), top);
    context.lineTo(px(x), top + height);
  } else {
    context.moveTo(left, py(y));
    context.lineTo(left + width, py(y));
  }
  context.stroke();
  context.setLineDash([]);
}

// How much is seen of what came before a motion had settled.
const PALE = 0.3;

/** Draw a layer {kind, x, y, …} in a colour; what is before its entry `since` is pale. */
export function drawLayer(context, scales, layer, colour) {
  const draw = { density, points, crosses, image }[layer.kind] ?? curve;
  if (!(layer.since > 0)) {
    draw(context, scales, layer, colour);
    return;
  }
  context.globalAlpha = PALE;
  draw(context, scales, part(layer, 0, layer.since + 1), colour);
  context.globalAlpha = 1;
  draw(context, scales, part(layer, layer.since), colour);
}

const part = (layer, ...ends) => ({ ...layer, x: layer.x.subarray(...ends), y: layer.y.subarray(...ends) });

function curve(context, { unit, px, py }, { x, y, width, dash }, colour) {
  context.strokeStyle = colour;
  context.lineWidth = unit * (width ?? 1.25);
  context.lineJoin = "round";
  context.setLineDash((dash ?? []).map((part) => part * unit));
  context.beginPath();
  let pen = false;
  for (let i = 0; i < x.length; i += 1) {
    const value = y[i];
    if (value !== value) {
      pen = false;
      continue;
    }
    if (pen) context.lineTo(px(x[i]), py(value));
    else context.moveTo(px(x[i]), py(value));
    pen = true;
  }
  context.stroke();
  context.setLineDash([]);
}

function points(context, { unit, px, py }, { x, y, size }, colour) {
  const side = (size ?? 2.5) * unit;
  context.fillStyle = colour;
  for (let i = 0; i < x.length; i += 1) context.fillRect(px(x[i]) - side / 2, py(y[i]) - side / 2, side, side);
}

/** Diagonal crosses. */
function crosses(context, { unit, px, py }, { x, y, size, width }, colour) {
  const arm = (size / 2) * unit;
  context.strokeStyle = colour;
  context.lineWidth = width * unit;
  context.beginPath();
  for (let i = 0; i < x.length; i += 1) {
    const [left, top] = [px(x[i]), py(y[i])];
    context.moveTo(left - arm, top - arm);
    context.lineTo(left + arm, top + arm);
    context.moveTo(left + arm, top - arm);
    context.lineTo(left - arm, top + arm);
  }
  context.stroke();
}

/** What densities are drawn with, kept from one to the next: to make it anew takes longer than to draw. */
let ground = null;

function groundOf(width, height) {
  if (ground?.canvas.width !== width || ground.canvas.height !== height) {
    const image = new ImageData(width, height);
    ground = { image, pixels: new Uint32Array(image.data.buffer), counts: new Uint16Array(width * height), canvas: asCanvas(image) };
  }
  return ground;
}

/** Many points as shades, darker where a pixel has more of them; few points are drawn larger. */
function density(context, scales, { x, y, rows, isSparse }, colour) {
  const { left, top } = scales;
  const width = Math.max(1, Math.round(scales.width));
  const height = Math.max(1, Math.round(scales.height));
  const { image, pixels, counts, canvas } = groundOf(width, height);
  // The pixels with points: the others need not be looked at.
  const places = new Uint32Array(y.length);
  let found = 0;
  for (let i = 0, k = 0; i < x.length; i += 1) {
    const column = Math.floor(scales.px(x[i]) - left);
    if (column < 0 || column >= width) {
      k += rows;
      continue;
    }
    for (let j = 0; j < rows; j += 1, k += 1) {
      const line = Math.floor(scales.py(y[k]) - top);
      if (!(line >= 0 && line < height)) continue;
      const place = line * width + column;
      if (counts[place] === 0) places[found++] = place;
      counts[place] += 1;
    }
  }
  const [r, g, b] = rgb(colour);
  const side = Math.max(1, Math.round(scales.unit)) + (isSparse ? 1 : 0);
  const drawn = places.subarray(0, found);
  pixels.fill(0);
  for (const place of drawn) {
    const [line, column] = [Math.floor(place / width), place % width];
    const alpha = Math.min(255, 140 + 36 * Math.log2(counts[place]));
    const value = (alpha << 24) | (b << 16) | (g << 8) | r;
    for (let down = 0; down < side && line + down < height; down += 1) {
      for (let right = 0; right < side && column + right < width; right += 1) {
        const at = place + down * width + right;
        if (pixels[at] >>> 24 < alpha) pixels[at] = value;
      }
    }
  }
  for (const place of drawn) counts[place] = 0;
  canvas.getContext("2d").putImageData(image, 0, 0);
  context.drawImage(canvas, left, top);
}

function image(context, { px, py }, { image: picture, box }) {
  context.imageSmoothingEnabled = false;
  const left = px(box.x[0]);
  const top = py(box.y[1]);
  context.drawImage(picture, left, top, px(box.x[1]) - left, py(box.y[0]) - top);
}

function rgb(colour) {
  const value = Number.parseInt(colour.replace("#", ""), 16);
  return [(value >> 16) & 255, (value >> 8) & 255, value & 255];
}

/** Return a canvas that holds an image. */
export function asCanvas(image) {
  const canvas = document.createElement("canvas");
  canvas.width = image.width;
  canvas.height = image.height;
  canvas.getContext("2d").putImageData(image, 0, 0);
  return canvas;
}
