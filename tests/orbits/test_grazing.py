"""What happens beside a graze: the discontinuity mapping, measured, and the attractors beyond."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.orbits.bifurcations.grazing import analysed_graze, consequence

# Formal orbits are meant here: they are looked at one by one.
pytestmark = pytest.mark.filterwarnings("ignore::percuss.FormalOrbitWarning")

AMPLITUDE = "forcing.amplitude"
COCO = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")


def at_graze(osc: pc.Oscillator, omega: float) -> tuple[pc.PeriodicOrbit, float]:
    """Return the motion whose amplitude, without stops, is 1, and the amplitude of its force."""
    k, a = float(osc.stiffness), float(osc.damping)
    amplitude = math.hypot(k - omega**2, 2.0 * a * omega)
    return pc.find_orbit(osc, pc.cosine(omega, amplitude=amplitude), 0), amplitude


def overdamped(multiplier: float) -> tuple[pc.Oscillator, float]:
    """Return an oscillator, and the frequency at which its larger multiplier is this."""
    slow = 1.5 - math.sqrt(1.5**2 - 1.0)
    return (
        pc.impact_oscillator(0.5, wall=1, side="above", damping="1.5"),
        -2.0 * math.pi * slow / math.log(multiplier),
    )


def propagator(osc: pc.Oscillator, s: float) -> np.ndarray:
    """Return the derivative of a free flight by its start, from two motions without force."""
    free = pc.Oscillator(osc.stiffness, osc.damping)
    columns = [pc.simulate(free, x0=x, v0=v, t_end=s)(s) for x, v in ((1.0, 0.0), (0.0, 1.0))]
    return np.array([[float(x), float(v)] for x, v in columns]).T


def measured_jump(
    orbit: pc.PeriodicOrbit, t: float, sign: float, depth: float, around: float = 0.2
) -> np.ndarray:
    """Return by how much the stop moves a motion that would pass it by a depth at t."""
    osc = orbit.oscillator
    t += 2.0 * orbit.period
    there = propagator(osc, around)
    before = np.linalg.solve(there, [sign * depth, 0.0])
    run = orbit.trajectory(4)
    x, v = (float(value) for value in run(t - around))
    hit = pc.simulate(
        osc, orbit.forcing, x0=x + before[0], v0=v + before[1], t0=t - around, t_end=t + around
    )
    apart = [float(a) - float(b) for a, b in zip(hit(t + around), run(t + around), strict=True)]
    return np.asarray(np.linalg.solve(there, apart) - np.array([sign * depth, 0.0]))


STOPS: dict[str, pc.Wall | pc.SoftStop] = {
    "wall": pc.Wall(1.0, "above", 0.8),
    "wall below": pc.Wall(-1.0, "below", 0.3),
    "soft": pc.SoftStop(1.0, "above", 9.0),
    "soft below": pc.SoftStop(-1.0, "below", 9.0),
    "soft with dashpot": pc.SoftStop(1.0, "above", 9.0, 0.7),
    "dashpot alone": pc.SoftStop(-1.0, "below", 0.0, 0.5),
}


@pytest.mark.parametrize("name", STOPS)
def test_the_coefficient_is_that_of_the_motion(name: str) -> None:
    stop = STOPS[name]
    orbit, _ = at_graze(pc.Oscillator(1.0, 0.05, (stop,)), 1.5)

    graze = analysed_graze(orbit, AMPLITUDE)

    assert graze.order == (0.5 if isinstance(stop, pc.Wall) else 1.5)
    sign = 1.0 if stop.side == "above" else -1.0
    depths = np.array([1e-4, 1e-5, 1e-6])
    jumps = np.array([measured_jump(orbit, graze.t, sign, d) for d in depths])
    found = jumps / depths[:, None] ** graze.order
    # What is left is of order sqrt(depth) of it.
    size = float(np.abs(graze.coefficient).max())
    error = np.abs(found - graze.coefficient).max(axis=1) / size
    assert error[-1] < 3e-3
    assert error[-1] < 0.5 * error[0]


def test_coco_the_impacting_orbits_come_back_below_the_graze() -> None:
    branch = pc.continue_orbit(
        pc.find_orbit(COCO, pc.cosine(1)), over={AMPLITUDE: (1.0, 0.05)}, largest_step=0.01
    )
    point = next(special for special in branch.special_points if special.kind == "grazing")

    graze = point.graze

    assert graze is not None
    assert graze.acceleration == pytest.approx(1.0, abs=1e-10)
    assert graze.coefficient == pytest.approx([0.0, -1.8 * math.sqrt(2.0)])
    assert graze.depth_rate == pytest.approx(10.0)
    assert (graze.free_side, graze.impacting_side) == ("below", "below")
    assert graze.scenario == "jump"
    # Along the branch, value = graze + u / impact_rate + c u^2: so is its fold.
    (fold,) = (special for special in branch.special_points if special.kind == "fold")
    speed = fold.orbit.min_impact_speed
    assert fold.value - point.value == pytest.approx(0.5 * speed / graze.impact_rate, rel=3e-4)
    # And the attractor beyond the graze has twice the speed of the fold at least.
    for beyond in (1e-7, 1e-9):
        run = pc.simulate(COCO, pc.cosine(1, amplitude=0.1 * (1 + beyond)), x0=0.9,
                          max_impacts=4000)  # fmt: skip
        assert run.impacts.v_before[-50:].min() > 1.9 * speed


@pytest.mark.parametrize("omega", [2.2, 2.5, 3.3])
def test_the_impact_velocity_leaves_the_graze_at_its_impact_rate(omega: float) -> None:
    osc = pc.impact_oscillator(0.8, wall=1, side="above", damping=0.05)
    orbit, amplitude = at_graze(osc, omega)
    graze = analysed_graze(orbit, AMPLITUDE)

    beyond = math.copysign(1e-7, graze.impact_rate)
    speeds = [
        each.impacts.v_before[0]
        for each in pc.orbits.single_impact_orbits(
            osc, pc.cosine(omega, amplitude=amplitude + beyond)
        )
    ]

    assert min(speeds, key=abs) == pytest.approx(graze.impact_rate * beyond, rel=1e-4)
    assert graze.impacting_side == ("above" if graze.impact_rate > 0.0 else "below")


@pytest.mark.parametrize(
    ("multiplier", "words"), [(0.15, "overlap"), (0.5, "chaos between"), (0.8, "without windows")]
)
def test_attractors_grow_continuously_from_a_graze_with_real_multipliers(
    multiplier: float, words: str
) -> None:
    """Impact speeds beyond it stay below the square-root law; their pattern is as told."""
    osc, omega = overdamped(multiplier)
    orbit, amplitude = at_graze(osc, omega)
    graze = analysed_graze(orbit, AMPLITUDE)
    assert graze.scenario == "continuous"
    assert words in graze.statement
    assert graze.multipliers.max().real == pytest.approx(multiplier)
    period = 2.0 * math.pi / omega

    n_speeds, longest = [], []
    for beyond in (1e-3, 1e-4, 1e-5):
        force = pc.cosine(omega, amplitude=amplitude * (1.0 + beyond))
        run = pc.simulate(osc, force, x0=0.9, t_end=4000 * period, max_impacts=2000)
        speeds = run.impacts.v_before[len(run.impacts) // 2 :]
        depth = graze.depth_rate * amplitude * beyond
        assert 0.3 < speeds.max() / math.sqrt(2.0 * graze.acceleration * depth) < 1.0
        n_speeds.append(len(np.unique((speeds / speeds.max()).round(6))))
        gaps = run.impacts.intervals[len(run.impacts) // 2 :] / period
        longest.append(gaps.max())
    assert longest == sorted(longest)
    if multiplier < 0.25:
        assert n_speeds == [1, 1, 1]
    if 0.25 < multiplier < 2.0 / 3.0:
        assert min(n_speeds) == 1
        assert max(n_speeds) > 100
    if multiplier > 2.0 / 3.0:
        assert min(n_speeds) > 50


def test_with_complex_multipliers_the_attractor_jumps() -> None:
    osc = pc.impact_oscillator(0.8, wall=1, side="above", damping=0.05)
    orbit, amplitude = at_graze(osc, 2.5)
    graze = analysed_graze(orbit, AMPLITUDE)
    assert graze.scenario == "jump"
    assert "2 periods after an impact" in graze.statement

    fastest = []
    for beyond in (1e-4, 1e-6, 1e-8):
        force = pc.cosine(2.5, amplitude=amplitude * (1.0 + beyond))
        run = pc.simulate(osc, force, x0=0.9, t_end=5000.0, max_impacts=4000)
        fastest.append(run.impacts.v_before[-500:].max())

    # From nothing it would be 100 times slower at the last than at the first; which of the
    # attractors that coexist beyond the graze a motion comes to hangs on rounding.
    assert min(fastest) > 0.2 * max(fastest)


def test_at_a_soft_stop_the_multipliers_are_continuous() -> None:
    osc = pc.Oscillator(1.0, 0.05, (pc.SoftStop(1.0, "above", 9.0, 0.2),))
    orbit, amplitude = at_graze(osc, 1.5)
    graze = analysed_graze(orbit, AMPLITUDE)
    assert graze.scenario == "continuous"
    assert (graze.free_side, graze.impacting_side) == ("below", "above")

    branch = pc.continue_orbit(orbit, over={AMPLITUDE: (amplitude, 1.02 * amplitude)})

    beyond = (branch.values - amplitude) / amplitude
    rows = np.flatnonzero((beyond > 1e-6) & (beyond < 1e-3))
    assert len(rows) >= 3
    depth = graze.depth_rate * amplitude * beyond[rows]
    # Entry as fast as on a parabola of that depth.
    speed = np.sqrt(2.0 * graze.acceleration * depth)
    assert (np.abs(branch.impact_velocity[rows, 0] / speed - 1.0) < 1.5 * speed).all()
    # The derivative of the correction acts once around; the next order is that of the depth.
    jump = 1.5 * graze.coefficient * np.sqrt(depth)[:, None]
    apart = [np.trace(branch[row].monodromy) - np.trace(graze.monodromy) for row in rows.tolist()]
    errors = np.abs(apart - jump @ graze.monodromy[0])
    assert (errors < 0.1 * np.abs(apart)).all()


def test_the_multipliers_are_those_of_the_orbit_without_the_graze() -> None:
    """Of an orbit with an impact, which returns to the stop and grazes it there."""
    osc = pc.impact_oscillator(0.5, wall=-0.3)
    orbit = pc.find_orbit(osc, pc.cosine(1.3))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (1.3, 0.6)})
    point = next(special for special in branch.special_points if special.kind == "grazing")

    graze = point.graze

    assert graze is not None
    np.testing.assert_allclose(
        np.sort_complex(graze.multipliers), np.sort_complex(point.orbit.multipliers), atol=1e-9
    )


def test_both_walls_grazed_at_once_are_one_graze_of_half_the_orbit() -> None:
    osc = pc.Oscillator(1.0, 0.05, (pc.Wall(1.0, "above", 0.8), pc.Wall(-1.0, "below", 0.8)))
    orbit, _ = at_graze(osc, 2.5)

    graze = analysed_graze(orbit, AMPLITUDE)

    squares = np.sort_complex(graze.multipliers**2)
    np.testing.assert_allclose(squares, np.sort_complex(orbit.multipliers), atol=1e-10)
    assert graze.order == 0.5
    assert "half period" in graze.statement


@pytest.mark.parametrize("walls", ["both", "again"])
def test_the_rate_holds_for_two_walls_and_for_orbits_with_other_impacts(walls: str) -> None:
    if walls == "both":
        osc = pc.Oscillator(1.0, 0.05, (pc.Wall(1.0, "above", 0.8), pc.Wall(-1.0, "below", 0.8)))
        path, over, orbit = (
            AMPLITUDE,
            (4.0, 8.0),
            pc.find_orbit(osc, pc.cosine(2.5, amplitude=4), 0),
        )
    else:
        osc = pc.impact_oscillator(0.5, wall=-0.3)
        path, over, orbit = "forcing.omega", (1.3, 0.6), pc.find_orbit(osc, pc.cosine(1.3))
    branch = pc.continue_orbit(orbit, over={path: over})
    point = next(special for special in branch.special_points if special.kind == "grazing")
    assert point.graze is not None

    beside = pc.switch_branch(point)

    value = float(pc.model.get_parameter(beside.oscillator, beside.forcing, None, path))
    rate = beside.min_impact_speed / (value - point.value)
    assert rate == pytest.approx(point.graze.impact_rate, rel=1e-3)


def test_where_a_plastic_impact_begins_to_stick_nothing_is_decided() -> None:
    """With r = 0 the mass leaves the wall at once, or else stays: at the change it grazes."""
    osc = pc.impact_oscillator(0, wall="0.2")
    branch = pc.continue_orbit(pc.find_orbit(osc, pc.cosine("2.5")), over={"forcing.omega": (2, 4)})
    point = next(special for special in branch.special_points if special.kind == "grazing")

    assert point.graze is None or point.graze.scenario == "undecided"


def test_which_statement_follows_from_which_matrix() -> None:
    def scenario(matrix: list[list[float]]) -> str:
        return consequence(np.array(matrix), is_wall=True)[0]

    assert scenario([[0.5, 0.3], [0.0, 0.2]]) == "continuous"
    assert scenario([[0.5, -0.3], [0.0, 0.2]]) == "jump"
    assert scenario([[-0.5, 0.3], [0.0, -0.2]]) == "jump"
    assert scenario([[0.0, 0.5], [-0.5, 0.0]]) == "jump"
    assert scenario([[1.5, 0.3], [0.0, 0.2]]) == "undecided"
    assert scenario([[0.5, 0.0], [0.3, 0.2]]) == "undecided"
    # The angle is so small that an impact is forgotten before it turns towards the wall.
    assert scenario([[0.5, 0.3], [-1e-5, 0.5]]) == "continuous"


def test_bad_input_is_named() -> None:
    with pytest.raises(pc.ParameterError, match="grazes no stop"):
        analysed_graze(pc.find_orbit(COCO, pc.cosine(1)), AMPLITUDE)
    orbit = pc.find_orbit(COCO, pc.cosine(1))
    branch = pc.continue_orbit(orbit, over={AMPLITUDE: (1.0, 0.0999)})
    assert (
        next(special for special in branch.special_points if special.kind == "fold").graze is None
    )
