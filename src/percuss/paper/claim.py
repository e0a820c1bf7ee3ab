"""A statement after its examination, as a record that goes into claims.json."""

from __future__ import annotations

import math
import textwrap
from dataclasses import dataclass

from percuss.paper.article import passages_of
from percuss.paper.code import Code, code_of
from percuss.paper.evidence import Deduction, Enclosure, Evidence
from percuss.paper.formula import Formula
from percuss.paper.statement import (
    Finding,
    Grade,
    Scope,
    Statement,
    VerdictKind,
    grade,
    judge,
    verdict_kind,
)


@dataclass(frozen=True)
class Claim:
    """A statement with its evidence and the verdict that follows.

    Parameters
    ----------
    id, reference, claim, method, theory, scope
        Of the statement.
    formula, right_formula
        Its formula and, where that is corrected, the right one, in mathtext; empty without one.
    is_printed
        Whether the formula is one that the article prints; else it puts words into symbols.
    finding
        The evidence.
    kind, verdict
        What `percuss.paper.statement.judge` says of it, in a word and in a sentence.
    grade
        What the verdict rests on: "deduced", "certified" in ball arithmetic, or "measured".
    code
        The function that computed the evidence.
    """

    id: str
    reference: str
    claim: str
    method: str
    theory: str
    scope: Scope
    formula: str
    right_formula: str
    is_printed: bool
    finding: Finding
    kind: VerdictKind
    verdict: str
    grade: Grade
    code: Code

    @property
    def study_file(self) -> str:
        """The file with its study, beside the pages of the report; empty where it has none."""
        return f"studies/{self.id}.toml" if self.finding.study else ""

    def study_text(self) -> str:
        """Return what stands in that file: the study, below what it shows."""
        title = f"Dyskin, Pasternak & Pelinovsky (2012), {self.reference}: {self.claim}"
        heading = title if self.scope == "article" else self.claim
        lines = textwrap.wrap(heading, 98, initial_indent="# ", subsequent_indent="# ")
        return "\n".join((*lines, "", self.finding.study))

    def record(self) -> dict[str, object]:
        """Return what claims.json holds; a number that is not finite becomes null."""
        return {
            "id": self.id,
            "scope": self.scope,
            "kind": self.kind,
            "verdict": self.verdict,
            "grade": self.grade,
            "reference": self.reference,
            "claim": self.claim,
            "quotations": _quotations(self.id),
            "formula": self.formula,
            "is_printed": self.is_printed,
            "right_formula": self.right_formula,
            "method": self.method,
            "evidence": {
                "printed": [_item(item) for item in self.finding.printed],
                "corrected": [_item(item) for item in self.finding.corrected],
            },
            "instead": self.finding.instead,
            "remark": self.finding.remark,
            "theory": self.theory,
            "study": self.study_file,
            "code": self.code.name,
        }


def _quotations(id: str) -> list[dict[str, object]]:
    return [
        {
            "passage": passage.id,
            "section": passage.section,
            "page": passage.page,
            "at": passage.at,
            "text": passage.quote,
            "reading": passage.reading,
        }
        for passage in passages_of(id)
    ]


def _item(item: Evidence) -> dict[str, object]:
    said: dict[str, object] = {"what": item.what, "outcome": item.outcome}
    if isinstance(item, Deduction):
        steps = [
            {"text": step.text, "formula": step.formula, "holds": step.holds, "by": step.by}
            for step in item.steps
        ]
        return {"kind": "deduced", **said, "concludes": item.concludes, "steps": steps}
    numbers = {name: getattr(item, name) for name in ("value", "low", "high", "expected")}
    if isinstance(item, Enclosure):
        return {"kind": "certified", **said, **_finite({**numbers, "radius": item.radius})}
    error = {"error": item.error}
    return {"kind": "measured", **said, **_finite({**numbers, **error}), "count": item.is_count}


def _finite(numbers: dict[str, float | None]) -> dict[str, object]:
    return {
        name: float(value) if value is not None and math.isfinite(value) else None
        for name, value in numbers.items()
    }


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
    >>> from percuss.paper.evidence import compare
    >>> sum_of_two = lambda: Finding(printed=(compare("1 + 1", 1.0 + 1.0, 2.0),))
    >>> examine(Statement("sum", "(0)", "1 + 1 is 2", "addition", sum_of_two)).kind
    'holds'
    """
    finding = statement.find()
    formula, right = statement.formula, ""
    if isinstance(formula, Formula):
        right = formula.tex(right=True) if formula.right is not None else ""
        formula = formula.tex()
    return Claim(
        id=statement.id,
        reference=statement.reference,
        claim=statement.claim,
        method=statement.method,
        theory=statement.theory,
        scope=statement.scope,
        formula=formula,
        right_formula=right,
        is_printed=statement.is_printed,
        finding=finding,
        kind=verdict_kind(finding),
        verdict=judge(finding),
        grade=grade(finding),
        code=code_of(statement.find),
    )
