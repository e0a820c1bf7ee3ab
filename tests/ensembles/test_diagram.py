from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.repetition import impact_periods, period_of
from percuss.motion.sections import SectionDirection, SectionGiven

OMEGA = "forcing.omega"
OSC = pc.impact_oscillator(restitution="0.8")


def test_points_are_those_of_plain_runs() -> None:
    force = pc.cosine(2.5)

    diagram = pc.bifurcation_diagram(
        OSC, force, over={"forcing.omega": [2.5, 2.8]}, starts=[(0.0, 1.0)], transient=50, points=9
    )

    for i, omega in enumerate((2.5, 2.8)):
        period = float(pc.cosine(omega).period or 0.0)
        run = pc.simulate(OSC, pc.cosine(omega), v0=1.0, t_end=60 * period)
        x, v = run(50 * period + np.arange(9) * period)
        np.testing.assert_allclose(diagram.x.sel(branch="start 0")[i], x, rtol=0, atol=1e-11)
        np.testing.assert_allclose(diagram.v.sel(branch="start 0")[i], v, rtol=0, atol=1e-11)


SOFT = pc.Oscillator(
    1, "0.05", (pc.SoftStop("0.2", "above", 30, "0.3"), pc.Wall("-0.9", "below", "0.7"))
)


@pytest.mark.filterwarnings("ignore:no motion has a point")
@pytest.mark.parametrize("osc", [OSC, SOFT], ids=["a wall", "a soft stop and a wall"])
@pytest.mark.parametrize("direction", ["up", "down", "both"])
@pytest.mark.parametrize("at", [0.3, 0.2, -0.85])
def test_passages_are_those_of_the_section_of_a_run(
    osc: pc.Oscillator, direction: SectionDirection, at: float
) -> None:
    """In the free flight, at the edge of the soft stop, and where none is."""
    diagram = pc.bifurcation_diagram(
        osc, pc.cosine(2.5), over={"forcing.omega": [2.5, 2.8]}, starts=[(0.0, 1.0)],
        follow=(), transient=50, points=40, section={"at": at, "direction": direction},
    )  # fmt: skip

    if osc is OSC and at == -0.85:
        assert np.isnan(diagram.v).all(), "inside the wall"
        return
    for i, omega in enumerate((2.5, 2.8)):
        period = float(pc.cosine(omega).period or 0.0)
        run = pc.simulate(osc, pc.cosine(omega), v0=1.0, t_end=89 * period)
        passages = run.section(at=at, direction=direction)
        late = passages.t.values >= 50 * period
        t, v = passages.t.values[late][-40:], passages.v.values[late][-40:]
        ours = diagram.isel(branch=0)
        kept = np.isfinite(ours.v.values[i])
        assert kept.sum() == len(t)
        np.testing.assert_allclose(ours.v.values[i][kept], v, rtol=0, atol=1e-9)
        cycles = ours.cycle.values[i][kept] - t / period
        assert np.abs(cycles - np.round(cycles)).max(initial=0.0) < 1e-9
        signs = {"up": {1.0}, "down": {-1.0}, "both": {1.0, -1.0}}[direction]
        assert set(np.sign(v).tolist()) <= signs
        if at != -0.85:
            assert len(t) > 20


def test_passages_under_a_record_are_those_of_the_section_of_a_run() -> None:
    force = pc.square_wave("2.5") + pc.cosine("2.5", amplitude="0.1")
    diagram = pc.bifurcation_diagram(
        SOFT, force, over={"oscillator.damping": ["0.05", "0.1"]}, starts=[(0.0, 1.0)],
        follow=(), transient=20, points=30, section={"at": 0.1, "direction": "down"},
    )  # fmt: skip

    for i, damping in enumerate(("0.05", "0.1")):
        osc = pc.Oscillator(1, damping, SOFT.stops)
        period = float(force.period or 0.0)
        passages = pc.simulate(osc, force, v0=1.0, t_end=49 * period).section(0.1, "down")
        v = passages.v.values[passages.t.values >= 20 * period][-30:]
        ours = diagram.v.isel(branch=0).values[i]
        np.testing.assert_allclose(ours[np.isfinite(ours)], v, rtol=0, atol=1e-9)
        assert len(v) >= 15


def test_many_motions_have_the_passages_of_each_alone() -> None:
    """Together they go in lockstep; the bits are those of one by one."""
    keywords: dict[str, Any] = {
        "starts": [(0.0, 1.0)], "follow": (), "section": {"at": 0.4, "direction": "up"},
    }  # fmt: skip
    omegas = np.linspace(2.4, 2.9, 40)

    together = pc.bifurcation_diagram(
        OSC, pc.cosine(2.5), over={"forcing.omega": omegas}, **keywords
    )

    for k in (0, 17, 39):
        alone = pc.bifurcation_diagram(
            OSC, pc.cosine(2.5), over={"forcing.omega": [omegas[k]]}, **keywords
        )
        np.testing.assert_array_equal(together.v.values[0, k], alone.v.values[0, 0])


