from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.arrays import Floats
from percuss.motion.sections import SectionDirection

WALLS = (pc.Wall(0.4, "above", 0.7), pc.Wall(-0.5, "below", 0.9))
SOFT = (pc.SoftStop(0.2, "above", 29.0, 0.7), pc.SoftStop(-0.3, "below", 5.0, 0.2))
BOTH = (WALLS[0], pc.SoftStop(0.2, "above", 5.0, 0.3), WALLS[1])
SYSTEMS = {
    "walls": (pc.Oscillator(1.0, 0.02, WALLS), pc.cosine(1.3)),
    "soft stops": (pc.Oscillator(1.0, 0.02, SOFT), pc.cosine(1.3)),
    "soft stop before a wall": (pc.Oscillator(1.0, 0.02, BOTH), pc.fourier(1.3, cos=(1.0, 0.3))),
    "elastic": (pc.impact_oscillator(), pc.sine(3)),
    "no spring": (pc.ball_on_table(amplitude=0.9, omega=1.0, gravity=1.0, restitution=0.8)),
}
CASES = [(name, stop) for name, (osc, _) in SYSTEMS.items() for stop in range(len(osc.stops))]


def way_after(stop: pc.Wall | pc.SoftStop) -> float:
    """Return the sign of a velocity after an impact on a stop."""
    above = stop.side == "above"
    return 1.0 if above == isinstance(stop, pc.SoftStop) else -1.0


def around(cycles: Floats) -> Floats:
    """Return differences of cycles, less whole ones."""
    return np.asarray((cycles + 0.5) % 1.0 - 0.5)


@pytest.mark.parametrize(("name", "stop"), CASES)
def test_impact_map_is_what_a_run_does(name: str, stop: int) -> None:
    osc, force = SYSTEMS[name]
    assert force.period is not None
    v = 0.8 * way_after(osc.stops[stop])
    run = pc.simulate(osc, force, osc.stops[stop].at, v, 0.3 * force.period, max_impacts=40)
    if isinstance(osc.stops[stop], pc.Wall):
        on_it = run.impacts.stop == stop
        t, expected = run.impacts.t[on_it][0], run.impacts.v_after[on_it][0]
    else:
        on_it = (run.crossings.stop == stop) & (run.crossings.direction == "in")
        t, expected = run.crossings.t[on_it][0], run.crossings.v[on_it][0]

    cycle, v_after = pc.impact_map(osc, force, stop)(0.3, v)

    assert around(cycle - t / force.period) == pytest.approx(0.0, abs=1e-14)
    assert v_after == pytest.approx(expected, abs=1e-14)


@pytest.mark.parametrize(("name", "stop"), CASES)
def test_derivative_of_the_impact_map_agrees_with_central_differences(name: str, stop: int) -> None:
    osc, force = SYSTEMS[name]
    step = pc.impact_map(osc, force, stop)
    cycles = np.array([0.1, 0.35, 0.6, 0.8])
    v = way_after(osc.stops[stop]) * np.array([0.9, 1.4, 0.6, 2.0])
    h = 1e-6

    matrices = step.jacobian(cycles, v)

    by_cycle = (step(cycles + h, v), step(cycles - h, v))
    by_v = (step(cycles, v + h), step(cycles, v - h))
    for k, (plus, minus) in enumerate((by_cycle, by_v)):
        expected = np.stack([around(plus[0] - minus[0]), plus[1] - minus[1]], axis=-1) / (2.0 * h)
        # The higher derivatives of a low impact are larger than the first.
        size = np.abs(matrices).max(axis=(1, 2))[:, None] ** 2 + 1.0
        assert (np.abs(matrices[:, :, k] - expected) <= 1e-7 * size).all()


