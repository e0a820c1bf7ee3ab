"""Resonances between neighbours on a branch of orbits without events, at which one step is too long.

Such an orbit is the sum of what each harmonic of the forces excites in each mode, in proportion to
1 / D with the dynamic stiffness D = k - w^2 + 2 i a w. Lightly damped, a mode has a resonance far
narrower than a step, in which stops may be met. A record has infinitely many harmonics, of which
those next to a mode's own frequency are looked at.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from percuss.arrays import Complexes, Floats, Integers
from percuss.kernels import law_columns as at
from percuss.kernels.law_columns import Law
from percuss.kernels.record import NEXT_REGION
from percuss.kernels.structure.basis import (
    DRAG,
    FORCE,
    FORCE_COS,
    FORCE_SIN,
    RATE,
    RATE_COS,
    RATE_SIN,
    SPRING,
)
from percuss.model.exact import as_float
from percuss.numerics import matmul, modulus, phasor, times
from percuss.orbits.orbit.over_period import states_over_period
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

# A dynamic stiffness between two neighbours may fall below theirs by the first factor. Below the
# second one it is none: the amplitude has no bound.
STIFF, NONE = 0.9999, 1e-9
# In place of 0 in a denominator.
TINY = np.finfo(np.float64).tiny
# Inputs into modes below this part of the largest are rounding; so are harmonics of a record below
# that part of what its jumps and bends add up to.
NOT_DRIVEN, CANCELLED = 1e-12, 1e-10
# Harmonics of a record that resonate within one step: with more, the step is too long.
MOST_HARMONICS = 64
# Part of its size by which a motion may change from one neighbour to the next; what is a smaller
# part of its displacements is rounding.
COARSE, ROUNDING = 0.25, 1e-9
# What resonates is a peak of its own above this part of the motions at both neighbours.
PEAK = 1.25


class _Modes(NamedTuple):
    """Modes and what drives them.

    ``springs`` and ``drags`` are (n,), k and 2 a; ``inputs`` (n, m) the amplitudes of m harmonics
    of the frequencies ``omegas``, of which the first is a constant; ``of_records`` (n, r) those of
    r repeated records of the value 1.
    """

    springs: Floats
    drags: Floats
    omegas: Floats
    inputs: Floats
    records: tuple[Law, ...]
    of_records: Floats


class _Resonances(NamedTuple):
    """What each harmonic excites in each mode between two neighbours, in rows of equal length.

    ``swings`` are the largest amplitudes, ``falls`` by what factor dynamic stiffnesses fall, and
    ``modes`` the numbers of the modes. The first row is that of the first mode under the constant.
    """

    swings: Floats
    falls: Floats
    modes: Integers


def passes_resonance(before: PeriodicOrbit, after: PeriodicOrbit) -> bool:
    """Return whether an oscillator has a resonance between two neighbours without events."""
    region = int(before.record[1][0, NEXT_REGION])
    here, there = (_mode_of(orbit.system.law, region) for orbit in (before, after))
    met = _resonances(here, there)
    if not _matters(met.falls, formal=not (before.admissible or after.admissible)):
        return False
    rows = np.array([orbit.system.law[region] for orbit in (before, after)])
    springs = rows[:, at.STIFFNESS]
    if (met.falls < NONE).any() or not springs.all():
        return True
    if here.records:
        # What does not resonate goes from one to the other; what does may be hidden in their
        # displacements, too.
        rest = [states_over_period(orbit)[0] for orbit in (before, after)]
        swing = 2.0 * float(met.swings[met.falls < STIFF].sum())
    else:
        rest = [rows[:, at.ORIGIN] + rows[:, at.ORIGIN_FORCE] / springs]
        swing = float(met.swings[1:].sum())
    low, high = rows[:, at.LOWER].max(), rows[:, at.UPPER].min()
    return not low < np.min(rest) - swing <= np.max(rest) + swing < high


def changes_much(before: PeriodicOrbit, after: PeriodicOrbit, speed: float) -> bool:
    """Return whether an oscillator's motion without events changes much between two neighbours.

    By a part of its largest velocity, or of a given one. Under another force alone it changes as
    that does, however much: nothing is between that the two do not show.
    """
    region = int(before.record[1][0, NEXT_REGION])
    linear, other = (
        (*orbit.system.law[region, [at.STIFFNESS, at.DAMPING]], orbit.period)
        for orbit in (before, after)
    )
    if linear == other:
        return False
    (x, v), (y, w) = (states_over_period(orbit) for orbit in (before, after))
    size = max(float(np.abs(v).max()), float(np.abs(w).max()), speed)
    length = max(float(np.abs(x).max()), float(np.abs(y).max()))
    floor = ROUNDING * 2.0 * math.pi / before.period * length
    return float(np.abs(w - v).max()) > max(COARSE * size, floor)


def passes_modal_resonance(before: StructureOrbit, after: StructureOrbit) -> bool:
    """Return whether a structure has a resonance between two neighbours without events."""
    if not (before.is_steady and after.is_steady):
        return False
    met = _resonances(_modes_of(before), _modes_of(after))
    is_formal = not (before.admissible or after.admissible)
    if not _matters(met.falls, formal=is_formal) or (met.falls < NONE).any():
        return bool((met.falls < NONE).any())
    resonates = met.falls < STIFF
    swing = np.zeros(len(_order_of(before)))
    np.add.at(swing, met.modes[resonates], met.swings[resonates])
    shapes = np.maximum(_shapes_of(before), _shapes_of(after))
    return _is_peak(before, after, matmul(swing, shapes))


def _is_peak(before: StructureOrbit, after: StructureOrbit, swing: Floats) -> bool:
    """Return whether coordinates that swing so far between two neighbours may reach a stop there.

    Or whether they outgrow both motions.
    """
    places = [states_over_period(orbit)[0] for orbit in (before, after)]
    extents = [0.5 * (x.max(axis=0) - x.min(axis=0)) for x in places]
    if (swing > PEAK * np.maximum(*extents)).any():
        return True
    directions = before.structure.stop_directions
    for i, c in enumerate(directions):
        sides = [
            matmul(x, c) - as_float(orbit.structure.stops[i].at)
            for x, orbit in zip(places, (before, after), strict=True)
        ]
        room = float(np.abs(sides).min()) if np.ptp(np.sign(sides)) == 0.0 else 0.0
        # What resonates goes, and may be hidden in the displacements, too.
        if room <= 2.0 * float(matmul(np.abs(c), swing)):
            return True
    return False


def _mode_of(law: Law, region: int) -> _Modes:
    own, rows = law[region], law[_harmonics(law)]
    waves = rows[rows[:, at.OMEGA] > 0.0]
    has_record = law[0, at.N_KNOTS] > 0.0
    return _Modes(
        own[[at.STIFFNESS]],
        2.0 * own[[at.DAMPING]],
        np.append(0.0, waves[:, at.OMEGA]),
        np.abs(np.append(own[at.ORIGIN_FORCE], waves[:, at.AMPLITUDE]))[None, :],
        (law,) if has_record else (),
        np.ones((1, int(has_record))),
    )


def _modes_of(orbit: StructureOrbit) -> _Modes:
    """Return the modes of a structure by their frequencies."""
    sets, b = orbit.run.record.sets, _set_of(orbit)
    modes, law, order = sets.modes[b], sets.law[b], _order_of(orbit)
    # A mode is driven by what enters w', and the derivative of what enters u'.
    quick = np.abs(modes[:, DRAG]) + np.sqrt(np.abs(modes[:, SPRING]))
    constant = np.abs(modes[:, FORCE]) + quick * np.abs(modes[:, RATE])
    drive, of_records = sets.drive[b], np.abs(sets.record_drive[b])
    forces = modulus(drive[:, :, FORCE_COS] + 1j * drive[:, :, FORCE_SIN])
    rates = modulus(drive[:, :, RATE_COS] + 1j * drive[:, :, RATE_SIN])
    inputs = np.concatenate([constant[:, None], forces + quick[:, None] * rates], axis=1)
    return _Modes(
        modes[order, SPRING],
        modes[order, DRAG],
        np.append(0.0, law[_harmonics(law), at.OMEGA]),
        inputs[order],
        tuple(sets.records),
        (of_records[:, :, 0] + quick[:, None] * of_records[:, :, 1])[order],
    )


def _set_of(orbit: StructureOrbit) -> int:
    return int(orbit.run.record.marks[0, NEXT_REGION])


def _order_of(orbit: StructureOrbit) -> Integers:
    """Return the modes by their frequencies."""
    return np.argsort(orbit.run.record.sets.modes[_set_of(orbit), :, SPRING])


def _shapes_of(orbit: StructureOrbit) -> Floats:
    """Return how far each coordinate moves where a mode swings by 1 at its own frequency, (n, n)."""
    sets, b, order = orbit.run.record.sets, _set_of(orbit), _order_of(orbit)
    own = np.sqrt(np.abs(sets.modes[b, order, SPRING]))
    shape = np.abs(sets.shape[b, order])
    return np.asarray(shape[:, 0] + own[:, None] * shape[:, 1])


def _matters(falls: Floats, *, formal: bool) -> bool:
    """Return whether dynamic stiffnesses that fall, by these factors, may hide a graze or an end.

    Between two formal orbits there is no graze of a motion.
    """
    return bool((falls < (NONE if formal else STIFF)).any())


def _resonances(here: _Modes, there: _Modes) -> _Resonances:
    """Return the resonances between two neighbours of all modes and harmonics."""
    inputs = np.maximum(here.inputs, there.inputs)
    least, falls = _least(*(_stiffness(modes, modes.omegas) for modes in (here, there)))
    amplitudes = [inputs.ravel()]
    leasts, all_falls = [least.ravel()], [falls.ravel()]
    of_modes = [np.repeat(np.arange(len(inputs)), inputs.shape[1])]
    of_records = np.maximum(here.of_records, there.of_records)
    for r, laws in enumerate(zip(here.records, there.records, strict=True)):
        for j, springs in enumerate(zip(here.springs, there.springs, strict=True)):
            numbers = _resonant_numbers(laws, np.array(springs))
            if len(numbers) > MOST_HARMONICS:
                return _Resonances(np.array([math.inf]), np.zeros(1), np.array([j]))
            waves = [_harmonics_of_record(law, numbers) for law in laws]
            least, falls = _least(
                *(
                    _stiffness(modes, omegas)[j]
                    for modes, (omegas, _) in zip((here, there), waves, strict=True)
                )
            )
            amplitudes.append(of_records[j, r] * np.maximum(waves[0][1], waves[1][1]))
            leasts.append(least)
            all_falls.append(falls)
            of_modes.append(np.full(len(numbers), j))
    amplitude = np.concatenate(amplitudes)
    acts = amplitude > NOT_DRIVEN * amplitude.max()
    falls = np.concatenate(all_falls)
    falls[~acts] = 1.0
    return _Resonances(amplitude / np.concatenate(leasts), falls, np.concatenate(of_modes))


def _stiffness(modes: _Modes, omegas: Floats) -> Complexes:
    """Return the dynamic stiffnesses, (n, m)."""
    return np.asarray(modes.springs[:, None] - omegas * omegas + 1j * modes.drags[:, None] * omegas)


def _resonant_numbers(laws: tuple[Law, Law], springs: Floats) -> Integers:
    """Return the numbers of a record's harmonics next to, and between, a mode's own frequencies."""
    repeats = np.array([law[0, at.REPEAT] for law in laws])
    own = np.sqrt(np.maximum(springs, 0.0)) * repeats / (2.0 * math.pi)
    return np.arange(max(1, math.floor(own.min())), math.ceil(own.max()) + 1)


def _harmonics_of_record(law: Law, numbers: Integers) -> tuple[Floats, Floats]:
    """Return the frequencies and amplitudes of a repeated record's harmonics.

    By parts, the Fourier integral of what is linear between knots is a sum over jumps and bends.
    """
    n, first, entries = int(law[0, at.N_KNOTS]), int(law[0, at.FIRST_KNOT]), at.KNOT_ENTRIES
    knots = law[first:, : entries * at.KNOTS_A_ROW].reshape(-1, entries)[:n]
    t, force, slope = knots[:, at.KNOT_T], knots[:, at.KNOT_FORCE], knots[:, at.KNOT_SLOPE]
    repeat = float(law[0, at.REPEAT])
    ends = force + slope * np.diff(t, append=t[0] + repeat)
    omega = 2.0 * math.pi / repeat * numbers.astype(np.float64)
    jumps, bends, per_time = force - np.roll(ends, 1), slope - np.roll(slope, 1), omega[:, None]
    parts = -bends / per_time**2 - 1j * (jumps / per_time)
    amplitude = modulus(times(parts, phasor(-per_time * t)).sum(axis=1))
    amplitude[amplitude < CANCELLED * modulus(parts).sum(axis=1)] = 0.0
    return omega, 2.0 / repeat * amplitude


def _harmonics(law: Law) -> slice:
    """Return the rows of the harmonics in a law."""
    return slice(at.FIRST_HARMONIC, at.FIRST_HARMONIC + int(law[0, at.N_HARMONICS]))


def _least(here: Complexes, there: Complexes) -> tuple[Floats, Floats]:
    """Return the least dynamic stiffnesses between two values, and as parts of the lesser value."""
    chord = there - here
    square = np.maximum(modulus(chord) ** 2, TINY)
    part = np.clip(-times(here.conj(), chord).real / square, 0.0, 1.0)
    least = np.maximum(modulus(here + part * chord), TINY)
    return least, least / np.maximum(np.minimum(modulus(here), modulus(there)), TINY)
