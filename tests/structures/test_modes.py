"""Motions of linear structures of every kind against the exponential of their matrices."""

from __future__ import annotations

import math
from collections import Counter

import numpy as np
import pytest
from tests.oracle.linear_structures import KINDS, LinearMotion, beam, linear_motion, rayleigh

import percuss as pc

INSTANTS = (0.01, 0.3, 2.0, 10.0)
# What is refused: two pairs of one shape, and free masses in a gyroscopic field.
REFUSED = {
    ("defective", "two pairs of modes coincide in one shape"),
    ("defective", "two pairs of modes coincide to five digits and more"),
    ("free gyroscopic masses", "masses that are free"),
}


def farthest(motion: LinearMotion) -> float:
    """Return by how much a motion is off, as a part of its largest values so far.

    A rate that is rounded once turns its mode by as much as it turns: that is taken off.
    """
    run = pc.simulate(motion.structure, x0=motion.x0, v0=motion.v0, t_end=INSTANTS[-1])
    sizes = [np.abs(motion.x0).max(), np.abs(motion.v0).max()]
    worst = 0.0
    for t in INSTANTS:
        for k, (ours, exact) in enumerate(zip(run(t), motion.exact(t), strict=True)):
            sizes[k] = max(sizes[k], np.abs(exact).max())
            worst = max(worst, float(np.abs(ours - exact).max() / sizes[k]))
    return worst / (1.0 + 0.01 * motion.quickest * INSTANTS[-1])


@pytest.mark.parametrize(
    "seeds", [range(20), pytest.param(range(2000), marks=pytest.mark.nightly)], ids=len
)
def test_linear_structures_of_every_kind_move_as_the_exponential_of_their_matrix(
    seeds: range,
) -> None:
    """A structure is computed, or refused in a sentence: no case loses digits unsaid.

    Nearly defective ones lose five digits at most.
    """
    wrong, refused, computed = [], Counter[tuple[str, str]](), Counter[str]()
    for seed in seeds:
        motion = linear_motion(seed)
        try:
            off = farthest(motion)
        except pc.ConvergenceError as error:
            refused[motion.kind, str(error).split(":")[0].split(",")[0]] += 1
            continue
        computed[motion.kind] += 1
        if not off < (2e-11 if motion.kind == "defective" else 2e-14):
            wrong.append((seed, motion.kind, off))

    assert wrong == []
    assert set(refused) <= REFUSED
    assert all(computed[kind] > 0 for kind in KINDS if kind not in dict(REFUSED))


# Two masses under a follower force, whose pairs of modes meet where it is this large.
FLUTTER = math.sqrt(1.25)


def follower(distance: float, damping: float) -> LinearMotion:
    p = FLUTTER * (1.0 + distance)
    stiffness = [[2.0, -1.0 + p], [-1.0 - p, 3.0]]
    structure = pc.Structure([1, 1], stiffness, [damping, damping])
    return LinearMotion("flutter", structure, np.array([1.0, 0.3]), np.array([-0.2, 0.5]))


@pytest.mark.parametrize("damping", [0.0, 0.01])
@pytest.mark.parametrize("side", [-1.0, 1.0])
def test_near_flutter_as_many_digits_are_lost_as_the_theory_says(
    side: float, damping: float
) -> None:
    """docs/theory/structures.md: the error is some 3e-16 over the root of the distance."""
    for distance in (1e-2, 1e-4, 1e-6, 1e-8, 1e-9):
        motion = follower(side * distance, damping)
        bound = 3e-15 / math.sqrt(distance)

        assert farthest(motion) < bound
        # An impact is off by as much: at its instant the free motion is at the wall.
        wall = pc.Wall("1.2" if side < 0 else "2", "above", on=0)
        own = motion.structure
        walled = pc.Structure(own.mass, own.stiffness, own.damping, [wall])
        run = pc.simulate(walled, x0=motion.x0, v0=motion.v0, t_end=100, max_impacts=1)
        t = float(run.impacts.t[0])
        x, v = motion.exact(t)
        assert abs(x[0] - float(run.structure.stops[0].at)) < bound * max(1.0, np.abs(v).max())


@pytest.mark.parametrize("distance", [-1e-11, 0.0, 1e-11])
def test_at_flutter_a_structure_is_refused_in_a_sentence(distance: float) -> None:
    motion = follower(distance, 0.01)

    with pytest.raises(
        pc.ConvergenceError, match=r"two pairs of modes coincide .*change the stiff"
    ):
        pc.simulate(motion.structure, x0=motion.x0, v0=motion.v0, t_end=1)


@pytest.mark.parametrize("damping", [0.0, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("gyroscopic", [0.3, 5.0])
def test_nearly_undamped_complex_pairs_lose_no_digits(gyroscopic: float, damping: float) -> None:
    coupling = [[damping, gyroscopic], [-gyroscopic, 2 * damping]]
    structure = pc.Structure([1, 1.5], [[2, -1], [-1, 3]], coupling)

    assert (
        farthest(LinearMotion("", structure, np.array([1.0, 0.3]), np.array([-0.2, 0.5]))) < 1e-14
    )


def test_a_clamped_beam_of_eight_elements_with_overdamped_modes() -> None:
    """C = M + K / 1000 damps the quick modes beyond critical: their real roots stand side by side."""
    mass, stiffness = beam(8)
    for damping in (rayleigh(mass, stiffness, 1.0, 1e-3), mass + 1e-3 * stiffness):
        rng = np.random.default_rng(3)
        structure = pc.Structure(mass, stiffness, damping)
        motion = LinearMotion("beam", structure, *rng.uniform(-1.0, 1.0, (2, 16)))

        assert farthest(motion) < 1e-15


def test_slow_modes_of_a_stiff_structure_keep_their_digits() -> None:
    """Springs of 1e8 between masses that hang on springs of 1: two frequencies of 1e4, one of 1."""
    springs = [[10**8 + 1, -(10**8), 0], [-(10**8), 2 * 10**8, -(10**8)], [0, -(10**8), 10**8 + 1]]
    structure = pc.Structure([1, 1, 1], springs)
    motion = LinearMotion("stiff", structure, np.ones(3), np.zeros(3))

    run = pc.simulate(structure, x0=motion.x0, v0=motion.v0, t_end=10)

    exact = motion.exact(10.0)
    np.testing.assert_allclose(run(10.0), exact, atol=1e-11)


@pytest.mark.parametrize("unit", [2.0**-30, 2.0**20, 2.0**30])
def test_modes_are_the_same_in_every_unit_of_time(unit: float) -> None:
    """Resonators of 1e9 rad/s and tides: a power of two of the unit changes no digit."""
    springs, dashpots = [4.5, 1.25, 0.75], [0.1, 0.03, 0.05]
    wall = pc.Wall(at="0.3", side="above", restitution="0.8", on=1)
    slow = pc.chain(masses=[1, 2], springs=springs, dashpots=dashpots, stops=[wall])
    fast = pc.chain(
        masses=[1, 2],
        springs=[k * unit * unit for k in springs],
        dashpots=[c * unit for c in dashpots],
        stops=[wall],
    )

    here = pc.simulate(slow, v0=[1, -0.5], t_end=20)
    there = pc.simulate(fast, v0=[unit, -0.5 * unit], t_end=20 / unit)

    assert len(here.impacts) >= 2
    np.testing.assert_array_equal(there.impacts.t * unit, here.impacts.t)
    np.testing.assert_array_equal(there(7 / unit)[0], here(7)[0])
    np.testing.assert_array_equal(there(7 / unit)[1] / unit, here(7)[1])
