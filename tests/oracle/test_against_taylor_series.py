"""The same events as a second oracle, which knows nothing but the differential equation."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import pytest
from tests.oracle.events_of import events_of
from tests.oracle.from_model import problem_of
from tests.oracle.random_problems import Motion, hard_motion
from tests.oracle.taylor_series import Event, Run, simulate
from tests.oracle.tolerances import EPS, Tolerances

import percuss as pc

DURATION = 10.0
MOST = 120
# The order of events of one instant; all others have the same.
RANKS = {"release": 0, "rest": 2}


class Seen(NamedTuple):
    """An event of percuss, in the order in which they come at one instant."""

    t: float
    rank: int
    kind: str
    stop: int
    v: float


@pytest.mark.parametrize(
    "seeds", [range(60), pytest.param(range(60, 20_000), marks=pytest.mark.nightly)], ids=len
)
def test_events_and_states_are_those_of_the_differential_equation(seeds: range) -> None:
    found = [fault for seed in seeds for fault in differences(seed)]

    assert found == []


def differences(seed: int) -> list[str]:
    """Return the first difference between percuss and the oracle that rounding does not explain."""
    case = hard_motion(seed)
    t0 = case.start[2]
    run = pc.simulate(
        case.oscillator, case.forcing, *case.start, t_end=t0 + DURATION, max_impacts=MOST
    )
    rng = np.random.default_rng(seed)
    at = tuple(sorted(float(t) for t in rng.uniform(t0, run.t_end, 4)))
    problem = problem_of(case.oscillator, case.forcing)
    exact = simulate(problem, *case.start, t_end=run.t_end, at=at)
    ours, theirs = _events(run), sorted(exact.events, key=_order)
    until, fault = _compared(case, ours, theirs, run.t_end)
    if fault:
        return [f"seed {seed}: {fault}; {case}"]
    return [f"seed {seed}: {fault}; {case}" for fault in _states(run, exact, until)][:1]


def _events(run: pc.Trajectory) -> list[Seen]:
    rows = events_of(run)
    return sorted(
        Seen(float(t), RANKS.get(kind, 1), kind, stop, float(v)) for t, kind, stop, v in rows
    )


def _order(event: Event) -> tuple[float, int, str, int]:
    """Return what orders events as `Seen` does: those of one instant by their kind."""
    return event.t, RANKS.get(event.kind, 1), event.kind, event.stop


def _compared(
    case: Motion, ours: list[Seen], theirs: list[Event], t_end: float
) -> tuple[float, str]:
    """Return up to when all is the same within rounding, and what is not."""
    errors = Tolerances(*case.start[:2])
    j = 0
    for one in ours:
        if one.kind == "rest":
            # percuss sums the tail of a chatter, of which the oracle lists more.
            while j < len(theirs) and theirs[j].kind == "impact" and theirs[j].stop == one.stop:
                errors.pass_event(theirs[j])
                j += 1
        if errors.lost:
            return float(theirs[j - 1].t), ""
        if j == len(theirs) or (one.kind, one.stop) != (theirs[j].kind, theirs[j].stop):
            other = theirs[j] if j < len(theirs) else None
            return one.t, _unlike(one, other, errors, t_end)
        other = theirs[j]
        j += 1
        late, fast = errors.pass_event(other)
        if errors.lost:
            return min(one.t, float(other.t)) - 1e-3, ""
        late += 2.0 * EPS * abs(one.t)
        if one.kind == "rest":
            # The sum of the tail is good to 1e-10 of itself, which is below 1e-5.
            late += 1e-15
        if abs(one.t - float(other.t)) > late + _low(other):
            return one.t, f"{one} at {other.t} +- {late}"
        if abs(one.v - float(other.v_before)) > fast + 4.0 * EPS * abs(one.v):
            return one.t, f"{one}, not v = {other.v_before} +- {fast}"
    more = [e for e in theirs[j:] if float(e.t) < t_end - 1e-9]
    if (
        more
        and len(ours) < MOST
        and not (ours and ours[-1].kind == "impact" and more[0].kind == "impact")
    ):
        return t_end, _unlike(None, more[0], errors, t_end)
    return t_end, ""


def _low(other: Event) -> float:
    """Return what a float cannot tell of an instant."""
    return EPS * abs(float(other.t))


def _unlike(one: Seen | None, other: Event | None, errors: Tolerances, t_end: float) -> str:
    """Return how two events differ, nothing where rounding may have decided between them."""
    speeds = [abs(one.v)] if one is not None and one.kind not in ("rest", "release") else []
    speeds += [abs(float(other.v_before))] if other is not None else []
    # A dip of this depth, v^2 / 2a, is as deep as the errors there; so is an end at t_end.
    times = [float(event.t) for event in (one, other) if event is not None]
    if any(v * v <= 1e3 * (errors.gap + EPS) for v in speeds) or t_end - min(times) < 1e-9:
        return ""
    return f"{one}, not {other}"


def _states(run: pc.Trajectory, exact: Run, until: float) -> list[str]:
    found = []
    for t, (x, v) in exact.states.items():
        near = [e for e in exact.events if abs(float(e.t) - t) < 1e-6]
        tail = any(begin - 1e-3 < t < end for begin, end in exact.tails)
        if t >= until or near or tail:
            continue
        ours = run(t)
        # Twelve events or so multiply rounding by less than 1e6; what is lost is not compared.
        scale = 1.0 + abs(float(x)) + abs(float(v))
        if (
            abs(float(ours[0]) - float(x)) > 1e-9 * scale
            or abs(float(ours[1]) - float(v)) > 1e-7 * scale
        ):
            found.append(f"{ours} at {t}, not {x}, {v}")
    return found
