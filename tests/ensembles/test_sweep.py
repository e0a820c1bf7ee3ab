from __future__ import annotations

import math

import numpy as np
import pytest
from tests.ensembles.studies import failing

import percuss as pc
from percuss.ensembles.grid import Axis, Grid
from percuss.ensembles.measures import INTERVALS, Window
from percuss.ensembles.sweep import Measured
from percuss.model.exact import as_float
from percuss.model.paths import get_parameter
from percuss.model.start import Start
from percuss.motion.growth import fit_power_law

OSC = pc.impact_oscillator(restitution=0.8)
FORCE = pc.cosine(2.5)
OMEGA = "forcing.omega"


def test_dimensions_are_called_what_was_asked_for_with_units() -> None:
    data = pc.sweep("period", OSC, FORCE, over={"forcing.omega": [2.5, 2.67]}, start=(0.0, 1.0))

    assert data.period.dims == (OMEGA,)
    assert data[OMEGA].attrs["units"] == "1/time"
    assert data.period.values.tolist() == [1.0, 2.0]
    assert data.attrs["complete"] == 1


def test_built_in_measures_are_those_of_a_run() -> None:
    period = float(FORCE.period or math.nan)

    def speed(run: pc.Trajectory) -> float:
        late = run.impacts.t >= 200 * period
        return float(np.abs(run.impacts.v_before[late]).max())

    def rate(run: pc.Trajectory) -> float:
        return float((run.impacts.t >= 200 * period).sum() / 64)

    def farthest(run: pc.Trajectory) -> float:
        t = np.linspace(200 * period, 264 * period, 400_001)
        return float(np.abs(run(t)[0]).max())

    # Few periods apart from a stable orbit: chaos would not agree with itself.
    over = {"oscillator.stops.0.restitution": [0.75, 0.8], "start.v0": [1.0, 0.5]}
    names = ["peak_impact_velocity", "impacts_per_period", "peak_displacement"]
    data = pc.sweep(names, OSC, FORCE, over=over, start=(0.0, 1.0))

    for name, measure in zip(names, (speed, rate, farthest), strict=True):
        own = pc.sweep(measure, OSC, FORCE, over=over, start=(0.0, 1.0))
        # Samples miss the farthest point by up to x'' dt^2 / 8.
        np.testing.assert_allclose(data[name], own[measure.__name__], rtol=1e-7)


def test_a_period_of_an_orbit_loses_what_its_impact_loses() -> None:
    """Undamped and one impact a period: (1 - r^2) v^2 / 2."""
    data = pc.sweep(
        ["dissipated_energy", "peak_impact_velocity", "impacts_per_period"],
        OSC,
        FORCE,
        over={"forcing.amplitude": [1.0, 2.0]},
        start=(0.0, 1.0),
    )

    np.testing.assert_array_equal(data.impacts_per_period, 1.0)
    v = data.peak_impact_velocity.values
    np.testing.assert_allclose(data.dissipated_energy, 0.5 * (1 - 0.64) * v**2, rtol=1e-9)
    # The equation has no length of its own with the wall at 0.
    np.testing.assert_allclose(v[1] / v[0], 2.0, rtol=1e-9)


def test_the_main_resonance_grows_linearly() -> None:
    data = pc.sweep(
        "growth_exponent",
        pc.impact_oscillator(),
        pc.sine(2),
        over={"start.v0": [1.0, 2.0]},
        transient=0,
        periods=2000,
    )

    np.testing.assert_allclose(data.growth_exponent, 1.0, atol=0.01)


def test_each_motion_is_followed_once_for_all_measures_except_a_period_with_an_exponent() -> None:
    """What is counted is what was done, and a measure does not depend on its company."""
    over = {"forcing.omega": [2.5, 2.8], "start.v0": [0.5, 1.0]}
    window = {"transient": 20, "periods": 128}
    names = ["impacts_per_period", "growth_exponent", "peak_displacement", "dissipated_energy",
             "peak_impact_velocity", "period", "largest_lyapunov_exponent"]  # fmt: skip
    alone = {
        name: pc.sweep(name, OSC, FORCE, over=over, **window)  # type: ignore[arg-type]
        for name in names
    }
    once = alone["impacts_per_period"].attrs["n_impacts"]

    no_period = [name for name in names if name != "period"]
    together = pc.sweep(no_period, OSC, FORCE, over=over, **window)  # type: ignore[arg-type]
    everything = pc.sweep(names, OSC, FORCE, over=over, **window)  # type: ignore[arg-type]

    assert {found.attrs["n_impacts"] for found in alone.values()} == {once}
    assert together.attrs["n_impacts"] == once
    assert everything.attrs["n_impacts"] == 2 * once
    for name in names:
        np.testing.assert_array_equal(everything[name], alone[name][name])
        if name != "period":
            np.testing.assert_array_equal(together[name], alone[name][name])


