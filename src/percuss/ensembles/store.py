"""Answers on disk, chunk by chunk, so that what was done outlives whoever did it.

A store is a Zarr group: an array for each column of the answer, in which each chunk of the job is
a chunk, and ``done``, with a chunk of its own for each of them. A chunk's data are written first
and its mark in ``done`` after them, each by writing a file and renaming it: whatever is killed at
whatever moment leaves chunks that are marked and whole, and others that are done again. The mark
is two numbers: one more than the impacts that the chunk took, and when it was finished, which a
copy of the file does not tell any more. Every file of a chunk ends with a checksum.

The store's own ``zarr.json`` is its marker: it is the first thing that is written, under another
name that is then linked to this one, and it says what study it is. A folder that holds anything
and has no such marker is somebody else's, and is left as it is. No folder is ever removed.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
from collections.abc import Iterator, Sequence
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.ensembles.code import code_hash
from percuss.ensembles.job import Answer, Block, Job, chunks_of
from percuss.ensembles.netcdf_bytes import write_whole
from percuss.ensembles.store_chunks import (
    MARK,
    cut_files,
    key_of,
    lay_down,
    mark_of,
    marks_in,
    sound_chunks,
)
from percuss.ensembles.store_contents import REASON_BYTES, contents, reasons_as_bytes
from percuss.errors import OutputError, PercussError

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = [
    "RESULT",
    "Store",
    "described",
    "has_store",
    "is_vacant",
    "keep_result",
    "make_folder",
    "opened_group",
    "own_attributes",
    "told",
]

FORMAT = 3
# The finished result, for whoever only wants to look at it.
RESULT = "result.nc"
# What says which study a store is of, and under what name it is written first.
MARKER = "zarr.json"
PART = re.compile(r"zarr\.json\.\d+\.part")


class Store:
    """A store that is open for one job: made for it, or found to be of it.

    Parameters
    ----------
    path
        The folder; it does not exist, is empty, or holds a store of the same job.
    job
        The job.

    Raises
    ------
    OutputError
        If it holds something else, another study, the work of other code, or cannot be written.
    """

    def __init__(self, path: str | Path, job: Job) -> None:
        self.path = Path(path)
        self.spans = chunks_of(job)
        self._chunk = min(job.chunk, job.size)
        self._columns = job.columns
        with told(self.path):
            is_there = has_store(self.path)
            self._arrays = _open(self.path, job) if is_there else _make(self.path, job)
            if is_there:
                self._drop_damaged()

    def todo(self) -> list[int]:
        """Return the numbers of the chunks without a mark."""
        with told(self.path):
            return np.flatnonzero(marks_in(self.path, len(self.spans))[:, 0] == 0).tolist()

    def write(self, number: int, block: Block) -> None:
        """Write a chunk, and its mark after it."""
        first, last = self.spans[number]
        with told(self.path):
            for name, column in self._columns.items():
                values = np.asarray(block.arrays[name], dtype=column.dtype)
                if last - first < self._chunk:
                    # The last chunk is stored as long as the others.
                    values = np.concatenate([values, column.empty(self._chunk - last + first)])
                lay_down(self.path / name / "c" / key_of(number, column.tail), values)
            if block.reasons:
                self._arrays["reasons"][number] = reasons_as_bytes(block.reasons)
            lay_down(self.path / "done" / "c" / str(number), mark_of(block.n_impacts))

    def read(self) -> Answer:
        """Return what has been done."""
        with told(self.path):
            return contents(self.path, self._arrays, self._columns, self.spans)

    def _drop_damaged(self) -> None:
        """Take the marks off chunks whose data are gone or cut off, so that they are done again."""
        marks = marks_in(self.path, len(self.spans))
        sound = sound_chunks(self.path, self._columns, self._chunk, marks, thoroughly=True)
        for number in np.flatnonzero((marks[:, 0] > 0) & ~sound).tolist():
            (self.path / "done" / "c" / str(number)).unlink()


@contextlib.contextmanager
def told(path: Path) -> Iterator[None]:
    """Say in a sentence what is wrong with a store."""
    try:
        yield
    except PercussError:
        raise
    except OSError as error:
        kept = "; what was finished is kept" if _has_chunks(path) else ""
        raise OutputError(path, f"{error.strerror or error}{kept}") from error
    except json.JSONDecodeError as error:
        raise OutputError(path, _cut_off(path)) from error
    except KeyError as error:
        reason = f"a damaged store, which has lost its {error}; choose another name"
        raise OutputError(path, reason) from error
    except (ValueError, TypeError, RuntimeError) as error:
        raise OutputError(path, f"a damaged store ({error}); choose another name") from error


def _cut_off(path: Path) -> str:
    """Say which description of a damaged store is cut off, and what to do."""
    cut = cut_files(path)
    if "zarr.json" in cut or not cut:
        return (
            "a damaged store: its zarr.json, which says what study it is, is cut off or changed; "
            "put a copy of that file back, or choose another name"
        )
    return f"a damaged store: {cut[0]} is cut off or changed; the command that began it mends that"


def _has_chunks(path: Path) -> bool:
    try:
        return (path / "done" / "c").exists()
    except OSError:
        # The path itself may be what is wrong.
        return False


def has_store(path: Path) -> bool:
    """Return whether a folder is described as Zarr: a store of percuss, or somebody else's."""
    return (path / MARKER).exists()


