from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.batch import BatchResult, Plan, drift_of
from percuss.model.exact import as_float


def reference(omega: str) -> tuple[pc.Oscillator, pc.Forcing]:
    return pc.impact_oscillator(restitution="0.8", side="above"), pc.cosine(omega)


def test_a_stable_orbit_has_the_exponents_of_its_multipliers() -> None:
    """Reference case lyap-stable-w2.5: (omega / 2 pi) ln r, to 1e-8."""
    exponents = pc.lyapunov_exponents(*reference("2.5"), start=(0.0, -1.0))

    expected = 2.5 / (2 * math.pi) * math.log(0.8)
    np.testing.assert_allclose(exponents.exponents, expected, rtol=0, atol=1e-12)
    assert expected == pytest.approx(-0.088785998026841200854, abs=1e-15)
    # A round is one impact a period.
    assert exponents.impact_rate == pytest.approx(2.5 / (2 * math.pi), rel=1e-9)


def test_chaos_has_the_exponents_of_the_reference() -> None:
    """Reference case lyap-chaos-w2.8-s0.0; its tolerance is four of its standard errors."""
    exponents = pc.lyapunov_exponents(*reference("2.8"), start=(0.0, -1.0), periods=200_000)

    error = 4.0 * exponents.errors[0] + 0.00057
    assert exponents.errors[0] < 0.001
    np.testing.assert_allclose(exponents.exponents, [0.14192, -0.35221], rtol=0, atol=error)
    assert exponents.impact_rate == pytest.approx(0.4712, abs=0.0005)


@pytest.mark.parametrize("damping", [0.0, 0.03])
def test_the_sum_rule_holds(damping: float) -> None:
    """The sum is -2 a and 2 ln r an impact, where nothing but one wall is met."""
    osc = pc.impact_oscillator(restitution=0.8, damping=damping)

    exponents = pc.lyapunov_exponents(osc, pc.cosine(2.8), start=(0.0, 1.0))

    expected = -2.0 * damping + 2.0 * exponents.impact_rate * math.log(0.8)
    assert exponents.total == pytest.approx(expected, rel=1e-9)
    assert exponents.exponents.sum() == pytest.approx(exponents.total, rel=1e-9)


@pytest.mark.parametrize(("transient", "periods"), [(20_000, 64), (20_000, 66), (1000, 2000)])
def test_on_a_long_orbit_impacts_and_exponents_are_of_the_same_periods(
    transient: int, periods: int
) -> None:
    """An orbit with six impacts in six periods: 64 periods are no whole number of rounds."""
    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.6")

    exponents = pc.lyapunov_exponents(
        osc, force, start=(0.5, 0), transient=transient, periods=periods
    )

    expected = 2.0 * 2.6 / (2.0 * math.pi) * math.log(0.8)
    assert exponents.total == pytest.approx(expected, rel=1e-12)
    assert exponents.exponents.sum() == pytest.approx(exponents.total, rel=1e-12)
    assert 2.0 * exponents.impact_rate * math.log(0.8) == pytest.approx(exponents.total, rel=1e-12)
    assert exponents.impact_rate * exponents.duration == pytest.approx(18.0, rel=1e-12)


def test_the_errors_cover_what_a_slow_approach_to_an_orbit_still_goes() -> None:
    """A neighbour of that orbit comes nearer by 3 % a round only."""
    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.6")
    there = pc.lyapunov_exponents(osc, force, start=(0.5, 0), transient=20_000, periods=64)

    exponents = pc.lyapunov_exponents(osc, force, start=(0.5, 0), transient=1200, periods=64)

    off = np.abs(exponents.exponents - there.exponents)
    assert (off > 1e-6).all()
    assert (off < 1.5 * exponents.errors).all()
    assert (exponents.errors < 3.0 * off).all()
    assert there.errors.max() < 1e-12


def test_halves_that_differ_by_more_than_chance_are_an_error() -> None:
    """Means of blocks that go down evenly, and ones that scatter."""
    trend = np.linspace(1.0, 0.0, 64)
    scatter = np.random.default_rng(1).normal(size=64)
    points = np.full((2, 65, 3), np.nan)
    for row, rates in enumerate((trend, scatter)):
        points[row, :, 0] = np.concatenate([[0.0], np.cumsum(rates)])
    empty = np.zeros(2)
    batch = BatchResult(empty.astype(int), empty, empty.astype(int), empty, points)

    drift = drift_of(batch, Plan(empty, np.ones(2), np.full(2, 64.0)))

    assert drift[0] == pytest.approx(trend[:32].mean() - trend[32:].mean())
    assert drift[1] == 0.0


