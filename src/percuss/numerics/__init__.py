"""What elsewhere NumPy, LAPACK and the C library compute, with the same bits on each machine."""

from percuss.numerics.functions import (
    atan2,
    cos,
    exp,
    expm1,
    geometric,
    hypot,
    log,
    phasor,
    power,
    sin,
    tan,
)
from percuss.numerics.linear import (
    determinant,
    directions,
    dot,
    inverse,
    is_finite,
    least_squares,
    matmul,
    norm,
    solve_linear,
)

__all__ = [
    "atan2",
    "cos",
    "determinant",
    "directions",
    "dot",
    "exp",
    "expm1",
    "geometric",
    "hypot",
    "inverse",
    "is_finite",
    "least_squares",
    "log",
    "matmul",
    "norm",
    "phasor",
    "power",
    "sin",
    "solve_linear",
    "tan",
]
