"""How many orbits a search has not seen: estimated, told, and paid for by effort."""

from __future__ import annotations

import math
import pickle

import pytest

import percuss as pc
from percuss.model.system import System
from percuss.orbits.finding.found import FoundOrbits, estimate_unseen
from percuss.orbits.finding.settled import settled_motions

OSC = pc.impact_oscillator("0.8", side="above")
FORCE = pc.cosine("2.66")


@pytest.mark.parametrize(
    ("counts", "low", "high"),
    [
        ((), 0.0, 0.0),
        # All were seen often: none is left.
        ((60, 45, 200), 0.0, 1e-9),
        # One seen once says that there may be another one.
        ((1, 50), 1.0, 2.0),
        ((1, 1, 1, 2), 4.5, 5.5),
        ((3, 4, 100), 0.4, 0.6),
    ],
)
def test_what_is_seen_seldom_tells_of_what_is_unseen(
    counts: tuple[int, ...], low: float, high: float
) -> None:
    assert low <= estimate_unseen(counts) <= high


def test_a_search_tells_its_starts_and_its_estimate() -> None:
    orbits = pc.find_orbits(OSC, FORCE, 3, 3)

    assert isinstance(orbits, list)
    assert orbits.n_searches >= 200
    assert f"{len(orbits)} periodic orbits from {orbits.n_searches:,} starts" in repr(orbits)
    assert "unseen" in repr(orbits)
    again = pickle.loads(pickle.dumps(orbits))
    assert (again.unseen_estimate, again.n_searches) == (orbits.unseen_estimate, orbits.n_searches)
    assert len(again) == len(orbits)


def test_closed_forms_leave_nothing_unseen() -> None:
    orbits = pc.find_orbits(OSC, FORCE, 1, 2)

    assert (orbits.unseen_estimate, orbits.n_searches) == (0.0, 0)
    assert orbits.completeness().endswith("from closed forms")


def test_effort_multiplies_the_starts() -> None:
    little = pc.find_orbits(OSC, FORCE, 3, 3, effort=0.2)
    much = pc.find_orbits(OSC, FORCE, 3, 3, effort=2)

    assert little.n_searches < 200
    assert much.n_searches >= 400
    assert len(little) <= len(much)
    for effort in (0, 1000, float("nan")):
        with pytest.raises(pc.ParameterError, match="effort"):
            pc.find_orbits(OSC, FORCE, 3, 3, effort=effort)


def test_a_search_that_is_cut_short_has_no_estimate() -> None:
    orbits = pc.find_orbits(OSC, FORCE, 3, 3, progress=lambda done, _: done < 5)

    assert isinstance(orbits, FoundOrbits)
    assert orbits.n_searches == 5
    assert math.isnan(orbits.unseen_estimate)
    assert "unseen" not in repr(orbits)


def test_an_estimate_of_almost_nothing_is_told_as_such() -> None:
    assert (
        FoundOrbits([], 2.4e-12, 206)
        .completeness()
        .endswith("from 206 starts; fewer than 0.01 more are estimated to be unseen")
    )
    assert "some 0.25 more" in FoundOrbits([], 0.25, 206).completeness()


def test_a_motion_that_spirals_in_slowly_is_on_its_orbit() -> None:
    """Its latest stretches are not those that close best: it was an attractor without a period."""
    stop = pc.SoftStop(-0.43826707498358897, "above", 92.96464178382809)
    osc = pc.Oscillator(2.5795219881846956, 0.0031017514183549902, (stop,))
    force = pc.cosine(3.3622598363260496, amplitude=1.1502308137948698)
    found = settled_motions(System(osc, force), 4, 3, n_starts=6, seed=1)
    assert [(motion.n_impacts, motion.n_periods) for motion in found] == [(1, 1)]
