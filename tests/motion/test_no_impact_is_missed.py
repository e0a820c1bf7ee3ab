from __future__ import annotations

import math

import pytest
from tests.motion.adversarial import faults_of, near_grazing_cases
from tests.motion.one_harmonic import is_right, passes
from tests.oracle.event_driven import simulate
from tests.oracle.from_model import problem_of

import percuss as pc

FINE = ((500, 0), (10_000, 1))


@pytest.mark.parametrize(
    ("n", "seed"), [(250, 0), *(pytest.param(*of, marks=pytest.mark.nightly) for of in FINE)]
)
def test_first_event_is_right_down_to_rounding_and_listed_below_it(n: int, seed: int) -> None:
    """Dips and near misses of 1e-15 to 1e-3 of the amplitude; 10,000 of them at night."""
    cases = list(near_grazing_cases(n, seed))

    wrong = [fault for case in cases for fault in faults_of(case)]

    assert wrong == []


@pytest.mark.parametrize("seed", [2, pytest.param(3, marks=pytest.mark.nightly)])
def test_first_event_is_right_where_damping_feeds_energy_in(seed: int) -> None:
    cases = list(near_grazing_cases(5_000 if seed == 3 else 300, seed, self_excited=True))

    wrong = [fault for case in cases for fault in faults_of(case)]

    assert wrong == []


@pytest.mark.parametrize("n", [15, pytest.param(40, marks=pytest.mark.nightly)])
def test_oracle_finds_the_touches_that_the_turning_points_promise(n: int) -> None:
    """The cases are built and judged at their turning points; here without that knowledge."""
    for case in near_grazing_cases(n, seed=2):
        truth = case.truth()
        problem = problem_of(case.oscillator, case.forcing)

        run = simulate(problem, *case.start, t_end=case.t_end, max_impacts=1)

        events = [*run.impacts.t, *run.crossings.t[:1]]
        assert (len(events) > 0) == (truth.clearance < 0)
        if events:
            assert abs(float(events[0]) - truth.first_root) <= math.ulp(truth.first_root)


@pytest.mark.parametrize("count", [400, pytest.param(2000, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("sign", [-1, 1], ids=["dips", "near misses"])
def test_shallow_pass_of_one_harmonic_is_an_impact_exactly_when_it_dips(
    sign: int, count: int
) -> None:
    """Dips of 1e-10 to 1e-3 below the wall, and as many passes above it."""
    wrong = []
    for case in passes(count, seed=1, sign=sign):
        osc, force = pc.impact_oscillator(), pc.cosine(case.omega)

        run = pc.simulate(osc, force, *case.start, t_end=case.t_end, max_impacts=1)

        event = run.impacts.t[0] if len(run.impacts) else None
        if not is_right(case, event):
            wrong.append(case)
    assert wrong == []
