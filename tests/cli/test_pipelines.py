"""Commands in scripts and queues: several studies, JSON, changes, parts, quiet."""

from __future__ import annotations

import json
import logging
import signal
from collections.abc import Iterator
from importlib import resources
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from tests.cli.commands import percuss
from tests.studies.texts import MOTION_TO_30, WALL_BELOW
from typer.testing import CliRunner

import percuss as pc
from percuss.cli import app, run_studies
from percuss.cli.terminal import ProgressBar
from percuss.io import load_record

MOTION = f'[study]\ntitle = "A motion"\n{MOTION_TO_30}svg = false\n[save]\ncsv = false\n'
SWEEP = f"""\
[study]
kind = "sweep"
{WALL_BELOW.format(restitution="0.8", omega="2.5")}\
[over]
"forcing.omega" = {{from = 2, to = 3, count = 40}}
[sweep]
transient = 20
periods = 8
measure = "peak_impact_velocity"
[draw]
png = false
svg = false
"""
jsonschema = pytest.importorskip("jsonschema", reason="comes with nbclient")

SCHEMA = json.loads(
    (resources.files("percuss.cli") / "schemas" / "run.schema.json").read_text(encoding="utf-8")
)


@pytest.fixture(autouse=True)
def _with_studies() -> Iterator[None]:
    Path("a.toml").write_text(MOTION, encoding="utf-8")
    Path("b.toml").write_text(MOTION.replace("A motion", "Another"), encoding="utf-8")
    Path("sweep.toml").write_text(SWEEP, encoding="utf-8")
    yield
    # A command shows warnings as its own sentences, in one process until it ends.
    logging.getLogger("percuss").handlers.clear()
    logging.getLogger("percuss").setLevel(logging.NOTSET)


def lines(text: str) -> list[dict[str, Any]]:
    """Return the lines of JSON, each of the published form."""
    found = [json.loads(line) for line in text.splitlines()]
    for line in found:
        jsonschema.validate(line, SCHEMA)
    return found


def test_several_studies_go_into_a_folder_each() -> None:
    status, out, err = percuss("run", "a.toml", "b.toml", "--out", "all", "--json")

    assert (status, err) == (0, "")
    first, second = lines(out)
    assert (first["title"], second["title"]) == ("A motion", "Another")
    assert first["files"] == [str(Path("all/a/motion.nc"))]
    assert first["status"] == second["status"] == "done"
    assert int(first["report"]["impacts"].split()[0]) > 0
    # Each file repeats its own study alone.
    assert load_record("all/b/motion.nc").command == f"percuss run b.toml --out {Path('all/b')}"


def test_a_pattern_that_the_shell_leaves_stands_for_its_files() -> None:
    _, out, _ = percuss("run", "[ab].toml", "--check", "--json")

    assert [line["study"] for line in lines(out)] == ["a.toml", "b.toml"]


def test_with_one_faulty_study_none_runs() -> None:
    Path("b.toml").write_text(MOTION.replace("t_end = 30", "t_end = -1"), encoding="utf-8")

    status, out, err = percuss("run", "a.toml", "b.toml", "--json")

    assert status == 2
    assert err == "b.toml:15: run.t_end = -1: not after t0 = 0.0\n"
    (line,) = lines(out)
    assert (line["study"], line["status"]) == ("b.toml", "faulty")
    assert line["faults"] == [
        {"file": "b.toml", "line": 15, "path": "run.t_end", "value": "-1",
         "reason": "not after t0 = 0.0"}
    ]  # fmt: skip
    assert not Path("a").exists()


def test_a_study_that_fails_does_not_stop_the_others() -> None:
    Path("a").write_text("mine", encoding="utf-8")

    status, out, err = percuss("run", "a.toml", "b.toml", "--json")

    assert status == 2
    assert err == "a: is a file, not a folder; rename it, or name another folder\n"
    assert [line["status"] for line in lines(out)] == ["failed", "done"]


def test_check_runs_nothing() -> None:
    status, out, _ = percuss("run", "a.toml", "sweep.toml", "--check")

    assert status == 0
    assert out.splitlines() == [
        "a.toml: valid, 'A motion', of kind motion; would write motion.nc",
        "sweep.toml: valid, of kind sweep; would write sweep.nc, sweep.csv, sweep.csv.toml",
    ]
    assert sorted(path.name for path in Path().iterdir()) == ["a.toml", "b.toml", "sweep.toml"]


def test_a_changed_value_is_computed_and_recorded() -> None:
    status, out, _ = percuss(
        "run", "a.toml", "--set", "run.t_end=10", "--set", "oscillator.stops.0.restitution=1/3",
        "--json",
    )  # fmt: skip

    assert status == 0
    assert lines(out)[0]["status"] == "done"
    record = load_record("a/motion.nc")
    assert "t_end = 10" in record.study
    assert 'restitution = "1/3"' in record.study
    assert "--set run.t_end=10 --set oscillator.stops.0.restitution=1/3" in record.command


def test_quiet_shows_nothing_but_faults() -> None:
    assert percuss("run", "a.toml", "--quiet") == (0, "", "")
    status, out, err = percuss("run", "a.toml", "--quiet")
    assert (status, out) == (2, "")
    assert err.startswith(
        "a/motion.nc: exists already; --force replaces".replace("/", str(Path("/")))
    )


