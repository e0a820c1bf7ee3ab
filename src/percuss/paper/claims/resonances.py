"""Beyond the article: which frequencies resonate at all, for the elastic impact oscillator."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction

import numpy as np
import sympy
from sympy import cos, pi, sin

from percuss.io.study_text import motion_text
from percuss.paper.claims.bilinear_limit import local_orders
from percuss.paper.claims.comparisons import ROUNDING, WithError, agreement, extrapolated
from percuss.paper.claims.harmonic_formulas import bound_steps
from percuss.paper.evidence import Comparison, Deduction, Evidence, Measurement, Step, compare
from percuss.paper.models.averaging import averaged, mean_delays, order, strength, strengths_at
from percuss.paper.models.flight_series import energy_gain
from percuss.paper.models.resonance_runs import (
    AWAY,
    GROWS,
    Ensemble,
    deviation_power,
    energy_rates,
    ensemble,
    first_run,
    run_near_growing,
    run_of,
)
from percuss.paper.proof import identity
from percuss.paper.statement import Finding, Statement

BEYOND = "beyond the article"
THEORY = "resonances.md"

# One frequency 2 p / q for each order q whose strength is large; how many motions are followed
# for how many impacts: high orders grow late.
OF_ORDER = {
    1: (Fraction(2), 24, 20_000),
    2: (Fraction(1), 24, 20_000),
    3: (Fraction(2, 3), 48, 40_000),
    4: (Fraction(3, 2), 48, 40_000),
    5: (Fraction(4, 5), 48, 40_000),
}
# Close to the golden section and the root of 2, and the seventh order.
GOLDEN = Fraction("0.6180339887")
OTHERS = (GOLDEN, Fraction("1.4142135624"), Fraction(4, 7), Fraction(8, 7))
# Speed and number of impacts with which the growing phase is looked at.
NEAR_PHASE = {1: (50.0, 10_000), 2: (50.0, 20_000), 3: (50.0, 200_000), 4: (30.0, 200_000)}
# Between which fast starts lie.
SPEEDS = 8.0, 12.0
# Impacts of the motions that studies show.
SHOWN = 1000
# At which the parts of the averaged H are compared: far above the force's amplitude.
FAST = 1000.0

j, n = sympy.symbols("j n", integer=True, positive=True)
s, psi, V = sympy.symbols("s psi V", real=True)
SPEED = sympy.Symbol("V", positive=True)


def _even(printed: Callable[[int], float] = lambda n: 2 * n / (n * n - 1)) -> Finding:
    checks = []
    for n in (2, 4, 6):
        runs = ensemble(Fraction(n), 24, 10_000)
        checks.append(_all_grow(f"n = {n}", runs))
        # A motion that starts in the wrong phase loses V first, for as many impacts as it has V.
        early, late = (np.diff(runs.largest) / np.diff(runs.counts))[:, -2:].T
        what = f"n = {n}: growth an impact, furthest from 2n/(n^2-1)"
        away = WithError(float(np.abs(late - printed(n)).max()), float(np.abs(late - early).max()))
        checks.append(agreement(what, away, 0.0, 1e-3))
    return Finding(tuple(checks), study=motion_text(first_run(Fraction(2), SHOWN)))


def _all_grow(which: str, runs: Ensemble) -> Comparison:
    """Return the check that every motion of an ensemble grew in the last decade of impacts."""
    least = float(runs.late_growth().min())
    what = f"{which}: least growth in the last decade, of {len(runs.largest)} motions"
    return Measurement(what, least, GROWS, math.inf, ROUNDING * least)


def _half(rate: float = 0.5) -> Finding:
    runs = ensemble(*OF_ORDER[2])
    (earlier, slopes), predicted = energy_rates()
    away = WithError(
        float(np.abs(slopes - rate / 0.5 * predicted).max()), float(np.abs(slopes - earlier).max())
    )
    return Finding(
        (
            _exponent(2),
            _all_grow("omega = 1", runs),
            # What is left out is of the order of 1 / V, and V is 70 in the middle.
            agreement("rate of V^2, furthest from |sin 2 psi| / 2", away, 0.0, 0.01),
        ),
        remark=(
            f"Between {slopes.min():.3f} and {slopes.max():.3f} in {len(slopes)} motions: the phase "
            "psi in which a motion leaves low speeds stays, so the factor of the square root is "
            "not universal; 1/sqrt(2) for V is the most."
        ),
        study=motion_text(first_run(OF_ORDER[2][0], SHOWN)),
    )


def _odd(kept: sympy.Expr = V) -> Finding:
    """Deduce that fast flights last pi and keep their speed, and follow some, and slow starts."""
    response = 1 / (1 - n**2)
    x = (V + n * response * sin(psi)) * sin(s) + response * (cos(psi + n * s) - cos(psi) * cos(s))
    number = 2 * j + 1
    rest = cos(psi) * (cos(n * s) - cos(s)) + sin(psi) * (n * sin(s) - sin(n * s))
    steps = (
        identity(
            "The flight from the phase psi with V obeys the equation,",
            x.diff(s, 2) + x,
            cos(psi + n * s),
        ),
        identity("begins at the wall", x.subs(s, 0), sympy.Integer(0)),
        identity("with V,", x.diff(s).subs(s, 0), V),
        identity("is there after pi", x.subs(n, number).subs(s, pi), sympy.Integer(0)),
        identity(
            "with -V, so that it begins anew with V", -x.subs(n, number).diff(s).subs(s, pi), kept
        ),
        identity("It is V sin s and a rest,", x, V * sin(s) + response * rest),
        identity(
            "where cos ns - cos s is a product,",
            (cos(n * s) - cos(s)).subs(n, number),
            -2 * sin((j + 1) * s) * sin(j * s),
        ),
        *bound_steps(),
        identity(
            "so that the rest is at most (2j + 2n)/(n^2-1) sin s, n = 2j + 1; sin s exceeds this by "
            "the following times sin s, not negative for n >= 3: no root inside for V > 1.",
            (1 - (n - 1 + 2 * n) / (n**2 - 1)),
            n * (n - 3) / (n**2 - 1),
        ),
        identity(
            "A flight run backwards is a flight under such a force: none that begins below a speed "
            "V > 1 ends at V or above.",
            cos(psi + number * (pi - s)),
            cos(number * s - psi - number * pi),
        ),
    )
    evidence: list[Evidence] = [Deduction("no growth for odd n >= 3, in any phase", steps)]
    for one in (3, 5, 7):
        changes, delays = [], []
        for phase in np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False):
            hits = run_of(Fraction(one), float(phase), 2.0, 1000).impacts
            changes.append(float(np.abs(hits.v_after - 2.0).max()))
            delays.append(float(np.abs(hits.intervals - math.pi).max()))
        for what, worst in (
            ("change of V = 2 in 1000 impacts, 12 phases", max(changes)),
            ("difference of a flight from pi", max(delays)),
        ):
            evidence.append(compare(f"n = {one}: {what}", worst, 0.0, ROUNDING, error=1e-11))
        largest = float(ensemble(Fraction(one), 24, 10_000).largest.max())
        what = f"n = {one}: largest speed of 24 starts with V < 2, 10,000 impacts"
        evidence.append(Measurement(what, largest, 0.0, 2.0, ROUNDING))
    return Finding(
        tuple(evidence),
        study=motion_text(run_of(Fraction(3), 0.0, 2.0, SHOWN)),
    )


def _exponent(q: int) -> Comparison:
    value, error = ensemble(*OF_ORDER[q]).exponent("typical")
    # Three standard errors; a finite run leaves slower terms besides.
    exponent = WithError(value, 3.0 * error)
    return agreement(f"q = {q}: exponent of the typical speed", exponent, 1.0 / q, 0.01)


def _gain_step(q: int, less: int) -> Step:
    """Return the step that the energy gained in q flights begins with V^(less - q) sin(q psi)."""
    omega = OF_ORDER[q][0]
    gains = energy_gain(omega)
    formula = rf"E_{{k+{q}}} - E_k = {gains.size:.6g}\,V^{{{-gains.power}}}\,\sin({q}\,\psi)"
    return Step(
        f"omega = {omega}: all higher powers of V vanish in {q} flights, and this one has the "
        "waves "
        f"exp({q} i psi), exp(-{q} i psi) alone (up to the origin of psi)",
        formula,
        gains.power == q - less and gains.waves == (-q, q) and gains.size > 0.0,
        "algebra",
    )


def _orders(less: int = 2) -> Finding:
    """Deduce the order of the gain, and measure how many slow starts grow."""
    power = sympy.Symbol("q", positive=True)
    steps = (
        *(_gain_step(q, less) for q in OF_ORDER),
        identity(
            "V^q then changes at a rate that depends on psi alone at leading order: by the gain of "
            "energy, of the order V^(2-q), times",
            sympy.diff(SPEED**power, SPEED) / sympy.diff(SPEED**2 / 2, SPEED),
            power * SPEED ** (power - 2),
        ),
    )
    remarks, shares = [], []
    for q, followed in OF_ORDER.items():
        runs = ensemble(*followed)
        shares.append(f"{runs.share_growing():.2f} of {followed[1]} for q = {q}")
        typical, largest = runs.exponent("typical"), runs.exponent("largest")
        remarks.append(
            f"q = {q}: typical {typical[0]:.3f} +- {typical[1]:.3f}, largest "
            f"{largest[0]:.3f} +- {largest[1]:.3f}"
        )
    return Finding(
        (Deduction("the gain in q flights is of the order V^(2-q)", steps),),
        remark="For q >= 3 no steady growth follows: the best phase repels, so that almost all "
        "motions fall back and grow again, and some starts stay bounded. Of the slow starts that "
        "were followed these grew by 1.3 in the last decade of impacts: "
        f"{', '.join(shares)}. Exponents of the speeds in time, medians over the starts: "
        f"{'; '.join(remarks)}. For q >= 4 their errors do not part neighbouring orders.",
        study=motion_text(first_run(OF_ORDER[3][0], SHOWN)),
    )


def _strengths(factor: float = 1.0) -> Finding:
    checks = []
    for text in ("2", "4", "1", "2/3", "4/3", "8/3", "1/2", "3/2", "5/2"):
        omega = Fraction(text)
        p, q = order(omega)
        # What H gives in q flights, 2 pi p each q-th part of them.
        derived = energy_gain(omega).size / (2.0 * math.pi * p * q)
        ratio = factor * abs(strength(omega)) / derived
        what = f"omega = {omega}: the closed form over the exact series of {q} flights"
        checks.append(compare(what, ratio, 1.0, 1e-12, error=1e-14))
        what = f"omega = {omega}: measured on flights at three speeds, over the closed form"
        # What is left out is of relative order speed^-2.
        shown = [one / strength(omega) for one in strengths_at(omega, (10.0, 20.0, 40.0))]
        checks.append(agreement(what, extrapolated(shown, 4.0), 1.0, 1e-4))
    return Finding(tuple(checks))


def _phases(less: float = 2.0) -> Finding:
    checks = []
    for q, (speed, impacts) in NEAR_PHASE.items():
        powers = [deviation_power(OF_ORDER[q][0], v * speed, impacts) for v in (1.0, 2.0, 4.0)]
        # What averaging leaves out is of relative order 1 / V: it halves, and is removed.
        power = extrapolated(powers, 2.0)
        checks.append(agreement(f"q = {q}: power of V in the deviation", power, q - less, 0.02))
    speed, _ = NEAR_PHASE[3]
    run = run_near_growing(OF_ORDER[3][0], speed, AWAY, SHOWN)
    return Finding(tuple(checks), study=motion_text(run))


def _weight(m: int, low: float, high: float) -> Comparison:
    """Return the part of H that depends on the phase at omega = 2/m, over what bounds growth."""
    weight = averaged(Fraction(2, m))
    if weight.q <= 4:
        # There is no part without the phase of the same order: what is left must not vanish.
        what = f"m = {m}: |h_q| of the resonance in q = {weight.q} flights, above 0"
        return Measurement(what, abs(weight.strength), min(low, 1e-3), high, 1e-5)
    ratio = abs(weight.strength) * FAST ** (6 - weight.q) / abs(weight.twist)
    what = f"m = {m}: force that depends on the phase over that which does not, V = {FAST:g}"
    return Measurement(what, ratio, low, high, 0.02 * ratio)


def _twist(power: float = -6.0) -> Finding:
    speeds = np.array([10.0, 20.0, 40.0, 80.0])
    checks = []
    for omega in (GOLDEN, OTHERS[1]):
        orders = local_orders(speeds, mean_delays(float(omega), speeds)).tolist()
        # The next term is smaller by 1 / V: it halves, and is removed.
        what = f"omega = {float(omega):.4f}: power of V"
        checks.append(agreement(what, extrapolated(orders, 2.0), power, 0.1))
    return Finding(tuple(checks))


def _subharmonics(closed: tuple[int, ...] = (7, 8, 9)) -> Finding:
    """See for which m fast motions may grow: where the phase outweighs what bounds growth."""
    all_m = range(2, 10)
    printed = tuple(_weight(m, 1.0, math.inf) for m in all_m)
    corrected = (
        *(_weight(m, 1.0, math.inf) for m in all_m if m not in closed),
        *(_weight(m, 0.0, 1.0) for m in closed),
        *(_held(Fraction(2, m)) for m in closed),
    )
    speeds = ", ".join(f"{averaged(Fraction(2, m)).balance:.1f} for m = {m}" for m in closed)
    return Finding(
        printed,
        corrected,
        "only for m <= 6; from m = 7 on, fast motions stay near their speed",
        remark="From m = 7 on the length of a fast flight depends on its speed more strongly than "
        f"the force can make use of, above V = {speeds}.",
        study=motion_text(first_run(Fraction(2, closed[0]), SHOWN, *SPEEDS)),
    )


def _only_subharmonic(others: tuple[str, ...] = ("4/3", "3/2", "4/5")) -> Finding:
    """Look for resonances off the eigenset whose frequency is no part 2/m of the resonant one."""
    evidence: list[Evidence] = []
    for text in others:
        omega = Fraction(text)
        gain = energy_gain(omega)
        q = order(omega)[1]
        runs = ensemble(omega, 48, 40_000)
        share = runs.share_growing()
        error = math.sqrt(share * (1.0 - share) / 48)
        what = f"omega = {text}: share of 48 slow starts that grew by 1.3 in the last decade"
        evidence.append(Measurement(what, share, 0.0, 0.1, error))
        what = f"omega = {text}: energy gained in {q} flights, over V^(2-q), in the best phase"
        evidence.append(Measurement(what, gain.size, -1e-9, 1e-9, 1e-12))
    are_there = any(item.outcome == "differs" for item in evidence)
    return Finding(
        tuple(evidence),
        undecided=(
            "the article does not say whether it speaks of all resonances off the eigenset, which "
            "is wrong, or announces those of its section 5, which are sub-harmonic"
            if are_there
            else ""
        ),
        remark=f"There are resonances at {', '.join(others)}, which are no parts 2/m of the resonant "
        "frequency."
        if are_there
        else "",
        study=motion_text(first_run(Fraction(others[0]), SHOWN)),
    )


def _held(omega: Fraction) -> Comparison:
    growth = _late_growth(omega)
    return agreement(f"omega = {omega}: late growth of fast starts, largest", growth, 1.0, 0.02)


def _late_growth(omega: Fraction) -> WithError:
    """Return the most by which starts between V = 8 and 12 pass their maximum over 2000 impacts.

    It hangs on the starts: its error is the distance of the second largest of the eight.
    """
    runs = ensemble(omega, 8, 40_000, *SPEEDS)
    early = int(np.searchsorted(runs.counts, 2_000))
    second, most = np.sort(runs.largest[:, -1] / runs.largest[:, early])[-2:]
    return WithError(float(most), float(most - second))


def _others(frequencies: tuple[Fraction, ...] = OTHERS) -> Finding:
    motions = [_held(omega) for omega in frequencies]
    third = _late_growth(Fraction(2, 3))
    what = "omega = 2/3, for comparison: late growth of fast starts, largest"
    motions.append(Measurement(what, third.value, GROWS, math.inf, third.error))
    balance = ", ".join(
        f"{averaged(omega).balance:.3g} for omega = {omega}"
        for omega in (Fraction(4, 7), Fraction(8, 7), Fraction(7, 4), Fraction(12, 7))
    )
    return Finding(
        tuple(motions),
        remark=(
            f"omega = 2/3 grows by {third.value:.2f}. From this speed on the length of a flight depends on the speed more "
            f"strongly than on the phase: {balance}: near a strong resonance slow motions grow for very long."
        ),
        study=motion_text(first_run(frequencies[0], SHOWN, *SPEEDS)),
    )


STATEMENTS = (
    Statement(
        id="resonance-even",
        reference=BEYOND,
        scope="beyond",
        claim="For even n every motion grows, in every phase of the force, at the rate of (19).",
        method="24 motions each for n = 2, 4, 6, with random phases and slow starts.",
        find=_even,
        formula=r"V_{k+1} - V_k \to 2n/(n^2-1)",
        theory=THEORY,
    ),
    Statement(
        id="resonance-half",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "At omega = 1 a motion grows as the square root of time, with a factor that depends on "
            "the phase psi in which it leaves low speeds; only where sin 2 psi = 0, as under cos t "
            "from the wall at t = 0, it does not grow."
        ),
        method="Second-order averaging, held against 16 motions.",
        find=_half,
        formula=r"V^2 \sim \frac{1}{2}|\sin 2\psi|\,t",
        theory=THEORY,
    ),
    Statement(
        id="resonance-odd",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "For odd n >= 3 no motion grows, in any phase of the force: fast flights last pi and "
            "return the speed they began with."
        ),
        method="Closed form of a flight and its bound; 12 phases at V = 2, and 24 slow starts.",
        find=_odd,
        formula=r"V_{k+1} = V_k,\ t_{k+1} = t_k + \pi",
        theory="paper-oscillator.md",
    ),
    Statement(
        id="resonance-order",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "At omega = 2p/q the energy gained in q fast flights is of the order V^(2-q), a "
            "multiple of sin(q psi): at omega = 2, 1, 2/3, 3/2, 4/5 for q = 1 to 5. So V^q changes "
            "at a rate that depends on the phase alone."
        ),
        method="Exact series of q flights in 1/V.",
        find=_orders,
        formula=r"E_{k+q} - E_k = c\,V^{2-q}\,\sin(q\,\psi) + O(V^{1-q})",
        theory=THEORY,
    ),
    Statement(
        id="resonance-strength",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "At omega = 2p/q the averaged motion of psi and V^2/2 has the Hamiltonian H = V^(2-q) "
            "h_q cos(q psi), with h_q = K/pi, 1/8, K^3 (1-omega^2)/(12 pi), K^4 omega (1-omega^2) "
            "tan(pi omega/2)/(24 pi) for q = 1, 2, 3, 4."
        ),
        method="Exact series of q flights in 1/V; q flights in a row at three speeds.",
        find=_strengths,
        formula=r"H = V^{2-q}\,h_q\cos q\psi,\ K = 2\cos(\pi\omega/2)/(1-\omega^2)",
        theory=THEORY,
    ),
    Statement(
        id="resonance-phase",
        reference=BEYOND,
        scope="beyond",
        claim="The growing phase attracts for q = 1, is neutral for q = 2 and repels for q > 2.",
        method="Two motions on either side of it: their distance as a power of V.",
        find=_phases,
        formula=r"\delta\psi \propto V^{q-2}",
        theory=THEORY,
    ),
    Statement(
        id="resonance-twist",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "Away from ratios 2p/q of small numbers the mean time of a fast flight differs from "
            "pi by "
            "V^(-6): no lower power has a part that does not depend on the phase."
        ),
        method="Weighted average over 2000 flights at four speeds.",
        find=_twist,
        formula=r"\overline{t_{k+1}-t_k} - \pi \propto V^{-6}",
        theory=THEORY,
    ),
    Statement(
        id="resonance-subharmonics",
        reference="section 1, (2)",
        claim="There are sub-harmonic resonances at W_r / m (impact oscillator, undamped; for "
        "any m).",
        method="Averaging up to the order at which the dependence of flight times on the speed "
        "bounds the growth; ensembles of fast "
        "starts.",
        find=_subharmonics,
        formula=r"\omega = 2/m",
        theory=THEORY,
    ),
    Statement(
        id="subharmonic-only",
        reference="section 4",
        claim="The resonances that are not associated with the eigenset are sub-harmonic.",
        method="Exact series of q flights, and ensembles of slow starts, at 4/3, 3/2 and 4/5.",
        find=_only_subharmonic,
        formula=r"\omega = 2/m",
        theory=THEORY,
    ),
    Statement(
        id="resonance-others",
        reference=BEYOND,
        scope="beyond",
        claim="At frequencies that are no ratio 2p/q with q <= 6, motions above some speed do "
        "not grow.",
        method="8 motions each between V = 8 and 12: growth from 2,000 to 40,000 impacts.",
        find=_others,
        formula="",
        theory=THEORY,
    ),
)
