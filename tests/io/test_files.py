"""Files appear whole or not at all, and replace nothing unasked."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import pytest

import percuss as pc
from percuss.errors import OutputError
from percuss.io import OutputFiles, check_output, save_csv, save_netcdf
from percuss.io.table import check_suffix


def everything_in(folder: Path) -> list[str]:
    return sorted(str(path.relative_to(folder)) for path in folder.rglob("*"))


def test_files_appear_together_at_the_end(tmp_path: Path) -> None:
    a, b = tmp_path / "new" / "a.txt", tmp_path / "new" / "b.txt"

    with OutputFiles(a, b) as files:
        files[a].write_text("a")
        files[b].write_text("b")
        assert not a.exists()
        assert not b.exists()

    assert everything_in(tmp_path) == ["new", "new/a.txt", "new/b.txt"]
    assert (a.read_text(), b.read_text()) == ("a", "b")


@pytest.mark.parametrize("reason", [ValueError("bad"), KeyboardInterrupt(), MemoryError()])
def test_an_interrupted_group_leaves_neither_file_nor_folder(
    tmp_path: Path, reason: BaseException
) -> None:
    a, b = tmp_path / "x" / "y" / "a.txt", tmp_path / "b.txt"

    def write_half() -> None:
        with OutputFiles(a, b) as files:
            files[a].write_text("half")
            raise reason

    with pytest.raises(type(reason)):
        write_half()

    assert everything_in(tmp_path) == []


def test_what_the_system_refuses_is_one_sentence(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"

    def fill_the_disk() -> None:
        with OutputFiles(path) as files:
            files[path].write_text("half")
            raise OSError(28, "No space left on device")

    with pytest.raises(OutputError) as caught:
        fill_the_disk()

    assert str(caught.value) == f"{tmp_path}: no space left on device"
    assert everything_in(tmp_path) == []


def test_an_existing_file_is_refused_and_keeps_its_bytes(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"
    path.write_text("precious")

    with pytest.raises(OutputError, match="exists already; force=True"), OutputFiles(path):
        pytest.fail("the block must not be entered")

    assert path.read_text() == "precious"


def test_force_replaces_the_named_files_and_no_others(tmp_path: Path) -> None:
    path, other = tmp_path / "a.txt", tmp_path / "other.txt"
    path.write_text("old")
    other.write_text("mine")

    with OutputFiles(path, force=True) as files:
        files[path].write_text("new")

    assert path.read_text() == "new"
    assert other.read_text() == "mine"


def test_a_file_that_appears_during_the_work_is_not_replaced(tmp_path: Path) -> None:
    path = tmp_path / "a.txt"

    def write_while_another_does() -> None:
        with OutputFiles(path) as files:
            files[path].write_text("ours")
            path.write_text("theirs")

    with pytest.raises(OutputError, match="exists already"):
        write_while_another_does()

    assert path.read_text() == "theirs"
    assert everything_in(tmp_path) == ["a.txt"]


def test_a_folder_in_which_something_else_appeared_stays(tmp_path: Path) -> None:
    path = tmp_path / "new" / "a.txt"

    def fail_beside_another_file() -> None:
        with OutputFiles(path) as files:
            files[path].write_text("ours")
            (tmp_path / "new" / "theirs.txt").write_text("theirs")
            raise ValueError("bad")

    with pytest.raises(ValueError, match="bad"):
        fail_beside_another_file()

    assert everything_in(tmp_path) == ["new", "new/theirs.txt"]


def test_a_folder_below_a_file_is_refused_before_any_work(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")

    with pytest.raises(OutputError) as caught:
        check_output([tmp_path / "file" / "out" / "a.txt"])

    assert (
        str(caught.value)
        == f"{tmp_path / 'file'}: is a file, not a folder; rename it, or name another folder"
    )


def test_a_folder_in_the_place_of_a_file_is_refused_even_with_force(tmp_path: Path) -> None:
    (tmp_path / "a.txt").mkdir()

    with pytest.raises(OutputError, match="is a folder"):
        check_output([tmp_path / "a.txt"], force=True)


def test_a_folder_without_permission_is_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # The superuser, as whom tests may run, is refused nothing.
    monkeypatch.setattr("percuss.io.files.os.access", lambda *_: False)

    with pytest.raises(OutputError) as caught:
        check_output([tmp_path / "out" / "a.txt"])

    assert str(caught.value) == f"{tmp_path}: the folder cannot be written to"


def test_a_name_that_the_system_cannot_take_is_one_sentence(tmp_path: Path) -> None:
    with pytest.raises(OutputError, match="name too long"):
        check_output([tmp_path / ("x" * 5000)])


def test_what_a_killed_run_left_is_removed_by_the_next(tmp_path: Path) -> None:
    killed = subprocess.Popen([sys.executable, "-c", ""])
    killed.wait()
    stale = tmp_path / f".a.txt.{killed.pid}.part"
    running, other, elsewhere = (
        tmp_path / f".a.txt.{os.getppid()}.part",
        tmp_path / f".b.txt.{killed.pid}.part",
        # Of another machine, where there is such a process.
        tmp_path / f".a.txt.{10**9}.part",
    )
    for path in (stale, running, other, elsewhere):
        path.write_text("half")
    for path in (stale, running, other):
        os.utime(path, (time.time() - 4000.0,) * 2)

    with OutputFiles(tmp_path / "a.txt") as files:
        files[tmp_path / "a.txt"].write_text("whole")

    assert everything_in(tmp_path) == sorted(["a.txt", running.name, other.name, elsewhere.name])


def test_the_size_of_a_large_file_is_announced_before_it_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    run = pc.simulate(pc.impact_oscillator(0.9), pc.cosine(2.8), v0=1.0, periods=400)
    save_csv(run, tmp_path / "small.csv")
    assert caplog.messages == []
    monkeypatch.setattr("percuss.io.files.LARGE", 10_000)

    save_csv(run, tmp_path / "run.csv")
    save_netcdf(run, tmp_path / "run.nc", samples=2001)

    reported = re.findall(r"writing (\S+): about (\d+) MB", caplog.text)
    assert [name for name, _ in reported] == ["run.csv", "run.nc"]


def test_the_announced_size_is_that_of_the_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    run = pc.simulate(pc.impact_oscillator(0.9), pc.cosine(2.8), v0=1.0, periods=4000)
    sizes: dict[str, int] = {}
    for module in ("table", "netcdf"):
        monkeypatch.setattr(
            f"percuss.io.{module}.say_size", lambda part, size: sizes.update({part.name[:5]: size})
        )

    save_csv(run, tmp_path / "a.csv")
    save_netcdf(run, tmp_path / "b.nc")

    for name, part in (("a.csv", ".a.cs"), ("b.nc", ".b.nc")):
        assert sizes[part] == pytest.approx((tmp_path / name).stat().st_size, rel=0.2)


@pytest.mark.parametrize(
    ("given", "right"),
    [
        ("r", "r.csv"),
        ("r.", "r.csv"),
        ("r.mat", "r.csv"),
        ("run.2.txt", "run.2.csv"),
        ("", "result.csv"),
    ],
)
def test_the_name_that_a_file_should_have_is_told(given: str, right: str) -> None:
    with pytest.raises(OutputError) as caught:
        check_suffix(given, ".csv")
    assert str(caught.value).endswith(f"call it {right}")
