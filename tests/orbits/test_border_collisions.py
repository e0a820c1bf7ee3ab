"""Branches where an impact meets a jump of the force: border collisions."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import fsolve

import percuss as pc

R, WALL, DAMPING = 0.8, 0.2, 0.05
HARD = pc.impact_oscillator(R, wall=WALL, side="above", damping=DAMPING)
OMEGA = "forcing.record.omega"


def borders(branch: pc.Branch) -> list[pc.SpecialPoint]:
    return [point for point in branch.special_points if point.kind == "border_collision"]


def under_constant_force(x: float, v: float, force: float, t: float) -> tuple[float, float]:
    """Return the state after a time, by the textbook's formula."""
    pace = math.sqrt(1.0 - DAMPING**2)
    y, b = x - force, (v + DAMPING * (x - force)) / pace
    decay, c, s = math.exp(-DAMPING * t), math.cos(pace * t), math.sin(pace * t)
    return (
        force + decay * (y * c + b * s),
        decay * ((pace * b - DAMPING * y) * c - (pace * y + DAMPING * b) * s),
    )


def corner_of(wall: float, restitution: float, guess: tuple[float, float]) -> tuple[float, float]:
    """Return half the period, and the velocity before the impact, of an orbit that hits at the jump.

    It starts from the wall as the force falls to -1, and comes back as it falls again.
    """

    def missed(z: np.ndarray) -> list[float]:
        half, v = z
        x, w = under_constant_force(wall, -restitution * v, -1.0, half)
        x, w = under_constant_force(x, w, 1.0, half)
        return [x - wall, w - v]

    half, v = fsolve(missed, guess, xtol=1e-13)
    return float(half), float(v)


@pytest.fixture(scope="module")
def through() -> pc.Branch:
    orbit = pc.find_orbit(HARD, pc.square_wave(2))
    return pc.continue_orbit(orbit, over={OMEGA: (2, "1.9")})


@pytest.fixture(scope="module")
def turned() -> pc.Branch:
    osc = pc.impact_oscillator("0.55", wall="-0.45", side="above", damping=DAMPING)
    orbit = pc.find_orbit(osc, pc.square_wave("2.5"))
    return pc.continue_orbit(orbit, over={"oscillator.stops.0.at": ("-0.8", "-0.45")})


def test_a_branch_goes_on_where_an_impact_meets_a_jump(through: pc.Branch) -> None:
    (point,) = borders(through)
    half, speed = corner_of(WALL, R, (math.pi / 1.958, 4.7))
    assert point.value == pytest.approx(math.pi / half, abs=1e-12)
    assert abs(point.orbit.impacts.v_before[0]) == pytest.approx(speed, abs=1e-10)
    assert point.orbit.impacts.t[0] % point.orbit.period == pytest.approx(half, abs=1e-11)
    assert point.interval[0] <= point.value <= point.interval[1]
    assert point.status == "located"
    assert through.special_points == (point,)
    assert "the branch goes on" in point.detail
    assert through.values[0] == 2.0
    assert through.values[-1] == 1.9
    # It is found ahead, not by ever shorter steps.
    assert np.diff(np.sort(through.values)).min() > 1e-5


def test_the_trace_jumps_there_by_a_closed_form(through: pc.Branch) -> None:
    """By (1 + r) [f] N_12 / v, with the free motion's N_12 over a period; the determinant not."""
    (point,) = borders(through)
    one, other = (
        pc.find_orbit(HARD, pc.square_wave(point.value + way * 1e-7)) for way in (1.0, -1.0)
    )
    # Below the value the impact comes before the jump, under the force 1 and not -1.
    cycles = [each.impacts.t[0] / each.period % 1.0 for each in (one, other)]
    assert cycles[0] > 0.5 > cycles[1]
    period, pace = point.orbit.period, math.sqrt(1.0 - DAMPING**2)
    free = math.exp(-DAMPING * period) * math.sin(pace * period) / pace
    jump = 2.0 * (1.0 + R) * free / abs(float(point.orbit.impacts.v_before[0]))
    traces, determinants = (
        [f(each.multipliers).real for each in (one, other)] for f in (np.sum, np.prod)
    )
    assert traces[1] - traces[0] == pytest.approx(jump, abs=1e-6)
    assert determinants[1] == pytest.approx(determinants[0], abs=1e-6)


def test_the_branch_on_both_sides_is_what_motions_settle_on(through: pc.Branch) -> None:
    (point,) = borders(through)
    for row in (point.row - 3, point.row + 3):
        orbit = through[row]
        run = pc.simulate(orbit.oscillator, orbit.forcing, periods=200)
        last = run.impacts.t[-1] / orbit.period % 1.0
        assert run.impacts.v_before[-1] == pytest.approx(orbit.impacts.v_before[0], abs=1e-9)
        assert last == pytest.approx(orbit.impacts.t[0] / orbit.period % 1.0, abs=1e-10)
        # The impact lies after the jump of the middle of the period, then before it.
        assert (last > 0.5) == (row < point.row)


