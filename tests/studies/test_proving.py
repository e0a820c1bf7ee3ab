"""Studies whose answer is proven: what is written, told and refused."""

from __future__ import annotations

import csv
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import pytest
from tests.studies.texts import faults_of

import percuss as pc
from percuss.errors import ParameterError
from percuss.execution import Execution
from percuss.studies import (
    Branch,
    Certify,
    Limits,
    Motion,
    Orbit,
    Save,
    Sought,
    Study,
    Sweep,
    parse_study,
    run_study,
    template_text,
)
from percuss.studies.proving import proven
from percuss.studies.tables import Draw

pytest.importorskip("flint")

NO_PICTURES = Draw(png=False, svg=False)
WALL = pc.impact_oscillator("0.8")


def motion(v0: str = "0.45", impacts: int = 5, digits: int = 12) -> Study:
    question = Motion(pc.Start(0, v0), Limits(max_impacts=impacts))
    return Study(
        pc.impact_oscillator(), pc.sine(3), question, draw=NO_PICTURES, certify=Certify(digits)
    )


def rows_of(file: Path) -> list[dict[str, str]]:
    lines = file.read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(lines))


def test_table_stands_in_the_text_and_comes_back() -> None:
    study = motion(digits=30)

    assert "[certify]\ndigits = 30\n" in study.text()
    assert parse_study(study.text()).certify == Certify(30)
    assert parse_study(study.text()).text() == study.text()
    assert "certify" not in replace(study, certify=None).text()
    bare = study.text().replace("digits = 30\n", "")
    assert parse_study(bare).certify == Certify(12)


def test_motion_writes_decimals_that_hold_the_truth(tmp_path: Path) -> None:
    # sin 3t from v0 = 1: the impacts are at k pi (Dyskin et al. 2012).
    result = run_study(motion("1", digits=40), tmp_path)

    rows = rows_of(tmp_path / "certified.csv")
    assert [row["event"] for row in rows] == ["impact"] * 5
    # pi to 50 decimals.
    pi = Fraction("3.14159265358979323846264338327950288419716939937510")
    for k, row in enumerate(rows, start=1):
        radius = Fraction(row["t_radius"])
        assert 0 < radius < Fraction(1, 10**40)
        assert abs(Fraction(row["t"]) - k * pi) <= radius + k * Fraction(1, 10**50)
    assert result.proven.complete
    assert result.report["certified"].startswith(
        "5 impacts up to t = [15.70796326794896619231321691"
    )
    assert result.report["proof"].startswith("proven up to max_impacts")
    assert result.report["digits"].startswith("40 asked for; largest radius ")


def test_picture_is_drawn_where_pictures_are(tmp_path: Path) -> None:
    result = run_study(replace(motion(), draw=Draw(svg=False), save=Save(csv=False)), tmp_path)

    names = [file.name for file in result.files]
    assert names == ["motion.nc", "motion.png", "certified.png"]
    assert (tmp_path / "certified.png").stat().st_size > 10_000


def test_events_of_all_kinds_are_in_the_order_of_time(tmp_path: Path) -> None:
    stops = (pc.Wall(-1, "below", "1/2"), pc.SoftStop("1/2", "above", 9))
    question = Motion(pc.Start(0, 2), Limits(t_end=30))
    force = pc.Forcing(constant=-2)
    study = Study(pc.Oscillator(1, "0.1", stops), force, question, draw=NO_PICTURES,
                  certify=Certify())  # fmt: skip

    run_study(study, tmp_path)

    rows = rows_of(tmp_path / "certified.csv")
    times = [float(row["t"]) for row in rows]
    assert times == sorted(times)
    assert [row["event"] for row in rows[:3]] == ["in", "out", "impact"]
    assert rows[-1]["event"] == "contact"
    assert rows[-1]["v_after"] == rows[-1]["v_after_radius"] == ""


def test_end_of_a_proof_is_reported_with_its_reason(tmp_path: Path) -> None:
    question = Motion(pc.Start(1, 0), Limits(t_end=20))
    osc = pc.impact_oscillator("1/2", wall=-1)
    study = Study(osc, None, question, draw=NO_PICTURES, certify=Certify(2))

    result = run_study(study, tmp_path)

    assert not result.proven.complete
    assert result.report["certified"].startswith("no events up to t = [3.1416 ")
    assert result.report["proof"].startswith("the proof ends at a touch that the balls cannot")
    assert rows_of(tmp_path / "certified.csv")[0]["event"] == "graze"


def test_orbit_is_proven(tmp_path: Path) -> None:
    study = Study(WALL, pc.cosine("2.5"), Orbit(), draw=NO_PICTURES, certify=Certify())

    result = run_study(study, tmp_path)

    assert result.report["certified"].startswith(
        "an orbit exists, no other with these events within "
    )
    assert result.report["certified"].endswith("passes through no stop; asymptotic")
    (row,) = rows_of(tmp_path / "certified.csv")
    off = Fraction(row["v_after"]) - Fraction(float(result.answer.impacts.v_after[0]))
    assert abs(off) < Fraction(1, 10**12)


