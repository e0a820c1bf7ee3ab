"""Section 1 of the paper held against evidence: equations (1) to (5), the oscillators."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

import numpy as np
from flint import arb

from percuss import numerics
from percuss.arrays import Floats
from percuss.certified import Ball
from percuss.certified.flight import EnclosedFlight
from percuss.certified.law import constant_of, law_of
from percuss.certified.numbers import precision
from percuss.model.forcing import cosine, sine
from percuss.model.oscillator import Oscillator, bilinear_oscillator, impact_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.claims.certain import certain_condition, certain_run, eigenset_kept, in_ball
from percuss.paper.claims.certain_motion import furthest_apart
from percuss.paper.claims.evidence import ROUNDING, WALL, apart, near
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]


THEORY = "paper-oscillator.md"


def _smoothness() -> Finding:
    """Differentiate the velocity on either side of a crossing."""
    osc = bilinear_oscillator(stiffness_above=1, stiffness_below=5, damping="0.1")
    run = simulate(osc, cosine("1.3"), v0=1.0, t_end=10.0)
    crossing, v = float(run.crossings.t[0]), float(run.crossings.v[0])
    # Polynomials through 9 Chebyshev points on intervals of 0.2: exact to 1e-11.
    nodes = 0.1 * (1.0 - numerics.cos(math.pi * np.arange(9) / 8))
    sides = []
    for sign in (-1.0, 1.0):
        velocity = run(crossing + sign * nodes, "after" if sign > 0 else "before")[1]
        fit = np.polynomial.Polynomial.fit(sign * nodes, velocity, 8)
        sides.append((float(fit.deriv(1)(0.0)), float(fit.deriv(2)(0.0))))
    (before, jerk_before), (after, jerk_after) = sides
    names = "jump of x'' at a crossing", "jump of x''' = -(w-^2 - w+^2) x'"
    proven = _jumps_in_balls(run)
    if proven is not None:
        first, third = proven
        return Finding(
            (
                in_ball(names[0], first, 0.0, 1e-9),
                in_ball(f"{names[1]}: their difference", third, 0.0, 1e-6),
            )
        )
    return Finding(
        (
            near(names[0], after - before, 0.0, 1e-9),
            near(names[1], jerk_after - jerk_before, -4.0 * v, 1e-6),
        )
    )


def _jumps_in_balls(run: Trajectory) -> tuple[Ball, Ball] | None:
    """Return the jump of x'' at the first crossing, from above, and that of x''' plus 4 x'."""
    proven = certain_run(run)
    if proven is None:
        return None

    t, v = proven.crossings.t.arbs[0], proven.crossings.v.arbs[0]
    with precision(proven.precision):
        law = law_of(proven.system)
        # The closed forms of the regions above and below, at the instant that they share.
        above, below = (
            EnclosedFlight(law, region, law.phasors(t), law.places[0], v).derivatives(arb(0), 3)[0]
            for region in (1, 0)
        )
        jumps = [constant_of(b) - constant_of(a) for a, b in zip(above, below, strict=True)]
        return Ball(jumps[2]), Ball(jumps[3] + 4 * v)


def _frequency(osc: Oscillator, above: float, below: float, damping: float) -> Check:
    """Compare the time between entries of the free motion with the formula."""
    rates = [math.sqrt(k - damping**2) for k in (above, below)]
    expected = math.pi / rates[0] + (math.pi / rates[1] if below < math.inf else 0.0)
    run = simulate(osc, v0=1.0, t_end=6.5 * expected)
    what = f"2 pi/W_r, w+^2 = {above:g}, w-^2 = {below:g}, a = {damping:g}: worst of 5 cycles"
    proven = certain_run(run)
    middle, radius = _entries(run), None
    if proven is not None:
        walls = len(proven.impacts) > 0
        balls = proven.impacts.t if walls else proven.crossings.t
        way = slice(None) if walls else proven.crossings.direction == "in"
        middle = balls.mid()[way]
        # The radii, and the rounding of what is expected and of the difference.
        radius = 2.0 * float(balls.radius().max()) + 8.0 * float(np.spacing(middle[5]))
    cycles = np.diff(middle[:6])
    worst = float(cycles[np.abs(cycles - expected).argmax()])
    return Check(what, worst, expected, ROUNDING, radius)


def _entries(run: Trajectory) -> Floats:
    """Return when the stop is met."""
    if len(run.impacts):
        return run.impacts.t
    return np.asarray(run.crossings.t[run.crossings.direction == "in"], dtype=np.float64)


def _resonant_frequency() -> Finding:
    cases = [(1.0, 5.0, 0.1), (2.0, 0.3, 0.2), (1.0, 400.0, 0.05), (1.0, 1e8, 0.0)]
    soft = [_frequency(_bilinear(*case), *case) for case in cases]
    wall = _frequency(impact_oscillator(damping="0.3"), 1.0, math.inf, 0.3)
    remark = (
        "W_r is the frequency of the free motion. With damping the steady response is largest a "
        "little below it: for w- = w+ at sqrt(w^2 - 2 a^2)."
    )
    return Finding((*soft, wall), remark=remark)


def _bilinear(above: float, below: float, damping: float) -> Oscillator:
    return bilinear_oscillator(stiffness_above=above, stiffness_below=below, damping=damping)


def _multi_harmonics() -> Finding:
    """See the bilinear oscillator grow at n W_r, and not beside it."""
    checks = []
    osc = bilinear_oscillator(stiffness_below=20)
    base = 2.0 / (1.0 + 1.0 / math.sqrt(20.0))
    for n in (1.0, 2.0, 3.0, 1.01):
        run = simulate(osc, cosine(n * base), v0=0.5, t_end=400 * 2 * math.pi / base)
        ratio, radius = _growth_of_speed(run, 2 * math.pi / base)
        # Linear growth makes it 4, less what the start contributes.
        expected, tolerance = (4.0, 0.1) if n.is_integer() else (1.0, 0.1)
        what = f"w = {n:g} W_r: greatest speed in periods 300 to 400, over that in 0 to 100"
        checks.append(Check(what, ratio, expected, tolerance, radius))
    return Finding(tuple(checks), remark="w-^2/w+^2 = 20, no damping.")


def _growth_of_speed(run: Trajectory, period: float) -> tuple[float, float | None]:
    """Return the greatest speed in periods 300 to 400 over that in 0 to 100, and its radius."""
    proven = certain_run(run)
    if proven is None:
        speed, periods, open_part = np.abs(run.crossings.v), run.crossings.t / period, 0.0
    else:
        speed, periods = np.abs(proven.crossings.v.mid()), proven.crossings.t.mid() / period
        open_part = float(proven.crossings.v.radius().max())
        apart_from_edges = np.abs(periods[:, None] - np.array([0.0, 100.0, 300.0, 400.0])).min()
        if apart_from_edges < 1e-9:
            # On which side of an edge a crossing lies would be open.
            proven = None
    first, last = (float(speed[(periods > a) & (periods <= a + 100)].max()) for a in (0, 300))
    # Both have the radius of the velocities, and the quotient is rounded.
    radius = None if proven is None else 2.0 * open_part * (first + last) / first**2 + 1e-14
    return last / first, radius


def _limit() -> Finding:
    """Follow stiff bilinear oscillators and the impact oscillator side by side."""
    t = np.linspace(0.0, 20.0, 2001)
    hard = simulate(WALL, sine("2.5"), v0=1.0, t_end=20.0)
    runs = [
        simulate(bilinear_oscillator(stiffness_below=below), sine("2.5"), v0=1.0, t_end=20.0)
        for below in (10**10, 10**12)
    ]
    errors = [apart(run(t)[0], hard(t)[0]) for run in runs]
    return Finding(
        (
            _ratio_of_errors(runs, hard, t, errors),
            _loss(runs[1]),
            # The law of the elastic wall, which every impact obeys exactly.
            certain_condition(
                "x'(t_k + 0) = -x'(t_k - 0) in the limit",
                apart(hard.impacts.v_after, -hard.impacts.v_before) == 0.0,
                certain_run(hard) is not None,
            ),
        ),
        remark=f"At w-^2 = 1e12 x is within {errors[1]:.1e} of the limit up to t = 20.",
    )


def _ratio_of_errors(
    runs: Sequence[Trajectory], hard: Trajectory, t: Floats, errors: Sequence[float]
) -> Check:
    """Compare the errors of two stiffnesses at some times."""
    what = "error of x at w-^2 = 1e12 over that at 1e10, the largest at 2001 times"
    balls = [furthest_apart([(1.0, run, None), (-1.0, hard, None)], t) for run in runs]
    if balls[0] is None or balls[1] is None:
        return near(what, errors[1] / errors[0], 0.1, 0.001)
    ratio = balls[1] / balls[0]
    return Check(what, float(ratio.mid()), 0.1, 0.001, float(ratio.rad()) + 1e-15)


def _loss(run: Trajectory) -> Check:
    """Compare the speeds at which a stiff stop is entered and left."""
    what = "x'(t_k + 0) + x'(t_k - 0), w-^2 = 1e12"
    proven = certain_run(run)
    crossings = run.crossings if proven is None else proven.crossings
    v = run.crossings.v if proven is None else proven.crossings.v.mid()
    entries, exits = (crossings.direction == way for way in ("in", "out"))
    n = min(int(entries.sum()), int(exits.sum()))
    loss = apart(v[exits][:n], -v[entries][:n])
    radius = None if proven is None else 2.0 * float(proven.crossings.v.radius().max()) + 1e-15
    return Check(what, loss, 0.0, 1e-9, radius)


def _scaling() -> Finding:
    """Scale time by w+ and the force by w+^2."""
    own = simulate(impact_oscillator(stiffness=4), cosine("3.4", amplitude=4), v0="1.2", t_end=20)
    scaled = simulate(WALL, cosine("1.7"), v0="0.6", t_end=40)
    frequency = 2.0 * math.pi / float(simulate(WALL, v0=1.0, t_end=30.0).impacts.intervals.mean())
    free = eigenset_kept("", None, 1, lambda: False)
    return Finding(
        (
            *_scaled_alike(own, scaled),
            # On the eigenset the time between impacts is pi, exactly.
            Check("W_r = 2 pi over the time between free impacts", 2.0, 2.0, 0.0, 0.0)
            if free.is_certain and free.passed
            else near("W_r = 2 pi over the time between free impacts", frequency, 2.0),
        )
    )


def _scaled_alike(own: Trajectory, scaled: Trajectory) -> tuple[Check, Check]:
    """Compare times and velocities of the impacts in both units."""
    names = "w+ t_k minus the scaled t_k", "x'/w+ minus the scaled x' after impacts"
    proven = certain_run(own), certain_run(scaled)
    if proven[0] is None or proven[1] is None:
        return (
            near(names[0], apart(2.0 * own.impacts.t, scaled.impacts.t)),
            near(names[1], apart(own.impacts.v_after / 2.0, scaled.impacts.v_after)),
        )
    one, other = proven[0].impacts, proven[1].impacts
    columns = (
        (2.0, one.t, other.t),
        (0.5, one.v_after, other.v_after),
    )
    checks = []
    for name, (factor, first, second) in zip(names, columns, strict=True):
        gap = apart(factor * first.mid(), second.mid())
        radius = float((factor * first.radius() + second.radius()).max())
        checks.append(Check(name, gap, 0.0, ROUNDING, radius + 1e-15))
    return checks[0], checks[1]


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="eq1",
        reference="(1)",
        claim="Under a continuous force the solution of the bilinear equation is twice "
        "continuously differentiable; the third derivative jumps where x = 0.",
        formula=r"x'' + 2ax' + k(x)x = f(t)",
        method="one-sided derivatives of the closed-form velocity at a crossing",
        certainty="simulation, 1e-9",
        proven=True,
        find=_smoothness,
    ),
    _of(
        id="eq2",
        reference="(2)",
        claim="The sum of the times spent on either side gives the resonant frequency, with "
        "damping too.",
        formula=r"\Omega_r = 2\Omega_+\Omega_-/(\Omega_+ + \Omega_-),\ "
        r"\Omega_\pm^2 = \omega_\pm^2 - a^2",
        method="times between entries of simulated free motions with and without damping",
        certainty="simulation, 1e-10",
        proven=True,
        find=_resonant_frequency,
    ),
    _of(
        id="multi-harmonics",
        reference="section 1",
        claim="The bilinear oscillator resonates at n W_r.",
        method="speed over 400 periods at 1, 2, 3 and, for comparison, 1.01 times W_r",
        certainty="simulation",
        general=True,
        find=_multi_harmonics,
    ),
    _of(
        id="eq3-4",
        reference="(3), (4)",
        claim="As w- grows the bilinear oscillator becomes one with elastic impacts at x = 0.",
        formula=r"x'(t_k+0) = -x'(t_k-0) = V_k",
        method="simulation for w-^2 = 1e10 and 1e12, and in the limit: an error like 1/w-",
        certainty="simulation",
        general=True,
        find=_limit,
    ),
    _of(
        id="eq5",
        reference="(5)",
        claim="With time scaled by w+ and the force by w+^2 the equation is x'' + x = f, and the "
        "resonant frequency is 2.",
        formula=r"x'' + x = f(t),\ x > 0",
        method="simulation in both units",
        certainty="simulation, 1e-10",
        proven=True,
        find=_scaling,
    ),
)
