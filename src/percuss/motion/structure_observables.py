"""Observables of a structure's run: their values, their extremes, and where they pass a level."""

from __future__ import annotations

import math
from typing import NamedTuple, get_args

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.kernels.law_columns import FIRST_HARMONIC, OMEGA
from percuss.kernels.structure import basis as at
from percuss.kernels.structure import observe
from percuss.kernels.structure.basis import Sets
from percuss.kernels.structure.bounds import fill_guard_bounds
from percuss.kernels.structure.observe import Gauge
from percuss.kernels.structure.run import StructureRun
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float, whole
from percuss.model.oscillator import On, SoftStop
from percuss.motion.extremes import Extrema, QuantityName, told_instant

# Rows that one call of the kernels writes.
AT_ONCE = 16_384
# A part of an observable below this many units of rounding of its terms is none: what a wall holds
# does not move.
CLEAN = 64.0 * 2.0**-52
# Values that differ by less than this part of the largest are one.
PLATEAU = 64.0 * 2.0**-52


class LinearForm(NamedTuple):
    """A linear function of the modes and the loads in one set, as a guard is.

    of_u, of_w: (n,); feed: (m, 2); record_feed, slope_feed: (r,), what the values and the slopes of
    records add.
    """

    of_u: Floats
    of_w: Floats
    constant: float
    feed: Floats
    record_feed: Floats
    slope_feed: Floats

    def plus(self, other: LinearForm, factor: float) -> LinearForm:
        """Return the sum with a multiple of another form."""
        return LinearForm(
            self.of_u + factor * other.of_u,
            self.of_w + factor * other.of_w,
            self.constant + factor * other.constant,
            self.feed + factor * other.feed,
            self.record_feed + factor * other.record_feed,
            self.slope_feed + factor * other.slope_feed,
        )


def extremes_of_run(
    system: StructureSystem,
    run: StructureRun,
    span: tuple[float, float],
    of: str,
    stop: int,
    on: On | None,
) -> Extrema:
    """Return the extremes of a quantity; see `StructureTrajectory.extremes`."""
    gauge = _gauge(run, _forms(system, run.sets, of, stop, on), None)
    rows = np.concatenate(_traced(run, gauge, span, stop if of == "stop_force" else -1))
    values, t = rows[:, observe.AT_VALUE], rows[:, observe.AT_T]
    least, most = float(values.min()), float(values.max())
    # A wall is reached at each impact, to within rounding: of all these instants the first.
    slack = PLATEAU * max(abs(least), abs(most))
    return Extrema(
        least,
        told_instant(run.events, span, float(t[np.argmax(values <= least + slack)])),
        most,
        told_instant(run.events, span, float(t[np.argmax(values >= most - slack)])),
    )


def passages_of_run(
    system: StructureSystem, run: StructureRun, t_end: float, level: float, on: On | None
) -> Floats:
    """Return (t, y') of each passage of a displacement up to t_end, (n, 2)."""
    gauge = _gauge(run, _forms(system, run.sets, "displacement", 0, on), level)
    parts = [
        rows[rows[:, observe.AT_KIND] == observe.PASSAGE][:, [observe.AT_T, observe.AT_SLOPE]]
        for rows in _traced(run, gauge, (-math.inf, t_end), -1)
    ]
    return np.concatenate(parts) if parts else np.zeros((0, 2))


def turning_points_of_run(run: StructureRun, c: Floats, t_end: float) -> Floats:
    """Return (t, y, y'') of each instant at which y = c . x turns up to t_end, (n, 3).

    None is missed but one at the start or at the end itself.
    """
    forms: list[LinearForm | None] = [
        displacement_form(run.sets, b, c) for b in range(len(run.sets.keys))
    ]
    rows = np.concatenate(_traced(run, _gauge(run, forms, None), (-math.inf, t_end), -1))
    turns = rows[rows[:, observe.AT_KIND] == observe.PASSAGE]
    return np.asarray(turns[:, [observe.AT_T, observe.AT_VALUE, observe.AT_SLOPE]])