def test_soft_stops_are_passed_through() -> None:
    """Both exponents of an orbit, from the derivative of two periods by central differences."""
    soft = (pc.SoftStop(0.5, "above", 29.0, 0.3), pc.Wall(-1.0, "below", 0.7))
    osc, force = pc.Oscillator(1.0, 0.02, soft), pc.cosine(2.0)
    exponents = pc.lyapunov_exponents(osc, force, start=(0.0, 1.0))
    period = float(force.period or math.nan)
    strobes = pc.simulate(osc, force, v0=1.0, t_end=400.5 * period).stroboscopic()
    x, v = float(strobes.x[400]), float(strobes.v[400])
    step, columns = 1e-6, []
    for dx, dv in ((step, 0.0), (0.0, step)):
        ends = []
        for sign in (1.0, -1.0):
            run = pc.simulate(osc, force, x + sign * dx, v + sign * dv, t_end=1.01 * period)
            ends.append(np.array([float(part) for part in run(period)]))
        columns.append((ends[0] - ends[1]) / (2 * step))

    multipliers = np.linalg.eigvals(np.stack(columns, axis=1))

    expected = np.sort(np.log(np.abs(multipliers)))[::-1] / period
    np.testing.assert_allclose(exponents.exponents, expected, rtol=0, atol=1e-6)
    assert exponents.errors.max() < 1e-9


def test_after_sticking_both_are_minus_infinity() -> None:
    osc, force = pc.impact_oscillator(0.3), pc.cosine(2.7, constant=-0.8)
    assert len(pc.simulate(osc, force, v0=1.0, t_end=20.0).contacts) > 0

    exponents = pc.lyapunov_exponents(osc, force, start=(0.0, 1.0), transient=10, periods=100)

    assert np.isneginf(exponents.exponents).all()
    assert exponents.errors.tolist() == [0.0, 0.0]


def test_a_free_oscillator_has_its_damping_twice() -> None:
    exponents = pc.lyapunov_exponents(pc.Oscillator(1.0, 0.1), pc.cosine(2.0))

    np.testing.assert_allclose(exponents.exponents, -0.1, rtol=0, atol=1e-12)
    overdamped = pc.lyapunov_exponents(pc.Oscillator(1.0, 1.25), pc.cosine(2.0))
    np.testing.assert_allclose(overdamped.exponents, [-0.5, -2.0], rtol=0, atol=1e-9)


def test_the_measure_is_that_of_one_motion() -> None:
    osc, force = reference("2.8")

    data = pc.sweep(
        "largest_lyapunov_exponent",
        osc,
        force,
        over={"forcing.omega": ["2.5", "2.8"]},
        start=(0.0, -1.0),
        transient=1000,
        periods=20_000,
    )

    one = pc.lyapunov_exponents(osc, force, start=(0.0, -1.0))
    assert data.largest_lyapunov_exponent.values[1] == one.exponents[0]
    # In a finite time, by what a direction gains once.
    assert data.largest_lyapunov_exponent.values[0] == pytest.approx(-0.0887860, abs=1e-4)


def test_what_is_wrong_with_a_call_is_said() -> None:
    osc, force = reference("2.5")
    with pytest.raises(pc.ParameterError, match="use a SoftStop"):
        pc.lyapunov_exponents(osc, force, start=(1.0, 0.0))
    with pytest.raises(pc.ParameterError, match="at least 64"):
        pc.lyapunov_exponents(osc, force, periods=3)


def test_as_many_impacts_as_the_periods_need_are_followed() -> None:
    osc, force = pc.impact_oscillator(restitution=0.8), pc.cosine(2.8)

    exponents = pc.lyapunov_exponents(osc, force, start=(0.0, 1.0), transient=0, periods=1_500_000)

    # More than the million after which a motion of a sweep is given up.
    assert exponents.impact_rate * exponents.duration > 1_000_000


def test_a_limit_of_impacts_is_blamed_by_its_name_with_how_far_it_came() -> None:
    osc, force = pc.impact_oscillator(restitution=0.8), pc.cosine(2.8)

    with pytest.raises(
        pc.ParameterError,
        match=r"^max_impacts = 500: as many impacts come until t = .*; allow more",
    ):
        pc.lyapunov_exponents(osc, force, start=(0.0, 1.0), max_impacts=500)


