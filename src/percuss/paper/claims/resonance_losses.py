"""Beyond the article: the resonances with losses, restitution below 1 and damping above 0."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache, partial

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.certified import certify
from percuss.errors import ConvergenceError, ParameterError
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import cosine
from percuss.model.oscillator import Oscillator
from percuss.motion.simulate import simulate
from percuss.orbits.finding.find import find_orbit
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.paper.claims.bilinear_limit import local_orders
from percuss.paper.claims.certain import certain_run, enclosed, follows, in_ball
from percuss.paper.claims.comparisons import (
    DOUBLES,
    ROUNDING,
    WithError,
    agreement,
    extrapolated,
    last_of,
)
from percuss.paper.evidence import Comparison, Enclosure, Measurement
from percuss.paper.models.resonance_losses import (
    cycle_work,
    gain,
    half_peak,
    largest_speeds,
    lossy,
    lost_share,
    peak_and_width,
    peak_orbit,
    response,
    saddle_speed,
    single_impact_speed,
    stiff,
    stiff_resonance,
)
from percuss.paper.statement import Finding, Statement
from percuss.studies.kinds.response import Response
from percuss.studies.study import Study, study_text

BEYOND = "beyond the article"
THEORY = "resonances.md"

# Restitution and damping, as text: exact.
LOSSES = (("0.95", "0"), ("0.8", "0.05"), ("1", "0.05"))
EVEN = (2, 4, 6)
# One frequency 2p/q of each order above 2, and another of orders 3 and 4.
SADDLES = ("2/3", "4/3", "1/2", "3/2", "4/5")
SMALL = 1e-4
# Frequencies over a peak, five of its widths at 1/sqrt 2.
ACROSS = np.linspace(-2.5, 2.5, 41)
# Restitution of a metal on metal; which peaks it leaves.
REAL = 0.8
PROMINENT = 1.5
# Some ten impacts: the start of one of many motions, as ball arithmetic has it.
START_END = 40.0
NOT_PROVEN = Finding((), undecided=f"a motion is not proven up to t = {START_END:g}")
# How far from a peak the speeds are that it is to stand out from.
AROUND = np.concatenate([np.linspace(-0.2, -0.1, 9), np.linspace(0.1, 0.2, 9)])
# Of an orbit, in its study.
PERIODS = 20
# The largest loss, as a share of the speed, and damping, at which peaks are measured; then their
# half and their quarter.
LOST, DAMPED = 0.1, 0.02
PARTS = np.array([1.0, 0.5, 0.25])


def _chart(osc: Oscillator, omegas: Floats) -> str:
    """Return the study of the orbits with one impact a period over these frequencies."""
    low, high = float(omegas[0]), float(omegas[-1])
    question = Response(over={"forcing.omega": (low, high)}, max_impacts=1, max_periods=1)
    return study_text(Study(osc, cosine(0.5 * (low + high)), question))


@cache
def _orbit(n: int, omega: str, losses: tuple[str, str]) -> PeriodicOrbit:
    """Return the orbit with one impact in n/2 periods of the force."""
    restitution, damping = losses
    speed = float(single_impact_speed(float(omega), n // 2, float(restitution), float(damping)))
    osc, force = lossy(restitution, damping), cosine(omega)
    for cycle in np.arange(12) / 12.0:
        try:
            guess = cycle, float(restitution) * speed
            orbit = find_orbit(osc, force, 1, n // 2, guess=guess, formal=True)
        except ConvergenceError:
            continue
        # The same equations have a second solution, on the wrong side of the wall.
        if orbit.admissible:
            return orbit
    raise ParameterError("omega", omega, "no orbit with one impact is found")


def _curve(factor: float = 1.0) -> Finding:
    """Hold orbits on either side of each peak against the closed form of their speed."""
    checks = []
    for losses in LOSSES:
        for n in EVEN:
            for omega in (f"{n - 0.05:.2f}", str(n), f"{n + 0.05:.2f}"):
                checks += _held(n, omega, losses, factor)
    return Finding(
        tuple(checks),
        study=motion_text(_orbit(2, "2", LOSSES[1]).trajectory(PERIODS)),
    )


def _held(n: int, omega: str, losses: tuple[str, str], factor: float) -> list[Comparison]:
    restitution, damping = losses
    speed = float(single_impact_speed(float(omega), n // 2, float(restitution), float(damping)))
    expected = factor * speed
    orbit = _orbit(n, omega, losses)
    what = f"r = {restitution}, a = {damping}, omega = {omega}: velocity at the impact, by the form"
    largest = f"r = {restitution}, a = {damping}, omega = {omega}: modulus of the larger multiplier"
    proven = certify(orbit)
    is_proven = proven.exists and proven.admissible and proven.stability != "undecided"
    if not is_proven or not follows(orbit.impacts.v_before, proven.impacts.v_before):
        return [enclosed(what, None, -expected, -expected), enclosed(largest, None, 0.0, 1.0)]
    ball = max(proven.multipliers, key=lambda one: abs(one.mid()))
    return [
        in_ball(what, proven.impacts.v_before[0], -expected),
        Enclosure(largest, abs(ball.mid()), ball.radius() + 1e-15, 0.0, 1.0),
    ]


def _peaks(factor: float = 1.0) -> Finding:
    """Measure peaks of motions at three losses, and remove what falls with the loss."""
    checks = []
    for n in EVEN:
        for name, by_wall in (("r < 1", True), ("a > 0", False)):
            heights, widths = zip(
                *(_measured_peak(n, lost, by_wall) for lost in (LOST * PARTS).tolist()),
                strict=True,
            )
            for what, values in (("height", heights), ("width", widths)):
                limit = extrapolated(values, 2.0)
                checks.append(
                    agreement(f"n = {n}, {name}: {what} by the form", limit, factor, 5e-3)
                )
    return Finding(
        tuple(checks),
        remark="Measured at eps = 0.1, 0.05 and 0.025; what is of order eps is removed.",
        study=_chart(lossy(1.0 - LOST, 0.0), _across(EVEN[0], LOST)[1]),
    )


def _across(n: int, lost: float, damping: float = 0.0) -> tuple[float, Floats]:
    """Return the width of a peak by the form, and frequencies across it."""
    width = 2.0 * lost / math.pi
    return width, n * math.sqrt(1.0 - damping**2) + 0.5 * width * ACROSS


def _measured_peak(n: int, lost: float, by_wall: bool) -> tuple[float, float]:
    """Return height and width of a peak over those of the form, from motions."""
    restitution, damping = (1.0 - lost, 0.0) if by_wall else (1.0, _damping(lost))
    width, omegas = _across(n, lost, damping)
    expected = gain(n) / lost_share(restitution, damping)
    transient = int(14 / lost) * n // 2
    speeds = largest_speeds(lossy(restitution, damping), omegas, expected, transient)
    height, measured = peak_and_width(omegas, speeds)
    return height / expected, measured / width


def _damping(lost: float) -> float:
    """Return the damping that takes this share of the speed in a flight."""
    ratio = -numerics.log(1.0 - lost) / math.pi
    return ratio / math.sqrt(1.0 + ratio**2)


def _half(end: float = 0.125) -> Finding:
    """Follow the orbit of the half-harmonic at three losses."""
    losses = (0.05, 0.0125, 0.003125)
    peaks = [half_peak(lost) for lost in losses]
    above = [
        peak.height - saddle_speed(Fraction(1), lost)
        for peak, lost in zip(peaks, losses, strict=True)
    ]
    fast = [(peak.multipliers[1] - 1.0) / lost for peak, lost in zip(peaks, losses, strict=True)]
    slow = np.array([1.0 - peak.multipliers[0] for peak in peaks])
    ends = [half_peak(lost).end / lost**2 for lost in (0.05, 0.025, 0.0125)]
    (large, small, _), (one, other, _) = losses, peaks
    return Finding(
        (
            # What is left falls as the root of the loss: it halves, and is removed.
            agreement(
                "height less sqrt(pi/(4 eps))",
                extrapolated(above, 2.0),
                0.25 * math.pi / math.sqrt(2.0),
                0.02,
            ),
            # What is left falls as the loss here.
            agreement("end of the stable orbits over eps^2", extrapolated(ends, 2.0), end, 1e-3),
            agreement("multiplier of the speed", extrapolated(fast, 4.0), -4.0, 0.02),
            agreement(
                "multiplier of the phase: its order in eps",
                last_of(local_orders(np.array(losses), slow)),
                2.0,
                0.05,
            ),
            Measurement("which is below 1", other.multipliers[0], 0.0, 1.0, 1e-9),
        ),
        remark=(
            f"Its width at 1/sqrt 2 is {one.width / large**2:.2f} eps^2 at eps = {large:g} "
            f"and {other.width / small**2:.2f} eps^2 at {small:g}: {other.width:.1e}. A motion "
            f"needs some {1.0 / (1.0 - other.multipliers[0]):.0f} periods to find its phase at "
            "the latter. The height's leading part and "
            "the multiplier of the speed are derived, the others found from the numbers."
        ),
        study=motion_text(peak_orbit(Fraction(1), 1.0 - large).trajectory(PERIODS)),
    )


def _saddles(factor: float = 1.0) -> Finding:
    """Find the orbits on which gain and loss balance for orders above 2."""
    checks = []
    for text in SADDLES:
        omega = Fraction(text)
        q = omega.denominator if omega.numerator % 2 == 0 else 2 * omega.denominator
        lost = [SMALL / 2 ** (q * step) for step in range(3)]
        orbits = [peak_orbit(omega, 1.0 - share) for share in lost]
        speeds = [float(np.abs(orbit.impacts.v_before).max()) for orbit in orbits]
        # The speed doubles, but for what does not grow with it.
        balance = np.diff(speeds) / [saddle_speed(omega, share) for share in lost[:2]]
        what = f"omega = {omega}: speed by the balance"
        checks.append(agreement(what, last_of(balance), factor, 0.02))
        rates = [
            sorted((np.real(orbit.multipliers) - 1.0) / share)
            for orbit, share in zip(orbits, lost, strict=True)
        ]
        shrinking, growing = (last_of(column) for column in np.array(rates).T)
        tolerance = 0.01 * q * q
        what = f"omega = {omega}: (multiplier - 1)/eps"
        checks.append(agreement(f"{what} of the speed", shrinking, -q * q, tolerance))
        checks.append(agreement(f"{what} of the phase", growing, q * (q - 2), tolerance))
    return Finding(
        tuple(checks),
        remark="A multiplier above 1 repels: no motion settles at that speed, so no stable peak "
        "comes of these resonances.",
        study=motion_text(orbits[0].trajectory(PERIODS)),
    )


def prominence(restitution: float, damping: float, omega: float) -> float:
    """Return how far a peak stands out: the largest speed beside omega over that around.

    Examples
    --------
    >>> prominence(0.8, 0.0, 2.0) > 1.5
    True
    """
    inside = omega + 0.02 * np.linspace(-1.0, 1.0, 9)
    around = omega + AROUND
    osc = lossy(restitution, damping)
    starts = (0.0, 1.0, 2.5, 5.0)
    near_it, beside = (response(osc, omegas, starts)[0].max() for omegas in (inside, around))
    return float(near_it / beside)


def _survive(survivors: tuple[str, ...] = ("2", "4", "6")) -> Finding:
    """See which resonances stand out at a restitution of 0.8."""
    if certain_run(simulate(lossy(REAL, 0.0), cosine(2.0), v0=5.0, t_end=START_END)) is None:
        return NOT_PROVEN
    checks, words = [], []
    for text in ("2", "4", "6", "1", "2/3", "4/3", "1/2"):
        measured = prominence(REAL, 0.0, float(Fraction(text)))
        low, high = (PROMINENT, math.inf) if text in survivors else (0.0, PROMINENT)
        checks.append(
            Measurement(f"omega = {text}: prominence of the peak", measured, low, high, 1e-6)
        )
        words.append(f"{measured:.2f} at {text}")
    both = ", ".join(f"{prominence(0.6, 0.05, n):.2f} at {n:g}" for n in (2.0, 4.0, 6.0))
    wide = 2.0 * lost_share(0.6, 0.05) / math.pi
    return Finding(
        tuple(checks),
        remark=(
            "Prominence, the largest speed within 0.02 of the frequency over the largest at a "
            f"distance of 0.1 to 0.2: {', '.join(words)}. With r = 0.6 and a = 0.05 it is {both}: "
            f"peaks of the width 2 eps/pi = {wide:.2f} are hills no narrower than that."
        ),
        study=_chart(lossy(REAL, 0.0), 2.0 + AROUND),
    )


def _bilinear(factor: float = 1.0) -> Finding:
    """Measure peaks of soft and hard bilinear oscillators at three dampings."""
    start = simulate(stiff(4.0, 0.01), cosine(stiff_resonance(4.0)), v0=5.0, t_end=START_END)
    if certain_run(start) is None:
        return NOT_PROVEN
    checks = []
    stiffnesses = (4.0, 25.0, 1e4)
    for below in stiffnesses:
        for m in (1, 2, 3):
            slope, width = _bilinear_peak(below, m)
            what = f"k- = {below:g}, m = {m}"
            checks.append(agreement(f"{what}: speed over 1/a by the form", slope, factor, 5e-3))
            checks.append(agreement(f"{what}: width over 2a", width, 1.0, 0.03))
    none = stiff_resonance(25.0 / 9.0) * 4.0
    at_zero = response(stiff(25.0 / 9.0, 0.01), np.array([none]), (1.0, 5.0, 20.0), 2000)[0]
    work = WithError(cycle_work(25.0 / 9.0, 4), DOUBLES)
    checks.append(agreement("k- = 25/9, m = 4: work on a cycle", work, 0.0, ROUNDING))
    checks.append(
        Measurement("and the largest speed at a = 0.01", float(at_zero[0]), 0.0, 1.0, 1e-6)
    )
    return Finding(
        tuple(checks),
        remark="The speed has a part that does not depend on a: two dampings remove it, a third shows "
        "what is left. At k- = "
        "25/9 the fourth multiple of W_r does no work: there is no resonance of first order.",
        study=_chart(stiff(stiffnesses[0], DAMPED), _across_stiff(stiffnesses[0], 1, DAMPED)),
    )


def _across_stiff(below: float, m: int, damping: float) -> Floats:
    return m * stiff_resonance(below) + damping * ACROSS


def _bilinear_peak(below: float, m: int) -> tuple[WithError, WithError]:
    """Return the slope of the height over 1/a, and the width, by the form."""
    cycle = math.pi * (1.0 + 1.0 / math.sqrt(below))
    per_time = cycle_work(below, m) / cycle
    peaks = []
    dampings = DAMPED * PARTS
    for damping in dampings.tolist():
        omegas = _across_stiff(below, m, damping)
        expected = per_time / damping
        speeds = largest_speeds(stiff(below, damping), omegas, expected, int(3 / damping) * m)
        peaks.append(peak_and_width(omegas, speeds))
    heights, widths = np.array(peaks).T
    slopes = np.diff(heights) / np.diff(1.0 / dampings) / per_time
    return last_of(slopes), last_of(widths / (2.0 * dampings))


_of = partial(Statement, reference=BEYOND, scope="beyond", theory=THEORY)

STATEMENTS = (
    _of(
        id="losses-curve",
        claim="With r < 1 or a > 0 the motion with one impact in p periods of the force, omega "
        "near 2p, attracts; its speed is known in closed form.",
        formula=r"V = \frac{2\,|P|}{\sqrt{(1+r)^2\,\tan^2(\delta/2) + (1-r)^2/\omega^2}}"
        r"\ (a = 0),\ \delta = \frac{2p\,\pi}{\omega} - \pi,\ P = \frac{1}{1-\omega^2}",
        method="periodic orbits on either side of three peaks, at three losses",
        find=_curve,
    ),
    _of(
        id="losses-peaks",
        claim="The multi-harmonic peaks fall as 1/eps and broaden as eps, the share of the "
        "speed lost from impact to impact; their width does not depend on n.",
        formula=r"V_{max} \to \frac{2n}{(n^2-1)\,\varepsilon},\ \Delta\omega \to "
        r"\frac{2\varepsilon}{\pi},\ \varepsilon = 1 - r\,e^{-\pi a}",
        method="motions at 41 frequencies across each peak, at three losses of either kind",
        find=_peaks,
    ),
    _of(
        id="losses-half",
        claim="The half-harmonic peak falls as the root of 1/eps only, stays stable, and is "
        "as narrow as eps^2.",
        formula=r"V_{max} \to \sqrt{\frac{\pi}{4\varepsilon}} + \frac{\pi}{4\sqrt{2}},\ "
        r"\omega < 1 + \frac{\varepsilon^2}{8}",
        method="branches of periodic orbits at four losses",
        find=_half,
    ),
    _of(
        id="losses-saddles",
        claim="At omega = 2p/q with q > 2 the motion on which gain and loss balance is a saddle, "
        "however small the loss.",
        formula=r"V^q = \frac{2\pi p\,|h_q|}{\varepsilon},\ \mu_1 = 1 - q^2\varepsilon,\ "
        r"\mu_2 = 1 + q(q-2)\varepsilon",
        method="periodic orbits of q impacts and their multipliers at three small losses",
        find=_saddles,
    ),
    _of(
        id="losses-survive",
        claim="At a restitution of 0.8 only the multi-harmonic peaks stand out.",
        method="largest speed of four starts, beside each frequency and around it",
        find=_survive,
    ),
    _of(
        id="losses-bilinear",
        claim="The peak of a bilinear oscillator at m W_r, soft or hard, has the height J_m/(a T) "
        "and the width 2a, with T the free cycle and J_m the force's work on it.",
        formula=r"J_m = |g(w) - (-1)^m\,g(w/\kappa)/\kappa|,\ "
        r"g(w) = \frac{2w\,\cos(\pi w/2)}{1-w^2},\ w = m\,\Omega_r,\ \kappa^2 = k_-",
        method="motions at 41 frequencies across each peak, k- = 4, 25, 1e4, at three dampings",
        find=_bilinear,
    ),
)