@pytest.mark.parametrize("cycle", [0.0, 0.25, 0.9])
def test_strobes_at_a_cycle_are_those_of_the_run(cycle: float) -> None:
    start = pc.Start(0.0, 1.0, 0.4)
    diagram = pc.bifurcation_diagram(
        OSC, pc.cosine(2.5), over={"forcing.omega": [2.5, 2.6, 2.7]}, starts=[start],
        transient=30, points=12, section={"cycle": cycle},
    )  # fmt: skip

    period = float(pc.cosine(2.6).period or 0.0)
    run = pc.simulate(OSC, pc.cosine(2.6), v0=1.0, t0=0.4, t_end=0.4 + 43 * period)
    strobes = run.stroboscopic(cycle=cycle)
    late = strobes.t.values >= 0.4 + 30 * period
    fresh = diagram.sel(branch="start 0").isel({OMEGA: 1})
    np.testing.assert_allclose(fresh.x, strobes.x.values[late][:12], rtol=0, atol=1e-11)
    np.testing.assert_allclose(fresh.v, strobes.v.values[late][:12], rtol=0, atol=1e-11)
    # A followed branch goes on from whole periods after its start, whatever the section is.
    plain = pc.bifurcation_diagram(
        OSC, pc.cosine(2.5), over={"forcing.omega": [2.5, 2.6, 2.7]}, starts=[start],
        transient=30, points=13,
    )  # fmt: skip
    assert diagram.period.values.tolist() == plain.period.values.tolist()
    assert diagram.attrs["section"] == f"cycle = {cycle:g}"


def test_the_period_is_the_same_at_every_section() -> None:
    over = {"forcing.omega": [2.5, 2.652, 2.66]}
    sections: tuple[SectionGiven, ...] = (
        "stroboscopic",
        "impacts",
        {"cycle": 0.4},
        {"at": 0.5, "direction": "down"},
    )

    periods = [
        pc.bifurcation_diagram(
            OSC, pc.cosine(2.5), over=over, starts=[(0.0, 1.0)], follow=["forward"],
            transient=10_000, section=section,
        ).period.sel(branch="forward").values.tolist()
        for section in sections
    ]  # fmt: skip

    assert periods == 4 * [[1, 1, 2]]


def test_the_followed_orbit_doubles_its_period_where_it_should() -> None:
    """Reference case pd-r0.8-n1: at omega = 2.65334772785532."""
    diagram = pc.bifurcation_diagram(
        OSC,
        pc.cosine(2.5),
        over={"forcing.omega": [2.5, 2.55, 2.6, 2.64, 2.652, 2.655, 2.66]},
        starts=[(0.0, 1.0)],
        follow=["forward"],
        transient=10_000,
    )

    assert diagram.period.sel(branch="forward").values.tolist() == [1, 1, 1, 1, 1, 2, 2]


def test_both_of_two_attractors_are_found_forward_and_backward() -> None:
    """Between the grazing of the one and the fold of the other; case fold-a0.05-r0.7-w1.5."""
    osc = pc.impact_oscillator(restitution=0.7, wall=1.0, side="above", damping=0.05)
    gaps = np.array([0.7, 1.2, 1.7, 2.0, 2.2])

    diagram = pc.bifurcation_diagram(
        osc,
        pc.cosine(1.5),
        over={"oscillator.stops.0.at": gaps},
        section="impacts",
        starts=[(0.0, 0.0)],
        transient=400,
        points=16,
    )

    strikes = np.isfinite(diagram.v_after).any("sample")
    # The striking motion lives up to a gap of 2.1214694, the other from 0.7943015 on.
    assert strikes.sel(branch="forward").values.tolist() == [True, True, True, True, False]
    assert strikes.sel(branch="backward").values.tolist() == [True, False, False, False, False]
    assert diagram.period.sel(branch="forward").values[1:4].tolist() == [1, 1, 1]


def test_a_followed_branch_is_not_lost_where_a_value_has_no_motion() -> None:
    with pytest.warns(UserWarning, match=r"3 of 9 values have no answer.*1\.4 of forward; the"):
        diagram = pc.bifurcation_diagram(
            OSC,
            pc.cosine(2.5),
            over={"oscillator.stops.0.restitution": [0.7, 1.4, 0.8]},
            starts=[(0.0, 1.0)],
        )

    assert diagram.period.sel(branch="forward").values.tolist() == [1, -1, 1]
    assert "restitution = 1.4" in diagram.reason.sel(branch="forward").values[1]
    assert "restitution = 1.4" in diagram.reason.sel(branch="start 0").values[1]


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

    found = period_of(np.stack([points, settled]), 16, np.full(2, 2.0 * np.pi))
    assert found.tolist() == [0, 3]


def test_the_alternating_end_of_a_transient_is_no_doubled_period_of_impacts() -> None:
    """A multiplier near -1, as before a doubling: two periods later the impacts are the same."""
    k = np.arange(33)
    speeds = [1.0 + 3e-6 * (-0.99) ** k, 1.0 + 0.1 * (-1.0) ** k, np.ones(33)]
    points = np.stack([np.stack([np.full(33, 0.25), v, np.zeros(33)], axis=1) for v in speeds])

    assert impact_periods(points, np.full(3, 33), 33).tolist() == [0, 2, 1]


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"over": {"forcing.omega": [1.0], "forcing.amplitude": [1.0]}}, "one axis"),
        ({"over": {"start.x0": [1.0]}}, "one axis"),
        ({"section": "poincare"}, "neither stroboscopic nor impacts, nor a cycle"),
        ({"section": {"at": 1.0, "cycle": 0.1}}, "neither stroboscopic nor impacts"),
        ({"section": {"direction": "up"}}, "neither stroboscopic nor impacts"),
        ({"section": {"at": 1.0, "direction": "left"}}, "direction = 'left': none of up, down"),
        ({"section": {"at": float("nan")}}, "at = nan"),
        ({"section": {"cycle": 1.0}}, r"cycle = 1.0: not in \[0, 1\)"),
        ({"follow": ["up"]}, "neither forward nor backward"),
        ({"starts": []}, "none at all"),
        ({"points": 1}, "at least 2"),
    ],
)
def test_what_is_wrong_with_a_call_is_said(keywords: dict[str, object], message: str) -> None:
    given = {"over": {"forcing.omega": [1.0]}} | keywords
    with pytest.raises(pc.ParameterError, match=message):
        pc.bifurcation_diagram(OSC, pc.cosine(2.5), **given)  # type: ignore[arg-type]
