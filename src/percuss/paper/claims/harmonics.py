"""Section 4 of the paper held against evidence: the forces sin(n t) and the eigenset."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from functools import cache, partial

import numpy as np
import sympy
from flint import arb
from sympy import Rational, pi, sin

from percuss.arrays import Floats
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import sine
from percuss.motion.eigenset_forms import harmonic_critical_velocity
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims import commensurate, harmonic_figures, harmonic_limits
from percuss.paper.claims.certain import certain_run, enclosed
from percuss.paper.claims.comparisons import ROUNDING, WALL, apart, furthest
from percuss.paper.claims.harmonic_formulas import (
    ABOVE,
    BEFORE,
    EQ17,
    EQ18,
    EQ18_VELOCITY,
    EQ19,
    EQ19_GAIN,
    EQ20,
    EQ21,
    EQ22,
    EQ23,
    REST,
    SINE,
    A,
    G,
    V,
    amplitude_steps,
    bound_steps,
    end_steps,
    form_steps,
    gain_steps,
    j,
    joined,
    k,
    n,
    positive_even,
    positive_odd,
    s,
    t,
)
from percuss.paper.evidence import Comparison, Deduction, Step, compare
from percuss.paper.formula import Formula, mathtext
from percuss.paper.proof import identity, leading_terms, positive, theorem
from percuss.paper.statement import Finding, Statement

THEORY = "paper-harmonics.md"
EVEN = (2, 4, 6, 8, 20)
ODD = (3, 5, 7, 9, 15)
FLIGHTS = 40
# A velocity above V_max of every odd n.
STEADY = Rational(1)
# What forty flights round, each a few times, at speeds below 60.
ROUNDED = 1e-12
# Of V_max, at which a second flight is looked at.
PARTS = (0.05, 0.5, 0.95)


@cache
def _run(number: int) -> Trajectory:
    """Return forty flights under sin(n t), for odd n from just above V_max(n)."""
    v0 = 1.01 * harmonic_critical_velocity(number) if number % 2 else 0.1
    return simulate(WALL, sine(number), v0=v0, t_end=(FLIGHTS + 0.5) * math.pi)


def _impacts(number: int, v0: float, count: int) -> Trajectory:
    return simulate(WALL, sine(number), v0=v0, max_impacts=count)


def _eigenset(count: int) -> Floats:
    return np.asarray(math.pi * np.arange(1, count + 1), dtype=np.float64)


def _velocity(run: Trajectory, flight: int) -> float:
    return float(run.impacts.v_after[flight - 1]) if flight else run.v0


def _small(what: str, value: float) -> Comparison:
    """Return the comparison of a simulated difference with zero."""
    return compare(what, value, 0.0, ROUNDING, error=ROUNDED)


def _worst(numbers: Iterable[int], error: Callable[[int, Trajectory, int], float]) -> float:
    """Return the largest error of a formula over numbers n and flights k."""
    return max(abs(error(one, _run(one), flight)) for one in numbers for flight in range(1, 40))


def _off_form(
    numbers: tuple[int, ...], x: Formula, velocity: Formula, amplitude: Formula
) -> Finding:
    """Compare simulated motions with the form and an amplitude, flight by flight."""
    times = np.linspace(0.0, (FLIGHTS + 0.4) * math.pi, 4001)
    inner = np.abs(times / math.pi - np.round(times / math.pi)) > 1e-6
    flights = np.floor(times / math.pi).astype(int)
    size, place, slope = amplitude.side(V, n, k), x.side(A, n, t), velocity.side(A, n, t)
    in_x, in_v = [], []
    for one in numbers:
        at, v = _run(one)(times)
        each = [size(_velocity(_run(one), f), one, f) for f in range(FLIGHTS + 1)]
        a = np.array(each)[flights]
        in_x.append(apart(at, place(a, one, times)))
        in_v.append(apart(v[inner], slope(a[inner], one, times[inner])))
    which = ", ".join(map(str, numbers))
    # The slope of x next to an impact times the rounding of the instant.
    return Finding(
        (
            _small(f"x of simulated motions minus the form, n = {which}", max(in_x)),
            compare(f"the same for x', n = {which}", max(in_v), 0.0, 1e-9, error=1e-11),
        )
    )


def _periods(even: sympy.Expr = pi, odd: sympy.Expr = 2 * pi) -> Finding:
    """Deduce the common periods of force and eigenset, and that motions on it exist."""
    force = sin(n * t)

    def returns(parity: int, period: sympy.Expr, sign: int) -> Step:
        words = f"n {'odd' if parity else 'even'}: after {period} the force is "
        words += "the same" if sign > 0 else "reversed, so that pi is no period"
        number = 2 * j + parity
        return identity(
            words, force.subs(t, t + period).subs(n, number), sign * force.subs(n, number)
        )

    steps = (
        returns(0, even, 1),
        returns(1, odd, 1),
        returns(1, odd / 2, -1),
        *form_steps(),
        *amplitude_steps(EQ19, odd=0),
        *amplitude_steps(EQ20, odd=1),
        *bound_steps(),
        *positive_even(),
        *positive_odd(),
    )
    off = {one: furthest(_run(one), _eigenset(FLIGHTS)) for one in (*EVEN, *ODD)}
    return Finding(
        (
            Deduction(
                "motions on the eigenset, and the period that it shares with the force", steps
            ),
            *(_small(f"n = {one}: impacts minus the eigenset, furthest", off[one]) for one in off),
        ),
        study=motion_text(_run(2)),
    )


def _even_form(x: Formula = EQ18, velocity: Formula = EQ18_VELOCITY) -> Finding:
    steps = (*form_steps(x, velocity), *amplitude_steps(EQ19, odd=0), *bound_steps())
    return Finding(
        (
            Deduction("(18) on every flight", (*steps, *positive_even())),
            *_off_form(EVEN, x, velocity, EQ19).printed,
        ),
        study=motion_text(_run(2)),
    )


def _even_amplitudes(amplitude: Formula = EQ19, gain: Formula = EQ19_GAIN) -> Finding:
    size, next_one = amplitude.side(V, n, k), gain.side(BEFORE, n)

    def in_amplitude(one: int, run: Trajectory, flight: int) -> float:
        middle = (flight + 0.5) * math.pi
        expected = EQ18.side(A, n, t)(size(_velocity(run, flight), one, flight), one, middle)
        return float(run(middle)[0]) - float(expected)

    def in_gain(one: int, run: Trajectory, flight: int) -> float:
        return _velocity(run, flight) - float(next_one(_velocity(run, flight - 1), one))

    steps = (
        *form_steps(),
        *amplitude_steps(amplitude, odd=0),
        *gain_steps(amplitude, gain, odd=0),
        *bound_steps(),
        *positive_even(),
        theorem(
            "So if the impact k - 1 is at (k-1) pi the next is at k pi, with this V_k: by induction "
            "all are."
        ),
    )
    return Finding(
        (
            Deduction("(19) on every flight", steps),
            _small("x in the middle of flights minus (18) with A_k", _worst(EVEN, in_amplitude)),
            _small("V_k minus that of (19)", _worst(EVEN, in_gain)),
        ),
        study=motion_text(_run(2)),
    )


def _twelve_flights(number: int, v0: float) -> Trajectory:
    return simulate(WALL, sine(number), v0=v0, t_end=12.5 * math.pi)


def _every_velocity(amplitude: Formula = EQ19) -> Finding:
    """Deduce that no V0 >= 0 gives an extra root; start from rest and from many velocities."""
    kept = [
        furthest(_twelve_flights(one, v0), _eigenset(12))
        for one in (2, 4, 6, 8, 20, 100)
        for v0 in (0.0, 1e-6, 0.01, 0.5, 10.0)
    ]
    steps = (
        *bound_steps(),
        *positive_even(amplitude),
        *gain_steps(EQ19, EQ19_GAIN, odd=0),
    )
    return Finding(
        (
            Deduction("no extra root for any V0 >= 0", steps),
            _small("t_k minus pi k, n = 2 to 100, V0 = 0 to 10", max(kept)),
        ),
        remark="From V0 = 0 the force lifts the mass off.",
        study=motion_text(_twelve_flights(2, 0.0)),
    )


def _decrease(law: sympy.Expr = 2 / n) -> Finding:
    e = sympy.Symbol("epsilon", positive=True)
    gain = 2 * G
    simulated = {one: _velocity(_run(one), 2) - _velocity(_run(one), 1) for one in (4, 20)}
    steps = (
        leading_terms(
            "With e = 1/n the increment begins", gain.subs(n, 1 / e), e, 3, law.subs(n, 1 / e)
        ),
        identity(
            "and its derivative in n is negative",
            sympy.diff(gain.subs(n, t), t).subs(t, n),
            -2 * (n**2 + 1) / (n**2 - 1) ** 2,
        ),
    )
    return Finding(
        (
            Deduction("the increment of (19) falls, and tends to 2/n", steps),
            *(
                _small(
                    f"n = {one}: simulated increment minus that of (19)",
                    value - 2 * one / (one**2 - 1),
                )
                for one, value in simulated.items()
            ),
        ),
        remark="For small n it is larger than 2/n: 4/3 for n = 2, where 2/n is 1.",
        study=motion_text(_run(4)),
    )


def _odd_form(amplitude: Formula = EQ20) -> Finding:
    steps = (
        *form_steps(),
        *amplitude_steps(amplitude, odd=1),
        *bound_steps(),
        *positive_odd(amplitude),
    )
    return Finding(
        (
            Deduction("(20) on every flight", steps),
            *_off_form(ODD, EQ18, EQ18_VELOCITY, amplitude).printed,
        ),
        study=motion_text(_run(3)),
    )


def _steady(same: Formula = EQ21) -> Finding:
    """Deduce that the velocity is kept, and start at other phases of the force as well."""
    late = []
    for one in ODD:
        v0 = 3.0 * harmonic_critical_velocity(one)
        run = simulate(WALL, sine(one), v0=v0, t0=0.3, t_end=60.0)
        late.append(apart(run.impacts.v_after, np.full(len(run.impacts), v0)))
        late.append(apart(np.diff(run.impacts.t), np.full(len(run.impacts) - 1, math.pi)))

    def in_gain(_: int, run: Trajectory, flight: int) -> float:
        return _velocity(run, flight) - _velocity(run, flight - 1)

    steps = (*form_steps(), *amplitude_steps(EQ20, odd=1), *gain_steps(EQ20, same, odd=1))
    return Finding(
        (
            Deduction("the velocity is kept", steps),
            _small("V_k - V_(k-1), n = 3 to 9, 15", _worst(ODD, in_gain)),
            _small("the same for starts at t = 0.3: V_k and the gaps", max(late)),
        ),
        remark="For odd n the response to the force changes its sign in pi, so a steady motion "
        "with gaps pi starts at every phase of the force, not at t = 0 alone.",
        study=motion_text(_run(3)),
    )


def _first_flight(formula: Formula = EQ22) -> Finding:
    """Deduce that (22) has no root, and look for impacts on the first flight."""
    firsts = [
        float(_impacts(one, part, 1).impacts.t[0])
        for one in ODD
        for part in (1e-4, 1e-2, 0.1, 0.3, 1.0)
    ]
    left = formula.printed.lhs
    steps = (
        identity(
            "(22) is x of (20) for even k",
            EQ18.printed.rhs.subs(A, EQ20.printed.rhs.subs(k, 2 * k)),
            left,
        ),
        identity(
            "it is V sin t and a rest", left, V * sin(t) + (n * sin(t) - sin(n * t)) / (n**2 - 1)
        ),
        *bound_steps(),
        positive("so it is positive for V > 0 where sin t > 0:", ABOVE * SINE + REST),
    )
    gaps = apart(np.array(firsts), np.full(len(firsts), math.pi))
    return Finding(
        (
            Deduction("(22) has no root", steps),
            _small("first impact minus pi, n = 3 to 9, 15, V0 = 1e-4 to 1", gaps),
        ),
        study=motion_text(_impacts(3, 0.1, 1)),
    )


def _second_flight(formula: Formula = EQ23) -> Finding:
    """Deduce (23) and that it has roots, and look for impacts on the second flight below V_max."""
    left = formula.printed.lhs
    limit = (n - sin(n * s) / sin(s)) / (n**2 - 1)
    steps = (
        identity(
            "(23) is x of (20) for odd k",
            EQ18.printed.rhs.subs(A, EQ20.printed.rhs.subs(k, 2 * k + 1)),
            left,
        ),
        identity(
            "At t = (2p+1) pi + s, with odd n, it is sin s (V - W(s))",
            left.subs(n, 2 * j + 1).subs(t, s + pi * (2 * k + 1)),
            ((V - limit) * sin(s)).subs(n, 2 * j + 1),
        ),
        *bound_steps(),
        *end_steps(),
        theorem(
            "By the bound W is positive inside; it is continuous: it takes each value up to its "
            "largest, V_max (intermediate value theorem)"
        ),
    )
    early = [_early(one, part * harmonic_critical_velocity(one)) for one in ODD for part in PARTS]
    return Finding(
        (Deduction("(23) has a root for 0 < V <= V_max", steps), *early),
        study=motion_text(_impacts(3, PARTS[1] * harmonic_critical_velocity(3), 2)),
    )


def _early(number: int, v0: float) -> Comparison:
    """See whether the first impact is at pi and the second before 2 pi."""
    run = _impacts(number, v0, 2)
    what = f"n = {number}, V0 = {v0:.4f}: second impact over pi, between 1 and 2"
    proven = certain_run(run)
    turns = None if proven is None else proven.impacts.t.arbs[1] / arb.pi()
    return enclosed(what, turns, 1.0 + 1e-3, 2.0 - 1e-3)


def _not_sufficient(v0: Rational = STEADY, same: Formula = EQ21) -> Finding:
    """Deduce that for odd n a motion stays on the eigenset with a bounded velocity for ever."""
    growth = [
        apart(
            _impacts(one, float(v0), 1000).impacts.v_after,
            np.full(1000, float(v0)),
        )
        for one in ODD
    ]
    least = v0 - 2 * G.subs(n, 3)
    steps = (
        identity(
            "n odd: the force returns after 2 pi, two steps of the eigenset",
            sin((2 * j + 1) * (t + 2 * pi)),
            sin((2 * j + 1) * t),
        ),
        *amplitude_steps(EQ20, odd=1),
        *bound_steps(),
        *positive_odd(),
        Step(
            "V0 is above 2n/(n^2-1), which is largest for n = 3: no extra root",
            f"{mathtext(v0)} - \\frac{{3}}{{4}} > 0",
            bool(least > 0),
            "algebra",
        ),
        *gain_steps(EQ20, same, odd=1),
    )
    return Finding(
        (
            Deduction("bounded motions on the eigenset, for every odd n", steps),
            compare(
                f"V_k - V_0 in 1000 flights from V0 = {v0}, n = 3 to 9, 15",
                max(growth),
                0.0,
                ROUNDING,
                error=25 * ROUNDED,
            ),
        ),
        study=motion_text(_impacts(3, float(v0), 1000)),
    )


_of = partial(Statement, theory=THEORY)

OWN: tuple[Statement, ...] = (
    _of(
        id="eq17",
        reference="(17)",
        claim="Under sin(n t) motions with the eigenset as impact times exist; it shares the "
        "period pi with the force for even n, 2 pi for odd n.",
        formula=EQ17,
        method="periods of sine, and the forms (18) and (20); simulation of forty flights",
        find=_periods,
    ),
    _of(
        id="eq18",
        reference="(18)",
        claim="For even n the motion on each flight is A_k sin t - sin(nt)/(n^2-1).",
        formula=joined(EQ18, EQ18_VELOCITY),
        method="substitution into the equation; simulation of forty flights",
        find=_even_form,
    ),
    _of(
        id="eq19",
        reference="(19)",
        claim="For even n the velocity gains 2n/(n^2-1) at each impact: linear growth.",
        formula=joined(EQ19, EQ19_GAIN),
        method="velocities at both ends of a flight; simulation of forty flights",
        find=_even_amplitudes,
    ),
    _of(
        id="eq19-velocities",
        reference="(18), (19)",
        claim="For even n every V0 >= 0 gives this resonance.",
        method="bound of sin(nt)/sin(t); simulation from V0 = 0 to 10",
        find=_every_velocity,
    ),
    _of(
        id="eq19-increment",
        reference="section 4",
        claim="The velocity increment decreases with n, as 2/n.",
        method="series in 1/n, and simulated increments",
        find=_decrease,
    ),
    _of(
        id="eq20",
        reference="(20)",
        claim="For odd n the form is the same, with other amplitudes.",
        formula=EQ20,
        method="substitution into the equation; simulation of forty flights",
        find=_odd_form,
    ),
    _of(
        id="eq21",
        reference="(21)",
        claim="For odd n the impact velocity stays the same: steady oscillation.",
        formula=EQ21,
        method="velocities at both ends of a flight; simulation of forty flights",
        find=_steady,
    ),
    _of(
        id="eq22",
        reference="(22)",
        claim="For odd n and V > 0 there is no extra root on the flights (2p pi, (2p+1) pi).",
        formula=EQ22,
        method="bound of sin(nt)/sin(t); simulation from V0 = 1e-4 to 1",
        find=_first_flight,
    ),
    _of(
        id="eq23",
        reference="(23)",
        claim="Extra roots lie on the flights ((2p+1) pi, 2(p+1) pi), where (23) gives them.",
        formula=EQ23,
        method="values that the left side takes; second impacts of motions below V_max",
        find=_second_flight,
    ),
    _of(
        id="not-sufficient",
        reference="section 4",
        claim="That the eigenset and the force share a period does not suffice for a resonance.",
        method="steady motions for every odd n; simulation of 1000 flights",
        find=_not_sufficient,
    ),
)


STATEMENTS: tuple[Statement, ...] = (
    *OWN,
    *harmonic_limits.STATEMENTS,
    *harmonic_figures.STATEMENTS,
    *commensurate.STATEMENTS,
)
