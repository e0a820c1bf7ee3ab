"""Edges of structures' motions: rest on walls, coincident impacts, chatter, release, critical damping."""

from __future__ import annotations

import math
import operator
from typing import Any

import numpy as np
import pytest
from tests.oracle.random_problems import random_motion

import percuss as pc
from percuss.model.exact import as_fraction
from percuss.motion import follow_structure

FLOOR = pc.Wall(at=0, side="below", restitution="0.5", on=0)


def held_pair(restitution: float | str = "0.5", **more: Any) -> pc.Structure:
    """Return two masses on springs, the first above a wall at 0."""
    wall = pc.Wall(at=0, side="below", restitution=restitution, on=0)
    return pc.chain([1, 2], [1, 2, 1], stops=[wall], **more)


def test_a_start_at_rest_on_a_wall_is_held_until_the_load_lets_go() -> None:
    """The load on the held mass falls from 1 into the wall to nothing and turns, at t = pi / 2."""
    structure = pc.Structure([1, 1], [1, 1], stops=[FLOOR])
    run = pc.simulate(structure, pc.Loads({0: pc.cosine(1, amplitude=-1)}), t_end=3)

    assert run.contacts.start.tolist() == [0.0]
    assert run.contacts.release == pytest.approx([math.pi / 2], abs=1e-14)
    assert len(run.impacts) == 0
    x, v = run([1.0, 1.5])
    np.testing.assert_array_equal(x[:, 0], 0.0)
    np.testing.assert_array_equal(v[:, 0], 0.0)
    # x'' + x = -cos t from rest at pi / 2: x = -(s sin t) / 2 + (cos t)(...), by its own equation.
    s = 3.0 - math.pi / 2
    exact = 0.5 * (math.sin(s) - s * math.cos(s))
    assert float(run(3.0)[0][0]) == pytest.approx(exact, abs=1e-14)


def test_a_spring_between_the_masses_pulls_a_held_mass_off() -> None:
    """The second mass swings away and pulls the first: the reaction is 2 - 2 x1, nothing more."""
    structure = pc.Structure([1, 1], [[2, -2], [-2, 2]], stops=[FLOOR])
    run = pc.simulate(structure, x0=[0, -1], t_end=5)

    release = math.pi / 2 / math.sqrt(2)
    assert run.contacts.release == pytest.approx([release], abs=1e-14)
    reaction = run.extremes("stop_force", stop=0)
    assert reaction.maximum == pytest.approx(2.0, abs=1e-14)
    assert reaction.minimum == pytest.approx(0.0, abs=1e-14)


def test_a_motion_from_rest_on_a_wall_comes_back_to_it_without_velocity() -> None:
    ceiling = pc.Wall(at=1, side="above", restitution="0.5", on=0)
    run = pc.simulate(pc.Structure([1, 1], [1, 4], stops=[ceiling]), x0=[1, "0.3"], t_end=30)

    np.testing.assert_allclose(run.grazes.t, 2.0 * math.pi * np.arange(1, 5), rtol=1e-15)
    assert len(run.impacts) == 0


def test_a_start_on_a_wall_with_velocity_into_it_is_an_impact_at_the_start() -> None:
    run = pc.simulate(held_pair(), v0=[-2, 0], t_end=0.1)

    first = run.impacts
    assert first.t[0] == 0.0
    assert (first.v_before[0], first.v_after[0]) == pytest.approx((-2.0, 1.0), abs=1e-15)
    assert run(0.0)[1].tolist() == pytest.approx([1.0, 0.0], abs=1e-15)


def test_a_start_inside_a_wall_is_refused_with_both_numbers() -> None:
    with pytest.raises(pc.ParameterError, match=r"y = -0\.25 is below the wall stops\.0 at y = 0"):
        pc.simulate(held_pair(), x0=[-0.25, 0], t_end=1)


