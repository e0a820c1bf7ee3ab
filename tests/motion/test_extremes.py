"""The largest and least values of a run, against 40 digits and closed forms."""

from __future__ import annotations

import math
from typing import Any, cast

import mpmath
import numpy as np
import pytest
from tests.oracle.event_driven import simulate
from tests.oracle.extremes import extremes
from tests.oracle.from_model import problem_of
from tests.oracle.random_problems import random_motion

import percuss as pc
from percuss.motion.extremes import QuantityName

EPS = 2.0**-52
# Impacts and soft stops multiply rounding by less than 1e6 in the time and cases chosen.
AFTER_IMPACTS = 1e-9
WEIGHTS = {"displacement": (1,), "velocity": (0, 1), "acceleration": (0, 0, 1)}


def test_a_mooring_line_pulls_hardest_at_its_entry() -> None:
    line = pc.SoftStop(at=0.5, side="above", stiffness=400e3, damping=400e3)
    buoy = pc.Oscillator.from_mass(50e3, stiffness=20e3, damping_coefficient=4e3, stops=(line,))
    waves = pc.cosine("0.7854", amplitude=40e3, constant=10e3)
    run = pc.simulate(buoy, waves, periods=200)

    last = run.extremes("stop_force", between=(run.t_end - 40.0, run.t_end))

    # In kN. The dashpot answers to the speed at the entry at once.
    assert round(-last.minimum / 1000, 2) == 883.04
    entries = run.crossings.t[run.crossings.direction == "in"]
    assert last.t_minimum in entries
    v = run.crossings.v[run.crossings.t == last.t_minimum][0]
    assert last.minimum == pytest.approx(-400e3 * v, rel=4 * EPS)


@pytest.mark.parametrize(
    "seeds", [range(0, 40, 8), pytest.param(range(400), marks=pytest.mark.nightly)], ids=len
)
def test_extremes_are_those_of_the_oracle(seeds: range) -> None:
    assert [fault for seed in seeds for fault in _faults(seed)] == []


def _faults(seed: int) -> list[str]:
    case = random_motion(seed)
    run = pc.simulate(case.oscillator, case.forcing, *case.start, t_end=case.start[2] + 6.0,
                      max_impacts=100)  # fmt: skip
    problem = problem_of(case.oscillator, case.forcing)
    exact = simulate(problem, *case.start, t_end=run.t_end, digits=25)
    wanted: list[tuple[Any, ...]] = [(name, 0, weights, None) for name, weights in WEIGHTS.items()]
    wanted += [("spring_force", 0, (-problem.stiffness,), None)]
    wanted += [
        ("stop_force", i, (-number_of(stop.stiffness), -2 * number_of(stop.damping)),
         (stop.at, 1 if stop.side == "above" else -1))
        for i, stop in enumerate(case.oscillator.stops)
        if isinstance(stop, pc.SoftStop)
    ]  # fmt: skip
    faults = []
    for name, stop, weights, edge in wanted:
        # The oracle does not know the limit before an impact at the very start.
        after = min(float(np.nextafter(run.t0, math.inf)), run.t_end)
        ours = run.extremes(name, stop, between=(after, run.t_end))
        least, t_least, most, t_most = extremes(exact, weights, run.t_end, edge)
        size = max(1.0, abs(float(least)), abs(float(most)))
        for value, t, other, other_t in (
            (ours.minimum, ours.t_minimum, least, t_least),
            (ours.maximum, ours.t_maximum, most, t_most),
        ):
            if abs(value - float(other)) > AFTER_IMPACTS * size:
                faults.append(f"{seed} {name} {stop}: {value!r} at {t}, not {other} at {other_t}")
    return faults


def number_of(value: Any) -> Any:
    return mpmath.mpf(float(value))


