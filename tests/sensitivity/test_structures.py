"""Sensitivities of structures: against those of oscillators, and differences of their oracle."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import Any, TypeAlias, get_args

import mpmath
import numpy as np
import pytest
from tests.oracle.event_driven import number
from tests.oracle.structures import StructureRun, simulate_structure, structure_problem
from tests.oracle.test_structures import of_mass_one

import percuss as pc
from percuss.arrays import Complexes, Floats
from percuss.model import as_fraction
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import PiTimes, angle
from percuss.model.paths import get_parameter, replace_parameter
from percuss.motion.moved_measures import MovedMeasure, has_rigid_stops
from percuss.motion.structure_measures import structure_measure_and_derivative
from percuss.orbits.orbit.structure_orbit import map_between

# The error of a central difference is H^2 times a third derivative, and 1e-50 / H by rounding.
H = Fraction(1, 10**13)
CLOSE = 1e-10
AnyNumbers: TypeAlias = Floats | Complexes


def assert_close(found: AnyNumbers, wanted: AnyNumbers, close: float = CLOSE) -> None:
    """Compare columns with each other, relative to their largest entry."""
    assert found.shape == wanted.shape
    assert (np.isnan(found) == np.isnan(wanted)).all()
    size = np.nanmax(np.abs(wanted), initial=0.0)
    assert (np.nan_to_num(np.abs(found - wanted)) <= close * size + 1e-13).all()


# -- one coordinate --------------------------------------------------------------------------------


def as_structure(path: str) -> str:
    """Return the path of a parameter of an oscillator in the structure of mass 1."""
    for old, new in (
        ("oscillator.stops", "structure.stops"),
        ("oscillator.stiffness", "structure.stiffness.0.0"),
        ("oscillator.damping", "structure.damping.0.0"),
        ("forcing.", "loads.0."),
        ("start.x0", "start.x0.0"),
        ("start.v0", "start.v0.0"),
    ):
        path = path.replace(old, new)
    return path


OF_ONE = (
    "oscillator.stiffness", "oscillator.damping", "oscillator.stops.0.at", "forcing.constant",
    "start.x0", "start.v0", "start.t0",
)  # fmt: skip
OF_WAVE = ("forcing.amplitude", "forcing.omega", "forcing.phase")
SOFT = pc.SoftStop(at="0.3", side="above", stiffness="12", damping="0.4")
RECORD = pc.record([0, "0.7", "1.9", 3], ["0.2", 1, "-0.5", "0.4"], repeat=True)
CASES: dict[str, tuple[pc.Oscillator, pc.Forcing, dict[str, Any], tuple[str, ...]]] = {
    "wall": (
        pc.Oscillator(damping="0.05", stops=(pc.Wall(at="0.2", side="above", restitution="0.8"),)),
        pc.cosine(2, constant="0.1"),
        {"v0": "0.5", "t_end": 12.5},
        (*OF_WAVE, "oscillator.stops.0.restitution"),
    ),
    "chatter, contact, release": (
        pc.Oscillator("0.1", "0.05", stops=(pc.Wall(at=0, side="below", restitution="0.4"),)),
        pc.cosine("0.7", constant="-0.6"),
        {"x0": "0.5", "t_end": 20},
        (*OF_WAVE, "oscillator.stops.0.restitution"),
    ),
    "plastic impact": (
        pc.Oscillator("0.1", "0.05", stops=(pc.Wall(at=0, side="below", restitution=0),)),
        pc.cosine("0.7", constant="-0.6"),
        {"x0": "0.5", "t_end": 20},
        OF_WAVE,
    ),
    "soft stop": (
        pc.Oscillator(damping="0.02", stops=(SOFT,)),
        pc.cosine("1.7", phase="0.4"),
        {"v0": "0.5", "t_end": 12.5},
        (*OF_WAVE, "oscillator.stops.0.stiffness", "oscillator.stops.0.damping"),
    ),
    "so many periods": (
        pc.Oscillator(damping="0.02", stops=(SOFT,)),
        pc.cosine("1.7", phase="0.4"),
        {"v0": "0.5", "t0": "0.2", "periods": "9/4"},
        OF_WAVE,
    ),
    "record": (
        pc.Oscillator(damping="0.1", stops=(pc.Wall(at="0.2", side="above", restitution="0.7"),)),
        RECORD,
        {"v0": "0.5", "t_end": 9.5},
        ("forcing.record.amplitude", "oscillator.stops.0.restitution"),
    ),
    "a wave that jumps": (
        pc.Oscillator(damping="0.1", stops=(pc.Wall(at="0.4", side="above", restitution="0.7"),)),
        pc.square_wave("1.3"),
        {"v0": "0.5", "t_end": 9.5},
        ("forcing.record.amplitude", "forcing.record.omega"),
    ),
    "critically damped": (
        pc.Oscillator(1, 1, stops=(pc.Wall(at="0.2", side="above", restitution="0.8"),)),
        pc.cosine(2, amplitude=2),
        {"v0": "0.5", "t_end": 9.5},
        OF_WAVE,
    ),
    "resonance, growing": (
        pc.Oscillator(4, "-0.01", stops=(pc.Wall(at=1, side="above", restitution="0.8"),)),
        pc.cosine(2),
        {"v0": "0.5", "t_end": 9.5},
        OF_WAVE,
    ),
}


@pytest.mark.parametrize("name", CASES)
def test_one_coordinate_has_the_sensitivities_of_the_oscillator(name: str) -> None:
    osc, force, limits, more = CASES[name]
    paths = [*OF_ONE, *more]
    # The damping of an oscillator is half of that of a structure of mass 1.
    halves = np.array([2.0 if path.endswith("damping") else 1.0 for path in paths])
    run, other = (pc.simulate(one, force, **limits) for one in (osc, of_mass_one(osc)))
    wanted = run.sensitivity(paths)
    derivatives = other.sensitivity([as_structure(path) for path in paths])

    for table, column in (
        ("impacts", "t"), ("impacts", "v_before"), ("impacts", "v_after"), ("crossings", "t"),
        ("crossings", "v"), ("contacts", "start"), ("contacts", "release"),
    ):  # fmt: skip
        one, two = (getattr(getattr(d, table), column) for d in (wanted, derivatives))
        assert_close(two * halves, one)
    times = np.linspace(run.t0, run.t_end, 37)
    for one, two in zip(wanted(times), derivatives(times), strict=True):
        assert_close(two[:, 0] * halves, one)
    rigid = has_rigid_stops(osc.stops)
    for measure in get_args(MovedMeasure):
        if rigid and measure == "peak_stop_force" and not run.extremes("stop_force").peak:
            continue
        one, two = wanted.of(measure), derivatives.of(measure) * halves
        assert_close(two[:, None], one[:, None], 1e-9)


def test_a_graze_has_the_sides_and_the_square_root_of_the_oscillator() -> None:
    osc = pc.Oscillator(stops=(pc.Wall(at=1, side="above", restitution="0.8"),))
    run, other = (pc.simulate(one, v0=1, t_end=4) for one in (osc, of_mass_one(osc)))
    wanted, found = (
        motion.sensitivity([path, "start.t0"])
        for motion, path in ((run, "start.v0"), (other, "start.v0.0"))
    )

    assert not found.differentiable
    assert found.reason == wanted.reason.replace("start.v0", "start.v0.0")
    assert_close(found.grazes.reach, wanted.grazes.reach)
    assert_close(found.grazes.speed, wanted.grazes.speed)
    assert np.isnan(found(3.0)[0]).all()
    assert_close(found.one_sided()(3.0)[0], wanted.one_sided()(3.0)[0][None])
    assert_close(found.square_root()(3.0)[0], wanted.square_root()(3.0)[0][None])


def test_both_sides_of_a_graze_of_two_masses() -> None:
    """Both move as one, and the first comes to rest at the wall; the spring between tells more."""
    wall = pc.Wall(at=1, side="above", restitution="0.8", on=0)
    two = pc.chain(masses=[1, 1], springs=[1, "0.7", 1], stops=[wall])

    def moved(step: float) -> Floats:
        states = [pc.simulate(two, v0=[1 + h, 1], t_end=3)(3.0) for h in (step, 0)]
        return np.concatenate(states[0]) - np.concatenate(states[1])

    d = pc.simulate(two, v0=[1, 1], t_end=3).sensitivity(["start.v0.0"])
    assert d.grazes.sides.tolist() == [-1]
    free, struck = (np.concatenate(one(3.0))[:, 0] for one in (d.one_sided(), d.square_root()))
    assert_close(moved(-1e-6) / -1e-6, free, 1e-8)
    assert_close(moved(1e-8) / 1e-4, struck, 1e-3)


# -- several coordinates, against the oracle -------------------------------------------------------


def moved_oracle(run: pc.StructureTrajectory, path: str, step: Fraction) -> StructureRun:
    """Return the motion of the oracle at a moved parameter."""
    values = run.structure, run.loads, run.start
    value = get_parameter(*values, path)
    times, plus = angle(value)
    moved = PiTimes(times, plus + step) if times else plus + step
    structure, loads, start = replace_parameter(*values, path, moved)
    with mpmath.workdps(100):
        times, plus = angle(start.t0)
        t0 = number(times) * mpmath.pi + number(plus)
    return simulate_structure(
        structure_problem(structure, loads),
        [as_fraction(x) for x in start.x0],
        [as_fraction(v) for v in start.v0],
        t0,
        t_end=run.t_end,
    )


def differences(
    run: pc.StructureTrajectory, path: str, times: Sequence[float]
) -> tuple[Floats, Floats, Floats]:
    """Return the differences of events' instants, of x and of v at times, by a parameter."""
    ahead, behind = (moved_oracle(run, path, step) for step in (H, -H))
    kinds = [event.kind for event in ahead.events]
    assert kinds == [event.kind for event in behind.events]
    with mpmath.workdps(100):
        step = 2 * mpmath.mpf(H.numerator) / H.denominator

        def by_step(one: Sequence[Any], other: Sequence[Any]) -> Floats:
            return np.array([float((a - b) / step) for a, b in zip(one, other, strict=True)])

        instants = by_step(
            [event.t for event in ahead.events], [event.t for event in behind.events]
        )
        states = [(ahead(t), behind(t)) for t in times]
        x, v = (np.array([by_step(a[k], b[k]) for a, b in states]) for k in range(2))
    return instants, x, v


