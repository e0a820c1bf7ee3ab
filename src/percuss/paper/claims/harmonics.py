"""Section 4 of the paper held against evidence: the forces sin(n t) and the eigenset."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cache, partial

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.model.forcing import sine
from percuss.motion.eigenset_forms import HarmonicMotion, harmonic_critical_velocity
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims import commensurate, harmonic_limits
from percuss.paper.claims.certain import certain_run, eigenset_kept
from percuss.paper.claims.evidence import ROUNDING, WALL, apart, condition, furthest, near
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]


THEORY = "paper-harmonics.md"
EVEN = (2, 4, 6, 8, 20)
ODD = (3, 5, 7, 9, 15)
FLIGHTS = 40
# Of V_max, at which a second flight is looked at.
PARTS = (0.05, 0.5, 0.95)


@cache
def _run(n: int) -> Trajectory:
    """Return forty flights under sin(n t), for odd n from just above V_max(n)."""
    v0 = 1.01 * harmonic_critical_velocity(n) if n % 2 else 0.1
    return simulate(WALL, sine(n), v0=v0, t_end=(FLIGHTS + 0.5) * math.pi)


def _eigenset(count: int) -> Floats:
    return np.asarray(math.pi * np.arange(1, count + 1), dtype=np.float64)


def _amplitude(n: int, run: Trajectory, k: int) -> float:
    """Return A_k of a simulated motion, from x in the middle of its flight."""
    t = (k + 0.5) * math.pi
    return (float(run(t)[0]) + numerics.sin(n * t) / (n * n - 1)) / numerics.sin(t)


def _velocity(run: Trajectory, k: int) -> float:
    return float(run.impacts.v_after[k - 1]) if k else run.v0


def _worst(numbers: Iterable[int], error: Callable[[int, Trajectory, int], float]) -> float:
    """Return the largest error of a formula over numbers n and flights k."""
    return max(abs(error(n, _run(n), k)) for n in numbers for k in range(1, FLIGHTS))


def _share(n: int) -> float:
    return n / (n * n - 1)


def _sign(k: int) -> float:
    """Return (-1)^k."""
    return -1.0 if k % 2 else 1.0


def _periods() -> Finding:
    """Count half turns pi in units of the force's period 2 pi/n."""
    whole = [(n, turns) for n in range(2, 20) for turns in (1, 2) if (n * turns) % 2 == 0]
    single = sorted(n for n, turns in whole if turns == 1)
    double = sorted(n for n, turns in whole if turns == 2)
    kept = [
        eigenset_kept(
            f"n = {n}, V0 = {_run(n).v0:.6g}: impacts on the eigenset, all",
            sine(n),
            _run(n).v0,
            partial(_on_eigenset, n),
        )
        for n in (*EVEN, *ODD)
    ]
    even, every = single == [*range(2, 20, 2)], double == [*range(2, 20)]
    return Finding(
        (
            # Whole numbers are counted: there is no rounding.
            Check("pi is a whole number of periods for even n", float(even), 1.0, radius=0.0),
            Check("2 pi is for every n", float(every), 1.0, radius=0.0),
            *kept,
        )
    )


def _on_eigenset(n: int) -> bool:
    return furthest(_run(n), _eigenset(FLIGHTS)) <= ROUNDING


def _form(numbers: tuple[int, ...]) -> Finding:
    """Compare simulated motions with A_k sin t - sin(n t)/(n^2 - 1)."""
    t = np.linspace(0.0, (FLIGHTS + 0.4) * math.pi, 4001)
    inner = np.abs(t / math.pi - np.round(t / math.pi)) > 1e-6
    flights = np.floor(t / math.pi).astype(int)
    in_x, in_v = [], []
    for n in numbers:
        x, v = _run(n)(t)
        a = np.array([_amplitude(n, _run(n), k) for k in range(FLIGHTS + 1)])[flights]
        in_x.append(apart(x, a * numerics.sin(t) - numerics.sin(n * t) / (n * n - 1)))
        slope = a * numerics.cos(t) - _share(n) * numerics.cos(n * t)
        in_v.append(apart(v[inner], slope[inner]))
    which = ", ".join(map(str, numbers))
    return Finding(
        (
            near(f"x of simulated motions minus the form, n = {which}", max(in_x)),
            near(f"x' of simulated motions minus the form, n = {which}", max(in_v), tolerance=1e-9),
        )
    )


def _even_amplitudes() -> Finding:
    def error(n: int, run: Trajectory, k: int) -> float:
        return _amplitude(n, run, k) - _sign(k) * (_velocity(run, k) + _share(n))

    def gain(n: int, run: Trajectory, k: int) -> float:
        return _velocity(run, k) - _velocity(run, k - 1) - 2 * _share(n)

    return Finding(
        (
            near("A_k - (-1)^k [V_k + n/(n^2-1)], n = 2 to 8, 20", _worst(EVEN, error)),
            near("V_k - V_(k-1) - 2n/(n^2-1)", _worst(EVEN, gain)),
        )
    )


