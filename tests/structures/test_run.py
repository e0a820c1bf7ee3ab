"""What a run of a structure gives: forces, energy, extremes, sections, strobes, texts."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import pytest

import percuss as pc
from percuss.arrays import Floats
from percuss.kernels.structure import march as engine
from percuss.motion import follow_structure

# Unsymmetric coupling by dashpots, a wall on a mass, one between two, a soft stop with a dashpot.
STOPS = (
    pc.Wall(at=-1, side="below", restitution="0.6", on=0),
    pc.Wall(at="0.8", side="above", restitution="0.7", on=(1, -1, 0)),
    pc.SoftStop(at="0.5", side="above", stiffness=40, damping="0.8", on=2),
)
THREE = pc.Structure(
    mass=[[2, "0.1", 0], ["0.1", 1, 0], [0, 0, "1.5"]],
    stiffness=[[5, -2, 0], [-2, 4, -1], [0, -1, 3]],
    damping=[["0.05", 0, 0], ["0.02", "0.1", 0], [0, "-0.03", "0.04"]],
    stops=STOPS,
)
LOADS = pc.Loads({
    0: pc.cosine("1.3", amplitude=2) + pc.sine("2.1", amplitude="0.5"),
    (0, 1, -1): pc.record([0, 2, 3, 9, 30], [0, 1, -2, 1.5, 0]),
    2: pc.cosine("0.7", amplitude="1.5", constant="0.4"),
})  # fmt: skip


def run_of_three(t_end: float = 30.0, **more: Any) -> Any:
    return pc.simulate(THREE, LOADS, x0=["0.3", 0, "-0.2"], v0=[1, -2, 0], t_end=t_end, **more)


def test_the_forces_are_in_balance_with_the_accelerations() -> None:
    run = run_of_three()
    t = np.linspace(0.01, 29.9, 157)
    forces = run.forces(t)

    assert dict(forces.sizes) == {"t": 157, "coordinate": 3, "stop": 3}
    total = (forces["spring"] + forces["damping"] + forces["loads"]).values
    total = total + forces["stops"].values.T @ THREE.stop_directions
    # The acceleration at an instant is the extreme over that instant.
    acceleration = np.array([
        [run.extremes("acceleration", on=i, between=(s, s)).minimum for i in range(3)] for s in t
    ])  # fmt: skip
    np.testing.assert_allclose(acceleration @ THREE.mass_matrix, total, rtol=0, atol=1e-12)
    h = 1e-4
    inner = np.array([np.abs(s - np.r_[run.impacts.t, run.crossings.t]).min() > 1e-3 for s in t])
    slope = (run(t + h)[1] - run(t - h)[1])[inner] / (2 * h)
    np.testing.assert_allclose(slope, acceleration[inner], rtol=0, atol=1e-5)


def test_the_energy_is_what_the_loads_do_less_what_dashpots_and_impacts_take() -> None:
    """Integrals over each smooth piece by Gauss's rule, against the difference of the energies."""
    run = run_of_three()
    knots = np.array([0.0, 2.0, 3.0, 9.0, 30.0])
    edges = np.unique(np.concatenate([
        knots, run.impacts.t, run.crossings.t, run.contacts.start, np.arange(0.0, 30.0, 0.5)
    ]))  # fmt: skip
    nodes, weights = np.polynomial.legendre.leggauss(24)
    gained = 0.0
    for a, b in pairwise(edges):
        t = a + (b - a) * 0.5 * (nodes + 1.0)
        forces, v = run.forces(t), run(t)[1]
        power = ((forces["loads"] + forces["damping"]).values * v).sum(axis=1)
        # Of a soft stop the dashpot's part alone: its spring is in the energy.
        y, speed = run.displacement(2, t)
        power -= np.where(y > 0.5, 0.8 * speed * speed, 0.0)
        gained += 0.5 * (b - a) * float((weights * power).sum())
    impacts = run.impacts
    lost = 0.5 * impacts.effective_mass * (impacts.v_before**2 - impacts.v_after**2)
    first, last = run.energy([0.0, 30.0])

    assert len(impacts) > 15
    assert len(run.crossings) > 5
    assert last - first == pytest.approx(gained - lost.sum(), abs=1e-12 * (first + lost.sum()))


