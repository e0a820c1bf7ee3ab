"""The sets of a proof of chaos: python examples/chaos.py [--out FILE].

x'' + x = cos 2.8 t above a wall at 0, r = 0.8: the sets on the manifolds of the saddle with one
impact a period. The image of each lies across the next one.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import percuss as pc
from percuss import plotting
from percuss.certified import prove_chaos


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path("chaos.png"))
    arguments = parser.parse_args()
    chaos = prove_chaos(pc.impact_oscillator("4/5"), pc.cosine("14/5"))
    print(chaos)
    grown = pc.manifolds(chaos.orbit, section="impact", length=4.0, spacing=0.02)
    figure = plotting.offscreen_figure(7.0, 5.0)
    ax = plotting.plot_manifolds(grown, figure.add_subplot())
    plotting.plot_enclosure(chaos, ax)
    figure.savefig(arguments.out, dpi=150)


if __name__ == "__main__":
    main()
