"""Basins of attraction: python examples/basin_picture.py [--out FILE].

x'' + 0.1 x' + x = cos 1.5 t below a wall at 1.45789, r = 0.7: to which of two motions, one with
an impact a period and one without any, each start (x0, v0) goes. Solid is the stable manifold of
the saddle between them, which bounds the basins. Half a minute on two cores.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np

import percuss as pc
from percuss import plotting

SIZE = 500


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("basin_picture.png"))
    parser.add_argument("--size", type=int, default=SIZE, help="starts along each axis")
    parser.add_argument("--store", type=Path, help="go on where an interrupted run has ended")
    arguments = parser.parse_args()
    osc = pc.impact_oscillator(restitution="0.7", wall="1.45789", side="above", damping="0.05")
    force = pc.cosine("1.5")
    (saddle,) = (
        orbit
        for orbit in pc.find_orbits(osc, force, max_impacts=1, max_periods=1)
        if orbit.stability == "unstable"
    )
    basins = pc.basins(
        osc,
        force,
        x0=np.linspace(-6.0, 1.45, arguments.size),
        v0=np.linspace(-6.0, 6.0, arguments.size),
        store=arguments.store,
        progress=True,
    )
    figure = plotting.offscreen_figure(6.6, 5.4)
    plotting.plot_basins(basins, figure.add_subplot(), manifolds=pc.manifolds(saddle))
    figure.savefig(arguments.out, dpi=150)
    for i in range(basins.sizes["attractor"]):
        one = basins.isel(attractor=i)
        error = float(one.fraction_error)
        print(f"{one.name.item()}: {float(one.fraction):.2%} +- {error:.2%} of the starts")


if __name__ == "__main__":
    main()
