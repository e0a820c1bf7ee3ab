"""Points of codimension two, at soft stops, between walls and under several harmonics."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.orbits.kinds import points

import percuss as pc
from percuss.arrays import Floats
from percuss.orbits import Branch, SpecialPoint
from percuss.orbits.bifurcations.parameter_ranges import own_value

Complex = NDArray[np.complex128]

OMEGA, AMPLITUDE = "forcing.omega", "forcing.amplitude"
GAP = "oscillator.stops.0.at"
DAMPING = "oscillator.damping"
RESTITUTION = "oscillator.stops.0.restitution"


def test_curves_of_folds_at_a_soft_stop_end_in_a_cusp(soft: Branch) -> None:
    few = {OMEGA: (1.45, 1.6), AMPLITUDE: (1.2, 1.4)}
    both = [pc.continue_curve(fold, few) for fold in points(soft, "fold")]
    assert len(both) == 2

    (one,), (other,) = (curve.special_points for curve in both)

    assert one.kind == other.kind == "cusp"
    assert one.status == "located"
    assert one.values == pytest.approx(other.values, abs=1e-9)
    # Beyond it no orbit of the family folds.
    osc = pc.Oscillator(1.0, "0.05", (pc.SoftStop(1.0, "above", 9.0),))
    for part, count in ((0.995, 2), (1.005, 0)):
        orbit = pc.find_orbit(osc, pc.cosine(1.45, amplitude=part * one.values[1]))
        branch = pc.continue_orbit(orbit, over={OMEGA: (1.45, 1.55)})
        assert len(points(branch, "fold")) == count


def test_a_curve_of_folds_may_close(soft: Branch) -> None:
    ranges = {OMEGA: (0.5, 2.5), AMPLITUDE: (0.1, 4.0)}

    curve = pc.continue_curve(points(soft, "fold")[0], ranges, largest_step=0.1)

    assert curve.end_reason == "the curve closed"
    assert [point.kind for point in curve.special_points] == ["cusp", "cusp"]
    assert curve.values[0] == pytest.approx(curve.values[-1], abs=0.05)


def test_folds_at_a_soft_stop_end_where_another_one_is_met() -> None:
    """The same point is on the curve of grazing of the second stop, where a multiplier is 1."""
    stops = (pc.SoftStop(1.0, "above", 9.0), pc.SoftStop(1.4, "above", 9.0))
    start = pc.find_orbit(pc.Oscillator(1.0, "0.05", stops), pc.cosine("1.5", amplitude="1.29"))
    assert start.sequence == (0,)
    branch = pc.continue_orbit(start, over={AMPLITUDE: (1.27, 1.31)})
    (graze,) = (point for point in points(branch, "grazing") if "turning" in point.detail)
    fold = max(points(branch, "fold"), key=lambda point: point.value)
    ranges = {OMEGA: (1.49, 1.53), AMPLITUDE: (1.25, 1.36)}

    folds, grazes = pc.continue_curve(fold, ranges), pc.continue_curve(graze, ranges)

    assert "meets soft stop 1 once more" in folds.end_reason
    ((last), (crossed,)) = folds.special_points[-1], grazes.special_points
    assert last.kind == crossed.kind == "fold_grazing"
    assert last.row in (0, len(folds) - 1)
    assert last.values == pytest.approx(crossed.values, abs=1e-10)
    assert folds.admissible.all()
    # From the other side, where both stops are met, it is approached only.
    both = pc.find_orbits(start.oscillator, pc.cosine("1.5", amplitude="1.29"), 2, 1)
    (deep,) = (each for each in both if each.n_impacts == 2 and not each.is_stable)
    other = pc.continue_orbit(deep, over={OMEGA: (1.45, 1.7)})
    (fold,) = (point for point in points(other, "fold") if point.orbit.n_impacts == 2)
    beyond = pc.continue_curve(fold, {OMEGA: (1.45, 1.7), AMPLITUDE: (1.28, 2.0)})
    assert "hardly meets soft stop 1" in beyond.end_reason
    distances = np.abs(beyond.values[[0, -1]] - last.values).max(axis=1)
    assert 0.0 < distances.min() < 1e-3


def test_symmetry_breaks_on_a_curve_of_symmetric_orbits(mirrored: Branch) -> None:
    (breaks,) = points(mirrored, "symmetry_breaking")
    (graze,) = points(mirrored, "grazing")
    ranges = {OMEGA: (1.0, 1.6), AMPLITUDE: (0.05, 4.0)}

    curve, grazes = pc.continue_curve(breaks, ranges), pc.continue_curve(graze, ranges)

    assert np.ptp(curve.values, axis=0).min() > 0.5
    for row in range(0, len(curve), 10):
        assert curve[row].symmetric
        assert np.abs(curve.multipliers[row] - 1.0).min() < 1e-9
    # Two systems of equations meet in one point.
    (one,), (other,) = curve.special_points, grazes.special_points
    assert one.kind == other.kind == "symmetry_breaking_grazing"
    assert one.values == pytest.approx(other.values, abs=1e-10)


def test_harmonics_graze_twice_and_without_acceleration() -> None:
    osc = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.1")
    cos, sin = (0.3, 0.4, 0.0), (0.0, 0.2, 0.15)
    calm = pc.find_orbit(osc, pc.fourier(0.7, cos=cos, sin=sin), n_impacts=0)
    (graze,) = points(pc.continue_orbit(calm, over={GAP: (0.1, 3.0)}), "grazing")

    curve = pc.continue_curve(graze, {GAP: (0.1, 3.0), "forcing.cos.1": (-2.0, 2.0)})

    def motion(second: float) -> Complex:
        """Fourier coefficients of the displacement."""
        n = np.arange(1, 4)
        force = np.array([cos[0], second, cos[2]]) - 1j * np.array(sin)
        return force / (1.0 - (0.7 * n) ** 2 + 0.2j * 0.7 * n)

    def turning(coefficients: Complex, order: int) -> Floats:
        """Angles at which a derivative of that order vanishes."""
        n = np.arange(1, 4)
        half = (1j * n) ** order * coefficients
        roots = np.roots(np.concatenate([half[::-1], [0.0], half.conj()]))
        return np.asarray(np.angle(roots[np.abs(np.abs(roots) - 1.0) < 1e-4]))

    def at(coefficients: Complex, angles: Floats, order: int = 0) -> Floats:
        n = np.arange(1, 4)
        terms = (1j * n) ** order * coefficients * np.exp(1j * np.outer(angles, n))
        return np.asarray(terms.sum(axis=1).real)

    (degenerate,) = [each for each in curve.special_points if each.kind == "degenerate_grazing"]
    gap, second = degenerate.values
    flat = turning(motion(second), 2)
    slope = at(motion(second), flat, 1)
    assert np.abs(slope).min() < 1e-10
    assert at(motion(second), flat)[np.argmin(np.abs(slope))] == pytest.approx(gap, abs=1e-10)
    (double,) = [each for each in curve.special_points if each.kind == "double_grazing"]
    gap, second = double.values
    heights = np.sort(at(motion(second), turning(motion(second), 1)))
    assert heights[-2:] == pytest.approx([gap, gap], abs=1e-9)
    # On the way to it the highest turning point grazes, and the motion is physical.
    for row in np.flatnonzero(curve.admissible)[::5]:
        gap, second = curve.values[row]
        heights = at(motion(second), turning(motion(second), 1))
        assert heights.max() == pytest.approx(gap, abs=1e-10)


def test_a_motion_without_a_spring_grazes_from_the_middle() -> None:
    """With no spring, and soft stops on either side, its amplitude is A/(w sqrt(w^2 + 4 a^2))."""
    osc = pc.backlash_oscillator(gap=1.0, stiffness=20.0, damping="0.1")
    amplitude = 2.5 * math.hypot(2.5, 0.2)
    calm = pc.find_orbit(osc, pc.cosine(2.5, amplitude=amplitude), n_impacts=0)
    assert calm.grazing_margin == pytest.approx(0.0, abs=1e-15)
    at = (amplitude, amplitude)
    graze = SpecialPoint("grazing", AMPLITUDE, amplitude, at, "located", calm, 0, "it touches")

    curve = pc.continue_curve(graze, {OMEGA: (2.5, 3.0), AMPLITUDE: (0.1, 12.0)})

    omega, found = curve.values.T
    assert omega[[0, -1]].tolist() == [2.5, 3.0]
    np.testing.assert_allclose(found, omega * np.sqrt(omega**2 + 0.04), rtol=0.0, atol=1e-11)


def test_a_curve_of_folds_is_the_same_from_each_of_its_points() -> None:
    """The second way begins far from where the first has ended, and no cusp appears there."""
    stops = pc.Wall("0.67", "above", "0.32"), pc.Wall("-0.67", "below", "0.32")
    ranges = {"forcing.constant": (-1, 1), DAMPING: (0, 1)}
    osc, whole = pc.Oscillator(1, "0.01", stops), pc.cosine("2.25", amplitude="1.73")
    branch = pc.continue_orbit(pc.find_orbit(osc, whole, 2, 1), over={DAMPING: (0, 1)})
    curve = pc.continue_curve(points(branch, "fold")[0], ranges)
    grazes = [point.values for point in curve.special_points]
    assert [point.kind for point in curve.special_points] == ["fold_grazing", "fold_grazing"]

    for row in (1, 11):
        constant, damping = curve.values[row].tolist()
        force = pc.cosine("2.25", amplitude="1.73", constant=constant)
        near = pc.Oscillator(1, 0.97 * damping, stops)
        orbit = pc.find_orbit(near, force, 2, 1, guess=curve[row], formal=True)
        (fold,) = points(pc.continue_orbit(orbit, over={DAMPING: (0, 1)}), "fold")
        assert fold.value == pytest.approx(damping, abs=1e-10)
        again = pc.continue_curve(fold, ranges).special_points
        assert [point.kind for point in again] == ["fold_grazing", "fold_grazing"]
        places = np.array([point.values for point in again])
        assert places == pytest.approx(np.array(grazes), abs=1e-9)


def test_folds_of_doubled_orbits_end_on_the_curve_of_doublings() -> None:
    """Beyond it come the same orbits a period later: such a curve closed, or went back to its start."""
    osc = pc.impact_oscillator("0.93", wall="0.45", side="above")
    ranges = {AMPLITUDE: (0.05, 4), DAMPING: (0, 1)}
    force = pc.cosine("2.23", amplitude="1.32", constant="0.158")
    (orbit,) = (each for each in pc.find_orbits(osc, force, 2, 2) if each.n_impacts == 2)
    branch = pc.continue_orbit(orbit, over={AMPLITUDE: (0.05, 4)})

    curve = pc.continue_curve(points(branch, "fold")[0], ranges)

    last = curve.special_points[-1]
    assert (last.kind, last.status) == ("degenerate_period_doubling", "bracketed")
    assert last.row == len(curve) - 1
    assert "the two-fold cover of a shorter one" in curve.end_reason
    assert curve.values[:, 1].argmax() == len(curve) - 1
    # The orbit of one period doubles there: from the doubling a branch starts to one side, and on
    # the other side of the point to the other.
    amplitude, damping = last.values
    simple = pc.find_orbit(osc, force, 1, 1, formal=True)
    along = pc.continue_orbit(simple, over={DAMPING: (0, 1)})
    for way, side in ((0.99, -1.0), (1.01, 1.0)):
        (damped,) = pc.orbits_at(along, way * damping)
        single = pc.continue_orbit(damped, over={AMPLITUDE: (0.05, 4)})
        doubling = min(
            points(single, "period_doubling"), key=lambda point: abs(point.value - amplitude)
        )
        shift = own_value(pc.switch_branch(doubling), AMPLITUDE) - doubling.value
        assert math.copysign(1.0, shift) == side


def test_a_curve_of_folds_runs_off_to_the_resonance_in_few_steps() -> None:
    """Steps are as long as the velocities are large; 2000 of one length led to damping 1e-4."""
    osc = pc.Oscillator(1.0, "0.05", (pc.SoftStop(0.6, "above", 58.6),))
    orbits = pc.find_orbits(osc, pc.cosine("2.612", amplitude="0.667"), 1, 2)
    orbit = next(each for each in orbits if each.n_impacts == 1)
    stiffness = "oscillator.stops.0.stiffness"
    branch = pc.continue_orbit(orbit, over={stiffness: (0.5, 80)})

    curve = pc.continue_curve(points(branch, "fold")[0], {stiffness: (0.5, 80), DAMPING: (0, 1)})

    assert "the velocities grow without bound" in curve.end_reason
    assert len(curve) < 200
    assert 0.0 < curve.values[0, 1] < 1e-7
    # There free motion alone is an orbit: half a swing beside the stop and half a swing in it.
    half_swings = math.pi * (1.0 + 1.0 / math.sqrt(1.0 + curve.values[0, 0]))
    assert half_swings == pytest.approx(curve[0].period, rel=1e-6)


def test_a_graze_of_two_periods_is_told_from_others_of_its_orbit() -> None:
    """Its orbit may be given from the other period on: a graze beside it was its own."""
    stops = pc.SoftStop("0.3268", "above", "3.7411"), pc.Wall("0.7264", "above", "0.633")
    osc = pc.Oscillator(1, "0.05", stops)
    force = pc.cosine("2.3838", amplitude="1.4125", phase="1.3296")
    orbits = [each for each in pc.find_orbits(osc, force, 2, 2) if each.n_periods == 2]
    branches = [pc.continue_orbit(orbit, over={OMEGA: (0.5, 3.5)}) for orbit in orbits]
    grazes = [point for branch in branches for point in points(branch, "grazing")]
    graze = min(grazes, key=lambda point: abs(point.value - 2.552))
    assert graze.value == pytest.approx(2.552, abs=1e-3)

    curve = pc.continue_curve(graze, {DAMPING: (0, 1), OMEGA: (0.5, 3.5)})

    assert [point.kind for point in curve.special_points] == ["fold_grazing", "resonant_grazing"]
    for orbit in curve:
        clearances = np.sort(orbit.turning_points.clearance)
        assert abs(clearances[0]) < 1e-9
        assert clearances[1] > 0.1


def test_a_curve_begins_at_the_end_of_a_range() -> None:
    """The first point was moved out of the range by rounding, to a restitution below 0."""
    osc = pc.impact_oscillator(0, wall="0.58", side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine("1.07", amplitude="0.48"), 1, 1)
    branch = pc.continue_orbit(orbit, over={DAMPING: (0, 1)})

    curve = pc.continue_curve(points(branch, "fold")[0], {DAMPING: (0, 1), RESTITUTION: (0, 1)})

    assert curve.values[0, 1] == 0.0
    assert curve.values[-1, 1] == 1.0


def test_a_mass_at_rest_after_a_plastic_impact_grazes_no_stop() -> None:
    osc = pc.impact_oscillator(1, wall="-0.14", side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine("3.11", amplitude="1.19"), 1, 1)
    branch = pc.continue_orbit(orbit, over={GAP: (-0.74, 0.46)})
    (doubling,) = points(branch, "period_doubling")

    curve = pc.continue_curve(doubling, {GAP: (-0.74, 0.46), RESTITUTION: (0, 1)})

    assert curve.values[-1, 1] == 0.0
    assert curve[-1].admissible
    assert curve[-1].v0 == 0.0
    assert curve.special_points == ()


def test_no_curve_goes_through_a_graze_at_the_end_of_a_plastic_impact() -> None:
    """It is there whatever the parameters are: a curve wandered through the plane."""
    osc = pc.impact_oscillator(0, wall="0.45", side="above", damping="0.01")
    force = pc.cosine("1.8", amplitude="1.2356")
    branch = pc.continue_orbit(pc.find_orbit(osc, force, 1, 1), over={OMEGA: (0.5, 3.5)})
    graze = min(points(branch, "grazing"), key=lambda point: point.value)

    with pytest.raises(pc.ParameterError, match="the graze coincides with another event"):
        pc.continue_curve(graze, {"forcing.constant": (-1, 1), OMEGA: (0.5, 3.5)})


def test_a_graze_is_the_same_from_each_period_of_the_force_on() -> None:
    """The orbit without the impact was given from another period on, where nothing grazes."""
    osc = pc.impact_oscillator("0.601", wall="0.641", side="above", damping="0.01")
    force = pc.cosine("2.182", amplitude="1.343", constant="0.118")
    orbits = [each for each in pc.find_orbits(osc, force, 2, 2) if each.n_periods == 2]
    branches = [pc.continue_orbit(orbit, over={AMPLITUDE: (0.05, 4)}) for orbit in orbits]
    same = [
        point
        for branch in branches
        for point in points(branch, "grazing")
        if point.value == pytest.approx(1.4419164804, abs=1e-9)
    ]
    assert {round(point.orbit.t0, 6) for point in same} == {0.090233, 2.036081}

    curves = [pc.continue_curve(graze, {GAP: (0, 1.2), AMPLITUDE: (0.05, 4)}) for graze in same]

    for curve in curves:
        assert curve.values[0] == pytest.approx(curves[0].values[0], abs=1e-9)
        assert curve.values[-1] == pytest.approx(curves[0].values[-1], abs=1e-9)
    one, other = (point.graze for point in same)
    assert one is not None
    assert other is not None
    assert one.monodromy == pytest.approx(other.monodromy, rel=1e-6, abs=1e-9)
    assert one.depth_rate == pytest.approx(other.depth_rate, rel=1e-6)


def test_a_curve_ends_where_impacts_coincide_as_a_branch_does() -> None:
    """Without damping two impacts merge at the resonance: beyond it a flight would last -0.15."""
    osc = pc.impact_oscillator("0.95", wall="0.25", side="above")
    force = pc.cosine("0.9", amplitude="1.175", constant="0.365")
    orbits = [each for each in pc.find_orbits(osc, force, 2, 1) if each.n_impacts == 2]
    constant = "forcing.constant"
    branches = [pc.continue_orbit(each, over={OMEGA: (0.5, 3.5)}) for each in orbits]
    doublings = [point for branch in branches for point in points(branch, "period_doubling")]

    curves = [pc.continue_curve(each, {OMEGA: (0.5, 3.5), constant: (-1, 1)}) for each in doublings]

    assert curves
    for curve in curves:
        assert all(orbit.itinerary.durations.min() > -1e-6 for orbit in curve)
    merged = [curve for curve in curves if "impacts coincide" in curve.end_reason]
    assert merged
    for curve in merged:
        (place,) = (q for q in curve.special_points if q.row in (0, len(curve) - 1))
        assert place.kind == "period_doubling_grazing"
        assert place.values[0] == pytest.approx(2.0, abs=1e-9)


def test_a_curve_of_grazing_goes_over_no_flights_of_negative_duration() -> None:
    stops = pc.Wall("0.6", "above", "0.554"), pc.Wall("-0.22", "below", "0.442")
    osc, force = pc.Oscillator(1, "0.01", stops), pc.cosine("2.175", amplitude="0.881")
    orbits = [each for each in pc.find_orbits(osc, force, 2, 2) if each.sequence == (1, 1)]
    branches = [pc.continue_orbit(each, over={GAP: (0, 1.2)}) for each in orbits]
    grazes = [point for branch in branches for point in points(branch, "grazing")]

    curves = [pc.continue_curve(each, {OMEGA: (0.5, 3.5), GAP: (0, 1.2)}) for each in grazes]

    assert any("impacts coincide" in curve.end_reason for curve in curves)
    for curve in curves:
        assert all(orbit.itinerary.durations.min(initial=0.0) > -1e-6 for orbit in curve)


def test_a_curve_that_begins_at_a_double_graze_says_so() -> None:
    """The motion without impacts between two walls grazes both, until a constant force is added."""
    walls = pc.Wall("0.5", "above", "0.7"), pc.Wall("-0.5", "below", "0.7")
    calm = pc.find_orbit(pc.Oscillator(1, "0.05", walls), pc.cosine(2, amplitude=1), 0)
    (graze,) = points(pc.continue_orbit(calm, over={AMPLITUDE: (0.5, 3)}), "grazing")

    aside = pc.continue_curve(graze, {AMPLITUDE: (0.5, 3), "forcing.constant": (-0.2, 0.2)})
    both = pc.continue_curve(graze, {AMPLITUDE: (0.5, 3), OMEGA: (1.5, 2.5)})

    (double,) = aside.special_points
    assert double.kind == "double_grazing"
    assert double.values == (graze.value, 0.0)
    assert not any(point.kind == "double_grazing" for point in both.special_points)
