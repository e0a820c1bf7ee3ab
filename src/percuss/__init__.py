"""Oscillators that meet stops: exact between impacts, no impact ever missed.

The equation is x'' + 2 a x' + k x = f(t) + stops, for unit mass. Describe an oscillator and a
forcing, follow the motion with `simulate`, draw it with `percuss.plotting`.

>>> import percuss as pc
>>> run = pc.simulate(pc.impact_oscillator(restitution=0.8), pc.cosine(2.0), v0=1.0, t_end=50.0)
>>> run.outcome.value
'the run reached t_end'
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from percuss.version import __version__ as __version__

if TYPE_CHECKING:
    # For type checkers: at run time a name's module is loaded at the name's first use, since
    # numba and xarray take long.
    from percuss.certified import certify as certify
    from percuss.ensembles import LyapunovExponents as LyapunovExponents
    from percuss.ensembles import basin_fractions as basin_fractions
    from percuss.ensembles import basins as basins
    from percuss.ensembles import bifurcation_diagram as bifurcation_diagram
    from percuss.ensembles import load_store as load_store
    from percuss.ensembles import lyapunov_exponents as lyapunov_exponents
    from percuss.ensembles import merge_parts as merge_parts
    from percuss.ensembles import status_of_store as status_of_store
    from percuss.ensembles import sweep as sweep
    from percuss.errors import ConvergenceError as ConvergenceError
    from percuss.errors import FormalOrbitWarning as FormalOrbitWarning
    from percuss.errors import LimitWarning as LimitWarning
    from percuss.errors import MissingExtraError as MissingExtraError
    from percuss.errors import OutputError as OutputError
    from percuss.errors import ParameterError as ParameterError
    from percuss.errors import PercussError as PercussError
    from percuss.errors import StudyError as StudyError
    from percuss.fitting import Fit as Fit
    from percuss.fitting import fit as fit
    from percuss.io import load_netcdf as load_netcdf
    from percuss.io import save_certificate as save_certificate
    from percuss.io import save_csv as save_csv
    from percuss.io import save_netcdf as save_netcdf
    from percuss.model import Expression as Expression
    from percuss.model import Forcing as Forcing
    from percuss.model import Harmonic as Harmonic
    from percuss.model import Loads as Loads
    from percuss.model import Oscillator as Oscillator
    from percuss.model import SoftStop as SoftStop
    from percuss.model import Start as Start
    from percuss.model import Structure as Structure
    from percuss.model import StructureStart as StructureStart
    from percuss.model import Units as Units
    from percuss.model import Wall as Wall
    from percuss.model import backlash_oscillator as backlash_oscillator
    from percuss.model import ball_on_table as ball_on_table
    from percuss.model import base_excitation as base_excitation
    from percuss.model import bilinear_oscillator as bilinear_oscillator
    from percuss.model import cantilever as cantilever
    from percuss.model import chain as chain
    from percuss.model import cosine as cosine
    from percuss.model import expression as expression
    from percuss.model import fourier as fourier
    from percuss.model import impact_oscillator as impact_oscillator
    from percuss.model import impact_pair as impact_pair
    from percuss.model import parameter as parameter
    from percuss.model import pi_times as pi_times
    from percuss.model import pulses as pulses
    from percuss.model import record as record
    from percuss.model import restitution_table as restitution_table
    from percuss.model import sea_state as sea_state
    from percuss.model import sine as sine
    from percuss.model import square_wave as square_wave
    from percuss.model import triangle_wave as triangle_wave
    from percuss.model import vibro_impact_absorber as vibro_impact_absorber
    from percuss.motion import Contacts as Contacts
    from percuss.motion import Crossings as Crossings
    from percuss.motion import Extrema as Extrema
    from percuss.motion import Grazes as Grazes
    from percuss.motion import Growth as Growth
    from percuss.motion import HarmonicMotion as HarmonicMotion
    from percuss.motion import Impacts as Impacts
    from percuss.motion import ImpactTimes as ImpactTimes
    from percuss.motion import Outcome as Outcome
    from percuss.motion import Sensitivity as Sensitivity
    from percuss.motion import StructureSensitivity as StructureSensitivity
    from percuss.motion import SubsetMotion as SubsetMotion
    from percuss.motion import Trajectory as Trajectory
    from percuss.motion import classify_impact_times as classify_impact_times
    from percuss.motion import eigenset as eigenset
    from percuss.motion import eigenset_motion as eigenset_motion
    from percuss.motion import force_at as force_at
    from percuss.motion import gradient as gradient
    from percuss.motion import growth as growth
    from percuss.motion import harmonic_critical_velocity as harmonic_critical_velocity
    from percuss.motion import line_spectrum as line_spectrum
    from percuss.motion import resonant_frequency as resonant_frequency
    from percuss.motion import simulate as simulate
    from percuss.motion import spectrum as spectrum
    from percuss.motion import subset_critical_velocity as subset_critical_velocity
    from percuss.motion import subset_forcing as subset_forcing
    from percuss.motion.structures import StructureTrajectory as StructureTrajectory
    from percuss.optimization import Design as Design
    from percuss.optimization import ParetoFront as ParetoFront
    from percuss.optimization import design as design
    from percuss.optimization import pareto_front as pareto_front
    from percuss.orbits import Branch as Branch
    from percuss.orbits import Cascade as Cascade
    from percuss.orbits import Curve as Curve
    from percuss.orbits import CurvePoint as CurvePoint
    from percuss.orbits import FoundOrbits as FoundOrbits
    from percuss.orbits import GrazeAnalysis as GrazeAnalysis
    from percuss.orbits import ImpactMap as ImpactMap
    from percuss.orbits import ManifoldBranch as ManifoldBranch
    from percuss.orbits import Manifolds as Manifolds
    from percuss.orbits import OrbitSensitivity as OrbitSensitivity
    from percuss.orbits import PeriodicOrbit as PeriodicOrbit
    from percuss.orbits import Response as Response
    from percuss.orbits import SectionMap as SectionMap
    from percuss.orbits import SingularityCurve as SingularityCurve
    from percuss.orbits import SingularitySet as SingularitySet
    from percuss.orbits import SpecialPoint as SpecialPoint
    from percuss.orbits import StroboscopicMap as StroboscopicMap
    from percuss.orbits import StructureBranch as StructureBranch
    from percuss.orbits import StructureCurve as StructureCurve
    from percuss.orbits import StructureCurvePoint as StructureCurvePoint
    from percuss.orbits import StructureManifolds as StructureManifolds
    from percuss.orbits import StructureOrbit as StructureOrbit
    from percuss.orbits import StructureOrbitSensitivity as StructureOrbitSensitivity
    from percuss.orbits import StructureSpecialPoint as StructureSpecialPoint
    from percuss.orbits import VelocityGap as VelocityGap
    from percuss.orbits import continue_curve as continue_curve
    from percuss.orbits import continue_orbit as continue_orbit
    from percuss.orbits import find_orbit as find_orbit
    from percuss.orbits import find_orbits as find_orbits
    from percuss.orbits import follow_cascade as follow_cascade
    from percuss.orbits import impact_map as impact_map
    from percuss.orbits import manifolds as manifolds
    from percuss.orbits import orbits_at as orbits_at
    from percuss.orbits import response_curve as response_curve
    from percuss.orbits import section_map as section_map
    from percuss.orbits import singularity_set as singularity_set
    from percuss.orbits import stroboscopic_map as stroboscopic_map
    from percuss.orbits import switch_branch as switch_branch
    from percuss.orbits import velocity_gap_curve as velocity_gap_curve
    from percuss.studies.record_file import read_record as read_record
    from percuss.web.widget import explore as explore

_HOMES = {
    "percuss.certified": ("certify",),
    "percuss.ensembles": (
        "LyapunovExponents",
        "basin_fractions",
        "basins",
        "bifurcation_diagram",
        "load_store",
        "lyapunov_exponents",
        "merge_parts",
        "status_of_store",
        "sweep",
    ),
    "percuss.errors": (
        "ConvergenceError",
        "FormalOrbitWarning",
        "LimitWarning",
        "MissingExtraError",
        "OutputError",
        "ParameterError",
        "PercussError",
        "StudyError",
    ),
    "percuss.fitting": ("Fit", "fit"),
    "percuss.io": (
        "load_netcdf",
        "save_certificate",
        "save_csv",
        "save_netcdf",
    ),
    "percuss.model": (
        "Expression",
        "Forcing",
        "Harmonic",
        "Loads",
        "Oscillator",
        "SoftStop",
        "Start",
        "Structure",
        "StructureStart",
        "Units",
        "Wall",
        "backlash_oscillator",
        "ball_on_table",
        "base_excitation",
        "bilinear_oscillator",
        "cantilever",
        "chain",
        "cosine",
        "expression",
        "fourier",
        "impact_oscillator",
        "impact_pair",
        "parameter",
        "pi_times",
        "pulses",
        "record",
        "restitution_table",
        "sea_state",
        "sine",
        "square_wave",
        "triangle_wave",
        "vibro_impact_absorber",
    ),
    "percuss.motion": (
        "Contacts",
        "Crossings",
        "Extrema",
        "Grazes",
        "Growth",
        "HarmonicMotion",
        "ImpactTimes",
        "Impacts",
        "Outcome",
        "Sensitivity",
        "StructureSensitivity",
        "SubsetMotion",
        "Trajectory",
        "classify_impact_times",
        "eigenset",
        "eigenset_motion",
        "force_at",
        "gradient",
        "growth",
        "harmonic_critical_velocity",
        "line_spectrum",
        "resonant_frequency",
        "simulate",
        "spectrum",
        "subset_critical_velocity",
        "subset_forcing",
    ),
    "percuss.motion.structures": ("StructureTrajectory",),
    "percuss.optimization": (
        "Design",
        "ParetoFront",
        "design",
        "pareto_front",
    ),
    "percuss.orbits": (
        "Branch",
        "Cascade",
        "Curve",
        "CurvePoint",
        "GrazeAnalysis",
        "ImpactMap",
        "ManifoldBranch",
        "Manifolds",
        "OrbitSensitivity",
        "PeriodicOrbit",
        "Response",
        "SectionMap",
        "SingularityCurve",
        "SingularitySet",
        "SpecialPoint",
        "StroboscopicMap",
        "StructureBranch",
        "StructureCurve",
        "StructureCurvePoint",
        "StructureManifolds",
        "StructureOrbit",
        "StructureOrbitSensitivity",
        "StructureSpecialPoint",
        "VelocityGap",
        "continue_curve",
        "continue_orbit",
        "FoundOrbits",
        "find_orbit",
        "find_orbits",
        "follow_cascade",
        "impact_map",
        "manifolds",
        "orbits_at",
        "response_curve",
        "section_map",
        "singularity_set",
        "stroboscopic_map",
        "switch_branch",
        "velocity_gap_curve",
    ),
    "percuss.studies.record_file": ("read_record",),
    "percuss.version": ("__version__",),
    "percuss.web.widget": ("explore",),
}
_HOME_OF = {name: home for home, names in _HOMES.items() for name in names}
__all__ = list(_HOME_OF)
_SUBPACKAGES = (
    "certified",
    "ensembles",
    "errors",
    "fitting",
    "io",
    "model",
    "motion",
    "optimization",
    "orbits",
    "plotting",
    "studies",
)


def __getattr__(name: str) -> Any:
    if name in _HOME_OF:
        return getattr(importlib.import_module(_HOME_OF[name]), name)
    if name in _SUBPACKAGES:
        return importlib.import_module(f"percuss.{name}")
    raise AttributeError(f"module 'percuss' has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*__all__, *_SUBPACKAGES])
