"""Motions of structures against the reference of 40 digits."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable

import numpy as np
import pytest
from tests.oracle.events_of import SLOW, events_of
from tests.oracle.random_structures import StructureMotion, near_graze, random_structure
from tests.oracle.structures import StructureRun, simulate_structure, structure_problem

import percuss as pc
from percuss.motion.structures import StructureTrajectory

# Impacts and soft stops multiply rounding by less than 1e4 in the time and cases chosen.
INSTANT = 1e-11
Times = dict[tuple[str, int], list[float]]


def flown(motion: StructureMotion) -> tuple[StructureTrajectory, StructureRun]:
    run = pc.simulate(
        motion.structure, motion.loads, x0=motion.x0, v0=motion.v0, t0=motion.t0,
        t_end=motion.t_end,
    )  # fmt: skip
    problem = structure_problem(motion.structure, motion.loads)
    exact = simulate_structure(problem, motion.x0, motion.v0, motion.t0, t_end=motion.t_end)
    return run, exact


def times_of(run: StructureTrajectory) -> Times:
    """Return the instants of the events by kind and stop."""
    rows = ((told.kind, told.stop, float(told.t)) for told in events_of(run, slowest=SLOW))
    return grouped(rows, run.t0, run.t_end)


def exact_times(run: StructureRun, motion: StructureMotion) -> Times:
    rows = (
        (event.kind, event.stop, float(event.t))
        for event in run.events
        if event.kind != "impact" or abs(event.v_before) > SLOW
    )
    return grouped(rows, motion.t0, motion.t_end)


def grouped(rows: Iterable[tuple[str, int, float]], t0: float, t_end: float) -> Times:
    found: Times = defaultdict(list)
    for kind, stop, t in rows:
        if t0 + 1e-9 < t < t_end - 1e-9:
            found[kind, stop].append(t)
    return {key: sorted(times) for key, times in found.items()}


def differences(
    motion: StructureMotion,
    instant: float = INSTANT,
    runs: tuple[StructureTrajectory, StructureRun] | None = None,
) -> list[str]:
    run, exact = runs or flown(motion)
    ours, theirs = times_of(run), exact_times(exact, motion)
    assert exact.doubts == []
    found = []
    for key in sorted({*ours, *theirs}):
        one, other = ours.get(key, []), theirs.get(key, [])
        if len(one) != len(other):
            found.append(f"{key}: {len(one)} events, not {len(other)}")
        elif one and np.abs(np.subtract(one, other)).max() > instant:
            found.append(f"{key}: off by {np.abs(np.subtract(one, other)).max():.2g}")
    events = [t for times in theirs.values() for t in times]
    for t in np.linspace(motion.t0, motion.t_end, 17).tolist():
        if all(abs(t - event) > 1e-6 for event in events):
            for ours_at, theirs_at in zip(run(t), exact(t), strict=True):
                far = np.abs(ours_at - np.array([float(entry) for entry in theirs_at])).max()
                if far > instant:
                    found.append(f"t = {t}: off by {far:.2g}")
    return found


def chatters_at_two_walls(run: StructureRun) -> bool:
    """Return whether hops were listed down to where a motion counts as at rest."""
    return any(event.kind == "impact" and 0 < abs(event.v_before) < 1e-25 for event in run.events)


# One motion in thirty has hops at two walls at once, which have a test of their own.
@pytest.mark.parametrize(
    "seeds", [range(0, 31, 6), pytest.param(range(300), marks=pytest.mark.nightly)], ids=len
)
def test_events_and_motions_of_2_to_10_masses_are_those_of_the_oracle(seeds: range) -> None:
    found, compared = [], 0
    for seed in seeds:
        motion = random_structure(seed)
        runs = flown(motion)
        if not chatters_at_two_walls(runs[1]):
            found += [(seed, fault) for fault in differences(motion, runs=runs)]
            compared += 1

    assert found == []
    assert compared > 0.95 * len(seeds)


@pytest.mark.parametrize("seed", [53, pytest.param(79, marks=pytest.mark.nightly)])
def test_hops_at_two_walls_at_once_end_where_those_of_the_oracle_end(seed: int) -> None:
    motion = random_structure(seed)
    runs = flown(motion)

    assert chatters_at_two_walls(runs[1])
    assert differences(motion, runs=runs) == []


@pytest.mark.parametrize(
    "seeds", [range(60), pytest.param(range(10_000), marks=pytest.mark.nightly)], ids=len
)
def test_a_wall_is_hit_or_missed_as_40_digits_say(seeds: range) -> None:
    """Depths of 1e-13 to 1e-6 of the amplitude; places are right to 1e-14 of it."""
    wrong, far = [], []
    for seed in seeds:
        case = near_graze(seed)
        run = pc.simulate(case.structure, case.loads, x0=case.x0, v0=case.v0, t_end=case.t_end)
        if (len(run.impacts) > 0) != case.hits:
            wrong.append((seed, float(case.depth) / case.amplitude))
        elif case.hits:
            late = float(abs(float(run.impacts.t[0]) - case.t))
            far.append(late * abs(float(run.impacts.v_before[0])) / case.amplitude)

    assert wrong == []
    assert max(far) < 1e-14


def test_energy_is_lost_at_impacts_alone() -> None:
    """Each takes (1 - r^2) / 2 of the effective mass times the square of the speed."""
    stops: list[pc.Wall | pc.SoftStop] = [
        pc.Wall("0.3", "above", "0.9", on=0),
        pc.Wall("-0.2", "below", 1, on=(0, 1, -1)),
        pc.SoftStop("0.25", "above", 40, on=2),
    ]
    structure = pc.chain([1, 2, "0.5"], [1, 3, 2, "0.5"], stops=stops)

    run = pc.simulate(structure, x0=[0, 0, 0], v0=[1, -1, 2], t_end=60)

    impacts = run.impacts
    ratio = np.where(impacts.stop == 0, 0.9, 1.0)
    mass = np.where(impacts.stop == 0, 1.0, 1.0 / (1 / 2 + 1 / 0.5))
    lost = 0.5 * (1.0 - ratio**2) * mass * impacts.v_before**2
    first, last = run.energy(np.array([0.0, 60.0])).tolist()
    assert len(impacts) > 50
    assert len(run.crossings) > 10
    assert abs(first - last - lost.sum()) < 1e-12 * first


def test_the_published_motion_closes_after_a_period() -> None:
    """NLvib's example 03 at w = 0.6, from the state that the oracle has found."""
    stop = pc.SoftStop(1, "above", 100, on=0)
    chain = pc.chain([1, 1], [0, 1, 1], [0, "0.03", "0.03"], [stop])
    loads = {1: pc.cosine("0.6", amplitude="0.1")}
    z = [0.98207585036983273242, 0.64100630632957019968,
         0.16872526368408097126, 0.060233071681055006043]  # fmt: skip

    run = pc.simulate(chain, loads, x0=z[:2], v0=z[2:], periods=1)

    np.testing.assert_allclose(np.concatenate(run(run.t_end)), z, atol=1e-14)
    np.testing.assert_allclose(run.crossings.t, [0.121462407, 0.380362607], atol=1e-9)


