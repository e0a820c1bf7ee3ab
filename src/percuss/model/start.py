"""The start of a motion, and the limits up to which it is followed."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

from percuss.errors import ParameterError
from percuss.model.exact import (
    Exact,
    Phase,
    PiTimes,
    angle,
    as_float,
    as_fraction,
    phase_problem,
    plain,
)
from percuss.model.faults import (
    Fault,
    dotted,
    faults,
    is_row,
    make_numbers,
    make_plain,
    number_faults,
    phase_faults,
    positive_faults,
    raise_first,
)
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.periods import period_in_common

if TYPE_CHECKING:
    # It imports structures, which have a start.
    from percuss.model.loads import Loads

NO_COMMON_PERIOD = "the loads have no common period; give loads.period, or t_end instead"
# Phases are reduced to one turn exactly up to 2**51 quarter turns.
MOST_PERIODS = 10**14
# What to do where a position lies inside a wall.
BEHIND_A_WALL = "start on its other side, or use a SoftStop, which can be entered"


@dataclass(frozen=True, slots=True)
class Start:
    """The state in which a motion starts.

    Parameters
    ----------
    x0
        Position [length], finite.
    v0
        Velocity [length/time], finite.
    t0
        Time [time], finite; may be a multiple of pi.

    Raises
    ------
    ParameterError
        If a value is not a finite number.

    Examples
    --------
    >>> Start(x0=0.0, v0="0.45")
    Start(x0=0.0, v0='0.45', t0=0.0)
    """

    x0: Exact
    v0: Exact
    t0: Phase = 0.0

    def __post_init__(self) -> None:
        make_numbers(self, "x0", "v0")
        make_plain(self, "t0")
        raise_first(faults(self, ""))


def start_of(start: object) -> Start:
    """Return a start that may be given as (x0, v0) or (x0, v0, t0); None: at rest at 0.

    Raises
    ------
    ParameterError
        If it is neither, or a value is not a finite number.

    Examples
    --------
    >>> start_of((0.5, "1/3"))
    Start(x0=0.5, v0='1/3', t0=0.0)
    """
    if isinstance(start, Start):
        return start
    given: Any = (0.0, 0.0) if start is None else start
    numbers = tuple(given) if is_row(given) else ()
    if not 2 <= len(numbers) <= 3:
        raise ParameterError("start", start, "not (x0, v0) or (x0, v0, t0)")
    return Start(*numbers)


@faults.register
def _(value: Start, prefix: str | None = None) -> list[Fault]:
    prefix = "start" if prefix is None else prefix
    return [
        *number_faults(dotted(prefix, "x0"), value.x0),
        *number_faults(dotted(prefix, "v0"), value.v0),
        *phase_faults(dotted(prefix, "t0"), value.t0),
    ]


def start_faults(
    osc: Oscillator,
    x0: object,
    v0: object,
    t0: object = 0.0,
    t_end: object = None,
    max_impacts: object = None,
    *,
    start: str | None = None,
    run: str | None = None,
) -> list[Fault]:
    """Return all faults of the start of a run and of its limits.

    Parameters
    ----------
    osc
        The oscillator, without faults of its own.
    x0
        Position at the start [length], not inside a wall.
    v0
        Velocity at the start [length/time].
    t0
        Time of the start [time].
    t_end
        Time of the end [time], after t0; or None.
    max_impacts
        Number of impacts and entries into soft stops after which to stop, >= 1; or None, but
        not both.
    start, run
        Dotted paths put before the names of the start and of the limits.

    Returns
    -------
    list of Fault
        Empty if nothing is wrong.

    Examples
    --------
    >>> from percuss.model import impact_oscillator
    >>> for fault in start_faults(impact_oscillator(), x0=-0.1, v0=0.0, t0=10.0, t_end=0.0):
    ...     print(fault)
    x0 = -0.1: below the wall at x = 0.0; start on its other side, or use a SoftStop, which can be \
