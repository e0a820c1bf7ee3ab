"""Answers on disk, chunk by chunk, so that what was done outlives whoever did it.

A store is a Zarr group: an array for each column of the answer, in which each chunk of the job is
a chunk, and ``done``, with a chunk of its own for each of them. A chunk's data are written first
and its mark in ``done`` after them, each by writing a file and renaming it: whatever is killed at
whatever moment leaves chunks that are marked and whole, and others that are done again. The mark
is one more than the number of impacts that the chunk took; its file tells when it was finished.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import shutil
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.code import code_hash
from percuss.ensembles.job import Block, Column, Job, chunks_of
from percuss.errors import OutputError

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = ["RESULT", "Store", "has_store", "keep_result", "opened_group", "own_attributes", "told"]

FORMAT = 2
# The finished result, for whoever only wants to look at it.
RESULT = "result.nc"
# Room for the reasons of a chunk: what does not fit is cut off.
REASON_BYTES = 1 << 18


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
            group = _open(self.path, job) if has_store(self.path) else _make(self.path, job)
            # Each look into the group reads a file.
            self._arrays = {name: group[name] for name in (*self._columns, "reasons", "done")}
            self._drop_damaged()

    def todo(self) -> list[int]:
        """Return the numbers of the chunks without a mark."""
        with told(self.path):
            return [int(i) for i in np.flatnonzero(self._arrays["done"][:] == 0)]

    def write(self, number: int, block: Block) -> None:
        """Write a chunk, and its mark after it."""
        first, last = self.spans[number]
        with told(self.path):
            for name, column in self._columns.items():
                values = np.asarray(block.arrays[name], dtype=column.dtype)
                if last - first < self._chunk:
                    # The last chunk is stored as long as the others.
                    values = np.concatenate([values, column.empty(self._chunk - last + first)])
                self._put(name, self._key(number, column), values)
            if block.reasons:
                self._arrays["reasons"][number] = _as_bytes(block.reasons)
            self._put("done", str(number), np.array([1 + block.n_impacts], dtype="i8"))

    @staticmethod
    def _key(number: int, column: Column) -> str:
        """Return the name of a chunk of a column among its files."""
        return "/".join([str(number), *("0" * len(column.tail))])

    def _put(self, name: str, key: str, values: NDArray[np.generic]) -> None:
        """Write a chunk as Zarr lays it down: its bytes, little end first, under its key.

        By Zarr itself a chunk takes 2 ms, most of them on the way to another thread and back.
        """
        target = self.path / name / "c" / key
        part = target.with_name(f"{target.name}.{os.getpid()}.part")
        target.parent.mkdir(parents=True, exist_ok=True)
        try:
            part.write_bytes(values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes())
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)

    def read(self) -> tuple[dict[str, NDArray[np.generic]], dict[int, str], int]:
        """Return all columns, the reasons by point, and the number of impacts it took."""
        with told(self.path):
            arrays = {name: np.array(self._arrays[name][:]) for name in self._columns}
            done = np.asarray(self._arrays["done"][:])
            for undone in np.flatnonzero(done == 0):
                # What was killed while it was written is not done.
                part = slice(*self.spans[int(undone)])
                for name, column in self._columns.items():
                    arrays[name][part] = column.empty(part.stop - part.start)
            reasons: dict[int, str] = {}
            # Of most chunks there is no file.
            for number, (first, _) in enumerate(self.spans):
                if not (self.path / "reasons" / "c" / str(number)).exists():
                    continue
                found = self._arrays["reasons"][number]
                if found[0]:
                    texts = json.loads(bytes(found).rstrip(b"\0"))
                    reasons |= {first + i: text for text, those in texts for i in those}
        return arrays, dict(sorted(reasons.items())), int(done.sum() - np.count_nonzero(done))

    def _drop_damaged(self) -> None:
        """Take the marks off chunks whose data are gone or cut off, so that they are done again."""
        done = np.asarray(self._arrays["done"][:])
        try:
            whole = not any(self._is_missing(int(i)) for i in np.flatnonzero(done))
            for name in self._columns if whole and done.any() else ():
                self._arrays[name][:]
        except (ValueError, RuntimeError, OSError):
            whole = False
        if not whole:
            for number in np.flatnonzero(done):
                if not self._is_whole(int(number)):
                    self._arrays["done"][int(number)] = 0

    def _is_missing(self, number: int) -> bool:
        """Tell whether a chunk has no file for one of its columns."""
        return any(
            not (self.path / name / "c" / self._key(number, column)).exists()
            for name, column in self._columns.items()
        )

    def _is_whole(self, number: int) -> bool:
        first, last = self.spans[number]
        try:
            for name in self._columns:
                self._arrays[name][first:last]
        except (ValueError, RuntimeError, OSError):
            return False
        return not self._is_missing(number)


@contextlib.contextmanager
def told(path: Path) -> Iterator[None]:
    """Say in a sentence what is wrong with a store."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(path, f"{error.strerror or error}; what was finished is kept") from error
    except (ValueError, KeyError, TypeError, RuntimeError) as error:
        raise OutputError(path, f"a damaged store ({error}); choose another name") from error


