"""Pictures of designs show each free parameter in its range."""

from __future__ import annotations

import pytest
from matplotlib.figure import Figure

import percuss as pc
from percuss import plotting
from percuss.errors import ParameterError


def test_a_design_shows_its_values_between_the_ends_of_their_ranges() -> None:
    stop = pc.SoftStop(at="0.2", side="above", stiffness=30)
    osc = pc.Oscillator.from_mass(
        1, 1, damping_coefficient="0.2", stops=[stop], units=pc.Units("m", "s", "kg")
    )
    free = {"oscillator.stops.0.stiffness": (5, 100), "oscillator.stops.0.damping": (0, 1)}
    best = pc.design("peak_stop_force", osc, pc.cosine(2), free=free, restarts=0)

    ax = plotting.plot_design(best, Figure().add_subplot())

    reported = [text.get_text() for text in ax.texts]
    assert "stiffness of the stop (N/m)" in reported
    assert "damping of the stop (N s/m)" in reported
    assert {"5", "100", "0", "1"} <= set(reported)
    assert ax.get_xlabel() == f"least peak stop force (N): {best.value:.6g}"
    places = [line.get_xdata()[0] for line in ax.lines if len(line.get_xdata()) == 1]
    shares = [(best.values[path] - low) / (high - low) for path, (low, high) in best.bounds.items()]
    assert places == pytest.approx(shares)


def test_the_damping_of_a_mass_is_called_its_coefficient() -> None:
    osc = pc.Oscillator.from_mass(2, 1, damping_coefficient="0.2")
    free = {"oscillator.damping": (0.1, 1)}
    best = pc.design("peak_displacement", osc, pc.cosine(2), free=free, restarts=0)

    ax = plotting.plot_design(best, Figure().add_subplot())

    assert "damping $c$ (dimensionless)" in [text.get_text() for text in ax.texts]


def test_what_is_no_design_is_refused() -> None:
    with pytest.raises(ParameterError, match="design"):
        plotting.plot_design(pc.Oscillator())
