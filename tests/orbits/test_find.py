from __future__ import annotations

import functools
import math
import pickle

import numpy as np
import pytest

import percuss as pc
from percuss.kernels.law_columns import DAMPING
from percuss.model.system import System
from percuss.orbits import single_impact_orbits
from percuss.orbits.orbit.itinerary import Itinerary, events_of_stops
from percuss.orbits.orbit.solve import solve

COCO = pc.impact_oscillator(0.8, wall=1.0, side="above", damping=0.05)
ABOVE = pc.impact_oscillator("0.8", side="above")
ELASTIC = pc.impact_oscillator()
SOFT = pc.backlash_oscillator(1.0, 100.0, damping=0.05, stop_damping=0.3)

SYSTEMS = {
    "one wall": (ABOVE, pc.cosine("2.8")),
    "period doubled": (ABOVE, pc.cosine("2.66")),
    "hysteresis": (
        pc.impact_oscillator("0.7", wall="1.45789", side="above", damping="0.05"),
        pc.cosine("1.5"),
    ),
    "elastic": (ELASTIC, pc.sine(3)),
    "two walls": (
        pc.Oscillator(
            1.0, "0.02", (pc.Wall("0.1", "above", "0.7"), pc.Wall("-0.1", "below", "0.7"))
        ),
        pc.cosine(2),
    ),
    "gear with backlash": (SOFT, pc.cosine(1.3)),
    "soft stop before a wall": (
        pc.Oscillator(1.0, 0.05, (pc.SoftStop(0.2, "above", 5.0, 0.1), pc.Wall(0.3, "above", 0.8))),
        pc.cosine(1.0),
    ),
    "bilinear, three harmonics": (
        pc.bilinear_oscillator(stiffness_below=9.0, damping=0.05),
        pc.fourier(1.6, cos=(1.0, 0.4), sin=(0.0, 0.0, 0.3), constant=0.2),
    ),
    "ball": pc.ball_on_table(amplitude="1.2", omega=1, gravity=1, restitution="0.5"),
}
each_system = pytest.mark.parametrize("name", SYSTEMS)


@functools.cache
def orbits_of(name: str) -> list[pc.PeriodicOrbit]:
    """Return what is found for a system, formal orbits too."""
    return pc.find_orbits(*SYSTEMS[name], max_impacts=3, max_periods=3, formal=True)


@each_system
def test_some_orbit_is_found_and_each_once(name: str) -> None:
    found = orbits_of(name)

    assert any(orbit.n_impacts > 0 and orbit.admissible for orbit in found)
    keys = [
        (
            o.n_periods,
            *np.round(np.sort(o.impacts.cycle), 5),
            *np.round(np.sort(o.impacts.v_after), 5),
            *np.round(o.multipliers, 5),
        )
        for o in found
    ]
    assert len(set(keys)) == len(keys)


@each_system
def test_determinant_is_what_impacts_and_dashpots_leave_of_an_area(name: str) -> None:
    osc, force = SYSTEMS[name]
    table = System(osc, force).law
    restitutions = np.array([float(getattr(stop, "restitution", 1)) for stop in osc.stops])
    for orbit in orbits_of(name):
        if math.isinf(orbit.n_impacts):
            continue
        run = orbit.trajectory()
        lasting = np.diff(np.append(run._events[:, 0], run.t_end))
        decay = float(table[run._marks[:, 2], DAMPING] @ lasting)
        kept = float(np.prod(restitutions[orbit.impacts.stop] ** 2)) * math.exp(-2.0 * decay)
        error = abs(np.linalg.det(orbit.monodromy) - kept)
        assert error <= 1e-10 * (orbit.monodromy**2).sum()
        assert np.prod(orbit.multipliers) == pytest.approx(kept, rel=1e-12)


