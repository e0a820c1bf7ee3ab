"""The error bound of a contact against a motion that is followed to 39 digits."""

from __future__ import annotations

import math
import pickle
from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from tests.kernels.uncompiled import python_of
from tests.oracle.event_driven import simulate as simulate_in_digits
from tests.oracle.from_model import problem_of
from tests.oracle.random_problems import (
    Motion,
    chattering_motion,
    random_motion,
    with_record,
    with_tables,
)
from tests.oracle.taylor_series import simulate

import percuss as pc
from percuss.kernels import error_bounds
from percuss.motion import error_bounds as bounds_of_a_run

DURATION = 20.0


def chattering_on_tables(seed: int) -> Motion:
    """Return a chattering motion with restitutions over the speed."""
    return with_tables(chattering_motion(seed), seed)


def excited_and_chattering(seed: int) -> Motion:
    """Return a chattering motion with negative damping."""
    case = chattering_motion(seed)
    osc = case.oscillator
    fed = pc.Oscillator(osc.stiffness, -0.05 - 0.2 * float(osc.damping), osc.stops)
    return Motion(fed, case.forcing, case.start)


def chattering_under_a_record(seed: int) -> Motion:
    """Return a chattering motion with a record added to its force, on tables for each third."""
    case = with_record(chattering_motion(seed), seed)
    return with_tables(case, seed) if seed % 3 == 0 else case


class BoundsBesideErrors:
    """The bounds of contacts of many motions beside their true errors."""

    def __init__(self) -> None:
        self._wrong: list[tuple[int, int, float, float]] = []
        self._ratios: list[float] = []
        self._open = 0

    def compare(self, seed: int, run: pc.Trajectory, starts: Sequence[Any]) -> None:
        """Note the contacts of a run whose exact starts are these."""
        for i, bound in enumerate(run.contacts.error_bound):
            if bound == math.inf:
                self._open += 1
                continue
            with mpmath.workdps(60):
                start = mpmath.mpf(float(run.contacts.start[i]))
                error = float(abs(starts[i] - start)) if i < len(starts) else math.inf
            if not error <= bound:
                self._wrong.append((seed, i, error, bound))
            if error > 0.0:
                self._ratios.append(bound / error)

    def check(self, n_motions: int, open_part: float) -> None:
        """Check that none is too small, few are infinite, and most are not absurdly large."""
        assert self._wrong == []
        assert len(self._ratios) > n_motions / 4
        assert self._open <= open_part * len(self._ratios)
        assert np.median(self._ratios) < 1000.0


@pytest.mark.parametrize(
    "seeds",
    # The second motion takes as long as all of the others.
    [range(2, 10), pytest.param((0, 1, *range(10, 2_000)), marks=pytest.mark.nightly)],
    ids=len,
)
def test_the_bound_of_a_contact_behind_knots_holds(seeds: Sequence[int]) -> None:
    """Against the closed forms of 40 digits; most bounds are finite, also behind knots."""
    bounds = BoundsBesideErrors()
    for seed in seeds:
        case = chattering_under_a_record(seed)
        end = case.start[2] + 6.0
        run = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=end, max_impacts=60)
        if len(run.contacts) == 0:
            continue
        exact = simulate_in_digits(
            problem_of(case.oscillator, case.forcing), *case.start, t_end=run.t_end + 1e-6
        )
        bounds.compare(seed, run, exact.contacts.start)

    bounds.check(len(seeds), open_part=0.3)


@pytest.mark.parametrize(
    "seeds", [range(16), pytest.param(range(16, 5_000), marks=pytest.mark.nightly)], ids=len
)
@pytest.mark.parametrize(
    "kind", [chattering_motion, random_motion, chattering_on_tables, excited_and_chattering]
)
def test_start_of_a_contact_is_never_farther_off_than_its_bound(kind: type, seeds: range) -> None:
    """Nor is the bound absurdly large: in the median of all it is some hundred times the error."""
    bounds = BoundsBesideErrors()
    for seed in seeds:
        case = kind(seed)
        end = case.start[2] + DURATION
        run = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=end, max_impacts=400)
        if len(run.contacts) == 0:
            continue
        problem = problem_of(case.oscillator, case.forcing)
        exact = simulate(problem, *case.start, t_end=run.t_end + 1e-6)
        starts = [event.t for event in exact.events if event.kind == "rest"]
        bounds.compare(seed, run, starts)

    bounds.check(len(seeds), open_part=0.05)


def test_bound_holds_rounding_of_what_came_before_the_chatter() -> None:
    """The tail alone is summed to 1e-20, but the impacts before it have been rounded."""
    run = pc.simulate(pc.impact_oscillator(0.8), pc.cosine(3.0, constant=-1.2), 0.0, 1.0, t_end=40)

    assert len(run.contacts) == 1
    assert 1e-14 < run.contacts.error_bound[0] < 1e-8


