"""The commands in one process: what they write, say and return."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from tests.cli.commands import percuss
from tests.studies.texts import MOTION_TO_30

import percuss as pc
from percuss.studies import load_study, parse_study, template_names, template_text

STUDY = f'[study]\ntitle = "A [bold] title"\n{MOTION_TO_30}'


@pytest.fixture(autouse=True)
def _with_studies() -> None:
    Path("study.toml").write_text(STUDY)


def test_run_writes_into_a_folder_of_the_studys_name_and_reports() -> None:
    status, out, err = percuss("run", "study.toml")

    assert (status, err) == (0, "")
    assert sorted(path.name for path in Path("study").iterdir()) == [
        "impacts.csv",
        "impacts.csv.toml",
        "motion.csv",
        "motion.csv.toml",
        "motion.nc",
        "motion.svg",
    ]
    run = pc.simulate(pc.impact_oscillator(0.5), pc.cosine(0.5), x0=1, t_end=30)
    rows = dict(line.split(maxsplit=1) for line in out.splitlines()[1:] if line[0] != " ")
    assert out.splitlines()[0] == "A [bold] title"
    assert rows["impacts"] == str(len(run.impacts))
    assert rows["crossings"] == "0"
    assert rows["contacts"] == f"2, the first from t = {run.contacts.start[0]:.10g}"
    assert rows["grazes"] == "0"
    assert rows["outcome"] == run.outcome.value
    assert rows["time"] == "t = 0 to 30"
    assert rows["computed"].startswith("in ")
    assert rows["files"] == "study/motion.nc"
    assert "impact times" in out


def test_a_result_is_run_again_as_a_study_is() -> None:
    percuss("run", "study.toml")

    status, _, _ = percuss("run", "study/motion.svg", "--out", "again")

    assert status == 0
    assert load_study("again/motion.nc") == parse_study(STUDY)


def test_the_command_stands_in_the_files() -> None:
    percuss("run", "study.toml", "--out", "a b")

    record = Path("a b/impacts.csv.toml").read_text()
    assert "\ncommand = \"percuss run study.toml --out 'a b'\"\n" in record


def test_results_are_refused_without_force_and_replaced_with_it() -> None:
    percuss("run", "study.toml")
    Path("study/impacts.csv").write_text("mine")

    status, out, err = percuss("run", "study.toml")
    assert (status, out) == (2, "")
    assert err == (
        "study/motion.nc: exists already; --force replaces the results in study, "
        "--out writes into another folder\n"
    )
    assert Path("study/impacts.csv").read_text() == "mine"

    assert percuss("run", "study.toml", "--force")[0] == 0
    assert Path("study/impacts.csv").read_text() != "mine"


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("none.toml", 'none.toml: no such file or directory; "percuss new" writes one'),
        (".", ".: is a directory"),
        ("picture.png", "picture.png: holds no record of percuss"),
    ],
)
def test_a_file_that_is_no_study_is_one_sentence(path: str, message: str) -> None:
    Path("picture.png").write_bytes(b"\x89PNG")

    assert percuss("run", path) == (2, "", f"{message}\n")


def test_every_fault_of_a_study_is_one_line_and_nothing_is_written() -> None:
    Path("study.toml").write_text(
        STUDY.replace('on = "0.5"', "on = 1.5").replace("t_end", "max_impacts = 9\ntend")
    )

    status, out, err = percuss("run", "study.toml")

    assert (status, out) == (2, "")
    assert err.splitlines() == [
        (
            "study.toml:7: oscillator.stops.0.restitution = 1.5: outside [0, 1]; "
            "above 1 an impact would create energy"
        ),
        'study.toml:16: run.tend: unknown key; did you mean "t_end"?',
    ]
    assert not Path("study").exists()


def test_a_folder_that_cannot_be_written_is_one_sentence() -> None:
    Path("file").write_text("")

    assert percuss("run", "study.toml", "-o", "file/out") == (
        2,
        "",
        "file: is a file, not a folder; rename it, or name another folder\n",
    )


@pytest.mark.parametrize("name", template_names())
def test_new_writes_a_template_that_runs_as_it_says(name: str) -> None:
    status, out, _ = percuss("new", "my study.toml", "--template", name)

    assert status == 0
    assert out == "wrote my study.toml; run it with: percuss run 'my study.toml'\n"
    assert Path("my study.toml").read_text() == template_text(name)


def test_new_does_not_overwrite_a_study_unasked() -> None:
    status, _, err = percuss("new")

    assert status == 2
    assert err == "study.toml: exists already; --force replaces it\n"
    assert Path("study.toml").read_text() == STUDY

    assert percuss("new", "--force")[0] == 0
    assert Path("study.toml").read_text() == template_text("impact")


def test_a_file_named_as_a_template_is_told_from_that_template() -> None:
    status, out, _ = percuss("new", "fit")

    assert status == 0
    assert out.splitlines()[1:] == [
        "it is of the template impact; that of fit: percuss new fit.toml -t fit"
    ]


def test_an_unknown_template_is_one_sentence() -> None:
    status, _, err = percuss("new", "a.toml", "-t", "spring")

    assert status == 2
    assert err == (
        "template = 'spring': not a template; the templates are backlash, ball, basins, bilinear, "
        "branch, curve, design, diagram, fit, impact, lyapunov, mooring, orbit, orbits, record, "
        "response, structure, structure_response, sweep\n"
    )
    assert not Path("a.toml").exists()


def test_the_version_is_the_packages() -> None:
    assert percuss("--version") == (0, f"percuss {pc.__version__}\n", "")


def test_new_makes_no_folders() -> None:
    status, out, err = percuss("new", "no/such/folder/x.toml")

    assert (status, out) == (2, "")
    assert err == "no/such/folder: no such folder; make it first\n"
    assert not Path("no").exists()


def test_the_templates_are_named_in_the_help_and_in_a_list() -> None:
    _, shown, _ = percuss("new", "--help")
    status, listed, _ = percuss("new", "--list")

    words = re.findall(r"\w+", shown)
    assert set(template_names()) <= set(words)
    assert status == 0
    assert [line.split()[0] for line in listed.splitlines()] == template_names()
    assert "a ball that bounces on a shaking table" in listed
    assert Path("study.toml").read_text() == STUDY


def test_a_file_of_another_kind_is_one_error() -> None:
    Path("letter.toml").write_text("Dear reader,\n\nthis is prose,\nand no study.\n\nYours\n" * 9)

    status, out, err = percuss("run", "letter.toml")

    assert (status, out) == (2, "")
    assert err.startswith("letter.toml:1: not a TOML file: ")
    assert err.endswith('; "percuss new" writes a study to begin with\n')
    assert err.count("\n") == 1
