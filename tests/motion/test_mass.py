"""An oscillator with a mass moves as the one divided by it, and its forces are forces."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from tests.oracle.random_problems import random_motion

import percuss as pc
from percuss.model.exact import as_fraction
from percuss.model.paths import moved_in_law, replace_parameter

MASS = Fraction(50)
FORCES = ("stop_force", "spring_force")


def with_mass(osc: pc.Oscillator, force: pc.Forcing) -> tuple[pc.Oscillator, pc.Forcing]:
    """Return the same oscillator and force before the division by a mass of 50."""
    stops = tuple(
        stop
        if isinstance(stop, pc.Wall)
        else pc.SoftStop(stop.at, stop.side, MASS * as_fraction(stop.stiffness),
                         2 * MASS * as_fraction(stop.damping))
        for stop in osc.stops
    )  # fmt: skip
    heavy = pc.Oscillator.from_mass(
        MASS, MASS * as_fraction(osc.stiffness), 2 * MASS * as_fraction(osc.damping), stops=stops
    )
    times_mass = force.per_mass(1 / MASS)
    return heavy, pc.Forcing(
        times_mass.harmonics, times_mass.constant, force.given_period, base=force.base
    )


@pytest.mark.parametrize("seed", range(30))
def test_a_mass_changes_no_bit_of_the_motion_and_scales_what_is_a_force(seed: int) -> None:
    case = random_motion(seed)
    (x0, v0, t0), unit = case.start, case.forcing
    heavy, force = with_mass(case.oscillator, unit)
    motions = [(case.oscillator, unit), (heavy, force), (heavy, unit.per_mass(1))]

    run, real, again = (
        pc.simulate(*motion, x0, v0, t0, t_end=t0 + 6.0, max_impacts=60) for motion in motions
    )

    for other in (real, again):
        for mine, its in zip(run.record, other.record, strict=True):
            np.testing.assert_array_equal(mine, its)
    t = np.linspace(run.t0, run.t_end, 50)
    np.testing.assert_array_equal(50.0 * run.energy(t), real.energy(t))
    np.testing.assert_array_equal(50.0 * run.impacts.impulse, real.impacts.impulse)
    for name in ("spring", "damping", "forcing", "stops"):
        np.testing.assert_array_equal(50.0 * run.forces(t)[name], real.forces(t)[name])
    for stop in range(len(heavy.stops)):
        for name in ("displacement", "acceleration", *FORCES):
            factor = 50.0 if name in FORCES else 1.0
            light, weight = (each.extremes(name, stop) for each in (run, real))  # type: ignore[arg-type]
            wanted = (
                factor * light.minimum,
                light.t_minimum,
                factor * light.maximum,
                light.t_maximum,
            )
            found = weight.minimum, weight.t_minimum, weight.maximum, weight.t_maximum
            assert wanted == found


def test_the_forces_balance_the_mass_times_the_acceleration() -> None:
    line = pc.SoftStop("0.5", "above", 400e3, 10e3)
    buoy = pc.Oscillator.from_mass(50e3, 20e3, damping_ratio="0.06", stops=(line,))
    run = pc.simulate(buoy, pc.cosine("0.7854", 40e3, constant=10e3), periods=5)
    t, h = np.linspace(1.0, run.t_end - 1.0, 200), 1e-5

    forces = run.forces(t)
    total = sum(forces[name] for name in ("spring", "damping", "forcing")) + forces["stops"].sum(
        "stop"
    )

    acceleration = (run(t + h)[1] - run(t - h)[1]) / (2 * h)
    # A central difference over 1e-5 s, of which none falls on an entry.
    np.testing.assert_allclose(total, 50e3 * acceleration, rtol=0, atol=50e3 * 1e-4)


def test_the_path_of_the_mass_leaves_spring_and_dashpots_as_they_are() -> None:
    stop = pc.SoftStop(1, "above", 30, 4)
    osc = pc.Oscillator.from_mass(2, 50, 3, stops=(stop,))
    force = pc.cosine("1.5", amplitude=5)

    heavier = replace_parameter(osc, force, None, "oscillator.mass", 8)[0]
    damped = replace_parameter(osc, force, None, "oscillator.damping_coefficient", 1)[0]

    assert heavier == pc.Oscillator.from_mass(8, 50, 3, stops=(stop,))
    assert damped == pc.Oscillator.from_mass(2, 50, 1, stops=(stop,))
    by_number = pc.sweep("max_displacement", osc, force, over={"oscillator.mass": [2, 4, 8]})
    m = pc.parameter("m", 2)
    tied = pc.Oscillator.from_mass(m, 50, 3, stops=(stop,))
    by_name = pc.sweep("max_displacement", tied, force, over={"m": [2, 4, 8]})
    np.testing.assert_array_equal(by_number.max_displacement, by_name.max_displacement)


def test_what_the_mass_moves_is_known_by_the_chain_rule() -> None:
    stop = pc.SoftStop(1, "above", 30, 4)
    osc, force = pc.Oscillator.from_mass(2, 50, 3, stops=(stop,)), pc.cosine("1.5", 5, constant=2)

    name, moved = moved_in_law(osc, force, "oscillator.mass")

    slopes = {path: float(value.derivative(name)) for path, value in moved.items()}
    assert slopes == {
        "oscillator.stiffness": -50 / 4,
        "oscillator.damping": -3 / 8,
        "oscillator.stops.0.stiffness": -30 / 4,
        "oscillator.stops.0.damping": -4 / 8,
        "forcing.constant": -2 / 4,
        "forcing.harmonics.0.amplitude": -5 / 4,
    }
    assert (
        "forcing.harmonics.0.amplitude"
        not in moved_in_law(osc, force.per_mass(2), "oscillator.mass").fields
    )


def test_a_support_that_shakes_moves_a_mass_as_it_moves_a_unit_mass() -> None:
    force = pc.base_excitation("0.15", 2)
    unit = pc.simulate(pc.impact_oscillator("0.8"), force, periods=30)
    wall = pc.Wall(0, "below", "0.8")

    run = pc.simulate(pc.Oscillator.from_mass(3, 3, stops=(wall,)), force, periods=30)

    np.testing.assert_array_equal(run.impacts.t, unit.impacts.t)
    np.testing.assert_allclose(run.forces([1.0])["forcing"], 3 * unit.forces([1.0])["forcing"])


def test_orbits_files_and_energies_of_sweeps_have_the_mass(tmp_path: Any) -> None:
    unit = pc.impact_oscillator("0.8", wall="0.3", side="above", damping="0.05")
    heavy, force = with_mass(unit, pc.cosine("1.3"))
    units = pc.Units("m", "s", "kg")
    heavy = pc.Oscillator.from_mass(
        MASS, heavy.stiffness, heavy.damping, stops=heavy.stops, units=units
    )

    orbit = pc.find_orbit(heavy, force)
    light = pc.find_orbit(unit, pc.cosine("1.3"))
    pc.save_netcdf(orbit, tmp_path / "orbit.nc")
    again = pc.load_netcdf(tmp_path / "orbit.nc")
    over = {"forcing.omega": [1.2, 1.3]}
    lost = pc.sweep("dissipated_energy", heavy, force, over=over)

    np.testing.assert_allclose(orbit.impacts.impulse, 50 * light.impacts.impulse, rtol=1e-12)
    np.testing.assert_array_equal(again.impacts.impulse, orbit.impacts.impulse)
    assert again.oscillator == heavy
    assert again.impacts.to_xarray().impulse.attrs["units"] == "N s"
    assert lost.dissipated_energy.attrs["units"] == "J"
    assert lost["forcing.omega"].attrs["units"] == "1/s"
    own = pc.sweep("dissipated_energy", unit, pc.cosine("1.3"), over=over).dissipated_energy
    np.testing.assert_array_equal(lost.dissipated_energy, 50 * own)


def test_tables_of_a_run_name_its_units() -> None:
    units = pc.Units("m", "s", "t")
    line = pc.SoftStop("0.5", "above", 400, 10)
    buoy = pc.Oscillator.from_mass(50, 20, 4, stops=(line,), units=units)
    run = pc.simulate(buoy, pc.cosine("0.7854", 40, constant=10), periods=3)

    assert run.crossings.to_xarray().v.attrs["units"] == "m/s"
    assert run.sample(3).x.attrs["units"] == "m"
    assert run.forces([1.0]).stops.attrs["units"] == "kN"
    assert repr(buoy).startswith(
        "Oscillator.from_mass(mass=50, stiffness=20, damping_coefficient=4, "
    )
    assert repr(buoy).endswith(", units=Units(length='m', time='s', mass='t'))")
    assert eval(repr(buoy), {**vars(pc.model)}) == buoy


def test_a_proof_has_the_forces_energies_and_impulses_of_the_run() -> None:
    pytest.importorskip("flint")
    wall, line = pc.Wall("-0.5", "below", "0.7"), pc.SoftStop("0.5", "above", 400, 10)
    osc = pc.Oscillator.from_mass("50", 20, 4, stops=(wall, line))
    run = pc.simulate(osc, pc.cosine("0.7854", 40, constant=10), x0="0.1", v0="0.3", t_end=12)
    proven = pc.certify(run, digits=12)
    t = [0.5, 3.25, 7.75]

    assert len(run.impacts) > 0
    np.testing.assert_allclose(proven.impacts.impulse.mid(), run.impacts.impulse, rtol=1e-9)
    np.testing.assert_allclose(proven.energy(t).mid(), run.energy(t), rtol=1e-9)
    for name in ("spring", "damping", "forcing", "stops"):
        own = run.forces(t)[name].values
        np.testing.assert_allclose(proven.forces(t)[name].values, own, rtol=1e-9, atol=1e-9)


def test_a_branch_over_the_mass_is_that_over_its_name_and_its_points_are_proven() -> None:
    pytest.importorskip("flint")
    wall = pc.Wall("0.3", "above", "0.8")
    m = pc.parameter("m", "1")
    number = pc.Oscillator.from_mass("1", 1, "0.1", stops=(wall,))
    name = pc.Oscillator.from_mass(m, 1, "0.1", stops=(wall,))
    force, branches = pc.cosine("1.3"), []
    for osc, path in ((number, "oscillator.mass"), (name, "m")):
        orbit = pc.find_orbit(osc, force)
        branches.append(pc.continue_orbit(orbit, over={path: (0.6, 3.0)}))

    mine, its = branches

    np.testing.assert_allclose(mine.values, its.values, rtol=1e-9)
    assert [p.kind for p in mine.special_points] == [p.kind for p in its.special_points]
    assert mine.special_points
    proven = [pc.certify(branch.special_points[0], digits=12) for branch in branches]
    assert all(point.exists for point in proven), [point.reason for point in proven]
    values = [point.value.mid() for point in proven]
    assert values[0] == pytest.approx(values[1], rel=1e-12)
