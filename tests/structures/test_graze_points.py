"""Points of codimension two on curves of grazes of structures: what the grazing orbit meets besides.

A second stop that is only touched changes nothing. So along the curve of its grazes the orbit is
that of the structure without it, and the points lie where that orbit has its folds, doublings and
torus points: found on its branch by other equations, and checked by a reference of 40 digits.
"""

from __future__ import annotations

from functools import cache

import mpmath
import numpy as np
import pytest
from mpmath import mpf
from tests.oracle.structures import simulate_structure, structure_problem

import percuss as pc
from percuss.orbits.bifurcations.structure_branch import StructureBranch
from percuss.orbits.bifurcations.structure_curve import StructureCurve

# Example 03 of NLvib, whose parameters alone are taken.
FIRST = pc.SoftStop(at=1, side="above", stiffness=100, on=0)
KINDS = {"fold": "fold_grazing", "period_doubling": "doubling_grazing", "torus": "torus_grazing"}
SECONDS = {
    "wall": {"restitution": "0.6"},
    "soft": {"stiffness": 30, "damping": "0.2"},
}


def chain(*stops: object) -> pc.Structure:
    return pc.chain([1, 1], [0, 1, 1], [0, "0.03", "0.03"], [FIRST, *stops])  # type: ignore[list-item]


def loads(omega: object) -> pc.Loads:
    return pc.Loads({1: pc.cosine(omega, amplitude="0.1")})  # type: ignore[arg-type]


@cache
def alone() -> StructureBranch:
    """Return the branch of the structure without the second stop."""
    orbit = pc.find_orbit(chain(), loads("0.65"))
    return pc.continue_orbit(orbit, over={"loads.0.omega": (0.6, 0.77)}, largest_step=0.2)


@cache
def grazes(second: str) -> StructureCurve:
    """Return the curve of the grazes of the second stop, over frequency and place."""
    orbit = pc.find_orbit(chain(), loads("0.65"))
    top = orbit.run.extremes("displacement", on=1).maximum
    kind = pc.Wall if second == "wall" else pc.SoftStop
    stop = kind(at=top + 0.01, side="above", on=1, **SECONDS[second])  # type: ignore[arg-type]
    orbit = pc.find_orbit(chain(stop), loads("0.65"), guess=orbit)
    place = "structure.stops.1.at"
    branch = pc.continue_orbit(orbit, over={place: (top + 0.01, top - 0.01)}, largest_step=0.3)
    (graze, *_) = (point for point in branch.special_points if point.kind == "grazing")
    ranges = {"loads.0.omega": (0.6, 0.77), place: (0.1, 3.0)}
    return pc.continue_curve(graze, over=ranges, largest_step=0.2)


@pytest.mark.parametrize("second", ["wall", pytest.param("soft", marks=pytest.mark.nightly)])
def test_a_graze_meets_the_folds_doublings_and_torus_points_of_its_orbit(second: str) -> None:
    found = {kind: [] for kind in KINDS.values()}  # type: dict[str, list[tuple[float, float]]]
    for point in grazes(second).special_points:
        found[point.kind].append(point.values)
    expected = {kind: [] for kind in KINDS.values()}  # type: dict[str, list[tuple[float, float]]]
    for own in alone().special_points:
        if own.kind in KINDS:
            top = own.orbit.run.extremes("displacement", on=1).maximum
            expected[KINDS[own.kind]].append((own.value, top))

    assert {kind: len(values) for kind, values in found.items()} == {
        "fold_grazing": 2, "doubling_grazing": 2, "torus_grazing": 1,
    }  # fmt: skip
    for kind, values in expected.items():
        # A zero of a multiplier's test is known less well than the orbit.
        np.testing.assert_allclose(sorted(found[kind]), sorted(values), rtol=0, atol=1e-10)


@pytest.mark.nightly
@pytest.mark.parametrize("row", range(5))
def test_their_multipliers_are_those_of_forty_digits(row: int) -> None:
    point = grazes("wall").special_points[row]
    omega, place = point.values
    problem = structure_problem(chain(), {1: pc.cosine(omega, amplitude="0.1")})
    with mpmath.workdps(40):
        period, h = 2 * mpmath.pi / mpf(omega), mpf("1e-15")
        start = [mpf(value) for value in (*point.orbit.x0.tolist(), *point.orbit.v0.tolist())]

        def image(state: list[mpf]) -> list[mpf]:
            run = simulate_structure(problem, state[:2], state[2:], t_end=period)
            x, v = run(period)
            return [*x, *v]

        there = image(start)
        assert max(abs(a - b) for a, b in zip(there, start, strict=True)) < 1e-11
        columns = []
        for k in range(4):
            beside = [[*start[:k], start[k] + s * h, *start[k + 1 :]] for s in (1, -1)]
            after, before = (image(state) for state in beside)
            columns.append([(a - b) / (2 * h) for a, b in zip(after, before, strict=True)])
        monodromy = np.array(columns, dtype=np.float64).T
        whole = simulate_structure(problem, start[:2], start[2:], t_end=period)
        times = np.linspace(0, float(period), 2001)[1:-1].tolist()
        heights = [float(whole(t)[0][1]) for t in times]
        near = times[int(np.argmax(heights))]
        turn = mpmath.findroot(lambda t: whole(t)[1][1], near)
        assert abs(whole(turn)[0][1] - mpf(place)) < 1e-11
    values = np.linalg.eigvals(monodromy)
    sizes = {
        "fold_grazing": np.abs(values - 1.0).min(),
        "doubling_grazing": np.abs(values + 1.0).min(),
        "torus_grazing": min(
            abs(values[i] * values[j] - 1.0) for i in range(4) for j in range(i)
        ),
    }  # fmt: skip
    assert sizes[point.kind] < 1e-7
