"""A shallow graze and a chatter: SciPy's events, heyoka and percuss side by side.

python examples/graze_and_chatter.py [--out graze_and_chatter.png | .svg] [--recompute]

The results of SciPy and heyoka are kept, with their versions, in graze_and_chatter.json;
--recompute makes them anew where both are installed (the `benchmark` extra).
"""

from __future__ import annotations

import argparse
import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import NDArray

import percuss as pc
from percuss.plotting.style import (
    BLUE,
    GREY,
    ORANGE,
    VERMILION,
    fix_ticks,
    offscreen_figure,
    style,
)

Floats = NDArray[np.float64]

STORED = Path(__file__).with_suffix(".json")

# Left: x = (1 + DEPTH) sin t, the steady motion of x'' + 0.1 x' + x = A cos t, meets a wall at 1.
DEPTH = 1e-4
AMPLITUDE = 0.1 * (1 + DEPTH)
GRAZE = {
    "osc": pc.impact_oscillator(restitution=0.8, wall=1.0, side="above", damping=0.05),
    "force": pc.cosine(1, amplitude=AMPLITUDE),
    "v0": 1 + DEPTH,
}
GRAZE_TIME = math.asin(1 / (1 + DEPTH))
GRAZE_WINDOW = np.linspace(-0.04, 0.04, 161) + math.pi / 2
GRAZE_UNIT = 1e-4

# Right: x'' + x = cos 2.8 t below a wall at 0, from a small hop.
CHATTER = {
    "osc": pc.impact_oscillator(restitution="0.8", side="above"),
    "force": pc.cosine("2.8"),
    "v0": "-0.032",
    "t0": "-0.2",
}
CHATTER_WINDOW = np.linspace(-0.2, 0.68, 881)
CHATTER_UNIT = 1e-4
# Closed form in 40 digits (tests/oracle): the impacts accumulate, the body rests, and leaves.
ACCUMULATION, RELEASE, X_AT_3 = 0.147667957791079, math.pi / 5.6, -0.188605894231


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("graze_and_chatter.png"))
    parser.add_argument("--recompute", action="store_true", help="run SciPy and heyoka again")
    arguments = parser.parse_args()
    if arguments.recompute:
        from graze_and_chatter_peers import results

        stored = results(AMPLITUDE, DEPTH, GRAZE_WINDOW, CHATTER_WINDOW)
        STORED.write_text(json.dumps(stored, separators=(",", ":")) + "\n", encoding="utf-8")
    peers = json.loads(STORED.read_text(encoding="utf-8"))
    graze = pc.simulate(**GRAZE, t_end=3.0)
    chatter = pc.simulate(**CHATTER, t_end=3.0)
    print(table(peers, graze, chatter))
    with style():
        draw(peers, graze, chatter, arguments.out)
    print(f"{arguments.out} drawn")


def table(peers: dict[str, Any], graze: pc.Trajectory, chatter: pc.Trajectory) -> str:
    """Return what each tool says, beside the closed form."""
    scipy, heyoka = peers["scipy"], peers["heyoka"]
    lines = [
        ("", f"SciPy {scipy['version']}", f"heyoka {heyoka['version']}", "percuss", "exact"),
        (
            "graze: first impact at",
            *(_instant(peer["graze"]["first_impact"]) for peer in (scipy, heyoka)),
            _instant(float(graze.impacts.t[0])),
            _instant(GRAZE_TIME),
        ),
        (
            "chatter: impacts end at",
            *(_instant(peer["chatter"]["last_impact"]) for peer in (scipy, heyoka)),
            _instant(float(chatter.contacts.start[0])),
            _instant(ACCUMULATION),
        ),
        (
            "body leaves the wall at",
            "never: stalled",
            "fell through it",
            _instant(float(chatter.contacts.release[0])),
            _instant(RELEASE),
        ),
        (
            "x at t = 3",
            "not reached",
            f"{heyoka['chatter']['x_at_3']:.10f}",
            f"{chatter(3.0)[0]:.10f}",
            f"{X_AT_3:.10f}",
        ),
    ]
    return "\n".join("  ".join(f"{cell:>24}" for cell in line) for line in lines)


def _instant(t: float | None) -> str:
    return "none" if t is None else f"{t:.10f}"


def draw(peers: dict[str, Any], graze: pc.Trajectory, chatter: pc.Trajectory, path: Path) -> None:
    """Draw both cases side by side."""
    figure = offscreen_figure(9.6, 4.3)
    left, right = figure.subplots(1, 2)
    draw_graze(left, peers, graze)
    draw_chatter(right, peers, chatter)
    for ax in (left, right):
        ax.axhline(0.0, color=GREY, linewidth=1.0, zorder=1)
        fix_ticks(ax)
    handles, labels = left.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=3, fontsize=10.5)
    figure.savefig(path, dpi=200)


