"""Finding periodic orbits, stable or not."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np

from percuss.errors import ConvergenceError, FormalOrbitWarning, ParameterError
from percuss.model.exact import as_float, plain, whole
from percuss.model.faults import raise_first
from percuss.model.forcing import Forcing
from percuss.model.law import law
from percuss.model.oscillator import Oscillator
from percuss.model.system import kind_faults
from percuss.numerics import log
from percuss.orbits.finding.refine_guess import (
    Known,
    counts_of_guess,
    described,
    orbit_near,
    refined,
)
from percuss.orbits.finding.search import (
    SCATTERED,
    GivenGuess,
    Guess,
    batches,
    guesses,
    scattered,
    starts_of,
)
from percuss.orbits.finding.search_budget import SearchBudget, check_length
from percuss.orbits.finding.settled import settled_motions
from percuss.orbits.finding.single_impact import has_closed_form, single_impact_orbits
from percuss.orbits.orbit.itinerary import events_of_stops
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.same import are_same
from percuss.orbits.orbit.steady import free_region, regions, steady_orbit
from percuss.orbits.orbit.sticking import sticking_orbits
from percuss.progress import Report

__all__ = ["FoundOrbits", "estimate_unseen", "find_formal_orbit", "find_orbit", "find_orbits"]

# The better first.
_RANKS = ("asymptotic", "elliptic", "parabolic", "unstable")
# Motions that are followed for long where nothing physical is found otherwise.
ATTRACTED = 40
# Batches of a search for all orbits, at an effort of 1; it ends early when fewer orbits than this
# are estimated to be unseen. The estimate is no bound: of 60 systems at random those that stopped
# just below one orbit lacked up to four.
FEWEST_BATCHES, MOST_BATCHES = 4, 16
ENOUGH = 0.25
LEAST_EFFORT, MOST_EFFORT = 0.1, 100.0
# An impact as slow as rounding, as a part of the fastest one.
NO_SPEED = 1e-12


def find_orbit(
    osc: Oscillator,
    force: Forcing | None = None,
    n_impacts: float = 1,
    n_periods: int = 1,
    sequence: Sequence[int] | None = None,
    guess: GivenGuess | None = None,
    *,
    seed: int = 0,
    progress: Report = None,
) -> PeriodicOrbit:
    """Find a periodic orbit with so many impacts in so many forcing periods.

    Newton's method solves the closed forms of all flights of the orbit together, for the times
    and velocities of its events, so that unstable orbits are found as easily as stable ones. One
    impact on a wall under one harmonic needs no search, nor do orbits without impacts and with
    sticking.

    Parameters
    ----------
    osc
        The oscillator.
    force
        The forcing, with a period; None or a constant for free motion, whose period is found.
    n_impacts
        Impacts on walls and entries into soft stops: 0 for none, `math.inf` with sticking.
    n_periods
        Forcing periods, >= 1. Not looked at for free motion.
    sequence
        The stops met, in order; default: what a search finds.
    guess
        Where to start: (cycle, v_after) of an impact, a run that settles on the orbit, or an
        orbit of a similar system; by default of a run and of an orbit one with its impacts and
        periods is found.
        Default: a search from random starts.
    seed
        Of the random starts.
    progress
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called after each start of the search, and ends it by
        returning False: the best orbit found so far is returned.

    Returns
    -------
    PeriodicOrbit
        Without a guess the most stable admissible one, and of several the one with the fastest
        least impact. An orbit that passes through a stop is returned only if nothing else is
        found, or the guess leads to it; its `admissible` is False.

    Warns
    -----
    FormalOrbitWarning
        If the orbit passes through a stop: no motion follows it.

    Raises
    ------
    ParameterError
        If the forcing has no period, a number or the guess does not fit, or the orbit would last
        for more than some 100,000 swings.
    ConvergenceError
        If nothing is found, within some ten million swings of all motions that are followed.

    Examples
    --------
    >>> import percuss as pc
    >>> orbit = find_orbit(pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05),
    ...                    pc.cosine(1.0))
    >>> orbit
    <PeriodicOrbit: 1 impact in 1 forcing period, T = 6.28319, asymptotic, \