@each_system
def test_multipliers_agree_with_central_differences_of_the_map(name: str) -> None:
    osc, force = SYSTEMS[name]
    h = 1e-6
    for orbit in orbits_of(name):
        in_flight = orbit.t0 + 0.37 * orbit.impacts.intervals[1 % max(len(orbit.impacts), 1) :][:1]
        if not orbit.admissible or len(in_flight) == 0 or math.isinf(orbit.n_impacts):
            continue
        t = float(in_flight[0])
        x, v = (float(part) for part in orbit.trajectory()(t))
        ends = [
            np.array(
                pc.simulate(osc, force, x + a, v + b, t, t_end=t + orbit.period)(t + orbit.period)
            )
            for a, b in ((h, 0.0), (-h, 0.0), (0.0, h), (0.0, -h))
        ]
        matrix = np.array([ends[0] - ends[1], ends[2] - ends[3]]).T / (2.0 * h)
        size = float((orbit.monodromy**2).sum())
        if not orbit.isolated or size > 1e4:
            continue
        # Second derivatives grow as the square of the first.
        assert np.trace(matrix) == pytest.approx(np.trace(orbit.monodromy), abs=1e-7 * (1.0 + size))


@each_system
def test_a_motion_that_starts_on_an_admissible_orbit_stays_on_it(name: str) -> None:
    osc, force = SYSTEMS[name]
    for orbit in orbits_of(name):
        if not orbit.admissible or orbit.n_impacts == 0:
            continue
        run = pc.simulate(
            osc, force, orbit.x0, orbit.v0, orbit.t0, t_end=orbit.t0 + 1.0001 * orbit.period
        )
        walls = np.array([isinstance(osc.stops[k], pc.Wall) for k in orbit.impacts.stop])
        growth = 1e-12 * (1.0 + float((orbit.monodromy**2).sum()))
        n = int(walls.sum())
        expected = np.sort(np.append(orbit.impacts.t[walls][1:], orbit.impacts.t[0] + orbit.period))
        if walls.all() and not math.isinf(orbit.n_impacts):
            assert len(run.impacts) == n
            np.testing.assert_allclose(run.impacts.t, expected, rtol=0, atol=growth)
        end = orbit.t0 + orbit.period
        x, _ = run(end)
        assert x == pytest.approx(orbit.x0, abs=growth)


@each_system
def test_margin_is_negative_exactly_where_an_orbit_passes_through_a_stop(name: str) -> None:
    osc, _ = SYSTEMS[name]
    for orbit in orbits_of(name):
        assert orbit.admissible == (orbit.grazing_margin >= 0.0) == (len(orbit.passages) == 0)
        if orbit.admissible:
            continue
        deepest = int(orbit.passages.depth.argmax())
        assert orbit.passages.depth[deepest] == -orbit.grazing_margin
        x, v = orbit.trajectory()(orbit.passages.t[deepest])
        stop = osc.stops[orbit.passages.stop[deepest]]
        assert abs(float(x) - float(stop.at)) == pytest.approx(-orbit.grazing_margin, abs=1e-13)
        assert float(v) == pytest.approx(0.0, abs=1e-7)


@each_system
def test_stability_follows_from_the_multipliers(name: str) -> None:
    for orbit in orbits_of(name):
        largest = np.abs(orbit.multipliers).max()
        if orbit.stability == "asymptotic":
            assert largest < 1.0
        elif orbit.stability == "unstable":
            assert largest > 1.0
        else:
            assert largest == pytest.approx(1.0, abs=1e-4)
        assert orbit.is_stable == (orbit.stability == "asymptotic")


def test_search_is_the_same_for_the_same_seed() -> None:
    first, second = (pc.find_orbits(*SYSTEMS["one wall"], seed=3) for _ in range(2))

    assert [orbit.t0 for orbit in first] == [orbit.t0 for orbit in second]


def test_stable_unstable_and_resting_orbits_stand_side_by_side() -> None:
    found = [(orbit.n_impacts, orbit.stability) for orbit in orbits_of("hysteresis")]

    for wanted in ((0, "asymptotic"), (1, "asymptotic"), (1, "unstable")):
        assert wanted in found