@pytest.mark.parametrize(
    ("k", "a"),
    [(1.0, 0.0), (4.0, 0.05), (4.0, 2.0), (1.0, 3.0), (0.0, 0.0), (0.0, 0.3), (-0.5, 0.1)],
    ids=["undamped", "light", "critical", "overdamped", "free", "dragged", "growing"],
)
@pytest.mark.parametrize("n_harmonics", [0, 1, 3])
def test_extremes_of_one_flight_are_exact_to_rounding(k: float, a: float, n_harmonics: int) -> None:
    parts = (
        pc.Harmonic(1.25, 1.0, 0.5), pc.Harmonic(0.75, 2.5, -1.0), pc.Harmonic(0.5, 7.0, 0.25)
    )  # fmt: skip
    force = pc.Forcing(parts[:n_harmonics], constant=-0.125)
    osc = pc.Oscillator(k, a)
    run = pc.simulate(osc, force, 0.5, 1.25, 0.0, t_end=7.0)
    exact = simulate(problem_of(osc, force), 0.5, 1.25, 0, t_end=7.0, digits=40)

    for name, weights in (WEIGHTS | {"spring_force": (-k,)}).items():
        ours = run.extremes(cast("QuantityName", name))
        least, t_least, most, t_most = (float(number) for number in
                                        extremes(exact, weights, 7.0))  # fmt: skip
        size = max(abs(least), abs(most), 1.0)
        assert abs(ours.minimum - least) <= 16 * EPS * size
        assert abs(ours.maximum - most) <= 16 * EPS * size
        # The instant of a summit has the rounding of the slope over the curvature there.
        assert abs(ours.t_minimum - t_least) <= 1e-13 or k * weights[0] == 0.0
        assert abs(ours.t_maximum - t_most) <= 1e-13 or k * weights[0] == 0.0


@pytest.mark.parametrize("beyond", [-1e-3, -1e-8, -1e-12, 0.0, 1e-12, 1e-8, 1e-3])
def test_a_summit_next_to_the_end_of_a_flight_is_not_missed(beyond: float) -> None:
    # x = sin t has its summit at pi / 2.
    run = pc.simulate(pc.Oscillator(), v0=1.0, t_end=4.0)
    end = 0.5 * math.pi + beyond

    before = run.extremes("displacement", between=(0.0, end))
    after = run.extremes("displacement", between=(end, 4.0))

    assert before.maximum == pytest.approx(math.sin(min(end, 0.5 * math.pi)), abs=EPS)
    assert after.maximum == pytest.approx(math.sin(max(end, 0.5 * math.pi)), abs=EPS)
    # At 1e-8 from it the summit is higher by 5e-17 only: the last digit decides.
    if abs(beyond) >= 1e-3:
        assert before.t_maximum == pytest.approx(min(end, 0.5 * math.pi), abs=4 * EPS)


def test_a_summit_between_two_impacts_in_a_fast_hop() -> None:
    # A ball thrown up with 1e-6: the hop is 2e-6 / 9.81 long and v^2 / 2 g high.
    floor = pc.Wall(at=0, side="below", restitution=1)
    run = pc.simulate(pc.Oscillator(stiffness=0, stops=(floor,)), pc.Forcing(constant=-9.81),
                      x0=0.0, v0=1e-6, max_impacts=3)  # fmt: skip

    hop = run.extremes("displacement")

    assert hop.maximum == pytest.approx(1e-12 / 19.62, rel=4 * EPS)
    assert hop.minimum == 0.0
    assert run.extremes("velocity").minimum == pytest.approx(-1e-6, rel=4 * EPS)
    assert run.extremes("acceleration").minimum == -9.81


def test_a_graze_reaches_the_stop_and_no_further() -> None:
    # x = sin t touches the edge at 1 exactly.
    stop = pc.SoftStop(at=1, side="above", stiffness=50, damping=1)
    run = pc.simulate(pc.Oscillator(stops=(stop,)), v0=1.0, t_end=20.0)

    assert run.extremes("displacement").maximum <= 1.0 + 2 * EPS
    assert abs(run.extremes("stop_force").minimum) <= 100 * EPS


def test_a_plateau_has_its_first_instant() -> None:
    still = pc.simulate(pc.Oscillator(), t0=2.0, t_end=9.0)
    assert still.extremes("displacement") == pc.Extrema(0.0, 2.0, 0.0, 2.0)
    # r = 0: the ball stays on the table from its first impact on.
    table = pc.Wall(at=0, side="below", restitution=0)
    ball = pc.Oscillator(stiffness=0, stops=(table,))
    run = pc.simulate(ball, pc.Forcing(constant=-2), x0=1.0, t_end=9.0)

    assert run.extremes("displacement").t_minimum == run.impacts.t[0] == 1.0
    assert run.extremes("acceleration") == pc.Extrema(-2.0, 0.0, 0.0, 1.0)
    assert run.extremes("stop_force") == pc.Extrema(0.0, 0.0, 2.0, 1.0)


