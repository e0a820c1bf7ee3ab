"""diffrax's Runge-Kutta steps with its event location, whose instants have derivatives."""

from __future__ import annotations

from typing import Any

import diffrax
import jax
import jax.numpy as jnp
import numpy as np
import optimistix
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Relative and absolute tolerance of the steps, and of the root of the event.
RTOL, ATOL = 1e-11, 1e-12
ROOT = 1e-13
MOST_STEPS = 100_000
# Longer than any flight of the benchmark.
LONGEST = 50.0

jax.config.update("jax_enable_x64", True)


class MovedImpacts:
    """Instants of n impacts with a wall above, and their derivatives by five parameters.

    The parameters are the damping a, the place of the wall, the restitution, and frequency and
    amplitude of the force of x'' + 2 a x' + x = A cos w t.
    """

    def __init__(self, n: int, v0: float) -> None:
        def force(t: Any, y: Any, p: Any) -> Any:
            return jnp.stack([y[1], p[4] * jnp.cos(p[3] * t) - 2.0 * p[0] * y[1] - y[0]])

        def reached(t: Any, y: Any, args: Any, **_: Any) -> Any:  # noqa: ARG001
            return y[0] - args[1]

        term = diffrax.ODETerm(force)
        event = diffrax.Event(reached, optimistix.Newton(ROOT, ROOT), direction=True)
        steps = diffrax.PIDController(rtol=RTOL, atol=ATOL)

        def hop(state: Any, _: Any, p: Any) -> Any:
            t, y = state
            solution = diffrax.diffeqsolve(
                term, diffrax.Dopri8(), t, t + LONGEST, None, y, p, event=event,
                stepsize_controller=steps, adjoint=diffrax.ForwardMode(), max_steps=MOST_STEPS,
            )  # fmt: skip
            hit, v = solution.ts[0], solution.ys[0, 1]
            return (hit, jnp.stack([p[1], -p[2] * v])), hit

        def instants(p: Any) -> Any:
            begin = jnp.asarray(0.0), jnp.asarray([0.0, v0])
            return jax.lax.scan(lambda state, x: hop(state, x, p), begin, None, length=n)[1]

        self._run = jax.jit(instants)
        self._all = jax.jit(jax.jacfwd(instants))

    def run(self, parameters: tuple[float, ...]) -> Floats:
        """Return the instants, (n,)."""
        return np.asarray(self._run(jnp.asarray(parameters)))

    def derivatives(self, parameters: tuple[float, ...]) -> Floats:
        """Return their derivatives, (n, 5)."""
        return np.asarray(self._all(jnp.asarray(parameters)))
