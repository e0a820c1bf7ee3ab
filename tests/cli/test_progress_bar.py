"""What is shown of a run while it lasts, and what Ctrl-C does."""

from __future__ import annotations

import signal
import time
from pathlib import Path

import pytest

from percuss.cli import terminal
from percuss.cli.terminal import (
    INTERRUPTED,
    STARTING,
    TERMINATED,
    WRITING,
    ProgressBar,
    Terminated,
)


def test_a_log_gets_lines_by_the_clock_from_the_start_on(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(terminal, "PATIENCE", 0.0)
    monkeypatch.setattr(terminal, "RENEWED_IN_A_LOG", 0.01)

    def next_line() -> str:
        while not (text := capfd.readouterr().err):
            time.sleep(0.01)
        return text.splitlines()[-1]

    with ProgressBar("measuring [x]") as watched:
        # Nothing is reported: the engine compiles.
        assert next_line() == f"{STARTING}, 0 s so far"
        assert watched(0.5, 2.0)
        capfd.readouterr()
        # A line of the clock may have been under way.
        while (line := next_line()).startswith(STARTING):
            pass
        assert line == "measuring [x]  25.0%, 0 s so far"
        watched.writing(Path("motion.nc"))
        capfd.readouterr()
        assert next_line() == "writing motion.nc, 0 s so far"

    assert watched._bar is None
    capfd.readouterr()
    assert capfd.readouterr() == ("", "")


def test_a_short_run_leaves_no_line(capfd: pytest.CaptureFixture[str]) -> None:
    with ProgressBar() as watched:
        assert watched(0.5, 1.0)

    assert not watched._clock.is_alive()
    assert capfd.readouterr() == ("", "")


def test_ctrl_c_stops_the_run_and_the_next_drops_what_is_written(
    capfd: pytest.CaptureFixture[str],
) -> None:
    with ProgressBar() as watched:
        assert watched(0.1, 1.0)
        signal.raise_signal(signal.SIGINT)
        assert not watched(0.2, 1.0)
        for name in ("motion.nc", "impacts.csv"):
            watched.writing(Path(name))
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    assert capfd.readouterr().err == f"{INTERRUPTED}\n"


def test_ctrl_c_while_a_whole_run_is_written_drops_it(capfd: pytest.CaptureFixture[str]) -> None:
    with ProgressBar() as watched:
        watched.writing(Path("motion.nc"))
        with pytest.raises(KeyboardInterrupt):
            signal.raise_signal(signal.SIGINT)

    assert capfd.readouterr().err == ""


def test_sigterm_stops_the_run_and_lets_its_files_be_finished(
    capfd: pytest.CaptureFixture[str],
) -> None:
    before = signal.getsignal(signal.SIGTERM)
    with ProgressBar() as stopped:
        signal.raise_signal(signal.SIGTERM)
        assert not stopped(0.2, 1.0)
        stopped.writing(Path("motion.nc"))
        with pytest.raises(Terminated):
            signal.raise_signal(signal.SIGTERM)
    with ProgressBar() as whole:
        whole.writing(Path("motion.nc"))
        signal.raise_signal(signal.SIGTERM)
        assert whole.signal == signal.SIGTERM

    assert capfd.readouterr().err == f"{TERMINATED}\n{WRITING}\n"
    assert signal.getsignal(signal.SIGTERM) is before


def test_sigterm_ends_chunks_as_ctrl_c_does() -> None:
    with ProgressBar(of_chunks=True) as watched:
        for number in (signal.SIGTERM, signal.SIGINT):
            with pytest.raises(KeyboardInterrupt):
                signal.raise_signal(number)

    assert watched.signal == signal.SIGTERM


def test_lines_name_the_study_or_the_part_and_quiet_shows_none(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(terminal, "PATIENCE", 0.0)
    with ProgressBar("measuring", name="part 3/100", is_quiet=True) as quiet:
        quiet(1.0, 2.0)
        assert not quiet._clock.is_alive()
    assert capfd.readouterr().err == ""
    with ProgressBar("measuring", name="part 3/100") as shown:
        shown(1.0, 2.0)
        while not (text := capfd.readouterr().err):
            time.sleep(0.01)
    assert text.startswith("part 3/100: ")
