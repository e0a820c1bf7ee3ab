"""The end of a curve of folds on that of period doublings or of symmetry breakings.

Beyond it come the same orbits, a period later or mirrored. In the point both curves solve the
equations, so that Newton's method does not tell them apart next to it: the curve is even in the
difference of the orbit from the simpler one, and the point is where a polynomial in its square is
at zero.
"""

from __future__ import annotations

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.numerics import dot, norm
from percuss.orbits.bifurcations.bifurcation_origin import Origin, difference_from_simpler
from percuss.orbits.bifurcations.curve_equations import CurveEquations
from percuss.orbits.continuation.locate import Zero
from percuss.orbits.continuation.problem import Point

# Parts of the difference from the simpler orbit at which the curve is taken, besides the whole:
# nearer ones, at which the equations are nearly singular, make the polynomial no better.
PARTS = 0.5, 0.25, 0.125, 0.0625


def origin_of_folds(
    a: Point[CurveEquations], b: Point[CurveEquations]
) -> tuple[Origin, Zero] | None:
    """Return the simpler orbit to which folds come between two points, and where; None for none.

    The ends of the zero are the nearest point of the curve, its orbit made the simpler one, and as
    far on the other side.
    """
    differences = [
        difference_from_simpler(each.problem.orbits, each.z[:-2], each.orbit) for each in (a, b)
    ]
    one, other = differences
    if one is None or other is None or dot(one, other) >= 0.0:
        return None
    origin: Origin = "mirrored" if a.orbit.n_periods % 2 else "doubled"
    sign = -1.0 if origin == "mirrored" else 1.0
    part = norm(one) / norm(one - other)
    chord = b.z - a.z
    normal = chord / norm(chord)
    near = [a.z]
    for left in PARTS:
        guess = a.z + (1.0 - left) * part * chord
        try:
            near.append(a.problem.corrected(guess, normal, near_others=True))
        except PercussError:
            # Too near to the other curve.
            break
    squares = [norm((z - _again(z, sign))[1:]) ** 2 for z in near]
    values = [0.5 * (z + _again(z, sign)) for z in near]
    nearest = values[-1]
    # Neville's polynomials at zero; the last is through all points.
    for order in range(1, len(values)):
        for k in range(len(values) - 1, order - 1, -1):
            rise = (values[k] - values[k - 1]) / (squares[k] - squares[k - order])
            values[k] = values[k] - squares[k] * rise
    z = values[-1]
    orbit = a.problem.solution(z)
    return origin, Zero(part, z, orbit, (nearest, 2.0 * z - nearest), goes_through=True)


def _again(z: Floats, sign: float) -> Floats:
    """Return the same orbit from its second half on, with velocities times a sign."""
    n = (len(z) - 3) // 2
    first, durations, velocities = z[0], z[1 : 1 + n], z[1 + n : -2]
    # Half a period earlier than its second half begins.
    instant = first + durations[: n // 2].sum() - 0.5 * durations.sum()
    halves = np.roll(durations, n // 2), sign * np.roll(velocities, n // 2)
    return np.concatenate([[instant], *halves, z[-2:]])
