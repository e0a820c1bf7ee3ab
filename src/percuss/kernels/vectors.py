"""Vectors of eight doubles inside kernels, of which one instruction handles four or two.

In a kernel an `Eight` is a value, as a float is, and stays in registers; in plain Python it is an
array of eight entries. They are added, subtracted and multiplied entry by entry, a float standing
for eight of itself, each entry rounded as a float is: the bits do not depend on how wide the
instructions of a processor are.

It is made of two vectors of four. Processors that have instructions for eight lower their clock for
them, by a tenth, which everything around pays.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any, TypeAlias

import numba
import numba.extending
import numpy as np
from llvmlite import ir
from numba.core import cgutils
from numpy.typing import NDArray

from percuss.arrays import Floats
from percuss.kernels.intermediate_code import TYPES

WIDTH = 8
HALF = WIDTH // 2
# Of a double.
BYTES = 8
Eight: TypeAlias = NDArray[np.float64]

# numba has no types for these.
_types: Any = numba.types
_extending: Any = numba.extending
_tools: Any = cgutils
_REAL = _types.float64
_FOUR = ir.VectorType(ir.DoubleType(), HALF)
_BITS = ir.VectorType(ir.IntType(64), HALF)
_PAIR = ir.LiteralStructType([_FOUR, _FOUR])
_WORD = ir.IntType(64)


class _EightType(_types.Type):  # type: ignore[misc]
    """What numba knows the vectors by."""

    def __init__(self) -> None:
        super().__init__(name="Eight")


_EIGHT = _EightType()
TYPES[str(_EIGHT)] = _EIGHT


@_extending.register_model(_EightType)
class _EightModel(_extending.models.PrimitiveModel):  # type: ignore[misc]
    """Two values of LLVM's."""

    def __init__(self, manager: Any, of: Any) -> None:
        super().__init__(manager, of, _PAIR)


def _lowered(function: Callable[..., Any], result: Any, *arguments: Any) -> Callable[[Any], Any]:
    """Let kernels call ``function`` with these types; what is decorated writes its instructions."""

    def decorated(written: Any) -> Any:
        def lower(_context: Any, builder: Any, _signature: Any, given: Any) -> Any:
            return written(builder, *given)

        # numba reads the names of the arguments, so that they must be written out.
        def of_none(_context: Any) -> Any:
            return lambda: result

        def of_one(_context: Any) -> Any:
            return lambda a: result if (a,) == arguments else None

        def of_two(_context: Any) -> Any:
            return lambda a, b: result if (a, b) == arguments else None

        _extending.lower_builtin(function, *arguments)(lower)
        _extending.type_callable(function)((of_none, of_one, of_two)[len(arguments)])
        return written

    return decorated


def _halves_of(builder: Any, value: Any) -> tuple[Any, Any]:
    """Return both halves of a vector, of a float twice the same."""
    if value.type == _PAIR:
        return builder.extract_value(value, 0), builder.extract_value(value, 1)
    one = builder.insert_element(ir.Constant(_FOUR, ir.Undefined), value, ir.IntType(32)(0))
    places = ir.Constant(ir.VectorType(ir.IntType(32), HALF), [0] * HALF)
    four = builder.shuffle_vector(one, ir.Constant(_FOUR, ir.Undefined), places)
    return four, four


def _joined(builder: Any, low: Any, high: Any) -> Any:
    """Return the vector of two halves."""
    pair = builder.insert_value(ir.Constant(_PAIR, ir.Undefined), low, 0)
    return builder.insert_value(pair, high, 1)


def _by_halves(function: Callable[..., Any], *arguments: Any) -> Callable[[Any], Any]:
    """Let kernels call ``function``; what is decorated writes its instructions for one half."""

    def decorated(written: Any) -> Any:
        @_lowered(function, _EIGHT, *arguments)
        def write(builder: Any, *given: Any) -> Any:
            halves = zip(*(_halves_of(builder, value) for value in given), strict=True)
            low, high = (written(builder, *some) for some in halves)
            return _joined(builder, low, high)

        return write

    return decorated


def _define(function: Callable[..., Any], instruction: str, *arguments: Any) -> None:
    """Let kernels apply an operator to two vectors, or to a vector and a float."""

    @_by_halves(function, *arguments)
    def write(builder: Any, a: Any, b: Any) -> Any:
        return getattr(builder, instruction)(a, b)


for _arguments in ((_EIGHT, _EIGHT), (_EIGHT, _REAL), (_REAL, _EIGHT)):
    _define(operator.add, "fadd", *_arguments)
    _define(operator.sub, "fsub", *_arguments)
    _define(operator.mul, "fmul", *_arguments)


def eight_at(law: Floats, row: int, column: int) -> Eight:
    """Return eight entries of a row, from a column on."""
    return law[row, column : column + WIDTH]