def test_a_wall_bears_the_force_that_holds_the_mass() -> None:
    # At rest on the wall from the start, under -2 - cos t + cos(3 t) / 2: the wall bears the
    # opposite, which is largest and smallest where its derivative sin t - (3 / 2) sin 3 t is 0.
    wall = pc.Wall(at=0, side="below", restitution="0.5")
    force = pc.cosine(1, amplitude=-1) + pc.cosine(3, amplitude="0.5") + pc.Forcing(constant=-2)
    run = pc.simulate(pc.Oscillator(stops=(wall,)), force, t_end=20.0)
    assert run.contacts.start.tolist() == [0.0]

    held = run.extremes("stop_force")

    with mpmath.workdps(40):
        # With c = cos t, sin 3 t = sin t (4 c^2 - 1): sin t = 0 or c^2 = 5 / 12.
        root = mpmath.sqrt(mpmath.mpf(5) / 12)
        bearing = [2 + c - (4 * c**3 - 3 * c) / 2 for c in (1, -1, root, -root)]
        least, most = float(min(bearing)), float(max(bearing))
        t_most = float(mpmath.acos(root))
    assert held.minimum == pytest.approx(least, rel=4 * EPS)
    assert held.maximum == pytest.approx(most, rel=4 * EPS)
    assert held.t_maximum == pytest.approx(t_most, abs=1e-7)
    assert np.allclose(run.forces(held.t_maximum)["stops"], most, rtol=4 * EPS, atol=0.0)


@pytest.mark.parametrize("phase", [0.0, 2.0, 4.5])
def test_a_wall_holds_a_mass_against_a_wave_and_a_harmonic(phase: float) -> None:
    """The force on the wall has its extremes at knots, and where the slopes of both cancel."""
    osc = pc.Oscillator(1, 0.1, stops=(pc.Wall(at=0, side="below", restitution=0.2),))
    harmonic = pc.cosine(2.1, amplitude=0.4, phase=phase, constant=-2.5)
    run = pc.simulate(osc, pc.triangle_wave(1.3, amplitude=0.7) + harmonic, 0.3, t_end=12)

    start = run.contacts.start[0] + 0.5
    t = np.linspace(start, run.t_end, 20_001)
    bears = run.forces(t).stops.values[0]
    found = run.extremes("stop_force", between=(start, run.t_end))
    # Between two instants a summit is higher by f'' dt^2 / 8, and a kink by the slope times dt.
    assert 0.0 <= found.maximum - bears.max() < 1e-3
    assert 0.0 <= bears.min() - found.minimum < 1e-3


def test_a_wall_bears_most_at_a_limit_where_a_contact_begins() -> None:
    # r = 0 under gravity that fades: the wall's force falls from the landing on.
    wall = pc.Wall(at=0, side="below", restitution=0)
    force = pc.cosine("0.1", amplitude=-1) + pc.Forcing(constant=-1)
    run = pc.simulate(pc.Oscillator(stiffness=0, stops=(wall,)), force, x0=1.0, t_end=20.0)

    held = run.extremes("stop_force")

    assert held.t_maximum == run.contacts.start[0]
    assert held.maximum == pytest.approx(1.0 + math.cos(0.1 * held.t_maximum), rel=4 * EPS)
    # Before the landing nothing touches.
    assert (held.minimum, held.t_minimum) == (0.0, 0.0)


def test_extremes_of_a_chatter_are_those_of_its_hops() -> None:
    osc = pc.impact_oscillator("0.8", wall=0)
    run = pc.simulate(osc, pc.cosine("2.7"), v0=1.0, t_end=60.0)
    assert len(run.contacts) > 0
    first = run.contacts.n_impacts[0]
    # At the impact itself the limit before it would count.
    tail = (np.nextafter(run.impacts.t[first - 1], math.inf), run.contacts.start[0])

    fastest = run.extremes("velocity", between=tail)

    # Its next landing is as fast as its last take-off.
    assert fastest.minimum == pytest.approx(-run.impacts.v_after[first - 1], rel=1e-6)
    whole = run.extremes("displacement")
    t = np.linspace(run.t0, run.t_end, 200_001)
    assert whole.minimum == 0.0
    assert run(t)[0].max() <= whole.maximum <= run(t)[0].max() + 1e-6