@pytest.mark.parametrize("restitution", ["0", "0.5"])
def test_a_run_goes_on_from_its_states_that_rounding_has_put_behind_the_wall(
    restitution: str,
) -> None:
    """Held by the wall, and struck by it, a state is at c . x only to the rounding of its modes."""
    wall = pc.Wall("0.3", "above", restitution, on=(0, 1, -1))
    structure, loads = pc.chain([1] * 3, 1, "0.1", stops=[wall]), pc.Loads({1: pc.sine(1, 2)})
    run = pc.simulate(structure, loads, t_end=40)
    instants = np.concatenate([np.linspace(1, 39, 77), run.impacts.t])
    behind = [t for t in instants if run.displacement((0, 1, -1), t)[0] > 0.3]
    assert len(behind) > 5

    for t in behind:
        again = pc.simulate(structure, loads, start=(*run(t), float(t)), t_end=40)
        np.testing.assert_allclose(again(40.0), run(40.0), rtol=0, atol=1e-13)


def test_a_start_behind_a_wall_by_rounding_is_at_it() -> None:
    """Behind it the kernels would follow another motion, 0.02 away at the end of this one."""
    wall = pc.Wall(1, "above", "0.7", on=(1, 0))
    structure, loads = pc.chain([1, 1], 1, "0.1", stops=[wall]), pc.Loads({0: pc.sine(1, 2)})
    start = ([1 + 4e-13, 0], [-0.2, 0])

    run = pc.simulate(structure, loads, start=start, t_end=20)
    at_it = pc.simulate(structure, loads, x0=[1, 0], v0=[-0.2, 0], t_end=20)
    np.testing.assert_allclose(run(20.0), at_it(20.0), rtol=0, atol=1e-11)
    over = {"start.x0.0": [1 + 4e-13, 1], "structure.stops.0.restitution": [0.7]}
    swept = pc.sweep(
        "min_displacement", structure, loads, over=over, start=start, on=0, transient=0, periods=3
    ).min_displacement.values.ravel()
    assert swept[0] == pytest.approx(swept[1], abs=1e-11)
    with pytest.raises(pc.ParameterError, match=r"is above the wall stops\.0 at y = 1"):
        pc.simulate(structure, loads, x0=[1 + 1e-11, 0], t_end=20)


@pytest.mark.parametrize(
    ("x0", "reason"),
    [
        ([0, 1, 2], r"3 numbers for 2 coordinates"),
        (0.5, r"not 2 numbers, one for each coordinate"),
        (["nothing", 0], r"nothing"),
    ],
)
def test_a_start_that_does_not_fit_is_refused(x0: Any, reason: str) -> None:
    with pytest.raises(pc.ParameterError, match=reason):
        pc.simulate(held_pair(), x0=x0, t_end=1)


def test_a_start_is_given_once() -> None:
    start = pc.StructureStart(x0=(0, 0), v0=(1, 0))
    run = pc.simulate(held_pair(), start=start, t_end=1)
    same = pc.simulate(held_pair(), start=([0, 0], [1, 0]), t_end=1)

    assert run.start == start
    np.testing.assert_array_equal(run(1.0), same(1.0))
    with pytest.raises(pc.ParameterError, match=r"given together with start"):
        pc.simulate(held_pair(), start=start, v0=[1, 0], t_end=1)
    with pytest.raises(pc.ParameterError, match=r"neither a StructureStart nor"):
        pc.simulate(held_pair(), start=3, t_end=1)  # type: ignore[call-overload]


def test_two_walls_struck_at_one_instant_keep_the_symmetry() -> None:
    """Two equal masses run outwards into walls at equal distances, of a symmetric chain."""
    walls = [
        pc.Wall(at=-1, side="below", restitution="0.7", on=0),
        pc.Wall(at=1, side="above", restitution="0.7", on=1),
    ]
    chain = pc.chain([1, 1], [1, 3, 1], dashpots="0.05", stops=walls)
    run = pc.simulate(chain, v0=[-20, 20], t_end=20)

    assert len(run.impacts) > 4
    assert len(run.impacts) % 2 == 0
    t, stop = run.impacts.t.reshape(-1, 2), run.impacts.stop.reshape(-1, 2)
    np.testing.assert_allclose(t[:, 0], t[:, 1], rtol=0, atol=1e-14)
    np.testing.assert_array_equal(np.sort(stop, axis=1), [[0, 1]] * len(stop))
    x, _ = run(np.linspace(0, 20, 301))
    np.testing.assert_allclose(x[:, 0], -x[:, 1], rtol=0, atol=1e-12)