def events_of(d: pc.StructureSensitivity) -> Floats:
    """Return the derivatives of all instants in the order of the oracle's events."""
    run = d.run
    tables: list[tuple[Floats, Floats]] = [
        (run.impacts.t, d.impacts.t), (run.crossings.t, d.crossings.t),
        (run.contacts.start, d.contacts.start), (run.contacts.release, d.contacts.release),
    ]  # fmt: skip
    instants = np.concatenate([t for t, _ in tables])
    moved = np.concatenate([column for _, column in tables])
    known = ~np.isnan(instants)
    return np.asarray(moved[known][np.argsort(instants[known], kind="stable")])


def check(run: pc.StructureTrajectory, *paths: str, close: float = CLOSE) -> None:
    """Compare all derivatives of a run with differences of the oracle."""
    d = run.sensitivity(paths)
    assert d.differentiable
    events = np.unique(run.record.events[:, 0])
    middles = 0.5 * (events[1:] + events[:-1])
    times = [float(t) for t in [*middles[:2], *middles[-2:], run.t_end]]
    dx, dv = d(times)
    instants = events_of(d)
    for p, path in enumerate(paths):
        t, x, v = differences(run, path, times)
        assert_close(instants[:, p], t, close)
        assert_close(dx[..., p], x, close)
        assert_close(dv[..., p], v, close)


