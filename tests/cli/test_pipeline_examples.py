"""The scripts of examples/pipelines say what works: their commands run, in order."""

from __future__ import annotations

import re
import shlex
import shutil
from pathlib import Path

import pytest
from typer.testing import CliRunner

from percuss.cli import app

FOLDER = Path(__file__).parents[2] / "examples" / "pipelines"
SMALL = [
    "--set", 'over."forcing.omega".count=5', "--set", "sweep.periods=4",
    "--set", 'over."oscillator.stops.0.restitution".count=4', "--set", "sweep.transient=2",
    "--set", "draw.svg=false", "--set", "sweep.measure=mean_power",
]  # fmt: skip


def commands(text: str, values: dict[str, str]) -> list[list[str]]:
    """Return the percuss commands of a script, with the values of its variables."""
    text = re.sub(r'"\s*\n\s*"', "", re.sub(r"(?m)^\s*#.*$", "", text))
    for name, value in values.items():
        text = text.replace(name, value)
    found = re.findall(r"percuss ((?:run|merge) [^\n&]*)", text)
    # The last quotation mark of a Snakefile's text closes it.
    whole = (line.removesuffix('"') if line.count('"') % 2 else line for line in found)
    return [shlex.split(line) for line in whole]


def run(command: list[str]) -> None:
    small = SMALL if command[0] == "run" else []
    result = CliRunner().invoke(app, [*command, *small])
    assert result.exit_code == 0, (command, result.output)


@pytest.fixture(autouse=True)
def _with_the_study() -> None:
    shutil.copy(FOLDER / "chart.toml", "chart.toml")


def test_the_job_array_ends_in_the_results() -> None:
    text = (FOLDER / "array.sh").read_text(encoding="utf-8")
    given = {"$STUDY": "chart.toml", "$STORE": "chart.zarr", "$PARTS": "2"}
    for number in ("1", "2"):
        ((*part,),) = commands(text, {**given, "$SLURM_ARRAY_TASK_ID": number})
        assert part[-2:] == ["--part", f"{number}/2"]
        run(part)
    merging = commands((FOLDER / "merge.sh").read_text(encoding="utf-8"), given)
    assert [command[0] for command in merging] == ["merge", "run"]
    for command in merging:
        run(command)

    assert {"sweep.nc", "sweep.png"} <= {file.name for file in Path("chart").iterdir()}


def test_the_snakefile_ends_in_its_result() -> None:
    text = (FOLDER / "Snakefile").read_text(encoding="utf-8")
    given = {"{input.study}": "chart.toml", "{input}": "chart.toml", "{PARTS}": "2"}
    first = commands(text, {**given, "{wildcards.i}": "1"})
    second = commands(text, {**given, "{wildcards.i}": "2"})
    assert [command[0] for command in first] == ["merge", "run", "run"]
    for command in (first[2], second[2], first[0], first[1]):
        run(command)

    assert Path("chart/sweep.nc").exists()
    assert '"chart/sweep.nc"' in text
