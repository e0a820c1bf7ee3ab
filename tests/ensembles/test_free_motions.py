"""Sweeps and diagrams of motions without forcing: limit cycles, by sections in place of strobes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.orbits.test_limit_cycles import CYCLES, found, self_excited

import percuss as pc
from percuss.ensembles.repetition import counting_periods, repeat_times

UP = {"at": 0.0, "direction": "up"}
DAMPING = "oscillator.damping"
SECTIONS: list[Any] = [UP, {"at": 0.5}, {"at": 0.9, "direction": "down"}, "impacts"]


@pytest.mark.parametrize(("symmetric", "inside", "radius", "period", "_given"), CYCLES)
def test_limit_cycles_settle_on_their_period(
    symmetric: bool, inside: str, radius: float, period: float, _given: object
) -> None:
    """The digits of tests/orbits/test_limit_cycles.py, from a motion in place of equations."""
    osc = self_excited(inside, symmetric=symmetric)

    data = pc.sweep(
        ["period", "max_displacement"], osc, over={}, start=(0.5, 0.1), transient=400, section=UP
    )

    assert abs(data.period.item() - period) < 1e-11 * period
    assert abs(data.max_displacement.item() - radius) < 1e-10 * radius
    assert data.period.attrs["units"] == "time"


@pytest.mark.parametrize("section", SECTIONS, ids=str)
def test_the_period_is_the_same_at_every_section(section: Any) -> None:
    osc = self_excited("-0.05")

    data = pc.sweep("period", osc, over={}, start=(0.5, 0.1, -3.0), section=section)

    assert abs(data.period.item() - found(osc).period) < 1e-11


def test_a_diagram_of_limit_cycles_is_the_branch_of_the_orbit() -> None:
    osc = self_excited("-0.05")
    branch = pc.continue_orbit(found(osc), over={DAMPING: ("-0.09", "-0.01")})
    values = [-0.05, -0.04, -0.03]
    names = ["max_displacement", "mean_power", "dissipated_energy", "largest_lyapunov_exponent"]

    data = pc.bifurcation_diagram(
        osc,
        None,
        over={DAMPING: values},
        section=UP,
        starts=[(0.5, 0.1), (0.0, 6.0)],
        transient=400,
        measures=["period", *names],
    )

    assert "cycle" not in data
    order = np.argsort(branch.values)
    expected = np.interp(values, branch.values[order], branch.period[order])
    for name in data.branch.values:
        np.testing.assert_allclose(data.period.sel(branch=name), expected, atol=2e-6)
        one = data.max_displacement.sel(branch=name).values
        two = data.max_displacement.sel(branch="forward").values
        np.testing.assert_allclose(one, two, rtol=1e-9)
    # At x = 0 upwards the speed is one number.
    speeds = data.v.sel(branch="forward").values[:, :-1]
    assert float(np.ptp(speeds, axis=1).max()) < 1e-9
    np.testing.assert_allclose(data.mean_power, 0.0, atol=0)
    # What the dashpots outside take, the one inside gives: the energy is that of a point of the
    # cycle, after 63 times 2 pi as before.
    cycle = found(osc).trajectory()
    x, v = cycle(np.linspace(cycle.t0, cycle.t_end, 1000))
    between = float(np.ptp(0.5 * (x * x + v * v)))
    at_own = data.dissipated_energy.sel({DAMPING: -0.05}).values
    assert 0.0 < between < 0.5
    assert (np.abs(63 * at_own) <= between).all()
    np.testing.assert_allclose(data.largest_lyapunov_exponent, 0.0, atol=1e-3)
    assert np.isfinite(data.period).all()


def test_the_measures_of_a_diagram_are_those_of_a_sweep() -> None:
    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.5")
    over = {"forcing.omega": [2.5, 2.6, 2.7]}
    names = ["peak_stop_force", "rms_displacement", "period", "peak_impact_velocity"]

    diagram = pc.bifurcation_diagram(
        osc, force, over=over, starts=[(0.0, 1.0)], points=33, measures=names
    )
    swept = pc.sweep(names, osc, force, over=over, start=(0.0, 1.0), periods=32)

    for name in names:
        np.testing.assert_array_equal(
            diagram[name].sel(branch="start 0").values if name != "period" else swept[name],
            swept[name],
        )
        assert diagram[name].attrs.get("units") == swept[name].attrs["units"]


def test_a_free_oscillation_that_dies_or_never_starts_has_no_period() -> None:
    with pytest.warns(UserWarning, match="no motion has a point on the section"):
        data = pc.bifurcation_diagram(
            pc.Oscillator(1, "0.3"), None, over={DAMPING: [0.3]}, section={"at": 0.5}, follow=()
        )
    assert data.period.values.tolist() == [[0.0]]

    growing = pc.sweep("period", pc.Oscillator(1, "-0.1"), over={}, start=(0, 1), section=UP)
    assert growing.period.item() == 0.0, "its speeds grow"


def test_a_free_conservative_oscillation_has_the_period_of_its_closed_form() -> None:
    """Between x = 0 and an elastic wall at half its amplitude: two thirds of a half turn."""
    osc = pc.Oscillator(4, stops=(pc.Wall("0.5", "above", 1),))

    data = pc.sweep("period", osc, over={}, start=(0, 2), section=UP)

    assert abs(data.period.item() - (np.pi / 2.0 + np.pi / 6.0)) < 1e-12


@pytest.mark.parametrize("osc", [pc.Oscillator(0, -0.1), pc.Oscillator(-1, 0.1), pc.Oscillator(4)])
def test_time_is_counted_without_a_spring_too(osc: pc.Oscillator) -> None:
    laws = pc.model.system.law(osc, None)[np.newaxis]
    (unit,) = counting_periods(laws, np.zeros(1, dtype=np.int64))
    assert unit == pytest.approx(2.0 * np.pi / (2.0 if osc.stiffness == 4 else 1.0), rel=1e-15)


def test_times_of_points_wrap_and_settle() -> None:
    def points(t: list[float], v: list[float]) -> np.ndarray:
        own = np.array(t) / 10.0
        return np.stack([own - np.floor(own), np.array(v), np.zeros(len(t))], axis=1)

    t = [8.0, 9.0, 11.0, 12.0, 14.0, 15.0, 17.0]
    two = points(t, [1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 1.0])
    few = two.copy()
    few[4:] = np.nan
    none = np.full_like(two, np.nan)
    uneven = points([8.0, 9.0, 10.1, 11.3, 12.2, 13.0, 14.5], [1.0] * 7)
    times = repeat_times(np.stack([two, few, none, uneven]), np.full(4, 10.0))
    np.testing.assert_allclose(times, [3.0, 0.0, 0.0, 0.0], rtol=1e-14)


@pytest.mark.parametrize(
    ("section", "measure"), [("stroboscopic", "period"), ({"cycle": 0.5}, "period")]
)
def test_strobes_need_a_forcing(section: Any, measure: str) -> None:
    with pytest.raises(pc.ParameterError, match="without a forcing there are no strobes"):
        pc.sweep(measure, pc.Oscillator(1), over={}, section=section)
    with pytest.raises(pc.ParameterError, match="without a forcing there are no strobes"):
        pc.bifurcation_diagram(
            pc.Oscillator(1), pc.Forcing(constant=1), over={DAMPING: [0.1]}, section=section
        )


def test_a_forcing_without_a_period_counts_nothing() -> None:
    quasi = pc.cosine("1.3") + pc.cosine("2.9")
    message = r'this forcing has none; give "20\*pi", which .*, or between='
    with pytest.raises(pc.ParameterError, match=message):
        pc.sweep("peak_displacement", pc.Oscillator(1), quasi, over={})
    with pytest.raises(pc.ParameterError, match="or ask sweep for a measure between="):
        pc.bifurcation_diagram(pc.Oscillator(1), quasi, over={DAMPING: [0.1]}, section=UP)

    def ends(run: pc.Trajectory) -> float:
        return run.t_end

    with pytest.warns(UserWarning, match=message):
        pc.sweep(ends, pc.Oscillator(1), quasi, over={"start.v0": [1]})


def test_a_function_of_a_free_run_takes_it_over_whole_counts() -> None:
    def ends(run: pc.Trajectory) -> float:
        return run.t_end

    data = pc.sweep(ends, pc.Oscillator(4), over={}, start=(0, 1, 2), transient=1, periods=3)

    assert data.ends.item() == pytest.approx(2.0 + 4.0 * np.pi, rel=1e-15)


def test_a_store_of_free_motions_goes_on(tmp_path: Path) -> None:
    osc, over = self_excited("-0.05"), {DAMPING: [-0.05, -0.04]}

    def diagram(**kept: Any) -> Any:
        return pc.bifurcation_diagram(
            osc, None, over=over, section=UP, start=(0.5, 0.1), measures=["peak_stop_force"], **kept
        )

    first = diagram()
    stored = diagram(store=tmp_path / "cycles.zarr")
    again = diagram(store=tmp_path / "cycles.zarr")
    assert first.drop_vars("reason").identical(stored.drop_vars("reason"))
    assert stored.identical(again)
    with pytest.raises(pc.OutputError):
        pc.bifurcation_diagram(
            osc, None, over=over, section=UP, start=(0.5, 0.1), store=tmp_path / "cycles.zarr"
        )


def test_free_motions_need_no_word_about_a_forcing() -> None:
    osc, over = self_excited("-0.05"), {DAMPING: [-0.05]}

    diagram = pc.bifurcation_diagram(osc, over=over, section=UP, start=(0.5, 0.1), points=4)
    rates = pc.lyapunov_exponents(osc, start=(0.5, 0.1), transient=50, periods=64)

    assert diagram.period.shape[-1] == 1
    assert abs(rates.exponents[0]) < 1e-3
    with pytest.raises(pc.ParameterError, match="section"):
        pc.bifurcation_diagram(osc, over=over)
