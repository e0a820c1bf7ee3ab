"""Resonances between neighbours on a branch of orbits without events, at which one step is too long.

Such an orbit is the sum of what each harmonic of the forces excites in each mode, in proportion to
1 / D with the dynamic stiffness D = k - w^2 + 2 i a w. Lightly damped, a mode has a resonance far
narrower than a step, in which stops may be met.
"""

from __future__ import annotations

import numpy as np

from percuss.arrays import Complexes, Floats
from percuss.kernels import law_columns as at
from percuss.kernels.law_columns import Law
from percuss.kernels.record import NEXT_REGION
from percuss.kernels.structure.basis import DRAG, FORCE, RATE, SPRING
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

__all__ = ["passes_modal_resonance", "passes_resonance"]

# A dynamic stiffness between two neighbours may fall below theirs by the first factor. Below the
# second one it is none: the amplitude has no bound.
STIFF, NONE = 0.9999, 1e-9
# Under a record, whose harmonics are not known, oscillations may change by this part of their range
# from one neighbour to the next, at so many instants, and by this part of the displacement in any
# case, which is rounding.
CHANGED, SEEN, ROUNDING = 0.25, 65, 1e-12
# In place of 0 in a denominator.
TINY = np.finfo(np.float64).tiny
# Inputs into a mode below this part of the largest are rounding.
NOT_DRIVEN = 1e-12


def passes_resonance(before: PeriodicOrbit, after: PeriodicOrbit) -> bool:
    """Return whether an oscillator has a resonance between two neighbours without events."""
    law, other = before.system.law, after.system.law
    region, rows = int(before.record[1][0, 2]), _harmonics(law)
    if law[0, at.N_KNOTS] > 0.0 and _is_reshaped(before, after, region):
        return True
    amplitudes = np.maximum(law[rows, at.AMPLITUDE], other[rows, at.AMPLITUDE])
    acts = np.append(law[region, at.ORIGIN_FORCE] != 0.0, amplitudes > 0.0)
    ends = []
    for own in (law, other):
        stiffness, damping = own[region, [at.STIFFNESS, at.DAMPING]]
        omega = np.append(0.0, own[rows, at.OMEGA])
        ends.append(stiffness - omega * omega + 2j * damping * omega)
    least, falls = _least(ends[0], ends[1])
    formal = not (before.admissible or after.admissible)
    if not _matters(falls[acts], formal=formal):
        return False
    if law[0, at.N_KNOTS] > 0.0 or (falls[acts] < NONE).any():
        return True
    return _reaches((law, other), region, float((amplitudes / least[1:]).sum()))


def _reaches(laws: tuple[Law, Law], region: int, swing: float) -> bool:
    """Return whether swings about the mean, between its two values, may reach a bound."""
    rows = np.array([law[region] for law in laws])
    if (rows[:, at.STIFFNESS] == 0.0).any():
        return True
    means = rows[:, at.ORIGIN] + rows[:, at.ORIGIN_FORCE] / rows[:, at.STIFFNESS]
    low, high = rows[:, at.LOWER].max(), rows[:, at.UPPER].min()
    return not low < means.min() - swing <= means.max() + swing < high


def _matters(falls: Floats, *, formal: bool) -> bool:
    """Return whether dynamic stiffnesses that fall, by these factors, may hide a graze or an end.

    Between two formal orbits there is no graze of a motion.
    """
    return bool((falls < (NONE if formal else STIFF)).any())


def _is_reshaped(before: PeriodicOrbit, after: PeriodicOrbit, region: int) -> bool:
    """Return whether the oscillation under a record changes much with the dynamic stiffnesses.

    With a force alone it changes as that does, however much: there is no resonance to be passed.
    """
    stiffnesses = [
        (*orbit.system.law[region, [at.STIFFNESS, at.DAMPING]], orbit.system.law[0, at.PERIOD])
        for orbit in (before, after)
    ]
    if stiffnesses[0] == stiffnesses[1]:
        return False
    phases = np.linspace(0.0, 1.0, SEEN)
    x, y = (orbit.trajectory()(orbit.period * phases)[0] for orbit in (before, after))
    # A mean moves without a resonance.
    change = np.abs((y - y.mean()) - (x - x.mean())).max()
    floor = ROUNDING * max(np.abs(x).max(), np.abs(y).max())
    return bool(change > CHANGED * max(np.ptp(x), np.ptp(y)) + floor)


def passes_modal_resonance(before: StructureOrbit, after: StructureOrbit) -> bool:
    """Return whether a structure has a resonance between two neighbours without events.

    Records are not looked at: their harmonics are not known.
    """
    ends, driven = [], []
    for orbit in (before, after):
        record = orbit.run.record
        if not orbit.is_steady:
            return False
        sets, b = record.sets, int(record.marks[0, NEXT_REGION])
        modes, law = sets.modes[b], sets.law[b]
        omega = np.append(0.0, law[_harmonics(law), at.OMEGA])
        stiffness = modes[:, SPRING, None] - omega * omega + 1j * modes[:, DRAG, None] * omega
        inputs = (
            np.abs(modes[:, [FORCE, RATE]]).max(axis=1)[:, None],
            np.abs(sets.drive[b]).max(axis=2),
        )
        order = np.argsort(modes[:, SPRING])
        ends.append(stiffness[order])
        driven.append(np.concatenate(inputs, axis=1)[order])
    largest = np.maximum(*driven)
    _, falls = _least(ends[0], ends[1])
    formal = not (before.admissible or after.admissible)
    return _matters(falls[largest > NOT_DRIVEN * largest.max()], formal=formal)


def _harmonics(law: Law) -> slice:
    """Return the rows of the harmonics in a law."""
    return slice(at.FIRST_HARMONIC, at.FIRST_HARMONIC + int(law[0, at.N_HARMONICS]))


def _least(here: Complexes, there: Complexes) -> tuple[Floats, Floats]:
    """Return the least dynamic stiffnesses between two values, and as parts of the lesser value."""
    chord = there - here
    square = np.maximum(np.abs(chord) ** 2, TINY)
    part = np.clip(-(here.conj() * chord).real / square, 0.0, 1.0)
    least = np.maximum(np.abs(here + part * chord), TINY)
    return least, least / np.maximum(np.minimum(np.abs(here), np.abs(there)), TINY)
