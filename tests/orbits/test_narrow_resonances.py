"""Branches of orbits without impacts at resonances narrower than a step: no graze is passed over."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.orbits.orbit.resonance import passes_resonance

STIFFNESS = {"oscillator": "oscillator.stiffness", "structure": "structure.stiffness.0.0"}
OMEGA = 0.45
LOW, HIGH = 0.05, 4.0


def force_of(amplitudes: list[float]) -> pc.Forcing:
    """Return harmonics of one period."""
    harmonics = tuple(
        pc.Harmonic(amplitude=amplitude, omega=(n + 1) * Fraction(9, 20))
        for n, amplitude in enumerate(amplitudes)
    )
    return pc.Forcing(harmonics=harmonics, period="40*pi/9")


def resonances(
    kind: str, damping: float, at: float, amplitudes: list[float], ends: tuple[float, float]
) -> Any:
    """Return the branch over the stiffness of the motion that meets no wall, from its end on."""
    wall = pc.Wall(at=-at, side="below", restitution=0.7, on=0 if kind == "structure" else None)
    force, (low, high) = force_of(amplitudes), ends
    if kind == "oscillator":
        osc = pc.Oscillator(stiffness=low, damping=damping, stops=(wall,))
        orbit: Any = pc.find_orbit(osc, force, n_impacts=0, formal=True)
    else:
        one = pc.Structure(mass=[1], stiffness=[high], damping=[2 * damping], stops=[wall])
        orbit = pc.find_orbit(one, {0: force}, guess=state_of(high, damping, amplitudes))
    return pc.continue_orbit(orbit, over={STIFFNESS[kind]: ends})


def displacements(stiffness: np.ndarray, damping: float, amplitudes: list[float]) -> np.ndarray:
    """Return the linear responses at 1024 instants of a period, (m, 1024)."""
    phases = np.linspace(0.0, 2.0 * math.pi, 1024, endpoint=False)
    x = np.zeros((len(stiffness), len(phases)))
    for n, amplitude in enumerate(amplitudes, start=1):
        omega = n * OMEGA
        gain = amplitude / (stiffness - omega**2 + 2j * damping * omega)
        x += (gain[:, None] * np.exp(1j * n * phases)).real
    return x


def state_of(stiffness: float, damping: float, amplitudes: list[float]) -> tuple[Any, Any]:
    x = displacements(np.array([stiffness]), damping, amplitudes)[0]
    speed = (x[1] - x[-1]) * OMEGA * len(x) / (4.0 * math.pi)
    return [float(x[0])], [float(speed)]


def grazes_of(damping: float, at: float, amplitudes: list[float]) -> int:
    """Return how often the linear response begins or ceases to reach the wall."""
    centres = [(n * OMEGA) ** 2 for n in (1, 2, 3)]
    sides = [centre + sign * np.geomspace(1e-9, 0.3, 400) for centre in centres for sign in (-1, 1)]
    values = np.unique(np.concatenate([np.linspace(LOW, HIGH, 3000), *sides, centres]))
    values = values[(values >= LOW) & (values <= HIGH)]
    is_free = displacements(values, damping, amplitudes).min(axis=1) > -at
    return int((is_free[1:] != is_free[:-1]).sum())


CASES = [
    # Of damping, wall and amplitudes: the second and third resonances are narrower than a step.
    (4.7e-6, 41.0, [1.0, 6.5e-4, 1.1e-3]),
    (3.4e-6, 341.0, [1.0, 3.3e-3, 8e-2]),
    (5.6e-4, 1.29, [1.0, 0.103, 0.0142]),
    (2e-3, 9.6, [1.0, 0.119, 7e-4]),
    (2.3e-5, 1.07, [1.0, 0.038, 0.076]),
]


@pytest.mark.parametrize(
    ("kind", "damping", "at", "amplitudes"),
    [("oscillator", *case) for case in CASES]
    + [("structure", *case) for case in CASES[2:]]
    + [pytest.param("structure", *case, marks=pytest.mark.nightly) for case in CASES[:2]],
)
def test_grazes_in_narrow_resonances_are_found(
    damping: float, at: float, amplitudes: list[float], kind: str
) -> None:
    branch = resonances(kind, damping, at, amplitudes, (LOW, HIGH))
    found = [point for point in branch.special_points if point.kind == "grazing"]
    assert len(found) == grazes_of(damping, at, amplitudes)
    values = np.array([point.value for point in found])
    least = displacements(values, damping, amplitudes).min(axis=1)
    np.testing.assert_allclose(least, -at, rtol=1e-4)
    # Those of the formal orbits between, up to amplitudes of thousands, do not count by their size.
    assert len(branch) < 500


def test_a_graze_at_the_start_of_the_period_is_found() -> None:
    # Hardly damped, the motion turns at whole periods of the cosine: at the seam of the orbit.
    damping, at = 1e-5, 10.0
    wall = pc.Wall(at=-at, side="below", restitution=0.7, on=0)
    one = pc.Structure(mass=[1], stiffness=[1], damping=[2 * damping], stops=[wall])
    orbit = pc.find_orbit(one, {0: pc.cosine(1.5)})
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (1.5, 1.02)})
    (graze,) = (point for point in branch.special_points if point.kind == "grazing")
    # (1 - w^2)^2 + 4 a^2 w^2 = 1 / at^2
    w2 = 1 - 2 * damping**2 + math.sqrt(1 / at**2 - 4 * damping**2 * (1 - damping**2))
    assert graze.value == pytest.approx(math.sqrt(w2), rel=1e-11)


@pytest.mark.parametrize("kind", ["oscillator", "structure"])
def test_without_damping_a_branch_ends_at_the_resonance(kind: str) -> None:
    if kind == "oscillator":
        orbit: Any = pc.find_orbit(pc.Oscillator(stiffness=1), pc.cosine("0.45"), n_impacts=0)
    else:
        orbit = pc.find_orbit(pc.chain([1], [1, 0]), pc.cosine("0.45"))
    path = "forcing.omega" if kind == "oscillator" else "loads.0.omega"
    branch = pc.continue_orbit(orbit, over={path: (0.4, 1.5)})
    assert "the velocities grow without bound" in branch.end_reason
    assert branch.values.max() == pytest.approx(1.0, abs=1e-6)
    assert branch.values.max() < 1.0
    assert branch.special_points == ()


@pytest.mark.parametrize("number", [1, 3, 5])
@pytest.mark.parametrize("kind", ["oscillator", "structure"])
def test_under_a_record_the_steps_follow_the_resonances_of_its_harmonics(
    kind: str, number: int
) -> None:
    # Next to its resonance a harmonic of the square wave is all but alone.
    amplitude, damping = 4 / math.pi / number, 1e-4
    at, start = 50.0, Fraction(11, 8) / number
    wall = pc.Wall(-at, "below", 0.7, on=0 if kind == "structure" else None)
    force = pc.square_wave(start)
    if kind == "oscillator":
        osc = pc.Oscillator(stiffness=1, damping=damping, stops=(wall,))
        orbit: Any = pc.find_orbit(osc, force, n_impacts=0)
    else:
        one = pc.Structure(mass=[1], stiffness=[1], damping=[2 * damping], stops=[wall])
        orbit = pc.find_orbit(one, {0: force})
    path = "forcing.omega" if kind == "oscillator" else "loads.0.omega"
    branch = pc.continue_orbit(orbit, over={path: (0.8 / number, float(start))})
    grazes = [point.value for point in branch.special_points if point.kind == "grazing"]
    expected = [math.sqrt(1 + sign * amplitude / at) / number for sign in (-1, 1)]
    np.testing.assert_allclose(sorted(grazes), expected, rtol=2e-3)


def test_neighbours_on_one_side_of_a_resonance_have_none_between() -> None:
    def at(omega: float, damping: float = 0.0, wall: float = -49) -> pc.PeriodicOrbit:
        osc = pc.Oscillator(1, damping, (pc.Wall(wall, "below", 0.7),))
        return pc.find_orbit(osc, pc.cosine(omega), n_impacts=0, formal=True)

    assert passes_resonance(at(0.9), at(1.1))
    assert passes_resonance(at(0.98, 0.01), at(1.02, 0.01))
    assert not passes_resonance(at(0.8), at(0.99))
    assert not passes_resonance(at(1.01, 0.01), at(1.2, 0.01))
    # Damped so much it has no resonance.
    assert not passes_resonance(at(0.9, 2.0), at(1.1, 2.0))
    # No motion reaches the wall; or all orbits are formal. Without damping there is no bound.
    assert not passes_resonance(at(0.98, 0.01, -60), at(1.02, 0.01, -60))
    assert not passes_resonance(at(0.98, 0.01, -2), at(1.02, 0.01, -2))
    assert passes_resonance(at(0.9, 0, -2), at(1.1, 0, -2))


def test_harmonics_that_reach_no_wall_and_change_little_make_no_steps_shorter() -> None:
    harmonics = tuple(
        pc.Harmonic(amplitude=1, omega=Fraction(1, 2) + Fraction(n, 50)) for n in range(20)
    )
    osc = pc.Oscillator(3, "0.05", (pc.Wall(1000, "above", 0.8),))
    orbit = pc.find_orbit(osc, pc.Forcing(harmonics=harmonics, period="100*pi"), 0)
    branch = pc.continue_orbit(orbit, over={"oscillator.stiffness": (0.2, 8)})
    assert len(branch) < 150


def test_a_branch_shows_its_resonance_though_it_reaches_no_wall() -> None:
    damping = 0.01
    osc = pc.Oscillator(1, damping, (pc.Wall(60, "above", 0.7),))
    orbit = pc.find_orbit(osc, pc.cosine(0.3), n_impacts=0)
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (0.3, 2.2)})
    # 1 / (2 a sqrt(1 - a^2)) is the largest amplitude.
    least = 60 - 0.5 / damping / math.sqrt(1 - damping**2)
    assert branch.grazing_margin.min() == pytest.approx(least, rel=0.02)
    assert len(branch) < 150


def test_a_response_without_damping_has_a_branch_on_each_side_of_its_resonance() -> None:
    osc = pc.Oscillator(stiffness=1, stops=(pc.Wall(2, "above", 0.8),))
    force = pc.cosine(1, amplitude=0.5)
    chart = pc.response_curve(
        osc, force, over={"forcing.omega": (0.8, 1.3)}, max_impacts=1, max_periods=1, n_seeds=4
    )
    ends = [(b.values.min(), b.values.max()) for b in chart.branches if b[0].n_impacts == 0]
    assert len(ends) == 2
    (low, first), (second, high) = sorted(ends)
    assert (low, high) == (0.8, 1.3)
    assert (first, second) == pytest.approx((1.0, 1.0), abs=1e-6)
    # What is formal next to the resonance does not hide the motions.
    assert chart.plot().get_ylim()[1] < 10.0
    without = next(b for b in chart.branches if b[0].n_impacts == 0)
    assert np.abs(without.plot().get_ylim()).max() < 50.0


@pytest.mark.parametrize(
    ("amplitude", "path", "ends"),
    [
        (0, "forcing.record.amplitude", (0.0, 0.5)),
        (0.2, "forcing.record.amplitude", (-0.3, 0.5)),
        (1e-9, "forcing.constant", (-0.5, 0.5)),
        (1e-9, "oscillator.stiffness", (0.5, 5.0)),
    ],
)
def test_under_a_record_a_motion_may_grow_from_nothing_or_move(
    amplitude: float, path: str, ends: tuple[float, float]
) -> None:
    osc = pc.Oscillator(stiffness=2, damping=0.05, stops=(pc.Wall(5, "above", 0.8),))
    force = pc.square_wave("2.5", amplitude) + pc.Forcing(constant=0.1)
    orbit = pc.find_orbit(osc, force, n_impacts=0)
    branch = pc.continue_orbit(orbit, over={path: ends})
    assert (branch.values.min(), branch.values.max()) == ends
    assert len(branch) < 200


def pressed(amplitude: float, omega: float | str, constant: float) -> pc.StructureOrbit:
    """Return the response of a mass that the load presses towards a soft stop with a dashpot."""
    stop = pc.SoftStop(1, "above", stiffness=10, damping="0.3", on=0)
    one = pc.Structure(mass=[1], stiffness=[1], damping=["0.2"], stops=[stop])
    orbit = pc.find_orbit(one, {0: pc.cosine(omega, amplitude) + pc.Forcing(constant=constant)})
    assert isinstance(orbit, pc.StructureOrbit)
    return orbit


def test_the_graze_of_a_small_response_and_what_follows_are_found() -> None:
    branch = pc.continue_orbit(pressed(0.01, "1.7", 0), over={"loads.0.constant": (-3, 7)})
    found = [(point.kind, point.value) for point in branch.special_points]
    # Those after the first are the oscillator's.
    expected = [
        ("grazing", 1 - 0.01 / math.hypot(1 - 1.7**2, 0.2 * 1.7)),
        ("fold", 1.00985046019),
        ("fold", 1.00827239718),
        ("period_doubling", 1.0088062944),
        ("period_doubling", 1.00984794487),
        ("grazing", 1.01348961318),
    ]
    assert [kind for kind, _ in found] == [kind for kind, _ in expected]
    np.testing.assert_allclose(
        [value for _, value in found], [value for _, value in expected], rtol=1e-10
    )


def test_no_step_passes_over_a_contact_from_a_free_response_to_a_held_one() -> None:
    # From the first contact to the last the load changes by less than a step.
    branch = pc.continue_orbit(pressed(1e-3, "0.5", -3), over={"loads.0.constant": (-3, 5.3)})
    graze = 1 - 1e-3 / math.hypot(1 - 0.5**2, 0.2 * 0.5)
    is_free = branch.n_impacts == 0
    assert branch.values[is_free].max() == pytest.approx(graze, abs=1e-7)


def test_resonances_that_reach_no_stop_and_are_no_peaks_make_no_steps_shorter() -> None:
    stop = pc.SoftStop(20, "above", stiffness=10, on=0)
    four = pc.chain([1, 1, 1, 1], [2, 1, 3, 2, 1], ["0.2", "0.1", "0.3", "0.2", "0.1"], [stop])
    orbit = pc.find_orbit(four, {3: pc.triangle_wave("0.35")})
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": ("0.05", "1.4")})
    assert (branch.values.min(), branch.values.max()) == (0.05, 1.4)
    assert len(branch) < 150


def test_a_branch_reaches_the_graze_of_a_stiff_stop_in_a_resonance() -> None:
    # Its steps along the branch, in which the parameter all but stood, did not come near it.
    stop = pc.SoftStop(30, "above", stiffness=300, on=0)
    one = pc.Structure(mass=[1], stiffness=[1], damping=["2e-5"], stops=[stop])
    orbit = pc.find_orbit(one, {0: pc.cosine("0.6")})
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": ("0.5", "1.2")}, max_points=60)
    (graze,) = (point.value for point in branch.special_points if point.kind == "grazing")
    assert graze == pytest.approx(math.sqrt(1 - 1 / 30), rel=1e-6)


def test_a_branch_does_not_turn_back_where_it_does_not_fold() -> None:
    # Next to grazes a step came to the same orbits on their other side, and went on backwards.
    branch = pc.continue_orbit(pressed(0.1, "0.5", -2.5), over={"loads.0.constant": (-2.5, 4.1)})
    assert branch.values[-1] == 4.1
    assert (branch.n_impacts[-1], branch.is_stable[-1]) == (0, True)
    turns = np.flatnonzero(np.diff(np.sign(np.diff(branch.values))))
    assert len(turns) == sum(point.kind == "fold" for point in branch.special_points) == 4


@pytest.mark.parametrize("kind", ["oscillator", "structure"])
def test_motions_between_two_formal_neighbours_are_not_stepped_over(kind: str) -> None:
    """Within one step, the five harmonics keep the response off the wall between two grazes."""
    parts = [
        (1.778, 0.5, -1.696), (0.222, 1.0, -0.2506), (0.5557, 1.5, -1.9463), (0.215, 2.0, -0.5011),
        (0.2904, 2.5, -2.1965),
    ]  # fmt: skip
    harmonics = tuple(pc.Harmonic(amplitude, omega, phase) for amplitude, omega, phase in parts)
    force, at, damping = pc.Forcing(harmonics, period=pc.pi_times(4)), -1.9376, 0.002276
    if kind == "oscillator":
        osc = pc.Oscillator(3, damping, (pc.Wall(at, "below", 0.7),))
        orbit: Any = pc.find_orbit(osc, force, n_impacts=0)
        branch: Any = pc.continue_orbit(orbit, over={"oscillator.stiffness": (LOW, 3)})
    else:
        wall = pc.Wall(at, "below", 0.7, on=0)
        one = pc.Structure(mass=[1], stiffness=[3], damping=[2.0 * damping], stops=[wall])
        orbit = pc.find_orbit(one, {0: force})
        branch = pc.continue_orbit(orbit, over={"structure.stiffness.0.0": (LOW, 3)})

    found = np.array([point.value for point in branch.special_points])
    times = np.linspace(0.0, 4.0 * np.pi, 20_001)
    x = np.zeros((len(found), len(times)))
    for a, w, phase in parts:
        gain = 1.0 / (found - w * w + 2j * damping * w)
        x += (a * gain[:, None] * np.exp(1j * (w * times + phase))).real
    assert found == pytest.approx([0.8477, 0.86795, 2.57373], abs=1e-4)
    np.testing.assert_allclose(x.min(axis=1), at, rtol=1e-5)
