"""What all tests of the command share."""

from __future__ import annotations

from pathlib import Path

import pytest

from percuss.cli import terminal


@pytest.fixture(autouse=True)
def _no_lines_by_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a command says does not depend on how fast the machine is."""
    monkeypatch.setattr(terminal, "PATIENCE", 3600.0)


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A command writes where it is called."""
    monkeypatch.chdir(tmp_path)
