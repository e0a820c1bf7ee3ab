"""`percuss prove` writes certificates, and says what has none."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from typer.testing import CliRunner

from percuss.cli import app
from percuss.studies import template_text

CHAOTIC = """\
[[oscillator.stops]]
type = "wall"
at = 0
side = "below"
restitution = "4/5"
[[forcing.harmonics]]
amplitude = 1
omega = "14/5"
[start]
x0 = 0
v0 = "1/2"
[run]
max_impacts = 4
"""


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("study.toml").write_text(CHAOTIC)


def prove(*arguments: str) -> tuple[int, str, str]:
    result = CliRunner().invoke(app, ["prove", *arguments])
    assert result.exception is None or isinstance(result.exception, SystemExit)
    return result.exit_code, result.stdout, result.stderr


def test_the_motion_of_a_study_has_a_certificate_beside_it() -> None:
    status, out, _ = prove("study.toml")

    assert status == 0
    assert "4 impacts" in out
    assert "check it with: python tools/check_certificate.py study.certificate.json" in out
    claims = json.loads(Path("study.certificate.json").read_text())
    assert claims["kind"] == "run"
    assert len(claims["events"]) == 4
    status, _, err = prove("study.toml")
    assert (status, err) == (2, "study.certificate.json: exists already; --force replaces it\n")
    assert prove("study.toml", "--force", "--set", "run.max_impacts=2")[0] == 0
    assert len(json.loads(Path("study.certificate.json").read_text())["events"]) == 2


def test_the_branch_of_a_study_has_a_certificate() -> None:
    model = CHAOTIC.split("[start]", maxsplit=1)[0].replace("14/5", "5/2")
    question = '[study]\nkind = "branch"\n[over]\n"forcing.omega" = [2.5, 2.51]\n'
    Path("study.toml").write_text(model + question)

    status, out, _ = prove("study.toml")

    assert status == 0
    assert "from end to end" in out
    claims = json.loads(Path("study.certificate.json").read_text())
    assert claims["kind"] == "branch"
    assert claims["law"]["tones"][0]["omega"] == ["0", "1"]


@pytest.mark.nightly  # tests/certified/test_certificates.py proves it by Python
def test_chaos_of_the_studys_system() -> None:
    status, out, _ = prove("study.toml", "--chaos", "--out", "chaos.json")

    assert status == 0
    assert "topological entropy >= 0.214584" in out
    assert json.loads(Path("chaos.json").read_text())["kind"] == "chaos"


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        (CHAOTIC.replace("max_impacts = 4", "t_end = 1"), (), "the run meets no stop"),
        (template_text("sweep"), (), "not of kind motion, orbit or branch, which alone"),
        (template_text("structure"), (), "of a structure, of which there are no proofs"),
        (
            CHAOTIC.split("[[forcing", maxsplit=1)[0] + "[start]\nx0 = 1\nv0 = 0\n[run]\nt_end = 1",
            ("--chaos",),
            "without forcing",
        ),
        (CHAOTIC, ("--digits", "0"), "digits = 0"),
        (CHAOTIC.replace("4/5", "2"), (), "restitution"),
    ],
)
def test_what_has_no_certificate_is_one_sentence(
    text: str, options: tuple[str, ...], said: str
) -> None:
    Path("study.toml").write_text(text)

    status, _, err = prove("study.toml", *options)

    assert status == 2
    assert said in err
    assert "Traceback" not in err
    assert not Path("study.certificate.json").exists()
