"""What the package keeps of the kernels' compilation, seen in a process that finds no other cache."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numba
import pytest
from numba.core import types

import percuss as pc
from percuss.kernels import intermediate_code, parts
from percuss.kernels.flight import Flight
from percuss.kernels.intermediate_code import TYPES, type_as_text, type_of_text
from percuss.kernels.march import march

LOCK = Path("requirements/dev.txt")
FIRST = """
import percuss as pc
from percuss.kernels.parts import compiled

run = pc.simulate(pc.impact_oscillator(restitution="0.8"), pc.cosine("2.8"), v0=1, t_end=50)
print(len(compiled), *(float(t).hex() for t in run.impacts.t))
"""


@pytest.fixture
def kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A copy of the package's file in its place, for a process that has not read it yet."""
    file = tmp_path / "intermediate-code.xz"
    file.write_bytes(intermediate_code.code_file().read_bytes())
    monkeypatch.setattr(intermediate_code, "code_file", lambda: file)
    intermediate_code.code.cache_clear()
    return file


@pytest.fixture(autouse=True)
def as_before() -> object:
    yield
    intermediate_code.code.cache_clear()


def test_the_file_is_that_of_the_kernels_and_of_the_locked_numba() -> None:
    file = Path(str(intermediate_code.code_file()))

    assert [each.name for each in file.parent.glob("*.xz")] == [file.name], "run make kernels"
    of, found = intermediate_code.unpacked(file.read_bytes())
    locked = re.search(r"^numba==(\d+\.\d+)", LOCK.read_text(), re.MULTILINE)
    assert locked is not None
    assert of["numba"] == locked[1], "run make kernels"
    modules = {part.function.rpartition(".")[0] for part in found.parts}
    assert {"percuss.kernels.flight", "percuss.kernels.structure.flight"} <= modules


def test_a_first_run_compiles_no_part_that_is_kept_and_has_the_same_bits(tmp_path: Path) -> None:
    settings: Any = numba.config
    if settings.DISABLE_JIT:
        pytest.skip("nothing is compiled")
    ended = subprocess.run(
        [sys.executable, "-c", FIRST],
        env=os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)},
        check=True,
        capture_output=True,
        text=True,
    )

    n_compiled, *t = ended.stdout.split()
    wall = pc.impact_oscillator(restitution="0.8")
    run = pc.simulate(wall, pc.cosine("2.8"), v0=1, t_end=50)
    assert t == [float(each).hex() for each in run.impacts.t]
    assert len(t) > 10
    if intermediate_code.code().parts and parts.has_fused_products():
        assert n_compiled == "0"
    else:
        assert int(n_compiled) > 100


def test_a_file_that_is_missing_or_damaged_is_as_none(kept: Path) -> None:
    whole = kept.read_bytes()
    for content in (b"", whole[:1000], whole[:-1], b"no " + whole):
        kept.write_bytes(content)
        intermediate_code.code.cache_clear()
        assert intermediate_code.code().parts == []
        with pytest.raises(ValueError, match="intermediate code"):
            intermediate_code.unpacked(content)

    kept.unlink()
    intermediate_code.code.cache_clear()

    assert intermediate_code.part_of(march, []) is None


def test_a_file_for_another_numba_or_processor_is_as_none(
    kept: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    of, found = intermediate_code.unpacked(kept.read_bytes())
    monkeypatch.setattr(intermediate_code, "machine", lambda: of)
    assert len(intermediate_code.code().parts) == len(found.parts) > 0

    for name in of:
        intermediate_code.code.cache_clear()
        monkeypatch.setattr(intermediate_code, "machine", lambda name=name: of | {name: "other"})
        assert intermediate_code.code().parts == []


def test_types_are_read_as_they_were_written() -> None:
    of: Any = types
    pair = of.UniTuple(of.float64, 2)
    mixed = of.Tuple((of.boolean, pair, of.Array(of.float64, 2, "C"), TYPES["Eight"]))
    named = of.BaseTuple.from_types((*mixed, pair), Flight)

    for each in (of.none, of.int64, pair, mixed, named):
        assert type_of_text(type_as_text(each)) == each
    with pytest.raises(KeyError):
        type_as_text(of.unicode_type)


def test_what_is_packed_is_unpacked() -> None:
    one = intermediate_code.Part("a.b", ["float64"], "float64", "_b", [], 3)
    two = intermediate_code.Part("", [], "", "_c", [0], 2)

    of, found = intermediate_code.unpacked(intermediate_code.packed([(one, b"abc"), (two, b"de")]))

    assert of == intermediate_code.machine()
    assert (found.parts, found.bitcode) == ([one, two], [b"abc", b"de"])
    assert found.places["a.b", ("float64",)] == 0
    assert of["numba"] == ".".join(numba.__version__.split(".")[:2])
