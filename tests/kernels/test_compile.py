"""The cache of compiled kernels, seen from one process to the next on a small package."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numba
import numpy as np
import pytest
from numba.core.caching import NullCache
from numba.core.compiler import Compiler
from numba.core.types.functions import BaseFunction
from tests.kernels.uncompiled import python_of

from percuss.kernels import compile as compile_module
from percuss.kernels import intermediate_code, parts, sources
from percuss.kernels.arithmetic import product_error

LEAF = """
from throwaway.compile import kernel

@kernel
def leaf(x):
    return {value} * x
"""
CALLER = """
from throwaway.compile import kernel
from throwaway.leaf import leaf

@kernel
def caller(x):
    return leaf(x) - 2.0
"""
CALL = """
import json, sys
from throwaway.caller import caller

value = caller(float(sys.argv[1]))
stats = caller.stats
print(json.dumps([value, sum(stats.cache_hits.values()), sum(stats.cache_misses.values()),
                  stats.cache_path]))
"""
KILLED_BEFORE_THE_CODE_IS_WRITTEN = """
import os
from numba.core.caching import IndexDataCacheFile
from throwaway.caller import caller

IndexDataCacheFile._save_data = lambda self, name, data: os._exit(9)
caller(1.0)
"""
AT_A_TERMINAL = """
import io, sys

class Terminal(io.StringIO):
    def isatty(self):
        return True

sys.stderr = Terminal()
"""
WHAT_WAS_SAID = """
assert (sys.stderr.getvalue().count("compiling") == 1) == (sum(stats.cache_misses.values()) == 1)
"""
CALL_ON_A_FULL_DISK = """
from numba.core.caching import IndexDataCacheFile

def refuse(self, name, data):
    raise OSError(28, "No space left on device")

IndexDataCacheFile._save_data = refuse
"""

WHAT_IS_LEFT_FOR_THE_COLLECTOR = """
import gc
from throwaway.caller import caller

if sys.argv[1] == "2.0":
    gc.freeze()
frozen, collections = gc.get_freeze_count(), gc.get_stats()[2]["collections"]
caller(1.0)
assert gc.isenabled()
if frozen:
    assert gc.get_freeze_count() > 0.9 * frozen
else:
    assert gc.get_freeze_count() == 0
    assert gc.get_stats()[2]["collections"] == collections
    assert gc.get_count()[0] < 1000
"""


@dataclass
class Called:
    """What one process computed, and how it came by its machine code."""

    value: float
    hits: int
    misses: int
    cache: Path | None


@dataclass
class Package:
    """A package of two kernels in two files, one calling the other, beside a user's folder."""

    root: Path

    @property
    def folder(self) -> Path:
        return self.root / "throwaway"

    @property
    def user_caches(self) -> Path:
        return self.root / "user" / "caches"

    def write_leaf(self, value: float) -> None:
        """Give the leaf's factor as an edit does that leaves the file's time as it was."""
        file = self.folder / "leaf.py"
        file.write_text(LEAF.format(value=value))
        os.utime(file, (1_000_000_000, 1_000_000_000))

    def run(
        self, script: str, x: float = 1.0, **environment: str
    ) -> subprocess.CompletedProcess[str]:
        inherited = {k: v for k, v in os.environ.items() if not k.startswith("NUMBA_")}
        home = str(self.root / "user")
        places = {"HOME": home, "USERPROFILE": home, "LOCALAPPDATA": str(self.user_caches)}
        return subprocess.run(
            [sys.executable, "-B", "-c", script, str(x)],
            cwd=self.root,
            env=inherited | places | {"XDG_CACHE_HOME": str(self.user_caches)} | environment,
            capture_output=True,
            text=True,
            check=False,
        )

    def call(self, x: float = 1.0, *, before: str = "", **environment: str) -> Called:
        """Call the caller in a new process."""
        done = self.run(before + CALL, x, **environment)
        assert done.returncode == 0, done.stderr
        value, hits, misses, cache = json.loads(done.stdout)
        return Called(value, hits, misses, None if cache is None else Path(cache))

    def cache_files(self, name: str) -> set[str]:
        return {file.name for file in (self.folder / "__pycache__").glob(f"{name}-*.nb[ci]")}


@pytest.fixture(scope="module")
def called_once(tmp_path_factory: pytest.TempPathFactory) -> Package:
    """A package whose kernels have been compiled, to be copied."""
    made = written(tmp_path_factory.mktemp("compiled"))
    made.call()
    return made


@pytest.fixture
def compiled(called_once: Package, tmp_path: Path) -> Package:
    """A package of the test's own whose kernels have been compiled, its files as old as they were."""
    shutil.copytree(called_once.root, tmp_path, dirs_exist_ok=True)
    return Package(tmp_path)


@pytest.fixture
def package(tmp_path: Path) -> Package:
    return written(tmp_path)


