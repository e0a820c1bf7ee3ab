"""A study of a second or so that kills its own process after a while: STORE SECONDS SIGNAL."""

from __future__ import annotations

import os
import signal
import sys
import threading
from pathlib import Path

import numpy as np
import xarray as xr
from tests.ensembles.studies import points_a_chunk

import percuss as pc


def study(store: Path | None) -> xr.Dataset:
    """Return three measures of 40 x 30 points, in 60 chunks; some points have no motion."""
    with points_a_chunk(20):
        return pc.sweep(
            ["impacts_per_period", "growth_exponent", "largest_lyapunov_exponent"],
            pc.impact_oscillator(restitution="0.8"),
            pc.cosine(2.5),
            over={"forcing.omega": np.linspace(2.0, 3.0, 40), "start.x0": np.linspace(-0.1, 1, 30)},
            transient=1000,
            periods=200,
            store=store,
        )


def kill_later(seconds: float, number: int) -> None:
    """Send a signal to this process after a while."""
    timer = threading.Timer(seconds, os.kill, (os.getpid(), number))
    timer.daemon = True
    timer.start()


if __name__ == "__main__":
    # Whoever has begun this in the background may have it ignored.
    signal.signal(signal.SIGINT, signal.default_int_handler)
    kill_later(float(sys.argv[2]), int(sys.argv[3]))
    study(Path(sys.argv[1]))