WALL = pc.Wall(at="0.3", side="above", restitution="0.8", on=0)
BETWEEN = pc.SoftStop(at="0.25", side="below", stiffness=30, damping="0.4", on=(1, -1))


def test_two_masses_with_a_wall_and_a_soft_stop_between_them() -> None:
    structure = pc.Structure(
        mass=[[1, "0.1"], ["0.1", 2]],
        stiffness=[[3, -1], [-1, "1.5"]],
        damping=[["0.05", "-0.01"], ["-0.01", "0.03"]],
        stops=[WALL, BETWEEN],
    )
    loads = pc.Loads({0: pc.cosine(2, amplitude="1.3", phase="0.2", constant="0.1")})
    run = pc.simulate(structure, loads, x0=["0.1", "-0.2"], v0=["0.4", "0.2"], t0="0.1", t_end=3.5)
    assert len(run.impacts) >= 1
    assert len(run.crossings) >= 2
    check(
        run, "structure.mass.0.0", "structure.mass.0.1", "structure.stiffness.0.1",
        "structure.damping.1.1", "structure.stops.0.at", "structure.stops.0.restitution",
        "structure.stops.1.stiffness", "structure.stops.1.damping", "structure.stops.1.at",
        "loads.0.harmonics.0.omega", "loads.0.harmonics.0.phase", "start.v0.1", "start.t0",
    )  # fmt: skip


