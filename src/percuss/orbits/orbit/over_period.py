"""An orbit at instants of its period: how far and how fast it goes, where some digits are enough."""

from __future__ import annotations

import numpy as np

from percuss.arrays import Floats
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit

# Instants of a period, both ends among them: 64 stretches show the tenth harmonic.
INSTANTS = 65


def states_over_period(orbit: PeriodicOrbit | StructureOrbit) -> tuple[Floats, Floats]:
    """Return displacements and velocities at 65 instants of a period, of a structure (65, n)."""
    run = orbit.trajectory() if isinstance(orbit, PeriodicOrbit) else orbit.run
    x, v = run(np.linspace(run.t0, run.t_end, INSTANTS))
    return x, v


def fastest(orbit: PeriodicOrbit) -> float:
    """Return the largest velocity of an orbit at these instants [length/time], 1 if it rests."""
    return float(np.abs(states_over_period(orbit)[1]).max()) or 1.0
