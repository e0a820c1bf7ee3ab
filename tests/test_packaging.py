"""The files a package is installed from agree with one another."""

from __future__ import annotations

import re
import shutil
import subprocess
import tomllib
from pathlib import Path

import pytest

import percuss

ROOT = Path(__file__).parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
LOCKS = ["run", "dev", "benchmark", "docs"]


def locked(name: str) -> set[str]:
    """Give the pins of a lock, each `package==version` with its marker if it has one."""
    text = (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8")
    return {line.removesuffix("\\").strip() for line in text.splitlines() if "==" in line[:60]}


def package_names(requirements: set[str] | list[str]) -> set[str]:
    return {re.split(r"[=<>~! ;\[]", line, maxsplit=1)[0].lower() for line in requirements}


def test_the_version_is_that_of_the_project_everywhere() -> None:
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")

    version = PROJECT["project"]["version"]

    assert percuss.__version__ == version
    assert f"\nversion: {version}\n" in citation
    assert re.findall(r"^## (\S+)", changelog, flags=re.MULTILINE)[0] == version


@pytest.mark.parametrize("name", LOCKS)
def test_a_lock_names_packages_and_hashes_but_no_address(name: str) -> None:
    text = (ROOT / "requirements" / f"{name}.txt").read_text(encoding="utf-8")

    for address in ["http", "://", "--index", "--find-links", "--extra-index"]:
        assert address not in text


@pytest.mark.parametrize("name", LOCKS)
def test_a_lock_holds_all_that_its_installation_asks_for(name: str) -> None:
    groups = PROJECT["dependency-groups"]
    extras = PROJECT["project"]["optional-dependencies"]
    asked = PROJECT["project"]["dependencies"] + groups["build"]
    every = [
        it
        for extra in ("certified", "cluster", "netcdf", "notebook", "stores", "web")
        for it in extras[extra]
    ]
    asked += {
        "run": extras["certified"] + extras["netcdf"] + extras["stores"] + extras["web"],
        "dev": groups["dev"] + every,
        "benchmark": extras["benchmark"],
        "docs": groups["docs"] + every,
    }[name]

    assert package_names(asked) <= package_names(locked(name))


def test_the_locks_give_a_shared_package_the_same_version() -> None:
    """All are installed into one environment, one after the other."""
    dev = locked("dev")

    assert locked("run") <= dev
    shared = package_names(dev)
    assert {pin for pin in locked("benchmark") if package_names([pin]) <= shared} <= dev


def make(target: str, folder: Path) -> subprocess.CompletedProcess[str]:
    """Run the Makefile in a folder of its own."""
    if shutil.which("make") is None:
        pytest.skip("there is no make")
    shutil.copy(ROOT / "Makefile", folder)
    return subprocess.run(
        ["make", target], cwd=folder, capture_output=True, text=True, check=False, timeout=240
    )


def test_an_environment_of_somebody_else_that_cannot_be_used_stays(tmp_path: Path) -> None:
    (tmp_path / ".venv").mkdir()
    (tmp_path / ".venv" / "notes.txt").write_text("mine", encoding="utf-8")

    done = make(".venv/made.stamp", tmp_path)

    assert done.returncode != 0
    assert "is not of this Makefile's making and cannot be used" in done.stderr
    assert [file.name for file in (tmp_path / ".venv").iterdir()] == ["notes.txt"]


def test_clean_removes_what_the_demos_wrote_and_nothing_beside_it(tmp_path: Path) -> None:
    for folder in ("demo/paper", "demo/n3_above", "src", "tests", "examples", "benchmarks"):
        (tmp_path / folder).mkdir(parents=True)
    (tmp_path / "demo" / "notes.txt").write_text("mine", encoding="utf-8")

    assert make("clean", tmp_path).returncode == 0

    assert [file.name for file in (tmp_path / "demo").iterdir()] == ["notes.txt"]
