"""Self-excited oscillators: limit cycles without forcing, their continuation, and growth.

x'' + 2 z x' + x = 0 with z = z- < 0 inside and z+ > 0 outside, for abs(x) < 1 or for x < 1. Radius
and period of the cycles are known to some digits from the text of others; here they are solved for
once more, in 30 digits.
"""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

import percuss as pc
from percuss.arrays import Floats
from percuss.kernels.flight import Flight, move, uncertainty
from percuss.kernels.law_columns import FIRST_HARMONIC
from percuss.model.system import System
from percuss.studies.reading import parse_study
from percuss.studies.running import run_study

# Both stops or only the one above, z-, the largest displacement, the period, and what others give.
CYCLES = [
    (True, "-0.025", 1.807455267376, 6.2847022629507, (1.8075, 6.28470)),
    (True, "-0.05", 2.4756663018684, 6.2859134177652, (2.4757, 6.28591)),
    (True, "-0.1", 3.7751374885413, 6.2873600447845, (3.7751, 6.28736)),
    (True, "-0.2", 6.3409230700651, 6.2886975787162, (6.3409, 6.28870)),
    (False, "-0.01", 1.8076411184386, 6.284367968209, (1.8076, 6.28437)),
    (False, "-0.025", 3.777155793145, 6.2869038688597, (3.7772, 6.28690)),
]
OUTSIDE = "0.05"
each_cycle = pytest.mark.parametrize("cycle", CYCLES, ids=lambda c: f"{c[0]}, {c[1]}")


def self_excited(inside: str, outside: str = OUTSIDE, *, symmetric: bool = True) -> pc.Oscillator:
    """Return an oscillator with one damping inside and another outside."""
    more = Fraction(outside) - Fraction(inside)
    stops = [pc.SoftStop(at=1, side="above", stiffness=0, damping=more)]
    if symmetric:
        stops.append(pc.SoftStop(at=-1, side="below", stiffness=0, damping=more))
    return pc.Oscillator(1, inside, tuple(stops))


def found(osc: pc.Oscillator) -> pc.PeriodicOrbit:
    return pc.find_orbit(osc, n_impacts=len(osc.stops))


def solved(inside: str, *, symmetric: bool) -> tuple[float, float]:
    """Return the largest displacement and the period of a cycle, from its equations in mpmath."""
    with mpmath.workdps(30):
        z = {name: mpmath.mpf(text) for name, text in (("in", inside), ("out", OUTSIDE))}

        def flown(where: str, x: Any, v: Any, s: Any) -> tuple[Any, Any]:
            a = z[where]
            w = mpmath.sqrt(1 - a * a)
            cosine, sine, decay = mpmath.cos(w * s), mpmath.sin(w * s), mpmath.exp(-a * s)
            at = decay * (x * cosine + (v + a * x) / w * sine)
            return at, decay * (v * cosine - (x + a * v) / w * sine)

        # Out at x = 1, back at x = 1, and on to the other edge, or round to the same.
        end = -1 if symmetric else 1

        def equations(v: Any, out: Any, back: Any) -> list[Any]:
            x1, v1 = flown("out", mpmath.mpf(1), v, out)
            x2, v2 = flown("in", mpmath.mpf(1), v1, back)
            return [x1 - 1, x2 - end, v2 - end * v]

        radius = max(1.5, -2.5 * float(z["in"]) * 12) if symmetric else -150 * float(z["in"])
        angle = float(mpmath.acos(1 / radius))
        inner = mpmath.pi - 2 * angle if symmetric else 2 * mpmath.pi - 2 * angle
        guess = (radius * float(mpmath.sin(angle)), 2 * angle, inner)
        v, out, back = mpmath.findroot(equations, guess)
        turn = mpmath.findroot(lambda s: flown("out", mpmath.mpf(1), v, s)[1], angle)
        period = (out + back) * (2 if symmetric else 1)
        return float(flown("out", mpmath.mpf(1), v, turn)[0]), float(period)


