"""One process writes a store at a time; the lock of one that was killed is recognised."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path

import pytest
import xarray as xr
from tests.ensembles.studies import points_a_chunk

import percuss as pc
from percuss.ensembles import lock as lock_module
from percuss.ensembles.lock import LOCK, SILENT, StoreLock
from percuss.processes import ProcessName, this_process

OSC, FORCE = pc.impact_oscillator(restitution="0.8"), pc.cosine("2.5")


def sweep(path: Path, progress: Callable[[float, float], bool] | None = None) -> xr.Dataset:
    with points_a_chunk(1):
        return pc.sweep(
            "mean_power", OSC, FORCE, over={"start.v0": [0.5, 1.0]}, transient=2, periods=2,
            store=path, progress=progress, n_workers=1,
        )  # fmt: skip


def put(path: Path, owner: ProcessName, age: float = 0.0) -> None:
    """Write the lock of a process that has renewed it so long ago."""
    about = asdict(owner) | {"since": time.time() - 120.0}
    (path / LOCK).write_text(json.dumps(about), encoding="utf-8")
    os.utime(path / LOCK, (time.time() - age,) * 2)


def gone() -> int:
    """Return the number of a process that has ended."""
    with subprocess.Popen([sys.executable, "-c", ""]) as process:
        process.wait()
    return process.pid


def test_a_store_at_work_is_refused_to_others_and_free_after_it(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    refused: list[str] = []

    def meanwhile(done: float, total: float) -> bool:  # noqa: ARG001
        with pytest.raises(pc.OutputError) as error:
            sweep(path)
        refused.append(str(error.value))
        return False

    sweep(path, meanwhile)

    own = this_process()
    assert f"process {own.pid} (this one) on {own.host} has been writing it for" in refused[0]
    assert refused[0].count("\n") == 0
    assert not (path / LOCK).exists()
    assert sweep(path).attrs["complete"] == 1


def test_a_finished_store_is_read_by_any_number(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    done = sweep(path)
    put(path, this_process())

    assert sweep(path).identical(done)
    assert (path / LOCK).exists()


@pytest.mark.skipif(os.name != "posix", reason="signals are POSIX's")
def test_the_lock_of_a_process_that_was_killed_is_taken_over(tmp_path: Path) -> None:
    own, path = this_process(), tmp_path / "a.zarr"
    sweep(path, lambda *_: False)
    killed = ProcessName(own.host, own.machine, gone(), "")
    again = ProcessName(own.host, own.machine, own.pid, "before this process began")
    for owner in (killed, again) if own.began else (killed,):
        put(path, owner)
        lock = StoreLock(path)
        lock.acquire()
        lock.release()
        assert [file.name for file in path.glob(f"{LOCK}*")] == []
    put(path, killed)
    assert sweep(path).attrs["complete"] == 1


def test_the_lock_of_another_machine_counts_as_long_as_it_is_renewed(tmp_path: Path) -> None:
    elsewhere = ProcessName("node7", "another boot", 1234, "1")
    put(tmp_path, elsewhere, age=SILENT - 60.0)
    with pytest.raises(pc.OutputError, match=r"process 1234 on node7 .* last heard of 4 min ago"):
        StoreLock(tmp_path).acquire()

    put(tmp_path, elsewhere, age=SILENT + 60.0)
    lock = StoreLock(tmp_path)
    lock.acquire()

    owner = json.loads((tmp_path / LOCK).read_text(encoding="utf-8"))
    assert owner["pid"] == os.getpid()
    lock.release()
    assert list(tmp_path.iterdir()) == []


def test_a_lock_is_renewed_and_given_back_by_its_owner_only(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lock_module, "RENEWED", 0.0)
    lock = StoreLock(tmp_path)
    lock.acquire()
    os.utime(tmp_path / LOCK, (0.0, 0.0))
    lock.renew()
    assert (tmp_path / LOCK).stat().st_mtime > time.time() - 60.0

    put(tmp_path, ProcessName("node7", "", 1, ""))
    lock.release()
    assert (tmp_path / LOCK).exists()


@pytest.mark.parametrize("links", [True, False])
def test_of_two_that_come_at_once_one_has_the_lock(
    links: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError("no links on this file system")

    if not links:
        monkeypatch.setattr("percuss.ensembles.lock.os.link", refuse)
    first, second = StoreLock(tmp_path), StoreLock(tmp_path)
    first.acquire()
    with pytest.raises(pc.OutputError, match="one process writes a store at a time"):
        second.acquire()
    first.release()
    second.acquire()
    second.release()


def test_a_lock_that_was_cut_off_counts_until_it_is_old(tmp_path: Path) -> None:
    (tmp_path / LOCK).write_text('{"host": "no', encoding="utf-8")
    with pytest.raises(pc.OutputError, match="another process has been writing it"):
        StoreLock(tmp_path).acquire()
    os.utime(tmp_path / LOCK, (time.time() - 2.0 * SILENT,) * 2)
    StoreLock(tmp_path).acquire()
