"""The same questions in ball arithmetic: results with radii that are certain.

Needs python-flint, the extra ``percuss[certified]``.
"""

from __future__ import annotations

from percuss.errors import MissingExtraError
from percuss.lazy import public_names

try:
    import flint as _flint  # noqa: F401
except ImportError:  # pragma: no cover
    raise MissingExtraError("certified results need python-flint", "certified") from None

from percuss.certified.ball_arithmetic import Ball, Balls, ComplexBall
from percuss.certified.certificates import certificate
from percuss.certified.certified_branch import BranchStretch, CertifiedBranch, EnclosedPoint
from percuss.certified.certify import certify
from percuss.certified.chaos import CertifiedChaos, prove_chaos
from percuss.certified.march import Ending
from percuss.certified.orbit_list import CompleteList, list_orbits
from percuss.certified.orbit_result import CertifiedOrbit
from percuss.certified.proven_basins import CertifiedBasins, prove_basins
from percuss.certified.results import CertifiedRun
from percuss.certified.special import CertifiedPoint
from percuss.certified.statements import (
    Verdict,
    critical_velocity,
    keeps_eigenset,
    keeps_subset,
    repeats_after,
)

__all__ = [
    "Ball",
    "Balls",
    "BranchStretch",
    "CertifiedBasins",
    "CertifiedBranch",
    "CertifiedChaos",
    "CertifiedOrbit",
    "CertifiedPoint",
    "CertifiedRun",
    "CompleteList",
    "ComplexBall",
    "EnclosedPoint",
    "Ending",
    "Verdict",
    "certificate",
    "certify",
    "critical_velocity",
    "keeps_eigenset",
    "keeps_subset",
    "list_orbits",
    "prove_basins",
    "prove_chaos",
    "repeats_after",
]

__dir__ = public_names(__name__)