entered
    t_end = 0.0: not after t0 = 10.0
    """
    x0, t0 = plain(x0), plain(t0)
    wrong_x0 = number_faults(dotted(start, "x0"), x0)
    return [
        *(wrong_x0 or wall_faults(osc, dotted(start, "x0"), cast("Exact", x0))),
        *number_faults(dotted(start, "v0"), plain(v0)),
        *phase_faults(dotted(start, "t0"), t0),
        *limit_faults(t0, t_end, max_impacts, run=run),
    ]


def late_problem(time: float, fastest: float) -> str | None:
    """Return why phases have no digits left at a time, with the most turns in a unit of time.

    Examples
    --------
    >>> late_problem(1e15, 0.5)
    'more than 1e+14 periods of 2; count time from nearer by'
    """
    if abs(time) * fastest <= MOST_PERIODS:
        return None
    return f"more than {MOST_PERIODS:g} periods of {1.0 / fastest:.3g}; count time from nearer by"


def limit_faults(
    t0: object,
    t_end: object = None,
    max_impacts: object = None,
    periods: object = None,
    *,
    run: str | None = None,
) -> list[Fault]:
    """Return the faults of the limits of a run; parameters as in `start_faults`, t0 as it is.

    Where t_end follows from a number of periods, its faults are told of that number.
    """
    t_end, max_impacts = plain(t_end), plain(max_impacts)
    name = dotted(run, "t_end")
    if t_end is None and max_impacts is None:
        return [Fault(name, None, "no limit at all; give t_end, max_impacts or both")]
    problems = []
    if t_end is not None:
        problems = phase_faults(name, t_end)
        is_known = not problems and phase_problem(t0) is None
        if is_known and as_float(cast("Phase", t_end)) <= as_float(cast("Phase", t0)):
            problems.append(Fault(name, t_end, f"not after t0 = {t0}"))
        if periods is not None:
            end = dotted(run, "periods"), periods
            problems = [Fault(*end, f"the end is {each.reason}") for each in problems]
    if max_impacts is not None:
        problems += _count_faults(dotted(run, "max_impacts"), max_impacts)
    return problems


def wall_faults(osc: Oscillator, name: str, x0: Exact) -> list[Fault]:
    """Return the faults of a position inside a wall."""
    problems = []
    for stop in osc.stops:
        sign = 1.0 if stop.side == "above" else -1.0
        # Compared as the doubles they become: 0.2 lies at a wall at "0.2", not inside it.
        if isinstance(stop, Wall) and sign * (as_float(x0) - as_float(stop.at)) > 0.0:
            reason = f"{stop.side} the wall at x = {stop.at}; {BEHIND_A_WALL}"
            problems.append(Fault(name, x0, reason))
    return problems


def periods_faults(
    force: Forcing | Loads | None,
    periods: object,
    t_end: object = None,
    *,
    run: str | None = None,
) -> list[Fault]:
    """Return the fault of a number of forcing periods that is to end a run.

    Parameters
    ----------
    force
        The forcing or the loads, without faults of their own; None for free motion.
    periods
        Number of periods, > 0.
    t_end
        Time of the end, which excludes the periods; or None.
    run
        Dotted path put before the names.

    Returns
    -------
    list of Fault
        Empty if nothing is wrong.

    Examples
    --------
    >>> from percuss.model import Harmonic
    >>> for fault in periods_faults(Forcing((Harmonic(1, "4.2"), Harmonic(1, "2.9"))), 20):
    ...     print(fault)
    periods = 20: the forcing has no period; give forcing.period = "20*pi", or t_end instead
    """
    name, periods = dotted(run, "periods"), plain(periods)
    if t_end is not None:
        return [Fault(name, periods, f"given together with t_end = {t_end}; give one")]
    problems = positive_faults(name, periods)
    if problems:
        return problems
    if force is None or force.is_constant:
        return [Fault(name, periods, "without harmonics there is no period; give t_end")]
    # Known exactly it need not be rounded.
    if force.exact_period is None and force.period is None:
        reason = NO_COMMON_PERIOD
        if isinstance(force, Forcing):
            found = period_in_common(force)
            given = "" if found is None else f' = "{found}"'
            reason = f"the forcing has no period; give forcing.period{given}, or t_end instead"
        return [Fault(name, periods, reason)]
    return []


def end_after_periods(force: Forcing | Loads, t0: Phase, periods: Exact) -> PiTimes:
    """Return the time so many forcing periods after t0, exactly.

    Parameters
    ----------
    force
        A forcing, or loads, with a period.
    t0
        Time of the start [time].
    periods
        Number of periods.

    Returns
    -------
    PiTimes
        The time [time].

    Examples
    --------
    >>> from percuss.model import sine
    >>> end_after_periods(sine(3), 0.0, 10)
    pi_times(20, 3)
    """
    period = cast("PiTimes", force.exact_period)
    if type(t0) is float and type(periods) is int:
        return _end_after(period, t0, periods)
    return _end_after.__wrapped__(period, t0, periods)


@lru_cache(256)
def _end_after(period: PiTimes, t0: Phase, periods: Exact) -> PiTimes:
    times, plus = angle(period)
    n = as_fraction(periods)
    return PiTimes(n * times, n * plus) + t0


def _count_faults(name: str, count: object) -> list[Fault]:
    if isinstance(count, bool) or not isinstance(count, int):
        return [Fault(name, count, "not a whole number of at least 1")]
    return [] if count >= 1 else [Fault(name, count, "not at least 1")]
