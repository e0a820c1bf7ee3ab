"""Curves of special points in two parameters, and the points of codimension two on them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.orbits.kinds import points
from tests.orbits.test_reference_orbits import ROWS, agree

import percuss as pc
from percuss.arrays import Floats
from percuss.io.column_units import units_of_columns
from percuss.io.results import kind_of
from percuss.kernels.flight import free_response
from percuss.model.system import law
from percuss.orbits import Branch, Curve, single_impact
from percuss.orbits.bifurcations.branch_equations import OrbitEquations
from percuss.orbits.bifurcations.curve_equations import return_equations

OMEGA, AMPLITUDE = "forcing.omega", "forcing.amplitude"
GAP, RESTITUTION = "oscillator.stops.0.at", "oscillator.stops.0.restitution"
COCO = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
PLANE = {OMEGA: (0.7, 1.3), AMPLITUDE: (0.01, 1.2)}
# Damped natural frequency: impacts that leave with any small velocity come back after half a
# period of it, or a multiple.
NATURAL = math.sqrt(1.0 - 0.05**2)


def response(omega: Floats) -> Floats:
    """The amplitude of the force under which the motion without impacts has amplitude 1."""
    return np.hypot(1.0 - omega**2, 0.1 * omega)


@pytest.fixture(scope="module")
def branch() -> Branch:
    orbit = pc.find_orbit(COCO, pc.cosine(1))
    return pc.continue_orbit(orbit, over={AMPLITUDE: (1, 0.05)})


@pytest.fixture(scope="module")
def curves(branch: Branch) -> dict[str, Curve]:
    return {point.kind: pc.continue_curve(point, PLANE) for point in branch.special_points}


def test_grazing_is_where_the_motion_without_impacts_reaches_the_wall(
    curves: dict[str, Curve],
) -> None:
    curve = curves["grazing"]

    omega, amplitude = curve.values.T

    np.testing.assert_allclose(amplitude, response(omega), rtol=0.0, atol=1e-12)
    assert curve.admissible.all()
    # The reference tells A at omega = 0.7 and 1.3, where the curve leaves the range.
    _, *expected = (float(value) for value in ROWS["coco-grazing-A"]["value"])
    assert omega[[0, -1]].tolist() == [0.7, 1.3]
    agree(amplitude[[0, -1]].tolist(), expected, "coco-grazing-A")


def test_a_table_has_a_row_for_each_orbit_and_the_units_of_both_parameters(
    curves: dict[str, Curve],
) -> None:
    curve = curves["fold"]

    (columns,) = (table(curve) for table in kind_of(curve).columns.values())

    assert list(columns)[:2] == [OMEGA, AMPLITUDE]
    np.testing.assert_array_equal(columns[OMEGA], curve.values[:, 0])
    assert {len(column) for column in columns.values()} == {len(curve)}
    kinds = [kind for kind in columns["special_point"] if kind]
    assert kinds == [point.kind for point in curve.special_points] != []
    units = units_of_columns(curve, columns, pc.Units("mm", "s"))
    assert units == {OMEGA: "1/s", AMPLITUDE: "mm/s^2"}
    assert curve.to_xarray()["unit"].values.tolist() == ["1/time", "length/time^2"]


def test_coco_s_grazing_curve_leaves_at_full_amplitude(branch: Branch) -> None:
    """With A up to 1 the published curve ends at sqrt(1.99), from (1 - w^2)^2 + 0.01 w^2 = 1."""
    (graze,) = points(branch, "grazing")

    curve = pc.continue_curve(graze, {OMEGA: (0.1, 1.5), AMPLITUDE: (0.01, 1.0)})

    assert curve.values[0] == pytest.approx([0.1, response(np.array(0.1))], abs=1e-12)
    assert curve.values[-1] == pytest.approx([math.sqrt(1.99), 1.0], abs=1e-12)
    assert curve.end_reason.endswith("forcing.amplitude = 1 reached")
    # Free motion makes whole numbers of half swings in a period, ever more of them.
    assert {point.kind for point in curve.special_points} == {"resonant_grazing"}
    found = [point.values[0] for point in curve.special_points]
    assert found == pytest.approx(2.0 * NATURAL / np.arange(19, 1, -1), abs=1e-10)


def test_on_the_curve_of_folds_the_discriminant_is_zero(curves: dict[str, Curve]) -> None:
    for omega, amplitude in curves["fold"].values.tolist():
        c2, c1, c0 = single_impact(COCO, pc.cosine(omega, amplitude=amplitude)).coefficients
        # c0 = b^2 - A^2.
        assert math.sqrt(c0 + amplitude**2 - c1**2 / (4.0 * c2)) == pytest.approx(
            amplitude, abs=1e-11
        )
    (graze,) = curves["fold"].special_points
    apart = np.abs(curves["fold"].multipliers - 1.0).min(axis=1)
    # Where the impact has no velocity it divides by nothing.
    assert (np.delete(apart, graze.row) < 1e-7).all()


def test_on_the_curve_of_period_doublings_the_closed_form_has_a_multiplier_of_minus_one(
    curves: dict[str, Curve],
) -> None:
    """The monodromy matrix is the free motion over a period, after what an impact does."""
    curve = curves["period_doubling"]
    assert len(curve) > 40
    for (omega, amplitude), orbit in zip(curve.values.tolist(), curve, strict=True):
        form = single_impact(COCO, pc.cosine(omega, amplitude=amplitude))
        cycle, u = form.roots[np.argmin(np.abs(form.roots[:, 1] - orbit.impacts.v_before[0]))]
        if abs(u) < 1e-3:
            # Both roots are near to zero, and a square root apart.
            continue
        s = 2.0 * math.pi / omega
        impulse, even, _ = free_response(law(COCO, pc.cosine(omega)), 2, s)
        force = amplitude * math.cos(2.0 * math.pi * cycle) - 1.0
        flight = np.array([[even + 0.05 * impulse, impulse], [-impulse, even - 0.05 * impulse]])
        impact = np.array([[-0.8, 0.0], [1.8 * force / u, -0.8]])
        trace, determinant = np.trace(flight @ impact), 0.64 * math.exp(-0.1 * s)
        assert abs(u * (1.0 + trace + determinant)) < 1e-11 * amplitude


def test_all_three_curves_touch_at_the_resonant_graze(curves: dict[str, Curve]) -> None:
    found = {kind: curve.special_points for kind, curve in curves.items()}

    assert {kind: [point.kind for point in each] for kind, each in found.items()} == {
        "fold": ["fold_grazing"],
        "grazing": ["resonant_grazing"],
        "period_doubling": ["period_doubling_grazing"],
    }
    for ((point),) in found.values():
        assert point.status == "located"
        assert point.codimension == 2
        # The motion without impacts has there the period of the free damped motion.
        assert point.values == pytest.approx([NATURAL, response(np.array(NATURAL))], abs=1e-10)
        for (low, high), value in zip(point.intervals, point.values, strict=True):
            assert low <= value <= high <= low + 1e-10


def test_thresholds_of_the_ball_for_every_restitution() -> None:
    """With g = w = 1 it is in step from A = pi (1 - r)/(1 + r) on (Guckenheimer & Holmes 1983).

    Its period doubles where A^2 has grown by (2 (1 + r^2)/(1 + r)^2)^2.
    """
    osc, force = pc.ball_on_table(amplitude="0.6", omega=1, gravity=1, restitution="0.8")
    branch = pc.continue_orbit(pc.find_orbit(osc, force), over={AMPLITUDE: (0.2, 1.3)})
    ranges = {RESTITUTION: (0.5, 1.0), AMPLITUDE: (0.01, 3.0)}

    fold, doubling = (
        pc.continue_curve(points(branch, kind)[0], ranges, largest_step=0.1)
        for kind in ("fold", "period_doubling")
    )

    r, amplitude = fold.values.T
    np.testing.assert_allclose(amplitude, math.pi * (1 - r) / (1 + r), rtol=0.0, atol=1e-11)
    r, amplitude = doubling.values.T
    expected = np.hypot(math.pi * (1 - r) / (1 + r), 2 * (1 + r**2) / (1 + r) ** 2)
    np.testing.assert_allclose(amplitude, expected, rtol=0.0, atol=1e-11)
    assert r[-1] == 1.0


@pytest.mark.parametrize("kind", ["fold", "period_doubling"])
def test_the_curves_go_through_their_graze_to_formal_orbits(
    curves: dict[str, Curve], kind: str
) -> None:
    curve = curves[kind]
    (point,) = curve.special_points

    before, after = curve.admissible[: point.row], curve.admissible[point.row + 1 :]

    assert before.all() != after.all()
    assert before.any() != after.any()
    smaller = np.diff(curve.values[:, 0]) > 0.0
    assert smaller[point.row - 3 : point.row + 3].all()
    # The curves touch that of grazes: they part with the square of the distance.
    rows = point.row + np.array([-3, -1, 1, 3])
    apart = np.abs(curve.values[rows, 1] - response(curve.values[rows, 0]))
    distances = np.abs(curve.values[rows, 0] - NATURAL)
    factors = apart / distances**2
    assert distances.max() > 3.0 * distances.min()
    assert factors.max() < 2.0 * factors.min()


def test_a_plastic_wall_is_no_exception() -> None:
    osc = pc.impact_oscillator(0, wall=1, side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine(1))
    branch = pc.continue_orbit(orbit, over={AMPLITUDE: (1, 0.05)})

    for point in branch.special_points:
        curve = pc.continue_curve(point, {OMEGA: (0.97, 1.03), AMPLITUDE: (0.01, 1.2)})
        (resonant,) = curve.special_points
        assert resonant.values == pytest.approx([NATURAL, response(np.array(NATURAL))], abs=1e-9)


def test_a_doubling_found_on_the_doubled_orbit_is_followed_as_that_of_the_single_one() -> None:
    osc = pc.impact_oscillator(0.8)
    ranges = {OMEGA: (2.4, 2.9), RESTITUTION: (0.75, 0.85)}
    single = pc.continue_orbit(pc.find_orbit(osc, pc.cosine(2.5)), over={OMEGA: (2.4, 2.9)})
    doubled = pc.continue_orbit(
        pc.find_orbit(osc, pc.cosine("2.68"), 2, 2), over={OMEGA: (2.6, 2.7)}
    )

    ends = [
        pc.continue_curve(points(each, "period_doubling")[0], ranges).values[[0, -1]]
        for each in (single, doubled)
    ]

    np.testing.assert_allclose(ends[0], ends[1], atol=1e-10)


def test_orbits_on_a_curve_of_grazing_with_impacts_graze_the_wall() -> None:
    """Orbits with an impact every second forcing period, and a turning point in between."""
    osc = pc.impact_oscillator("0.8", wall=0.5, side="above", damping="0.02")
    orbit = pc.find_orbit(osc, pc.cosine("2.9"), 1, 2)
    branch = pc.continue_orbit(orbit, over={OMEGA: (1.5, 6)})
    graze = max(points(branch, "grazing"), key=lambda point: point.value)
    assert "turning point" in graze.detail

    curve = pc.continue_curve(graze, {OMEGA: (1.5, 6), RESTITUTION: (0.0, 1.0)}, largest_step=0.1)

    assert curve.values[[0, -1], 1].tolist() == [0.0, 1.0]
    # With little restitution the mass comes back to the wall right after an impact.
    double = [each for each in curve.special_points if each.kind == "double_grazing"]
    assert len(double) == 1
    assert (curve.admissible == (curve.values[:, 1] >= double[0].values[1])).all()
    for row in (0, *range(double[0].row + 1, len(curve), 4)):
        orbit = curve[row]
        assert orbit.n_impacts == 1
        run = orbit.trajectory()
        # Away from the impact, and from the small hop after it.
        inside = np.linspace(run.t0, run.t_end, 4002)[500:-50]
        x, _ = run(inside)
        peak = inside[np.argmax(x)]
        x, _ = run(np.linspace(peak - 1e-2, peak + 1e-2, 2001))
        # A maximum between two samples 1e-5 apart is missed by less than 1e-9.
        assert x.max() == pytest.approx(0.5, abs=1e-9)


def test_a_soft_stop_grazes_where_a_wall_does(soft: Branch) -> None:
    (graze,) = points(soft, "grazing")

    curve = pc.continue_curve(graze, {OMEGA: (1.2, 2.0), AMPLITUDE: (0.1, 4.0)})

    np.testing.assert_allclose(curve.values[:, 1], response(curve.values[:, 0]), atol=1e-12)
    assert curve.special_points == ()


@pytest.mark.parametrize("which", ["single", "mirrored", "soft"])
def test_neighbours_return_multiplied(which: str, mirrored: Branch, soft: Branch) -> None:
    """The determinant of the equations is the characteristic polynomial, up to a factor."""
    orbit = {
        "single": pc.find_orbit(COCO, pc.cosine(1)),
        "mirrored": mirrored[3],
        "soft": soft[3],
    }[which]
    equations = OrbitEquations(orbit, {AMPLITUDE: (0.0, 5.0)})
    table = equations.law_at(equations.own_values)
    _, matrix = equations.shot(equations.unknowns_of(orbit), table)

    def determinant(multiplier: float) -> float:
        return float(np.linalg.det(return_equations(matrix, equations.n, multiplier)))

    trace, product = np.trace(orbit.monodromy), np.prod(orbit.multipliers).real
    factor = determinant(2.0) / (4.0 - 2.0 * trace + product)
    assert factor != 0.0
    for mu in (-1.0, 0.0, 0.5, 1.0):
        expected = factor * (mu * mu - mu * trace + product)
        assert determinant(mu) == pytest.approx(expected, rel=1e-9, abs=1e-9 * abs(factor))


def test_the_order_of_the_range_is_that_of_the_rows(branch: Branch) -> None:
    (fold,) = points(branch, "fold")

    up = pc.continue_curve(fold, {OMEGA: (0.9, 1.1), AMPLITUDE: (0.05, 1.0)})
    down = pc.continue_curve(fold, {OMEGA: (1.1, 0.9), AMPLITUDE: (0.05, 1.0)})
    turned = pc.continue_curve(fold, {AMPLITUDE: (0.05, 1.0), OMEGA: (0.9, 1.1)})

    assert up.values[[0, -1], 0].tolist() == [0.9, 1.1]
    np.testing.assert_allclose(down.values, up.values[::-1], atol=1e-10)
    assert turned.paths == (AMPLITUDE, OMEGA)
    assert sorted(turned.values[[0, -1], 1].tolist()) == [0.9, 1.1]


def test_what_was_followed_is_returned_when_it_is_stopped(branch: Branch) -> None:
    (fold,) = points(branch, "fold")
    reported: list[tuple[float, float]] = []

    def stop(done: float, total: float) -> bool:
        reported.append((done, total))
        return done < 4

    short = pc.continue_curve(fold, PLANE, max_points=3)
    stopped = pc.continue_curve(fold, PLANE, progress=stop)

    assert "max_points = 3 reached" in short.end_reason
    assert 4 <= len(short) <= 9
    assert "stopped by progress" in stopped.end_reason
    assert reported[0] == (1, 4000)
    assert len(stopped) < len(short)


def test_a_curve_is_a_table(curves: dict[str, Curve]) -> None:
    curve = curves["fold"]

    data = curve.to_xarray()

    assert data.value.values.tolist() == curve.values.tolist()
    assert data.parameter.values.tolist() == [OMEGA, AMPLITUDE]
    assert data.special_kind.values.tolist() == ["fold_grazing"]
    assert data.attrs["end_reason"] == curve.end_reason
    assert len(list(curve)) == len(curve) == data.sizes["point"]
    assert (np.diff(curve.arclength) > 0.0).all()
    assert curve[2] is curve.orbits[2]
    assert "1 fold_grazing" in repr(curve)


def test_bad_input_is_named(branch: Branch, mirrored: Branch) -> None:
    (fold,) = points(branch, "fold")
    follow = pc.continue_curve

    with pytest.raises(pc.ParameterError, match=r"did you mean forcing\.omega"):
        follow(fold, {"forcing.omga": (0.9, 1.1), AMPLITUDE: (0.05, 1.0)})
    with pytest.raises(pc.ParameterError, match=r"own value 1\b"):
        follow(fold, {OMEGA: (1.1, 1.2), AMPLITUDE: (0.05, 1.0)})
    with pytest.raises(pc.ParameterError, match="two numbers"):
        follow(fold, {OMEGA: (1.1,), AMPLITUDE: (0.05, 1.0)})  # type: ignore[dict-item]
    with pytest.raises(pc.ParameterError, match="two parameters"):
        follow(fold, {OMEGA: (0.9, 1.1)})
    with pytest.raises(pc.ParameterError, match="twice the same"):
        follow(fold, {OMEGA: (0.9, 1.1), "forcing.harmonics.0.omega": (0.9, 1.1)})
    with pytest.raises(pc.ParameterError, match="max_points"):
        follow(fold, PLANE, max_points=0)
    with pytest.raises(pc.ParameterError, match="largest_step"):
        follow(fold, PLANE, largest_step=2.0)
    with pytest.raises(pc.ParameterError, match="no special point"):
        follow(branch[0], PLANE)  # type: ignore[call-overload]
    (breaks,) = points(mirrored, "symmetry_breaking")
    with pytest.raises(pc.ParameterError, match="symmetry is lost"):
        follow(breaks, {GAP: (0.2, 0.5), AMPLITUDE: (0.05, 4.0)})


def test_other_kinds_of_points_make_no_curve(conservative: Branch) -> None:
    resonance = points(conservative, "strong_resonance")[0]

    with pytest.raises(pc.ParameterError, match="fold, period_doubling, symmetry_breaking or"):
        pc.continue_curve(resonance, {OMEGA: (2.2, 3.8), GAP: (-1.0, 0.0)})
