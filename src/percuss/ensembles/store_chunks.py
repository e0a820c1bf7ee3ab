"""The files of a store's chunks: written whole, and looked at for what has befallen them.

Each file is what Zarr's codecs "bytes" and "crc32c" make of a chunk: its numbers, the little end
first, and after them the CRC-32C of those bytes, by which Zarr and we see that any of them has
changed. By Zarr itself a chunk takes 2 ms, most of them on the way to another thread and back.
"""

from __future__ import annotations

import os
import time
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.job import Column

__all__ = [
    "MARK",
    "cut_files",
    "key_of",
    "lay_down",
    "mark_of",
    "marks_in",
    "sound_chunks",
    "taken_up",
]

# Numbers of a mark: one more than the impacts of its chunk, and when it was finished [us].
MARK = 2
# Bytes of a checksum.
SUM = 4


def key_of(number: int, tail: Sequence[int]) -> str:
    """Return the name of a chunk among the files of its column, whose points have this shape."""
    return "/".join([str(number), *("0" * len(tail))])


def mark_of(n_impacts: int) -> NDArray[np.int64]:
    """Return the mark of a chunk that has been finished now."""
    return np.array([1 + n_impacts, time.time_ns() // 1000], dtype=np.int64)


def lay_down(target: Path, values: NDArray[np.generic]) -> None:
    """Write a chunk, under another name first."""
    # Only who has a store should wait for it.
    from google_crc32c import value as checksum

    part = target.with_name(f"{target.name}.{os.getpid()}.part")
    target.parent.mkdir(parents=True, exist_ok=True)
    content = values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()
    left = memoryview(content + checksum(content).to_bytes(SUM, "little"))
    try:
        # Without a file object: Ctrl-C can come between its making and its first line.
        flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0)
        file = os.open(part, flags, 0o666)
        try:
            while left:
                left = left[os.write(file, left) :]
        finally:
            os.close(file)
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def taken_up(file: Path) -> bytes | None:
    """Return what was laid down, None where there is no such file or it is not as it was."""
    from google_crc32c import value as checksum

    try:
        content = file.read_bytes()
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return None
    inner, stored = content[:-SUM], content[-SUM:]
    is_whole = len(inner) > 0 and checksum(inner).to_bytes(SUM, "little") == stored
    return inner if is_whole else None


def marks_in(path: Path, n: int) -> NDArray[np.int64]:
    """Return the marks of a store's chunks, (n, 2) array; 0 where there is none or it is damaged.

    A folder of its own for each mark would cost more than the mark: in the store they are one row.

    Parameters
    ----------
    path
        The folder of the store.
    n
        How many chunks there are.
    """
    marks = np.zeros((n, MARK), dtype=np.int64)
    folder = path / "done" / "c"
    for entry in os.scandir(folder) if folder.is_dir() else ():
        if entry.name.isdecimal() and int(entry.name) < n:
            content = taken_up(Path(entry.path))
            if content is not None and len(content) == marks[0].nbytes:
                marks[int(entry.name)] = np.frombuffer(content, dtype="<i8")
    return marks


def sound_chunks(
    path: Path,
    columns: Mapping[str, Column],
    chunk: int,
    marks: NDArray[np.int64],
    *,
    thoroughly: bool,
) -> NDArray[np.bool_]:
    """Return which chunks are marked, and have all their data.

    Parameters
    ----------
    path
        The folder of the store.
    columns
        The columns of the answer.
    chunk
        Points of a chunk.
    marks
        What `marks_in` returns.
    thoroughly
        Whether every byte is looked at; otherwise the lengths of the files alone.
    """
    sound = marks[:, 0] > 0
    sizes = {name: column.empty(chunk).nbytes for name, column in columns.items()}
    for number in np.flatnonzero(sound).tolist():
        for name, column in columns.items():
            file = path / name / "c" / key_of(number, column.tail)
            if not _is_sound(file, sizes[name], thoroughly=thoroughly):
                sound[number] = False
        reasons = path / "reasons" / "c" / str(number) / "0"
        if thoroughly and reasons.exists() and taken_up(reasons) is None:
            sound[number] = False
    return sound


def _is_sound(file: Path, size: int, *, thoroughly: bool) -> bool:
    if thoroughly:
        content = taken_up(file)
        return content is not None and len(content) == size
    try:
        return file.stat().st_size == size + SUM
    except (FileNotFoundError, NotADirectoryError):
        return False


def cut_files(path: Path) -> list[str]:
    """Return which descriptions in a store are no JSON any more, the store's own first."""
    import json

    found = []
    for file in (path / "zarr.json", *sorted(path.glob("*/zarr.json"))):
        try:
            json.loads(file.read_bytes())
        except ValueError:
            found.append(str(file.relative_to(path)))
        except OSError:
            continue
    return found
