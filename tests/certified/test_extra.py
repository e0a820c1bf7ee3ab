from __future__ import annotations

import subprocess
import sys

WITHOUT = """
import sys
sys.modules["flint"] = None
import percuss as pc
run = pc.simulate(pc.impact_oscillator(), v0=1, t_end=3.0)
try:
    pc.certify(run)
except pc.MissingExtraError as missing:
    print(missing)
"""


def test_without_flint_all_else_works_and_certify_says_what_to_install() -> None:
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=True
    )

    assert done.stdout == "certified results need python-flint: install percuss[certified]\n"
