"""The pattern that impact times repeat or settle to: the smallest, and no other."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import pytest
from numpy.typing import NDArray

import percuss as pc
from percuss.motion.patterns import find_pattern

WALL = pc.impact_oscillator(0.8)
FREQUENCIES = [round(2.05 + 0.01 * k, 2) for k in range(58)]
# Started at v0 = 0.3 these come to another stable orbit than (1, 1), which is stable there too.
OTHERS = {2.56: (3, 3), 2.57: (3, 3), 2.58: (3, 3), 2.59: (3, 3), 2.6: (6, 6)}


def found_after(omega: float, periods: int) -> pc.ImpactTimes:
    force = pc.cosine(omega)
    return pc.classify_impact_times(pc.simulate(WALL, force, v0=0.3, periods=periods))


@pytest.mark.parametrize("periods", [50, 100, 150, 200, 300])
def test_plain_motions_have_their_pattern_from_fifty_periods_on(periods: int) -> None:
    for omega in FREQUENCIES:
        answer = found_after(omega, periods)
        if omega in OTHERS:
            assert (answer.n_impacts, answer.n_periods) in (OTHERS[omega], (0, 0)), omega
            continue
        assert (answer.n_impacts, answer.n_periods) == (1, 1), omega
        assert answer.kind in ("periodic", "settling"), omega
        if periods > 150:
            assert answer.kind == "periodic", omega


@pytest.mark.parametrize("omega", OTHERS)
def test_the_other_frequencies_of_the_table_have_another_orbit(omega: float) -> None:
    run = pc.simulate(WALL, pc.cosine(omega), v0=0.3, periods=3000)
    period = 2.0 * math.pi / omega
    n = OTHERS[omega][1]
    x, v = run((3000 - np.arange(1.0, 14.0)) * period)

    np.testing.assert_allclose(x[n:], x[:-n], rtol=0, atol=1e-9)
    assert np.abs(v[n // 3 :] - v[: -(n // 3)]).max() > 1e-3
    answer = pc.classify_impact_times(run)
    assert (answer.kind, answer.n_impacts, answer.n_periods) == ("periodic", *OTHERS[omega])


def test_a_settling_motion_is_named_with_the_rate_of_its_orbit() -> None:
    for omega in (2.05, 2.3, 2.5):
        answer = found_after(omega, 40)
        orbit = pc.find_orbit(WALL, pc.cosine(omega))
        rate = -math.log(abs(orbit.multipliers[0])) / orbit.period
        assert answer.kind == "settling"
        assert answer.rate == pytest.approx(rate, rel=0.05)
        assert math.isnan(found_after(omega, 300).rate)


def test_a_slow_motion_is_named_as_it_settles() -> None:
    osc = pc.Oscillator(1, 0, (pc.Wall(-0.30417989318508254, "below", 0.9),))
    force = pc.fourier(2.843608325149707, cos=(1, 0.4), sin=(0, 0, 0.3))
    kinds = {}
    for periods in (50, 200, 800):
        run = pc.simulate(osc, force, x0=0.01, v0=0.3, periods=periods)
        answer = pc.classify_impact_times(run)
        kinds[periods] = answer.kind, answer.n_impacts, answer.n_periods

    assert kinds[50][0] == "no_period_found"
    assert kinds[200] == ("settling", 3, 6)
    assert kinds[800] == ("periodic", 3, 6)


def settling(
    multipliers: tuple[complex, ...], count: int, size: float = 0.1
) -> NDArray[np.float64]:
    """Return times of one impact a period, off by a sum of powers of multipliers."""
    k = np.arange(float(count))
    off = sum(np.real(z**k) for z in map(complex, multipliers))
    return np.asarray(k + 1.0 + size * off / len(multipliers))


@pytest.mark.parametrize(
    "multipliers",
    [(-0.95,), (0.9,), (-0.9, 0.3), (0.95 * np.exp(0.3j),), (0.9 * np.exp(2.1j),), (0.93j,)],
)
def test_no_multiple_is_named_however_the_deviation_turns(multipliers: tuple[complex, ...]) -> None:
    for count in (60, 120, 250, 1000):
        answer = find_pattern(settling(multipliers, count), 1.0, is_dissipative=True)
        assert answer is not None
        assert (answer.n_impacts, answer.n_periods) == (1, 1)
        if answer.is_settling:
            assert answer.rate == pytest.approx(-math.log(abs(multipliers[0])), rel=0.05)


def test_deviations_that_tend_to_constants_are_a_longer_pattern() -> None:
    k = np.arange(300.0)
    late = k + (0.01 + 0.2 * 0.9**k) * (-1.0) ** k

    for count in (40, 60, 100, 300):
        answer = find_pattern(late[:count], 1.0, is_dissipative=True)
        assert answer is None or (answer.n_impacts, answer.n_periods) == (2, 2)
    assert answer is not None


def test_deviations_that_fall_by_a_power_of_the_time_settle_to_nothing_yet() -> None:
    """At a period doubling: the pattern and its double cannot be told apart."""
    k = np.arange(400.0)
    times = k + 0.2 * (-1.0) ** k / np.sqrt(1.0 + k)

    assert find_pattern(times, 1.0, is_dissipative=True) is None


def test_impacts_very_near_in_time_are_one_pattern() -> None:
    k = np.arange(80.0)
    first = k + 0.05 * 0.85**k
    times = np.stack([first, first + 1e-4 * (1.0 + 0.2 * 0.8**k)], axis=1).ravel()

    answer = find_pattern(times, 1.0, is_dissipative=True)
    assert answer is not None
    assert (answer.n_impacts, answer.n_periods) == (2, 1)


@pytest.mark.parametrize("start", [0.0, 1e4, 1e7])
def test_times_that_repeat_to_their_rounding_are_periodic(start: float) -> None:
    random = np.random.default_rng(0)
    k = np.arange(2000.0)
    times = start + k * math.pi
    times += random.uniform(-2.0, 2.0, len(k)) * np.spacing(times.max())

    for is_dissipative in (True, False):
        answer = find_pattern(times, math.pi, is_dissipative=is_dissipative)
        assert answer is not None
        assert not answer.is_settling
        assert (answer.n_impacts, answer.n_periods, answer.n_used) == (1, 1, 2000)


def test_without_losses_what_does_not_repeat_has_no_pattern() -> None:
    """An elliptic orbit: neighbours turn about it for ever, ever so near."""
    osc, force = pc.impact_oscillator(), pc.sine("2.3")
    orbit = pc.find_orbit(osc, force)
    assert orbit.stability == "elliptic"
    for off in (1e-6, 1e-3, 0.05):
        for periods in (50, 300, 2000):
            run = pc.simulate(osc, force, orbit.x0, orbit.v0 + off, orbit.t0, periods=periods)
            assert pc.classify_impact_times(run).kind == "no_period_found"
    run = pc.simulate(osc, force, orbit.x0, orbit.v0, orbit.t0, periods=2000)
    assert pc.classify_impact_times(run).kind == "periodic"


def test_chaotic_times_have_no_pattern() -> None:
    osc = pc.impact_oscillator("0.8", side="above")
    for periods in (30, 50, 100, 400, 2000):
        run = pc.simulate(osc, pc.cosine("2.8"), v0=0.5, x0=-0.2, periods=periods)
        assert pc.classify_impact_times(run).kind == "no_period_found"


def test_without_a_forcing_period_the_intervals_are_compared() -> None:
    k = np.arange(60.0)
    answer = pc.classify_impact_times(
        1.3 * k + 0.1 * (-0.9) ** k, pc.impact_oscillator(0.8, wall=1)
    )

    assert (answer.kind, answer.n_impacts, answer.n_periods) == ("settling", 1, 0)


def random_system(random: np.random.Generator) -> tuple[pc.Oscillator, pc.Forcing, float, float]:
    restitution = float(random.uniform(0.3, 0.97))
    at, gap = float(random.uniform(-0.8, 0.8)), float(random.uniform(0.05, 0.8))
    stiff = float(random.uniform(5.0, 200.0))
    stops = (
        (pc.Wall(at, "below", restitution),),
        (pc.Wall(-gap, "below", restitution), pc.Wall(gap, "above", restitution)),
        (pc.SoftStop(at, "below", stiff, float(random.uniform(0.05, 1.0))),),
        (pc.SoftStop(0.3, "above", stiff, 0.2), pc.Wall(-gap, "below", restitution)),
    )[random.integers(4)]
    omega = float(random.uniform(0.6, 4.0))
    parts = float(random.uniform(-0.6, 0.6)), float(random.uniform(-0.4, 0.4))
    force = pc.fourier(omega, cos=(1, parts[0]), sin=(0, 0, parts[1]))
    if random.random() < 0.6:
        force = pc.cosine(omega)
    osc = pc.Oscillator(1.0, float(random.choice([0.0, 0.01, 0.05])), stops)
    x0 = at if osc.stops[0].at == at else 0.0
    return osc, force, x0, float(random.uniform(0.0, 1.0))


def stable_motions(seed: int) -> Iterator[tuple[pc.Trajectory, int, int]]:
    """Yield long runs with the counts of their end, from the state at whole periods alone."""
    random = np.random.default_rng(seed)
    while True:
        osc, force, x0, v0 = random_system(random)
        period = force.period
        assert period is not None
        run = pc.simulate(osc, force, x0, v0, periods=3000, max_impacts=60_000)
        if run.t_end < 2999.0 * period or len(run.contacts):
            continue
        ends = (np.arange(2952, 3000) + 0.3713) * period
        x, v = run(ends)
        distance = [
            max(np.abs(x[n:] - x[:-n]).max(), np.abs(v[n:] - v[:-n]).max()) for n in range(1, 7)
        ]
        repeating = [n for n in range(1, 7) if distance[n - 1] < 1e-9]
        if not repeating:
            continue
        n = repeating[0]
        # Whole periods that all but repeat would leave it open which is the orbit.
        if any(distance[k - 1] < 1e-4 for k in range(1, n)):
            continue
        times = times_of(run)
        m = int(((times >= ends[0]) & (times < ends[n])).sum())
        if 1 <= m <= 6:
            yield run, m, n


def times_of(run: pc.Trajectory) -> NDArray[np.float64]:
    if len(run.impacts):
        return run.impacts.t
    return np.asarray(run.crossings.t[run.crossings.direction == "in"])


def check_stable_motions(seed: int, count: int) -> None:
    """Every answer is the pattern or none, at any length; after 3000 periods it is the pattern."""
    for _, (run, *pattern) in zip(range(count), stable_motions(seed), strict=False):
        osc, force, times = run.oscillator, run.forcing, times_of(run)
        assert force is not None
        assert force.period is not None
        for periods in (30, 50, 75, 100, 200, 400, 800, 3000):
            first = times[times <= periods * force.period]
            answer = pc.classify_impact_times(first, osc, force)
            if answer.n_impacts or periods == 3000:
                assert [answer.n_impacts, answer.n_periods] == pattern, (osc, force, periods)


def test_stable_motions_at_random_have_no_wrong_pattern() -> None:
    check_stable_motions(1, 50)


@pytest.mark.nightly
@pytest.mark.parametrize("seed", [2, 3, 4])
def test_two_hundred_stable_motions_at_random_have_no_wrong_pattern(seed: int) -> None:
    check_stable_motions(seed, 200)