abs(multipliers) 0.5843, 0.5843>
    >>> round(float(orbit.impacts.v_before[0]), 12)
    1.695732937595
    """
    orbit = find_formal_orbit(
        osc, force, n_impacts, n_periods, sequence, guess, seed=seed, progress=progress
    )
    if not orbit.admissible:
        warnings.warn(_why_formal(orbit), FormalOrbitWarning, stacklevel=2)
    return orbit


def find_formal_orbit(
    osc: Oscillator,
    force: Forcing | None = None,
    n_impacts: float = 1,
    n_periods: int = 1,
    sequence: Sequence[int] | None = None,
    guess: GivenGuess | None = None,
    *,
    seed: int = 0,
    progress: Report = None,
) -> PeriodicOrbit:
    """Find a periodic orbit as `find_orbit` does, without a warning where it is formal.

    For callers that look at `admissible` themselves. Parameters, value and errors are those of
    `find_orbit`.
    """
    n_impacts, n_periods = _counts(n_impacts, n_periods)
    _check(osc, force, n_impacts, sequence)
    if guess is not None:
        n_impacts, n_periods = counts_of_guess(guess, n_impacts, n_periods)
        # Of orbits without impacts and with sticking there is nothing to guess: they are complete.
        if n_impacts not in (0, math.inf):
            return orbit_near(osc, force, int(n_impacts), n_periods, sequence, guess)
        _check(osc, force, n_impacts, None)
    table = law(osc, force)
    check_length(table, n_impacts, n_periods)
    budget = SearchBudget(table, progress, starts_of(osc, table) + SCATTERED + ATTRACTED)
    found: list[PeriodicOrbit] = []
    for search in (_wanted, _scattered, _attracting):
        found += search(osc, force, n_impacts, n_periods, sequence, seed, budget)
        if budget.end_reason or any(orbit.admissible for orbit in found):
            break
    budget.close()
    if not found:
        what = described(n_impacts, n_periods if _has_period(force) else 0)
        why = f"; the search ended: {budget.end_reason}" if budget.end_reason else ""
        advice = "give a guess: (cycle, v_after) of an impact, or a run that settles on it"
        raise ConvergenceError(f"no orbit with {what} found{why}", None, math.nan, advice)
    return min(found, key=_order)


def _why_formal(orbit: PeriodicOrbit) -> str:
    if len(orbit.passages):
        k = int(np.argmax(orbit.passages.depth))
        stop, depth = orbit.passages.stop[k], orbit.passages.depth[k]
        where = f"it passes through stop {stop}, by {depth:.3g} at t = {orbit.passages.t[k]:.6g}"
    else:
        where = "one of its flights lasts less than no time"
    return f"the orbit is formal, no motion follows it: {where}; its admissible is False"


def find_orbits(
    osc: Oscillator,
    force: Forcing | None = None,
    max_impacts: int = 3,
    max_periods: int = 4,
    seed: int = 0,
    *,
    formal: bool = False,
    effort: float = 1.0,
    progress: Report = None,
) -> FoundOrbits:
    """Find all periodic orbits that a search from random starts finds, each once.

    Orbits with one impact on a wall under one harmonic, without impacts and with sticking are
    complete: they come from closed forms. The others start from stretches of motions that almost
    close; of a family of orbits in one system one member is given. From how many starts each
    orbit was reached tells about how many were reached from none (`unseen_estimate`). The search
    goes on until this estimate is below a quarter of an orbit, or its effort is spent: some ten million swings
    of all motions that are followed at the most. Very unstable orbits are reached from one start
    in a thousand or fewer; where none of them was seen the estimate cannot know of them.

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period, or is None or constant.
    max_impacts, max_periods
        The longest orbits to look for, >= 1.
    seed
        Of the random starts.
    formal
        Whether to return those, too, that pass through a stop between impacts.
    effort
        Multiplies the starts, 0.1 to 100: 200 from each stop at least and 800 at most. More find
        more of the orbits that are hard to reach, which are the very unstable ones.
    progress
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called after each start of the search, and ends it by
        returning False: those found so far are returned.

    Returns
    -------
    FoundOrbits
        A list of `PeriodicOrbit`, by n_periods, then n_impacts, then stability, with
        `unseen_estimate` and `n_searches`.

    Raises
    ------
    ParameterError
        If the forcing has no period, a number is out of range, or the longest orbits would last
        for more than some 100,000 swings.

    Examples
    --------
    Below a fold of the gap, a stable and an unstable orbit beside the one without impacts:

    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.7, wall="1.45789", side="above", damping=0.05)
    >>> for orbit in find_orbits(osc, pc.cosine("1.5"), max_impacts=1, max_periods=1):
    ...     print(orbit.n_impacts, orbit.stability)
    0 asymptotic
    1 asymptotic
    1 unstable

    Of a search the estimate of what is unseen is told:

    >>> found = find_orbits(osc, pc.cosine("1.5"), max_impacts=2, max_periods=2)
    >>> found.unseen_estimate < 1.0
    True
    """
    max_impacts, max_periods = (
        whole("max_impacts", max_impacts, 1),
        whole("max_periods", max_periods, 1),
    )
    raise_first(kind_faults(osc, force))
    _check(osc, force, max_impacts if osc.stops else 0, None)
    table = law(osc, force)
    check_length(table, max_impacts, max_periods)
    if not LEAST_EFFORT <= effort <= MOST_EFFORT:
        reason = f"outside {LEAST_EFFORT:g} to {MOST_EFFORT:g}; 1 is the usual effort"
        raise ParameterError("effort", effort, reason)
    batch_counts = max(1, round(effort * FEWEST_BATCHES)), max(1, round(effort * MOST_BATCHES))
    budget = SearchBudget(table, progress, starts_of(osc, table, batch_counts[1]))
    unseen = Unseen()
    found: list[PeriodicOrbit] = []
    for orbit in _all(osc, force, (max_impacts, max_periods), seed, budget, batch_counts, unseen):
        wanted = (orbit.admissible or formal) and not _only_touches(orbit)
        if wanted and not any(are_same(orbit, other) for other in found):
            found.append(orbit)
    budget.close()
    found.sort(key=lambda orbit: (orbit.n_periods, orbit.n_impacts, *_order(orbit)))
    return FoundOrbits(found, unseen.estimate, budget.n_done)


def _counts(n_impacts: float, n_periods: int) -> tuple[float, int]:
    """Return impacts and periods as Python's numbers; a float that is whole will do."""
    numbers = plain(n_impacts), plain(n_periods)
    impacts, periods = (int(n) if isinstance(n, float) and n.is_integer() else n for n in numbers)
    if impacts != math.inf and not (isinstance(impacts, int) and impacts >= 0):
        raise ParameterError("n_impacts", impacts, "neither a whole number nor inf")
    return cast("float", impacts), whole("n_periods", periods, 1)


