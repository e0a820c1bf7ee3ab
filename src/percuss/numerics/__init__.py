"""Elementary functions and linear algebra with the same bits on every machine.

Those of NumPy, LAPACK and the C library differ between machines in the last digits.
"""

from percuss.numerics.functions import (
    atan2,
    cos,
    cosine_sine,
    exp,
    expm1,
    geometric,
    hypot,
    log,
    modulus,
    phasor,
    power,
    sin,
    tan,
    times,
)
from percuss.numerics.linear import (
    balanced,
    cholesky,
    determinant,
    directions,
    dot,
    fit_line,
    inverse,
    is_finite,
    least_squares,
    leverages,
    matmul,
    norm,
    solve_linear,
)
from percuss.numerics.modes import ModePairs, entry_sizes, mode_pairs
from percuss.numerics.roots import gauss_legendre, gauss_points, panels, polynomial_roots
from percuss.numerics.wide import Wide

__all__ = [
    "ModePairs",
    "Wide",
    "atan2",
    "balanced",
    "cholesky",
    "cos",
    "cosine_sine",
    "determinant",
    "directions",
    "dot",
    "entry_sizes",
    "exp",
    "expm1",
    "fit_line",
    "gauss_legendre",
    "gauss_points",
    "geometric",
    "hypot",
    "inverse",
    "is_finite",
    "least_squares",
    "leverages",
    "log",
    "matmul",
    "mode_pairs",
    "modulus",
    "norm",
    "panels",
    "phasor",
    "polynomial_roots",
    "power",
    "sin",
    "solve_linear",
    "tan",
    "times",
]