def test_growth_is_fitted_to_the_fastest_impact_of_each_interval() -> None:
    """Held against the impacts of the run itself."""
    osc, force, periods = pc.impact_oscillator(restitution=0.9), pc.cosine(2.8), 400
    data = pc.sweep("growth_exponent", osc, force, over={}, start=(0.0, 1.0), transient=0,
                     periods=periods)  # fmt: skip
    run = pc.simulate(osc, force, v0=1.0, periods=periods)
    edges = INTERVALS * run.t_end
    stretch = np.searchsorted(edges, run.impacts.t, side="right") - 1
    peaks = [np.abs(run.impacts.v_before[stretch == k]).max(initial=0.0) for k in range(24)]
    middle = np.sqrt(edges[1:] * edges[:-1])
    hit = np.array(peaks) > 0.0

    expected = fit_power_law(middle[hit], np.array(peaks)[hit]).exponent
    assert float(data.growth_exponent) == pytest.approx(expected, rel=1e-9)


def test_points_without_an_answer_hold_nan_and_say_why() -> None:
    first = r"3 of 4 points have no answer, the first at oscillator\.stops\.0\.restitution = 0\.8, "
    with pytest.warns(UserWarning, match=first + r"start\.x0 = -0\.1; the commonest reason"):
        data = pc.sweep(
            "impacts_per_period",
            OSC,
            FORCE,
            over={"oscillator.stops.0.restitution": [0.8, 1.5], "start.x0": [-0.1, 0.5]},
            transient=10,
            periods=10,
        )

    assert np.isnan(data.impacts_per_period.values).tolist() == [[True, False], [True, True]]
    assert data.point.values.tolist() == [0, 2, 3]
    assert "use a SoftStop" in data.reason.values[0]
    assert "restitution = 1.5" in data.reason.values[1]


def test_the_traceback_of_a_measure_is_kept_and_the_sweep_goes_on() -> None:
    with pytest.warns(UserWarning, match=r"1 of 3 points have no answer.*RuntimeError: no answer"):
        data = pc.sweep(failing, OSC, FORCE, over={"forcing.omega": [2.0, 2.6, 2.4]})

    assert data.failing.values[[0, 2]].tolist() == [1.0, 1.0]
    assert np.isnan(data.failing.values[1])
    assert data.point.values.tolist() == [1]
    assert 'raise RuntimeError("no answer here")' in data.reason.values[0]


def test_a_function_without_a_name_in_a_module_is_refused_by_processes_in_a_sentence() -> None:
    over = {"forcing.omega": [2.0, 2.6]}

    with pytest.raises(pc.ParameterError, match='in a module, or take engine="threads"'):
        pc.sweep(lambda osc, force: 1.0, OSC, FORCE, over=over, engine="processes")  # noqa: ARG005


def test_what_is_no_number_is_a_sentence_for_each_point_and_counted() -> None:
    def partial_measure(osc: pc.Oscillator, force: pc.Forcing) -> float:
        omega = as_float(get_parameter(osc, force, None, "forcing.omega"))
        return "chaos" if omega > 2.5 else 1.0  # type: ignore[return-value]

    with pytest.warns(
        UserWarning, match=r"2 of 3 points have no answer, .*omega = 2\.6; the reason"
    ):
        data = pc.sweep(partial_measure, OSC, FORCE, over={"forcing.omega": [2.0, 2.6, 2.7]})

    assert data.attrs["failed"] == 2
    assert "returned 'chaos', which is no number" in data.reason.values[0]
    assert len(data.reason.values[0].splitlines()) == 1
    with pytest.warns(
        UserWarning,
        match=r"partial_measure has no answer for any of 2 points; the reason \(2 of 2\)",
    ):
        pc.sweep(partial_measure, OSC, FORCE, over={"forcing.omega": [2.6, 2.7]})


def test_a_motion_with_too_many_impacts_is_given_up() -> None:
    with pytest.warns(UserWarning, match="more than 50 impacts"):
        data = pc.sweep(
            "period", OSC, FORCE, over={"start.v0": [1.0]}, start=(0.0, 1.0), max_impacts=50
        )

    assert np.isnan(data.period.values[0])
    assert data.reason.values[0] == "more than 50 impacts before the end"


