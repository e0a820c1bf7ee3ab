"""Rules of the package that no tool checks; what still breaks one is counted, and may only shrink.

Lower a number here when you lower its count; where nothing is left, delete the entry.
"""

from __future__ import annotations

import ast
import importlib
import re
import sys
from collections import Counter
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from types import FrameType, ModuleType

import grimp
import pytest

import percuss
import percuss as pc
from percuss.certified import tables
from percuss.cli import app
from percuss.kernels import march
from percuss.motion.structures import StructureImpacts
from percuss.studies import running

ROOT = Path(percuss.__file__).parent
TESTS = Path(__file__).parent

# Reads of another module's `_name`, for each package.
PRIVATE_READS = {
    # Dask's public way to cancel chunks waits without end for a scheduler that is frozen.
    "ensembles": 1,
    # numba has no public name for the machine that it compiles for.
    "kernels": 1,
}
# Names of types that are defined twice: a kind of study has the name of what it returns.
TYPES = {"Branch": 2, "Curve": 2, "Design": 2, "Fit": 2, "Response": 2}
# Modules that a motion study runs through from the command line to the first call of the kernel,
# and those of them whose functions call one another down to it: the others return before.
MODULES_OF_A_STUDY, MODULES_THAT_CALL = 21, 5
# What NamedTuple gives to all, behind an underscore that keeps it apart from the fields.
PUBLIC = {"_asdict", "_field_defaults", "_fields", "_make", "_replace"}

# Where a module may read what is private to others, or import it, in a line or one of several in
# brackets. It may find too much, never too little.
MAY_READ = re.compile(
    r"(?<![^.\w]self)(?<![^.\w]cls)\._\w|\bimport\b.*\b_\w|^ +_\w+(?: as \w+)?,?\s*(?:#.*)?$",
    re.MULTILINE,
)
# Classes anywhere; type aliases and variables, which begin with a capital and have a small letter.
TYPE = re.compile(r"^ *class (\w+)[(:\[]|^(_*[A-Z]\w*)(?:: .+?)? = ", re.MULTILINE)


@cache
def modules() -> dict[Path, str]:
    """Return the texts of all modules by their path in the package."""
    return {
        file.relative_to(ROOT): file.read_text(encoding="utf-8")
        for file in sorted(ROOT.rglob("*.py"))
    }


def is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__") and name not in PUBLIC


def names_made(tree: ast.Module) -> set[str]:
    """Return all names that a module defines: functions, classes, variables and attributes."""
    made: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            made.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            made.add(node.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.ctx, ast.Store):
            made.add(node.attr)
    return made


def private_reads(text: str) -> Iterator[str]:
    """Yield each `value._name` and each import of a `_name` that the module does not define."""
    if not MAY_READ.search(text):
        # Of most modules no syntax tree is made, which takes as long as all else.
        return
    tree = ast.parse(text)
    read: list[ast.Attribute] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            yield from (
                f"{node.lineno}: from {node.module} import {imported.name}"
                for imported in node.names
                if is_private(imported.name)
            )
        elif isinstance(node, ast.Attribute) and is_private(node.attr):
            own = isinstance(node.value, ast.Name) and node.value.id in {"self", "cls"}
            read += [] if own else [node]
    made = names_made(tree) if read else set()
    yield from (f"{each.lineno}: {ast.unparse(each)}" for each in read if each.attr not in made)


def type_names(text: str) -> Iterator[str]:
    """Yield the names of the classes of a module, and those of its type aliases and variables."""
    for of_class, of_alias in TYPE.findall(text):
        if of_class or not of_alias.isupper():
            yield of_class or of_alias


def test_no_module_reads_the_private_names_of_another() -> None:
    found: dict[str, list[str]] = {}
    for path, text in modules().items():
        reads = [f"{path}:{read}" for read in private_reads(text)]
        found.setdefault(path.parts[0], []).extend(reads)

    more = {name: reads for name, reads in found.items() if len(reads) > PRIVATE_READS.get(name, 0)}
    assert more == {}


def test_no_name_of_a_type_is_defined_twice() -> None:
    count = Counter(name for text in modules().values() for name in type_names(text))

    assert {name: n for name, n in count.items() if n > TYPES.get(name, 1)} == {}


def test_no_module_imports_itself_by_way_of_others() -> None:
    graph = grimp.build_graph("percuss", cache_dir=None)
    # The package itself imports its parts on demand, which is no circle.
    circles = {
        frozenset(graph.find_upstream_modules(name) & graph.find_downstream_modules(name) | {name})
        for name in graph.modules - {"percuss"}
    }

    assert [circle for circle in circles if len(circle) > 1] == []


