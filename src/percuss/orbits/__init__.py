"""Periodic motions and their families."""

from __future__ import annotations

from percuss.lazy import public_names
from percuss.orbits.bifurcations.branch import Branch as Branch
from percuss.orbits.bifurcations.cascade import Cascade as Cascade
from percuss.orbits.bifurcations.cascade import follow_cascade as follow_cascade
from percuss.orbits.bifurcations.continue_curve import continue_curve as continue_curve
from percuss.orbits.bifurcations.continue_orbit import continue_orbit as continue_orbit
from percuss.orbits.bifurcations.curve import Curve as Curve
from percuss.orbits.bifurcations.curve import CurvePoint as CurvePoint
from percuss.orbits.bifurcations.grazing import GrazeAnalysis as GrazeAnalysis
from percuss.orbits.bifurcations.grazing import analysed_graze as analysed_graze
from percuss.orbits.bifurcations.orbits_at import orbits_at as orbits_at
from percuss.orbits.bifurcations.special_points import SpecialPoint as SpecialPoint
from percuss.orbits.bifurcations.structure_branch import StructureBranch as StructureBranch
from percuss.orbits.bifurcations.structure_branch import (
    StructureSpecialPoint as StructureSpecialPoint,
)
from percuss.orbits.bifurcations.structure_curve import StructureCurve as StructureCurve
from percuss.orbits.bifurcations.structure_curve import (
    StructureCurvePoint as StructureCurvePoint,
)
from percuss.orbits.bifurcations.switching import switch_branch as switch_branch
from percuss.orbits.finding.find import find_orbit as find_orbit
from percuss.orbits.finding.find import find_orbits as find_orbits
from percuss.orbits.finding.found import FoundOrbits as FoundOrbits
from percuss.orbits.finding.single_impact import SingleImpact as SingleImpact
from percuss.orbits.finding.single_impact import single_impact as single_impact
from percuss.orbits.finding.single_impact import single_impact_orbits as single_impact_orbits
from percuss.orbits.orbit.moved_orbit import OrbitSensitivity as OrbitSensitivity
from percuss.orbits.orbit.moved_structure_orbit import (
    StructureOrbitSensitivity as StructureOrbitSensitivity,
)
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit as PeriodicOrbit
from percuss.orbits.orbit.stability import Stability as Stability
from percuss.orbits.orbit.structure_orbit import StructureOrbit as StructureOrbit
from percuss.orbits.orbit.turning_points import Passages as Passages
from percuss.orbits.responses.families import SeenAttractor as SeenAttractor
from percuss.orbits.responses.response import FamilyRange as FamilyRange
from percuss.orbits.responses.response import Response as Response
from percuss.orbits.responses.response import response_curve as response_curve
from percuss.orbits.responses.velocity_gap import VelocityGap as VelocityGap
from percuss.orbits.responses.velocity_gap import velocity_gap_curve as velocity_gap_curve
from percuss.orbits.surface.manifold_branch import ManifoldBranch as ManifoldBranch
from percuss.orbits.surface.manifolds import Manifolds as Manifolds
from percuss.orbits.surface.manifolds import manifolds as manifolds
from percuss.orbits.surface.maps import ImpactMap as ImpactMap
from percuss.orbits.surface.maps import SectionMap as SectionMap
from percuss.orbits.surface.maps import StroboscopicMap as StroboscopicMap
from percuss.orbits.surface.maps import impact_map as impact_map
from percuss.orbits.surface.maps import section_map as section_map
from percuss.orbits.surface.maps import stroboscopic_map as stroboscopic_map
from percuss.orbits.surface.singularity_set import SingularityCurve as SingularityCurve
from percuss.orbits.surface.singularity_set import SingularitySet as SingularitySet
from percuss.orbits.surface.singularity_set import singularity_set as singularity_set
from percuss.orbits.surface.structure_manifolds import StructureManifolds as StructureManifolds

__dir__ = public_names(__name__)
