"""How far a search for orbits has come: told, stopped, bounded."""

from __future__ import annotations

import math

import pytest

import percuss as pc
from percuss.model.system import law
from percuss.orbits.finding import search_budget as module
from percuss.orbits.finding.search_budget import SearchBudget, swings_of

OSC = pc.impact_oscillator(0.7, wall=0.113, damping=0.05)
FORCE = pc.cosine(2.7)


def test_find_orbits_tells_of_each_start() -> None:
    reported: list[tuple[float, float]] = []

    def report(done: float, total: float) -> bool:
        reported.append((done, total))
        return True

    orbits = pc.find_orbits(OSC, FORCE, 2, 2, progress=report)

    total = reported[0][1]
    # It ends as soon as few orbits are estimated to be unseen.
    assert orbits.unseen_estimate < 0.25 or orbits.n_searches == total
    assert orbits.n_searches <= total
    assert reported == [(float(k + 1), total) for k in range(orbits.n_searches)]
    assert repr(orbits) == repr(pc.find_orbits(OSC, FORCE, 2, 2))


def test_find_orbits_stops_and_returns_what_is_found() -> None:
    reported: list[float] = []

    def report(done: float, _: float) -> bool:
        reported.append(done)
        return done < 3

    some = pc.find_orbits(OSC, FORCE, 3, 4, progress=report)

    assert reported == [1.0, 2.0, 3.0]
    # Those from closed forms come first.
    assert {1} <= {orbit.n_impacts for orbit in some}


def test_find_orbit_stops_with_the_best_or_says_that_it_was_stopped() -> None:
    with pytest.raises(pc.ConvergenceError, match="the search ended: stopped by progress"):
        pc.find_orbit(OSC, FORCE, 7, 3, progress=lambda *_: False)

    closed = pc.find_orbit(OSC, FORCE, progress=lambda *_: False)
    assert closed.n_impacts == 1


def test_a_line_appears_for_long_searches_only(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("percuss.progress.PATIENCE", -1.0)
    monkeypatch.setattr("percuss.progress.RENEWED_IN_A_LOG", 0.0)
    pc.find_orbits(OSC, FORCE, 1, 1, progress=True)
    # All of one impact come from the closed form.
    assert capsys.readouterr().err == ""

    pc.find_orbits(OSC, FORCE, 2, 1, progress=True)
    assert "206 of 806 starts done" in capsys.readouterr().err


@pytest.mark.parametrize("n_impacts", [1, 2, 0, math.inf])
def test_orbits_that_last_too_long_are_refused(n_impacts: float) -> None:
    with pytest.raises(pc.ParameterError, match="simulate follows longer motions") as error:
        pc.find_orbit(OSC, pc.cosine("1e-8"), n_impacts)
    assert "makes some 100,000,000 swings" in str(error.value)


def test_find_orbits_refuses_them_too() -> None:
    with pytest.raises(pc.ParameterError, match=r"max_periods = .*swings"):
        pc.find_orbits(OSC, FORCE, 3, 10**6)


@pytest.mark.parametrize("n_impacts", [100_001, 10**15])
def test_orbits_of_too_many_impacts_are_refused(n_impacts: int) -> None:
    reason = "_impacts = .*: orbits of up to 100,000 impacts are searched for"
    with pytest.raises(pc.ParameterError, match=f"n{reason}"):
        pc.find_orbit(OSC, FORCE, n_impacts)
    with pytest.raises(pc.ParameterError, match=f"max{reason}"):
        pc.find_orbits(OSC, FORCE, n_impacts, 1)


def test_a_search_that_takes_too_much_ends_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "ALL_SWINGS", 1e3)
    with pytest.raises(pc.ConvergenceError, match=r"it took as long as 1,000 swings"):
        pc.find_orbit(OSC, FORCE, 7, 3)
    # What is found until then stands.
    assert pc.find_orbits(OSC, FORCE, 3, 4)


def test_many_impacts_are_bounded_by_the_work_of_newtons_method() -> None:
    search_budget = SearchBudget(law(OSC, FORCE))
    for _ in range(100):
        search_budget.solved(3)
    assert search_budget.goes_on()
    search_budget.solved(600)
    assert not search_budget.goes_on()


def test_swings_are_those_of_the_softer_region_or_the_force() -> None:
    """A stiff stop turns the mass once, in no time."""
    stiff = pc.bilinear_oscillator(stiffness_below=1e12)
    assert swings_of(law(stiff, pc.cosine(0.1)), math.pi) == pytest.approx(1.0)
    assert swings_of(law(stiff, pc.cosine(5.0)), math.pi) == pytest.approx(2.5)
    # Without a spring in the gap it swings in the stops.
    free = pc.Oscillator(0, 0, (pc.SoftStop(1.0, "above", 9.0),))
    assert swings_of(law(free, pc.cosine(0.1)), math.pi) == pytest.approx(1.5)
