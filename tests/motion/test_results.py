from __future__ import annotations

import copy
import math
import pickle
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import percuss as pc

MIXED = pc.Oscillator(
    1.0, 0.02, (pc.Wall(-1.0, "below", 0.7), pc.SoftStop(0.5, "above", 29.0, 0.3))
)


def run_of_all_kinds() -> pc.Trajectory:
    return pc.simulate(MIXED, pc.sine(2.0, amplitude=2.0), x0=0.2, t_end=60.0)


def test_limits_of_the_motion_at_an_impact_are_its_velocities() -> None:
    run = run_of_all_kinds()

    x, before = run(run.impacts.t, "before")
    _, after = run(run.impacts.t)

    assert len(run.impacts) > 5
    np.testing.assert_allclose(x, -1.0, atol=1e-14)
    np.testing.assert_allclose(before, run.impacts.v_before, atol=1e-13)
    assert after.tolist() == run.impacts.v_after.tolist()
    np.testing.assert_allclose(run.impacts.impulse, 1.7 * -before, atol=1e-13)


def test_motion_has_the_shape_of_the_times_in_any_order() -> None:
    run = run_of_all_kinds()
    t = np.random.default_rng(1).uniform(0.0, 60.0, (7, 5))

    x, v = run(t)

    one_by_one = np.array([[run(s) for s in row] for row in t])
    assert x.tolist() == one_by_one[..., 0].tolist()
    assert v.tolist() == one_by_one[..., 1].tolist()
    assert run([])[0].shape == (0,)
    assert run(3.0)[0].shape == ()


def test_sample_spans_the_run_and_stroboscopic_takes_whole_periods() -> None:
    run = run_of_all_kinds()

    samples, strobe = run.sample(101), run.stroboscopic()

    assert (float(samples.t[0]), float(samples.t[-1])) == (0.0, 60.0)
    assert samples.x.to_numpy().tolist() == run(samples.t)[0].tolist()
    np.testing.assert_allclose(strobe.t, math.pi * np.arange(20), rtol=1e-15)
    assert strobe.v.to_numpy().tolist() == run(strobe.t)[1].tolist()


def test_forces_add_up_to_the_acceleration() -> None:
    run = run_of_all_kinds()
    t = np.linspace(0.01, 59.99, 500)

    forces = run.forces(t)

    total = forces.spring + forces.damping + forces.forcing + forces.stops.sum("stop")
    h = 1e-5
    slope = (run(t + h)[1] - run(t - h)[1]) / (2 * h)
    events = np.concatenate([run.impacts.t, run.crossings.t])
    smooth = np.abs(t[:, None] - events).min(axis=1) > 2 * h
    np.testing.assert_allclose(total.to_numpy()[smooth], slope[smooth], atol=1e-6)


def test_wall_reacts_in_contact_with_what_all_others_push() -> None:
    run = pc.simulate(
        pc.impact_oscillator(0.0, wall=0.5), pc.sine(1.0, constant=-2.0), x0=0.5, t_end=3.0
    )

    forces = run.forces([1.0])

    assert float(forces.stops[0, 0]) == pytest.approx(0.5 + 2.0 - math.sin(1.0), rel=1e-14)


def test_energy_counts_the_springs_in_touch() -> None:
    run = pc.simulate(pc.bilinear_oscillator(stiffness_below=9.0), v0=2.0, t_end=9.0)

    np.testing.assert_allclose(run.energy(np.linspace(0, 9, 50)), 2.0, rtol=1e-13)


def test_times_outside_the_run_are_refused_with_its_limits() -> None:
    run = run_of_all_kinds()
    for t in (-1e-9, 60.1, math.nan, math.inf, [1.0, 61.0]):
        with pytest.raises(pc.ParameterError, match=r"outside the run, 0\.0 to 60\.0"):
            run(t)
    with pytest.raises(pc.ParameterError, match="neither"):
        run(1.0, "left")  # type: ignore[arg-type]
    with pytest.raises(pc.ParameterError, match="n = 1: not a whole number of at least 2"):
        run.sample(1)


