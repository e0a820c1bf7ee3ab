"""Special points by themselves: each is the shortest of branches, which another program proves again."""

from __future__ import annotations

import copy
import dataclasses
import functools
import json
import re
from fractions import Fraction
from typing import Any, cast

import numpy as np
import pytest
from tests.certified.checker import (
    Claims,
    assert_refused,
    by_name,
    changed,
    chosen,
    leaves,
    theorem_of,
)
from tests.certified.motions import backlash, corner_of_two_stops
from tests.certified.test_special_points import impacting, points, wall_0

import percuss as pc
from arithmetic import of, unit
from branches import POINTS, law_over, point_said
from orbits import Cycle, shot_of
from percuss.certified import CertifiedPoint, certificate
from percuss.errors import ParameterError
from reading import FORMS, LAW, read
from theorems import theorem

TWO_WALLS = pc.Oscillator(
    1, "0.02", (pc.Wall("0.3", "above", "0.7"), pc.Wall("-0.5", "below", "0.7"))
)
SPRING_AND_WALL = pc.Oscillator(
    1, "0.05", (pc.SoftStop("0.6", "above", 9), pc.Wall("0.9", "above", "0.7"))
)


@functools.cache
def elastic() -> pc.PeriodicOrbit:
    return pc.find_orbit(pc.impact_oscillator(1), pc.cosine("2.5"))


@functools.cache
def symmetric() -> pc.PeriodicOrbit:
    walls = pc.Wall("0.3", "above", "0.7"), pc.Wall("-0.3", "below", "0.7")
    return pc.find_orbit(pc.Oscillator(1, "0.02", walls), pc.cosine("1.5"), 2, 1)


@functools.cache
def point_of(orbit: pc.PeriodicOrbit, path: str, ends: tuple[float, float], near: float) -> Any:
    branch = pc.continue_orbit(orbit, over={path: ends})
    return min(branch.special_points, key=lambda point: abs(point.value - near))


def proven_again(claims: Claims, said: str) -> tuple[Fraction, Fraction]:
    """Return the numbers between which the parameter is proven to be."""
    lines = theorem_of(claims).splitlines()
    (line,) = (line for line in lines if said in line)
    low, high = re.findall(r"-?[0-9]+\.[0-9]+", line)
    return Fraction(low), Fraction(high)


@pytest.mark.parametrize("digits", [8, 12, 25])
def test_a_doubling_is_proven_again(digits: int) -> None:
    point = points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"]

    claims = certificate(pc.certify(point, digits=digits))

    low, high = proven_again(claims, "a multiplier is -1, and orbits of twice the period branch")
    # 20 digits by another way: see tests/reference/cases.json, pd-r0.8-n1.
    known, unit = Fraction("2.6533477278553229342"), Fraction(1, 10**19)
    assert low - unit <= known <= high + unit
    assert high - low < Fraction(1, 10 ** (digits - 1))


@pytest.mark.parametrize("digits", [8, 25])
def test_a_fold_is_proven_again(digits: int) -> None:
    point = points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)["fold"]

    claims = certificate(pc.certify(point, digits=digits))

    low, high = proven_again(claims, "p is extremal along the curve")
    # sigma = G sqrt(1 + (omega k_x / k_d)^2): tests/reference/cases.json, fold-a0.05-r0.7-w1.5.
    known, unit = Fraction("2.1214694431410491882"), Fraction(1, 10**19)
    assert low - unit <= known <= high + unit
    assert high - low < Fraction(1, 10**digits)


@pytest.mark.parametrize("n_impacts", [0, 1])
def test_a_graze_is_proven_again_from_both_sides(n_impacts: int) -> None:
    point = points(impacting(n_impacts), "oscillator.stops.0.at", 0.5, 2.5)["grazing"]

    claims = certificate(pc.certify(point))

    low, high = proven_again(claims, "event 0 has no velocity")
    # The amplitude of steady motion, 1/|1 - omega^2 + 2 i a omega|; the words round down.
    unit = Fraction(1, 10**20)
    assert low**2 <= 1 / (Fraction(25, 16) + Fraction(9, 400)) <= (high + unit) ** 2
    assert high - low < Fraction(1, 10**20)