def test_a_wall_that_lets_go_as_the_dashpot_of_a_soft_stop_sets_in() -> None:
    """The release is as late as the crossing that jumps the forces, for perturbations too."""
    structure = pc.Structure(
        mass=[["1.15", "0.1"], ["0.1", 1]],
        stiffness=[[3, -1], [-1, "2.13"]],
        damping=[["0.2", "-0.1"], ["-0.1", "0.2"]],
        stops=[
            pc.Wall("0.2932", "above", 0, on=1),
            pc.SoftStop("-0.0845", "below", "18.3", "0.65", on=(1, -1)),
        ],
    )
    loads = pc.Loads({0: pc.cosine("1.855"), 1: pc.Forcing(constant="0.87")})
    run = pc.simulate(structure, loads, v0=[0, "0.3"], t_end=2.5)
    assert run.contacts.release[0] in run.crossings.t
    check(run, "structure.stops.0.at", "structure.stops.1.at", "loads.0.harmonics.0.omega")

    # And by the start, as orbits take it.
    system, end = StructureSystem(structure, loads), 2.5
    state = np.array([0.0, 0.0, 0.0, 0.3])
    matrix = map_between(system, state, (0.0, end), "so long").derivative
    for k in range(4):
        ahead, behind = (
            map_between(
                system, state + way * np.eye(4)[k], (0.0, end), "so long", derivative=False
            ).image
            for way in (1e-6, -1e-6)
        )
        assert matrix[:, k] == pytest.approx((ahead - behind) / 2e-6, abs=1e-7)


def test_equal_poles_gyroscopic_and_free_motions() -> None:
    """A mode has no derivative where two poles are equal; the motion has."""
    for stiffness, damping in (
        ([2, 2], [0, 0]),
        ([1, 1], [2, 2]),
        ([[1, -1], [-1, 1]], 0),
        ([2, 2], [[0, "0.5"], ["-0.5", 0]]),
    ):
        structure = pc.Structure(mass=[1, 1], stiffness=stiffness, damping=damping)
        loads = pc.Loads({(1, "0.5"): pc.cosine("1.3")})
        run = pc.simulate(structure, loads, x0=["0.1", "-0.2"], v0=[1, "0.2"], t_end=3.0)
        check(
            run, "structure.stiffness.0.1", "structure.stiffness.0.0", "structure.damping.0.1",
            "structure.mass.0.1",
        )  # fmt: skip


def test_chatter_and_contact_of_a_structure() -> None:
    """What a wall holds goes on with memory: the other mass moves."""
    structure = pc.Structure(
        mass=[[1, "0.1"], ["0.1", 2]],
        stiffness=[[2, -1], [-1, "1.5"]],
        damping=[["0.05", "-0.01"], ["-0.01", "0.03"]],
        stops=[pc.Wall(at=0, side="below", restitution="0.3", on=0)],
    )
    loads = pc.Loads({0: pc.cosine("0.8", amplitude="0.9", constant="-0.5")})
    run = pc.simulate(structure, loads, x0=["0.3", "-0.2"], v0=[0, "0.5"], t_end=14.0)
    d = run.sensitivity(["structure.mass.0.1", "structure.damping.0.0", "start.v0.1",
                         "structure.stops.0.restitution", "structure.stops.0.at"])  # fmt: skip
    assert len(run.contacts) >= 1
    assert np.isfinite(run.contacts.release[0])
    t = run.t_end
    for p, path in enumerate(d.paths):
        ahead, behind = (moved_oracle(run, path, step) for step in (H, -H))
        with mpmath.workdps(100):
            step = 2 * mpmath.mpf(H.numerator) / H.denominator
            pairs = list(zip(ahead(t), behind(t), strict=True))
            wanted = np.array(
                [[float((a - b) / step) for a, b in zip(*pair, strict=True)] for pair in pairs]
            )
            releases = [
                [event.t for event in one.events if event.kind == "release"]
                for one in (ahead, behind)
            ]
            moved = np.array([float((a - b) / step) for a, b in zip(*releases, strict=True)])
        assert_close(np.concatenate([column[..., p] for column in d(t)]), wanted.reshape(-1))
        known = ~np.isnan(run.contacts.release)
        assert_close(d.contacts.release[known, p], moved)


# -- measures, and orbits, against differences of runs ---------------------------------------------


