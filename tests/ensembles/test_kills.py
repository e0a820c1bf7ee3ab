"""Killed at random times, beside other people's data, a store loses nothing and ends the same."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.ensembles.killed_study import study

import percuss as pc

ROOT = Path(__file__).parents[2]
FEW, MANY = 1, 100
# Within so many seconds from where the work begins a child is killed.
WITHIN = 1.5
OTHERS = ("notes.txt", "a.zarr/notes.txt", "a.zarr/impacts_per_period/c/notes.txt")

pytestmark = [
    pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's"),
    pytest.mark.filterwarnings("ignore:.* have no answer"),
]


def kill_and_resume(folder: Path, kills: int, seed: int) -> Counter[str]:
    """Kill studies again and again; return how often each signal met one that had work left."""
    random = np.random.default_rng(seed)
    expected = study(None)
    met: Counter[str] = Counter()
    number = 0
    while sum(met.values()) < kills:
        here = folder / str(number)
        here.mkdir(exist_ok=True)
        sent = signal.SIGKILL if random.random() < 0.7 else signal.SIGINT
        code = run_child(here / "a.zarr", random.uniform(0.0, WITHIN), sent)
        put_others(here)
        is_done = code == 0 and left(here / "a.zarr") == 0
        if not is_done:
            met[sent.name] += 1
            # It was killed, or has heard Ctrl-C and ended with what was done.
            assert code in (0, 1, -signal.SIGKILL, -signal.SIGINT)
            if random.random() < 0.8:
                continue
        check(here, expected)
        number += 1
    check(folder / str(number), expected)
    return met


def run_child(store: Path, seconds: float, sent: signal.Signals) -> int:
    command = [sys.executable, "-m", "tests.ensembles.killed_study", str(store), str(seconds)]
    with subprocess.Popen(
        [*command, str(int(sent))], cwd=ROOT, start_new_session=True, stderr=subprocess.PIPE
    ) as child:
        try:
            child.communicate(timeout=120)
        finally:
            if child.poll() is None:
                os.killpg(child.pid, signal.SIGKILL)
    return child.returncode


def left(store: Path) -> int:
    status = pc.status_of_store(store)
    return int(status["points"] - status["points_done"])


def put_others(here: Path) -> None:
    """Put files of somebody else's beside a store and into it, where there is room for them."""
    for name in OTHERS:
        if (here / name).parent.is_dir() and (here / "a.zarr" / "zarr.json").exists():
            (here / name).write_text(name, encoding="utf-8")


def check(here: Path, expected: xr.Dataset) -> None:
    """Finish a study, hold it against one that was never killed, and see that all files are there."""
    here.mkdir(exist_ok=True)
    before = [name for name in OTHERS if (here / name).exists()]
    assert study(here / "a.zarr").identical(expected)
    assert pc.load_store(here / "a.zarr").identical(expected)
    assert [name for name in OTHERS if (here / name).exists()] == before
    assert all((here / name).read_text(encoding="utf-8") == name for name in before)


def test_killed_at_random_times_a_store_ends_with_the_same_bits(tmp_path: Path) -> None:
    assert sum(kill_and_resume(tmp_path, FEW, seed=1).values()) == FEW


@pytest.mark.nightly
def test_killed_a_hundred_times_stores_end_with_the_same_bits(tmp_path: Path) -> None:
    met = kill_and_resume(tmp_path, MANY, seed=2)

    assert sum(met.values()) == MANY
    assert set(met) == {"SIGKILL", "SIGINT"}