QUANTITIES: list[tuple[Any, dict[str, Any]]] = [
    ("displacement", {"on": 1}),
    ("displacement", {"on": (1, -1, 0)}),
    ("velocity", {"on": 0}),
    ("acceleration", {"on": 2}),
    ("acceleration", {"on": (1, 0, -1)}),
    ("spring_force", {"on": 0}),
    ("stop_force", {"stop": 2}),
]


@pytest.mark.parametrize(("of", "where"), QUANTITIES)
def test_extremes_hold_all_values_and_are_values(of: Any, where: dict[str, Any]) -> None:
    run = run_of_three()
    extrema = run.extremes(of, **where)
    events = np.r_[run.impacts.t, run.crossings.t]
    t = np.unique(np.r_[np.linspace(0, 30, 60_001), events])
    values = _values(run, of, where, t)
    size = np.abs(values).max()

    assert values.max() <= extrema.maximum + 1e-13 * size
    assert values.min() >= extrema.minimum - 1e-13 * size
    for extreme, at, of_grid in (
        (extrema.maximum, extrema.t_maximum, values.max()),
        (extrema.minimum, extrema.t_minimum, values.min()),
    ):
        # A grid of 0.0005 misses a smooth extreme by less than this.
        assert abs(extreme - of_grid) <= 1e-4 * size or at in events
        alone = run.extremes(of, **where, between=(at, at))
        assert extreme in (alone.minimum, alone.maximum) or min(
            abs(extreme - alone.minimum), abs(extreme - alone.maximum)
        ) <= 1e-13 * size  # fmt: skip


def _values(run: Any, of: str, where: dict[str, Any], t: Any) -> Any:
    if of in ("displacement", "velocity"):
        return run.displacement(where["on"], t)[of == "velocity"]
    forces = run.forces(t)
    if of == "stop_force":
        return forces["stops"].values[where["stop"]]
    if of == "spring_force":
        return forces["spring"].values[:, where["on"]]
    total = (forces["spring"] + forces["damping"] + forces["loads"]).values
    total = total + forces["stops"].values.T @ THREE.stop_directions
    return np.linalg.solve(THREE.mass_matrix, total.T).T @ THREE.direction(where["on"])


def test_an_extreme_at_an_event_has_its_instant_to_the_bit() -> None:
    """The end of a flight and the event there are rounded otherwise: one in six differed."""
    stops = (
        pc.Wall("0.3", "above", "0.5", on=1),
        pc.SoftStop("0.2", "above", 20, "0.5", on=(1, -1, 0)),
    )
    three = pc.chain([1, 2, 1], [1, 3, 2, 0], "0.1", stops)
    loads = pc.Loads({0: pc.cosine("1.5", amplitude=2, constant="0.3"), 1: pc.sine(2)})
    at_events = 0
    for k in range(40):
        run = pc.simulate(three, loads, t0=k / 10, x0=[0, 0, k / 100], t_end=k / 10 + 8)
        events = np.concatenate([run.impacts.t, run.crossings.t, [run.t0, run.t_end]])
        for extrema in (
            run.extremes("displacement", on=1),
            run.extremes("velocity", on=1),
            run.extremes("stop_force", stop=1),
        ):
            for t in (extrema.t_minimum, extrema.t_maximum):
                nearest = events[np.abs(events - t).argmin()]
                if abs(nearest - t) < 1e-12:
                    assert nearest == t
                    at_events += 1
    assert at_events > 80


