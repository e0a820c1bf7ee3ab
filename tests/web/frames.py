"""What the page sends to the server, and reading its frames as the page does."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from numpy.typing import NDArray


def read_frame(data: bytes) -> tuple[dict[str, Any], dict[str, NDArray[np.floating[Any]]]]:
    """Return header and arrays."""
    size = int.from_bytes(data[:4], "little")
    header = json.loads(data[4 : 4 + size])
    arrays: dict[str, NDArray[np.floating[Any]]] = {}
    at = 4 + size
    for name, length in header["arrays"]:
        arrays[name] = np.frombuffer(data, "<f4", length, at)
        at += 4 * length
        if name.startswith("value") and "origin" in header:
            arrays[name] = arrays[name] + np.float64(header["origin"])
    assert at == len(data)
    return header, arrays


def motion_tables(periods: int) -> dict[str, Any]:
    """Return the tables of a motion, as the page sends them."""
    return {
        "oscillator": {
            "stiffness": 1,
            "damping": "0.05",
            "stops": [{"type": "wall", "at": "0.2", "side": "above", "restitution": "0.8"}],
        },
        "forcing": {"harmonics": [{"amplitude": 1, "omega": "2.8", "phase": 0}]},
        "start": {"x0": 0, "v0": "0.5"},
        "run": {"periods": periods},
    }