def test_a_chatter_comes_to_rest_while_another_mass_moves() -> None:
    """Gravity on the first alone, no coupling: the times of a bouncing ball, in closed form."""
    structure = pc.Structure([1, 1], [0, 4], stops=[FLOOR])
    loads = pc.Loads({0: pc.Forcing(constant=-1)})
    run = pc.simulate(structure, loads, x0=[0, 1], v0=[1, 0], t_end=6)

    # 2 v (1 + r + r^2 + ...) / g.
    np.testing.assert_allclose(run.contacts.start, [4.0], rtol=0, atol=1e-13)
    assert run.contacts.error_bound[0] < 1e-10
    t = np.linspace(0, 6, 2001)
    x, _ = run(t)
    np.testing.assert_allclose(x[:, 1], np.cos(2 * t), rtol=0, atol=1e-13)
    assert x[:, 0].min() >= -1e-15
    np.testing.assert_array_equal(x[t > 4.001, 0], 0.0)


def test_nothing_is_beyond_the_wall_in_the_summed_tail_of_a_chatter() -> None:
    """Between the last impact that is listed and the contact, at instants of many hops."""
    structure = held_pair("0.8", dashpots="0.1")
    loads = pc.Loads({0: pc.cosine("0.4", amplitude=2, constant=-2)})
    run = pc.simulate(structure, loads, x0=["0.2", 0], t_end=30)

    assert len(run.contacts) > 0
    deepest = 0.0
    for k in range(len(run.contacts)):
        last = run.impacts.t[run.contacts.n_impacts[k] - 1]
        begin = run.contacts.start[k]
        assert last < begin
        t = last + (begin - last) * (1.0 - np.geomspace(1.0, 1e-9, 4001))
        x, v = run(t)
        deepest = min(deepest, float(x[:, 0].min()))
        # It hops off, in velocities that fall to nothing, and the other mass moves on smoothly.
        assert np.abs(v[-1, 0]) < 1e-3 * np.abs(v[0, 0])
        assert (v[:, 0] > 0).any()
        assert (v[:, 0] < 0).any()
        assert np.abs(np.diff(x[:, 1])).max() < 2 * (begin - last) * np.abs(v[:, 1]).max() + 1e-15
        before, after = (run(begin, limit) for limit in ("before", "after"))
        np.testing.assert_allclose(before[0], after[0], rtol=0, atol=1e-13)
    assert deepest >= -1e-15


def test_contact_on_two_walls_at_once_ends_on_one_after_the_other() -> None:
    """Two uncoupled masses rest on their walls, and their loads turn at different instants."""
    walls = [pc.Wall(0, "below", 0, on=0), pc.Wall(0, "below", 0, on=1)]
    structure = pc.Structure([1, 1], [1, 1], stops=walls)
    loads = pc.Loads({
        0: pc.cosine(1, amplitude=-1), 1: pc.cosine("1/2", amplitude=-1)
    })  # fmt: skip
    run = pc.simulate(structure, loads, t_end=4)

    assert run.contacts.stop.tolist() == [0, 1]
    np.testing.assert_allclose(run.contacts.release, [math.pi / 2, math.pi], rtol=0, atol=1e-13)
    forces = run.forces([1.0, 2.0])["stops"].values
    np.testing.assert_allclose(forces[:, 0], [math.cos(1), math.cos(0.5)], rtol=0, atol=1e-15)
    np.testing.assert_allclose(forces[:, 1], [0.0, math.cos(1.0)], rtol=0, atol=1e-15)


def test_a_soft_stop_is_entered_at_zero_speed() -> None:
    """A load that grows from nothing presses a mass at rest on the edge of a stop into it."""
    stop = pc.SoftStop(at=0, side="above", stiffness=99, on=0)
    structure = pc.Structure([1, 1], [1, 1], stops=[stop])
    run = pc.simulate(structure, pc.Loads({0: pc.record([0, 10], [0, 10])}), t_end=1)

    # It begins within the stop, as the motion of an oscillator does.
    assert len(run.crossings) == 0
    # x'' + 100 x = t from rest.
    exact = 0.01 * (1.0 - math.sin(10.0) / 10.0)
    assert float(run(1.0)[0][0]) == pytest.approx(exact, abs=1e-16)


