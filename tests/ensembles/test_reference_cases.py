"""The Lyapunov, basin and bifurcation cases of the reference, by what ensembles find.

A bifurcation is located by following orbits, to the tolerance of the case; a diagram, a sweep or
basins on either side of it then show what it says.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc

FILE = Path(__file__).parents[1] / "reference" / "cases.json"
KINDS = ("Lyapunov", "basin", "bifurcation")
CASES: dict[str, dict[str, Any]] = {
    case["id"]: case
    for case in json.loads(FILE.read_text(encoding="utf-8"))
    if case["category"] in KINDS
}


def numbers(case: dict[str, Any]) -> list[float]:
    value = case["value"]
    return [float(one) for one in (value if isinstance(value, list) else [value])]


def period_of(osc: pc.Oscillator, force: pc.Forcing, path: str, value: float) -> int:
    """Return the period of the motion after a long time, slow as it is next to a doubling."""
    over, settling = {path: [value]}, 20_000
    start = [(0.0, 1.0 if osc.stops[0].side == "below" else -1.0)]
    diagram = pc.bifurcation_diagram(
        osc, force, over=over, starts=start, follow=[], transient=settling, section="impacts"
    )
    return int(diagram.period.values[0, 0])


def check_stable(case: dict[str, Any]) -> None:
    osc = pc.impact_oscillator(restitution="0.8", side="above")
    exponents = pc.lyapunov_exponents(osc, pc.cosine("2.5"), start=(0.0, -1.0))

    np.testing.assert_allclose(
        exponents.exponents, numbers(case)[0], rtol=0, atol=case["tolerance"]
    )


def check_chaos(case: dict[str, Any]) -> None:
    osc = pc.impact_oscillator(restitution="0.8", side="above")
    exponents = pc.lyapunov_exponents(osc, pc.cosine("2.8"), start=(0.0, -1.0), periods=200_000)

    largest, rate, smallest = numbers(case)
    tolerance = case["tolerance"] + 4.0 * exponents.errors[0]
    assert exponents.errors[0] < 0.001
    np.testing.assert_allclose(exponents.exponents, [largest, smallest], rtol=0, atol=tolerance)
    assert exponents.impact_rate == pytest.approx(rate, abs=tolerance)


def check_line(case: dict[str, Any]) -> None:
    osc = pc.impact_oscillator(restitution="0.7", wall="1.45789", side="above", damping="0.05")
    for boundary in numbers(case):
        x0 = [boundary - case["tolerance"], boundary + case["tolerance"]]
        basins = pc.basins(osc, pc.cosine("1.5"), x0=x0, v0=[0.0])
        assert sorted(basins.name.values.tolist()) == ["(0, 1)", "(1, 1)"]
        assert sorted(basins.basin.values[:, 0].tolist()) == [0, 1]


def check_grazing(case: dict[str, Any]) -> None:
    """The steady response begins to strike at the amplitude of the case."""
    osc = pc.impact_oscillator(restitution="0.8", wall=1, side="above", damping="0.05")
    for omega, amplitude in zip(("1", "0.7", "1.3"), numbers(case), strict=True):
        force = pc.cosine(omega, amplitude=0.5 * amplitude)
        # Far enough below it that the way there from rest does not strike either.
        data = pc.sweep(
            "peak_displacement", osc, force, over={"forcing.amplitude": [0.5 * amplitude]},
            transient=400,
        )  # fmt: skip
        # Without impacts the response is proportional to the amplitude.
        graze = 0.5 * amplitude / float(data.peak_displacement[0])
        assert graze == pytest.approx(amplitude, abs=case["tolerance"])


def check_fold(case: dict[str, Any]) -> None:
    osc = pc.impact_oscillator(restitution="0.7", wall=1, side="above", damping="0.05")
    force, path = pc.cosine("1.5"), "oscillator.stops.0.at"
    fold, graze, speed = numbers(case)
    branch = pc.continue_orbit(pc.find_orbit(osc, force), over={path: (0.5, 3.0)})
    points = {point.kind: point for point in branch.special_points}
    assert points["fold"].value == pytest.approx(fold, abs=case["tolerance"])
    assert points["grazing"].value == pytest.approx(graze, abs=case["tolerance"])
    # The branch holds velocities after impacts: 0.7 of those before.
    assert branch.impact_velocity[points["fold"].row].max() in (
        pytest.approx(speed, abs=1e-6), pytest.approx(0.7 * speed, abs=1e-6)
    )  # fmt: skip

    gaps = np.array([graze - 0.01, *np.linspace(1.2, 2.0, 5), fold - 0.01, fold + 0.01])
    shares = pc.basin_fractions(
        osc, force, over={path: gaps}, x0=(-4.0, 0.5), v0=(-4.0, 4.0), n_starts=100
    )
    assert shares.exists.values[0].tolist() == (gaps < fold).tolist()
    assert shares.exists.values[1].tolist() == (gaps > graze).tolist()


def check_doubling(case: dict[str, Any]) -> None:
    restitution = str(case["params"]["r"])
    osc = pc.impact_oscillator(restitution=restitution, side="above")
    doubled = located_doubling(osc, pc.cosine("2.5"), "forcing.omega", (2.4, 2.8))

    omega = numbers(case)[0]
    assert doubled == pytest.approx(omega, abs=case["tolerance"])
    assert period_of(osc, pc.cosine(2.5), "forcing.omega", omega - 1e-3) == 1
    assert period_of(osc, pc.cosine(2.5), "forcing.omega", omega + 1e-3) == 2


def check_ball(case: dict[str, Any]) -> None:
    """The table's frame: gravity 1 and a force of amplitude G."""
    path, (begins, doubles) = "forcing.amplitude", numbers(case)

    def ball(amplitude: float) -> tuple[pc.Oscillator, pc.Forcing]:
        force = pc.sine(1, amplitude=amplitude)
        harmonics = force.harmonics
        return (
            pc.Oscillator(0.0, 0.0, (pc.Wall(0.0, "below", "0.8"),)),
            pc.Forcing(harmonics, constant=-1),
        )

    osc, force = ball(0.7)
    branch = pc.continue_orbit(pc.find_orbit(osc, force), over={path: (0.2, 1.3)})
    found = {point.kind: point.value for point in branch.special_points}
    assert found["fold"] == pytest.approx(begins, abs=case["tolerance"])
    assert found["period_doubling"] == pytest.approx(doubles, abs=case["tolerance"])
    orbit = pc.find_orbit(osc, force)
    for amplitude, period in ((doubles - 0.01, 1), (doubles + 0.01, 2)):
        start = (0.0, float(orbit.impacts.v_after[0]), float(orbit.impacts.t[0]))
        diagram = pc.bifurcation_diagram(
            osc, force, over={path: np.linspace(0.7, amplitude, 30)}, starts=[pc.Start(*start)],
            follow=["forward"], section="impacts", transient=3000,
        )  # fmt: skip
        assert int(diagram.period.sel(branch="forward")[-1]) == period


def located_doubling(
    osc: pc.Oscillator, force: pc.Forcing, path: str, ends: tuple[float, float]
) -> float:
    branch = pc.continue_orbit(pc.find_orbit(osc, force), over={path: ends})
    (value,) = (p.value for p in branch.special_points if p.kind == "period_doubling")
    return float(value)


CHECKS: dict[str, Callable[[dict[str, Any]], None]] = {
    "lyap-stable-w2.5": check_stable,
    "lyap-chaos-w2.8-s0.0": check_chaos,
    "basin-boundary-line": check_line,
    "coco-grazing-A": check_grazing,
    "fold-a0.05-r0.7-w1.5": check_fold,
    "pd-r0.8-n1": check_doubling,
    "pd-r0.5-n1": check_doubling,
    "ball-thresholds-r0.8": check_ball,
}


@pytest.mark.parametrize("name", CASES)
def test_ensembles_find_what_the_reference_says(name: str) -> None:
    CHECKS[name](CASES[name])


def test_the_reference_has_cases_of_every_kind() -> None:
    assert {case["category"] for case in CASES.values()} == set(KINDS)
    assert math.isfinite(sum(sum(numbers(case)) for case in CASES.values()))
