"""The paper's open question, whether a smoothed force law tends to the bilinear one."""

from __future__ import annotations

import math

import numpy as np

from percuss.paper.claims.bilinear_limit import local_orders
from percuss.paper.claims.comparisons import Measured, agreement, extrapolated, last_of
from percuss.paper.evidence import Measurement
from percuss.paper.models.smoothing_errors import (
    LONGEST,
    RADII,
    bound_use,
    crossing_errors,
    expected_gain,
    grazing_errors,
    grazing_jump,
    horizons,
    stiff_errors,
    time_gained,
    wall_delay,
)
from percuss.paper.statement import Finding, Statement

__all__ = ["STATEMENTS", "STIFF_RADII"]

BEYOND = "beyond the paper"
STIFF_RADII = (1e-1, 1e-2, 1e-3, 1e-4)
# Of displacements by Runge and Kutta's method with steps to 1e-14.
ROUNDING = 1e-11


def _smoothed(order: float = 2.0) -> Finding:
    errors = crossing_errors()
    orders = local_orders(RADII, errors)[-4:]
    ratio = float((errors[1:] / errors[:-1]).max())
    mean = Measured(float(orders.mean()), float(np.ptp(orders)))
    # What steps to 1e-14 leave up to t = 20, over the least error that is measured.
    rounding = ROUNDING / float(errors.min())
    used = bound_use(20.0)
    return Finding(
        (
            Measurement(
                "error over the proved bound, up to t = 20", used, 0.0, 1.0, rounding * used
            ),
            Measurement(
                "error over that of the next larger radius: largest", ratio, 0.0, 1.0, rounding
            ),
            agreement("order in rho, all crossings fast", mean, order, 0.02),
        ),
        remark=f"The error is at most {bound_use(20.0):.1e} of the bound rho (e^(lambda t) - 1).",
    )


def _smoothed_at_grazing(power: float = 1.5) -> Finding:
    errors = grazing_errors()
    found = last_of(local_orders(RADII, errors))
    ratio = last_of(errors / grazing_jump(RADII))
    hyperbola = local_orders(RADII, grazing_errors("hyperbola"))[-1]
    return Finding(
        (
            # The next term is smaller by about k- rho, 2e-3 at the smallest radius.
            agreement("order in rho", found, power, 5e-3),
            agreement("jump by (4 sqrt(2)/15) (k- - k+) rho^(3/2)", ratio, 1.0, 5e-3),
        ),
        remark=f"With a hyperbola for the parabola the order is {hyperbola:.2f}, rising to 3/2.",
    )


def _smoothed_in_time(factor: float = 2.0) -> Finding:
    found = horizons()
    longer = np.diff(found, axis=1)
    means = longer.mean(axis=0)
    least = int(means.argmin())
    # Three standard errors of the mean.
    error = 3.0 * float(longer[:, least].std(ddof=1)) / math.sqrt(len(found))
    gained, gained_error = time_gained()
    expected, expected_error = expected_gain()
    # Of ln(10)/lambda, which is half of what is expected; three standard errors of the quotient.
    multiple = Measured(
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
                "time gained by a tenth of rho (mean over the starts) by ln 10 / lambda",
                multiple,
                factor,
                0.5,
            ),
        ),
        remark=f"A tenth of rho gains {gained:.1f} +- {gained_error:.1f} over {len(found)} starts; "
        f"2 ln 10 / lambda is {expected:.1f} +- {expected_error:.1f}. The motions do not converge "
        "uniformly in time, as one might expect from the convergence at each time.",
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
    )


STATEMENTS = (
    Statement(
        id="smoothed-converges",
        reference="introduction",
        claim=(
            "The motion with a smoothed force law tends to that of the bilinear oscillator as the "
            "radius rho of the rounding tends to zero (which the paper calls unclear)."
        ),
        method="Proved at fixed t and k- by Gronwall's inequality; measured for ten radii, k- = 20.",
        find=_smoothed,
        formula=(
            r"|x_\rho - x| \leq \rho\,(e^{\lambda t} - 1),\ "
            r"\lambda = (k_- - k_+)/\sqrt{8\,(k_- + k_+)}"
        ),
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
        "grows as (2/lambda) ln(1/rho), with the growth rate lambda of small differences.",
        method="Chaotic motions, k- = 20, omega = 2.6: until when both are within 0.1, over many starts.",
        find=_smoothed_in_time,
        formula=r"t \sim \frac{2}{\lambda_L}\ln(1/\rho)",
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