def test_beyond_a_period_doubling_the_doubled_orbit_is_stable() -> None:
    single = pc.find_orbit(*SYSTEMS["period doubled"])
    doubled = pc.find_orbit(*SYSTEMS["period doubled"], 2, 2)

    assert (single.stability, doubled.stability) == ("unstable", "asymptotic")
    assert single.multipliers[0].real < -1.0


def test_family_of_the_third_harmonic_is_not_isolated() -> None:
    """Dyskin et al. 2012: with n = 3 every V0 > 1/2 gives an orbit, and r = 1 none to itself."""
    for v0 in (0.51, 0.75):
        orbit = pc.find_orbit(ELASTIC, pc.sine(3), 2, 3, guess=(0.0, v0))

        assert not orbit.isolated
        assert orbit.v0 == pytest.approx(v0, abs=1e-12)
        np.testing.assert_allclose(orbit.monodromy, np.eye(2), atol=1e-12)
        assert orbit.stability == "parabolic"
    assert pc.find_orbit(ELASTIC, pc.sine("2.3")).isolated


def test_a_member_of_a_family_next_to_the_guess_is_found() -> None:
    orbit = pc.find_orbit(ELASTIC, pc.sine(3), 2, 3, guess=(0.01, 0.6))

    assert not orbit.isolated
    assert orbit.residual < 1e-12
    assert abs(orbit.v0 - 0.6) < 0.05


def test_free_motion_is_found_with_its_period() -> None:
    bilinear = pc.bilinear_oscillator(1.0, stiffness_below=4.0)

    orbit = pc.find_orbit(bilinear, guess=pc.simulate(bilinear, x0=0.1, v0=1.0, t_end=60.0))

    assert orbit.period == pytest.approx(1.5 * math.pi, abs=1e-12)
    assert (orbit.n_impacts, orbit.n_periods, orbit.isolated) == (1, 0, False)
    assert orbit.stability == "parabolic"


def test_sticking_of_the_locking_ball() -> None:
    """The reference case ball-locking-G1.2-r0.5, found without a start."""
    orbit = pc.find_orbit(*SYSTEMS["ball"], n_impacts=math.inf)

    assert math.isinf(orbit.n_impacts)
    assert orbit.period == pytest.approx(2.0 * math.pi, abs=1e-12)
    run = orbit.trajectory(2)
    take_off = run.contacts.release[0] % (2.0 * math.pi)
    # It takes off where the table's acceleration falls below gravity: 1.2 sin t = 1.
    assert take_off == pytest.approx(math.asin(1.0 / 1.2), abs=1e-12)
    np.testing.assert_array_equal(orbit.multipliers, [0.0, 0.0])
    assert orbit.residual < 1e-13
    assert orbit.is_stable


def test_several_periods_of_a_trajectory_join() -> None:
    for orbit in orbits_of("two walls") + orbits_of("ball")[:3]:
        run = orbit.trajectory(3)
        times = run.t0 + np.linspace(0.01, 0.97, 50) * orbit.period
        first, last = run(times), run(times + 2 * orbit.period)
        np.testing.assert_allclose(last, first, rtol=0, atol=1e-11)
        assert run.t_end == pytest.approx(run.t0 + 3 * orbit.period, rel=1e-15)


def test_spectrum_of_an_unstable_orbit_repeats_itself() -> None:
    orbit = pc.find_orbit(*SYSTEMS["two walls"], 2, 1)
    assert orbit.stability == "unstable"

    lines = orbit.spectrum(8)

    assert float(lines.mismatch_x) < 1e-13
    # Half-period antisymmetry leaves the odd lines only.
    np.testing.assert_allclose(lines.amplitude[::2], 0.0, atol=1e-13)


def test_guess_by_a_run_takes_its_pattern() -> None:
    run = pc.simulate(*SYSTEMS["period doubled"], -0.05, 0.3, t_end=900.0)

    orbit = pc.find_orbit(*SYSTEMS["period doubled"], guess=run)

    assert (orbit.n_impacts, orbit.n_periods) == (2, 2)
    assert orbit.is_stable


