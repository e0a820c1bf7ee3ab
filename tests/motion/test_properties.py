from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import percuss as pc
from percuss.arrays import Floats
from percuss.model.exact import as_float
from percuss.model.oscillator import Side

STIFFNESSES = st.sampled_from([-0.5, 0.0, 1e-6, 1.0, 4.0, 30.0])
DAMPINGS = st.sampled_from([0.0, 1e-3, 0.1, 1.0, 3.0])
RESTITUTIONS = st.sampled_from([1.0, 0.9, 0.5, 0.1])
SMALL = st.floats(-1.0, 1.0)


@st.composite
def forcings(draw: st.DrawFn) -> pc.Forcing:
    n = draw(st.integers(1, 3))
    harmonics = tuple(
        pc.Harmonic(draw(st.floats(0.1, 2.0)), draw(st.floats(0.2, 5.0)), draw(st.floats(0.0, 6.0)))
        for _ in range(n)
    )
    return pc.Forcing(harmonics=harmonics, constant=draw(SMALL))


@st.composite
def oscillators(draw: st.DrawFn) -> pc.Oscillator:
    """With any of: a wall on either side, a soft stop on either side."""
    stops: list[pc.Wall | pc.SoftStop] = []
    if draw(st.booleans()):
        stops.append(pc.Wall(-1.5, "below", draw(RESTITUTIONS)))
    if draw(st.booleans()):
        stops.append(pc.Wall(1.5, "above", draw(RESTITUTIONS)))
    sides: list[tuple[float, Side]] = [(-0.5, "below"), (0.75, "above")]
    for at, side in sides:
        if draw(st.booleans()):
            stiffness = draw(st.sampled_from([-0.5, 1.0, 50.0, 1e4]))
            stops.append(pc.SoftStop(at, side, stiffness, draw(st.sampled_from([0.0, 0.5]))))
    return pc.Oscillator(draw(STIFFNESSES), draw(DAMPINGS), tuple(stops))


def is_well_conditioned(run: pc.Trajectory) -> bool:
    """Without near-grazes, slow impacts or contacts, where a rounding grows by its own nature."""
    speeds = np.abs([*run.impacts.v_before, *run.crossings.v])
    return len(run.contacts) == 0 and len(run.grazes) == 0 and bool((speeds > 0.1).all())


@given(
    stiffness=STIFFNESSES, damping=DAMPINGS, force=forcings(), x0=SMALL, v0=SMALL,
    middle=st.floats(0.01, 7.99),
)  # fmt: skip
def test_flight_in_two_parts_is_the_flight(
    stiffness: float, damping: float, force: pc.Forcing, x0: float, v0: float, middle: float
) -> None:
    osc = pc.Oscillator(stiffness, damping)
    whole = pc.simulate(osc, force, x0, v0, t_end=8.0)
    x, v = whole(middle)
    rest = pc.simulate(osc, force, float(x), float(v), middle, t_end=8.0)

    # Rounding of the state in the middle, grown over the rest.
    size = 1.0 + float(np.abs(whole(np.linspace(0.0, 8.0, 50))).max())
    np.testing.assert_allclose(rest(8.0), whole(8.0), atol=1e-12 * size)


@given(osc=oscillators(), force=forcings(), x0=st.floats(-0.4, 0.4), v0=SMALL)
@settings(max_examples=60)
def test_energy_changes_by_the_work_of_forcing_dashpots_and_impacts(
    osc: pc.Oscillator, force: pc.Forcing, x0: float, v0: float
) -> None:
    run = pc.simulate(osc, force, x0, v0, t_end=4.0, max_impacts=50)

    lost = 0.5 * float((run.impacts.v_before**2 - run.impacts.v_after**2).sum())
    # A chatter's tail is not in `impacts`: its energy is that of the last hop.
    lost += sum(0.5 * run.impacts.v_after[n - 1] ** 2 for n in run.contacts.n_impacts if n > 0)
    work = work_of(run, osc, force) - lost
    gain = float(run.energy(run.t_end) - run.energy(run.t0))
    size = 1.0 + float(run.energy(np.linspace(run.t0, run.t_end, 200)).max())
    assert abs(gain - work) <= 1e-9 * size