def _check(
    osc: Oscillator,
    force: Forcing | None,
    n_impacts: float,
    sequence: Sequence[int] | None,
) -> None:
    raise_first(kind_faults(osc, force))
    if force is not None and force.harmonics and force.period is None:
        reason = "a periodic orbit needs a periodic forcing; give period= where it has one"
        raise ParameterError("forcing.period", None, reason)
    if n_impacts in (0, math.inf) and not _has_period(force):
        reason = "free motion has no orbit of this kind that is not rest or a free oscillation"
        raise ParameterError("n_impacts", n_impacts, reason)
    if n_impacts != 0 and not osc.stops:
        raise ParameterError("n_impacts", n_impacts, "the oscillator has no stops to meet")
    if sequence is not None and len(sequence) != n_impacts:
        reason = f"not one stop for each of the {n_impacts} impacts"
        raise ParameterError("sequence", tuple(sequence), reason)
    if sequence is not None:
        # It says what is wrong with a stop that is none, or with one that is on the way.
        events_of_stops(osc, law(osc, force), tuple(sequence))
    if not _has_period(force) and as_float(osc.damping) > 0.0:
        reason = "free motion loses energy all the time and never returns"
        raise ParameterError("oscillator.damping", osc.damping, reason)


def _has_period(force: Forcing | None) -> bool:
    return force is not None and force.period is not None


def _only_touches(orbit: PeriodicOrbit) -> bool:
    """Return whether one of several impacts has no velocity: the orbit without it is the same."""
    if not 2 <= orbit.n_impacts < math.inf:
        return False
    return orbit.min_impact_speed <= NO_SPEED * float(np.abs(orbit.impacts.v_before).max())


def _order(orbit: PeriodicOrbit) -> tuple[bool, int, float]:
    slowest = 0.0 if orbit.n_impacts == 0 else orbit.min_impact_speed
    return not orbit.admissible, _RANKS.index(orbit.stability), -slowest


def _wanted(
    osc: Oscillator,
    force: Forcing | None,
    n_impacts: float,
    n_periods: int,
    sequence: Sequence[int] | None,
    seed: int,
    budget: SearchBudget,
) -> Iterator[PeriodicOrbit]:
    """Yield orbits of one kind."""
    periods = n_periods if _has_period(force) else 0
    if force is not None and n_impacts == 0:
        yield from _steady(osc, force, every=False)
    elif force is not None and math.isinf(n_impacts):
        found = sticking_orbits(osc, force, n_periods)
        yield from (orbit for orbit in found if orbit.n_periods == n_periods)
    else:
        counts = int(n_impacts), n_periods
        for orbit in _impacting(osc, force, *counts, seed, budget, exactly=True):
            if (orbit.n_impacts, orbit.n_periods) != (n_impacts, periods):
                continue
            if sequence is None or _is_rotation(orbit.sequence, tuple(sequence)):
                yield orbit


