"""heyoka's Taylor integrator with its event detection, at full tolerance."""

from __future__ import annotations

import math
from typing import Any

import heyoka as hy
import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# Slower than this, with the force pushing in, the body is set to rest until the force turns:
# without such a rule heyoka falls through the wall where impacts accumulate.
SLOWEST = 1e-9


class Bounce:
    """The callback of an impact: takes v to -r v, and keeps the event."""

    def __init__(self) -> None:
        self.begin(1, 1.0)

    def begin(self, limit: int, restitution: float) -> None:
        self.t: list[float] = []
        self.v: list[float] = []
        self.limit, self.restitution = limit, restitution

    def __call__(self, ta: Any, _: int) -> bool:
        t, v = ta.time, ta.state[1]
        self.t.append(t)
        self.v.append(v)
        after = -self.restitution * v
        ta.state[0] = 0.0
        ta.state[1] = after
        if after < SLOWEST and _force(ta, t) <= 0.0:
            return False
        return len(self.t) < self.limit

    def __deepcopy__(self, _: object) -> Bounce:
        # The integrator copies its callbacks; the lists must stay the same.
        return self


def _force(ta: Any, t: float) -> float:
    return float(math.cos(ta.pars[0] * t + ta.pars[1]))


class Impacts:
    """x'' + x = cos(omega t + phase) on x > 0, with impacts at 0."""

    def __init__(self, *, callback: bool = True) -> None:
        x, v = hy.make_vars("x", "v")
        self.bounce = Bounce() if callback else None
        falling = {"direction": hy.event_direction.negative}
        event = (
            hy.t_event(x, callback=self.bounce, **falling) if callback else hy.t_event(x, **falling)
        )
        system = [(x, v), (v, hy.cos(hy.par[0] * hy.time + hy.par[1]) - x)]
        self.ta = hy.taylor_adaptive(system, [0.0, 0.0], t_events=[event], pars=[1.0, 0.0])

    def _begin(self, omega: float, phase: float, x: float, v: float, t: float) -> None:
        self.ta.pars[:] = (omega, phase)
        self.ta.time = t
        self.ta.state[:] = (x, v)
        self.ta.reset_cooldowns()

    def run(
        self,
        n: int,
        omega: float,
        phase: float,
        restitution: float,
        start: tuple[float, float],
        t_end: float = 1e300,
    ) -> tuple[Floats, Floats]:
        """Return times and velocities before the first n impacts, by the callback."""
        bounce, ta = self.bounce, self.ta
        assert bounce is not None
        bounce.begin(n, restitution)
        self._begin(omega, phase, *start, 0.0)
        while len(bounce.t) < n and ta.time < t_end:
            ta.propagate_until(min(t_end, ta.time + 1e9))
            if bounce.t and ta.time == bounce.t[-1] and len(bounce.t) < n:
                ta.time = _next_push(omega, phase, ta.time)
                ta.state[:] = (0.0, 0.0)
                ta.reset_cooldowns()
        return np.array(bounce.t), np.array(bounce.v)

    def run_restarted(
        self, n: int, omega: float, phase: float, start: tuple[float, float]
    ) -> tuple[Floats, Floats]:
        """Return the same for elastic impacts: the integrator stops, a loop turns v and goes on."""
        self._begin(omega, phase, *start, 0.0)
        state, go_on = self.ta.state, self.ta.propagate_until
        times, speeds = [], []
        for _ in range(n):
            go_on(1e300)
            times.append(self.ta.time)
            speeds.append(state[1])
            state[0] = 0.0
            state[1] = -state[1]
        return np.array(times), np.array(speeds)

    def call_back(self, n: int) -> None:
        """Call the callback n times outside of the integration, for what it takes alone."""
        assert self.bounce is not None
        self.bounce.begin(n + 1, 1.0)
        for _ in range(n):
            self.bounce(self.ta, -1)

    def first_event(
        self, omega: float, start: tuple[float, float, float], t_end: float
    ) -> float | None:
        """Return the time of the first fall through 0 of cos(omega t) driven motion."""
        self._begin(omega, 0.0, *start)
        outcome = self.ta.propagate_until(t_end)[0]
        return None if outcome == hy.taylor_outcome.time_limit else float(self.ta.time)


