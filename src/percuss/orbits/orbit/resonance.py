"""Resonances between neighbours on a branch of orbits without events, at which one step is too long.

Such an orbit is the sum of what each harmonic of the forces excites in each mode, in proportion to
1 / D with the dynamic stiffness D = k - w^2 + 2 i a w. Lightly damped, a mode has a resonance far
narrower than a step, in which stops may be met.
"""

from __future__ import annotations

import numpy as np

from percuss.arrays import Complexes, Flags
from percuss.kernels import law_columns as at
from percuss.kernels.law_columns import Law
from percuss.kernels.record import KIND, KNOT, NEXT_REGION, START
from percuss.kernels.structure.basis import DRAG, FORCE, RATE, SPRING
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

__all__ = ["passes_modal_resonance", "passes_resonance"]

# A dynamic stiffness between two neighbours may fall below theirs by this factor.
STIFF = 0.9999
# Under a record, whose harmonics are not known, oscillations may change by this part of their range
# from one neighbour to the next, at so many instants, and by this part of the displacement in any
# case, which is rounding.
CHANGED, SEEN, ROUNDING = 0.25, 65, 1e-12
# Inputs into a mode below this part of the largest are rounding.
NOT_DRIVEN = 1e-12


def passes_resonance(before: PeriodicOrbit, after: PeriodicOrbit) -> bool:
    """Return whether an oscillator has a resonance between two neighbours without events."""
    law, other = before.system.law, after.system.law
    region, rows = int(before.record[1][0, 2]), _harmonics(law)
    if law[0, at.N_KNOTS] > 0.0 and _is_reshaped(before, after, region):
        return True
    acts = np.append(
        law[region, at.ORIGIN_FORCE] != 0.0,
        np.maximum(law[rows, at.AMPLITUDE], other[rows, at.AMPLITUDE]) > 0.0,
    )
    ends = []
    for own in (law, other):
        stiffness, damping = own[region, [at.STIFFNESS, at.DAMPING]]
        omega = np.append(0.0, own[rows, at.OMEGA])
        ends.append(stiffness - omega * omega + 2j * damping * omega)
    return _falls(ends[0], ends[1], acts)


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
        if not np.isin(record.marks[:, KIND], (START, KNOT)).all():
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
    return _falls(ends[0], ends[1], largest > NOT_DRIVEN * largest.max())


def _harmonics(law: Law) -> slice:
    """Return the rows of the harmonics in a law."""
    return slice(at.FIRST_HARMONIC, at.FIRST_HARMONIC + int(law[0, at.N_HARMONICS]))


def _falls(here: Complexes, there: Complexes, acts: Flags) -> bool:
    """Return whether dynamic stiffnesses that act are smaller between two values than at both."""
    chord = there - here
    square = np.maximum(np.abs(chord) ** 2, np.finfo(np.float64).tiny)
    part = np.clip(-(here.conj() * chord).real / square, 0.0, 1.0)
    least = np.abs(here + part * chord)
    return bool((acts & (least < STIFF * np.minimum(np.abs(here), np.abs(there)))).any())
