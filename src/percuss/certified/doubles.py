"""Which numbers were taken as doubles that are not the decimals that they print as."""

from __future__ import annotations

from fractions import Fraction

from percuss.model.forcing import Forcing
from percuss.model.harmonics import FourierTerm
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.model.stops import Wall

__all__ = ["doubles_of", "in_words"]


def doubles_of(
    osc: Oscillator, force: Forcing | None, start: Start | None = None
) -> tuple[str, ...]:
    """Return the paths of such numbers.

    Examples
    --------
    >>> import percuss as pc
    >>> doubles_of(pc.impact_oscillator(0.8, damping=0.5), pc.cosine("2.8"))
    ('oscillator.stops.0.restitution',)
    """
    values: dict[str, object] = {
        "oscillator.stiffness": osc.stiffness,
        "oscillator.damping": osc.damping,
    }
    for i, stop in enumerate(osc.stops):
        names = ("at", "restitution") if isinstance(stop, Wall) else ("at", "stiffness", "damping")
        values |= {f"oscillator.stops.{i}.{name}": getattr(stop, name) for name in names}
    if force is not None:
        values["forcing.constant"] = force.constant
        if force.base is not None:
            values["forcing.omega"] = force.base
        for i, part in enumerate(force.harmonics):
            if isinstance(part, FourierTerm):
                values |= {f"forcing.{name}.{i}": getattr(part, name) for name in ("cos", "sin")}
                continue
            for name in ("omega", "amplitude", "phase"):
                values[f"forcing.harmonics.{i}.{name}"] = getattr(part, name)
    if start is not None:
        values |= {f"start.{name}": getattr(start, name) for name in ("x0", "v0", "t0")}
    return tuple(path for path, value in values.items() if _is_other(value))


def _is_other(value: object) -> bool:
    return isinstance(value, float) and Fraction(repr(value)) != Fraction(value)


def in_words(doubles: tuple[str, ...]) -> str:
    """Return the end of a line that says so; empty without any."""
    return f"; taken as doubles: {', '.join(doubles)}" if doubles else ""