class BatchBounce:
    """The callback of impacts of motions in a batch: takes v to -r v, and keeps the event."""

    def __init__(self, n_motions: int) -> None:
        self.t: list[list[float]] = [[] for _ in range(n_motions)]
        self.v: list[list[float]] = [[] for _ in range(n_motions)]
        self.limit, self.restitution = 1, 1.0

    def watch(self, ta: Any) -> None:
        # Views: to ask the integrator for them anew takes as long as all the rest.
        self.time, self.state, self.pars = ta.time, ta.state, ta.pars

    def __call__(self, _: Any, __: int, i: int) -> bool:
        t, v = self.time[i], self.state[1, i]
        times = self.t[i]
        times.append(t)
        self.v[i].append(v)
        after = -self.restitution * v
        self.state[0, i] = 0.0
        self.state[1, i] = after
        if after < SLOWEST and math.cos(self.pars[0, i] * t + self.pars[1, i]) <= 0.0:
            return False
        return len(times) < self.limit

    def __deepcopy__(self, _: object) -> BatchBounce:
        return self


class BatchImpacts:
    """x'' + x = cos(omega t) on x > 0, with impacts at 0: many motions, a few at a time.

    A motion that has come to its end makes room for the next.
    """

    # The fastest of 1, 4, 8, 16 and 32 on a machine whose vectors hold eight.
    LANES = 16

    def __init__(self) -> None:
        x, v = hy.make_vars("x", "v")
        n = self.LANES
        self.bounce = BatchBounce(n)
        event = hy.t_event_batch(x, callback=self.bounce, direction=hy.event_direction.negative)
        system = [(x, v), (v, hy.cos(hy.par[0] * hy.time + hy.par[1]) - x)]
        self.ta = hy.taylor_adaptive_batch(
            system, np.zeros((2, n)), t_events=[event], pars=np.zeros((2, n))
        )
        self.bounce.watch(self.ta)

    def run(
        self,
        motions: list[tuple[float, float, float]],
        restitution: float,
        limit: int = 10**9,
        t_end: float = 1e9,
    ) -> list[tuple[list[float], list[float]]]:
        """Return times of impacts and velocities before them of each motion (omega, x0, v0)."""
        ta, bounce = self.ta, self.bounce
        bounce.limit, bounce.restitution = limit, restitution
        found: list[tuple[list[float], list[float]]] = [([], [])] * len(motions)
        waiting = iter(range(len(motions)))
        # Who is in each lane; a lane without anyone stays where it is.
        who = [self._load(i, next(waiting, None), motions) for i in range(self.LANES)]
        while any(one is not None for one in who):
            times = [float(t) for t in ta.time]
            ends = [t if one is None else t_end for one, t in zip(who, times, strict=True)]
            ta.propagate_until(ends)
            for i, one in enumerate(who):
                if one is None:
                    continue
                t = float(ta.time[i])
                if len(bounce.t[i]) >= limit or t >= t_end:
                    found[one] = bounce.t[i], bounce.v[i]
                    who[i] = self._load(i, next(waiting, None), motions)
                elif bounce.t[i] and t == bounce.t[i][-1] and ta.state[1, i] < SLOWEST:
                    self._put(i, _next_push(float(ta.pars[0, i]), 0.0, t), (0.0, 0.0))
        return found

    def _load(
        self, i: int, one: int | None, motions: list[tuple[float, float, float]]
    ) -> int | None:
        if one is not None:
            omega, x, v = motions[one]
            self.bounce.t[i], self.bounce.v[i] = [], []
            self.ta.pars[:, i] = omega, 0.0
            self._put(i, 0.0, (x, v))
        return one

    def _put(self, i: int, t: float, state: tuple[float, float]) -> None:
        times = np.array(self.ta.time)
        times[i] = t
        self.ta.set_time(times)
        self.ta.state[:, i] = state
        self.ta.reset_cooldowns(i)