def test_a_force_of_two_frequencies_has_exponents_whose_sum_is_that_of_the_rule() -> None:
    """Neither the sum rule nor the tangent needs a period; time counts in 2 pi / sqrt(k)."""
    osc = pc.impact_oscillator(restitution=0.8, stiffness=4.0, damping=0.02)
    force = pc.cosine(2.8) + pc.cosine(math.sqrt(3.0), amplitude=0.5)
    assert force.period is None

    exponents = pc.lyapunov_exponents(osc, force, start=(0.0, 1.0), transient=100, periods=2000)

    assert exponents.duration == pytest.approx(2000 * math.pi)
    expected = -2.0 * 0.02 + 2.0 * exponents.impact_rate * math.log(0.8)
    assert exponents.total == pytest.approx(expected, rel=1e-9)
    assert exponents.exponents.sum() == pytest.approx(exponents.total, rel=1e-9)


def test_a_free_motion_has_the_exponents_of_its_losses() -> None:
    """At rest the oscillator forgets at the rate of its damping in either direction."""
    exponents = pc.lyapunov_exponents(
        pc.Oscillator(stiffness=1.0, damping=0.1), None, start=(1.0, 0.0)
    )

    np.testing.assert_allclose(exponents.exponents, -0.1, rtol=1e-3)
    assert exponents.total == pytest.approx(-0.2, rel=1e-9)
    with pytest.raises(pc.ParameterError, match="without a harmonic and without a stiffness"):
        pc.lyapunov_exponents(pc.Oscillator(stiffness=0.0), None)


@pytest.mark.parametrize(("phase", "v0"), [(1.5, 0.0), (2.0, 0.0), (2.0, 0.05)])
def test_a_contact_in_the_transient_is_no_part_of_the_exponents(phase: float, v0: float) -> None:
    """The mass sticks once, at the start or after a few hops, on its way to an orbit that does not."""
    osc, force = pc.impact_oscillator(0.8), pc.cosine(2.5, phase=phase)
    run = pc.simulate(osc, force, v0=v0, periods=100)
    rates = pc.lyapunov_exponents(osc, force, start=(0.0, v0), transient=200, periods=64)
    swept = pc.sweep("largest_lyapunov_exponent", osc, force, over={}, start=(0.0, v0))
    one = pc.Structure([1], [1], stops=[pc.Wall(0, "below", 0.8, on=0)])
    same = pc.lyapunov_exponents(
        one, pc.Loads({0: force}), start=([0], [v0]), transient=200, periods=64
    )

    assert len(run.contacts) == 1
    np.testing.assert_allclose(same.exponents, rates.exponents, rtol=0, atol=1e-10)
    assert same.total == pytest.approx(rates.total, abs=1e-10)
    expected = 2.5 / (2 * math.pi) * math.log(0.8)
    np.testing.assert_allclose(rates.exponents, expected, rtol=0, atol=1e-10)
    assert float(swept.largest_lyapunov_exponent) == pytest.approx(expected, abs=0.01)


def test_a_wall_that_holds_from_the_start_on_leaves_no_memory() -> None:
    osc = pc.impact_oscillator(0.8, wall=-0.3, side="above", damping=0.05)

    rates = pc.lyapunov_exponents(osc, pc.cosine(3, amplitude=0.1), start=(-0.3, 0.0), periods=64)

    assert rates.exponents.tolist() == [-math.inf, -math.inf]
    assert rates.total == -math.inf


@pytest.mark.parametrize(
    ("osc", "force", "start"),
    [
        (pc.impact_oscillator(), None, (0.1, 1.0)),
        (pc.impact_oscillator(), pc.sine(3), (0.0, 0.55)),
        (pc.Oscillator(stops=[pc.SoftStop(9, "above", 3)]), pc.cosine("1.7"), (0.1, 1.0)),
        (pc.Oscillator(1, 1, [pc.SoftStop(9, "above", 3)]), pc.cosine("1.7"), (0.1, 1.0)),
    ],
    ids=["free", "identity", "elliptic", "critical damping"],
)
def test_the_errors_of_exponents_hold_their_rounding(
    osc: pc.Oscillator, force: pc.Forcing | None, start: tuple[float, float]
) -> None:
    """Zeros were told as 1.5e-18 with an error of 6.9e-21, and the smaller one of two first."""
    true = -as_float(osc.damping)
    stops = [dataclasses.replace(stop, on=0) for stop in osc.stops]
    one = pc.Structure([1], [1], [2 * true * -1], stops)
    loads = None if force is None else pc.Loads({0: force})
    at_rest = [start[0]], [start[1]]

    for found in (
        pc.lyapunov_exponents(osc, force, start=start, transient=10, periods=640),
        pc.lyapunov_exponents(one, loads, start=at_rest, transient=10, periods=640),
    ):
        assert (np.abs(found.exponents - true) <= found.errors).all()
        assert (found.errors > 0.0).all()
        assert (found.errors < 1e-6).all()
        assert found.exponents[0] >= found.exponents[1]


