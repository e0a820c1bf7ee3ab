"""Symmetric orbits: where the symmetry breaks is enclosed, and nothing else is taken for it."""

from __future__ import annotations

import dataclasses
import re
from typing import Any

import numpy as np
import pytest
from flint import arb, ctx
from tests.certified.checker import (
    Claims,
    assert_refused,
    at_point,
    by_name,
    changed,
    chosen,
    leaves,
    theorem_of,
)
from tests.certified.motions import corner_of_two_stops

import percuss as pc
from percuss.certified import CertifiedBranch, certificate
from percuss.certified.properties import monodromy_of
from percuss.certified.shooting import Shooting, shooting_of
from percuss.certified.special import symmetry_function
from percuss.certified.system import system_of

WALLS = (pc.Wall("0.3", "above", "0.7"), pc.Wall("-0.3", "below", "0.7"))
OSC = pc.Oscillator(1, "0.02", WALLS)


@pytest.fixture(scope="module")
def branch() -> pc.Branch:
    orbit = pc.find_orbit(OSC, pc.cosine("1.5"), 2, 1)
    return pc.continue_orbit(orbit, over={"forcing.amplitude": (0.4, 1.1)})


@pytest.fixture(scope="module")
def breaking(branch: pc.Branch) -> pc.SpecialPoint:
    (point,) = branch.special_points
    return point


@pytest.mark.parametrize("digits", [8, 12, 25])
def test_a_symmetry_breaking_is_enclosed(breaking: pc.SpecialPoint, digits: int) -> None:
    proven = pc.certify(breaking, digits=digits)

    assert breaking.kind == "symmetry_breaking"
    assert proven.exists, proven
    assert abs(proven.value.mid() - breaking.value) < 1e-11
    assert proven.value.digits() >= digits
    assert "without the symmetry branch off" in proven.statement


@pytest.fixture(scope="module")
def whole(branch: pc.Branch) -> CertifiedBranch:
    return pc.certify(branch)


def test_a_branch_of_symmetric_orbits_is_one_curve_through_it(
    whole: CertifiedBranch, breaking: pc.SpecialPoint
) -> None:
    assert whole.complete, whole.reason
    assert [s.stability for s in whole.stretches] == ["asymptotic", "undecided", "unstable"]
    (point,) = whole.special_points
    assert point.kind == "symmetry_breaking"
    assert point.value.arb.contains(pc.certify(breaking, digits=30).value.arb)
    assert float(point.value.radius()) < 1e-4


@pytest.fixture(scope="module", params=["alone", pytest.param("branch", marks=pytest.mark.nightly)])
def claims(breaking: pc.SpecialPoint, request: pytest.FixtureRequest) -> Claims:
    """The strips next to the breaking, from one that is stable to one that is not."""
    if request.param == "alone":
        return certificate(pc.certify(breaking))
    orbit = pc.find_orbit(OSC, pc.cosine("1.5", amplitude="0.593"), 2, 1)
    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.5925, 0.594)})
    return at_point(certificate(pc.certify(branch)))


def test_a_breaking_on_a_branch_is_proven_again(claims: Claims, breaking: pc.SpecialPoint) -> None:
    words = theorem_of(claims)

    assert "its second half the mirror image of the first" in words
    (said,) = (line for line in words.splitlines() if "without the symmetry branch off" in line)
    low, high = (float(word) for word in re.findall(r"0\.59[0-9]+", said))
    assert low <= pc.certify(breaking).value.mid() <= high + 1e-9
    assert high - low < 1e-5


@by_name
def test_a_breaking_that_is_changed_anywhere_is_refused(claims: Claims, by_name: bool) -> None:
    (curve,) = claims["curves"]
    n = len(curve["strips"])

    # From the next strip to the last one there is the breaking as well.
    of_ends = (it for it in leaves(claims) if "strips" not in it or it[3] in (0, n - 1))
    for path in chosen((it for it in of_ends if it[-1] != "before"), by_name):
        assert_refused(changed(claims, path))
    for change in (
        {"periods": "1"},
        {"periods": "3/2"},
        {"points": [curve["points"][0] | {"kind": "period_doubling"}]},
        {"points": [curve["points"][0] | {"kind": "fold"}]},
        {"points": [curve["points"][0] | {"before": n - 2}]},
        {"points": [curve["points"][0] | {"before": n - 1}]},
    ):
        assert_refused(claims | {"curves": [curve | change]})


