"""The model: oscillators, structures, forcings and starts, as frozen values."""

from __future__ import annotations

from percuss.lazy import public_names
from percuss.model.bouncing_ball import ball_on_table as ball_on_table
from percuss.model.exact import Exact as Exact
from percuss.model.exact import Phase as Phase
from percuss.model.exact import PiTimes as PiTimes
from percuss.model.exact import as_float as as_float
from percuss.model.exact import as_fraction as as_fraction
from percuss.model.exact import pi_times as pi_times
from percuss.model.expression import Expression as Expression
from percuss.model.expression import expression as expression
from percuss.model.expression import parameter as parameter
from percuss.model.faults import Fault as Fault
from percuss.model.faults import draft as draft
from percuss.model.faults import faults as faults
from percuss.model.force_record import ForceRecord as ForceRecord
from percuss.model.forcing import Component as Component
from percuss.model.forcing import Forcing as Forcing
from percuss.model.forcing import FourierTerm as FourierTerm
from percuss.model.forcing import Harmonic as Harmonic
from percuss.model.harmonic_forces import base_excitation as base_excitation
from percuss.model.harmonic_forces import cosine as cosine
from percuss.model.harmonic_forces import fourier as fourier
from percuss.model.harmonic_forces import sine as sine
from percuss.model.loads import Loads as Loads
from percuss.model.loads import loads_of as loads_of
from percuss.model.mechanisms import cantilever as cantilever
from percuss.model.mechanisms import chain as chain
from percuss.model.mechanisms import impact_pair as impact_pair
from percuss.model.mechanisms import vibro_impact_absorber as vibro_impact_absorber
from percuss.model.oscillator import On as On
from percuss.model.oscillator import Oscillator as Oscillator
from percuss.model.oscillator import Side as Side
from percuss.model.oscillator import SoftStop as SoftStop
from percuss.model.oscillator import Stop as Stop
from percuss.model.oscillator import Wall as Wall
from percuss.model.oscillator import backlash_oscillator as backlash_oscillator
from percuss.model.oscillator import bilinear_oscillator as bilinear_oscillator
from percuss.model.oscillator import impact_oscillator as impact_oscillator
from percuss.model.paths import get_parameter as get_parameter
from percuss.model.paths import long_form as long_form
from percuss.model.paths import moved_fields as moved_fields
from percuss.model.paths import parameter_paths as parameter_paths
from percuss.model.paths import replace_parameter as replace_parameter
from percuss.model.paths import replace_parameters as replace_parameters
from percuss.model.restitution import Restitution as Restitution
from percuss.model.restitution import RestitutionTable as RestitutionTable
from percuss.model.restitution import restitution_table as restitution_table
from percuss.model.sea_state import sea_state as sea_state
from percuss.model.start import Start as Start
from percuss.model.start import end_after_periods as end_after_periods
from percuss.model.start import periods_faults as periods_faults
from percuss.model.start import start_faults as start_faults
from percuss.model.structure import Structure as Structure
from percuss.model.structure_start import StructureStart as StructureStart
from percuss.model.structure_start import check_start as check_start
from percuss.model.units import Units as Units
from percuss.model.waves import pulses as pulses
from percuss.model.waves import record as record
from percuss.model.waves import square_wave as square_wave
from percuss.model.waves import triangle_wave as triangle_wave

__dir__ = public_names(__name__)
