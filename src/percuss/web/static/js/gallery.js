// Named motions to begin with.

import { button, element, fileField } from "./dom.js";
import { COMPACT, MechanismPicture } from "./mechanism_picture.js";
import { endsOf } from "./scales.js";

const THUMB = { width: 220, height: 130 };
// Of a portrait: margin and hatches in pixels of the canvas; how much is seen of the first half of a motion,
// and of what lies behind a soft stop.
const [EDGE, HATCH, PALE, SHADE] = [24, 14, 0.3, 0.2];

export class Gallery {
  constructor(app, { presets, mechanisms }) {
    this.app = app;
    this.cards = presets.map((preset) => {
      const canvas = element("canvas", { width: 2 * THUMB.width, height: 2 * THUMB.height, "aria-hidden": "true" });
      const card = element(
        "button",
        { type: "button", class: "preset", onclick: () => app.begin(preset.study), "data-name": preset.name },
        canvas, element("strong", {}, preset.title), element("span", {}, preset.caption),
      );
      return { preset, canvas, card };
    });
    const head = element("p", { class: "hint" }, "Motions to begin with, each seen as its phase portrait, velocity v over displacement x, between its stops: walls are hatched, soft stops shaded, and the first half of a motion is pale. A click opens one in Explore.");
    const rows = mechanisms.map((it) => mechanismCard(it, () => app.beginMechanism(it.name)));
    const several = element("p", { class: "hint" }, "Structures of two and three masses, each with its mechanical picture.");
    const file = fileField("study file", (it) => app.openStudy(it), ".toml");
    const open = button("Open a study file", () => file.click(), { title: "a .toml of percuss run; or drop it on the page" });
    const own = element("div", { class: "tools", hidden: app.options.isStatic === true }, open, file);
    this.root = element("section", { class: "gallery", "aria-label": "Gallery" }, head, own, ...this.cards.map(({ card }) => card), several, ...rows);
    this.isDrawn = false;
  }

  /** Draw the portraits, one after another, when they are first seen. */
  shown() {
    if (this.isDrawn) return;
    this.isDrawn = true;
    this.#next(0);
  }

  recolour() {
    for (const { canvas, drawn } of this.cards) if (drawn) portrait(canvas, drawn, this.root);
  }

  #next(k) {
    const card = this.cards[k];
    if (!card) return;
    this.app.requests.put(
      "thumb",
      { kind: "thumb", study: card.preset.study, points: 1500 },
      {
        answer: ({ elements }, arrays) => {
          card.drawn = { arrays, stops: elements.stops };
          portrait(card.canvas, card.drawn, this.root);
          this.#next(k + 1);
        },
        fault: () => this.#next(k + 1),
      },
    );
  }
}

function mechanismCard({ name, title, caption, elements }, open) {
  const picture = new MechanismPicture();
  picture.take(elements, 0, COMPACT);
  picture.draw(Array(elements.n).fill(0));
  picture.svg.setAttribute("aria-hidden", "true");
  return element("button", { type: "button", class: "preset", onclick: open, "data-mechanism": name }, picture.svg, element("strong", {}, title), element("span", {}, caption));
}

/** Draw x and v of a motion between its stops: walls hatched, soft stops shaded, the first half pale. */
function portrait(canvas, { arrays: { portrait_x: x, portrait_v: v, portrait_t: t }, stops }, root) {
  const context = canvas.getContext("2d");
  const { width, height } = canvas;
  const colour = (name) => getComputedStyle(root).getPropertyValue(name);
  const [left, right] = aroundStops(endsOf(x), stops);
  const [low, high] = endsOf(v);
  const px = (value) => EDGE + ((value - left) / (right - left || 1)) * (width - 2 * EDGE);
  const py = (value) => height - EDGE - ((value - low) / (high - low || 1)) * (height - 2 * EDGE);
  context.clearRect(0, 0, width, height);
  for (const stop of stops) drawStop(context, stop, px(stop.at), canvas, colour(stop.type === "wall" ? "--wall" : "--stop"));
  context.strokeStyle = colour("--line");
  context.lineWidth = 2;
  stroke(context, [[0, py(0)], [width, py(0)]]);
  context.strokeStyle = colour("--curve");
  context.lineJoin = "round";
  context.lineWidth = 2.5;
  const middle = t.findIndex((time) => time >= 0.5 * (t[0] + t.at(-1)));
  const points = Array.from(x, (value, k) => [px(value), py(v[k])]);
  context.globalAlpha = PALE;
  stroke(context, points.slice(0, middle + 1));
  context.globalAlpha = 1;
  stroke(context, points.slice(middle));
}

/** Draw a stop and what lies behind it. */
function drawStop(context, { type, side }, at, { width, height }, colour) {
  const out = side === "above" ? 1 : -1;
  context.strokeStyle = colour;
  context.fillStyle = colour;
  context.lineWidth = 4;
  stroke(context, [[at, 0], [at, height]]);
  if (type === "wall") {
    context.lineWidth = 2;
    for (let y = 0; y < height + HATCH; y += HATCH) stroke(context, [[at, y], [at + out * HATCH, y - HATCH]]);
    return;
  }
  context.globalAlpha = SHADE;
  context.fillRect(at, 0, out > 0 ? width - at : -at, height);
  context.globalAlpha = 1;
}

function stroke(context, points) {
  context.beginPath();
  for (const [x, y] of points) context.lineTo(x, y);
  context.stroke();
}

/** Return a range that holds the stops near it, too. */
function aroundStops([low, high], stops) {
  const near = stops.map(({ at }) => at).filter((at) => at > low - 0.5 * (high - low) && at < high + 0.5 * (high - low));
  return [Math.min(low, ...near), Math.max(high, ...near)];
}
