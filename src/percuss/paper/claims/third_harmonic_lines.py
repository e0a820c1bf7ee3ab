"""Figure 8: the spectra of the third harmonic above and below its critical velocity."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np
from flint import arb

from percuss import numerics
from percuss.arrays import Floats
from percuss.certified.numbers import precision
from percuss.errors import ParameterError
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import bilinear_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.spectrum import line_spectrum, spectrum
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_run
from percuss.paper.claims.certain_lines import BITS, jump_bound, power_law, proven_lines
from percuss.paper.claims.comparisons import WALL, WithError
from percuss.paper.claims.third_harmonic_family import STIFFNESSES, T_END, bilinear_run, stepped
from percuss.paper.evidence import Enclosure, Measurement
from percuss.paper.statement import Finding, Statement

ABOVE, BELOW = "0.51", "0.45"
PERIOD = 4.0 * math.pi
# The figure's frequencies reach to 36; the law of the peaks is seen over a wider range.
HIGHEST, FAR = 36.0, 1152.0
N_LINES = int(2.0 * FAR) + 1
EDGES = np.asarray(4.5 * 2.0 ** np.arange(9), dtype=np.float64)
# A law is much slower than another if its power is at most this part of the other's.
MUCH = 0.5
# Lines weaker than this part of the strongest are rounding.
NOTHING = 1e-12
# Whole periods of 4 pi in the figure's 30 pi.
WINDOW = 28.0 * math.pi


@cache
def _run(v0: str) -> Trajectory:
    return simulate(WALL, sine(3), v0=v0, t_end=10.0 * PERIOD)


@cache
def lines(v0: str) -> tuple[Floats, Floats]:
    """Return the frequencies and amplitudes of the lines of x; all are multiples of 1/2.

    Examples
    --------
    >>> omega, amplitude = lines("0.51")
    >>> omega[:3], round(float(amplitude[6]), 12)  # sin(3t)/8
    (array([0. , 0.5, 1. ]), 0.125)
    """
    spectrum = line_spectrum(_run(v0), PERIOD, N_LINES)
    return spectrum.omega.values, spectrum.amplitude.values


def peak_law(v0: str) -> float:
    """Return the exponent of the highest line of each octave from 4.5 to 1152.

    Examples
    --------
    >>> round(peak_law("0.51"), 1)
    -2.0
    """
    omega, amplitude = lines(v0)
    edges = EDGES
    highest = [
        int(np.flatnonzero(inside)[amplitude[inside].argmax()])
        for inside in ((omega >= low) & (omega < 2.0 * low) for low in edges[:-1])
    ]
    return numerics.fit_line(numerics.log(omega[highest]), numerics.log(amplitude[highest]))[0]


def power_above(v0: str, omega0: float) -> float:
    """Return the share of the variance of x in the lines above a frequency."""
    omega, amplitude = lines(v0)
    square = amplitude[1:] ** 2
    return float(square[omega[1:] > omega0].sum() / square.sum())


def _lines_of(v0: str) -> tuple[arb, ...]:
    """Return balls of the lines of the motion from V0.

    Raises
    ------
    ParameterError
        If the motion is not proven to have the period 4 pi.
    """
    proven = proven_lines(v0, N_LINES)
    if proven is None:
        raise ParameterError("v0", v0, "no motion with the proven period 4 pi")
    return proven


def _ratio(what: str, one: arb, other: arb, low: float, high: float) -> Enclosure:
    with precision(BITS):
        ratio = one / other
        return Enclosure(what, float(ratio.mid()), float(ratio.rad()) + 1e-300, low, high)


def _present_in_balls(v0: str) -> Floats:
    """Return the frequencies of the lines up to the figure's highest, as balls tell them."""
    proven = _lines_of(v0)
    strongest = max(proven, key=float)
    few = proven[: int(2.0 * HIGHEST) + 1]
    return 0.5 * np.flatnonzero([bool(line > NOTHING * strongest) for line in few]).astype(float)


