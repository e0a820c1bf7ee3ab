"""The paper's open question, whether a smoothed force law tends to the bilinear one."""

from __future__ import annotations

import math

import numpy as np

from percuss.paper.claims.bilinear_limit import local_orders
from percuss.paper.claims.evidence import condition, near
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


def _smoothed() -> Finding:
    orders = local_orders(RADII, crossing_errors())[-4:]
    return Finding(
        (
            condition("error within the proved bound up to t = 20", bound_use(20.0) <= 1.0),
            condition(
                "error falls with every radius", bool(np.all(np.diff(crossing_errors()) < 0))
            ),
            near("order in rho, all crossings fast", float(orders.mean()), 2.0, 0.02),
        ),
        remark=f"The error is at most {bound_use(20.0):.1e} of the bound rho (e^(lambda t) - 1).",
    )


def _smoothed_at_grazing() -> Finding:
    errors = grazing_errors()
    order = local_orders(RADII, errors)[-1]
    ratio = (errors / grazing_jump(RADII))[-1]
    hyperbola = local_orders(RADII, grazing_errors("hyperbola"))[-1]
    return Finding(
        (
            # The next term is smaller by about k- rho, 2e-3 at the smallest radius.
            near("order in rho", float(order), 1.5, 5e-3),
            near("jump by (4 sqrt(2)/15) (k- - k+) rho^(3/2)", float(ratio), 1.0, 5e-3),
        ),
        remark=f"With a hyperbola for the parabola the order is {hyperbola:.2f}, rising to 3/2.",
    )


def _smoothed_in_time() -> Finding:
    found = horizons()
    gained, gained_error = time_gained()
    expected, expected_error = expected_gain()
    return Finding(
        (
            condition(
                f"rho = 1e-5: within 0.1 up to t = {LONGEST:g} from every start",
                bool(np.isinf(found[:, -1]).all()),
            ),
        ),
        (
            condition(
                "each tenth of rho: within 0.1 for longer in the mean",
                bool(np.all(np.diff(found.mean(axis=0)) > 0.0)),
            ),
            near(
                "time gained by a tenth of rho (mean over the starts) by 2 ln 10 / lambda",
                gained / expected,
                1.0,
                # Three standard errors of the quotient.
                3.0 * math.hypot(gained_error / expected, gained * expected_error / expected**2),
            ),
        ),
        "only up to a time that grows as ln(1/rho) where motions are chaotic",
        remark=f"A tenth of rho gains {gained:.1f} +- {gained_error:.1f} over {len(found)} starts; "
        f"2 ln 10 / lambda is {expected:.1f} +- {expected_error:.1f}.",
    )


def _smoothed_and_stiff() -> Finding:
    stiff = 1e6
    errors = np.array([stiff_errors(stiff, radius)[0] for radius in STIFF_RADII])
    orders = local_orders(np.array(STIFF_RADII), errors)
    stiffer = np.array([1e6, 1e7])
    at_wall = np.array([stiff_errors(k, 0.01)[1] for k in stiffer])
    ratio = float(at_wall[-1] / wall_delay(stiffer[-1], 0.01))
    return Finding(
        (near("order between rho = 0.1 and 0.01, k- = 1e6", float(orders[0]), 2.0, 0.1),),
        (
            condition(
                "rho = 1e-4, k- = 1e6: error below rho^2", abs(errors[-1]) < STIFF_RADII[-1] ** 2
            ),
            near(
                "rho = 0.01: power of k- in the distance from a wall at rho",
                float(local_orders(stiffer, at_wall)[0]),
                -1.0 / 3.0,
                0.01,
            ),
            near("that distance by the duration of the contact", ratio, 1.0, 0.02),
        ),
        "only for rho << V/sqrt(k-); at fixed rho the limit k- -> infinity is a wall at x = rho, "
        "reached as k-^(-1/3)",
    )


STATEMENTS = (
    Statement(
        "smoothed-converges",
        "introduction",
        "The motion with a smoothed force law tends to that of the bilinear oscillator as the "
        "radius rho of the rounding tends to zero (which the paper calls unclear).",
        "Proved at fixed t and k- by Gronwall's inequality; measured for ten radii, k- = 20.",
        "proved; Runge-Kutta steps at 1e-14 against the closed form",
        _smoothed,
        r"|x_\rho - x| \leq \rho\,(e^{\lambda t} - 1),\ "
        r"\lambda = (k_- - k_+)/\sqrt{8\,(k_- + k_+)}",
        "smoothed-law.md",
        proven=True,
    ),
    Statement(
        "smoothed-grazing",
        BEYOND,
        "Where the bilinear motion touches x = 0, the smoothed one is off by rho^(3/2).",
        "A touch in closed form; ten radii.",
        "derived; Runge-Kutta steps at 1e-14 against the closed form",
        _smoothed_at_grazing,
        r"\delta v = \frac{4\sqrt{2}}{15}(k_- - k_+)\,\rho^{3/2}/\sqrt{f}",
        "smoothed-law.md",
    ),
    Statement(
        "smoothed-in-time",
        BEYOND,
        "The smoothed motion tends to the bilinear one uniformly in time.",
        "Chaotic motions, k- = 20, omega = 2.6: until when both are within 0.1, over many starts.",
        "Runge-Kutta steps at 1e-14 against the closed form",
        _smoothed_in_time,
        r"t \sim \frac{2}{\lambda_L}\ln(1/\rho)",
        "smoothed-law.md",
    ),
    Statement(
        "smoothed-and-stiff",
        BEYOND,
        "The smoothed motion tends to the bilinear one to second order however stiff the spring.",
        "k- = 1e6, four radii; rho = 0.01 against a wall at x = rho.",
        "derived; Runge-Kutta steps at 1e-14 against the closed form",
        _smoothed_and_stiff,
        r"\rho \ll V/\sqrt{k_-}",
        "smoothed-law.md",
    ),
)
