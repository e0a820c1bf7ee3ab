"""Period-doubling cascades."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, ParameterError
from percuss.model.exact import Phase, whole
from percuss.numerics import solve_linear
from percuss.orbits.bifurcations.branch_equations import BranchEquations
from percuss.orbits.bifurcations.detector import BranchDetector
from percuss.orbits.bifurcations.parameter_ranges import checked_range, own_value
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.bifurcations.switching import switch_branch
from percuss.orbits.continuation.follow import StepLimits, follow
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.progress import Progress, Report
from percuss.wording import counted

STEPS = StepLimits(max_points=1000, largest=0.02)
# Distance beyond a doubling in which the next is searched for, in distances of the last two: these
# shrink by some 4.7 each time.
AHEAD = 1.5
# From a doubling that is uncertain by more than this part of its distance from the last one the
# next cannot be predicted.
RESOLVED = 0.05
# Special points that end a family of stable orbits before it doubles.
ENDS = {
    "fold": "fold",
    "grazing": "graze",
    "chatter": "chatter",
    "symmetry_breaking": "lose their symmetry",
    "branch_point": "meet another family",
    "border_collision": "meet a jump of the force",
}


@dataclass(frozen=True, slots=True, repr=False, eq=False)
class Cascade:
    """A sequence of period doublings, made by `follow_cascade`.

    Attributes
    ----------
    path
        Path of the parameter.
    points
        The doublings, in order.
    values
        (n,) array, their parameters.
    errors
        (n,) array, their errors by rounding: the change of the condition in one more step of
        Newton's method, over its slope.
    orbits
        The first orbit of each family.
    end_reason
        Why no further doubling was found.
    """

    path: str
    points: tuple[SpecialPoint, ...]
    values: Floats
    errors: Floats
    orbits: tuple[PeriodicOrbit, ...] = field(repr=False)
    end_reason: str

    @property
    def ratios(self) -> Floats:
        """Distances of neighbouring doublings over those of the next two, (n - 2,).

        In a cascade that goes on for ever they tend to 4.6692... (Feigenbaum 1978), and without
        any loss of energy to 8.7211... (Greene, MacKay, Vivaldi & Feigenbaum 1981).
        """
        distances = np.diff(self.values)
        return np.asarray(distances[:-1] / distances[1:])

    @property
    def ratio_errors(self) -> Floats:
        """The errors of the ratios by `errors`, (n - 2,)."""
        distances, doubt = np.abs(np.diff(self.values)), self.errors[1:] + self.errors[:-1]
        parts = doubt / distances
        return np.asarray(np.abs(self.ratios) * (parts[:-1] + parts[1:]))

    def __len__(self) -> int:
        """Return the number of doublings."""
        return len(self.values)

    def __repr__(self) -> str:
        """Return the cascade in a line."""
        last = f", the last ratio {self.ratios[-1]:.4g}" if len(self) > 2 else ""
        doublings = counted(len(self), "period doubling")
        return f"<Cascade: {doublings} in {self.path}{last}; {self.end_reason}>"


def follow_cascade(
    orbit: PeriodicOrbit,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_doublings: int = 6,
    progress: Report = None,
) -> Cascade:
    """Follow an orbit to its period doubling, the doubled orbit to its own, and so on.

    Parameters
    ----------
    orbit
        Where to begin.
    over
        One parameter by its path, and the range to stay in; it is followed towards the second
        value.
    max_doublings
        The most doublings; the equations of the last family are as many times 2^n.
    progress
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called after each step with the number of orbits and the
        most there can be, and stops by returning False: the cascade has the doublings so far.

    Returns
    -------
    Cascade
        With `end_reason`: the parameter reached its end; the orbits folded, or grazed and were
        formal from there on, before they doubled; the doubled orbits lie on the side where the
        single ones are stable; or rounding does not resolve more.

    Raises
    ------
    ParameterError
        As `continue_orbit`, and if the orbit is unstable or formal.

    Examples
    --------
    >>> import percuss as pc
    >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6))
    >>> cascade = follow_cascade(orbit, over={"forcing.omega": (2.6, 2.75)}, max_doublings=4)
    >>> print(cascade.values.round(6))
    [2.653348 2.715987 2.729118 2.731364]
    >>> print(cascade.ratios.round(3))
    [4.77  5.847]
    """
    if isinstance(orbit, StructureOrbit):
        reason = "of a structure; follow each doubling by switch_branch and continue_orbit"
        raise ParameterError("orbit", orbit, reason)
    path, _, last, value = checked_range(orbit, over)
    max_doublings = whole("max_doublings", max_doublings, 1)
    if orbit.stability == "unstable" or not orbit.admissible:
        reason = "unstable" if orbit.admissible else "formal, it passes through a stop"
        raise ParameterError("orbit", orbit, f"{reason}; a cascade starts with a stable orbit")
    if last == value:
        raise ParameterError(path, over[path], "nothing to follow: the orbit is at its end")
    points: list[SpecialPoint] = []
    orbits, errors, end = [orbit], [], last
    total = (max_doublings + 1) * STEPS.max_points
    reported = Progress(progress, total, "orbits", is_bound=True)
    while True:
        point, error, why = _next_doubling(orbits[-1], path, value, end, reported)
        if point is None and end != last and f"{end:.12g} reached" in why:
            # It may lie farther away than the last ones predict.
            point, error, why = _next_doubling(orbits[-1], path, value, last, reported)
        if point is None:
            break
        points.append(point)
        errors.append(error)
        why = _unresolved(points, errors)
        if why or len(points) == max_doublings:
            why = why or f"max_doublings = {max_doublings} reached"
            break
        try:
            orbits.append(switch_branch(point))
        except ConvergenceError as fault:
            why = str(fault)
            break
        towards = math.copysign(1.0, last - value)
        value = own_value(orbits[-1], path)
        if (value - point.value) * towards < 0.0 or orbits[-1].stability == "unstable":
            why = f"the doubling at {path} = {point.value:.12g} is subcritical: the doubled orbits "
            why += "lie where the single ones are stable, and are unstable"
            break
        end = last
        if len(points) > 1:
            end = points[-1].value + AHEAD * (points[-1].value - points[-2].value)
            end = min(end, last) if towards > 0.0 else max(end, last)
    reported.close()
    values = np.array([point.value for point in points])
    return Cascade(path, tuple(points), values, np.array(errors), tuple(orbits), why)


def _next_doubling(
    orbit: PeriodicOrbit, path: str, value: float, end: float, progress: Progress
) -> tuple[SpecialPoint | None, float, str]:
    """Return where an orbit doubles before a value, its error, or why it does not."""
    family = BranchEquations(orbit, path, min(value, end), max(value, end))
    start = family.started(orbit, value)
    sign = math.copysign(1.0, end - value) * math.copysign(1.0, start.tangent[-1])
    rows, why, _ = follow(
        start, sign, BranchDetector(), STEPS, until=_is_turning, progress=progress
    )
    last = rows[-1][1] if rows else None
    if last is None or not _is_turning(last):
        return None, math.nan, why
    if last.kind == "period_doubling":
        return last, _error(family, last, start.tests["multiplier -1"], value), ""
    counts = counted(orbit.n_impacts, "impact") + " in " + counted(orbit.n_periods, "period")
    where = f"{path} = {last.value:.12g}"
    return (
        None,
        math.nan,
        f"the orbits with {counts} {ENDS[last.kind]} at {where} before they double",
    )


def _is_turning(point: SpecialPoint) -> bool:
    return point.kind == "period_doubling" or point.kind in ENDS


def _error(family: BranchEquations, point: SpecialPoint, before: float, value: float) -> float:
    """Return how far one more step of Newton's method would move a doubling."""
    start = family.start(point.orbit, point.value)
    residual, matrix = family.residual(start, point.value)
    again = start.copy()
    again[:-1] -= solve_linear(matrix, residual)
    again = family.corrected(again, along_parameter(len(again)))
    old = family.tests(point.orbit)["multiplier -1"]
    new = family.test(again, "multiplier -1")
    # The condition falls from its value at the start of the family to zero.
    slope = abs(before / (point.value - value))
    return max(abs(new), abs(old), abs(new - old)) / slope + 0.5 * float(np.diff(point.interval)[0])


def _unresolved(points: list[SpecialPoint], errors: list[float]) -> str:
    if len(points) < 2:
        return ""
    distance = abs(points[-1].value - points[-2].value)
    if errors[-1] < RESOLVED * distance:
        return ""
    return (
        f"rounding moves the last doubling by {errors[-1]:.2g}, "
        f"of {distance:.2g} from the one before"
    )
