"""The spectrum of a run, and the Fourier coefficients of a periodic one.

A run of an oscillator has one displacement; of a structure that of a coordinate, a direction or a
point is taken (`DisplacementSignal`).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from percuss.arrays import Complexes, Floats
from percuss.errors import ParameterError
from percuss.model.exact import MOST_ROWS, as_float, real, reals, whole
from percuss.model.forcing import Forcing
from percuss.model.oscillator import On
from percuss.motion.fourier_integral import ROWS, fourier_integral
from percuss.motion.instants import span_within
from percuss.motion.trajectory import Trajectory
from percuss.numerics import cos, modulus, phasor, times
from percuss.progress import Progress, Report

if TYPE_CHECKING:
    # A second of import.
    from xarray import Dataset

    from percuss.motion.structures import StructureTrajectory

Quantity = Literal["displacement", "velocity"]
WindowName = Literal["hann", "none"]
Method = Literal["exact", "fft"]

# The grids without a given omega reach up to so many times the frequency of the forcing or of the
# spring, whichever is higher, and hold no more than so many frequencies.
REACH = 12.0
MOST_FREQUENCIES = 4096
MOST_SAMPLES = 1 << 22
# Frequencies whose squares are numbers, and units in the last place that a period is longer than.
HIGHEST, SHORTEST = 1e150, 8.0
# Exponentials that are computed between two reports, half a second to a second.
BETWEEN_REPORTS = 1 << 24


@dataclass(frozen=True, slots=True)
class DisplacementSignal:
    """A displacement over time: that of a run of an oscillator, or one of a structure's run.

    Attributes
    ----------
    run
        The run.
    motion
        Returns displacement and velocity at times, of their shape.
    integral
        Returns the integrals of the displacement times exp(-i w (t - low)) over [low, high], from
        w, low and high.
    forcings
        What acts.
    slowest
        The lowest frequency of free motion [1/time], 0 without one.
    n_events
        The events of the run, knots of records among them.
    """

    run: Trajectory | StructureTrajectory
    motion: Callable[..., tuple[Floats, Floats]]
    integral: Callable[[Floats, float, float], Complexes]
    forcings: tuple[Forcing, ...]
    slowest: float
    n_events: int


def signal_of(run: Trajectory | StructureTrajectory, on: On | None) -> DisplacementSignal:
    """Return the displacement of a run, of a structure's on a coordinate, direction or point.

    Raises
    ------
    ParameterError
        If it is no run, or there is no such displacement.
    """
    if isinstance(run, Trajectory):
        if on is not None:
            raise ParameterError("on", on, "a run of an oscillator has one displacement")
        spring = math.sqrt(abs(as_float(run.oscillator.of_unit_mass().stiffness)))
        forcings = () if run.forcing is None else (run.forcing,)
        integral = partial(fourier_integral, run)
        return DisplacementSignal(run, run, integral, forcings, spring, len(run.record[0]))
    # By its name: the module of structures is loaded where there are some.
    if type(run).__name__ != "StructureTrajectory":
        raise ParameterError("run", run, "not the run of an oscillator or of a structure")
    from percuss.motion.structure_fourier import slowest_rate, structure_fourier_integral

    c = run.structure.direction(on)

    def motion(t: ArrayLike, limit: Literal["after", "before"] = "after") -> tuple[Floats, Floats]:
        x, v = run(t, limit)
        return (x * c).sum(axis=-1), (v * c).sum(axis=-1)

    integral = partial(structure_fourier_integral, run, c)
    slowest, n_events = slowest_rate(run), len(run.record.events)
    return DisplacementSignal(run, motion, integral, run.loads.forcings, slowest, n_events)


# The greatest numbers have squares beyond all floats.
@np.errstate(over="ignore", invalid="ignore")
def spectrum(
    run: Trajectory | StructureTrajectory,
    method: Method = "exact",
    *,
    omega: ArrayLike | None = None,
    window: WindowName = "hann",
    of: Quantity = "displacement",
    between: tuple[float, float] | None = None,
    n: int | None = None,
    on: On | None = None,
    progress: Report = None,
) -> Dataset:
    """Return the spectrum of a run over a finite time.

    With X(w) the integral of window(t) x(t) exp(-i w t) over the time T = end - start, and W the
    integral of the window, ``cosine - i sine = 2 X / W``: a long run of A cos(w t) + B sin(w t)
    has the cosine A and the sine B at w (and at w = 0 the cosine is twice the mean, as the first
    coefficient of a Fourier series is).

    Parameters
    ----------
    run
        The run.
    method
        "exact": X of the closed form of the motion, by integration by parts from event to event
        (`percuss.motion.fourier_integral`): exact to rounding, at any frequency, no aliasing.
        "fft": the sum over n equidistant points of the motion by the fast Fourier transform: at
        all multiples of 2 pi/T below n/2 of them, each with what belongs to higher frequencies
        folded onto it; fast for long runs.
    omega
        Angular frequencies for "exact" [1/time]. Default: up to 4096 equidistant ones from 0 to
        12 times the highest frequency of forcing and spring, of a structure of the loads and the
        slowest mode, multiples of pi/T if these are few enough; lines of a long run are narrower
        than the distance of so few.
    window
        "hann": (1 - cos(2 pi (t - start)/T))/2, whose side lobes fall as w^-3; "none".
    of
        "displacement" or "velocity".
    between
        Start and end [time]; default: the whole run.
    n
        Number of points for "fft", >= 4. Default: a power of two that reaches twice as far as the
        frequencies of "exact", at most 2^22.
    on
        Of a structure the coordinate, direction or point whose displacement is taken; none with one
        coordinate.
    progress
        Of "exact", which takes long at many frequencies of a run with many events: True shows a
        line on the error stream after two seconds; a function ``(done, total) -> bool`` is called
        with the number of frequencies, and stops by returning False: those done are returned.

    Returns
    -------
    xarray.Dataset
        Over ``omega`` [1/time]: ``cosine``, ``sine`` and ``amplitude`` [length, or
        length/time], and ``power``, the one-sided density whose integral over omega is the mean
        square weighted by the window squared [the square of that, times time]. Its attributes
        name the method, the window and the times.

    Raises
    ------
    ParameterError
        If a word is unknown, a number outside its domain, or the times outside the run.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=100 * 3.141592653589793)
    >>> lines = spectrum(run, omega=[0.0, 2.0], window="none").amplitude
    >>> (lines * 3.141592653589793).round(9).values
    array([4.        , 1.33333333])

    The difference of two free masses that strike each other without loss is a triangle wave, with
    8 / pi^2 at its frequency:

    >>> pair = pc.simulate(pc.impact_pair(masses=[1, 1], gap=1), v0=[1, 0], t_end=40)
    >>> lines = spectrum(pair, omega=1.5707963267948966, window="none", on=(1, -1)).amplitude
    >>> (lines * 3.141592653589793**2).round(9).values
    array([8.])
    """
    signal = signal_of(run, on)
    _check_words(method, window, of)
    low, high = _times(run, between)
    if method == "exact":
        if n is not None:
            raise ParameterError("n", n, 'a number of points belongs to method="fft"')
        grid = _default_grid(signal, low, high) if omega is None else _frequencies(omega)
        transform = _exact(signal, grid, low, high, window, of, progress)
        grid = grid[: len(transform)]
    else:
        if omega is not None:
            reason = 'the frequencies of method="fft" follow from n and the times'
            raise ParameterError("omega", np.shape(omega), reason)
        grid, transform = _fast(signal, low, high, window, of, _samples(signal, low, high, n))
    weight, squared = _weights(window, high - low)
    values = 2.0 * transform / weight
    power = (transform.real * transform.real + transform.imag * transform.imag) / (
        math.pi * squared
    )
    names = {"method": method, "window": window, "of": of, "start": low, "end": high}
    return _dataset("omega", grid, values, names, power=power)


def fast_amplitudes(run: Trajectory, low: float, high: float, n: int) -> tuple[Floats, Floats]:
    """Return the frequencies and amplitudes of `spectrum` by "fft" as bare arrays.

    A dataset takes three times as long to make as its numbers, too long for a slider.

    Parameters
    ----------
    run
        The run.
    low, high
        Start and end [time], within the run.
    n
        Number of points, >= 4.

    Returns
    -------
    tuple of array
        Angular frequencies [1/time] and amplitudes [length].

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=100.0)
    >>> omega, amplitude = fast_amplitudes(run, 0.0, 100.0, 1024)
    >>> lines = spectrum(run, "fft", n=1024)
    >>> bool((lines.amplitude.values == amplitude).all() and (lines.omega.values == omega).all())
    True
    """
    omega, transform = _fast(signal_of(run, None), low, high, "hann", "displacement", n)
    weight, _ = _weights("hann", high - low)
    with np.errstate(over="ignore", invalid="ignore"):
        return omega, modulus(2.0 * transform / weight)


# The greatest numbers have squares beyond all floats.
@np.errstate(over="ignore", invalid="ignore")
def line_spectrum(
    run: Trajectory | StructureTrajectory,
    period: float,
    n_lines: int = 33,
    *,
    of: Quantity = "displacement",
    periods: int = 1,
    on: On | None = None,
) -> Dataset:
    """Return the exact Fourier coefficients of a periodic motion, from the end of a run.

    x(t) is the sum over the lines n = 0, 1, ... of cosine cos(w t) + sine sin(w t), with
    w = 2 pi n/period; the cosine of line 0 is the mean. The coefficients are integrals of the
    closed form over the last whole periods: exact to rounding, without aliasing.

    Parameters
    ----------
    run
        The run, of one period more than are used.
    period
        The period [time], > 0; a multiple of the shortest one gives lines that are zero.
    n_lines
        How many lines, >= 1.
    of
        "displacement" or "velocity".
    periods
        How many periods to take the mean of, >= 1.
    on
        Of a structure the coordinate, direction or point whose displacement is taken; none with one
        coordinate.

    Returns
    -------
    xarray.Dataset
        Over ``line``: ``omega`` [1/time], ``cosine``, ``sine``, ``amplitude`` [length, or
        length/time]. ``mismatch_x`` and ``mismatch_v`` show whether the run has this period: the
        distances of x and v from their values one period before, in the middle of the last
        period's longest flight.

    Raises
    ------
    ParameterError
        If a number is outside its domain, or the run too short.

    Examples
    --------
    Free motion between elastic impacts, abs(sin t):

    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=20.0)
    >>> lines = line_spectrum(run, 3.141592653589793, 3)
    >>> (lines.cosine * 3.141592653589793).round(9).values
    array([ 2.        , -1.33333333, -0.26666667])
    >>> float(lines.mismatch_v) < 1e-14
    True
    """
    signal = signal_of(run, on)
    _check_words("exact", "none", of)
    period = real("period", period)
    n_lines, periods = whole("n_lines", n_lines, 1, MOST_ROWS), whole("periods", periods, 1)
    if not period > 0.0:
        raise ParameterError("period", period, "not a positive number")
    if (periods + 1) * period > run.t_end - run.t0:
        reason = f"{periods + 1} of them do not fit into the run, {run.t0:g} to {run.t_end:g}"
        raise ParameterError("period", period, reason)
    low, high = run.t_end - periods * period, run.t_end
    if not period > SHORTEST * np.spacing(max(abs(low), abs(high))):
        raise ParameterError("period", period, f"no more than the rounding of times near {high:g}")
    omega = 2.0 * math.pi / period * np.arange(n_lines, dtype=np.float64)
    values = 2.0 * _exact(signal, omega, low, high, "none", of) / (high - low)
    values[0] *= 0.5
    names = {"method": "exact", "of": of, "period": period, "start": low, "end": high}
    dataset = _dataset("line", np.arange(n_lines), values, names)
    t = _middle_of_longest(run, high - period, high)
    now, before = signal.motion(t), signal.motion(t - period)
    return dataset.assign(
        omega=("line", omega),
        mismatch_x=abs(float(now[0] - before[0])),
        mismatch_v=abs(float(now[1] - before[1])),
    )


def _check_words(method: str, window: str, of: str) -> None:
    for name, value, known in (
        ("method", method, ("exact", "fft")),
        ("window", window, ("hann", "none")),
        ("of", of, ("displacement", "velocity")),
    ):
        if value not in known:
            raise ParameterError(name, value, f"neither {known[0]} nor {known[1]}")


def _times(
    run: Trajectory | StructureTrajectory, between: tuple[float, float] | None
) -> tuple[float, float]:
    low, high = span_within(between, run.t0, run.t_end)
    if low == high:
        raise ParameterError("between", (low, high), "one instant; a spectrum is that of a time")
    return low, high


def _frequencies(omega: ArrayLike) -> Floats:
    grid = np.atleast_1d(reals("omega", omega))
    if grid.ndim != 1 or not np.isfinite(grid).all():
        raise ParameterError("omega", grid.shape, "not one array of finite numbers")
    if (np.abs(grid) > HIGHEST).any():
        reason = f"above {HIGHEST:g}, where its square is beyond the range of floats"
        raise ParameterError("omega", float(np.abs(grid).max()), reason)
    return grid


def _highest(signal: DisplacementSignal) -> float:
    """Return the frequency up to which a spectrum is drawn."""
    fastest = signal.slowest
    for forcing in signal.forcings:
        rates = [float(harmonic.omega) for harmonic in forcing.components()]
        record = forcing.record
        if record is not None and record.period is not None:
            rates.append(2.0 * math.pi / as_float(record.period))
        fastest = max([fastest, *rates])
    return REACH * (fastest or 2.0 * math.pi / (signal.run.t_end - signal.run.t0))


def _default_grid(signal: DisplacementSignal, low: float, high: float) -> Floats:
    highest = _highest(signal)
    n = min(MOST_FREQUENCIES, math.ceil(highest * (high - low) / math.pi) + 1)
    return np.linspace(0.0, highest, max(n, 2))


def _samples(signal: DisplacementSignal, low: float, high: float, n: int | None) -> int:
    if n is not None:
        return whole("n", n, 4, MOST_ROWS)
    wanted = 4.0 * _highest(signal) * (high - low) / (2.0 * math.pi)
    return min(MOST_SAMPLES, 1 << max(2, (math.ceil(wanted) - 1).bit_length()))


def _exact(
    signal: DisplacementSignal,
    omega: Floats,
    low: float,
    high: float,
    window: WindowName,
    of: Quantity,
    report: Report = None,
) -> Complexes:
    """Return X at the frequencies that are done when the caller stops."""
    progress = Progress(report, len(omega), "frequencies")
    plain = partial(_plain, signal, low=low, high=high, of=of)
    n = max(ROWS, BETWEEN_REPORTS // signal.n_events)
    parts = [np.empty(0, dtype=np.complex128)]
    for first in range(0, len(omega), n):
        some = omega[first : first + n]
        integral = plain(some) if window == "none" else _hann(plain, some, high - low)
        parts.append(times(integral, phasor(-some * low)))
        if not progress.advance(len(some)):
            break
    progress.close()
    return np.concatenate(parts)


def _hann(plain: Callable[[Floats], Complexes], omega: Floats, duration: float) -> Complexes:
    """Return the integral with a Hann window: three exponentials, so it takes three integrals."""
    step = 2.0 * math.pi / duration
    shifts = np.concatenate([omega, omega - step, omega + step])
    middle, lower, upper = plain(shifts).reshape(3, -1)
    return np.asarray(0.5 * middle - 0.25 * (lower + upper))


def _plain(
    signal: DisplacementSignal, omega: Floats, low: float, high: float, of: Quantity
) -> Complexes:
    """Return the integral of x or v times exp(-i w (t - low))."""
    transform = signal.integral(omega, low, high)
    if of == "displacement":
        return transform
    # By parts: the displacement is continuous over impacts.
    (first, last), _ = signal.motion([low, high])
    return np.asarray(last * phasor(-omega * (high - low)) - first + 1j * omega * transform)


def _fast(
    signal: DisplacementSignal, low: float, high: float, window: WindowName, of: Quantity, n: int
) -> tuple[Floats, Complexes]:
    """Return the frequencies and X, as a sum over n points."""
    place = np.arange(n) / n
    motion = signal.motion(np.minimum(low + place * (high - low), signal.run.t_end))
    values = motion[0] if of == "displacement" else motion[1]
    if window == "hann":
        values = values * (0.5 - 0.5 * cos(2.0 * math.pi * place))
    # Displacements near the largest double have a sum, and moments a frequency, without a number.
    with np.errstate(over="ignore", invalid="ignore"):
        omega = 2.0 * math.pi / (high - low) * np.arange(n // 2 + 1, dtype=np.float64)
        transform = times(np.fft.rfft(values) * ((high - low) / n), phasor(-omega * low))
    return omega, transform


def _weights(window: WindowName, duration: float) -> tuple[float, float]:
    """Return the integrals of the window and of its square."""
    return (duration, duration) if window == "none" else (0.5 * duration, 0.375 * duration)


def _middle_of_longest(run: Trajectory | StructureTrajectory, low: float, high: float) -> float:
    """Return the middle of the longest stretch without an event."""
    times = np.concatenate([run.impacts.t, run.crossings.t, [low, high]])
    cuts = np.unique(times[(times >= low) & (times <= high)])
    longest = int(np.diff(cuts).argmax())
    return float(0.5 * (cuts[longest] + cuts[longest + 1]))


def _dataset(
    over: str,
    places: NDArray[np.generic],
    values: Complexes,
    attributes: Mapping[str, str | float],
    **more: Floats,
) -> Dataset:
    import xarray

    columns = {
        "cosine": (over, values.real),
        "sine": (over, -values.imag),
        "amplitude": (over, modulus(values)),
    }
    columns |= {name: (over, column) for name, column in more.items()}
    return xarray.Dataset(columns, coords={over: places}, attrs=dict(attributes))
