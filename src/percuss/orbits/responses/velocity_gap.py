"""Impact velocity against gap of orbits with one impact: an ellipse, in closed form.

The equations of a flight from the wall and back to it after n forcing periods (`single_impact`),

    M (p, q) = b + d U,    p^2 + q^2 = A^2,

hold the position s of the wall in b alone, through the constant force G at the wall, which is
G = c - k s for a spring k and a constant force c: with D and S of `single_impact`,
b = -G (D, S) = k (s - s0) (D, S), s0 = c/k, the equilibrium. So

    (p, q) = B (s - s0, U),    B = M^-1 (k (D, S), d),

and the circle of (p, q) is the image of an ellipse around the equilibrium: with the angle z of
the force at the impact,

    (s - s0, U) = A B^-1 (cos z, sin z).

Whiston (1987) and Budd & Dux (1994, Phil. Trans. R. Soc. A 347, 365) draw it for an undamped
oscillator; damping changes M and d only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Flags, Floats
from percuss.errors import ParameterError
from percuss.kernels import law_columns as at
from percuss.kernels.flight import free_response
from percuss.model.exact import MOST_ROWS, as_float, whole
from percuss.model.force_record import refuse_record
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.paths import replace_parameter
from percuss.model.system import System
from percuss.numerics import (
    atan2,
    cos,
    directions,
    inverse,
    is_finite,
    matmul,
    norm,
    sin,
    solve_linear,
)
from percuss.orbits.finding.search_budget import check_length
from percuss.orbits.finding.single_impact import (
    cycle_of,
    equations_of,
    has_closed_form,
    orbit_of_root,
    single_impact,
)
from percuss.orbits.orbit.itinerary import entry, row_of_region
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.pictures import HasPicture
from percuss.wording import counted

# Below this part of the larger one, a singular value of a matrix is rounding.
SINGULAR = 1e-12


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class VelocityGap(HasPicture):
    """Single-impact orbits of n forcing periods as the wall moves, made by `velocity_gap_curve`.

    Attributes
    ----------
    n_periods
        Forcing periods of an orbit.
    equilibrium
        Where the mass rests without the harmonic: the ellipse has its centre there [length].
    form
        (2, 2) array Q, symmetric: with z = (gap, velocity) the ellipse is z Q z = 1.
    graze
        Gap with which the impact has no velocity, on one side of the ellipse and, negative, on
        the other: the amplitude of the motion without impacts [length].
    fold, fold_velocity
        Gap at which two orbits meet, the farthest one from the equilibrium on either side, and
        their velocity there; between it and the graze on its side each gap has two orbits
        [length, length/time].
    largest_velocity
        Height of the ellipse [length/time].
    gap
        (n,) array, distance of the wall from the equilibrium towards the side on which it lies,
        negative where the wall is beyond it; the physical half of the ellipse, from one graze to
        the other [length].
    velocity
        (n,) array, into the wall, >= 0 [length/time].
    cycle
        (n,) array, cycle of the impact.
    stability
        (n,) array of texts, as in `PeriodicOrbit`; "" at the grazes.
    admissible
        (n,) array, whether the motion passes the wall nowhere between its impacts.
    """

    picture: ClassVar = "plot_velocity_gap"

    n_periods: int
    equilibrium: float
    form: Floats
    graze: float
    fold: float
    fold_velocity: float
    largest_velocity: float
    gap: Floats
    velocity: Floats
    cycle: Floats
    stability: NDArray[np.str_]
    admissible: Flags

    @property
    def is_stable(self) -> Flags:
        """Whether neighbours approach each orbit, (n,)."""
        return np.asarray(self.stability == "asymptotic")

    def velocities_at(self, gap: float) -> Floats:
        """Return the velocities > 0 into the wall with a gap, the larger first.

        Parameters
        ----------
        gap
            Distance of the wall from the equilibrium.

        Returns
        -------
        array
            (k,), k = 0, 1 or 2.
        """
        (q00, q01), (_, q11) = self.form
        below = q01 * gap * (q01 * gap) - q11 * (q00 * gap * gap - 1.0)
        if below < 0.0:
            return np.empty(0)
        roots = (-q01 * gap + np.array([1.0, -1.0]) * math.sqrt(below)) / q11
        return np.asarray(roots[roots > 0.0])

    def __repr__(self) -> str:
        """Return the curve in a line."""
        return (
            f"<VelocityGap: 1 impact in {counted(self.n_periods, 'forcing period')}, grazing with "
            f"gaps of {self.graze:.6g} and {-self.graze:.6g}, fold at {self.fold:.6g}, largest "
            f"velocity {self.largest_velocity:.6g}>"
        )


def velocity_gap_curve(
    osc: Oscillator, force: Forcing, n_periods: int = 1, *, n_points: int = 361
) -> VelocityGap:
    """Return impact velocity against gap of orbits with one impact in n forcing periods.

    The curve is an ellipse around the equilibrium, in closed form, for one wall and one harmonic.
    Stability and admissibility are those of the orbits along it.

    Parameters
    ----------
    osc
        The oscillator, with one wall and a spring; the position of the wall does not matter.
    force
        One harmonic, and a constant.
    n_periods
        Forcing periods of an orbit, >= 1.
    n_points
        Rows of the table, >= 3.

    Returns
    -------
    VelocityGap
        The ellipse, its limits, and a table along its physical half.

    Raises
    ------
    ParameterError
        If the oscillator has no spring, not one wall, or the forcing not one harmonic, or where
        the ellipse degenerates: elastic impacts without damping, or n periods that are whole
        periods of the free motion.

    Examples
    --------
    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
    >>> curve = velocity_gap_curve(osc, pc.cosine(1.0))
    >>> round(curve.graze, 9), round(curve.fold, 6)
    (10.0, 10.002925)
    >>> orbit = pc.find_orbit(osc, pc.cosine(1.0))
    >>> bool(abs(curve.velocities_at(1.0)[0] - orbit.impacts.v_before[0]) < 1e-12)
    True
    """
    n_periods = whole("n_periods", n_periods, 1)
    n_points = whole("n_points", n_points, 3, MOST_ROWS)
    system = System.of(osc, force)
    _check(system)
    check_length(system.law, 1, n_periods)
    map_, rest, sign = _map(system, n_periods)
    # Columns (gap, velocity) as functions of the angle: towards the wall both are positive.
    axes = sign * inverse(map_)
    angles = _physical_half(axes[1], n_points)
    circle = np.array([cos(angles), sin(angles)])
    gap, velocity = matmul(axes, circle)
    velocity[[0, -1]] = 0.0
    widths = matmul(axes, axes.T)
    law = system.law
    amplitude = float(law[at.FIRST_HARMONIC, at.AMPLITUDE])
    cycle = np.array([cycle_of(law, p, q) for p, q in (amplitude * circle).T])
    rows = zip(gap.tolist(), velocity.tolist(), cycle.tolist(), strict=True)
    orbits = [_orbit(system, n_periods, rest + sign * g, c, sign * v) for g, v, c in rows]
    return VelocityGap(
        n_periods=n_periods,
        equilibrium=rest,
        form=matmul(map_.T, map_),
        graze=1.0 / norm(map_[:, 0]),
        fold=math.copysign(math.sqrt(widths[0, 0]), widths[0, 1]),
        fold_velocity=abs(float(widths[0, 1])) / math.sqrt(widths[0, 0]),
        largest_velocity=norm(axes[1]),
        gap=gap,
        velocity=velocity,
        cycle=cycle,
        stability=np.array([orbit.stability if orbit else "" for orbit in orbits]),
        admissible=np.array([bool(orbit and orbit.admissible) for orbit in orbits]),
    )


def _check(system: System) -> None:
    osc = system.oscillator
    refuse_record(system.forcing, "this curve")
    if len(osc.stops) != 1 or not has_closed_form(system, 0):
        reason = "the closed form is for one wall and no other stop, under one harmonic"
        raise ParameterError("osc", osc, reason)
    if as_float(osc.stiffness) == 0.0:
        reason = "without a spring the velocity does not depend on where the wall is"
        raise ParameterError("oscillator.stiffness", osc.stiffness, reason)


def _map(system: System, n_periods: int) -> tuple[Floats, float, float]:
    """Return B / A, which maps (s - s0, U) to the unit circle; s0; and the sign into the wall."""
    (osc, force), law = system.of_unit_mass, system.law
    assert force is not None
    matrix, _, of_velocity = equations_of(system, n_periods, 0)
    met = entry(osc, 0)
    row = row_of_region(law, met.before)
    impulse, _, rise = free_response(law, row, n_periods * float(law[0, at.PERIOD]))
    stiffness = as_float(osc.stiffness)
    right = np.column_stack([stiffness * np.array([rise, impulse]), of_velocity])
    amplitude = float(law[at.FIRST_HARMONIC, at.AMPLITUDE])
    scale = np.array([1.0, float(law[at.FIRST_HARMONIC, at.OMEGA])])
    if amplitude == 0.0 or _is_singular(matrix / scale[:, np.newaxis]):
        reason = f"the free motion closes after {n_periods} forcing periods, or there is no force"
        raise ParameterError("n_periods", n_periods, f"{reason}: there is no ellipse")
    map_ = solve_linear(matrix, right) / amplitude
    if _is_singular(map_ * scale):
        reason = "the ellipse degenerates into lines: impacts are elastic and nothing is damped,"
        raise ParameterError("osc", osc, f"{reason} or a whole number of free periods passes")
    return np.asarray(map_, dtype=np.float64), as_float(force.constant) / stiffness, met.sign


def _is_singular(matrix: Floats) -> bool:
    if not is_finite(matrix):
        return True
    sizes, _ = directions(matrix)
    return bool(sizes[1] <= SINGULAR * sizes[0])


def _physical_half(of_velocity: Floats, n_points: int) -> Floats:
    """Return the angles at which a cosine and a sine with these factors are not negative."""
    middle = atan2(float(of_velocity[1]), float(of_velocity[0]))
    return np.linspace(middle - 0.5 * math.pi, middle + 0.5 * math.pi, n_points)


def _orbit(
    system: System, n_periods: int, wall: float, cycle: float, u: float
) -> PeriodicOrbit | None:
    osc, force, _ = replace_parameter(*system, None, "oscillator.stops.0.at", wall)
    assert force is not None
    return orbit_of_root(System(osc, force), single_impact(osc, force, n_periods), cycle, u)