@pytest.mark.parametrize("name", SYSTEMS)
def test_stroboscopic_map_and_its_derivative(name: str) -> None:
    osc, force = SYSTEMS[name]
    assert force.period is not None
    strobe = pc.stroboscopic_map(osc, force, cycle=0.2)
    x, v = np.array([0.05, 0.1, 0.15]), np.array([0.4, -0.9, 1.3])
    run = pc.simulate(osc, force, 0.1, -0.9, 0.2 * force.period, t_end=1.2 * force.period)
    h = 1e-6

    np.testing.assert_allclose(
        [part[1] for part in strobe(x, v)], run(run.t_end), rtol=0, atol=1e-13
    )
    matrices = strobe.jacobian(x, v)
    by_x = (np.array(strobe(x + h, v)) - np.array(strobe(x - h, v))) / (2.0 * h)
    by_v = (np.array(strobe(x, v + h)) - np.array(strobe(x, v - h))) / (2.0 * h)
    expected = np.stack([by_x, by_v], axis=-1).transpose(1, 0, 2)
    np.testing.assert_allclose(matrices, expected, atol=1e-7 * np.abs(matrices).max())


def test_shapes_are_those_of_the_arguments() -> None:
    step = pc.impact_map(*SYSTEMS["elastic"])
    strobe = pc.stroboscopic_map(*SYSTEMS["elastic"])

    assert step(np.full((2, 3), 0.2), 0.7)[0].shape == (2, 3)
    assert step.jacobian(0.2, 0.7).shape == (2, 2)
    assert strobe(np.full((2, 3), 0.2), 0.7)[1].shape == (2, 3)
    assert strobe.jacobian(np.full(4, 0.2), 0.7).shape == (4, 2, 2)


def test_through_chatter_and_sticking_the_derivative_is_zero() -> None:
    osc, force = pc.impact_oscillator(0.5), pc.cosine(1.0, constant=-0.9)
    strobe = pc.stroboscopic_map(osc, force)

    # Different pasts, one release: the same end.
    ends = np.array(strobe(0.0, np.array([0.2, 0.25, 0.3])))
    np.testing.assert_allclose(ends, ends[:, :1] * np.ones(3), rtol=0, atol=1e-14)
    np.testing.assert_array_equal(strobe.jacobian(0.0, 0.25), np.zeros((2, 2)))


def test_an_impact_map_goes_on_from_rest_at_the_wall_with_its_release() -> None:
    osc, force = pc.impact_oscillator(0.5), pc.cosine(1.0, constant=-0.9)
    step = pc.impact_map(osc, force)

    # At half a turn the force holds the mass.
    cycle, v = step(np.array([0.4, 0.5]), 0.0)

    assert cycle[0] == pytest.approx(cycle[1], abs=1e-14)
    assert v[0] == pytest.approx(v[1], abs=1e-14)
    np.testing.assert_array_equal(step.jacobian(0.5, 0.0), np.zeros((2, 2)))


def test_where_no_impact_follows_the_map_is_nowhere() -> None:
    osc = pc.impact_oscillator(0.5, damping=0.4, wall=-0.5)
    step = pc.impact_map(osc, pc.cosine(2.0, amplitude=0.1))

    assert all(math.isnan(part) for part in step(0.2, 0.01))
    assert np.isnan(step.jacobian(0.2, 0.01)).all()


