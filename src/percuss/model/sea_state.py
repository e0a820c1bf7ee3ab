"""An irregular sea as a sum of harmonics, from its spectrum."""

from __future__ import annotations

import math
from typing import Any, Literal, get_args

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import Computed, Exact, as_float, whole
from percuss.model.faults import Fault, plain_number, positive_faults, raise_first
from percuss.model.forcing import Forcing, Harmonic
from percuss.numerics import exp, power

SeaKind = Literal["jonswap", "pierson-moskowitz"]
# The band of frequencies in units of that of the peak: 98 % of the energy of either spectrum.
LOWEST, HIGHEST = 0.5, 4.0
MOST_HARMONICS = 10_000
# Peak enhancement of the mean JONSWAP spectrum, and its widths below and above the peak
# (Hasselmann et al. 1973).
ENHANCEMENT = 3.3
WIDTH_BELOW, WIDTH_ABOVE = 0.07, 0.09


def sea_state(
    hs: Exact, tp: Exact, kind: SeaKind = "jonswap", n: int = 40, seed: int = 0
) -> Forcing:
    """Return the elevation of an irregular sea as a forcing of n harmonics.

    The band from half to four times the frequency of the peak is cut into n equal parts. Each gives
    one harmonic: its frequency is drawn from the part, so that the sea does not repeat itself, its
    phase at random, and its amplitude is sqrt(2 S dw). The amplitudes are scaled so that they hold
    the whole energy, the sum of their squares being hs^2 / 8.

    Take the elevation as a force per unit mass with `per_mass`: of F newtons for each metre on a
    mass m, ``sea_state(...).per_mass(m / F)``.

    Parameters
    ----------
    hs
        Significant wave height [length], > 0: four times the standard deviation of the elevation.
        It may be an expression of parameters, and so may the period.
    tp
        Period of the peak of the spectrum [time], > 0.
    kind
        "jonswap", with a peak enhancement of 3.3 (Hasselmann et al. 1973), or "pierson-moskowitz"
        (Pierson & Moskowitz 1964).
    n
        Number of harmonics, 1 to 10,000.
    seed
        Of the random numbers, a whole number of at least 0: the same sea each time.

    Returns
    -------
    Forcing
        With n harmonics and no period.

    Raises
    ------
    ParameterError
        If a value is outside its domain, or there is no such spectrum.

    Examples
    --------
    >>> sea = sea_state(hs=2.0, tp=8.0, n=30, seed=1)
    >>> len(sea.harmonics), round(sum(h.amplitude**2 for h in sea.harmonics), 12)
    (30, 0.5)
    """
    hs, tp = plain_number(hs), plain_number(tp)
    raise_first(sea_faults(hs, tp, kind, n, seed))
    n, seed = whole("n", n, 1, MOST_HARMONICS), whole("seed", seed, 0, math.inf)
    peak = 2.0 * math.pi / as_float(tp)
    period = tp if isinstance(tp, Computed) else None
    draw = np.random.Generator(np.random.PCG64(seed)).random((2, n))
    # In units of the peak's frequency.
    places = LOWEST + (HIGHEST - LOWEST) * (np.arange(n) + draw[0]) / n
    energy = np.array([spectrum_at(float(w), kind) for w in places])
    shares: Floats = np.sqrt(energy / (8.0 * math.fsum(energy)))
    size: Any = hs if isinstance(hs, Computed) else as_float(hs)
    return Forcing(
        Harmonic(
            size * float(a),
            float(w) * peak if period is None else 2.0 * math.pi * float(w) / period,
            2.0 * math.pi * float(phase),
        )
        for a, w, phase in zip(shares, places, draw[1], strict=True)
    )


def sea_faults(hs: Exact, tp: Exact, kind: object, n: object, seed: object) -> list[Fault]:
    """Return all faults of the arguments of `sea_state`.

    Examples
    --------
    >>> [fault.name for fault in sea_faults(-1, 0, "jonswap", 0, 1)]
    ['hs', 'tp', 'n']
    """
    problems = [*positive_faults("hs", hs), *positive_faults("tp", tp)]
    if kind not in get_args(SeaKind):
        problems.append(Fault("kind", kind, f"none of {', '.join(get_args(SeaKind))}"))
    for name, value, least, most in (("n", n, 1, MOST_HARMONICS), ("seed", seed, 0, math.inf)):
        try:
            whole(name, value, least, most)
        except ParameterError as error:
            problems.append(Fault(error.name, error.value, error.reason))
    return problems


def spectrum_at(w: float, kind: SeaKind) -> float:
    """Return the density of energy at a frequency in units of the peak's, but for a factor.

    Examples
    --------
    >>> round(spectrum_at(1.0, "jonswap") / spectrum_at(1.0, "pierson-moskowitz"), 12)
    3.3
    """
    density = w**-5 * exp(-1.25 * w**-4)
    if kind == "pierson-moskowitz":
        return density
    width = WIDTH_BELOW if w <= 1.0 else WIDTH_ABOVE
    return density * power(ENHANCEMENT, exp(-0.5 * ((w - 1.0) / width) ** 2))
