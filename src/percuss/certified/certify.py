"""`certify`: the proof of a run, an orbit, a special point or a branch, with the bits that it needs."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from fractions import Fraction
from itertools import count
from typing import cast, overload

from flint import arb

from percuss.certified.ball_law import Over, lost_bits, system_for, too_wide
from percuss.certified.certified_branch import CertifiedBranch, certify_branch
from percuss.certified.march import MOST_EVENTS, Ending, MarchLimits, MarchRecord, march, start_used
from percuss.certified.numbers import precision
from percuss.certified.orbit_result import CertifiedOrbit
from percuss.certified.orbits import certify_orbit
from percuss.certified.results import CertifiedRun, run_of_record
from percuss.certified.special import CertifiedPoint, certify_point
from percuss.certified.system import system_of
from percuss.errors import ParameterError
from percuss.model.exact import Phase, as_float, plain, whole
from percuss.model.faults import raise_first
from percuss.model.start import Start, start_faults, start_of
from percuss.motion.entries import entry_rows
from percuss.motion.trajectory import Outcome, Trajectory
from percuss.orbits.bifurcations.branch import Branch
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.progress import RunProgress

MOST_BITS, FEWEST_BITS = 4096, 32
MOST_DIGITS = 1000
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
            record = march(system, begin, MarchLimits(t_end, number, finest), reported)
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
        # One attempt shows how many bits are missing; if these do not help, twice as many may.
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
        return None, len(run.impacts) + len(entry_rows(run))
    if run.outcome is Outcome.at_rest and run.t_end in run.contacts.start:
        # The run had no other end.
        return None, None
    if run.outcome in (Outcome.reached_max_impacts, Outcome.no_more_impacts, Outcome.interrupted):
        # Just after the last event, whose float may be early by its rounding.
        return run.t_end + 1e-9 * max(1.0, abs(run.t_end)), None
    return run.end, None


def _bits(record: MarchRecord, digits: int) -> tuple[float, float]:
    """Return the growth of the balls in bits, and the digits that are missing."""
    instants = [row.t for row in record.impacts] + [row.t for row in record.crossings]
    velocities = [row.v_before for row in record.impacts] + [row.v for row in record.crossings]
    contacts = [row.start for row in record.contacts]
    contacts += [row.release for row in record.contacts if row.release is not None]
    fastest = max((float(v.abs_upper()) for v in velocities), default=0.0)
    start = record.pieces[0].start if record.pieces else arb(0)
    length = float((record.until - start).abs_upper()) if record.until.is_finite() else 0.0
    flight = length / max(1, len(instants))
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
    """Return log2 of a ball's radius, relative to its size or to a scale if that is larger."""
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


@overload
def certify(
    what: Trajectory,
    digits: int = 12,
    *,
    start: Start | Sequence[Phase] | None = None,
    t_end: Phase | None = None,
    max_impacts: int | None = None,
    most_bits: int = MOST_BITS,
    bits: int | None = None,
    over: Over | None = None,
    progress: bool | Callable[[float, float], bool] | None = None,
) -> CertifiedRun: ...


@overload
def certify(
    what: PeriodicOrbit,
    digits: int = 12,
    *,
    most_bits: int = MOST_BITS,
    bits: int | None = None,
    over: Over | None = None,
) -> CertifiedOrbit: ...


@overload
def certify(
    what: SpecialPoint, digits: int = 12, *, most_bits: int = MOST_BITS, bits: int | None = None
) -> CertifiedPoint: ...


@overload
def certify(
    what: Branch, *, progress: bool | Callable[[float, float], bool] | None = None
) -> CertifiedBranch: ...


