"""States of the impact surface that lead to a graze."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.arrays import Floats

WALL = pc.impact_oscillator(0.8)
WALLS = pc.Oscillator(1.0, 0.02, (pc.Wall(0.4, "above", 0.7), pc.Wall(-0.5, "below", 0.9)))
SOFT = pc.Oscillator(
    1.0, 0.02, (pc.SoftStop(0.2, "above", 29.0, 0.7), pc.SoftStop(-0.3, "below", 5.0, 0.2))
)
PENDULUM = pc.Oscillator(-1.0, 0.1, (pc.Wall(-1, "below", 0.8), pc.Wall(1, "above", 0.7)))
SYSTEMS = {
    "wall at the equilibrium": (WALL, pc.cosine(2.5)),
    "gap": (pc.impact_oscillator(0.7, wall=-0.4, damping=0.05), pc.cosine(1.3)),
    "wall above": (pc.impact_oscillator(0.8, wall=1, side="above", damping=0.05), pc.cosine(1)),
    "two walls": (WALLS, pc.cosine(1.3)),
    "soft stops": (SOFT, pc.cosine(1.3)),
    "no spring": pc.ball_on_table(amplitude=0.9, omega=1.0, gravity=0.5, restitution=0.8),
    "overdamped": (pc.impact_oscillator(0.8, damping=1.2), pc.cosine(2.0)),
    "two harmonics": (pc.impact_oscillator(0.9), pc.fourier(1.3, cos=(1.0, 0.3, 0.0, 0.2))),
    "exact resonance": (pc.impact_oscillator(), pc.sine(1)),
}


def run_to(
    found: pc.SingularitySet, curve: pc.SingularityCurve, i: int, part: float
) -> tuple[float, float]:
    """Return x and v after a part of the way from a state to its graze."""
    force = found.forcing
    assert force.period is not None
    t0 = float(curve.cycle[i]) * force.period
    x0, v0 = found.oscillator.stops[found.stop].at, float(curve.v_after[i])
    end = t0 + part * float(curve.duration[i])
    x, v = pc.simulate(found.oscillator, force, x0, v0, t0, t_end=end)(end, limit="before")
    return float(x), float(v)


@pytest.mark.parametrize("name", SYSTEMS)
def test_each_state_leads_to_the_stop_without_velocity(name: str) -> None:
    osc, force = SYSTEMS[name]

    curves = pc.singularity_set(osc, force)

    assert len(curves) > 0
    for curve in curves:
        at = float(osc.stops[curve.touched].at)
        for i in np.linspace(0, len(curve) - 1, 12).astype(int)[1:-1]:
            # Just before, where it is no question whether rounding makes it an impact.
            short = min(1e-3, 0.01 * curve.duration[i])
            x, v = run_to(curves, curve, int(i), 1.0 - short / curve.duration[i])
            # With the acceleration b and the jerk j: x = b s^2 / 2 - j s^3 / 6, v = b s - ...
            assert abs(x - at) == pytest.approx(0.5 * abs(v) * short, rel=0.03, abs=2 * short**3)
            assert abs(v) < 20.0 * short


@pytest.mark.parametrize("name", ["wall at the equilibrium", "wall above", "two harmonics"])
def test_graze_is_exact_in_the_closed_form(name: str) -> None:
    osc, force = SYSTEMS[name]
    curves = pc.singularity_set(osc, force)

    for curve in curves:
        for i in np.linspace(0, len(curve) - 1, 20).astype(int)[1:-1]:
            x, v = run_to(curves, curve, int(i), 1.0)

            # A graze that rounding makes an impact has a velocity of the root of that.
            assert abs(x - float(osc.stops[curve.touched].at)) < 1e-13
            assert abs(v) < 1e-6


@pytest.mark.parametrize(("omega", "wall"), [(2.5, 0.0), (2.7, 0.0), (0.6, -0.2)])
def test_curve_is_that_of_the_undamped_flight_backwards(omega: float, wall: float) -> None:
    """The flight with x = wall, v = 0 at tau, written out, and looked at on a fine grid."""
    osc = pc.impact_oscillator(0.8, wall=wall)
    curves = pc.singularity_set(osc, pc.cosine(omega)).curves
    period = 2.0 * math.pi / omega
    gain = 1.0 / (1.0 - omega**2)
    checked = 0

    for curve in curves:
        tau, s = curve.touch_cycle * period, curve.duration
        rest = wall - gain * np.cos(omega * tau)
        turn = gain * omega * np.sin(omega * tau)

        def place(time: Floats, c: Floats = rest, d: Floats = turn, tau: Floats = tau) -> Floats:
            motion = c * np.cos(time) - d * np.sin(time) + gain * np.cos(omega * (tau - time))
            return np.asarray(motion)

        speed = rest * np.sin(s) + turn * np.cos(s) - gain * omega * np.sin(omega * (tau - s))
        np.testing.assert_allclose(place(s), wall, atol=1e-13)
        np.testing.assert_allclose(curve.v_after, speed, atol=1e-12)
        assert all(place(part * s).min() > wall - 1e-12 for part in np.linspace(0.001, 0.999, 400))
        checked += len(curve)
    assert checked > 300


@pytest.mark.parametrize("name", ["wall at the equilibrium", "gap", "wall above", "soft stops"])
def test_impact_map_has_a_square_root_on_one_side_and_a_jump_across(name: str) -> None:
    osc, force = SYSTEMS[name]
    step = pc.impact_map(osc, force)
    curve = max(pc.singularity_set(osc, force, touched=0), key=len)

    for i in np.linspace(0, len(curve) - 1, 9).astype(int)[2:-2]:
        tangent = np.array([np.ptp(curve.cycle[i - 1 : i + 2]), 0.0])
        tangent[0] = curve.cycle[i + 1] - curve.cycle[i - 1]
        tangent[1] = curve.v_after[i + 1] - curve.v_after[i - 1]
        normal = np.array([-tangent[1], tangent[0]]) / np.hypot(*tangent)
        off = np.array([-4e-7, -1e-7, 1e-7, 4e-7])
        cycle, v = step(curve.cycle[i] + off * normal[0], curve.v_after[i] + off * normal[1])

        rooted = np.abs(v[:2]).max() < np.abs(v[2:]).max()
        far, near, across = (v[0], v[1], v[2]) if rooted else (v[3], v[2], v[1])
        assert abs(near) < 0.01
        assert far / near == pytest.approx(2.0, rel=0.02)
        # Across, the graze is missed, and the next impact is another one.
        assert abs(across) > 20.0 * abs(near)
        assert abs((cycle[2] - cycle[1] + 0.5) % 1.0 - 0.5) > 0.01


def test_jumps_of_the_impact_map_lie_on_the_set() -> None:
    """Seen without the set: neighbours on lines of one velocity whose next impacts lie apart."""
    osc, force = SYSTEMS["wall at the equilibrium"]
    assert force.period is not None
    step = pc.impact_map(osc, force)
    curves = pc.singularity_set(osc, force).curves
    states = np.concatenate([np.column_stack([c.cycle % 1.0, c.v_after]) for c in curves])
    cycles = np.linspace(0.0, 1.0, 801)
    jumps = 0

    for speed in (0.05, 0.2, 0.4, 0.55, 0.7):
        after, v = step(cycles, speed)
        leaps = np.hypot((np.diff(after) + 0.5) % 1.0 - 0.5, np.diff(v))
        for i in np.flatnonzero(leaps > 0.3):
            middle = np.array([0.5 * (cycles[i] + cycles[i + 1]), speed])
            assert np.hypot(*(states - middle).T).min() < 0.01
            jumps += 1

    assert jumps == 5


def test_second_iterate_is_the_preimage_of_the_first() -> None:
    osc, force = SYSTEMS["wall at the equilibrium"]
    curves = pc.singularity_set(osc, force, n_iterates=2)
    first = [curve for curve in curves if curve.iterate == 1]
    states = np.concatenate([np.column_stack([c.cycle % 1.0, c.v_after]) for c in first])
    second = [curve for curve in curves if curve.iterate == 2]

    assert second
    for curve in second:
        # The next impact of those without velocity is a matter of rounding.
        part = np.flatnonzero(curve.v_after > 1e-5)[1:-1:11]
        images = np.stack(pc.impact_map(osc, force)(curve.cycle[part], curve.v_after[part]), 1)
        for image in images:
            assert np.hypot(*(states - image).T).min() < 0.005


@pytest.mark.parametrize("name", SYSTEMS)
def test_neighbours_on_a_curve_are_near(name: str) -> None:
    found = pc.singularity_set(*SYSTEMS[name], n_iterates=2, spacing=0.01)

    for iterate in (1, 2):
        curves = [curve for curve in found if curve.iterate == iterate]
        for curve in curves:
            assert np.abs(np.diff(curve.cycle)).max() <= 0.01
            assert np.abs(np.diff(curve.touch_cycle)).max() <= 0.01
            fastest = max(np.abs(c.v_after).max() for c in curves)
            assert np.abs(np.diff(curve.v_after)).max() <= 0.0101 * fastest


def test_set_does_not_depend_on_the_restitution_of_its_wall() -> None:
    """What lies between the state and the graze is one flight."""
    sets = [pc.singularity_set(pc.impact_oscillator(r), pc.cosine(2.5)) for r in (0.0, 0.5, 1.0)]

    for other in sets[1:]:
        np.testing.assert_array_equal(other[0].v_after, sets[0][0].v_after)


def test_other_wall_may_lie_between() -> None:
    osc, force = SYSTEMS["two walls"]
    curves = pc.singularity_set(osc, force).curves

    assert {curve.touched for curve in curves} == {0, 1}
    assert max(int(c.n_between.max()) for c in curves if c.touched == 0) >= 1
    only = pc.singularity_set(osc, force, touched=0)
    assert {curve.touched for curve in only} == {0}


def test_curves_end_at_the_chatter_with_zero_velocity_at_its_release() -> None:
    """Where the force on the wall turns outwards, at cycle 3/4 of a cosine, hops are grazes."""
    (curve,) = pc.singularity_set(*SYSTEMS["wall at the equilibrium"]).curves

    assert curve.begins == "zero_velocity"
    assert curve.cycle[0] == pytest.approx(0.75, abs=1e-9)
    assert curve.ends == "no_acceleration"
    assert curve.touch_cycle[-1] % 1.0 == pytest.approx(0.25, abs=1e-9)


def test_grazes_that_come_back_exactly_are_no_noise() -> None:
    """For r = 1 and the third harmonic each graze is followed by another (eq. 24 of the paper)."""
    curves = pc.singularity_set(pc.impact_oscillator(), pc.sine(3), n_iterates=3)

    assert len(curves) < 30


def test_wall_that_is_never_left_is_grazed_by_nothing() -> None:
    force = pc.Forcing((pc.Harmonic(0.3, 2.0),), constant=-1.0)

    assert len(pc.singularity_set(pc.impact_oscillator(0.8), force)) == 0


def test_grazes_at_all_instants_make_closed_curves() -> None:
    force = pc.Forcing((pc.Harmonic(0.1, 2.0),), constant=1.0)
    osc = pc.Oscillator(1.0, 0.02, (pc.Wall(0.0, "below", 0.8), pc.Wall(1.5, "above", 0.8)))
    curves = pc.singularity_set(osc, force, 1, touched=0).curves

    assert [curve.ends for curve in curves] == ["closed"]
    assert curves[0].cycle[-1] == pytest.approx(curves[0].cycle[0] + 1.0, abs=1e-12)
    assert curves[0].v_after[-1] == pytest.approx(curves[0].v_after[0], abs=1e-12)


def test_curves_without_number_are_cut_off_and_say_so() -> None:
    curves = pc.singularity_set(PENDULUM, pc.cosine(1.0, amplitude=1.4), max_points=3000)

    assert sum(len(curve) for curve in curves) < 6100
    assert "unresolved" in {curve.ends for curve in curves}


def test_a_curve_that_turns_back_where_an_edge_is_grazed_is_whole() -> None:
    """Within 1e-4 of a period of grazes it goes down to v = 0.3 and comes back to v = 0.38."""
    stops = (pc.Wall("-0.565", "below", "0.436"), pc.SoftStop("1.5", "above", 30))
    osc = pc.Oscillator(0, 0.08312382304680543, stops)
    force = pc.cosine(1.7200012881854545, amplitude=0.8939372099284666, phase=1.9179135191419552)

    curves = pc.singularity_set(osc, force)

    # By an independent way the map jumps here.
    cycle, v = 0.5407289215845, 0.3450849907627
    near = [
        np.hypot((c.cycle - cycle + 0.5) % 1.0 - 0.5, c.v_after - v).min() for c in curves.curves
    ]
    assert min(near) < 0.005


def test_the_edge_of_a_soft_stop_is_grazed_from_inside_too() -> None:
    stops = (pc.SoftStop("0.8", "above", 17, "0.2"), pc.SoftStop("-1.5", "below", 20))
    osc = pc.Oscillator("-0.3", "0.13", stops)
    force = pc.cosine("3.1", amplitude="0.47", phase=4)
    singular = pc.singularity_set(osc, force, 1)
    period = singular.forcing.period
    assert period is not None

    inside = [curve for curve in singular.curves if (curve.duration < 0.4 * period).all()]

    assert inside
    step = pc.impact_map(osc, force, 1)
    for curve in inside:
        k = len(curve) // 2
        t, v = float(curve.cycle[k]) * period, float(curve.v_after[k])
        run = pc.simulate(osc, force, x0="-1.5", v0=v, t0=t, t_end=t + 1.5 * period)
        depths = -1.5 - np.array([run(t + part * curve.duration[k])[0] for part in (0.5, 1.0)])
        assert depths[0] > 1e-6
        assert abs(depths[1]) < 1e-10
        assert abs(run(t + curve.duration[k])[1]) < 1e-8
        # On one side it comes out and in again at once, on the other it stays inside.
        speeds = step(np.full(2, curve.cycle[k] % 1.0), v * np.array([1 - 1e-6, 1 + 1e-6]))[1]
        assert np.abs(speeds).min() < 0.02 * np.abs(speeds).max()


def test_to_xarray_holds_all_points() -> None:
    curves = pc.singularity_set(WALL, pc.cosine(2.5), n_iterates=2)
    data = curves.to_xarray()
    assert (data.v_after.attrs["units"], data.duration.attrs["units"]) == ("length/time", "time")

    assert data.sizes["point"] == sum(len(curve) for curve in curves)
    assert data.iterate.values.tolist() == [curve.iterate for curve in curves]
    np.testing.assert_array_equal(data.v_after[data.number == 1], curves[1].v_after)


@pytest.mark.parametrize(
    ("osc", "force", "options", "words"),
    [
        (pc.impact_oscillator(0.0), pc.cosine(2.5), {"n_iterates": 2}, "restitution 0"),
        (WALL, pc.cosine(2.5), {"n_iterates": 0}, "not a whole number from 1 to 1000"),
        (WALL, pc.cosine(2.5), {"stop": 1}, "the oscillator has 1 stop"),
        (WALL, pc.cosine(2.5), {"touched": 3}, "the oscillator has 1 stop"),
        (WALL, pc.cosine(2.5), {"spacing": 0.0}, "not positive"),
        (WALL, pc.cosine(2.5), {"longest": math.inf}, "not finite"),
        (WALL, pc.Forcing(), {}, "periodic forcing"),
    ],
)
def test_bad_input_is_told(
    osc: pc.Oscillator, force: pc.Forcing, options: dict[str, float], words: str
) -> None:
    with pytest.raises(pc.ParameterError, match=words):
        pc.singularity_set(osc, force, **options)  # type: ignore[arg-type]
