// Plots: uPlot draws axes and takes the zoom, the curves are drawn here.

import uPlot from "../vendor/uPlot.esm.js";
import { element, shown } from "./dom.js";

const css = (root, name) => getComputedStyle(root).getPropertyValue(name).trim();

/** One plot with its title and its read-out. */
export class Plot {
  /**
   * options: title, x, y (labels), kind ("line" | "points"), logY, equal, height,
   * onZoom(range or null), onHover(index or null), onClick(x, y).
   */
  constructor(options) {
    this.options = options;
    this.layers = [];
    this.lines = [];
    this.zoom = null;
    this.mark = null;
    this.readout = element("output", { class: "readout" });
    this.host = element("div", { class: "canvas", tabindex: "0", role: "img", "aria-label": options.title });
    this.root = element(
      "figure",
      { class: "plot" },
      element("figcaption", {}, element("strong", {}, options.title), this.readout),
      this.host,
    );
    // A logarithmic axis has no 0.
    this.limits = { x: [0, 1], y: options.logY ? [1e-6, 1] : [0, 1] };
    this.chart = null;
    new ResizeObserver(() => this.#fit()).observe(this.host);
    this.host.addEventListener("keydown", (event) => this.#key(event));
    this.host.addEventListener("wheel", (event) => this.#wheel(event), { passive: false });
  }

  /** Show layers {x, y, kind, colour, width}; the first one is read out. Lines {x or y, colour}. */
  show(layers, lines = [], limits = null) {
    this.layers = layers;
    this.lines = lines;
    this.home = limits ?? this.#extent();
    if (this.zoom === null) this.limits = this.home;
    this.redraw();
  }

  /** Mark a point, as the cursor of another plot does; null for none. */
  point(x, y) {
    this.mark = x === null ? null : [x, y];
    this.#overlay();
  }

  redraw() {
    if (this.chart === null) return;
    const { x, y } = this.limits;
    this.chart.batch(() => {
      this.chart.setScale("x", { min: x[0], max: x[1] });
      this.chart.setScale("y", { min: y[0], max: y[1] });
    });
    this.chart.redraw(false, true);
  }

  /** Take the colours of the theme anew. */
  recolour() {
    this.chart?.destroy();
    this.chart = null;
    this.#fit();
  }

  #fit() {
    const width = Math.floor(this.host.clientWidth);
    const height = Math.floor(this.host.clientHeight);
    if (width < 40 || height < 40) return;
    if (this.chart === null) this.#make(width, height);
    else this.chart.setSize({ width, height });
    this.redraw();
  }

  #make(width, height) {
    const colour = css(this.root, "--ink");
    const grid = { stroke: css(this.root, "--grid"), width: 1 };
    const font = '12px system-ui, "Segoe UI", Roboto, sans-serif';
    const axis = (label, size) => ({ stroke: colour, grid, ticks: grid, font, labelFont: font, label, size, labelSize: 16, labelGap: 0 });
    const log = this.options.logY;
    const options = {
      width, height,
      padding: [8, 12, 0, 0],
      legend: { show: false },
      scales: {
        x: { time: false, auto: false, min: this.limits.x[0], max: this.limits.x[1] },
        y: { auto: false, distr: log ? 3 : 1, min: this.limits.y[0], max: this.limits.y[1] },
      },
      axes: [
        { ...axis(this.options.x, 34), values: (_, ticks) => ticks.map((tick) => shown(tick)) },
        { ...axis(this.options.y, 56), ...(log ? { grid: { ...grid, filter: decadesOf }, ticks: { ...grid, filter: decadesOf } } : {}), values: (_, ticks) => ticks.map((tick) => (log ? power(tick) : shown(tick))) },
      ],
      series: [{}, { show: true, paths: () => null, points: { show: false } }],
      cursor: {
        points: { show: false },
        drag: { x: true, y: this.options.kind === "points" || this.options.equal === true, uni: 12, setScale: false },
      },
      hooks: {
        draw: [(chart) => this.#draw(chart)],
        setSelect: [(chart) => this.#selected(chart)],
        setCursor: [(chart) => this.#hover(chart)],
      },
    };
    this.chart = new uPlot(options, [[0, 1], [null, null]], this.host);
    this.chart.over.addEventListener("dblclick", () => this.reset());
    this.chart.over.addEventListener("click", (event) => this.#click(event));
    this.dot = element("i", { class: "dot", hidden: true });
    this.chart.over.append(this.dot);
  }

  /** Show all again. */
  reset() {
    if (this.zoom === null) return;
    this.zoom = null;
    this.limits = this.home;
    this.redraw();
    this.options.onZoom?.(null);
  }

  #setZoom(x, y) {
    this.zoom = { x, y };
    this.limits = { x, y };
    this.redraw();
    this.options.onZoom?.(this.zoom);
  }

  #selected(chart) {
    const { left, top, width, height } = chart.select;
    if (width < 5 && height < 5) return;
    const wide = width >= 5;
    const tall = height >= 5 && height < chart.over.clientHeight - 1;
    const x = wide ? [chart.posToVal(left, "x"), chart.posToVal(left + width, "x")] : this.limits.x;
    const y = tall ? [chart.posToVal(top + height, "y"), chart.posToVal(top, "y")] : this.limits.y;
    chart.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false);
    this.dragged = performance.now();
    this.#setZoom(x, y);
  }

  #scaled(range, about, factor) {
    return [about + (range[0] - about) * factor, about + (range[1] - about) * factor];
  }

  #wheel(event) {
    if (this.chart === null || !(event.ctrlKey || event.metaKey || event.shiftKey)) return;
    event.preventDefault();
    const box = this.chart.over.getBoundingClientRect();
    const x = this.chart.posToVal(event.clientX - box.left, "x");
    const turned = event.deltaY || event.deltaX;
    const width = this.limits.x[1] - this.limits.x[0];
    if (event.shiftKey) return this.#setZoom(this.limits.x.map((end) => end + Math.sign(turned) * 0.1 * width), this.limits.y);
    return this.#setZoom(this.#scaled(this.limits.x, x, turned > 0 ? 1.25 : 0.8), this.limits.y);
  }

