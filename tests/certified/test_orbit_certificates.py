"""Orbits that percuss proves, another program proves again; what is changed in them, it refuses."""

from __future__ import annotations

import copy
from fractions import Fraction

import pytest
from tests.certified.checker import (
    SOFT,
    WALL,
    Claims,
    assert_refused,
    changed,
    later,
    leaves,
    theorem_of,
    wave,
)

import percuss as pc
from percuss.certified import certificate

GAP = pc.Oscillator(
    1, "1/50", (pc.Wall("3/10", "above", "7/10"), pc.Wall("-3/10", "below", "7/10"))
)
PLASTIC = pc.impact_oscillator(0, damping="1/20", wall="1/2", side="above")


@pytest.mark.parametrize(
    ("osc", "force", "kind", "said"),
    [
        (WALL, pc.cosine("14/5"), (1, 1), "It is unstable"),
        (SOFT, pc.cosine("11/10"), (1, 1), "Neighbouring motions approach it"),
        (
            WALL,
            pc.fourier("7/5", cos=[0, 1]),
            (2, 1),
            "2 events in 2 periods of the force, 10/7 pi",
        ),
        (GAP, pc.cosine("3/2"), (2, 1), "2 events in 1 periods of the force, 4/3 pi long, lie"),
        (PLASTIC, pc.cosine("3/2"), (1, 1), "Neighbouring motions approach it"),
    ],
    ids=["wall", "soft stop", "two periods in one", "two walls", "without rebound"],
)
def test_orbits_are_proven_again(
    osc: pc.Oscillator, force: pc.Forcing, kind: tuple[int, int], said: str
) -> None:
    words = theorem_of(certificate(pc.certify(pc.find_orbit(osc, force, *kind))))

    assert "one periodic orbit, and one only" in words
    assert said in words


def test_an_orbit_that_is_changed_anywhere_is_refused(orbit: Claims) -> None:
    plastic = certificate(pc.certify(pc.find_orbit(PLASTIC, pc.cosine("3/2"))))

    for claims in (orbit, plastic):
        theorem_of(claims)
        for path in leaves(claims):
            assert_refused(changed(claims, path))


def test_a_mass_that_the_force_holds_on_a_wall_without_rebound_leaves_it_in_no_orbit() -> None:
    claims = certificate(pc.certify(pc.find_orbit(PLASTIC, pc.cosine("3/2"))))
    (event,) = claims["events"]

    # Half a period later the force points to the other side.
    t = [str(Fraction(end) + Fraction("2.0943951")) for end in event["t"]]
    assert_refused(claims | {"events": [event | {"t": t}]})
    # Of a wall that keeps anything a velocity about zero is none.
    law = claims["law"]
    other = law | {"bounds": [law["bounds"][0] | {"restitution": "1/1000000000000000"}]}
    assert_refused(claims | {"law": other}, "does not lead into its region")


def test_a_number_that_depends_on_a_parameter_is_none_of_an_orbit(orbit: Claims) -> None:
    other = copy.deepcopy(orbit)
    other["law"]["regions"][0]["stiffness"] = ["1", "0"]

    assert_refused(other, "this is no branch")


@pytest.mark.parametrize(
    "tones",
    [
        [wave("7/5", "0")],
        [wave("7/5", "1/3"), wave("7/5", "1/3", "1")],
        [wave("7/5", "1/3"), wave("7/5", "1/3", "2/3"), wave("7/5", "1/3", "-2/3")],
    ],
    ids=["no amplitude", "two that cancel", "three that cancel"],
)
def test_a_tone_that_is_none_does_not_make_the_period_longer(
    orbit: Claims, tones: list[Claims]
) -> None:
    other = copy.deepcopy(orbit)
    other["law"]["tones"] += tones
    other["law"]["base"] = "7/5"
    # Two periods of the force, which would be called one.
    other["events"] += later(orbit, 1)["events"]

    assert_refused(other, "no amplitude")


def test_tones_of_one_frequency_that_do_not_cancel_are_one_force(orbit: Claims) -> None:
    tiny = f"1/{10**60}"
    for tones in (
        [wave("14/5", "1/2"), wave("14/5", "1/2")],
        [wave("14/5", "1"), wave("14/5", tiny), wave("14/5", f"-{tiny}")],
        [wave("14/5", "1", "1/3"), wave("14/5", "1", "-1/3")],
    ):
        other = copy.deepcopy(orbit)
        other["law"]["tones"] = tones
        assert "5/7 pi long" in theorem_of(other)


def test_a_tone_without_amplitude_is_left_out_of_a_certificate(orbit: Claims) -> None:
    force = pc.Forcing((pc.Harmonic(1, "14/5"), pc.Harmonic(0, "7/5")), period=pc.pi_times("10/7"))
    claims = certificate(pc.certify(pc.find_orbit(WALL, force, 2, 1)))

    assert claims["law"] == orbit["law"]
    assert claims["periods"] == 2
    assert "in 2 periods of the force, 10/7 pi long" in theorem_of(claims)


def test_places_counted_from_the_end_and_missing_periods_are_refused(
    orbit: Claims,
) -> None:
    events = [event | {"region": -1} for event in orbit["events"]]

    for change in ({"events": events}, {"periods": None}, {"periods": 0}, {"periods": 1.0}):
        assert_refused(orbit | change)
