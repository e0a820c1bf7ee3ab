"""Kernels inside kernels.

numba compiles each function for itself, optimised, with machine code and an entry from Python,
before its caller is compiled, and then the caller with a copy of it: through ten levels of calls
the same code is optimised ten times. A *part* stops at LLVM's intermediate code. The whole of a
program is then optimised once, as one: two thirds of the time, and a tenth faster code
(docs/decisions/006-parts.md). The intermediate code of a part may have been made ahead
(`percuss.kernels.intermediate_code`).
"""

from __future__ import annotations

import functools
import platform
from collections.abc import Callable, Mapping
from contextvars import ContextVar
from typing import Any

import llvmlite.binding
import numba
from numba.core import funcdesc
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, DefaultPassBuilder, compile_result
from numba.core.compiler_machinery import PassManager
from numba.core.typing.templates import signature

from percuss.kernels.intermediate_code import KeptCode, part_of, type_of_text

# numba's passes that take long and find nothing to do in a kernel: closures and overloads written
# out, whole-array expressions fused, and the ends of variables marked, for the references that
# kernels do not count.
_NOT_NEEDED = ("inline_closure_likes", "inline_overloads", "nopython_rewrites", "ir_legalization")
# Whether code is made for other processors than this one.
is_portable: ContextVar[bool] = ContextVar("is_portable", default=False)
# The parts that this process has compiled, each with numba's result.
compiled: list[tuple[Callable[..., Any], Any]] = []


def has_fused_products() -> bool:
    """Return whether the processor that is compiled for multiplies and adds with one rounding."""
    settings: Any = numba.config
    if is_portable.get():
        return False
    if settings.CPU_NAME is not None:
        # Chosen by the user; what its name implies is not known here.
        return "+fma" in (settings.CPU_FEATURES or "")
    if platform.machine().lower() in ("arm64", "aarch64"):
        return True
    return bool(llvmlite.binding.get_host_cpu_features().get("fma", False))


def as_part(whole: Any, options: Mapping[str, Any], is_cold: bool = False) -> None:
    """Let kernels that call ``whole`` take its code in, instead of calling its machine code."""

    @functools.cache
    def part_for(_is_portable: bool) -> Any:
        njit: Any = numba.njit
        compiler = _ColdPartCompiler if is_cold else _PartCompiler
        return njit(pipeline_class=compiler, no_cpython_wrapper=True, **options)(whole.py_func)

    def part() -> Any:
        return part_for(is_portable.get())

    def call_template(args: Any, kws: Any) -> Any:
        # One part for all values of an argument: a constant that is given is passed to it.
        return part().get_call_template(tuple(map(numba.types.unliteral, args)), kws)

    # These two are what numba asks of a function that is called by one it compiles.
    whole.get_call_template = call_template
    whole.get_overload = lambda sig: part().get_overload(sig)


class _RolledLibrary(JITCodeLibrary):
    """The code of a program whose loops stay as they are written."""

    def _optimize_final_module(self) -> None:
        """Optimise as numba does, but write no steps of a loop out one after the other."""
        settings: Any = numba.config
        tuning = llvmlite.binding.create_pipeline_tuning_options(settings.OPT)
        tuning.loop_vectorization = settings.LOOP_VECTORIZE
        tuning.loop_unrolling = False
        builder = llvmlite.binding.create_pass_builder(self._codegen._tm, tuning)
        builder.getModulePassManager().run(self._final_module, builder)


class RolledCompiler(Compiler):
    """Compiles a program whose loops go over the coordinates of a structure.

    To LLVM their lengths are unknown, and it writes several steps of each loop out, for long ones
    and for what is left: three tenths of the time that a structure takes to compile, to code that
    is slower for few coordinates.
    """

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        """Return numba's result, its library one that leaves loops as they are."""
        library = _RolledLibrary(self.state.targetctx.codegen(), func.__qualname__)
        library.enable_object_caching()
        self.state.library = library
        return super().compile_extra(func)


