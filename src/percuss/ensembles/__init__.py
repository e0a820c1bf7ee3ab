"""Many motions: measures over grids, diagrams, basins, exponents."""

from percuss.ensembles.basins import basins
from percuss.ensembles.diagram import bifurcation_diagram
from percuss.ensembles.lyapunov import LyapunovExponents, lyapunov_exponents
from percuss.ensembles.store import status_of_store
from percuss.ensembles.sweep import sweep

__all__ = [
    "LyapunovExponents",
    "basins",
    "bifurcation_diagram",
    "lyapunov_exponents",
    "status_of_store",
    "sweep",
]
