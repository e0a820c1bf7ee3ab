"""`percuss run` with studies of every kind: what is said, and stores that are interrupted."""

from __future__ import annotations

import os
import signal
import sys
import time
import warnings
from pathlib import Path

import pytest
from tests.children import begun, interrupt
from tests.cli.commands import percuss
from tests.studies.texts import WALL_ABOVE

import percuss as pc
from percuss.cli.terminal import ProgressBar
from percuss.io import load_netcdf

MODEL = f"{WALL_ABOVE}[draw]\npng = false\n"
BRANCH = f'{MODEL}[study]\nkind = "branch"\n[over]\n"forcing.amplitude" = [1, "0.09"]\n'
BASINS = f"""\
{MODEL}
[study]
kind = "basins"
[basins]
x0 = {{from = -3, to = 1, count = 700}}
v0 = {{from = -3, to = 3, count = 700}}
"""


@pytest.fixture(autouse=True)
def _with_studies() -> None:
    Path("branch.toml").write_text(BRANCH)
    Path("basins.toml").write_text(BASINS)


def test_a_branch_is_reported_with_its_special_points() -> None:
    status, out, err = percuss("run", "branch.toml")

    assert (status, err) == (0, "")
    assert "special points  fold at 0.0999707536283 (located): two orbits meet and end" in out
    assert "                grazing at 0.1 (located): an impact on stop 0 has no velocity" in out
    assert len(load_netcdf("branch/branch.nc").special_points) >= 2


def test_a_store_or_an_engine_for_one_orbit_is_one_sentence() -> None:
    assert percuss("run", "branch.toml", "--store", "a.zarr") == (
        2,
        "",
        "store = 'a.zarr': for studies of many motions and of fits; this one is of kind branch\n",
    )
    assert percuss("run", "branch.toml", "--engine", "processes")[0] == 2
    assert not Path("branch").exists()


def test_an_engine_that_is_none_is_one_sentence() -> None:
    status, out, err = percuss("run", "basins.toml", "--engine", "thread")

    assert (status, out) == (2, "")
    assert err.startswith('engine = \'thread\': neither "threads" nor "processes"')
    assert err.count("\n") == 1
    assert not Path("basins").exists()


def test_no_orbit_is_one_sentence() -> None:
    text = BRANCH.replace('damping = "0.05"', "damping = 9").replace("at = 1", "at = 1000")
    Path("branch.toml").write_text(text)

    status, out, err = percuss("run", "branch.toml")

    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert "no orbit with 1 impact in 1 forcing period found" in err


def test_sigterm_is_told_where_a_store_is_kept(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = ProgressBar.__call__

    def terminated(bar: ProgressBar, done: float, total: float) -> bool:
        if done > 0 and not bar.is_stopped:
            signal.raise_signal(signal.SIGTERM)
        return real(bar, done, total)

    monkeypatch.setattr(ProgressBar, "__call__", terminated)
    status, _, err = percuss("run", "basins.toml", "--store", "run.zarr")

    assert status == 143
    assert err.endswith("ended by SIGTERM; the same command goes on with run.zarr\n")


def test_ctrl_c_leaves_a_store_that_the_same_command_goes_on_with(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "percuss", "run", "basins.toml", "--store", "run.zarr"]
    with begun(command, env={**os.environ, "COLUMNS": "200"}) as process:
        # The first chunk that is done says that the work has begun.
        while process.poll() is None and not list(tmp_path.glob("run.zarr/done/c/*")):
            time.sleep(0.05)
        interrupt(process)
        out, err = process.communicate(timeout=120)

    assert process.returncode == 130, err
    assert "files" not in out
    assert err.endswith("interrupted; the same command goes on with run.zarr\n")
    assert not Path("basins").exists()
    status = pc.status_of_store("run.zarr")
    assert 0 < status["points_done"] < status["points"]


def test_a_warning_of_a_run_is_one_sentence(tmp_path: Path) -> None:
    study = tmp_path / "s.toml"
    own = '[study]\nkind = "sweep"\n[over]\n"start.x0" = [2, 3]\n[sweep]\nmeasure = "period"\n'
    study.write_text(MODEL + own, encoding="utf-8")

    with warnings.catch_warnings():
        warnings.simplefilter("default")
        status, _, err = percuss("run", str(study), "--out", str(tmp_path / "out"))

    assert status == 0
    lines = [line for line in err.splitlines() if "warning" in line]
    assert len(lines) == 1
    assert lines[0].startswith("warning: period has no answer for any of 2 points; ")
    assert "UserWarning" not in err
