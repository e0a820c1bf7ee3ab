"""Periodic motions and their families."""

from __future__ import annotations

from percuss.orbits.branch import Branch as Branch
from percuss.orbits.continuation import continue_orbit as continue_orbit
from percuss.orbits.find import find_orbit as find_orbit
from percuss.orbits.find import find_orbits as find_orbits
from percuss.orbits.maps import ImpactMap as ImpactMap
from percuss.orbits.maps import StroboscopicMap as StroboscopicMap
from percuss.orbits.maps import impact_map as impact_map
from percuss.orbits.maps import stroboscopic_map as stroboscopic_map
from percuss.orbits.passages import Passages as Passages
from percuss.orbits.periodic_orbit import PeriodicOrbit as PeriodicOrbit
from percuss.orbits.single_impact import SingleImpact as SingleImpact
from percuss.orbits.single_impact import single_impact as single_impact
from percuss.orbits.single_impact import single_impact_orbits as single_impact_orbits
from percuss.orbits.special_points import SpecialPoint as SpecialPoint
from percuss.orbits.stability import Stability as Stability