def test_halves_of_orbits_of_a_law_without_the_symmetry_are_refused(claims: Claims) -> None:
    law = claims["law"]
    (tone,), (region,) = law["tones"], law["regions"]
    for change in (
        {"regions": [region | {"constant": "1/1000"}]},
        {"bounds": [law["bounds"][0] | {"at": "-31/100"}, law["bounds"][1]]},
        {"bounds": [law["bounds"][0], law["bounds"][1] | {"restitution": "71/100"}]},
        {"tones": [tone, {"omega": "3", "amplitude": "1/1000", "phase": ["0", "0"]}]},
    ):
        assert_refused(claims | {"law": law | change}, "a law without the symmetry")


@pytest.mark.parametrize("row", [3, -3])
def test_orbits_proven_alone_lie_in_the_strips_of_the_symmetric_ones(
    branch: pc.Branch, whole: CertifiedBranch, row: int
) -> None:
    # At the last one orbits without the symmetry are stable.
    alone = pc.certify(branch[row], digits=30)
    assert (alone.stability == "unstable") == (row < 0)
    ((t, v),) = whole.events_at(float(branch.values[row]))

    assert len(t) == len(alone.events) == 2
    period = alone.period.arb
    for own_t, own_v in (state for _, state in alone.events):
        assert any(
            box_v.contains(own_v)
            and any(box_t.contains(own_t + turn * period) for turn in (-1, 0, 1))
            for box_t, box_v in zip(t.arbs, v.arbs, strict=True)
        )


def test_orbits_without_the_symmetry_are_no_curve_through_it() -> None:
    """They begin at the breaking, where their own equations are singular: the proof has a gap."""
    orbit = pc.find_orbit(OSC, pc.cosine("1.5", amplitude="0.62"), 2, 1)
    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.58, 0.63)})
    assert [point.kind for point in branch.special_points] == ["symmetry_breaking"]

    proven = pc.certify(branch)

    assert not proven.complete
    assert proven.special_points == ()


def test_its_enclosures_at_two_precisions_agree(breaking: pc.SpecialPoint) -> None:
    few, many = pc.certify(breaking, digits=8), pc.certify(breaking, digits=30)

    assert few.value.arb.contains(many.value.arb)


def test_on_both_sides_of_it_the_stability_is_proven_to_be_another(branch: pc.Branch) -> None:
    (row,) = [point.row for point in branch.special_points]

    found = [pc.certify(branch[k]) for k in (row - 1, row + 1)]

    assert [each.stability for each in found] == ["asymptotic", "unstable"]


def test_the_map_over_half_an_orbit_squares_to_that_over_all() -> None:
    orbit = pc.find_orbit(OSC, pc.cosine("1.5", amplitude="0.5"), 2, 1)
    system = system_of(orbit.oscillator, orbit.forcing)
    with ctx.workprec(120):
        equations, guess = shooting_of(system, orbit)
        states = equations.newton(guess)
        half = Shooting.of(system, equations.events, 1, mirrored=True)
        ours = half.newton(states[:1])
        whole, _ = monodromy_of(equations, states)
        test = symmetry_function(half, ours)

    # det(1 + H) of the half map H; the whole one is its square.
    first, second = np.sqrt([complex(whole.multipliers[k]) for k in (0, 1)])
    roots = [(1 + a * first) * (1 + b * second) for a in (1, -1) for b in (1, -1)]
    assert min(abs(root - float(test)) for root in roots) < 1e-12
    assert abs(ours[0][0] - states[0][0]) < arb(10) ** -30


def test_soft_stops_break_their_symmetry_too() -> None:
    osc = pc.backlash_oscillator(gap=1, stiffness="26.7", damping="0.05")
    orbits = pc.find_orbits(osc, pc.cosine("0.8", amplitude="1.2"), max_impacts=2, max_periods=1)
    orbit = next(orbit for orbit in orbits if orbit.symmetric and orbit.isolated)
    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (0.5, 1.3)})
    point = next(each for each in branch.special_points if each.kind == "symmetry_breaking")
    assert len(point.orbit.itinerary) == 4

    proven = pc.certify(point)

    assert proven.exists, proven
    assert abs(proven.value.mid() - point.value) < 1e-9


def test_a_fold_of_symmetric_orbits_is_not_taken_for_one() -> None:
    walls = pc.Wall(1, "above", "0.7"), pc.Wall(-1, "below", "0.7")
    orbit = pc.find_orbit(pc.Oscillator(1, "0.02", walls), pc.cosine("1.5", amplitude=3), 2, 1)
    branch = pc.continue_orbit(orbit, over={"forcing.amplitude": (3.0, 0.1)})
    fold = next(point for point in branch.special_points if point.kind == "fold")
    other = dataclasses.replace(fold, kind="symmetry_breaking")

    assert pc.certify(fold).exists
    assert not pc.certify(other, most_bits=300).exists


