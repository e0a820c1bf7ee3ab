"""What is built is whole: a wheel that works without a clone, and sources that build it."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
import zipfile
from collections.abc import Callable
from email.parser import Parser
from pathlib import Path

import pytest

import percuss

wheel = pytest.importorskip("hatchling.builders.wheel", reason="builds the package")
sdist = pytest.importorskip("hatchling.builders.sdist", reason="builds the package")

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "percuss"
VERSION = percuss.__version__


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    folder = tmp_path_factory.mktemp("dist")
    build: Callable[..., str] = lambda kind: next(
        iter(kind(str(ROOT)).build(directory=str(folder), versions=["standard"]))
    )
    return {"wheel": Path(build(wheel.WheelBuilder)), "sdist": Path(build(sdist.SdistBuilder))}


def test_the_wheel_holds_all_files_of_the_package_and_nothing_else(built: dict[str, Path]) -> None:
    with zipfile.ZipFile(built["wheel"]) as file:
        names = set(file.namelist())
    there = {
        f"percuss/{path.relative_to(PACKAGE).as_posix()}"
        for path in PACKAGE.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }

    assert built["wheel"].name == f"percuss-{VERSION}-py3-none-any.whl"
    assert {name for name in names if ".dist-info/" not in name} == there
    assert {"percuss/py.typed", "percuss/cli/schemas/run.schema.json"} <= names
    assert f"percuss-{VERSION}.dist-info/licenses/LICENSE" in names


def told_by(wheel: Path, folder: Path, change: tuple[bytes, bytes] = (b"", b"")) -> tuple[int, str]:
    """Return what the package in a wheel, with a change of its kernels, says of its file."""
    with zipfile.ZipFile(wheel) as file:
        file.extractall(folder)
    kernels = folder / "percuss" / "kernels" / "march.py"
    assert change[0] in kernels.read_bytes()
    kernels.write_bytes(kernels.read_bytes().replace(*change))
    ended = subprocess.run(
        [sys.executable, "-m", "percuss.web.wasm.sources"],
        check=False, env=os.environ | {"PYTHONPATH": str(folder)}, cwd=folder, capture_output=True, text=True,
    )  # fmt: skip
    return ended.returncode, ended.stderr


def test_the_wheel_holds_the_kernels_of_the_page_as_they_are(
    built: dict[str, Path], tmp_path: Path
) -> None:
    assert told_by(built["wheel"], tmp_path / "same") == (0, "")
    changed = told_by(
        built["wheel"], tmp_path / "other", (b"status = MOVING", b"status = 0 + MOVING")
    )
    assert changed == (1, "kernels.wasm is not that of the kernels as they are\n")


def test_the_metadata_are_those_that_an_index_takes(built: dict[str, Path]) -> None:
    with zipfile.ZipFile(built["wheel"]) as file:
        text = file.read(f"percuss-{VERSION}.dist-info/METADATA").decode()
    about = Parser().parsestr(text)

    assert (about["Name"], about["Version"], about["License-Expression"]) == (
        "percuss", VERSION, "MIT",
    )  # fmt: skip
    assert about["Description-Content-Type"] == "text/markdown"
    assert about["Requires-Python"] == ">=3.11"
    assert "# percuss" in str(about.get_payload())
    required = [line for line in about.get_all("Requires-Dist", []) if "extra ==" not in line]
    assert {re.split(r"[><=]", line)[0] for line in required} == {
        "numpy", "numba", "xarray", "pydantic", "typer", "rich", "matplotlib", "pillow",
    }  # fmt: skip


def test_the_sources_hold_what_builds_and_tests_the_package(built: dict[str, Path]) -> None:
    with tarfile.open(built["sdist"]) as file:
        names = {name.partition("/")[2] for name in file.getnames()}

    assert {
        "pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "CITATION.cff", "Makefile",
        "src/percuss/__init__.py", "tests/conftest.py", "docs/images/chatter.gif",
    } <= names  # fmt: skip
    assert not [name for name in names if re.search(r"__pycache__|\.venv|^demo/|^dist/", name)]
    assert built["sdist"].stat().st_size < 20e6


def test_the_recipe_asks_for_what_the_package_asks_for() -> None:
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    recipe = (ROOT / "recipe" / "recipe.yaml").read_text(encoding="utf-8")
    extras = project["optional-dependencies"]
    asked = [*project["dependencies"], *extras["netcdf"], *extras["stores"]]
    listed = recipe[recipe.index("  run:") : recipe.index("tests:")].replace("-base", "")

    assert f'version: "{VERSION}"' in recipe
    for requirement in asked:
        assert f"- {requirement.replace('>=', ' >=')}\n" in listed, requirement


def test_no_file_names_the_host_of_a_registry() -> None:
    files = [
        ROOT / name for name in ("README.md", "SECURITY.md", "CONTRIBUTING.md", "pyproject.toml")
    ]
    files += [*(ROOT / ".github").rglob("*.yml"), ROOT / "recipe" / "recipe.yaml"]
    hosts = re.compile(r"https?://[\w.]*(pypi|pythonhosted|anaconda|conda)[\w.]*")

    assert [file.name for file in files if hosts.search(file.read_text(encoding="utf-8"))] == []
