"""A motion as the page shows it: curve, portrait, impacts and spectrum."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Flags, Floats
from percuss.model.exact import as_float
from percuss.motion.energetics import forces_at
from percuss.motion.entries import entry_rows
from percuss.motion.impact_times import classify_impact_times
from percuss.motion.simulate import simulate
from percuss.motion.spectrum import fast_amplitudes
from percuss.motion.trajectory import AnyRun, Outcome, Trajectory
from percuss.plotting.samples import (
    FEWEST_POINTS,
    LARGEST,
    POINTS_PER_CYCLE,
    SampledMotion,
    reduce_to_columns,
    sample_curve,
)
from percuss.studies.study import Study
from percuss.web.frame import frame
from percuss.web.mechanisms import elements_of_oscillator
from percuss.web.request import BadRequest, PageRequest, RunningRequest, motion_of, study_of

# A slider waits no longer [s], and for no more impacts; the motion up to there is shown.
PATIENCE = 1.0
MOST_IMPACTS = 50_000
# Terms of the formulas that are evaluated for a curve: some 0.2 s of computing.
MOST_TERMS = 1_600_000
# Points of the transform of a spectrum; frequencies up to so many times the highest of the motion
# are shown.
TRANSFORMED, REACH = 4096, 8.0
# Number of impacts in the section: the last ones.
SHOWN_IMPACTS = 4000


@dataclass(frozen=True, slots=True)
class Followed:
    """A motion, and its computing time [s]."""

    run: Trajectory
    seconds: float


def followed(study: Study, running: RunningRequest | None = None) -> Followed:
    """Follow the motion of a study for as long as a slider can wait."""
    running = running or RunningRequest()
    began = running.seconds()
    motion = motion_of(study)
    limit = min(motion.limits.max_impacts or MOST_IMPACTS, MOST_IMPACTS)
    start = motion.start
    run = simulate(
        study.oscillator,
        study.forcing,
        start.x0,
        start.v0,
        start.t0,
        t_end=motion.end(study.forcing),
        max_impacts=limit,
        progress=running.progress(0.0, 0.0, PATIENCE),
    )
    return Followed(run, running.seconds() - began)


def answer_explore(request: PageRequest, running: RunningRequest | None = None) -> bytes:
    """Return the curves of a motion.

    Parameters
    ----------
    request
        With the option ``points`` (of a curve) and, for a part of the run, ``window``.
    running
        State of the answer; default: a new one.

    Returns
    -------
    bytes
        A frame: t, x of the curve in the window; velocity_t, v of its velocity; force_t0, force0,
        ... of the forces of the stops that act; portrait_t, portrait_x, portrait_v of its end;
        cycle, speed, impulse, event_stop and event_t of the impacts; omega, amplitude of the
        spectrum. `elements` of the picture, and facts.

    Raises
    ------
    StudyError, BadRequest
        If there is no such motion.
    """
    points = int(request.number("points", 4000, 100, 20_000))
    study = study_of(request.tables)
    motion = followed(study, running)
    run = motion.run
    window = window_of(request, run.t0, run.t_end)
    curve, is_band = _curve(run, window)
    t, x, _ = _drawn(curve, curve.x, points)
    velocity_t, v, _ = _drawn(curve, curve.v, points)
    end = sample_curve(run, _end_of(run, window, points)) if is_band else curve
    tail = moving(end)[-points:]
    period = None if run.forcing is None else run.forcing.period
    header = {
        **header_of_run(request, run, window, period, motion_of(study).limits.max_impacts),
        "n_impacts": len(run.impacts),
        "n_crossings": len(run.crossings),
        "n_entries": len(entry_rows(run)),
        "impact_times": _class_of(run),
        "contacts": _contacts(run),
        "elements": elements_of_oscillator(study.oscillator, study.forcing),
        "milliseconds": 1e3 * motion.seconds,
    }
    arrays = {
        "t": t,
        "x": x,
        "velocity_t": velocity_t,
        "v": v,
        **_forces(run, curve, points),
        "portrait_t": end.t[tail],
        "portrait_x": end.x[tail],
        "portrait_v": end.v[tail],
        **_section(run),
        **_spectrum(run),
    }
    return frame(header, arrays)


def _drawn(curve: SampledMotion, values: Floats, points: int) -> tuple[Floats, Floats, Flags]:
    """Return the points of a curve that a picture so many points wide is drawn from."""
    return reduce_to_columns(curve.t, values, curve.jumps, columns=points // 2, most=points)


def _forces(run: Trajectory, curve: SampledMotion, points: int) -> dict[str, Floats]:
    """Return the forces of the stops along a curve, of those that act."""
    arrays: dict[str, Floats] = {}
    if len(run.crossings) == 0 and len(run.contacts) == 0:
        return arrays
    _, forces = forces_at(run.system, run.contacts, curve.t, curve.x, curve.v)["stops"]
    for i, force in enumerate(forces):
        if force.any():
            t, shown, _ = _drawn(curve, force, points)
            arrays |= {f"force_t{i}": t, f"force{i}": shown}
    return arrays


def header_of_run(
    request: PageRequest,
    run: AnyRun,
    window: tuple[float, float] | None,
    period: float | None,
    own: int | None,
) -> dict[str, object]:
    """Return what is told of every run; ``own`` is the study's own limit of impacts."""
    at_limit = run.outcome is Outcome.reached_max_impacts and (own is None or own > MOST_IMPACTS)
    return {
        "id": request.id,
        "kind": request.kind,
        "t0": run.t0,
        "t_end": run.t_end,
        "window": window,
        "period": period,
        "outcome": run.outcome.value,
        # By the page, and not by the study's own limit.
        "is_cut": at_limit or run.outcome is Outcome.interrupted,
        "n_contacts": len(run.contacts),
        "n_grazes": len(run.grazes),
    }


