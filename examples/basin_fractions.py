"""Basin fractions over a parameter: python examples/basin_fractions.py [--out FILE].

x'' + 0.1 x' + x = cos 1.5 t below a wall, r = 0.7: which part of the starts goes to which motion
as the gap grows. The motion without impacts appears at a gap of 0.794, where it no longer touches
the wall, and the one with impacts ends at 2.121, in a fold. Some seconds on two cores.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import percuss as pc
from percuss import plotting


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("basin_fractions.png"))
    arguments = parser.parse_args()
    fractions = pc.basin_fractions(
        pc.impact_oscillator(restitution="0.7", wall=1.0, side="above", damping="0.05"),
        pc.cosine("1.5"),
        over={"oscillator.stops.0.at": (0.5, 2.4)},
        x0=(-5.0, 0.5),
        v0=(-5.0, 5.0),
        n_starts=2000,
        progress=True,
    )
    figure = plotting.offscreen_figure(6.6, 4.2)
    plotting.plot_fractions(fractions, figure.add_subplot())
    figure.savefig(arguments.out, dpi=150)
    print(arguments.out)


if __name__ == "__main__":
    main()