def test_guess_by_an_orbit_takes_over_its_kind_and_its_formal_ones() -> None:
    near = pc.find_orbit(ABOVE, pc.cosine("2.7"))
    formal = single_impact_orbits(ABOVE, pc.cosine("2.7"))[1]

    orbit = pc.find_orbit(ABOVE, pc.cosine("2.8"), guess=near)
    with pytest.warns(pc.FormalOrbitWarning, match="it passes through stop 0, by"):
        beyond = pc.find_orbit(ABOVE, pc.cosine("2.8"), guess=formal)

    expected = single_impact_orbits(ABOVE, pc.cosine("2.8"))
    assert orbit.v0 == pytest.approx(expected[0].v0, abs=1e-12)
    assert beyond.v0 == pytest.approx(expected[1].v0, abs=1e-12)
    assert not beyond.admissible


def test_sequence_asks_for_the_order_of_the_stops() -> None:
    osc, force = SYSTEMS["two walls"]

    once = pc.find_orbit(osc, force, 3, 1, sequence=(0, 0, 1))

    assert sorted(once.sequence) == [0, 0, 1]
    assert once.admissible


def test_a_long_run_with_slow_impacts_leads_to_its_orbit() -> None:
    """At t = 3,000 the rounding of an instant moves the velocity by more than a solution may miss.

    One impact of speed 0.007 in seven periods, next to the graze at the amplitude.
    """
    amplitude = 1 / math.hypot(1 - 16, 2 * 1.2 * 4)
    wall = amplitude * (1 - 1e-3)
    osc = pc.impact_oscillator("0.8", wall=wall, side="above", damping="1.2")
    run = pc.simulate(osc, pc.cosine(4), periods=2000)

    orbit = pc.find_orbit(osc, pc.cosine(4), guess=run)

    assert (orbit.n_impacts, orbit.n_periods, orbit.is_stable) == (1, 7, True)
    assert orbit.min_impact_speed == pytest.approx(run.impacts.v_before[-1], rel=1e-6)


def test_a_run_that_repeats_twice_its_orbit_gives_the_orbit() -> None:
    run = pc.simulate(ABOVE, pc.cosine("2.5"), -0.05, 0.3, t_end=400.0)

    orbit = pc.find_orbit(ABOVE, pc.cosine("2.5"), 2, 2, guess=run)

    assert (orbit.n_impacts, orbit.n_periods) == (1, 1)
    assert orbit.is_stable


def test_a_run_that_sticks_gives_the_sticking_orbit() -> None:
    osc, force = SYSTEMS["ball"]
    run = pc.simulate(osc, force, v0=0.1, t_end=100.0)
    assert len(run.contacts) > 5

    assert math.isinf(pc.find_orbit(osc, force, guess=run).n_impacts)


def test_where_no_motion_does_so_a_formal_orbit_is_found() -> None:
    """Two impacts on one wall of two in a period, without the other, is only formal here."""
    with pytest.warns(pc.FormalOrbitWarning, match="formal, no motion follows it") as warned:
        orbit = pc.find_orbit(*SYSTEMS["two walls"], 2, 1, sequence=(1, 1))
    assert warned[0].filename == __file__

    assert orbit.sequence == (1, 1)
    assert not orbit.admissible
    assert orbit.grazing_margin < 0.0
    assert set(orbit.passages.stop) <= {0, 1}
    assert orbit.residual < 1e-12


def test_results_survive_pickle() -> None:
    orbit = pc.find_orbit(COCO, pc.cosine(1.0))

    again = pickle.loads(pickle.dumps(orbit))

    assert again.multipliers.tolist() == orbit.multipliers.tolist()
    assert again.trajectory().impacts.t.tolist() == orbit.trajectory().impacts.t.tolist()


QUASIPERIODIC = pc.Forcing((pc.Harmonic(1.0, 1.0), pc.Harmonic(1.0, "1.41421356")))


