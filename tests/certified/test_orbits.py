from __future__ import annotations

import dataclasses
import json
import math
from pathlib import Path

import numpy as np
import pytest
from flint import arb
from tests import reference

import percuss as pc
from percuss.certified import CertifiedOrbit

ROWS = {
    row["id"]: row
    for row in json.loads((Path(reference.__file__).parent / "cases.json").read_text("utf-8"))
}
# Single-impact orbits: id, wall's side, periods.
SINGLE = {
    "orbit-w2.8-r0.8-s0-n1": 1,
    "orbit-w2.5-r0.8-s0-n1": 1,
    "orbit-w4.2-r0.8-s0-n2": 2,
    "orbit-elastic-w2.3": 1,
}


@pytest.mark.parametrize("name", SINGLE)
def test_reference_orbits_lie_inside_their_enclosures(name: str) -> None:
    row = ROWS[name]
    params, harmonic = row["params"], row["params"]["harmonics"][0]
    wall = params["walls"][0]
    osc = pc.impact_oscillator(
        str(params["r"]),
        wall=str(wall["x"]),
        side={"lower": "below", "upper": "above"}[wall["side"]],  # type: ignore[arg-type]
        damping=str(params["a"]),
    )
    force = pc.cosine(str(harmonic["omega"]), str(harmonic["A"]), phase=str(harmonic["phi"]))
    orbit = pc.find_orbit(osc, force, n_periods=SINGLE[name])

    proven = pc.certify(orbit, digits=18)

    speed, _, trace, determinant = (arb(str(v)) + arb(0, 1e-17) for v in row["value"][:4])
    assert abs(proven.impacts.v_before.arbs[0]).overlaps(speed)
    assert proven.impacts.v_before[0].digits() > 18
    assert proven.trace.arb.overlaps(trace)
    assert proven.determinant.arb.overlaps(determinant)
    expected = [complex(float(real), float(imag)) for real, imag in row["value"][4:6]]
    for ours in proven.multipliers:
        assert min(abs(ours.mid() - value) for value in expected) < 1e-14


def test_an_asymptotically_stable_orbit_is_proven_alone_admissible_and_stable() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))

    proven = pc.certify(orbit)

    assert proven.exists
    assert proven.isolated
    assert proven.unique_within >= 1e-8
    assert proven.admissible is True
    assert proven.stability == "asymptotic"
    assert proven.is_stable
    assert proven.determinant.contains("0.64")
    assert proven.sequence == orbit.sequence
    assert abs(proven.t0.mid() - orbit.t0) < 1e-12
    assert abs(proven.v0.mid() - orbit.v0) < 1e-12
    assert abs(proven.min_impact_speed.mid() - orbit.min_impact_speed) < 1e-12
    # A run from a point of it comes back.
    start = pc.Start(0, proven.v0.mid(), proven.t0.mid())
    run = pc.simulate(orbit.oscillator, orbit.forcing, start.x0, start.v0, start.t0, max_impacts=1)
    after = pc.certify(run)
    np.testing.assert_allclose(after.impacts.v_after.mid(), [proven.v0.mid()], atol=1e-14)


