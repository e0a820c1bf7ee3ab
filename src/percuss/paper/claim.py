"""A statement after its examination, as a record that goes into claims.json."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from percuss.paper.statement import Check, Finding, Grade, Statement, grade, judge

__all__ = ["Claim", "ClaimKind", "examine"]

ClaimKind = Literal["holds", "corrected", "fails", "undecided"]

# In place of what the statement says of floats.
IN_BALLS = "ball arithmetic, each number with an error that is proven"


@dataclass(frozen=True)
class Claim:
    """A statement with its evidence and the verdict that follows.

    Parameters
    ----------
    id, reference, claim, formula, method, certainty, theory
        Of the statement.
    finding
        The evidence.
    verdict
        What `percuss.paper.statement.judge` says of it.
    grade
        What the verdict rests on: "certified" in ball arithmetic, "derived", or "numerical".
    """

    id: str
    reference: str
    claim: str
    formula: str
    method: str
    certainty: str
    theory: str
    finding: Finding
    verdict: str
    grade: Grade

    @property
    def kind(self) -> ClaimKind:
        """The verdict in a word."""
        if self.verdict.startswith("holds with"):
            return "corrected"
        return "undecided" if self.verdict.startswith("undecided") else self._plain

    @property
    def _plain(self) -> ClaimKind:
        return "holds" if self.verdict == "holds" else "fails"

    def record(self) -> dict[str, object]:
        """Return what claims.json holds; a number that is not finite becomes null."""
        return {
            "id": self.id,
            "reference": self.reference,
            "claim": self.claim,
            "formula": self.formula,
            "method": self.method,
            "evidence": {
                "printed": [_numbers(check) for check in self.finding.printed],
                "corrected": [_numbers(check) for check in self.finding.corrected],
            },
            "verdict": self.verdict,
            "grade": self.grade,
            "certainty": self.certainty,
            "remark": self.finding.remark,
            "theory": self.theory,
        }


def _numbers(check: Check) -> dict[str, object]:
    numbers = {
        name: float(getattr(check, name))
        for name in ("measured", "expected", "difference", "tolerance")
    }
    finite = {name: value if math.isfinite(value) else None for name, value in numbers.items()}
    radius = {} if check.radius is None else {"radius": float(check.radius)}
    return {"what": check.what, **finite, **radius, "passed": bool(check.passed)}


def examine(statement: Statement) -> Claim:
    """Compute the evidence of a statement, and judge it.

    Parameters
    ----------
    statement
        The statement.

    Returns
    -------
    Claim
        With its verdict.

    Examples
    --------
    >>> sum_of_two = lambda: Finding(printed=(Check("1 + 1", 1.0 + 1.0, 2.0),))
    >>> examine(Statement("sum", "(0)", "1 + 1 is 2", "addition", "exact", sum_of_two)).kind
    'holds'
    """
    finding = statement.find()
    rests_on = grade(finding, proven=statement.proven, general=statement.general)
    return Claim(
        id=statement.id,
        reference=statement.reference,
        claim=statement.claim,
        formula=statement.formula,
        method=statement.method,
        certainty=IN_BALLS if rests_on == "certified" else statement.certainty,
        theory=statement.theory,
        finding=finding,
        verdict=judge(finding),
        grade=rests_on,
    )