def work_of(run: pc.Trajectory, osc: pc.Oscillator, force: pc.Forcing) -> float:
    """Return the work of forcing and dashpots by Gauss-Legendre quadrature between events."""
    contacts = [*run.contacts.start, *run.contacts.release]
    ends = np.array([run.t0, *run.impacts.t, *run.crossings.t, *contacts, run.t_end])
    ends = np.unique(ends[np.isfinite(ends) & (ends <= run.t_end)])
    nodes, weights = np.polynomial.legendre.leggauss(24)
    total = 0.0
    for left, right in pairwise(ends):
        # Short against the fastest motion and decay here, 100 rad a unit of time.
        count = math.ceil((right - left) / 0.05)
        edges = np.linspace(left, right, count + 1)
        half = 0.5 * np.diff(edges)
        t = np.clip((edges[:-1] + half)[:, None] + half[:, None] * nodes, left, right)
        x, v = run(t)
        power = driving(force, t) * v - 2.0 * dashpot(osc, x) * v**2
        total += float((power * weights * half[:, None]).sum())
    return total


def driving(force: pc.Forcing, t: Floats) -> Floats:
    value = np.full_like(t, as_float(force.constant))
    for part in force.components():
        omega = float(part.omega)
        value += part.cos * np.cos(omega * t) + part.sin * np.sin(omega * t)
    return value


def dashpot(osc: pc.Oscillator, x: Floats) -> Floats:
    damping = np.full_like(x, as_float(osc.damping))
    for stop in osc.stops:
        if isinstance(stop, pc.SoftStop):
            depth = x - as_float(stop.at)
            touched = depth > 0.0 if stop.side == "above" else depth < 0.0
            damping += np.where(touched, as_float(stop.damping), 0.0)
    return damping


@given(osc=oscillators(), omega=st.floats(0.5, 4.0), x0=st.floats(-0.4, 0.4), v0=SMALL)
def test_starting_one_period_later_shifts_the_motion_by_a_period(
    osc: pc.Oscillator, omega: float, x0: float, v0: float
) -> None:
    force = pc.cosine(omega, phase=0.3)
    assert force.period is not None
    now = pc.simulate(osc, force, x0, v0, t_end=6.0, max_impacts=30)
    assume(is_well_conditioned(now))

    later = pc.simulate(osc, force, x0, v0, force.period, t_end=force.period + 6.0, max_impacts=30)

    # The period is a rounded one, and the end may cut the last event off.
    n = min(len(now.impacts), len(later.impacts))
    assert abs(len(now.impacts) - len(later.impacts)) <= 1
    np.testing.assert_allclose(
        later.impacts.t[:n] - force.period, now.impacts.t[:n], atol=1e-9, rtol=0
    )


@given(
    osc=oscillators(), force=forcings(), x0=st.floats(-0.4, 0.4), v0=SMALL,
    exponent=st.integers(-200, 200),
)  # fmt: skip
def test_a_scale_that_is_a_power_of_two_changes_no_bit_of_the_times(
    osc: pc.Oscillator, force: pc.Forcing, x0: float, v0: float, exponent: int
) -> None:
    """A linear equation has no scale of its own: chatter, grazes and all."""
    scale = 2.0**exponent
    stops = tuple(replace(stop, at=as_float(stop.at) * scale) for stop in osc.stops)
    harmonics = tuple(
        pc.Harmonic(as_float(part.amplitude) * scale, part.omega, part.phase)
        for part in force.harmonics
        if isinstance(part, pc.Harmonic)
    )
    large = pc.Forcing(harmonics=harmonics, constant=as_float(force.constant) * scale)

    run = pc.simulate(osc, force, x0, v0, t_end=6.0, max_impacts=50)
    scaled = pc.simulate(
        pc.Oscillator(osc.stiffness, osc.damping, stops), large, x0 * scale, v0 * scale,
        t_end=6.0, max_impacts=50,
    )  # fmt: skip

    assert scaled.impacts.t.tolist() == run.impacts.t.tolist()
    assert scaled.crossings.t.tolist() == run.crossings.t.tolist()
    assert scaled.contacts.start.tolist() == run.contacts.start.tolist()
    assert (scaled.impacts.v_after / scale).tolist() == run.impacts.v_after.tolist()


