"""The conclusion's statement on Poincare maps at multiples of the driving period."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from percuss import numerics
from percuss.io.study_text import motion_text
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import Oscillator
from percuss.motion.simulate import simulate
from percuss.orbits import stroboscopic_map
from percuss.paper.claims.comparisons import WALL
from percuss.paper.claims.half_harmonic_growth import limit_constant
from percuss.paper.evidence import Measurement, compare
from percuss.paper.statement import Finding, Statement

# Driving periods from rest, of which the first are left out of the fit.
PERIODS, SETTLED = 3000, 300


def _poincare(osc: Oscillator) -> Finding:
    """Iterate the stroboscopic map of (27) from rest, and fit the growth of x^2 + v^2."""
    strobe = stroboscopic_map(osc, sine(1))
    state = np.zeros(2)
    squares = np.empty(PERIODS)
    for k in range(PERIODS):
        state = np.array(strobe(state[0], state[1]), dtype=np.float64)
        squares[k] = float((state**2).sum())
    t = 2.0 * math.pi * np.arange(1, PERIODS + 1)
    late = slice(SETTLED, None)
    # Between the points of the map and the impacts before them lies a term of the order of V.
    terms = np.column_stack([t, np.sqrt(t), np.ones_like(t)])[late]
    fitted = numerics.least_squares(terms, squares[late], 1e-14)
    rate = float(fitted[0])
    rest = squares[late] - (terms * fitted).sum(axis=1)
    error = float(np.abs(rest).max() / t[-1])
    expected = limit_constant(0.0)[0] ** 2
    what = "growth of x^2 + v^2 per time at t = 2 pi k, by the stroboscopic map from rest"
    return Finding(
        (compare(f"{what}: 0 if it misses the resonance", rate, 0.0, 1e-3, error=error),),
        (
            compare(f"{what}: sin(2 psi)/2", rate, expected, 1e-3, error=error),
            Measurement(
                "least growth in one period: no fixed point is near",
                float(np.diff(squares)[late].min()),
                0.0,
                math.inf,
                error=PERIODS * float(np.spacing(squares[-1])),
            ),
        ),
        "a map of points at multiples of the driving period misses nothing; what misses the "
        "half-harmonic is to look for its fixed points alone",
        remark=(
            "Such a map takes any state to the state a period later. It assumes nothing of the "
            "times between impacts, commensurate or not, and its iterates are the motion. A "
            "resonance is no fixed point of it, so an analysis of fixed points and of their "
            "stability does not see it: so far the article is right. The impact times and "
            "velocities, by which the article analyses the resonance in section 5, are themselves "
            "points of a Poincare map, as its section 2 says."
        ),
        study=motion_text(simulate(osc, sine(1), t_end=float(t[-1]))),
    )


STATEMENTS = (
    Statement(
        id="poincare-maps",
        reference="conclusion",
        claim="Poincare maps at multiples of the driving period are insufficient: some important "
        "cases, such as subharmonic resonances, are missed.",
        method="3000 iterates of the stroboscopic map under sin t",
        find=partial(_poincare, WALL),
        theory="half-harmonic.md",
    ),
)
