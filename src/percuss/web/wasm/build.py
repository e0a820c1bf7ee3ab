"""Make the file of WebAssembly: ``python -m percuss.web.wasm.build``, or ``make wasm``.

numba's code for each entry is given to the WebAssembly target of the LLVM that numba brings along,
and linked by ``wasm-ld`` (Debian's package ``lld``; ``LINKER`` names another one). Nothing but this
module needs a linker: the file lies in the package.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from itertools import islice
from pathlib import Path
from typing import Any, get_type_hints

from percuss.ensembles import decisions
from percuss.kernels import batch, fill_law, law_columns, observables, record
from percuss.kernels.compile import OPTIONS
from percuss.kernels.parts import is_portable
from percuss.web import facts
from percuss.web.wasm import attractors, basins, exponents
from percuss.web.wasm.entries import ENTRIES, SIGNATURES
from percuss.web.wasm.sources import KERNELS_FILE, SECTION, sources_hash

TRIPLE = "wasm32-unknown-unknown"
LAYOUT = "e-m:e-p:32:32-p10:8:8-p20:8:8-i64:64-n32:64-S128-ni:1:10:20"
FEATURES = "+simd128,+nontrapping-fptoint,+bulk-memory,+sign-ext"
LINKERS = ("wasm-ld", "wasm-ld-19", "wasm-ld-16", "wasm-ld-14")
# A product of integers and whether it overflows, which else takes a function of 128 bits.
CHECKED_PRODUCT = """
define linkonce_odr { i64, i1 } @checked_product(i64 %a, i64 %b) {
  %product = mul i64 %a, %b
  %is_zero = icmp eq i64 %a, 0
  %divisor = select i1 %is_zero, i64 1, i64 %a
  %quotient = udiv i64 %product, %divisor
  %differs = icmp ne i64 %quotient, %b
  %overflows = select i1 %is_zero, i1 false, i1 %differs
  %half = insertvalue { i64, i1 } undef, i64 %product, 0
  %both = insertvalue { i64, i1 } %half, i1 %overflows, 1
  ret { i64, i1 } %both
}
"""
# What the page has to know of the arrays.
COLUMNS = {
    record: (
        "T X V STATE_ENTRIES TOUCHED N_EVENTS N_IMPACTS "
        "N_GRAZES COUNTERS EVENT_T EVENT_T_LOW V_BEFORE V_AFTER EVENT_COLUMNS KIND BOUND "
        "NEXT_REGION MARK_COLUMNS GRAZE_COLUMNS IMPACT CROSSING CONTACT RELEASE REACHED_END "
        "REACHED_LIMIT AT_REST OVERFLOW NO_MORE FULL SPENT"
    ),
    law_columns: "COLUMNS PERIOD GROWTH STOP_COLUMNS",
    observables: (
        "N_OBSERVABLES POINT_COLUMNS PLAN_ENTRIES STROBES IMPACT_POINTS PASSAGES PEAK_SPEED"
    ),
    batch: "BUFFER GRAZES",
    attractors: (
        "ASKED_SECTION ASKED_TRANSIENT ASKED_PERIODS ASKED_CYCLE ASKED_LEVEL ASKED_WAY "
        "ASKED_ENTRIES"
    ),
    decisions: "PERIODIC CHAOTIC REST UNBOUNDED BLOCKS EXPONENT_COLUMNS SIDE",
    basins: (
        "RULES_T0 RULES_PERIODS RULES_ESCAPE RULES_ENTRIES CLASS_KIND CLASS_PERIODS "
        "CLASS_ENTRIES "
        "FOUND_KIND FOUND_PERIODS FOUND_IMPACTS FOUND_POINTS FOUND_FIRST FOUND_FRACTION "
        "FOUND_ERROR FOUND_ENTRIES MOST_FOUND MOST_POINTS MOST_STROBES NEEDS_PYTHON"
    ),
    exponents: "OUT_VALUE OUT_ERROR OUT_SIGN OUT_ENTRIES",
    facts: "PERIODS",
    fill_law: (
        "GIVEN_STIFFNESS GIVEN_DAMPING GIVEN_CONSTANT GIVEN_MASS GIVEN_STOPS GIVEN_HARMONICS "
        "GIVEN_PER_MASS STOP_AT STOP_STIFFNESS STOP_DAMPING STOP_SIDE STOP_RESTITUTION "
        "STOP_IS_WALL WAVE_OMEGA WAVE_AMPLITUDE WAVE_TIMES WAVE_PLUS WAVE_IS_DOUBLE GIVEN_COLUMNS"
    ),
}


def build(linker: str) -> bytes:
    """Return the file, linked by a linker."""
    import llvmlite.binding as llvm

    is_portable.set(True)
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    whole = None
    symbols = {}
    for name in ENTRIES:
        symbols[name], text = _code_of(name)
        module = llvm.parse_assembly(text)
        if whole is None:
            whole = module
        else:
            # Kernels that several entries call are merged by their names.
            whole.link_in(module)
    assert whole is not None
    target = llvm.Target.from_triple(TRIPLE)
    machine = target.create_target_machine(opt=3, features=FEATURES)
    with tempfile.TemporaryDirectory() as folder:
        made, linked = Path(folder) / "kernels.o", Path(folder) / KERNELS_FILE
        made.write_bytes(machine.emit_object(whole))
        exports = [f"--export={symbol}" for symbol in symbols.values()]
        options = ["--no-entry", "--allow-undefined", "-O3", "--strip-all", "--gc-sections"]
        command = [linker, *options, *exports, "--export=__heap_base", str(made), "-o", str(linked)]
        subprocess.run(command, check=True)
        return linked.read_bytes() + _section(symbols)


def _code_of(name: str) -> tuple[str, str]:
    """Return the symbol of an entry, and its code for the target."""
    import numba

    entry: Any = ENTRIES[name]
    options = {**OPTIONS, "no_cpython_wrapper": True}
    compiled: Any = numba.njit(_signature(name), **options)(entry)
    (signature,) = compiled.signatures
    symbol = str(compiled.overloads[signature].fndesc.mangled_name)
    text = compiled.inspect_llvm(signature)
    text = re.sub(r'target triple = ".*"', f'target triple = "{TRIPLE}"', text)
    text = re.sub(r'target datalayout = ".*"', f'target datalayout = "{LAYOUT}"', text)
    # WebAssembly has neither common symbols nor a C library; its square root is an instruction.
    text = text.replace("= common ", "= weak ")
    text = re.sub(r"^declare double @sqrt\(.*$", "", text, flags=re.MULTILINE)
    text = text.replace("@sqrt(", "@llvm.sqrt.f64(")
    if "declare double @llvm.sqrt.f64(" not in text:
        text += "\ndeclare double @llvm.sqrt.f64(double)\n"
    if "@llvm.umul.with.overflow.i64(" in text:
        text = re.sub(r"^declare .*@llvm.umul.with.overflow.i64\(.*$", "", text, flags=re.MULTILINE)
        text = text.replace("@llvm.umul.with.overflow.i64(", "@checked_product(") + CHECKED_PRODUCT
    return symbol, text


def _signature(name: str) -> Any:
    """Return the types of an entry's arguments; the arrays of a tuple are passed one by one."""
    import numba

    types: Any = numba.types
    of_words = {"f": types.float64, "i": types.int64}
    for letter, kind in (("F", types.float64), ("I", types.int64)):
        of_words |= {f"{letter}{n}": types.Array(kind, n, "C") for n in (1, 2, 3)}
    kinds = (of_words[word] for word in SIGNATURES[name].split())
    hints = get_type_hints(ENTRIES[name])
    del hints["return"]
    arguments = []
    for hint in hints.values():
        fields = getattr(hint, "_fields", None)
        if fields is None:
            arguments.append(next(kinds))
        else:
            arguments.append(types.NamedTuple(tuple(islice(kinds, len(fields))), hint))
    return types.int64(*arguments)


