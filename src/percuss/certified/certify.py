"""One door: what is to be proven, and to how many digits."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast, overload

from percuss.certified.orbit_result import CertifiedOrbit
from percuss.certified.orbits import certify_orbit
from percuss.certified.proving import certify_run
from percuss.certified.ranges import Over
from percuss.certified.results import CertifiedRun
from percuss.certified.special import CertifiedPoint, certify_point
from percuss.errors import ParameterError
from percuss.model.exact import Phase, plain, whole
from percuss.model.faults import raise_first
from percuss.model.start import Start, start_faults
from percuss.motion.trajectory import Trajectory
from percuss.orbits.bifurcations.special_points import SpecialPoint
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit

__all__ = ["certify"]

MOST_BITS = 4096
MOST_DIGITS = 1000
FEWEST_BITS = 32


@overload
def certify(
    what: Trajectory,
    digits: int = 12,
    *,
    start: Start | None = None,
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
    what: SpecialPoint,
    digits: int = 12,
    *,
    most_bits: int = MOST_BITS,
    bits: int | None = None,
) -> CertifiedPoint: ...


def certify(
    what: Trajectory | PeriodicOrbit | SpecialPoint,
    digits: int = 12,
    *,
    start: Start | None = None,
    t_end: Phase | None = None,
    max_impacts: int | None = None,
    most_bits: int = MOST_BITS,
    bits: int | None = None,
    over: Over | None = None,
    progress: bool | Callable[[float, float], bool] | None = None,
) -> CertifiedRun | CertifiedOrbit | CertifiedPoint:
    """Prove a result in ball arithmetic: every number comes with a radius that is certain.

    The numbers of the model are taken exactly as they were given: ``"2.8"`` is 14/5, a float
    is that double. Precision rises until the digits are there, or ``most_bits`` are reached. What
    cannot be proven, such as a touch without velocity, ends the proof with a result that says up
    to where it goes and why (docs/theory/certified.md).

    - Of a run each impact is proven to exist, to be the first one after the one before, and to
      have a velocity; the balls hold the exact motion.
    - An orbit is proven to exist, to be alone or one of a family, to pass through no stop or
      through one, and to be asymptotically stable, elliptic or unstable.
    - Of a special point of a branch, a fold, period doubling, symmetry breaking, strong resonance,
      graze or corner, the parameter is enclosed.

    Parameters
    ----------
    what
        The run, orbit or special point.
    digits
        Decimal digits wanted, >= 1. A run's time is good to 10^-digits of itself or, near 0, of
        the mean flight time; its velocity of itself or of the fastest impact if that is larger;
        those of an orbit of its period and greatest velocity.
    start
        Another start than that of the run, which is taken as it was given to `simulate`:
        ``v0="0.45"`` is 9/20.
    t_end, max_impacts
        Other limits than those of the run; ``max_impacts`` counts entries into soft stops too.
    most_bits
        Precision at which to give up.
    bits
        Work at just this precision, whatever digits come of it.
    over
        A number of the force, by its path, that stands for all values in a `Ball` or between two
        exact numbers: the constant or an amplitude. The proof of a run or an orbit holds for each
        of them; a narrow ball is how a number that is no fraction, as cos(pi/5), is meant exactly.
    progress
        For a run, as of `simulate`: True shows a line, a function ``(done, total) -> bool`` is
        called after each event and stops the proof by returning False. It starts anew at each
        precision.

    Returns
    -------
    CertifiedRun, CertifiedOrbit or CertifiedPoint
        With the same names as the result that was given, and balls in place of floats.

    Raises
    ------
    ParameterError
        If a number is outside its domain, or `what` is nothing that can be certified.
    MissingExtraError
        If python-flint is not there.

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
    """
    digits, most_bits, bits = (plain(value) for value in (digits, most_bits, bits))  # type: ignore[assignment]
    _check(digits, most_bits, bits)
    if isinstance(what, Trajectory):
        if start is not None and not isinstance(start, Start):
            raise ParameterError("start", start, "not a Start; give pc.Start(x0, v0, t0)")
        begin = what.start if start is None else start
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
    if isinstance(what, SpecialPoint):
        if over is not None:
            raise ParameterError("over", dict(over), "a special point has a parameter of its own")
        return certify_point(what, digits, most_bits, bits)
    raise ParameterError("what", what, "neither a run, nor an orbit, nor a special point")


def _check(digits: object, most_bits: object, bits: object) -> None:
    for name, value, low, high in (
        ("digits", digits, 1, MOST_DIGITS),
        ("most_bits", most_bits, FEWEST_BITS, 2**20),
        ("bits", bits, FEWEST_BITS, 2**20),
    ):
        if name == "bits" and value is None:
            continue
        whole(name, value, low, high)
