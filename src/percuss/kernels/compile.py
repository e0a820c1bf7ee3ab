"""The decorator of every kernel, and the cache of what it compiled.

numba keeps the machine code of a function beside a stamp of the one file that holds it, but that
machine code has its callees inlined: an edit of a callee's file leaves the caller stale, silently.
Here the name of each cache file carries a hash of all kernel files instead, so code that was
compiled from other text is never found (docs/decisions/002-compile-cache.md).
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
from collections.abc import Callable
from importlib import resources
from pathlib import Path
from typing import Any, ParamSpec, TypeVar, cast

import numba
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.core.dispatcher import Dispatcher

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
}


def kernel(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a function of numbers at its first call, and keep the machine code on disk.

    Kernels release the GIL, follow IEEE 754 (a division by zero is infinite or NaN) and are never
    reordered by the compiler. With ``NUMBA_DISABLE_JIT=1`` the function itself is returned.

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
    compiled: Any = numba.njit(**OPTIONS)(function)
    if isinstance(compiled, Dispatcher):
        # numba refuses a function for which it finds no writable folder, or no file (a prompt).
        with contextlib.suppress(RuntimeError, OSError):
            compiled._cache = _KernelCache(function)  # type: ignore[attr-defined]
    return cast("Callable[P, R]", compiled)


def python_of(function: Callable[P, R]) -> Callable[P, R]:
    """Give the plain Python function behind a kernel.

    Parameters
    ----------
    function
        A kernel, compiled or, with ``NUMBA_DISABLE_JIT=1``, not.

    Returns
    -------
    Callable
        The function as it was written.

    Examples
    --------
    >>> @kernel
    ... def twice(x: float) -> float:
    ...     return 2.0 * x
    >>> python_of(twice).__name__, python_of(python_of(twice))(4.0)
    ('twice', 8.0)
    """
    return cast("Callable[P, R]", getattr(function, "py_func", function))


@functools.cache
def _sources_hash() -> str:
    """Hash the names and contents of all Python files of this folder, once a process."""
    digest = hashlib.sha256()
    for file in sorted(resources.files(__package__).iterdir(), key=lambda entry: entry.name):
        if file.name.endswith(".py"):
            content = file.read_bytes()
            digest.update(f"{file.name} {len(content)}\n".encode())
            digest.update(content)
    return digest.hexdigest()[:20]


class _NamedBySources(CompileResultCacheImpl):
    """Puts the hash of the sources into the names of a kernel's cache files."""

    def get_filename_base(self, fullname: str, abiflags: str) -> str:
        return str(super().get_filename_base(f"{fullname}-{_sources_hash()}", abiflags))


class _KernelCache(FunctionCache):
    """The cache of one kernel: a help that never fails a computation."""

    _impl_class = _NamedBySources

    def load_overload(self, sig: object, target_context: object) -> object:
        try:
            return super().load_overload(sig, target_context)
        except Exception:  # noqa: BLE001  a damaged file raises whatever unpickling it leads to
            with contextlib.suppress(OSError):
                self.flush()
            return None

    def save_overload(self, sig: object, data: object) -> None:
        # The disk may be full, or the folder taken away since the function was decorated.
        with contextlib.suppress(OSError):
            super().save_overload(sig, data)
            self._remove_files_of_other_sources()

    def _remove_files_of_other_sources(self) -> None:
        name, _ = self._impl.filename_base.split(f"-{_sources_hash()}-")
        for file in Path(self.cache_path).glob(f"{name}-*-*.nb[ci]"):
            if not file.name.startswith(f"{name}-{_sources_hash()}-"):
                # Another process may have removed it first.
                file.unlink(missing_ok=True)
