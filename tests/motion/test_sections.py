"""Passages of a displacement, and strobes at any cycle."""

from __future__ import annotations

import math

import mpmath
import numpy as np
import pytest
from tests.oracle.curves import Flight
from tests.oracle.event_driven import Run, number, simulate
from tests.oracle.extremes import zeros
from tests.oracle.from_model import problem_of
from tests.oracle.random_problems import random_motion

import percuss as pc


def test_a_free_oscillator_passes_a_level_at_its_arcsines() -> None:
    run = pc.simulate(pc.Oscillator(), v0=1.0, t_end=20.0)

    up, down = (run.section(at=0.3, direction=way) for way in ("up", "down"))

    first = math.asin(0.3)
    assert np.allclose(up.t, first + 2 * math.pi * np.arange(4), rtol=1e-15, atol=0)
    assert np.allclose(down.t, math.pi - first + 2 * math.pi * np.arange(3), rtol=1e-15, atol=0)
    assert np.allclose(up.v, math.sqrt(1 - 0.09), rtol=1e-14)
    assert (up.x == 0.3).all()
    both = run.section(at=0.3)
    assert sorted([*up.t.values, *down.t.values]) == both.t.values.tolist()
    assert set(both) == {"t", "x", "v"}


@pytest.mark.parametrize("below", [1e-3, 1e-8, 1e-12, 1e-14])
def test_a_level_that_is_almost_grazed_is_passed_twice_or_not_at_all(below: float) -> None:
    # The summit of sin t is 1.
    run = pc.simulate(pc.Oscillator(), v0=1.0, t_end=6.0)

    passed, missed = run.section(at=1.0 - below), run.section(at=1.0 + below)

    assert len(missed.t) == 0
    assert len(passed.t) == 2
    half = math.acos(1.0 - below)
    # An error of a few units in the last place of x over the slope there.
    doubt = 8 * 2.0**-52 / math.sin(half)
    assert np.allclose(passed.t, [0.5 * math.pi - half, 0.5 * math.pi + half], rtol=0, atol=doubt)


def test_a_touch_is_no_passage() -> None:
    run = pc.simulate(pc.Oscillator(), v0=1.0, t_end=20.0)

    assert len(run.section(at=1.0).t) in (0, 2, 4, 6)
    # 2 - 2 cos t touches 0 at each period, and starts there.
    held = pc.simulate(pc.Oscillator(), pc.Forcing(constant=2), t_end=20.0)
    assert set(np.sign(held.section(at=0.0).v.values)) <= {-1.0, 1.0}
    assert len(held.section(at=0.0).t) % 2 == 0


def test_the_edge_of_a_stop_is_passed_at_its_crossings() -> None:
    stop = pc.SoftStop(at="0.3", side="above", stiffness=40, damping=0.5)
    run = pc.simulate(pc.Oscillator(1, "0.02", (stop,)), pc.cosine("1.3"), t_end=100.0)

    passed = run.section(at=0.3)

    assert passed.t.values.tolist() == run.crossings.t.tolist()
    assert passed.v.values.tolist() == run.crossings.v.tolist()


def test_at_a_wall_there_is_no_passage_and_inside_it_no_section() -> None:
    osc, force = pc.impact_oscillator("0.9", wall=0), pc.cosine(2)
    run = pc.simulate(osc, force, v0=1.0, t_end=50.0)

    assert len(run.section(at=0.0).t) == 0
    inside = r"^at = -0\.1: below the wall at x = 0"
    with pytest.raises(pc.ParameterError, match=inside):
        run.section(at=-0.1)
    with pytest.raises(pc.ParameterError, match=inside):
        pc.section_map(osc, force, at=-0.1)


def test_a_start_on_the_level_is_no_passage() -> None:
    run = pc.simulate(pc.Oscillator(), v0=1.0, t_end=7.0)

    assert np.allclose(run.section(at=0.0).t, [math.pi, 2 * math.pi], rtol=1e-15)