def by_richardson(values: Callable[[float], Floats], at: float, step: float) -> Floats:
    """Return the derivative from differences of the eighth order."""
    steps = [step / 2**k for k in range(4)]
    found = [(values(at + h) - values(at - h)) / (2 * h) for h in steps]
    for k in range(1, 4):
        found = [
            (4**k * one - other) / (4**k - 1)
            for one, other in zip(found[1:], found[:-1], strict=True)
        ]
    return np.asarray(found[0])


def beam(
    damping: float = 0.13, at: float = 0.2, amplitude: float = 0.4, omega: float = 1.7
) -> tuple[pc.Structure, pc.Loads]:
    stops: list[pc.Wall | pc.SoftStop] = [
        pc.Wall(at=at, side="above", restitution=0.7, on=0),
        pc.SoftStop(at=-0.2, side="below", stiffness=100, damping=0.3, on=1),
    ]
    damped = [[damping, -0.03], [-0.03, 0.16]]
    structure = pc.Structure([1, 1], [[1, -1], [-1, 2]], damped, stops)
    return structure, pc.Loads({1: pc.cosine(omega, amplitude=amplitude)})


BEAM_PATHS = {
    "damping": "structure.damping.0.0",
    "at": "structure.stops.0.at",
    "amplitude": "loads.0.amplitude",
    "omega": "loads.0.omega",
}


def measures_of(motion: Any, on: Any) -> Floats:
    d = motion.sensitivity(["loads.0.amplitude"])
    d = getattr(d, "motion", d)
    measures = get_args(MovedMeasure)
    return np.array([structure_measure_and_derivative(d, name, on)[0] for name in measures])


@pytest.mark.parametrize("name", BEAM_PATHS)
def test_measures_of_a_run(name: str) -> None:
    def run(value: float | None = None) -> pc.StructureTrajectory:
        structure, loads = beam(**({} if value is None else {name: value}))
        return pc.simulate(structure, loads, v0=[1, 0], t_end=9)

    d = run().sensitivity(list(BEAM_PATHS.values()))
    found = np.array([d.of(measure, (1, 0.5)) for measure in get_args(MovedMeasure)])
    value = inspect.signature(beam).parameters[name].default
    wanted = by_richardson(lambda p: measures_of(run(p), (1, 0.5)), value, 2e-4)
    assert_close(found[:, list(BEAM_PATHS).index(name)], wanted, 1e-8)


@pytest.mark.parametrize("name", BEAM_PATHS)
def test_an_orbit(name: str) -> None:
    orbit = pc.find_orbit(*beam())

    def values(p: float) -> Floats:
        other = pc.find_orbit(*beam(**{name: p}), guess=orbit)
        state = [*other.x0, *other.v0, *other.run.impacts.t, *other.run.impacts.v_before]
        largest = other.multipliers[0]
        mine = [largest.real, largest.imag, other.period]
        return np.array([*state, *mine, *measures_of(other, 1)])

    d = orbit.sensitivity(list(BEAM_PATHS.values()))
    measures = [d.of(measure, 1) for measure in get_args(MovedMeasure)]
    largest = d.multipliers[0]
    own = [largest.real, largest.imag, d.period]
    found = np.array([*d.x0, *d.v0, *d.impacts.t, *d.impacts.v_before, *own, *measures])
    value = inspect.signature(beam).parameters[name].default
    wanted = by_richardson(values, value, 2e-3)
    assert_close(found[:, list(BEAM_PATHS).index(name)], wanted, 1e-8)


TABLE = pc.restitution_table(speeds=(0, 1, 3), values=("0.9", "0.8", "0.6"))
FORCED: dict[str, tuple[pc.Oscillator, pc.Forcing, tuple[str, ...]]] = {
    "wall": (*CASES["wall"][:2], ("oscillator.stops.0.restitution", "forcing.omega")),
    "table": (
        pc.Oscillator(damping="0.05", stops=(pc.Wall("0.2", "above", TABLE),)),
        pc.cosine(2),
        ("oscillator.stops.0.restitution.values.1", "oscillator.stops.0.restitution.speeds.1"),
    ),
    "soft": (*CASES["soft stop"][:2], ("oscillator.stops.0.stiffness", "forcing.omega")),
    "wave": (*CASES["a wave that jumps"][:2], ("forcing.record.omega", "forcing.record.amplitude")),
}


