"""Stable and unstable manifolds of saddle orbits."""

from __future__ import annotations

import cmath
import math
from typing import Literal

import numpy as np
import pytest

import percuss as pc
from percuss.arrays import Floats
from percuss.orbits.surface.manifold_growth import LONGEST, local_manifold

PENDULUM = pc.Oscillator(stiffness=-1.0, damping=0.1)
# Slopes of the manifolds of free motion at k = -1, a = 0.1.
GROWING = math.sqrt(1.01) - 0.1
FALLING = -math.sqrt(1.01) - 0.1


def saddle_of_the_pendulum(amplitude: float, *stops: pc.Wall) -> pc.PeriodicOrbit:
    osc = pc.Oscillator(-1.0, 0.1, stops)
    return pc.find_orbit(osc, pc.cosine(2.0, amplitude=amplitude), n_impacts=0)


@pytest.fixture(scope="module")
def flip() -> pc.PeriodicOrbit:
    """A saddle with negative multipliers, past its period doubling at 2.6533."""
    return pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.7))


@pytest.fixture(scope="module")
def bilinear() -> pc.PeriodicOrbit:
    """An inverted pendulum between two soft stops."""
    stops = (pc.SoftStop(-0.5, "below", 9.0, 0.3), pc.SoftStop(0.5, "above", 9.0, 0.3))
    osc = pc.Oscillator(-1.0, 0.1, stops)
    return pc.find_orbit(osc, pc.cosine(2.0, amplitude=0.3), n_impacts=0)


def distances(points: Floats, branches: tuple[pc.ManifoldBranch, ...], scale: Floats) -> Floats:
    """Return how far points lie from the polylines of branches, in units of the scale."""
    pieces = [piece / scale for branch in branches for piece in branch.pieces]
    begin = np.concatenate([piece[:-1] for piece in pieces])
    along = np.concatenate([np.diff(piece, axis=0) for piece in pieces])
    found = np.empty(len(points))
    for i, point in enumerate(points / scale):
        rest = point - begin
        part = (rest * along).sum(axis=1) / np.maximum((along**2).sum(axis=1), 1e-300)
        rest -= np.clip(part, 0.0, 1.0)[:, None] * along
        found[i] = np.sqrt((rest**2).sum(axis=1).min())
    return found


def test_manifolds_of_free_motion_are_straight_lines() -> None:
    curves = pc.manifolds(saddle_of_the_pendulum(1.0), length=10.0)

    for branch in curves.branches:
        x, v = (branch.points - curves.saddles[0]).T
        slope = GROWING if branch.kind == "unstable" else FALLING
        assert branch.end_reason == "length"
        assert len(branch.pieces) == 1
        assert np.sign(x[-1]) == branch.side
        np.testing.assert_allclose(v, slope * x, atol=1e-11)


def test_local_manifold_has_the_curvature_of_the_map() -> None:
    """(x, y) -> (2 x, y / 2 + x^2) keeps y = x^2 / (4 - 1 / 2)."""

    def forth(points: Floats) -> Floats:
        x, y = points.T
        return np.column_stack([2.0 * x, 0.5 * y + x**2])

    local = local_manifold(
        forth,
        lambda first, second: second - first,
        np.zeros(2),
        np.diag([2.0, 0.5]),
        np.array([1.0, 0.0]),
        2.0,
        np.ones(2),
    )

    assert local.reach == LONGEST
    np.testing.assert_allclose(local.bend, [0.0, 1.0 / 3.5], atol=1e-7)
    np.testing.assert_allclose(local.at(np.array([0.02])), [[0.02, 0.0004 / 3.5]], atol=1e-11)


def test_first_points_lie_along_the_eigenvectors(flip: pc.PeriodicOrbit) -> None:
    curves = pc.manifolds(flip, cycle=0.37, length=0.5)
    step = pc.stroboscopic_map(flip.oscillator, flip.forcing, cycle=0.37)  # type: ignore[arg-type]
    matrix = step.jacobian(*curves.saddles[0])

    for branch in curves.branches:
        multiplier = curves.multipliers[0 if branch.kind == "unstable" else 1]
        tangent = branch.points[1] - branch.points[0]
        tangent /= np.hypot(*tangent)
        np.testing.assert_allclose(matrix @ tangent, multiplier * tangent, atol=0.02)


@pytest.mark.parametrize("section", ["stroboscopic", "impact"])
def test_manifolds_of_a_wall_oscillator_are_invariant(
    flip: pc.PeriodicOrbit, section: Literal["stroboscopic", "impact"]
) -> None:
    curves = pc.manifolds(
        flip,
        section=section,
        cycle=0.37,
        length=4.0,
        spacing=0.004,
    )
    assert flip.forcing is not None
    step: pc.StroboscopicMap | pc.ImpactMap = pc.impact_map(flip.oscillator, flip.forcing)
    if section == "stroboscopic":
        step = pc.stroboscopic_map(flip.oscillator, flip.forcing, cycle=0.37)

    for branches, far in ((curves.stable, 4.0), (curves.unstable, 0.8)):
        for branch in branches:
            points = branch.points[branch.arclength < far][5::40]
            images = np.stack(step(*points.T), axis=1)
            # Chords of 0.004 that turn by 0.15 stay within 0.004 * 0.15 / 8 of their arc.
            assert distances(images, branches, curves.scale).max() < 1e-4