def observable_at(
    system: StructureSystem,
    run: StructureRun,
    times: Floats,
    of: str,
    stop: int = 0,
    on: On | None = None,
) -> Floats:
    """Return a quantity at times (n,) of a run, that after an event at its instant."""
    gauge = _gauge(run, _forms(system, run.sets, of, stop, on), None)
    out = np.empty(len(times))
    observe.observe_at(run, gauge, times, True, out)
    return out


def part_at(run: StructureRun, b: int, form: LinearForm, times: Floats) -> Floats:
    """Return a linear form of the modes in a set at times (n,) at which that set acts, else 0."""
    forms: list[LinearForm | None] = [None] * len(run.sets.keys)
    forms[b] = form
    out = np.empty(len(times))
    observe.observe_at(run, _gauge(run, forms, None), times, True, out)
    return out


def _traced(run: StructureRun, gauge: Gauge, span: tuple[float, float], stop: int) -> list[Floats]:
    """Return the turning points, or the passages, of an observable between two instants, in parts."""
    progress = np.zeros(observe.PROGRESS_ENTRIES)
    progress[observe.STOP] = stop
    parts: list[Floats] = []
    while True:
        rows = np.empty((AT_ONCE, observe.TRACE_COLUMNS))
        count = observe.trace(run, gauge, span, progress, rows)
        if count == 0:
            return parts
        parts.append(rows[:count])


def _forms(
    system: StructureSystem, sets: Sets, of: str, stop: int, on: On | None
) -> list[LinearForm | None]:
    """Return a quantity in each set, None where it is 0."""
    if of not in get_args(QuantityName):
        raise ParameterError("of", of, f"none of {', '.join(get_args(QuantityName))}")
    structure = system.structure
    if of == "stop_force":
        number = whole("stop", stop, 0)
        if number >= len(structure.stops):
            reason = f"the structure has {len(structure.stops)} stops, counted from 0"
            raise ParameterError("stop", stop, reason)
        return [_stop_force(system, sets, b, number) for b in range(len(sets.keys))]
    c = structure.direction(on)
    if of == "spring_force":
        c = -(c[:, None] * structure.stiffness_matrix).sum(axis=0)
    forms: list[LinearForm | None] = []
    for b in range(len(sets.keys)):
        form = displacement_form(sets, b, c)
        if of in ("velocity", "acceleration"):
            form = _velocity(sets, b, form)
        forms.append(_slope(sets, b, form) if of == "acceleration" else form)
    return forms


def _stop_force(system: StructureSystem, sets: Sets, b: int, i: int) -> LinearForm | None:
    """Return the force of a stop along its c in a set."""
    if not int(sets.keys[b]) >> i & 1:
        return None
    stop = system.structure.stops[i]
    if isinstance(stop, SoftStop):
        y = displacement_form(sets, b, system.structure.stop_directions[i])
        y = y._replace(constant=y.constant - as_float(stop.at))
        zero = y.plus(y, -1.0)
        force = zero.plus(y, -as_float(stop.stiffness))
        return force.plus(_velocity(sets, b, y), -as_float(stop.damping))
    sign = float(system.signs[i])
    nothing = np.zeros(len(sets.records))
    return LinearForm(
        sign * sets.guard[b, i, :, at.OF_U],
        sign * sets.guard[b, i, :, at.OF_W],
        sign * float(sets.levels[b, i, at.CONSTANT]),
        sign * sets.feed[b, i],
        sign * sets.record_feed[b, i],
        nothing,
    )