@pytest.mark.parametrize(
    ("point", "said"),
    [
        (lambda: point_of(symmetric(), "forcing.amplitude", (0.4, 1.1), 0.593), "half an orbit"),
        (lambda: points(backlash(), "forcing.amplitude", 0.3, 2.5)["fold"], "p is extremal"),
        (lambda: point_of(elastic(), "forcing.omega", (2.2, 2.9), 2.457), "are i and -i"),
        (lambda: point_of(elastic(), "forcing.omega", (2.2, 2.9), 2.562), "exp(2 pi i/3)"),
        (
            lambda: point_of(
                pc.find_orbit(TWO_WALLS, pc.cosine("1.5"), 2, 1),
                "oscillator.stops.1.at",
                (-3, -0.4),
                -1.4485,
            ),
            "event 1 has no velocity",
        ),
        (
            lambda: point_of(
                pc.find_orbit(TWO_WALLS, pc.cosine("1.5"), 2, 1),
                "oscillator.stops.1.at",
                (-3, -0.4),
                -0.4468,
            ),
            "event 2 has no velocity",
        ),
        (
            lambda: point_of(
                pc.find_orbit(SPRING_AND_WALL, pc.cosine("1.5", amplitude=2), 2, 1),
                "forcing.amplitude",
                (0.1, 2.5),
                0.776,
            ),
            "event 2 has no velocity",
        ),
    ],
    ids=[
        "symmetry breaking",
        "fold of four events",
        "fourth roots",
        "third roots",
        "graze of the last impact",
        "graze between two events",
        "graze among soft stops",
    ],
)
def test_points_of_each_kind_are_proven_again(point: Any, said: str) -> None:
    proven = pc.certify(point())

    low, high = proven_again(certificate(proven), said)

    unit = Fraction(1, 10**9)
    assert low - unit < Fraction(proven.value.mid()) < high + unit
    assert high - low < unit


@pytest.fixture(scope="module")
def doubling() -> CertifiedPoint:
    return pc.certify(points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"])


@by_name
@pytest.mark.parametrize(
    "point",
    [
        lambda: points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"],
        lambda: points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)["fold"],
        lambda: point_of(symmetric(), "forcing.amplitude", (0.4, 1.1), 0.593),
        lambda: point_of(elastic(), "forcing.omega", (2.2, 2.9), 2.457),
        lambda: points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)["grazing"],
    ],
    ids=["doubling", "fold", "symmetry breaking", "resonance", "graze"],
)
def test_a_point_that_is_changed_anywhere_is_refused(point: Any, by_name: bool) -> None:
    claims = certificate(pc.certify(point()))
    theorem_of(claims)
    strips = claims["curves"][0]["strips"]

    for path in chosen(leaves(claims), by_name):
        if path[-1] == "slow" and strips[path[3]]["along"] == 1 and path[3] == 1:
            # The strip with a fold is along a velocity already: other equations prove it as well.
            assert "p is extremal" in theorem(changed(claims, path))
            continue
        assert_refused(changed(claims, path))


def test_a_point_of_another_kind_than_it_is_is_refused(doubling: CertifiedPoint) -> None:
    claims = certificate(doubling)
    for kind in ("fold", "symmetry_breaking", "third_root", "fourth_root", "grazing"):
        other = copy.deepcopy(claims)
        other["curves"][0]["points"][0]["kind"] = kind
        assert_refused(other)


def test_the_ends_of_a_doubling_alone_do_not_tell_that_orbits_branch_off() -> None:
    """Where 1 may be a multiplier on the way, only the multiplier -1 is told."""
    signs = {kind: {0} for kind in POINTS}

    class Given:
        def __init__(self, doubling: int, fold: int) -> None:
            self.signs = signs | {"period_doubling": {doubling}, "fold": {fold}}

    def said(*strips: Given) -> str:
        return str(point_said({}, "period_doubling", cast("Any", strips), mirrored=False))

    assert "twice the period" in said(Given(1, 1), Given(0, 1), Given(-1, 1))
    assert said(Given(1, 1), Given(0, 0), Given(-1, 1)) == "a multiplier is -1"
    assert said(Given(1, 1), Given(0, 1), Given(-1, -1)) == "a multiplier is -1"
    assert said(Given(1, 1), Given(-1, 1), Given(1, 1)) == ""


def test_roots_of_one_of_a_law_that_does_not_keep_areas_are_refused() -> None:
    claims = certificate(pc.certify(point_of(elastic(), "forcing.omega", (2.2, 2.9), 2.457)))
    for place, name, value in (("regions", "damping", "1/10000000000000000000000"),
                               ("bounds", "restitution", ["1", "-1/10000000000000000000000"])):  # fmt: skip
        other = copy.deepcopy(claims)
        other["law"][place][0][name] = value
        assert_refused(other)


