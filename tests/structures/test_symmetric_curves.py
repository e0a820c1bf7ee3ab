"""Curves in two parameters on which the symmetry of a structure's orbits breaks."""

import numpy as np
import pytest

import percuss as pc


def structure(masses: list[str], springs: list[str], stop: pc.Wall | pc.SoftStop) -> pc.Structure:
    """Two masses of which one is between a stop and its mirror image."""
    place = f"-{stop.at}"
    if isinstance(stop, pc.Wall):
        mirrored: pc.Stop = pc.Wall(place, "below", stop.restitution, on=stop.on)
    else:
        mirrored = pc.SoftStop(place, "below", stop.stiffness, stop.damping, on=stop.on)
    return pc.chain(masses, [*springs, 0], dashpots="0.05", stops=[stop, mirrored])


def breakings(
    two: pc.Structure, omega: str, amplitude: str, span: tuple[str, str]
) -> list[pc.StructureSpecialPoint]:
    """Return where the symmetry breaks on the branch of an orbit."""
    orbit = pc.find_orbit(two, pc.Loads({0: pc.cosine(omega, amplitude=amplitude)}))
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": span})
    return [point for point in branch.special_points if point.kind == "symmetry_breaking"]


def half(orbit: pc.StructureOrbit, step: float = 1e-6) -> np.ndarray:
    """Return the derivative of the mirrored map over half a period, by differences of runs."""
    start = np.concatenate([orbit.x0, orbit.v0])
    columns = []
    for unit in np.eye(len(start)):
        ends = []
        for sign in (1.0, -1.0):
            x, v = np.split(start + sign * step * unit, 2)
            run = pc.simulate(
                orbit.structure, orbit.loads, x0=x.tolist(), v0=v.tolist(), t_end=0.5 * orbit.period
            )
            ends.append(-np.concatenate(run(run.t_end)))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.array(columns).T


def between_walls(amplitudes: tuple[str, str]) -> pc.StructureCurve:
    """Return the curve of two masses of which one goes between two walls."""
    two = structure(["1.042", "0.754"], ["1.713", "1.781"], pc.Wall("0.578", "above", "0.54", on=0))
    (point, *_) = breakings(two, "0.827", "0.37", ("0.6616", "0.9924"))
    ranges = {"loads.0.omega": ("0.5789", "1.0751"), "loads.0.amplitude": amplitudes}
    return pc.continue_curve(point, ranges, largest_step=0.1)


def test_the_symmetry_breaks_along_the_curve_of_the_oscillator() -> None:
    walls = pc.Wall("0.5", "above", "0.6"), pc.Wall("-0.5", "below", "0.6")
    osc = pc.Oscillator(stiffness=1, damping="0.05", stops=walls)
    one = pc.Structure(mass=1, stiffness=1, damping="0.1", stops=walls)
    force = pc.cosine("1.5")
    (orbit, *_) = pc.find_orbits(osc, force, 2, 1)
    alone = pc.continue_orbit(orbit, over={"forcing.omega": ("1.1", "1.5")})
    point = next(point for point in alone.special_points if point.kind == "symmetry_breaking")
    ranges = ("1.0", "1.6"), ("0.7", "1.3")
    expected = pc.continue_curve(
        point, dict(zip(("forcing.omega", "forcing.amplitude"), ranges, strict=True))
    )
    branch = pc.continue_orbit(
        pc.find_orbit(one, pc.Loads({0: force})), over={"loads.0.omega": ("1.1", "1.5")}
    )
    (first, _) = (point for point in branch.special_points if point.kind == "symmetry_breaking")

    curve = pc.continue_curve(
        first, dict(zip(("loads.0.omega", "loads.0.amplitude"), ranges, strict=True))
    )

    assert curve.kind == "symmetry_breaking"
    assert curve.values[0] == pytest.approx(expected.values[0], abs=1e-9)
    assert curve.values[-1] == pytest.approx(expected.values[-1], abs=1e-9)
    for own in curve.orbits:
        x, v = own.run(0.5 * own.period)
        assert np.abs([x + own.x0, v + own.v0]).max() < 1e-9
        assert np.abs(own.multipliers - 1.0).min() < 1e-7


def test_folds_of_symmetric_orbits_meet_the_curve() -> None:
    two = structure(["1.82", "1.299"], ["1.291", "1.969"], pc.Wall("0.385", "above", "0.69", on=1))
    (point, *_) = breakings(two, "1.677", "0.95", ("1.35", "2.01"))

    curve = pc.continue_curve(
        point, {"loads.0.omega": ("1.18", "2.18"), "loads.0.amplitude": ("0.475", "1.425")}
    )

    (both,) = curve.special_points
    assert both.kind == "fold_symmetry_breaking"
    # The orbits on both curves have the multipliers 1 and -1 of half of them.
    values = np.linalg.eigvals(half(both.orbit))
    assert np.abs(values - 1.0).min() < 1e-5
    assert np.abs(values + 1.0).min() < 1e-5


def test_a_curve_goes_on_where_a_slow_impact_passes_the_beginning_of_the_period() -> None:
    """It ended with "there is no such system", next to no graze."""
    curve = between_walls(("0.28", "0.38"))

    assert curve.end_reason.count("reached") == 2
    first = np.array([(orbit.run.impacts.t / orbit.period).min() for orbit in curve.orbits])
    stops = [int(orbit.run.impacts.stop[0]) for orbit in curve.orbits]
    # The first impact is the other one, half a period apart, once one has passed.
    assert set(stops) == {0, 1}
    assert first.min() < 0.02
    assert first.max() > 0.45
    assert max(orbit.residual for orbit in curve.orbits) < 1e-9
    for row in (0, -1):
        assert np.abs(np.linalg.eigvals(half(curve.orbits[row])) + 1.0).min() < 1e-5


def test_a_curve_says_at_which_stop_its_orbits_graze_at_its_end() -> None:
    curve = between_walls(("0.36", "0.555"))

    ends = [end for end in curve.end_reason.split("; at the other end ") if "reached" not in end]
    assert [end.rpartition("; ")[2] for end in ends] == ["the orbit grazes stop 0 there"]


def test_what_has_no_curve_is_told() -> None:
    stop = pc.Wall("0.213", "above", "0.58", on=0)
    two = structure(["0.566", "0.705"], ["1.717", "1.26"], stop)
    (point, *_) = breakings(two, "1.021", "0.22", ("0.8168", "1.2252"))
    assert not point.orbit.admissible
    ranges = {"loads.0.omega": ("0.9", "1.2"), "loads.0.amplitude": ("0.1", "0.4")}
    with pytest.raises(pc.ParameterError, match="formal: where the symmetry of orbits breaks"):
        pc.continue_curve(point, ranges)
    three = structure(
        ["1.82", "1.299"], ["1.291", "1.969"], pc.Wall("0.385", "above", "0.69", on=1)
    )
    (point, *_) = breakings(three, "1.677", "0.95", ("1.35", "2.01"))
    with pytest.raises(pc.ParameterError, match="the symmetry is lost when they vary"):
        pc.continue_curve(
            point, {"loads.0.omega": ("1.18", "2.18"), "structure.stops.0.at": ("0.3", "0.5")}
        )
