"""Certificates are read in one way only, by a program of its own, and written to files."""

from __future__ import annotations

import ast
import json
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from tests.certified.checker import (
    CHECKER,
    NINES,
    WALL,
    Claims,
    assert_refused,
    leaves,
    run_of,
    theorem_of,
    wave,
    with_value,
)
from tests.test_house import private_reads

import percuss as pc
from arithmetic import NotProvenError
from percuss.certified import certificate
from percuss.errors import OutputError, ParameterError


def test_what_is_cut_off_or_of_another_version_is_refused(run: Claims) -> None:
    text = json.dumps(run)

    for part in (text[:-1], text[: len(text) // 2], "", "[]", "null", '{"certificate": 1}'):
        assert_refused(part, "cut off or changed")
    assert_refused(run | {"certificate": 2}, "version 2; this program checks version 1")
    assert_refused(
        run | {"kind": "weather"},
        "'weather'; this program checks run, orbit, branch, list, basins, chaos",
    )


NO_NUMBER = r"is no (rational|whole) number|is no list"


@pytest.mark.parametrize(
    ("place", "value", "said"),
    [
        (("start", "x"), 0.0, NO_NUMBER),
        (("start", "x"), float("nan"), NO_NUMBER),
        (("start", "x"), "1e400000000", NO_NUMBER),
        (("start", "x"), " 0", NO_NUMBER),
        (("start", "x"), "0/0", "ZeroDivisionError"),
        (("start", "t"), "00", NO_NUMBER),
        (("start", "t"), ["0", "0", "0"], NO_NUMBER),
        (("start", "spin"), "0", "should stand where"),
        (("law", "friction"), "1/10", "should stand where"),
        (("law", "base"), "11/20", "repeats before its period ends"),
        (("law", "base"), "-11/10", "are not multiples of"),
        (("law", "regions", 0, "upper"), False, "is no whole number"),
        (("events", 0, "bound"), False, NO_NUMBER),
        (("events", 0, "bound"), 0.0, NO_NUMBER),
        (("events", 0, "bound"), -1, NO_NUMBER),
        (("events",), {}, NO_NUMBER),
        (("events",), [], "no event is claimed"),
        (("claim",), "and it is chaotic", "should stand where"),
        (("certificate",), True, NO_NUMBER),
        # Of many digits.
        (("law", "regions", 0, "damping"), f"7{'0' * 4299}1/9{'0' * 4299}7", NO_NUMBER),
        (("law", "regions", 0, "damping"), f"1/{'9' * 2001}", NO_NUMBER),
        (("law", "bounds", 0, "restitution"), f"1{'0' * 4298}/{'9' * 4300}", NO_NUMBER),
        (("law", "base"), f"11{'0' * 2000}/1{'0' * 2001}", NO_NUMBER),
        (("start", "t"), ["0", "9" * 4300], NO_NUMBER),
        (("events", 0, "bound"), 10**9 + 1, NO_NUMBER),
    ],
    ids=lambda value: repr(value)[:40],
)
def test_what_could_be_read_in_two_ways_or_not_at_all_is_refused(
    run: Claims, place: tuple[Any, ...], value: Any, said: str
) -> None:
    assert_refused(with_value(run, place, value), said)


@pytest.mark.parametrize("number", [NINES, f"-{NINES}", f"1/{NINES}", f"{NINES}/{NINES[:-1]}8"])
def test_what_is_read_can_be_printed(run: Claims, orbit: Claims, number: str) -> None:
    """Whatever number stands anywhere, the program ends with a theorem or with a sentence."""
    for claims in (run, orbit):
        places = [path for path in leaves(claims) if path[0] not in ("certificate", "kind")]
        for path in places[:: max(1, len(places) // 12)]:
            try:
                theorem_of(with_value(claims, path, number))
            except NotProvenError as error:
                assert str(error)  # noqa: PT017


def test_numbers_of_the_law_at_a_parameter_need_not_be_printed() -> None:
    """Products of numbers with as many digits as there may be have more than Python prints."""
    law: Claims = {
        "regions": [{"stiffness": "1", "damping": "0", "constant": "0", "lower": 0, "upper": None}],
        "bounds": [{"at": "0", "restitution": ["2", f"1/{NINES}"]}],
        "tones": [wave("1", "1")],
        "base": "1",
    }
    strip = {
        "along": 0, "begin": f"1/{NINES}", "end": f"3/{NINES}", "middle": [f"2/{NINES}", "1", "0"],
        "tangent": ["1", "0", f"1/{NINES}"], "sizes": ["0", "1/9", "0"], "stability": "undecided",
        "slow": None,
    }  # fmt: skip
    curve = {"periods": "1", "events": [{"bound": 0, "region": 0}], "strips": [strip], "points": []}
    claims = {"certificate": 1, "kind": "branch", "law": law, "curves": [curve]}

    assert_refused(claims, "bound 0 has a restitution of 2$|bound 0 has a restitution of 1.9999")
    law["bounds"][0]["restitution"] = "1"
    law["base"] = ["-1", f"1/{NINES}"]
    assert_refused(claims, "the frequencies are not multiples of -")


@pytest.mark.parametrize("word", ["Unstable", "\ud800", "a" * 41, "\x1b[2J"])
def test_a_word_is_of_small_letters(orbit: Claims, word: str) -> None:
    assert_refused(orbit | {"stability": word}, "is no word of small letters")


def test_a_number_of_very_many_digits_has_no_certificate() -> None:
    # More digits than the program reads, and than Python prints.
    for digits in (2500, 5000):
        wall = pc.impact_oscillator("4/5", wall=Fraction(10**digits // 9, 10**digits))
        run = run_of(wall, pc.cosine("14/5"), x0=1, max_impacts=2)

        with pytest.raises(ParameterError, match="one of its numbers has more than 2000 digits"):
            certificate(run)


def test_instants_far_away_end_in_time(run: Claims, orbit: Claims, chaos: Claims) -> None:
    far = f"1{'0' * 60}"
    for claims, place, value in (
        (orbit, ("law", "tones", 0, "phase"), ["0", far]),
        (run, ("start", "t"), ["0", far]),
        (chaos, ("sets", len(chaos["sets"]) - 1, "center", 0), "-1000000000001"),
        (chaos, ("sets", len(chaos["sets"]) - 1, "center", 0), far),
    ):
        assert_refused(with_value(claims, place, value))


def test_a_proof_that_takes_too_long_is_given_up(
    run: Claims, complete: Claims, monkeypatch: Any
) -> None:
    theorem_of(run)
    monkeypatch.setattr("flights.MOST_STATES", 50)

    # Much of a large region is excluded without a search.
    for claims in (run, complete | {"speeds": ["1/5", "1000000"]}):
        assert_refused(claims, "not within 50 states")
    for change in ({"impacts": 10**6, "periods": 10**6}, {"impacts": 101}):
        assert_refused(complete | change, "more than 100 impacts or periods")


def test_a_name_that_stands_twice_and_endless_brackets_are_refused(run: Claims) -> None:
    text = json.dumps(run)

    for other in (text.replace('"x": "0"', '"x": "0", "x": "0"'), "[" * 10**6):
        assert other != text
        assert_refused(other, "cut off or changed")


def test_the_program_runs_by_itself_without_percuss(tmp_path: Path, orbit: Claims) -> None:
    """The folder, copied anywhere: it needs no other file, and nothing but Python."""
    shutil.copytree(CHECKER, tmp_path / "anywhere", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "a.json").write_text(json.dumps(orbit))
    (tmp_path / "b.json").write_text(json.dumps(orbit | {"periods": 2}))

    def ran(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-I", "-S", "anywhere", *arguments]
        return subprocess.run(command, capture_output=True, text=True, check=False, cwd=tmp_path)

    proven, wrong, missing, none = ran("a.json"), ran("b.json"), ran("c.json"), ran()

    assert [it.returncode for it in (proven, wrong, missing, none)] == [0, 1, 1, 2]
    assert proven.stdout.startswith("PROVEN. There is one periodic orbit")
    assert "x'' + 0 x' + 1 x = 0 + 1 cos(14/5 t + 0)" in proven.stdout
    assert wrong.stderr.startswith("NOT PROVEN: ")
    assert "Traceback" not in wrong.stderr + missing.stderr


# What each module of the program uses of the others, and what of Python's library.
MODULES = {
    "arithmetic": "",
    "words": "",
    "flights": "arithmetic words",
    "reading": "arithmetic flights words",
    "parts": "arithmetic words",
    "runs": "arithmetic flights words",
    "orbits": "arithmetic flights words",
    "branches": "arithmetic flights orbits reading words",
    "lists": "arithmetic flights orbits parts words",
    "basins": "arithmetic flights orbits parts words",
    "chaos": "arithmetic flights parts words",
    "theorems": "arithmetic basins branches chaos flights lists orbits reading runs words",
    "__main__": "arithmetic theorems",
}
OF_PYTHON = {
    "__future__", "collections", "contextlib", "dataclasses", "fractions", "itertools", "json", "math",
    "pathlib", "re", "sys", "typing",
}  # fmt: skip


def test_its_modules_use_few_others_and_no_floating_point() -> None:
    assert {path.stem for path in CHECKER.glob("*.py")} == set(MODULES)
    for module, others in MODULES.items():
        text = (CHECKER / f"{module}.py").read_text(encoding="utf-8")
        used = set()
        for node in ast.walk(ast.parse(text)):
            if isinstance(node, ast.Import):
                used |= {name.name for name in node.names}
            elif isinstance(node, ast.ImportFrom):
                used.add(str(node.module).partition(".")[0])
            assert not (isinstance(node, ast.Constant) and isinstance(node.value, float)), module
            assert not (isinstance(node, ast.Name) and node.id == "float"), module
        assert used - OF_PYTHON == set(others.split()), module
        assert list(private_reads(text)) == [], module


def test_a_certificate_is_written_and_no_file_is_lost(tmp_path: Path) -> None:
    proven = run_of(WALL, None, v0=1, max_impacts=3)
    file = tmp_path / "a.json"
    pc.save_certificate(proven, file)

    assert json.loads(file.read_text()) == certificate(proven)
    with pytest.raises(OutputError, match=r"a\.json: exists already; force=True replaces it"):
        pc.save_certificate(proven, file)
    pc.save_certificate(proven, file, force=True)
    with pytest.raises(OutputError, match=r"a\.json"):
        pc.save_certificate(proven, file / "b.json")


@pytest.mark.parametrize(
    ("result", "reason"),
    [
        (
            lambda: 3,
            "not one of CertifiedRun, CertifiedOrbit, CertifiedPoint, CertifiedBranch, CertifiedChaos",
        ),
        (lambda: run_of(WALL, None, v0=1, t_end=1), "the run meets no stop"),
        (
            lambda: run_of(pc.impact_oscillator(0), pc.cosine(3), v0=1, t_end=9),
            "chatter, a contact or a graze",
        ),
        (
            lambda: run_of(
                pc.impact_oscillator(pc.expression("sqrt(1/2)")), None, v0=1, max_impacts=2
            ),
            "a number is irrational",
        ),
        (
            lambda: run_of(WALL, pc.square_wave("1.3"), v0=1, max_impacts=2),
            "its force has a record",
        ),
    ],
)
def test_what_has_no_certificate_says_why(result: Any, reason: str) -> None:
    with pytest.raises(ParameterError, match=reason):
        certificate(result())