@pytest.mark.parametrize("name", FORCED)
def test_multipliers_of_one_coordinate_are_moved_as_those_of_the_oscillator(name: str) -> None:
    osc, force, more = FORCED[name]
    paths = ["oscillator.stiffness", "oscillator.damping", "oscillator.stops.0.at", *more]
    halves = np.array([2.0 if path == "oscillator.damping" else 1.0 for path in paths])
    one = pc.find_orbit(osc, force)
    other = pc.find_orbit(of_mass_one(osc), force)
    assert_close(other.multipliers, one.multipliers)
    wanted = one.sensitivity(paths).multipliers
    found = other.sensitivity([as_structure(path) for path in paths]).multipliers * halves
    assert_close(found, wanted, 1e-9)


def test_multipliers_of_an_orbit_that_rests_or_of_equal_ones_have_no_derivative() -> None:
    two = pc.Structure([1, 1], [[1, 0], [0, 1]], ["0.1", "0.1"])
    orbit = pc.find_orbit(two, pc.Loads({0: pc.cosine(2)}))
    assert np.isnan(orbit.sensitivity(["structure.stiffness.0.0"]).multipliers).all()

    wall = pc.Wall(at=0, side="below", restitution="0.3", on=0)
    held = pc.chain(masses=[1, 1], springs=[1, 1, 0], dashpots="0.2", stops=[wall])
    orbit = pc.find_orbit(held, pc.Loads({0: pc.cosine("0.8", amplitude=1, constant=-1)}))
    assert len(orbit.run.contacts)
    d = orbit.sensitivity(["structure.stops.0.restitution"])
    assert np.isfinite(d.x0).all()
    assert np.isnan(d.multipliers).all()


def test_an_orbit_closes_for_all_parameters() -> None:
    orbit = pc.find_orbit(*beam())
    d = orbit.sensitivity(list(BEAM_PATHS.values()))

    end, fast = (np.asarray(part) for part in d(orbit.period))
    slope = (orbit.run(orbit.period)[1], orbit.run.forces(orbit.period))
    pushes = slope[1].spring + slope[1].damping + slope[1].loads
    stops = orbit.structure.stop_directions.T @ slope[1].stops.values
    acceleration = pushes.values[0] + stops[:, 0]
    assert_close(end + slope[0][:, None] * d.period, d.x0)
    assert_close(fast + acceleration[:, None] * d.period, d.v0)


def test_a_frequency_that_leaves_the_loads_without_a_period_is_refused() -> None:
    structure = pc.Structure([1, 1], [[1, -1], [-1, 2]], ["0.1", "0.2"])
    loads = pc.Loads({0: pc.cosine(2), 1: pc.cosine(2)})
    orbit = pc.find_orbit(structure, loads)

    with pytest.raises(pc.ParameterError, match="without a period"):
        orbit.sensitivity(["loads.0.omega"])


def test_the_gradient_of_a_measure() -> None:
    structure, loads = beam()
    path = BEAM_PATHS["at"]
    run = pc.simulate(structure, loads, t_end=6)

    found = pc.gradient("peak_impact_velocity", structure, loads, wrt=[path], t_end=6)
    assert found == pytest.approx(run.sensitivity([path]).of("peak_impact_velocity"), rel=1e-15)
    with pytest.raises(pc.ParameterError, match="of structures"):
        pc.gradient("max_displacement", pc.Oscillator(), wrt=["start.v0"], on=0, t_end=1)


def test_walls_that_are_struck_at_one_instant() -> None:
    """Which comes first depends on the sign of a change, unless both instants move alike."""
    walls = [pc.Wall(at=1, side="above", restitution=0.8, on=i) for i in (0, 1)]
    structure = pc.Structure([[2, 1], [1, 2]], [0, 0], stops=walls)
    run = pc.simulate(structure, v0=[1, 1], t_end=2)
    first, second = run.impacts.t[:2].tolist()
    assert first == second
    assert first == pytest.approx(1, abs=1e-15)

    d = run.sensitivity(["start.v0.0", "start.t0"])
    assert np.isnan(d(1.5)[1][:, 0]).all()
    assert np.isfinite(d(1.5)[1][:, 1]).all()