def test_a_branch_turns_at_a_nonsmooth_fold(turned: pc.Branch) -> None:
    (point,) = borders(turned)
    assert "two orbits meet and end, a nonsmooth fold" in point.detail
    assert not [other for other in turned.special_points if other.kind == "fold"]
    assert point.value == turned.values.min()
    before, after = turned[point.row - 1], turned[point.row + 1]
    assert {before.stability, after.stability} == {"asymptotic", "unstable"}
    # Where a smooth fold has a multiplier of 1 these are away from it.
    assert min(abs(np.concatenate([before.multipliers, after.multipliers]) - 1.0)) > 0.03
    # Two orbits at one wall: found afresh from guesses near both.
    for row in (point.row - 3, point.row + 3):
        orbit = turned[row]
        osc = pc.impact_oscillator("0.55", wall=turned.values[row], side="above", damping=DAMPING)
        run = pc.simulate(osc, orbit.forcing, orbit.x0, orbit.v0, orbit.t0,
                          t_end=orbit.t0 + 2.5 * orbit.period)  # fmt: skip
        assert np.abs(run.impacts.v_before - orbit.impacts.v_before[0]).max() < 1e-9


def test_no_proof_is_claimed_of_it(turned: pc.Branch) -> None:
    (point,) = borders(turned)
    proof = pc.certify(point)
    assert not proof.exists
    assert "two values" in proof.reason
    with pytest.raises(pc.ParameterError, match="without doubling"):
        pc.switch_branch(point)


def test_it_is_found_over_a_tied_parameter() -> None:
    w = pc.parameter("w", "1.98")
    force = pc.square_wave(w, amplitude="0.25" * w**2)
    branch = pc.continue_orbit(pc.find_orbit(HARD, force), over={"w": ("1.98", "1.93")})
    (point,) = borders(branch)
    orbit = point.orbit
    assert orbit.impacts.t[0] / orbit.period % 1.0 == pytest.approx(0.5, abs=1e-12)
    assert "the branch goes on" in point.detail
    assert branch.values[-1] == 1.93


@pytest.mark.parametrize(
    ("dashpot", "first", "last"), [("0", "1.69", "1.65"), ("0.3", "1.68", "1.67")]
)
def test_at_the_edge_of_a_soft_stop_a_branch_is_smooth(dashpot: str, first: str, last: str) -> None:
    """The multipliers do not depend on the force at the edge, so that nothing is listed."""
    stop = pc.SoftStop(at="0.2", side="above", stiffness=20, damping=dashpot)
    osc = pc.Oscillator(1, "0.05", (stop,))
    orbit = pc.find_orbit(osc, pc.square_wave(first))
    branch = pc.continue_orbit(orbit, over={OMEGA: (first, last)})
    assert branch.special_points == ()
    assert branch.values[-1] == float(last)
    entries = np.array([each.itinerary.start / each.period % 1.0 for each in branch])
    assert entries.min() < 0.5 < entries.max()
    changes = np.abs(np.diff(branch.multipliers.sum(axis=1).real))
    assert changes.max() < 3.0 * np.median(changes[changes > 0.0]) + 1e-3
    fresh = pc.find_orbit(osc, pc.square_wave(last))
    assert fresh.multipliers.sum() == pytest.approx(branch.multipliers[-1].sum(), abs=1e-9)


def test_at_the_kink_of_a_record_a_branch_is_smooth() -> None:
    """The force of a triangle wave is continuous, and so are the multipliers."""
    orbit = pc.find_orbit(HARD, pc.triangle_wave("2.1"))
    branch = pc.continue_orbit(orbit, over={OMEGA: ("2.1", "1.8")})
    cycles = np.array([each.impacts.t[0] / each.period % 1.0 for each in branch])
    assert min(abs(cycles - 0.75)) < 0.02 or (cycles.min() < 0.5 < cycles.max())
    assert borders(branch) == []
    assert np.abs(np.diff(branch.multipliers.sum(axis=1).real)).max() < 0.1


def test_an_orbit_of_twice_the_period_starts_at_one() -> None:
    """Its impacts come before the jump and after it in turn, and motions settle on it."""
    osc = pc.impact_oscillator("0.5", wall="-0.2", side="above", damping="0.05")
    over = {"oscillator.stops.0.at": ("-0.2", "-0.18")}
    branch = pc.continue_orbit(pc.find_orbit(osc, pc.pulses("0.9", "0.86", amplitude=-1)), over)
    (point,) = borders(branch)
    assert "from stable to unstable; an orbit of twice the period starts" in point.detail
    doubled = pc.switch_branch(point)
    assert (doubled.n_impacts, doubled.n_periods, doubled.stability) == (2, 2, "asymptotic")
    cycles = (2.0 * doubled.impacts.t / doubled.period + 0.5) % 1.0 - 0.5
    assert cycles[0] * cycles[1] < 0.0
    run = pc.simulate(doubled.oscillator, doubled.forcing, x0=-0.5, periods=120)
    assert sorted(run.impacts.v_before[-2:]) == pytest.approx(
        sorted(doubled.impacts.v_before), abs=1e-9
    )
    later = pc.switch_branch(point, other_side=True)
    assert later.impacts.v_before[::-1] == pytest.approx(doubled.impacts.v_before, abs=1e-9)
    back = pc.continue_orbit(doubled, {"oscillator.stops.0.at": ("-0.195", "-0.18")})
    origin = back.special_points[0]
    assert origin.kind == "border_collision"
    assert origin.value == pytest.approx(point.value, abs=1e-12)
    assert "two-fold cover" in origin.detail
    assert "two-fold cover" in back.end_reason
    assert pc.switch_branch(origin).n_periods == 1


