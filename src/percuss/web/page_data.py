"""The data of the page when it opens: presets, and the figures and claims of a report."""

from __future__ import annotations

import json
import re
from pathlib import Path

from percuss.version import __version__
from percuss.web.design_view import outcomes_of_page
from percuss.web.presets import FIGURES, presets
from percuss.web.proof import can_certify
from percuss.web.structure_view import mechanism_rows

# Columns of the claims of a report that the page shows.
CLAIM = ("id", "reference", "claim", "verdict", "grade")


def page_data(report: Path | None = None) -> dict[str, object]:
    """Return what the page is given when it opens.

    Parameters
    ----------
    report
        Folder of a report of `percuss paper`, or None.

    Returns
    -------
    dict
        The version, the presets, the mechanisms of several masses, the outcomes of designs, whether
        there is a report, its figures by their presets and its claims with their verdicts, and
        whether runs can be certified here.

    Examples
    --------
    >>> page_data()["presets"][0]["name"]
    'first_impacts'
    """
    rows = [
        {"name": row.name, "title": row.title, "caption": row.caption, "study": row.tables}
        for row in presets()
    ]
    return {
        "version": __version__,
        "presets": rows,
        "mechanisms": mechanism_rows(),
        "outcomes": outcomes_of_page(),
        "report": report is not None,
        "figures": FIGURES,
        "claims": [] if report is None else claims_of(report),
        "certified": can_certify(),
    }


def claims_of(report: Path) -> list[dict[str, str]]:
    """Return the claims of a report with their verdicts; none where they cannot be read."""
    try:
        rows = json.loads((report / "claims.json").read_text("utf-8"))["records"]
        return [{name: str(row[name]) for name in CLAIM} for row in rows]
    except (OSError, ValueError, TypeError, KeyError):
        return []


def scripts_of(report: Path) -> list[str]:
    """Return the texts of the scripts in a report."""
    file = report / "index.html"
    return re.findall("<script>(.*?)</script>", file.read_text("utf-8"), re.DOTALL)
