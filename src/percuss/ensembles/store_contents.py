"""What is in a store: the answer as far as it has come."""

from __future__ import annotations

import json
import math
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.job import Answer, Column
from percuss.ensembles.sizes import too_large
from percuss.ensembles.store_chunks import key_of, marks_in, taken_up

__all__ = ["REASON_BYTES", "contents", "reasons_as_bytes"]

# Room for the reasons of a chunk: what does not fit is cut off.
REASON_BYTES = 1 << 18


def contents(
    path: Path,
    group: Mapping[str, Any],
    columns: Mapping[str, Column],
    spans: Sequence[tuple[int, int]],
) -> Answer:
    """Return what has been done; NaN and -1 elsewhere.

    Parameters
    ----------
    path
        The folder of the store.
    group
        Its arrays, of which that of the reasons is read through Zarr.
    columns
        Those of them that are the answer.
    spans
        First and last point of each chunk, the last not included.
    """
    marks = marks_in(path, len(spans))
    chunk = spans[0][1] - spans[0][0]
    size = spans[-1][1]
    arrays = {name: _empty(path, column, size) for name, column in columns.items()}
    reasons: dict[int, str] = {}
    for number in np.flatnonzero(marks[:, 0]).tolist():
        first, last = spans[number]
        block = _block(path, columns, number, chunk)
        texts = _reasons(path, group, number)
        if block is None or texts is None:
            # What has been damaged since is not done.
            marks[number] = 0
            continue
        for name, values in block.items():
            arrays[name][first:last] = values[: last - first]
        reasons |= {first + i: text for i, text in texts.items()}
    done = marks[:, 0]
    for number in np.flatnonzero(done == 0).tolist():
        first, last = spans[number]
        for name, column in columns.items():
            arrays[name][first:last] = column.empty(last - first)
    n_impacts = int(done.sum() - np.count_nonzero(done))
    complete = bool((done > 0).all())
    return Answer(arrays, dict(sorted(reasons.items())), n_impacts, complete=complete)


def _empty(path: Path, column: Column, size: int) -> NDArray[np.generic]:
    """Return room for a column, in a nameless file beside it where memory has none."""
    shape = (size, *column.tail)
    if too_large([size], math.prod(column.tail)) is None:
        return np.empty(shape, dtype=column.dtype)
    with tempfile.TemporaryFile(dir=path) as file:
        return np.memmap(file, dtype=column.dtype, mode="w+", shape=shape)


def _block(
    path: Path, columns: Mapping[str, Column], number: int, chunk: int
) -> dict[str, NDArray[np.generic]] | None:
    """Return the data of a chunk, None where a part is missing or is not as it was written."""
    found: dict[str, NDArray[np.generic]] = {}
    for name, column in columns.items():
        content = taken_up(path / name / "c" / key_of(number, column.tail))
        expected = chunk * math.prod(column.tail) * np.dtype(column.dtype).itemsize
        if content is None or len(content) != expected:
            return None
        values = np.frombuffer(content, dtype=np.dtype(column.dtype).newbyteorder("<"))
        found[name] = values.reshape(chunk, *column.tail)
    return found


def _reasons(path: Path, group: Mapping[str, Any], number: int) -> dict[int, str] | None:
    """Return the reasons of a chunk by its points, None where they are not as they were written."""
    file = path / "reasons" / "c" / str(number) / "0"
    # Of most chunks there is no file.
    if not file.exists():
        return {}
    if taken_up(file) is None:
        return None
    found = bytes(group["reasons"][number]).rstrip(b"\0")
    return {i: text for text, those in json.loads(found) for i in those} if found else {}


def reasons_as_bytes(reasons: dict[int, str]) -> NDArray[np.uint8]:
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
