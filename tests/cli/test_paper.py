"""The command `percuss paper`."""

from __future__ import annotations

import sys
import time
from pathlib import Path

from tests.children import begun, interrupt
from tests.cli.commands import percuss


def paper(*arguments: str) -> tuple[int, str, str]:
    return percuss("paper", *arguments)


def test_it_writes_the_report_and_prints_the_verdicts() -> None:
    status, out, err = paper("--only", "fig9,eq12")

    assert (status, err) == (0, "")
    assert Path("percuss-paper/index.html").stat().st_size > 20_000
    assert "1 figure: fig9" in out
    assert "(12)" in out
    assert "2 statements: 1 holds, 1 corrected, 0 fails, 0 undecided" in out
    assert "percuss-paper/index.html and claims.json" in out
    assert "percuss paper --only fig9,eq12" in Path("percuss-paper/fig9.csv").read_text()


def test_an_unknown_name_is_one_sentence_with_a_hint() -> None:
    status, out, err = paper("--only", "fig16")

    assert (status, out) == (2, "")
    assert err.startswith("only = 'fig16': no figure or statement; did you mean \"fig")
    assert err.count("\n") == 1
    assert not Path("percuss-paper").exists()


def test_a_folder_that_is_not_empty_is_refused_without_force() -> None:
    Path("out").mkdir()
    Path("out/mine").write_text("mine")

    assert paper("--only", "fig9", "--out", "out") == (
        2,
        "",
        "out: the folder is not empty; --force writes into it\n",
    )
    assert paper("--only", "fig9", "--out", "out", "--force")[0] == 0
    assert Path("out/mine").read_text() == "mine"


def test_a_folder_that_cannot_be_written_is_one_sentence() -> None:
    Path("file").write_text("")

    assert paper("--only", "fig9", "--out", "file/out") == (
        2,
        "",
        "file: is a file, not a folder; rename it, or name another folder\n",
    )


def test_ctrl_c_keeps_the_finished_figures_and_a_report(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "percuss", "paper", "--out", "out"]
    with begun(command, cwd=tmp_path) as process:
        for _ in range(2400):
            if list(tmp_path.glob("out/*.svg")):
                break
            time.sleep(0.1)
        interrupt(process)
        out, err = process.communicate(timeout=120)

    assert process.returncode == 130
    assert "Traceback" not in err
    assert "missing" in out
    assert "interrupted" in (tmp_path / "out/index.html").read_text()
    assert list(tmp_path.glob("out/*.svg"))
    assert not list(tmp_path.glob("out/.*.part"))
