"""Unstable manifolds of structures' orbits, against the oscillator's own and by where they lead."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import percuss as pc
import percuss.plotting as pp
from percuss.arrays import Floats

TWO = pc.chain([1, 1], [1, 1, 0], "0.1", [pc.Wall("0.5", "above", "0.7", on=1)])
LOADS = pc.Loads({0: pc.cosine("0.9", amplitude="0.3")})


@pytest.fixture(scope="module")
def orbits() -> list[pc.StructureOrbit]:
    return pc.find_orbits(TWO, LOADS, 1, 1)


@pytest.fixture(scope="module")
def grown(orbits: list[pc.StructureOrbit]) -> pc.StructureManifolds:
    (saddle,) = (orbit for orbit in orbits if not orbit.is_stable)
    return pc.manifolds(saddle, length=2.0, spacing=0.02, cycle=0.25)


def distances(points: Floats, curve: Floats, scale: Floats) -> Floats:
    """The distances of points from a line of straight pieces, in units of the scale."""
    a, b = curve[:-1] / scale, curve[1:] / scale
    steps = b - a
    off = (points / scale)[:, None] - a
    part = np.clip((off * steps).sum(-1) / (steps * steps).sum(-1), 0.0, 1.0)
    return np.asarray(np.sqrt(((off - part[..., None] * steps) ** 2).sum(-1)).min(axis=1))


def test_one_coordinate_has_the_curve_of_the_oscillator() -> None:
    stops = (pc.Wall("1.45789", "above", "0.7"),)
    osc, force = pc.Oscillator(1, "0.05", stops), pc.cosine("1.5")
    theirs = next(o for o in pc.find_orbits(osc, force, 1, 1) if o.stability == "unstable")
    structure, loads = pc.Structure(1, 1, "0.1", stops), pc.Loads({0: force})
    ours = next(o for o in pc.find_orbits(structure, loads, 1, 1) if not o.is_stable)

    curves: list[Any] = [pc.manifolds(orbit, length=1.0) for orbit in (ours, theirs)]

    np.testing.assert_allclose(curves[0].saddles, curves[1].saddles, atol=1e-11)
    assert curves[0].multiplier == pytest.approx(curves[1].multipliers[0], rel=1e-10)
    halves = [
        np.concatenate([b.points for b in c.branches if b.kind == "unstable"]) for c in curves
    ]
    # A line of points 0.01 apart is off the curve by their distance squared.
    one = [b.points for b in curves[1].unstable]
    for points in np.array_split(halves[0], 4):
        near = np.minimum(*(distances(points, line, curves[1].scale) for line in one))
        assert near.max() < 1e-4


def test_images_of_points_lie_on_the_curve(grown: pc.StructureManifolds) -> None:
    period = grown.orbit.period
    for branch in grown.branches:
        assert branch.end_reason in ("length", "collapse")
        (curve,) = branch.pieces
        # Of these the images are still on it.
        some = curve[(branch.arclength > 0.05) & (branch.arclength < 0.25)][::3]
        images = []
        for state in some:
            run = pc.simulate(
                TWO, LOADS, x0=state[:2], v0=state[2:], t0=0.25 * period, t_end=1.25 * period
            )
            images.append(np.concatenate(run(run.t_end)))
        assert len(images) > 3
        assert distances(np.array(images), curve, grown.scale).max() < 1e-4
        # Near the saddle it has the direction of the eigenvector.
        first = (curve[1] - curve[0]) / grown.scale
        first /= np.linalg.norm(first)
        along = first @ (grown.directions[0] / grown.scale)
        assert abs(along) == pytest.approx(1.0, abs=1e-3)
        assert np.sign(along) == branch.side


def test_its_halves_lead_to_the_two_attractors(
    grown: pc.StructureManifolds, orbits: list[pc.StructureOrbit]
) -> None:
    attractors = [orbit for orbit in orbits if orbit.is_stable]
    reached = set()
    for branch in grown.branches:
        state = branch.points[len(branch) // 2]
        t0 = 0.25 * grown.orbit.period
        run = pc.simulate(TWO, LOADS, x0=state[:2], v0=state[2:], t0=t0, periods=150)
        x, _ = run(100.0 * grown.orbit.period)
        off = [float(np.abs(orbit.x0 - x).max()) for orbit in attractors]
        assert min(off) < 1e-6
        reached.add(int(np.argmin(off)))

    assert reached == {0, 1}


def test_tables_have_all_points(grown: pc.StructureManifolds) -> None:
    data = grown.to_xarray()
    assert (data.x.attrs["units"], data.v.attrs["units"]) == ("length", "length/time")
    assert data.x.shape == data.v.shape == (sum(map(len, grown.branches)), 2)
    assert data.saddle.values.tolist() == [0, 0]
    pieces = grown.displacement((1, -1))
    np.testing.assert_array_equal(
        np.concatenate(pieces)[:, 0], data.x.values[:, 0] - data.x.values[:, 1]
    )
    assert repr(grown).startswith("<StructureManifolds: at cycle 0.25, 1 saddle points; ")


def test_pictures_show_one_displacement(grown: pc.StructureManifolds) -> None:
    for on, name in ((None, "x_{1}"), ((1, -1), "x_{0} - x_{1}")):
        ax = pp.plot_manifolds(grown, on=on)

        manifold, saddle = ax.lines
        c = grown.orbit.structure.direction(1 if on is None else on)
        np.testing.assert_allclose(saddle.get_xdata(), grown.saddles[:, :2] @ c)
        assert np.isfinite(np.asarray(manifold.get_xdata(), dtype=float)).sum() > 100
        assert name in ax.get_xlabel()


def test_what_is_no_curve_is_told(orbits: list[pc.StructureOrbit]) -> None:
    stable = next(orbit for orbit in orbits if orbit.is_stable)
    (saddle,) = (orbit for orbit in orbits if not orbit.is_stable)
    calls: dict[str, dict[str, Any]] = {
        r"kinds = \('stable',\): of a structure a surface of 3 dim": {"kinds": ("stable",)},
        "section = 'impact': of a structure there is the stroboscopic": {"section": "impact"},
        r"spacing = 0\.0: not a finite positive number": {"spacing": 0.0},
    }

    with pytest.raises(pc.ParameterError, match="0 multipliers outside the unit circle and 0 on"):
        pc.manifolds(stable)
    for sentence, given in calls.items():
        with pytest.raises(pc.ParameterError, match=sentence):
            pc.manifolds(saddle, **given)


def test_growing_stops_by_progress(orbits: list[pc.StructureOrbit]) -> None:
    (saddle,) = (orbit for orbit in orbits if not orbit.is_stable)

    found = pc.manifolds(saddle, length=5.0, progress=lambda done, _: done < 1.0)

    assert len(found.branches) == 1
