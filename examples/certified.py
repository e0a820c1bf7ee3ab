"""How far doubles can be trusted: a chaotic run beside its certified twin.

python examples/certified.py [--impacts 200]

Needs the extra percuss[certified].
"""

from __future__ import annotations

import argparse

import numpy as np

import percuss as pc

OSCILLATOR = pc.impact_oscillator()
FORCE = pc.sine("2.7")
START = pc.Start(x0=0, v0="0.3")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--impacts", type=int, default=200)
    n = parser.parse_args().impacts
    run = pc.simulate(OSCILLATOR, FORCE, START.x0, START.v0, max_impacts=n)

    proven = pc.certify(run, digits=12, start=START)

    print(proven)
    print(f"{proven.bits_per_impact:.2f} bits an impact, {proven.precision} bits in all\n")
    print("impact  time, certified                    error of doubles")
    times = proven.impacts.t
    for k in [*range(9, n, max(1, n // 10))]:
        error = abs(run.impacts.t[k] - times.mid()[k])
        print(f"{k + 1:6d}  {times[k].text(18):34s} {error:9.1e}")
    lost = np.flatnonzero(np.abs(run.impacts.t - times.mid()) > 1e-3)
    if len(lost):
        print(f"\nDoubles have lost the motion from impact {lost[0] + 1} on.")


if __name__ == "__main__":
    main()
