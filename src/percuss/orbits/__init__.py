"""Periodic motions and their families."""

from __future__ import annotations

from percuss.orbits.branch import Branch as Branch
from percuss.orbits.cascade import Cascade as Cascade
from percuss.orbits.cascade import follow_cascade as follow_cascade
from percuss.orbits.continuation import continue_orbit as continue_orbit
from percuss.orbits.curve import Curve as Curve
from percuss.orbits.curve import CurvePoint as CurvePoint
from percuss.orbits.curve_continuation import continue_curve as continue_curve
from percuss.orbits.find import find_orbit as find_orbit
from percuss.orbits.find import find_orbits as find_orbits
from percuss.orbits.grazing import GrazeAnalysis as GrazeAnalysis
from percuss.orbits.grazing import analysed_graze as analysed_graze
from percuss.orbits.manifolds import ManifoldBranch as ManifoldBranch
from percuss.orbits.manifolds import Manifolds as Manifolds
from percuss.orbits.manifolds import manifolds as manifolds
from percuss.orbits.maps import ImpactMap as ImpactMap
from percuss.orbits.maps import StroboscopicMap as StroboscopicMap
from percuss.orbits.maps import impact_map as impact_map
from percuss.orbits.maps import stroboscopic_map as stroboscopic_map
from percuss.orbits.passages import Passages as Passages
from percuss.orbits.periodic_orbit import PeriodicOrbit as PeriodicOrbit
from percuss.orbits.response import FamilyRange as FamilyRange
from percuss.orbits.response import Response as Response
from percuss.orbits.response import response_curve as response_curve
from percuss.orbits.response_search import SeenAttractor as SeenAttractor
from percuss.orbits.single_impact import SingleImpact as SingleImpact
from percuss.orbits.single_impact import single_impact as single_impact
from percuss.orbits.single_impact import single_impact_orbits as single_impact_orbits
from percuss.orbits.singularity_set import SingularityCurve as SingularityCurve
from percuss.orbits.singularity_set import SingularitySet as SingularitySet
from percuss.orbits.singularity_set import singularity_set as singularity_set
from percuss.orbits.special_points import SpecialPoint as SpecialPoint
from percuss.orbits.stability import Stability as Stability
from percuss.orbits.switching import switch_branch as switch_branch
from percuss.orbits.velocity_gap import VelocityGap as VelocityGap
from percuss.orbits.velocity_gap import velocity_gap_curve as velocity_gap_curve
