"""Soft stops with dashpots far above critical: derivatives from the slow parts alone."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from mpmath import mp, mpf

import percuss as pc
from percuss.arrays import Floats
from percuss.kernels import law_columns as at
from percuss.kernels.flight import Flight, set_phases
from percuss.kernels.flight_columns import (
    LONGEST_PHASE,
    MOST_TERMS,
    response_to_late_phase,
    response_to_motion,
    series_phase,
)
from percuss.kernels.overdamped import time_to_fade
from percuss.model.system import law

DASHPOTS = [1e5, 1e7, 1e9]
# The parameters of the closed forms, and what they are called here.
PATHS = {
    "stiffness": "oscillator.stiffness",
    "damping": "oscillator.damping",
    "at": "oscillator.stops.0.at",
    "stop": "oscillator.stops.0.stiffness",
    "omega": "forcing.omega",
    "amplitude": "forcing.amplitude",
    "v0": "start.v0",
}
H = mpf(10) ** -20


def stopped(dashpot: float) -> tuple[pc.Oscillator, pc.Forcing]:
    stop = pc.SoftStop(at="0.5", side="above", stiffness=1000, damping=dashpot)
    return pc.Oscillator(stiffness=1, damping="0.05", stops=(stop,)), pc.cosine("0.8")


def flight_of(
    k: mpf, a: mpf, force: tuple[mpf, mpf, mpf], start: tuple[mpf, mpf, mpf]
) -> Callable[[mpf], tuple[mpf, mpf]]:
    """Return x and v over the time since a start, for x'' + 2 a x' + k x = g + A cos w t."""
    (g, amplitude, w), (t, x, v) = force, start
    rate = mp.sqrt(mp.mpc(a * a - k))
    one, other = -a + rate, -a - rate
    gain = amplitude / (k - w * w + 2j * a * w) * mp.expj(w * t)
    z, u = x - g / k - mp.re(gain), v - mp.re(1j * w * gain)
    first = (u - other * z) / (one - other)

    def state(s: mpf) -> tuple[mpf, mpf]:
        parts = (first, one), (z - first, other), (gain, 1j * w)
        terms = [(size * mp.exp(root * s), root) for size, root in parts]
        return g / k + mp.re(sum(q for q, _ in terms)), mp.re(sum(r * q for q, r in terms))

    return state


def motion(values: dict[str, mpf], crossings: list[float], t_end: float) -> list[mpf]:
    """Return instants and velocities of the crossings next to given ones, and the state at the end.

    The first one goes into the stop.
    """
    p = values
    start, inside = (mpf(0), mpf(0), p["v0"]), False
    found: list[mpf] = []
    for guess in [*crossings, None]:
        k = p["stiffness"] + (p["stop"] if inside else 0)
        a = p["damping"] + (p["dashpot"] if inside else 0)
        force = p["stop"] * p["at"] if inside else mpf(0), p["amplitude"], p["omega"]
        state = flight_of(k, a, force, start)
        if guess is None:
            return [*found, *state(mpf(t_end) - start[0])]
        s = mpf(guess) - start[0]
        for _ in range(8):
            x, v = state(s)
            s -= (x - p["at"]) / v
        assert abs(x - p["at"]) < mpf(10) ** -45
        start, inside = (start[0] + s, p["at"], state(s)[1]), not inside
        found += [start[0], start[2]]
    raise AssertionError


@pytest.mark.parametrize("dashpot", DASHPOTS)
def test_derivatives_are_those_of_closed_forms(dashpot: float) -> None:
    """At 1e5 they had lost five digits, and at 1e9 they did not come back."""
    run = pc.simulate(*stopped(dashpot), v0="0.5", periods=2)
    crossings = run.crossings.t.tolist()
    assert len(crossings) == 4
    found = run.sensitivity(list(PATHS.values()))
    dx, dv = found(run.t_end)
    with mp.workdps(60):
        given = dict(
            zip(PATHS, map(mpf, ("1", "0.05", "0.5", "1000", "0.8", "1", "0.5")), strict=True)
        )
        given["dashpot"] = mpf(dashpot)
        for p, name in enumerate(PATHS):
            ahead, behind = (
                motion({**given, name: given[name] + step}, crossings, run.t_end)
                for step in (H, -H)
            )
            wanted = [float((a - b) / (2 * H)) for a, b in zip(ahead, behind, strict=True)]
            events = np.stack([found.crossings.t[:, p], found.crossings.v[:, p]], axis=1)
            np.testing.assert_allclose([*events.ravel(), dx[p], dv[p]], wanted, rtol=1e-12)


@pytest.mark.parametrize("dashpot", DASHPOTS)
def test_an_orbit_moves_like_the_motion_that_comes_to_it(dashpot: float) -> None:
    """Solved from the state at a fixed instant, the answer was wrong in all digits at 1e9."""
    osc, force = stopped(dashpot)
    paths = [path for name, path in PATHS.items() if name not in {"omega", "v0"}]
    orbit = pc.find_orbit(osc, force)
    run = pc.simulate(osc, force, v0="0.5", periods=80)

    moved, settled = orbit.sensitivity(paths), run.sensitivity(paths)

    last = np.flatnonzero(run.crossings.direction == "in")[-1]
    np.testing.assert_allclose(moved.t0, settled.crossings.t[last], rtol=1e-12)
    np.testing.assert_allclose(moved.v0, settled.crossings.v[last], rtol=1e-12)


FORCES = {
    "two waves": pc.cosine("0.8") + pc.sine("7.3", amplitude="0.4"),
    "a record": pc.cosine(2) + pc.record([0, 1, 2, 300], [0, 1, "0.5", 2]),
}


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize(("stiffness", "damping"), [(1, 50), (-1, 20), (0, 30), (350, 20)], ids=str)
def test_both_forms_agree_where_the_fast_decay_is_over(
    stiffness: float, damping: float, force: str
) -> None:
    table = law(pc.Oscillator(stiffness, damping), FORCES[force])
    region = at.FIRST_HARMONIC + 2
    phases = np.empty((2, 2))
    set_phases(table, 2.5, 0.0, phases)
    flight = Flight(table, region, (2.5, 0.0, 0.7, 0.4), phases, phases)
    fades = time_to_fade(table, region)

    def of_motion(s: float) -> Floats:
        return np.array(response_to_motion(flight, s, np.zeros(MOST_TERMS)))

    def of_phase(s: float) -> Floats:
        return np.array(response_to_late_phase(table, region, 0, s)).reshape(2, 2)

    before = math.nextafter(fades, 0.0)
    found, size = of_motion(fades), abs(of_motion(fades))
    # The series have the last one as what is left of the terms of its equation.
    size[2] += abs(stiffness) * size[0] + 2.0 * damping * size[1]
    assert (abs(found - of_motion(before)) < 1e-12 * size).all()
    sizes = np.hypot(*of_phase(fades).T)[:, np.newaxis]
    assert (abs(of_phase(fades) - of_phase(before)) < 1e-13 * sizes).all()


@pytest.mark.parametrize("dashpot", DASHPOTS)
def test_a_flight_takes_few_steps(dashpot: float) -> None:
    table = law(*stopped(dashpot))
    region = int(table[:, at.NUMBER].argmax())
    fades = time_to_fade(table, region)

    assert series_phase(table, region, 0.8, 0.99 * fades) < 60.0 * LONGEST_PHASE
    assert series_phase(table, region, 0.8, 3.0) < LONGEST_PHASE
