"""Section 2 of the paper held against evidence: equations (6) to (9), Property 1."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import partial

import numpy as np

from percuss import numerics
from percuss.model.exact import Exact
from percuss.model.forcing import Forcing, cosine, fourier, sine
from percuss.model.harmonics import Harmonic
from percuss.motion.eigenset import eigenset
from percuss.motion.eigenset_forms import SubsetMotion, eigenset_motion
from percuss.motion.simulate import simulate
from percuss.paper.claims import oscillator_statements
from percuss.paper.claims.certain import eigenset_kept
from percuss.paper.claims.certain_motion import sum_is_zero
from percuss.paper.claims.evidence import ROUNDING, WALL, apart, condition, furthest, near
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]


THEORY = "paper-family.md"


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
            sum_is_zero(
                "2x + y/2 minus the motion under the combined force, on Y_2",
                [
                    (2.0, simulate(WALL, slow.forcing, v0="0.3", t_end=60), None),
                    (0.5, simulate(WALL, fast.forcing, v0="0.9", t_end=60), None),
                    (-1.0, subset, None),
                ],
                t,
                lambda: apart(subset(t)[0], 2.0 * slow(t)[0] + 0.5 * fast(t)[0]),
                ROUNDING,
            ),
            sum_is_zero(
                "2x + y/2 minus the motion under the combined force, on the eigenset",
                [(2.0, first, None), (0.5, second, None), (-1.0, both, None)],
                t,
                lambda: apart(both(t)[0], 2.0 * first(t)[0] + 0.5 * second(t)[0]),
                1e-9,
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
    for n, v0 in ((2, Fraction(0)), (3, Fraction(3, 5)), (4, Fraction(1, 10))):
        more = v0 + Fraction(7, 10)
        slow, fast = (simulate(WALL, sine(n), v0=v, t_end=60.0) for v in (v0, more))
        what = f"sin {n}t: motion from V0 = {float(v0):g} plus x0 minus motion from {float(more):g}"
        if _both_keep(sine(n), v0, more):
            # On each flight both are solutions of one equation from one start: the same motion.
            checks.append(Check(what, 0.0, 0.0, 1e-9, 0.0))
            continue
        gap = apart(slow(t)[0] + eigenset_motion(0.7, t)[0], fast(t)[0])
        checks.append(near(what, gap, tolerance=1e-9))
    remark = "With proof: all their impacts are on the eigenset, so that the sum obeys both laws."
    return Finding(tuple(checks), remark=remark)


def _both_keep(force: Forcing, one: Exact, other: Exact) -> bool:
    """Return whether the motions from two velocities provably keep to the eigenset for ever."""
    kept = [eigenset_kept("", force, v, lambda: False) for v in (one, other)]
    return all(check.is_certain and check.passed for check in kept)


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
        ("cos 2t", cosine(2), -numerics.cos(2 * t) / 3, 0.0),
        ("sin 2t", sine(2), -numerics.sin(2 * t) / 3, -2.0 / 3.0),
    ):
        x = simulate(WALL, force, v0=1.0, t_end=1.5)(t)[0]
        as_printed = 1.0 * numerics.sin(t) - part[0] + part
        right = (1.0 - slope) * numerics.sin(t) - part[0] * numerics.cos(t) + part
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
    if _both_keep(sine(2), 1, "1.001"):
        # On the eigenset the difference is 0.001 sin(t - pi k) on every flight, exactly.
        return Finding(
            (
                Check("largest |y - z|, eps = 1e-3", 1e-3, 1e-3, 1e-8, 1e-18),
                Check("|y' - z'| <= eps", 1.0, 1.0, 0.0, 0.0),
            )
        )
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
    *oscillator_statements.STATEMENTS,
    _of(
        id="eq6",
        reference="(6)",
        claim="Motions with the same impact times may be added with positive factors, and their "
        "forces with them.",
        formula=r"z = \alpha x + \beta y,\ z'' + z = \alpha f + \beta g",
        method="simulation under the combined force",
        certainty="simulation, 1e-9",
        theory="paper-oscillator.md",
        proven=True,
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
        theory="paper-oscillator.md",
        proven=True,
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
        theory="paper-oscillator.md",
        proven=True,
        find=_closeness,
    ),
)
