"""The verdicts and measured values of `percuss paper`."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

from percuss.paper.run import run_paper

# What one run does not share with another, and what stands in the sources word for word.
OWN = ("seconds", "command", "date", "versions", "machine", "milliseconds", "quotations", "code")


def frozen() -> dict[str, Any]:
    """Return what claims.json says, without times."""
    with tempfile.TemporaryDirectory() as folder:
        run_paper(folder, force=True, processes=1)
        written = json.loads((Path(folder) / "claims.json").read_text(encoding="utf-8"))
    return {row["id"]: _without_times(row) for row in written["records"]}


def _without_times(value: Any) -> Any:
    if isinstance(value, dict):
        return {name: _without_times(inner) for name, inner in value.items() if name not in OWN}
    if isinstance(value, list):
        return [_without_times(inner) for inner in value]
    return value
