"""Proofs and their certificates are the same in all units of length and time."""

from __future__ import annotations

from fractions import Fraction
from typing import NamedTuple

import pytest
from tests.certified.checker import theorem_of

import percuss as pc
from percuss.certified import certificate, list_orbits, prove_basins


class Scale(NamedTuple):
    """How many units of length and of time are 1."""

    length: Fraction
    time: Fraction

    def wall(self, restitution: str, at: str = "0", damping: str = "0") -> pc.Oscillator:
        return pc.impact_oscillator(
            restitution,
            wall=str(Fraction(at) * self.length),
            side="above" if at != "0" else "below",
            stiffness=str(1 / self.time**2),
            damping=str(Fraction(damping) / self.time),
        )

    def cosine(self, omega: str) -> pc.Forcing:
        return pc.cosine(str(Fraction(omega) / self.time), str(self.length / self.time**2))

    def speed(self, value: str) -> str:
        return str(Fraction(value) * self.length / self.time)

    def place(self, value: str) -> str:
        return str(Fraction(value) * self.length)


MILLION = Fraction(10**6)
ONE_UNIT = {
    "small": Scale(1 / MILLION, Fraction(1)),
    "large": Scale(MILLION, Fraction(1)),
    "slow": Scale(Fraction(1), MILLION),
}
BOTH_UNITS = {
    "small and fast": Scale(1 / MILLION, 1 / MILLION),
    "large and slow": Scale(MILLION, MILLION),
}
SCALES = ONE_UNIT | BOTH_UNITS
scales = pytest.mark.parametrize("scale", list(SCALES.values()), ids=list(SCALES))


@scales
def test_runs_and_orbits(scale: Scale) -> None:
    osc, force = scale.wall("4/5"), scale.cosine("14/5")
    run = pc.simulate(osc, force, v0=scale.speed("1"), max_impacts=5)
    orbit = pc.certify(pc.find_orbit(osc, force), digits=20)

    assert "at 5 instants" in theorem_of(certificate(pc.certify(run)))
    assert "It is unstable" in theorem_of(certificate(orbit))


def test_a_ball_that_falls_for_a_long_time() -> None:
    ball = pc.impact_oscillator("4/5", stiffness=0)
    run = pc.simulate(ball, pc.Forcing(constant=-1), x0=10**9, max_impacts=3)

    assert "at 3 instants" in theorem_of(certificate(pc.certify(run)))


def test_a_mass_that_nothing_turns_between_small_stops() -> None:
    stops = pc.Wall(0, "below", "1/2"), pc.SoftStop("1/10000000", "above", 100)
    run = pc.simulate(pc.Oscillator(0, 0, stops), v0="1/1000000", max_impacts=3)

    assert "meets the stops at" in theorem_of(certificate(pc.certify(run)))


@pytest.mark.parametrize("digits", [40, 300])
def test_orbits_of_many_digits(digits: int) -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("4/5"), pc.cosine("5/2"))

    assert "Neighbouring motions" in theorem_of(certificate(pc.certify(orbit, digits)))


@scales
def test_branches_have_as_many_strips_and_their_points_all_digits(scale: Scale) -> None:
    ends = float(Fraction("2.652") / scale.time), float(Fraction("2.654") / scale.time)
    orbit = pc.find_orbit(scale.wall("4/5"), scale.cosine("2.652"))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": ends})

    proven, point = pc.certify(branch), pc.certify(branch.special_points[0], digits=12)

    assert proven.complete
    assert sum(len(chain.strips) for chain in proven.chains) < 300
    assert point.value.digits() > 12
    assert "a multiplier is -1" in theorem_of(certificate(point))


@pytest.mark.parametrize("length", [Fraction(1), 1 / MILLION, MILLION])
def test_special_points_over_a_place_have_all_digits(length: Fraction) -> None:
    osc = pc.impact_oscillator("4/5", wall=str(length / 5), side="above", damping="1/20")
    orbit = pc.find_orbit(osc, pc.cosine(2, str(length)))
    ends = float(length / 5), float(length * Fraction(6, 5))
    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.at": ends})

    points = [pc.certify(point, digits=12) for point in branch.special_points]

    assert {point.kind for point in points} == {"period_doubling", "grazing", "fold"}
    assert min(point.value.digits() for point in points) > 12
    assert all(theorem_of(certificate(point)) for point in points if not point.is_formal)


@scales
def test_lists(scale: Scale) -> None:
    osc, force = scale.wall("7/10", "1.45789", "1/20"), scale.cosine("3/2")
    found = list_orbits(osc, force, 1, 1, speeds=(scale.speed("1/20"), scale.speed("5")))

    assert "is among 2 orbits" in theorem_of(certificate(found))


@pytest.mark.parametrize(
    "scale",
    [
        pytest.param(scale, marks=() if name == "small and fast" else pytest.mark.nightly)
        for name, scale in SCALES.items()
    ],
    ids=list(SCALES),
)
def test_basins(scale: Scale) -> None:
    orbit = pc.find_orbit(scale.wall("7/10"), scale.cosine("23/10"))
    x0, v0 = (scale.place("1/10"), scale.place("3/20")), (scale.speed("3/10"), scale.speed("7/20"))

    found = prove_basins(orbit, x0=x0, v0=v0, cells=1)

    assert found.decided == 1.0
    assert "approach the orbits" in theorem_of(certificate(found))
