"""Records that rest on measured motions notice a fault of the engine; see `engine_fault`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from tests.paper.engine_fault import FAULTS

from percuss.paper.collection import items, statement_with_id
from percuss.paper.statement import verdict_kind

ROOT = Path(__file__).parents[2]
# Records whose verdict turns round under the fault, one at least of each kind of motion.
SHORT = {"lossy": ("eq27", "eq39"), "shifted": ("eq18",), "late": ("eq33",)}


def verdicts(fault: str, folder: Path, *records: str) -> dict[str, str]:
    out = folder / "verdicts.json"
    subprocess.run(
        [sys.executable, "-m", "tests.paper.engine_fault", fault, str(out), *records],
        cwd=ROOT, check=True, timeout=600, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    found: dict[str, str] = json.loads(out.read_text(encoding="utf-8"))
    return found


@pytest.mark.parametrize("fault", list(FAULTS))
def test_records_notice_a_fault_of_the_engine(fault: str, tmp_path: Path) -> None:
    records = {item.name: item for item in items() if item.name in SHORT[fault]}

    found = verdicts(fault, tmp_path, *records)

    own = {name: verdict_kind(statement_with_id(item).find()) for name, item in records.items()}
    assert found.keys() == own.keys() == set(SHORT[fault])
    assert [name for name in own if found[name] == own[name]] == []