def test_extremes_of_an_uncoupled_mass_are_those_of_the_oscillator() -> None:
    stop = pc.SoftStop(at="0.3", side="above", stiffness=50, damping=2)
    wall = pc.Wall(at="-0.4", side="below", restitution="0.8")
    alone = pc.Oscillator.from_mass(2, stiffness=3, damping_coefficient="0.1", stops=(stop, wall))
    force = pc.cosine("1.1", amplitude=3)
    one = pc.simulate(alone, force, v0="0.5", t_end=20)
    stops: list[pc.Wall | pc.SoftStop] = [
        pc.SoftStop(at="0.3", side="above", stiffness=50, damping=2, on=0),
        pc.Wall(at="-0.4", side="below", restitution="0.8", on=0),
    ]
    both = pc.Structure([2, 1], [3, 8], ["0.1", 0], stops=stops)
    run = pc.simulate(both, pc.Loads({0: force}), x0=[0, 1], v0=["0.5", 0], t_end=20)

    assert len(run.impacts) == len(one.impacts) > 5
    for of in ("displacement", "velocity", "acceleration", "spring_force", "stop_force"):
        mine, theirs = run.extremes(of, on=0), one.extremes(of)
        for name in ("minimum", "t_minimum", "maximum", "t_maximum"):
            assert getattr(mine, name) == pytest.approx(getattr(theirs, name), abs=1e-11)
    directions: tuple[Literal["up", "down"], ...] = ("up", "down")
    for direction in directions:
        t, exact = run.section(0.1, on=0, direction=direction).t, one.section(0.1, direction).t
        np.testing.assert_allclose(t, exact, rtol=0, atol=1e-11)


def test_the_force_of_a_stop_jumps_at_its_entry_and_both_limits_count() -> None:
    stop = pc.SoftStop(at=0, side="above", stiffness=9, damping=2, on=(1, -1))
    structure = pc.Structure([1, 1], [0, 0], stops=[stop])
    run = pc.simulate(structure, x0=[0, "0.5"], v0=[1, 0], t_end=3)

    extrema = run.extremes("stop_force")
    assert extrema.t_minimum >= 0.5
    assert run.extremes("stop_force", between=(0.5, 0.5)).minimum == pytest.approx(-2, abs=1e-14)
    assert run.extremes("stop_force", between=(0, 0.4)).peak == 0.0


def test_a_section_counts_each_passage_once() -> None:
    """At the edge of a soft stop, at a level that a wall hides, and beside it."""
    run = run_of_three()
    edge = run.section("0.5", on=2)
    np.testing.assert_allclose(edge.t, run.crossings.t, rtol=0, atol=1e-12)
    assert dict(edge.sizes) == {"crossing": len(run.crossings), "coordinate": 3}
    assert run.section(-1, on=0).sizes["crossing"] == 0
    t = np.linspace(0, 30, 300_001)
    for at, on in ((0.0, 0), (0.2, (1.0, -1.0, 0.0)), (-0.1, 1)):
        y = run.displacement(on, t)[0] - at
        section = run.section(at, on=on)
        assert section.sizes["crossing"] == np.count_nonzero(y[1:] * y[:-1] < 0)
        place, speed = run.displacement(on, section.t.values)
        np.testing.assert_allclose(place, at, rtol=0, atol=1e-13)
        up = run.section(at, on=on, direction="up")
        assert up.sizes["crossing"] == np.count_nonzero(speed > 0)


@pytest.mark.parametrize(
    ("call", "reason"),
    [
        (lambda run: run.extremes("power"), r"of = 'power': none of displacement"),
        (lambda run: run.extremes("stop_force", stop=3), r"stop = 3: the structure has 3 stops"),
        (lambda run: run.extremes("velocity", on=3), r"on = 3: no such coordinate"),
        (lambda run: run.extremes("velocity"), r"on = None: not said on what it acts"),
        (lambda run: run.extremes("velocity", on=0, between=(1, 99)), r"not two instants"),
        (lambda run: run.section(0, on="tip"), r"on = 'tip': no such point"),
        (lambda run: run.section(0, on=0, direction="left"), r"direction = 'left'"),
        (lambda run: run.forces([31.0]), r"t = 31\.0: outside the run"),
        (lambda run: run.stroboscopic(), r"loads\.period = None: a stroboscopic view needs"),
    ],
)
def test_what_a_run_cannot_give_is_refused_in_a_sentence(call: Any, reason: str) -> None:
    run = run_of_three(t_end=30.0)
    with pytest.raises(pc.ParameterError, match=reason):
        call(run)