def test_an_unstable_orbit_is_proven_unstable() -> None:
    proven = pc.certify(pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.8")))

    assert proven.stability == "unstable"
    assert abs(proven.multipliers[0].mid()) > 2.9
    # The product of the multipliers is r^2.
    product = proven.multipliers[0].acb * proven.multipliers[1].acb
    assert product.real.overlaps(arb("0.64"))


def test_an_elastic_orbit_is_elliptic_as_its_determinant_is_one_exactly() -> None:
    proven = pc.certify(pc.find_orbit(pc.impact_oscillator(), pc.cosine("2.3")))

    assert proven.stability == "elliptic"
    assert proven.determinant.arb == 1
    assert abs(proven.trace.arb) < 2


def test_a_family_is_proven_by_its_closed_form() -> None:
    orbit = pc.find_orbit(
        pc.impact_oscillator(), pc.sine(3), n_impacts=2, n_periods=3, guess=(0.0, 0.6)
    )

    proven = pc.certify(orbit)

    assert proven.exists
    assert not proven.isolated
    assert proven.admissible is True
    assert proven.stability == "parabolic"
    assert proven.period.contains("2*pi")
    assert all(m.mid() == 1 for m in proven.multipliers)


def test_free_motion_is_a_family_too() -> None:
    orbit = pc.find_orbit(pc.bilinear_oscillator(stiffness_below=4), guess=(0.0, -1.0))

    proven = pc.certify(orbit)

    assert proven.exists
    assert not proven.isolated
    assert proven.period.contains("3*pi/2")


def test_a_family_without_a_closed_form_is_left_unproven() -> None:
    orbit = pc.find_orbit(
        pc.impact_oscillator(), pc.sine(3), n_impacts=2, n_periods=3, guess=(0.0, 0.6)
    )
    moved = dataclasses.replace(orbit, oscillator=pc.impact_oscillator(wall="1/1000000"))

    proven = pc.certify(moved)

    assert not proven.exists
    assert "closed form" in proven.reason
    assert math.isnan(proven.period.radius())


def test_steady_motion_is_its_formula() -> None:
    osc = pc.impact_oscillator("0.7", wall=2, side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine("1.5"), n_impacts=0)

    proven = pc.certify(orbit)

    assert proven.exists
    assert proven.admissible is True
    assert proven.stability == "asymptotic"
    # exp(-2 a T) with T = 4 pi/3.
    assert proven.determinant.arb.overlaps((-arb("0.1") * 4 * arb.pi() / 3).exp())
    assert abs(proven.x0.mid() - orbit.x0) < 1e-13


def test_steady_motion_through_a_stop_is_proven_formal() -> None:
    osc = pc.impact_oscillator("0.7", wall="0.5", side="above", damping="0.05")
    with pytest.warns(pc.FormalOrbitWarning):
        orbit = pc.find_orbit(osc, pc.cosine("1.5"), n_impacts=0)

    assert pc.certify(orbit).admissible is False


def test_formal_orbits_with_impacts_are_proven_so() -> None:
    osc = pc.impact_oscillator("0.7", wall="1.5", side="above", damping="0.05")
    orbits = pc.find_orbits(osc, pc.cosine("1.5"), max_impacts=1, max_periods=1)
    orbit = next(orbit for orbit in orbits if orbit.n_impacts == 1)
    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.at": (0.5, 2.5)})
    # Behind the graze the impact velocity is that out of the stop.
    formal = [orbit for orbit, fits in zip(branch, branch.admissible, strict=True) if not fits]
    assert len(formal) > 5

    assert {pc.certify(orbit).admissible for orbit in formal[1::5]} == {False}


def test_soft_stops_and_several_impacts_are_proven() -> None:
    osc = pc.backlash_oscillator(gap=1, stiffness=10, damping="0.05")
    orbits = pc.find_orbits(osc, pc.cosine("1.2", amplitude=2), max_impacts=3, max_periods=2)
    assert max(orbit.n_impacts for orbit in orbits) >= 2

    for orbit in orbits:
        proven = pc.certify(orbit)
        assert proven.exists, (orbit, proven)
        assert proven.stability == orbit.stability
        assert proven.admissible is orbit.admissible
        np.testing.assert_allclose(proven.impacts.t.mid(), orbit.impacts.t, atol=1e-9)
        np.testing.assert_allclose(
            sorted(abs(m.mid()) for m in proven.multipliers),
            sorted(np.abs(orbit.multipliers)),
            atol=1e-9,
        )


def test_an_orbit_with_sticking_comes_back_to_its_contact() -> None:
    orbits = pc.find_orbits(pc.impact_oscillator("0.8"), pc.cosine("2.7"), max_impacts=2,
                            max_periods=12)  # fmt: skip
    sticking = [orbit for orbit in orbits if math.isinf(orbit.n_impacts)]
    assert sticking

    proven: CertifiedOrbit = pc.certify(sticking[0])

    assert proven.exists, proven
    assert math.isinf(proven.n_impacts)
    assert proven.stability == "asymptotic"
    assert all(m.mid() == 0 for m in proven.multipliers)
    # It starts from a release, where cos(2.7 t) = 0.
    assert (proven.t0.arb * arb("2.7")).cos().contains(0)


def test_an_orbit_that_is_none_is_not_proven() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    wrong = dataclasses.replace(orbit, forcing=pc.cosine("5.5"))

    proven = pc.certify(wrong, most_bits=200)

    assert not proven.exists
    assert "not proven" in repr(proven)


def test_steady_motion_without_a_spring_may_be_anywhere() -> None:
    osc = pc.backlash_oscillator(gap=1, stiffness=20, damping="0.1")
    orbit = pc.find_orbit(osc, pc.cosine(2), n_impacts=0)

    proven = pc.certify(orbit)

    assert proven.exists
    assert not proven.isolated
    assert proven.admissible is True
    assert proven.stability == "parabolic"
    assert proven.multipliers[0].mid() == 1
    assert proven.x0.contains(orbit.x0)
    assert abs(proven.v0.mid() - orbit.v0) < 1e-13


@pytest.mark.parametrize("digits", [40, 700])
def test_many_digits_of_an_orbit_are_proven(digits: int) -> None:
    """Steps of Newton's method that are smaller than any float end it as well."""
    proven = pc.certify(pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5")), digits)

    assert proven.exists, proven
    assert proven.v0.digits() >= digits - 1


def test_at_a_period_doubling_no_stability_is_claimed() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    (point,) = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.8)}).special_points
    exact = pc.certify(point, digits=25).value

    # The amplitude scales the motion, so a range of it does not move the multiplier; that of the
    # frequency is cut off after so many digits, and the balls have fewer.
    omega = f"{exact.arb.mid().str(25, radius=False)}"
    there = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine(omega))
    coarse, fine = pc.certify(there, bits=70), pc.certify(there, digits=40)

    assert coarse.exists
    assert coarse.stability == "undecided"
    assert not coarse.is_stable
    assert (
        abs(coarse.multipliers[1].mid() + 1) < 1e-9 or abs(coarse.multipliers[0].mid() + 1) < 1e-9
    )
    # With more bits the side on which the cut-off number lies is decided.
    assert fine.stability in ("asymptotic", "unstable")


