from __future__ import annotations

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.measures import period_of

OMEGA = "forcing.omega"
OSC = pc.impact_oscillator(restitution="0.8")


def test_points_are_those_of_plain_runs() -> None:
    force = pc.cosine(2.5)

    found = pc.bifurcation_diagram(
        OSC, force, over={"forcing.omega": [2.5, 2.8]}, starts=[(0.0, 1.0)], transient=50, points=9
    )

    for i, omega in enumerate((2.5, 2.8)):
        period = float(pc.cosine(omega).period or 0.0)
        run = pc.simulate(OSC, pc.cosine(omega), v0=1.0, t_end=60 * period)
        x, v = run(50 * period + np.arange(9) * period)
        np.testing.assert_allclose(found.x.sel(branch="start 0")[i], x, rtol=0, atol=1e-11)
        np.testing.assert_allclose(found.v.sel(branch="start 0")[i], v, rtol=0, atol=1e-11)


def test_the_followed_orbit_doubles_its_period_where_it_should() -> None:
    """Reference case pd-r0.8-n1: at omega = 2.65334772785532."""
    found = pc.bifurcation_diagram(
        OSC,
        pc.cosine(2.5),
        over={"forcing.omega": [2.5, 2.55, 2.6, 2.64, 2.652, 2.655, 2.66]},
        starts=[(0.0, 1.0)],
        follow=["forward"],
        transient=10_000,
    )

    assert found.period.sel(branch="forward").values.tolist() == [1, 1, 1, 1, 1, 2, 2]


def test_both_of_two_attractors_are_found_forward_and_backward() -> None:
    """Between the grazing of the one and the fold of the other; case fold-a0.05-r0.7-w1.5."""
    osc = pc.impact_oscillator(restitution=0.7, wall=1.0, side="above", damping=0.05)
    gaps = np.array([0.7, 1.2, 1.7, 2.0, 2.2])

    found = pc.bifurcation_diagram(
        osc,
        pc.cosine(1.5),
        over={"oscillator.stops.0.at": gaps},
        section="impacts",
        starts=[(0.0, 0.0)],
        transient=400,
        points=16,
    )

    strikes = np.isfinite(found.v_after).any("sample")
    # The striking motion lives up to a gap of 2.1214694, the other from 0.7943015 on.
    assert strikes.sel(branch="forward").values.tolist() == [True, True, True, True, False]
    assert strikes.sel(branch="backward").values.tolist() == [True, False, False, False, False]
    assert found.period.sel(branch="forward").values[1:4].tolist() == [1, 1, 1]


def test_a_followed_branch_is_not_lost_where_a_value_has_no_motion() -> None:
    with pytest.warns(UserWarning, match=r"3 of 9 values have no answer.*1\.4 of forward; the"):
        found = pc.bifurcation_diagram(
            OSC,
            pc.cosine(2.5),
            over={"oscillator.stops.0.restitution": [0.7, 1.4, 0.8]},
            starts=[(0.0, 1.0)],
        )

    assert found.period.sel(branch="forward").values.tolist() == [1, -1, 1]
    assert "restitution = 1.4" in found.reason.sel(branch="forward").values[1]
    assert "restitution = 1.4" in found.reason.sel(branch="start 0").values[1]


def test_periods_of_impacts_and_of_strobes_agree() -> None:
    over = {"forcing.omega": [2.6, 2.67, 4.5, 4.62]}

    found = [
        pc.bifurcation_diagram(
            OSC,
            pc.cosine(2.5),
            over=over,
            section=section,
            starts=[(0.0, 1.0), (0.5, 0.0)],
            transient=2000,
        ).period.values
        for section in ("stroboscopic", "impacts")
    ]

    np.testing.assert_array_equal(*found)
    assert {1, 2} <= set(found[0].ravel())


def test_the_turning_end_of_a_transient_is_no_period() -> None:
    k = np.arange(33)
    size = 1e-5 * 0.9**k
    points = np.stack([1.0 + size * np.cos(2.1 * k), size * np.sin(2.1 * k)], axis=1)

    settled = np.stack([1.0 + 0.1 * np.cos(2 * np.pi * k / 3), np.zeros(33)], axis=1)

    assert period_of(np.stack([points, settled]), 16).tolist() == [0, 3]


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"over": {"forcing.omega": [1.0], "forcing.amplitude": [1.0]}}, "one axis"),
        ({"over": {"start.x0": [1.0]}}, "one axis"),
        ({"section": "poincare"}, "neither stroboscopic nor impacts"),
        ({"follow": ["up"]}, "neither forward nor backward"),
        ({"starts": []}, "none at all"),
        ({"points": 1}, "at least 2"),
    ],
)
def test_what_is_wrong_with_a_call_is_said(keywords: dict[str, object], message: str) -> None:
    given = {"over": {"forcing.omega": [1.0]}} | keywords
    with pytest.raises(pc.ParameterError, match=message):
        pc.bifurcation_diagram(OSC, pc.cosine(2.5), **given)  # type: ignore[arg-type]