def test_strobes_come_once_a_period_of_the_loads() -> None:
    pair = pc.impact_pair(masses=[1, 1], gap=1, restitution="0.5")
    run = pc.simulate(pair, pc.Loads({0: pc.cosine(2)}), t_end=20, t0=1)
    every, shifted = run.stroboscopic(), run.stroboscopic(cycle=0.25)

    np.testing.assert_allclose(every.t, 1 + math.pi * np.arange(7), rtol=0, atol=1e-13)
    np.testing.assert_allclose(shifted.t % math.pi, math.pi / 4, rtol=0, atol=1e-13)
    np.testing.assert_array_equal(shifted.x.values, run(shifted.t.values)[0])
    with pytest.raises(pc.ParameterError, match=r"cycle = 1\.0: not in \[0, 1\)"):
        run.stroboscopic(cycle=1)


def test_a_run_beyond_a_record_says_so() -> None:
    text = "loads.1: the record lasts from t = 0 to 30, its end values hold beyond"
    assert run_of_three(30.0).beyond_record == ""
    assert run_of_three(31.0).beyond_record == text
    assert text in repr(run_of_three(31.0))


def test_units_label_what_a_run_gives() -> None:
    units = pc.Units("mm", "s", "kg")
    structure = pc.Structure([1, 1], [1, 1], stops=[pc.Wall(1, on=0, side="above")], units=units)
    run = pc.simulate(structure, v0=[2, 0], t_end=5)

    assert run.forces([1.0])["stops"].attrs["units"] == units.of("mass length/time^2")
    assert run.section(0.5, on=0)["v"].attrs["units"] == "mm/s"
    assert run.impacts.to_xarray()["v_before"].attrs["units"] == "mm/s"
    assert "v_before" in run.impacts._repr_html_()


def test_periods_are_those_of_the_oscillator_to_the_bit_and_have_its_faults() -> None:
    """Ten periods of 2 pi / 3: ten times that float is an ulp off."""
    free = pc.Structure([1], [1])
    run = pc.simulate(free, {0: pc.cosine(3)}, periods=10)
    known = pc.simulate(pc.Oscillator(), pc.cosine(3), periods=10)

    assert run.t_end == known.t_end
    two = pc.Loads({0: pc.cosine(1) + pc.cosine("1.4")})
    for loads, periods, reason in (
        (two, 3, "the loads have no common period; give loads.period, or t_end instead"),
        (None, 3, "without harmonics there is no period; give t_end"),
        ({0: pc.cosine(1)}, 0, "not positive"),
        ({0: pc.cosine(1)}, "three", "three"),
    ):
        with pytest.raises(pc.ParameterError, match=reason):
            pc.simulate(free, loads, periods=periods)


def interrupted_at(monkeypatch: pytest.MonkeyPatch, call: int) -> None:
    """Let Ctrl-C come in a call of the kernel, as while it is compiled."""
    march, calls = engine.march, iter(range(1, 10**9))

    def stopped(*arguments: Any) -> int:
        if next(calls) == call:
            raise KeyboardInterrupt
        return int(march(*arguments))

    monkeypatch.setattr(follow_structure, "PATIENCE", 1)
    monkeypatch.setattr(engine, "march", stopped)


def test_ctrl_c_in_the_first_compilation_is_ctrl_c(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution="0.8")
    interrupted_at(monkeypatch, 1)
    with pytest.raises(KeyboardInterrupt):
        pc.simulate(pair, v0=[1, 0], t_end=10)


def test_ctrl_c_later_keeps_what_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution="0.8")
    interrupted_at(monkeypatch, 4)
    run = pc.simulate(pair, v0=[1, 0], t_end=1e6)
    assert run.outcome is pc.Outcome.interrupted
    assert run.t_end < 1e6


def test_ctrl_c_ends_the_search_of_an_orbit(monkeypatch: pytest.MonkeyPatch) -> None:
    wall = pc.Wall(at=0, side="above", restitution="0.7", on=0)
    two = pc.chain(masses=[1, 1], springs=[1, 1, 1], dashpots="0.1", stops=[wall])
    interrupted_at(monkeypatch, 5)
    with pytest.raises(KeyboardInterrupt):
        pc.find_orbit(two, pc.Loads({0: pc.cosine(2)}))