def certify(
    what: Trajectory | PeriodicOrbit | SpecialPoint | Branch,
    digits: int = 12,
    *,
    start: Start | Sequence[Phase] | None = None,
    t_end: Phase | None = None,
    max_impacts: int | None = None,
    most_bits: int = MOST_BITS,
    bits: int | None = None,
    over: Over | None = None,
    progress: bool | Callable[[float, float], bool] | None = None,
) -> CertifiedRun | CertifiedOrbit | CertifiedPoint | CertifiedBranch:
    """Prove a result in ball arithmetic: every number has a radius that is certain.

    The numbers of the model are taken exactly as they were given: ``"2.8"`` is 14/5, a float
    is that double. The precision rises until the digits are reached, or ``most_bits``. What cannot
    be proven, such as a touch without velocity, ends the proof; its result says where and why
    (docs/theory/certified.md).

    - Each impact of a run is proven to exist, to be the first after the one before, and to have a
      velocity that is not zero; the balls hold the exact motion.
    - An orbit is proven to exist, to be isolated or one of a family, to pass through no stop or
      through one, and to be asymptotically stable, elliptic or unstable.
    - The parameter of a special point is enclosed: of a fold, period doubling, symmetry breaking,
      strong resonance, graze or corner.
    - A branch is proven whole: the curve of orbits goes on without a gap between one end of a
      stretch and the other, through folds and symmetry breakings, with the stability and
      admissibility of all of them.

    Parameters
    ----------
    what
        The run, orbit, special point or branch.
    digits
        Decimal digits wanted, >= 1. The error of a time of a run is at most 10^-digits of the time
        or, near 0, of the mean flight time; that of a velocity of itself or of the fastest impact,
        if that is larger; those of an orbit of its period and greatest velocity.
    start
        Another start than that of the run, a `Start`, (x0, v0) or (x0, v0, t0), taken as it is
        given: ``v0="0.45"`` is 9/20.
    t_end, max_impacts
        Other limits than those of the run; ``max_impacts`` counts entries into soft stops too.
    most_bits
        Greatest precision.
    bits
        Work at just this precision, whatever digits result.
    over
        A number of the force, by its path, that stands for all values in a `Ball` or between two
        exact numbers: the constant or an amplitude. The proof of a run or an orbit holds for each
        of them; a narrow ball stands for a number that is no fraction, such as cos(pi/5).
    progress
        For a run, as of `simulate`: True shows a line, a function ``(done, total) -> bool`` is
        called after each event and stops the proof by returning False. It starts anew at each
        precision. For a branch it is called after each strip of the proof.

    Returns
    -------
    CertifiedRun, CertifiedOrbit, CertifiedPoint or CertifiedBranch
        With the same names as the result that was given, and balls in place of floats.

    Raises
    ------
    ParameterError
        If a number is outside its domain, or `what` cannot be certified.
    MissingExtraError
        If python-flint is not installed.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.45", max_impacts=3)
    >>> proven = pc.certify(run, digits=12)
    >>> print(proven.impacts.t[2].text(12))
    [7.53223107958 +/- 2.16e-12]
    >>> proven.impacts.t[0].contains("pi"), proven.complete
    (True, True)

    >>> orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    >>> pc.certify(orbit).stability
    'asymptotic'

    >>> branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.6)})
    >>> proven = pc.certify(branch)
    >>> proven.complete, [(s.low, s.high, s.stability) for s in proven.stretches]
    (True, [(2.5, 2.6, 'asymptotic')])
    """
    digits, most_bits, bits = (plain(value) for value in (digits, most_bits, bits))  # type: ignore[assignment]
    _check(digits, most_bits, bits)
    if isinstance(what, Trajectory):
        begin = what.start if start is None else start_of(start)
        if start is not None or t_end is not None or max_impacts is not None:
            end = what.end if t_end is None and max_impacts is None else t_end
            x0, v0, t0 = begin.x0, begin.v0, begin.t0
            raise_first(start_faults(what.oscillator, x0, v0, t0, end, max_impacts))
        limits = cast("Phase | None", plain(t_end)), cast("int | None", plain(max_impacts))
        return certify_run(what, digits, begin, limits, most_bits, bits, progress, over)
    if (start, t_end, max_impacts) != (None, None, None):
        raise ParameterError("start", start, "start, t_end and max_impacts are of runs only")
    if isinstance(what, PeriodicOrbit):
        return certify_orbit(what, digits, most_bits, bits, over)
    if isinstance(what, Branch):
        if over is not None or bits is not None:
            name, value = ("over", over) if over is not None else ("bits", bits)
            raise ParameterError(name, value, "a branch is proven along its own parameter")
        return certify_branch(what, progress)
    if isinstance(what, SpecialPoint):
        if over is not None:
            raise ParameterError("over", dict(over), "a special point has a parameter of its own")
        return certify_point(what, digits, most_bits, bits)
    reason = "neither a run, nor an orbit, nor a special point, nor a branch"
    if type(what).__name__.startswith("Structure"):
        reason += " of an oscillator; results of structures have no certificates"
    raise ParameterError("what", what, reason)


def _check(digits: object, most_bits: object, bits: object) -> None:
    for name, value, low, high in (
        ("digits", digits, 1, MOST_DIGITS),
        ("most_bits", most_bits, FEWEST_BITS, 2**20),
        ("bits", bits, FEWEST_BITS, 2**20),
    ):
        if name == "bits" and value is None:
            continue
        whole(name, value, low, high)