def formal() -> CertifiedPoint:
    point = points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"]
    with pytest.warns(pc.FormalOrbitWarning):
        orbit = pc.find_orbit(
            wall_0().oscillator, pc.cosine(point.value), guess=(point.orbit.t0, point.orbit.v0)
        )
    return pc.certify(dataclasses.replace(point, orbit=orbit))


def soft_graze() -> CertifiedPoint:
    osc = pc.Oscillator(1, "0.05", (pc.SoftStop("0.6", "above", 9),))
    orbits = pc.find_orbits(osc, pc.cosine("1.5"), max_impacts=1, max_periods=1)
    orbit = next(orbit for orbit in orbits if orbit.n_impacts == 1)
    return pc.certify(points(orbit, "oscillator.stops.0.at", 0.3, 2.5)["grazing"])


def corner() -> CertifiedPoint:
    return pc.certify(corner_of_two_stops())


def unproven() -> CertifiedPoint:
    point = points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"]
    return pc.certify(dataclasses.replace(point, kind="chatter"))


@pytest.mark.parametrize(
    ("point", "reason"),
    [
        (formal, "its orbits pass through a stop"),
        (soft_graze, "a touch of a soft stop is no impact"),
        (corner, "a corner is the place of a stop, exactly"),
        (unproven, "the point is not proven: infinitely many impacts"),
    ],
)
def test_points_without_a_certificate_say_why(point: Any, reason: str) -> None:
    proven = point()
    with pytest.raises(ParameterError, match=reason):
        certificate(proven)


def claims_read(claims: Claims) -> Any:
    form = {"certificate": "n", "kind": "w", "law": LAW} | FORMS["branch"]
    return read(json.loads(json.dumps(claims)), form)


@pytest.mark.parametrize(
    ("point", "slow"),
    [
        (lambda: point_of(symmetric(), "forcing.amplitude", (0.4, 1.1), 0.593), None),
        (lambda: points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"], None),
        (lambda: points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"], 0),
        (lambda: points(backlash(), "forcing.amplitude", 0.3, 2.5)["fold"], None),
        (lambda: points(impacting(1), "oscillator.stops.0.at", 0.5, 2.5)["grazing"], 0),
        (
            lambda: point_of(
                pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.655")),
                "oscillator.stops.0.restitution",
                (0.5, 0.95),
                0.8,
            ),
            None,
        ),
    ],
    ids=["mirrored", "frequency", "with a slow event", "soft stops", "graze", "restitution"],
)
def test_what_orbits_miss_by_differs_by_the_derivative_between(
    point: Any, slow: int | None
) -> None:
    """The mean value theorem, in boxes far wider than the strips that are proven."""
    claims = claims_read(certificate(pc.certify(point())))
    (curve,) = claims["curves"]
    random, middle = np.random.default_rng(3), curve["strips"][0]["middle"]

    def shot(at: list[Any]) -> Any:
        law = law_over(claims["law"], at[-1])
        cycle = Cycle(law, curve["events"], curve["periods"])
        states = list(zip(at[:-1:2], at[1::2], strict=True))
        return shot_of(cycle, states, slow)

    for _ in range(12):
        corners = [
            [value * (1 + Fraction(random.uniform(-1, 1)) / 10**5) for value in middle]
            for _ in range(2)
        ]
        one, other = (shot([of(value) for value in corner]).missed for corner in corners)
        box = [of(min(pair), max(pair)) for pair in zip(*corners, strict=True)]
        apart = [b - a for a, b in zip(*corners, strict=True)]
        for row, a, b in zip(shot(box).rows, one, other, strict=True):
            mean = sum((entry * way for entry, way in zip(row, apart, strict=True)), of(0))
            difference = b - a
            assert mean.low <= difference.low
            assert difference.high <= mean.high
            assert mean.width < unit() >> 12


def test_the_derivative_with_a_slow_event_is_that_times_its_velocity() -> None:
    claims = claims_read(
        certificate(pc.certify(points(wall_0(), "forcing.omega", 2.3, 2.8)["period_doubling"]))
    )
    (curve,) = claims["curves"]
    at = [of(value) for value in curve["strips"][0]["middle"]]
    cycle = Cycle(law_over(claims["law"], at[-1]), curve["events"], curve["periods"])

    (alone, slow) = (shot_of(cycle, [(at[0], at[1])], k).monodromy for k in (None, 0))

    # The velocity after the event is that of the state but for what the middle of a strip misses.
    for row, scaled in zip(alone, slow, strict=True):
        for entry, product in zip(row, scaled, strict=True):
            assert abs((entry * at[1] - product).middle().low) < unit() >> 30