def test_a_start_is_given_at_once_or_in_parts() -> None:
    pair = pc.impact_pair([1, 2], "0.5", "0.8")

    whole = pc.simulate(pair, start=pc.StructureStart((0, 0), (1, 0)), t_end=9)
    parts = pc.simulate(pair, v0=[1, 0], t_end=9)

    assert len(parts.impacts) > 3
    assert whole.impacts.t.tolist() == parts.impacts.t.tolist()
    with pytest.raises(pc.ParameterError, match="given together with start"):
        pc.simulate(pair, v0=[1, 0], start=pc.StructureStart((0, 0), (1, 0)), t_end=9)


def test_an_impact_elsewhere_is_no_new_contact_and_no_release() -> None:
    """Two masses without a spring between them: one is pressed to its wall, the other one hops."""
    stops = [pc.Wall(0, "below", 0, on=0), pc.Wall(0, "below", "0.9", on=1)]
    structure = pc.Structure([1, 1], [0, 0], stops=stops)
    weight = pc.Loads({(1, 1): pc.Forcing(constant=-1)})

    run = pc.simulate(structure, weight, x0=[0, 1], v0=[0, 0], t_end=10)

    assert len(run.impacts) > 2
    assert run.contacts.stop.tolist() == [0]
    assert run.contacts.start.tolist() == [0.0]
    assert np.isnan(run.contacts.release).all()
    # Impacts at one instant: the second wall is hit when the first is touched.
    both = pc.simulate(structure, weight, x0=[1, 1], v0=[0, 0], t_end=4)
    assert both.impacts.t[:2].tolist() == [both.impacts.t[0]] * 2
    assert both.impacts.stop[:2].tolist() == [0, 1]
    assert both.contacts.stop.tolist() == [0]
    assert both.contacts.start[0] == pytest.approx(2**0.5, abs=1e-14)


def test_free_masses_coupled_by_velocities_alone_are_refused_in_a_sentence() -> None:
    # Two constants of the motion are two roots 0 that do not drift; a pair of them would.
    structure = pc.Structure([1, 1], [0, 0], [[0, "0.7"], ["-0.7", 0]])

    with pytest.raises(pc.ConvergenceError, match="give each a weak spring to the ground"):
        pc.simulate(structure, x0=[0, 0], v0=[1, 0], t_end=1)


@pytest.mark.parametrize("spring", ["1e-3", "1e-6"])
def test_weak_springs_hold_masses_that_gyroscopic_terms_couple(spring: str) -> None:
    structure = pc.Structure(
        [1, 1], [spring, spring], [[0, "0.7"], ["-0.7", 0]],
        stops=[pc.Wall("0.5", "above", "0.8", on=0), pc.SoftStop("-0.6", "below", 50, on=1)],
    )  # fmt: skip
    loads = pc.Loads({1: pc.cosine(2, amplitude=1)})
    motion = StructureMotion("weak springs", structure, loads, (0.1, -0.2), (1.0, 0.5), 0.0, 8.0)

    assert differences(motion) == []


def test_a_body_that_drifts_freely_between_gyroscopic_masses_keeps_its_double_root() -> None:
    # Springs between three masses, none to the ground, and damping that no mode shares.
    springs = [[1, -1, 0], [-1, 2, -1], [0, -1, 1]]
    damping = [["0.2", "-0.1", "-0.1"], ["-0.3", "0.3", 0], ["0.1", "-0.2", "0.1"]]
    structure = pc.Structure([1, 1, 1], springs, damping, stops=[pc.Wall(1, "above", "0.7", on=2)])
    motion = StructureMotion(
        "free body", structure, pc.Loads({0: pc.cosine(1, "0.2")}), (0.0, 0.1, 0.0),
        (0.5, 0.2, 0.4), 0.0, 8.0,
    )  # fmt: skip

    assert differences(motion) == []
