"""Beyond the paper: which frequencies resonate at all, for the elastic impact oscillator."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from percuss.paper.claims.bilinear_limit import local_orders
from percuss.paper.claims.certain import certain_condition
from percuss.paper.claims.certain_flights import all_flights_last_pi
from percuss.paper.claims.evidence import ROUNDING, condition, near
from percuss.paper.models.averaging import averaged, mean_delays, strength
from percuss.paper.models.resonance_runs import deviation_power, energy_rates, ensemble, run_of
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["GOLDEN", "OF_ORDER", "OTHERS", "STATEMENTS"]

BEYOND = "beyond the paper"
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
# At which the parts of the averaged H are compared: far above the force's amplitude.
FAST = 1000.0


def _even() -> Finding:
    found = []
    for n in (2, 4, 6):
        runs = ensemble(Fraction(n), 24, 10_000)
        found.append(near(f"n = {n}: share of motions that grow", runs.share_growing(), 1.0, 0.0))
        # A motion that starts in the wrong phase loses V first, for as many impacts as it has V.
        each = runs.largest[:, -1] / 10_000
        apart = float(np.abs(each - 2 * n / (n * n - 1)).max())
        found.append(near(f"n = {n}: growth an impact, furthest from 2n/(n^2-1)", apart, 0.0, 1e-3))
    return Finding(tuple(found))


def _half() -> Finding:
    runs = ensemble(*OF_ORDER[2])
    slopes, predicted = energy_rates()
    apart = float(np.abs(np.subtract(slopes, predicted)).max())
    return Finding(
        (
            _exponent(2),
            near("share of motions that grow", runs.share_growing(), 1.0, 0.0),
            # What is left out is of the order of 1 / V, and V is 70 in the middle.
            near("rate of V^2, furthest from |sin 2 psi| / 2", apart, 0.0, 0.01),
        ),
        remark=(
            f"Between {min(slopes):.3f} and {max(slopes):.3f} in {len(slopes)} motions: the phase "
            "psi in which a motion leaves low speeds stays, so the factor of the square root is "
            "not universal; 1/sqrt(2) for V is the most."
        ),
    )


def _odd() -> Finding:
    found = []
    for n in (3, 5, 7):
        changes, delays = [], []
        for phase in np.linspace(0.0, 2.0 * math.pi, 12, endpoint=False):
            hits = run_of(Fraction(n), float(phase), 2.0, 1000).impacts
            changes.append(float(np.abs(hits.v_after - 2.0).max()))
            delays.append(float(np.abs(hits.intervals - math.pi).max()))
        # With proof: of all phases, and of all impacts.
        proven = all_flights_last_pi(n, "2")
        for what, worst in (
            ("change of V = 2 in 1000 impacts, any phase", max(changes)),
            ("difference of a flight from pi", max(delays)),
        ):
            name = f"n = {n}: {what}"
            found.append(Check(name, 0.0, 0.0, ROUNDING, 0.0) if proven else near(name, worst))
        runs = ensemble(Fraction(n), 24, 10_000)
        below = bool(runs.largest.max() <= 2.0)
        found.append(certain_condition(f"n = {n}: no slow start passes V = 2", below, proven))
    return Finding(
        tuple(found),
        remark="Flights from V = 2 last pi from every phase, so all faster ones do; as flights can "
        "be run backwards, none that began more slowly ends with V = 2 or more.",
    )


def _exponent(q: int) -> Check:
    exponent = ensemble(*OF_ORDER[q]).exponent("typical")
    # Three standard errors, and what a finite run leaves of slower terms where there is no error.
    tolerance = max(3.0 * exponent.error, 0.01)
    return near(f"q = {q}: exponent of the typical speed", exponent.value, 1.0 / q, tolerance)


def _orders() -> Finding:
    remarks = []
    for q, followed in OF_ORDER.items():
        runs = ensemble(*followed)
        typical, largest = runs.exponent("typical"), runs.exponent("largest")
        remarks.append(
            f"q = {q}: typical {typical.value:.3f} +- {typical.error:.3f}, largest "
            f"{largest.value:.3f} +- {largest.error:.3f}, {runs.share_growing():.0%} grew by 1.3 in "
            "the last decade"
        )
    return Finding(tuple(_exponent(q) for q in OF_ORDER), remark="; ".join(remarks) + ".")


def _strengths() -> Finding:
    found = []
    # What is left of higher orders falls as speed^-4, from 1e-4 at the lower speed.
    for omega in ("2", "4", "1", "2/3", "4/3", "8/3", "1/2", "3/2", "5/2"):
        exact, measured = strength(Fraction(omega)), averaged(Fraction(omega)).strength
        found.append(
            near(f"omega = {omega}: measured by the closed form", measured / exact, 1, 1e-4)
        )
    return Finding(tuple(found))


def _phases() -> Finding:
    found = []
    for q, (speed, impacts) in NEAR_PHASE.items():
        slow, fast = (deviation_power(OF_ORDER[q][0], v, impacts) for v in (speed, 2.0 * speed))
        # What averaging leaves out is of relative order 1 / V: it halves, and is removed.
        power = 2.0 * fast - slow
        found.append(near(f"q = {q}: power of V in the deviation", power, q - 2.0, 0.02))
    return Finding(tuple(found))


def _is_open(omega: Fraction) -> bool:
    """Return whether the phase outweighs the twist for fast motions, so that they may grow."""
    found = averaged(omega)
    if found.q <= 4:
        return abs(found.strength) > 1e-9
    return abs(found.strength) * FAST ** (6 - found.q) > abs(found.twist)


def _twist() -> Finding:
    speeds = np.array([10.0, 20.0, 40.0])
    found = []
    for omega in (GOLDEN, OTHERS[1]):
        first, last = local_orders(speeds, mean_delays(float(omega), speeds)).tolist()
        # The next term is smaller by 1 / V: it halves, and is removed.
        found.append(near(f"omega = {float(omega):.4f}: power of V", 2.0 * last - first, -6.0, 0.1))
    return Finding(tuple(found))


def _subharmonics() -> Finding:
    open_at = {m: _is_open(Fraction(2, m)) for m in range(2, 10)}
    printed = tuple(condition(f"m = {m}: fast motions may grow", open_at[m]) for m in open_at)
    closed = (7, 8, 9)
    corrected = (
        *(condition(f"m = {m}: fast motions may grow", open_at[m]) for m in range(2, 7)),
        *(condition(f"m = {m}: they may not", not open_at[m]) for m in closed),
        *(_held(Fraction(2, m)) for m in closed),
    )
    speeds = ", ".join(f"{averaged(Fraction(2, m)).balance:.1f} for m = {m}" for m in closed)
    return Finding(
        printed,
        corrected,
        "only for m <= 6; from m = 7 on, fast motions stay near their speed",
        remark=f"The twist outweighs the phase above V = {speeds}.",
    )


def _held(omega: Fraction) -> Check:
    growth = _late_growth(omega)
    return near(f"omega = {omega}: late growth of fast starts, largest", growth, 1.0, 0.02)


def _late_growth(omega: Fraction) -> float:
    """Return the most by which starts between V = 8 and 12 pass their maximum over 2000 impacts."""
    runs = ensemble(omega, 8, 40_000, 8.0, 12.0)
    early = int(np.searchsorted(runs.counts, 2_000))
    return float((runs.largest[:, -1] / runs.largest[:, early]).max())


def _others() -> Finding:
    found = [_held(omega) for omega in OTHERS]
    third = _late_growth(Fraction(2, 3))
    found.append(condition("omega = 2/3, for comparison, grows by 1.3", third > 1.3))
    balance = ", ".join(
        f"{averaged(omega).balance:.3g} for omega = {omega}"
        for omega in (Fraction(4, 7), Fraction(8, 7), Fraction(7, 4), Fraction(12, 7))
    )
    return Finding(
        tuple(found),
        remark=(
            f"omega = 2/3 grows by {third:.2f}. The speed above which the twist outweighs the "
            f"phase is {balance}: near a strong resonance slow motions grow for a very long time."
        ),
    )


STATEMENTS = (
    Statement(
        "resonance-even",
        BEYOND,
        "For even n every motion grows, in every phase of the force, at the rate of (19).",
        "24 motions each for n = 2, 4, 6, with random phases and slow starts.",
        "simulation of an ensemble",
        _even,
        r"V_{k+1} - V_k \to 2n/(n^2-1)",
        THEORY,
    ),
    Statement(
        "resonance-half",
        BEYOND,
        "At omega = 1 every motion grows as the square root of time, with a factor that depends on "
        "the phase in which it leaves low speeds.",
        "Second-order averaging, held against 16 motions.",
        "derived; simulation of an ensemble",
        _half,
        r"V^2 \sim \frac{1}{2}|\sin 2\psi|\,t",
        THEORY,
    ),
    Statement(
        "resonance-odd",
        BEYOND,
        "For odd n >= 3 no motion grows, in any phase of the force: fast flights last pi and "
        "return the speed they began with.",
        "Closed form of a flight; 12 phases at V = 2, and 24 slow starts.",
        "derived; simulation, 1e-10",
        _odd,
        r"V_{k+1} = V_k,\ t_{k+1} = t_k + \pi",
        "paper-oscillator.md",
        proven=True,
    ),
    Statement(
        "resonance-order",
        BEYOND,
        "At omega = 2p/q in lowest terms, q <= 5 and not an odd integer above 1, speeds grow as "
        "the q-th root of time.",
        "Median over an ensemble of the median speed of the last half of the impacts, fitted.",
        "statistical, three standard errors",
        _orders,
        r"V \sim t^{1/q}",
        THEORY,
    ),
    Statement(
        "resonance-strength",
        BEYOND,
        "The averaged force of order q has the strength K/pi, 1/8, K^3 (1-omega^2)/(12 pi), "
        "K^4 omega (1-omega^2) tan(pi omega/2)/(24 pi) for q = 1, 2, 3, 4.",
        "q flights in a row from the closed form, at two speeds, projected on sin(q psi).",
        "closed form; 4 digits measured here, more in the tests",
        _strengths,
        r"H = V^{2-q}\,h_q\cos q\psi,\ K = 2\cos(\pi\omega/2)/(1-\omega^2)",
        THEORY,
    ),
    Statement(
        "resonance-phase",
        BEYOND,
        "The growing phase attracts for q = 1, is neutral for q = 2 and repels for q > 2.",
        "Two motions on either side of it: their distance as a power of V.",
        "simulation, 1/V",
        _phases,
        r"\delta\psi \propto V^{q-2}",
        THEORY,
    ),
    Statement(
        "resonance-twist",
        BEYOND,
        "Away from ratios 2p/q of small numbers the mean time of a fast flight differs from pi by "
        "V^(-6): no lower power has a part that does not depend on the phase.",
        "Weighted average over 2000 flights at three speeds.",
        "closed form of a flight, averaged to rounding",
        _twist,
        r"\overline{t_{k+1}-t_k} - \pi \propto V^{-6}",
        THEORY,
    ),
    Statement(
        "resonance-subharmonics",
        "section 1, (2)",
        "There are sub-harmonic resonances at W_r / m (impact oscillator, undamped; for any m).",
        "Averaging up to the order where the twist bounds the growth; ensembles of fast starts.",
        "derived; coefficients measured to 1e-2; simulation of an ensemble",
        _subharmonics,
        r"\omega = 2/m",
        THEORY,
    ),
    Statement(
        "resonance-others",
        BEYOND,
        "At frequencies that are no ratio 2p/q with q <= 6, motions above some speed do not grow.",
        "8 motions each between V = 8 and 12: growth from 2,000 to 40,000 impacts.",
        "simulation of an ensemble",
        _others,
        "",
        THEORY,
    ),
)
