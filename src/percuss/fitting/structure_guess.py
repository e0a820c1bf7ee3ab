"""The nodes of a structure's record and their first states, by a filter along the record.

The samples of one accelerometer between two impacts hardly determine a state: the other coordinates
show only in the course of the motion. So the state is carried from node to node with its
uncertainty, and corrected by the samples of each segment (the square-root information filter of
Bierman 1977, with the model itself in place of its linearisation).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.fitting.measured import MeasuredRecord
from percuss.fitting.shooting import Layout, Shots, shoot
from percuss.kernels.structure.sample import evaluate
from percuss.model.acting_sets import StructureSystem
from percuss.model.exact import as_float
from percuss.model.oscillator import Wall
from percuss.model.paths import replace_parameters
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.follow_structure import followed
from percuss.numerics import hypot, log
from percuss.numerics.linear import directions, least_squares, matmul

# What a wrong guess of the parameters adds to the noise, in parts of the samples' size; and to a
# state that is carried on, in parts of its size.
WRONG = 0.1
# Standard deviation of an unknown state, in sizes of the motion.
WIDE = 3.0
# Steps of the correction in one segment, and halvings of a step.
CORRECTIONS, HALVINGS = 4, 4
# From node to node, in parts of the distance that was asked for.
NEAREST, FARTHEST = 0.6, 1.2
# Samples of a segment.
FEWEST = 6
MOST_IMPACTS = 100_000


class Guessed(NamedTuple):
    """A state with what is known of it: rows of the triangle R, where R (s - state) is normal."""

    state: Floats
    triangle: Floats


def lay_out_structure(
    structure: Structure, record: MeasuredRecord, values: Mapping[str, float], cycles: float
) -> tuple[Layout, Floats, Floats]:
    """Return the nodes of a structure's record, their first states, and standard errors of these.

    Parameters
    ----------
    structure
        The structure.
    record
        What was measured.
    values
        The parameters by their paths.
    cycles
        From node to node, in cycles of what was measured.

    Returns
    -------
    Layout, (n, 2 n_x) array, (2 n_x,) array
        The layout with the states, and the median errors.
    """
    moved, loads, start = replace_parameters(structure, record.force, record.start, values)
    assert start is None or isinstance(start, StructureStart)
    system = StructureSystem.of(moved, loads)
    given, record = record, replace(record, force=loads, start=start)
    begin, end = record.begin, record.end
    sizes = sizes_of(system, record, start)
    size = np.sqrt(np.mean(np.square(record.samples.values))) if len(record.samples) else 1.0
    length = cycles * cycle_of(record)
    if start is None:
        state, triangle = np.zeros(2 * moved.n), np.diag(1.0 / (WIDE * sizes))
    else:
        begin = min(as_float(start.t0), begin)
        state, triangle = np.concatenate([start.x, start.v]), np.zeros((0, 2 * moved.n))
    guess = Guessed(state, triangle)
    keys: set[int] = set()
    t, states, spans, errors = begin, [], [], []
    while True:
        until = next_node(system, record, guess.state, t, length, end)
        # At first the length of a segment is not known well: the state is that before it.
        layout = one_segment(record, start if t == begin else None, (t, until), keys)
        guess, shots, error = corrected(moved, layout, guess, float(size) * WRONG)
        states.append(guess.state)
        spans.append((t, until))
        errors.append(error)
        if until >= end:
            break
        guess = carried_on(shots, guess, WRONG * sizes, is_fixed=layout.is_fixed)
        t = until
    whole = np.array(spans)
    first = np.searchsorted(record.samples.t, whole[:, 0], side="left")
    first[0] = 0
    is_fixed = start is not None
    layout = Layout(given, whole, np.append(first, len(record.samples)), is_fixed, keys)
    known = np.array(errors)[is_fixed:] if len(errors) > 1 else np.array(errors)
    return layout, np.array(states), np.minimum(np.median(known, axis=0), sizes)


def sizes_of(
    system: StructureSystem, record: MeasuredRecord, start: StructureStart | None
) -> Floats:
    """Return how large displacements and velocities are, of the motion from the start or from rest."""
    n = system.structure.n
    x, v = (np.zeros(n), np.zeros(n)) if start is None else (start.x, start.v)
    begin = record.begin if start is None else as_float(start.t0)
    times = np.linspace(begin, record.end, 400)
    place = motion_at(system, (x, v, begin), times)
    sizes = np.sqrt(np.mean(np.square(place), axis=0)).T.reshape(-1)
    largest = np.repeat(sizes.reshape(2, n).max(axis=1), n)
    largest = np.where(largest > 0.0, largest, 1.0)
    return np.asarray(np.maximum(sizes, 0.1 * largest))


def motion_at(
    system: StructureSystem, start: tuple[Floats, Floats, float], times: Floats
) -> Floats:
    """Return displacements and velocities, (n_times, n, 2), of the motion from a state."""
    place = np.zeros((len(times), system.structure.n, 2))
    run, _ = followed(system, start, float(times[-1]), MOST_IMPACTS)
    evaluate(run, times, True, place)
    return place


def cycle_of(record: MeasuredRecord) -> float:
    """Return the time of a cycle of what was measured: between every second passage of the mean."""
    samples = record.samples
    length = record.end - record.begin
    kinds = np.unique(samples.quantities)
    cycles = []
    for kind in kinds.tolist():
        values = samples.values[samples.quantities == kind]
        off = values - np.mean(values)
        noise = 3.0 * float(np.median(samples.noise[samples.quantities == kind]))
        # What is nearer to the mean than noise is no passage.
        signs = np.sign(off[np.abs(off) > min(noise, float(np.std(values)))])
        cycles.append(2.0 * length / max(int(np.count_nonzero(signs[1:] != signs[:-1])), 2))
    least = FEWEST * length / max(len(samples) / max(len(kinds), 1), 1.0)
    return max(min(cycles, default=length), least)


def next_node(
    system: StructureSystem,
    record: MeasuredRecord,
    state: Floats,
    t: float,
    length: float,
    end: float,
) -> float:
    """Return where the next node is: at a sample at which all walls are far."""
    if end - t < (NEAREST + FARTHEST) * length:
        return end
    samples = record.samples.t
    times = samples[(samples >= t + NEAREST * length) & (samples <= t + FARTHEST * length)]
    if not len(times):
        later = samples[samples > t + FARTHEST * length]
        return float(later[0]) if len(later) else end
    structure, n = system.structure, system.structure.n
    walls = [i for i, stop in enumerate(structure.stops) if isinstance(stop, Wall)]
    if not walls:
        return float(times[len(times) // 2])
    place = motion_at(system, (state[:n], state[n:], t), times)
    clearance = np.full(len(times), math.inf)
    for i in walls:
        normal = system.sets.normals[i]
        own = (place[:, :, 0] * normal).sum(axis=1) - system.signs[i] * as_float(
            structure.stops[i].at
        )
        clearance = np.minimum(clearance, own / (np.std(own) or 1.0))
    return float(times[int(np.argmax(clearance))])


def one_segment(
    record: MeasuredRecord,
    start: StructureStart | None,
    span: tuple[float, float],
    keys: set[int],
) -> Layout:
    """Return the layout of one segment alone."""
    samples = record.samples
    inside = (samples.t >= span[0]) & (samples.t < span[1])
    if span[1] >= record.end:
        inside = samples.t >= span[0]
    own = samples.taken(inside)
    record_of_segment = MeasuredRecord(own, samples.taken(slice(0, 0)), record.force, start)
    return Layout(
        record_of_segment, np.array([span]), np.array([0, len(own)]), start is not None, keys
    )


def corrected(
    structure: Structure, layout: Layout, guess: Guessed, wrong: float
) -> tuple[Guessed, Shots, Floats]:
    """Return the state by the samples of its segment too, its run, and errors by these alone."""
    samples = layout.record.samples
    noise = hypot(samples.noise, wrong)
    state, d = guess.state, len(guess.state)

    def at(state: Floats) -> tuple[Shots, Floats, float]:
        shots = shoot(structure, (layout,), {}, state[None, :])
        right = (samples.values - shots.values[:, 0]) / noise
        off = matmul(guess.triangle, shots.nodes[0] - guess.state)
        if not shots.is_complete:
            return shots, right, math.inf
        # Misses beyond a few deviations count less: an impact may be missed.
        return shots, right, float(log(1.0 + right * right / 9.0).sum() * 9.0 + (off * off).sum())

    shots, right, cost = at(state)
    for _ in range(0 if layout.is_fixed else CORRECTIONS):
        if not math.isfinite(cost):
            break
        kept = 1.0 / np.sqrt(1.0 + right * right / 9.0)
        rows = shots.rows[:, 0] / noise[:, None] * kept[:, None]
        whole = np.concatenate([rows, guess.triangle])
        rest = np.concatenate([right * kept, -matmul(guess.triangle, shots.nodes[0] - guess.state)])
        step = least_squares(whole, rest, 1e-12)
        for _ in range(HALVINGS):
            trial = at(shots.nodes[0] + step)
            if trial[2] < cost:
                break
            step = 0.25 * step
        else:
            break
        gain = cost - trial[2]
        shots, right, cost = trial
        if gain < 1e-3 * cost:
            break
    if not math.isfinite(cost):
        reason = "no motion can be followed from the guess; give others"
        raise ParameterError("free", layout.spans[0].tolist(), reason)
    state = shots.nodes[0]
    rows = shots.rows[:, 0] / noise[:, None]
    triangle = triangle_of(np.concatenate([rows, guess.triangle]))
    alone = np.concatenate([shots.rows[:, 0] / samples.noise[:, None], guess.triangle[:d]])
    return Guessed(state, triangle), shots, errors_of(alone)


def triangle_of(rows: Floats) -> Floats:
    """Return a triangle, or fewer rows, with the same products of columns."""
    sizes, own = directions(rows)
    return np.asarray(sizes[:, None] * own[: len(sizes)])


def errors_of(rows: Floats) -> Floats:
    """Return the standard errors of unknowns with these equations."""
    sizes, own = directions(rows)
    known = sizes > 1e-12 * sizes[0] if len(sizes) else sizes > 0.0
    parts = own[: len(sizes)][known] / sizes[known, None]
    return np.asarray(np.sqrt((parts * parts).sum(axis=0)))


def carried_on(shots: Shots, guess: Guessed, wrong: Floats, *, is_fixed: bool) -> Guessed:
    """Return the state at a segment's end, with what is known of it there."""
    d = len(guess.state)
    spread = np.diag(wrong)
    if not is_fixed:
        sizes, own = directions(guess.triangle)
        sizes = np.maximum(sizes, 1e-12 * sizes[0])
        back = own[: len(sizes)].T / sizes
        spread = np.concatenate([matmul(shots.end_rows[0, :, -d:], back), spread], axis=1)
    covariance = matmul(spread, spread.T)
    units = np.sqrt(np.diag(covariance))
    values, own = directions(covariance / units / units[:, None])
    triangle = own[: len(values)] / np.sqrt(np.maximum(values, 1e-14))[:, None] / units
    return Guessed(shots.ends[0].copy(), triangle)
