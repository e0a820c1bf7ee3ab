"""Elementary functions of numbers and arrays, from `percuss.kernels.arithmetic`.

NumPy's differ in the last digit between processors: it takes vector forms where it can, and the
C library's elsewhere. These give the same bits for numbers and arrays of any shape.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, overload

import numpy as np

from percuss.arrays import Complexes, Floats, row_of
from percuss.kernels import arithmetic
from percuss.kernels.compile import uncompiled

# Up to so many numbers plain Python is faster than the first call of a kernel in a process.
FEW = 16

_exponentials = uncompiled(arithmetic.exponentials)
_cosine_sine = uncompiled(arithmetic.cosine_sine)


def _tangent(x: float) -> float:
    cosine, sine = _cosine_sine(x)
    return float(sine / cosine)


_PLAIN: dict[int, Callable[..., float]] = {
    arithmetic.EXPONENTIAL: lambda x: _exponentials(x)[0],
    arithmetic.EXPONENTIAL_LESS_ONE: lambda x: _exponentials(x)[1],
    arithmetic.LOGARITHM: uncompiled(arithmetic.logarithm),
    arithmetic.COSINE: lambda x: _cosine_sine(x)[0],
    arithmetic.SINE: lambda x: _cosine_sine(x)[1],
    arithmetic.TANGENT: _tangent,
    arithmetic.ARCTANGENT: uncompiled(arithmetic.arctangent),
    arithmetic.HYPOTENUSE: uncompiled(arithmetic.hypotenuse),
}


def _evaluated(which: int, *given: Any) -> Any:
    if all(isinstance(value, float | int) for value in given):
        return float(_PLAIN[which](*(float(value) for value in given)))
    arrays = [np.asarray(value, dtype=np.float64) for value in given]
    shape = np.broadcast_shapes(*(array.shape for array in arrays))
    flat = [row_of(np.broadcast_to(array, shape)) for array in arrays]
    out = np.empty(flat[0].shape)
    if len(out) <= FEW:
        for i, values in enumerate(zip(*(array.tolist() for array in flat), strict=True)):
            out[i] = _PLAIN[which](*values)
    else:
        arithmetic.evaluate(which, flat[0], flat[-1], out)
    return out.reshape(shape)[()]


@overload
def exp(x: float) -> float: ...
@overload
def exp(x: Floats) -> Floats: ...
def exp(x: Any) -> Any:
    """Return the exponential.

    Examples
    --------
    >>> exp(0.0)
    1.0
    """
    return _evaluated(arithmetic.EXPONENTIAL, x)


@overload
def expm1(x: float) -> float: ...
@overload
def expm1(x: Floats) -> Floats: ...
def expm1(x: Any) -> Any:
    """Return the exponential less one, to full relative precision.

    Examples
    --------
    >>> expm1(1e-20)
    1e-20
    """
    return _evaluated(arithmetic.EXPONENTIAL_LESS_ONE, x)


@overload
def log(x: float) -> float: ...
@overload
def log(x: Floats) -> Floats: ...
def log(x: Any) -> Any:
    """Return the natural logarithm; -inf of 0 and NaN of negative numbers, without a warning.

    Examples
    --------
    >>> log(1.0), log(0.0)
    (0.0, -inf)
    """
    return _evaluated(arithmetic.LOGARITHM, x)


@overload
def cos(x: float) -> float: ...
@overload
def cos(x: Floats) -> Floats: ...
def cos(x: Any) -> Any:
    """Return the cosine.

    Examples
    --------
    >>> cos(0.0)
    1.0
    """
    return _evaluated(arithmetic.COSINE, x)


@overload
def sin(x: float) -> float: ...
@overload
def sin(x: Floats) -> Floats: ...
def sin(x: Any) -> Any:
    """Return the sine.

    Examples
    --------
    >>> sin(0.0)
    0.0
    """
    return _evaluated(arithmetic.SINE, x)


@overload
def tan(x: float) -> float: ...
@overload
def tan(x: Floats) -> Floats: ...
def tan(x: Any) -> Any:
    """Return the tangent.

    Examples
    --------
    >>> tan(0.0)
    0.0
    """
    return _evaluated(arithmetic.TANGENT, x)


@overload
def atan2(y: float, x: float) -> float: ...
@overload
def atan2(y: Floats, x: Floats) -> Floats: ...
def atan2(y: Any, x: Any) -> Any:
    """Return the angle of the point (x, y), in [-pi, pi].

    Examples
    --------
    >>> atan2(1.0, 0.0)
    1.5707963267948966
    """
    return _evaluated(arithmetic.ARCTANGENT, y, x)


@overload
def hypot(x: float, y: float) -> float: ...
@overload
def hypot(x: Floats, y: Floats | float) -> Floats: ...
def hypot(x: Any, y: Any) -> Any:
    """Return sqrt(x^2 + y^2), without overflow on the way.

    Examples
    --------
    >>> hypot(3.0, 4.0)
    5.0
    """
    return _evaluated(arithmetic.HYPOTENUSE, x, y)


def cosine_sine(angle: float) -> tuple[float, float]:
    """Return the cosine and the sine of a number.

    Examples
    --------
    >>> cosine_sine(0.0)
    (1.0, 0.0)
    """
    cosine, sine = _cosine_sine(angle)
    return cosine, sine


def phasor(angle: Floats | float) -> Complexes:
    """Return exp(i angle), an array of the shape of the angles.

    Examples
    --------
    >>> phasor(0.0)
    array(1.+0.j)
    """
    flat = row_of(angle)
    out = np.empty(2 * flat.size)
    if flat.size <= FEW:
        for i, value in enumerate(flat.tolist()):
            out[2 * i : 2 * i + 2] = _cosine_sine(value)
    else:
        arithmetic.evaluate(arithmetic.PHASOR, flat, flat, out)
    return out.view(np.complex128).reshape(np.shape(angle))


def times(a: Complexes, b: Complexes) -> Complexes:
    """Return the product of complex arrays, which NumPy contracts where the processor can.

    Examples
    --------
    >>> times(np.array([1.0 + 2.0j]), np.array([3.0 - 1.0j]))
    array([5.+5.j])
    """
    shape = np.broadcast_shapes(a.shape, b.shape)
    product = np.empty(shape, dtype=np.complex128)
    np.subtract(a.real * b.real, a.imag * b.imag, out=product.real)
    np.add(a.real * b.imag, a.imag * b.real, out=product.imag)
    return product


def modulus(z: Complexes) -> Floats:
    """Return the absolute values of complex numbers.

    Examples
    --------
    >>> modulus(np.array([3.0 + 4.0j]))
    array([5.])
    """
    return np.asarray(hypot(z.real, z.imag))


@overload
def power(base: float, exponent: float) -> float: ...
@overload
def power(base: float, exponent: Floats) -> Floats: ...
def power(base: Any, exponent: Any) -> Any:
    """Return a power of a positive number, to some 1e-16 of the size of its logarithm.

    Examples
    --------
    >>> round(power(10.0, 0.5) ** 2, 14)
    10.0
    """
    return exp(exponent * log(base))


def geometric(first: float, last: float, count: int) -> Floats:
    """Return positive numbers of one ratio, both ends exactly as given.

    Examples
    --------
    >>> geometric(1.0, 100.0, 3).round(12)
    array([  1.,  10., 100.])
    """
    numbers: Floats = first * exp(np.linspace(0.0, log(last / first), count))
    numbers[-1:] = last
    numbers[:1] = first
    return numbers
