"""The response chart of a damped bilinear oscillator, and the ellipses of an impact oscillator.

python examples/bilinear_response.py [--out docs/images]

Some minutes of search. The pictures are those of docs/response-charts.md, and the tables
printed are its tables.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

import percuss as pc
from percuss.plotting import offscreen_figure, plot_response, plot_velocity_gap
from percuss.plotting.style import GREY, style

OSC = pc.bilinear_oscillator(stiffness_above=1.0, stiffness_below=9.0, damping=0.05)
FORCE = pc.cosine(1.0)
RANGE = (0.3, 8.0)
IMAGES = Path(__file__).parent.parent / "docs" / "images"


def main() -> None:
    """Search, print what was found, and draw."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=IMAGES, help="folder of the pictures")
    out: Path = parser.parse_args().out
    out.mkdir(parents=True, exist_ok=True)
    chart = pc.response_curve(OSC, FORCE, over={"forcing.omega": RANGE}, progress=True)
    print(chart)
    print_families(chart)
    print_peaks(chart)
    figure = offscreen_figure(9.0, 8.4)
    with style():
        above, below = figure.subplots(2, 1, sharex=True)
    mark_resonances(plot_response(chart, "amplitude", above, log_y=True))
    mark_resonances(plot_response(chart, "impact_velocity", below, log_y=True, legend=False))
    above.set_xlabel("")
    figure.savefig(out / "bilinear_response.png", dpi=130)
    ellipses(out / "velocity_gap.png")


def print_families(chart: pc.Response) -> None:
    """Print where each kind of orbit is, and where it is stable."""
    for family in chart.families:
        stable = ", ".join(f"{low:.4f} to {high:.4f}" for low, high in family.stable_ranges)
        print(f"({family.n_impacts}, {family.n_periods})  stable: {stable or 'nowhere'}")


def print_peaks(chart: pc.Response) -> None:
    """Print the largest amplitude of each kind of stable orbit, and where it is."""
    resonance = float(pc.resonant_frequency(OSC))
    table = chart.to_xarray()
    stable = table.admissible & (table.stability == "asymptotic")
    for family in chart.families:
        kind = (table.n_impacts == family.n_impacts) & (table.n_periods == family.n_periods)
        rows = np.flatnonzero(kind & stable)
        if len(rows):
            top = rows[int(np.argmax(table.amplitude.values[rows]))]
            amplitude, omega = float(table.amplitude[top]), float(table.value[top])
            name = f"({family.n_impacts}, {family.n_periods})"
            print(f"{name}  {amplitude:.3f} at {omega:.4f} = {omega / resonance:.4f} resonances")


def mark_resonances(ax: Axes) -> None:
    """Draw lines at whole multiples and whole parts of the resonant frequency."""
    resonance = float(pc.resonant_frequency(OSC))
    places = {1: r"$\omega_r$"}
    places |= {n: rf"${n}\omega_r$" for n in (2, 3, 4, 5)}
    places |= {1.0 / m: rf"$\omega_r/{m}$" for m in (2, 3, 4)}
    with style():
        for ratio, text in places.items():
            ax.axvline(ratio * resonance, color=GREY, linewidth=0.6, linestyle=":", zorder=0.4)
            ax.annotate(text, (ratio * resonance, 1.0), xycoords=("data", "axes fraction"),
                        xytext=(0.0, 3.0), textcoords="offset points", ha="center",
                        fontsize=8.5, color=GREY)  # fmt: skip


def ellipses(path: Path) -> None:
    """Draw impact velocity against gap of (1, n) orbits for a rigid wall."""
    osc = pc.impact_oscillator(restitution=0.8, wall=0.0, side="above", damping=0.02)
    curves = [pc.velocity_gap_curve(osc, pc.cosine(2.8), n) for n in (1, 2, 3)]
    figure = offscreen_figure(8.2, 4.2)
    with style():
        ax = figure.add_subplot()
    plot_velocity_gap(curves, ax)
    figure.savefig(path, dpi=130)


if __name__ == "__main__":
    main()
