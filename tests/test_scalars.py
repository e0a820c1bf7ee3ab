"""Every call takes every real number: Python's, NumPy's and those of arrays without dimensions."""

from __future__ import annotations

from collections.abc import Callable
from decimal import Decimal
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
import xarray as xr

import percuss as pc
from percuss.certified import keeps_eigenset
from percuss.model.exact import as_float, as_fraction, pi_times, plain, reals, whole
from percuss.model.system import law

Make = Callable[[float], Any]

# All of them hold a quarter and a whole number exactly.
REAL: dict[str, Make] = {
    "fraction": Fraction,
    "decimal": Decimal,
    "text": str,
    "float32": np.float32,
    "float64": np.float64,
    "long double": np.longdouble,
    "array": np.array,
    "array of float16": lambda number: np.array(number, dtype=np.float16),
    "array of objects": lambda number: np.array(Fraction(number), dtype=object),
    "xarray": xr.DataArray,
}
WHOLE: dict[str, Make] = {
    "int64": np.int64,
    "uint8": np.uint8,
    "array": np.array,
    "xarray": xr.DataArray,
}

WALL, FORCE = pc.impact_oscillator("0.8", wall=0.5, side="above", damping=0.05), pc.cosine(1.25)
RUN = pc.simulate(WALL, FORCE, periods=20)
ORBIT = pc.find_orbit(WALL, FORCE)
SADDLE = pc.find_orbit(pc.Oscillator(stiffness=-1.0, damping=0.1), pc.cosine(2.0), n_impacts=0)

CALLS: dict[str, Callable[[Make], Any]] = {
    "a start": lambda n: pc.simulate(WALL, FORCE, n(-0.25), n(1), n(0.25), t_end=n(9)).impacts.t,
    "periods": lambda n: pc.simulate(WALL, FORCE, periods=n(2.25)).impacts.t,
    "a run's states": lambda n: RUN(n(3.25)),
    "a run's growth": lambda n: pc.growth(RUN, since=n(20)).exponent,
    "a run's spectrum": lambda n: pc.spectrum(RUN, omega=[n(1.25)], between=(n(10), n(60)))["amplitude"],
    "a run's lines": lambda n: pc.line_spectrum(RUN, n(5)).cosine,
    "a pair of numbers": lambda n: as_float(pc.Start(n(0.25), n(1), n(2)).x0),
    "an oscillator": lambda n: pc.impact_oscillator(n(0.75), wall=n(0.25), damping=n(0.25)),
    "bilinear": lambda n: pc.bilinear_oscillator(stiffness_below=n(4)),
    "backlash": lambda n: pc.backlash_oscillator(stiffness=n(25), gap=n(2)),
    "a mass": lambda n: pc.Oscillator.from_mass(n(2), n(8), damping_ratio=n(0.25)),
    "a ball": lambda n: as_float(pc.ball_on_table(n(1), n(2), restitution=n(0.5))[1].constant),
    "a force": lambda n: pc.cosine(n(1.25), n(0.5), n(0.25)).period,
    "fourier": lambda n: pc.fourier(n(2), cos=(n(1), n(0.25))).period,
    "a guess": lambda n: pc.find_orbit(WALL, FORCE, guess=(n(ORBIT.t0 % 1), n(-1))).x0,
    "an axis": lambda n: pc.sweep(
        "period", WALL, FORCE, over={"forcing.omega": [n(1.25), n(1.5)]}, start=(n(0), n(0.25))
    ).period,
    "basins": lambda n: pc.basins(
        WALL, FORCE, x0=[n(0), n(0.25)], v0=(n(0), n(1)), t0=n(0.25), escape=n(1000), periods=50
    ).basin[:, ::100],
    "a branch": lambda n: len(pc.continue_orbit(
        ORBIT, over={"forcing.omega": (n(1.25), n(1.5))}, largest_step=n(0.25), max_points=4
    )),
    "a map": lambda n: pc.stroboscopic_map(WALL, FORCE, cycle=n(0.25))(n(0.25), n(0)),
    "an impact map": lambda n: pc.impact_map(WALL, FORCE)(n(0.25), n(-1)),
    "manifolds": lambda n: len(pc.manifolds(
        SADDLE, length=n(0.5), spacing=n(0.25), cycle=n(0.25)
    ).branches),
    "a set": lambda n: len(pc.singularity_set(WALL, FORCE, spacing=n(0.25), longest=n(9))),
    "a proof": lambda n: keeps_eigenset(pc.impact_oscillator(), pc.sine(3), n(0.75), n(0)).holds,
    "a factor of pi": lambda n: as_float(pi_times(n(3), n(4)) + n(0.25)),
}  # fmt: skip

