"""Whether neighbours of a motion part or meet: the largest exponent of a finite run."""

from __future__ import annotations

import math

from percuss.errors import PercussError
from percuss.motion.outcome import Outcome
from percuss.motion.trajectory import Trajectory
from percuss.studies.study import Study
from percuss.web.question import motion_of

__all__ = ["exponent_of"]

# Forcing periods left out, and those that the exponent is taken over.
TRANSIENT, PERIODS = 200, 1000
# Events times parts of the force in the run to the attractor: motions with more take too long.
MOST_TERMS = 200_000
# So many standard errors are no chance, and neighbours that part by a power of the time, t^2 at
# most, seem to have the exponent 2 ln T / T after a time T.
CERTAIN, POWER = 5.0, 2.0


def exponent_of(study: Study, run: Trajectory) -> dict[str, object] | None:
    """Return the largest Lyapunov exponent of a motion over a finite time.

    Parameters
    ----------
    study
        The motion.
    run
        The same, followed to its attractor.

    Returns
    -------
    dict or None
        `value` [1/time], None for minus infinity: a contact ends all memory; `error`, its standard
        error; `is_chaotic`, whether it is above 0 beyond that error and beyond what a growth by a
        power of the time makes; `is_settling`, whether it is as far below 0; `n_periods`, what it
        is taken over. None where it takes too long or there is none.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.studies import Limits, Motion
    >>> asked = Motion(pc.Start(0, "0.5"), Limits(periods=10))
    >>> study = Study(pc.impact_oscillator("0.8", side="above"), pc.cosine("2.8"), asked)
    >>> run = pc.simulate(study.oscillator, study.forcing, v0="0.5", periods=10)
    >>> exponent_of(study, run)["is_chaotic"]
    True
    """
    from percuss.ensembles import lyapunov_exponents

    force = study.forcing
    if force is None or force.period is None:
        return None
    if run.outcome in (Outcome.interrupted, Outcome.overflow):
        return None
    events = len(run.impacts) + len(run.crossings) + len(run.contacts)
    if events * (1 + len(force.components())) > MOST_TERMS:
        return None
    try:
        found = lyapunov_exponents(
            study.oscillator,
            force,
            start=motion_of(study).start,
            transient=TRANSIENT,
            periods=PERIODS,
        )
    except PercussError:
        return None
    value, error = float(found.exponents[0]), float(found.errors[0])
    lasting = PERIODS * force.period
    least = max(CERTAIN * error, POWER * math.log(lasting) / lasting if lasting > 1.0 else 0.0)
    return {
        "value": value if math.isfinite(value) else None,
        "error": error,
        "is_chaotic": bool(value > least),
        "is_settling": bool(value < -least),
        "n_periods": PERIODS,
    }
