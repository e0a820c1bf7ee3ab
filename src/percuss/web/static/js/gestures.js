// Zooming and panning a plot: wheel, keys, dragging with Shift, two fingers.

import { whileHeld } from "./dom.js";
import { moved } from "./scales.js";

const STILL = { part: 0, factor: 1, about: null };
const KEYS = {
  ArrowLeft: { x: { ...STILL, part: -0.1 }, y: STILL },
  ArrowRight: { x: { ...STILL, part: 0.1 }, y: STILL },
  ArrowDown: { x: STILL, y: { ...STILL, part: -0.1 } },
  ArrowUp: { x: STILL, y: { ...STILL, part: 0.1 } },
  "+": { x: { ...STILL, factor: 0.8 }, y: STILL },
  "-": { x: { ...STILL, factor: 1.25 }, y: STILL },
};
KEYS["="] = KEYS["+"];

/**
 * Move the limits of a plot by pointers and keys.
 *
 * plot: options, host (element), over() (element of the plotting area), limits, isLog, at(x, y) from pixels,
 * setZoom(x, y), reset().
 */
export function attach(plot) {
  const move = ({ x, y }, from = plot.limits) =>
    plot.setZoom(moved(from.x, x.part, x.factor, x.about, false), moved(from.y, y.part, y.factor, y.about, plot.isLog));

  plot.host.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key in KEYS) move(KEYS[event.key]);
    else if (event.key === "0" || event.key === "Escape") plot.reset();
    // As a click in the middle.
    else if (event.key === "Enter") plot.options.onClick?.(...[plot.limits.x, plot.limits.y].map(([low, high]) => (low + high) / 2));
    else return;
    event.preventDefault();
    event.stopPropagation();
  });

  // A bare wheel scrolls the page.
  plot.host.addEventListener(
    "wheel",
    (event) => {
      if (!plot.over() || !(event.ctrlKey || event.metaKey || event.shiftKey)) return;
      event.preventDefault();
      const turned = event.deltaY || event.deltaX;
      const x = event.shiftKey
        ? { ...STILL, part: Math.sign(turned) * 0.1 }
        : { ...STILL, factor: turned > 0 ? 1.25 : 0.8, about: plot.at(event)[0] };
      move({ x, y: STILL });
    },
    { passive: false },
  );
  dragging(plot, move);
  twoFingers(plot, move);
}

/** Shift and drag: the picture follows the pointer. */
function dragging(plot, move) {
  plot.host.addEventListener("pointerdown", (event) => {
    if (!event.shiftKey || event.button !== 0 || event.pointerType === "touch") return;
    event.preventDefault();
    const from = plot.limits;
    const box = plot.over().getBoundingClientRect();
    const follow = (now) =>
      move(
        {
          x: { ...STILL, part: (event.clientX - now.clientX) / box.width },
          y: { ...STILL, part: (now.clientY - event.clientY) / box.height },
        },
        from,
      );
    whileHeld(follow, () => (plot.dragged = performance.now()));
  });
}

/** One finger scrolls the page; two zoom the plot and move it. */
function twoFingers(plot, move) {
  let start = null;
  const spread = ([one, two]) => ({
    x: (one.clientX + two.clientX) / 2,
    y: (one.clientY + two.clientY) / 2,
    apart: Math.max(20, Math.hypot(one.clientX - two.clientX, one.clientY - two.clientY)),
  });
  plot.host.addEventListener(
    "touchstart",
    (event) => {
      if (event.touches.length !== 2 || !plot.over()) return;
      event.preventDefault();
      const fingers = spread([...event.touches]);
      start = { ...fingers, from: plot.limits, about: plot.at({ clientX: fingers.x, clientY: fingers.y }) };
    },
    { passive: false },
  );
  plot.host.addEventListener(
    "touchmove",
    (event) => {
      if (start === null || event.touches.length !== 2) return;
      event.preventDefault();
      const now = spread([...event.touches]);
      const box = plot.over().getBoundingClientRect();
      const factor = Math.min(20, Math.max(0.05, start.apart / now.apart));
      const x = { factor, about: start.about[0], part: ((start.x - now.x) / box.width) * factor };
      const y = { factor, about: start.about[1], part: ((now.y - start.y) / box.height) * factor };
      move({ x, y }, start.from);
    },
    { passive: false },
  );
  plot.host.addEventListener("touchend", (event) => {
    if (start !== null && event.touches.length < 2) plot.dragged = performance.now();
    if (event.touches.length < 2) start = null;
  });
}
