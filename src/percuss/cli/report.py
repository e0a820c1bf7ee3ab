"""What came out of a study, as a short table."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from percuss.studies.running import StudyResult
from percuss.studies.study import Study

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