def test_a_term_of_a_fourier_sum_may_vanish_inside_a_range() -> None:
    force = pc.fourier(2.5, cos=(1.0, 0.2))

    data = pc.sweep(
        "peak_impact_velocity",
        OSC,
        force,
        over={"forcing.cos.1": [0.0, 0.1, 0.0]},
        start=(0.0, 1.0),
    )

    alone = pc.sweep("peak_impact_velocity", OSC, FORCE, over={"start.v0": [1.0]}, start=(0.0, 1.0))
    assert data.peak_impact_velocity.values[0] == alone.peak_impact_velocity.values[0]
    assert data.peak_impact_velocity.values[2] == alone.peak_impact_velocity.values[0]


def test_a_sweep_can_be_stopped_and_returns_what_is_done() -> None:
    done = []

    def stop(points: float, total: float) -> bool:
        done.append((points, total))
        return False

    data = pc.sweep(
        failing,
        OSC,
        FORCE,
        over={"forcing.omega": np.linspace(1.0, 2.0, 100)},
        progress=stop,
        n_workers=1,
    )

    assert data.attrs["complete"] == 0
    assert len(done) == 1
    assert int(np.isfinite(data.failing.values).sum()) == done[0][0] == 16


@pytest.mark.parametrize(
    ("over", "measure", "message"),
    [
        ({"forcing.omga": [1.0]}, "period", "did you mean"),
        ({"forcing.omega": []}, "period", "an axis without values"),
        ({"forcing.omega": [1.0, math.nan]}, "period", "nan"),
        ({"forcing.omega": 2.0}, "period", "not a list of values"),
        ({"forcing.omega": [[1.0, 2.0]]}, "period", "not a"),
        ({"forcing.omega": [1.0], "forcing.harmonics.0.omega": [2.0]}, "period", "named twice"),
        ({"forcing.omega": [1.0]}, "perod", "did you mean period"),
        ({"forcing.omega": [1.0]}, "max_displacement_1", 'write "max_displacement" and on=1'),
        ({"forcing.omega": [1.0]}, [], "none at all"),
    ],
)
def test_what_is_wrong_with_a_call_is_said(
    over: dict[str, object], measure: str, message: str
) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.sweep(measure, OSC, FORCE, over=over)


def test_a_built_in_measure_needs_a_period() -> None:
    with pytest.raises(pc.ParameterError, match=r"forcing\.period"):
        pc.sweep("period", OSC, pc.cosine("1.3") + pc.cosine("2.9"), over={"start.v0": [1.0]})


def test_chunks_are_of_a_tenth_of_a_second_or_more_and_never_too_many() -> None:
    def chunk(size: int, periods: int, path: str = "start.v0") -> tuple[int, int]:
        axis = Axis(path, (1.0,) * size)
        grid = Grid(OSC, FORCE, Start(0.0, 1.0), (axis,))
        job = Measured(grid, ("period",), Window(0, periods), 10**6)
        return job.chunk, -(-job.size // job.chunk)

    assert chunk(100_000, 1000) == (2000, 50)
    # To make the law of each point takes as long as a thousand impacts.
    assert chunk(100_000, 1000, "forcing.harmonics.0.omega") == (1000, 100)
    assert chunk(100_000, 10) == (8192, 13)
    assert chunk(10, 10_000_000) == (1, 10)
    # Forty million points of a thousand periods.
    points, chunks = chunk(40_000_000, 1000)
    assert chunks <= 20_000
    assert points == 2000


def test_least_and_largest_displacement_are_the_extremes_of_the_run() -> None:
    osc, force = pc.impact_oscillator("0.7", wall="-0.2", damping="0.05"), pc.cosine("1.7")
    names = ["min_displacement", "max_displacement"]

    data = pc.sweep(names, osc, force, over={"forcing.omega": [1.7]}, transient=20, periods=10)

    run = pc.simulate(osc, force, periods=30)
    exact = run.extremes("displacement", between=(run.t_end * 2 / 3, run.t_end))
    assert data["min_displacement"].item() == pytest.approx(exact.minimum, abs=1e-12)
    assert data["max_displacement"].item() == pytest.approx(exact.maximum, abs=1e-12)


def test_extremes_of_a_sweep_are_on_this_side_of_the_walls() -> None:
    walls = pc.Wall("-0.5", "below", "0.9"), pc.Wall("0.5", "above", "0.7")
    osc = pc.Oscillator(damping="0.03", stops=walls)
    data = pc.sweep(
        ("min_displacement", "max_displacement"), osc, pc.cosine(1, amplitude="1.51"),
        over={"forcing.omega": [0.9, 1.0, 1.1], "oscillator.damping": [0.03, 0.15]},
        transient=100, periods=64,
    )  # fmt: skip
    assert (data.min_displacement.values == -0.5).all()
    assert (data.max_displacement.values == 0.5).all()