class _PartLibrary(JITCodeLibrary):
    """The code of a part, to be linked into that of its callers and optimised there.

    It is kept without that of the parts that it calls, which a program takes in once each.
    """

    def finalize(self) -> None:
        """Leave the code as it is."""
        self._finalize_dynamic_globals()
        self._finalized = True

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = self._own().clone()
            for library in self._gather({}):
                is_part = isinstance(library, _PartLibrary)
                other = library._own() if is_part else library._get_module_for_linking()
                self._shared_module.link_in(other, preserve=True)
        return self._shared_module

    def _own(self) -> Any:
        """Return the code of this part alone, which may be linked in more than once."""
        for function in self._final_module.functions:
            if not function.is_declaration:
                function.linkage = "linkonce_odr"
        return self._final_module

    def _gather(self, found: dict[Any, None]) -> dict[Any, None]:
        """Add the libraries that this part calls, and those that these parts call, each once."""
        for library in self._linking_libraries:
            if library not in found:
                found[library] = None
                if isinstance(library, _PartLibrary):
                    library._gather(found)
        return found


class _ColdPartLibrary(_PartLibrary):
    """A part that stays a call, known to the optimiser as one of a cold path."""

    def add_ir_module(self, ir_module: Any) -> None:
        # Said here, and not of the finished module: llvmlite 0.44 puts an attribute of a finished
        # function on its return value.
        for function in ir_module.functions:
            if not function.is_declaration:
                function.attributes.add("noinline")
                function.attributes.add("cold")
        super().add_ir_module(ir_module)


class _PartCompiler(Compiler):
    """Compiles to a part, or takes one that was made ahead."""

    library_class: type[_PartLibrary] = _PartLibrary

    def define_pipelines(self) -> list[Any]:
        """Leave out the passes that find nothing to do in a kernel, a tenth of the time."""
        pipeline: Any = DefaultPassBuilder.define_nopython_pipeline(self.state)
        needed = PassManager(pipeline.pipeline_name)
        needed.passes = [each for each in pipeline.passes if each[0].name() not in _NOT_NEEDED]
        needed.finalize()
        return [needed]

    def compile_extra(self, func: Callable[..., Any]) -> Any:
        # What is kept is for processors with fused products.
        made = part_of(func, self.state.args) if has_fused_products() else None
        if made is not None:
            result = self._taken(func, *made)
        else:
            codegen = self.state.targetctx.codegen()
            self.state.library = self.library_class(codegen, func.__qualname__)
            self.state.flags.no_compile = True
            result = super().compile_extra(func)
            compiled.append((func, result))
        # numba identifies a function by a built-in one, which is never called.
        nothing: list[None] = []
        key = nothing.append
        self.state.targetctx.insert_user_function(key, result.fndesc, [result.library])
        return result._replace(entry_point=key)

    def _taken(self, func: Callable[..., Any], code: KeptCode, place: int) -> Any:
        """Return what numba's passes would, of the code in a file."""
        part, state = code.parts[place], self.state
        meant = signature(type_of_text(part.returns), *state.args)
        described = funcdesc.FunctionDescriptor(
            native=True,
            modname=func.__module__,
            qualname=func.__qualname__,
            unique_name=part.symbol,
            doc="",
            typemap=None,
            restype=meant.return_type,
            calltypes=None,
            args=(),
            kws=(),
            mangler=lambda *_args, **_keywords: part.symbol,
            argtypes=meant.args,
            env_name="",
        )
        return compile_result(
            typing_context=state.typingctx,
            target_context=state.targetctx,
            signature=meant,
            objectmode=False,
            fndesc=described,
            library=_library(state.targetctx.codegen(), code, place),
        )


_LIBRARIES: dict[int, _PartLibrary] = {}


def _library(codegen: Any, code: KeptCode, place: int) -> _PartLibrary:
    """Return the library of a part from a file, with those that it calls; one for each part."""
    if place not in _LIBRARIES:
        library = _PartLibrary(codegen, code.parts[place].symbol)
        library._final_module = llvmlite.binding.parse_bitcode(code.bitcode[place])
        library._linking_libraries = [_library(codegen, code, k) for k in code.parts[place].calls]
        library._finalized = True
        _LIBRARIES[place] = library
    return _LIBRARIES[place]


class _ColdPartCompiler(_PartCompiler):
    """Compiles to a part that stays a call."""

    library_class = _ColdPartLibrary
