"""Facts about a motion beyond its curves: the nearest periodic orbit, the Lyapunov exponent."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.model.oscillator import SoftStop, Wall
from percuss.motion.entries import entry_rows
from percuss.motion.trajectory import Outcome, Trajectory
from percuss.orbits import PeriodicOrbit
from percuss.orbits.finding.find import find_orbit
from percuss.orbits.finding.search_budget import swings_of
from percuss.plotting.samples import sample_curve
from percuss.studies.study import Study
from percuss.web.explore import moving
from percuss.web.frame import frame
from percuss.web.request import PageRequest, RunningRequest, motion_of, study_of

# Periods after which a motion is near its attractor, and those looked at for a return.
SETTLING, LOOKED_AT = 200, 64
# The longest orbit looked for, in forcing periods, and how many returns are tried.
LONGEST, TRIES = 12, 3
MOST_IMPACTS = 20_000
# How far the speed of an orbit may be from that of the motion, as a part of it.
NEAR = 0.25
# A clearance within so many times the residual of an orbit is 0.
MARGIN_ERRORS = 100.0
# What is counted at each kind of stop.
HITS = (("impact", Wall), ("entry", SoftStop))
# Motions whose periods are very long or very full are followed for so long [s].
PATIENCE = 1.0
# Forcing periods left out, and those that the exponent is taken over.
TRANSIENT, PERIODS = 200, 1000
# Events times harmonics in the run to the attractor: motions with more take too long.
MOST_TERMS = 200_000
# Swings in the time that the exponent is taken over: so many take the kernels about a second.
MOST_SWINGS = 1e10


def answer_facts(request: PageRequest, running: RunningRequest | None = None) -> bytes:
    """Return the periodic orbit that the motion comes nearest to, with its stability.

    Parameters
    ----------
    request
        With a study.
    running
        State of the answer; default: a new one.

    Returns
    -------
    bytes
        A frame: `orbit`, its counts, multipliers and clearance, None where none was found; x, v of
        one period of it; `hits`, whether its count is of impacts, of entries, or of both;
        `exponent`, as `exponent_of` returns it.

    Raises
    ------
    StudyError, BadRequest
        If there is no such motion.
    """
    study = study_of(request.tables)
    header: dict[str, object] = {"id": request.id, "kind": "facts"}
    if study.forcing is None or study.forcing.period is None:
        return frame({**header, "orbit": None, "exponent": None})
    run = _settled(study, running or RunningRequest())
    orbit = _nearest(study, run)
    stops = study.oscillator.stops
    header |= {
        "hits": [name for name, kind in HITS if any(isinstance(stop, kind) for stop in stops)],
        "orbit": None if orbit is None else _orbit_header(orbit),
        "exponent": exponent_of(study, run),
    }
    if orbit is None:
        return frame(header)
    curve = sample_curve(orbit.trajectory())
    shown = moving(curve)
    # Closed: the last impact leads to the first point.
    x, v = (np.append(column[shown], column[0]) for column in (curve.x, curve.v))
    return frame(header, {"orbit_x": x, "orbit_v": v})


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
    >>> question = Motion(pc.Start(0, "0.5"), Limits(periods=10))
    >>> study = Study(pc.impact_oscillator("0.8", side="above"), pc.cosine("2.8"), question)
    >>> run = pc.simulate(study.oscillator, study.forcing, v0="0.5", periods=10)
    >>> exponent_of(study, run)["is_chaotic"]
    True
    """
    from percuss.ensembles import lyapunov_exponents
    from percuss.ensembles.decisions import sign_of_exponent

    force = study.forcing
    if force is None or force.period is None:
        return None
    if run.outcome in (Outcome.interrupted, Outcome.overflow):
        return None
    events = len(run.impacts) + len(run.crossings) + len(run.contacts)
    if events * (1 + len(force.components())) > MOST_TERMS:
        return None
    if swings_of(run.system.law, (TRANSIENT + PERIODS) * force.period) > MOST_SWINGS:
        return None
    try:
        result = lyapunov_exponents(
            study.oscillator,
            force,
            start=motion_of(study).start,
            transient=TRANSIENT,
            periods=PERIODS,
        )
    except PercussError:
        return None
    value, error = float(result.exponents[0]), float(result.errors[0])
    sign = sign_of_exponent(value, error, PERIODS, force.period)
    return {
        "value": value if math.isfinite(value) else None,
        "error": error,
        "is_chaotic": sign > 0,
        "is_settling": sign < 0,
        "n_periods": PERIODS,
    }


