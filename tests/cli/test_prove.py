"""`percuss prove` writes certificates, and says what has none."""

from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path

import pytest
from tests.cli.commands import percuss
from tests.studies.texts import WALL_BELOW

import percuss as pc
from percuss.studies import template_text

CHAOTIC = f"""\
{WALL_BELOW.format(restitution="4/5", omega="14/5")}\
[start]
x0 = 0
v0 = "1/2"
[run]
max_impacts = 4
"""


@pytest.fixture(autouse=True)
def _with_studies() -> None:
    Path("study.toml").write_text(CHAOTIC)


def prove(*arguments: str) -> tuple[int, str, str]:
    return percuss("prove", *arguments)


def test_the_motion_of_a_study_has_a_certificate_beside_it() -> None:
    status, out, _ = prove("study.toml")

    assert status == 0
    assert "4 impacts" in out
    assert "check it with: python tools/check_certificate study.certificate.json" in out
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


def test_a_special_point_of_a_branch_has_a_certificate_by_itself() -> None:
    model = CHAOTIC.split("[start]", maxsplit=1)[0].replace("14/5", "5/2")
    question = '[study]\nkind = "branch"\n[over]\n"forcing.omega" = [2.5, 2.7]\n'
    Path("branch.toml").write_text(model + question)

    status, out, _ = prove("branch.toml", "--point", "1")

    assert status == 0
    assert "period_doubling at forcing.harmonics.0.omega = [2.65334772785532" in out
    (curve,) = json.loads(Path("branch.certificate.json").read_text())["curves"]
    assert [point["kind"] for point in curve["points"]] == ["period_doubling"]
    for study, number, reason in (
        ("branch.toml", "2", "the branch has 1 special point"),
        ("study.toml", "1", "a special point of a branch; the study has none"),
    ):
        status, _, err = prove(study, "--point", number, "-f")
        assert status == 2
        assert reason in err


def test_all_orbits_of_the_studys_system_have_a_certificate() -> None:
    status, out, _ = prove("study.toml", "--list", "1", "1", "--speeds", "1/5", "3", "-o", "a.json")

    assert status == 0
    assert "all that there are with speeds 0.2 to 3" in out
    claims = json.loads(Path("a.json").read_text())
    assert (claims["kind"], claims["impacts"], claims["periods"]) == ("list", 1, 1)
    assert claims["speeds"] == ["1/5", "3"]
    # Speeds from the orbits that a search finds.
    assert prove("study.toml", "--list", "1", "1", "-o", "b.json")[0] == 0
    (orbit,) = pc.find_orbits(pc.impact_oscillator("4/5"), pc.cosine("14/5"), 1, 1)
    low, high = (float(Fraction(v)) for v in json.loads(Path("b.json").read_text())["speeds"])
    assert 5.0 * low < orbit.impacts.v_after[0] < high < 2.0 * orbit.impacts.v_after[0]


def test_the_basins_of_a_study_have_a_certificate() -> None:
    model = CHAOTIC.split("[start]", maxsplit=1)[0].replace("14/5", "11/5").replace("4/5", "3/5")
    axes = "x0 = {from = 0.1, to = 0.3, count = 3}\nv0 = [0.25, 0.4]\n"
    Path("study.toml").write_text(f'{model}[study]\nkind = "basins"\n[basins]\n{axes}')

    status, out, _ = prove("study.toml")

    assert status == 0
    assert "2 cells, proven basins of 100.0 % of the area" in out
    claims = json.loads(Path("study.certificate.json").read_text())
    assert claims["kind"] == "basins"
    (cell,) = claims["cells"]
    assert [float(Fraction(x)) for x in cell["x"]] == [0.1, 0.3]
    # Of starts on the wall there are none.
    Path("study.toml").write_text(
        f'{model}[study]\nkind = "basins"\n[basins]\ncycle = [0, 0.5]\nv = [0.25, 0.4]\n'
    )
    status, _, err = prove("study.toml", "--force")
    assert status == 2
    assert "of starts on a wall" in err


@pytest.mark.nightly  # tests/certified/test_chaos_certificates.py proves it by Python
def test_chaos_of_the_studys_system() -> None:
    status, out, _ = prove("study.toml", "--chaos", "--out", "chaos.json")

    assert status == 0
    assert "topological entropy >= 0.214584" in out
    assert json.loads(Path("chaos.json").read_text())["kind"] == "chaos"


@pytest.mark.parametrize(
    ("text", "options", "said"),
    [
        (CHAOTIC.replace("max_impacts = 4", "t_end = 1"), (), "the run meets no stop"),
        (template_text("sweep"), (), "not of kind motion, orbit, branch or basins, which alone"),
        (CHAOTIC, ("--speeds", "1/5", "3"), "a list of orbits, which is not asked for"),
        (CHAOTIC, ("--chaos", "--list", "1", "1"), "prove one, then the other"),
        (CHAOTIC, ("--list", "1", "1", "--speeds", "0", "3"), "give a least speed above 0"),
        (CHAOTIC, ("--list", "1", "1", "--speeds", "2", "1"), "speeds"),
        (CHAOTIC, ("--list", "0", "1"), "impacts"),
        (
            CHAOTIC.replace("at = 0", "at = -50"),
            ("--list", "1", "1"),
            "give the least and the greatest",
        ),
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
