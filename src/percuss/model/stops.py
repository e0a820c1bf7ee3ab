"""The stops: rigid walls and soft stops, and which of them fit together."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from percuss.model.exact import Exact, as_float
from percuss.model.faults import (
    Fault,
    damping_faults,
    dotted,
    faults,
    make_plain,
    number_faults,
    raise_first,
    scale_faults,
)

__all__ = ["Side", "SoftStop", "Stop", "Wall"]

Side: TypeAlias = Literal["above", "below"]


@dataclass(frozen=True, slots=True)
class Wall:
    """A rigid stop: the motion stays on one side of it, and an impact turns v into -r v.

    Parameters
    ----------
    at
        Position [length], finite.
    side
        On which side of the free motion the wall lies: a wall ``"below"`` keeps x >= at.
    restitution
        Coefficient of restitution r, in [0, 1].

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> Wall(at=-1.0, side="below", restitution="0.7")
    Wall(at=-1.0, side='below', restitution='0.7')
    """

    at: Exact
    side: Side
    restitution: Exact = 1.0

    def __post_init__(self) -> None:
        make_plain(self, "at", "side", "restitution")
        raise_first(faults(self))


@dataclass(frozen=True, slots=True)
class SoftStop:
    """A compliant stop: it adds the force -k_s (x - at) - 2 a_s x' while x is beyond it.

    Contact is by geometry, so the dashpot may pull. With a_s > 0 the force jumps where the
    stop is reached, with a_s = 0 it is continuous there.

    Parameters
    ----------
    at
        Position [length], finite.
    side
        On which side of the free motion the stop lies: ``"above"`` acts on x > at.
    stiffness
        Stiffness k_s per unit mass [1/time^2], of any sign.
    damping
        Damping a_s per unit mass [1/time], >= 0.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> SoftStop(at=1.0, side="above", stiffness=29.0)
    SoftStop(at=1.0, side='above', stiffness=29.0, damping=0.0)
    """

    at: Exact
    side: Side
    stiffness: Exact
    damping: Exact = 0.0

    def __post_init__(self) -> None:
        make_plain(self, "at", "side", "stiffness", "damping")
        raise_first(faults(self))


Stop: TypeAlias = Wall | SoftStop


@faults.register
def _(value: Wall, prefix: str | None = None) -> list[Fault]:
    problems = [
        *number_faults(dotted(prefix, "at"), value.at),
        *_side_faults(dotted(prefix, "side"), value.side),
    ]
    name = dotted(prefix, "restitution")
    not_a_number = number_faults(name, value.restitution)
    if not_a_number:
        return problems + not_a_number
    restitution = as_float(value.restitution)
    if restitution > 1.0:
        reason = "outside [0, 1]; above 1 an impact would create energy"
        problems.append(Fault(name, value.restitution, reason))
    elif restitution < 0.0:
        reason = "outside [0, 1]; below 0 the motion would pass through the wall"
        problems.append(Fault(name, value.restitution, reason))
    return problems


@faults.register
def _(value: SoftStop, prefix: str | None = None) -> list[Fault]:
    return [
        *number_faults(dotted(prefix, "at"), value.at),
        *_side_faults(dotted(prefix, "side"), value.side),
        *scale_faults(dotted(prefix, "stiffness"), value.stiffness),
        *damping_faults(dotted(prefix, "damping"), value.damping),
    ]


def stops_faults(stops: tuple[Stop, ...], prefix: str | None = None) -> list[Fault]:
    """Return the faults of stops, each right in itself, that do not fit together."""
    problems: list[Fault] = []
    walls: dict[Side, int] = {}
    for index, stop in enumerate(stops):
        if not isinstance(stop, Wall):
            continue
        first = walls.setdefault(stop.side, index)
        if first != index:
            reason = (
                f"a second wall {stop.side}; stops.{first} at x = {stops[first].at} is one,"
                " keep the inner of the two"
            )
            problems.append(Fault(dotted(prefix, f"stops.{index}.side"), stop.side, reason))
    if len(walls) == 2:
        below, above = stops[walls["below"]], stops[walls["above"]]
        if as_float(below.at) >= as_float(above.at):
            reason = f"not above the lower wall at x = {below.at}; the walls leave no room"
            problems.append(Fault(dotted(prefix, f"stops.{walls['above']}.at"), above.at, reason))
    for index in walls.values():
        problems += _behind_faults(stops, stops[index], prefix)
    return problems


def _behind_faults(stops: tuple[Stop, ...], wall: Stop, prefix: str | None) -> list[Fault]:
    sign = 1.0 if wall.side == "above" else -1.0
    problems = []
    for index, stop in enumerate(stops):
        # Compared as the doubles they become: two texts of one double are one position.
        depth = sign * (as_float(stop.at) - as_float(wall.at))
        if isinstance(stop, Wall) or depth < 0.0:
            continue
        place = "at" if depth == 0.0 else "behind"
        effect = (
            "it would never act"
            if stop.side == wall.side
            else "it would always act, as stiffness, damping and a constant force do"
        )
        reason = f"{place} the wall {wall.side} at x = {wall.at}, where {effect}"
        problems.append(Fault(dotted(prefix, f"stops.{index}.at"), stop.at, reason))
    return problems


def _side_faults(name: str, side: object) -> list[Fault]:
    if isinstance(side, str) and side in {"above", "below"}:
        return []
    return [Fault(name, side, 'neither "above" nor "below"')]