COUNTS: dict[str, Callable[[Make], Any]] = {
    "impacts": lambda n: pc.simulate(WALL, FORCE, max_impacts=n(3)).impacts.t,
    "samples": lambda n: RUN.sample(n(5)).x,
    "lines": lambda n: pc.line_spectrum(RUN, 5, n(3), periods=n(1)).cosine,
    "an orbit": lambda n: pc.find_orbit(WALL, FORCE, n(1), n(1)).x0,
    "orbits": lambda n: len(pc.find_orbits(WALL, FORCE, n(1), n(1), n(0))),
    "instants": lambda n: pc.eigenset(pc.impact_oscillator(), n(3)),
    "a sweep": lambda n: pc.sweep(
        "period", WALL, FORCE, over={"forcing.omega": [1.25]}, periods=n(20), transient=n(5)
    ).period,
    "a diagram": lambda n: pc.bifurcation_diagram(
        WALL, FORCE, over={"forcing.omega": [1.25]}, points=n(4), transient=n(5)
    ).x,
    "a gap": lambda n: pc.velocity_gap_curve(WALL, FORCE, n(1), n_points=n(9)).gap,
    "a proof": lambda n: keeps_eigenset(pc.impact_oscillator(), pc.sine(3), 1, 0, n(3)).holds,
    "a proven run": lambda n: pc.certify(RUN, n(5), max_impacts=n(2)).complete,
}  # fmt: skip


def as_is(result: Any) -> Any:
    """Return a result; of a model, which keeps how a number was given, the table of its law."""
    return law(result, None) if isinstance(result, pc.Oscillator) else result


@pytest.mark.parametrize("call", CALLS)
def test_a_call_takes_every_real_number(call: str) -> None:
    expected = as_is(CALLS[call](float))

    for name, make in REAL.items():
        np.testing.assert_array_equal(as_is(CALLS[call](make)), expected, name)


@pytest.mark.parametrize("call", COUNTS)
def test_a_call_takes_every_whole_number(call: str) -> None:
    expected = COUNTS[call](int)

    for name, make in WHOLE.items():
        np.testing.assert_array_equal(COUNTS[call](make), expected, name)


def test_a_motions_own_result_is_a_start() -> None:
    x, v = RUN(5.0)

    again = pc.simulate(WALL, FORCE, x, v, np.array(5.0), t_end=20)

    assert again.start == pc.Start(float(x), float(v), 5.0)
    assert len(again.impacts) > 0


def test_nothing_is_rounded_that_was_exact() -> None:
    third = np.array(Fraction(1, 3), dtype=object)

    assert as_fraction(third) == Fraction(1, 3)
    assert as_fraction(np.longdouble(1) / 3) == Fraction(*(np.longdouble(1) / 3).as_integer_ratio())
    assert as_fraction(np.float32(0.1)) == Fraction(float(np.float32(0.1)))


@pytest.mark.parametrize(
    "value",
    [
        np.array(True),
        np.timedelta64(5, "ns"),
        np.array("2020-01-01", dtype="datetime64[ns]"),
        np.ma.masked,
        np.array([1.0]),
        np.complex128(1),
        np.array("x"),
        None,
    ],
)
def test_what_is_no_real_number_is_refused(value: Any) -> None:
    with pytest.raises(pc.ParameterError, match="not a number"):
        as_float(value)


def test_an_infinite_long_double_is_not_finite() -> None:
    with pytest.raises(pc.ParameterError, match="not finite"):
        as_float(np.longdouble("inf"))


def test_arrays_of_exact_numbers_become_doubles_one_by_one() -> None:
    found = reals("t", np.array([["1/3", Fraction(1, 4)], [Decimal("0.1"), 1]], dtype=object))

    assert found.tolist() == [[1 / 3, 0.25], [0.1, 1.0]]
    with pytest.raises(pc.ParameterError, match="t = 'x': not a number"):
        reals("t", ["x"])


def test_whole_numbers_have_limits() -> None:
    assert whole("n", np.array(3), 1) == 3
    assert whole("n", np.float64(3), 1) == 3
    assert type(plain(np.uint8(3))) is int
    for wrong in (2.5, True, 0, None, np.float64(3.5), float("inf"), float("nan")):
        with pytest.raises(pc.ParameterError, match=r"n = .*: not a whole number of at least 1"):
            whole("n", wrong, 1)
