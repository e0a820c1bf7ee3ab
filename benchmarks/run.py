"""Run the benchmarks: python benchmarks/run.py [name ...] [--write docs/benchmarks.md].

Without names all of them. Peers (heyoka, SciPy) take part where they are installed; a benchmark
that needs what is not there is left out with a line. Answers are
asserted, times are printed only.
"""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
# Modules of this folder, in the order of the table.
NAMES = {
    "w1": "elastic",
    "w2": "sweep",
    "w3": "bilinear",
    "w4": "basin",
    "harmonics": "three_harmonics",
    "records": "records",
    "sensitivities": "sensitivities",
    "fits": "fits",
    "structures": "structures",
    "long": "long_runs",
    "adversarial": "grazes",
    "sampling": "sampling",
    "memory": "memory",
    "measures": "measures",
    "ensembles": "ensembles",
    "certified": "certified",
    "compilations": "compilations",
    "import": "startup",
    "workbench": "workbench",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", metavar="name", help=", ".join(NAMES))
    parser.add_argument("--write", type=Path, metavar="FILE", help="write the table as Markdown")
    arguments = parser.parse_args()
    unknown = [name for name in arguments.names if name not in NAMES]
    if unknown:
        parser.error(f"no benchmark {unknown[0]}; there are {', '.join(NAMES)}")

    sys.path.insert(0, str(ROOT))
    from benchmarks.report import Report

    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    report = Report()
    wrong, left_out = [], []
    for name in arguments.names or NAMES:
        try:
            importlib.import_module(f"benchmarks.{NAMES[name]}").run(report)
        except ImportError as error:
            # What is missing is no fault of percuss's; the others are measured all the same.
            print(f"  {name} is left out: {error}", flush=True)
            left_out.append(name)
        except AssertionError as error:
            print(f"  WRONG ANSWER: {error}", flush=True)
            wrong.append(name)
    if wrong:
        sys.exit(f"wrong answers in {', '.join(wrong)}; nothing written")
    if left_out:
        print(
            f"left out: {', '.join(left_out)}; pip install -e '.[all,benchmark]' brings what is missing"
        )
    if arguments.write:
        arguments.write.write_text(report.markdown(), encoding="utf-8")


if __name__ == "__main__":
    main()
