"""The states of the impact surface that lead to an impact without velocity."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError
from percuss.kernels import law as at
from percuss.kernels.flight import constant_force
from percuss.kernels.law import Law
from percuss.model.exact import as_float, real, whole
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.stops import Wall
from percuss.orbits.orbit.chain import entry, row_of_region
from percuss.orbits.surface.backward import BackwardMotions
from percuss.orbits.surface.maps import check_period
from percuss.orbits.surface.touch_curves import CurveEnd, Stretch, Tracer, stretches
from percuss.orbits.surface.touch_intervals import touch_intervals

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

__all__ = ["CurveEnd", "SingularityCurve", "SingularitySet", "singularity_set"]

Floats = NDArray[np.float64]

# Forcing periods, or natural ones, over which a touch is followed back.
LONGEST = 20.0


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class SingularityCurve:
    """One curve of a singularity set: states along the instant of the touch they lead to.

    Attributes
    ----------
    touched
        Index of the stop that is touched.
    iterate
        n where the touch takes the place of the n-th next impact on the set's own stop, or on
        another stop comes between the (n - 1)-th and the n-th.
    cycle
        (n,) array, continuous along the curve; the first lies in [0, 1), others may leave it.
    v_after
        (n,) array, velocities after the impact, or into the soft stop [length/time].
    touch_cycle
        (n,) array, cycle of the touch, continuous; not less than that of the state.
    duration
        (n,) array, time from the state to the touch [time].
    n_between
        (n,) array, events between the state and the touch: impacts and crossings of edges.
    begins, ends
        Why the curve begins and ends there. "tangency": there the motion touches a stop a second
        time; "zero_velocity": the impact is a touch itself; "no_acceleration": the force at the
        touch vanishes; "longest": the way back is cut off; "no_restitution": it leads to an
        impact that leaves no velocity; "unresolved": `max_points` was too few; "closed": it
        returns to where it began.
    """

    touched: int
    iterate: int
    cycle: Floats
    v_after: Floats
    touch_cycle: Floats
    duration: Floats
    n_between: NDArray[np.int64]
    begins: CurveEnd
    ends: CurveEnd

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.cycle)

    def __repr__(self) -> str:
        """Tell the curve in a line."""
        return (
            f"<SingularityCurve: {len(self)} points, iterate {self.iterate}, touches stop "
            f"{self.touched}; begins at {self.begins}, ends at {self.ends}>"
        )


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class SingularitySet:
    """Curves in the impact surface on which an impact map is singular; see `singularity_set`.

    Attributes
    ----------
    oscillator, forcing
        What moves.
    stop
        Index of the stop whose impact surface it is.
    curves
        The curves.
    """

    oscillator: Oscillator
    forcing: Forcing
    stop: int
    curves: tuple[SingularityCurve, ...] = field(repr=False)

    def __len__(self) -> int:
        """Return the number of curves."""
        return len(self.curves)

    def __iter__(self) -> Iterator[SingularityCurve]:
        """Go through the curves."""
        return iter(self.curves)

    def __getitem__(self, i: int) -> SingularityCurve:
        """Return a curve."""
        return self.curves[i]

    def __repr__(self) -> str:
        """Tell the set in a line."""
        points = sum(len(curve) for curve in self.curves)
        return f"<SingularitySet of stop {self.stop}: {len(self)} curves, {points} points>"

    def to_xarray(self) -> Dataset:
        """Return all points as one dataset, for files and for pandas (`.to_dataframe()`).

        Returns
        -------
        xarray.Dataset
            Along ``point``, with the number of the curve beside each; what belongs to whole
            curves along ``curve``.

        Examples
        --------
        >>> import percuss as pc
        >>> found = pc.singularity_set(pc.impact_oscillator(0.8), pc.cosine(2.5))
        >>> list(found.to_xarray().sizes)
        ['point', 'curve']
        """
        import xarray

        def along(name: str) -> Floats:
            parts = [getattr(curve, name) for curve in self.curves]
            return np.concatenate(parts) if parts else np.empty(0)

        sizes = [len(curve) for curve in self.curves]
        names = ("cycle", "v_after", "touch_cycle", "duration", "n_between")
        curves: dict[str, tuple[str, object]] = {
            name: ("curve", np.array([getattr(curve, name) for curve in self.curves], dtype=kind))
            for name, kind in (("touched", int), ("iterate", int), ("begins", str), ("ends", str))
        }
        points = {name: ("point", along(name)) for name in names}
        number = {"number": ("point", np.repeat(np.arange(len(sizes)), sizes))}
        return xarray.Dataset({**points, **number, **curves}, attrs={"stop": self.stop})


def singularity_set(
    osc: Oscillator,
    force: Forcing,
    stop: int = 0,
    *,
    n_iterates: int = 1,
    touched: int | None = None,
    spacing: float = 0.005,
    longest: float | None = None,
    max_points: int = 20_000,
) -> SingularitySet:
    """Return the states of an impact surface that lead to an impact without velocity.

    There the impact map has a square root on the one side and a jump across. Each touch, at any
    instant at which the force leads the mass off the stop, is followed back in closed form to
    the impacts before it, the first of which is the state; the way back is searched with proof.
    So a curve has no false parts. It ends where its motion touches a stop twice.

    Parameters
    ----------
    osc
        The oscillator.
    force
        The forcing, with a period.
    stop
        Index of the stop whose impact surface (cycle, v_after) is looked at.
    n_iterates
        Touches at up to the so many-th next impact on that stop, >= 1.
    touched
        Index of the stop that is touched; default: the stop itself, and any wall.
    spacing
        Largest distance of neighbouring points, with a cycle and the largest velocity as units,
        > 0. Pieces of a curve whose touches all lie within 1/512 of a period may be missed.
    longest
        How far a touch is followed back [time]; default: 20 forcing periods, or natural ones
        where these are longer.
    max_points
        Touches of one stop after which no more are followed. Where a touch has a past without
        end, curves without number accumulate; those that are too fine end "unresolved".

    Returns
    -------
    SingularitySet
        Its curves.

    Raises
    ------
    ParameterError
        If there is no such stop, the forcing has no period, a number is out of its range, or
        more than one iterate is wanted of a wall without restitution: then nothing tells what
        came before an impact.

    Notes
    -----
    Singularity sets and what they do to attractors: Budd & Dux (1994), Phil. Trans. R. Soc. A
    347, 365. docs/theory/impact-surface.md tells how the way back is found.

    Examples
    --------
    Off a wall at the equilibrium the touch at phase theta of the unforced state is hit after
    half a natural period:

    >>> import percuss as pc
    >>> found = pc.singularity_set(pc.impact_oscillator(0.8), pc.cosine(2.5))
    >>> curve = found[0]
    >>> v = float(curve.v_after[50])
    >>> run = pc.simulate(found.oscillator, found.forcing, x0=0.0, v0=v,
    ...                   t0=float(curve.cycle[50]) * found.forcing.period, t_end=20.0)
    >>> x, speed = run(run.t0 + float(curve.duration[50]))
    >>> bool(abs(x) < 1e-12), bool(abs(speed) < 1e-12)
    (True, True)
    """
    check_period(osc, force, "a singularity set")
    stop, n_iterates = whole("stop", stop, 0), whole("n_iterates", n_iterates, 1)
    spacing = real("spacing", spacing)
    longest = None if longest is None else real("longest", longest)
    wanted = entry(osc, stop)
    _check(osc, stop, n_iterates, spacing, longest)
    motions = BackwardMotions(osc, force)
    period = float(motions.law[0, at.PERIOD])
    if longest is None:
        longest = LONGEST * max(period, _natural_period(motions.law))
    walls = [i for i, it in enumerate(osc.stops) if isinstance(it, Wall) or i == stop]
    curves: list[SingularityCurve] = []
    for which in walls if touched is None else [touched]:
        met = entry(osc, which)
        place = as_float(osc.stops[which].at)
        tracer = Tracer(motions, place, met, wanted, n_iterates, longest)
        force_there = constant_force(motions.law, row_of_region(motions.law, met.before), place)
        for interval in touch_intervals(motions.law, force_there, -met.way):
            found = stretches(tracer, interval, period, spacing, max_points)
            curves += [_curve(which, stretch, period) for stretch in found]
    curves.sort(key=lambda curve: (curve.iterate, curve.touched))
    return SingularitySet(osc, force, stop, tuple(curves))


def _check(
    osc: Oscillator, stop: int, n_iterates: int, spacing: float, longest: float | None
) -> None:
    if not spacing > 0.0:
        raise ParameterError("spacing", spacing, "not positive")
    if longest is not None and not longest > 0.0:
        raise ParameterError("longest", longest, "not a finite positive time")
    it = osc.stops[stop]
    if n_iterates > 1 and isinstance(it, Wall) and as_float(it.restitution) == 0.0:
        reason = "with restitution 0 nothing tells what came before an impact; at most 1"
        raise ParameterError("n_iterates", n_iterates, reason)


def _natural_period(table: Law) -> float:
    """Return the longest period of free motion in a region; 0 if none oscillates."""
    longest = 0.0
    for number in range(int(table[0, at.N_REGIONS])):
        row = row_of_region(table, number)
        if table[row, at.OVERDAMPED] == 0.0 and table[row, at.RATE] > 0.0:
            longest = max(longest, 2.0 * math.pi / float(table[row, at.RATE]))
    return longest


def _curve(touched: int, stretch: Stretch, period: float) -> SingularityCurve:
    whole = math.floor(stretch.t[0] / period)
    return SingularityCurve(
        touched=touched,
        iterate=stretch.iterate,
        cycle=stretch.t / period - whole,
        v_after=stretch.v,
        touch_cycle=stretch.touch / period - whole,
        duration=stretch.touch - stretch.t,
        n_between=stretch.n_between,
        begins=stretch.begins,
        ends=stretch.ends,
    )
