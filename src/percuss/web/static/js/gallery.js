// Named motions to begin with.

import { button, element } from "./dom.js";
import { COMPACT, MechanismPicture } from "./mechanism_picture.js";

const THUMB = { width: 220, height: 130 };

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
    const head = element("p", { class: "hint" }, "Motions to begin with, each seen as its phase portrait. A click opens one in Explore, in place of what is set there.");
    const rows = mechanisms.map((it) => mechanismCard(it, () => app.beginMechanism(it.name)));
    const several = element("p", { class: "hint" }, "Structures of two and three masses, each with its mechanical picture.");
    const file = element("input", { type: "file", accept: ".toml", hidden: true, "aria-label": "study file", onchange: () => file.files[0] && app.openStudy(file.files[0]) });
    const open = button("Open a study file", () => {
      file.value = "";
      file.click();
    }, { title: "a .toml of percuss run; or drop it on the page" });
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
    for (const { canvas, arrays } of this.cards) if (arrays) portrait(canvas, arrays, this.root);
  }

  #next(k) {
    const card = this.cards[k];
    if (!card) return;
    this.app.requests.put(
      "thumb",
      { kind: "thumb", study: card.preset.study, points: 1500 },
      {
        answer: (_, arrays) => {
          card.arrays = arrays;
          portrait(card.canvas, arrays, this.root);
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

function portrait(canvas, { portrait_x: x, portrait_v: v }, root) {
  const context = canvas.getContext("2d");
  const { width, height } = canvas;
  context.clearRect(0, 0, width, height);
  const [left, right] = ends(x);
  const [low, high] = ends(v);
  const place = (value, a, b, size) => 12 + ((value - a) / (b - a || 1)) * (size - 24);
  context.strokeStyle = getComputedStyle(root).getPropertyValue("--curve");
  context.lineWidth = 1.5;
  context.lineJoin = "round";
  context.beginPath();
  for (let i = 0; i < x.length; i += 1) context.lineTo(place(x[i], left, right, width), height - place(v[i], low, high, height));
  context.stroke();
}

function ends(values) {
  let low = Infinity;
  let high = -Infinity;
  for (const value of values) {
    if (value < low) low = value;
    if (value > high) high = value;
  }
  return [low, high];
}
