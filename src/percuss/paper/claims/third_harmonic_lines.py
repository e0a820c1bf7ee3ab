"""Figure 8: the spectra of the third harmonic above and below its critical velocity."""

from __future__ import annotations

import itertools
import math
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.model.forcing import sine
from percuss.motion.simulate import simulate
from percuss.motion.spectrum import line_spectrum, spectrum
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_condition
from percuss.paper.claims.certain_lines import are_sorted, jump_bound, power_law, proven_lines
from percuss.paper.claims.evidence import WALL, near
from percuss.paper.claims.third_harmonic_family import STIFFNESSES, T_END, bilinear_run, stepped
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS", "lines", "share_between_lines"]


ABOVE, BELOW = "0.51", "0.45"
PERIOD = 4.0 * math.pi
# The figure's frequencies reach to 36; the law of the peaks is seen over a wider range.
HIGHEST, FAR = 36.0, 1152.0
N_LINES = int(2.0 * FAR) + 1
EDGES = np.asarray(4.5 * 2.0 ** np.arange(9), dtype=np.float64)
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
    found = line_spectrum(_run(v0), PERIOD, N_LINES)
    return found.omega.values, found.amplitude.values


def _present(v0: str) -> Floats:
    """Return the frequencies of the lines that are there, up to the figure's highest."""
    omega, amplitude = lines(v0)
    present = (amplitude > NOTHING * amplitude.max()) & (omega <= HIGHEST)
    return np.asarray(omega[present], dtype=np.float64)


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


def _bound(v0: str) -> float:
    """Return w^2 times what no line at high frequencies w exceeds, from the velocity's jumps."""
    run = _run(v0)
    jumps = run.impacts.impulse[run.impacts.t > run.t_end - PERIOD - 1e-9]
    return float(2.0 * jumps.sum() / PERIOD)


def power_above(v0: str, omega0: float) -> float:
    """Return the share of the variance of x in the lines above a frequency."""
    omega, amplitude = lines(v0)
    square = amplitude[1:] ** 2
    return float(square[omega[1:] > omega0].sum() / square.sum())


def _present_in_balls(v0: str) -> Floats | None:
    """Return the same frequencies where the balls tell which lines are there, else None."""
    proven = proven_lines(v0, N_LINES)
    if proven is None:
        return None
    strongest = max(proven, key=float)
    few = proven[: int(2.0 * HIGHEST) + 1]
    there = [bool(line > NOTHING * strongest) for line in few]
    missing = [bool(line < NOTHING * strongest) for line in few]
    if not all(a != b for a, b in zip(there, missing, strict=True)):
        return None
    return 0.5 * np.flatnonzero(there).astype(np.float64)


def _regular() -> Finding:
    """List the lines at V0 = 0.51."""
    omega, amplitude = lines(ABOVE)
    expected = np.concatenate([[0.0, 1.0, 2.0, 3.0], np.arange(4.0, HIGHEST + 1.0, 2.0)])
    certain = _present_in_balls(ABOVE)
    found = _present(ABOVE) if certain is None else certain
    same = len(found) == len(expected) and bool((found == expected).all())
    proven = proven_lines(ABOVE, N_LINES)
    falls = None if proven is None else are_sorted(proven[4::4])
    falling = amplitude[(omega % 2.0 == 0.0) & (omega >= 2.0)]
    by_floats = bool((np.diff(falling) < 0).all())
    return Finding(
        (
            certain_condition(
                "lines at 0, 1, 3 and the even frequencies, and at no other",
                same,
                certain is not None,
            ),
            certain_condition(
                "each even line is lower than the one before",
                by_floats if falls is None else falls,
                falls is not None,
            ),
        ),
        remark=(
            f"The even lines fall as w^{peak_law(ABOVE):.3f}, as those of any motion whose velocity "
            "jumps: a power, however rapid it looks."
        ),
    )