def written(root: Path) -> Package:
    made = Package(root)
    made.folder.mkdir()
    (made.folder / "__init__.py").touch()
    for module in (compile_module, parts, intermediate_code, sources):
        file = Path(str(module.__file__))
        text = file.read_text().replace("percuss.kernels", "throwaway")
        (made.folder / file.name).write_text(text)
    (made.folder / "caller.py").write_text(CALLER)
    made.write_leaf(-2.0)
    return made


def take_away(folder: Path) -> None:
    """Make a folder of caches impossible to create, for root too: a file has its name."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.write_text("no folder")


def test_the_second_process_loads_what_the_first_compiled(package: Package) -> None:
    first = package.call(1.0)
    second = package.call(3.0)

    assert (first.value, first.hits, first.misses) == (-4.0, 0, 1)
    assert (second.value, second.hits, second.misses) == (-8.0, 1, 0)
    assert second.cache == package.folder / "__pycache__"


def test_a_copy_finds_what_was_compiled(compiled: Package) -> None:
    """Or the tests below would compile in any case."""
    assert compiled.call().hits == 1


def test_an_edit_of_a_callee_in_another_file_reaches_the_compiled_caller(package: Package) -> None:
    """The file's time is unchanged, as it is for all files of a wheel built reproducibly."""
    assert package.call(10.0).value == -22.0

    package.write_leaf(-3.0)

    edited = package.call(10.0)
    assert (edited.value, edited.misses) == (-32.0, 1)
    assert package.call(10.0).hits == 1


def test_a_file_added_to_the_kernels_makes_them_compile_anew(compiled: Package) -> None:
    (compiled.folder / "added.py").touch()

    assert compiled.call().misses == 1


def test_files_compiled_from_older_sources_are_removed(compiled: Package) -> None:
    older = compiled.cache_files("caller.caller")
    compiled.write_leaf(-3.0)

    compiled.call()

    newer = compiled.cache_files("caller.caller")
    assert len(older) == len(newer) == 2
    assert not older & newer


def test_a_process_killed_while_it_saves_leaves_no_stale_code(compiled: Package) -> None:
    """numba writes the new index first: for a moment it names the old machine code as new."""
    compiled.write_leaf(-3.0)

    assert compiled.run(KILLED_BEFORE_THE_CODE_IS_WRITTEN).returncode == 9

    assert compiled.call(10.0).value == -32.0
    assert compiled.call(10.0).hits == 1


@pytest.mark.parametrize(("suffix", "kept"), [("nbi", 0), ("nbi", 100), ("nbc", 1000)])
def test_a_damaged_cache_file_is_compiled_anew(compiled: Package, suffix: str, kept: int) -> None:
    for file in (compiled.folder / "__pycache__").glob(f"*.{suffix}"):
        file.write_bytes(file.read_bytes()[:kept])

    assert compiled.call(10.0).value == -22.0
    assert compiled.call(10.0).hits == 1


def test_a_full_disk_costs_the_cache_and_not_the_answer(package: Package) -> None:
    full = package.call(10.0, before=CALL_ON_A_FULL_DISK)

    assert (full.value, full.hits, full.misses) == (-22.0, 0, 1)


def test_a_package_that_cannot_be_written_is_cached_in_the_folder_of_the_user(
    package: Package,
) -> None:
    take_away(package.folder / "__pycache__")

    first = package.call(10.0)
    second = package.call(10.0)

    assert (first.value, second.value, second.hits) == (-22.0, -22.0, 1)
    assert second.cache is not None
    assert package.root / "user" in second.cache.parents


def test_without_any_folder_to_write_to_each_process_compiles(package: Package) -> None:
    take_away(package.folder / "__pycache__")
    take_away(package.root / "user")

    first = package.call(10.0)
    second = package.call(10.0)

    assert (first.value, second.value) == (-22.0, -22.0)
    assert (second.hits, second.misses, second.cache) == (0, 1, None)


def test_the_cache_folder_that_the_user_names_is_used(package: Package) -> None:
    named = package.root / "named"

    package.call(NUMBA_CACHE_DIR=str(named))
    package.write_leaf(-3.0)

    edited = package.call(10.0, NUMBA_CACHE_DIR=str(named))
    assert (edited.value, edited.hits) == (-32.0, 0)
    assert edited.cache is not None
    assert named in edited.cache.parents
    assert not package.cache_files("caller.caller")


@pytest.mark.parametrize("x", [1.0, 2.0])
def test_what_compiling_has_left_is_collected_when_all_is_and_what_was_frozen_stays_so(
    package: Package, x: float
) -> None:
    package.call(x, before="import sys\n" + WHAT_IS_LEFT_FOR_THE_COLLECTOR)


def test_with_the_compiler_off_a_kernel_is_the_function_itself(package: Package) -> None:
    script = """
import types
from throwaway.caller import caller

assert isinstance(caller, types.FunctionType)
assert caller(10.0) == -22.0
"""

    done = package.run(script, NUMBA_DISABLE_JIT="1")

    assert done.returncode == 0, done.stderr