def test_all_values_of_a_run_lie_between_its_extremes() -> None:
    gap = (pc.SoftStop("0.3", "above", 40, "0.5"), pc.SoftStop("-0.2", "below", 90, "0.25"))
    run = pc.simulate(pc.Oscillator(1, "0.02", gap), pc.cosine("1.3"), t_end=300.0)
    t = np.linspace(run.t0, run.t_end, 100_001)
    x, v = run(t)
    forces = run.forces(t)
    sums = sum(forces[name].values for name in ("spring", "damping", "forcing"))
    sampled = {
        ("displacement", 0): x, ("velocity", 0): v, ("spring_force", 0): forces.spring.values,
        ("stop_force", 0): forces.stops.values[0], ("stop_force", 1): forces.stops.values[1],
        ("acceleration", 0): sums + forces.stops.values.sum(axis=0),
    }  # fmt: skip

    for (name, stop), values in sampled.items():
        extrema = run.extremes(cast("QuantityName", name), stop)
        slack = 64 * EPS * np.abs(values).max()
        assert extrema.minimum <= values.min() + slack, name
        assert extrema.maximum >= values.max() - slack, name
        # 300 samples an oscillation come near, even at a jump.
        near = 0.05 * np.ptp(values)
        assert extrema.minimum == pytest.approx(values.min(), abs=near), name
        assert extrema.maximum == pytest.approx(values.max(), abs=near), name


@pytest.mark.parametrize(
    ("of", "stop", "between", "name"),
    [
        ("speed", 0, None, "of"),
        ("stop_force", 1, None, "stop"),
        ("stop_force", -1, None, "stop"),
        ("velocity", 0, (0.0, 99.0), "between"),
        ("velocity", 0, (2.0, 1.0), "between"),
        ("velocity", 0, 3.0, "between"),
    ],
)
def test_a_wrong_question_is_refused(of: Any, stop: int, between: Any, name: str) -> None:
    run = pc.simulate(pc.impact_oscillator(), v0=1.0, t_end=5.0)

    with pytest.raises(pc.ParameterError, match=rf"^{name}"):
        run.extremes(of, stop, between)


@pytest.mark.parametrize("omega", np.random.default_rng(5).uniform(0.6, 3, 12).tolist())
def test_a_window_from_jump_to_jump_has_the_limits_within_and_without(omega: float) -> None:
    """The rounding of an instant decided whether the acceleration beyond it counted."""
    force = pc.square_wave(omega)
    period = force.period
    assert period is not None
    run = pc.simulate(pc.Oscillator("0.7", "0.1"), force, t_end=2.2 * period)
    one = pc.Structure(mass=[1], stiffness=["0.7"], damping=["0.2"])
    same = pc.simulate(one, pc.Loads({0: force}), x0=[0], v0=[0], t_end=2.2 * period)
    begin, end = period, 2 * period
    limits = [
        side - 0.7 * run(t)[0] - 0.2 * run(t)[1] for t in (begin, end) for side in (1.0, -1.0)
    ]
    found = run.extremes("acceleration", between=(begin, end))
    also = same.extremes("acceleration", on=0, between=(begin, end))
    assert found.maximum >= max(limits) - 1e-13
    assert found.minimum <= min(limits) + 1e-13
    assert (also.minimum, also.maximum) == pytest.approx((found.minimum, found.maximum), rel=1e-12)


@pytest.mark.parametrize("half_periods", [1, 2, 3, 5, 6, 15, 40, 41])
@pytest.mark.parametrize("omega", ["1", "1.3", "0.7", "3.7"])
def test_the_rounding_of_an_end_at_a_jump_decides_nothing(omega: str, half_periods: int) -> None:
    """Within a run both limits count, at the end of a motion the one before: no jump has come."""
    force = pc.square_wave(omega)
    osc = pc.Oscillator(1, "0.1", [pc.Wall(100, "above", 0)])
    one = pc.Structure(mass=[1], stiffness=[1], damping=["0.2"])
    assert force.period is not None
    jump, short = half_periods * force.period / 2, 2.0**-10
    longer = pc.simulate(osc, force, t_end=jump + 1.0)
    same = pc.simulate(one, pc.Loads({0: force}), x0=[0], v0=[0], t_end=jump + 1.0)
    ended = pc.simulate(osc, force, t_end=jump)
    x, v = longer(jump)
    limits = [abs(side - x - 0.2 * v) for side in (1.0, -1.0)]
    before = limits[(half_periods - 1) % 2]
    near = pytest.approx(float(max(limits)), abs=float(0.1 * abs(limits[0] - limits[1]) + 2e-3))

    for window in ((jump - short, jump), (jump, jump + short)):
        for peak in (
            longer.extremes("acceleration", between=window).peak,
            same.extremes("acceleration", on=0, between=window).peak,
        ):
            assert peak == near
    window = jump - short, jump
    at_end = ended.extremes("acceleration", between=window).peak
    assert at_end == pytest.approx(before, abs=2e-2)
    for found in (
        pc.sweep("peak_acceleration", osc, force, over={}, between=window),
        pc.sweep("peak_acceleration", one, pc.Loads({0: force}), over={}, between=window, on=0),
    ):
        assert float(found.peak_acceleration) == pytest.approx(at_end, rel=1e-9)


