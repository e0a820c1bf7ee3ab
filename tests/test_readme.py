"""What the README shows runs, and what it points to is there."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_code_of_the_readme_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    blocks = re.findall(r"```python\n(.*?)```", README, flags=re.DOTALL)

    for block in blocks:
        exec(compile(block, "README.md", "exec"), {})  # noqa: S102  our own text

    assert len(blocks) == 5
    assert capsys.readouterr().out.count("Trajectory") == 4
    assert (tmp_path / "portrait.png").stat().st_size > 10_000


def test_the_files_that_the_readme_names_exist() -> None:
    linked = re.findall(r"\]\(([^)#]+)\)", README)

    assert linked
    assert [name for name in linked if not (ROOT / name).exists()] == []
