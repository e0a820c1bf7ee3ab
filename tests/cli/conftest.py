"""What all tests of the command share."""

from __future__ import annotations

import pytest

from percuss.cli import terminal


@pytest.fixture(autouse=True)
def _no_lines_by_the_clock(monkeypatch: pytest.MonkeyPatch) -> None:
    """What a command says does not depend on how fast the machine is."""
    monkeypatch.setattr(terminal, "PATIENCE", 3600.0)
