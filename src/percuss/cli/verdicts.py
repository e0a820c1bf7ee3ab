"""What came out of `percuss paper`, as a table."""

from __future__ import annotations

from collections import Counter

from rich.console import Console
from rich.table import Table
from rich.text import Text

from percuss.paper.claim import Claim, Kind
from percuss.paper.run import PaperResult

__all__ = ["print_verdicts"]

COLOURS = {"holds": "green", "corrected": "yellow", "fails": "red", "undecided": "magenta"}
WORDS: dict[Kind, str] = {
    "holds": "holds",
    "corrected": "corrected",
    "fails": "fails",
    "undecided": "undecided",
}


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