def test_an_impact_at_the_very_knot_of_a_record_is_one_impact() -> None:
    """Free flight reaches the wall at t = 1, where the load sets in."""
    walls = [pc.Wall(1, "above", "1/2", on=0)]
    structure = pc.Structure([1, 1], [0, 1], stops=walls)
    load = pc.record([0, 1, 3], [0, 0, 2])
    run = pc.simulate(structure, pc.Loads({0: load}), v0=[1, 0], t_end=2)

    assert run.impacts.t.tolist() == [1.0]
    assert run.impacts.v_after.tolist() == [-0.5]
    # x'' = t - 1 from x = 1, v = -1/2.
    assert float(run(2.0)[0][0]) == pytest.approx(0.5 + 1 / 6, abs=1e-15)


def test_a_wall_lets_go_at_a_jump_of_a_record_with_the_acceleration_of_the_jump() -> None:
    """It leaves the wall at once: no landing, and no graze, at the very instant of the release."""
    force = pc.record([0, 1, 2], [1, "0.8", -1], kind="hold")
    alone = pc.Oscillator(damping="0.1", stops=(pc.Wall("0.2", "above", "0.3"),))
    structure = pc.Structure([1], [1], ["0.2"], stops=[pc.Wall("0.2", "above", "0.3", on=0)])

    run = pc.simulate(structure, pc.Loads({0: force}), x0=["0.2"], t_end=5)
    other = pc.simulate(alone, force, x0="0.2", t_end=5)

    assert run.contacts.release.tolist() == other.contacts.release.tolist() == [2.0]
    assert len(run.impacts) == len(other.impacts) == 0
    assert len(run.grazes) == len(other.grazes) == 0
    assert run(3.0)[0][0] == pytest.approx(other(3.0)[0], abs=1e-15)
    moved = run.sensitivity(["structure.stops.0.at"])(3.0)[0]
    expected = other.sensitivity(["oscillator.stops.0.at"])(3.0)[0]
    assert np.ravel(moved) == pytest.approx(np.ravel(expected), abs=1e-14)


def test_free_masses_keep_their_momentum_exactly_through_impacts() -> None:
    """Three balls on a line without springs, elastic: velocities are handed on."""
    walls = [
        pc.Wall(at=1, side="above", restitution=1, on=(1, -1, 0)),
        pc.Wall(at=1, side="above", restitution=1, on=(0, 1, -1)),
    ]
    balls = pc.Structure([1, 1, 1], [0, 0, 0], stops=walls)
    run = pc.simulate(balls, v0=[1, 0, 0], t_end=5)

    assert run.impacts.t.tolist() == pytest.approx([1.0, 2.0], abs=1e-15)
    x, v = run(5.0)
    np.testing.assert_allclose(v, [0, 0, 1], rtol=0, atol=1e-15)
    np.testing.assert_allclose(x, [1, 1, 3], rtol=0, atol=1e-14)


def test_without_rebound_two_masses_go_on_together() -> None:
    """r = 0: the impulse leaves no relative velocity, and nothing pulls them apart."""
    wall = pc.Wall(at=1, side="above", restitution=0, on=(1, -1))
    balls = pc.Structure([1, 3], [0, 0], stops=[wall])
    run = pc.simulate(balls, v0=[1, 0], t_end=3)

    np.testing.assert_allclose(run(3.0)[1], [0.25, 0.25], rtol=0, atol=1e-15)
    assert len(run.impacts) == 1
    assert float(run.displacement((1, -1), 3.0)[0]) <= 1.0 + 1e-15


def test_restitution_tables_are_read_at_the_velocity_of_the_direction() -> None:
    table = pc.restitution_table([1, 3], ["0.9", "0.6"])
    wall = pc.Wall(at=1, side="above", restitution=table, on=(1, -1))
    balls = pc.Structure([1, 1], [0, 0], stops=[wall])
    run = pc.simulate(balls, v0=[1, -1], t_end=1)

    assert run.impacts.v_before.tolist() == [2.0]
    assert run.impacts.v_after == pytest.approx([-2.0 * 0.75], abs=1e-15)
    assert run.impacts.impulse == pytest.approx([-3.5 * 0.5], abs=1e-15)


