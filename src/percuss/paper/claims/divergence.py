"""Divergence of motions that start close together: the effect of rounding on a computed motion."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.certified import certify, prove_chaos
from percuss.io.study_text import motion_text
from percuss.model.forcing import Forcing
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import Oscillator
from percuss.motion.simulate import simulate
from percuss.paper.claims.comparisons import DOUBLES, WALL
from percuss.paper.evidence import Enclosure, Evidence, Measurement
from percuss.paper.statement import Finding, Statement

# After each multiple of pi, away from the impacts of the motions looked at.
AFTER = 0.37
# Starts under sin 3t: just below the critical velocity 1/2, and that of figure 6b.
CHAOTIC, REGULAR = 0.4999, 0.45
# Differences at the start: as small as doubles resolve, and one that shows slow growth.
STEP, WIDE_STEP = 1e-15, 1e-9
T_END = 120.0 * math.pi
# Between these the separation is neither that of the first flights nor that of the whole motion.
LEAST, MOST = 1e2, 1e12
# By so much doubles of a chaotic motion grow apart at least.
LARGE = 1e9
# By so much the exact motions part, whatever computes them.
PARTED = 1e6
# A motion is lost when it is off by more than this, a fiftieth of its size.
LOST = 1e-2


@cache
def separation(osc: Oscillator, force: Forcing, v0: float, step: float, t_end: float) -> Floats:
    """Return the distance of the motions from v0 and v0 + step over that at the start.

    The distance is sqrt(dx^2 + dv^2) once each pi, 0.37 after its multiples: near an impact it is
    large for any two motions, as one has hit and the other has not.

    Examples
    --------
    >>> float(separation(WALL, sine(3), 0.6, 1e-9, 30.0).max()) < 3.0
    True
    """
    one = simulate(osc, force, v0=v0, t_end=t_end)
    other = simulate(osc, force, v0=v0 + step, t_end=t_end)
    t = np.arange(1, int(t_end / math.pi)) * math.pi + AFTER
    (x, v), (y, w) = one(t), other(t)
    return np.asarray(numerics.hypot(x - y, v - w) / (other.v0 - one.v0))


def growth_rate(distances: Floats) -> tuple[float, float]:
    """Return the rate of exponential growth and its standard error, from `separation`.

    Examples
    --------
    >>> rate, error = growth_rate(numerics.exp(0.3 * math.pi * np.arange(100)))
    >>> round(rate, 6), error < 1e-6
    (0.3, True)
    """
    if not (distances > LEAST).any():
        return math.nan, math.nan
    begin = int(np.argmax(distances > LEAST))
    end = int(np.argmax(distances > MOST)) or len(distances)
    t = math.pi * np.arange(begin, end, dtype=np.float64)
    if len(t) < 4:
        return math.nan, math.nan
    return numerics.fit_line(t, numerics.log(distances[begin:end]))


def _proven_growth(v0: float) -> Enclosure:
    """Enclose the largest distance of x of two motions, over that of their starts, once each pi."""
    starts = v0, v0 + STEP
    t = [k * math.pi + AFTER for k in range(1, int(T_END / math.pi))]
    # Doubles are the exact starts of what is proven.
    runs = [certify(simulate(WALL, sine(3), v0=start, t_end=T_END)) for start in starts]
    x, y = (run(t)[0].arbs for run in runs)
    apart = [abs(a - b) / (starts[1] - starts[0]) for a, b in zip(x, y, strict=True)]
    most = max((one for one in apart if one.is_finite()), key=lambda one: float(one.lower()))
    what = f"V0 = {v0:g}: growth of {STEP:g} to t = {T_END:.0f} without rounding"
    return Enclosure(what, float(most.mid()), float(most.rad().upper()), PARTED, math.inf)


def _proven_chaos() -> Enclosure:
    """Enclose the lower bound of the entropy that covering relations of the impact map prove."""
    entropy = prove_chaos(WALL, sine(3)).entropy
    what = "lower bound of the topological entropy of the impact map, above 0 if it is chaotic"
    return Enclosure(what, float(entropy.mid()), float(entropy.radius()), 1e-9, math.inf)


def _numerics(unstable: tuple[float, ...] = (CHAOTIC, 0.49, 0.02)) -> Finding:
    """Let two motions part whose starts differ by a few units of the last digit."""
    checks: list[Evidence] = []
    said = []
    for v0 in unstable:
        chaotic = separation(WALL, sine(3), v0, STEP, T_END)
        rate, error = growth_rate(chaotic)
        grown = float(chaotic.max())
        checks += [
            # The rounding of the two motions is as large as their first difference.
            Measurement(
                f"V0 = {v0:g}: growth of {STEP:g} to t = {T_END:.0f} in doubles",
                grown,
                low=LARGE,
                high=math.inf,
                error=0.5 * grown,
            ),
            Measurement(
                f"V0 = {v0:g}: its rate, with three standard errors",
                rate,
                0.0,
                math.inf,
                3.0 * error,
            ),
            _proven_growth(v0),
        ]
        is_lost = chaotic * STEP > LOST
        lost = math.pi * (1 + int(is_lost.argmax())) + AFTER
        since = f"from t = {lost:.0f} on" if is_lost.any() else f"not up to t = {T_END:.0f}"
        said.append(f"exp({rate:.3f} t), {since} (V0 = {v0:g})")
    regular = separation(WALL, sine(3), REGULAR, WIDE_STEP, T_END)
    return Finding(
        (
            _proven_chaos(),
            *checks,
            Measurement(
                f"V0 = {REGULAR:g}: growth of {WIDE_STEP:g} to t = {T_END:.0f}",
                float(regular.max()),
                low=0.0,
                high=10.0,
                # Motions of doubles, over their first difference.
                error=DOUBLES / WIDE_STEP,
            ),
        ),
        remark=(
            "Differences grow in bursts, where flights nearly graze. How they grow on average, and "
            f"from when on a difference of {STEP:g}, the rounding of doubles, is more than "
            f"{LOST:g}: {'; '.join(said)}. At V0 = {REGULAR:g} differences grow at most "
            f"{regular.max():.1f} times. Of two motions whose starts are that close the exact ones, "
            "enclosed by balls, part by a factor of more than a million at each of the three starts, "
            "and those in doubles by far more, since each impact rounds anew. That the oscillator is "
            "chaotic is proven, by covering relations of its impact map: infinitely many motions are "
            "periodic, and others follow each order of two loops. No method of integration changes that: the instability is "
            "that of the motion. Three starts under one force are examples, and no proof for all "
            "parameters."
        ),
        study=motion_text(simulate(WALL, sine(3), v0=unstable[0], t_end=T_END)),
    )


STATEMENTS = (
    Statement(
        id="periodicity-chaos",
        reference="section 6",
        claim="Where the oscillator is chaotic the numerical simulation is not stable.",
        method="pairs of motions under sin 3t whose starts differ by the last digits, at four velocities, "
        "in doubles and in balls; covering relations in balls",
        find=_numerics,
    ),
)