@each_cycle
def test_a_limit_cycle_has_the_known_radius_and_period(cycle: Any) -> None:
    symmetric, inside, radius, period, published = cycle

    orbit = found(self_excited(inside, symmetric=symmetric))

    extremes = orbit.trajectory().extremes("displacement")
    assert extremes.maximum == pytest.approx(radius, rel=1e-12)
    assert orbit.period == pytest.approx(period, rel=1e-12)
    assert (round(radius, 4), round(period, 5)) == published
    assert solved(inside, symmetric=symmetric) == pytest.approx((radius, period), rel=2e-13)
    assert orbit.n_periods == 0
    assert orbit.isolated
    assert orbit.stability == "asymptotic"


@each_cycle
def test_one_multiplier_of_a_cycle_is_1_and_the_other_its_loss_of_area(cycle: Any) -> None:
    symmetric, inside, *_ = cycle
    orbit = found(self_excited(inside, symmetric=symmetric))

    trivial, other = orbit.multipliers.real

    assert trivial == 1.0
    assert np.sort(np.linalg.eigvals(orbit.monodromy).real) == pytest.approx([other, 1], abs=1e-11)
    # A motion beside the cycle comes nearer by this factor in each period.
    run = pc.simulate(orbit.oscillator, x0=1.0, v0=orbit.v0 * (1 + 1e-6), max_impacts=13)
    entries = run.crossings.v[(run.crossings.direction == "in") & (run.crossings.stop == 0)]
    distances = np.abs(entries) - abs(orbit.v0) if orbit.x0 == 1.0 else None
    if distances is not None:
        assert distances[1:5] / distances[:4] == pytest.approx(4 * [other], rel=1e-4)


def test_run_backwards_the_cycle_is_the_same_and_repels() -> None:
    """Reversed time turns the sign of every dashpot round."""
    forth = found(self_excited("-0.1"))
    back = found(self_excited("0.1", "-0.05"))

    assert back.stability == "unstable"
    assert back.period == pytest.approx(forth.period, rel=1e-13)
    assert abs(back.v0) == pytest.approx(float(np.abs(forth.impacts.v_before).max()), rel=0.2)
    assert back.multipliers[0].real * forth.multipliers[1].real == pytest.approx(1.0, rel=1e-11)


def test_a_run_and_a_similar_cycle_are_guesses() -> None:
    osc = self_excited("-0.1")
    orbit = found(osc)

    by_run = pc.find_orbit(osc, guess=pc.simulate(osc, v0=1, t_end=400))
    nearby = pc.find_orbit(self_excited("-0.11"), guess=orbit)

    assert by_run.period == pytest.approx(orbit.period, rel=1e-13)
    assert nearby.period == pytest.approx(found(self_excited("-0.11")).period, rel=1e-13)


