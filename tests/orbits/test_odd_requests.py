"""Requests at the edges of what orbits can be asked for, each answered or refused in a sentence."""

from __future__ import annotations

import math
from typing import Any

import pytest

import percuss as pc

COCO = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")


def test_a_guess_that_is_no_number_is_refused() -> None:
    with pytest.raises(pc.ParameterError, match="neither two finite numbers"):
        pc.find_orbit(COCO, pc.cosine(1), guess=(0.2, math.nan))


def test_a_free_motion_that_does_not_come_back_gives_no_guess() -> None:
    """Thrown from the ceiling without a force, and without a spring, a mass never returns."""
    osc = pc.impact_oscillator(1, wall=0, stiffness=0)

    with pytest.raises(pc.ParameterError, match="the motion from it does not come back"):
        pc.find_orbit(osc, None, guess=(0, 1))


def test_a_guess_whose_motion_has_another_pattern_is_spaced_evenly() -> None:
    """The motion from it meets the other wall next; an orbit with one impact is found beside it."""
    walls = pc.Wall(-1, "below", "0.8"), pc.Wall(1, "above", "0.8")
    osc, force = pc.Oscillator(stiffness=1, damping="0.05", stops=walls), pc.cosine(1)
    from_there = pc.simulate(osc, force, -1, 3, max_impacts=1)
    with pytest.warns(pc.FormalOrbitWarning):
        orbit = pc.find_orbit(osc, force, n_impacts=1, guess=(0, 3))

    assert from_there.impacts.stop[0] == 1
    assert (orbit.sequence, orbit.n_periods) == ((0,), 1)
    assert orbit.residual < 1e-12


def test_less_than_one_period_of_an_orbit_is_refused() -> None:
    orbit = pc.find_orbit(COCO, pc.cosine(1))

    with pytest.raises(pc.ParameterError, match="less than one"):
        orbit.trajectory(periods=0)


def test_a_period_that_is_given_tells_whether_the_force_is_odd() -> None:
    """cos wt + cos 3wt changes its sign after half of 2 pi/w, and not after half of twice that."""
    osc = pc.backlash_oscillator(gap=1, stiffness=10, damping="0.3", stiffness_inside=1)
    w = math.sqrt(2.0)
    harmonics = (pc.cosine(w) + pc.cosine(3.0 * w, amplitude="0.1")).harmonics

    found = [
        pc.find_orbit(osc, pc.Forcing(harmonics, period=n * 2.0 * math.pi / w), n_impacts=0)
        for n in (1, 2, 3)
    ]

    assert [orbit.forcing is not None and orbit.forcing.frequency for orbit in found] == [None] * 3
    assert [orbit.symmetric for orbit in found] == [True, False, True]


def test_a_chart_over_decades_reaches_both_ends() -> None:
    """Where the range is wide the families are looked for at equal ratios of the parameter."""
    osc = pc.impact_oscillator("0.8", wall=-3, damping=1)

    chart = pc.response_curve(
        osc, pc.cosine(1), over={"forcing.omega": ("0.02", 2)}, max_impacts=1, max_periods=1
    )

    (steady,) = chart.families
    assert (steady.n_impacts, steady.ranges) == (0, ((0.02, 2.0),))


def test_results_tell_themselves_in_a_line_and_as_a_table() -> None:
    orbit = pc.find_orbit(COCO, pc.cosine(1))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": ("0.95", "1.05")})
    resonant = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.01")
    with pytest.warns(pc.FormalOrbitWarning):
        formal = pc.find_orbit(resonant, pc.cosine(1), n_impacts=0)

    for result in (orbit, branch):
        table = result._repr_html_()
        assert table.count("<table") == 1
        assert repr(result)[1:-1] in table
    assert repr(formal.passages) == "<Passages: 1, the deepest 49>"


def test_what_is_no_orbit_is_refused_in_a_sentence() -> None:
    osc = pc.impact_oscillator("0.8")
    for call in (pc.continue_orbit, pc.follow_cascade):
        with pytest.raises(pc.ParameterError, match="not a periodic orbit; find_orbit"):
            call(osc, over={"forcing.omega": (1, 2)})  # type: ignore[call-overload, arg-type]


def test_a_list_in_place_of_ranges_is_told_in_a_sentence() -> None:
    osc, force = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05"), pc.cosine(1)
    orbit = pc.find_orbit(osc, force)
    point = pc.continue_orbit(orbit, over={"forcing.amplitude": (1, "0.05")}).special_points[0]
    paths: Any = ["forcing.omega"]
    for call in (
        lambda: pc.continue_orbit(orbit, over=paths),
        lambda: pc.response_curve(osc, force, over=paths),
        lambda: pc.follow_cascade(orbit, over=paths),
        lambda: pc.continue_curve(point, over=paths),
    ):
        with pytest.raises(pc.ParameterError, match=r"^over = \['forcing.omega'\]: not (one|two)"):
            call()
    structure = pc.chain([1, 1], [1, 1, 1], dashpots="0.1")
    found = pc.find_orbit(structure, pc.Loads({0: pc.cosine("0.5")}))
    with pytest.raises(pc.ParameterError, match=r"^over = \['forcing.omega'\]: not one"):
        pc.continue_orbit(found, over=paths)