def _every_velocity() -> Finding:
    """Start on even n from rest and from many velocities."""
    kept = [
        furthest(simulate(WALL, sine(n), v0=v0, t_end=12.5 * math.pi), _eigenset(12))
        for n in (2, 4, 6, 8, 20, 100)
        for v0 in (0.0, 1e-6, 0.01, 0.5, 10.0)
    ]
    # The ratio is the same on either side of pi/2.
    eta = np.linspace(1e-6, 0.5 * math.pi, 100_001)
    ratio = max(
        float((np.abs(numerics.sin(n * eta)) / numerics.sin(eta)).max()) / n for n in (2, 4, 6, 20)
    )
    return Finding(
        (
            near("t_k minus pi k, n = 2 to 100, V0 = 0 to 10", max(kept)),
            condition("|sin nt| <= n |sin t|, so that x >= V_k |sin t|", ratio <= 1.0 + ROUNDING),
        ),
        remark="No velocity gives an extra root; from V0 = 0 the force lifts the mass off.",
    )


def _decrease() -> Finding:
    ratios = {n: 2 * _share(n) / (2 / n) for n in (4, 20, 1000)}
    gains = {n: _velocity(_run(n), 2) - _velocity(_run(n), 1) for n in (4, 20)}
    return Finding(
        (
            *(
                near(f"n = {n}: simulated increment over 2/n", gains[n] * n / 2, ratios[n])
                for n in gains
            ),
            near("n = 1000: increment over 2/n", ratios[1000], 1.0, 2e-6),
        ),
        remark="Exactly 2/n for large n; for n = 2 the increment is 4/3 where 2/n is 1.",
    )


def _odd_amplitudes() -> Finding:
    def error(n: int, run: Trajectory, k: int) -> float:
        return _amplitude(n, run, k) - (_sign(k) * _velocity(run, k) + _share(n))

    return Finding((near("A_k - (-1)^k V_k - n/(n^2-1), n = 3 to 9, 15", _worst(ODD, error)),))


def _steady() -> Finding:
    def gain(_: int, run: Trajectory, k: int) -> float:
        return _velocity(run, k) - _velocity(run, k - 1)

    late = []
    for n in ODD:
        v0 = 3.0 * harmonic_critical_velocity(n)
        run = simulate(WALL, sine(n), v0=v0, t0=0.3, t_end=60.0)
        late.append(apart(run.impacts.v_after, np.full(len(run.impacts), v0)))
        late.append(apart(np.diff(run.impacts.t), np.full(len(run.impacts) - 1, math.pi)))
    return Finding(
        (
            near("V_k - V_(k-1), n = 3 to 9, 15", _worst(ODD, gain)),
            near("the same for starts at t = 0.3: V_k and the gaps", max(late)),
        ),
        remark="For odd n the particular solution changes its sign in pi, so a steady motion "
        "with gaps pi starts at every phase of the force, not at t = 0 alone.",
    )


def _first_flight() -> Finding:
    """Look for impacts on the first flight, whatever the velocity."""
    firsts = [
        float(simulate(WALL, sine(n), v0=part, max_impacts=1, t_end=7.0).impacts.t[0])
        for n in ODD
        for part in (1e-4, 1e-2, 0.1, 0.3, 1.0)
    ]
    values = [apart(*_flight_values(n, 0)) for n in ODD]
    return Finding(
        (
            near("x minus the left side on (0, pi)", max(values)),
            near("first impact minus pi, n = 3 to 9, 15, V0 = 1e-4 to 1", _gap_to_pi(firsts)),
        )
    )


def _gap_to_pi(times: list[float]) -> float:
    return apart(np.array(times), np.full(len(times), math.pi))


def _flight_values(n: int, k: int) -> tuple[Floats, Floats]:
    """Return x on flight k of a simulated motion, and by (22) or (23)."""
    run = _run(n)
    t = (k + np.linspace(0.001, 0.999, 999)) * math.pi
    amplitude = run.v0 * _sign(k) + _share(n)
    return run(t)[0], amplitude * numerics.sin(t) - numerics.sin(n * t) / (n * n - 1)


def _second_flight() -> Finding:
    """Look for impacts on the second flight below V_max."""
    values = [apart(*_flight_values(n, 1)) for n in ODD]
    early = [_early(n, part * harmonic_critical_velocity(n)) for n in ODD for part in PARTS]
    return Finding(
        tuple(early),
        remark=f"Simulated flights differ from the left side by {max(values):.0e} at most, "
        "with A_1 = n/(n^2-1) - V; the minus before V is lost in the text's extraction.",
    )


def _early(n: int, v0: float) -> Check:
    """See whether the first impact is at pi and the second before 2 pi."""
    run = simulate(WALL, sine(n), v0=v0, max_impacts=2)
    what = f"n = {n}, V0 = {v0:.4f}: second impact over pi, between 1 and 2"
    proven = certain_run(run)
    if proven is None:
        return near(what, run.impacts.t[1] / math.pi, 1.5, 0.5 - 1e-3)
    ball = proven.impacts.t[1]
    # In units of pi, with what the division may round.
    return Check(what, ball.mid() / math.pi, 1.5, 0.5 - 1e-3, ball.radius() + 1e-12)


