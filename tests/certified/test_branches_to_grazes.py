"""Certified branches up to grazes: against closed forms, and against motions on either side."""

from __future__ import annotations

import copy
import math
import re
from dataclasses import replace
from fractions import Fraction

import pytest
from flint import arb
from tests.certified.checker import (
    Claims,
    assert_refused,
    by_name,
    changed,
    chosen,
    leaves,
    theorem_of,
)

import percuss as pc
from percuss.certified import CertifiedBranch, certificate
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.graze_end import GrazeEnd, graze_at_end
from percuss.certified.numbers import precision
from percuss.certified.strips import StripChain
from percuss.certified.system import system_of


def impacting(wall: str, omega: str = "1.5") -> pc.PeriodicOrbit:
    """Return the unstable orbit of one impact that is born where the linear motion touches a wall."""
    osc = pc.impact_oscillator("0.7", damping="0.05", wall=wall, side="above")
    orbits = pc.find_orbits(osc, pc.cosine(omega), 1, 1)
    return next(o for o in orbits if o.n_impacts == 1 and not o.is_stable)


def amplitude(omega: float) -> float:
    """Return the amplitude of the linear motion: at a wall there it touches the wall."""
    return 1.0 / math.hypot(1.0 - omega * omega, 0.1 * omega)


@pytest.fixture(scope="module")
def part() -> StripChain:
    """A chain that does not reach the graze: from a wall at 0.855 to one at 0.865."""
    branch = pc.continue_orbit(impacting("0.86"), over={"oscillator.stops.0.at": (0.855, 0.865)})
    (part,) = pc.certify(branch).chains
    return part


@pytest.fixture(scope="module")
def graze(part: StripChain) -> GrazeEnd:
    with precision(96):
        found = graze_at_end(part, at_begin=True)
    assert found is not None
    return found


def test_the_graze_is_where_the_linear_motion_touches_the_wall(graze: GrazeEnd) -> None:
    # 1 - omega^2 = -5/4 and 2 a omega = 3/20.
    with precision(96):
        assert graze.value.overlaps(1 / (arb(25) / 16 + arb(9) / 400).sqrt())
    assert float(graze.value.rad()) < 1e-10
    assert graze.number == 0
    low, high = graze.parameters
    assert low <= Fraction(amplitude(1.5)) <= high
    # As far as the chain, and no farther than the graze.
    assert high >= Fraction(0.855)
    assert abs(low - Fraction(amplitude(1.5))) < Fraction(1, 10**12)


def test_orbits_of_the_float_engine_lie_in_the_tubes(graze: GrazeEnd) -> None:
    for wall in ("0.7945", "0.797", "0.81", "0.85"):
        orbit = impacting(wall)
        t, v = float(orbit.impacts.t[0]) % orbit.period, float(orbit.impacts.v_after[0])
        with precision(96):
            assert any(graze.holds([t + k * orbit.period, v, float(wall)]) for k in range(2))
            assert not graze.holds([t, v, float(wall) + 0.01])


def test_a_chain_that_leads_away_from_a_graze_has_none(part: StripChain) -> None:
    with precision(96):
        assert graze_at_end(part) is None


def test_orbits_that_would_pass_through_another_wall_are_none(part: StripChain) -> None:
    """Deliberately wrong: between the same walls, of which the orbits meet the second as well."""
    walls = pc.Wall("-0.7", "below", "0.7"), pc.Wall("0.86", "above", "0.7")
    osc = pc.Oscillator(1, "0.05", walls)
    events = [replace(event, bound=1, stop=1) for event in part.curve.events]
    curve = replace(
        part.curve,
        system=system_of(osc, pc.cosine("1.5")),
        events=events,
        path="oscillator.stops.1.at",
    )
    far = pc.Oscillator(1, "0.05", (pc.Wall("-7", "below", "0.7"), walls[1]))
    with precision(96):
        with pytest.raises(Undecided):
            graze_at_end(replace(part, curve=curve), at_begin=True)
        # And where they do not meet it they are motions.
        free = replace(curve, system=system_of(far, pc.cosine("1.5")))
        found = graze_at_end(replace(part, curve=free), at_begin=True)
    assert found is not None
    assert abs(float(found.value) - amplitude(1.5)) < 1e-10


def test_without_a_restitution_or_with_a_table_there_is_no_such_proof(part: StripChain) -> None:
    table = pc.Wall("0.86", "above", pc.restitution_table(["0.1", 1], ["0.8", "0.6"]))
    osc = pc.Oscillator(1, "0.05", (table,))
    curve = replace(part.curve, system=system_of(osc, pc.cosine("1.5")))
    with precision(96), pytest.raises(Undecided, match="a table of restitutions"):
        graze_at_end(replace(part, curve=curve), at_begin=True)


@pytest.fixture(scope="module")
def proven() -> CertifiedBranch:
    branch = pc.continue_orbit(impacting("0.81"), over={"oscillator.stops.0.at": (0.79, 0.82)})
    return pc.certify(branch)


@pytest.mark.nightly
def test_a_branch_goes_on_to_its_graze(proven: CertifiedBranch) -> None:
    (point,) = proven.special_points
    assert point.kind == "grazing"
    assert abs(point.value.mid() - amplitude(1.5)) < 1e-10
    assert "touches the stop" in point.statement
    to_graze, after = proven.stretches[-2:]
    assert after.joined
    assert (to_graze.admissible, to_graze.stability) == (True, "unstable")
    assert to_graze.low <= point.value.mid() <= to_graze.high
    assert to_graze.high >= after.low > to_graze.low
    assert proven.events_at("0.797")
    assert len(proven.outlines()) > len(proven)
    # Strips of the chain that lie on the way to the graze as well are left out.
    assert len(proven) < 10
    (words, graze, *_) = theorem_of(certificate(proven)).splitlines()[1:]
    assert "The orbits are unstable, on the part of the curve with p between 0.794" in words
    assert "has no velocity: the motion touches the wall there" in graze


