"""What came out of a command, as tables."""

from __future__ import annotations

from collections import Counter
from typing import TYPE_CHECKING

from rich.console import Console
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    # A second of import, and each command prints only one of them.
    from percuss.paper.claim import Claim, ClaimKind
    from percuss.paper.run import PaperResult
    from percuss.studies.running import StudyResult
    from percuss.studies.study import Study

__all__ = ["print_report", "print_verdicts"]

COLOURS = {"holds": "green", "corrected": "yellow", "fails": "red", "undecided": "magenta"}
WORDS: dict[ClaimKind, str] = {
    "holds": "holds",
    "corrected": "corrected",
    "fails": "fails",
    "undecided": "undecided",
}
# Columns are as wide as the longest of the usual names.
WIDTH = len("special points") + 2


def print_report(study: Study, result: StudyResult) -> None:
    """Print what was found, how long it took and the files."""
    rows = {
        **result.report,
        "computed": f"in {result.seconds:.3g} s",
        "files": "\n".join(map(str, result.files)) or "none",
    }
    # Text, not markup: a path may hold square brackets. No wrapping: it may be copied.
    console = Console(highlight=False, soft_wrap=True)
    if study.title:
        console.print(Text(study.title, style="bold"))
    width = max(WIDTH, *(len(name) + 2 for name in rows))
    for name, words in rows.items():
        lines = words.replace("\n", f"\n{' ' * width}")
        console.print(Text.assemble((name.ljust(width), "dim"), lines))


def print_verdicts(result: PaperResult) -> None:
    """Print the verdicts, the figures, what is missing, and where the report is."""
    console = Console(highlight=False)
    claims = [
        result.claims[item.name]
        for item in result.items
        if item.kind == "statement" and item.name in result.claims
    ]
    if claims:
        console.print(_table(claims))
        count = Counter(claim.kind for claim in claims)
        words = ", ".join(f"{count[kind]} {word}" for kind, word in WORDS.items())
        noun = "statement" if len(claims) == 1 else "statements"
        console.print(f"{len(claims)} {noun}: {words}")
    if result.figures:
        names = (item.name for item in result.items if item.kind == "figure")
        drawn = ", ".join(name for name in names if name in result.figures)
        noun = "figure" if len(result.figures) == 1 else "figures"
        console.print(f"{len(result.figures)} {noun}: {drawn}", soft_wrap=True)
    for item, reason in result.missing.items():
        console.print(Text.assemble((f"missing {item.name}: ", "red"), reason), soft_wrap=True)
    # Text, not markup, and unbroken: a path may be copied.
    line = f"{result.folder / 'index.html'} and claims.json, in {result.seconds:.0f} s"
    console.print(Text(line), soft_wrap=True)


def _table(claims: list[Claim]) -> Table:
    table = Table(box=None, pad_edge=False, header_style="dim")
    table.add_column("where", no_wrap=True)
    table.add_column("verdict", no_wrap=True)
    table.add_column("by", no_wrap=True)
    table.add_column("claim")
    for claim in claims:
        verdict = Text(WORDS[claim.kind], style=COLOURS[claim.kind])
        table.add_row(Text(claim.reference), verdict, Text(claim.grade), Text(claim.claim))
    return table