@pytest.mark.parametrize(
    ("arguments", "keywords", "message"),
    [
        ((COCO, QUASIPERIODIC), {}, "needs a periodic forcing"),
        ((COCO, pc.cosine(1.0), 0.5), {}, "n_impacts = 0.5: neither a whole number nor math.inf"),
        ((COCO, pc.cosine(1.0), 1, 0), {}, "n_periods = 0: not a whole number of at least 1"),
        ((COCO, pc.cosine(1.0)), {"guess": (0.1, 0.3)}, "no stop of the oscillator is left with"),
        (
            (COCO, pc.cosine(1.0)),
            {"guess": "near"},
            "neither two finite numbers .cycle, v_after. nor a run nor an",
        ),
        (
            (COCO, pc.cosine(1.0)),
            {"sequence": (2,)},
            "stop = 2: the oscillator has 1 stop, counted from 0",
        ),
        ((COCO, pc.cosine(1.0)), {"sequence": (0, 0)}, "not one stop for each of the 1 impacts"),
        ((COCO,), {}, "free motion loses energy all the time"),
        ((ELASTIC, None, 0), {}, "free motion has no orbit of this kind"),
        ((pc.Oscillator(), pc.cosine(2.0)), {}, "the oscillator has no stops to meet"),
    ],
)
def test_what_does_not_fit_is_told_in_a_sentence(
    arguments: tuple[object, ...], keywords: dict[str, object], message: str
) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.find_orbit(*arguments, **keywords)  # type: ignore[call-overload]


def test_no_convergence_carries_the_last_iterate_and_what_to_try() -> None:
    osc = pc.impact_oscillator("0.7", wall=3.0, side="above", damping="0.05")

    # Beyond the fold of the gap, at 2.12, there is none.
    with pytest.raises(pc.ConvergenceError, match="no orbit with 1 impact in 1 forcing") as caught:
        pc.find_orbit(osc, pc.cosine("1.5"), guess=(0.2, -2.0))

    assert len(caught.value.last) == 1  # type: ignore[arg-type]
    assert caught.value.residual > 1e-3
    assert "try another guess" in str(caught.value)
    assert pickle.loads(pickle.dumps(caught.value)).residual == caught.value.residual


def test_an_orbit_that_covers_another_twice_is_not_given_as_one_of_twice_the_period() -> None:
    single = pc.find_orbit(COCO, pc.cosine(1.0))

    with pytest.raises(pc.ConvergenceError, match="2-fold cover"):
        pc.find_orbit(COCO, pc.cosine(1.0), 2, 2, guess=single)


def test_at_resonance_without_damping_there_is_no_orbit_without_impacts() -> None:
    with pytest.raises(pc.ConvergenceError, match="at resonance without damping"):
        pc.find_orbit(ELASTIC, pc.sine(1), n_impacts=0)


def test_motions_that_grow_for_ever_are_no_orbit_however_fast() -> None:
    """At the half-harmonic resonance two impacts a period almost close, the better the faster."""
    with pytest.raises(pc.ConvergenceError):
        pc.find_orbit(
            pc.impact_oscillator(), pc.sine(1), n_impacts=2, n_periods=1, guess=(0.185, 25)
        )


def test_free_motion_that_only_dies_out_at_a_wall_is_no_orbit() -> None:
    """Newton's method goes down to no velocity at all, where the equations have no numbers left."""
    wall = pc.Wall(at=0, side="above", restitution="0.9")
    osc = pc.Oscillator(stiffness=1, damping=0, stops=(wall,))

    with pytest.raises(pc.ConvergenceError, match="no orbit with 1 impact found"):
        pc.find_orbit(osc, None)
    with pytest.raises(pc.ConvergenceError, match="no orbit with 1 impact"):
        pc.find_orbit(osc, None, guess=(0.0, -1e-200))


