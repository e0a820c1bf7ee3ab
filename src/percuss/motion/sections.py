"""Sections: at which instants of a motion its state is taken."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from percuss.errors import ParameterError
from percuss.model.exact import real
from percuss.model.expression import Expression

SectionDirection = Literal["up", "down", "both"]
# The sign of the velocity, 0 for either.
DIRECTIONS = {"up": 1.0, "down": -1.0, "both": 0.0}
NAMES = ("stroboscopic", "impacts")
# What a caller gives.
SectionGiven: TypeAlias = Literal["stroboscopic", "impacts"] | Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class PoincareSection:
    """A section, made by `section_of`.

    Attributes
    ----------
    kind
        "stroboscopic": once a forcing period; "impacts": at impacts and entries into soft stops;
        "passages": where a displacement is passed.
    cycle
        Of the strobes, (t / period) mod 1; None: that of the start.
    at, direction
        The displacement [length], and with which sign of the velocity it is passed.
    """

    kind: Literal["stroboscopic", "impacts", "passages"]
    cycle: float | None = None
    at: float = 0.0
    direction: SectionDirection = "both"

    @property
    def given(self) -> str | dict[str, float | str]:
        """What makes it: a name, or the keywords of `Trajectory.stroboscopic` or `section`."""
        if self.kind == "passages":
            return {"at": self.at, "direction": self.direction}
        return self.kind if self.cycle is None else {"cycle": self.cycle}

    @property
    def label(self) -> str:
        """A few words, such as "cycle = 0.25" or "x = 0.3, up"."""
        if self.kind == "passages":
            direction = "" if self.direction == "both" else f", {self.direction}"
            return f"x = {self.at:.12g}{direction}"
        return self.kind if self.cycle is None else f"cycle = {self.cycle:.12g}"

    @property
    def sign(self) -> float:
        """The sign of the velocity at a passage, 0 for either."""
        return DIRECTIONS[self.direction]


def section_of(given: object) -> PoincareSection:
    """Return a section from its name, or from the keywords of a view of a run.

    Parameters
    ----------
    given
        "stroboscopic", "impacts", ``{"cycle": 0.25}`` as `Trajectory.stroboscopic` takes it, or
        ``{"at": 0.3, "direction": "up"}`` as `Trajectory.section` does.

    Raises
    ------
    ParameterError
        If it is none of these, or a number is out of its range.

    Examples
    --------
    >>> section_of({"at": 0.3, "direction": "up"}).label, section_of("impacts").kind
    ('x = 0.3, up', 'impacts')
    """
    if isinstance(given, PoincareSection):
        return given
    if given == "stroboscopic":
        return PoincareSection("stroboscopic")
    if given == "impacts":
        return PoincareSection("impacts")
    keys = set(given) if isinstance(given, Mapping) else set()
    if isinstance(given, Mapping) and keys == {"cycle"}:
        cycle = real("cycle", given["cycle"])
        if not 0.0 <= cycle < 1.0:
            raise ParameterError("cycle", cycle, "not in [0, 1)")
        return PoincareSection("stroboscopic", cycle=cycle)
    if isinstance(given, Mapping) and "at" in keys and keys <= {"at", "direction"}:
        direction = given.get("direction", "both")
        if direction not in tuple(DIRECTIONS):
            raise ParameterError("direction", direction, f"none of {', '.join(DIRECTIONS)}")
        at = given["at"]
        if isinstance(at, Expression) and at.names:
            reason = "an expression of parameters, which the place of a section does not follow"
            raise ParameterError("at", at, f"{reason}; give a number")
        return PoincareSection("passages", at=real("at", at), direction=direction)
    reason = (
        f"neither {' nor '.join(NAMES)}, nor a cycle such as {{'cycle': 0.25}}, nor a place such as "
        "{'at': 0.3, 'direction': 'up'}"
    )
    raise ParameterError("section", given, reason)