def window_of(request: PageRequest, t0: float, t_end: float) -> tuple[float, float] | None:
    """Return the requested part of the run, None for all of it."""
    given = request.options.get("window")
    if given is None:
        return None
    if not isinstance(given, list) or len(given) != 2:
        raise BadRequest("the window is not a pair of times")
    low, high = given
    if any(isinstance(time, bool) or not isinstance(time, int | float) for time in given):
        raise BadRequest("the window is not a pair of times")
    if not all(abs(time) < LARGEST for time in given):
        raise BadRequest("the window is not a pair of finite times")
    # The window may be that of an earlier motion, and lie outside of this one.
    low, high = max(float(low), t0), min(float(high), t_end)
    return (low, high) if low < high else None


def _curve(run: Trajectory, window: tuple[float, float] | None) -> tuple[SampledMotion, bool]:
    """Return each piece of the motion, or where that takes too long a band, and whether it is one.

    A band has more cycles than there are pixels: points at any times show it.
    """
    low, high = window or (run.t0, run.t_end)
    events = _events(run)
    within = np.searchsorted(events, high) - np.searchsorted(events, low)
    cycles = (high - low) * _fastest(run) / (2.0 * np.pi)
    affordable = MOST_TERMS // (1 + len(run.forcing.components() if run.forcing else ()))
    if FEWEST_POINTS * within + POINTS_PER_CYCLE * cycles <= affordable:
        return sample_curve(run, window), False
    t = np.linspace(low, high, affordable // 4)
    x, v = run(t)
    shown = (np.abs(x) < LARGEST) & (np.abs(v) < LARGEST)
    shown[0] = True
    return SampledMotion(
        t[shown], x[shown], v[shown], np.zeros(int(shown.sum()), dtype=np.bool_)
    ), True


def _end_of(
    run: Trajectory, window: tuple[float, float] | None, points: int
) -> tuple[float, float] | None:
    """Return the last part of a window that makes so many points."""
    low, high = window or (run.t0, run.t_end)
    events = _events(run)
    last = int(np.searchsorted(events, high))
    first = last - points // FEWEST_POINTS - 2
    duration = 2.0 * np.pi * points / (POINTS_PER_CYCLE * _fastest(run))
    begin = max(low, high - duration, float(events[first]) if first >= 0 else low)
    return (begin, high) if begin < high else window


def moving(curve: SampledMotion) -> NDArray[np.intp]:
    """Return the indices of a curve without the insides of rests, one dot in a portrait."""
    rests = np.zeros(len(curve.t), dtype=np.bool_)
    at_rest = curve.v == 0.0
    rests[1:-1] = at_rest[:-2] & at_rest[1:-1] & at_rest[2:]
    return np.flatnonzero(~rests)


def _events(run: Trajectory) -> Floats:
    """Return the times at which one formula of the motion ends and another begins."""
    return np.sort(np.concatenate([run.impacts.t, run.crossings.t, run.contacts.start]))


def _class_of(run: Trajectory) -> dict[str, object]:
    pattern = classify_impact_times(run)
    return {
        "kind": pattern.kind,
        "n_impacts": pattern.n_impacts,
        "n_periods": pattern.n_periods,
        "rate": pattern.rate if math.isfinite(pattern.rate) else None,
    }


def _contacts(run: Trajectory) -> list[list[float]]:
    """Return start and release of the first contacts."""
    contacts = run.contacts
    return [
        [float(start), float(release)]
        for start, release in zip(contacts.start[:8], contacts.release[:8], strict=True)
    ]


def _section(run: Trajectory) -> dict[str, Floats]:
    """Return the impacts, or without walls the entries into soft stops, as points."""
    impacts = run.impacts
    if len(impacts):
        last = slice(-SHOWN_IMPACTS, None)
        speed = np.abs(impacts.v_before[last])
        return {
            "cycle": impacts.cycle[last],
            "speed": speed,
            "event_stop": impacts.stop[last].astype(float),
            "impulse": impacts.impulse[last],
            "event_t": impacts.t[last],
        }
    entered = entry_rows(run)[-SHOWN_IMPACTS:]
    t = run.crossings.t[entered]
    period = run.forcing.period if run.forcing is not None else None
    cycle = np.mod(t / period, 1.0) if period else np.zeros(len(t))
    return {
        "cycle": cycle,
        "speed": np.abs(run.crossings.v[entered]),
        "event_stop": run.crossings.stop[entered].astype(float),
        "impulse": np.full(len(t), np.nan),
        "event_t": t,
    }


def _spectrum(run: Trajectory) -> dict[str, Floats]:
    """Return the amplitudes of the later half of the run, or of what the points can resolve."""
    fastest = _fastest(run)
    longest = TRANSFORMED * np.pi / (2.0 * REACH * fastest)
    half = 0.5 * (run.t_end - run.t0)
    if half <= 0.0:
        return {"omega": np.empty(0), "amplitude": np.empty(0)}
    begin = max(run.t_end - half, run.t_end - longest)
    omega, amplitude = fast_amplitudes(run, begin, run.t_end, TRANSFORMED)
    shown = (omega <= REACH * fastest) & (amplitude < LARGEST)
    # At zero the coefficient is twice the mean.
    amplitude[:1] *= 0.5
    return {"omega": omega[shown], "amplitude": amplitude[shown]}


def _fastest(run: Trajectory) -> float:
    """Return the highest frequency of forcing and spring."""
    stiffness = as_float(run.oscillator.of_unit_mass().stiffness)
    harmonics = () if run.forcing is None else run.forcing.components()
    return (
        max([stiffness**0.5 if stiffness > 0.0 else 0.0, *(as_float(h.omega) for h in harmonics)])
        or 1.0
    )