@pytest.mark.parametrize("is_coupled", [False, True])
def test_masses_beside_it_change_nothing_however_many_the_modes(is_coupled: bool) -> None:
    # From a dozen modes on they are taken row by row.
    rng = np.random.default_rng(5)

    def matrices(n: int) -> tuple[Floats, Floats]:
        root, other = rng.normal(size=(2, n, n))
        stiffness = root @ root.T / n + 0.5 * np.eye(n)
        drag = 0.01 * other @ other.T / n if is_coupled else 0.01 * stiffness
        return stiffness, 0.02 * np.eye(n) + drag

    (stiffness, damping), beside = matrices(4), matrices(10)
    whole = [np.zeros((14, 14)), np.zeros((14, 14))]
    for matrix, own, other in zip(whole, (stiffness, damping), beside, strict=True):
        matrix[:4, :4], matrix[4:, 4:] = own, other
    stops = (
        pc.SoftStop("0.3", "above", 20, "0.1", on=0),
        pc.Wall("-0.4", "below", "0.8", on=1),
    )
    few = pc.Structure(np.eye(4), stiffness, damping, stops)
    many = pc.Structure(np.eye(14), whole[0], whole[1], stops)
    force = pc.cosine("1.3", amplitude="0.7")
    record = pc.record([0.0, 3.0, 9.0], [0.0, 0.5, -0.2])

    alone = pc.simulate(few, pc.Loads({0: force, 1: record}), t_end=40)
    together = pc.simulate(many, pc.Loads({0: force, 1: record, 9: pc.cosine("0.9")}), t_end=40)

    assert len(alone.crossings.t) > 10
    assert len(alone.impacts.t) > 3
    assert together.crossings.t == pytest.approx(alone.crossings.t, abs=1e-11)
    assert together.impacts.t == pytest.approx(alone.impacts.t, abs=1e-11)


def test_one_coordinate_is_told_in_the_singular() -> None:
    run = pc.simulate(pc.Structure(1, 1), v0=1, t_end=1)

    assert repr(run).startswith("<StructureTrajectory: 1 coordinate, ")


def test_the_acceleration_is_that_of_a_structure_of_one_mass_and_of_an_oscillator() -> None:
    """In flight, beyond a soft stop and on a wall that holds it; of the shape of the times."""
    stops = (
        pc.SoftStop("0.3", "above", 40, "0.5"),
        pc.Wall(0, "below", "0.4"),
    )
    osc = pc.Oscillator.from_mass(2, stiffness=3, damping_coefficient="0.4", stops=stops)
    held: list[pc.Wall | pc.SoftStop] = [
        pc.SoftStop("0.3", "above", 40, "0.5", on=0),
        pc.Wall(0, "below", "0.4", on=0),
    ]
    one = pc.Structure(2, 3, "0.4", stops=held)
    force = pc.cosine("0.9", amplitude=4, constant=-1)
    t = np.linspace(0, 40, 1202).reshape(2, 601)

    run = pc.simulate(osc, force, x0="0.1", t_end=40)

    same = pc.simulate(one, pc.Loads({0: force}), x0="0.1", t_end=40)
    own = run.acceleration(t)
    assert own.shape == t.shape
    assert np.abs(own - same.acceleration(0, t)).max() < 1e-9
    # Held by the wall, in flight, and pressed by the stop.
    first = run.contacts.start[0]
    assert run.acceleration(first + 1e-3) == 0.0
    x, v = run(t)
    pressed = np.where(x > 0.3, 40 * (x - 0.3) + 0.5 * v, 0.0)
    exact = (4 * np.cos(0.9 * t) - 1 - 3 * x - 0.4 * v - pressed) / 2
    free = x > 1e-6
    assert np.abs(own - exact)[free].max() < 1e-10


