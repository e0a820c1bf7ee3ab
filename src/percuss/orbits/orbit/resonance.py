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
from percuss.kernels.structure.basis import DRAG, FORCE, RATE, SPRING
from percuss.numerics import modulus, phasor, times
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

__all__ = ["COARSE", "changes_much", "passes_modal_resonance", "passes_resonance"]

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
# Instants of a period at which displacements and velocities are taken.
SEEN = 65


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


def passes_resonance(before: PeriodicOrbit, after: PeriodicOrbit) -> bool:
    """Return whether an oscillator has a resonance between two neighbours without events."""
    region = int(before.record[1][0, NEXT_REGION])
    here, there = (_mode_of(orbit.system.law, region) for orbit in (before, after))
    swings, falls = _resonances(here, there)
    if not _matters(falls, formal=not (before.admissible or after.admissible)):
        return False
    rows = np.array([orbit.system.law[region] for orbit in (before, after)])
    springs = rows[:, at.STIFFNESS]
    if (falls < NONE).any() or not springs.all():
        return True
    if here.records:
        # What does not resonate goes from one to the other; what does may be hidden in their
        # displacements, too.
        rest = [_seen(orbit)[0] for orbit in (before, after)]
        swing = 2.0 * float(swings[falls < STIFF].sum())
    else:
        rest = [rows[:, at.ORIGIN] + rows[:, at.ORIGIN_FORCE] / springs]
        swing = float(swings[1:].sum())
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
    (x, v), (y, w) = (_seen(orbit) for orbit in (before, after))
    size = max(float(np.abs(v).max()), float(np.abs(w).max()), speed)
    length = max(float(np.abs(x).max()), float(np.abs(y).max()))
    floor = ROUNDING * 2.0 * math.pi / before.period * length
    return float(np.abs(w - v).max()) > max(COARSE * size, floor)


def _seen(orbit: PeriodicOrbit) -> tuple[Floats, Floats]:
    """Return displacements and velocities at instants of a period."""
    x, v = orbit.trajectory()(orbit.t0 + orbit.period * np.linspace(0.0, 1.0, SEEN))
    return x, v


def passes_modal_resonance(before: StructureOrbit, after: StructureOrbit) -> bool:
    """Return whether a structure has a resonance between two neighbours without events."""
    if not (before.is_steady and after.is_steady):
        return False
    _, falls = _resonances(_modes_of(before), _modes_of(after))
    return _matters(falls, formal=not (before.admissible or after.admissible))


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
    record = orbit.run.record
    sets, b = record.sets, int(record.marks[0, NEXT_REGION])
    modes, law = sets.modes[b], sets.law[b]
    order = np.argsort(modes[:, SPRING])
    constant = np.abs(modes[:, [FORCE, RATE]]).max(axis=1)[:, None]
    inputs = np.concatenate([constant, np.abs(sets.drive[b]).max(axis=2)], axis=1)
    return _Modes(
        modes[order, SPRING],
        modes[order, DRAG],
        np.append(0.0, law[_harmonics(law), at.OMEGA]),
        inputs[order],
        tuple(sets.records),
        np.abs(sets.record_drive[b]).max(axis=2)[order],
    )


def _matters(falls: Floats, *, formal: bool) -> bool:
    """Return whether dynamic stiffnesses that fall, by these factors, may hide a graze or an end.

    Between two formal orbits there is no graze of a motion.
    """
    return bool((falls < (NONE if formal else STIFF)).any())


def _resonances(here: _Modes, there: _Modes) -> tuple[Floats, Floats]:
    """Return the largest amplitudes between two of all modes and harmonics, and how far D falls.

    The first is that of the first mode under the constant.
    """
    inputs = np.maximum(here.inputs, there.inputs)
    least, falls = _least(*(_stiffness(modes, modes.omegas) for modes in (here, there)))
    amplitudes = [inputs.ravel()]
    leasts, all_falls = [least.ravel()], [falls.ravel()]
    of_records = np.maximum(here.of_records, there.of_records)
    for r, laws in enumerate(zip(here.records, there.records, strict=True)):
        for j, springs in enumerate(zip(here.springs, there.springs, strict=True)):
            numbers = _resonant_numbers(laws, np.array(springs))
            if len(numbers) > MOST_HARMONICS:
                return np.array([math.inf]), np.zeros(1)
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
    amplitude = np.concatenate(amplitudes)
    acts = amplitude > NOT_DRIVEN * amplitude.max()
    falls = np.concatenate(all_falls)
    falls[~acts] = 1.0
    return amplitude / np.concatenate(leasts), falls


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
