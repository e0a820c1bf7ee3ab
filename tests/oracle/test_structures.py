"""The oracle of structures against closed forms, other ways, energy and published parameters."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from scipy.integrate import solve_ivp
from tests.oracle import event_driven
from tests.oracle.events_of import SLOW, events_of
from tests.oracle.from_model import problem_of
from tests.oracle.random_problems import Motion, chattering_motion, random_motion, with_record
from tests.oracle.random_structures import KINDS, StructureMotion, near_graze, random_structure
from tests.oracle.structures import (
    StructureEvent,
    StructureProblem,
    StructureRun,
    closed_orbit,
    simulate_structure,
    solved,
    structure_problem,
)

import percuss as pc
from percuss.arrays import Floats


def flown(motion: StructureMotion) -> StructureRun:
    problem = structure_problem(motion.structure, motion.loads)
    return simulate_structure(problem, motion.x0, motion.v0, motion.t0, t_end=motion.t_end)


def of_mass_one(osc: pc.Oscillator) -> pc.Structure:
    """Return the structure of one coordinate whose dashpots are coefficients, twice a."""
    stops = [
        stop
        if isinstance(stop, pc.Wall)
        else pc.SoftStop(stop.at, stop.side, stop.stiffness, 2 * float(stop.damping))
        for stop in osc.stops
    ]
    return pc.Structure(1, osc.stiffness, 2 * float(osc.damping), stops)


def recorded(seed: int) -> Motion:
    return with_record(random_motion(seed), seed)


@pytest.mark.parametrize("motion_of", [random_motion, chattering_motion, recorded])
@pytest.mark.parametrize("seeds", [range(6), pytest.param(range(80), marks=pytest.mark.nightly)])
def test_one_coordinate_is_the_oscillator_of_the_other_oracle(
    motion_of: Callable[[int], Motion], seeds: range
) -> None:
    for seed in seeds:
        motion = motion_of(seed)
        x, v, t = motion.start
        structure = of_mass_one(motion.oscillator)

        run = simulate_structure(
            structure_problem(structure, motion.forcing), [x], [v], t, t_end=t + 6
        )
        other = event_driven.simulate(
            problem_of(motion.oscillator, motion.forcing), x, v, t, t_end=t + 6, digits=30
        )

        ours = sorted((e.t, e.kind, e.stop) for e in run.events if _is_told(e))
        theirs = sorted(told[:3] for told in events_of(other, slowest=SLOW))
        assert [e[1:] for e in ours] == [e[1:] for e in theirs]
        assert all(abs(a[0] - b[0]) < 1e-28 for a, b in zip(ours, theirs, strict=True))
        for moment in np.linspace(t + 0.1, t + 5.9, 7).tolist():
            (y,), (speed,) = run(moment)
            want, want_speed = other(moment)
            assert abs(y - want) < 1e-28
            assert abs(speed - want_speed) < 1e-28


def _is_told(event: StructureEvent) -> bool:
    return event.kind != "impact" or abs(event.v_before) > SLOW


def force_at(motion: StructureMotion, x: Floats, v: Floats, t: float) -> Floats:
    """Return loads and soft stops in doubles, by the position alone."""
    structure = motion.structure
    total = np.zeros(structure.n)
    rows = motion.loads.directions(structure)
    for row, force in zip(rows, motion.loads.forcings, strict=True):
        size = float(force.constant)
        for part in force.components():
            w = float(part.omega)
            size += part.cos * np.cos(w * t) + part.sin * np.sin(w * t)
        total += size * row
    for stop, row in zip(structure.stops, structure.stop_directions, strict=True):
        sign = 1.0 if stop.side == "above" else -1.0
        if isinstance(stop, pc.SoftStop) and sign * (row @ x - float(stop.at)) > 0:
            push = float(stop.stiffness) * (row @ x - float(stop.at))
            total -= row * (push + float(stop.damping) * (row @ v))
    return total


@pytest.mark.parametrize("seed", [1, 3, 6, 11, 20, 22, 24, 25])
def test_flights_are_those_of_an_ode_solver(seed: int) -> None:
    """From event to event, with soft stops by the position and walls left out."""
    motion = random_structure(seed)
    structure, run = motion.structure, flown(motion)
    n, inverse = structure.n, np.linalg.inv(structure.mass_matrix)

    def rates(t: float, z: Floats) -> Floats:
        x, v = z[:n], z[n:]
        pull = structure.stiffness_matrix @ x + structure.damping_matrix @ v
        return np.concatenate([v, inverse @ (force_at(motion, x, v, t) - pull)])

    moments = [motion.t0, *sorted({float(e.t) for e in run.events}), motion.t_end]
    flights = 0
    for begin, end in itertools.pairwise(moments):
        if end - begin < 1e-3 or run.held_at(0.5 * (begin + end)):
            continue
        # A little inside, where both limits are the same.
        a, b = begin + 1e-9, end - 1e-9
        z0, z1 = (np.array([float(c) for part in run(t) for c in part]) for t in (a, b))
        found = solve_ivp(rates, (a, b), z0, method="DOP853", rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(found.y[:, -1], z1, atol=1e-7)
        for t in np.linspace(a, b, 20):
            x = np.array([float(c) for c in run(float(t))[0]])
            for stop, row in zip(structure.stops, structure.stop_directions, strict=True):
                if isinstance(stop, pc.Wall):
                    sign = 1.0 if stop.side == "above" else -1.0
                    assert sign * (row @ x - float(stop.at)) < 1e-12
        flights += 1
    assert flights > 2


# Gauss's rule of 20 points on a step of half a turn leaves less than 1e-45.
NODES, WEIGHTS = [], []
with mpmath.workdps(70):
    for k in range(1, 11):
        node = mpmath.findroot(
            lambda z: mpmath.legendre(20, z),
            mpmath.cos(mpmath.pi * (k - mpf("0.25")) / mpf("20.5")),
        )
        slope = 20 * (node * mpmath.legendre(20, node) - mpmath.legendre(19, node)) / (node**2 - 1)
        NODES += [(1 + node) / 2, (1 - node) / 2]
        WEIGHTS += [1 / ((1 - node**2) * slope**2)] * 2


def energy_balance(motion: StructureMotion, run: StructureRun) -> Any:
    """Return energy gained less work done, at 60 digits."""
    problem = structure_problem(motion.structure, motion.loads)
    n = motion.structure.n
    kinetic, work = [mpf(0), mpf(0)], mpf(0)
    with mpmath.workdps(60):

        def bilinear(matrix: Any, a: list[Any], b: list[Any]) -> Any:
            return mpmath.fsum(
                event_driven.number(matrix[i][j]) * a[i] * b[j]
                for i in range(n)
                for j in range(n)
                if matrix[i][j]
            )

        ends = [event_driven.number(motion.t0), event_driven.number(motion.t_end)]
        for k, t in enumerate(ends):
            _, v = run(t)
            kinetic[k] = bilinear(problem.mass, v, v) / 2
        begins = [mpmath.ldexp(mpf(start), -256) for start in run.starts]
        for i, begin in enumerate(begins):
            end = begins[i + 1] if i + 1 < len(begins) else ends[1]
            inside = run.steps[i][3]
            for u, weight in zip(NODES, WEIGHTS, strict=True):
                t = begin + u * (end - begin)
                x, v = run(t)
                power = -bilinear(problem.stiffness, v, x) - bilinear(problem.damping, v, v)
                for load in problem.loads:
                    size = event_driven.number(load.constant)
                    for h in load.harmonics:
                        cos, sin = mpmath.cos_sin(event_driven.number(h.omega) * t)
                        size += event_driven.number(h.cos) * cos + event_driven.number(h.sin) * sin
                    speed = sum(float(c) * s for c, s in zip(load.direction, v, strict=True))
                    power += size * speed
                for j in inside:
                    direction, soft = problem.stops[j]
                    assert isinstance(soft, event_driven.Soft)
                    y = sum(float(c) * s for c, s in zip(direction, x, strict=True))
                    speed = sum(float(c) * s for c, s in zip(direction, v, strict=True))
                    y -= event_driven.number(soft.at)
                    power -= speed * event_driven.number(soft.stiffness) * y
                    power -= speed * event_driven.number(soft.damping) * speed
                work += weight * (end - begin) * power
        for event in run.events:
            if event.kind == "impact":
                c = problem.stops[event.stop][0]
                work -= (event.v_before**2 - event.v_after**2) / 2 / effective(problem, c)
        return kinetic[1] - kinetic[0] - work


def effective(problem: StructureProblem, c: tuple[Fraction, ...]) -> Any:
    """Return c . M^-1 c of a diagonal or small mass, exactly."""

    pull = solved(problem.mass, c)
    return event_driven.number(sum((a * b for a, b in zip(c, pull, strict=True)), Fraction(0)))


@pytest.mark.parametrize("seed", [1, 3, 6, 11, 22, 9])
def test_energy_gained_is_work_done_to_40_digits(seed: int) -> None:
    """An impact takes (1 - r^2) (c v)^2 / (2 c M^-1 c), a wall that holds does no work."""
    motion = random_structure(seed)
    run = flown(motion)

    # A chatter's sum leaves the square of 1e-18 and that of its last speed.
    limit = mpf("1e-30") if run.tails else mpf("1e-40")
    assert abs(energy_balance(motion, run)) < limit


def test_kinds_of_structures_are_all_drawn_and_all_kinds_of_events_happen() -> None:
    motions = [random_structure(seed) for seed in range(30)]
    kinds = {event.kind for motion in motions[1:4] for event in flown(motion).events}

    assert {motion.kind for motion in motions} == set(KINDS)
    assert kinds == {"impact", "in", "out", "rest", "release"}
    assert {motion.structure.n for motion in motions} >= {3, 4, 5, 6, 7, 8, 9, 10}


def test_a_wall_lets_go_when_it_would_have_to_pull() -> None:
    """A mass pressed to a wall by 1, another one on a spring of 4 before it: 1 = 4 x1 ends it."""
    structure = pc.Structure([1, 1], [[4, -4], [-4, 4]], stops=[pc.Wall(0, "below", "0.5", on=0)])
    problem = structure_problem(structure, {0: pc.Forcing(constant=-1)})

    run = simulate_structure(problem, [0, 0], [0, 1], t_end=2)

    rest, release = run.events[:2]
    assert (rest.kind, rest.t, release.kind) == ("rest", 0, "release")
    # x1 = sin(2 t) / 2 pulls at the first mass with 4 x1.
    assert abs(release.t - mpmath.asin(mpf("0.5")) / 2) < 1e-16
    with mpmath.workdps(60):
        assert abs(release.t - mpmath.pi / 12) < mpf("1e-50")


def test_of_two_walls_at_one_instant_the_first_comes_first_and_again_until_none_is_met() -> None:
    """A mass 1 between a wall and a mass that it hits at the same instant, as Newton's cradle."""
    stops = [pc.Wall(0, "below", 1, on=(1, -1)), pc.Wall(0, "above", 1, on=0)]
    problem = structure_problem(pc.Structure([1, 1], [0, 0], stops=stops))

    run = simulate_structure(problem, [0, 0], [0, 1], t_end=1)

    # The second runs into the first, which takes its speed to the wall, comes back and returns it.
    impacts = [e for e in run.events if e.kind == "impact"]
    assert [(e.stop, float(e.v_before), float(e.v_after)) for e in impacts] == [
        (0, -1.0, 1.0), (1, 1.0, -1.0), (0, -1.0, 1.0),
    ]  # fmt: skip
    assert [float(v) for v in run(1)[1]] == [0.0, -1.0]