def test_accelerations_and_reactions_under_a_record_are_those_of_the_equation_of_motion() -> None:
    """The slope of the record between its knots was left out."""
    knots, values = [0, 2, 3, 9, 30], [0, 1, -2, 1.5, 0]
    stops = (
        pc.SoftStop("0.3", "above", 40, "0.5", on=1),
        pc.Wall("-0.2", "below", "0.3", on=0),
    )
    two = pc.chain([1, 2], [1, "0.5", 0], "0.1", stops)
    wave = pc.cosine("1.3", amplitude="0.2")
    t = np.linspace(0.01, 29, 997)

    run = pc.simulate(two, pc.Loads({0: pc.record(knots, values), 1: wave}), t_end=30)

    x, v = run(t)
    pressed = np.where(x[:, 1] > 0.3, 40 * (x[:, 1] - 0.3) + 0.5 * v[:, 1], 0.0)
    stiffness = np.array([[1.5, -0.5], [-0.5, 0.5]])
    free = np.stack([np.interp(t, knots, values), 0.2 * np.cos(1.3 * t)], axis=1)
    free -= x @ stiffness + v @ np.asarray(two.damping, dtype=np.float64)
    free[:, 1] -= pressed
    (start,), (release,) = run.contacts.start, run.contacts.release
    held = (t >= start) & (t <= release)
    assert 10 < held.sum() < 100
    own = np.stack([run.acceleration(0, t), 2 * run.acceleration(1, t)], axis=1)
    assert np.abs(own - free)[~held].max() < 1e-13
    assert np.abs(own[held, 0]).max() == 0.0
    assert np.abs(own - free)[held, 1].max() < 1e-13
    reaction = run.forces(t).stops.values[1]
    assert np.abs(reaction + free[:, 0])[held].max() < 1e-13
    assert reaction[held].min() > 0.0


@pytest.mark.parametrize(("restitution", "omega"), [("0.4", "0.9"), ("0", "1.7")])
def test_extremes_are_those_of_the_motion_after_a_wall_lets_go(
    restitution: str, omega: str
) -> None:
    """There velocity and acceleration are zero, and it goes back whence it came."""
    wall = pc.Wall(at="0.1", side="above", restitution=restitution, on=0)
    two = pc.chain(masses=[1, 1], springs=[2, 1, 1], dashpots="0.1", stops=[wall])
    run = pc.simulate(two, pc.Loads({0: pc.cosine(omega, amplitude="0.8")}), v0=[1, 0], t_end=70)
    released = run.contacts.release[:-1]
    assert len(released) >= 2

    for start, release in zip(run.contacts.start[:-1], released, strict=True):
        since = 0.5 * (start + release)
        if since > 60.0:
            continue
        x = run(np.linspace(since, since + 6.0, 2001))[0][:, 0]
        found = run.extremes("displacement", on=0, between=(since, since + 6.0))
        assert 0.0 <= x.min() - found.minimum < 1e-4
        assert found.maximum == pytest.approx(0.1, rel=1e-12)


def test_a_turn_after_a_release_from_forces_that_cancel_is_not_missed() -> None:
    """On the wall's own mode the acceleration is the rounding of the load, of 1e-16 of its terms."""
    k, damping, load = 2.3323376771651705, 0.09466019226988065, 2.5885784183433356
    wall = pc.Wall(0, "above", "0.8", on=0)
    one = pc.Structure([1], [k], [2 * damping], [wall])
    force = pc.cosine("0.5", amplitude=load, phase=0.01696219311972036)
    run = pc.simulate(one, pc.Loads({0: force}), t_end=8)
    x = run(np.linspace(2.0, 8.0, 60_001))[0][:, 0]

    found = run.extremes("displacement", on=0, between=(2.0, 8.0))

    assert run.contacts.start[0] == 0.0
    assert 0.0 <= x.min() - found.minimum < 1e-7


@pytest.mark.parametrize("t_end", [300.0, 4000.0])
def test_a_motion_that_grows_without_events_ends_with_its_numbers(t_end: float) -> None:
    """One long flight had the outcome of a run that reaches its end, with numbers beyond floats."""
    pair = pc.Structure([1, 1], [[-6, -1], [-1, 1]], [["0.4", "-0.2"], ["-0.2", "0.2"]])
    run = pc.simulate(pair, pc.Loads({0: pc.cosine("1.2")}), t_end=t_end)
    assert run.outcome is pc.Outcome.overflow
    assert 1e149 < np.abs(run(run.t_end)).max() < 1.0000001e150

    alone = pc.simulate(pc.Structure([1], [-6]), pc.Loads({0: pc.cosine(2)}), t_end=t_end)
    same = pc.simulate(pc.Oscillator(-6), pc.cosine(2), t_end=t_end)
    assert alone.outcome is same.outcome
    assert alone.t_end == pytest.approx(same.t_end, rel=1e-12)