def test_sigterm_ends_a_run_with_what_is_done_and_its_own_status(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    real = ProgressBar.__call__

    def terminated(bar: ProgressBar, done: float, total: float) -> bool:
        if not bar.is_stopped:
            signal.raise_signal(signal.SIGTERM)
        return real(bar, done, total)

    monkeypatch.setattr(ProgressBar, "__call__", terminated)
    status, out, err = percuss("run", "a.toml", "--set", "run.t_end=1e6", "--json")

    assert status == 143
    assert "ended by SIGTERM; writing what was done" in err
    (line,) = lines(out)
    assert (line["status"], line["files"]) == ("interrupted", [str(Path("a/motion.nc"))])


def test_verbose_logs_each_step_with_its_time() -> None:
    status, _, err = percuss("run", "a.toml", "--verbose")

    assert status == 0
    assert " INFO percuss.studies.running: A motion: computing" in err
    assert "wrote a/motion.nc".replace("/", str(Path("/"))) in err


def test_parts_are_merged_by_commands_to_the_result_of_one() -> None:
    for number in (1, 2):
        status, out, err = percuss(
            "run", "sweep.toml", "--store", "r.zarr", "--part", f"{number}/2", "--json"
        )
        (line,) = lines(out)
        assert (status, err, line["status"], line["files"]) == (0, "", "done", [])
        assert (line["part"], line["report"]["points"]) == (f"{number}/2", "20")
        assert not Path("r.zarr").exists()
    status, _, err = percuss("run", "sweep.toml", "--store", "r.zarr")
    assert status == 2
    assert "its parts lie in r.zarr.parts; percuss merge r.zarr puts them together first" in err
    _, out, _ = percuss("status", "r.zarr")
    assert "2 of 2 are there, 2 of them complete" in out
    assert "100.0%: 40 of 40 points" in out

    status, out, err = percuss("merge", "r.zarr")
    assert (status, err) == (0, "")
    assert out.startswith("merged 40 points into r.zarr; percuss run STUDY --store r.zarr writes")
    assert percuss("run", "sweep.toml", "--store", "r.zarr", "--quiet") == (0, "", "")
    assert percuss("run", "sweep.toml", "--out", "one", "--quiet") == (0, "", "")
    assert Path("sweep/sweep.csv").read_bytes() == Path("one/sweep.csv").read_bytes()
    assert pc.load_netcdf("sweep/sweep.nc").identical(pc.load_netcdf("one/sweep.nc"))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["a.toml", "--part", "1/2", "--store", "r.zarr"], "for studies of many motions"),
        (["sweep.toml", "--part", "1/2"], "needs a store, where the parts are put together"),
        (["sweep.toml", "--part", "3/2", "--store", "r.zarr"], "not a part from 1 to their number"),
        (["sweep.toml", "--part", "x", "--store", "r.zarr"], "such as 3/100"),
        (["a.toml", "b.toml", "--store", "r.zarr"], "one store for 2 studies"),
        (["a.toml", "./a.toml"], "of this name there are several"),
    ],
)
def test_options_that_do_not_fit_are_one_sentence(arguments: list[str], message: str) -> None:
    status, out, err = percuss("run", *arguments)

    assert (status, out) == (2, "")
    assert message in err
    assert err.count("\n") == 1


def test_the_schemas_are_printed() -> None:
    status, out, _ = percuss("schema", "run")
    assert (status, json.loads(out)) == (0, SCHEMA)
    assert SCHEMA["properties"]["form"]["const"] == run_studies.FORM
    assert json.loads(percuss("schema")[1])["title"] == "A study of percuss"
    assert percuss("schema", "x") == (2, "", 'name = \'x\': neither "study" nor "run"\n')


def test_doctor_names_versions_cores_and_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "percuss.cli.doctor.find_spec", lambda name: None if name == "uvicorn" else name
    )
    status, out, _ = percuss("doctor", "--json")
    found = json.loads(out)

    assert status == 0
    assert found["percuss"].startswith(pc.__version__)
    assert "numba" in found["packages"]
    assert found["web"] == ('percuss serve: uvicorn missing; pip install "percuss[web]"')
    assert found["certified"].endswith(": there")
    assert percuss("doctor")[1].splitlines()[0].startswith("percuss     ")


def test_cite_is_that_of_the_citation_file() -> None:
    text = (Path(__file__).parents[2] / "CITATION.cff").read_text(encoding="utf-8")
    line, entry = percuss("cite")[1], percuss("cite", "--bibtex")[1]

    title = next(row for row in text.splitlines() if row.startswith("title:")).split('"')[1]
    for said in (line, entry):
        assert title in said
        assert pc.__version__ in said
        assert "percuss developers" in said
    assert entry.startswith("@software{percuss,\n")


def test_the_shell_completes_commands_and_options() -> None:
    _, out, _ = percuss("--help")

    assert "--install-completion" in out
    result = CliRunner().invoke(
        app, [], prog_name="percuss",
        env={"_PERCUSS_COMPLETE": "complete_bash", "COMP_WORDS": "percuss me", "COMP_CWORD": "1"},
    )  # fmt: skip
    assert result.output.split() == ["merge"]


@pytest.mark.parametrize(
    ("arguments", "lacking", "sentence"),
    [
        (["a.toml"], "h5py", "a NetCDF file needs h5py: install percuss[netcdf]"),
        (
            ["sweep.toml", "--store", "r.zarr", "--set", "save.netcdf=false"],
            "zarr",
            "a store needs zarr: install percuss[stores]",
        ),
    ],
)
def test_without_an_optional_package_a_sentence_says_what_to_install_before_any_work(
    arguments: list[str], lacking: str, sentence: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    real = find_spec
    for module in ("percuss.errors", "percuss.studies.running"):
        monkeypatch.setattr(
            f"{module}.find_spec", lambda name: None if name == lacking else real(name)
        )

    assert percuss("run", *arguments) == (2, "", f"{sentence}\n")
    assert sorted(path.name for path in Path().iterdir()) == ["a.toml", "b.toml", "sweep.toml"]