class EnteredKernel(BaseException):
    """Ends a run where the kernel would begin; no handler of the command line stops it."""


def test_a_study_runs_through_few_modules_on_its_way_to_the_kernel(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    files: set[Path] = set()
    calling: set[Path] = set()
    importing = 0

    def note(frame: FrameType, event: str, _: object) -> None:
        nonlocal importing
        if frame.f_code.co_name == "<module>":
            # What runs when a module is imported does so whatever is asked.
            importing += {"call": 1, "return": -1}.get(event, 0)
        elif event == "call" and not importing:
            file = Path(frame.f_code.co_filename)
            if file.is_relative_to(ROOT):
                files.add(file.relative_to(ROOT))

    def enter(*_: object) -> None:
        frame: FrameType | None = sys._getframe()
        while frame is not None:
            file = Path(frame.f_code.co_filename)
            if file.is_relative_to(ROOT):
                calling.add(file.relative_to(ROOT))
            frame = frame.f_back
        raise EnteredKernel

    monkeypatch.setattr(march, "march", enter)
    # A motion of its own, which compiles the kernels.
    monkeypatch.setattr(running, "simulate", lambda *_, **__: None)
    study = ROOT.parents[1] / "examples" / "mooring.toml"

    def run() -> None:
        with pytest.raises(EnteredKernel):
            app(["run", str(study), "--out", str(tmp_path / "out")], standalone_mode=False)

    # The first time small kernels are compiled or loaded, unless a test before has called them.
    run()
    before = sys.getprofile()
    sys.setprofile(note)
    try:
        run()
    finally:
        sys.setprofile(before)

    assert len(files) <= MODULES_OF_A_STUDY, "\n".join(sorted(map(str, files)))
    assert len(calling) <= MODULES_THAT_CALL, "\n".join(sorted(map(str, calling)))


def test_each_long_test_is_there() -> None:
    lines = (TESTS / "long_tests.txt").read_text(encoding="utf-8").splitlines()
    cases = [line for line in lines if not line.startswith("#")]

    assert cases == sorted(set(cases))
    for case in cases:
        file, _, name = case.partition("::")
        function = f"def {name.partition('[')[0]}("
        assert function in (TESTS / file).read_text(encoding="utf-8"), case


def test_a_private_read_is_found_wherever_it_stands() -> None:
    """Names that the module itself defines, its own attributes and those of NamedTuple pass."""
    text = (
        "from other import _a, b\n"
        "from other import (\n    _d,  # why\n    e,\n)\n"
        "class Own:\n    _own = 1\n    def f(self): return self._x, b.one._own, b._fields, b._c\n"
    )

    assert list(private_reads(text)) == [
        "1: from other import _a", "2: from other import _d", "8: b._c",
    ]  # fmt: skip
    assert list(private_reads("from a import (\n    _d as d,\n)\n")) == ["1: from a import _d"]
    for text in ("a.b._c", "a.self._c", "myself._c", "f(a)._c"):
        assert list(private_reads(f"x = {text}\n")) == [f"1: {text}"]


def test_a_type_is_found_wherever_it_stands() -> None:
    text = "Floats: TypeAlias = int\n_Real = float\nMOST = 1\nfew = 2\nclass A:\n    class B(C): pass\n    D = 3\n"

    assert list(type_names(text)) == ["Floats", "_Real", "A", "B"]


SUBPACKAGES = ("certified", "ensembles", "errors", "io", "model", "motion", "optimization", "orbits",
               "plotting", "studies")  # fmt: skip


@pytest.mark.parametrize("name", ["", *SUBPACKAGES])
def test_a_prompt_completes_public_names_alone(name: str) -> None:
    package = importlib.import_module(f"percuss.{name}".rstrip("."))
    names = dir(package)
    modules = {each for each in names if isinstance(getattr(package, each), ModuleType)}

    assert {"annotations", "find_spec", "public_names"}.isdisjoint(names)
    assert not any(each.startswith("_") for each in names if each != "__version__")
    assert not modules or package is percuss


@pytest.mark.parametrize(
    "kind",
    [
        pc.Contacts, pc.Crossings, pc.Grazes, pc.Impacts, pc.LyapunovExponents, pc.orbits.Passages,
        pc.orbits.SingleImpact, StructureImpacts, tables.CertifiedContacts,
        tables.CertifiedCrossings, tables.CertifiedGrazes, tables.CertifiedImpacts,
    ],
)  # fmt: skip
def test_a_result_of_arrays_is_equal_to_itself_alone(kind: type) -> None:
    """As `Trajectory`: the fields compared, ``==`` would end in "the truth value ... is ambiguous"."""
    assert "__eq__" not in vars(kind)
    assert "__hash__" not in vars(kind)