@pytest.mark.parametrize("amplitude", ["0.1", "0.2"])
def test_no_stability_is_claimed_of_what_is_not_proven_to_be_a_motion(amplitude: str) -> None:
    # x = sin t grazes the wall at 1; twice that passes through it.
    osc = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine(1, amplitude="0.1"), 0, 1)
    formal = dataclasses.replace(orbit, forcing=pc.cosine(1, amplitude=amplitude))

    proven = pc.certify(formal)

    assert proven.exists
    assert proven.admissible is (None if amplitude == "0.1" else False)
    assert proven.stability == "undecided"
    assert not proven.is_stable
    assert abs(proven.multipliers[0].real.mid()) < 1  # of the formal map
    assert "asymptotic" not in repr(proven)
    assert "alone with these events" in repr(proven)


@pytest.mark.parametrize(
    ("omega", "admissible", "stability"),
    [("2.5", True, "asymptotic"), ("3.3", True, "unstable"), ("2", False, "undecided")],
)
def test_after_an_impact_without_rebound_the_force_decides(
    omega: str, admissible: bool, stability: str
) -> None:
    """At omega = 2 it points to the wall: the mass sticks, and the orbit of one impact is formal."""
    osc = pc.impact_oscillator(0, damping="0.05")

    proven = pc.certify(pc.find_orbit(osc, pc.cosine(omega), formal=not admissible))

    assert (proven.admissible, proven.stability) == (admissible, stability)
    assert proven.impacts.v_after[0].contains(0)
    if admissible:
        run = pc.simulate(osc, pc.cosine(omega), v0=0, t0=proven.t0.mid(), max_impacts=1)
        assert abs(run.impacts.t[0] - proven.t0.mid() - proven.period.mid()) < 1e-9