@pytest.mark.parametrize("jump", [f"{k / 70:.3f}" for k in range(1, 13)])
def test_an_acceleration_that_is_largest_at_the_jump_of_a_load(jump: str) -> None:
    """Where the end of a flight rounds otherwise than the event, the other side was taken."""
    force = pc.record([-8, jump, 5], [1, "0.2", 0], "hold") + pc.cosine("0.2", phase="-0.5")
    paths = ["forcing.constant", "forcing.record.amplitude"]
    begin = (0, "0.3", "-7.3")
    one = pc.simulate(pc.Oscillator(0), force, start=begin, t_end=1)
    run = pc.simulate(pc.Structure([1], [0]), pc.Loads({0: force}), start=begin, t_end=1)
    for motion in (one, run):
        assert motion.extremes("acceleration").t_maximum == float(jump)
    found = run.sensitivity([path.replace("forcing", "loads.0") for path in paths])
    assert_close(found.of("peak_acceleration"), one.sensitivity(paths).of("peak_acceleration"))


@pytest.mark.parametrize("path", ["amplitude", "constant"])
def test_an_acceleration_that_is_largest_as_a_chatter_ends(path: str) -> None:
    """In its summed tail the largest value moves with the last impact."""
    structure = pc.Structure(
        [["2.14", "0.2", 0], ["0.2", "0.5", 0], [0, 0, "0.74"]],
        [["3.3", "-1.35", 0], ["-1.35", "2.16", "-0.81"], [0, "-0.81", "0.81"]],
        [["0.53", "-0.135", 0], ["-0.135", "0.216", "-0.081"], [0, "-0.081", "0.081"]],
        [
            pc.Wall("0.612", "above", "0.53", on=1),
            pc.Wall("0.638", "above", "0.4", on=(0, 1, -1)),
        ],
    )
    on = ("-0.3", "-0.58", "-1.11")

    def run(changed: float = 0.0) -> pc.StructureTrajectory:
        push, force = 0.0, pc.record(["1.394", "4.167"], ["3.017", "0.564"])
        if path == "amplitude":
            force = (1.0 + changed) * force
        else:
            push = changed
        waves = pc.cosine("0.975", amplitude="0.422", phase="3.12")
        waves += pc.cosine("2.176", amplitude="0.361", phase="2.07")
        loads = pc.Loads(
            {
                1: waves + force + pc.Forcing(constant=push),
                0: pc.cosine("2.519", amplitude="-0.201", phase="4.54"),
            }
        )
        return pc.simulate(structure, loads, v0=["-0.197", "0.459", "1.793"], t0="3.25", t_end=6)

    extrema = run().extremes("acceleration", on=on)
    (start,) = run().contacts.start
    assert run().impacts.t[-1] < extrema.t_maximum < start
    assert extrema.maximum == extrema.peak
    of = f"loads.0.{'record.amplitude' if path == 'amplitude' else 'constant'}"
    found = run().sensitivity([of]).of("peak_acceleration", on)
    near = [run(h).extremes("acceleration", on=on).maximum for h in (-1e-5, 1e-5)]
    assert_close(found, np.array([(near[1] - near[0]) / 2e-5]), 1e-5)


def test_an_acceleration_that_is_largest_where_a_wall_begins_to_hold() -> None:
    """The structure has it up to the rest, in which the derivative was 0; another wall holds."""
    walls = [pc.Wall(at=0.1, side="above", restitution=0.5, on=i) for i in (0, 1)]
    on = (0, 1, 1)

    def run(mass: float = 0.9, amplitude: float = 1.0) -> pc.StructureTrajectory:
        stiffness = [[3, -1, 0], [-1, 3, -1], [0, -1, 2]]
        structure = pc.Structure([0.8, mass, 0.7], stiffness, [0.2, 0.2, 0.1], stops=walls)
        loads = {0: pc.Forcing(constant=6), 1: amplitude * pc.record([0, 2], [-3, 9])}
        return pc.simulate(structure, pc.Loads(loads), t_end=2)

    def peak(motion: pc.StructureTrajectory) -> Floats:
        return np.array([motion.extremes("acceleration", on=on).peak])

    extrema, contacts = run().extremes("acceleration", on=on), run().contacts
    assert contacts.stop.tolist() == [0, 1]
    assert extrema.t_maximum == contacts.start[1]
    d = run().sensitivity(["structure.mass.1.1", "loads.1.record.amplitude"])
    wanted = [
        by_richardson(lambda mass: peak(run(mass)), 0.9, 1e-2),
        by_richardson(lambda amplitude: peak(run(amplitude=amplitude)), 1.0, 1e-2),
    ]
    assert_close(d.of("peak_acceleration", on), np.concatenate(wanted), 1e-9)