def _regular(v0: str = ABOVE) -> Finding:
    """Compare the lines at V0 = 0.51 with the pattern 0, 1, 2, 3 and all even frequencies."""
    proven = _lines_of(v0)
    strongest = max(proven, key=float)
    expected = {0, 1, 2, 3, *range(4, int(HIGHEST) + 1, 2)}
    there = [proven[2 * w] for w in sorted(expected)]
    missing = [proven[i] for i in range(int(2 * HIGHEST) + 1) if i % 2 or i // 2 not in expected]
    even = proven[4::4]
    steps = [(b, a) for a, b in itertools.pairwise(even)]
    largest = max(steps, key=lambda pair: float(pair[0]) / float(pair[1]))
    return Finding(
        (
            _ratio(
                "weakest line at 0, 1, 3 and the even frequencies, over the strongest",
                min(there, key=float),
                strongest,
                NOTHING,
                1.0,
            ),
            _ratio(
                "strongest at any other multiple of 1/2 up to 36, over the strongest",
                max(missing, key=float),
                strongest,
                -NOTHING,
                NOTHING,
            ),
            _ratio(
                "largest ratio of an even line to the one before, up to 1152", *largest, 0.0, 1.0
            ),
        ),
        remark=(
            f"The even lines fall as w^{peak_law(v0):.3f}, as those of any motion whose velocity "
            "jumps: a power, however rapid it looks."
        ),
        study=motion_text(_run(v0)),
    )


def _share_above(v0: str, omega: int) -> arb:
    """Return the share of the variance in the lines above a frequency."""
    with precision(BITS):
        square = [line * line for line in _lines_of(v0)]
        return sum(square[2 * omega + 1 :], arb(0)) / sum(square[1:], arb(0))


def _irregular(v0: str = BELOW) -> Finding:
    """Count the lines at V0 = 0.45 and how often their heights go up."""
    present, before = _present_in_balls(v0), _present_in_balls(ABOVE)
    proven = _lines_of(v0)
    there = [proven[int(2.0 * w)] for w in present]
    # At least so many, for certain.
    rises = sum(bool(b > a) for a, b in itertools.pairwise(there))
    shares = [power_above(one, 4.0) for one in (BELOW, ABOVE)]
    between = {name: share_between_lines(bilinear_run(k)) for name, k in STIFFNESSES.items()}
    steps = share_between_lines(stepped(4e8, 0.0).x)
    return Finding(
        (
            Enclosure(
                f"number of lines up to 36; {len(before)} at V0 = 0.51",
                len(present),
                0.0,
                len(before) + 1.0,
                math.inf,
            ),
            Enclosure(
                "share of them that are higher than the one before",
                rises / len(present),
                0.0,
                1 / 3,
                1.0,
            ),
            _ratio(
                "share of the variance above w = 4, over that at V0 = 0.51",
                _share_above(v0, 4),
                _share_above(ABOVE, 4),
                1.0 + 1e-9,
                math.inf,
            ),
        ),
        remark=(
            f"{len(present)} lines instead of {len(before)}, {rises} of them higher than the one "
            f"before; all are sharp, at multiples of 1/2. The share of the variance above w = 4 is "
            f"{shares[0]:.2e}, at V0 = 0.51 {shares[1]:.2e}. From 18 to 36 the share of the power "
            f"between the lines is {share_between_lines(_run(BELOW)):.0e} in the limit, "
            + ", ".join(f"{share:.1e} at {name}" for name, share in between.items())
            + f", and {steps:.1e} with plain Runge-Kutta steps at w-/w+ = 2e4."
        ),
        study=motion_text(_run(v0)),
    )


def _law(v0: str) -> arb:
    """Return the exponent of the peaks."""
    slope = power_law(_lines_of(v0), EDGES)
    return arb("nan") if slope is None else slope


def _bilinear_law(v0: str, stiffness_below: float) -> WithError:
    """Return the exponent of the highest line of each octave that fig 8 shows, bilinear."""
    osc = bilinear_oscillator(stiffness_below=stiffness_below)
    run = simulate(osc, sine(3), v0=v0, t_end=T_END)
    if certain_run(run) is None:
        return WithError(math.nan, math.nan)
    omega = 0.5 * np.arange(1, int(2.0 * HIGHEST) + 1)
    height = spectrum(run, omega=omega, between=(0.0, WINDOW)).amplitude.values
    tops = [
        int(np.flatnonzero(inside)[height[inside].argmax()])
        for inside in ((omega >= low) & (omega < 2.0 * low) for low in EDGES[:3])
    ]
    where, heights = (np.asarray(column[tops], dtype=np.float64) for column in (omega, height))
    return WithError(*numerics.fit_line(numerics.log(where), numerics.log(heights)))


def _slower(v0: str = BELOW, law: float = -2.0) -> Finding:
    """Compare the laws by which the peaks fall, in the limit and for the bilinear oscillator."""
    above, below = _law(ABOVE), _law(v0)
    one, other = jump_bound(v0), jump_bound(ABOVE)
    ratio = arb("nan") if one is None or other is None else one / other

    def of(what: str, value: arb, low: float, high: float) -> Enclosure:
        return Enclosure(what, float(value.mid()), float(value.rad()) + 1e-15, low, high)

    slower = "exponent of the highest peaks at V0 = 0.45 over that at V0 = 0.51"
    laws = {
        name: (_bilinear_law(ABOVE, k), _bilinear_law(v0, k)) for name, k in STIFFNESSES.items()
    }
    said = "; ".join(
        f"{fast.value:.2f} +- {fast.error:.2f} at V0 = 0.51, {slow.value:.2f} +- {slow.error:.2f} "
        f"at 0.45 ({name})"
        for name, (fast, slow) in laws.items()
    )
    fast, slow = laws["w-/w+ = 2e4"]
    within = slow.value / fast.value
    return Finding(
        (
            of(f"{slower}, eight octaves of the limit", below / above, 0.0, MUCH),
            Measurement(
                f"{slower}, the three octaves of the figure, w-/w+ = 2e4",
                within,
                0.0,
                MUCH,
                within * math.hypot(slow.error / slow.value, fast.error / fast.value),
            ),
        ),
        corrected=(
            of("exponent of the highest peaks at V0 = 0.51", above, law - 0.03, law + 0.03),
            of("exponent of the highest peaks at V0 = 0.45", below, law - 0.1, law + 0.1),
            of("ratio of the bounds of w^2 times a line", ratio, 0.99, 1.01),
        ),
        correction=(
            "in the impact oscillator the peaks fall by the same power, w^-2, and below nearly the "
            "same bound; at V0 = 0.45 there are more of them, and their heights are irregular"
        ),
        remark=(
            "Peaks fall much more slowly where their power is half as large, or less. Fig 8 shows "
            "numerical motions of the bilinear oscillator, and three octaves of peaks only. There "
            f"the exponents are {said}. So within the figure, and above all with 2e4 read as the "
            "ratio of the squares, they fall more slowly at 0.45; further on they do not."
        ),
        study=motion_text(_run(v0)),
    )


def share_between_lines(motion: Trajectory | Floats) -> float:
    """Return the share of the power from 18 to 36 that is not at multiples of 1/2.

    Over seven periods of 4 pi a Hann window widens each line to its neighbours at 1/14.

    Parameters
    ----------
    motion
        A run of at least 28 pi, or x at equidistant times from 0 to 30 pi, both ends included.

    Examples
    --------
    >>> share_between_lines(_run("0.45")) < 1e-20
    True
    """
    number = np.arange(18 * 14, int(HIGHEST * 14) + 1)
    if isinstance(motion, Trajectory):
        density = spectrum(motion, omega=number / 14.0, between=(0.0, WINDOW))
        amplitude = density.amplitude.values
    else:
        n = round((len(motion) - 1) * WINDOW / T_END)
        share = np.arange(n) / n
        # The points do not divide the window evenly: its end is within half a step of 28 pi.
        transform = np.fft.rfft(motion[:n] * (0.5 - 0.5 * numerics.cos(2.0 * math.pi * share)))
        amplitude = np.abs(transform[number])
    power = amplitude**2
    between = (number % 7 >= 2) & (number % 7 <= 5)
    return float(power[between].sum() / power.sum())


STATEMENTS = (
    Statement(
        id="periodicity-fig8a-regular",
        reference="fig 8a",
        claim="At V0 = 0.51 the spectrum has regular peaks whose height falls with the frequency.",
        method="exact Fourier coefficients of the periodic motion",
        find=_regular,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-fig8b-irregular",
        reference="fig 8b",
        claim="At V0 = 0.45 the spectrum is wider, with irregular peaks.",
        method="exact Fourier coefficients; exact Fourier integrals of the bilinear motions",
        find=_irregular,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-fig8b-slower",
        reference="fig 8b",
        claim="At V0 = 0.45 the peaks fall much more slowly with the frequency than at V0 = 0.51.",
        method="highest line of each of eight octaves; bound by the jumps of the velocity",
        find=_slower,
        theory="third-harmonic.md",
    ),
)
