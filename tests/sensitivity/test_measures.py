"""Derivatives of measures against differences of the measures themselves."""

from __future__ import annotations

from typing import Any, get_args

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.measures import MEASURES
from percuss.model.paths import get_parameter, replace_parameter
from percuss.motion.moved_measures import MovedMeasure
from percuss.numerics import gauss_legendre

WALL = pc.Oscillator(damping="0.05", stops=(pc.Wall(at="0.2", side="above", restitution="0.6"),))
SOFT = pc.Oscillator.from_mass(
    2, 3, damping_coefficient="0.3", stops=(pc.SoftStop("0.2", "above", 60, "1.5"),)
)
HELD = pc.Oscillator(1, "0.1", stops=(pc.Wall(at="-0.4", side="below", restitution="0.3"),))
CASES = {
    "wall": (WALL, pc.cosine("2.1", constant="0.1")),
    "soft": (SOFT, pc.cosine("1.7", amplitude=4)),
    "held": (HELD, pc.cosine("0.7", phase=2, constant="-0.4")),
    "square wave": (WALL, pc.square_wave("1.3", 1)),
}
STOP = "oscillator.stops.0.at"
PATHS = {
    "wall": (STOP, "oscillator.damping", "forcing.omega", "forcing.constant"),
    "soft": (STOP, "oscillator.stops.0.damping", "oscillator.mass", "forcing.amplitude"),
    "held": (STOP, "oscillator.stiffness", "forcing.amplitude", "start.v0"),
    "square wave": (STOP, "forcing.record.omega", "forcing.record.amplitude"),
}
# A central difference of eighth order: by rounding its error is some 1e-15 / STEP.
STEP = 1e-3
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)


def value_of(run: pc.Trajectory, measure: str) -> float:
    """Return a measure of a run, from its extremes, tables and fine integrals."""
    if measure.endswith("_displacement") and not measure.startswith("rms"):
        ends = run.extremes("displacement")
        least, largest = ends.minimum, ends.maximum
        return {"max": largest, "min": least, "peak": max(largest, -least)}[
            measure.split("_", maxsplit=1)[0]
        ]
    if measure == "peak_acceleration":
        return run.extremes("acceleration").peak
    if measure == "peak_stop_force":
        return run.extremes("stop_force").peak
    if measure == "peak_impact_velocity":
        entries = run.crossings.v[run.crossings.direction == "in"]
        return float(np.abs(np.concatenate([run.impacts.v_before, entries])).max())
    edges = np.unique(np.append(run.record[0][:, 0], run.t_end))
    nodes, weights = gauss_legendre(30)
    middles, halves = 0.5 * (edges[1:] + edges[:-1])[:, np.newaxis], 0.5 * np.diff(edges)
    t = (middles + halves[:, np.newaxis] * nodes).reshape(-1)
    x, v = run(t)
    if measure == "rms_displacement":
        values = x * x
    elif measure == "contact_share":
        values = (np.abs(run.forces(t).stops.values[0]) > 0.0).astype(float)
    else:
        values = run.forces(t).forcing.values * v
    total = float((halves[:, np.newaxis] * weights).reshape(-1) @ values)
    mean = total / (edges[-1] - edges[0])
    return float(np.sqrt(mean)) if measure == "rms_displacement" else mean


def difference(run: pc.Trajectory, path: str, measure: str) -> float:
    """Return the central difference of eighth order of a measure."""
    values = run.oscillator, run.forcing, run.start
    middle = float(pc.expression(str(get_parameter(*values, path))))

    def at(step: float) -> float:
        osc, force, start = replace_parameter(*values, path, middle + step)
        return value_of(pc.simulate(osc, force, start=start, t_end=run.t_end), measure)

    pairs = enumerate(WEIGHTS, start=1)
    return sum(weight * (at(k * STEP) - at(-k * STEP)) for k, weight in pairs) / STEP


@pytest.mark.parametrize("measure", get_args(MovedMeasure))
@pytest.mark.parametrize("case", CASES)
def test_measures_of_a_run(case: str, measure: MovedMeasure) -> None:
    run = pc.simulate(*CASES[case], "-0.1", "0.5", t_end=11.3)
    derivative = run.sensitivity(PATHS[case])
    if measure == "peak_stop_force" and case in ("wall", "square wave"):
        with pytest.raises(
            pc.ParameterError, match="a rigid wall has impulses in place of a force"
        ):
            derivative.of(measure)
        return
    found = derivative.of(measure)
    wanted = [difference(run, path, measure) for path in PATHS[case]]
    size = np.abs(wanted).max()
    np.testing.assert_allclose(found, wanted, rtol=1e-10, atol=1e-10 * size + 1e-13)


# Against a wall above.
PRESS = pc.Forcing(constant=4)
STEPS = pc.record([0, "0.7", "1.9", 3], ["0.2", 1, "-0.5", "0.4"], repeat=True)


