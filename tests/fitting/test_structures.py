"""Fits of structures to records that another program has made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import percuss as pc
from percuss.arrays import Floats

GAP, RESTITUTION = "structure.stops.0.at", "structure.stops.0.restitution"
TRUTH = {"m2": 1.5, "k2": 8.0, "c": 0.2, "k3": 5.0, GAP: 0.3, RESTITUTION: 0.7}
LOADS = pc.Loads({0: pc.cosine("1.9", amplitude=2)})
TIMES = np.linspace(0, 40, 801)[:-1]


def rig(values: Sequence[float] = tuple(TRUTH.values())) -> pc.Structure:
    """Return three masses in a row; the last one meets a wall."""
    m2, k2, c, k3 = (
        pc.parameter(name, value)
        for name, value in zip(("m2", "k2", "c", "k3"), values, strict=False)
    )
    wall = pc.Wall(at=values[4], side="above", restitution=values[5], on=2)
    return pc.chain(
        masses=[1, m2, "0.8"],
        springs=[4, k2, k3, 2],
        dashpots=[c, "0.1", "0.1", "0.1"],
        stops=[wall],
    )


@pytest.fixture(scope="module")
def motion() -> tuple[Floats, Floats]:
    """Return displacements and accelerations of SciPy's motion, (3, n_times) each."""
    m2, k2, c, k3, gap, restitution = TRUTH.values()
    masses = np.array([1.0, m2, 0.8])
    stiffness = np.array([[4 + k2, -k2, 0], [-k2, k2 + k3, -k3], [0, -k3, k3 + 2]])
    damping = np.array([[c + 0.1, -0.1, 0], [-0.1, 0.2, -0.1], [0, -0.1, 0.2]])

    def pushes(t: Any, x: Floats, v: Floats) -> Floats:
        force = -stiffness @ x - damping @ v
        force[0] += 2 * np.cos(1.9 * t)
        return np.asarray((force.T / masses).T)

    def rate(t: float, y: Floats) -> Floats:
        return np.concatenate([y[3:], pushes(t, y[:3], y[3:])])

    def beyond(_: float, y: Floats) -> float:
        return float(y[2]) - gap

    event: Any = beyond
    event.terminal, event.direction = True, 1
    found, begin, state = np.zeros((6, len(TIMES))), 0.0, np.zeros(6)
    while begin < TIMES[-1]:
        flight = solve_ivp(
            rate, (begin, 40.0), state, events=event, dense_output=True, method="DOP853",
            rtol=1e-10, atol=1e-11,
        )  # fmt: skip
        end = float(flight.t[-1])
        inside = (begin <= TIMES) & (end >= TIMES)
        found[:, inside] = flight.sol(TIMES[inside])
        begin, state = end, flight.y[:, -1].copy()
        state[2], state[5] = gap, -restitution * state[5]
    return found[:3], pushes(TIMES, found[:3], found[3:])


def noisy(values: Floats, seed: int = 0) -> tuple[Floats, float]:
    noise = 0.02 * float(np.std(values))
    return values + noise * np.random.default_rng(seed).standard_normal(len(values)), noise


def is_near(fit: pc.Fit) -> bool:
    return all(abs(fit.values[name] - TRUTH[name]) < 4 * fit.errors[name] for name in fit.values)


@pytest.mark.parametrize("start", ["free", (0, 0)])
def test_six_parameters_of_three_masses_from_one_accelerometer(
    motion: tuple[Floats, Floats], start: Any
) -> None:
    a, noise = noisy(motion[1][2])
    off = (1.1, 0.9, 1.1, 0.9, 1.1, 0.9)
    guess = [true * part for true, part in zip(TRUTH.values(), off, strict=True)]
    fit = pc.fit(
        {"t": TIMES, "acceleration_2": a}, rig(guess), LOADS, noise=noise, start=start,
        free=dict(zip(TRUTH, guess, strict=True)),
    )  # fmt: skip
    assert fit.converged
    assert fit.chi2 == pytest.approx(1, abs=4 * math.sqrt(2 / len(TIMES)))
    assert is_near(fit)
    assert fit.nodes.shape[1] == 7
    assert (fit.errors["k2"] / 8) < 1e-3
    x, _ = fit(TIMES)
    # The coordinates that no sensor saw.
    assert np.abs(x - motion[0].T).max() < 0.01 * np.abs(motion[0]).max()
    # Beside an impact a sample is taken on the side of it that suits it.
    beside = np.abs(fit.of("acceleration_2", TIMES) - fit.residuals.fitted.values) > 1e-10
    assert beside.sum() < 12


def test_a_point_of_modes_and_the_stiffness_of_a_soft_stop() -> None:
    def beam(stiffness: float) -> pc.Structure:
        stop = pc.SoftStop(at="0.05", side="above", stiffness=stiffness, on="tip")
        return pc.Structure.from_modes(
            frequencies=[1, 6], damping_ratios="0.02", shapes={"tip": [2, -2], "middle": [1, 1]},
            stops=[stop],
        )  # fmt: skip

    loads = pc.Loads({"middle": pc.cosine("0.9", amplitude="0.1")})
    t = np.linspace(0, 60, 900)
    run = pc.simulate(beam(40), loads, t_end=60)
    assert len(run.crossings.t) > 10
    x, noise = noisy(run.displacement("middle", t)[0])
    force, of_force = noisy(run.forces(t).stops.values[0], 1)
    path = "structure.stops.0.stiffness"
    data = {"t": t, "displacement_middle": x, "stop_force": force}
    fit = pc.fit(
        data, beam(25), loads, free={path: 25}, start=(0, 0),
        noise={"displacement_middle": noise, "stop_force": of_force},
    )  # fmt: skip
    assert fit.converged
    assert fit.values[path] == pytest.approx(40, abs=4 * fit.errors[path])
    assert set(fit.residuals.quantity.values.tolist()) == {"displacement_middle", "stop_force"}


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (
            {"t": TIMES, "acceleration": TIMES},
            "of which place? name it acceleration_0, acceleration_1",
        ),
        ({"t": TIMES, "acceleration_tip": TIMES}, "of no place; there are"),
        ({"t": TIMES, "stop_force_1": TIMES}, "of stop 1, where the structure has 1"),
        (
            {"t": TIMES[:3], "acceleration_0": TIMES[:3]},
            "3 values for 7 unknowns; a free start has 6",
        ),
        ({"impact_times": TIMES[1:20]}, "alone say too little of a structure"),
    ],
)
def test_faults_are_sentences(data: Any, words: str) -> None:
    with pytest.raises(pc.ParameterError) as told:
        pc.fit(data, rig(), LOADS, free={"k2": 8.0})
    assert words in str(told.value)
