"""The three kinds of evidence: a measured number, a certified number, a deduction.

They are never mixed: what is measured has an error that is estimated, what is certified a radius
that is proven in ball arithmetic, and what is deduced has steps that were carried out when the
report was made.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias

Agreement = Literal["agrees", "differs", "open"]


@dataclass(frozen=True)
class Measurement:
    """A number that was computed in floating point, and the range in which it should lie.

    Parameters
    ----------
    what
        The quantity, in a few words.
    value
        What was measured.
    low, high
        The range that agrees with the statement; infinite where it has one end only.
    error
        How far the value may be from the true one: a bound on rounding, or a standard error.
    expected
        The number of the statement, where the range is made from one and its digits.
    is_count
        Whether the value is a number of things that were counted. A count has no error: where it
        is uncertain what to count, that is another measurement.

    Examples
    --------
    >>> Measurement("V*(5)", 1.50002, low=1.4995, high=1.5005).outcome
    'agrees'
    >>> Measurement("V*(5)", 1.5003, low=1.4995, high=1.5005, error=1e-3).outcome
    'open'
    """

    what: str
    value: float
    low: float
    high: float
    error: float = 0.0
    expected: float | None = None
    is_count: bool = False

    @property
    def outcome(self) -> Agreement:
        """Whether the value agrees or differs, for all that its error leaves open."""
        return _outcome(self.value, self.error, self.low, self.high)


@dataclass(frozen=True)
class Enclosure:
    """A number enclosed in ball arithmetic, and the range in which it should lie.

    Parameters
    ----------
    what
        The quantity, in a few words.
    value, radius
        Midpoint and radius of the enclosure.
    low, high, expected
        As in `Measurement`.

    Examples
    --------
    >>> Enclosure("pi", 3.14, 0.01, low=3.1, high=3.2).outcome
    'agrees'
    """

    what: str
    value: float
    radius: float
    low: float
    high: float
    expected: float | None = None

    @property
    def outcome(self) -> Agreement:
        """Whether it is proven that the number agrees, or that it differs."""
        return _outcome(self.value, self.radius, self.low, self.high)


@dataclass(frozen=True)
class Step:
    """A step of a deduction, and whether it was found to hold when it was carried out.

    Parameters
    ----------
    text
        The step in words.
    formula
        The same in mathtext, without dollar signs; empty where words are enough.
    holds
        Whether the step came out: what `percuss.paper.proof` computed.
    by
        What carried it out: algebra by SymPy or ball arithmetic; or a theorem that is named, or an
        argument in words, which nothing carries out.
    """

    text: str
    formula: str
    holds: bool
    by: Literal["algebra", "balls", "theorem", "argument"]


@dataclass(frozen=True)
class Deduction:
    """A proof of the statement, or of its contrary, that was carried out step by step.

    Parameters
    ----------
    what
        What is deduced, in a few words.
    steps
        From the first to the last; if one does not come out nothing is deduced.
    concludes
        Whether the conclusion is what the statement says, or contradicts it.

    Examples
    --------
    >>> Deduction("1 + 1 = 2", (Step("add", "1 + 1 = 2", 1 + 1 == 2, "algebra"),)).outcome
    'agrees'
    >>> Deduction("1 + 1 = 2", (Step("add", "1 + 1 = 3", 1 + 1 == 3, "algebra"),)).outcome
    'open'
    """

    what: str
    steps: tuple[Step, ...]
    concludes: Literal["agrees", "differs"] = "agrees"

    @property
    def outcome(self) -> Agreement:
        """What follows, "open" where a step did not come out, or all of them are words."""
        carried_out = any(step.by in ("algebra", "balls") for step in self.steps)
        proven = carried_out and all(step.holds for step in self.steps)
        return self.concludes if proven else "open"


Comparison: TypeAlias = Measurement | Enclosure
Evidence: TypeAlias = Comparison | Deduction


def compare(
    what: str,
    value: float,
    expected: float,
    tolerance: float = 0.0,
    radius: float | None = None,
    *,
    error: float = 0.0,
) -> Comparison:
    """Return the comparison of a number with the one that a statement gives.

    Parameters
    ----------
    what
        The quantity, in a few words.
    value
        What was computed.
    expected
        What the statement says.
    tolerance
        Largest difference that agrees with it: half a unit of the last digit printed, or the
        rounding of the computation.
    radius
        Proven radius of the value; None: it is a float.
    error
        Of a float, as in `Measurement`.

    Returns
    -------
    Measurement or Enclosure
        `Enclosure` where there is a radius.

    Examples
    --------
    >>> compare("a third", 1 / 3, 0.33, 0.005)
    Measurement(what='a third', value=0.333..., low=0.325, high=0.335, error=0.0, expected=0.33, ...)
    """
    low, high = expected - tolerance, expected + tolerance
    if radius is None:
        return Measurement(what, float(value), low, high, error, float(expected))
    return Enclosure(what, float(value), float(radius), low, high, float(expected))


def counted(what: str, found: int, low: int, high: float | None = None) -> Measurement:
    """Return a count, and the numbers that agree with a statement.

    Parameters
    ----------
    what
        What is counted, in a few words.
    found
        How many there are.
    low, high
        The least and the largest number that agrees; without `high` it is `low` alone.

    Examples
    --------
    >>> counted("impacts", 30, 30)
    Measurement(what='impacts', value=30.0, low=30.0, high=30.0, error=0.0, expected=30.0, is_count=True)
    >>> counted("impacts", 30, 31, math.inf).outcome
    'differs'
    """
    only = high is None
    return Measurement(
        what,
        float(found),
        float(low),
        float(low) if high is None else high,
        expected=float(low) if only else None,
        is_count=True,
    )


def is_decided(item: Evidence) -> bool:
    """Return whether it is proven that an item agrees, or that it differs.

    Examples
    --------
    >>> is_decided(compare("pi", 3.14, 3.0, 0.1, radius=0.01))
    True
    """
    return not isinstance(item, Measurement) and item.outcome != "open"


def is_proven(item: Evidence) -> bool:
    """Return whether it is proven that an item agrees.

    Examples
    --------
    >>> is_proven(compare("pi", 3.14, 3.0, 0.1, radius=0.01))
    False
    """
    return is_decided(item) and item.outcome == "agrees"


def _outcome(value: float, error: float, low: float, high: float) -> Agreement:
    if math.isnan(value) or math.isnan(error):
        return "open"
    if low <= value - error and value + error <= high:
        return "agrees"
    return "differs" if value + error < low or value - error > high else "open"
