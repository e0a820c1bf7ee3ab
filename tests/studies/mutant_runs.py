"""Runs mutants of studies in a process of its own: one number a line in, one answer a line out."""

from __future__ import annotations

import json
import os
import selectors
import subprocess
import sys
import tempfile
import time
import traceback
import warnings
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from tests.studies.mutants import mutant, text_of

from percuss.errors import PercussError
from percuss.studies.reading import parse_study
from percuss.studies.running import run_study
from percuss.studies.study import Study
from percuss.studies.templates import template_names

# A study is asked to stop after this time, as by Ctrl-C [s].
STOPPED = 1.0
# It may use the processor for so long after that, and take so long in all on a busy machine [s].
ENDED, LONGEST = 10.0, 300.0


def answer(seed: int) -> dict[str, Any]:
    """Return what became of a mutant: what it did wrong, or nothing."""
    try:
        study = parse_study(mutant(seed).text, f"mutant {seed}")
    except PercussError:
        return {"is_run": False}
    begun = time.process_time()
    try:
        run(study)
    except PercussError as error:
        # In one sentence: no text of a library beneath.
        if "\n" in str(error):
            return {"is_run": True, "problem": f"several lines: {error}"}
    except Exception:  # noqa: BLE001
        return {"is_run": True, "problem": traceback.format_exc()}
    used = time.process_time() - begun
    late = {"problem": f"{used:.0f} s of work"} if used > STOPPED + ENDED else {}
    return {"is_run": True} | late


def run(study: Study) -> None:
    """Run a study, and stop it as Ctrl-C does where it takes longer."""
    begun = time.process_time()
    with tempfile.TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("ignore")
        run_study(study, folder, progress=lambda *_: time.process_time() < begun + STOPPED)


def serve() -> None:
    """Answer until the input ends."""
    # What a library prints to the output by itself would be taken for an answer.
    out = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    # What is compiled or loaded for the first time is no time of a mutant.
    for name in template_names():
        with suppress(PercussError):
            run(parse_study(text_of(name), name))
    for line in sys.stdin:
        print(json.dumps(answer(int(line))), file=out, flush=True)


class Runner:
    """A process that runs mutants, and that is begun anew where it hangs."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[str] | None = None

    def __call__(self, seed: int) -> dict[str, Any]:
        """Return what became of a mutant."""
        process = self._process or self._begun()
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdin.write(f"{seed}\n")
        process.stdin.flush()
        with selectors.DefaultSelector() as selector:
            selector.register(process.stdout, selectors.EVENT_READ)
            if not selector.select(LONGEST):
                self._end()
                return {"is_run": True, "problem": f"nothing after {LONGEST} s"}
        line = process.stdout.readline()
        if not line:
            status = process.wait()
            self._process = None
            return {"is_run": True, "problem": f"the process ended with status {status}"}
        found: dict[str, Any] = json.loads(line)
        return found

    def _begun(self) -> subprocess.Popen[str]:
        root = Path(__file__).parents[2]
        code = "from tests.studies.mutant_runs import serve; serve()"
        self._process = subprocess.Popen(
            [sys.executable, "-c", code], cwd=root, text=True,
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL,
        )  # fmt: skip
        return self._process

    def _end(self) -> None:
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._end()