def described(path: Path) -> dict[str, Any] | None:
    """Return what a store of percuss says of itself, None where the folder is somebody else's.

    Raises
    ------
    OSError, ValueError
        If there is no description, or it cannot be read.
    """
    about = json.loads((path / MARKER).read_bytes())
    attributes = about.get("attributes") if isinstance(about, dict) else None
    own = attributes.get("percuss") if isinstance(attributes, dict) else None
    return own if isinstance(own, dict) and about.get("node_type") == "group" else None


def is_vacant(path: Path, parts: Sequence[str] = ()) -> bool:
    """Return whether a store can be made in a folder, because nothing of anybody's is in it.

    Parameters
    ----------
    path
        The folder: missing, empty, or with what a process has left that was killed while it made
        a store there.
    parts
        Names of folders in it that may be there if they are vacant themselves.
    """
    if not path.exists():
        return True
    return path.is_dir() and all(
        PART.fullmatch(entry.name) or (entry.name in parts and is_vacant(entry))
        for entry in path.iterdir()
    )


def make_folder(path: Path) -> None:
    """Make the folder of a store; what it lies in is there, or the path has a slip in it.

    Raises
    ------
    OutputError
        If it cannot be made.
    """
    with told(path):
        if not path.parent.exists():
            raise OutputError(path, f"there is no folder {path.parent}; make it first")
        path.mkdir(exist_ok=True)


def opened_group(path: Path, mode: str) -> Any:
    """Return the Zarr group in a folder."""
    # Half a second of import, which only who has a store should wait.
    import zarr

    return zarr.open_group(str(path), mode=mode, zarr_format=3)  # type: ignore[arg-type]


def own_attributes(path: Path) -> dict[str, Any]:
    """Return what a store says of itself.

    Raises
    ------
    OutputError
        If it is no store of percuss, or of another version.
    """
    own = described(path)
    if own is None:
        reason = "Zarr data that are no store of percuss, and are left as they are"
        raise OutputError(path, f"{reason}; choose another name for a store")
    if own.get("format") != FORMAT:
        reason = (
            f"a store of format {own.get('format')}, written by percuss {own.get('version')}; "
            f"this is percuss {metadata.version('percuss')} and reads format {FORMAT}"
        )
        raise OutputError(path, reason)
    return own


def keep_result(path: str | Path, dataset: Dataset) -> None:
    """Write the finished result into its store, for `load_store`.

    Parameters
    ----------
    path
        The folder of the store.
    dataset
        The result.

    Raises
    ------
    OutputError
        If it cannot be written.
    """
    target = Path(path) / RESULT
    part = target.with_suffix(f".{os.getpid()}.part")
    with told(Path(path)):
        try:
            write_whole(dataset, part)
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)


def _identity(job: Job) -> dict[str, Any]:
    # As it comes back from the file: tuples as lists.
    identity: dict[str, Any] = json.loads(json.dumps(job.identity()))
    return identity