def test_a_long_flight_loses_no_passage_and_no_digit() -> None:
    run = pc.simulate(pc.Oscillator(), v0=1.0, t_end=2.0 * math.pi * 100_000)

    t = run.section(at=0.3, direction="up").t.values

    assert len(t) == 100_000
    exact = [mpmath.asin(mpmath.mpf(0.3)) + 2 * mpmath.pi * n for n in (50_000, 99_999)]
    assert [t[50_000], t[99_999]] == pytest.approx([float(e) for e in exact], rel=2.0**-51)


@pytest.mark.parametrize(
    "seeds", [range(0, 30, 4), pytest.param(range(300), marks=pytest.mark.nightly)], ids=len
)
def test_sections_are_those_of_the_oracle(seeds: range) -> None:
    assert [fault for seed in seeds for fault in _faults(seed)] == []


def _faults(seed: int) -> list[str]:
    case = random_motion(seed)
    t0 = case.start[2]
    run = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=t0 + 6.0, max_impacts=60)
    exact = simulate(problem_of(case.oscillator, case.forcing), *case.start, t_end=run.t_end,
                     digits=25)  # fmt: skip
    span = run.extremes("displacement")
    faults = []
    for part in (0.1, 0.37, 0.9):
        level = span.minimum + part * (span.maximum - span.minimum)
        ours = run.section(at=level).t.values
        theirs = _passages(exact, level, run.t_end)
        if len(ours) != len(theirs) or not np.allclose(ours, theirs, rtol=0, atol=1e-8):
            faults.append(f"{seed} at {level!r}: {ours}, not {theirs}")
    return faults


def _passages(run: Run, level: float, t_end: float) -> list[float]:
    found = []
    with mpmath.workdps(4 * run.digits + 20):
        ends = [*run.starts[1:], number(t_end)]
        for t, end, piece in zip(run.starts, ends, run.pieces, strict=True):
            if isinstance(piece, Flight) and end > t:
                found += [float(t + s) for s in zeros(piece, (1,), end - t, run.digits, level)]
    return found


@pytest.mark.parametrize("cycle", [0.0, 0.25, 0.999])
@pytest.mark.parametrize("t0", [-3.0, 0.0, 11.5])
def test_strobes_come_once_a_period_at_their_cycle(cycle: float, t0: float) -> None:
    force = pc.cosine("1.3")
    osc = pc.impact_oscillator("0.9", wall=-1)
    run = pc.simulate(osc, force, v0=1.0, t0=t0, periods=12)

    strobes = run.stroboscopic(cycle=cycle)

    assert list(strobes) == ["t", "x", "v"]
    turns = strobes.t.values * 1.3 / (2.0 * math.pi) - cycle
    assert np.allclose(turns, np.round(turns), atol=1e-12)
    assert len(strobes.t) in (12, 13)
    period = 2.0 * math.pi / 1.3
    assert t0 <= strobes.t[0] < t0 + period
    x, v = run(strobes.t.values)
    assert (x == strobes.x).all()
    assert (v == strobes.v).all()


def test_strobes_without_a_cycle_begin_with_the_start() -> None:
    run = pc.simulate(pc.Oscillator(), pc.cosine("1.3"), v0=1.0, t0=0.7, periods=3)

    assert run.stroboscopic().t[0] == 0.7


def test_a_wrong_section_is_refused() -> None:
    run = pc.simulate(pc.Oscillator(), pc.cosine(2), v0=1.0, t_end=5.0)

    with pytest.raises(pc.ParameterError, match=r"^cycle"):
        run.stroboscopic(cycle=1.0)
    with pytest.raises(pc.ParameterError, match=r"^at"):
        run.section(at=math.nan)
    with pytest.raises(pc.ParameterError, match=r"^at = .*the place of a section does not follow"):
        run.section(at=pc.parameter("a", 1) / 10)  # type: ignore[arg-type]
    with pytest.raises(pc.ParameterError, match=r"^direction"):
        run.section(at=0.0, direction="left")  # type: ignore[arg-type]  # that is the point