@pytest.mark.parametrize(
    ("measure", "force", "start"),
    [("peak_acceleration", STEPS, ("0.1", "0.38")), ("peak_stop_force", STEPS + PRESS, ("-0.5", 0)),
     ("peak_stop_force", pc.triangle_wave("1.3", amplitude="0.7") + PRESS, ("-0.5", 0))],
    ids=["a flight", "a contact", "a wave in contact"],
)  # fmt: skip
def test_a_peak_before_a_jump_of_the_force_is_moved_by_the_force_before_it(
    measure: MovedMeasure, force: pc.Forcing, start: tuple[str, str]
) -> None:
    osc = pc.Oscillator("2.9", stops=(pc.Wall(at="0.3", side="above", restitution=0),))
    run = pc.simulate(osc, force, *start, t_end="14.6")
    paths = ["forcing.record.amplitude", "forcing.constant", "oscillator.stops.0.at"]
    if "omega" in str(force.record):
        paths.append("forcing.record.omega")

    found = run.sensitivity(paths).of(measure)

    wanted = [difference(run, path, measure) for path in paths]
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)


def test_all_of_them_are_measures_of_sweeps() -> None:
    assert set(get_args(MovedMeasure)) <= set(MEASURES)


def test_a_measure_that_counts_has_no_derivative() -> None:
    run = pc.simulate(*CASES["wall"], t_end=5)
    with pytest.raises(pc.ParameterError, match="have a derivative"):
        run.sensitivity(["forcing.omega"]).of("impacts_per_period")  # type: ignore[arg-type]


@pytest.mark.parametrize("measure", ["rms_displacement", "mean_power", "contact_share"])
def test_a_run_of_so_many_periods_ends_with_the_last_one(measure: MovedMeasure) -> None:
    osc, late = SOFT, pc.Start("0.1", "0.3", "0.4")

    def run(omega: float = 1.7, t0: object = "0.4") -> pc.Trajectory:
        start = pc.Start("0.1", "0.3", t0)  # type: ignore[arg-type]
        return pc.simulate(osc, pc.cosine(omega, amplitude=4), start=start, periods="3/2")

    paths = ["forcing.omega", "start.t0", "forcing.period"]
    found = pc.gradient(
        measure, osc, pc.cosine(1.7, amplitude=4), wrt=paths[:2], start=late, periods="3/2"
    )
    steps = [(k * STEP, weight) for k, weight in enumerate(WEIGHTS, start=1)]
    for value, by in zip(found, ("omega", "t0"), strict=True):
        middle = {"omega": 1.7, "t0": 0.4}[by]
        sides = [
            weight
            * (
                value_of(run(**{by: middle + h}), measure)
                - value_of(run(**{by: middle - h}), measure)
            )
            for h, weight in steps
        ]
        np.testing.assert_allclose(value, sum(sides) / STEP, rtol=1e-9)
    of_period = run().sensitivity(paths[2:]).of(measure)
    np.testing.assert_allclose(of_period, -found[:1] * 1.7**2 / (2.0 * np.pi), rtol=1e-12)


def test_an_extreme_at_the_end_of_so_many_periods() -> None:
    # x = v0 t up to the end, at 2 pi / omega.
    osc, force = pc.Oscillator(stiffness=0), pc.cosine(2, amplitude=0)
    found = pc.gradient(
        "max_displacement", osc, force, wrt=["forcing.omega"], start=(0, 3), periods=1
    )
    np.testing.assert_allclose(found, -3.0 * 2.0 * np.pi / 4.0, rtol=1e-15)
    fixed = pc.gradient(
        "max_displacement", osc, force, wrt=["forcing.omega"], start=(0, 3), t_end="pi"
    )
    np.testing.assert_array_equal(fixed, 0.0)


def test_a_parameter_that_leaves_no_period_moves_no_end() -> None:
    force = pc.Forcing((pc.Harmonic(1, 2), pc.Harmonic("0.2", 4)), period="pi")
    path = ["forcing.harmonics.1.omega"]
    by_periods = pc.gradient("rms_displacement", WALL, force, wrt=path, periods=3)
    by_time = pc.gradient("rms_displacement", WALL, force, wrt=path, t_end="3*pi")
    np.testing.assert_array_equal(by_periods, by_time)


def run_to(end: float, *, as_structure: bool = False, periods: float | None = None) -> Any:
    """Return a run whose end and damping follow from a parameter."""
    last = pc.parameter("T", end)
    limits: dict[str, Any] = {"t_end": 2 * last}
    if periods is not None:
        limits = {"periods": 2 * pc.parameter("n", periods)}
    if as_structure:
        wall = pc.Wall(at="0.2", side="above", restitution="0.8", on=0)
        structure = pc.Structure(1, 1, last / 100, stops=[wall])
        loads = pc.Loads({0: pc.cosine(2)})
        return pc.simulate(structure, loads, v0=["0.5"], **limits)
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping=last / 200)
    return pc.simulate(osc, pc.cosine(2), v0="0.5", **limits)


