"""What the page has to know before it asks anything."""

from __future__ import annotations

import json
import re
from pathlib import Path

from percuss.version import __version__
from percuss.web.presets import FIGURES, presets
from percuss.web.proof import can_certify

__all__ = ["claims_of", "facts_of_page", "scripts_of"]

# Of a statement of the report: what the page shows of it.
CLAIM = ("id", "reference", "claim", "verdict", "grade")


def facts_of_page(report: Path | None = None) -> dict[str, object]:
    """Return what the page begins with.

    Parameters
    ----------
    report
        Folder of a report of `percuss paper`, or None.

    Returns
    -------
    dict
        The version, the presets, whether there is a report, its figures by their presets and its
        statements with their verdicts, and whether runs can be certified here.

    Examples
    --------
    >>> facts_of_page()["presets"][0]["name"]
    'first_impacts'
    """
    rows = [
        {"name": it.name, "title": it.title, "caption": it.caption, "study": it.tables}
        for it in presets()
    ]
    return {
        "version": __version__,
        "presets": rows,
        "report": report is not None,
        "figures": FIGURES,
        "claims": [] if report is None else claims_of(report),
        "certified": can_certify(),
    }


def claims_of(report: Path) -> list[dict[str, str]]:
    """Return the statements of a report with their verdicts; none where they cannot be read."""
    try:
        rows = json.loads((report / "claims.json").read_text("utf-8"))
        return [{name: str(row[name]) for name in CLAIM} for row in rows]
    except (OSError, ValueError, TypeError, KeyError):
        return []


def scripts_of(report: Path) -> list[str]:
    """Return the scripts that stand in a report."""
    file = report / "index.html"
    return re.findall("<script>(.*?)</script>", file.read_text("utf-8"), re.DOTALL)