def test_a_parameter_that_spoils_the_symmetry_is_refused(breaking: pc.SpecialPoint) -> None:
    path = "oscillator.stops.0.at"
    other = dataclasses.replace(breaking, path=path, value=0.3)

    proven = pc.certify(other)

    assert not proven.exists
    assert "takes the symmetry away" in proven.reason


def test_an_orbit_without_mirrored_halves_is_refused() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.3, 2.8)})
    other = dataclasses.replace(branch.special_points[0], kind="symmetry_breaking")

    proven = pc.certify(other)

    assert "mirrored halves" in proven.reason


def test_a_corner_is_the_place_of_the_other_stop_exactly() -> None:
    proven = pc.certify(corner_of_two_stops())

    assert proven.exists, proven
    assert proven.value.contains("1.1")
    assert proven.value.digits() > 20


def test_each_kind_has_a_proof_or_a_sentence(breaking: pc.SpecialPoint) -> None:
    for kind in ("branch_point", "chatter"):
        proven = pc.certify(dataclasses.replace(breaking, kind=kind))
        assert not proven.exists
        assert len(proven.reason) > 40


def test_a_point_of_a_sticking_orbit_is_left_unproven(breaking: pc.SpecialPoint) -> None:
    orbit = next(
        each
        for each in pc.find_orbits(
            pc.impact_oscillator("0.8"), pc.cosine("2.7"), max_impacts=2, max_periods=12
        )
        if each.n_impacts == float("inf")
    )

    proven = pc.certify(dataclasses.replace(breaking, kind="grazing", orbit=orbit))

    assert not proven.exists
    assert "sticks" in proven.reason


def test_the_breaking_is_that_of_an_independent_calculation(breaking: pc.SpecialPoint) -> None:
    """The half map and its derivative in 40 digits, from the closed form of a flight."""
    mp = pytest.importorskip("mpmath").mp.clone()
    mp.dps = 40
    a, omega, r, wall = (mp.mpf(value) for value in ("0.02", "1.5", "0.7", "0.3"))
    free = mp.sqrt(1 - a * a)

    def motion(t: Any, v: Any, force: Any, s: Any) -> tuple[Any, Any]:
        gain = force / (1 - omega**2 + 2j * a * omega)

        def steady(at: Any, order: int) -> Any:
            return mp.re(gain * (1j * omega) ** order * mp.expj(omega * at))

        y, z = wall - steady(t, 0), v - steady(t, 1)
        c, d = mp.cos(free * s), mp.sin(free * s) / free
        decay = mp.exp(-a * s)
        place = decay * ((c + a * d) * y + d * z) + steady(t + s, 0)
        speed = decay * ((c - a * d) * z - d * y) + steady(t + s, 1)
        return place, speed

    def image(t: Any, v: Any, force: Any) -> tuple[Any, Any]:
        s = mp.findroot(lambda s: motion(t, v, force, s)[0] + wall, mp.pi / omega)
        # The impact reverses the velocity, and so does the mirror.
        return t + s - mp.pi / omega, r * motion(t, v, force, s)[1]

    events = breaking.orbit.impacts
    first = int(np.flatnonzero(events.stop == 0)[0])

    def conditions(t: Any, v: Any, force: Any) -> list[Any]:
        step = mp.mpf(10) ** -16
        here = image(t, v, force)
        by_t = [(p - q) / (2 * step) for p, q in zip(
            image(t + step, v, force), image(t - step, v, force), strict=True
        )]  # fmt: skip
        by_v = [(p - q) / (2 * step) for p, q in zip(
            image(t, v + step, force), image(t, v - step, force), strict=True
        )]  # fmt: skip
        determinant = by_t[0] * by_v[1] - by_t[1] * by_v[0]
        return [here[0] - t, here[1] - v, 1 + by_t[0] + by_v[1] + determinant]

    start = events.t[first], events.v_after[first], breaking.value
    found = mp.findroot(conditions, [mp.mpf(float(value)) for value in start])

    proven = pc.certify(breaking, digits=20)
    with ctx.workprec(120):
        assert abs(proven.value.arb - arb(mp.nstr(found[2], 35))) < arb(10) ** -20