def has_store(path: Path) -> bool:
    """Tell whether a folder holds a store."""
    return (path / "zarr.json").exists()


def opened_group(path: Path, mode: str) -> Any:
    """Return the Zarr group in a folder."""
    # Half a second of import, which only who has a store should wait.
    import zarr

    return zarr.open_group(str(path), mode=mode, zarr_format=3)  # type: ignore[arg-type]


def own_attributes(path: Path, group: Any) -> dict[str, Any]:
    """Return what a store says of itself.

    Raises
    ------
    OutputError
        If it is no store of percuss, or of another version.
    """
    own = group.attrs.get("percuss")
    if not isinstance(own, dict):
        raise OutputError(path, "a Zarr group, but no store of percuss; choose another name")
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
            dataset.to_netcdf(part, engine="h5netcdf")
            part.replace(target)
        finally:
            part.unlink(missing_ok=True)


def _identity(job: Job) -> dict[str, Any]:
    # As it comes back from the file: tuples as lists.
    identity: dict[str, Any] = json.loads(json.dumps(job.identity()))
    return identity


def _make(path: Path, job: Job) -> Any:
    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise OutputError(path, "exists and is no store of percuss; choose another name")
    path.parent.mkdir(parents=True, exist_ok=True)
    # A group without its attributes is one that was killed while it was made: made anew.
    group = opened_group(path, "w")
    n = len(chunks_of(job))
    for name, column in job.columns.items():
        group.create_array(
            name,
            shape=(job.size, *column.tail),
            chunks=(min(job.chunk, job.size), *column.tail),
            dtype=column.dtype,
            fill_value=np.nan if column.dtype == "f8" else -1,
            dimension_names=("point", *column.dims) if column.dims or not column.tail else None,
            compressors=None,
        )
    group.create_array(
        "reasons", shape=(n, REASON_BYTES), chunks=(1, REASON_BYTES), dtype="u1", fill_value=0
    )
    group.create_array("done", shape=(n,), chunks=(1,), dtype="i8", fill_value=0, compressors=None)
    group.attrs["percuss"] = {
        "format": FORMAT,
        "version": metadata.version("percuss"),
        "code": code_hash(),
        "size": job.size,
        "chunk": job.chunk,
        # A point may stand for a whole branch.
        "motions_of_a_point": min(math.prod(column.tail) for column in job.columns.values()),
        "dimensions": [[it.name, list(it.values), it.units] for it in job.dimensions],
        "columns": {
            name: {"dims": list(column.dims), "units": column.units}
            for name, column in job.columns.items()
        },
        "study": _identity(job),
    }
    return group


def _open(path: Path, job: Job) -> Any:
    group = opened_group(path, "r+")
    if not dict(group.attrs) and not any(True for _ in path.glob("done/c/*")):
        # It was killed while it was made, before it held anything.
        shutil.rmtree(path)
        return _make(path, job)
    own = own_attributes(path, group)
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
    return group


def _as_bytes(reasons: dict[int, str]) -> NDArray[np.uint8]:
    """Return reasons as JSON, each text once, cut where they do not fit."""
    by_text: dict[str, list[int]] = {}
    for i, text in sorted(reasons.items()):
        by_text.setdefault(text, []).append(i)
    for longest in (None, 2000, 300, 40, 0):
        short: dict[str, list[int]] = {}
        for text, those in by_text.items():
            cut = text if longest is None else text[-longest:] if longest else ""
            short.setdefault(cut, []).extend(those)
        found = json.dumps(list(short.items())).encode()
        if len(found) <= REASON_BYTES:
            break
    return np.frombuffer(found.ljust(REASON_BYTES, b"\0"), dtype=np.uint8)
