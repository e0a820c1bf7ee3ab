"""Worker processes: how they begin, and what they need of the caller's script."""

from __future__ import annotations

import ast
import multiprocessing
import pickle
import pickletools
import signal
import sys
import traceback
import types
from collections.abc import Iterable
from concurrent import futures
from pathlib import Path

from percuss.ensembles.job import Block, Job
from percuss.errors import ParameterError

__all__ = ["check_processes", "compute_remembered", "process_pool"]

GUARD = 'if __name__ == "__main__":'

# The job of this worker process, sent once when it began.
_remembered: list[Job] = []


def process_pool(n: int, job: Job) -> futures.Executor:
    """Return a pool of so many processes, each of which keeps the job."""
    return futures.ProcessPoolExecutor(
        n,
        # Forking a process whose threads hold locks can hang it.
        mp_context=multiprocessing.get_context("spawn"),
        initializer=_remember,
        initargs=(job,),
    )


def _remember(job: Job) -> None:
    _remembered[:] = [job]
    # Ctrl-C reaches all processes of a terminal; what is done about it is the caller's.
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def compute_remembered(first: int, last: int) -> Block:
    """Do a chunk of the job that this worker process keeps."""
    return _remembered[0].compute(first, last)


def check_processes(job: Job) -> None:
    """Raise a `ParameterError` unless worker processes can begin and find the job's function.

    A process that is spawned imports the caller's script first, under another name than
    ``__main__``, and takes functions from there by their names.
    """
    measure = getattr(job, "measure", None)
    shown = getattr(measure, "__name__", measure)
    try:
        sent = pickle.dumps(job)
    except (pickle.PicklingError, AttributeError, TypeError) as error:
        if measure is None:
            raise
        reason = (
            "cannot be sent to another process, which takes functions by the name that they have "
            'in a module; define it with def in a module, or take engine="threads"'
        )
        raise ParameterError("measure", shown, reason) from error
    words = {word for _, word, _ in pickletools.genops(sent) if isinstance(word, str)}
    main = sys.modules["__main__"]
    file = getattr(main, "__file__", None)
    if file is not None and not Path(file).is_file():
        reason = (
            f"begins other processes, which import the script that asks for them, and {file} is "
            'no file; save it as one, or take engine="threads"'
        )
        raise ParameterError("engine", "processes", reason)
    if file is not None:
        _check_script(main, Path(file), words if "__main__" in words else set())
    elif "__main__" in words:
        reason = (
            "defined where no other process can import it, in a notebook, a session or a text "
            "given to python; put it into a file of its own and import it from there, or take "
            'engine="threads"'
        )
        raise ParameterError("measure", shown, reason)


def _check_script(main: types.ModuleType, file: Path, words: set[str]) -> None:
    """Raise unless a script asks for processes under its guard, and defines functions above it."""
    try:
        nodes = list(ast.walk(ast.parse(file.read_bytes())))
    except (OSError, SyntaxError, ValueError):
        return
    guards = [it for it in nodes if isinstance(it, ast.If) and "__name__" in ast.unparse(it.test)]
    for frame, line in traceback.walk_stack(None):
        is_script = frame.f_code.co_name == "<module>" and frame.f_globals is vars(main)
        if is_script and not any(it.lineno <= line <= (it.end_lineno or line) for it in guards):
            reason = (
                f"begins other processes, which import {file.name} and would come to its line "
                f"{line} again; put what the script does under `{GUARD}`"
            )
            raise ParameterError("engine", "processes", reason)
    under = _defined(it for guard in guards for it in ast.walk(guard))
    hidden = set(under) & words
    if any(under.count(name) == _defined(nodes).count(name) for name in hidden):
        reason = (
            f"defined under `{GUARD}`, where other processes do not see it; "
            "define it above that line"
        )
        raise ParameterError("measure", min(hidden), reason)


def _defined(nodes: Iterable[ast.AST]) -> list[str]:
    return [it.name for it in nodes if isinstance(it, ast.FunctionDef | ast.ClassDef)]
