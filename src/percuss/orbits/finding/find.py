"""Finding periodic orbits, stable or not."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, cast, overload

import numpy as np

from percuss.errors import ConvergenceError, FormalOrbitWarning, ParameterError
from percuss.kernels.law_columns import DAMPING
from percuss.model.exact import as_float, plain, whole
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator, Wall
from percuss.model.periods import require_period
from percuss.model.restitution import is_elastic
from percuss.model.structure import Structure
from percuss.model.system import System
from percuss.motion.structures import StructureTrajectory
from percuss.orbits.finding.find_structures import find_structure_orbits
from percuss.orbits.finding.found import (
    ENOUGH,
    FoundOrbits,
    check_effort,
    estimate_unseen,
)
from percuss.orbits.finding.refine_guess import (
    Known,
    counts_of_guess,
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
from percuss.orbits.orbit.signature import are_same
from percuss.orbits.orbit.steady import free_region, regions, steady_orbit
from percuss.orbits.orbit.sticking import sticking_orbits
from percuss.orbits.orbit.structure_orbit import StructureOrbit, find_structure_orbit
from percuss.progress import Report
from percuss.wording import counts_in_words

# From the best to the worst.
_RANKS = ("asymptotic", "elliptic", "parabolic", "unstable")
# Motions that are followed for long where no admissible orbit is found otherwise.
ATTRACTED = 40
# Velocity of an impact that is rounding, as a part of the fastest.
NO_SPEED = 1e-12
# Instants of a period at which its fastest motion is looked for.
SAMPLES = 64


@overload
def find_orbit(
    osc: Oscillator,
    force: Forcing | None = None,
    n_impacts: float = 1,
    n_periods: int = 1,
    sequence: Sequence[int] | None = None,
    guess: GivenGuess | None = None,
    *,
    seed: int = 0,
    formal: bool = False,
    progress: Report = None,
) -> PeriodicOrbit: ...
@overload
def find_orbit(
    osc: Structure,
    force: Loads | Mapping[Any, Forcing] | Forcing,
    *,
    n_periods: int = 1,
    guess: tuple[object, object] | StructureTrajectory | StructureOrbit | None = None,
) -> StructureOrbit: ...
def find_orbit(
    osc: Any,
    force: Any = None,
    n_impacts: float = 1,
    n_periods: int = 1,
    sequence: Sequence[int] | None = None,
    guess: Any = None,
    *,
    seed: int = 0,
    formal: bool = False,
    progress: Report = None,
) -> Any:
    """Find a periodic orbit with so many impacts in so many forcing periods.

    Newton's method solves the closed forms of all flights of the orbit together, for the times
    and velocities of its events, so that unstable orbits are found as easily as stable ones. One
    impact on a wall under one harmonic needs no search, nor do orbits without impacts and with
    sticking.

    An orbit of a structure is found by Newton's method on the map over its period, from the state
    of a guess, or where a motion from rest is after 200 periods, or some more if none is found from
    there; it takes `n_periods` and `guess` alone, and returns a `StructureOrbit`.

    Parameters
    ----------
    osc
        The oscillator, or a `Structure`.
    force
        The forcing, with a period, of a structure its loads; None or a constant for free motion,
        whose period is found: with negative damping, a limit cycle.
    n_impacts
        Impacts on walls and entries into soft stops: 0 for none, `math.inf` with sticking.
    n_periods
        Forcing periods, >= 1. Disregarded for free motion.
    sequence
        The stops met, in order; default: what a search finds.
    guess
        Where to start: (cycle, v_after) of an impact, a run that settles on the orbit, or an
        orbit of a similar system; by default of a run and of an orbit one with its impacts and
        periods is found. Of a structure: (x0, v0) at t = 0, a run that settles on the orbit, or an
        orbit of a similar one. Default: a search from random starts.
    seed
        Of the random starts.
    formal
        Whether a formal orbit is returned without a warning.
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

    Two masses, of which the first meets a stiff stop (example 03 of NLvib):

    >>> structure = pc.Structure(
    ...     mass=[1, 1], stiffness=[[1, -1], [-1, 2]], damping=[["0.03", "-0.03"], ["-0.03", "0.06"]],
    ...     stops=[pc.SoftStop(at=1, side="above", stiffness=100, on=0)],
    ... )
    >>> orbit = pc.find_orbit(structure, pc.Loads({1: pc.cosine("0.65", amplitude="0.1")}))
    >>> orbit.run.crossings.t.round(9), orbit.is_stable
    (array([0.14800746, 0.44255645]), True)
    """
    if isinstance(osc, Structure):
        for name, value, is_given in (
            ("n_impacts", n_impacts, n_impacts != 1),
            ("sequence", sequence, sequence is not None),
            ("formal", formal, formal),
        ):
            if is_given:
                reason = "of a structure the orbit near a guess is found, with the impacts it has"
                raise ParameterError(name, value, reason)
        return find_structure_orbit(osc, force, guess, n_periods)
    seed = whole("seed", seed, 0, math.inf)
    n_impacts, n_periods = _counts(n_impacts, n_periods)
    system = System.of(osc, force)
    _check(system, n_impacts, sequence)
    if guess is not None:
        n_impacts, n_periods = counts_of_guess(guess, n_impacts, n_periods)
        if n_impacts in (0, math.inf):
            # All orbits without impacts and with sticking are known: they need no guess.
            _check(system, n_impacts, None)
            guess = sequence = None
    if guess is not None:
        orbit = orbit_near(system, int(n_impacts), n_periods, sequence, guess)
    else:
        orbit = _searched(_Wanted(system, n_impacts, n_periods, sequence, seed), progress)
    if not orbit.admissible and not formal:
        warnings.warn(_why_formal(orbit), FormalOrbitWarning, stacklevel=2)
    return orbit


def _why_formal(orbit: PeriodicOrbit) -> str:
    if len(orbit.passages):
        k = int(np.argmax(orbit.passages.depth))
        stop, depth = orbit.passages.stop[k], orbit.passages.depth[k]
        where = f"it passes through stop {stop}, by {depth:.3g} at t = {orbit.passages.t[k]:.6g}"
    else:
        where = "one of its flights has a negative duration"
    return f"the orbit is formal, no motion follows it: {where}; its admissible is False"


@overload
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
) -> FoundOrbits[PeriodicOrbit]: ...
@overload
def find_orbits(
    osc: Structure,
    force: Loads | Mapping[Any, Forcing] | Forcing,
    max_impacts: int = 3,
    max_periods: int = 4,
    seed: int = 0,
    *,
    formal: bool = False,
    effort: float = 1.0,
    progress: Report = None,
) -> FoundOrbits[StructureOrbit]: ...
def find_orbits(
    osc: Any,
    force: Any = None,
    max_impacts: int = 3,
    max_periods: int = 4,
    seed: int = 0,
    *,
    formal: bool = False,
    effort: float = 1.0,
    progress: Report = None,
) -> Any:
    """Find all periodic orbits that a search from random starts finds, each once.

    Orbits with one impact on a wall under one harmonic, without impacts and with sticking are
    complete: they come from closed forms. The search for the others starts from stretches of
    motions that almost close; of a family of orbits in one system one member is given. The number
    of starts from which each orbit was reached gives an estimate of how many were reached from none
    (`unseen_estimate`). The search goes on until this estimate is below a quarter of an orbit, or
    its effort is spent: some ten million swings of all motions that are followed at the most. Very
    unstable orbits are reached from one start in a thousand or fewer; where none of them was seen
    the estimate does not count them.

    Orbits of a structure are found by shooting: Newton's method on the map over the period of the
    loads, from random starts and from where their motions almost close. Its linear response is the
    only orbit that needs no start.

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period, or is None or constant. A `Structure` has loads with
        a common period.
    max_impacts, max_periods
        The longest orbits to look for, >= 1. Of a structure the impacts on all walls and entries
        into all soft stops of an orbit are counted; orbits that stick are given whatever their
        number.
    seed
        Of the random starts.
    formal
        Whether to return formal orbits too, which pass through a stop between impacts; not of a
        structure.
    effort
        Multiplies the starts, 0.1 to 100: 200 from each stop at least and 800 at most, of a
        structure 40 to 160. More find more of the orbits that are hard to reach, which are the
        very unstable ones.
    progress
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called after each start of the search, and ends it by
        returning False: those found so far are returned.

    Returns
    -------
    FoundOrbits
        A list of `PeriodicOrbit`, or of a structure of `StructureOrbit`, by n_periods, then
        n_impacts, then stability, with `unseen_estimate` and `n_searches`.

    Raises
    ------
    ParameterError
        If the forcing has no period, a number is out of range, the longest orbits would last for
        more than some 100,000 swings, or formal orbits of a structure are asked for.

    Examples
    --------
    Below a fold of the gap, a stable and an unstable orbit, and the one without impacts:

    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(0.7, wall="1.45789", side="above", damping=0.05)
    >>> for orbit in find_orbits(osc, pc.cosine("1.5"), max_impacts=1, max_periods=1):
    ...     print(orbit.n_impacts, orbit.stability)
    0 asymptotic
    1 asymptotic
    1 unstable

    After a search the number of unseen orbits is estimated:

    >>> orbits = find_orbits(osc, pc.cosine("1.5"), max_impacts=2, max_periods=2)
    >>> orbits.unseen_estimate < 1.0
    True

    Two masses, of which the first meets a stiff stop (example 03 of NLvib): beside the response
    without a contact there are two unstable ones with a contact a period of the force, and a stable
    one over two periods:

    >>> structure = pc.Structure(
    ...     mass=[1, 1], stiffness=[[1, -1], [-1, 2]], damping=[["0.03", "-0.03"], ["-0.03", "0.06"]],
    ...     stops=[pc.SoftStop(at=1, side="above", stiffness=100, on=0)],
    ... )
    >>> orbits = pc.find_orbits(structure, pc.Loads({1: pc.cosine("0.75", amplitude="0.1")}), 2, 2)
    >>> for orbit in orbits:
    ...     print(orbit.n_periods, orbit.n_impacts, orbit.is_stable)
    1 0 True
    1 1 False
    1 1 False
    2 2 True
    """
    seed = whole("seed", seed, 0, math.inf)
    if isinstance(osc, Structure):
        return find_structure_orbits(
            osc, force, max_impacts, max_periods, seed,
            formal=formal, effort=effort, progress=progress,
        )  # fmt: skip
    max_impacts, max_periods = (
        whole("max_impacts", max_impacts, 1),
        whole("max_periods", max_periods, 1),
    )
    system = System.of(osc, force)
    _check(system, max_impacts if osc.stops else 0, None)
    check_length(system.law, max_impacts, max_periods, given="max")
    batch_counts = check_effort(effort)
    budget = SearchBudget(system.law, progress, starts_of(system, batch_counts[1]))
    unseen = Unseen()
    orbits: list[PeriodicOrbit] = []
    for orbit in _all(system, (max_impacts, max_periods), seed, budget, batch_counts, unseen):
        wanted = (orbit.admissible or formal) and not _has_idle_impact(orbit)
        if wanted and not any(are_same(orbit, other) for other in orbits):
            orbits.append(orbit)
    budget.close()
    orbits.sort(key=lambda orbit: (orbit.n_periods, orbit.n_impacts, *_order(orbit)))
    return FoundOrbits(orbits, unseen.estimate, budget.n_done)


def _counts(n_impacts: float, n_periods: int) -> tuple[float, int]:
    """Return impacts and periods as Python's numbers; whole floats are accepted."""
    numbers = plain(n_impacts), plain(n_periods)
    impacts, periods = (int(n) if isinstance(n, float) and n.is_integer() else n for n in numbers)
    if impacts != math.inf and not (isinstance(impacts, int) and impacts >= 0):
        raise ParameterError("n_impacts", impacts, "neither a whole number nor math.inf")
    return cast("float", impacts), whole("n_periods", periods, 1)