def displacement_form(sets: Sets, b: int, c: Floats) -> LinearForm:
    """Return c . x in a set."""
    shape = sets.shape[b].transpose(2, 0, 1)
    parts = [c[:, None] * shape[:, :, k] for k in range(2)]
    of_u, of_w = (
        np.where(
            np.abs(part.sum(axis=0)) <= CLEAN * np.abs(part).sum(axis=0), 0.0, part.sum(axis=0)
        )
        for part in parts
    )
    m, r = sets.turns.shape[2], len(sets.records)
    nothing = np.zeros(r)
    return LinearForm(
        of_u, of_w, float((c * sets.offset[b]).sum()), np.zeros((m, 2)), nothing, nothing
    )


def _velocity(sets: Sets, b: int, y: LinearForm) -> LinearForm:
    """Return the derivative of a displacement, which no load enters."""
    slope = _slope(sets, b, y)
    nothing = np.zeros_like(y.record_feed)
    return LinearForm(slope.of_u, slope.of_w, 0.0, np.zeros_like(y.feed), nothing, nothing)


def _slope(sets: Sets, b: int, form: LinearForm) -> LinearForm:
    """Return the derivative of a form in time."""
    p, q = form.of_u, form.of_w
    modes, drive, into = sets.modes[b], sets.drive[b], sets.record_drive[b]
    omegas = sets.law[b, FIRST_HARMONIC : FIRST_HARMONIC + len(form.feed), OMEGA]
    feed = np.stack([omegas * form.feed[:, 1], -omegas * form.feed[:, 0]], axis=1)
    feed += (p[:, None, None] * drive[:, :, at.RATE_COS :]).sum(axis=0)
    feed += (q[:, None, None] * drive[:, :, : at.RATE_COS]).sum(axis=0)
    return LinearForm(
        -modes[:, at.SPRING] * q,
        p - modes[:, at.DRAG] * q,
        float((p * modes[:, at.RATE] + q * modes[:, at.FORCE]).sum()),
        feed,
        (p[:, None] * into[:, :, 1] + q[:, None] * into[:, :, 0]).sum(axis=0),
        form.record_feed,
    )


def _gauge(run: StructureRun, forms: list[LinearForm | None], level: float | None) -> Gauge:
    """Return the gauge of a quantity: of its derivative, or of its difference from a level."""
    sets = run.sets
    b, n, m, r = len(forms), sets.modes.shape[1], sets.turns.shape[2], len(sets.records)
    k = observe.GAUGE_ROWS
    acts = np.array([float(form is not None) for form in forms])
    guard, levels = np.zeros((b, k, n, at.GUARD_ENTRIES)), np.zeros((b, k, at.LEVEL_COLUMNS))
    feed, record_feed = np.zeros((b, k, m, 2)), np.zeros((b, k, r))
    slope_feed = np.zeros((b, k, r))
    for i, form in enumerate(forms):
        if form is None:
            continue
        watched = _slope(sets, i, form) if level is None else form
        if level is not None:
            watched = watched._replace(constant=watched.constant - level)
        opposite = watched.plus(watched, -2.0)
        for row, form_of_row in enumerate((form, watched, opposite)):
            guard[i, row, :, at.OF_U], guard[i, row, :, at.OF_W] = (
                form_of_row.of_u,
                form_of_row.of_w,
            )
            levels[i, row, at.CONSTANT] = form_of_row.constant
            levels[i, row, at.IS_FED] = 1.0
            feed[i, row], record_feed[i, row] = form_of_row.feed, form_of_row.record_feed
            slope_feed[i, row] = form_of_row.slope_feed
        omegas = sets.law[i, FIRST_HARMONIC : FIRST_HARMONIC + m, OMEGA].copy()
        fill_guard_bounds(sets.modes[i], sets.drive[i], omegas, guard[i], feed[i], levels[i])
    return Gauge(
        acts, guard, levels, feed, record_feed, slope_feed,
        present=np.zeros((k, at.LEVEL_COLUMNS)),
        values=np.zeros(k), order=np.zeros(k), free=np.zeros(k),
        scratch=np.zeros((8, max(n, m, k), run.scratch.shape[2])),
    )  # fmt: skip