@pytest.mark.parametrize("phase", [1.5, 0.8])
def test_a_contact_in_the_transient_leaves_perturbations_that_are_turned(phase: float) -> None:
    """Under a force without a period the exponents are means: they began with any direction."""
    tone = pc.cosine(pc.expression("sqrt(2)"), amplitude="0.0001")
    force = pc.cosine("2.653", phase=phase) + tone
    one = pc.Structure([1], [1], stops=[pc.Wall(0, "below", "0.3", on=0)])
    loads, later = pc.Loads({0: force}), 200 * math.pi
    run = pc.simulate(one, loads, x0=[0], v0=[0], t_end=later)
    x, v = run(later)
    assert len(run.contacts) == 1

    stuck = pc.lyapunov_exponents(one, loads, start=([0], [0]), transient=160, periods=64)

    begun = pc.StructureStart(x.tolist(), v.tolist(), later)
    free = pc.lyapunov_exponents(one, loads, start=begun, transient=60, periods=64)
    osc = pc.impact_oscillator("0.3")
    same = pc.lyapunov_exponents(osc, force, start=(0, 0), transient=160, periods=64)
    np.testing.assert_allclose(stuck.exponents, free.exponents, rtol=0, atol=1e-11)
    np.testing.assert_allclose(stuck.exponents, same.exponents, rtol=0, atol=1e-11)
    assert stuck.total == pytest.approx(free.total, abs=1e-11)


@pytest.mark.parametrize(
    ("damping", "exponents"),
    [
        ("0", (0.0, 0.0)), ("0.1", (-0.1, -0.1)), ("1", (-1.0, -1.0)),
        ("3", (-0.171572875253809902, -5.828427124746190)),
    ],
    ids=["undamped", "damped", "critical", "overdamped"],
)  # fmt: skip
def test_a_flight_of_a_billion_oscillations_is_one_step(
    damping: str, exponents: tuple[float, float]
) -> None:
    """It was as many steps as 200 radians have room in it: hours, and at critical damping no end."""
    osc = pc.impact_oscillator("0.8", wall=5, side="above", damping=damping)

    found = pc.lyapunov_exponents(osc, pc.cosine("1e-9"), start=(0.1, 1.0), transient=0, periods=64)

    # Where both are one, what begins in one direction has a share t in the other.
    np.testing.assert_allclose(found.exponents, exponents, rtol=0, atol=1e-9)
    assert found.total == pytest.approx(sum(exponents), rel=1e-12)


@pytest.mark.parametrize("omega", ["0.01", "1e-9"])
@pytest.mark.parametrize(
    ("damping", "exponents"),
    [
        (0, (0.0,) * 4),
        ("0.2", (-0.1,) * 4),
        (2, (-1.0,) * 4),
        (6, (-0.171572875, -0.550510257, -5.449489743, -5.828427125)),
    ],
    ids=["undamped", "damped", "critical", "overdamped"],
)
def test_a_structure_is_carried_over_a_billion_oscillations_at_once(
    damping: int | str, exponents: tuple[float, ...], omega: str
) -> None:
    """It has K = 1 and 3; multipliers of a long period were rounding, or zero, and so -inf."""
    structure = pc.Structure([[1, 0], [0, 1]], [[2, -1], [-1, 2]], [[damping, 0], [0, damping]])
    start = ([0.1, 0.2], [1.0, -0.3])

    found = pc.lyapunov_exponents(
        structure, pc.Loads({0: pc.cosine(omega)}), start=start, transient=0, periods=64
    )

    # What begins in one direction has a share in the others, at critical damping t times as large.
    near = (2.0 + math.log(found.duration)) / found.duration + 1e-9
    np.testing.assert_allclose(found.exponents, exponents, rtol=0, atol=near)
    assert found.total == pytest.approx(sum(exponents), rel=1e-9)
