"""How motions that start close to one another part: what rounding does to a computed motion."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.io.study_text import motion_text
from percuss.model.forcing import Forcing, sine
from percuss.model.oscillator import Oscillator
from percuss.motion.simulate import simulate
from percuss.paper.claims.comparisons import WALL
from percuss.paper.evidence import Measurement
from percuss.paper.statement import Finding, Statement

__all__ = ["AFTER", "CHAOTIC", "REGULAR", "STATEMENTS", "STEP", "growth_rate", "separation"]


# After each multiple of pi, away from the impacts of the motions looked at.
AFTER = 0.37
# Starts under sin 3t: just below the critical velocity 1/2, and that of figure 6b.
CHAOTIC, REGULAR = 0.4999, 0.45
# Differences at the start: as small as doubles resolve, and one that shows slow growth.
STEP, WIDE_STEP = 1e-15, 1e-9
T_END = 120.0 * math.pi
# Between these the separation is neither that of the first flights nor that of the whole motion.
LEAST, MOST = 1e2, 1e12
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


def _numerics(unstable: float = CHAOTIC) -> Finding:
    """Let two motions part whose starts differ by a few units of the last digit."""
    chaotic = separation(WALL, sine(3), unstable, STEP, T_END)
    regular = separation(WALL, sine(3), REGULAR, WIDE_STEP, T_END)
    rate, error = growth_rate(chaotic)
    is_lost = chaotic * STEP > LOST
    lost = math.pi * (1 + int(is_lost.argmax())) + AFTER if is_lost.any() else math.inf
    return Finding(
        (
            Measurement(
                f"V0 = {unstable:g}: growth of {STEP:g} to t = {T_END:.0f}",
                float(chaotic.max()),
                low=MOST,
                high=math.inf,
            ),
            Measurement(
                "its rate of growth, with three standard errors", rate, 0.0, math.inf, 3.0 * error
            ),
            Measurement(
                f"V0 = {REGULAR:g}: growth of {WIDE_STEP:g} to t = {T_END:.0f}",
                float(regular.max()),
                low=0.0,
                high=10.0,
            ),
        ),
        remark=(
            f"At V0 = {CHAOTIC:g} differences grow in bursts, where flights nearly graze, on average "
            f"as exp({rate:.3f} t) with the error {error:.3f} of the fit; a difference of {STEP:g}, "
            f"the rounding of doubles, is more than {LOST:g} from t = {lost:.0f} on. At V0 = "
            f"{REGULAR:g} differences grow at most {regular.max():.1f} times up to t = {T_END:.0f}. "
            "No method of integration changes that: the instability is that of the motion."
        ),
        study=motion_text(simulate(WALL, sine(3), v0=unstable, t_end=T_END)),
    )


STATEMENTS = (
    Statement(
        id="periodicity-chaos",
        reference="section 6",
        claim="Where the oscillator is chaotic the numerical simulation is not stable.",
        method="two motions under sin 3t whose starts differ by the last digits, at two velocities",
        find=_numerics,
    ),
)
