// Plots: uPlot draws axes and handles the zoom, the curves are drawn here.

import uPlot from "../vendor/uPlot.esm.js";
import { element, shown } from "./dom.js";
import { drawLayer, drawLine } from "./draw.js";
import { attach } from "./gestures.js";
import { bisect, digitsOf, extentOf, grown, isAxis, logTexts, tickTexts, ticksOf } from "./scales.js";

const css = (root, name) => getComputedStyle(root).getPropertyValue(name).trim();
const FACE = 'system-ui, "Segoe UI", Roboto, sans-serif';
// Size of the text of the page on usual screens [pixels].
const TEXT = 14;

/** The options of plots of a motion: over time, and in its plane. */
export const MOTION = { title: "Displacement", x: "time t", y: "displacement x", kind: "line", names: ["t", "x"] };
export const PORTRAIT = { title: "Phase portrait", x: "displacement x", y: "velocity v", kind: "portrait", names: ["x", "v"] };

/** One plot with its title and its read-out. */
export class Plot {
  /**
   * options: title, about (a tooltip), x, y (labels), kind ("line" | "points" | "portrait"), logY,
   * onZoom(range or null), onHover(index or null), onClick(x, y), read(x, y) -> text;
   * isTime: the mark has a line at its time; isFollower: what it shows is zoomed by another plot.
   */
  constructor(options) {
    this.options = options;
    this.layers = [];
    this.lines = [];
    this.zoom = null;
    this.mark = null;
    this.isLog = options.logY === true;
    this.readout = element("output", { class: "readout", "aria-live": "off" });
    this.key = element("span", { class: "key" });
    this.empty = element("p", { class: "empty", hidden: true });
    this.host = element("div", {
      class: "canvas", tabindex: "0", role: "img", "aria-label": options.title, "aria-description": options.about,
    });
    this.root = element(
      "figure",
      { class: "plot" },
      element("figcaption", { title: options.about }, element("strong", {}, options.title), this.key, this.readout),
      element("div", { class: "frame" }, this.host, this.empty),
    );
    // A logarithmic axis has no 0.
    this.limits = { x: [0, 1], y: this.isLog ? [1e-6, 1] : [0, 1] };
    this.chart = null;
    this.colours = new Map();
    this.observer = new ResizeObserver(() => this.#guarded(() => this.#fit()));
    this.observer.observe(this.host);
    attach(this);
  }

  /** Show layers {x, y, kind, colour, width}; the first one is read out, those that are isBehind are drawn first. Lines {x or y, colour}. */
  show(layers, lines = [], limits = null, isHeld = false) {
    this.#guarded(() => this.#show(layers, lines, limits, isHeld));
  }

  #show(layers, lines, limits, isHeld) {
    this.layers = layers;
    this.lines = lines;
    this.empty.hidden = true;
    const tight = this.options.kind === "line";
    this.fitted = limits ?? extentOf(layers, lines, { logY: this.isLog, tight });
    // While a slider is held the axes stand still, as far as they can.
    if (isHeld && this.home) this.home = { x: grown(this.home.x, this.fitted.x, false), y: grown(this.home.y, this.fitted.y, this.isLog) };
    else this.home = this.fitted;
    if (this.zoom === null) this.limits = this.home;
    this.redraw();
  }

  /** Show axes only, with the reason. */
  wait(text, limits) {
    this.layers = [];
    this.lines = [];
    this.zoom = null;
    this.limits = this.home = this.fitted = limits;
    this.say(text);
    this.redraw();
  }

  /** Set the title. */
  rename(title) {
    this.key.title = this.key.textContent;
    this.root.querySelector("figcaption strong").textContent = title;
  }

  /** Show a message over the axes. */
  say(text) {
    this.empty.textContent = text;
    this.empty.hidden = false;
  }

  /** Fit the axes: the slider is released. */
  settle() {
    if (!this.fitted || this.home === this.fitted) return;
    this.home = this.fitted;
    if (this.zoom !== null) return;
    this.limits = this.home;
    this.redraw();
  }

  /** Zoom to a part, as a link holds it; null for all. */
  take(zoom) {
    this.zoom = zoom !== null && isAxis(zoom.x, false) && isAxis(zoom.y, this.isLog) ? zoom : null;
    if (this.zoom !== null) this.limits = this.zoom;
  }

  /** Mark a point, as the cursor of another plot does; null for none. */
  point(x, y) {
    this.mark = x === null ? null : [x, y];
    this.#overlay();
  }

  redraw() {
    this.#guarded(() => this.#redraw());
  }