def test_a_stop_that_others_shield_is_nowhere_met_in_thousands_of_impacts() -> None:
    """The motion settles to hops on one wall for ever, that do not reach the other."""
    osc = pc.Oscillator(1.0, 0.05, (pc.Wall(0.0, "below", 0.8), pc.Wall(9.0, "above", 0.1)))

    assert np.isnan(pc.impact_map(osc, pc.sine(3), stop=1)(0.1, -0.1)[0])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda o, f: pc.impact_map(o, f, stop=2),
            "stop = 2: the oscillator has 1 stop, counted from 0",
        ),
        (lambda o, _: pc.impact_map(o, pc.Forcing()), "an impact map needs a periodic forcing"),
        (lambda o, _: pc.stroboscopic_map(o, pc.Forcing()), "needs a periodic forcing"),
        (lambda o, f: pc.impact_map(o, f)(0.1, -0.3), "into the wall"),
        (lambda o, f: pc.impact_map(o, f)(math.nan, 0.3), "cycle = nan: not a finite"),
        (lambda o, f: pc.stroboscopic_map(o, f)(-0.1, 0.3), "below the wall"),
    ],
)
def test_what_does_not_fit_is_told_in_a_sentence(call: object, message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        call(pc.impact_oscillator(0.8), pc.sine(3))  # type: ignore[operator]


SECTIONS: list[tuple[str, float, SectionDirection]] = [("walls", 0.1, "up"), ("soft stops", 0.2, "up"), ("soft stops", -0.1, "down"),
            ("soft stop before a wall", 0.3, "up"), ("elastic", 0.4, "both"),
            ("no spring", 0.05, "down")]  # fmt: skip


@pytest.mark.parametrize(("name", "at", "direction"), SECTIONS)
def test_section_map_is_what_a_run_does(name: str, at: float, direction: SectionDirection) -> None:
    osc, force = SYSTEMS[name]
    assert force.period is not None
    v = -0.8 if direction == "down" else 0.8
    section = pc.section_map(osc, force, at=at, direction=direction)
    run = pc.simulate(osc, force, at, v, 0.3 * force.period, periods=30)
    passages = run.section(at=at, direction=direction)

    point = np.array([0.3, v])
    for k in range(3):
        point = np.array(section(*point))
        cycle = passages.t.values[k] / force.period
        assert around(point[0] - cycle) == pytest.approx(0, abs=1e-12)
        assert point[1] == pytest.approx(float(passages.v[k]), abs=1e-12)


@pytest.mark.parametrize(("name", "at", "direction"), SECTIONS)
def test_derivative_of_the_section_map_agrees_with_central_differences(
    name: str, at: float, direction: SectionDirection
) -> None:
    section = pc.section_map(*SYSTEMS[name], at=at, direction=direction)
    cycles = np.array([0.1, 0.35, 0.6])
    v = (-1.0 if direction == "down" else 1.0) * np.array([0.9, 1.4, 1.1])
    h = 1e-6

    by_cycle = [np.stack(section(cycles + sign * h, v)) for sign in (1.0, -1.0)]
    by_speed = [np.stack(section(cycles, v + sign * h)) for sign in (1.0, -1.0)]
    columns = [(by_cycle[0] - by_cycle[1]), (by_speed[0] - by_speed[1])]
    columns[0][0], columns[1][0] = around(columns[0][0]), around(columns[1][0])

    expected = np.stack(columns, axis=-1).transpose(1, 0, 2) / (2.0 * h)
    np.testing.assert_allclose(section.jacobian(cycles, v), expected, rtol=2e-6, atol=2e-6)


def test_an_orbit_has_its_multipliers_at_every_section() -> None:
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine("2.4"))
    passages = orbit.trajectory(1).section(at=0.1, direction="up")
    section = pc.section_map(osc, pc.cosine("2.4"), at=0.1, direction="up")

    product = np.eye(2)
    for t, v in zip(passages.t.values, passages.v.values, strict=True):
        product = section.jacobian(t / orbit.period, v) @ product

    found = np.sort_complex(np.linalg.eigvals(product))
    np.testing.assert_allclose(found, np.sort_complex(orbit.multipliers), atol=1e-10)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"at": 0.9}, "at = 0.9: above the wall"),
        ({"at": 0.1, "direction": "in"}, "direction = 'in': none of up, down, both"),
        ({"at": math.inf}, "at = inf"),
    ],
)
def test_a_section_that_is_none_is_refused(keywords: dict[str, object], message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.section_map(*SYSTEMS["walls"], **keywords)  # type: ignore[arg-type]


def test_a_velocity_against_the_direction_is_refused_and_no_passage_is_nan() -> None:
    section = pc.section_map(*SYSTEMS["walls"], at=0.1, direction="up")
    with pytest.raises(pc.ParameterError, match="no velocity of a passage x = 0"):
        section(0.3, -1.0)
    far = pc.section_map(pc.Oscillator(1, 1), pc.cosine(2, amplitude="0.1"), at=3.0)

    assert np.isnan(far(0.0, 1.0)[1]) or float(far(0.0, 1.0)[1]) < 0.0
    assert np.isnan(far.jacobian(0.0, -1.0)).all()


def test_under_a_record_a_motion_that_stays_off_the_stop_has_no_image() -> None:
    """No proof that nothing comes any more goes past a knot: the search did not end."""
    osc = pc.Oscillator(damping=1, stops=(pc.Wall(-1, "below", 0), pc.Wall(1, "above", "0.4")))
    impacts = pc.impact_map(osc, pc.square_wave(2, amplitude="0.1"))

    assert np.isnan(impacts(0.3, 0.5)).all()
    assert np.isnan(impacts.jacobian(0.3, 0.5)).all()
