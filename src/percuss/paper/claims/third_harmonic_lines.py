"""Figure 8: the spectra of the third harmonic above and below its critical velocity."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from numpy.typing import NDArray

from percuss.model.forcing import sine
from percuss.motion.simulate import simulate
from percuss.motion.spectrum import line_spectrum, spectrum
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.evidence import WALL, condition, near
from percuss.paper.claims.third_harmonic_family import STIFFNESSES, T_END, bilinear_run, stepped
from percuss.paper.statement import Finding, Statement

__all__ = ["STATEMENTS", "lines", "share_between_lines"]

Floats = NDArray[np.float64]

ABOVE, BELOW = "0.51", "0.45"
PERIOD = 4.0 * math.pi
# The figure's frequencies reach to 36; the law of the peaks is seen over a wider range.
HIGHEST, FAR = 36.0, 1152.0
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
    found = line_spectrum(_run(v0), PERIOD, int(2.0 * FAR) + 1)
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
    edges = 4.5 * 2.0 ** np.arange(9)
    highest = [
        int(np.flatnonzero(inside)[amplitude[inside].argmax()])
        for inside in ((omega >= low) & (omega < 2.0 * low) for low in edges[:-1])
    ]
    return float(np.polyfit(np.log(omega[highest]), np.log(amplitude[highest]), 1)[0])


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


def _regular() -> Finding:
    """List the lines at V0 = 0.51."""
    omega, amplitude = lines(ABOVE)
    expected = np.concatenate([[0.0, 1.0, 2.0, 3.0], np.arange(4.0, HIGHEST + 1.0, 2.0)])
    found = _present(ABOVE)
    same = len(found) == len(expected) and bool((found == expected).all())
    falling = amplitude[(omega % 2.0 == 0.0) & (omega >= 2.0)]
    return Finding(
        (
            condition("lines at 0, 1, 3 and the even frequencies, and at no other", same),
            condition(
                "each even line is lower than the one before", bool((np.diff(falling) < 0).all())
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
    shares = [power_above(v0, 4.0) for v0 in (BELOW, ABOVE)]
    between = {name: share_between_lines(bilinear_run(k)) for name, k in STIFFNESSES.items()}
    steps = share_between_lines(stepped(4e8, 0.0).x)
    return Finding(
        (
            condition("more lines up to 36 than at V0 = 0.51", len(found) > len(before)),
            condition(
                "a third of the lines or more are higher than the one before",
                3 * rises > len(found),
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


def _slower() -> Finding:
    """Compare the laws by which the peaks fall."""
    above, below = peak_law(ABOVE), peak_law(BELOW)
    bounds = _bound(BELOW), _bound(ABOVE)
    return Finding(
        (
            condition(
                "the exponent of the peaks at V0 = 0.45 is greater by 0.2", below > above + 0.2
            ),
        ),
        corrected=(
            near("exponent of the highest peaks at V0 = 0.51", above, -2.0, 0.03),
            near("exponent of the highest peaks at V0 = 0.45", below, -2.0, 0.1),
            near("ratio of the bounds of w^2 times a line", bounds[0] / bounds[1], 1.0, 0.01),
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
        transform = np.fft.rfft(motion[:n] * (0.5 - 0.5 * np.cos(2.0 * math.pi * share)))
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