def _irregular() -> Finding:
    """Count the lines at V0 = 0.45 and how often their heights go up."""
    omega, amplitude = lines(BELOW)
    found, before = _present(BELOW), _present(ABOVE)
    heights = amplitude[np.isin(omega, found)]
    rises = int((np.diff(heights) > 0.0).sum())
    certain = _present_in_balls(BELOW), _present_in_balls(ABOVE)
    is_certain = certain[0] is not None and certain[1] is not None
    proven = proven_lines(BELOW, N_LINES)
    is_counted = False
    if certain[0] is not None and certain[1] is not None and proven is not None:
        found, before = certain[0], certain[1]
        there = [proven[int(2.0 * w)] for w in found]
        # At least so many, for certain.
        rises = sum(bool(b > a) for a, b in itertools.pairwise(there))
        is_counted = 3 * rises > len(found)
    shares = [power_above(v0, 4.0) for v0 in (BELOW, ABOVE)]
    between = {name: share_between_lines(bilinear_run(k)) for name, k in STIFFNESSES.items()}
    steps = share_between_lines(stepped(4e8, 0.0).x)
    return Finding(
        (
            certain_condition(
                "more lines up to 36 than at V0 = 0.51", len(found) > len(before), is_certain
            ),
            certain_condition(
                "a third of the lines or more are higher than the one before",
                3 * rises > len(found),
                is_counted,
            ),
        ),
        remark=(
            f"{len(found)} lines instead of {len(before)}, {rises} of them higher than the one "
            f"before; all are sharp, at multiples of 1/2. The share of the variance above w = 4 is "
            f"{shares[0]:.2e}, at V0 = 0.51 {shares[1]:.2e}. From 18 to 36 the share of the power "
            f"between the lines is {share_between_lines(_run(BELOW)):.0e} in the limit, "
            + ", ".join(f"{share:.1e} at {name}" for name, share in between.items())
            + f", and {steps:.1e} with plain Runge-Kutta steps at w-/w+ = 2e4."
        ),
    )


def _law(v0: str) -> tuple[float, float | None]:
    """Return the exponent of the peaks, and its radius where it is proven."""
    proven = proven_lines(v0, N_LINES)
    slope = None if proven is None else power_law(proven, EDGES)
    if slope is None:
        return peak_law(v0), None
    return float(slope.mid()), float(slope.rad()) + 1e-15


def _slower() -> Finding:
    """Compare the laws by which the peaks fall."""
    above, below = _law(ABOVE), _law(BELOW)
    is_certain = above[1] is not None and below[1] is not None
    sizes = jump_bound(BELOW), jump_bound(ABOVE)
    what = "ratio of the bounds of w^2 times a line"
    if sizes[0] is None or sizes[1] is None:
        ratio = near(what, _bound(BELOW) / _bound(ABOVE), 1.0, 0.01)
    else:
        by = sizes[0] / sizes[1]
        ratio = Check(what, float(by.mid()), 1.0, 0.01, float(by.rad()) + 1e-15)
    return Finding(
        (
            certain_condition(
                "the exponent of the peaks at V0 = 0.45 is greater by 0.2",
                below[0] > above[0] + 0.2,
                is_certain,
            ),
        ),
        corrected=(
            Check("exponent of the highest peaks at V0 = 0.51", above[0], -2.0, 0.03, above[1]),
            Check("exponent of the highest peaks at V0 = 0.45", below[0], -2.0, 0.1, below[1]),
            ratio,
        ),
        correction=(
            "the peaks fall by the same power, w^-2, and below nearly the same bound; at V0 = 0.45 "
            "there are more of them, and their heights are irregular"
        ),
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
        found = spectrum(motion, omega=number / 14.0, between=(0.0, WINDOW))
        amplitude = found.amplitude.values
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
        certainty="closed form, 12 digits",
        find=_regular,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-fig8b-irregular",
        reference="fig 8b",
        claim="At V0 = 0.45 the spectrum is wider, with irregular peaks.",
        method="exact Fourier coefficients; exact Fourier integrals of the bilinear motions",
        certainty="closed form, 12 digits",
        find=_irregular,
        theory="third-harmonic.md",
    ),
    Statement(
        id="periodicity-fig8b-slower",
        reference="fig 8b",
        claim="At V0 = 0.45 the peaks fall much more slowly with the frequency than at V0 = 0.51.",
        method="highest line of each of eight octaves; bound by the jumps of the velocity",
        certainty="closed form, 12 digits",
        find=_slower,
        theory="third-harmonic.md",
    ),
)