def _check(system: System, n_impacts: float, sequence: Sequence[int] | None) -> None:
    osc, force = system
    if force is not None and not force.is_constant:
        require_period(force, "a periodic orbit needs a periodic forcing")
    if n_impacts in (0, math.inf) and system.period is None:
        reason = "free motion has no orbit of this kind that is not rest or a free oscillation"
        raise ParameterError("n_impacts", n_impacts, reason)
    if n_impacts != 0 and not osc.stops:
        raise ParameterError("n_impacts", n_impacts, "the oscillator has no stops to meet")
    if sequence is not None and len(sequence) != n_impacts:
        reason = f"not one stop for each of the {n_impacts} impacts"
        raise ParameterError("sequence", tuple(sequence), reason)
    if sequence is not None:
        # It raises the error of a stop that there is not, or that lies between two others.
        events_of_stops(system, tuple(sequence))
    if system.period is None:
        _check_energy(system)


def _check_energy(system: System) -> None:
    """Refuse free motion that only loses, or only gains, energy."""
    osc, dampings = (
        system.oscillator,
        [float(system.law[row, DAMPING]) for row in regions(system.law)],
    )
    elastic = all(is_elastic(stop.restitution) for stop in osc.stops if isinstance(stop, Wall))
    if as_float(osc.damping) > 0.0 and min(dampings) >= 0.0:
        reason = "free motion loses energy all the time and never returns"
    elif as_float(osc.damping) < 0.0 and max(dampings) <= 0.0 and elastic:
        reason = "free motion gains energy all the time and never returns"
    else:
        return
    raise ParameterError("oscillator.damping", osc.damping, reason)


