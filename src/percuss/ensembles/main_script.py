"""Whether other processes can begin from the script that asks for them."""

from __future__ import annotations

import ast
import io
import pickle
import sys
import types
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from percuss.errors import ParameterError

__all__ = ["check_main"]

GUARD = 'if __name__ == "__main__":'


def check_main(work: object) -> None:
    """Raise unless other processes can begin, and find there what they are sent.

    A process that is spawned imports the caller's script first, under another name than
    ``__main__``, and takes functions from there by their names.

    Parameters
    ----------
    work
        What is sent to them, which can be pickled.

    Raises
    ------
    ParameterError
        If the script would ask for processes again, or a function is not defined in it then.
    """
    main = sys.modules["__main__"]
    file = getattr(main, "__file__", None)
    names = _names_in_main(work)
    if file is not None and not Path(file).is_file():
        reason = (
            f"begins other processes, which import the script that asks for them, and {file} is "
            'no file; save it as one, or take engine="threads"'
        )
        raise ParameterError("engine", "processes", reason)
    if file is None:
        if names:
            reason = (
                "defined where no other process can import it, in a notebook, a session or a text "
                "given to python; put it into a file of its own and import it from there, or take "
                'engine="threads"'
            )
            raise ParameterError("measure", names[0], reason)
        return
    try:
        body = ast.parse(Path(file).read_bytes()).body
    except (OSError, SyntaxError, ValueError):
        return
    line = _line_in_main(main, Path(file))
    if line is not None and not _is_guarded(body, line):
        reason = (
            f"begins other processes, which import {Path(file).name} and would come to its line "
            f"{line} again; put what the script does under `{GUARD}`"
        )
        raise ParameterError("engine", "processes", reason)
    seen, hidden = set(_bound(body, guarded=False)), set(_bound(body, guarded=True))
    for name in names:
        if name in hidden - seen:
            reason = (
                f"defined under `{GUARD}`, where other processes do not see it; "
                "define it above that line"
            )
            raise ParameterError("measure", name, reason)


class _Finder(pickle.Pickler):
    """Notes what is taken from ``__main__`` by its name."""

    def __init__(self) -> None:
        super().__init__(io.BytesIO())
        self.names: list[str] = []

    def reducer_override(self, value: Any) -> Any:
        """Note a function or a class, and pickle it as ever."""
        if isinstance(value, types.FunctionType | type) and value.__module__ == "__main__":
            self.names.append(value.__qualname__.partition(".")[0])
        return NotImplemented


def _names_in_main(work: object) -> list[str]:
    finder = _Finder()
    finder.dump(work)
    return finder.names


def _line_in_main(main: types.ModuleType, file: Path) -> int | None:
    """Return the line of the script that is being run, None where none is."""
    frame: types.FrameType | None = sys._getframe()  # there is no other way
    while frame is not None:
        is_module = frame.f_code.co_name == "<module>" and frame.f_globals is vars(main)
        if is_module and Path(frame.f_code.co_filename).resolve() == file.resolve():
            return frame.f_lineno
        frame = frame.f_back
    return None


def _is_guard(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.If) and any(
        isinstance(node, ast.Name) and node.id == "__name__" for node in ast.walk(statement.test)
    )


def _is_guarded(body: Sequence[ast.stmt], line: int) -> bool:
    """Tell whether a line stands under a guard."""
    for statement in body:
        if statement.lineno <= line <= (statement.end_lineno or line):
            if _is_guard(statement):
                return True
            return any(_is_guarded(inner, line) for inner in _bodies(statement))
    return False


def _bodies(statement: ast.stmt) -> Iterator[Sequence[ast.stmt]]:
    """Give the statements inside one that are run where it is."""
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        return
    for name in ("body", "orelse", "finalbody"):
        yield getattr(statement, name, [])
    for handler in getattr(statement, "handlers", []):
        yield handler.body


def _bound(body: Sequence[ast.stmt], *, guarded: bool, inside: bool = False) -> Iterator[str]:
    """Give the names that a module binds, either under its guards or elsewhere."""
    for statement in body:
        under = inside or _is_guard(statement)
        if under == guarded:
            yield from _names_of(statement)
        for inner in _bodies(statement):
            yield from _bound(inner, guarded=guarded, inside=under)


def _names_of(statement: ast.stmt) -> Iterator[str]:
    if isinstance(statement, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
        yield statement.name
    elif isinstance(statement, ast.Import | ast.ImportFrom):
        yield from (alias.asname or alias.name.partition(".")[0] for alias in statement.names)
    elif isinstance(statement, ast.Assign | ast.AnnAssign):
        for node in ast.walk(statement):
            if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
                yield node.id
