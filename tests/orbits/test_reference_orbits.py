"""The reference cases that an orbit decides (tests/reference/README.md)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import ArrayLike
from tests.reference.measures import Case

import percuss as pc
from percuss.orbits import single_impact, single_impact_orbits

ROWS = {
    row["id"]: row
    for row in json.loads(
        (Path(__file__).parents[1] / "reference" / "cases.json").read_text(encoding="utf-8")
    )
}
ORBITS = [name for name, row in ROWS.items() if row["category"] == "periodic orbit"]
ONE_WALL = [name for name in ORBITS if len(ROWS[name]["params"].get("walls", ())) == 1]
TWO_WALLS = [name for name in ORBITS if len(ROWS[name]["params"].get("walls", ())) == 2]
BILINEAR = [name for name in ORBITS if "kp" in ROWS[name]["params"]]


def system(name: str, **changes: object) -> tuple[pc.Oscillator, pc.Forcing]:
    """Return oscillator and forcing of a case, with parameters that it leaves open."""
    params = json.loads(json.dumps(ROWS[name]["params"]))
    for key, value in changes.items():
        place = params["walls"][0] if key == "x" else params["harmonics"][0]
        place[key] = value
    case = Case(name, params, [], 0.0)
    return case.oscillator(), case.force()


def numbers(name: str) -> list[Any]:
    """Return the values of a case as floats and, for pairs, complex numbers or lists."""
    return [
        [float(part) for part in value] if isinstance(value, list) else float(value)
        for value in ROWS[name]["value"]
    ]


def agree(found: ArrayLike, expected: ArrayLike, name: str) -> None:
    there, wanted = (np.asarray(part, dtype=np.float64) for part in (found, expected))
    np.testing.assert_allclose(there, wanted, rtol=0, atol=ROWS[name]["tolerance"])


def multipliers_agree(orbit: pc.PeriodicOrbit, first: list[float], name: str) -> None:
    """The first given is one of a pair; trace and determinant tell the other."""
    wanted = complex(*first)
    agree(np.abs(orbit.multipliers - wanted).min(), 0.0, name)


def test_no_case_is_left_out() -> None:
    assert sorted(ONE_WALL + TWO_WALLS + BILINEAR) == sorted(ORBITS)
    assert len(ORBITS) == 12


@pytest.mark.parametrize("name", ONE_WALL)
def test_single_impact_orbits(name: str) -> None:
    speed, t0, trace, determinant, first, second = numbers(name)
    osc, force = system(name)
    n_periods = ROWS[name]["params"]["period_multiple"]

    found = single_impact_orbits(osc, force, n_periods)

    orbit = min(found, key=lambda each: abs(each.impacts.v_before[0] - speed))
    agree([orbit.impacts.v_before[0], orbit.t0], [speed, t0], name)
    agree(np.trace(orbit.monodromy), trace, name)
    agree(np.linalg.det(orbit.monodromy), determinant, name)
    multipliers_agree(orbit, first, name)
    multipliers_agree(orbit, second, name)
    assert orbit.admissible
    assert orbit.residual < 1e-13


@pytest.mark.parametrize(
    "name", [name for name in ONE_WALL if name != "hyst-lower-a0.05-r0.7-w1.5"]
)
def test_find_orbit_gives_the_same_without_the_closed_form(name: str) -> None:
    """By Newton's method, from a guess that is a tenth off."""
    speed, t0 = numbers(name)[:2]
    osc, force = system(name)
    assert force.period is not None
    v_after = -float(ROWS[name]["params"]["r"]) * speed
    guess = (t0 / force.period + 0.01, 1.1 * v_after)

    orbit = pc.find_orbit(osc, force, 1, ROWS[name]["params"]["period_multiple"], guess=guess)

    agree([orbit.impacts.v_before[0], orbit.t0], [speed, t0], name)


@pytest.mark.parametrize("name", TWO_WALLS)
def test_orbits_between_two_walls(name: str) -> None:
    speed, t0, trace, determinant, first, second = numbers(name)
    osc, force = system(name)

    orbit = pc.find_orbit(osc, force, 2, 1)

    upper = list(orbit.impacts.stop).index(0)
    agree(np.abs(orbit.impacts.v_before), [speed, speed], name)
    agree(orbit.impacts.t[upper] % orbit.period, t0, name)
    agree(np.trace(orbit.monodromy), trace, name)
    agree(np.linalg.det(orbit.monodromy), determinant, name)
    multipliers_agree(orbit, first, name)
    multipliers_agree(orbit, second, name)