def _has_idle_impact(orbit: PeriodicOrbit) -> bool:
    """Return whether an impact has zero velocity: without it the orbit is the same."""
    if not 1 <= orbit.n_impacts < math.inf:
        return False
    fastest = float(np.abs(orbit.impacts.v_before).max())
    if orbit.n_impacts == 1:
        # Of one impact alone the motion tells what is fast.
        times = np.linspace(orbit.t0, orbit.t0 + orbit.period, SAMPLES)
        fastest = float(np.abs(orbit.trajectory()(times)[1]).max())
    return orbit.min_impact_speed <= NO_SPEED * fastest


def _order(orbit: PeriodicOrbit) -> tuple[bool, int, float]:
    slowest = 0.0 if orbit.n_impacts == 0 else orbit.min_impact_speed
    return not orbit.admissible, _RANKS.index(orbit.stability), -slowest


class _Wanted(NamedTuple):
    """The orbit that a caller looks for."""

    system: System
    n_impacts: float
    n_periods: int
    sequence: Sequence[int] | None
    seed: int

    def is_met(self, orbit: PeriodicOrbit) -> bool:
        """Return whether an orbit has these impacts and periods, and meets these stops."""
        if self.n_impacts == 0:
            return True
        periods = self.n_periods if self.system.period is not None else 0
        if (orbit.n_impacts, orbit.n_periods) != (self.n_impacts, periods):
            return False
        if _has_idle_impact(orbit):
            return False
        return self.sequence is None or _is_rotation(orbit.sequence, tuple(self.sequence))

    @property
    def may_be_guessed(self) -> bool:
        """Whether there are forced orbits with finitely many impacts, which a guess leads to."""
        return self.system.period is not None and self.n_impacts not in (0, math.inf)