def _not_sufficient() -> Finding:
    """Stay on the eigenset for ever with odd n, and follow the velocity for a thousand flights."""
    kept, growth = [], []
    for n in ODD:
        motion = HarmonicMotion(n, 0.6)
        run = simulate(WALL, motion.forcing, v0=0.6, max_impacts=1000)
        on = furthest(run, _eigenset(1000)) <= 1e-9
        what = f"n = {n}, V0 = 0.6: all impacts on the eigenset, where V_k = V_(k-1) by (21)"
        kept.append(eigenset_kept(what, motion.forcing, 0.6, partial(bool, on)))
        growth.append(apart(run.impacts.v_after, np.full(1000, 0.6)))
    return Finding(
        tuple(kept), remark=f"Simulated, V_k - V_0 is at most {max(growth):.0e} in 1000 flights."
    )


_of = partial(Statement, theory=THEORY)

OWN: tuple[Statement, ...] = (
    _of(
        id="eq17",
        reference="(17)",
        claim="Under sin(n t) motions with the eigenset as impact times exist; it shares the "
        "period pi with the force for even n, 2 pi for odd n.",
        formula=r"x'' + x = \sin nt,\ x > 0",
        method="counting of periods; simulation of forty flights",
        certainty="simulation, 1e-10",
        find=_periods,
    ),
    _of(
        id="eq18",
        reference="(18)",
        claim="For even n the motion on each flight is A_k sin t - sin(nt)/(n^2-1).",
        formula=r"x_k = A_k\sin t - \frac{\sin nt}{n^2-1}",
        method="simulation of forty flights",
        certainty="closed form, 12 digits",
        proven=True,
        find=partial(_form, EVEN),
    ),
    _of(
        id="eq19",
        reference="(19)",
        claim="For even n the velocity gains 2n/(n^2-1) at each impact: linear growth.",
        formula=r"A_k = (-1)^k[V_k + \frac{n}{n^2-1}],\ V_k = V_{k-1} + \frac{2n}{n^2-1}",
        method="amplitudes and velocities of simulated motions; symbolic in the tests",
        certainty="symbolic",
        proven=True,
        find=_even_amplitudes,
    ),
    _of(
        id="eq19-velocities",
        reference="(18), (19)",
        claim="For even n every V0 >= 0 gives this resonance.",
        method="bound of sin(nt)/sin(t); simulation from V0 = 0 to 10",
        certainty="proof",
        proven=True,
        find=_every_velocity,
    ),
    _of(
        id="eq19-increment",
        reference="section 4",
        claim="The velocity increment decreases as 2/n.",
        method="simulated increments, and the formula",
        certainty="closed form, 12 digits",
        proven=True,
        find=_decrease,
    ),
    _of(
        id="eq20",
        reference="(20)",
        claim="For odd n the form is the same, with other amplitudes.",
        formula=r"A_k = (-1)^k V_k + \frac{n}{n^2-1}",
        method="amplitudes of simulated motions; symbolic in the tests",
        certainty="symbolic",
        proven=True,
        find=lambda: _both(_form(ODD), _odd_amplitudes()),
    ),
    _of(
        id="eq21",
        reference="(21)",
        claim="For odd n the impact velocity stays the same: steady oscillation.",
        formula=r"V_k = V_{k-1}",
        method="velocities of simulated motions; symbolic in the tests",
        certainty="symbolic",
        proven=True,
        find=_steady,
    ),
    _of(
        id="eq22",
        reference="(22)",
        claim="For odd n and V > 0 there is no extra root on the flights (2p pi, (2p+1) pi).",
        formula=r"[V + \frac{n}{n^2-1}]\sin t - \frac{\sin nt}{n^2-1} = 0",
        method="simulation from V0 = 1e-4 to 1",
        certainty="proof",
        proven=True,
        find=_first_flight,
    ),
    _of(
        id="eq23",
        reference="(23)",
        claim="Extra roots lie on the flights ((2p+1) pi, 2(p+1) pi).",
        formula=r"[-V + \frac{n}{n^2-1}]\sin t - \frac{\sin nt}{n^2-1} = 0",
        method="simulation below V_max",
        certainty="simulation, 1e-10",
        find=_second_flight,
    ),
    _of(
        id="not-sufficient",
        reference="section 4",
        claim="That the eigenset and the force share a period does not suffice for a resonance.",
        method="simulation of 1000 flights for odd n",
        certainty="simulation, 1e-10",
        find=_not_sufficient,
    ),
)


def _both(one: Finding, other: Finding) -> Finding:
    return Finding((*one.printed, *other.printed))


STATEMENTS: tuple[Statement, ...] = (
    *OWN,
    *harmonic_limits.STATEMENTS,
    *commensurate.STATEMENTS,
)
