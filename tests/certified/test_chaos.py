"""Chaos, proven: what covering relations say, and what the float engine says of the same sets."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from flint import arb

import percuss as pc
from percuss.arrays import Floats
from percuss.certified import CertifiedChaos, prove_chaos
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.covering import (
    HSet,
    ImpactSurface,
    are_disjoint,
    covering,
    image_of,
)
from percuss.certified.numbers import precision
from percuss.certified.shooting import events_of
from percuss.certified.system import system_of

OSC, FORCE = pc.impact_oscillator("4/5"), pc.cosine("14/5")
PERIOD = 2.0 * math.pi / 2.8
CORNERS = [(u, s) for u in (-1.0, 1.0) for s in np.linspace(-1.0, 1.0, 7)]


@pytest.fixture(scope="module")
def chaos() -> CertifiedChaos:
    return prove_chaos(OSC, FORCE)


@pytest.fixture(scope="module")
def surface(chaos: CertifiedChaos) -> ImpactSurface:
    system = system_of(OSC, FORCE)
    return ImpactSurface(system, events_of(system, chaos.orbit)[0])


def coordinates(hset: HSet, t: Floats, v: Floats) -> Floats:
    """Return floats of the coordinates of states in a set, whole periods removed."""
    t = (t - hset.center[0] + 0.5 * PERIOD) % PERIOD - 0.5 * PERIOD
    axes = np.array([hset.unstable, hset.stable]).T
    return np.linalg.solve(axes, np.array([t, v - hset.center[1]])).T


def points(hset: HSet, places: Floats) -> tuple[Floats, Floats]:
    """Return instants and velocities at coordinates in a set."""
    axes = np.array([hset.unstable, hset.stable]).T
    t, v = np.array(hset.center)[:, None] + axes @ places.T
    return t, v


def test_chaos_is_proven_from_nothing_with_three_loops(chaos: CertifiedChaos) -> None:
    assert chaos
    assert chaos.loops[0] == (0,)
    lengths = [len(loop) for loop in chaos.loops]
    # 0.1437 is the entropy of loops of 1 and 14 impacts, the first that was proven here.
    assert chaos.entropy.mid() > 0.1437
    root = math.exp(chaos.entropy.mid())
    assert sum(root**-n for n in lengths) == pytest.approx(1.0, abs=1e-12)
    assert chaos.entropy.radius() < 1e-15
    assert "topological entropy" in repr(chaos)
    for (i, j), cover in zip(chaos.transitions, chaos.coverings, strict=True):
        assert cover.beyond > 1.0, (i, j)
        assert cover.within < 1.0, (i, j)


def test_the_entropy_of_loops_of_1_and_14_impacts() -> None:
    low, high = Fraction(1), Fraction(2)
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if middle**-1 + middle**-14 > 1 else (low, middle)
    assert math.log(low) == pytest.approx(0.1436617, abs=1e-7)


def test_motions_cross_the_sets_as_is_proven(chaos: CertifiedChaos) -> None:
    """The independent way: the float map of points on the unstable sides and inside."""
    step = pc.impact_map(OSC, FORCE)
    rng = np.random.default_rng(7)
    inside = rng.uniform(-1.0, 1.0, (40, 2))
    for (i, j), cover in zip(chaos.transitions, chaos.coverings, strict=True):
        if i == 0 and j != 0:
            continue  # a part of set 0 covers the first set of a loop
        places = np.concatenate([np.array(CORNERS), inside])
        t, v = points(chaos.sets[i], places)
        cycle, after = step(t / PERIOD % 1.0, v)
        u, s = coordinates(chaos.sets[j], cycle * PERIOD, after).T
        assert np.abs(s).max() < cover.within + 1e-9
        ends = u[: len(CORNERS)] * places[: len(CORNERS), 0] * cover.sign
        assert ends.min() > cover.beyond - 1e-9, (i, j)


def test_a_part_of_the_first_set_covers_the_first_set_of_each_loop(chaos: CertifiedChaos) -> None:
    step = pc.impact_map(OSC, FORCE)
    for loop in chaos.loops[1:]:
        places = np.stack([np.linspace(-1.0, 1.0, 4_001), np.zeros(4_001)], axis=1)
        cycle, after = step(
            *(w / f for w, f in zip(points(chaos.sets[0], places), (PERIOD, 1.0), strict=True))
        )
        u, s = coordinates(chaos.sets[loop[1]], cycle * PERIOD, after).T
        crosses = np.abs(u) < 1.0
        assert crosses.any()
        assert np.abs(s[crosses]).max() < 1.0


def test_sets_are_disjoint_and_a_set_is_not_disjoint_from_itself(
    chaos: CertifiedChaos, surface: ImpactSurface
) -> None:
    with precision(96):
        first = chaos.sets[0]
        assert not are_disjoint(surface, first, first)
        # A whole period later it is the same set.
        (t, v), unstable, stable = first
        assert not are_disjoint(surface, first, HSet((t + PERIOD, v), unstable, stable))
        # Nothing is said of sets longer than a period, or so far apart that other shifts count.
        assert not are_disjoint(surface, first, HSet((t + 2 * PERIOD, v), unstable, stable))
        assert not are_disjoint(surface, first, HSet((t, v + 9.0), (PERIOD, 0.0), stable))
        assert all(
            are_disjoint(surface, a, b) for i, a in enumerate(chaos.sets) for b in chaos.sets[:i]
        )


def test_nothing_is_claimed_of_sets_that_do_not_cover(
    chaos: CertifiedChaos, surface: ImpactSurface
) -> None:
    first = chaos.sets[0]
    with precision(96):
        image = image_of(surface, first)
        assert covering(surface, image, first, first).sign == -1
        wide = [4.0 * x for x in first.unstable]
        thin = [0.1 * x for x in first.stable]
        for other in (
            first._replace(unstable=(wide[0], wide[1])),
            first._replace(stable=(thin[0], thin[1])),
            first._replace(center=(first.center[0] + 0.5 * PERIOD, first.center[1])),
            chaos.sets[3],
        ):
            with pytest.raises(Undecided, match="not proven to cover another"):
                covering(surface, image, first, other)


def test_a_set_through_which_a_graze_passes_is_undecided(surface: ImpactSurface) -> None:
    # From the wall without velocity: some states of the set leave it at once, others do not.
    hset = HSet((0.3, 0.0), (0.2, 0.0), (0.0, 0.05))
    with precision(96), pytest.raises(Undecided):
        image_of(surface, hset)


@pytest.mark.parametrize("itinerary", [[0], [1], [0, 1], [2, 0, 0, 1]])
def test_a_periodic_orbit_follows_each_order_of_loops(
    chaos: CertifiedChaos, itinerary: list[int]
) -> None:
    orbit = chaos.periodic_orbit(itinerary)

    assert orbit.exists
    assert orbit.admissible is True
    assert orbit.stability == "unstable"
    assert orbit.n_impacts == sum(len(chaos.loops[number]) for number in itinerary)


def test_periodic_orbits_of_loops_that_are_not_there_are_refused(chaos: CertifiedChaos) -> None:
    for itinerary in ([], [9], [0, 17]):
        with pytest.raises(pc.ParameterError, match="numbers of loops are 0 to 2"):
            chaos.periodic_orbit(itinerary)


def test_a_stable_orbit_and_one_of_another_system_are_refused() -> None:
    damped = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    stable = pc.find_orbit(damped, pc.cosine(1))
    with pytest.raises(pc.ParameterError, match="no saddle: its multipliers have moduli"):
        prove_chaos(damped, pc.cosine(1), saddle=stable)
    with pytest.raises(pc.ParameterError, match="of another oscillator or forcing"):
        prove_chaos(OSC, FORCE, saddle=stable)


def test_what_is_no_orbit_is_no_saddle() -> None:
    orbit = pc.find_orbit(OSC, FORCE)
    for other in (5, pc.simulate(OSC, FORCE, v0=1, max_impacts=3), pc.certify(orbit), [orbit]):
        with pytest.raises(pc.ParameterError, match="not a periodic orbit of find_orbit"):
            prove_chaos(OSC, FORCE, saddle=other)  # type: ignore[arg-type]


def test_a_stop_is_given_by_a_whole_number(chaos: CertifiedChaos) -> None:
    for stop in (0.5, math.nan, True, "wall", -1):
        with pytest.raises(pc.ParameterError, match="not a whole number of at least 0"):
            prove_chaos(OSC, FORCE, saddle=chaos.orbit, stop=stop)  # type: ignore[arg-type]
    with pytest.raises(pc.ParameterError, match="the orbit does not meet it"):
        prove_chaos(OSC, FORCE, saddle=chaos.orbit, stop=5)
    # As all whole numbers are taken.
    found = prove_chaos(OSC, FORCE, saddle=chaos.orbit, stop=0.0, most_orbits=1)  # type: ignore[arg-type]
    assert type(found.stop) is int


def test_where_there_is_no_saddle_it_says_so() -> None:
    with pytest.raises(pc.ParameterError, match="no saddle with one impact a period was found"):
        prove_chaos(OSC, pc.cosine("2.6"))


def test_no_homoclinic_orbit_is_no_chaos_and_no_error() -> None:
    # Below the homoclinic tangency of Shaw & Rand (1989), next to the doubling the saddle is alone.
    orbit = pc.find_orbit(OSC, pc.cosine("2.66"))
    chaos = prove_chaos(OSC, pc.cosine("2.66"), saddle=orbit)

    assert not chaos
    assert chaos.reason == "no homoclinic orbit of the saddle was found"
    assert repr(chaos) == "<CertifiedChaos: open: no homoclinic orbit of the saddle was found>"
    with pytest.raises(pc.ParameterError, match="no homoclinic orbit"):
        chaos.periodic_orbit([0])


def test_a_larger_box_encloses_the_derivatives_at_its_corners(
    chaos: CertifiedChaos, surface: ImpactSurface
) -> None:
    step = pc.impact_map(OSC, FORCE)
    first = chaos.sets[0]
    with precision(96):
        derivative = image_of(surface, first).derivative
    for u, s in CORNERS:
        t, v = points(first, np.array([[u, s]]))
        jacobian = step.jacobian(float(t[0] / PERIOD % 1.0), float(v[0]))
        # Of (cycle, v); that of (t, v) has the period in it.
        scaled = jacobian * np.array([[1.0, PERIOD], [1.0 / PERIOD, 1.0]])
        for row, wanted in zip(derivative, scaled, strict=True):
            for ball, value in zip(row, wanted, strict=True):
                assert (ball + arb(0, 1e-9)).contains(float(value))


def test_the_saddle_at_which_chaos_is_proven_is_reported_too() -> None:
    told: list[tuple[float, float]] = []

    def report(done: float, total: float) -> bool:
        told.append((done, total))
        return True

    proven = prove_chaos(OSC, FORCE, most_orbits=1, progress=report)

    assert bool(proven)
    assert told[0][0] == 1.0
