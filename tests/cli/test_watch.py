"""What is shown of a run while it lasts, and what Ctrl-C does."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from percuss.cli import watch
from percuss.cli.watch import INTERRUPTED, Watch


def test_where_nobody_looks_the_bar_leaves_no_empty_line(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(watch, "PATIENCE", 0.0)

    with Watch() as watched:
        watched._timer.join()
        assert watched(0.5, 1.0)

    assert watched._bar is not None
    assert capfd.readouterr() == ("", "")


def test_ctrl_c_stops_the_run_and_the_next_drops_what_is_written(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with Watch() as watched:
        assert watched(0.1, 1.0)
        signal.raise_signal(signal.SIGINT)
        assert not watched(0.2, 1.0)
        for name in ("motion.nc", "impacts.csv"):
            watched.writing(Path(name))
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    assert capfd.readouterr().err == f"{INTERRUPTED}\n"


def test_ctrl_c_while_a_whole_run_is_written_drops_it(capfd: pytest.CaptureFixture[str]) -> None:
    with Watch() as watched:
        watched.writing(Path("motion.nc"))
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    assert capfd.readouterr().err == ""
