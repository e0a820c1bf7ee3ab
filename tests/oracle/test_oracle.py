from __future__ import annotations

from collections.abc import Iterator

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from tests.oracle.curves import Flight, Force, Harmonic, Real
from tests.oracle.event_driven import Problem, Run, Soft, Wall, simulate
from tests.oracle.from_model import problem_of
from tests.reference.measures import Case, load_cases


@pytest.fixture(autouse=True)
def _digits() -> Iterator[None]:
    with mpmath.workdps(180):
        yield


@pytest.mark.parametrize("case", load_cases(), ids=lambda case: case.id)
def test_oracle_gives_the_reference_values(case: Case) -> None:
    problem = problem_of(case.oscillator(), case.force())
    x0, v0, t0 = case.start()

    run = simulate(problem, x0, v0, t0, **case.limits())

    # The values are compared as doubles, half an ulp of which is 6e-14 at t = 300.
    tolerance = min(case.tolerance, 1e-13)
    np.testing.assert_allclose(case.measured(run), case.expected, rtol=1e-15, atol=tolerance)


@pytest.mark.parametrize(
    ("a", "k", "omega"),
    [
        ("0.1", "2", "3"),
        ("3", "2", "1.5"),
        ("2", "4", "1"),
        ("0", "0", "1"),
        ("0.7", "0", "1"),
        ("0.2", "-1.5", "2"),
        ("0", "4", "2"),
        ("0", "4", "2.000000000000000000001"),
    ],
    ids=[
        "underdamped",
        "overdamped",
        "critical",
        "free flight",
        "no spring",
        "negative stiffness",
        "resonance",
        "detuned by 1e-21",
    ],
)
def test_sum_of_exponentials_is_the_power_series_of_the_equation(
    a: str, k: str, omega: str
) -> None:
    force = Force(mpf("0.3"), (Harmonic(mpf(omega), mpf(1), mpf("-0.4")),), mpf("0.25"))
    flight = Flight(mpf(a), mpf(k), force, mpf("0.5"), mpf(-2), 40)

    series = mpmath.fsum(c * mpf("0.5") ** n for n, c in enumerate(flight.taylor(0, 60)))

    assert abs(flight.value(mpf("0.5")) - series) < mpf("1e-40")


@pytest.mark.parametrize("depth", ["1e-3", "1e-9", "1e-15"])
def test_dip_of_any_depth_is_an_impact_and_a_near_miss_is_none(depth: str) -> None:
    """The motion x = cos t turns at x = -1 at t = pi, and a wall lies just inside or beyond."""
    inside, beyond = (Wall(-1 + sign * mpf(depth), "below", "0.5") for sign in (1, -1))

    hit = simulate(Problem(stops=(inside,)), 1, 0, t_end=4)
    miss = simulate(Problem(stops=(beyond,)), 1, 0, t_end=4)

    assert len(hit.impacts.t) == 1
    assert abs(hit.impacts.t[0] - (mpmath.pi - mpmath.acos(1 - mpf(depth)))) < mpf("1e-40")
    assert miss.impacts.t == []
    assert miss.touches == []


def test_exact_tangency_is_a_touch_that_changes_nothing() -> None:
    run = simulate(Problem(stops=(Wall(-1, "below", "0.5"),)), 1, 0, t_end=7)

    assert run.impacts.t == []
    assert len(run.touches) == 1
    assert abs(run.touches[0] - mpmath.pi) < mpf("1e-18")
    assert abs(run(6)[0] - mpmath.cos(6)) < mpf("1e-40")


def test_events_lie_on_the_stops_and_the_motion_is_continuous() -> None:
    stops = (
        Soft("0.8", "above", 30, "0.4"),
        Soft("-0.3", "below", "-0.5", 0),
        Soft("0.8", "above", 5, 0),
        Wall("-0.6", "below", "0.7"),
    )
    drive = (Harmonic("1.3", 1, "0.2"), Harmonic("2.9", 0, 1))
    problem = Problem("0.05", "0.4", "0.1", drive, stops)

    run = simulate(problem, 0, "0.6", t_end=20)

    for t, stop, v in _events(run):
        index = run.starts.index(t)
        x, v_arriving = run.pieces[index - 1].state(t - run.starts[index - 1])
        assert abs(x - mpf(stops[stop].at)) < mpf("1e-40")
        assert abs(v_arriving - v) < mpf("1e-40")
    assert {stop for _, stop, _ in _events(run)} == {0, 1, 2, 3}


def _events(run: Run) -> list[tuple[Real, int, Real]]:
    crossings, impacts = run.crossings, run.impacts
    return [
        *zip(crossings.t, crossings.stop, crossings.v, strict=True),
        *zip(impacts.t, impacts.stop, impacts.v_before, strict=True),
    ]


def test_soft_stop_gives_back_the_energy_that_its_spring_took() -> None:
    """Without dashpots the speed is the same at x = 0 whenever it comes by."""
    run = simulate(Problem(0, 1, 0, (), (Soft(0, "below", 99),)), 0, 1, t_end=40)

    assert len(run.crossings.v) > 10
    assert all(abs(abs(v) - 1) < mpf("1e-40") for v in run.crossings.v)
