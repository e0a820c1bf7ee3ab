"""Sensitivities of orbits against differences of orbits."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.sensitivity.differences import orbit_differences

import percuss as pc
from percuss.model.paths import get_parameter, replace_parameter
from percuss.orbits.orbit.solve import orbit_of_solution, solve

WALL = pc.Oscillator(damping="0.05", stops=(pc.Wall(at="0.2", side="above", restitution="0.6"),))
SOFT = pc.Oscillator(damping="0.1", stops=(pc.SoftStop("0.2", "above", 30, "0.5"),))
TIED = pc.parameter("w", 2)
CASES = {
    "wall": (WALL, pc.cosine(2, phase="0.3"), ("oscillator.stops.0.restitution", "forcing.phase")),
    "soft": (SOFT, pc.cosine(2), ("oscillator.stops.0.stiffness", "oscillator.stops.0.damping")),
    "tied": (WALL, pc.cosine(TIED, amplitude="0.3" * TIED**2), ("w",)),
    "two harmonics": (WALL, pc.fourier(2, cos=[1, 0.3]), ("forcing.omega", "forcing.cos.1")),
    "square wave": (WALL, pc.square_wave(2, 1), ("forcing.record.omega",)),
}
TABLE = pc.restitution_table(speeds=(0, 1, 3), values=("0.9", "0.8", "0.6"))
CASES["restitution by speed"] = (
    pc.Oscillator(damping="0.05", stops=(pc.Wall("0.2", "above", TABLE),)),
    pc.cosine(2),
    ("oscillator.stops.0.restitution.values.1", "oscillator.stops.0.restitution.speeds.2"),
)
ALWAYS = ("oscillator.damping", "oscillator.stiffness", "oscillator.stops.0.at")
# A central difference of eighth order: by rounding its error is some 1e-14 / STEP.
STEP = 1e-3
WEIGHTS = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
CLOSE: dict[str, Any] = {"rtol": 1e-10, "atol": 1e-10}


def moved(orbit: pc.PeriodicOrbit, path: str, step: float) -> pc.PeriodicOrbit:
    """Return the same orbit at another value of a parameter."""
    values = orbit.oscillator, orbit.forcing, None
    value = float(pc.expression(str(get_parameter(*values, path)))) + step
    osc, force, _ = replace_parameter(*values, path, value)
    system = type(orbit.system)(osc, force)
    return orbit_of_solution(system, solve(system, orbit.itinerary))


def difference(orbit: pc.PeriodicOrbit, path: str) -> dict[str, Any]:
    """Return central differences of eighth order of all that an orbit has."""

    def numbers(step: float) -> dict[str, Any]:
        other = moved(orbit, path, step)
        run = other.trajectory()
        return {
            "period": np.array(other.period),
            "t": other.impacts.t,
            "v_before": other.impacts.v_before,
            "v_after": other.impacts.v_after,
            "trace": other.multipliers.sum(),
            "determinant": other.multipliers.prod(),
            "max": np.array(run.extremes("displacement").maximum),
        }

    pairs = [(numbers(k * STEP), numbers(-k * STEP)) for k in range(1, 5)]
    return {
        name: sum(
            weight * (ahead[name] - behind[name])
            for weight, (ahead, behind) in zip(WEIGHTS, pairs, strict=True)
        )
        / STEP
        for name in pairs[0][0]
    }


def check_orbit(
    orbit: pc.PeriodicOrbit, derivatives: pc.OrbitSensitivity, p: int, wanted: dict[str, Any]
) -> None:
    np.testing.assert_allclose(derivatives.period[p], wanted["period"], **CLOSE)
    np.testing.assert_allclose(derivatives.impacts.v_after[:, p], wanted["v_after"], **CLOSE)
    # Of the multipliers, which have a root where two meet, their sum and product have none.
    trace = derivatives.multipliers[:, p].sum()
    determinant = (orbit.multipliers[::-1] * derivatives.multipliers[:, p]).sum()
    np.testing.assert_allclose(trace, wanted["trace"], **CLOSE)
    np.testing.assert_allclose(determinant, wanted["determinant"], **CLOSE)


@pytest.mark.parametrize("case", CASES)
def test_forced_orbits(case: str) -> None:
    osc, force, own = CASES[case]
    orbit = pc.find_orbit(osc, force)
    paths = (*ALWAYS, *own)
    derivatives = orbit.sensitivity(paths)
    for p, path in enumerate(paths):
        wanted = difference(orbit, path)
        check_orbit(orbit, derivatives, p, wanted)
        np.testing.assert_allclose(derivatives.impacts.t[:, p], wanted["t"], **CLOSE)
        np.testing.assert_allclose(derivatives.impacts.v_before[:, p], wanted["v_before"], **CLOSE)
        np.testing.assert_allclose(derivatives.of("max_displacement")[p], wanted["max"], **CLOSE)


CYCLE = pc.Oscillator(1, "-0.05", stops=(pc.Wall(at=1, side="above", restitution="0.7"),))
STOP = "oscillator.stops.0"


@pytest.mark.parametrize(
    ("case", "path"),
    [
        ("wall", f"{STOP}.at"),
        pytest.param("wall", f"{STOP}.restitution", marks=pytest.mark.nightly),
        pytest.param("wall", "oscillator.damping", marks=pytest.mark.nightly),
        pytest.param("wall", "oscillator.stiffness", marks=pytest.mark.nightly),
        pytest.param("wall", "forcing.omega", marks=pytest.mark.nightly),
        ("tied", "w"),
        pytest.param("cycle", "oscillator.damping", marks=pytest.mark.nightly),
        ("cycle", "oscillator.stiffness"),
    ],
)
def test_orbits_against_the_oracle(case: str, path: str) -> None:
    osc, force = (CYCLE, None) if case == "cycle" else CASES[case][:2]
    orbit = pc.find_orbit(osc, force)
    assert orbit.n_impacts == 1
    derivatives = orbit.sensitivity([path])
    wanted = orbit_differences(orbit, path)
    close: dict[str, Any] = {"rel": 1e-10, "abs": 1e-13}
    assert derivatives.t0[0] == pytest.approx(wanted.t0, **close)
    assert derivatives.impacts.v_after[0, 0] == pytest.approx(wanted.v0, **close)
    assert derivatives.period[0] == pytest.approx(wanted.period, **close)
    trace = derivatives.multipliers[:, 0].sum()
    determinant = (orbit.multipliers[::-1] * derivatives.multipliers[:, 0]).sum()
    # Of free motion the map of (t, v) has the multiplier 1 of the instants too.
    assert trace == pytest.approx(wanted.trace, **close)
    assert determinant == pytest.approx(wanted.determinant, **close)


def test_a_column_closes_after_a_period() -> None:
    orbit = pc.find_orbit(WALL, pc.cosine(2))
    derivatives = orbit.sensitivity(["oscillator.stops.0.at", "oscillator.damping"])
    run = derivatives.motion.run
    begin, end = (np.array(derivatives(t)) for t in (run.t0, run.t_end))
    np.testing.assert_allclose(begin, end, atol=1e-13)


def test_the_period_of_a_limit_cycle() -> None:
    orbit = pc.find_orbit(CYCLE)
    paths = ["oscillator.damping", "oscillator.stiffness", "oscillator.stops.0.at"]
    derivatives = orbit.sensitivity(paths)
    # A longer wall at the same rates: all lengths grow, no time.
    np.testing.assert_allclose(derivatives.period[2], 0.0, atol=1e-13)
    np.testing.assert_allclose(derivatives.v0[2], orbit.v0, rtol=1e-12)
    for p, path in enumerate(paths[:2]):
        check_orbit(orbit, derivatives, p, difference(orbit, path))


def test_a_frequency_moved_alone_has_no_orbit() -> None:
    waves = pc.Harmonic(1, 2), pc.Harmonic("0.2", 4)
    orbit = pc.find_orbit(WALL, pc.Forcing(waves, period="pi"))
    with pytest.raises(pc.ParameterError, match="without a period"):
        orbit.sensitivity(["forcing.harmonics.1.omega"])


def test_an_orbit_of_a_family_has_no_derivative() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(restitution=1), None)
    with pytest.raises(pc.ConvergenceError, match="family"):
        orbit.sensitivity(["oscillator.stiffness"])


def test_an_orbit_with_sticking_is_the_run_that_comes_to_it() -> None:
    wall = pc.Wall(at="-0.4", side="below", restitution="0.3")
    osc = pc.Oscillator(1, "0.1", stops=(wall,))
    force = pc.cosine("0.7", phase=2, constant="-0.4")
    orbit = pc.find_orbit(osc, force, n_impacts=math.inf)
    assert np.isinf(orbit.n_impacts)
    paths = ["oscillator.stops.0.at", "oscillator.damping", "forcing.amplitude"]
    derivatives = orbit.sensitivity(paths)
    # The contact ends all memory of the start.
    run = pc.simulate(osc, force, "-0.1", "0.5", t_end=orbit.t0 + 3.5 * orbit.period)
    t = orbit.t0 + np.array([0.1, 0.6, 0.9]) * orbit.period
    later = np.array(run.sensitivity(paths)(t + 2 * orbit.period))
    np.testing.assert_allclose(np.array(derivatives(t)), later, rtol=1e-9, atol=1e-9)
    assert not derivatives.multipliers.any()


def test_multipliers_that_are_equal_have_no_derivative() -> None:
    orbit = pc.find_orbit(pc.Oscillator(1, 1), pc.cosine(2), n_impacts=0)
    derivatives = orbit.sensitivity(["oscillator.damping"])
    assert np.isnan(derivatives.multipliers).all()
    assert np.isfinite(derivatives.x0).all()


@pytest.mark.parametrize("kind", ["fold", "period_doubling"])
def test_special_points(kind: str) -> None:
    osc = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    branch = pc.continue_orbit(
        pc.find_orbit(osc, pc.cosine(1)), over={"forcing.amplitude": (1.0, 0.09)}
    )
    point = next(point for point in branch.special_points if point.kind == kind)
    if kind == "fold":
        with pytest.raises(pc.ConvergenceError, match="on a fold"):
            point.orbit.sensitivity(["forcing.amplitude"])
    else:
        slope = point.orbit.sensitivity(["forcing.amplitude"]).multipliers[:, 0]
        assert np.isfinite(slope).all()
        assert slope[0] != 0.0


def test_the_response_of_a_linear_oscillator() -> None:
    orbit = pc.find_orbit(pc.Oscillator(damping="0.1"), pc.cosine(2), n_impacts=0)
    derivatives = orbit.sensitivity(["forcing.amplitude", "oscillator.damping"])
    # x + i v / w = exp(-i w t) / (K - w^2 + 2 i a w).
    gain = 1 / (1 - 4 + 0.4j)
    np.testing.assert_allclose(
        [derivatives.x0[0], derivatives.v0[0]], [gain.real, -2 * gain.imag], rtol=1e-12
    )
    slope = -4j * gain**2
    np.testing.assert_allclose(
        [derivatives.x0[1], derivatives.v0[1]], [slope.real, -2 * slope.imag], rtol=1e-12
    )


def test_means_over_a_period_without_impacts_end_with_it() -> None:
    # x'' + 2 a x' + x = cos w t: x has the amplitude A = 1/sqrt(D), D = (1 - w^2)^2 + 4 a^2 w^2.
    a, w = 0.1, 1.3
    orbit = pc.find_orbit(pc.Oscillator(damping=a), pc.cosine(w), n_impacts=0)
    found = orbit.sensitivity(["forcing.omega"])
    d, faster = (1 - w**2) ** 2 + 4 * a**2 * w**2, -4 * w * (1 - w**2) + 8 * a**2 * w
    np.testing.assert_allclose(
        found.of("rms_displacement"), -faster / (2 * math.sqrt(2) * d**1.5), rtol=1e-12
    )
    # The mean power is that of the dashpot, a w^2 A^2.
    power = 2 * a * w / d - a * w**2 * faster / d**2
    np.testing.assert_allclose(found.of("mean_power"), power, rtol=1e-12)


def test_frequencies_and_a_period_of_one_parameter() -> None:
    def model(w: float) -> tuple[pc.Oscillator, pc.Forcing]:
        name = pc.parameter("w", w)
        waves = pc.Harmonic(1, name), pc.Harmonic("0.2", 3 * name, "pi/3")
        return WALL, pc.Forcing(waves, period=2 * pc.pi_times(1) / name)

    found = pc.find_orbit(*model(2.0)).sensitivity(["w"])
    np.testing.assert_allclose(found.period, -math.pi / 2.0, rtol=1e-14)
    step = 1e-5
    sides = [pc.find_orbit(*model(2.0 + h)).min_impact_speed for h in (step, -step)]
    slope = (sides[0] - sides[1]) / (2.0 * step)
    np.testing.assert_allclose(found.of("peak_impact_velocity"), slope, rtol=1e-7)


FREE = (
    "oscillator.damping",
    "forcing.constant",
    "forcing.record.amplitude",
    "forcing.record.omega",
)


@pytest.mark.parametrize("omega", [1.1, 2, 2.7, 3])
def test_orbits_without_impacts_under_a_square_wave(omega: float) -> None:
    osc = pc.Oscillator(damping="0.1", stops=(pc.Wall(at=9, side="above", restitution="0.5"),))
    force = pc.square_wave(omega, amplitude="0.7") + pc.Forcing(constant="0.1")
    orbit = pc.find_orbit(osc, force, n_impacts=0)
    derivatives = orbit.sensitivity(FREE)
    # The orbit is odd about its mean.
    np.testing.assert_allclose(derivatives.of("max_displacement")[1], 1.0, **CLOSE)
    peak = (orbit.trajectory().extremes("displacement").maximum - 0.1) / 0.7
    np.testing.assert_allclose(derivatives.of("max_displacement")[2], peak, **CLOSE)
    check_close(orbit, derivatives, ("rms_displacement", "mean_power", "peak_acceleration"))
    # Both multipliers have the size exp(-damping period).
    size = math.exp(-0.1 * orbit.period)
    moved = np.real(np.conj(orbit.multipliers[:, np.newaxis]) * derivatives.multipliers) / size
    by_size = size * np.array([-orbit.period, 0.0, 0.0, 0.1 * orbit.period / omega])
    np.testing.assert_allclose(moved, np.tile(by_size, (2, 1)), **CLOSE)


def check_close(
    orbit: pc.PeriodicOrbit, derivatives: pc.OrbitSensitivity, measures: tuple[str, ...]
) -> None:
    """Compare derivatives of measures with central differences of fourth order."""
    step = 1e-4
    for p, path in enumerate(derivatives.paths):
        values = []
        value = float(pc.expression(str(get_parameter(*orbit.system, None, path))))
        for k in (2, 1, -1, -2):
            osc, force, _ = replace_parameter(*orbit.system, None, path, value + k * step)
            other = pc.find_orbit(osc, force, orbit.n_impacts, orbit.n_periods).sensitivity([path])
            values.append([other.measured(measure)[0] for measure in measures])
        wanted = np.array([-1, 8, -8, 1]) @ np.array(values) / (12 * step)
        found = [derivatives.measured(measure)[1][p] for measure in measures]
        np.testing.assert_allclose(found, wanted, rtol=1e-7, atol=1e-8, err_msg=path)


def test_the_multipliers_of_an_orbit_without_impacts_by_its_frequency() -> None:
    orbit = pc.find_orbit(pc.Oscillator(damping="0.1"), pc.cosine(2), n_impacts=0)
    moved = orbit.sensitivity(["forcing.omega"]).multipliers[:, 0]
    size = math.exp(-0.1 * math.pi)
    by_size = np.real(np.conj(orbit.multipliers) * moved) / size
    np.testing.assert_allclose(by_size, 0.1 * math.pi / 2 * size, rtol=1e-12)


HELD = {
    "by a jump": (
        pc.Oscillator(
            0, "0.01", stops=(pc.Wall("-0.5", "below", "0.9"), pc.Wall("0.3", "above", 0))
        ),
        pc.square_wave("2.7", amplitude="0.7") + pc.Forcing(constant="0.1"),
        2,
        ("oscillator.damping", "oscillator.stops.1.at", "forcing.record.amplitude"),
    ),
    "at the end of a chatter": (
        pc.Oscillator(0, "0.6", stops=(pc.Wall(0, "below", "0.3"),)),
        pc.cosine("2.7", amplitude="0.38", phase="1.68", constant="-0.3"),
        1,
        ("oscillator.damping", "oscillator.stops.0.restitution", "forcing.constant"),
    ),
    "after a plastic impact": (
        pc.Oscillator(
            "2.3", "0.2", stops=(pc.Wall("-0.2", "below", 0), pc.SoftStop("0.3", "above", 100, 2))
        ),
        pc.cosine("2.7", amplitude="1.77", phase="0.1"),
        1,
        ("oscillator.damping", "oscillator.stops.0.at", "forcing.omega", "forcing.phase"),
    ),
}


@pytest.mark.parametrize("case", HELD)
def test_measures_of_orbits_with_sticking(case: str) -> None:
    osc, force, n_periods, paths = HELD[case]
    orbit = pc.find_orbit(osc, force, math.inf, n_periods)
    measures = ("rms_displacement", "mean_power", "contact_share", "peak_acceleration")
    check_close(orbit, orbit.sensitivity(paths), measures)


def test_the_instant_of_a_plastic_impact() -> None:
    def orbit_with(damping: float) -> pc.PeriodicOrbit:
        osc = pc.Oscillator("2.3", damping, stops=(pc.Wall("-0.2", "below", 0),))
        return pc.find_orbit(osc, pc.cosine("2.7", amplitude="1.77", phase="0.1"), 1)

    found = orbit_with(0.2).sensitivity(["oscillator.damping"])
    late = (orbit_with(0.201).t0 - orbit_with(0.199).t0) / 0.002
    assert found.t0[0] == pytest.approx(late, rel=1e-5)
    assert found.impacts.t[0, 0] == found.t0[0]
    assert found.v0[0] == found.x0[0] == 0.0


def test_a_plastic_impact_ends_an_orbit_without_the_force_that_the_wall_holds() -> None:
    # Of another wall the end of the period is rounded another way: in half of them the
    # acceleration without the wall counted.
    for at in np.linspace(0, 1e-4, 8):
        osc = pc.Oscillator("2.3", "0.6", stops=(pc.Wall(float(at), "below", 0),))
        force = pc.cosine(1, amplitude="1.34", phase="2.78", constant="0.2")
        orbit = pc.find_orbit(osc, force, math.inf)
        once, twice = (orbit.trajectory(n).extremes("acceleration") for n in (1, 2))
        assert (once.minimum, once.maximum) == pytest.approx((twice.minimum, twice.maximum))
        inside = orbit.t0, orbit.t0 + 1.5 * orbit.period
        within = orbit.trajectory(2).extremes("acceleration", between=inside)
        assert once.minimum == pytest.approx(within.minimum, rel=1e-12)