def draw_graze(ax: Axes, peers: dict[str, Any], graze: pc.Trajectory) -> None:
    """Draw the neighbourhood of the wall that the motion enters by DEPTH."""
    t = GRAZE_WINDOW
    s = (t - math.pi / 2) * 100
    _scipy(ax, s, np.array(peers["scipy"]["graze"]["x"]) / GRAZE_UNIT, peers)
    _heyoka(ax, s, np.array(peers["heyoka"]["graze"]["x"]) / GRAZE_UNIT, peers)
    _percuss(ax, s, (graze(t)[0] - 1.0) / GRAZE_UNIT)
    _wall(ax, s, -4.0, 1.6)
    _label(ax, "SciPy: no event", (0.0, 1.0), (1.0, 1.3), VERMILION)
    _label(ax, "heyoka and\npercuss: impact", (0.22, -3.0), (0.62, -3.4), BLUE)
    ax.set_title("A shallow graze: the wall is entered by 0.0001", loc="left")
    ax.set_xlabel(r"$100\,(t - \pi/2)$, dimensionless")
    ax.set_ylabel(r"$10^4\,(x - x_\mathrm{wall})$, dimensionless")


def draw_chatter(ax: Axes, peers: dict[str, Any], chatter: pc.Trajectory) -> None:
    """Draw the hops up to their accumulation, the rest on the wall, and the release."""
    t = CHATTER_WINDOW
    scipy = peers["scipy"]["chatter"]
    known = len(scipy["x"])
    _scipy(ax, t[:known], np.array(scipy["x"]) / CHATTER_UNIT, peers)
    ax.plot(scipy["last_impact"], 0.0, "X", color=VERMILION, markersize=9, zorder=5)
    _heyoka(ax, t, np.array(peers["heyoka"]["chatter"]["x"]) / CHATTER_UNIT, peers)
    _percuss(ax, t, chatter(t)[0] / CHATTER_UNIT)
    _wall(ax, t, -7.0, 5.0)
    _label(ax, "heyoka: through the wall", (0.178, 4.0), (0.23, 4.0), ORANGE)
    stall = f"SciPy: stalls there,\n{scipy['impacts']} events and no progress"
    _label(ax, stall, (scipy["last_impact"], -0.25), (0.17, -4.6), VERMILION)
    _label(ax, "percuss: at rest until\nthe force turns", (0.4, 0.0), (0.3, -1.7), BLUE)
    ax.set_title("A chatter: infinitely many impacts before 0.148", loc="left")
    ax.set_xlabel(r"$t$, dimensionless")
    ax.set_ylabel(r"$10^4\,x$, dimensionless")


def _scipy(ax: Axes, t: Floats, x: Floats, peers: dict[str, Any]) -> None:
    label = f"SciPy {peers['scipy']['version']} (DOP853, rtol 1e-12, events)"
    ax.plot(t, x, color=VERMILION, linewidth=1.8, label=label, zorder=3)


def _heyoka(ax: Axes, t: Floats, x: Floats, peers: dict[str, Any]) -> None:
    label = f"heyoka {peers['heyoka']['version']}"
    ax.plot(t, x, color=ORANGE, linewidth=4.0, label=label, zorder=2)


def _percuss(ax: Axes, t: Floats, x: Floats) -> None:
    ax.plot(t, x, color=BLUE, linewidth=1.6, label="percuss", zorder=4)


def _label(
    ax: Axes, text: str, point: tuple[float, float], place: tuple[float, float], color: str
) -> None:
    """Write a text that begins at a place, with a line to the point it speaks of."""
    line = {"arrowstyle": "-", "color": color, "shrinkA": 2, "shrinkB": 0, "relpos": (0.0, 0.5)}
    ax.annotate(text, point, place, va="center", arrowprops=line, zorder=6)


def _wall(ax: Axes, t: Floats, lowest: float, highest: float) -> None:
    """Shade what lies behind the wall."""
    ax.axhspan(0.0, highest, color="#E8E8E8", zorder=0, linewidth=0)
    place = (0.015, 0.97)
    ax.text(*place, "behind the wall", transform=ax.transAxes, va="top", style="italic")
    ax.set_xlim(t[0], t[-1])
    ax.set_ylim(lowest, highest)


if __name__ == "__main__":
    main()