def test_manifolds_between_soft_stops_are_invariant(bilinear: pc.PeriodicOrbit) -> None:
    curves = pc.manifolds(bilinear, length=6.0, spacing=0.01)
    step = pc.stroboscopic_map(bilinear.oscillator, bilinear.forcing)  # type: ignore[arg-type]

    for branches, far in ((curves.stable, 6.0), (curves.unstable, 0.2)):
        for branch in branches:
            points = branch.points[branch.arclength < far][5::20]
            images = np.stack(step(*points.T), axis=1)
            assert distances(images, branches, curves.scale).max() < 3e-4


def test_elastic_manifolds_are_mirror_images_in_time() -> None:
    """Without losses, and with a force even in time, (cycle, v) -> (-cycle, v) swaps them.

    One of them is grown by the map alone, the other one by its inverse alone.
    """
    orbit = pc.find_orbit(pc.impact_oscillator(), pc.cosine(2.7))
    curves = pc.manifolds(orbit, section="impact", length=3.0, spacing=0.005)

    for branches, others in ((curves.stable, curves.unstable), (curves.unstable, curves.stable)):
        for branch in branches:
            mirrored = branch.points[5::60] * [-1.0, 1.0] % [1.0, np.inf]
            inside = branch.arclength[5::60] < 2.9
            assert distances(mirrored[inside], others, curves.scale).max() < 1e-4


def test_motions_on_the_stable_manifold_approach_the_orbit(flip: pc.PeriodicOrbit) -> None:
    """Seen by `simulate` alone, which knows no inverse map."""
    curves = pc.manifolds(flip, cycle=0.37, length=4.0, kinds=("stable",))
    period = flip.period

    for branch in curves.stable:
        for x, v in branch.points[10::150]:
            run = pc.simulate(
                flip.oscillator, flip.forcing, x, v, 0.37 * period, t_end=30.37 * period
            )
            t = (np.arange(31) + 0.37) * period
            away = np.hypot(*((np.stack(run(t), axis=1) - curves.saddles[0]) / curves.scale).T)
            # Rounding leaves the saddle again by 1.73 a period.
            assert away.min() < 1e-5


@pytest.mark.parametrize("restitution", [0.8, 0.5])
@pytest.mark.parametrize(("part", "meets"), [(0.98, False), (1.02, True)])
def test_manifolds_cross_from_the_homoclinic_tangency_on(
    restitution: float, part: float, meets: bool
) -> None:
    """The condition of Shaw & Rand (1989), from the saddle's motion x = B cos(omega t - phi).

    What leaves along the unstable direction hits the wall at 1 with v = x' + l+ (1 - x), and
    returns on the stable one if -r v = x' + l- (1 - x): for some t if and only if
    B sqrt((1 + r)^2 omega^2 + m^2) >= abs(m), with m = r l+ + l-.
    """
    omega, m = 2.0, restitution * GROWING + FALLING
    grazing = abs(m) / math.hypot((1.0 + restitution) * omega, m)
    response = 1.0 / complex(-1.0 - omega**2, 0.2 * omega)
    orbit = saddle_of_the_pendulum(part * grazing / abs(response), pc.Wall(1, "above", restitution))
    # The section just after the instant at which both come nearest.
    phase = math.atan2(-(1.0 + restitution) * omega, abs(m)) - cmath.phase(response)
    cycle = phase / (2.0 * math.pi) + 0.02

    curves = pc.manifolds(orbit, cycle=cycle, length=8.0, spacing=0.002, kinds=("unstable",))

    branch = next(branch for branch in curves.unstable if branch.side == 1)
    # The first piece leads to the wall, the second one off it. Beyond the stable line?
    x, v = (branch.pieces[1] - curves.saddles[0]).T
    beyond = v - FALLING * x
    assert beyond.max() > 0.0
    assert bool(beyond.min() < 0.0) is meets


def test_manifolds_are_cut_where_they_jump() -> None:
    orbit = saddle_of_the_pendulum(1.5, pc.Wall(-1, "below", 0.8), pc.Wall(1, "above", 0.8))
    curves = pc.manifolds(orbit, length=10.0, spacing=0.02)

    for branch in curves.branches:
        assert len(branch.pieces) > 1
        for before, after in zip(branch.pieces[:-1], branch.pieces[1:], strict=True):
            assert np.hypot(*((after[0] - before[-1]) / curves.scale)) > 0.02
        for piece in branch.pieces:
            assert np.hypot(*(np.diff(piece, axis=0) / curves.scale).T).max() <= 0.02


