"""Many motions: measures over grids, diagrams, basins, exponents."""

from percuss.ensembles.array_parts import merge_parts
from percuss.ensembles.basin_fractions import basin_fractions
from percuss.ensembles.basins import basins
from percuss.ensembles.diagram import bifurcation_diagram
from percuss.ensembles.lyapunov import LyapunovExponents, lyapunov_exponents
from percuss.ensembles.stored import load_store, status_of_store
from percuss.ensembles.sweep import sweep
from percuss.lazy import public_names

__all__ = [
    "LyapunovExponents",
    "basin_fractions",
    "basins",
    "bifurcation_diagram",
    "load_store",
    "lyapunov_exponents",
    "merge_parts",
    "status_of_store",
    "sweep",
]

__dir__ = public_names(__name__)