def test_elastic_impacts_keep_the_energy_over_ten_thousand() -> None:
    walls = [
        pc.Wall(at=-1, side="below", restitution=1, on=0),
        pc.Wall(at="1.5", side="above", restitution=1, on=(1, -1)),
        pc.Wall(at="0.5", side="above", restitution=1, on=1),
    ]
    chain = pc.chain([1, 2], [1, 2, 1], stops=walls)
    run = pc.simulate(chain, v0=[3, -2], t_end=1e6, max_impacts=10_000)

    assert len(run.impacts) == 10_000
    energy = run.energy([0.0, *run.impacts.t[::97]])
    np.testing.assert_allclose(energy, energy[0], rtol=1e-12, atol=0)


@pytest.mark.parametrize(
    "seeds", [range(0, 200, 8), pytest.param(range(300), marks=pytest.mark.nightly)], ids=len
)
def test_one_coordinate_moves_as_the_oscillator_does(seeds: range) -> None:
    assert [fault for seed in seeds for fault in _differences(seed)] == []


def _differences(seed: int) -> list[str]:
    case = random_motion(seed)
    osc = case.oscillator
    mass = float(np.random.default_rng([9, seed]).choice([1.0, 0.3, 7.0]))
    x0, v0, t0 = case.start
    alone = pc.simulate(osc, case.forcing, x0, v0, t0, t_end=t0 + 5.0, max_impacts=60)
    run = pc.simulate(
        _as_structure(osc, mass), case.forcing * mass, [x0], [v0], t0,
        t_end=t0 + 5.0, max_impacts=60,
    )  # fmt: skip
    end = min(alone.t_end, run.t_end)
    # A chatter may be summed an impact earlier in the one than in the other.
    shared = min(len(alone.impacts), len(run.impacts))
    listed = {len(alone.impacts), len(run.impacts)}
    faults = []
    if len(listed) > 1 and not len(alone.contacts):
        faults.append(f"{seed}: {len(alone.impacts)} and {len(run.impacts)} impacts")
    if len(alone.contacts) == 0:
        t, other = alone.impacts.t[:shared], run.impacts.t[:shared]
        if not np.allclose(t, other, rtol=0, atol=1e-11 * max(1.0, abs(end))):
            faults.append(f"{seed}: impacts {np.abs(t - other).max():g} apart")
    for name in ("crossings.t", "contacts.start", "contacts.release"):
        mine, theirs = (operator.attrgetter(name)(each) for each in (alone, run))
        mine, theirs = mine[mine < end - 1e-6], theirs[theirs < end - 1e-6]
        if len(mine) != len(theirs) or not np.allclose(mine, theirs, rtol=0, atol=1e-9):
            faults.append(f"{seed}: {name} {mine} and {theirs}")
    times = np.linspace(t0, end, 301)
    events = np.concatenate([alone.impacts.t, run.impacts.t])
    apart = np.abs(times[:, None] - events).min(axis=1, initial=1.0) > 1e-9
    tails = zip(alone.contacts.start, alone.contacts.n_impacts, strict=True)
    for start, n in tails:
        last = alone.impacts.t[n - 1] if n else start
        apart &= ~((times >= last - 1e-3) & (times <= start + 1e-6))
    (x, v), (y, w) = alone(times[apart]), run(times[apart])
    for mine, theirs in ((x, y[:, 0]), (v, w[:, 0])):
        size = max(1.0, float(np.abs(mine).max(initial=0.0)))
        worst = float(np.abs(mine - theirs).max(initial=0.0))
        if not worst <= 1e-11 * size:
            faults.append(f"{seed}: {worst:g} of {size:g}")
    return faults


def _as_structure(osc: pc.Oscillator, mass: float) -> pc.Structure:
    """Return an oscillator of unit mass as a structure of one coordinate of another mass."""
    m = as_fraction(mass)
    stops = [
        stop if isinstance(stop, pc.Wall)
        else pc.SoftStop(stop.at, stop.side, m * as_fraction(stop.stiffness),
                         2 * m * as_fraction(stop.damping))
        for stop in osc.stops
    ]  # fmt: skip
    return pc.Structure(
        mass, m * as_fraction(osc.stiffness), 2 * m * as_fraction(osc.damping), stops=stops
    )


