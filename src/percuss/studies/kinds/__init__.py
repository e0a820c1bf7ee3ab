"""The kinds of studies, one module each, named as its class."""

from __future__ import annotations

from importlib import import_module

from percuss.studies.question import Question

__all__ = ["kind_named", "kind_names"]

_KINDS = (
    "motion",
    "orbit",
    "orbits",
    "branch",
    "curve",
    "response",
    "sweep",
    "diagram",
    "basins",
    "lyapunov",
)


def kind_names() -> list[str]:
    """Return the names of the kinds."""
    return list(_KINDS)


def kind_named(name: str) -> type[Question]:
    """Return the questions of a kind by its name."""
    kind: type[Question] = getattr(import_module(f"{__name__}.{name}"), name.capitalize())
    return kind
