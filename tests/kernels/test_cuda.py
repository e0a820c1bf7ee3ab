"""The batch kernels are fit for a CUDA device: their types now, their values in the simulator."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from percuss.kernels.record import REACHED_END

PROGRAM = Path(__file__).with_name("device_batch.py")


def answer_of(*arguments: str, **environment: str) -> Any:
    """Run the program in a process of its own: the simulator replaces the whole of `numba.cuda`."""
    done = subprocess.run(
        [sys.executable, "-W", "ignore", str(PROGRAM), *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


# A whole march takes ten seconds to type, a round of flights two.
@pytest.mark.parametrize("kernel", ["lockstep", pytest.param("follow", marks=pytest.mark.nightly)])
def test_the_kernels_have_types_on_a_device(kernel: str) -> None:
    wrong = answer_of("types", kernel, "broken")

    assert wrong[kernel] == ""
    # A check that lets this pass would let anything pass.
    assert "TypingError" in wrong["broken"]


def test_in_the_simulator_motions_have_the_impacts_of_simulate() -> None:
    # Its arrays are no arrays to compiled functions: all is plain Python here.
    answer = answer_of("values", NUMBA_ENABLE_CUDASIM="1", NUMBA_DISABLE_JIT="1")

    assert answer["status"] == [REACHED_END] * 3
    assert all(len(speeds) > 1 for speeds in answer["expected"])
    assert answer["speeds"] == answer["expected"]