def _searched(wanted: _Wanted, progress: Report) -> PeriodicOrbit:
    """Return the best orbit of a search; ConvergenceError if there is none."""
    system, n_impacts, n_periods, *_ = wanted
    check_length(system.law, n_impacts, n_periods)
    n_starts = starts_of(system) + SCATTERED + ATTRACTED
    budget = SearchBudget(system.law, progress, n_starts)
    orbits: list[PeriodicOrbit] = []
    for search in (_from_motions, _from_random_guesses, _from_attractors):
        orbits += (orbit for orbit in search(wanted, budget) if wanted.is_met(orbit))
        if budget.end_reason or any(orbit.admissible for orbit in orbits):
            break
    budget.close()
    if not orbits:
        what = counts_in_words(n_impacts, n_periods if system.period is not None else 0)
        why = f"; the search ended: {budget.end_reason}" if budget.end_reason else ""
        advice = "give a guess: (cycle, v_after) of an impact, or a run that settles on it"
        raise ConvergenceError(f"no orbit with {what} found{why}", None, math.nan, advice)
    return min(orbits, key=_order)


def _from_motions(wanted: _Wanted, budget: SearchBudget) -> Iterator[PeriodicOrbit]:
    """Yield orbits from closed forms and from stretches of motions that almost close."""
    system, n_impacts, n_periods, _, seed = wanted
    if n_impacts == 0:
        yield from _steady(system, every=False)
    elif math.isinf(n_impacts):
        yield from sticking_orbits(system, n_periods)
    else:
        yield from _impacting(system, int(n_impacts), n_periods, seed, budget, exactly=True)


def _from_random_guesses(wanted: _Wanted, budget: SearchBudget) -> Iterator[PeriodicOrbit]:
    """Yield orbits from guesses at random, where the sequence of stops is known."""
    system, n_impacts, n_periods, sequence, seed = wanted
    if not wanted.may_be_guessed or (sequence is None and len(system.oscillator.stops) > 1):
        return
    stops = (0,) * int(n_impacts) if sequence is None else tuple(sequence)
    known = Known(system)
    for guess in scattered(system, stops, n_periods, seed, budget):
        orbit = _refined(guess, known, budget)
        if orbit is not None:
            yield orbit


