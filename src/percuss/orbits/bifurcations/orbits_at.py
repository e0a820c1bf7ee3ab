"""The orbits of a branch at one value of its parameter."""

from __future__ import annotations

from itertools import pairwise
from typing import Any, overload

from percuss.errors import ConvergenceError, ParameterError
from percuss.model.exact import Phase, as_float, real
from percuss.orbits.bifurcations.branch import Branch
from percuss.orbits.bifurcations.continue_orbit import continue_orbit
from percuss.orbits.bifurcations.structure_branch import StructureBranch
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit


@overload
def orbits_at(branch: Branch, value: Phase) -> list[PeriodicOrbit]: ...
@overload
def orbits_at(branch: StructureBranch, value: Phase) -> list[StructureOrbit]: ...
def orbits_at(branch: Branch | StructureBranch, value: Phase) -> list[Any]:
    """Return the orbits of a branch at one value of its parameter, in the order of its rows.

    Each is solved for from the nearer of the two rows that it lies between; a branch that turns
    back has several.

    Parameters
    ----------
    branch
        A branch, as `continue_orbit` makes it.
    value
        The value of the parameter, with its dimension.

    Returns
    -------
    list of PeriodicOrbit or StructureOrbit
        Empty where the branch does not come to the value.

    Raises
    ------
    ParameterError
        If it is no branch, or the value is not a finite number.
    ConvergenceError
        If one of the orbits is not found, as next to a fold or at a jump of the branch.

    Examples
    --------
    >>> import percuss as pc
    >>> orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
    >>> branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.8)})
    >>> [other] = pc.orbits_at(branch, 2.7)
    >>> other.multipliers.real.round(4), other.is_stable
    (array([-1.729 , -0.3702]), False)
    """
    if not isinstance(branch, Branch | StructureBranch):
        raise ParameterError("branch", branch, "not a branch; continue_orbit() follows one")
    wanted = real("value", value)
    found = []
    for row, (before, after) in enumerate(pairwise(branch.values.tolist())):
        if before == wanted and (row == 0 or branch.values[row - 1] != wanted):
            found.append(branch.orbits[row])
        if (before - wanted) * (after - wanted) < 0.0:
            nearer = row if abs(before - wanted) <= abs(after - wanted) else row + 1
            found.append(_carried(branch, nearer, value))
    if branch.values[-1] == wanted:
        found.append(branch.orbits[-1])
    return found


def _carried(branch: Branch | StructureBranch, row: int, value: Phase) -> Any:
    """Return the orbit to which that of a row leads at a value."""
    own, wanted = float(branch.values[row]), as_float(value)
    part = continue_orbit(branch.orbits[row], over={branch.path: (own, value)}, largest_step=1.0)
    for orbit, reached in zip(part.orbits, part.values.tolist(), strict=True):
        if reached == wanted:
            return orbit
    what = f"no orbit of the branch at {branch.path} = {wanted:.12g}"
    raise ConvergenceError(what, own, abs(own - wanted), part.end_reason)