def test_numbers_that_are_no_floats_are_part_of_the_bound() -> None:
    force = pc.cosine(3.0, constant=-1.2)
    bounds = [
        pc.simulate(pc.impact_oscillator(0.0), force, x0, v0, t0, t_end=9).contacts.error_bound[0]
        for x0, v0, t0 in ((0.1, 0.3, 0.7), ("0.1", 0.3, 0.7), (0.1, "0.3", 0.7), (0.1, 0.3, "0.7"))
    ]

    assert max(bounds[1:]) < 1.1 * bounds[0]
    assert all(bound > bounds[0] for bound in bounds[1:])


def test_contact_after_a_release_knows_nothing_of_what_was_before() -> None:
    run = pc.simulate(pc.impact_oscillator(0.3), pc.cosine(1.0, constant=-0.3), 0.5, 0.0, t_end=300)

    assert len(run.contacts) > 20
    np.testing.assert_allclose(run.contacts.error_bound[10:], run.contacts.error_bound[10], rtol=1)


def test_contact_from_the_start_has_the_rounding_of_its_time_alone() -> None:
    osc, force = pc.impact_oscillator(0.5), pc.cosine(1.0, constant=-2.0)

    exact = pc.simulate(osc, force, 0.0, 0.0, 0.25, t_end=9.0)
    rounded = pc.simulate(osc, force, 0.0, 0.0, "1/3", t_end=9.0)

    assert exact.contacts.error_bound.tolist() == [0.0]
    assert 0.0 < rounded.contacts.error_bound[0] < 1e-16


@pytest.mark.parametrize("depth", [0.0, 1e-16, 1e-14])
def test_nothing_is_said_after_a_graze(depth: float) -> None:
    """x = cos t turns at the wall at pi; what is pressed to it later may not come so at all."""
    walls = (pc.Wall(-1.0 + depth, "below", 0.5), pc.Wall(1.0, "above", 0.0))
    push = pc.cosine("0.25", amplitude=1e-20)
    run = pc.simulate(pc.Oscillator(1.0, 0.0, walls), push, 1.0, 0.0, t_end=30.0)

    assert all(bound == math.inf or bound < 1e-15 for bound in run.contacts.error_bound)


def test_bound_is_computed_when_asked_for_and_once(monkeypatch: pytest.MonkeyPatch) -> None:
    run = pc.simulate(pc.impact_oscillator(0.8), pc.cosine(3.0, constant=-1.2), 0.0, 1.0, t_end=40)
    twin = pickle.loads(pickle.dumps(run))
    calls = []
    kernel = error_bounds.contact_errors

    def counted(*arguments: object) -> None:
        calls.append(1)
        kernel(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(bounds_of_a_run, "contact_errors", counted)
    assert run.contacts.start.tolist() == twin.contacts.start.tolist()
    assert calls == []
    assert run.contacts.error_bound[0] == run.contacts.error_bound[0]
    assert calls == [1]
    assert twin.contacts.error_bound.tolist() == run.contacts.error_bound.tolist()
    assert run.contacts.to_xarray().error_bound.values.tolist() == run.contacts.error_bound.tolist()


def test_plain_python_gives_the_bounds_of_the_compiled_kernel(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    case = (pc.impact_oscillator(0.05), pc.cosine(3.0, constant=-1.2), 0.1, 0.3)
    compiled = pc.simulate(*case, t_end=8).contacts.error_bound
    for name, value in vars(error_bounds).items():
        if callable(value) and hasattr(value, "py_func"):
            monkeypatch.setattr(error_bounds, name, python_of(value))
    monkeypatch.setattr(bounds_of_a_run, "contact_errors", error_bounds.contact_errors)

    plain = pc.simulate(*case, t_end=8).contacts.error_bound

    assert len(plain) > 0
    np.testing.assert_allclose(plain, compiled, rtol=1e-9)


@pytest.mark.parametrize("restitution", ["0.9", "0.99", "0.999"])
def test_thousands_of_hops_do_not_inflate_the_bound(restitution: str) -> None:
    """Of hops under a constant force all is known: they end at 2 v / (1 - r)."""
    osc = pc.Oscillator(0.0, 0.0, (pc.Wall(0.0, "below", restitution),))
    run = pc.simulate(osc, pc.Forcing(constant=-1.0), 0.0, 1.0, max_impacts=30_000)

    end = 2 / (1 - Fraction(restitution))
    error = abs(Fraction(float(run.contacts.start[0])) - end)
    n = len(run.impacts)
    # Each hop may round by some 1e-14 of the rest of the chatter, at worst all the same way.
    assert error <= run.contacts.error_bound[0] < 1e-13 * n * end
