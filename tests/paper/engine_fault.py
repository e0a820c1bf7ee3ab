"""Examines records of the paper with a fault in the engine: python -m tests.paper.engine_fault FAULT OUT [id ...].

In a process of its own, since records keep their motions from one to the next. Without ids all
records are examined. OUT receives the verdict of each as JSON, or what it raised.
"""

import json
import math
import sys
from collections.abc import Callable
from pathlib import Path

from percuss.arrays import Floats
from percuss.kernels import law_columns as at

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


def _harmonics(table: Floats) -> range:
    return range(at.FIRST_HARMONIC, at.FIRST_HARMONIC + int(table[0, at.N_HARMONICS]))


def _regions(table: Floats) -> range:
    n = int(table[0, at.N_HARMONICS])
    first = at.FIRST_HARMONIC + n
    return range(first, first + int(table[0, at.N_REGIONS]) * (1 + n), 1 + n)


def main(fault: str, out: str, *ids: str) -> None:
    """Put the fault into every law, examine, write the verdicts."""
    import percuss.model.system

    whole = percuss.model.system.law

    def faulty(*model: object) -> Floats:
        table = whole(*model).copy()
        FAULTS[fault](table)
        return table

    vars(percuss.model.system)["law"] = vars(percuss.model.system)["law"] = faulty

    from percuss.paper.claim import examine
    from percuss.paper.collection import items, statement_with_id

    found: dict[str, str] = {}
    for item in items():
        if item.kind == "statement" and (not ids or item.name in ids):
            try:
                found[item.name] = examine(statement_with_id(item)).kind
            except Exception as error:  # noqa: BLE001  a record that raises has noticed
                found[item.name] = f"raises {type(error).__name__}"
    Path(out).write_text(json.dumps(found, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
