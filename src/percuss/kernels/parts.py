"""Kernels that are called by kernels: parts of their callers, without machine code of their own.

numba compiles each function for itself, optimised, with machine code and a door to Python, before
its caller is compiled, and then the caller with a copy of it: through ten levels of calls the same
code is optimised ten times. A part stops at LLVM's intermediate code. The whole of a program is
then optimised once, as one: two thirds of the time, and a tenth faster code
(docs/decisions/006-parts.md).
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

import numba
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler


def as_part(compiled: Any, options: Mapping[str, Any]) -> None:
    """Let kernels that call ``compiled`` take its code in, instead of calling its machine code."""

    @functools.cache
    def part() -> Any:
        njit: Any = numba.njit
        return njit(pipeline_class=_PartCompiler, no_cpython_wrapper=True, **options)(
            compiled.py_func
        )

    # These two are what numba asks of a function that is called by one it compiles.
    compiled.get_call_template = lambda args, kws: part().get_call_template(args, kws)
    compiled.get_overload = lambda sig: part().get_overload(sig)


class _PartCompiler(Compiler):
    """Compiles to a part."""

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        self.state.library = _PartLibrary(self.state.targetctx.codegen(), func.__qualname__)
        self.state.flags.no_compile = True
        result = super().compile_extra(func)
        # numba tells functions apart by a built-in one; this one is never called.
        nothing: list[None] = []
        key = nothing.append
        self.state.targetctx.insert_user_function(key, result.fndesc, [result.library])
        return result._replace(entry_point=key)


class _PartLibrary(JITCodeLibrary):
    """The code of a part, to be linked into that of its callers and optimised there."""

    def _optimize_final_module(self) -> None:
        pass

    def _finalize_final_module(self) -> None:
        self._finalize_dynamic_globals()
        self._finalized = True
