"""Errors and warnings of percuss, in one place; every layer imports it.

Every message is a sentence with the numbers in it: what was given, what is wrong, what to do.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib.util import find_spec

from percuss.wording import shown

__all__ = [
    "ConvergenceError",
    "FormalOrbitWarning",
    "LimitWarning",
    "MissingExtraError",
    "OutputError",
    "ParameterError",
    "PercussError",
    "StudyError",
    "check_installed",
]


def __dir__() -> list[str]:
    return __all__


class PercussError(Exception):
    """Base of everything percuss raises on purpose."""


class ParameterError(PercussError, ValueError):
    """A parameter has a value that the model or a call cannot take.

    Parameters
    ----------
    name
        Name of the parameter, a dotted path where it belongs to a larger value.
    value
        What was given.
    reason
        What is wrong with it, and what would be right.

    Examples
    --------
    >>> print(ParameterError("restitution", -0.1, "outside [0, 1]"))
    restitution = -0.1: outside [0, 1]
    """

    def __init__(self, name: str, value: object, reason: str) -> None:
        # All three go to args, or the exception cannot travel back from a worker process.
        super().__init__(name, value, reason)
        self.name = name
        self.value = value
        self.reason = reason

    def __str__(self) -> str:
        return f"{self.name} = {shown(self.value)}: {self.reason}"


class ConvergenceError(PercussError, RuntimeError):
    """An iteration found no solution.

    Parameters
    ----------
    what
        What was looked for.
    last
        The last iterate, None where there was none.
    residual
        By how much it misses; NaN where there was no iterate.
    advice
        What to try.

    Examples
    --------
    >>> print(ConvergenceError("no (1, 1) orbit found", (0.2, 1.0), 0.013, "try another guess"))
    no (1, 1) orbit found; the last iterate misses by 0.013: try another guess
    """

    def __init__(self, what: str, last: object, residual: float, advice: str) -> None:
        super().__init__(what, last, residual, advice)
        self.what = what
        self.last = last
        self.residual = residual
        self.advice = advice

    def __str__(self) -> str:
        missed = "" if self.last is None else f"; the last iterate misses by {self.residual:.3g}"
        return f"{self.what}{missed}: {self.advice}"


class FormalOrbitWarning(UserWarning):
    """An orbit that was found passes through a stop: it solves the equations, no motion does."""


class LimitWarning(UserWarning):
    """A computation ended at a limit that nobody asked for; its result is true, but shorter.

    The message names the limit, how far the computation came, and the keyword that moves it.
    """


class StudyError(PercussError, ValueError):
    """A study has faults; all of them are listed, one a line.

    Parameters
    ----------
    faults
        The faults found; the text of each is one line of the message.

    Examples
    --------
    >>> print(StudyError(["run.t_end = -1: not after t0 = 0", "unknown key 'strat'"]))
    run.t_end = -1: not after t0 = 0
    unknown key 'strat'
    """

    def __init__(self, faults: Iterable[object]) -> None:
        self.faults = tuple(faults)
        super().__init__(self.faults)

    def __str__(self) -> str:
        return "\n".join(str(fault) for fault in self.faults)


class OutputError(PercussError):
    """A result cannot be written where it was asked for.

    Parameters
    ----------
    path
        The file or folder.
    reason
        Why not, and what to do.

    Examples
    --------
    >>> print(OutputError("out", "holds files already; --force replaces them"))
    out: holds files already; --force replaces them
    """

    def __init__(self, path: object, reason: str) -> None:
        super().__init__(path, reason)
        self.path = path
        self.reason = reason

    def __str__(self) -> str:
        return f"{self.path}: {self.reason}"


class MissingExtraError(PercussError, ImportError):
    """An optional dependency is not installed.

    Parameters
    ----------
    what
        What needs it, and what is missing.
    extra
        The extra of percuss that installs it.

    Examples
    --------
    >>> print(MissingExtraError("certified mode needs python-flint", "certified"))
    certified mode needs python-flint: install percuss[certified]
    """

    def __init__(self, what: str, extra: str) -> None:
        super().__init__(what, extra)
        self.what = what
        self.extra = extra

    def __str__(self) -> str:
        return f"{self.what}: install percuss[{self.extra}]"


def check_installed(what: str, extra: str, *modules: str) -> None:
    """Raise a `MissingExtraError` unless optional modules are installed.

    Parameters
    ----------
    what
        What needs them.
    extra
        The extra of percuss that installs them.
    *modules
        Their names.

    Raises
    ------
    MissingExtraError
        If one is missing, with the names of all that are.

    Examples
    --------
    >>> check_installed("a store", "stores", "json", "no_such_module")
    Traceback (most recent call last):
    percuss.errors.MissingExtraError: a store needs no_such_module: install percuss[stores]
    """
    missing = [name for name in modules if find_spec(name) is None]
    if missing:
        raise MissingExtraError(f"{what} needs {' and '.join(missing)}", extra)
