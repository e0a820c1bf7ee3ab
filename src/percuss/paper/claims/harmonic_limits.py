"""Equations (24) to (26) and table 2 held against evidence: where the eigenset is left."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from functools import cache, partial

import numpy as np

from percuss import numerics
from percuss.certified import Ball
from percuss.model.forcing import sine
from percuss.motion.eigenset_forms import harmonic_contact_time, harmonic_critical_velocity
from percuss.motion.simulate import simulate
from percuss.paper.claims.certain import eigenset_kept, in_ball, limit_velocity
from percuss.paper.claims.evidence import (
    WALL,
    apart,
    furthest,
    last_unchanged,
    latest,
    near,
    printed_table,
)
from percuss.paper.statement import Check, Finding, Statement

__all__ = ["STATEMENTS"]

THEORY = "paper-harmonics.md"
TABLE_2 = {
    5: "0.26",
    7: "0.18",
    9: "0.138",
    11: "0.112",
    13: "0.095",
    15: "0.082",
}
ODD = (3, *TABLE_2)
# Parts of V_max at which it is seen whether the eigenset is left.
BELOW = (1e-3, 0.1, 0.3, 0.5, 0.7, 0.9, 1 - 1e-11)
ABOVE = (1 + 1e-11, 1.1, 2.0, 10.0)


def _leaves(n: int, v0: float) -> bool:
    """Return whether the impacts of two turns are not the eigenset."""
    run = simulate(WALL, sine(n), v0=v0, t_end=4.5 * math.pi)
    eigenset = np.asarray(math.pi * np.arange(1, 5), dtype=np.float64)
    return len(run.impacts) != 4 or furthest(run, eigenset) > 1e-8


@cache
def _simulated_limit(n: int) -> float:
    """Return by halving up to which V0 the eigenset is left; V_max is not used."""
    return last_unchanged(partial(_leaves, n), 0.5 / n, 1.0)


def _sign(n: int) -> int:
    """Return (-1)^m, n = 2m + 1."""
    return -1 if (n // 2) % 2 else 1


def _shifted_flight() -> Finding:
    """Compare both lines of (24) with simulated second flights."""
    xi = np.linspace(-0.499, 0.499, 999) * math.pi
    in_x, in_v = [], []
    for n in ODD:
        v0, share = 1.01 * harmonic_critical_velocity(n), n / (n * n - 1)
        x, v = simulate(WALL, sine(n), v0=v0, t_end=7.0)(xi + 1.5 * math.pi)
        wave = _sign(n) / (n * n - 1)
        in_x.append(apart(x, (v0 - share) * numerics.cos(xi) + wave * numerics.cos(n * xi)))
        in_v.append(apart(v, -(v0 - share) * numerics.sin(xi) - n * wave * numerics.sin(n * xi)))
    return Finding(
        (
            near("x of simulated flights minus the first line, n = 3 to 15", max(in_x)),
            near("x' minus the second line, with the sign of its left side", max(in_v)),
        ),
        remark="The second line, set to zero, has the same roots with either sign.",
    )


def _roots(n: int) -> list[float]:
    """Return the roots of tan xi = n tan(n xi) in [0, pi/2), 0 among them.

    Between pi/2 - pi/n and pi/2, where both sides have a pole, there is none.
    """
    xi = np.linspace(1e-9, (0.5 - 0.5 / n) * math.pi, 400 * n)
    values = numerics.sin(xi) * numerics.cos(n * xi) - n * numerics.sin(n * xi) * numerics.cos(xi)
    found = [0.0]
    for i in np.flatnonzero(values[:-1] * values[1:] < 0.0):
        before = partial(_same_sign, n, float(values[i]))
        found.append(last_unchanged(before, float(xi[i]), float(xi[i + 1])))
    return found


def _same_sign(n: int, value: float, xi: float) -> bool:
    tilt = numerics.sin(xi) * numerics.cos(n * xi) - n * numerics.sin(n * xi) * numerics.cos(xi)
    return tilt * value > 0.0


def _velocity(n: int, xi: float) -> float:
    """Return V of (26)."""
    return (n - _sign(n) * numerics.cos(n * xi) / numerics.cos(xi)) / (n * n - 1)


def _third() -> Finding:
    limit = _proven_limit(3)
    what = "V_max(3), starts on either side"
    found = near(what, _simulated_limit(3), 0.5) if limit is None else in_ball(what, limit, 0.5)
    return Finding(
        (
            found,
            near("V_max(3) from the contact", harmonic_critical_velocity(3), 0.5, 1e-15),
            near("contact over 3 pi/2 (xi = 0)", harmonic_contact_time(3) / (1.5 * math.pi), 1.0),
            near("roots of (25) in [0, pi/2) beside 0", len(_roots(3)) - 1),
        )
    )


def _contact() -> Finding:
    """See whether the simulated first extra impact lies at a root of (25)."""
    checks = []
    for n in TABLE_2:
        run = simulate(WALL, sine(n), v0=_simulated_limit(n) * (1 - 1e-10), t_end=1.999 * math.pi)
        # xi < 0 before the middle of the flight; the dip is as wide as the root of its depth.
        xi = 1.5 * math.pi - latest(run, 1, math.inf)
        roots = np.array(_roots(n))
        nearest = float(roots[np.abs(roots - xi).argmin()])
        checks.append(near(f"n = {n}: |xi| of the extra impact, nearest root", xi, nearest, 1e-4))
    return Finding(tuple(checks))


def _which_root() -> Finding:
    """Put every root of (25) into (26)."""
    printed: list[Check] = []
    corrected: list[Check] = []
    for n in TABLE_2:
        roots = _roots(n)
        what = f"n = {n}: V of (26) at xi ="
        printed += [
            near(f"{what} {xi:.6f}, found by simulation", _simulated_limit(n), _velocity(n, xi))
            for xi in roots
        ]
        largest = roots[-1]
        corrected += [
            near(
                f"{what} {largest:.6f}, found by simulation",
                _simulated_limit(n),
                _velocity(n, largest),
            ),
            near(f"n = {n}: xi of `harmonic_contact_time`", _xi(n), largest),
            near(f"n = {n}: number of roots in [0, pi/2)", len(roots), (n - 1) // 2),
        ]
    return Finding(
        tuple(printed),
        tuple(corrected),
        "with the largest of the (n-1)/2 roots of (25) in [0, pi/2), the touch next to the impact",
        remark="The paper does not say which root; its table 2 has the right one.",
    )


def _xi(n: int) -> float:
    return 1.5 * math.pi - harmonic_contact_time(n)


def _table() -> Finding:
    return printed_table("V_max", TABLE_2, harmonic_critical_velocity, proven=_proven_limit)


def _proven_limit(n: int) -> Ball | None:
    """Return V_max as a ball, from what is proven about starts on either side of it."""
    return limit_velocity(sine(n), Fraction(1, 100 * n), 1)


def _both_sides() -> Finding:
    """Simulate below and above each critical velocity."""
    checks = []
    for n in ODD:
        v = harmonic_critical_velocity(n)
        for words, parts, kept in (("not on", BELOW, False), ("on", ABOVE, True)):
            each = [_side(n, part * v, kept=kept) for part in parts]
            # The weakest of them speaks for all.
            each.sort(key=lambda check: (check.passed, check.is_certain))
            ends = f"{parts[0]:g} to {parts[-1]:g}"
            checks.append(replace(each[0], what=f"n = {n}: {words} the eigenset, V/V_max = {ends}"))
        limit = _proven_limit(n)
        what = f"n = {n}: limit minus the root of the contact condition"
        if limit is None:
            checks.append(near(what, _simulated_limit(n) - v))
        else:
            checks.append(in_ball(what, limit, v))
    return Finding(
        tuple(checks),
        remark="Seven V0 in (0, V_max), four above. At V_max itself the extra root is a touch "
        "that changes nothing.",
    )


def _side(n: int, v0: float, *, kept: bool) -> Check:
    return eigenset_kept("", sine(n), v0, lambda: _leaves(n, v0) is not kept, kept=kept)


_of = partial(Statement, theory=THEORY)

STATEMENTS: tuple[Statement, ...] = (
    _of(
        id="eq24",
        reference="(24)",
        claim="With t = xi + 2 pi p + 3 pi/2 the second flight is the first line of (24), and "
        "its velocity vanishes with the second.",
        formula=r"x(\xi) = [V - \frac{n}{n^2-1}]\cos\xi + \frac{(-1)^m}{n^2-1}\cos n\xi",
        method="simulated flights; symbolic in the tests",
        certainty="symbolic",
        proven=True,
        find=_shifted_flight,
    ),
    _of(
        id="eq24-third",
        reference="(24)",
        claim="For n = 3 the contact is at xi = 0 and V_max = 1/2.",
        formula=r"V_{max}(3) = 1/2",
        method="contact condition, and the limit found by simulation",
        certainty="closed form, 12 digits",
        proven=True,
        find=_third,
    ),
    _of(
        id="eq25",
        reference="(25)",
        claim="For n = 5, 7, ... the contact is at a root of tan xi = n tan(n xi).",
        formula=r"\tan\xi = n\tan n\xi",
        method="instant of the extra impact of simulated motions just below the limit",
        certainty="simulation, 1e-4",
        proven=True,
        find=_contact,
    ),
    _of(
        id="eq26",
        reference="(25), (26)",
        claim="(26) with a root of (25) gives V_max.",
        formula=r"V_{max} = \frac{1}{n^2-1}[n - (-1)^m\frac{\cos n\xi}{\cos\xi}]",
        method="all roots of (25), and the limit found by simulation alone",
        certainty="closed form, 12 digits",
        proven=True,
        find=_which_root,
    ),
    _of(
        id="table2",
        reference="table 2",
        claim="V_max = 0.26, 0.18, 0.138, 0.112, 0.095, 0.082 for n = 5, 7, 9, 11, 13, 15.",
        method="starts on either side, proven to keep to the eigenset or to leave it; without "
        "ball arithmetic, the root of the contact condition",
        certainty="closed form, 12 digits",
        find=_table,
    ),
    _of(
        id="table2-simulated",
        reference="table 2",
        claim="Velocities below V_max give other impact times than the eigenset, those above it "
        "the eigenset.",
        method="all impacts of starts on both sides, proven or simulated, and the limit by halving",
        certainty="simulation, 1e-10",
        find=_both_sides,
    ),
)
