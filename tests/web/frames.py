"""Reading the frames of the server, as the page does."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray


def read_frame(data: bytes) -> tuple[dict[str, Any], dict[str, NDArray[np.float32]]]:
    """Return header and arrays."""
    size = int.from_bytes(data[:4], "little")
    header = json.loads(data[4 : 4 + size])
    arrays, at = {}, 4 + size
    for name, length in header["arrays"]:
        arrays[name] = np.frombuffer(data, "<f4", length, at)
        at += 4 * length
    assert at == len(data)
    return header, arrays