@pytest.mark.parametrize("as_structure", [False, True])
@pytest.mark.parametrize("name", ["T", "n"])
def test_an_end_that_is_an_expression_moves_with_its_parameters(
    name: str, as_structure: bool
) -> None:
    def measured(step: float) -> Any:
        by_time = name == "T"
        end, periods = (5 + step, None) if by_time else (5, 2.65 + step)
        run = run_to(end, as_structure=as_structure, periods=periods)
        on = [0] if as_structure else []
        return run.sensitivity([name]).measured("rms_displacement", *on)

    pairs = enumerate(WEIGHTS, start=1)
    sides = [weight * (measured(k * STEP)[0] - measured(-k * STEP)[0]) for k, weight in pairs]
    np.testing.assert_allclose(measured(0.0)[1], sum(sides) / STEP, rtol=1e-9)


def test_a_parameter_of_the_end_alone_moves_nothing_else() -> None:
    run = pc.simulate(pc.Oscillator(), v0=3, t_end=pc.parameter("T", 1))
    d = run.sensitivity(["T", "start.v0"])
    np.testing.assert_allclose(
        d.of("max_displacement"), [3.0 * np.cos(1.0), np.sin(1.0)], rtol=1e-15
    )
    np.testing.assert_array_equal(d([0.5, 1.0])[0][:, 0], 0.0)
    structure = run_to(5, as_structure=True).structure
    met = pc.simulate(
        structure, pc.Loads({0: pc.cosine(2)}), v0=["0.5"], t_end=pc.parameter("U", 3)
    )
    of_wall = met.sensitivity(["structure.stops.0.restitution", "U"])
    np.testing.assert_array_equal(of_wall([2.0])[0][..., 1], 0.0)


def test_a_parameter_of_the_end_has_the_value_that_it_has_elsewhere() -> None:
    osc = pc.Oscillator(damping=pc.parameter("T", 1))
    with pytest.raises(pc.ParameterError, match="one name has one value"):
        pc.simulate(osc, v0=3, t_end=pc.parameter("T", 2))


@pytest.mark.parametrize("of_structure", [False, True])
def test_an_impact_at_the_start_moves_away_from_it(of_structure: bool) -> None:
    """A free mass starts at a wall towards it: x = at - (t - d)/2 after d = at - x0 at the speed 1."""
    wall = pc.Wall(at="0.3", side="above", restitution="0.5", on=0 if of_structure else None)
    model: Any = (
        pc.Structure([1], [[0]], stops=[wall]) if of_structure else pc.Oscillator(0, stops=(wall,))
    )
    run = pc.simulate(model, x0="0.3", v0=1, t_end=1)
    kind = "structure" if of_structure else "oscillator"
    start = "start.x0.0" if of_structure else "start.x0"
    value, moved = run.sensitivity([start, f"{kind}.stops.0.at"]).measured("rms_displacement")
    assert value == pytest.approx(np.sqrt(0.09 - 0.15 + 1 / 12), rel=1e-12)
    np.testing.assert_allclose(moved, np.array([-0.05, 0.15]) / (2 * value), rtol=1e-12)


def test_one_path_in_the_place_of_a_list_is_told_under_its_name() -> None:
    osc = pc.Oscillator()
    with pytest.raises(pc.ParameterError, match=r"wrt = 'start\.v0': no list of paths"):
        pc.gradient("max_displacement", osc, wrt="start.v0", start=(0, 3), t_end=4)
    with pytest.raises(pc.ParameterError, match=r"paths = 'start\.v0': no list of paths"):
        pc.simulate(osc, v0=3, t_end=4).sensitivity("start.v0")


def test_a_motion_that_a_wall_lets_go_between_two_knots() -> None:
    """At the next knot the velocity jumped, as after a release by that knot."""
    osc = pc.Oscillator(0, "0.1", stops=(pc.Wall("-0.656", "below", 0),))

    def run_at(omega: float) -> pc.Trajectory:
        force = pc.triangle_wave(omega, "-0.893") + pc.cosine("0.675", amplitude="0.269", phase=6)
        return pc.simulate(osc, force, v0="0.192", t0="3.25", t_end="11.25")

    run, step = run_at(2.143), 1e-5
    (release,) = run.contacts.release
    t = np.array([6.2, 7.6, 8.2, 9.2, 11.2])
    assert t[0] < release < t[1]
    moved = run.sensitivity(["forcing.record.omega"])(t)
    near = [run_at(2.143 + k * step)(t) for k in (-1, 1)]
    for k in range(2):
        difference = (near[1][k] - near[0][k]) / (2.0 * step)
        assert np.abs(moved[k][:, 0] - difference).max() < 1e-7
