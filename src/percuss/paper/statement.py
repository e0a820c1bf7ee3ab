"""A statement of the paper, and the verdict that its evidence leads to."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

__all__ = ["Check", "Finding", "Grade", "Statement", "grade", "judge"]

Grade = Literal["certified", "derived", "numerical"]


@dataclass(frozen=True)
class Check:
    """One comparison: what was measured, what was expected, and how far they may be apart.

    Parameters
    ----------
    what
        What is compared, in a few words.
    measured, expected
        The two numbers; a condition is measured 1 where it holds, else 0, and expected 1.
    tolerance
        Largest absolute difference that counts as agreement, from the digits printed or from the
        rounding of the computation.
    radius
        How far the measured number can be from the true one, proven in ball arithmetic; 0 for a
        condition that is proven to hold, or not to. None: a float, its error is not bounded.

    Examples
    --------
    >>> Check("V*(5)", measured=1.50002, expected=1.5, tolerance=0.0005).passed
    True
    >>> Check("pi", measured=3.14, expected=3.0, tolerance=0.1, radius=0.01).is_certain
    True
    """

    what: str
    measured: float
    expected: float
    tolerance: float = 0.0
    radius: float | None = None

    @property
    def difference(self) -> float:
        """Measured minus expected."""
        return self.measured - self.expected

    @property
    def passed(self) -> bool:
        """Whether both agree, for all that the radius leaves open; a NaN never does."""
        return abs(self.difference) + (self.radius or 0.0) <= self.tolerance

    @property
    def is_certain(self) -> bool:
        """Whether it is proven that they agree, or that they do not."""
        if self.radius is None:
            return False
        return self.passed or abs(self.difference) - self.radius > self.tolerance


@dataclass(frozen=True)
class Finding:
    """What was found out about a statement.

    Parameters
    ----------
    printed
        Checks of the statement as the paper prints it.
    corrected
        Checks of a corrected form, where the printed one fails.
    correction
        The corrected form in words and symbols, completing "holds with the correction ...".
    undecided
        Why nothing can be said, where this is so; empty otherwise.
    remark
        What else the reader should know.
    """

    printed: tuple[Check, ...]
    corrected: tuple[Check, ...] = ()
    correction: str = ""
    undecided: str = ""
    remark: str = ""


@dataclass(frozen=True)
class Statement:
    """A formula, number or sentence of the paper, and how to find out whether it is right.

    Parameters
    ----------
    id
        Short name, unique: "eq12", "table1-m5", "chaos-fig6b".
    reference
        Where the paper has it: "(12)", "table 1", "fig 14", "section 5".
    claim
        What it says, in words.
    formula
        The same in matplotlib's mathtext, without dollar signs; empty where words are enough.
    method
        How it is examined.
    certainty
        Of the verdict: "symbolic", "closed form, 12 digits", "simulation, 1e-9", "statistical".
    find
        Computes the evidence.
    theory
        File of docs/theory with the derivation; empty where there is none.
    proven
        Whether the derivation proves the verdict for all cases, not only for those computed.
    general
        Whether it speaks of more than the cases that are computed, and no derivation proves it:
        then these may be certain and the statement is not, unless one of them refutes it.
    """

    id: str
    reference: str
    claim: str
    method: str
    certainty: str
    find: Callable[[], Finding]
    formula: str = ""
    theory: str = ""
    proven: bool = False
    general: bool = False


def judge(finding: Finding) -> str:
    """Return the verdict that follows from the checks, and from nothing else.

    Parameters
    ----------
    finding
        The evidence.

    Returns
    -------
    str
        "holds", "holds with the correction ...", "fails", or "undecided because ...".

    Examples
    --------
    >>> judge(Finding(printed=(Check("sum", 2.0, 2.0),)))
    'holds'
    >>> judge(Finding((Check("sum", 2.5, 2.0),), (Check("sum", 2.5, 2.5),), "5/2 for 2"))
    'holds with the correction 5/2 for 2'
    >>> judge(Finding(printed=(Check("sum", 2.5, 2.0),)))
    'fails'
    """
    if finding.undecided:
        return f"undecided because {finding.undecided}"
    every = (*finding.printed, *finding.corrected)
    if not every or any(math.isnan(check.measured) for check in every):
        return "undecided because no number came out of the computation"
    if _all_pass(finding.printed):
        return "holds"
    if finding.corrected and _all_pass(finding.corrected):
        return f"holds with the correction {finding.correction}"
    return "fails"


def grade(finding: Finding, *, proven: bool = False, general: bool = False) -> Grade:
    """Return what the verdict rests on.

    Parameters
    ----------
    finding
        The evidence.
    proven, general
        Of the statement.

    Returns
    -------
    str
        "derived" if it is proven; "certified" where every comparison that the verdict needs is
        certain in ball arithmetic; "numerical" otherwise. Of a form that fails one certain
        disagreement is enough; a general form that holds is not certain by its cases.

    Examples
    --------
    >>> certain = Check("pi", 3.1415926, 3.0, tolerance=0.1, radius=1e-6)
    >>> grade(Finding((certain, Check("sum", 2.0, 2.0))))
    'certified'
    >>> grade(Finding((Check("sum", 2.0, 2.0),)))
    'numerical'
    """
    if judge(finding).startswith("undecided"):
        return "numerical"
    if proven:
        return "derived"
    if general and judge(finding) != "fails":
        return "numerical"
    if _all_pass(finding.printed):
        needed = _all_certain(finding.printed)
    else:
        needed = any(check.is_certain and not check.passed for check in finding.printed)
        if finding.corrected and _all_pass(finding.corrected):
            needed = needed and _all_certain(finding.corrected)
    return "certified" if needed else "numerical"


def _all_certain(checks: Sequence[Check]) -> bool:
    return all(check.is_certain for check in checks)


def _all_pass(checks: Sequence[Check]) -> bool:
    return all(check.passed for check in checks)