def test_a_branch_of_cycles_has_its_period_as_an_unknown() -> None:
    stop = pc.parameter("stop", 1)
    more = Fraction("0.15")
    osc = pc.Oscillator(
        1,
        "-0.1",
        (
            pc.SoftStop(at=stop, side="above", stiffness=0, damping=more),
            pc.SoftStop(at=-1, side="below", stiffness=0, damping=more),
        ),
    )
    branch = pc.continue_orbit(found(osc), over={"stop": ("0.6", "1.5")})

    assert branch.special_points == ()
    assert len(set(np.round([orbit.period for orbit in branch], 9).tolist())) > 5
    for k in (0, len(branch) // 3, len(branch) - 1):
        there = pc.Oscillator(
            1,
            "-0.1",
            (
                pc.SoftStop(at=branch.values[k], side="above", stiffness=0, damping=more),
                osc.stops[1],
            ),
        )
        again = found(there)
        assert branch[k].period == pytest.approx(again.period, rel=1e-12)
        assert branch[k].multipliers == pytest.approx(again.multipliers, abs=1e-9)


def test_two_cycles_meet_at_a_fold() -> None:
    """Damped near rest and far out, excited in between: a small cycle repels, a large attracts."""

    def osc(middle: pc.Expression | float) -> pc.Oscillator:
        stops = []
        for at, damping in ((1, middle - 0.05), (2, 0.1 - middle)):
            stops.append(pc.SoftStop(at=at, side="above", stiffness=0, damping=damping))
            stops.append(pc.SoftStop(at=-at, side="below", stiffness=0, damping=damping))
        return pc.Oscillator(1, 0.05, tuple(stops))

    orbits = pc.find_orbits(osc(pc.parameter("d", -0.3)), max_impacts=4)
    assert sorted(orbit.stability for orbit in orbits) == ["asymptotic", "unstable"]
    large = next(orbit for orbit in orbits if orbit.is_stable)
    branch = pc.continue_orbit(large, over={"d": (-0.4, -0.01)})

    (fold,) = [point for point in branch.special_points if point.kind == "fold"]
    assert fold.status == "located"
    assert fold.orbit.multipliers == pytest.approx([1.0, 1.0], abs=1e-5)
    # Beyond it every motion comes to rest, before it the large cycle attracts.
    times = np.linspace(3990, 4000, 50)
    beyond, before = (
        pc.simulate(osc(fold.value + shift), v0=4, t_end=4000)(times)[0] for shift in (0.01, -0.01)
    )
    assert float(np.abs(beyond).max()) < 0.1
    assert float(np.abs(before).max()) > 2.0


def test_a_study_without_forcing_finds_a_cycle(tmp_path: Path) -> None:
    study = parse_study(
        """
[study]
kind = "branch"
[oscillator]
damping = "-0.05"
stops = [
  {type = "soft", at = 1, side = "above", stiffness = 0, damping = "0.1"},
  {type = "soft", at = -1, side = "below", stiffness = 0, damping = "0.1"},
]
[orbit]
impacts = 2
[over]
"oscillator.damping" = ["-0.07", "-0.03"]
"""
    )
    run_study(study, tmp_path)

    branch = pc.load_netcdf(tmp_path / "branch.nc")
    assert min(orbit.period for orbit in branch) < CYCLES[1][3] < branch[-1].period * 1.01


def test_a_growing_run_is_proven() -> None:
    pytest.importorskip("flint")
    osc = pc.impact_oscillator("0.8", damping="-0.1")
    run = pc.simulate(osc, pc.cosine("2.8"), v0=1, t_end=50)

    proven = pc.certify(run)

    assert len(run.impacts) == len(proven.impacts) == 15
    for t, ball in zip(run.impacts.t, proven.impacts.t, strict=True):
        assert ball.mid() == pytest.approx(t, rel=1e-12)
    cycle = pc.certify(found(self_excited("-0.1")))
    assert not cycle.exists
    assert "period of a limit cycle is an unknown" in cycle.reason


@pytest.mark.parametrize(("restitution", "damping"), [("0.9", "-0.02"), ("0.5", "-0.05")])
def test_a_wall_that_takes_what_the_dashpot_gives(restitution: str, damping: str) -> None:
    """With the wall at the equilibrium all speeds are alike; off it there is one cycle."""
    osc = pc.impact_oscillator(restitution, wall=-1, damping=damping)

    orbit = pc.find_orbit(osc)

    # From the wall at -1 with velocity v, back after s with -v / r.
    with mpmath.workdps(30):
        a, r = mpmath.mpf(damping), mpmath.mpf(restitution)
        w = mpmath.sqrt(1 - a * a)

        def equations(v: Any, s: Any) -> list[Any]:
            decay, cosine, sine = mpmath.exp(-a * s), mpmath.cos(w * s), mpmath.sin(w * s)
            x = decay * (-cosine + (v - a) / w * sine)
            speed = decay * (v * cosine - (-1 + a * v) / w * sine)
            return [x + 1, speed * r + v]

        v, s = mpmath.findroot(equations, (orbit.v0, orbit.period))
    assert orbit.v0 == pytest.approx(float(v), rel=1e-12)
    assert orbit.period == pytest.approx(float(s), rel=1e-12)


def test_growth_without_bound_is_an_outcome() -> None:
    loose = pc.simulate(pc.Oscillator(1, "-0.1"), v0=1, t_end=1e5)
    elastic = pc.simulate(pc.impact_oscillator(1, damping="-0.1"), v0=1, t_end=1e5)
    creeping = pc.simulate(pc.impact_oscillator(1, wall=-1, damping=-2), x0=1, t_end=1e5)

    for run in (loose, elastic, creeping):
        assert run.outcome is pc.Outcome.overflow
        assert 1e149 < float(np.abs(run(run.t_end)).max()) <= 1.01e150


@pytest.mark.parametrize(
    ("osc", "message"),
    [
        (pc.impact_oscillator(1, wall=-1, damping=-1), "gains energy all the time"),
        (pc.impact_oscillator(1, wall=-1, damping=1), "loses energy all the time"),
        (pc.bilinear_oscillator(stiffness_below=4, damping=-1), "gains energy all the time"),
    ],
)
def test_free_motion_that_only_gains_or_loses_has_no_orbit(
    osc: pc.Oscillator, message: str
) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.find_orbit(osc)


# Every linear regime: oscillating, critical, two roots, near each other and far apart, no spring.
REGIMES = [(1.0, -0.01), (4.0, -2.0), (1.0, -3.0), (1e-6, -1.0), (0.0, -0.7), (-0.5, -0.3), (0, -9)]


@pytest.mark.parametrize("law", REGIMES, ids=str)
@pytest.mark.parametrize("omega", [1.0, 0.01, 1e-6])
def test_a_growing_flight_is_exact_to_its_bound(law: tuple[float, float], omega: float) -> None:
    k, a = law
    system = System(pc.Oscillator(k, a), pc.cosine(omega, constant=0.3))
    phases, arrival = np.array([[1.0, 0.0]]), np.empty((1, 2))
    region = FIRST_HARMONIC + 1
    flight = Flight(system.law, region, (0.0, 0.0, 0.7, 0.3), phases, arrival)

    for s in (1e-9, 0.01, 0.4, 0.6, 3.0, 20.0, 70.0):
        y, v = move(flight, s)
        exact_y, exact_v = _exact(k, a, omega, s)
        if not abs(exact_y) < 1e150:
            continue
        assert abs(y - exact_y) <= uncertainty(flight, s), s
        size = 1e-13 * (1.0 + abs(a) * s) * max(abs(float(exact_v)), uncertainty(flight, s) * 1e13)
        assert abs(v - exact_v) <= size


def _exact(k: float, a: float, omega: float, s: float) -> Floats:
    """Return (y, v) of y'' + 2 a y' + k y = 0.3 + cos(omega s), y = 0, y' = 0.7, in mpmath."""
    with mpmath.workdps(120):
        a_, k_, w, t = (mpmath.mpf(value) for value in (a, k, omega, s))
        # Equal roots are moved apart by far less than the digits asked for.
        root = mpmath.sqrt(mpmath.mpc(a_ * a_ - k_) + mpmath.mpf(10) ** -60)
        # (y, y', 1, exp(i w t)) obeys a linear system: partial fractions of its transform.
        tiny = mpmath.mpf(10) ** -50
        poles = [-a_ + root, -a_ - root, tiny, w * 1j + 2 * tiny]

        def top(p: Any) -> Any:
            real = mpmath.mpf("0.7") * (p - poles[2]) * (p - poles[3])
            return real + mpmath.mpf(0.3) * (p - poles[3]) + (p - poles[2])

        y, v = mpmath.mpf(0), mpmath.mpf(0)
        for i, pole in enumerate(poles):
            others = mpmath.mpf(1)
            for j, other in enumerate(poles):
                if j != i:
                    others *= pole - other
            term = top(pole) / others * mpmath.exp(pole * t)
            y, v = y + term, v + pole * term
        return np.array([float(y.real), float(v.real)])


def test_a_cycle_on_a_wall_that_takes_all_velocity_is_found() -> None:
    osc = pc.impact_oscillator(restitution=0, wall=1, side="above", damping="-0.05")
    settled = pc.simulate(osc, x0=0.1, max_impacts=60)
    for guess in (None, settled):
        orbit = pc.find_orbit(osc, guess=guess)
        assert orbit.period == pytest.approx(settled.impacts.intervals[-1], rel=1e-13)
        assert orbit.stability == "asymptotic"
    # From rest on the wall the growing motion comes back to it.
    with mpmath.workdps(30):
        w = mpmath.sqrt(1 - mpmath.mpf("0.05") ** 2)
        period = mpmath.findroot(
            lambda t: mpmath.exp(t / 20) * (mpmath.cos(w * t) - mpmath.sin(w * t) / (20 * w)) - 1,
            orbit.period,
        )
    assert orbit.period == pytest.approx(float(period), rel=1e-13)
