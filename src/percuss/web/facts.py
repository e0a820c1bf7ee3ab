"""What percuss knows of a motion beside its curves: the nearest periodic orbit."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from percuss.errors import PercussError
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.orbits.find import find_orbit
from percuss.orbits.periodic_orbit import PeriodicOrbit
from percuss.studies.study import Study
from percuss.web.frame import frame
from percuss.web.question import Question, motion_of, study_of

__all__ = ["answer_facts", "nearest_orbit"]

# Periods after which a motion is near its attractor, and those looked at for a return.
SETTLING, LOOKED_AT = 200, 64
# The longest orbit looked for, in forcing periods, and how many returns are tried.
LONGEST, TRIES = 12, 3
MOST_IMPACTS = 20_000


def answer_facts(question: Question) -> bytes:
    """Return the periodic orbit that the motion comes nearest to, with its stability.

    Parameters
    ----------
    question
        With a study.

    Returns
    -------
    bytes
        A frame: `orbit`, its counts, multipliers and clearance, None where none was found; x, v of
        one round of it.

    Raises
    ------
    StudyError, BadQuestion
        If there is no such motion.
    """
    study = study_of(question.tables)
    orbit = nearest_orbit(study)
    header = {"id": question.id, "kind": "facts", "orbit": None if orbit is None else _told(orbit)}
    if orbit is None:
        return frame(header)
    run = orbit.trajectory()
    x, v = run(np.linspace(run.t0, run.t_end, 400))
    return frame(header, {"orbit_x": x, "orbit_v": v})


def _told(orbit: PeriodicOrbit) -> dict[str, object]:
    return {
        "n_impacts": orbit.n_impacts,
        "sticks": math.isinf(orbit.n_impacts),
        "n_periods": orbit.n_periods,
        "period": orbit.period,
        "stability": orbit.stability,
        "admissible": orbit.admissible,
        "multipliers": [[value.real, value.imag] for value in orbit.multipliers.tolist()],
        "grazing_margin": orbit.grazing_margin,
        "min_impact_speed": orbit.min_impact_speed,
        "x0": orbit.x0,
        "v0": orbit.v0,
        "t0": orbit.t0,
    }


def nearest_orbit(study: Study) -> PeriodicOrbit | None:
    """Return the periodic orbit that the end of a motion comes nearest to.

    Parameters
    ----------
    study
        The motion; it is followed for longer than the study says, to come near its attractor.

    Returns
    -------
    PeriodicOrbit or None
        The one found from the closest return of the motion to where it was whole periods before;
        None without a forcing period, or where no return leads to an orbit.
    """
    force = study.forcing
    if force is None or force.period is None:
        return None
    run = _settled(study)
    for n_periods, n_impacts, guess in _returns(run, force.period):
        try:
            return find_orbit(
                study.oscillator, force, n_impacts=n_impacts, n_periods=n_periods, guess=guess
            )
        except PercussError:
            continue
    return None


def _settled(study: Study) -> Trajectory:
    start = motion_of(study).start
    return simulate(
        study.oscillator,
        study.forcing,
        start.x0,
        start.v0,
        start.t0,
        periods=SETTLING + LOOKED_AT,
        max_impacts=MOST_IMPACTS,
    )


def _returns(
    run: Trajectory, period: float
) -> Iterator[tuple[int, int, Trajectory | tuple[float, float]]]:
    """Return (periods, impacts, guess) of the closest returns, closest first, short ones first."""
    entries = run.impacts
    last = run.t_end - LOOKED_AT * period
    recent = np.flatnonzero(entries.t >= max(last, run.t0))
    if len(recent) == 0:
        yield 1, 0, run
        return
    t, v, cycle = entries.t[recent], entries.v_after[recent], entries.cycle[recent]
    scale = float(np.abs(v).max()) or 1.0
    found: list[tuple[float, int, int, float, float]] = []
    for count in range(1, min(len(t) - 1, 4 * LONGEST) + 1):
        lasting = (t[count:] - t[:-count]) / period
        whole = np.rint(lasting)
        apart = np.abs(lasting - whole) + np.abs(v[count:] - v[:-count]) / scale
        apart[(whole < 1) | (whole > LONGEST)] = np.inf
        best = int(np.argmin(apart))
        if np.isfinite(apart[best]):
            row = float(apart[best]), int(whole[best]), count
            found.append((*row, float(cycle[best]), float(v[best])))
    # A short return that is as close as rounding is the period itself; its multiples are no closer.
    found.sort(key=lambda row: (max(row[0], 1e-6), row[1], row[2]))
    for _, n_periods, n_impacts, at, speed in found[:TRIES]:
        yield n_periods, n_impacts, (at, speed)