def _orbit_header(orbit: PeriodicOrbit) -> dict[str, object]:
    # A clearance below the error of the orbit is none.
    grazes = abs(orbit.grazing_margin) <= MARGIN_ERRORS * max(orbit.residual, np.spacing(1.0))
    return {
        "n_impacts": orbit.n_impacts,
        "sticks": math.isinf(orbit.n_impacts),
        "n_periods": orbit.n_periods,
        "period": orbit.period,
        "stability": orbit.stability,
        "admissible": orbit.admissible or grazes,
        "grazes": grazes,
        "multipliers": [[value.real, value.imag] for value in orbit.multipliers.tolist()],
        "grazing_margin": 0.0 if grazes else orbit.grazing_margin,
        "min_impact_speed": orbit.min_impact_speed,
        "x0": orbit.x0,
        "v0": orbit.v0,
        "t0": orbit.t0,
    }


def _nearest(study: Study, run: Trajectory) -> PeriodicOrbit | None:
    """Return the periodic orbit that the end of a settled motion comes nearest to.

    It is found from the closest return of the motion to where it was whole periods before; None
    where no return leads to an orbit.
    """
    force = study.forcing
    if force is None or force.period is None or run.outcome is Outcome.interrupted:
        # A search follows such periods again and again: there is no time for it.
        return None
    formal = None
    for near_return in _returns(run, force.period):
        try:
            orbit = find_orbit(
                study.oscillator,
                force,
                n_impacts=near_return.n_impacts,
                n_periods=near_return.n_periods,
                guess=near_return.guess,
                formal=True,
            )
        except PercussError:
            continue
        if not _is_near(orbit, near_return.speed):
            continue
        if orbit.admissible:
            return orbit
        # No motion follows it; one that may be followed comes first.
        formal = formal or orbit
    return formal


@dataclass(frozen=True, slots=True)
class Return:
    """A stretch of a motion that almost closes: its counts, where to begin, and how fast it is."""

    n_impacts: float
    n_periods: int
    guess: Trajectory | tuple[float, float]
    speed: float


def _is_near(orbit: PeriodicOrbit, speed: float) -> bool:
    """Return whether an orbit is the one that a motion came close to: a search may have run away.

    Where a motion grows for ever it all but closes, and no orbit is near.
    """
    speeds = np.abs(orbit.impacts.v_after)
    return (
        len(speeds) == 0
        or math.isinf(orbit.n_impacts)
        or bool((np.abs(speeds - speed) <= NEAR * max(speed, 1e-3)).any())
    )


def _settled(study: Study, running: RunningRequest) -> Trajectory:
    return motion_of(study).simulated(
        study,
        periods=SETTLING + LOOKED_AT,
        max_impacts=MOST_IMPACTS,
        progress=running.progress(0.0, 0.0, PATIENCE),
    )


def _returns(run: Trajectory, period: float) -> Iterator[Return]:
    """Return the closest returns of impacts and entries, closest first, short ones first."""
    begin = max(run.t_end - LOOKED_AT * period, run.t0)
    release = run.contacts.release
    if (np.isfinite(release) & (run.contacts.start >= begin)).any():
        # Infinitely many impacts each time: the search begins at the contact.
        yield from (Return(math.inf, n_periods, run, 0.0) for n_periods in range(1, TRIES))
    t, v = _entries(run)
    recent = t >= begin
    t, v = t[recent], v[recent]
    if len(t) == 0:
        yield Return(0, 1, run, 0.0)
        return
    scale = float(np.abs(v).max()) or 1.0
    near_returns: list[tuple[float, int, int, int]] = []
    for count in range(1, min(len(t) - 1, 4 * LONGEST) + 1):
        duration = (t[count:] - t[:-count]) / period
        whole = np.rint(duration)
        distance = np.abs(duration - whole) + np.abs(v[count:] - v[:-count]) / scale
        distance[(whole < 1) | (whole > LONGEST)] = np.inf
        best = int(np.argmin(distance))
        if np.isfinite(distance[best]):
            near_returns.append((float(distance[best]), int(whole[best]), count, best))
    # A short return that is as close as rounding is the period itself; its multiples are no closer.
    near_returns.sort(key=lambda row: (max(row[0], 1e-6), row[1], row[2]))
    for _, n_periods, n_impacts, k in near_returns[:TRIES]:
        # The orbit enters soft stops: the search begins from the run itself.
        at = (t[k] / period) % 1.0, v[k]
        guess = run if len(run.crossings) else (float(at[0]), float(at[1]))
        yield Return(n_impacts, n_periods, guess, float(abs(v[k])))


def _entries(run: Trajectory) -> tuple[Floats, Floats]:
    """Return times and velocities after impacts and at entries into soft stops, in order."""
    entered = entry_rows(run)
    t = np.concatenate([run.impacts.t, run.crossings.t[entered]])
    v = np.concatenate([run.impacts.v_after, run.crossings.v[entered]])
    order = np.argsort(t, kind="stable")
    return t[order], v[order]