@given(osc=oscillators(), force=forcings(), x0=st.floats(-0.4, 0.4), v0=SMALL)
def test_mirrored_motion_is_the_mirror_of_the_motion(
    osc: pc.Oscillator, force: pc.Forcing, x0: float, v0: float
) -> None:
    stops = tuple(
        replace(stop, at=-as_float(stop.at), side="above" if stop.side == "below" else "below")
        for stop in osc.stops
    )
    harmonics = tuple(
        pc.Harmonic(-as_float(part.amplitude), part.omega, part.phase)
        for part in force.harmonics
        if isinstance(part, pc.Harmonic)
    )
    mirrored = pc.Forcing(harmonics=harmonics, constant=-as_float(force.constant))

    run = pc.simulate(osc, force, x0, v0, t_end=6.0, max_impacts=30)
    assume(is_well_conditioned(run))
    other = pc.simulate(
        pc.Oscillator(osc.stiffness, osc.damping, stops), mirrored, -x0, -v0,
        t_end=6.0, max_impacts=30,
    )  # fmt: skip

    np.testing.assert_allclose(other.impacts.t, run.impacts.t, rtol=1e-10)
    np.testing.assert_allclose(other.impacts.v_after, -run.impacts.v_after, rtol=1e-8)
    assert other.impacts.stop.tolist() == run.impacts.stop.tolist()
    assert other.crossings.direction.tolist() == run.crossings.direction.tolist()


@given(
    eighths=st.integers(-40, 40), stiffness=st.sampled_from([0.25, 1.0, 4.0]),
    damping=st.sampled_from([0.0, 0.125]), restitution=RESTITUTIONS, v0=st.floats(0.5, 2.0),
)  # fmt: skip
def test_preload_is_a_shift_of_the_wall(
    eighths: int, stiffness: float, damping: float, restitution: float, v0: float
) -> None:
    """x = y + d with a wall at d, constant force K d: exact in binary."""
    d = eighths / 8.0
    here = pc.impact_oscillator(restitution, stiffness=stiffness, damping=damping)
    moved = pc.impact_oscillator(restitution, wall=d, stiffness=stiffness, damping=damping)

    run = pc.simulate(here, pc.sine(2.7), v0=v0, t_end=9.0)
    shifted = pc.simulate(moved, pc.sine(2.7, constant=stiffness * d), d, v0, t_end=9.0)

    assert shifted.impacts.t.tolist() == run.impacts.t.tolist()
    assert shifted.impacts.v_after.tolist() == run.impacts.v_after.tolist()


def test_soft_stop_tends_to_the_wall_like_the_root_of_its_compliance() -> None:
    """At fixed times away from impacts, r = 1: a hundred times the stiffness, a tenth the error."""
    t = np.array([2.0, 5.0, 8.0])
    rigid = pc.simulate(pc.impact_oscillator(), pc.cosine(2.6), v0=1.0, t_end=9.0)
    errors = []
    for stiffness in (1e6, 1e8, 1e10, 1e12, 1e14):
        osc = pc.bilinear_oscillator(stiffness_below=stiffness)
        run = pc.simulate(osc, pc.cosine(2.6), v0=1.0, t_end=9.0)
        assert len(run.crossings) == 2 * len(rigid.impacts)
        errors.append(float(np.abs(run(t)[0] - rigid(t)[0]).max()))
    ratios = np.array(errors[:-1]) / np.array(errors[1:])

    np.testing.assert_allclose(ratios, 10.0, rtol=0.1)
    assert errors[-1] < 1e-5


@given(osc=oscillators(), force=forcings(), x0=st.floats(-0.4, 0.4), v0=SMALL)
@settings(max_examples=40)
def test_same_inputs_give_the_same_bits_whole_or_limited(
    osc: pc.Oscillator, force: pc.Forcing, x0: float, v0: float
) -> None:
    calls: list[float] = []

    def report(done: float, _: float) -> bool:
        calls.append(done)
        return True

    run = pc.simulate(osc, force, x0, v0, t_end=10.0, max_impacts=60)
    again = pc.simulate(osc, force, x0, v0, t_end=10.0, max_impacts=60, progress=report)
    limited = pc.simulate(osc, force, x0, v0, t_end=10.0, max_impacts=5)

    assert again.impacts.t.tolist() == run.impacts.t.tolist()
    assert again.crossings.v.tolist() == run.crossings.v.tolist()
    n = len(limited.impacts)
    assert limited.impacts.t.tolist() == run.impacts.t[:n].tolist()
    assert limited.impacts.v_after.tolist() == run.impacts.v_after[:n].tolist()


def test_long_runs_give_the_same_bits_however_the_arrays_grow() -> None:
    """150,000 impacts outgrow the first arrays; a smaller limit cuts them elsewhere."""
    osc, force = pc.impact_oscillator(0.95), pc.cosine(2.7)
    run = pc.simulate(osc, force, v0=1.0, max_impacts=150_000)
    for limit in (9_999, 10_001, 65_530, 65_540, 140_000):
        part = pc.simulate(osc, force, v0=1.0, max_impacts=limit)
        assert part.impacts.v_after.tolist() == run.impacts.v_after[:limit].tolist()