  /** A plot that fails shows the reason, and leaves the others alone. */
  #guarded(work) {
    try {
      work();
    } catch (error) {
      console.error(error);
      this.say(`this plot cannot be drawn: ${error.message}`);
    }
  }

  #redraw() {
    if (this.chart === null) return;
    // An axis without two finite ends would make endless ticks.
    if (!isAxis(this.limits.x, false)) this.limits = { ...this.limits, x: [0, 1] };
    if (!isAxis(this.limits.y, this.isLog)) this.limits = { ...this.limits, y: this.isLog ? [1e-6, 1] : [0, 1] };
    const { x, y } = this.limits;
    // All of it drawn once.
    this.chart.batch(() => {
      this.chart.setScale("x", { min: x[0], max: x[1] });
      this.chart.setScale("y", { min: y[0], max: y[1] });
      this.chart.redraw(false, true);
    });
    // A description of the picture for screen readers, and for tests.
    const [across, upwards] = [x, y].map((ends) => ends.map((end) => shown(end)).join(" to "));
    const title = this.root.querySelector("strong").textContent;
    const seen = this.empty.hidden ? `${this.options.y} from ${upwards} over ${this.options.x} from ${across}` : this.empty.textContent;
    this.host.ariaLabel = `${title}: ${seen}; arrow keys move it, + and - zoom, 0 shows all${this.options.onClick ? ", Enter opens the middle" : ""}`;
    this.host.dataset.limits = JSON.stringify(this.limits);
    this.root.dataset.x = this.options.x;
    this.root.dataset.y = this.options.y;
  }

  /** Draw again with the colours of the theme and the labels. */
  recolour() {
    this.colours.clear();
    this.chart?.destroy();
    this.chart = null;
    this.#guarded(() => this.#fit());
  }

  /** Remove the plot and its listeners. */
  close() {
    this.observer.disconnect();
    this.chart?.destroy();
    this.chart = null;
  }

  /** Name the axes. */
  label(x, y) {
    if (this.options.x === x && this.options.y === y) return;
    Object.assign(this.options, { x, y });
    this.recolour();
  }

  over() {
    return this.chart?.over;
  }

  /** Return the values under a pointer. */
  at({ clientX, clientY }) {
    const box = this.chart.over.getBoundingClientRect();
    return [this.chart.posToVal(clientX - box.left, "x"), this.chart.posToVal(clientY - box.top, "y")];
  }

  /** Zoom out to all. */
  reset() {
    if (this.zoom !== null) {
      this.zoom = null;
      this.limits = this.home;
      this.redraw();
    } else if (!this.options.isFollower) return;
    this.options.onZoom?.(null);
  }

  setZoom(x, y) {
    if (!isAxis(x, false) || !isAxis(y, this.isLog)) return;
    this.zoom = { x, y };
    this.limits = { x, y };
    this.redraw();
    this.options.onZoom?.(this.zoom);
  }

  #fit() {
    const width = Math.floor(this.host.clientWidth);
    const height = Math.floor(this.host.clientHeight);
    if (width < 40 || height < 40) return;
    // Letters and lines grow with the page's text, as on a larger screen.
    const enlarged = Number.parseFloat(getComputedStyle(this.root).fontSize) / TEXT || 1;
    if (this.chart !== null && (enlarged !== this.enlarged || height !== this.chart.height)) {
      this.chart.destroy();
      this.chart = null;
    }
    this.enlarged = enlarged;
    if (this.chart === null) this.#make(width, height);
    else this.chart.setSize({ width, height });
    this.redraw();
  }

  #make(width, height) {
    const grid = { stroke: css(this.root, "--grid"), width: 1 };
    const font = `${Math.round(12 * this.enlarged)}px ${FACE}`;
    // A long label beside a low plot is smaller.
    const axis = (label, size, room) => ({
      stroke: css(this.root, "--ink"), grid, ticks: grid, font, labelFont: `${Math.min(12 * this.enlarged, (1.8 * room) / label.length)}px ${FACE}`, label, size: size * this.enlarged, labelSize: 16 * this.enlarged, labelGap: 0,
    });
    const log = this.isLog;
    // With Shift a drag moves the picture: see gestures.js.
    const unlessShift = (_chart, _target, handler) => (event) => (event.shiftKey ? null : handler(event));
    const options = {
      width, height,
      // Half of the last label may stand beyond the axis.
      padding: [8, () => this.enlarged * Math.max(12, 4 * (digitsOf(this.limits.x, 0.05) + 2)), 0, 0],
      legend: { show: false },
      scales: {
        x: { time: false, auto: false, min: this.limits.x[0], max: this.limits.x[1] },
        y: { auto: false, distr: log ? 3 : 1, min: this.limits.y[0], max: this.limits.y[1] },
      },
      axes: [
        {
          ...axis(this.options.x, 34, width - 80),
          // Long labels stand farther apart.
          space: (_chart, _axis, low, high) => this.enlarged * Math.max(50, 8 * (digitsOf([low, high], 0.05) + 2)),
          splits: (_chart, _axis, low, high, step) => ticksOf(low, high, false, step),
          values: (_, ticks) => tickTexts(ticks),
        },
        {
          ...axis(this.options.y, 60, height - 50 * this.enlarged),
          splits: (_chart, _axis, low, high, step) => ticksOf(low, high, log, step),
          filter: (_, ticks) => ticks,
          size: (_, texts) => this.enlarged * Math.max(60, 30 + 7 * Math.max(0, ...(texts ?? []).map((text) => text.length))),
          values: (_, ticks) => (log ? logTexts : tickTexts)(ticks),
        },
      ],
      series: [{}, { show: true, paths: () => null, points: { show: false } }],
      cursor: {
        points: { show: false },
        bind: { mousedown: unlessShift },
        drag: { x: true, y: this.options.kind !== "line", uni: 12, setScale: false },
      },
      hooks: {
        draw: [(chart) => this.#guarded(() => this.#draw(chart))],
        setSelect: [(chart) => this.#selected(chart)],
        setCursor: [(chart) => this.#hover(chart)],
      },
    };
    this.chart = new uPlot(options, [[0, 1], [null, null]], this.host);
    this.chart.over.addEventListener("dblclick", () => this.reset());
    this.chart.over.addEventListener("click", (event) => this.#click(event));
    this.dot = element("i", { class: "dot", hidden: true });
    this.cursor = element("i", { class: "time", hidden: true });
    this.chart.over.append(this.cursor, this.dot);
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
    this.setZoom(x, y);
  }

  #scales(chart) {
    const { left, top, width, height } = chart.bbox;
    const { x, y } = this.limits;
    const [low, high] = this.isLog ? y.map(Math.log10) : y;
    const sx = width / (x[1] - x[0]);
    const sy = height / (high - low);
    return {
      left, top, width, height,
      unit: devicePixelRatio * this.enlarged,
      px: (value) => left + (value - x[0]) * sx,
      py: this.isLog
        ? (value) => top + height - (Math.log10(value > 0 ? value : 1e-300) - low) * sy
        : (value) => top + height - (value - low) * sy,
    };
  }

  #draw(chart) {
    const context = chart.ctx;
    const scales = this.#scales(chart);
    const colourOf = (name) => this.#colour(name);
    context.save();
    context.beginPath();
    context.rect(scales.left, scales.top, scales.width, scales.height);
    context.clip();
    const pictures = this.layers.filter((layer) => layer.kind === "image");
    for (const layer of pictures) drawLayer(context, scales, layer, "");
    for (const line of this.lines) drawLine(context, scales, line, colourOf(line.colour ?? "--stop"));
    const others = this.layers.filter((layer) => layer.kind !== "image");
    for (const isBehind of [true, false]) {
      for (const layer of others) if ((layer.isBehind === true) === isBehind) drawLayer(context, scales, layer, colourOf(layer.colour));
    }
    context.restore();
    this.#overlay();
  }

  /** Return a colour of the theme; asking the browser for it anew each time is slow. */
  #colour(name) {
    if (!name.startsWith("--")) return name;
    if (!this.colours.has(name)) this.colours.set(name, css(this.root, name));
    return this.colours.get(name);
  }

  #overlay() {
    if (this.dot === undefined || this.chart === null) return;
    const [x, y] = this.mark ?? [Number.NaN, Number.NaN];
    const { limits } = this;
    const isWithin = x >= limits.x[0] && x <= limits.x[1];
    this.cursor.hidden = !(this.options.isTime && isWithin);
    this.dot.hidden = !(isWithin && y >= limits.y[0] && y <= limits.y[1]);
    if (!this.cursor.hidden) this.cursor.style.transform = `translateX(${this.chart.valToPos(x, "x")}px)`;
    if (!this.dot.hidden) this.dot.style.transform = `translate(${this.chart.valToPos(x, "x")}px, ${this.chart.valToPos(y, "y")}px)`;
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
    if (layer.x.length === 0) return -1;
    if (this.options.kind === "line") return bisect(layer.x, x);
    const scales = this.#scales(chart);
    let best = -1;
    let least = Infinity;
    for (let i = 0; i < layer.x.length; i += 1) {
      const dx = scales.px(layer.x[i]) - scales.left - left * devicePixelRatio;
      const dy = scales.py(layer.y[i]) - scales.top - top * devicePixelRatio;
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
    this.options.onClick(...this.at(event));
  }
}