@pytest.mark.parametrize("name", BILINEAR)
def test_orbits_of_bilinear_oscillators(name: str) -> None:
    x, v, crossings, trace, determinant, *multipliers = numbers(name)
    osc, force = system(name)

    orbit = pc.find_orbit(osc, force)

    run = orbit.trajectory(2)
    start = np.ceil(run.t0 / orbit.period) * orbit.period
    agree(run(start), [x, v], name)
    inside = (run.crossings.t >= start) & (run.crossings.t <= start + orbit.period)
    agree(run.crossings.t[inside] - start, crossings, name)
    agree(np.trace(orbit.monodromy), trace, name)
    agree(np.linalg.det(orbit.monodromy), determinant, name)
    for multiplier in multipliers:
        multipliers_agree(orbit, multiplier, name)
    strobe = pc.stroboscopic_map(osc, force)
    agree(strobe(x, v), [x, v], name)


def test_grazing_of_cocos_example() -> None:
    for omega, amplitude in zip(("1", "0.7", "1.3"), ROWS["coco-grazing-A"]["value"], strict=True):
        osc, force = system("coco-grazing-A", A=amplitude, omega=omega)

        orbit = pc.find_orbit(osc, force, n_impacts=0)

        agree(orbit.grazing_margin, 0.0, "coco-grazing-A")
        # Its two orbits with one impact end there too, with no velocity.
        agree(np.abs(single_impact(osc, force).roots[:, 1]).min(), 0.0, "coco-grazing-A")


def test_fold_in_the_gap() -> None:
    name = "fold-a0.05-r0.7-w1.5"
    sigma, graze, speed = ROWS[name]["value"]

    at_fold = single_impact(*system(name, x=sigma))
    before = single_impact(*system(name, x=f"{float(sigma) - 1e-9:.17g}"))
    beyond = single_impact(*system(name, x=f"{float(sigma) + 1e-9:.17g}"))

    scale = at_fold.coefficients[1] ** 2
    assert abs(at_fold.discriminant) < 1e-13 * scale
    agree(-0.5 * at_fold.coefficients[1] / at_fold.coefficients[0], float(speed), name)
    assert (len(before.roots), len(beyond.roots)) == (2, 0)
    assert pc.find_orbit(*system(name, x=graze), 0).grazing_margin == pytest.approx(0.0, abs=1e-10)


@pytest.mark.parametrize("name", ["pd-r0.8-n1", "pd-r0.5-n1"])
def test_period_doubling(name: str) -> None:
    omega, speed = ROWS[name]["value"]

    orbit = single_impact_orbits(*system(name, omega=omega))[0]

    agree(orbit.min_impact_speed, float(speed), name)
    determinant = np.linalg.det(orbit.monodromy)
    agree(1.0 + np.trace(orbit.monodromy) + determinant, 0.0, name)
    assert orbit.stability == "parabolic"


def test_thresholds_of_the_ball() -> None:
    name = "ball-thresholds-r0.8"
    fold, doubling = (float(value) for value in ROWS[name]["value"])

    assert len(single_impact(*system(name, A=fold - 1e-9)).roots) == 0
    assert len(single_impact(*system(name, A=fold + 1e-9)).roots) == 2
    orbits = single_impact_orbits(*system(name, A=doubling))
    edge = [1.0 + np.trace(each.monodromy) + np.linalg.det(each.monodromy) for each in orbits]
    agree(min(np.abs(edge)), 0.0, name)


def test_spectrum_of_an_orbit() -> None:
    name = "spectrum-orbit-w2.5"

    orbit = pc.find_orbit(*system(name))

    amplitude = orbit.spectrum(6).amplitude.values
    # |c_m| is half the amplitude of a line, but for the mean.
    agree(amplitude * [1.0, 0.5, 0.5, 0.5, 0.5, 0.5], [float(c) for c in numbers(name)], name)


def test_spectrum_of_free_motion() -> None:
    name = "spectrum-abs-sin"
    osc, _ = system(name)

    orbit = pc.find_orbit(osc, guess=pc.simulate(osc, v0=1.0, t_end=20.0))

    agree(orbit.period, np.pi, name)
    agree(orbit.spectrum(5).amplitude.values, numbers(name), name)
