"""Compare results with those that are kept: python -m tests.frozen [part ...] [--write].

Parts: motions (digests of events and grids), branches (numbers, to 1e-12), sentences (studies and
faults), claims (of `percuss paper`), ratios (of times).
"""

from __future__ import annotations

import argparse
import importlib
import json
import math
import sys
import time
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path
from typing import Any

VALUES = Path(__file__).parent / "values"
# Where each part is computed, and by how much its numbers may differ. Times are the machine's, and
# so are told only.
PARTS = {
    "claims": ("tests.frozen.claims", 0.0),
    "branches": ("tests.frozen.branches", 1e-12),
    "motions": ("tests.frozen.motions", 0.0),
    "sentences": ("tests.frozen.sentences", 0.0),
    "ratios": ("benchmarks.ratios", 0.05),
}


def differences(kept: Any, now: Any, tolerance: float, path: str = "") -> Iterator[str]:
    """Yield where two values differ; numbers may by the tolerance, relative and absolute."""
    if isinstance(kept, dict) and isinstance(now, dict):
        for name in {**kept, **now}:
            where = f"{path}[{name}]"
            if name not in kept or name not in now:
                yield f"{where}: {'new' if name not in kept else 'gone'}"
            else:
                yield from differences(kept[name], now[name], tolerance, where)
    elif isinstance(kept, list) and isinstance(now, list):
        if len(kept) != len(now):
            yield f"{path}: {len(kept)} values, now {len(now)}"
        for k, pair in enumerate(zip(kept, now, strict=False)):
            yield from differences(*pair, tolerance, f"{path}[{k}]")
    elif isinstance(kept, float) and isinstance(now, float):
        if not (kept == now or math.isclose(kept, now, rel_tol=tolerance, abs_tol=tolerance)
                or (math.isnan(kept) and math.isnan(now))):  # fmt: skip
            yield f"{path}: {kept!r}, now {now!r}"
    elif kept != now:
        yield f"{path}: {str(kept)[:200]!r}, now {str(now)[:200]!r}"


def computed(part: str) -> tuple[Any, float]:
    """Return what a part gives, as JSON holds it, and how long it took [s]."""
    began = time.perf_counter()
    found = importlib.import_module(PARTS[part][0]).frozen()
    return json.loads(json.dumps(found)), time.perf_counter() - began


def main() -> int:
    """Compute the parts, two at a time; return 1 if something has changed."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("parts", nargs="*", metavar="part", help=", ".join(PARTS))
    parser.add_argument("--write", action="store_true", help="keep what is found")
    arguments = parser.parse_args()
    parts = arguments.parts or PARTS
    status = 0
    with ProcessPoolExecutor(2) as pool:
        work = {part: pool.submit(computed, part) for part in parts}
        for part, future in work.items():
            found, seconds = future.result()
            file = VALUES / f"{part}.json"
            if arguments.write:
                text = json.dumps(found, indent=1, ensure_ascii=False)
                file.write_text(text + "\n", encoding="utf-8")
            kept = json.loads(file.read_text(encoding="utf-8"))
            changed = list(differences(kept, found, PARTS[part][1]))
            print(
                f"{part}: {len(found)} results, {len(changed)} changes, {seconds:.0f} s", flush=True
            )
            print(*(f"  {line}" for line in changed[:40]), sep="\n", end="\n" if changed else "")
            status |= bool(changed) and part != "ratios"
    return status


if __name__ == "__main__":
    sys.exit(main())
