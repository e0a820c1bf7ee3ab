"""The decorator of every kernel, and its cache.

numba keeps the machine code of a function beside a stamp of the one file that holds it, but that
machine code has its callees inlined: an edit of a callee's file leaves the caller stale, silently.
Here the name of each cache file carries a hash of all kernel files instead, so code that was
compiled from other text is never found (docs/decisions/002-compile-cache.md).
"""

from __future__ import annotations

import builtins
import contextlib
import functools
import gc
import sys
import types
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numba
import numba.extending
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.compiler import Compiler
from numba.core.compiler_lock import global_compiler_lock
from numba.core.types.functions import BaseFunction

from percuss.kernels.parts import RolledCompiler, as_part, has_fused_products
from percuss.kernels.sources import sources_hash

P = ParamSpec("P")
R = TypeVar("R")
# `_nrt` is numba's switch for its counted references: kernels allocate nothing, and without it
# they do not count each array that they hand on, which took most of their time.
OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",
    "fastmath": False,
    "_nrt": False,
    # Kernels are called by name, never through a C pointer: a tenth less to compile.
    "no_cfunc_wrapper": True,
    # Said for each: a function that is compiled for a `formula` would take this over from it.
    "forceinline": False,
}

# The signatures that numba has found, by what it was asked: an operator and the types it is given.
_MEANT: dict[tuple[Any, ...], Any] = {}


@functools.cache
def _announce_compilation() -> None:
    """Explain at a terminal or in a notebook, once a process, why the first call takes long."""
    terminal = sys.stderr is not None and sys.stderr.isatty()
    if terminal or hasattr(builtins, "__IPYTHON__"):
        sys.stderr.write("percuss: compiling (some seconds, once for an installation)\n")


class _NamedBySources(CompileResultCacheImpl):
    """Puts the hash of the sources into the names of a kernel's cache files."""

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        return str(super().get_filename_base(f"{fullname}-{sources_hash()}", abiflags))


class KernelCache(FunctionCache):
    """The cache of one kernel; where it fails, the kernel is compiled as if there were none."""

    _impl_class = _NamedBySources

    def load_overload(self, sig: object, target_context: object) -> object:
        """Load machine code; return None where no file of it can be used."""
        overload = None
        try:
            # numba's own loads all that compiling needs first, a quarter of a second.
            with self._guard_against_spurious_io_errors():
                overload = self._load_overload(sig, target_context)
        except Exception:  # noqa: BLE001  a damaged file raises whatever unpickling it leads to
            with contextlib.suppress(OSError):
                self.flush()
        if overload is None:
            _announce_compilation()
        return overload

    def save_overload(self, sig: object, data: object) -> None:
        """Save machine code where that is possible, and remove what has become stale."""
        # The disk may be full, or the folder taken away since the function was decorated.
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)
            self._remove_files_of_other_sources()

    def _remove_files_of_other_sources(self) -> None:
        name, _ = self._impl.filename_base.split(f"-{sources_hash()}-")
        for file in Path(self.cache_path).glob(f"{name}-*-*.nb[ci]"):
            if not file.name.startswith(f"{name}-{sources_hash()}-"):
                # Another process may have removed it first.
                file.unlink(missing_ok=True)


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function of numbers at its first call, and keep the machine code on disk.

    A kernel that another one calls becomes part of that one's machine code; only one that is
    called from Python gets machine code of its own. Kernels release the GIL, follow IEEE 754 (a
    division by zero is infinite or NaN) and are never reordered by the compiler. With
    ``NUMBA_DISABLE_JIT=1`` the function itself is returned.

    The machine code lies in ``NUMBA_CACHE_DIR`` where the user has set it, else beside the source,
    else in numba's folder for the user; where none can be written, each process compiles anew.

    Parameters
    ----------
    function
        Takes and returns numbers, arrays and tuples of them, calls only `math`, NumPy and other
        kernels.

    Returns
    -------
    Callable
        Called as the function is.

    Examples
    --------
    >>> @kernel
    ... def reflected(v: float, restitution: float) -> float:
    ...     return -restitution * v
    >>> reflected(-2.0, 0.5)
    1.0
    """
    return _compiled(function, OPTIONS)


def formula(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that is written out wherever it is called.

    For any other kernel the compiler weighs whether to write it out or to call it. A loop of
    formulas becomes vector instructions, where one with a call in it handles one number at a time;
    and a general flight saves a call in each of its hottest functions.

    Parameters
    ----------
    function
        Takes and returns numbers and tuples of them.

    Returns
    -------
    Callable
        Called as the function is.

    Examples
    --------
    >>> @formula
    ... def energy(x: float, v: float) -> float:
    ...     return 0.5 * (x * x + v * v)
    >>> energy(1.0, 1.0)
    1.0
    """
    return _compiled(function, OPTIONS | {"forceinline": True})


