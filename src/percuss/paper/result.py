"""The result of a run of `percuss paper`."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from percuss.paper.claim import Claim
from percuss.paper.collection import Item
from percuss.paper.figure_files import Drawn

INTERRUPTED = "not begun when the run was interrupted"


@dataclass(frozen=True)
class PaperResult:
    """What came out of a run.

    Parameters
    ----------
    folder
        Where the files are.
    items
        What was asked for, in the order of the report.
    claims, figures
        What was done, by name.
    missing
        Why the others are not there.
    command
        The command.
    seconds
        How long it took [s].
    """

    folder: Path
    items: tuple[Item, ...]
    claims: dict[str, Claim]
    figures: dict[str, Drawn]
    missing: dict[Item, str]
    command: str
    seconds: float

    @property
    def is_interrupted(self) -> bool:
        """Whether the run was stopped before its end."""
        return INTERRUPTED in self.missing.values()