def _next_push(omega: float, phase: float, t: float) -> float:
    """Return when cos(omega t + phase) next turns positive."""
    turns = math.ceil((omega * t + phase) / (2 * math.pi) - 0.75)
    return ((turns + 0.75) * 2 * math.pi - phase) / omega


class Bilinear:
    """x'' + k(x) x = sin t from rest, k = 1 above 0: an event at 0 switches k."""

    # From x = v = x'' = 0 heyoka 7.13 finds the event at the start for ever.
    BEGIN = 0.1

    def __init__(self, stiffness_below: float) -> None:
        x, v = hy.make_vars("x", "v")
        peer = self

        class Switch:
            def __call__(self, ta: Any, direction: int) -> bool:
                ta.pars[0] = 1.0 if direction > 0 else peer.stiffness_below
                ta.state[0] = 0.0
                return True

            def __deepcopy__(self, _: object) -> Switch:
                return self

        self.stiffness_below = stiffness_below
        system = [(x, v), (v, hy.sin(hy.time) - hy.par[0] * x)]
        event = hy.t_event(x, callback=Switch())
        self.ta = hy.taylor_adaptive(system, [0.0, 0.0], t_events=[event], pars=[1.0])

    def positions(self, t: Floats) -> Floats:
        """Return x at the times t."""
        first = int(np.searchsorted(t, self.BEGIN))
        s = float(t[first])
        self.ta.pars[0] = 1.0
        self.ta.time = s
        self.ta.state[:] = (float(_from_rest(s)), s * math.sin(s) / 2)
        self.ta.reset_cooldowns()
        rest = self.ta.propagate_grid(t[first:])[-1][:, 0]
        return np.concatenate([_from_rest(t[:first]), rest])


class ThreeHarmonics:
    """The oscillator of `benchmarks.three_harmonics`: a wall at 0, and a soft stop at 1."""

    TERMS = ((1.0, 0.2, 2.0), (0.3, 0.0, 4.0), (0.1, 0.15, 6.0))

    def __init__(self) -> None:
        x, v = hy.make_vars("x", "v")
        peer = self

        class Impact:
            def __call__(self, ta: Any, _: int) -> bool:
                peer.impacts.append(ta.time)
                ta.state[1] = -0.9 * ta.state[1]
                return True

            def __deepcopy__(self, _: object) -> Impact:
                return self

        class Edge:
            def __call__(self, ta: Any, _: int) -> bool:
                peer.crossings.append(ta.time)
                ta.pars[0] = 1.0 if ta.state[1] > 0.0 else 0.0
                return True

            def __deepcopy__(self, _: object) -> Edge:
                return self

        waves = [a * hy.cos(w * hy.time) + b * hy.sin(w * hy.time) for a, b, w in self.TERMS]
        stop = hy.par[0] * (8.0 * (x - 1.0) + 0.1 * v)
        force = waves[0] + waves[1] + waves[2]
        events = [
            hy.t_event(x, callback=Impact(), direction=hy.event_direction.negative),
            hy.t_event(x - 1.0, callback=Edge()),
        ]
        system = [(x, v), (v, force - 0.04 * v - x - stop)]
        self.ta = hy.taylor_adaptive(system, [0.5, 0.0], t_events=events, pars=[0.0])
        self.impacts: list[float] = []
        self.crossings: list[float] = []

    def run(self, t_end: float) -> tuple[Floats, Floats]:
        """Return the times of the impacts and of the crossings."""
        self.impacts, self.crossings = [], []
        self.ta.time, self.ta.pars[0] = 0.0, 0.0
        self.ta.state[:] = (0.5, 0.0)
        self.ta.reset_cooldowns()
        self.ta.propagate_until(t_end)
        return np.array(self.impacts), np.array(self.crossings)


def _from_rest(t: Floats | float) -> Floats:
    return np.asarray((np.sin(t) - t * np.cos(t)) / 2)