def _from_attractors(wanted: _Wanted, budget: SearchBudget) -> Iterator[PeriodicOrbit]:
    """Yield orbits to which motions settle that are followed for long."""
    system, n_impacts, n_periods, _, seed = wanted
    if not wanted.may_be_guessed:
        return
    counts = int(n_impacts), n_periods
    for motion in settled_motions(system, *counts, n_starts=ATTRACTED, seed=seed, budget=budget):
        if motion.orbit is not None:
            yield motion.orbit


def _is_rotation(one: tuple[int, ...], other: tuple[int, ...]) -> bool:
    return len(one) == len(other) and any(
        one == other[k:] + other[:k] for k in range(max(1, len(other)))
    )


def _all(
    system: System,
    counts: tuple[int, int],
    seed: int,
    budget: SearchBudget,
    batch_counts: tuple[int, int],
    unseen: Unseen,
) -> Iterator[PeriodicOrbit]:
    """Yield all orbits that are found, and set the estimate of those that are not."""
    if system.period is not None:
        yield from _steady(system, every=True)
        yield from sticking_orbits(system, counts[1])
    if not system.oscillator.stops:
        return
    if system.period is None:
        unseen.estimate = math.nan
        yield from _impacting(system, *counts, seed, budget, exactly=False)
        return
    yield from _single_impacts(system, range(1, counts[1] + 1))
    closed = _closed_forms(system)
    if counts[0] == 1 and len(closed) == len(system.oscillator.stops):
        return
    known = Known(system)
    fewest, most = batch_counts
    for k, batch in enumerate(batches(system, counts, seed, budget, most)):
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
            # The samples of a search cut short are too few for an estimate.
            unseen.estimate = math.nan
        if k + 1 >= fewest and unseen.estimate < ENOUGH:
            return


@dataclass(slots=True)
class Unseen:
    """The estimate of how many orbits a search has not seen."""

    estimate: float = 0.0


def _closed_forms(system: System) -> list[int]:
    stops = range(len(system.oscillator.stops))
    return [stop for stop in stops if has_closed_form(system, stop)]


def _single_impacts(system: System, periods: Iterable[int]) -> Iterator[PeriodicOrbit]:
    """Yield the orbits with one impact that closed forms give."""
    osc, force = system
    if force is not None:
        for stop in _closed_forms(system):
            for n_periods in periods:
                yield from single_impact_orbits(osc, force, n_periods, stop)


def _steady(system: System, *, every: bool) -> Iterator[PeriodicOrbit]:
    """Yield admissible orbits without impacts, and that of the region free of stops."""
    free = free_region(system)
    for region in regions(system.law):
        try:
            orbit = steady_orbit(system, region)
        except ConvergenceError:
            # The error of the region asked for says why there is none.
            if not every and region == free:
                raise
            continue
        if orbit.admissible or region == free:
            yield orbit


def _impacting(
    system: System,
    max_impacts: int,
    max_periods: int,
    seed: int,
    budget: SearchBudget,
    *,
    exactly: bool,
) -> Iterator[PeriodicOrbit]:
    """Yield orbits with impacts: from closed forms, then from a search.

    ``exactly`` takes only those with as many impacts and periods.
    """
    if max_impacts == 1 or not exactly:
        yield from _single_impacts(system, range(max_periods if exactly else 1, max_periods + 1))
        if max_impacts == 1 and len(_closed_forms(system)) == len(system.oscillator.stops):
            return
    known = Known(system)
    counts = max_impacts, max_periods if system.period is not None else 0
    for guess in guesses(system, (max_impacts, max_periods), seed, budget, exactly=exactly):
        if exactly and (guess.n_impacts, guess.n_periods) != counts:
            continue
        orbit = _refined(guess, known, budget)
        if orbit is not None:
            yield orbit
        if not budget.goes_on():
            return


def _refined(guess: Guess, known: Known, budget: SearchBudget) -> PeriodicOrbit | None:
    """Return the new orbit that a guess leads to, if there is one."""
    orbit = refined(guess, known)
    budget.solved(len(guess.itinerary))
    if orbit is not None:
        budget.made(orbit.period)
    return orbit
