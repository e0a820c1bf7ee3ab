"""Keep the intermediate code of kernels in the package: ``make kernels``, after a change of them.

It runs the examples of the docstrings in a process that compiles all anew, and writes the parts
that were compiled for them (docs/decisions/027-intermediate-code.md). It takes two minutes.
"""

from __future__ import annotations

import itertools
import os
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any

KERNELS = "percuss.kernels."
# Names of LLVM carry a number for each function that numba has met: these must not be those of a
# process that takes some parts from the file and compiles others.
FIRST_NUMBER = 1_000_000


def ask() -> int:
    """Run the examples of all docstrings; return pytest's exit code."""
    import pytest

    return int(pytest.main(["-q", "-p", "no:cacheprovider", "src"]))


def parts() -> Iterator[tuple[Any, bytes]]:
    """Return what is kept of each part that was compiled, those that it calls before it."""
    from percuss.kernels.intermediate_code import Part, full_name, type_as_text
    from percuss.kernels.parts import compiled

    places: dict[Any, int] = {}
    known = {result.library: (function, result) for function, result in compiled}

    def kept(library: Any) -> Iterator[tuple[Any, bytes]]:
        if library in places:
            return
        function, result = known.get(library, (None, None))
        # Of functions that others make there may be several of one name.
        name = "" if function is None or "<locals>" in full_name(function) else full_name(function)
        called = [] if result is None else library._linking_libraries
        for each in called:
            yield from kept(each)
        module = library._get_module_for_linking() if result is None else library._own()
        code = module.as_bitcode()
        calls = [places[each] for each in called]
        places[library] = len(places)
        if result is None:
            yield Part("", [], "", library.name, calls, len(code)), code
            return
        returns = type_as_text(result.signature.return_type)
        arguments = [str(each) for each in result.signature.args]
        symbol = result.fndesc.llvm_func_name
        yield Part(name, arguments, returns, symbol, calls, len(code)), code

    for function, result in compiled:
        if full_name(function).startswith(KERNELS):
            yield from kept(result.library)


def main() -> int:
    """Write the file, where there is none yet of these kernels; remove those of others."""
    from numba.core.bytecode import FunctionIdentity

    FunctionIdentity._unique_ids = itertools.count(FIRST_NUMBER)
    from percuss.kernels import intermediate_code

    file = Path(str(intermediate_code.code_file()))
    if intermediate_code.code().parts:
        print(f"{file.name} is that of the kernels as they are")
        return 0
    if ask() != 0:
        return 1
    found = list(parts())
    for old in file.parent.glob("intermediate-code-*.xz"):
        old.unlink()
    file.write_bytes(intermediate_code.packed(found))
    print(f"{file.name}: {len(found)} parts, {file.stat().st_size // 1000} kB")
    return 0


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as empty:
        os.environ["NUMBA_CACHE_DIR"] = empty
        sys.exit(main())
