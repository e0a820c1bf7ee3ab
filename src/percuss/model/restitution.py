"""Restitution as one number, or as a table over the speed of the impact."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from percuss.model.exact import Computed, Exact, as_float, as_fraction, number_problem, plain
from percuss.model.faults import Fault, as_tuple, dotted, faults, number_faults, raise_first


@dataclass(frozen=True, slots=True)
class RestitutionTable:
    """Restitution over the speed of an impact; made by `restitution_table`.

    Attributes
    ----------
    speeds
        Speeds of impacts [length/time], increasing.
    values
        The restitution at each.
    """

    speeds: tuple[Exact, ...]
    values: tuple[Exact, ...]

    def __post_init__(self) -> None:
        for name in ("speeds", "values"):
            given = as_tuple(getattr(self, name))
            if isinstance(given, tuple):
                given = tuple(plain(value) for value in given)
            object.__setattr__(self, name, given)
        raise_first(faults(self))

    def __repr__(self) -> str:
        """Return the call that makes it."""
        return f"restitution_table(speeds={self.speeds!r}, values={self.values!r})"


Restitution: TypeAlias = Exact | RestitutionTable


def restitution_table(speeds: Iterable[Exact], values: Iterable[Exact]) -> RestitutionTable:
    """Return a restitution that depends on the speed of the impact.

    It is linear between the speeds given and constant below the first and above the last.

    Parameters
    ----------
    speeds
        Speeds of impacts [length/time], >= 0 and increasing.
    values
        The restitution r at each, above 0 and up to 1. The speed after an impact, r(v) v, has to
        grow with the speed v before it.

    Returns
    -------
    RestitutionTable
        For ``restitution=`` of a `Wall`.

    Raises
    ------
    ParameterError
        If a number is outside its domain, the two differ in length, or faster impacts would leave
        slower.

    Examples
    --------
    Metals lose more of a faster impact:

    >>> import percuss as pc
    >>> steel = pc.restitution_table(speeds=["0.1", 1, 5], values=["0.9", "0.8", "0.65"])
    >>> run = pc.simulate(pc.impact_oscillator(steel), v0=3, max_impacts=3)
    >>> (abs(run.impacts.v_after) / abs(run.impacts.v_before)).round(4)
    array([0.725 , 0.7559, 0.7758])
    """
    # What is no sequence is told as the other faults are.
    return RestitutionTable(speeds, values)  # type: ignore[arg-type]


def restitution_knots(restitution: Restitution) -> tuple[tuple[Fraction, Fraction], ...]:
    """Return (speed, restitution) of a table; of a number one, at rest.

    Examples
    --------
    >>> restitution_knots("0.5")
    ((Fraction(0, 1), Fraction(1, 2)),)
    """
    if not isinstance(restitution, RestitutionTable):
        return ((Fraction(0), as_fraction(restitution)),)
    return tuple(
        (as_fraction(speed), as_fraction(value))
        for speed, value in zip(restitution.speeds, restitution.values, strict=True)
    )


def restitution_at_rest(restitution: Restitution) -> float:
    """Return the restitution of the slowest impacts.

    Examples
    --------
    >>> restitution_at_rest(restitution_table([1, 2], ["0.9", "0.8"])), restitution_at_rest("0.7")
    (0.9, 0.7)
    """
    return float(restitution_knots(restitution)[0][1])


def is_elastic(restitution: Restitution) -> bool:
    """Return whether no impact loses energy.

    Examples
    --------
    >>> is_elastic(1), is_elastic(restitution_table([1, 2], [1, "0.9"]))
    (True, False)
    """
    return all(value == 1 for _, value in restitution_knots(restitution))


@faults.register
def _(value: RestitutionTable, prefix: str | None = None) -> list[Fault]:
    wrong: list[Fault] = []
    columns: dict[str, tuple[Any, ...]] = {}
    for name in ("speeds", "values"):
        given, path = getattr(value, name), dotted(prefix, name)
        if not isinstance(given, tuple):
            wrong.append(Fault(path, given, "not a list of numbers"))
            continue
        columns[name] = given
        for i, number in enumerate(given):
            wrong += _number_faults(f"{path}.{i}", number, name)
    wrong += _order_faults(columns.get("speeds", ()), dotted(prefix, "speeds"))
    if len(columns) == 2:
        n_speeds, n_values = len(columns["speeds"]), len(columns["values"])
        if n_speeds == 0 or n_values != n_speeds:
            reason = f"{n_values} for {n_speeds} speeds; give one value at each, and at least one"
            wrong.append(Fault(dotted(prefix, "values"), value.values, reason))
    if wrong:
        return wrong
    for (u0, r0), (u1, r1) in itertools.pairwise(restitution_knots(value)):
        slope = (r1 - r0) / (u1 - u0)
        # The derivative of r(u) u is linear between two knots.
        if min(r0 + slope * u0, r1 + slope * u1) <= 0:
            reason = (
                f"the restitution falls so fast from speed {float(u0):g} to {float(u1):g} that a "
                "faster impact leaves slower; r(v) v has to grow"
            )
            return [Fault(dotted(prefix, "values"), value.values, reason)]
    return []


def _order_faults(speeds: tuple[Any, ...], path: str) -> list[Fault]:
    """Return the faults of speeds that are not above the one before, where both are numbers."""
    return [
        Fault(f"{path}.{i}", after, f"not above the speed before it, {before}")
        for i, (before, after) in enumerate(itertools.pairwise(speeds), 1)
        if number_problem(before) is None
        and number_problem(after) is None
        and not as_float(before) < as_float(after)
    ]


def _number_faults(path: str, number: object, name: str) -> list[Fault]:
    if isinstance(number, Computed):
        return [Fault(path, number, "an expression; a table holds numbers")]
    problems = number_faults(path, number)
    if problems:
        return problems
    size = as_float(number)  # type: ignore[arg-type]
    if name == "speeds" and size < 0.0:
        return [Fault(path, number, "negative; it is the size of the velocity")]
    if name == "values" and size > 1.0:
        return [Fault(path, number, "above 1; an impact would create energy")]
    if name == "values" and size <= 0.0:
        return [Fault(path, number, "not above 0; restitution=0 is a wall that stops every mass")]
    return []
