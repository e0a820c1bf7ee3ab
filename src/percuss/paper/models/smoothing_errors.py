"""Errors of the motion with a smoothed force law against the bilinear one, as measured."""

from __future__ import annotations

import math
from functools import cache, lru_cache

import numpy as np

from percuss import numerics
from percuss.arrays import Floats
from percuss.ensembles.lyapunov import lyapunov_exponents
from percuss.model.harmonic_forces import cosine
from percuss.model.oscillator import bilinear_oscillator, impact_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.models.smooth_law import Rounding, growth_rate, smooth_motion

# k- of fig 2.
BELOW = 20.0
RADII: Floats = 0.5 ** np.arange(4.0, 14.0)
# A motion that crosses x = 0 fast: cos 1.3 t from (1/2, 0.3).
OMEGA, X0, V0 = 1.3, 0.5, 0.3
TIMES = np.concatenate(([0.0], np.linspace(1.0, 20.0, 200)))
# Under cos 1.7 t from (1/2, 0.8): before the second impact, away from the first.
STIFF_OMEGA, STIFF_SPEED, STIFF_TIME = 1.7, 0.8, 4.0
# Under cos 2.6 t from (0, 0.3), where neighbours part exponentially.
CHAOTIC_OMEGA, CHAOTIC_SPEED = "2.6", 0.3
CHAOTIC_RADII = (1e-2, 1e-3, 1e-4, 1e-5)
CHAOTIC_END = 140.0
FAR = 0.1
# Beta(1/3, 1/2) / 3, the integral of (1 - u^3)^(-1/2) over [0, 1].
CONTACT_INTEGRAL = 1.4021821053254543
# Motions for the statistics, how many periods their starts lie apart, and how long each may take.
# Starts nearer than a horizon share a stretch of motion: 20 periods apart, neighbours' gains were
# correlated by 0.6, and their standard error was too small by half.
CHAOTIC_STARTS, APART, LONGEST = 100, 100, 1000.0
EXPONENT_PERIODS = 20_000
_CHAOTIC = bilinear_oscillator(stiffness_below=BELOW)


def crossing_run() -> Trajectory:
    """Return the bilinear motion whose crossings of x = 0 are all fast."""
    osc = bilinear_oscillator(stiffness_below=BELOW)
    return simulate(osc, cosine(OMEGA), x0=X0, v0=V0, t_end=TIMES[-1])


@cache
def crossing_errors(rounding: Rounding = "parabola") -> Floats:
    """Return the largest error of the displacement up to t = 20, for each of `RADII`.

    All crossings of x = 0 in this motion are fast.

    Parameters
    ----------
    rounding
        Curve that rounds the kink.

    Examples
    --------
    >>> errors = crossing_errors()
    >>> round(float(np.log2(errors[-2] / errors[-1])), 1)
    2.0
    """
    exact = crossing_run()(TIMES)[0]
    return np.array(
        [np.abs(_smooth(radius, rounding)[0] - exact).max() for radius in RADII.tolist()]
    )


@cache
def _smooth(radius: float, rounding: Rounding = "parabola") -> tuple[Floats, Floats]:
    return smooth_motion(
        cosine(OMEGA), TIMES, X0, V0, stiffness_below=BELOW, radius=radius, rounding=rounding
    )


def bound_use(until: float) -> float:
    """Return the largest part of the proved bound that the errors use, over `RADII`.

    Parameters
    ----------
    until
        Up to which time.

    Returns
    -------
    float
        Largest sqrt((k+ + k-) dx^2 / 2 + dv^2) / (radius sqrt((k+ + k-) / 2) (e^(lambda t) - 1)).
    """
    exact_x, exact_v = crossing_run()(TIMES)
    mean = 0.5 * (1.0 + BELOW)
    chosen = (TIMES > 0.0) & (until >= TIMES)
    used = []
    for radius in RADII.tolist():
        x, v = _smooth(radius)
        error = numerics.hypot(math.sqrt(mean) * (x - exact_x), v - exact_v)[chosen]
        bound = radius * math.sqrt(mean) * numerics.expm1(growth_rate(1.0, BELOW) * TIMES[chosen])
        used.append(float((error / bound).max()))
    return max(used)


