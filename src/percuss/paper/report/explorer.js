"use strict";
// The impact oscillator x'' + x = sin t, x > 0, in closed form from impact to impact.
(() => {
  const IMPACTS = 400, FLIGHTS = 12, FRAME = { left: 44, right: 348, top: 14, bottom: 264 };
  const by = (id) => document.getElementById(id);
  if (!by("explorer")) return;

  /** Position and velocity, a time after an impact at t with velocity v. */
  function flight(t, v, after) {
    const s = Math.sin(t), c = Math.cos(t), S = Math.sin(after), C = Math.cos(after);
    return {
      x: (v + after * s / 2) * S + c / 2 * (S - after * C),
      v: v * C + s / 2 * (S + after * C) + c / 2 * after * S,
    };
  }

  /** The next impact: the first zero of the position is bracketed by steps and found by bisection. */
  function next(t, v) {
    const force = Math.sin(t);
    // Against the force a slow mass is back after 2 v / |force|.
    const step = force < 0 ? Math.min(0.04, -v / (2 * force)) : 0.04;
    let low = step, high = 2 * step;
    while (flight(t, v, high).x > 0 && high < 40) { low = high; high += step; }
    for (let i = 0; i < 60; i++) {
      const middle = (low + high) / 2;
      if (flight(t, v, middle).x > 0) low = middle; else high = middle;
    }
    return { t: t + high, v: -flight(t, v, high).v, length: high };
  }

  /** The invariant Q of the impacts; for late impacts it is cos 2 psi. */
  function invariant(t, v) {
    const s = Math.sin(t), c = Math.abs(Math.cos(t));
    const angle = Math.atan2(Math.PI / 2 * v * c, v * v * c * c + v * s * (v * s + Math.PI / 2));
    return c < 1e-9 ? -1 : Math.max(-1, Math.min(1, 4 * v * c / Math.PI * angle - 1));
  }

  function run(t0, v0) {
    const impacts = [{ t: t0, v: v0 }];
    for (let k = 0; k < IMPACTS; k++) {
      const { t, v, length } = next(impacts[k].t, impacts[k].v);
      impacts[k].length = length;
      impacts.push({ t, v });
    }
    const last = impacts[IMPACTS], psi = Math.acos(invariant(last.t, last.v)) / 2;
    return { impacts, psi, b: Math.sqrt(Math.sin(2 * psi) / 2), last };
  }

  const mark = (name, attributes, text = "") =>
    `<${name} ${Object.entries(attributes).map(([key, value]) => `${key}="${value}"`).join(" ")}>${text}</${name}>`;

  /** A frame with round numbers at its axes, and the map from numbers into it. */
  function frame(xs, ys, across, upwards) {
    const [x0, x1] = xs, [y0, y1] = ys;
    const X = (x) => FRAME.left + (x - x0) / (x1 - x0) * (FRAME.right - FRAME.left);
    const Y = (y) => FRAME.bottom - (y - y0) / (y1 - y0) * (FRAME.bottom - FRAME.top);
    const ticks = (a, b) => {
      const raw = (b - a) / 5, power = 10 ** Math.floor(Math.log10(raw));
      const by = [1, 2, 5, 10].find((m) => m * power >= raw) * power, found = [];
      for (let k = Math.ceil(a / by); k * by <= b; k++) found.push(Number((k * by).toPrecision(6)));
      return found;
    };
    const axes = [
      mark("rect", { x: FRAME.left, y: FRAME.top, width: FRAME.right - FRAME.left, height: FRAME.bottom - FRAME.top, class: "frame" }),
      ...ticks(x0, x1).map((x) => mark("text", { x: X(x), y: FRAME.bottom + 14, "text-anchor": "middle" }, x)),
      ...ticks(y0, y1).map((y) => mark("text", { x: FRAME.left - 5, y: Y(y) + 4, "text-anchor": "end" }, String(y).replace("-", "\u2212"))),
      mark("text", { x: (FRAME.left + FRAME.right) / 2, y: 294, "text-anchor": "middle" }, across),
      mark("text", { x: 12, y: 139, "text-anchor": "middle", transform: "rotate(-90 12 139)" }, upwards),
    ].join("");
    return { axes, at: (x, y) => `${X(x).toFixed(1)},${Y(y).toFixed(1)}`, X, Y };
  }

  function portrait(impacts) {
    const loops = impacts.slice(0, FLIGHTS).map(({ t, v, length }) =>
      Array.from({ length: 61 }, (_, i) => flight(t, v, length * i / 60)));
    const all = loops.flat(), most = Math.max(...all.map((p) => Math.abs(p.v))) * 1.05;
    const { axes, at } = frame([0, Math.max(...all.map((p) => p.x)) * 1.05], [-most, most], "x", "velocity");
    by("portrait").innerHTML = axes + loops.map((loop, k) =>
      mark("polyline", { points: loop.map((p) => at(p.x, p.v)).join(" "), opacity: 0.35 + 0.65 * k / FLIGHTS })).join("");
  }

  function growth(impacts, b) {
    const rows = impacts.filter(({ t }) => t > 0), end = Math.sqrt(rows.at(-1).t);
    const most = Math.max(b * end, ...rows.map(({ v }) => v)) * 1.05;
    const { axes, at, X, Y } = frame([0, end], [0, most], "√t", "velocity after an impact");
    by("growth").innerHTML = axes
      + rows.map(({ t, v }) => mark("circle", { cx: X(Math.sqrt(t)).toFixed(1), cy: Y(v).toFixed(1), r: 1.6 })).join("")
      + mark("polyline", { points: `${at(0, 0)} ${at(end, b * end)}`, class: "law" });
  }

  function show() {
    const v0 = Number(by("velocity").value), t0 = Number(by("phase").value);
    const { impacts, psi, b, last } = run(t0, v0);
    by("velocity-out").textContent = v0.toFixed(2);
    by("phase-out").textContent = t0.toFixed(2);
    by("psi").textContent = psi.toFixed(4);
    by("factor").textContent = b.toFixed(4);
    by("ratio").textContent = (last.v / Math.sqrt(last.t)).toFixed(4);
    by("late").textContent = (last.t - Math.PI * Math.floor(last.t / Math.PI)).toFixed(4);
    portrait(impacts);
    growth(impacts, b);
  }

  for (const name of ["velocity", "phase"]) by(name).addEventListener("input", show);
  show();
})();
