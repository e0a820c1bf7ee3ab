"""The decorator of every kernel."""

from __future__ import annotations

import contextlib
import functools
import gc
import types
from collections.abc import Callable
from typing import Any, ParamSpec, TypeVar, cast

import numba

from percuss.kernels.cache import KernelCache
from percuss.kernels.parts import as_part

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

    A kernel that another one calls becomes part of that one's machine code; only one that is
    called from Python gets machine code of its own. Kernels release the GIL, follow IEEE 754 (a division by zero is infinite or NaN) and are never
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
    return _compiled(function, OPTIONS)


def formula(function: Callable[P, R]) -> Callable[P, R]:
    """Compile a kernel that is written out wherever it is called, so that loops of it are vectors.

    Elsewhere the compiler weighs whether to write a kernel out or to call it, and a loop with a
    call in it stays one number at a time.

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


def _compiled(function: Callable[P, R], options: dict[str, Any]) -> Callable[P, R]:
    compiled: Any = numba.njit(**options)(function)
    # With the compiler off it is the function itself.
    if hasattr(compiled, "py_func"):
        # numba refuses a function for which it finds no writable folder, or no file (a prompt).
        with contextlib.suppress(RuntimeError, OSError):
            compiled._cache = KernelCache(function)
        compiled._compile_for_args = _undisturbed(compiled._compile_for_args)
        as_part(compiled, options)
    return cast("Callable[P, R]", compiled)


def _undisturbed(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile without the garbage collector, which takes a tenth of the time."""

    @functools.wraps(function)
    def wrapped(*args: Any, **keywords: Any) -> Any:
        if not gc.isenabled():
            return function(*args, **keywords)
        gc.disable()
        try:
            return function(*args, **keywords)
        finally:
            gc.enable()

    return wrapped