def _touching() -> tuple[Floats, Floats, Floats]:
    """Return two times, and x and v there of the motion that touches x = 0 at t = 0."""
    gain, ends = 1.0 / (1.0 - OMEGA**2), np.array([-1.0, 0.5])
    x = gain * (numerics.cos(OMEGA * ends) - numerics.cos(ends))
    v = gain * (numerics.sin(ends) - OMEGA * numerics.sin(OMEGA * ends))
    return ends, x, v


def touching_run() -> Trajectory:
    """Return the bilinear motion that touches x = 0 at t = 0."""
    ends, x, v = _touching()
    osc, start = bilinear_oscillator(stiffness_below=BELOW), (float(x[0]), float(v[0]))
    return simulate(osc, cosine(OMEGA), *start, t0=float(ends[0]), t_end=float(ends[-1]))


@cache
def grazing_errors(rounding: Rounding = "parabola") -> Floats:
    """Return the error a moment after the bilinear motion touched x = 0, for each of `RADII`.

    Parameters
    ----------
    rounding
        Curve that rounds the kink.

    Returns
    -------
    array
        (n,) jumps in velocity: sqrt(dx^2 + dv^2) at t = 1/2, after a touch at t = 0 of the motion
        x = (cos omega t - cos t) / (1 - omega^2).
    """
    ends, x, v = _touching()
    errors = []
    for radius in RADII.tolist():
        smooth = smooth_motion(
            cosine(OMEGA),
            ends,
            float(x[0]),
            float(v[0]),
            stiffness_below=BELOW,
            radius=radius,
            rounding=rounding,
        )
        errors.append(math.hypot(smooth[0][-1] - x[-1], smooth[1][-1] - v[-1]))
    return np.array(errors)


def grazing_jump(radius: Floats) -> Floats:
    """Return the jump in velocity at a touch with x'' = 1, to leading order (parabola).

    (4 sqrt(2) / 15) (k- - k+) radius^(3/2).

    Examples
    --------
    >>> float((grazing_errors() / grazing_jump(RADII))[-1].round(3))
    0.999
    """
    return 4.0 * math.sqrt(2.0) / 15.0 * (BELOW - 1.0) * np.asarray(radius) ** 1.5


def wall_run(radius: float) -> Trajectory:
    """Return the motion with a wall where the rounding of this radius begins."""
    wall = impact_oscillator(wall=radius)
    return simulate(wall, cosine(STIFF_OMEGA), X0, STIFF_SPEED, t_end=STIFF_TIME)


@cache
def stiff_errors(stiffness: float, radius: float) -> tuple[float, float]:
    """Return how far the smoothed law is from the bilinear one and from a wall at the radius.

    Parameters
    ----------
    stiffness
        k-.
    radius
        Radius of the rounding.

    Returns
    -------
    tuple of float
        Differences of the displacements after one impact, at t = 4.
    """
    force, later = cosine(STIFF_OMEGA), STIFF_TIME
    start = (X0, STIFF_SPEED)
    osc = bilinear_oscillator(stiffness_below=stiffness)
    smooth, _ = smooth_motion(force, [0.0, later], *start, stiffness_below=stiffness, radius=radius)
    bilinear = simulate(osc, force, *start, t_end=later)(later)[0]
    wall = wall_run(radius)(later)[0]
    return float(smooth[-1] - bilinear), float(smooth[-1] - wall)


def wall_delay(stiffness: float, radius: float) -> float:
    """Return the displacement at t = 4 that the duration of the rounded contact costs.

    To leading order in k-^(-1/3): beyond x = radius the force is k- (radius - x)^2 / (4 radius),
    and a contact lasts 2 (6 radius / (k- V))^(1/3) times the integral of (1 - u^3)^(-1/2) over
    [0, 1].

    Parameters
    ----------
    stiffness, radius
        As in `stiff_errors`.
    """
    run = wall_run(radius)
    hit, speed = float(run.impacts.t[0]), float(run.impacts.v_after[0])
    late = 2.0 * (6.0 * radius / (stiffness * speed)) ** (1.0 / 3.0) * CONTACT_INTEGRAL
    flight = STIFF_TIME - hit
    force = numerics.cos(STIFF_OMEGA * hit) - radius
    return float(-late * (speed * numerics.cos(flight) + force * numerics.sin(flight)))


