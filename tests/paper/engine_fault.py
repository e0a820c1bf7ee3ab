"""Examines records of the paper with a fault in the engine: python -m tests.paper.engine_fault FAULT OUT [id ...].

In a process of its own, since other code keeps laws that have no fault. Without ids all records
are examined. OUT receives of each, as JSON, the verdict or what it raised, whether it asked the
engine for a motion, and whether a number is among its evidence.
"""

import json
import math
import sys
from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import TypedDict

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
NONE = "none"


class Examined(TypedDict):
    """What became of a record: its verdict, and what this rests on."""

    verdict: str
    asks_engine: bool
    has_numbers: bool


def _harmonics(table: Floats) -> range:
    return range(at.FIRST_HARMONIC, at.FIRST_HARMONIC + int(table[0, at.N_HARMONICS]))


def _regions(table: Floats) -> range:
    n = int(table[0, at.N_HARMONICS])
    first = at.FIRST_HARMONIC + n
    return range(first, first + int(table[0, at.N_REGIONS]) * (1 + n), 1 + n)


def _forget() -> None:
    """Forget the motions and laws that records keep, so that each asks for its own."""
    for module in _modules():
        for value in vars(module).values():
            if callable(clear := getattr(value, "cache_clear", None)):
                clear()


def _modules() -> list[ModuleType]:
    return [module for name, module in sys.modules.items() if name.startswith("percuss.")]


def main(fault: str, out: str, *ids: str) -> None:
    """Put the fault into every law, examine, write what was found."""
    import percuss.model.law
    from percuss.paper.collection import Item, items, statement_with_id
    from percuss.paper.evidence import Deduction
    from percuss.paper.statement import verdict_kind

    whole = percuss.model.law.law
    asked: list[object] = []

    def faulty(*model: object) -> Floats:
        asked.append(model)
        table = whole(*model).copy()
        if fault != NONE:
            FAULTS[fault](table)
        return table

    def examined(item: Item) -> Examined:
        statement = statement_with_id(item)
        _forget()
        asked.clear()
        try:
            finding = statement.find()
        except Exception as error:  # noqa: BLE001  a record that raises has noticed
            return Examined(
                verdict=f"raises {type(error).__name__}", asks_engine=True, has_numbers=True
            )
        evidence = (*finding.printed, *finding.corrected)
        numbers = [one for one in evidence if not isinstance(one, Deduction)]
        return Examined(
            verdict=verdict_kind(finding), asks_engine=bool(asked), has_numbers=bool(numbers)
        )

    chosen = [one for one in items() if one.kind == "statement" and (not ids or one.name in ids)]
    for item in chosen:
        statement_with_id(item)
    for module in _modules():
        if vars(module).get("law") is whole:
            vars(module)["law"] = faulty
    found = {item.name: examined(item) for item in chosen}
    Path(out).write_text(json.dumps(found, indent=1), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