def test_someone_at_a_terminal_is_told_of_the_wait_once(package: Package) -> None:
    for misses in (1, 0):
        done = package.run(AT_A_TERMINAL + CALL + WHAT_WAS_SAID)

        assert done.returncode == 0, done.stderr
        assert json.loads(done.stdout)[2] == misses

    assert package.run(CALL).stderr == ""


def test_only_what_python_calls_has_machine_code(package: Package) -> None:
    package.call()

    assert package.cache_files("caller.caller")
    assert not package.cache_files("leaf.leaf")


def test_a_kernel_called_by_kernels_can_be_called_from_python_too() -> None:
    @compile_module.kernel
    def half(x: float) -> float:
        return 0.5 * x

    @compile_module.kernel
    def quarter(x: float) -> float:
        return half(half(x))

    assert (quarter(8.0), half(8.0), quarter(1), half(1)) == (2.0, 4.0, 0.25, 0.5)


def test_a_cold_kernel_stays_a_call_of_its_caller() -> None:
    @compile_module.cold
    def of_a_cold_path(x: float) -> float:
        return x * x + 1.0

    @compile_module.kernel
    def of_a_warm_one(x: float) -> float:
        return x * x + 2.0

    @compile_module.kernel
    def caller(x: float) -> float:
        return of_a_cold_path(x) if x > 2.0 else of_a_warm_one(x)

    assert (caller(3.0), caller(2.0)) == (10.0, 6.0)
    compiled: Any = caller
    if hasattr(compiled, "inspect_llvm"):
        (text,) = compiled.inspect_llvm().values()
        calls = [line for line in text.splitlines() if " call " in line]
        assert any("of_a_cold_path" in line for line in calls)
        assert not any("of_a_warm_one" in line for line in calls)


def test_code_for_other_processors_has_no_part_that_was_made_for_this_one() -> None:
    if not parts.has_fused_products():
        pytest.skip("both are made of the same instructions")

    @compile_module.kernel
    def error(x: float) -> float:
        return product_error(x, x, x * x)

    def errors(x: float) -> float:
        return error(x) + error(x + 1.0)

    njit: Any = numba.njit
    here, portable = njit(errors), njit(errors)
    value = here(1.1)
    token = parts.is_portable.set(True)
    try:
        assert portable(1.1) == value
    finally:
        parts.is_portable.reset(token)

    (text,) = here.inspect_llvm().values()
    assert "llvm.fma" in text
    (text,) = portable.inspect_llvm().values()
    assert "llvm.fma" not in text


def test_an_operator_is_looked_up_once_for_its_types_and_numba_is_left_as_it_was(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    asked: list[Any] = []
    functions: Any = BaseFunction
    of_numba = functions.get_call_type

    def noted(self: Any, context: Any, args: Any, kws: Any) -> Any:
        asked.append((self, tuple(args)))
        return of_numba(self, context, args, kws)

    monkeypatch.setattr(BaseFunction, "get_call_type", noted)
    settings: Any = numba.config
    if settings.DISABLE_JIT:
        pytest.skip("nothing is compiled")
    monkeypatch.setattr(compile_module, "_MEANT", {})

    @compile_module.kernel
    def added(z: complex) -> complex:
        return z + z + (z + z) + (z + (z + z))

    @compile_module.kernel
    def unknown(z: complex) -> bool:
        return z < 1j  # type: ignore[operator, no-any-return]

    compiled: Any = added
    # A run of the tests before this one has kept it.
    compiled._cache = NullCache()
    assert added(1j) == 7j
    assert len(asked) == len(set(asked)) > 0
    with pytest.raises(numba.TypingError, match="complex128"):
        unknown(1j)
    assert functions.get_call_type is noted


def test_the_python_function_behind_a_kernel_gives_the_same_value() -> None:
    @compile_module.kernel
    def cubed(x: float) -> float:
        return x * x * x

    assert python_of(cubed)(0.1) == cubed(0.1)
    assert python_of(cubed) is not cubed


def test_a_division_by_zero_in_a_kernel_is_infinite() -> None:
    @compile_module.kernel
    def inverse(x: float) -> float:
        return 1.0 / x

    assert inverse(0.0) == float("inf")


def test_the_steps_of_a_loop_over_coordinates_are_not_written_out() -> None:
    def total(x: list[float]) -> float:
        total = 0.0
        for i in range(len(x)):
            total += x[i]
        return total

    def n_additions(compiler: type[Compiler]) -> int:
        njit: Any = numba.njit
        compiled = njit(pipeline_class=compiler)(total)
        assert compiled(np.array([1.0, 2.0, 4.0])) == 7.0
        (code,) = compiled.inspect_llvm().values()
        return str(code).count(" fadd ")

    assert n_additions(parts.RolledCompiler) == 1 < n_additions(Compiler)


def test_compiled_kernels_are_loaded_without_what_compiling_needs(compiled: Package) -> None:
    """numba's modules for it take a quarter of a second to import."""
    script = "import sys\nfrom throwaway.caller import caller\ncaller(1.0)\nprint('numba.np.arrayobj' in sys.modules)"

    assert compiled.run(script).stdout == "False\n"
