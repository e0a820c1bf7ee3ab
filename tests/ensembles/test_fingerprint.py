"""What counts when a store is asked whether a function is the one it was begun with."""

from __future__ import annotations

import functools
import importlib
import json
import os
import subprocess
import sys
import threading
from collections import namedtuple
from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.fingerprint import fingerprint

OSC, FORCE = pc.impact_oscillator("0.8"), pc.cosine(2.5)
OVER = {"forcing.omega": [2.4, 2.5]}
SCALE: Any = 1.0
LOCK: Any = threading.Lock()


class Colour(Enum):
    red = 1
    green = 2


Pair = namedtuple("Pair", "a b")


@dataclass(frozen=True, slots=True)
class Scaled:
    k: Any

    def __call__(self, osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG002
        return float(self.k)


class Counter:
    def __init__(self, k: Any) -> None:
        self.k = k

    @functools.cached_property
    def twice(self) -> Any:
        return self.k * 2

    def take(self, osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG002
        return float(self.k)


def closed(k: Any) -> Callable[..., float]:
    def measure(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
        return float(k)

    return measure


def nested(k: Any) -> Callable[..., float]:
    def inner() -> float:
        return float(k)

    def measure(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
        return inner()

    return measure


def with_default(k: Any) -> Callable[..., float]:
    def measure(osc: pc.Oscillator, force: pc.Forcing, *, k: Any = k) -> float:  # noqa: ARG001
        return float(k)

    return measure


def three(k: Any, osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    return float(k)


def nested_in(inner: Callable[..., float]) -> Callable[..., float]:
    def measure(osc: pc.Oscillator, force: pc.Forcing) -> float:
        return inner(osc, force)

    return measure


def helper_of_one(x: float) -> float:
    return x / 3.0


def helper() -> float:
    return float(SCALE)


def with_an_attribute(osc: Any, force: Any) -> float:  # noqa: ARG001
    """Its attribute has the name of a variable of the module that it does not read."""
    return float(np.zeros((2, 2))[..., 0].sum()) + float(osc.LOCK)


def by_helper(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    return helper()


def recursive(osc: pc.Oscillator, force: pc.Forcing, n: int = 3) -> float:
    return 0.0 if n == 0 else recursive(osc, force, n - 1)


def locked(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    with LOCK:
        return 0.0


def with_numpy(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    return float(np.sin(1.0)) + float(np.random.default_rng(1).normal())


MAKERS: dict[str, Callable[[Any], Callable[..., float]]] = {
    "closure": closed,
    "closure of a closure": nested,
    "default": with_default,
    "partial": lambda k: functools.partial(three, k),
    "partial by name": lambda k: functools.partial(with_default(0), k=k),
    "numba": lambda k: numba.njit(closed(k)),
    "numba in a closure": lambda k: nested_in(numba.njit(closed(k))),
}


@pytest.mark.parametrize("how", MAKERS)
def test_every_value_that_a_function_reads_counts(how: str) -> None:
    make = MAKERS[how]

    assert fingerprint(make(3.0)) == fingerprint(make(3.0))
    assert fingerprint(make(3.0)) != fingerprint(make(5.0))
    assert fingerprint(make(3.0)) != fingerprint(make(3))


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("a", b"a"),
        ((1, 2), [1, 2]),
        ({1, 2}, {1, 3}),
        ({"a": 1}, {"a": 2}),
        (np.arange(3), np.arange(3.0)),
        (np.arange(4), np.arange(4).reshape(2, 2)),
        (np.float32(1.0), np.float64(1.0)),
        (Fraction(1, 3), Fraction(1, 2)),
        (OSC, pc.impact_oscillator("0.9")),
        (0.0, -0.0),
        (np.sin, np.cos),
        ({"a": [1, {"b": (2, 3)}]}, {"a": [1, {"b": (2, 4)}]}),
        (range(3), range(4)),
        (Path("a"), Path("b")),
        (slice(3), slice(4)),
        (np, np.linalg),
        (pc.sweep, pc.basins),
        (dict, list),
        (lambda a, b: a, lambda a, *, b: a),  # noqa: ARG005
        (np.arange(6).reshape(2, 3), np.arange(6).reshape(2, 3).T.copy()),
        (numba.njit(helper_of_one), numba.njit(helper_of_one, fastmath=True)),
        (functools.partial(three, 1.0), functools.partial(three, 2.0)),
        (nested(1.0), nested(2.0)),
    ],
)
def test_values_of_many_kinds_are_distinguished(one: Any, other: Any) -> None:
    assert fingerprint(closed(one)) == fingerprint(closed(one))
    assert fingerprint(closed(one)) != fingerprint(closed(other))


def test_a_variable_of_the_module_counts_through_a_helper(monkeypatch: pytest.MonkeyPatch) -> None:
    before = fingerprint(by_helper)
    monkeypatch.setitem(globals(), "SCALE", 2.0)

    assert fingerprint(by_helper) != before


def test_functions_on_one_line_and_without_text_are_distinguished() -> None:
    one, other = lambda osc, force: 1.0, lambda osc, force: 2.0  # noqa: ARG005
    # As in a session, where there is no file to read the text from.
    first, second = (eval(compile(f"lambda o, f: {k}.0", "<session>", "eval")) for k in (1, 2))

    assert fingerprint(one) != fingerprint(other)
    assert fingerprint(first) != fingerprint(second)


@pytest.mark.parametrize("read", ["late.law", "folder.late.law", "late", "from late"])
def test_functions_of_the_users_modules_count_however_they_are_reached(
    read: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the name of their module, in a folder without an __init__, or imported in the call."""
    (tmp_path / "folder").mkdir()
    for file in (tmp_path / "late.py", tmp_path / "folder" / "late.py"):
        file.write_text("def law(): return 1.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    spaces: list[dict[str, Any]] = [{}, {}]
    text = {
        "late.law": "import late\ndef measure(osc, force): return late.law()",
        "folder.late.law": "import folder.late\ndef measure(o, f): return folder.late.law()",
        "late": "def measure(osc, force):\n import late\n return late.law()",
        "from late": "def measure(osc, force):\n from late import law\n return law()",
    }[read]
    for space in spaces:
        exec(text, space)  # noqa: S102
    one, same = (fingerprint(space["measure"]) for space in spaces)
    module = sys.modules["folder.late" if read.startswith("folder") else "late"]
    exec("def law(): return 2.0", vars(module))  # noqa: S102
    other = fingerprint(spaces[0]["measure"])
    for name in ("late", "folder", "folder.late"):
        sys.modules.pop(name, None)

    assert one == same
    assert one != other


def test_the_code_that_runs_counts_and_not_a_newer_text(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = tmp_path / "edited.py"
    file.write_text("def measure(osc, force): return 1.0\n")
    monkeypatch.syspath_prepend(tmp_path)
    module = importlib.import_module("edited")
    monkeypatch.setitem(sys.modules, "edited", module)
    before = fingerprint(module.measure)
    file.write_text("# A remark.\ndef measure(osc, force): return 23.0\n")
    still = fingerprint(module.measure)
    exec(compile(file.read_text(), str(file), "exec"), vars(module))  # noqa: S102

    assert still == before
    assert fingerprint(module.measure) != before


def test_an_attribute_is_no_variable_of_the_module() -> None:
    assert set(fingerprint(with_an_attribute)) == {"measure.code", "measure.np"}


def test_a_function_that_calls_itself_has_a_fingerprint() -> None:
    assert fingerprint(recursive) == fingerprint(recursive)


def test_it_is_the_same_in_another_process() -> None:
    """With another seed of hashes, which orders sets anew."""
    program = (
        "import json; from tests.ensembles import test_fingerprint as t\n"
        "print(json.dumps([t.fingerprint(f) for f in t.samples()]))"
    )
    # This process has a seed by chance.
    elsewhere = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True, text=True, check=True, cwd=Path(__file__).parents[2],
        env={**os.environ, "PYTHONHASHSEED": "1"},
    ).stdout  # fmt: skip

    assert json.loads(elsewhere) == [fingerprint(function) for function in samples()]


def samples() -> list[Callable[..., float]]:
    words = {"one", "two", "three", "four", "five"}
    values = (words, {"k": words}, OSC, (1, words), np.arange(3), nested(1.0), Fraction(1, 3))
    made = [closed(value) for value in values]
    return [*made, by_helper, recursive, with_numpy, numba.njit(closed(words))]


def in_itself() -> list[Any]:
    loop: list[Any] = []
    loop.append(loop)
    return loop


@pytest.mark.parametrize(
    "value",
    [
        threading.Lock(),
        (str(x) for x in range(2)),
        {1: threading.Lock()},
        Scaled(1.0),
        Scaled,
        Counter(1).take,
        Pair(1, 2),
        Colour.red,
        functools.lru_cache(helper),
        np.random.default_rng(1),
        [].append,
        np.array([Fraction(1, 3)], dtype=object),
        np.ma.masked_array([1.0, 2.0], [True, False]),
        in_itself(),
    ],
    ids=lambda value: type(value).__name__,
)
def test_a_value_without_comparable_content_is_refused(value: Any) -> None:
    with pytest.raises(pc.ParameterError, match=r"reads 'k', .*leave out store="):
        fingerprint(closed(value))


@pytest.mark.parametrize("measure", [Scaled(1.0), Counter(1).take, functools.lru_cache(by_helper)])
def test_a_measure_that_is_no_function_is_refused(measure: Any) -> None:
    with pytest.raises(pc.ParameterError, match=r"is a .*leave out store="):
        fingerprint(measure)


def test_only_a_store_needs_the_fingerprint(tmp_path: Path) -> None:
    assert pc.sweep(locked, OSC, FORCE, over=OVER).attrs["complete"] == 1
    with pytest.raises(pc.ParameterError, match=r"reads 'LOCK', a lock, .*leave out store="):
        pc.sweep(locked, OSC, FORCE, over=OVER, store=tmp_path / "a.zarr")
    assert not (tmp_path / "a.zarr").exists()


def test_a_store_does_not_answer_for_another_function(tmp_path: Path) -> None:
    path = tmp_path / "a.zarr"
    data = pc.sweep(closed(3.0), OSC, FORCE, over=OVER, store=path)

    with pytest.raises(pc.OutputError, match=r"another study, which differs in measure\.k"):
        pc.sweep(closed(5.0), OSC, FORCE, over=OVER, store=path)
    assert pc.sweep(closed(3.0), OSC, FORCE, over=OVER, store=path).identical(data)