def chaotic_run(t_end: float = CHAOTIC_END) -> Trajectory:
    """Return the bilinear motion where neighbours part exponentially."""
    return simulate(_CHAOTIC, cosine(CHAOTIC_OMEGA), v0=CHAOTIC_SPEED, t_end=t_end)


@cache
def chaotic_errors(
    radii: tuple[float, ...] = CHAOTIC_RADII, t_end: float = CHAOTIC_END
) -> tuple[Floats, Floats]:
    """Return how the smoothed motion leaves a chaotic bilinear one.

    Parameters
    ----------
    radii
        Radii of the rounding.
    t_end
        How long to follow.

    Returns
    -------
    tuple of array
        Times, and the (radii, times) magnitudes of the difference of the displacements.
    """
    times = np.arange(0.0, t_end, 0.05)
    force = cosine(CHAOTIC_OMEGA)
    exact = chaotic_run(t_end)(times)[0]
    smooth = [
        smooth_motion(force, times, 0.0, CHAOTIC_SPEED, stiffness_below=BELOW, radius=radius)[0]
        for radius in radii
    ]
    return times, np.abs(np.array(smooth) - exact)


@cache
def horizons(n_starts: int = CHAOTIC_STARTS) -> Floats:
    """Return until when smoothed motions stay within 0.1 of chaotic bilinear ones.

    The starts lie on one chaotic motion, `APART` periods apart. A single horizon says little: it
    hangs on the rounding of the last bits.

    Parameters
    ----------
    n_starts
        How many motions.

    Returns
    -------
    array
        (n_starts, radii) times for `CHAOTIC_RADII`; infinite beyond `LONGEST`.
    """
    period = 2.0 * math.pi / float(CHAOTIC_OMEGA)
    instants = APART * period * np.arange(1, n_starts + 1)
    guide = chaotic_run(instants[-1])
    return np.array(
        [
            [_horizon(float(x), float(v), radius) for radius in CHAOTIC_RADII]
            for x, v in zip(*guide(instants), strict=True)
        ]
    )


def _horizon(x0: float, v0: float, radius: float) -> float:
    force, window = cosine(CHAOTIC_OMEGA), np.linspace(0.0, 40.0, 161)
    exact = _chaotic(x0, v0)
    state = x0, v0
    for begin in np.arange(0.0, LONGEST, window[-1]):
        times = begin + window
        x, v = smooth_motion(force, times, *state, stiffness_below=BELOW, radius=radius)
        far = np.abs(x - exact(times)[0]) > FAR
        if far.any():
            return float(times[far.argmax()])
        state = float(x[-1]), float(v[-1])
    return math.inf


@lru_cache(maxsize=1)
def _chaotic(x0: float, v0: float) -> Trajectory:
    return simulate(_CHAOTIC, cosine(CHAOTIC_OMEGA), x0=x0, v0=v0, t_end=LONGEST)


def time_gained() -> tuple[float, float]:
    """Return the mean time that a tenth of the radius gains, with its standard error.

    Each start gives one value, the mean over three tenths, and all values are of one chaotic sea.

    Returns
    -------
    tuple of float
        Mean and standard error [time].
    """
    measured = horizons()
    gained = (measured[:, -1] - measured[:, 0]) / (measured.shape[1] - 1)
    return float(gained.mean()), float(gained.std(ddof=1) / math.sqrt(len(gained)))


@cache
def expected_gain() -> tuple[float, float]:
    """Return 2 ln 10 / lambda, the time in which errors grow a hundredfold, with its standard error.

    lambda is the larger Lyapunov exponent of the bilinear oscillator on the chaotic motion.

    Returns
    -------
    tuple of float
        Time and standard error [time].
    """
    exponents = lyapunov_exponents(
        _CHAOTIC, cosine(CHAOTIC_OMEGA), start=(0.0, CHAOTIC_SPEED), periods=EXPONENT_PERIODS
    )
    rate, error = float(exponents.exponents[0]), float(exponents.errors[0])
    time = 2.0 * numerics.log(10.0) / rate
    return time, time * error / rate
