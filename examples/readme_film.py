"""The film at the top of the README: chatter, rest on the wall, and release, period after period.

python examples/readme_film.py [--out docs/images/chatter.gif]
"""

from __future__ import annotations

import argparse
from pathlib import Path

import percuss as pc
from percuss.plotting import animate

OUT = Path(__file__).parents[1] / "docs" / "images" / "chatter.gif"
OSC = pc.impact_oscillator(restitution="0.6", wall="0.2", side="above", damping="0.05")
FORCE = pc.cosine("0.35")
# Periods until the motion repeats, and those that the film shows: it begins again without a jump.
SETTLING, SHOWN = 40, 2


def main(out: Path) -> None:
    settled = pc.simulate(OSC, FORCE, periods=SETTLING)
    (x0,), (v0,) = settled([settled.t_end])
    run = pc.simulate(OSC, FORCE, x0=x0, v0=v0, periods=SHOWN)
    print(run)
    film = animate(run, duration=8.0, fps=20.0)
    film.write(out, force=True)
    print(f"{out}: {out.stat().st_size / 1e6:.2f} MB, {film}")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=OUT)
    main(parser.parse_args().out)
