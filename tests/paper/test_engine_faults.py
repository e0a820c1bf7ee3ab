"""Records that rest on motions of the engine notice a fault of it; see `engine_fault`."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from tests.paper.engine_fault import FAULTS, NONE
from tests.paper.findings import finding

from percuss.paper.statement import verdict_kind

ROOT = Path(__file__).parents[2]
# Records whose verdict turns round under the fault, one at least of each kind of motion.
SHORT = {"lossy": ("eq27", "eq39"), "shifted": ("eq18",), "late": ("eq33",)}


def examined(
    fault: str, folder: Path, *records: str
) -> dict[str, tuple[str, list[str], list[float]]]:
    out = folder / f"{fault}.json"
    subprocess.run(
        [sys.executable, "-m", "tests.paper.engine_fault", fault, str(out), *records],
        cwd=ROOT, check=True, timeout=600, env={**os.environ, "OPENBLAS_NUM_THREADS": "1"},
    )  # fmt: skip
    return {name: tuple(of) for name, of in json.loads(out.read_text(encoding="utf-8")).items()}


# One by day; what each of the others moves is seen at night, in all records.
@pytest.mark.parametrize(
    "fault",
    [
        pytest.param(fault, marks=() if fault == "lossy" else pytest.mark.nightly)
        for fault in FAULTS
    ],
)
def test_records_notice_a_fault_of_the_engine(fault: str, tmp_path: Path) -> None:
    found = examined(fault, tmp_path, *SHORT[fault])

    own = {name: verdict_kind(finding(name)) for name in SHORT[fault]}
    assert found.keys() == own.keys() == set(SHORT[fault])
    assert [name for name in own if found[name][0] == own[name]] == []


@pytest.mark.nightly
def test_each_record_whose_numbers_a_fault_moves_notices_one(tmp_path: Path) -> None:
    own = examined(NONE, tmp_path)
    found = [examined(fault, tmp_path) for fault in FAULTS]

    # What no fault moves is algebra, or proven without the engine.
    moved = {name for name in own if any(of[name][2] != own[name][2] for of in found)}
    noticed = {name for name in own if any(of[name][:2] != own[name][:2] for of in found)}
    assert moved >= {name for names in SHORT.values() for name in names}
    assert moved - noticed == set()