def _scattered(
    osc: Oscillator,
    force: Forcing | None,
    n_impacts: float,
    n_periods: int,
    sequence: Sequence[int] | None,
    seed: int,
    budget: SearchBudget,
) -> Iterator[PeriodicOrbit]:
    """Yield orbits of one kind from guesses at random, where the order of the stops is known."""
    if force is None or not _has_period(force) or n_impacts in (0, math.inf):
        return
    if sequence is None and len(osc.stops) > 1:
        return
    stops = (0,) * int(n_impacts) if sequence is None else tuple(sequence)
    known = Known(osc, force)
    for guess in scattered(osc, force, stops, n_periods, seed, budget):
        orbit = _refined(guess, known, budget)
        if orbit is not None and (orbit.n_impacts, orbit.n_periods) == (n_impacts, n_periods):
            yield orbit


def _attracting(
    osc: Oscillator,
    force: Forcing | None,
    n_impacts: float,
    n_periods: int,
    sequence: Sequence[int] | None,
    seed: int,
    budget: SearchBudget,
) -> Iterator[PeriodicOrbit]:
    """Yield orbits of one kind to which motions settle that are followed for long."""
    if force is None or not _has_period(force) or n_impacts in (0, math.inf):
        return
    counts = int(n_impacts), n_periods
    for motion in settled_motions(
        osc, force, *counts, n_starts=ATTRACTED, seed=seed, budget=budget
    ):
        orbit = motion.orbit
        if orbit is None or (orbit.n_impacts, orbit.n_periods) != counts:
            continue
        if sequence is None or _is_rotation(orbit.sequence, tuple(sequence)):
            yield orbit


def _is_rotation(one: tuple[int, ...], other: tuple[int, ...]) -> bool:
    return len(one) == len(other) and any(
        one == other[k:] + other[:k] for k in range(max(1, len(other)))
    )


def _all(
    osc: Oscillator,
    force: Forcing | None,
    counts: tuple[int, int],
    seed: int,
    budget: SearchBudget,
    batch_counts: tuple[int, int],
    unseen: Unseen,
) -> Iterator[PeriodicOrbit]:
    if force is not None and _has_period(force):
        yield from _steady(osc, force, every=True)
        yield from sticking_orbits(osc, force, counts[1])
    if not osc.stops:
        return
    if force is None or not _has_period(force):
        unseen.estimate = math.nan
        yield from _impacting(osc, force, *counts, seed, budget, exactly=False)
        return
    closed = _closed_forms(osc, force)
    for stop in closed:
        for n in range(1, counts[1] + 1):
            yield from single_impact_orbits(osc, force, n, stop)
    if counts[0] == 1 and len(closed) == len(osc.stops):
        return
    known = Known(osc, force)
    fewest, most = batch_counts
    for k, batch in enumerate(batches(osc, force, *counts, seed, budget, most)):
        for guess in batch:
            orbit = _refined(guess, known, budget)
            if orbit is not None:
                yield orbit
            if not budget.goes_on():
                break
        # Orbits from closed forms are known without a search.
        unseen.estimate = estimate_unseen(
            len(trials)
            for trials, admissible, signature in zip(
                known.trials, known.admissible, known.signatures, strict=True
            )
            if admissible and not (len(signature.stops) == 1 and signature.stops[0] in closed)
        )
        if not budget.goes_on() and k + 1 < fewest:
            # Cut short before there was enough to estimate from.
            unseen.estimate = math.nan
        if k + 1 >= fewest and unseen.estimate < ENOUGH:
            return


@dataclass(slots=True)
class Unseen:
    """How many orbits a search has probably not seen."""

    estimate: float = 0.0


def _closed_forms(osc: Oscillator, force: Forcing | None) -> list[int]:
    return [stop for stop in range(len(osc.stops)) if has_closed_form(osc, force, stop)]