def test_everything_public_survives_pickling_and_copying() -> None:
    run = run_of_all_kinds()
    values = [
        run, run.impacts, run.crossings, run.contacts, run.grazes, run.outcome, MIXED,
        pc.fourier(2.0, cos=(1.0,)), pc.Start(0.0, "0.45"), pc.classify_impact_times(run),
        pc.ParameterError("a", 1, "b"), pc.OutputError("a", "b"), pc.StudyError(["a"]),
        pc.MissingExtraError("a", "b"),
    ]  # fmt: skip
    for value in values:
        for twin in (pickle.loads(pickle.dumps(value)), copy.deepcopy(value)):
            assert type(twin) is type(value)
            assert str(twin) == str(value)
    twin = pickle.loads(pickle.dumps(run))
    t = np.linspace(0.0, 60.0, 100)
    assert twin(t)[0].tolist() == run(t)[0].tolist()
    assert twin.impacts.t.tolist() == run.impacts.t.tolist()


def test_each_limit_has_its_outcome() -> None:
    free = pc.impact_oscillator(wall=-2.0)
    rows: list[tuple[pc.Trajectory, str]] = [
        (pc.simulate(free, v0=1.0, t_end=9.0), "reached_t_end"),
        (pc.simulate(free, v0=3.0, max_impacts=9), "reached_max_impacts"),
        (pc.simulate(free, v0=1.0, max_impacts=9), "no_more_impacts"),
        (
            pc.simulate(pc.impact_oscillator(0.5), pc.Forcing(constant=-1.0), 1.0, t_end=99),
            "at_rest",
        ),
        (pc.simulate(free, x0=1.0, v0=1e200, t_end=9.0), "overflow"),
    ]
    for run, name in rows:
        assert run.outcome.name == name
        assert run.outcome.value in repr(run)
        assert np.isfinite(run.t_end)
        assert np.isfinite(run.sample(3).x).all()


@pytest.mark.parametrize("t0", [0.0, 0.3, -7.1])
def test_time_outside_the_run_by_its_rounding_is_the_end_and_more_is_refused(t0: float) -> None:
    run = pc.simulate(pc.impact_oscillator(0.8), pc.cosine(2.0), 0.1, 0.3, t0, periods=7)
    ulp = float(np.spacing(max(abs(t0), abs(run.t_end))))

    for end, sign in ((run.t0, -1.0), (run.t_end, 1.0)):
        for n in (1, 4):
            assert [float(part) for part in run(end + sign * n * ulp)] == [
                float(part) for part in run(end)
            ]
        for n in (6, 1000):
            with pytest.raises(pc.ParameterError, match="outside the run"):
                run([end, end + sign * n * ulp])
    with pytest.raises(pc.ParameterError, match="outside the run"):
        run(math.nan)


@pytest.mark.parametrize("omega", ["2.1", "0.7", "3.3"])
def test_last_strobe_is_there_where_a_run_lasts_whole_periods(omega: str) -> None:
    for periods in (3, 7, 29):
        run = pc.simulate(
            pc.impact_oscillator(0.8), pc.cosine(omega), 0.1, 0.3, 0.1, periods=periods
        )

        assert run.stroboscopic().sizes["period"] == periods + 1


@pytest.mark.parametrize("t_end", [400.0, 1e4])
@pytest.mark.parametrize("stops", [(), (pc.Wall(-1.0, "below", 0.5),)], ids=["free", "wall"])
def test_growth_is_kept_up_to_where_it_passes_the_limit(
    t_end: float, stops: tuple[pc.Wall, ...]
) -> None:
    """cosh t from rest passes 1e150 at log(2e150)."""
    run = pc.simulate(pc.Oscillator(-1.0, 0.0, stops), x0=1.0, t_end=t_end)

    assert run.outcome is pc.Outcome.overflow
    assert run.t_end == pytest.approx(150 * math.log(10) + math.log(2), rel=1e-12)
    assert float(run(300.0)[0]) == pytest.approx(math.cosh(300.0), rel=1e-12)
    assert np.isfinite(run(np.linspace(0.0, run.t_end, 99))).all()


