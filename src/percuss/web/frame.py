"""Answers as bytes: a header in JSON, and arrays in single precision after it."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

# Arrays begin at multiples of this, as the browser's typed arrays want it.
ALIGNED = 4


def frame(header: Mapping[str, object], arrays: Mapping[str, ArrayLike] | None = None) -> bytes:
    """Return an answer as the page reads it.

    Four bytes tell the length of the header (little endian), a multiple of 4; then the header, in
    JSON, with the names and lengths of the arrays under ``arrays``; then the arrays, float32.
    Where the header has an ``origin``, arrays called ``value...`` are counted from it, so that
    neighbours in a narrow range stay apart.

    Parameters
    ----------
    header
        Small values: numbers, texts, lists. Numbers that are not finite become null.
    arrays
        Arrays of one dimension by name.

    Returns
    -------
    bytes
        The answer.

    Examples
    --------
    >>> data = frame({"id": 7}, {"t": [0.0, 0.5]})
    >>> size = int.from_bytes(data[:4], "little")
    >>> data[4 : 4 + size].decode().strip(), len(data) - 4 - size
    ('{"id":7,"arrays":[["t",2]]}', 8)
    """
    # What is too large for single precision becomes infinite, and is left out of the picture.
    with np.errstate(over="ignore"):
        columns = {name: np.asarray(row, dtype="<f4") for name, row in (arrays or {}).items()}
    whole = {**header, "arrays": [[name, len(column)] for name, column in columns.items()]}
    text = json.dumps(_json_value(whole), separators=(",", ":"), allow_nan=False).encode()
    text += b" " * (-len(text) % ALIGNED)
    parts = [len(text).to_bytes(4, "little"), text]
    return b"".join([*parts, *(column.tobytes() for column in columns.values())])


def _json_value(value: object) -> object:
    """Return a value that JSON can hold."""
    if isinstance(value, Mapping):
        return {str(name): _json_value(part) for name, part in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_json_value(part) for part in value]
    if isinstance(value, np.generic):
        return _json_value(value.item())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