@pytest.mark.parametrize("half_periods", [1, 2, 3, 5, 6, 15, 40, 41])
@pytest.mark.parametrize("omega", ["1", "1.3", "0.7", "3.7"])
def test_the_force_of_a_wall_has_both_limits_where_a_window_ends_at_a_jump(
    omega: str, half_periods: int
) -> None:
    """A knot while the mass is held is no event of the run."""
    force = pc.square_wave(omega, amplitude="0.3") + pc.Forcing(constant=-1)
    osc = pc.Oscillator(1, "0.1", [pc.Wall(0, "below", 0)])
    assert force.period is not None
    jump, short = half_periods * force.period / 2, 2.0**-10
    run = pc.simulate(osc, force, t_end=jump + 1.0)
    assert len(run.contacts) == 1

    for window in ((jump - short, jump), (jump, jump + short)):
        found = run.extremes("stop_force", between=window)
        assert (found.minimum, found.maximum) == pytest.approx((0.7, 1.3), rel=1e-12)
    ended = pc.simulate(osc, force, t_end=jump).extremes("stop_force", between=(jump - short, jump))
    before = 0.7 if half_periods % 2 == 1 else 1.3
    assert (ended.minimum, ended.maximum) == pytest.approx((before, before), rel=1e-12)


@pytest.mark.parametrize(("restitution", "omega"), [("0.1", "0.4"), ("0.3", "0.9"), ("0.7", "0.4")])
def test_the_end_of_a_chatter_has_the_acceleration_of_the_free_structure(
    restitution: str, omega: str
) -> None:
    """In the mean the wall holds it there; the oscillator's peak was greater by 1e-7 of it."""
    force = pc.cosine(omega, amplitude="0.5") + pc.Forcing(constant="-0.3")
    osc = pc.Oscillator(1, "0.05", [pc.Wall(0, "below", restitution)])
    walls = [pc.Wall(0, "below", restitution, on=0)]
    one = pc.Structure(mass=[1], stiffness=[1], damping=["0.1"], stops=walls)
    run = pc.simulate(osc, force, x0="0.2", t_end=80.0)
    same = pc.simulate(one, pc.Loads({0: force}), x0=["0.2"], v0=[0], t_end=80.0)
    assert len(run.contacts) == len(same.contacts) > 3

    found = run.extremes("acceleration", between=(30.0, 80.0))
    also = same.extremes("acceleration", on=0, between=(30.0, 80.0))

    assert (also.minimum, also.maximum) == pytest.approx((found.minimum, found.maximum), rel=1e-11)


@pytest.mark.parametrize("since", [0, 1, 7])
def test_a_wall_that_holds_for_good_bears_the_same_in_every_period(since: int) -> None:
    """0.2 - 0.1 cos(2 t + 2), whenever the contact has begun: in a sweep and in a run."""
    stops = pc.Wall(-1, "below", "0.8"), pc.Wall("-0.2", "above", 0)
    osc = pc.Oscillator(damping=1, stops=stops)
    force = pc.cosine(2, amplitude="0.1", phase=2)
    start = -0.2, 0.0
    run = pc.simulate(osc, force, start=start, periods=since + 1)
    window = since * math.pi, run.t_end

    swept = pc.sweep(
        "peak_stop_force", osc, force, over={}, start=start, transient=since, periods=1
    )
    held = run.extremes("stop_force", stop=1, between=window)

    assert run.outcome.name == "at_rest"
    assert float(swept.peak_stop_force) == pytest.approx(0.3, rel=1e-15)
    assert (-held.minimum, -held.maximum) == pytest.approx((0.3, 0.1), rel=1e-14)