def _steady(osc: Oscillator, force: Forcing, *, every: bool) -> Iterator[PeriodicOrbit]:
    """Yield orbits without impacts: of every region, or the one free of stops and what fits."""
    table = law(osc, force)
    free = free_region(osc, table)
    for region in regions(table):
        try:
            orbit = steady_orbit(osc, force, region)
        except ConvergenceError:
            # The one that was asked for tells why there is none.
            if not every and region == free:
                raise
            continue
        if orbit.admissible or region == free:
            yield orbit


def _impacting(
    osc: Oscillator,
    force: Forcing | None,
    max_impacts: int,
    max_periods: int,
    seed: int,
    budget: SearchBudget,
    *,
    exactly: bool,
) -> Iterator[PeriodicOrbit]:
    """Yield orbits with impacts: from closed forms, then from a search.

    ``exactly`` takes those with as many impacts and periods only.
    """
    closed = _closed_forms(osc, force)
    if force is not None and (max_impacts == 1 or not exactly):
        for stop in closed:
            for n in range(max_periods if exactly else 1, max_periods + 1):
                yield from single_impact_orbits(osc, force, n, stop)
        if max_impacts == 1 and len(closed) == len(osc.stops):
            return
    known = Known(osc, force)
    counts = max_impacts, max_periods if _has_period(force) else 0
    for guess in guesses(osc, force, max_impacts, max_periods, seed, budget, exactly=exactly):
        if exactly and (guess.n_impacts, guess.n_periods) != counts:
            continue
        orbit = _refined(guess, known, budget)
        if orbit is not None:
            yield orbit
        if not budget.goes_on():
            return


def _refined(guess: Guess, known: Known, budget: SearchBudget) -> PeriodicOrbit | None:
    """Return the new orbit that a guess leads to, if there is one."""
    orbit = refined(known.osc, known.forcing, guess, known)
    budget.solved(len(guess.chain))
    if orbit is not None:
        budget.made(orbit.period)
    return orbit


# The estimate is of what a search with so many times the samples would show.
SAMPLES = 6.0


class FoundOrbits(list[PeriodicOrbit]):
    """The list of the periodic orbits that `find_orbits` has found.

    Parameters
    ----------
    orbits
        The orbits.
    unseen_estimate
        How many orbits of the kinds that were looked for have not been found, estimated from how
        often the others were (`estimate_unseen`); 0 where closed forms give all, NaN where the search
        gives no estimate (free motion, or too few starts).
    n_searches
        From how many starts was searched.
    """

    def __init__(
        self,
        orbits: Iterable[PeriodicOrbit] = (),
        unseen_estimate: float = math.nan,
        n_searches: int = 0,
    ) -> None:
        super().__init__(orbits)
        self.unseen_estimate, self.n_searches = unseen_estimate, n_searches

    def __repr__(self) -> str:
        """Tell the orbits, one a line, and how complete they are."""
        return "\n".join([*map(repr, self), self.completeness()])

    def completeness(self) -> str:
        """Return in words how many orbits were found and how many may be missing."""
        n = len(self)
        found = f"{n} periodic orbit" + ("" if n == 1 else "s")
        if self.n_searches == 0:
            return f"{found} from closed forms"
        found += f" from {self.n_searches:,} starts"
        if math.isnan(self.unseen_estimate):
            return found
        return f"{found}; some {self.unseen_estimate:.2g} more are estimated to be unseen"


def estimate_unseen(counts: Iterable[int]) -> float:
    """Return about how many kinds are unseen, from how often each of the others was seen.

    The larger of two estimates. With f1 kinds seen once and f2 seen twice there are at least
    f1^2 / (2 f2) more on average (Chao 1984, Scand. J. Statist. 11, 265); without any seen twice,
    f1 (f1 + 1) / 2. That bound is low where kinds are seen at rates of many orders, as orbits are
    by their multipliers: then each doubling of the samples shows as many new kinds as the last
    one did, which is the sum of 2^-n over the kinds, n being how often each was seen. The second
    estimate is what six times as many samples would show at this pace.

    Parameters
    ----------
    counts
        In how many independent samples each kind was seen, >= 1.

    Returns
    -------
    float
        The estimate, >= 0.

    Examples
    --------
    >>> round(estimate_unseen([1, 1, 1, 2, 30]), 2), round(estimate_unseen([2, 3, 27, 400]), 2)
    (4.52, 0.97)
    """
    seen = list(counts)
    once, twice = seen.count(1), seen.count(2)
    least = once**2 / (2.0 * twice) if twice else 0.5 * once * (once + 1)
    pace = math.fsum(0.5**n for n in seen)
    return max(least, pace * log(SAMPLES) / log(2.0))