def test_a_soft_stop_acts_by_position_also_where_its_dashpot_pulls() -> None:
    stop = pc.SoftStop(0, "above", 9, 6, on=(1, 0))
    problem = structure_problem(pc.Structure([1, 1], [0, 0], stops=[stop]))

    run = simulate_structure(problem, [-1, 0], [1, 0], t_end=5)

    # x = s e^(-3 s) never comes back to 0, and the force changes its sign at s = 2/3.
    assert [(e.kind, float(e.t)) for e in run.events] == [("in", 1.0)]
    with mpmath.workdps(60):
        assert abs(run(mpf(5))[0][0] - 4 * mpmath.exp(-12)) < mpf("1e-50")


@pytest.mark.parametrize(
    ("omega", "entry", "exit_", "depth", "multiplier"),
    [
        ("0.65", "0.148007457", "0.442556446", "0.030303", None),
        ("0.60", "0.121462407", "0.380362607", "0.009533", -0.26575 + 1.36536j),
    ],
)
def test_periodic_motions_of_nlvibs_example_03(
    omega: str, entry: str, exit_: str, depth: str, multiplier: complex | None
) -> None:
    """Its parameters: masses 1, 1, springs 0, 1, 1, damping 0.03 K, a stop of 100 at 1."""
    chain = pc.chain([1, 1], [0, 1, 1], [0, "0.03", "0.03"], [pc.SoftStop(1, "above", 100, on=0)])
    problem = structure_problem(chain, {1: pc.cosine(omega, amplitude="0.1")})
    guess = {
        "0.65": ["0.947", "0.675", "0.379", "0.108"],
        "0.60": ["0.982", "0.641", "0.169", "0.06"],
    }
    with mpmath.workdps(60):
        orbit = closed_orbit(problem, guess[omega], 2 * mpmath.pi / mpf(omega))

    came, went = orbit.run.events
    assert (came.kind, went.kind) == ("in", "out")
    assert abs(came.t - mpf(entry)) < 1e-9
    assert abs(went.t - mpf(exit_)) < 1e-9
    inside = np.linspace(float(came.t), float(went.t), 401)
    deepest = max(float(orbit.run(t)[0][0]) for t in inside.tolist()) - 1.0
    assert deepest == pytest.approx(float(depth), abs=1e-6)
    if multiplier is not None:
        outer = max(orbit.multipliers, key=lambda value: (abs(value), value.imag))
        assert abs(complex(outer) - multiplier) < 1e-5


@pytest.mark.parametrize("seed", range(8))
def test_the_generator_of_near_grazes_tells_the_truth(seed: int) -> None:
    case = near_graze(seed)
    problem = structure_problem(case.structure, case.loads)

    run = simulate_structure(problem, case.x0, case.v0, t_end=case.t_end)

    assert 1e-14 * case.amplitude < abs(case.depth) < 2e-6 * case.amplitude
    assert [event.kind for event in run.events] == ["impact"] * case.hits
    assert run.doubts == []
    if case.hits:
        assert abs(run.events[0].t - case.t) < mpf("1e-35")