def test_special_points_of_a_branch_are_proven(tmp_path: Path) -> None:
    question = Branch(Sought(), {"forcing.omega": ("2.3", "2.8")})
    study = Study(WALL, pc.cosine("2.5"), question, draw=NO_PICTURES, certify=Certify())

    result = run_study(study, tmp_path)

    points = result.answer.special_points
    rows = rows_of(tmp_path / "certified.csv")
    assert len(rows) == len(points) == len(result.proven) > 0
    for row, point in zip(rows, points, strict=True):
        assert row["proven"] == "yes"
        assert abs(float(row["forcing.harmonics.0.omega"]) - point.value) < 1e-9
        assert Fraction(row["forcing.harmonics.0.omega_radius"]) < Fraction(1, 10**12)
    assert result.report["certified"].count("\n") == len(points) - 1


def test_stopped_study_is_not_proven_but_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def half(_: Motion, study: Study, execution: Execution) -> pc.Trajectory:
        assert callable(execution.progress)
        assert not execution.progress(0.5, 1.0)
        run: pc.Trajectory = pc.simulate(study.oscillator, study.forcing, v0="0.45", max_impacts=2)
        return run

    monkeypatch.setattr(Motion, "answer", half)

    result = run_study(motion(), tmp_path, progress=lambda done, total: False)  # noqa: ARG005

    assert not result.is_whole
    assert result.proven is None
    assert [file.name for file in result.files if file.suffix != ".toml"] == [
        "motion.nc",
        "impacts.csv",
        "motion.csv",
    ]
    assert result.report["certified"] == "nothing, the study was interrupted"


def test_stopped_proof_holds_what_was_done(tmp_path: Path) -> None:
    # The run is over before anyone is asked; the proof asks after each event.
    result = run_study(motion(), tmp_path, progress=lambda done, total: done > total)

    assert not result.is_whole
    assert len(result.answer.impacts) == 5
    assert 0 < len(rows_of(tmp_path / "certified.csv")) < 5
    assert result.report["proof"].startswith("the proof was interrupted")


def test_other_kinds_are_refused_before_any_work(tmp_path: Path) -> None:
    question = Sweep(("period",), {"forcing.omega": (2.0, 3.0)})
    study = Study(WALL, pc.cosine(2), question, certify=Certify())

    with pytest.raises(ParameterError, match="motion, orbit and branch; this one is of kind sweep"):
        run_study(study, tmp_path)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("digits", ["0", "1001", '"12"', "1.5"])
def test_digits_out_of_range_are_faults_of_the_file(digits: str) -> None:
    text = motion().text().replace("digits = 12", f"digits = {digits}")

    (fault,) = faults_of(text)

    assert "certify.digits" in fault


def test_table_is_none_of_a_kind_without_proof() -> None:
    text = Study(WALL, pc.cosine("2.5"), Orbit()).text().replace('"orbit"', '"orbits"')
    text = text.replace("[orbit]\nimpacts = 1\nperiods = 1\n", "[orbits]\n[certify]\n")

    (fault,) = faults_of(text)

    assert "certify: no table of this kind of study" in fault


WITHOUT = """
import sys
sys.modules["flint"] = None
from percuss.cli import main
sys.argv = ["percuss", "run", "s.toml", "--certify", "12"]
main()
"""


def test_without_flint_one_sentence_names_the_extra(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(replace(motion(), certify=None).text(), encoding="utf-8")

    done = subprocess.run(
        [sys.executable, "-c", WITHOUT], capture_output=True, text=True, check=False, cwd=tmp_path
    )

    assert done.stderr == "certified results need python-flint: install percuss[certified]\n"
    assert done.returncode == 2
    assert [path.name for path in tmp_path.iterdir()] == ["s.toml"]


def test_a_grazing_orbit_is_one_of_the_formal_equations(tmp_path: Path) -> None:
    # x = sin t touches the wall at 1 without velocity.
    osc = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    force = pc.cosine(1, amplitude="0.1")
    study = Study(osc, force, Orbit(Sought(impacts=0)), draw=NO_PICTURES, certify=Certify())

    reported = run_study(study, tmp_path).report["certified"]

    assert reported.startswith(
        "a solution of the formal equations of an orbit exists, no other with"
    )
    assert "with these events;" in reported
    assert reported.endswith("is open; stability undecided")


def test_a_proof_of_a_motion_asks_whether_to_go_on() -> None:
    asked: list[float] = []

    def progress(done: float, _: float) -> bool:
        asked.append(done)
        # The motion itself is there with the first two calls.
        return len(asked) < 5

    run = proven(parse_study(template_text("impact")), 12, progress)

    assert "interrupted" in str(run)
    assert len(asked) == 5
