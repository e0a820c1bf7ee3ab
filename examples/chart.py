"""Two charts over two parameters: python examples/chart.py [--out FOLDER].

x'' + 0.1 x' + x = cos(omega t) below a wall: the largest Lyapunov exponent and the period of the
motion that begins at rest, over omega and the gap. A few minutes on two cores; with --store it
can be interrupted.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import percuss as pc
from percuss import plotting

SIZE = 240


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path())
    parser.add_argument("--size", type=int, default=SIZE, help="values along each axis")
    parser.add_argument("--store", type=Path, help="go on where an interrupted run has ended")
    arguments = parser.parse_args()
    chart = pc.sweep(
        ["largest_lyapunov_exponent", "period"],
        pc.impact_oscillator(restitution="0.8", wall=0.0, side="above", damping="0.05"),
        pc.cosine(1.0),
        over={
            "forcing.omega": np.linspace(1.5, 4.5, arguments.size),
            "oscillator.stops.0.at": np.linspace(-0.2, 0.6, arguments.size),
        },
        start=(-0.3, 0.0),
        transient=300,
        periods=256,
        store=arguments.store,
        progress=True,
    )
    arguments.out.mkdir(parents=True, exist_ok=True)
    for measure, file in (
        ("largest_lyapunov_exponent", "chart_of_exponents.png"),
        ("period", "chart_of_periods.png"),
    ):
        figure = plotting.offscreen_figure(6.8, 4.8)
        plotting.plot_chart(chart, measure, figure.add_subplot())
        figure.savefig(arguments.out / file, dpi=150)
        print(arguments.out / file)


if __name__ == "__main__":
    main()