@pytest.mark.parametrize("apart", [1e-6, 1e-9, 1e-12])
def test_two_impacts_a_hair_apart_are_two_in_order(apart: float) -> None:
    """Free masses reach their walls at t = 1 and 1 + apart; floats at 1 resolve 2e-16."""
    walls = [pc.Wall(1, "above", 1, on=0), pc.Wall(1, "above", 1, on=1)]
    structure = pc.Structure([1, 1], [0, 0], stops=walls)
    run = pc.simulate(structure, x0=[0, -apart], v0=[1, 1], t_end=1.5)

    assert run.impacts.stop.tolist() == [0, 1]
    assert np.diff(run.impacts.t)[0] == pytest.approx(apart, abs=4e-16)


def test_a_coupled_system_at_critical_damping_is_exact() -> None:
    """C = 2 sqrt(K) with a defective pair in each mode: x = (1 + w t) exp(-w t) in modes."""
    # K = [[5, -4], [-4, 5]] has rates 1 and 3 on (1, 1) and (1, -1); 2 sqrt(K) = [[4, -2], [-2,
    # 4]].
    structure = pc.Structure([1, 1], [[5, -4], [-4, 5]], [[4, -2], [-2, 4]])
    run = pc.simulate(structure, x0=[1, 0], t_end=5)

    t = np.linspace(0, 5, 101)
    slow, fast = (1 + t) * np.exp(-t) / 2, (1 + 3 * t) * np.exp(-3 * t) / 2
    np.testing.assert_allclose(run(t)[0], np.stack([slow + fast, slow - fast], axis=1),
                               rtol=0, atol=4e-16)  # fmt: skip


def test_damping_that_does_not_commute_can_be_defective_too() -> None:
    """C couples the modes and the characteristic polynomial has a double pair of real roots.

    With x'' = -K x - C x' of a companion form: roots -1, -1, -2, -2 by C = diag(2, 4), K = [[1, g],
    [0, 4]]: the second drives the first through K, and all is known in closed form.
    """
    structure = pc.Structure([1, 1], [[1, 1], [0, 4]], [[2, 0], [0, 4]])
    run = pc.simulate(structure, x0=[0, 1], t_end=4)

    t = np.linspace(0, 4, 41)
    # y = (1 + 2 t) e^-2t; x'' + 2 x' + x = -y has the particular part -(5 + 2 t) e^-2t.
    second = (1 + 2 * t) * np.exp(-2 * t)
    first = (5 - 3 * t) * np.exp(-t) - (5 + 2 * t) * np.exp(-2 * t)
    np.testing.assert_allclose(run(t)[0], np.stack([first, second], axis=1), rtol=0, atol=2e-14)


def stack() -> tuple[pc.Structure, dict[int, pc.Forcing], dict[str, Any]]:
    """Return two masses at rest on each other and the floor, and a third that drops on them.

    A blow goes to and fro between the two until it is spent: many impacts of one instant.
    """
    walls = [
        pc.Wall(at=0, side="below", restitution="0.5", on=on)
        for on in ((1, 0, 0), (-1, 1, 0), (0, -1, 1))
    ]
    weight = pc.Forcing(constant=-1)
    loads = {0: weight + pc.cosine(1, amplitude="0.1"), 1: weight, 2: weight}
    return pc.Structure([1, 1, 1], [0, 0, 1], stops=walls), loads, {"x0": [0, 0, "0.5"]}


