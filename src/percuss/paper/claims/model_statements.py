"""Sections 1 and 2 of the paper held against evidence: equations (1) to (9), Property 1."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from percuss.model.forcing import Forcing, cosine, fourier, sine
from percuss.model.harmonics import Harmonic
from percuss.model.oscillator import Oscillator, bilinear_oscillator, impact_oscillator
from percuss.motion.eigenset import eigenset
from percuss.motion.eigenset_forms import SubsetMotion, eigenset_motion
from percuss.motion.simulate import simulate
from percuss.paper.claims.certain import eigenset_kept
from percuss.paper.claims.evidence import WALL, apart, condition, furthest, near
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]

THEORY = "paper-family.md"


def _smoothness() -> Finding:
    """Differentiate the velocity on either side of a crossing."""
    osc = bilinear_oscillator(stiffness_above=1, stiffness_below=5, damping="0.1")
    run = simulate(osc, cosine("1.3"), v0=1.0, t_end=10.0)
    crossing, v = float(run.crossings.t[0]), float(run.crossings.v[0])
    # Polynomials through 9 Chebyshev points on intervals of 0.2: exact to 1e-11.
    nodes = 0.1 * (1.0 - np.cos(math.pi * np.arange(9) / 8))
    sides = []
    for sign in (-1.0, 1.0):
        velocity = run(crossing + sign * nodes, "after" if sign > 0 else "before")[1]
        fit = np.polynomial.Polynomial.fit(sign * nodes, velocity, 8)
        sides.append((float(fit.deriv(1)(0.0)), float(fit.deriv(2)(0.0))))
    (before, jerk_before), (after, jerk_after) = sides
    return Finding(
        (
            near("jump of x'' at a crossing", after - before, 0.0, 1e-9),
            near("jump of x''' = -(w-^2 - w+^2) x'", jerk_after - jerk_before, -4.0 * v, 1e-6),
        )
    )


def _frequency(osc: Oscillator, above: float, below: float, damping: float) -> Check:
    """Compare the time between entries of the free motion with the formula."""
    rates = [math.sqrt(k - damping**2) for k in (above, below)]
    expected = math.pi / rates[0] + (math.pi / rates[1] if below < math.inf else 0.0)
    run = simulate(osc, v0=1.0, t_end=6.5 * expected)
    times = run.impacts.t
    if not len(times):
        times = run.crossings.t[run.crossings.direction == "in"]
    cycles = np.diff(times[:6])
    worst = float(cycles[np.abs(cycles - expected).argmax()])
    what = f"2 pi/W_r, w+^2 = {above:g}, w-^2 = {below:g}, a = {damping:g}: worst of 5 cycles"
    return near(what, worst, expected)


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
        speed, periods = np.abs(run.crossings.v), run.crossings.t * base / (2 * math.pi)
        first, last = (float(speed[(periods > a) & (periods <= a + 100)].max()) for a in (0, 300))
        # Linear growth makes it 4, less what the start contributes.
        expected, tolerance = (4.0, 0.1) if n.is_integer() else (1.0, 0.1)
        what = f"w = {n:g} W_r: greatest speed in periods 300 to 400, over that in 0 to 100"
        checks.append(near(what, last / first, expected, tolerance))
    return Finding(tuple(checks), remark="w-^2/w+^2 = 20, no damping.")


def _limit() -> Finding:
    """Follow stiff bilinear oscillators and the impact oscillator side by side."""
    t = np.linspace(0.0, 20.0, 2001)
    hard = simulate(WALL, sine("2.5"), v0=1.0, t_end=20.0)
    errors, losses = [], []
    for below in (10**10, 10**12):
        run = simulate(bilinear_oscillator(stiffness_below=below), sine("2.5"), v0=1.0, t_end=20.0)
        entries, exits = (run.crossings.direction == way for way in ("in", "out"))
        errors.append(apart(run(t)[0], hard(t)[0]))
        losses.append(apart(run.crossings.v[exits], -run.crossings.v[entries]))
    return Finding(
        (
            near("error of x at w-^2 = 1e12 over that at 1e10", errors[1] / errors[0], 0.1, 0.001),
            near("x'(t_k + 0) + x'(t_k - 0), w-^2 = 1e12", losses[1], tolerance=1e-9),
            near(
                "x'(t_k + 0) + x'(t_k - 0) in the limit",
                apart(hard.impacts.v_after, -hard.impacts.v_before),
            ),
        ),
        remark=f"At w-^2 = 1e12 x is within {errors[1]:.1e} of the limit up to t = 20.",
    )


def _scaling() -> Finding:
    """Scale time by w+ and the force by w+^2."""
    own = simulate(impact_oscillator(stiffness=4), cosine("3.4", amplitude=4), v0=1.2, t_end=20)
    scaled = simulate(WALL, cosine("1.7"), v0=0.6, t_end=40)
    frequency = 2.0 * math.pi / float(simulate(WALL, v0=1.0, t_end=30.0).impacts.intervals.mean())
    return Finding(
        (
            near("w+ t_k minus the scaled t_k", apart(2.0 * own.impacts.t, scaled.impacts.t)),
            near(
                "x'/w+ minus the scaled x' after impacts",
                apart(own.impacts.v_after / 2.0, scaled.impacts.v_after),
            ),
            near("W_r = 2 pi over the time between free impacts", frequency, 2.0),
        )
    )


def _combination() -> Finding:
    """Combine motions with the same impact times, on Y_2 and on the eigenset."""
    t = np.linspace(0.0, 60.0, 3001)
    slow, fast = SubsetMotion(2, "0.3"), SubsetMotion(2, "0.9")
    doubled = _times(slow.forcing, 2.5)
    subset = simulate(WALL, doubled, v0=2.0 * 0.3 + 0.5 * 0.9, t_end=60.0)
    first, second = (simulate(WALL, sine(n), v0=0.4, t_end=60.0) for n in (2, 4))
    both = simulate(WALL, fourier(2, sin=(2.0, 0.5)), v0=2.5 * 0.4, t_end=60.0)
    return Finding(
        (
            near(
                "2x + y/2 minus the motion under the combined force, on Y_2",
                apart(subset(t)[0], 2.0 * slow(t)[0] + 0.5 * fast(t)[0]),
            ),
            near(
                "2x + y/2 minus the motion under the combined force, on the eigenset",
                apart(both(t)[0], 2.0 * first(t)[0] + 0.5 * second(t)[0]),
                tolerance=1e-9,
            ),
        )
    )


def _times(force: Forcing, factor: float) -> Forcing:
    """Return a force of one harmonic times a factor."""
    (part,) = force.harmonics
    assert isinstance(part, Harmonic)
    amplitude = float(part.amplitude) * factor
    return cosine(part.omega, amplitude, part.phase, float(force.constant) * factor)


def _free_motion() -> Finding:
    run = simulate(WALL, v0="1.5", t_end=100.0)
    t = np.linspace(0.0, 100.0, 2001)
    off = apart(run(t)[0], eigenset_motion("1.5", t)[0])
    return Finding(
        tuple(
            eigenset_kept(f"V0 = {v0}: t_k = pi k, all k", None, v0, partial(_is_free, v0))
            for v0 in ("1e-6", "0.1", "1.5", "1000")
        ),
        remark=f"Simulated, x differs from V0 sin(t - pi k) by {off:.0e} at most.",
    )


def _is_free(v0: str) -> bool:
    return furthest(simulate(WALL, v0=v0, t_end=100.0), eigenset(WALL, 40)) <= 1e-10


def _shifted() -> Finding:
    """Add the free motion to forced ones whose impact times are the eigenset."""
    t = np.linspace(0.0, 60.0, 3001)
    checks = []
    for n, v0 in ((2, 0.0), (3, 0.6), (4, 0.1)):
        slow, fast = (simulate(WALL, sine(n), v0=v0 + dv, t_end=60.0) for dv in (0.0, 0.7))
        what = f"sin {n}t: motion from V0 = {v0:g} plus x0 minus motion from {v0 + 0.7:g}"
        gap = apart(slow(t)[0] + eigenset_motion(0.7, t)[0], fast(t)[0])
        checks.append(near(what, gap, tolerance=1e-9))
    return Finding(tuple(checks))


def _property_1() -> Finding:
    """Change the initial velocity, off the eigenset and on it."""
    rng = np.random.default_rng(1)
    least, worst = math.inf, 0.0
    for _ in range(60):
        omegas, amplitudes = rng.uniform(0.4, 5.0, 2), rng.uniform(0.3, 1.0, 2)
        phases, v0 = rng.uniform(-3.0, 3.0, 2), float(rng.uniform(0.3, 2.0))
        force = Forcing(map(Harmonic, amplitudes, omegas, phases), constant=0.5)
        least = min(least, _change(force, v0))
    for m in (2, 3, 4, 5):
        worst = max(worst, _change(SubsetMotion(m, "0.1").forcing, 0.1))
    for n in (2, 3, 4, 5):
        worst = max(worst, _change(sine(n), 0.6))
    remark = (
        "Proof: between two common impact times the difference of the motions is "
        "(W_k - V_k) sin(t - t_k), so t_(k+1) - t_k is a multiple of pi (the paper writes sin t). "
        "That W_k differs from V_k for all k needs uniqueness, which holds for analytic forces "
        "such as sums of harmonics (Schatzman 1998, Math. Comput. Modelling 28)."
    )
    return Finding(
        (
            condition(
                "60 random forces: V0 changed by 1e-3 moves one of 4 impacts by over 1e-6",
                least > 1e-6,
            ),
            near("on the eigenset and its subsets, moves of the impact times", worst),
        ),
        remark=remark,
    )


def _change(force: Forcing, v0: float) -> float:
    """Return by how much the first impacts move with the initial velocity."""
    one, other = (simulate(WALL, force, v0=v, max_impacts=4, t_end=200) for v in (v0, v0 + 1e-3))
    count = min(len(one.impacts), len(other.impacts))
    return apart(one.impacts.t[:count], other.impacts.t[:count])


def _split() -> Finding:
    """Hold (15) against the first flight under cos 2t and sin 2t."""
    t = np.linspace(0.0, 1.5, 301)
    printed, corrected = [], []
    for name, force, part, slope in (
        ("cos 2t", cosine(2), -np.cos(2 * t) / 3, 0.0),
        ("sin 2t", sine(2), -np.sin(2 * t) / 3, -2.0 / 3.0),
    ):
        x = simulate(WALL, force, v0=1.0, t_end=1.5)(t)[0]
        as_printed = 1.0 * np.sin(t) - part[0] + part
        right = (1.0 - slope) * np.sin(t) - part[0] * np.cos(t) + part
        printed.append(near(f"{name}: x minus (15)", apart(x, as_printed)))
        corrected.append(near(f"{name}: x minus the corrected form", apart(x, right)))
    return Finding(
        tuple(printed),
        tuple(corrected),
        "(V - x_part'(0)) sin t - x_part(0) cos t + x_part(t), t from t_k; "
        "(15) itself for the x_part that starts from rest",
        remark="What the proof needs, that two flights differ by (A_y - A_z) sin t, is right.",
    )


def _closeness() -> Finding:
    """Follow two motions whose velocities differ by 1e-3."""
    t = np.linspace(0.0, 20 * math.pi, 4001)
    one, other = (simulate(WALL, sine(2), v0=v, t_end=20 * math.pi) for v in (1.0, 1.001))
    (x, v), (y, w) = one(t), other(t)
    # Next to an impact, rounding may put the two velocities on different sides.
    inner = np.abs(t / math.pi - np.round(t / math.pi)) > 1e-6
    return Finding(
        (
            near("largest |y - z| over 20 flights, eps = 1e-3", apart(x, y), 1e-3, 1e-8),
            condition("|y' - z'| <= eps", apart(v[inner], w[inner]) <= 1e-3 + 1e-10),
        )
    )


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
        find=_resonant_frequency,
    ),
    _of(
        id="multi-harmonics",
        reference="section 1",
        claim="The bilinear oscillator resonates at n W_r.",
        method="speed over 400 periods at 1, 2, 3 and, for comparison, 1.01 times W_r",
        certainty="simulation",
        find=_multi_harmonics,
    ),
    _of(
        id="eq3-4",
        reference="(3), (4)",
        claim="As w- grows the bilinear oscillator becomes one with elastic impacts at x = 0.",
        formula=r"x'(t_k+0) = -x'(t_k-0) = V_k",
        method="simulation for w-^2 = 1e10 and 1e12, and in the limit: an error like 1/w-",
        certainty="simulation",
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
        find=_scaling,
    ),
    _of(
        id="eq6",
        reference="(6)",
        claim="Motions with the same impact times may be added with positive factors, and their "
        "forces with them.",
        formula=r"z = \alpha x + \beta y,\ z'' + z = \alpha f + \beta g",
        method="simulation under the combined force",
        certainty="simulation, 1e-9",
        find=_combination,
    ),
    _of(
        id="eq9",
        reference="(7) to (9)",
        claim="Without forcing the impact times are the eigenset pi k, whatever V0.",
        formula=r"x_0 = V_0\,\sin(t - \pi k),\ \pi k \leq t \leq \pi(k+1)",
        method="simulation of the free oscillator",
        certainty="simulation, 1e-10",
        find=_free_motion,
    ),
    _of(
        id="eigenset-sum",
        reference="section 3",
        claim="Adding the free motion to one whose impact times are the eigenset gives another "
        "motion under the same force.",
        method="simulation from both velocities",
        certainty="simulation, 1e-9",
        find=_shifted,
    ),
    _of(
        id="property1",
        reference="Property 1",
        claim="Different motions with the same impact times, not within the eigenset, have "
        "different forces: changing V0 alone changes the impact times.",
        method="proof; simulation under 60 random forces, and on the eigenset",
        certainty="proof",
        proven=True,
        find=_property_1,
    ),
    _of(
        id="eq15",
        reference="(15)",
        claim="A flight is V sin t - x_part(0) + x_part(t), for a particular solution x_part.",
        formula=r"y = A_y\sin t - x_{part}(0) + x_{part}(t),\ A_y = V",
        method="comparison with simulated flights",
        certainty="closed form, 12 digits",
        proven=True,
        find=_split,
    ),
    _of(
        id="eq16",
        reference="(16)",
        claim="Motions on the same impact times whose velocities differ by eps stay within eps "
        "of each other, from flight to flight.",
        formula=r"|y - z| \leq \epsilon,\ |y' - z'| \leq \epsilon",
        method="simulation of 20 flights",
        certainty="simulation, 1e-8",
        find=_closeness,
    ),
)
