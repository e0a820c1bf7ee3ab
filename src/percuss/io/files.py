"""Output files: complete or absent, and never overwritten without permission."""

from __future__ import annotations

import glob
import logging
import os
import time
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import Self

from percuss.errors import OutputError
from percuss.processes import is_running

LOG = logging.getLogger(__name__)

EXISTS = "exists already; force=True replaces it"
# The size of a larger file is announced before it is written [bytes].
LARGE = 50_000_000
# A part that has not grown for so long belongs to a process that was killed [s].
STALE = 3600.0


def check_output(paths: Iterable[Path | str], *, force: bool = False) -> None:
    """Refuse, before any work is done, an output that could not be written in the end.

    Parameters
    ----------
    paths
        The files that will be written.
    force
        Whether files of these names may be replaced.

    Raises
    ------
    OutputError
        If a file exists and `force` is false, or if a folder is missing and cannot be made, or
        cannot be written to.

    Examples
    --------
    >>> check_output(["no-such-folder/motion.nc"])
    """
    for path in map(Path, paths):
        try:
            _check_folder(path.parent)
            if path.is_dir():
                raise OutputError(str(path), "is a folder; choose another name")
            if path.exists() and not force:
                raise OutputError(str(path), EXISTS)
        except OSError as error:
            raise OutputError(str(path), _reason(error)) from error


def check_output_folder(folder: Path | str, *, force: bool = False) -> None:
    """Refuse, before any work is done, a folder that could not be written to or holds other things.

    Parameters
    ----------
    folder
        The folder; it need not be there.
    force
        Whether it may hold something.

    Raises
    ------
    OutputError
        If it is not empty and `force` is false, cannot be made, or cannot be written to.

    Examples
    --------
    >>> check_output_folder("no-such-folder")
    """
    folder = Path(folder)
    try:
        _check_folder(folder)
        if not force and folder.is_dir() and any(folder.iterdir()):
            reason = "the folder is not empty; force=True writes into it"
            raise OutputError(str(folder), reason)
    except OSError as error:
        raise OutputError(str(folder), _reason(error)) from error


def _check_folder(folder: Path) -> None:
    """Raise unless `folder` is, or could be made, a folder that can be written to."""
    for ancestor in (folder, *folder.parents):
        if ancestor.exists() or ancestor.is_symlink():
            if not ancestor.is_dir():
                raise OutputError(
                    str(ancestor), "is a file, not a folder; rename it, or name another folder"
                )
            if not os.access(ancestor, os.W_OK | os.X_OK):
                raise OutputError(str(ancestor), "the folder cannot be written to")
            return


def _remove_stale_parts(path: Path) -> None:
    """Remove the parts of this file that killed processes have left.

    In a folder shared by several machines the process may run elsewhere: then the part is recent.
    """
    for part in path.parent.glob(f".{glob.escape(path.name)}.*.part"):
        number = part.name.removesuffix(".part").rpartition(".")[2]
        if number.isdecimal() and not is_running(int(number)):
            with suppress(OSError):
                if time.time() - part.stat().st_mtime >= STALE:
                    part.unlink()


def _reason(error: OSError) -> str:
    """Return the message of the operating system in lower case and without full stop."""
    words = error.strerror or str(error) or type(error).__name__
    return words[:1].lower() + words[1:]


def record_file(path: Path | str) -> Path:
    """Return the file that holds the record of a CSV file.

    Examples
    --------
    >>> record_file("impacts.csv").name
    'impacts.csv.toml'
    """
    return Path(path).with_name(f"{Path(path).name}.toml")


def say_size(part: Path, size: int) -> None:
    """Announce on the error stream the size of a large file [bytes], from its temporary name."""
    if size >= LARGE:
        name = part.name.removeprefix(".").removesuffix(f".{os.getpid()}.part")
        LOG.warning(f"writing {name}: about {size / 1e6:,.0f} MB")


class OutputFiles:
    """A group of files that appear together at the end of a ``with`` block, or not at all.

    Each file is written under a temporary name in its own folder and renamed at the end. An
    exception inside the block, Ctrl-C included, removes these files and the folders that were made
    for them. Errors of the operating system are raised as an `OutputError`.

    Parameters
    ----------
    *paths
        The files to write.
    force
        Whether files of these names may be replaced.

    Examples
    --------
    >>> import tempfile
    >>> folder = Path(tempfile.mkdtemp())
    >>> with OutputFiles(folder / "a.txt") as files:
    ...     _ = files[folder / "a.txt"].write_text("done")
    ...     (folder / "a.txt").exists()
    False
    >>> (folder / "a.txt").read_text()
    'done'
    """

    def __init__(self, *paths: Path | str, force: bool = False) -> None:
        self._paths = [Path(path) for path in paths]
        self._force = force
        self._made: list[Path] = []

    def __getitem__(self, path: Path | str) -> Path:
        """Return the temporary name under which to write the file `path`."""
        final = Path(path)
        return final.with_name(f".{final.name}.{os.getpid()}.part")

    def __enter__(self) -> Self:
        check_output(self._paths, force=self._force)
        try:
            for path in self._paths:
                self._make_folder(path.parent)
                _remove_stale_parts(path)
        except OSError as error:
            self._discard()
            raise OutputError(str(error.filename or path.parent), _reason(error)) from error
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        try:
            if error is None:
                self._publish()
        except BaseException as late:
            error = late
            raise
        finally:
            if error is not None:
                self._discard()
        if isinstance(error, OSError):
            raise OutputError(str(self._paths[0].parent), _reason(error)) from error

    def _make_folder(self, folder: Path) -> None:
        missing = [part for part in (folder, *folder.parents) if not part.exists()]
        for part in reversed(missing):
            part.mkdir(exist_ok=True)
            self._made.append(part)

    def _publish(self) -> None:
        # Checked once more: another process may have written here during a long run.
        check_output(self._paths, force=self._force)
        for path in self._paths:
            try:
                self[path].replace(path)
            except OSError as error:
                raise OutputError(str(path), _reason(error)) from error

    def _discard(self) -> None:
        for path in self._paths:
            with suppress(OSError):
                self[path].unlink(missing_ok=True)
        for folder in reversed(self._made):
            # A folder in which something else has appeared meanwhile stays.
            with suppress(OSError):
                folder.rmdir()