def test_equations_without_numbers_end_newtons_method() -> None:
    system = System(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    events = events_of_stops(system, (0,))

    for guess in ([0.0, 1e200, 1e200], [math.nan, 1.0, 1.0], [0.0, 2.5, math.inf]):
        assert not solve(system, Itinerary.of_vector(events, np.array(guess), 1)).converged


def wall_under(stiffness: int, damping: int, at: str) -> pc.Oscillator:
    wall = pc.Wall(at=at, side="above", restitution="0.5")
    return pc.Oscillator(stiffness=stiffness, damping=damping, stops=(wall,))


@pytest.mark.parametrize(("at", "omega"), [("0.2", "2"), ("0.3", "1.7")])
def test_a_springless_motion_moved_up_to_the_wall_has_no_impact(at: str, omega: str) -> None:
    with pytest.raises(pc.ConvergenceError, match="no orbit with 1 impact"):
        pc.find_orbit(wall_under(0, 0, at), pc.cosine(omega))


@pytest.mark.parametrize(("stiffness", "damping"), [(1, 1), (-1, 0)])
def test_a_motion_that_touches_the_wall_exactly_has_no_impact(stiffness: int, damping: int) -> None:
    # Its amplitude is 1/5, the place of the wall.
    orbit = pc.find_orbit(wall_under(stiffness, damping, "0.2"), pc.cosine(2), formal=True)
    assert orbit.min_impact_speed > 1e-6


def test_a_run_that_meets_walls_and_soft_stops_leads_to_its_own_orbit() -> None:
    stops = (pc.SoftStop("0.05", "above", 2000, 5), pc.Wall("-0.04", "below", "0.7"))
    osc = pc.Oscillator(stiffness=400, damping="0.75", stops=stops)
    force = pc.Forcing((pc.Harmonic(30, 15, "0.3"),), constant="2.5")
    run = pc.simulate(osc, force, x0="0.01", periods=400)
    period = force.period
    assert period is not None
    met = [
        np.count_nonzero(times > run.t_end - period)
        for times in (run.impacts.t, run.crossings.t[run.crossings.direction == "in"])
    ]
    orbit = pc.find_orbit(osc, force, guess=run)
    assert met == [2, 1]
    assert (orbit.n_impacts, orbit.n_periods, orbit.admissible) == (3, 1, True)
    x, v = run(run.t_end - period / 2)
    t = orbit.t0 + (run.t_end - period / 2 - orbit.t0) % period
    np.testing.assert_allclose(orbit.trajectory()(t), (x, v), rtol=1e-7)


@pytest.mark.parametrize("length", [1.0, 1e-12, 1e12])
@pytest.mark.parametrize("time", [1.0, 1e6])
def test_orbits_after_plastic_impacts_are_the_same_in_all_units(length: float, time: float) -> None:
    """Where all velocities after impacts are 0 residuals were compared with a velocity of 1."""
    osc = pc.Oscillator(1 / time**2, 0.02 / time, (pc.Wall(-0.3 * length, "below", 0),))
    force = pc.cosine(2.3 / time, amplitude=length / time**2)

    orbits = pc.find_orbits(osc, force, max_impacts=2, max_periods=2)

    (orbit,) = (orbit for orbit in orbits if 0 < orbit.n_impacts < math.inf)
    assert orbit.impacts.cycle[0] == pytest.approx(0.9842670328759969, abs=1e-12)
    assert orbit.impacts.v_before[0] * time / length == pytest.approx(-0.05995136366911891)
    assert orbit.isolated


@pytest.mark.parametrize(("length", "time"), [(1.0, 1.0), (1.0, 1e3), (1e-6, 1e3)])
def test_a_member_of_a_family_that_touches_a_wall_is_no_orbit_with_impacts(
    length: float, time: float
) -> None:
    """Without a spring a mass swings at any place; one is that at which it grazes the wall."""
    walls = (
        pc.Wall(-0.9 * length, "below", 0.6392529414753486),
        pc.Wall(0.9 * length, "above", 0.6305088218487964),
    )
    osc = pc.Oscillator(0, 0.03354790808704237 / time, walls)
    amplitude = 0.5471421761465569 * length / time**2
    force = pc.cosine(2.68854365735367 / time, amplitude=amplitude, phase=1)

    orbits = pc.find_orbits(osc, force, max_impacts=2, max_periods=1)

    assert [orbit.n_impacts for orbit in orbits] == [0]