def test_a_structure_of_one_coordinate_has_the_same_point(through: pc.Branch) -> None:
    (point,) = borders(through)
    wall = pc.Wall(at=WALL, side="above", restitution=R, on=0)
    structure = pc.Structure(mass=1, stiffness=1, damping=2 * DAMPING, stops=(wall,))
    orbit = pc.find_orbit(structure, pc.Loads({0: pc.square_wave("1.97")}))
    branch = pc.continue_orbit(orbit, over={"loads.0.record.omega": ("1.97", "1.94")})
    (own,) = branch.special_points
    assert own.kind == "border_collision"
    assert own.value == pytest.approx(point.value, abs=1e-11)
    assert own.detail == point.detail.replace("of the force", "of the loads")
    assert branch.values[-1] == 1.94
    fresh = pc.find_orbit(HARD, pc.square_wave("1.94"))
    assert branch.multipliers[-1] == pytest.approx(fresh.multipliers, abs=1e-9)


@pytest.mark.parametrize("loaded", [0, 1])
def test_a_load_on_another_mass_makes_no_corner(loaded: int) -> None:
    """The acceleration of the mass that hits the wall jumps with a load on itself alone."""
    wall = pc.Wall(at="0.5", side="above", restitution="0.7", on=0)
    chain = pc.chain([1, 1], [1, 1, 0], ["0.1", "0.1", 0], stops=(wall,))
    start, end = (("2.0", "2.09"), ("1.1", "1.02"))[loaded]
    orbit = pc.find_orbit(chain, pc.Loads({loaded: pc.square_wave(start)}))
    branch = pc.continue_orbit(orbit, over={"loads.0.record.omega": (start, end)})
    kinds = [point.kind for point in branch.special_points]
    assert branch.values[-1] == float(end)
    cycles = np.array([each.run.impacts.t[-1] / each.period for each in branch])
    assert cycles.min() < 0.5 < cycles.max()
    assert ("border_collision" in kinds) == (loaded == 0)
    last = branch[len(branch) - 1]
    run = pc.simulate(chain, last.loads, x0=last.x0, v0=last.v0, t_end=last.period)
    assert np.abs(np.concatenate(run(run.t_end)) - np.concatenate([last.x0, last.v0])).max() < 1e-9


def check_end_at_a_jump(curve: pc.Curve, cycle: float, multiplier: float) -> None:
    """Check that a curve ends where its impact meets a jump, with the multiplier it is made of."""
    assert "an event meets a jump of the force, where the multipliers jump" in curve.end_reason
    ends = [each.impacts.t[0] / each.period % 1.0 for each in (curve[0], curve[-1])]
    row = int(np.argmin(np.abs(np.array(ends) - cycle)))
    assert ends[row] == pytest.approx(cycle, abs=1e-7)
    end = curve[-row]
    assert np.abs(end.multipliers - multiplier).min() < 1e-6
    # The values are those of the sentence.
    assert f"{curve.paths[0]} = {curve.values[-row][0]:.12g}" in curve.end_reason


@pytest.mark.parametrize(
    "other",
    [("oscillator.stops.0.restitution", "0.2", "0.6"), ("oscillator.stops.0.at", "-0.8", "0")],
)
def test_a_curve_of_folds_ends_at_a_jump_and_says_so(other: tuple[str, str, str]) -> None:
    path, low, high = other
    osc = pc.impact_oscillator("0.55", wall="-0.45", side="above", damping=DAMPING)
    orbit = pc.find_orbit(osc, pc.square_wave("2.5"))
    branch = pc.continue_orbit(orbit, over={OMEGA: ("2.5", "2.2")})
    (fold,) = [point for point in branch.special_points if point.kind == "fold"]
    curve = pc.continue_curve(fold, over={OMEGA: ("2", "3"), path: (low, high)})
    check_end_at_a_jump(curve, 0.5, 1.0)


def test_a_curve_of_doublings_ends_at_a_jump_and_says_so() -> None:
    # Held samples: the force steps by a little at 0.7 of the period.
    force = pc.record(["0", "1.33", "1.862", "2.66"], [1, -1, "-0.95", 1], kind="hold", repeat=True)
    over = {"oscillator.stops.0.at": ("0.24", "0.2")}
    osc = pc.impact_oscillator(R, wall="0.24", side="above", damping=DAMPING)
    branch = pc.continue_orbit(pc.find_orbit(osc, force), over=over)
    (doubling,) = [point for point in branch.special_points if point.kind == "period_doubling"]
    ranges = {"oscillator.stops.0.at": ("0.1", "0.3"), "oscillator.damping": ("0.05", "0.3")}
    check_end_at_a_jump(pc.continue_curve(doubling, over=ranges), 0.7, -1.0)