  #key(event) {
    const [low, high] = this.limits.x;
    const width = high - low;
    const moves = { ArrowLeft: -0.1, ArrowRight: 0.1 };
    const zooms = { "+": 0.8, "=": 0.8, "-": 1.25 };
    if (event.key in moves) this.#setZoom([low + moves[event.key] * width, high + moves[event.key] * width], this.limits.y);
    else if (event.key in zooms) this.#setZoom(this.#scaled(this.limits.x, (low + high) / 2, zooms[event.key]), this.limits.y);
    else if (event.key === "0" || event.key === "Escape") this.reset();
    else return;
    event.preventDefault();
  }

  #extent() {
    const x = [Infinity, -Infinity];
    const y = [Infinity, -Infinity];
    for (const layer of this.layers) {
      if (layer.inset) continue;
      widen(x, layer.x);
      widen(y, layer.y);
    }
    for (const line of this.lines) {
      if (line.x !== undefined) widen(x, [line.x]);
      if (line.y !== undefined) widen(y, [line.y]);
    }
    return { x: padded(x, this.options.kind === "line" && !this.options.equal ? 0 : 0.04), y: this.options.logY ? decades(y) : padded(y, 0.06) };
  }

  #scales(chart) {
    const { left, top, width, height } = chart.bbox;
    const { x, y } = this.limits;
    const log = this.options.logY;
    const [low, high] = log ? y.map(Math.log10) : y;
    const sx = width / (x[1] - x[0]);
    const sy = height / (high - low);
    return {
      left, top, width, height,
      px: (value) => left + (value - x[0]) * sx,
      py: log
        ? (value) => top + height - (Math.log10(value > 0 ? value : 1e-300) - low) * sy
        : (value) => top + height - (value - low) * sy,
    };
  }

  #draw(chart) {
    const context = chart.ctx;
    const scales = this.#scales(chart);
    context.save();
    context.beginPath();
    context.rect(scales.left, scales.top, scales.width, scales.height);
    context.clip();
    for (const line of this.lines) this.#line(context, scales, line);
    for (const layer of this.layers) {
      if (layer.kind === "density") this.#density(context, scales, layer);
      else if (layer.kind === "points") this.#points(context, scales, layer);
      else if (layer.kind === "image") this.#image(context, scales, layer);
      else this.#curve(context, scales, layer);
    }
    context.restore();
    this.#overlay();
  }

  #line(context, scales, { x, y, colour }) {
    const { left, top, width, height, px, py } = scales;
    context.strokeStyle = css(this.root, colour ?? "--stop");
    context.lineWidth = devicePixelRatio * 1.5;
    context.setLineDash([6 * devicePixelRatio, 4 * devicePixelRatio]);
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

  #curve(context, { px, py }, { x, y, colour, width, dash }) {
    context.strokeStyle = css(this.root, colour);
    context.lineWidth = devicePixelRatio * (width ?? 1.25);
    context.lineJoin = "round";
    context.setLineDash((dash ?? []).map((part) => part * devicePixelRatio));
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

  #points(context, { px, py }, { x, y, colour, size }) {
    const side = (size ?? 2.5) * devicePixelRatio;
    context.fillStyle = css(this.root, colour);
    for (let i = 0; i < x.length; i += 1) context.fillRect(px(x[i]) - side / 2, py(y[i]) - side / 2, side, side);
  }

  /** Many points as shades: the more on a pixel the darker. */
  #density(context, scales, { x, y, rows, colour }) {
    const width = Math.max(1, Math.round(scales.width));
    const height = Math.max(1, Math.round(scales.height));
    const counts = new Uint16Array(width * height);
    const perRow = rows;
    const left = scales.left;
    const top = scales.top;
    for (let i = 0, k = 0; i < x.length; i += 1) {
      const column = Math.floor(scales.px(x[i]) - left);
      if (column < 0 || column >= width) {
        k += perRow;
        continue;
      }
      for (let j = 0; j < perRow; j += 1, k += 1) {
        const line = Math.floor(scales.py(y[k]) - top);
        if (line >= 0 && line < height) counts[line * width + column] += 1;
      }
    }
    const image = new ImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    const [r, g, b] = rgb(css(this.root, colour));
    for (let i = 0; i < counts.length; i += 1) {
      if (counts[i] === 0) continue;
      const alpha = Math.min(255, 110 + 40 * Math.log2(counts[i]));
      pixels[i] = (alpha << 24) | (b << 16) | (g << 8) | r;
    }
    context.drawImage(asCanvas(image), left, top);
  }

  #image(context, { px, py }, { image, box }) {
    context.imageSmoothingEnabled = false;
    const left = px(box.x[0]);
    const top = py(box.y[1]);
    context.drawImage(image, left, top, px(box.x[1]) - left, py(box.y[0]) - top);
  }

  #overlay() {
    if (this.dot === undefined || this.chart === null) return;
    this.dot.hidden = this.mark === null;
    if (this.mark === null) return;
    const [x, y] = this.mark;
    this.dot.style.transform = `translate(${this.chart.valToPos(x, "x")}px, ${this.chart.valToPos(y, "y")}px)`;
  }

  #hover(chart) {
    const { left, top } = chart.cursor;
    if (left < 0 || this.layers.length === 0) {
      this.readout.textContent = "";
      this.options.onHover?.(null);
      return;
    }
    const x = chart.posToVal(left, "x");
    const y = chart.posToVal(top, "y");
    if (this.options.read) {
      this.readout.textContent = this.options.read(x, y);
      return;
    }
    const index = this.#nearest(chart, x, left, top);
    if (index < 0) return;
    const layer = this.layers[0];
    const [nameX, nameY] = this.options.names ?? ["x", "y"];
    this.readout.textContent = `${nameX} = ${shown(layer.x[index], 5)}, ${nameY} = ${shown(layer.y[index], 5)}`;
    this.options.onHover?.(index);
  }

  #nearest(chart, x, left, top) {
    const layer = this.layers[0];
    if (layer.x.length === 0 || layer.kind === "density") return -1;
    if (this.options.kind === "line" && !this.options.equal) return bisect(layer.x, x);
    const scales = this.#scales(chart);
    const ratio = devicePixelRatio;
    let best = -1;
    let least = Infinity;
    for (let i = 0; i < layer.x.length; i += 1) {
      const dx = scales.px(layer.x[i]) - scales.left - left * ratio;
      const dy = scales.py(layer.y[i]) - scales.top - top * ratio;
      const apart = dx * dx + dy * dy;
      if (apart < least) {
        least = apart;
        best = i;
      }
    }
    return best;
  }

  #click(event) {
    if (this.options.onClick === undefined || performance.now() - (this.dragged ?? -1000) < 300) return;
    const box = this.chart.over.getBoundingClientRect();
    this.options.onClick(this.chart.posToVal(event.clientX - box.left, "x"), this.chart.posToVal(event.clientY - box.top, "y"));
  }
}

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

/** Return the label of a tick of a logarithmic axis: whole powers of ten have one. */
function power(tick) {
  if (tick === null || !(tick > 0)) return "";
  const exponent = Math.round(Math.log10(tick));
  if (Math.abs(tick / 10 ** exponent - 1) > 1e-6) return "";
  return `10${[...String(exponent)].map((digit) => RAISED[digit]).join("")}`;
}

const decadesOf = (_, splits) => splits.map((split) => (power(split) === "" ? null : split));

const RAISED = Object.fromEntries([..."-0123456789"].map((digit, i) => [digit, [..."⁻⁰¹²³⁴⁵⁶⁷⁸⁹"][i]]));

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
