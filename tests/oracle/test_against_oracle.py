from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.oracle.event_driven import simulate
from tests.oracle.events_of import SLOW, events_of
from tests.oracle.from_model import problem_of
from tests.oracle.random_problems import (
    FORCE_FREE,
    Motion,
    chattering_motion,
    hard_motion,
    random_motion,
    self_excited_motion,
    with_record,
    with_tables,
)

import percuss as pc

# A run of percuss or of the oracle: both have the same tables.
Run = Any
Event = tuple[float, str, int, float]

DURATION = 8.0
# Elastic hops on a wall can be any number.
MOST = 300
# Impacts and soft stops multiply rounding by less than 1e6 in the time and cases chosen.
TOLERANCE = 1e-9


@pytest.mark.parametrize(
    "seeds", [range(0, 30, 2), pytest.param(range(1500), marks=pytest.mark.nightly)], ids=len
)
def test_events_and_motion_are_those_of_the_oracle(seeds: range) -> None:
    found = [fault for seed in seeds for fault in _differences(random_motion(seed))]

    assert found == []


@pytest.mark.parametrize(
    "seeds", [range(12), pytest.param(range(500), marks=pytest.mark.nightly)], ids=len
)
def test_motions_that_are_fed_with_energy_are_those_of_the_oracle(seeds: range) -> None:
    found = [fault for seed in seeds for fault in _differences(self_excited_motion(seed))]

    assert found == []


@pytest.mark.parametrize(
    "seeds", [range(2, 13), pytest.param(range(34), marks=pytest.mark.nightly)], ids=len
)
@pytest.mark.parametrize("motion_of", [random_motion, chattering_motion, hard_motion])
def test_events_and_motion_under_a_record_are_those_of_the_oracle(
    motion_of: Callable[[int], Motion], seeds: range
) -> None:
    motions = [with_record(motion_of(seed), seed) for seed in seeds]
    found = [fault for motion in motions for fault in _differences(motion)]

    assert found == []


@pytest.mark.parametrize(
    "seeds", [range(3), pytest.param(range(400), marks=pytest.mark.nightly)], ids=len
)
def test_restitutions_over_the_speed_are_those_of_the_oracle(seeds: range) -> None:
    motions = [with_tables(random_motion(seed), seed) for seed in seeds]
    motions += [with_tables(chattering_motion(seed), seed) for seed in seeds]

    assert [fault for motion in motions for fault in _differences(motion)] == []


@pytest.mark.parametrize("name", FORCE_FREE)
def test_without_forces_nothing_happens_at_a_stop_but_what_the_oracle_says(name: str) -> None:
    assert _differences(FORCE_FREE[name]) == []


def _differences(case: Motion) -> list[str]:
    t0 = case.start[2]
    until = t0 + DURATION
    run = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=until, max_impacts=MOST)
    end = run.t_end
    exact = simulate(problem_of(case.oscillator, case.forcing), *case.start, t_end=end, digits=30)
    # The last event of a run that was stopped by its number lies on the end.
    ours, theirs = ([e for e in _events(r) if e[0] < end - TOLERANCE] for r in (run, exact))
    found = [
        f"{case}: {one}, not {other}"
        for one, other in zip(ours, theirs, strict=False)
        if one[1:3] != other[1:3] or _far(one[0], other[0]) or _far(one[3], other[3])
    ]
    if len(ours) != len(theirs):
        found.append(f"{case}: {len(ours)} events, not {len(theirs)}")
    times = [t for t in np.linspace(t0, end, 9)[:-1] if all(abs(t - e[0]) > 1e-6 for e in theirs)]
    for t in times if not found else []:
        state, other = run(t), exact(float(t))
        if _far(float(state[0]), float(other[0])) or _far(float(state[1]), float(other[1])):
            found.append(f"{case}: {state} at {t}, not {other}")
    half = max(1, len(_meetings(run)) // 2)
    part = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=end, max_impacts=half)
    if _meetings(part) != _meetings(run)[:half]:
        found.append(f"{case}: {len(_meetings(part))} meetings for max_impacts = {half}")
    return found[:1]


def _meetings(run: pc.Trajectory) -> list[float]:
    """Return when the body meets a stop, hard or soft: what ``max_impacts`` counts."""
    entries = run.crossings.t[run.crossings.direction == "in"]
    # Stops at one place are entered together.
    return sorted([*run.impacts.t, *set(entries)])


def _far(one: float, other: float) -> bool:
    return not math.isclose(one, other, rel_tol=TOLERANCE, abs_tol=TOLERANCE)


def _events(run: Run) -> list[Event]:
    rows = events_of(run, slowest=SLOW)
    return sorted((float(t), kind, stop, float(v)) for t, kind, stop, v in rows)
