"""A bifurcation diagram: python examples/bifurcation_diagram.py [--out FILE].

x'' + x = cos(omega t) above a wall at 0, r = 0.8: the impact velocities over omega, followed
forward and backward, and from one start at each value. Period doubling begins at 2.6533; where
the colours part, two attractors coexist. A minute on two cores.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import percuss as pc
from percuss import plotting

VALUES = 1200


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("bifurcation_diagram.png"))
    parser.add_argument("--store", type=Path, help="go on where an interrupted run has ended")
    arguments = parser.parse_args()
    diagram = pc.bifurcation_diagram(
        pc.impact_oscillator(restitution="0.8"),
        pc.cosine("2.6"),
        over={"forcing.omega": np.linspace(2.55, 3.0, VALUES)},
        section="impacts",
        starts=[(0.0, 1.0)],
        transient=500,
        points=400,
        store=arguments.store,
        progress=True,
    )
    figure = plotting.offscreen_figure(7.6, 4.8)
    plotting.plot_diagram(diagram, figure.add_subplot())
    figure.savefig(arguments.out, dpi=150)
    print(f"{arguments.out}: {int(np.isfinite(diagram.v_after).sum()):,} impacts drawn")


if __name__ == "__main__":
    main()