def cold(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that is called seldom, and is never written out where it is called.

    What most calls of a loop pass by takes registers from the loop where it is written out: the
    forces of records so slowed motions that have none. The arguments are numbers, or few arrays,
    for they are kept at hand on the way to the call.

    Parameters
    ----------
    function
        As that of `kernel`.

    Returns
    -------
    Callable
        Called as the function is.

    Examples
    --------
    >>> @cold
    ... def series(x: float) -> float:
    ...     return x - x**3 / 6.0
    >>> series(0.0)
    0.0
    """
    return _compiled(function, OPTIONS, is_cold=True)


def error_of_product(function: Callable[P, R]) -> Callable[P, R]:
    """Let kernels take one instruction, where there is one, for the rounding error of a product.

    That error is a double, so that the instruction and the function give the same bits, for all
    products that neither overflow nor come near the least doubles.

    Parameters
    ----------
    function
        Takes (a, b, c), where c is a * b rounded, and returns a * b - c by sums and products.

    Returns
    -------
    Callable
        The function itself.
    """
    extending: Any = numba.extending
    real = numba.types.float64

    def typed(_context: object) -> Any:
        return lambda _a, _b, _c: real

    def lowered(context: Any, builder: Any, signature: Any, given: Any) -> Any:
        if has_fused_products():
            return builder.fma(given[0], given[1], builder.fneg(given[2]))
        return context.compile_internal(builder, function, signature, given)

    extending.type_callable(function)(typed)
    extending.lower_builtin(function, real, real, real)(lowered)
    return function


@functools.cache
def uncompiled(function: Callable[P, R]) -> Callable[P, R]:
    """Return a kernel as plain Python, those that it calls included.

    It gives the same bits without the wait for the compiler, for a few numbers.

    Parameters
    ----------
    function
        The kernel.

    Returns
    -------
    Callable
        Called as the kernel is.
    """
    plain: Any = getattr(function, "py_func", function)
    names = {
        name: uncompiled(plain.__globals__[name])
        for name in plain.__code__.co_names
        if hasattr(plain.__globals__.get(name), "py_func")
    }
    around = {**plain.__globals__, **names}
    return cast("Callable[P, R]", types.FunctionType(plain.__code__, around, plain.__name__))


def _compiled(
    function: Callable[P, R], options: dict[str, Any], is_cold: bool = False
) -> Callable[P, R]:
    is_of_structures = function.__module__.startswith("percuss.kernels.structure.")
    compiler = RolledCompiler if is_of_structures else Compiler
    compiled: Any = numba.njit(pipeline_class=compiler, **options)(function)
    # With the compiler off it is the function itself.
    if hasattr(compiled, "py_func"):
        # numba refuses a function for which it finds no writable folder, or no file (a prompt).
        with contextlib.suppress(RuntimeError, OSError):
            compiled._cache = KernelCache(function)
        compiled._compile_for_args = _undisturbed(compiled._compile_for_args)
        as_part(compiled, options, is_cold)
    return cast("Callable[P, R]", compiled)


def _undisturbed(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile without the garbage collector, which takes a tenth of the time, and type once."""

    @functools.wraps(function)
    def wrapped(*args: Any, **keywords: Any) -> Any:
        is_collecting = gc.isenabled()
        gc.disable()
        try:
            with _typed_once():
                return function(*args, **keywords)
        finally:
            if is_collecting:
                if gc.get_freeze_count() == 0:
                    # What is left of it counts as old, and is looked through with all that is old:
                    # at once it would take half a second, which many a process never needs.
                    gc.freeze()
                    gc.unfreeze()
                gc.enable()

    return wrapped


@contextlib.contextmanager
def _typed_once() -> Iterator[None]:
    """Let numba find out once what an operator is of given types, not wherever it stands.

    At each of ten thousand places it would ask up to forty implementations, of texts, lists and
    sets too, whether they take two numbers: a quarter of the time of a compilation.
    """
    functions: Any = BaseFunction
    of_numba = functions.get_call_type

    def get_call_type(self: Any, context: Any, args: Any, kws: Any) -> Any:
        if kws:
            return of_numba(self, context, args, kws)
        asked = (self, context, tuple(args))
        if asked not in _MEANT:
            _MEANT[asked] = of_numba(self, context, args, kws)
        return _MEANT[asked]

    # Whoever holds the lock is the only one who compiles.
    with global_compiler_lock:
        functions.get_call_type = get_call_type
        try:
            yield
        finally:
            functions.get_call_type = of_numba