@pytest.mark.parametrize("capacity", [1, 5, 10, 13, 14, 15, 16, 20, 40, 60])
def test_impacts_of_one_instant_are_all_listed_however_long_the_record_is(
    capacity: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    structure, loads, start = stack()
    run = pc.simulate(structure, loads, t_end=4, **start)
    monkeypatch.setattr(follow_structure, "FIRST_CAPACITY", capacity)
    short = pc.simulate(structure, loads, t_end=4, **start)

    assert (np.diff(run.impacts.t) == 0.0).sum() > 100
    for name in ("events", "marks", "states"):
        assert getattr(short.record, name).tobytes() == getattr(run.record, name).tobytes(), name


def test_all_walls_that_hold_at_the_start_are_listed_before_the_limit_of_impacts() -> None:
    """Twelve masses at rest on twelve walls: more contacts than rows for the impacts allowed."""
    walls = [pc.Wall(at=0, side="below", on=i) for i in range(12)]
    structure = pc.Structure([1] * 12, [1] * 12, stops=walls)
    loads = {i: pc.Forcing(constant=-1) for i in range(12)}
    run = pc.simulate(structure, loads, t_end=2, max_impacts=1)

    assert run.contacts.stop.tolist() == list(range(12))
    assert run.outcome.value == "the run reached t_end"


def test_a_start_on_a_wall_with_a_velocity_of_rounding_is_at_rest() -> None:
    """An impulse of 1e-17 changes no mode: impacts followed one another at one instant for ever."""
    two = pc.chain([1, 1], [1, 1, 0], "0.4", [pc.Wall("0.05", "above", "0.2", on=1)])
    loads = pc.Loads({0: pc.cosine("0.4")})
    whole = pc.simulate(two, loads, periods=6)
    start, release = whole.contacts.start[-2], whole.contacts.release[-2]
    assert release - start > 1.0

    for t in np.linspace(start + 1e-3, release - 1e-3, 40):
        x, v = whole(t)
        run = pc.simulate(two, loads, x0=x, v0=v, t0=t, t_end=release + 1.0)
        assert len(run.impacts) == 0
        assert run.contacts.start[0] == t
        assert run.contacts.release[0] == pytest.approx(release, abs=1e-10)
        np.testing.assert_allclose(run(run.t_end), whole(run.t_end), rtol=0, atol=1e-11)
    # A velocity that is no rounding is an impact, however small.
    for speed in (1e-20, 1e-12):
        still = pc.chain([1, 1], [1, 1, 0], 0, [pc.Wall(0, "above", "0.5", on=1)])
        hit = pc.simulate(still, x0=[0, 0], v0=[0, speed], t_end=1)
        assert hit.impacts.v_before[0] == pytest.approx(speed)
        assert hit.impacts.t[0] == 0.0


def test_a_soft_stop_given_in_two_parts_is_entered_and_left_in_both() -> None:
    """Where one part is left the other is at its edge, too: its own short visit is not passed over."""
    force = pc.Loads({0: pc.Forcing(constant=2)})
    parts = [pc.SoftStop(0, "below", k, on=0) for k in (1e-3, 3e-3)]
    for seed in range(40):
        first, second = sorted(np.random.default_rng(seed).uniform(0.5, 3.0, 2).tolist())
        # x = (t - first) (t - second) but for the weak stop.
        start = [first * second], [-first - second]
        run = pc.simulate(pc.Structure([1], [0], stops=parts), force, *start, t_end=second + 1)
        whole = pc.Structure([1], [0], stops=[pc.SoftStop(0, "below", 4e-3)])
        expected = pc.simulate(whole, force, *start, t_end=second + 1).crossings

        assert run.crossings.direction.tolist() == ["in", "in", "out", "out"]
        assert sorted(run.crossings.stop.tolist()) == [0, 0, 1, 1]
        rounding = 1e-14 / (second - first)
        np.testing.assert_allclose(run.crossings.t[::2], expected.t, rtol=0, atol=rounding)
        np.testing.assert_allclose(run.crossings.t[1::2], expected.t, rtol=0, atol=rounding)


@pytest.mark.parametrize(("name", "times"), [("t0", (1e16, 1e16 + 10)), ("t_end", (0, 1e18))])
def test_times_at_which_phases_have_no_digits_are_refused(
    name: str, times: tuple[float, float]
) -> None:
    one = pc.chain([1], [1, 0], "0.1", [pc.Wall(5, "above", "0.8", on=0)])
    with pytest.raises(pc.ParameterError, match=rf"^{name} = 1e\+1[68]: more than 1e\+14 periods"):
        pc.simulate(one, {0: pc.cosine(2)}, t0=times[0], t_end=times[1])
