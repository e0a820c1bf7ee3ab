"""One motion: simulating it, and reading it."""

from __future__ import annotations

from percuss.lazy import public_names
from percuss.motion.eigenset import eigenset as eigenset
from percuss.motion.eigenset import resonant_frequency as resonant_frequency
from percuss.motion.eigenset_forms import HarmonicMotion as HarmonicMotion
from percuss.motion.eigenset_forms import SubsetMotion as SubsetMotion
from percuss.motion.eigenset_forms import eigenset_motion as eigenset_motion
from percuss.motion.eigenset_forms import harmonic_critical_velocity as harmonic_critical_velocity
from percuss.motion.eigenset_forms import subset_critical_velocity as subset_critical_velocity
from percuss.motion.eigenset_forms import subset_forcing as subset_forcing
from percuss.motion.energetics import force_at as force_at
from percuss.motion.extremes import Extrema as Extrema
from percuss.motion.gradients import gradient as gradient
from percuss.motion.growth import Growth as Growth
from percuss.motion.growth import growth as growth
from percuss.motion.impact_times import ImpactTimes as ImpactTimes
from percuss.motion.impact_times import classify_impact_times as classify_impact_times
from percuss.motion.moved_motion import MovedContacts as MovedContacts
from percuss.motion.moved_motion import MovedCrossings as MovedCrossings
from percuss.motion.moved_motion import MovedGrazes as MovedGrazes
from percuss.motion.moved_motion import MovedImpacts as MovedImpacts
from percuss.motion.sensitivity import Sensitivity as Sensitivity
from percuss.motion.simulate import simulate as simulate
from percuss.motion.spectrum import line_spectrum as line_spectrum
from percuss.motion.spectrum import spectrum as spectrum
from percuss.motion.structure_sensitivity import StructureSensitivity as StructureSensitivity
from percuss.motion.tables import Contacts as Contacts
from percuss.motion.tables import Crossings as Crossings
from percuss.motion.tables import Grazes as Grazes
from percuss.motion.tables import Impacts as Impacts
from percuss.motion.trajectory import Outcome as Outcome
from percuss.motion.trajectory import Trajectory as Trajectory

__dir__ = public_names(__name__)
