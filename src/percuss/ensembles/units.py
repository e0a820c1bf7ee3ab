"""Dimensions of parameters by the last word of their paths, as datasets say them."""

from __future__ import annotations

__all__ = ["units_of"]

_UNITS = {
    "stiffness": "1/time^2",
    "damping": "1/time",
    "at": "length",
    "restitution": "1",
    "amplitude": "length/time^2",
    "omega": "1/time",
    "phase": "rad",
    "constant": "length/time^2",
    "period": "time",
    "cos": "length/time^2",
    "sin": "length/time^2",
    "x0": "length",
    "v0": "length/time",
    "t0": "time",
}


def units_of(path: str) -> str:
    """Return the dimensions of a parameter.

    Parameters
    ----------
    path
        Its dotted path.

    Returns
    -------
    str
        In length, time and radians.

    Examples
    --------
    >>> units_of("oscillator.stops.0.at"), units_of("forcing.cos.0")
    ('length', 'length/time^2')
    """
    words = [word for word in path.split(".") if not word.isdigit()]
    return _UNITS[words[-1]]