def _make(path: Path, job: Job) -> dict[str, Any]:
    if not is_vacant(path):
        reason = "exists and is no store of percuss; it is left as it is; choose another name"
        raise OutputError(path, reason)
    about = {
        "format": FORMAT,
        "version": metadata.version("percuss"),
        "code": code_hash(),
        "size": job.size,
        "chunk": job.chunk,
        # A point may stand for a whole branch.
        "motions_of_a_point": min(math.prod(column.tail) for column in job.columns.values()),
        "dimensions": [[it.name, list(it.values), it.units] for it in job.dimensions],
        "columns": {
            name: {"dims": list(column.dims), "units": column.units, "meaning": column.meaning}
            for name, column in job.columns.items()
        },
        "study": _identity(job),
    }
    make_folder(path)
    _mark(path, about)
    # Arrays that are missing are made, here and after a process that was killed before.
    return _open(path, job)


def _mark(path: Path, about: dict[str, object]) -> None:
    """Write what a store is, at once and never over a description that is there."""
    marker, part = path / MARKER, path / f"{MARKER}.{os.getpid()}.part"
    group = {"zarr_format": 3, "node_type": "group", "attributes": {"percuss": about}}
    try:
        with part.open("w", encoding="utf-8") as file:
            json.dump(group, file, allow_nan=False)
            file.flush()
            os.fsync(file.fileno())
        try:
            os.link(part, marker)
        except FileExistsError:
            # Another process was first; whether its study is the same is looked at next.
            return
        except OSError:
            # A file system without links.
            if not marker.exists():
                part.replace(marker)
    finally:
        part.unlink(missing_ok=True)


def _open(path: Path, job: Job) -> dict[str, Any]:
    own = own_attributes(path)
    wanted = _identity(job)
    known = {*own["study"], *wanted}
    different = [key for key in sorted(known) if own["study"].get(key) != wanted.get(key)]
    if different or (own["size"], own["chunk"]) != (job.size, job.chunk):
        what = ", ".join(different) or "the chunks"
        raise OutputError(
            path, f"holds another study, which differs in {what}; choose another name"
        )
    if own["code"] != code_hash():
        reason = (
            f"was begun by other code (percuss {own['version']}, code {own['code']}; this is "
            f"{metadata.version('percuss')}, code {code_hash()}), whose last bits may differ; "
            "finish it with that or choose another name"
        )
        raise OutputError(path, reason)
    group = opened_group(path, "r+")
    return {name: _opened_array(path, group, name, job) for name in _names(job)}


def _names(job: Job) -> tuple[str, ...]:
    return (*job.columns, "reasons", "done")


def _opened_array(path: Path, group: Any, name: str, job: Job) -> Any:
    """Return an array, described anew where a crash of the machine has left no description."""
    try:
        found = group[name]
    except (ValueError, KeyError, TypeError):
        if not is_vacant(path / name) and not _is_of_store(path / name):
            reason = f"holds a {name} that is no array of this store, and is left as it is"
            raise OutputError(path, f"{reason}; move it away") from None
        (path / name / MARKER).unlink(missing_ok=True)
        return _array(group, name, job)
    shape = _shape(name, job)
    if getattr(found, "shape", None) != shape:
        reason = f"holds a {name} that is no array of shape {shape}, as this store has it"
        raise OutputError(path, f"{reason}; move it away")
    return found


def _is_of_store(folder: Path) -> bool:
    """Return whether a folder holds nothing but what an array of a store is made of."""
    return folder.is_dir() and {entry.name for entry in folder.iterdir()} <= {MARKER, "c"}


def _shape(name: str, job: Job) -> tuple[int, ...]:
    n = len(chunks_of(job))
    if name in ("done", "reasons"):
        return (MARK * n,) if name == "done" else (n, REASON_BYTES)
    return (job.size, *job.columns[name].tail)


def _array(group: Any, name: str, job: Job) -> Any:
    """Describe an array in a group; chunks that are there stay."""
    from zarr.codecs import Crc32cCodec, ZstdCodec

    shape, sums = _shape(name, job), [Crc32cCodec()]
    if name == "done":
        return group.create_array(
            name, shape=shape, chunks=(MARK,), dtype="i8", fill_value=0, compressors=sums
        )
    if name == "reasons":
        return group.create_array(
            name, shape=shape, chunks=(1, REASON_BYTES), dtype="u1", fill_value=0,
            compressors=[ZstdCodec(), *sums],
        )  # fmt: skip
    column = job.columns[name]
    return group.create_array(
        name,
        shape=shape,
        chunks=(min(job.chunk, job.size), *column.tail),
        dtype=column.dtype,
        fill_value=np.nan if column.dtype == "f8" else -1,
        dimension_names=("point", *column.dims) if column.dims or not column.tail else None,
        compressors=sums,
    )