def _section(symbols: dict[str, str]) -> bytes:
    """Return the custom section that describes the file."""
    columns = {
        name: int(getattr(module, name))
        for module, names in COLUMNS.items()
        for name in names.split()
    }
    about = {
        "hash": sources_hash(),
        "entries": {name: [symbols[name], SIGNATURES[name]] for name in ENTRIES},
        "columns": columns,
    }
    name, text = SECTION.encode(), json.dumps(about, sort_keys=True).encode()
    body = _leb(len(name)) + name + text
    return b"\x00" + _leb(len(body)) + body


def _leb(value: int) -> bytes:
    out = bytearray()
    while True:
        byte, value = value & 0x7F, value >> 7
        out.append(byte | (0x80 if value else 0))
        if not value:
            return bytes(out)


def main() -> int:
    """Write the file into the package; return 1 where there is no linker."""
    named = os.environ.get("LINKER")
    linker = next(filter(None, map(shutil.which, [named] if named else LINKERS)), None)
    if linker is None:
        sys.stderr.write(
            "percuss needs wasm-ld to make the file of WebAssembly: install lld (Debian: apt "
            "install lld), or name a linker with LINKER=/path/to/wasm-ld\n"
        )
        return 1
    data = build(linker)
    file = Path(__file__).parents[1] / "static" / KERNELS_FILE
    file.write_bytes(data)
    sys.stdout.write(f"{file.name}: {len(data):,} bytes\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
