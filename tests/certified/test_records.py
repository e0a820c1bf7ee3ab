"""Proofs under records: linear and held, once and repeated, and what meets a knot."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from flint import arb
from tests.certified.comparison import misses
from tests.oracle.random_problems import (
    Motion,
    chattering_motion,
    random_motion,
    with_record,
    with_tables,
)

import percuss as pc
from percuss.certified import CertifiedRun, Ending
from percuss.certified.ball_law import law_of
from percuss.certified.fold import CurveResidual, OrbitsAlong
from percuss.certified.knots import Blur
from percuss.certified.numbers import precision
from percuss.certified.pieces import Moment
from percuss.certified.shooting import shooting_of, vector_of
from percuss.certified.system import system_of
from percuss.model.paths import get_parameter

HALF = pc.impact_oscillator("1/2")
PLASTIC = pc.impact_oscillator(0)
DROP = pc.impact_oscillator("1/2", stiffness=0)
PI = pc.pi_times(1)


def proof(osc: pc.Oscillator, force: pc.Forcing, t_end: Any, **start: Any) -> CertifiedRun:
    return pc.certify(pc.simulate(osc, force, t_end=t_end, **start), digits=20)


def random_kind(seed: int) -> Motion:
    """Return a motion under a record: with harmonics or not, with tables, or chattering."""
    motion = chattering_motion(seed) if seed % 3 == 2 else random_motion(seed + 500_000)
    motion = with_record(motion, seed)
    return with_tables(motion, seed) if seed % 3 == 1 else motion


@pytest.mark.parametrize(
    "seeds",
    [range(0, 24, 4), pytest.param(range(4000), marks=pytest.mark.nightly)],
    ids=lambda seeds: str(len(seeds)),
)
def test_no_enclosure_misses_the_truth(seeds: range) -> None:
    found = [text for seed in seeds for text in misses(random_kind(seed), bits=(None, 53))]

    assert found == []


def dropped_on_knots(seed: int) -> Motion:
    """Return a ball under gravities that change at quarters: many impacts come at a knot exactly."""
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.choice([0.25, 0.5, 1.0], 12)) - 0.25
    f = rng.choice([-1.0, -2.0, -4.0], 12)
    force = pc.record(t, f, "hold" if rng.random() < 0.7 else "linear")
    osc = pc.impact_oscillator(float(rng.choice([0.5, 0.5, 1.0, 0.0])), stiffness=0)
    start = (0.5, 0.0, 0.0) if rng.random() < 0.5 else (0.0, float(rng.choice([0.5, 1.0])), 0.0)
    return Motion(osc, force, start)


@pytest.mark.parametrize(
    "seeds",
    [range(0, 40, 4), pytest.param(range(2000), marks=pytest.mark.nightly)],
    ids=lambda seeds: str(len(seeds)),
)
def test_impacts_at_knots_are_those_of_the_oracle(seeds: range) -> None:
    """What stays open is an accumulation at a knot, or an impact at the very end."""
    found = [text for seed in seeds for text in misses(dropped_on_knots(seed), bits=(None, 53))]

    open_ones = [text for text in found if "outside of" not in text and "stops of" not in text]
    assert [text for text in found if text not in open_ones] == []
    assert len(open_ones) <= 0.05 * len(seeds)
    assert all("before the knot" in text or "comes by t_end" in text for text in open_ones)


@pytest.mark.parametrize("force", [pc.triangle_wave(1), pc.square_wave(2, "0.7")])
@pytest.mark.parametrize(
    ("stiffness", "damping"),
    [
        (1, 0),  # in resonance with the triangle wave
        ("1.0000000001", 0),
        (1, "0.1"),
        (1, 1),
        (1, 3),
        (0, 0),
        (0, "0.3"),
        ("-0.2", "0.1"),
        ("1e-9", "0.2"),
    ],
)
def test_each_regime_is_that_of_the_oracle(stiffness: str, damping: str, force: pc.Forcing) -> None:
    osc = pc.impact_oscillator("0.7", stiffness=stiffness, damping=damping, wall="-0.1")
    case = Motion(osc, force + pc.Forcing(constant="-0.3"), (0.2, 0.5, -1.0))

    assert misses(case, bits=(None, 53)) == []


def test_an_impact_at_a_jump_is_the_same_in_either_order() -> None:
    force = pc.record([0, PI, 10], [0, 2, 0], kind="hold", outside="zero")
    proven = proof(HALF, force, 9.5, v0=1)
    assert proven.complete
    with precision(200):
        first, second = (t.arb for t in proven.impacts.t)
        assert first.contains(arb.pi())
        # At the jump itself the balls hold the motion in either order.
        x, v = proven(PI)
        assert x[0].contains(0)
        assert x[0].radius() < 1e-19
        assert v[0].arb.contains(-1)
        assert v[0].contains("1/2")
    assert proven.accumulations == 0
    assert len(proven.event_times) == 1 + len(proven.impacts)
    with precision(200):
        assert proven.impacts.v_after[0].contains("1/2")
        # Then x = 2 (1 - cos s) + sin(s)/2, until tan(s/2) = -1/4.
        assert second.contains(3 * arb.pi() - 2 * (arb(1) / 4).atan())
        assert float(second.rad()) < 1e-19


def test_an_impact_at_a_kink_is_the_same_in_either_order() -> None:
    force = pc.record([-1, PI, PI + 10], [0, 0, 2])
    proven = proof(HALF, force, 8, v0=1)
    assert len(proven.impacts) == 1
    with precision(200):
        x, v = proven(PI + 1)
        assert x[0].arb.contains((1 - arb(1).sin()) / 5 + arb(1).sin() / 2)
        assert v[0].arb.contains((1 - arb(1).cos()) / 5 + arb(1).cos() / 2)


def test_a_crossing_at_a_jump_is_the_same_in_either_order() -> None:
    osc = pc.Oscillator(1, 0, (pc.SoftStop(0, "below", 3, "0.5"),))
    force = pc.record([0, PI, 10], [0, 2, 0], kind="hold", outside="zero")
    proven = proof(osc, force, PI + 1, v0=1)
    assert proven.crossings.direction[0] == "in"
    with precision(200):
        assert proven.crossings.t[0].arb.contains(arb.pi())
        # x'' + x' + 4 x = 2 from x = 0 at speed -1.
        rate, s = (arb(15) / 4).sqrt(), arb("0.25")
        free = (-s / 2).exp()
        x = arb("0.5") - free * (rate * s).cos() / 2 - free * (rate * s).sin() * arb("1.25") / rate
        assert proven(PI + "0.25")[0][0].arb.contains(x)


def test_a_landing_at_a_jump_is_held_if_both_forces_hold_it() -> None:
    # From v = 1 under gravity 1: down after 2.
    osc = pc.impact_oscillator(0, stiffness=0)
    for after, rests in ((-2, True), (1, False)):
        force = pc.record([0, 2, 10], [-1, after, 0], kind="hold", outside="zero")
        run = pc.simulate(osc, force, v0=1, t_end=9.0)
        proven = pc.certify(run, most_bits=256)
        assert proven.impacts.t[0].contains(2)
        if rests:
            assert proven.contacts.start[0].contains(2)
        else:
            assert proven.outcome is Ending.precision
            assert "whether a landing comes before a knot is open" in proven.reason


def test_two_impacts_at_a_jump_are_left_open() -> None:
    """Between walls nearer than the radius: the second impact may be before the jump, too."""
    walls = pc.Wall(0, "below", 1), pc.Wall("1e-90", "above", 1)
    force = pc.record([0, PI, 10], [0, 2, 0], kind="hold", outside="zero")
    run = pc.simulate(pc.Oscillator(1, 0, walls[:1]), force, v0=1, t_end=4.0)
    assert pc.certify(run).complete
    system = system_of(pc.Oscillator(1, 0, walls), force)
    with precision(100):
        tiny = arb(2) ** -60
        blur = Blur(arb(0), arb(0), arb.pi(), tiny, arb(2))
        with pytest.raises(Exception, match="two events may lie within the radius of a knot"):
            blur.after(system, 0, 0, arb(1))


def test_a_graze_at_a_knot_is_left_open() -> None:
    force = pc.record([0, PI, 10], [0, 2, 0], kind="hold", outside="zero")
    run = pc.simulate(pc.impact_oscillator("1/2", wall=-1), force, x0=1, t_end=8.0)
    proven = pc.certify(run, most_bits=256)
    assert proven.outcome is Ending.graze
    assert proven.grazes.t[0].may_contain("pi")


@pytest.mark.parametrize(
    ("samples", "kind", "release"),
    [
        # Over knots, and to the zero of a line between two.
        ([-1, -2, -1, 1, -1], "linear", 4),
        # By a jump.
        ([-1, -1, 1, -1, -1], "hold", 3),
        # The force is zero at the knots at 2 and 5; it only touches zero at 2.
        ([-1, 0, -1, 0, 1], "linear", 5),
        ([-1, 0, 1, 0, -1], "linear", 2),
        # No force at all from 2 to 3, then away.
        ([-1, 0, 1, -1, -1], "hold", 3),
    ],
)
def test_a_contact_goes_on_over_knots_and_ends_exactly(
    samples: list[int], kind: Any, release: int
) -> None:
    run = pc.simulate(PLASTIC, pc.record([0, 2, 3, 5, 7], samples, kind), t_end=9.0)
    proven = pc.certify(run)
    assert proven.contacts.start[0].contains(0)
    assert proven.contacts.release[0].contains(release)
    assert proven.contacts.release[0].radius() < 1e-15
    assert len(proven.contacts) == len(run.contacts)
    np.testing.assert_allclose(proven.impacts.t.mid(), run.impacts.t, rtol=1e-14)


def test_a_jump_during_a_chatter_changes_its_end() -> None:
    """A ball dropped from 1/2 under gravity 1 with r = 1/2, three times as heavy from a knot on."""
    at_impact = pc.record([0, "2.5", 10], [-1, -3, -1], kind="hold")
    assert proof(DROP, at_impact, 9, x0=0.5).contacts.start[0].contains("8/3")
    within_a_hop = pc.record([0, "2.25", 10], [-1, -3, -1], kind="hold")
    with precision(200):
        found = proof(DROP, within_a_hop, 9, x0=0.5).contacts.start[0].arb
        assert found.contains((9 + arb(3).sqrt()) / 4)
        assert float(found.rad()) < 1e-19


def test_a_jump_at_an_accumulation_is_said_in_a_sentence() -> None:
    force = pc.record([0, 3, 10], [-1, -3, -1], kind="hold")
    proven = pc.certify(pc.simulate(DROP, force, x0=0.5, t_end=9.0), most_bits=300)
    assert not proven.complete
    assert "before the knot of the record at t = 3 is open" in proven.reason
    assert abs(proven.t_end.mid() - 3) < 1e-12


def test_a_start_on_a_knot_is_in_the_piece_that_begins() -> None:
    force = pc.square_wave(2)
    proven = proof(pc.Oscillator(), force, PI, t0="pi/2")
    with precision(200):
        x, v = proven("pi/2"), proven(pc.pi_times(1, 2) + "0.5")
        assert x[0][0].contains(0)
        assert v[0][0].arb.contains(arb("0.5").cos() - 1)


def test_a_start_on_a_wall_at_a_jump_is_held_or_leaves() -> None:
    for sign, held in ((1, True), (-1, False)):
        force = pc.square_wave(2, amplitude=sign)
        run = pc.simulate(HALF, force, t0="pi/2", t_end=PI)
        proven = pc.certify(run)
        assert len(proven.contacts) == held
        if not held:
            with precision(200):
                assert proven(PI)[0][0].arb.contains(1)


@pytest.mark.parametrize("kind", ["linear", "hold"])
def test_two_knots_within_a_rounding_are_two(kind: Any) -> None:
    t = [0.0, 1.0, 1.0 + 1e-15, 3.0]
    assert t[2] > t[1]
    force = pc.record(t, [0.0, 1.0, -1.0, 0.5], kind)
    assert misses(Motion(HALF, force, (0.3, -1.0, 0.0)), bits=(None, 53)) == []
    # And an impact between them.
    force = pc.record([0, PI, PI + 1e-15, 10], [0, 1, -1, 0], "hold")
    proven = proof(HALF, force, 9, v0=1)
    assert proven.complete
    assert proven.impacts.t[0].contains("pi")


def test_waves_of_an_irrational_frequency_have_exact_knots() -> None:
    wave = pc.square_wave(pc.expression("sqrt(3)"))
    end = pc.expression("2*pi/sqrt(3)")
    proven = proof(pc.Oscillator(), wave, 4)
    assert proven.complete
    with precision(200):
        turn = (arb.pi() / arb(3).sqrt()).cos()
        assert proven(end)[0][0].arb.contains(2 * turn * (1 - turn))
    # That this end is a knot no ball can prove.
    cut = pc.certify(pc.simulate(pc.Oscillator(), wave, t_end=end), most_bits=256)
    assert "whether the run ends before the knot of the record at t = 3.62759" in cut.reason
    # The period of the sum with a harmonic of the same number is known, too.
    law = law_of(system_of(HALF, wave + pc.cosine(pc.expression("sqrt(3)"))))
    with precision(200):
        assert law.period(1).overlaps(2 * arb.pi() / arb(3).sqrt())


@pytest.mark.parametrize(
    ("force", "constant", "for_ever"),
    [
        # By the largest force, and, with no force at all half of the time, by a whole period.
        (pc.square_wave(2, "0.5"), -1, True),
        (pc.square_wave(2, "0.5"), "-0.5", True),
        (pc.triangle_wave(2, "0.5") + pc.cosine(2, amplitude="0.1"), "-0.55", True),
        (pc.square_wave(2, "0.5"), "-0.4", False),
        (pc.record([0, 1, 2], [-1, 0, -1], outside="end"), 0, True),
        (pc.record([0, 1, 2], [-1, 0, -1], outside="zero"), 0, True),
    ],
)
def test_rest_for_ever_is_recognised(force: pc.Forcing, constant: str, for_ever: bool) -> None:
    force = force + pc.Forcing(constant=constant)
    run = pc.simulate(PLASTIC, force, t0=1, t_end=40.0)
    proven = pc.certify(run, max_impacts=20)
    assert (proven.outcome is Ending.at_rest) == for_ever


def test_a_mass_at_rest_moves_when_the_record_begins() -> None:
    force = pc.record([0, 1, 2], [0, 0, 1], outside="zero")
    for osc in (HALF, pc.Oscillator(), pc.Oscillator(1, 0, (pc.SoftStop(0, "below", 3),))):
        proven = proof(osc, force, 2)
        with precision(200):
            x, v = proven([1, 1.5])
            assert x[0].contains(0)
            assert x[1].arb.contains(arb("0.5") - arb("0.5").sin())
            assert v[1].arb.contains(1 - arb("0.5").cos())
    still = pc.record([0, 1, 2], [0, 0, 0])
    assert pc.certify(pc.simulate(pc.Oscillator(), still, t_end=9.0)).complete


def test_a_knot_is_no_event() -> None:
    run = pc.simulate(HALF, pc.triangle_wave(3, 2), v0=1, t_end=6.0)
    proven = pc.certify(run)
    assert len(proven.event_times) == 1 + len(run.impacts)
    assert len(proven.crossings) == 0
    cycle = proven.impacts.cycle.mid()
    np.testing.assert_allclose(cycle, run.impacts.t * 3 / (2 * np.pi) % 1, atol=1e-12)
    strobes = proven.stroboscopic()
    assert dict(strobes.sizes) == {"period": 3}
    np.testing.assert_allclose(strobes.x, run(np.arange(3) * 2 * np.pi / 3)[0], atol=1e-13)


def test_the_force_at_a_jump_is_both() -> None:
    proven = proof(pc.Oscillator(), pc.square_wave(pc.expression("sqrt(3)")), 5)
    found = proven.forces(["0.5", "2"])
    assert found.forcing.values.tolist() == [1.0, -1.0]
    assert found.forcing_radius.values.tolist() == [0.0, 0.0]
    jump = proven.forces(pc.expression("pi/sqrt(3)"))
    assert float(jump.forcing[0]) == 0.0
    assert 1.0 <= float(jump.forcing_radius[0]) < 1.00001
    exact = proof(pc.Oscillator(), pc.square_wave(2), 5).forces(["pi/2"])
    assert float(exact.forcing[0]) == -1.0


def test_a_mass_divides_the_record() -> None:
    heavy = pc.Oscillator.from_mass(2, 8, stops=HALF.stops)
    light = pc.Oscillator(4, 0, HALF.stops)
    one = proof(heavy, pc.square_wave(1, 3), 9, v0=1)
    other = proof(light, pc.square_wave(1, "1.5"), 9, v0=1)
    for mine, theirs in zip(one.impacts.t, other.impacts.t, strict=True):
        assert mine.overlaps(theirs)


def test_the_strength_of_a_record_may_be_a_range() -> None:
    run = pc.simulate(HALF, pc.triangle_wave(2), v0=1, max_impacts=3)
    ends = "0.9999999", "1.0000001"
    over = pc.certify(run, digits=5, over={"forcing.record.amplitude": ends})
    assert over.complete
    for value in (*ends, 1):
        each = pc.certify(pc.simulate(HALF, pc.triangle_wave(2, value), v0=1, max_impacts=3))
        for wide, narrow in zip(over.impacts.t, each.impacts.t, strict=True):
            assert wide.arb.contains(narrow.arb)


@pytest.mark.parametrize(
    "force",
    [
        pc.square_wave(2),
        pc.triangle_wave("1.7", amplitude=2) + pc.cosine("1.7"),
        pc.pulses(2, "0.1", 5),
        pc.square_wave(pc.expression("sqrt(3)")),
        pc.triangle_wave("0.6*pi", 2) + pc.cosine("1.2*pi", "0.3"),
        # The record in seconds, the harmonic in hertz.
        pc.record([0, "0.5", 2], [0, 2, 0], repeat=True) + pc.cosine("pi"),
        # Its impact comes just after a knot.
        pc.record([0, 1, 2.5, 4], [0, 1, -1, 0.5], repeat=True),
    ],
    ids=["square", "triangle", "pulses", "irrational", "pi", "hertz", "jump"],
)
def test_an_orbit_is_proven_and_is_that_of_floats(force: pc.Forcing) -> None:
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    orbit = pc.find_orbit(osc, force)
    proven = pc.certify(orbit, digits=20)
    assert (proven.exists, proven.isolated, proven.admissible) == (True, True, True)
    assert proven.stability == "asymptotic"
    assert proven.unique_within > 0
    for multiplier, theirs in zip(proven.multipliers, orbit.multipliers, strict=True):
        assert abs(multiplier.mid() - theirs) < 1e-9
    # The run from its impact is on it a period later, and between all knots.
    with precision(100):
        times = [proven.t0.mid() + float(proven.period.arb) * part for part in (0.1, 0.5, 0.9, 1.3)]
    floats = orbit.trajectory(4)(np.array(times) + 2 * orbit.period)
    for balls, values in zip(proven(times), floats, strict=True):
        np.testing.assert_allclose(balls.mid(), values, atol=1e-9)
        assert balls.radius().max() < 1e-14


def test_an_orbit_with_an_impact_at_a_knot_is_left_open() -> None:
    """Where the force jumps at the impact, the map has no derivative."""
    # From v = 1 just after an impact, under no spring and the force -2: back after a unit of time.
    force = pc.record([0, "1/2", 1], [-2, -2, -2], kind="hold", repeat=True)
    orbit = pc.find_orbit(pc.impact_oscillator(1, stiffness=0), force, guess=(0.0, 1.0))
    proven = pc.certify(orbit, most_bits=256)
    assert not proven.exists


def test_steady_motion_under_a_square_wave_is_its_closed_form() -> None:
    """x = 1 - cos(t - tau/2)/cos(tau/2) on the first half period tau."""
    osc = pc.impact_oscillator("0.8", wall=5, side="above")
    proven = pc.certify(pc.find_orbit(osc, pc.square_wave(2), n_impacts=0), digits=20)
    assert proven.x0.contains(0)
    assert proven.v0.contains(-1)
    assert proven.admissible
    x, _ = proven("pi/4")
    with precision(200):
        assert x[0].arb.contains(1 - arb(2).sqrt())
    near = pc.impact_oscillator("0.8", wall="0.3", side="above")
    formal = pc.find_orbit(near, pc.square_wave(2), n_impacts=0, formal=True)
    assert pc.certify(formal).admissible is False


GAP, PACE = "oscillator.stops.0.at", "forcing.record.omega"
DAMPED = pc.impact_oscillator("0.7", wall="-0.2", damping="0.05")


@pytest.mark.parametrize(
    ("force", "over", "kinds"),
    [
        (
            pc.square_wave("2.3"),
            {GAP: ("-0.72", "-0.2")},
            ["border_collision", "fold", "grazing", "period_doubling"],
        ),
        (pc.square_wave("2.3"), {PACE: ("2.3", "2.8")}, ["grazing", "period_doubling"]),
        pytest.param(
            pc.triangle_wave("2.3", amplitude="1.5") + pc.cosine("2.3", amplitude="0.1"),
            {GAP: ("-0.9", "-0.1")},
            ["fold", "grazing", "period_doubling"],
            marks=pytest.mark.nightly,
        ),
    ],
    ids=["square, gap", "square, frequency", "triangle and harmonic, gap"],
)
def test_special_points_under_waves_are_enclosed(
    force: pc.Forcing, over: dict[str, tuple[Any, Any]], kinds: list[str]
) -> None:
    orbit = pc.find_orbit(DAMPED, force)
    points = {p.kind: p for p in pc.continue_orbit(orbit, over=over).special_points}
    assert sorted(points) == kinds
    border = points.pop("border_collision", None)
    if border is not None:
        assert "the derivative of the equations has two values" in pc.certify(border).reason
    for kind, point in points.items():
        proven = pc.certify(point)
        assert proven.exists, kind
        assert abs(proven.value.mid() - point.value) < 1e-10
        assert proven.value.radius() < 1e-12


def test_a_graze_of_steady_motion_under_a_wave_is_its_closed_form() -> None:
    """Of an undamped spring x = 1 - cos(t - h)/cos(h) turns at the middle h of a half period."""
    osc = pc.impact_oscillator("0.8", wall=-1)
    calm = pc.find_orbit(osc, pc.square_wave(2, amplitude="0.5"), n_impacts=0)
    branch = pc.continue_orbit(calm, over={"forcing.record.amplitude": ("0.5", 5)})
    proven = pc.certify(branch.special_points[0], digits=20)
    with precision(200):
        assert proven.value.arb.contains(1 / ((1 / (arb.pi() / 4).cos()) - 1))


@pytest.mark.parametrize("path", [PACE, "forcing.record.amplitude", GAP, "oscillator.damping"])
@pytest.mark.parametrize("wave", [pc.square_wave, pc.triangle_wave])
def test_the_derivative_by_a_parameter_over_knots_is_that_of_differences(
    wave: Callable[..., pc.Forcing], path: str
) -> None:
    orbit = pc.find_orbit(DAMPED, wave("2.3", amplitude=2), formal=True)
    with precision(300):
        system = system_of(*orbit.system)
        equations, guess = shooting_of(system, orbit)
        value = arb(float(get_parameter(*orbit.system, None, path)))
        w, eta = vector_of(guess), vector_of(guess)[0]
        w[0] = value
        curve = OrbitsAlong(system, equations.events, orbit.n_periods, path, 0)
        residual, step = CurveResidual(curve, eta, curve.coarse()), arb(2) ** -100
        ends = [residual.value([value + move, *w[1:]]) for move in (step, -step)]
        expected = (ends[0] - ends[1]) * (1 / (2 * step))
        exact = residual.derivative(w)
        for row in range(exact.nrows()):
            assert abs(exact[row, 0] - expected[row, 0]) < 1e-25


def test_an_expression_among_the_samples_is_refused() -> None:
    force = pc.record([0, 1], [pc.parameter("p", 1), 0])
    run = pc.simulate(HALF, force, v0=1, t_end=1.0)
    with pytest.raises(pc.ParameterError, match=r"forcing\.record\.f\.0 .*needs samples"):
        pc.certify(run)


@pytest.mark.parametrize("make", [pc.triangle_wave, pc.square_wave])
def test_pieces_are_found_at_and_around_their_knots(make: Callable[[str], pc.Forcing]) -> None:
    with precision(128):
        record = law_of(system_of(HALF, make("1.7"))).record
        assert record is not None
        for number in (-7, -1, 0, 1, 5, 1000):
            knot = record.knot(number)
            tiny = arb(10) ** -30
            assert record.piece_at(knot) == number
            assert record.piece_at(Moment(knot.t - tiny)) == number - 1
            assert record.piece_at(Moment(knot.t + tiny)) == number
            with pytest.raises(Exception, match="before or after the knot"):
                record.piece_at(Moment(knot.t + arb(0, tiny)))
