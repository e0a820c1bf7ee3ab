"""Answers on disk, chunk by chunk, so that what was done outlives whoever did it.

A store is a Zarr group: an array for each column of the answer, in which each chunk of the job is
a chunk, and ``done``, with a chunk of its own for each of them. A chunk's data are written first
and its mark in ``done`` after them, each by writing a file and renaming it: whatever is killed at
whatever moment leaves chunks that are marked and whole, and others that are done again.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import json
from collections.abc import Iterator
from importlib import metadata, resources
from importlib.resources.abc import Traversable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.job import Block, Job, chunks_of
from percuss.errors import OutputError

__all__ = ["Store", "status_of_store"]

FORMAT = 1
# Room for the reasons of a chunk: what does not fit is cut off.
REASON_BYTES = 1 << 18
# Folders whose code an answer depends on.
CODE = ("kernels", "model", "motion", "ensembles")


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
        self._columns = job.columns
        with _told(self.path):
            self._group = _open(self.path, job) if _has_store(self.path) else _make(self.path, job)

    def todo(self) -> list[int]:
        """Return the numbers of the chunks without a mark."""
        with _told(self.path):
            return [int(i) for i in np.flatnonzero(self._group["done"][:] == 0)]

    def write(self, number: int, block: Block) -> None:
        """Write a chunk, and its mark after it."""
        first, last = self.spans[number]
        with _told(self.path):
            for name in self._columns:
                self._group[name][first:last] = block.arrays[name]
            if block.reasons:
                self._group["reasons"][number] = _as_bytes(block.reasons)
            self._group["n_impacts"][number] = block.n_impacts
            self._group["done"][number] = 1

    def read(self) -> tuple[dict[str, NDArray[np.generic]], dict[int, str], int]:
        """Return all columns, the reasons by point, and the number of impacts it took."""
        with _told(self.path):
            arrays = {name: np.asarray(self._group[name][:]) for name in self._columns}
            n_impacts = int(self._group["n_impacts"][:].sum())
            reasons: dict[int, str] = {}
            for number, (first, _) in enumerate(self.spans):
                found = self._group["reasons"][number]
                if found[0]:
                    texts = json.loads(bytes(found).rstrip(b"\0"))
                    reasons |= {first + i: text for text, those in texts for i in those}
        return arrays, dict(sorted(reasons.items())), n_impacts


def status_of_store(path: str | Path) -> dict[str, object]:
    """Return what a store holds and how much of it is done.

    Parameters
    ----------
    path
        The folder.

    Returns
    -------
    dict
        ``study`` (what makes it that study), ``version``, ``chunks``, ``done``, ``points``,
        ``n_impacts``.

    Raises
    ------
    OutputError
        If there is no store, or it is damaged.
    """
    where = Path(path)
    if not _has_store(where):
        raise OutputError(where, "no store there")
    with _told(where):
        group = _zarr().open_group(str(where), mode="r")
        own = _own(where, group)
        done = np.asarray(group["done"][:])
        return {
            "study": own["study"],
            "version": own["version"],
            "points": own["size"],
            "chunks": len(done),
            "done": int(done.sum()),
            "n_impacts": int(group["n_impacts"][:].sum()),
        }


@functools.cache
def code_hash() -> str:
    """Return a hash of the code that an answer depends on."""
    digest = hashlib.sha256()
    root = resources.files("percuss")
    for folder in CODE:
        if root.joinpath(folder).is_dir():
            for name, content in _sources(root.joinpath(folder), folder):
                digest.update(f"{name} {len(content)}\n".encode())
                digest.update(content)
    return digest.hexdigest()[:20]


def _sources(folder: Traversable, name: str) -> Iterator[tuple[str, bytes]]:
    for entry in sorted(folder.iterdir(), key=lambda entry: entry.name):
        if entry.is_dir():
            yield from _sources(entry, f"{name}/{entry.name}")
        elif entry.name.endswith(".py"):
            yield f"{name}/{entry.name}", entry.read_bytes()


def _zarr() -> Any:
    # Half a second, which only who has a store should wait.
    import zarr

    return zarr


def _has_store(path: Path) -> bool:
    return (path / "zarr.json").exists()


def _identity(job: Job) -> dict[str, Any]:
    # As it comes back from the file: tuples as lists.
    identity: dict[str, Any] = json.loads(json.dumps(job.identity()))
    return identity


def _make(path: Path, job: Job) -> Any:
    if path.exists() and (not path.is_dir() or any(path.iterdir())):
        raise OutputError(path, "exists and is no store of percuss; choose another name")
    zarr = _zarr()
    path.parent.mkdir(parents=True, exist_ok=True)
    # A group without its attributes is one that was killed while it was made: made anew.
    group = zarr.open_group(str(path), mode="w", zarr_format=3)
    n = len(chunks_of(job))
    for name, column in job.columns.items():
        group.create_array(
            name,
            shape=(job.size, *column.tail),
            chunks=(min(job.chunk, job.size), *column.tail),
            dtype=column.dtype,
            fill_value=np.nan if column.dtype == "f8" else -1,
        )
    group.create_array(
        "reasons", shape=(n, REASON_BYTES), chunks=(1, REASON_BYTES), dtype="u1", fill_value=0
    )
    group.create_array("n_impacts", shape=(n,), chunks=(1,), dtype="i8", fill_value=0)
    group.create_array("done", shape=(n,), chunks=(1,), dtype="u1", fill_value=0)
    group.attrs["percuss"] = {
        "format": FORMAT,
        "version": metadata.version("percuss"),
        "code": code_hash(),
        "size": job.size,
        "chunk": job.chunk,
        "study": _identity(job),
    }
    return group


def _open(path: Path, job: Job) -> Any:
    group = _zarr().open_group(str(path), mode="r+")
    if not dict(group.attrs) and not any(True for _ in path.glob("done/c/*")):
        return _remake(path, job)
    own = _own(path, group)
    wanted = _identity(job)
    different = [key for key in sorted({*own["study"], *wanted})
                 if own["study"].get(key) != wanted.get(key)]  # fmt: skip
    if different or (own["size"], own["chunk"]) != (job.size, job.chunk):
        what = ", ".join(different) or "the chunks"
        raise OutputError(
            path, f"holds another study, which differs in {what}; choose another name"
        )
    if own["code"] != code_hash():
        reason = (
            f"was begun by other code (percuss {own['version']}, code {own['code']}; this is "
            f"{metadata.version('percuss')}, code {code_hash()}), whose last bits may differ; finish it with that "
            "or choose another name"
        )
        raise OutputError(path, reason)
    return group


def _remake(path: Path, job: Job) -> Any:
    """Make a store again that was killed while it was made, before it held anything."""
    import shutil

    shutil.rmtree(path)
    return _make(path, job)


def _own(path: Path, group: Any) -> dict[str, Any]:
    own = group.attrs.get("percuss")
    if not isinstance(own, dict):
        raise OutputError(path, "a Zarr group, but no store of percuss; choose another name")
    if own.get("format") != FORMAT:
        raise OutputError(path, f"a store of format {own.get('format')}; this reads {FORMAT}")
    return own


def _as_bytes(reasons: dict[int, str]) -> NDArray[np.uint8]:
    """Return reasons as JSON, each text once, cut where they do not fit."""
    by_text: dict[str, list[int]] = {}
    for i, text in sorted(reasons.items()):
        by_text.setdefault(text, []).append(i)
    for longest in (None, 2000, 300, 40, 0):
        short: dict[str, list[int]] = {}
        for text, those in by_text.items():
            short.setdefault(text if longest is None else text[-longest:] if longest else "", []).extend(those)  # fmt: skip
        found = json.dumps(list(short.items())).encode()
        if len(found) <= REASON_BYTES:
            break
    return np.frombuffer(found.ljust(REASON_BYTES, b"\0"), dtype=np.uint8)


@contextlib.contextmanager
def _told(path: Path) -> Iterator[None]:
    """Say in a sentence what is wrong with a store."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        raise OutputError(path, f"{error.strerror or error}; what was finished is kept") from error
    except (ValueError, KeyError, TypeError, RuntimeError) as error:
        raise OutputError(path, f"a damaged store ({error}); choose another name") from error
