"""Perturbed records on sets of impact times, and on chaos."""

from __future__ import annotations

from tests.paper.perturbed import Mutation, perturbed

import percuss as pc
from percuss.paper.claims.divergence import REGULAR

MUTATIONS: list[Mutation] = [
    perturbed("periodicity-resonance-sets", "10 for 8", resonant=("2", "4", "6", "10")),
    perturbed("periodicity-subsets-too", "a start on the eigenset", starts=((pc.sine(2), 0.5),)),
    perturbed("periodicity-eigenset-alone", "a velocity that Y_3 does not allow", fast="2.5"),
    perturbed("periodicity-cos-and-sin", "sin 2t for sin t", growing=pc.sine(2)),
    perturbed("periodicity-phase", "at an extreme of the force only", phases=(0.0,)),
    perturbed("periodicity-chaos", "a regular start", unstable=(REGULAR,)),
]
UNMOVED: dict[str, str] = {}