def test_unstable_manifold_that_falls_onto_an_attractor_collapses(flip: pc.PeriodicOrbit) -> None:
    curves = pc.manifolds(flip, cycle=0.37, length=30.0, kinds=("unstable",))
    orbit = pc.find_orbit(flip.oscillator, flip.forcing, n_impacts=2, n_periods=2)
    x, v = orbit.trajectory(2)(
        (math.ceil(orbit.t0 / flip.period) + 0.37 + np.arange(2)) * flip.period
    )

    assert [branch.end_reason for branch in curves.unstable] == ["collapse"] * 2
    for branch in curves.unstable:
        assert np.hypot(branch.points[-1, 0] - x, branch.points[-1, 1] - v).min() < 1e-4


def test_restitution_of_0_ends_the_stable_manifold() -> None:
    orbit = saddle_of_the_pendulum(1.0, pc.Wall(-1, "below", 0.0), pc.Wall(1, "above", 0.0))
    curves = pc.manifolds(orbit, length=50.0, kinds=("stable",))

    assert {branch.end_reason for branch in curves.stable} == {"no_image"}


def test_an_orbit_that_leaves_a_stop_slowly_is_fast_elsewhere() -> None:
    stops = (pc.Wall("-0.236", "below", "0.677"), pc.Wall("0.556", "above", "0.757"))
    osc = pc.Oscillator(1.0, 0.10789501080286258, stops)
    force = pc.cosine(3.4444563539825968, amplitude=1.3741378272651137, phase=4.843404085715232)
    orbit = pc.find_orbit(osc, force, 2, 2, sequence=(1, 0), guess=(0.8032036967, -0.012422763))

    curves = pc.manifolds(orbit, section="impact", stop=1, length=0.5)

    # Of the motion between impacts on this stop, at 0.012, the one on the other is at 0.39.
    assert abs(curves.saddles[0, 1]) < 0.02
    assert {branch.end_reason for branch in curves.stable} == {"length"}


def test_an_orbit_of_two_periods_has_two_saddle_points() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(4.8), n_impacts=1, n_periods=2)

    curves = pc.manifolds(orbit, cycle=0.4, length=1.0)

    assert len(curves.saddles) == 2
    assert len(curves.branches) == 8
    assert {branch.saddle for branch in curves.branches} == {0, 1}


def test_to_xarray_holds_all_points(flip: pc.PeriodicOrbit) -> None:
    curves = pc.manifolds(flip, section="impact", length=1.0)
    data = curves.to_xarray()
    assert data.v_after.attrs["units"] == "length/time"

    assert data.sizes["point"] == sum(len(branch) for branch in curves.branches)
    assert data.kind.values.tolist() == [branch.kind for branch in curves.branches]
    assert data.attrs["stop"] == 0


def test_progress_is_told_and_stops(flip: pc.PeriodicOrbit) -> None:
    reported: list[tuple[float, float]] = []

    def stop_at_once(done: float, total: float) -> bool:
        reported.append((done, total))
        return False

    curves = pc.manifolds(flip, cycle=0.37, progress=stop_at_once)

    assert reported[0][1] == 4.0
    assert [branch.end_reason for branch in curves.branches] == ["interrupted"]


def test_no_more_points_are_made_than_allowed(flip: pc.PeriodicOrbit) -> None:
    curves = pc.manifolds(flip, cycle=0.37, length=15.0, max_points=300)

    for branch in curves.branches:
        assert len(branch) <= 300
        assert branch.end_reason == "max_points"
        # What there was no room to refine is left out, not cut to pieces.
        assert len(branch.pieces) <= 3


def test_bad_input_is_told(flip: pc.PeriodicOrbit) -> None:
    stable = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
    without = pc.find_orbit(pc.impact_oscillator(0.0), pc.cosine(2.5))
    with pytest.raises(pc.ParameterError, match="no saddle"):
        pc.manifolds(stable)
    with pytest.raises(pc.ParameterError, match="forgets the past"):
        pc.manifolds(without)
    with pytest.raises(pc.ParameterError, match="an impact at it"):
        pc.manifolds(flip, cycle=float(flip.impacts.cycle[0]))
    with pytest.raises(pc.ParameterError, match="does not meet it"):
        pc.manifolds(flip, section="impact", stop=1)
    with pytest.raises(pc.ParameterError, match="does not meet it"):
        pc.manifolds(saddle_of_the_pendulum(1.0), section="impact")
    with pytest.raises(pc.ParameterError, match="neither stroboscopic nor impact"):
        pc.manifolds(flip, section="poincare")  # type: ignore[call-overload]
    for name in ("length", "spacing"):
        with pytest.raises(pc.ParameterError, match="not a finite positive number"):
            pc.manifolds(flip, **{name: 0.0})  # type: ignore[call-overload]