@pytest.fixture(scope="module")
def claims(part: StripChain, graze: GrazeEnd) -> Claims:
    """What is claimed of a strip of a chain and the tubes to the graze at its begin."""
    branch = certified(part, (graze, None))
    return certificate(branch)


def certified(part: StripChain, grazes: tuple[GrazeEnd | None, GrazeEnd | None]) -> CertifiedBranch:
    short = replace(part, strips=part.strips[:1] if grazes[0] is not None else part.strips[-1:])
    return CertifiedBranch(
        oscillator=part.curve.system.oscillator,
        forcing=part.curve.system.forcing,
        path=part.curve.path,
        stretches=(),
        special_points=(),
        complete=False,
        reason="",
        precision=96,
        chains=(short,),
        grazes=(grazes,),
    )


def graze_in_words(claims: Claims) -> tuple[Fraction, Fraction]:
    """Return the numbers between which the parameter of a graze is proven to be."""
    lines = theorem_of(claims).splitlines()
    (line,) = (line for line in lines if "has no velocity" in line)
    low, high = re.findall(r"[0-9]\.[0-9]+", line)
    return Fraction(low), Fraction(high)


def test_a_graze_is_proven_again(claims: Claims) -> None:
    low, high = graze_in_words(claims)

    # 1 - omega^2 = -5/4 and 2 a omega = 3/20; the words round down.
    unit = Fraction(1, 10**15)
    assert low**2 <= 1 / (Fraction(25, 16) + Fraction(9, 400)) <= (high + unit) ** 2
    assert high - low < Fraction(1, 10**12)
    assert "The orbits are unstable" in theorem_of(claims)


def test_a_graze_at_the_end_of_a_curve_is_proven_again(
    part: StripChain, graze: GrazeEnd, claims: Claims
) -> None:
    turned = replace(part, strips=[
        replace(strip, end=strip.tube.low if strip.end == strip.tube.high else strip.tube.high)
        for strip in reversed(part.strips)
    ])  # fmt: skip

    other = certificate(certified(turned, (None, graze)))

    assert other["curves"][0]["strips"][-1]["end"] == "0"
    assert graze_in_words(other) == graze_in_words(claims)


@by_name
def test_a_graze_that_is_changed_anywhere_is_refused(claims: Claims, by_name: bool) -> None:
    strips = claims["curves"][0]["strips"]
    n_slow = sum(strip["slow"] is not None for strip in strips)
    of_some = (it for it in leaves(claims) if "strips" not in it or it[3] in (0, n_slow))
    for path in chosen(of_some, by_name):
        assert_refused(changed(claims, path))


def test_a_graze_of_other_equations_or_beyond_another_stop_is_refused(
    claims: Claims,
) -> None:
    strips = claims["curves"][0]["strips"]
    slow = [strip for strip in strips if strip["slow"] is not None]
    (first, *_) = slow
    assert first["begin"] == "0"
    half = str(Fraction(first["end"]) / 2)
    # The same strip on both sides of zero: an impact at which the motion goes into the wall.
    past = first | {"begin": str(-Fraction(first["end"]))}
    for change in (
        [first | {"slow": None}],
        [first | {"slow": 1, "along": 3}],
        [first | {"stability": "asymptotic"}],
        [past | {"middle": [first["middle"][0], "0", *first["middle"][2:]]}],
        [strips[-1] | {"slow": 0}],
        [first | {"begin": half}, slow[-1]],
    ):
        assert_refused(claims | {"curves": [claims["curves"][0] | {"strips": change}]})
    # A second event that the equation does not have: at another stop, or into another region.
    (curve,) = claims["curves"]
    for event in ({"bound": 7, "region": 0}, {"bound": 0, "region": 7}):
        longer = {"events": [*curve["events"], event], "strips": [
            first | {
                "middle": [*first["middle"][:2], "4", "1", first["middle"][-1]],
                "tangent": [*first["tangent"][:2], "0", "0", first["tangent"][-1]],
                "sizes": [*first["sizes"][:2], "1/1000", "1/1000", first["sizes"][-1]],
            }
        ]}  # fmt: skip
        assert_refused(claims | {"curves": [curve | longer]})
    # A second wall, which the orbits meet on the way; and one that they do not come to.
    for at, is_met in (("-7/10", True), ("-7", False)):
        other = copy.deepcopy(claims)
        law = other["law"]
        law["bounds"] = [{"at": at, "restitution": "7/10"}, *law["bounds"]]
        law["regions"][0] |= {"lower": 0, "upper": 1}
        other["curves"][0]["events"][0]["bound"] = 1
        if is_met:
            assert_refused(other)
        else:
            assert graze_in_words(other) == graze_in_words(claims)
    # A wall that keeps nothing, or a spring in its place: the velocity before says nothing any
    # more.
    other = copy.deepcopy(claims)
    other["law"]["bounds"][0]["restitution"] = "0"
    assert_refused(other)


@pytest.mark.nightly
def test_a_graze_over_the_frequency() -> None:
    branch = pc.continue_orbit(impacting("0.81", "1.53"), over={"forcing.omega": (1.49, 1.535)})

    (point,) = pc.certify(branch).special_points

    assert abs(amplitude(float(point.value)) - 0.81) < 1e-8
