"""Examines records of the paper with a fault in the engine: python -m tests.paper.engine_fault FAULT OUT [id ...].

In a process of its own, since records keep their motions from one to the next. Without ids all
records are examined. OUT receives of each, as JSON, the verdict and the evidence.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from percuss.arrays import Floats
from percuss.kernels import law_columns as at

if TYPE_CHECKING:
    from percuss.paper.collection import Item

# Far above every tolerance of a record, and far below what takes a steady motion elsewhere.
LOSS, SHIFT, STIFFER = 1e-3, 1e-3, 1e-4


def lossy(table: Floats) -> None:
    """Let each wall take a thousandth of the speed."""
    for row in _regions(table):
        table[row, [at.LOWER_RESTITUTION, at.UPPER_RESTITUTION]] *= 1.0 - LOSS


def shifted(table: Floats) -> None:
    """Let the force come a thousandth of a radian early."""
    c, s = math.cos(SHIFT), math.sin(SHIFT)
    for row in _harmonics(table):
        cosine, sine = table[row, [at.COSINE, at.SINE]]
        table[row, [at.COSINE, at.SINE]] = c * cosine + s * sine, c * sine - s * cosine


def late(table: Floats) -> None:
    """Let each flight end late: what turns the free motion is a ten-thousandth slower."""
    for row in _regions(table):
        table[row, [at.RATE, at.HALF_TURNS, at.HALF_TURNS_LOW]] *= 1.0 - STIFFER
        table[row, at.TWICE_PER_RATE] /= 1.0 - STIFFER


FAULTS: dict[str, Callable[[Floats], None]] = {"lossy": lossy, "shifted": shifted, "late": late}
NONE = "none"
# Verdict, outcomes and numbers of a record.
Examined: TypeAlias = tuple[str, list[str], list[float]]


def _harmonics(table: Floats) -> range:
    return range(at.FIRST_HARMONIC, at.FIRST_HARMONIC + int(table[0, at.N_HARMONICS]))


def _regions(table: Floats) -> range:
    n = int(table[0, at.N_HARMONICS])
    first = at.FIRST_HARMONIC + n
    return range(first, first + int(table[0, at.N_REGIONS]) * (1 + n), 1 + n)


def _examined(item: Item) -> Examined:
    from percuss.paper.collection import statement_with_id
    from percuss.paper.evidence import Deduction
    from percuss.paper.statement import verdict_kind

    try:
        finding = statement_with_id(item).find()
    except Exception as error:  # noqa: BLE001  a record that raises has noticed
        return f"raises {type(error).__name__}", [], []
    evidence = (*finding.printed, *finding.corrected)
    numbers = [one.value for one in evidence if not isinstance(one, Deduction)]
    return verdict_kind(finding), [one.outcome for one in evidence], numbers


def main(fault: str, out: str, *ids: str) -> None:
    """Put the fault into every law, examine, write what was found."""
    import percuss.model.system
    from percuss.paper.collection import items, statement_with_id

    whole = percuss.model.system.law

    def faulty(*model: object) -> Floats:
        table = whole(*model).copy()
        FAULTS[fault](table)
        return table

    chosen = [one for one in items() if one.kind == "statement" and (not ids or one.name in ids)]
    for item in chosen:
        statement_with_id(item)
    for name, module in list(sys.modules.items()):
        if fault != NONE and name.startswith("percuss.") and vars(module).get("law") is whole:
            vars(module)["law"] = faulty
    found = {item.name: _examined(item) for item in chosen}
    Path(out).write_text(json.dumps(found, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