def _type_eight_at(_context: Any) -> Any:
    def result_of(law: Any, _row: Any, _column: Any) -> Any:
        return _EIGHT(law, _types.intp, _types.intp)

    return result_of


def _lower_eight_at(context: Any, builder: Any, signature: Any, given: Any) -> Any:
    array = context.make_array(signature.args[0])(context, builder, given[0])
    row, _ = _tools.unpack_tuple(builder, array.strides)
    entry = ir.Constant(row.type, BYTES)
    offset = builder.add(builder.mul(given[1], row), builder.mul(given[2], entry))
    halves = []
    for beyond in (0, HALF * BYTES):
        there = builder.add(offset, ir.Constant(row.type, beyond))
        place = _tools.pointer_add(builder, array.data, there, _FOUR.as_pointer())
        # A row may begin anywhere between two lines of the memory.
        halves.append(builder.load(place, align=BYTES))
    return _joined(builder, *halves)


_extending.type_callable(eight_at)(_type_eight_at)
_extending.lower_builtin(eight_at, _types.Array, _types.intp, _types.intp)(_lower_eight_at)


def counting() -> Eight:
    """Return 0, 1, 2 and so on."""
    return np.arange(float(WIDTH))


@_lowered(counting, _EIGHT)
def _write_counting(builder: Any) -> Any:
    low, high = (
        ir.Constant(_FOUR, [float(k) for k in range(first, first + HALF)]) for first in (0, HALF)
    )
    return _joined(builder, low, high)


def least(a: Eight, b: Eight) -> Eight:
    """Return the smaller of each two entries."""
    return np.minimum(a, b)


@_by_halves(least, _EIGHT, _EIGHT)
def _write_least(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered("<", a, b), a, b)


def greatest(a: Eight, b: Eight) -> Eight:
    """Return the larger of each two entries."""
    return np.maximum(a, b)


@_by_halves(greatest, _EIGHT, _EIGHT)
def _write_greatest(builder: Any, a: Any, b: Any) -> Any:
    return builder.select(builder.fcmp_ordered(">", a, b), a, b)


def magnitude(a: Eight) -> Eight:
    """Return the magnitude of each entry."""
    return np.abs(a)


@_by_halves(magnitude, _EIGHT)
def _write_magnitude(builder: Any, a: Any) -> Any:
    signless = ir.Constant(_BITS, [2**63 - 1] * HALF)
    return builder.bitcast(builder.and_(builder.bitcast(a, _BITS), signless), _FOUR)


def shifted(first: float, a: Eight) -> Eight:
    """Return ``first`` and all entries but the last."""
    return np.concatenate(([first], a[:-1]))


@_lowered(shifted, _EIGHT, _REAL, _EIGHT)
def _write_shifted(builder: Any, first: Any, a: Any) -> Any:
    low, high = _halves_of(builder, a)
    one, _ = _halves_of(builder, first)
    # The last entry of the one, and the first three of the other.
    places = ir.Constant(ir.VectorType(ir.IntType(32), HALF), [*range(HALF - 1, 2 * HALF - 1)])
    return _joined(
        builder, builder.shuffle_vector(one, low, places), builder.shuffle_vector(low, high, places)
    )


def entry_of(a: Eight, k: int) -> float:
    """Return one entry."""
    return float(a[k])


@_lowered(entry_of, _REAL, _EIGHT, _types.intp)
def _write_entry_of(builder: Any, a: Any, k: Any) -> Any:
    place = _tools.alloca_once(builder, _PAIR)
    builder.store(a, place)
    entries = builder.bitcast(place, ir.DoubleType().as_pointer())
    return builder.load(builder.gep(entries, [k]))


def first_not_positive(a: Eight, k: int) -> int:
    """Return the number of the first entry from the k-th on that is not above 0, WIDTH if none."""
    return next((i for i in range(k, WIDTH) if not a[i] > 0.0), WIDTH)


@_lowered(first_not_positive, _types.intp, _EIGHT, _types.intp)
def _write_first_not_positive(builder: Any, a: Any, k: Any) -> Any:
    zero = ir.Constant(_FOUR, [0.0] * HALF)
    end, every = _WORD(HALF), _WORD(2**WIDTH - 1)
    wanted = builder.shl(every, k)
    places = []
    # Each half for itself: bits of both in one number would make them one vector of eight again.
    for half, first in zip(_halves_of(builder, a), (0, HALF), strict=True):
        bits = builder.bitcast(builder.fcmp_unordered("<=", half, zero), ir.IntType(HALF))
        found = builder.and_(builder.zext(bits, _WORD), builder.lshr(wanted, _WORD(first)))
        # A bit behind those of the half, where none is found.
        found = builder.or_(found, _WORD(1 << HALF))
        places.append(builder.cttz(found, ir.Constant(ir.IntType(1), 1)))
    is_low = builder.icmp_unsigned("<", places[0], end)
    return builder.select(is_low, places[0], builder.add(places[1], end))
