"""What a public function cannot take is one sentence with its name, whatever its type."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest

import percuss as pc

OSC, FORCE = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05), pc.cosine(1.0)
# Without its types, which these calls do not keep to.
api: Any = pc
HUGE = 10**5000  # of more digits than Python writes
RAGGED = [[1.0, 2.0], [3.0]]


@cache
def run() -> pc.Trajectory:
    return pc.simulate(OSC, FORCE, periods=30)


@cache
def orbit() -> pc.PeriodicOrbit:
    return pc.find_orbit(OSC, FORCE)


@cache
def saddle() -> pc.PeriodicOrbit:
    return pc.find_orbit(pc.Oscillator(stiffness=-1.0, damping=0.1), pc.cosine(2.0), n_impacts=0)


@cache
def branch() -> pc.Branch:
    return pc.continue_orbit(orbit(), over={"forcing.amplitude": (1.0, 0.99)})


def beam(**given: Any) -> pc.Structure:
    return pc.cantilever(**({"n_modes": 2} | given))


def cascade(n: Any) -> pc.Cascade:
    return pc.follow_cascade(orbit(), over={"forcing.amplitude": (1.0, 1.1)}, max_doublings=n)


def basins(**given: Any) -> Any:
    return api.basins(OSC, **({"force": FORCE, "x0": [0.0], "v0": [0.0], "periods": 80} | given))


def fractions(**given: Any) -> Any:
    call = {"force": FORCE, "x0": (-1, 0), "v0": (0, 1), "n_starts": 2, "over": {"x": [1.0]}}
    return api.basin_fractions(OSC, **(call | given))


def responses(**given: Any) -> Any:
    return api.response_curve(OSC, FORCE, over={"forcing.omega": (1, 1.1)}, **given)


def designs(**given: Any) -> Any:
    return api.design("peak_displacement", OSC, FORCE, free={"forcing.omega": (1, 1.1)}, **given)


def exponents(**given: Any) -> pc.LyapunovExponents:
    return pc.lyapunov_exponents(OSC, FORCE, **given)


def period(**given: Any) -> Any:
    return pc.sweep("period", OSC, FORCE, over={"forcing.omega": [1.0]}, **given)


CALLS: list[tuple[Callable[[], Any], str]] = [
    (lambda: api.orbits_at(orbit(), 1.0), "branch = <PeriodicOrbit"),
    (lambda: api.orbits_at({}, 1.0), "branch = {}: not a branch"),
    (lambda: api.orbits_at(branch(), "x"), "value = 'x': not a number"),
    (lambda: api.growth(None), "run = None: not the run of an oscillator"),
    (lambda: api.growth(OSC), "run = Oscillator("),
    (lambda: api.spectrum(run(), omega=RAGGED), "omega = [[1.0, 2.0], [3.0]]: rows of different"),
    (lambda: api.spectrum(run(), omega=[1e300]), "omega = 1e+300: above 1e+150"),
    (lambda: api.spectrum(run(), between=(1,)), "between = (1,): not a pair"),
    (lambda: api.spectrum(run(), between=1), "between = 1: not a pair"),
    (lambda: api.spectrum(run(), between=(1, 1)), "between = (1.0, 1.0): one instant"),
    (lambda: api.line_spectrum(run(), 1e-300), "period = 1e-300: no more than the rounding"),
    (lambda: api.line_spectrum(run(), 1.0, HUGE), "n_lines = int of too many digits: not a whole"),
    (lambda: api.line_spectrum(run(), 1.0, periods=HUGE), "periods = int of too many digits"),
    (lambda: api.section_map(OSC, FORCE, at=0.2, direction=[]), "direction = []: none of up"),
    (lambda: api.velocity_gap_curve(OSC, FORCE, 10**15), "n_periods = 1000000000000000: an orbit"),
    (lambda: api.velocity_gap_curve(OSC, FORCE, n_points=10**15), "n_points = 1000000000000000"),
    (lambda: api.find_orbit(OSC, FORCE, seed=-1), "seed = -1: not a whole number"),
    (lambda: api.find_orbits(OSC, FORCE, 1, 1, seed=1.5), "seed = 1.5: not a whole number"),
    (lambda: responses(seed=-2), "seed = -2: not a whole number"),
    (lambda: responses(seed=None), "seed = None: not a whole number"),
    (lambda: designs(seed="x"), "seed = 'x': not a whole number"),
    (lambda: api.eigenset(None, 2), "osc = None: not an Oscillator"),
    (lambda: api.eigenset(pc.impact_oscillator(), HUGE), "count = int of too many digits"),
    (lambda: api.eigenset(pc.impact_oscillator(), 2, "x"), "t0 = 'x': not a number"),
    (lambda: api.resonant_frequency([]), "osc = []: not an Oscillator"),
    (lambda: api.eigenset_motion(1.0, ["x"]), "t = 'x': not a number"),
    (lambda: api.eigenset_motion(1.0, [0.5, -1.0]), "t = -1.0: not a finite time of at least 0"),
    (lambda: api.eigenset_motion(1.0, np.nan), "t = nan: not a finite time of at least 0"),
    (lambda: api.eigenset_motion(1.0, 1e22), "t = 1e+22: more than 1e+14 periods of 6.28"),
    (lambda: api.subset_forcing(1e300), "not a whole number from 2 to"),
    (lambda: api.subset_critical_velocity(HUGE), "m = int of too many digits: not a whole"),
    (lambda: api.classify_impact_times("abc", OSC), "run = 'abc': not a number"),
    (lambda: api.classify_impact_times([1.0, 2.0], 1), "osc = 1: not an Oscillator"),
    (lambda: api.classify_impact_times([1.0], OSC, "x"), "force = 'x': not a Forcing"),
    (lambda: api.fourier(1.0, np.array(3.0)), "cos = array(3.): not a tuple"),
    (lambda: api.restitution_table(np.array(1.0), [0.5]), "speeds"),
    (lambda: beam(points=[1]), "points = [1]: not {name: place}"),
    (lambda: beam(length=1e-300), "length = 1e-300: the highest frequency of such a beam"),
    (lambda: beam(n_modes=HUGE), "n_modes = int of too many digits: not a whole number from 1 to"),
    (lambda: api.merge_parts(None), "store = None: not the path of a folder"),
    (lambda: api.merge_parts(""), "store = '': not the path of a folder"),
    (lambda: cascade(None), "max_doublings = None: not a whole number of at least 1"),
    (lambda: cascade(1.5), "max_doublings = 1.5: not a whole number"),
    (lambda: api.manifolds(run()), "orbit = <Trajectory"),
    (lambda: api.manifolds(None), "orbit = None: not a periodic orbit"),
    (lambda: api.manifolds(saddle(), max_points=0), "max_points = 0: not a whole number"),
    (lambda: api.manifolds(saddle(), max_points=2.5), "max_points = 2.5: not a whole"),
    (lambda: api.manifolds(saddle(), kinds="stable"), "kinds = 'stable': not some of"),
    (lambda: api.manifolds(saddle(), kinds=1), "kinds = 1: not some of"),
    (lambda: api.singularity_set(OSC, FORCE, touched=0.5), "touched = 0.5: not a whole"),
    (lambda: api.singularity_set(OSC, FORCE, touched=7), "touched = 7: "),
    (lambda: api.singularity_set(OSC, FORCE, max_points="x"), "max_points = 'x': not a whole"),
    (lambda: api.singularity_set(OSC, FORCE, n_iterates=10**9), "n_iterates = 1000000000: not a"),
    (lambda: basins(force="cosine"), "force = 'cosine': no forcing"),
    (lambda: basins(force=OSC), "force = Oscillator("),
    (lambda: fractions(force=[]), "force = []: no forcing"),
    (lambda: basins(x0=b"1"), "start.x0 = b'1': not a list of values"),
    (lambda: basins(x0={1.0, 2.0}), "not a list of values"),
    (lambda: basins(stop="first"), "stop = 'first': not a whole number"),
    (lambda: basins(x0=[]), "start.x0 = (): an axis without values"),
    (lambda: fractions(escape=-1), "escape = -1.0: not a finite distance above 0"),
    (lambda: api.pulses(None, 0.5), "omega = None: not a number"),
    (lambda: api.square_wave(None), "omega = None: not a number; a wave has"),
    (lambda: api.force_at(FORCE, [0.0, -1e300]), "t = 1e+300: more than 1e+14 periods of 6.28"),
    (lambda: api.force_at(api.square_wave(2), 1e20), "t = 1e+20: more than 1e+14 periods of 3.14"),
    (lambda: api.classify_impact_times([1.0, np.inf], OSC), "run = (2,): not one array of finite"),
    (lambda: period(transient=1e300), "transient = "),
    (lambda: period(periods=HUGE), "periods = int of too many digits: not a whole number from 1"),
    (lambda: period(max_impacts=1e300), "max_impacts = "),
    (lambda: exponents(start=(0, 0, 1e300)), "t0 = 1e+300: more than 1e+14 periods of 6.28"),
    (lambda: exponents(periods=1e300), "periods = "),
]


@pytest.mark.parametrize(("call", "beginning"), CALLS)
def test_a_wrong_argument_is_named_in_one_sentence(call: Callable[[], Any], beginning: str) -> None:
    with pytest.raises(pc.ParameterError, match=re.escape(beginning)) as raised:
        call()
    assert "\n" not in str(raised.value)


def test_motions_that_begin_too_late_have_a_reason_and_the_others_an_answer() -> None:
    with pytest.warns(UserWarning, match="1 of 2 points"):
        data = pc.sweep("period", OSC, FORCE, over={"start.t0": [0.0, 1e16]}, start=(0.0, 0.0))

    assert data.period.values[0] == 1.0
    assert np.isnan(data.period.values[1])
    assert data.reason.values[0].endswith(
        "more than 1e+14 periods of 6.28; count time from nearer by"
    )


def test_seeds_may_be_as_large_as_those_of_numpy() -> None:
    assert len(pc.sea_state(1.0, 8.0, seed=2**128 - 1).harmonics) == 40


def test_whole_numbers_of_numpy_are_those_of_python() -> None:
    assert api.subset_forcing(np.float32(2)) == pc.subset_forcing(2)


def test_random_starts_later_than_phases_are_exact_have_no_motion() -> None:
    with pytest.warns(UserWarning, match="t0 = 1e\\+300: more than 1e\\+14 periods"):
        data = fractions(t0=1e300, over={"forcing.omega": [1.0]})

    assert data.attrs["failed"] == 2


def test_times_late_after_the_start_keep_their_digits() -> None:
    """The motion v0 sin(t - k pi) is v0 abs(sin t), whatever the double of pi is."""
    t = 1e14 + 0.5
    x, v = pc.eigenset_motion(2.0, t)

    assert abs(x - 2.0 * abs(float(mpmath.sin(t)))) < 1e-15
    assert abs(v - 2.0 * float(mpmath.cos(t) * mpmath.sign(mpmath.sin(t)))) < 1e-15
    at_impacts = pc.eigenset_motion(2.0, np.arange(9) * np.pi)
    assert (at_impacts[0] == 0.0).all()
    assert (at_impacts[1] == 2.0).all()


def test_an_impact_without_restitution_takes_the_smaller_exponent() -> None:
    stops = pc.SoftStop(0, "below", 5), pc.Wall(1, "above", 0.0)
    rates = pc.lyapunov_exponents(pc.Oscillator(stops=stops), FORCE, transient=200, periods=640)

    assert -0.1 < rates.exponents[0] < -0.08
    assert rates.exponents[1] == rates.total == -np.inf
