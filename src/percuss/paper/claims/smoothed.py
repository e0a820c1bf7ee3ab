"""The paper's open question, whether a smoothed force law tends to the bilinear one."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import sympy

from percuss.io.study_text import motion_text
from percuss.paper.claims.bilinear_limit import local_orders
from percuss.paper.claims.comparisons import WithError, agreement, extrapolated, last_of
from percuss.paper.evidence import Deduction, Measurement
from percuss.paper.formula import mathtext
from percuss.paper.models.smoothing_errors import (
    LONGEST,
    RADII,
    bound_use,
    chaotic_run,
    crossing_errors,
    crossing_run,
    expected_gain,
    grazing_errors,
    grazing_jump,
    horizons,
    stiff_errors,
    time_gained,
    touching_run,
    wall_delay,
    wall_run,
)
from percuss.paper.proof import identity, theorem
from percuss.paper.statement import Finding, Statement

BEYOND = "beyond the article"
STIFF_RADII = (1e-1, 1e-2, 1e-3, 1e-4)
# Of displacements by Runge and Kutta's method with steps to 1e-14.
ROUNDING = 1e-11


ABOVE, UNDER, RADIUS, TIME = sympy.symbols("k_+ k_- rho t", positive=True)
# lambda of the bound rho (e^(lambda t) - 1).
RATE = (UNDER - ABOVE) / sympy.sqrt(8 * (UNDER + ABOVE))


def _bound(rate: sympy.Expr) -> Deduction:
    """Deduce the bound with the rounding by a parabola, which has a rate."""
    x, u, w, d = sympy.symbols("x u w d", real=True)
    a, m, size = sympy.symbols("a m N", positive=True)
    gap = sympy.Symbol("Delta", positive=True)
    excess = (RADIUS - x) ** 2 / (2 * RADIUS)
    by_hand = gap / (4 * sympy.sqrt(m))
    drive = gap * RADIUS / 4
    bound = drive / by_hand * (sympy.exp(by_hand * TIME) - 1)
    steps = (
        identity(
            "Between 0 and rho the rounded magnitude exceeds |x| by this; beyond by nothing.",
            (x**2 + RADIUS**2) / (2 * RADIUS) - x,
            excess,
        ),
        identity(
            "So it is between 0 and rho/2 there.",
            RADIUS / 2 - excess,
            x * (2 * RADIUS - x) / (2 * RADIUS),
        ),
        theorem(
            "Both laws are Lipschitz: both motions are unique (Picard and Lindelöf). u is their "
            "difference, w = u', d that of the magnitudes: by the triangle inequality it is at "
            "most |u| + rho/2.",
            r"w' = -2 a w - m u + \frac{\Delta}{2} d",
        ),
        identity(
            "With N^2 = m u^2 + w^2, m = (k+ + k-)/2 and Delta = k- - k+, N N' is",
            m * u * w + w * (-2 * a * w - m * u + gap / 2 * d),
            gap / 2 * w * d - 2 * a * w**2,
        ),
        identity(
            "where damping helps, |w| is at most N, and |u w| at most N^2/(2 sqrt m), since",
            m * u**2 + w**2 - 2 * sympy.sqrt(m) * u * w,
            (sympy.sqrt(m) * u - w) ** 2,
        ),
        identity(
            "so N N' is at most this:",
            gap / 2 * (size**2 / (2 * sympy.sqrt(m)) + size * RADIUS / 2),
            size * (by_hand * size + drive),
        ),
        theorem(
            "N is then at most the solution of the equation with the same start, 0 (Gronwall's "
            "inequality: Hartman 1964, theorem III.1.1).",
        ),
        identity(
            "That solution is the right one:",
            sympy.diff(bound, TIME),
            by_hand * bound + drive,
        ),
        identity(
            "It bounds |u| = N/sqrt m by this,",
            bound / sympy.sqrt(m),
            RADIUS * (sympy.exp(by_hand * TIME) - 1),
        ),
        identity(
            "with the stated rate,",
            by_hand.subs({gap: UNDER - ABOVE, m: (UNDER + ABOVE) / 2}),
            rate,
        ),
        replace(
            identity(
                "and tends to 0 with rho, at every t.",
                sympy.limit(RADIUS * (sympy.exp(rate * TIME) - 1), RADIUS, 0),
                sympy.Integer(0),
            ),
            formula=r"\rho \, (e^{\lambda t} - 1) \to 0",
        ),
    )
    return Deduction("the bound, and that the motions tend to one another", steps)


def _smoothed(order: float = 2.0, rate: sympy.Expr = RATE) -> Finding:
    errors = crossing_errors()
    orders = local_orders(RADII, errors)[-4:]
    ratio = float((errors[1:] / errors[:-1]).max())
    mean = WithError(float(orders.mean()), float(np.ptp(orders)))
    # What steps to 1e-14 leave up to t = 20, over the least error that is measured.
    rounding = ROUNDING / float(errors.min())
    used = bound_use(20.0)
    return Finding(
        (
            _bound(rate),
            Measurement(
                "error over the proved bound, up to t = 20", used, 0.0, 1.0, rounding * used
            ),
            Measurement(
                "error over that of the next larger radius: largest", ratio, 0.0, 1.0, rounding
            ),
            agreement("order in rho, all crossings fast", mean, order, 0.02),
        ),
        remark=f"The error is at most {bound_use(20.0):.1e} of the bound rho (e^(lambda t) - 1).",
        study=motion_text(crossing_run()),
    )


def _smoothed_at_grazing(power: float = 1.5) -> Finding:
    errors = grazing_errors()
    order = last_of(local_orders(RADII, errors))
    ratio = last_of(errors / grazing_jump(RADII))
    hyperbola = local_orders(RADII, grazing_errors("hyperbola"))[-1]
    return Finding(
        (
            # The next term is smaller by about k- rho, 2e-3 at the smallest radius.
            agreement("order in rho", order, power, 5e-3),
            agreement("jump by (4 sqrt(2)/15) (k- - k+) rho^(3/2)", ratio, 1.0, 5e-3),
        ),
        remark=f"With a hyperbola for the parabola the order is {hyperbola:.2f}, rising to 3/2.",
        study=motion_text(touching_run()),
    )


def _smoothed_in_time(factor: float = 2.0) -> Finding:
    measured = horizons()
    longer = np.diff(measured, axis=1)
    means = longer.mean(axis=0)
    least = int(means.argmin())
    # Three standard errors of the mean.
    error = 3.0 * float(longer[:, least].std(ddof=1)) / math.sqrt(len(measured))
    gained, gained_error = time_gained()
    expected, expected_error = expected_gain()
    # Of ln(10)/sigma, which is half of what is expected; three standard errors of the quotient.
    multiple = WithError(
        2.0 * gained / expected,
        6.0 * math.hypot(gained_error / expected, gained * expected_error / expected**2),
    )
    return Finding(
        (
            Measurement(
                "each tenth of rho: how much longer within 0.1, in the mean; the least",
                float(means[least]),
                low=0.0,
                high=LONGEST,
                error=error,
            ),
            # The order of the error in rho: a whole number.
            agreement(
                "time gained by a tenth of rho (mean over the starts) by ln 10 / sigma",
                multiple,
                factor,
                0.5,
            ),
        ),
        remark=f"A tenth of rho gains {gained:.1f} +- {gained_error:.1f} over {len(measured)} starts; "
        f"2 ln 10 / sigma is {expected:.1f} +- {expected_error:.1f}. The motions do not converge "
        "uniformly in time, as one might expect from the convergence at each time.",
        study=motion_text(chaotic_run()),
    )


def _smoothed_and_stiff(power: float = -1.0 / 3.0) -> Finding:
    stiff = 1e6
    errors = np.array([stiff_errors(stiff, radius)[0] for radius in STIFF_RADII])
    orders = local_orders(np.array(STIFF_RADII), errors)
    # The next term is smaller by k-^(-1/3).
    stiffer, falls = np.array([1e5, 1e6, 1e7]), 10.0 ** (1.0 / 3.0)
    at_wall = np.array([stiff_errors(k, 0.01)[1] for k in stiffer])
    powers = local_orders(stiffer, at_wall).tolist()
    delays = [gap / wall_delay(k, 0.01) for gap, k in zip(at_wall, stiffer, strict=True)]
    # What steps to 1e-14 leave, over the least error that is measured.
    rounding = ROUNDING / float(np.abs(errors).min())
    return Finding(
        (
            Measurement(
                "order between rho = 0.1 and 0.01, k- = 1e6",
                float(orders[0]),
                -math.inf,
                1.9,
                rounding,
            ),
            Measurement(
                "rho = 1e-4, k- = 1e6: error over rho^2",
                float(abs(errors[-1])) / STIFF_RADII[-1] ** 2,
                0.0,
                1.0,
                rounding,
            ),
            agreement(
                "rho = 0.01: power of k- in the distance from a wall at rho",
                extrapolated(powers, falls),
                power,
                0.01,
            ),
            agreement(
                "that distance by the duration of the contact",
                extrapolated(delays, falls),
                1.0,
                0.02,
            ),
        ),
        remark=f"Between rho = 0.1 and 0.01 the order is {orders[0]:.2f}: there rho is larger than "
        "V/sqrt(k-).",
        study=motion_text(wall_run(STIFF_RADII[1])),
    )


STATEMENTS = (
    Statement(
        id="smoothed-converges",
        reference=BEYOND,
        scope="beyond",
        claim=(
            "The motion with a smoothed force law tends to that of the bilinear oscillator as the "
            "radius rho of the rounding tends to zero, which the article calls unclear."
        ),
        method="Deduced at fixed t and k- with Gronwall's inequality; measured for ten radii, k- = 20.",
        find=_smoothed,
        formula=(rf"|x_\rho - x| \leq \rho\,(e^{{\lambda t}} - 1),\ \lambda = {mathtext(RATE)}"),
        theory="smoothed-law.md",
    ),
    Statement(
        id="smoothed-grazing",
        reference=BEYOND,
        scope="beyond",
        claim="Where the bilinear motion touches x = 0, the smoothed one is off by rho^(3/2).",
        method="A touch in closed form; ten radii.",
        find=_smoothed_at_grazing,
        formula=r"\delta v = \frac{4\sqrt{2}}{15}(k_- - k_+)\,\rho^{3/2}/\sqrt{f}",
        theory="smoothed-law.md",
    ),
    Statement(
        id="smoothed-in-time",
        reference=BEYOND,
        scope="beyond",
        claim="Where motions are chaotic the smoothed one stays near the bilinear one up to a time that "
        "grows as (2/sigma) ln(1/rho), with the growth rate sigma of small differences, the Lyapunov "
        "exponent.",
        method="Chaotic motions, k- = 20, omega = 2.6: until when both are within 0.1, over many starts.",
        find=_smoothed_in_time,
        formula=r"t \sim \frac{2}{\sigma}\ln(1/\rho)",
        theory="smoothed-law.md",
    ),
    Statement(
        id="smoothed-and-stiff",
        reference=BEYOND,
        scope="beyond",
        claim="The second order in rho holds for rho << V/sqrt(k-) alone; at fixed rho a stiffer spring "
        "tends to a wall at x = rho, as k-^(-1/3).",
        method="k- = 1e6, four radii; rho = 0.01 against a wall at x = rho.",
        find=_smoothed_and_stiff,
        formula=r"\rho \ll V/\sqrt{k_-}",
        theory="smoothed-law.md",
    ),
)