def test_limit_that_was_not_asked_for_is_told_with_its_numbers(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(sys.modules["percuss.motion.simulate"], "MOST_IMPACTS", 50)
    case = (pc.impact_oscillator(), pc.sine(3), 0.0, 0.51)

    with pytest.warns(pc.LimitWarning, match=r"at t = 157\.\d+ after 50 impacts.*max_impacts"):
        run = pc.simulate(*case, periods=10**9)

    assert run.outcome is pc.Outcome.reached_max_impacts
    # What was asked for is no reason to warn.
    assert len(pc.simulate(*case, max_impacts=50).impacts) == 50


def test_run_that_its_watcher_stops_holds_what_was_done() -> None:
    shares: list[float] = []

    def report(done: float, total: float) -> bool:
        shares.append(done / total)
        return len(shares) < 3

    run = pc.simulate(
        pc.impact_oscillator(), pc.sine(3), v0=0.51, max_impacts=3_000_000, progress=report
    )

    assert run.outcome is pc.Outcome.interrupted
    assert 0.0 < shares[0] < shares[1] < shares[2] < 1.0
    assert 0 < len(run.impacts) < 3_000_000
    assert run.t_end == run.impacts.t[-1]
    assert np.isfinite(run(run.t_end)).all()


BAD_CALLS: dict[str, tuple[Callable[[pc.Oscillator], Any], str]] = {
    "x0 not a number": (lambda osc: pc.simulate(osc, x0=math.nan, t_end=1.0), "x0 = nan"),
    "v0 infinite": (lambda osc: pc.simulate(osc, v0=math.inf, t_end=1.0), "v0 = inf"),
    "t0 not a number": (lambda osc: pc.simulate(osc, t0=math.nan, t_end=1.0), "t0 = nan"),
    "inside the wall": (lambda osc: pc.simulate(osc, x0=-1.1, t_end=1.0), "x0 = -1.1: below"),
    "end before start": (lambda osc: pc.simulate(osc, t0=2.0, t_end=1.0), "t_end = 1.0: not after"),
    "end at start": (lambda osc: pc.simulate(osc, t0=2.0, t_end=2.0), "t_end = 2.0: not after"),
    "end infinite": (lambda osc: pc.simulate(osc, t_end=math.inf), "t_end = inf"),
    "no limit": (pc.simulate, "no limit at all"),
    "no impacts": (lambda osc: pc.simulate(osc, max_impacts=0), "max_impacts = 0"),
    "half an impact": (lambda osc: pc.simulate(osc, max_impacts=1.5), "max_impacts = 1.5"),  # type: ignore[call-overload]
    "force a harmonic": (
        lambda osc: pc.simulate(osc, pc.Harmonic(1, 2), t_end=1),  # type: ignore[call-overload]
        "not a Forcing; give Forcing((harmonic,))",
    ),
    "force a list": (lambda osc: pc.simulate(osc, [1], t_end=1), "force = [1]: not a Forcing"),  # type: ignore[call-overload]
    "oscillator a text": (lambda _: pc.simulate("x", t_end=1), "osc = 'x': not an Oscillator"),  # type: ignore[call-overload]
    "periods and end": (
        lambda osc: pc.simulate(osc, pc.sine(1), t_end=1, periods=2),
        "periods = 2: given together with t_end = 1",
    ),
    "no period": (
        lambda osc: pc.simulate(osc, pc.sine(1) + pc.sine("1.5"), periods=2),
        "periods = 2: the forcing has no period; give forcing.period",
    ),
    "free motion has no period": (lambda osc: pc.simulate(osc, periods=2), "without harmonics"),
    "no periods": (lambda osc: pc.simulate(osc, pc.sine(1), periods=0), "periods = 0: not pos"),
    "end a word": (lambda osc: pc.simulate(osc, t_end="late"), "a multiple of pi such as"),
    "negative count": (lambda osc: pc.eigenset(osc, -1), "count = -1"),
}


@pytest.mark.parametrize(("call", "words"), BAD_CALLS.values(), ids=BAD_CALLS.keys())
def test_bad_input_is_refused_in_one_sentence_with_the_number(
    call: Callable[[pc.Oscillator], Any], words: str
) -> None:
    with pytest.raises(pc.ParameterError) as caught:
        call(MIXED)

    assert words in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_limit_beyond_all_integers_of_the_machine_is_a_limit() -> None:
    run = pc.simulate(pc.impact_oscillator(0.5), v0=1.0, t_end=10.0, max_impacts=10**30)

    assert run.outcome is pc.Outcome.reached_t_end


def test_times_may_be_multiples_of_pi_and_periods() -> None:
    osc, force = pc.impact_oscillator(), pc.sine(3)

    run = pc.simulate(osc, force, v0=1, t0="pi", t_end="20*pi")

    assert (run.t0, run.t_end) == (math.pi, 20 * math.pi)
    assert pc.simulate(osc, force, v0=1, t_end=pc.pi_times(20)).t_end == 20 * math.pi
    for periods in (30, "30"):
        assert pc.simulate(osc, force, v0=1, periods=periods).t_end == 20 * math.pi
    assert pc.simulate(osc, force, v0=1, t0="pi", periods="1.5").t_end == 2 * math.pi


def test_max_impacts_counts_entries_into_soft_stops_and_the_outcome_says_so() -> None:
    run = pc.simulate(MIXED, pc.sine(2.0, amplitude=2.0), x0=0.2, max_impacts=9)

    assert len(run.impacts) + (run.crossings.direction == "in").sum() == 9
    assert run.outcome.value == "the run reached max_impacts (impacts and entries into soft stops)"


@pytest.mark.parametrize("name", ["impacts", "crossings", "contacts", "grazes"])
def test_every_table_is_a_dataset_of_its_columns(name: str) -> None:
    table = getattr(run_of_all_kinds(), name)

    dataset = table.to_xarray()

    assert dict(dataset.sizes) == {name.removesuffix("s"): len(table)}
    for column, values in dataset.items():
        np.testing.assert_array_equal(values, getattr(table, str(column)))
        assert values.attrs["long_name"]
    frame = table.to_pandas()
    assert list(frame.columns) == list(dataset)
    assert len(frame) == len(table)


def test_a_force_by_itself_is_its_harmonics_and_records() -> None:
    knots, values = [0, 1, 3, 4], [0, 2, -1, 0]
    t = np.array([[-1.0, 0.0, 0.5], [2.0, 3.5, 7.25]])
    wave = 0.5 + 2 * np.cos(3 * t) + np.sin(1.5 * t)
    sum_of_both = pc.cosine(3, amplitude=2, constant="0.5") + pc.sine("1.5")
    line = np.interp(t, knots, values)
    again = np.interp(t % 4, knots, values)

    for record, expected in (
        (pc.record(knots, values), line),
        (pc.record(knots, values, outside="zero"), np.where((t >= 0) & (t <= 4), line, 0.0)),
        (pc.record(knots, values, repeat=True), again),
        (pc.record(knots, values, kind="hold"), np.take([0, 2, -1, 0], [[0, 0, 0], [1, 2, 3]])),
    ):
        own = pc.force_at(record + sum_of_both, t)
        assert own.shape == t.shape
        assert np.abs(own - wave - expected).max() < 1e-14

    assert pc.force_at(pc.cosine(2), 0.0) == 1.0
    # In the force's own dimension, with or without a mass that it moves.
    osc = pc.Oscillator.from_mass(4, stiffness=1, damping_coefficient=0)
    run = pc.simulate(osc, sum_of_both, t_end=10)
    times = np.linspace(0, 10, 11)
    assert np.abs(pc.force_at(sum_of_both, times) - run.forces(times).forcing).max() < 1e-14
    with pytest.raises(pc.ParameterError, match="t = nan: not a finite time"):
        pc.force_at(sum_of_both, [0.0, np.nan])
    with pytest.raises(pc.ParameterError, match="not a forcing; of loads give one"):
        pc.force_at(pc.Loads({0: sum_of_both}), 0.0)  # type: ignore[arg-type]
