"""A run proven to as many digits as asked for: precision is raised until they are there."""

from __future__ import annotations

import math
from collections.abc import Callable
from fractions import Fraction
from itertools import count

from flint import arb

from percuss.certified.law import lost_bits
from percuss.certified.march import MOST_EVENTS, Limits, march
from percuss.certified.numbers import precision
from percuss.certified.ranges import Over, system_for, too_wide
from percuss.certified.record import Ending, MarchRecord
from percuss.certified.results import CertifiedRun, run_of_record
from percuss.certified.starting import start_used
from percuss.certified.system import system_of
from percuss.model.exact import Phase, as_float
from percuss.model.start import Start
from percuss.motion.outcome import Outcome
from percuss.motion.progress import RunProgress
from percuss.motion.trajectory import Trajectory

__all__ = ["certify_run"]

# Bits beyond the digits asked for at the first attempt, and at the following ones.
FIRST_MARGIN, MARGIN = 88, 12
# Endings that no bits put off, and those that more bits may.
HOPELESS = (Ending.no_event, Ending.most_events, Ending.chatter, Ending.interrupted)
OPEN = (Ending.graze, Ending.force, Ending.precision)


def certify_run(
    run: Trajectory,
    digits: int,
    start: Start | None,
    limits: tuple[Phase | None, int | None],
    most_bits: int,
    bits: int | None,
    progress: bool | Callable[[float, float], bool] | None = None,
    over: Over | None = None,
) -> CertifiedRun:
    """Prove a run; see `percuss.certify`."""
    system = system_for(system_of(run.oscillator, run.forcing), over)
    given = run.start if start is None else start
    begin = start_used(system, given)
    t_end, number = limits if limits != (None, None) else _limits_of(run)
    finest = Fraction(1, 2 * 10**digits)
    best: tuple[MarchRecord, float] | None = None
    with precision(FIRST_MARGIN):
        lost = lost_bits(system)
    work = bits or min(most_bits, math.ceil(digits / math.log10(2)) + FIRST_MARGIN + lost)
    for attempt in count():
        reported = _progress(progress, begin, t_end, number)
        with precision(work):
            record = march(system, begin, Limits(t_end, number, finest), reported)
            spent, missing = _bits(record, digits)
        reported.close()
        enough = missing <= 0 and record.ending not in OPEN
        if best is None or enough or not record.until < best[0].until:
            best = record, spent
        if bits is not None or enough or work >= most_bits or record.ending in HOPELESS:
            if missing > 0 and bits is None and not best[0].reason:
                short_by = math.ceil(min(missing * math.log10(2), digits))
                best[0].reason = f"{short_by} fewer digits than asked for, with {work} bits"
                best[0].reason += too_wide(system)
            elif bits is None and best[0].ending in OPEN:
                best[0].reason += too_wide(system)
            return run_of_record(system, (begin, given), *best, digits)
        # What misses is known after one attempt; if more does not help, much more may.
        short = attempt == 0 and record.ending not in OPEN
        more = math.ceil(min(missing, work)) + MARGIN if short else work
        work = min(most_bits, work + more)
    raise AssertionError


def _progress(
    progress: bool | Callable[[float, float], bool] | None,
    begin: Start,
    t_end: Phase | None,
    number: int | None,
) -> RunProgress:
    end = math.inf if t_end is None else as_float(t_end)
    return RunProgress(progress, as_float(begin.t0), end, number or MOST_EVENTS)


def _limits_of(run: Trajectory) -> tuple[Phase | None, int | None]:
    """Return the limits of a run: its impacts where their number ended it, else its end."""
    if run.outcome is Outcome.reached_max_impacts and len(run.contacts) == 0:
        # Stops at one place are entered together.
        entries = set(run.crossings.t[run.crossings.direction == "in"].tolist())
        return None, len(run.impacts) + len(entries)
    if run.outcome is Outcome.at_rest and run.t_end in run.contacts.start:
        # It had no other end.
        return None, None
    if run.outcome in (Outcome.reached_max_impacts, Outcome.no_more_impacts, Outcome.interrupted):
        # Just after the last event, which the float's instant may miss by its rounding.
        return run.t_end + 1e-9 * max(1.0, abs(run.t_end)), None
    return run.end, None


def _bits(record: MarchRecord, digits: int) -> tuple[float, float]:
    """Return the bits that the balls have grown by, and those that miss to the digits."""
    instants = [row.t for row in record.impacts] + [row.t for row in record.crossings]
    velocities = [row.v_before for row in record.impacts] + [row.v for row in record.crossings]
    contacts = [row.start for row in record.contacts]
    contacts += [row.release for row in record.contacts if row.release is not None]
    fastest = max((float(v.abs_upper()) for v in velocities), default=0.0)
    start = record.pieces[0].start if record.pieces else arb(0)
    apart = float((record.until - start).abs_upper()) if record.until.is_finite() else 0.0
    flight = apart / max(1, len(instants))
    worst, last = -math.inf, -math.inf
    columns = (instants, flight), (contacts, max(flight, record.width)), (velocities, fastest)
    for column, scale in columns:
        errors = [_relative(value, scale) for value in column]
        worst = max([worst, *errors])
    ends = [row[-1] for row in (record.impacts, record.crossings) if row]
    for row in ends:
        last = max(last, _relative(row.t, flight), _relative(row[1], fastest))
    spent = record.bits + last if last > -math.inf else 0.0
    wanted = -digits / math.log10(2)
    return spent, worst - wanted


def _relative(value: arb, scale: float) -> float:
    """Return log2 of a ball's radius in parts of its size, or of a scale if that is larger."""
    radius = value.rad()
    if radius.is_zero():
        return -math.inf
    if not value.is_finite():
        return math.inf
    with precision(64):
        size = abs(value.mid()).max(arb(scale))
        if size.is_zero():
            return -math.inf
        return float((radius / size).log()) / math.log(2)
