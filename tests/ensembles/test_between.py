"""Measures between two instants: of forcings that have no period."""

from __future__ import annotations

import math
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc

STOP = pc.SoftStop(at="0.2", side="above", stiffness=29, damping="0.3")
OSC = pc.Oscillator(1, "0.05", (STOP,))
SEA = pc.sea_state(hs=1.0, tp=5.0, n=12, seed=3)
QUASI = pc.cosine("1.3") + pc.cosine("2.9", amplitude="0.4")
RECORD = pc.record([0.0, 1.0, 2.5, 4.0, 9.0], [0.0, 1.0, -0.5, 1.5, 0.0])
FORCES = {"sea": SEA, "quasi-periodic": QUASI, "record": RECORD, "none": None}
EPS = 2.0**-52


@pytest.mark.parametrize("name", FORCES)
def test_measures_are_those_of_the_run_in_between(name: str) -> None:
    force, between = FORCES[name], (7.5, 31.0)
    names = ["max_displacement", "min_displacement", "peak_stop_force", "peak_acceleration"]

    data = pc.sweep(names, OSC, force, over={}, start=(0.1, 2.0, 0.5), between=between)

    run = pc.simulate(OSC, force, 0.1, 2.0, 0.5, t_end=31.0)
    x = run.extremes("displacement", between=between)
    expected = [
        x.maximum,
        x.minimum,
        run.extremes("stop_force", between=between).peak,
        run.extremes("acceleration", between=between).peak,
    ]
    for measure, value in zip(names, expected, strict=True):
        assert data[measure].item() == pytest.approx(value, rel=1e-11, abs=1e-13), measure


def test_impacts_and_energy_are_counted_in_times_of_free_vibration() -> None:
    osc = pc.impact_oscillator("0.8", stiffness=4, wall=-0.05)
    names = ["impacts_per_period", "dissipated_energy", "mean_power"]

    data = pc.sweep(names, osc, QUASI, over={}, start=(0.1, 0.5), between=(2, "10*pi"))

    run = pc.simulate(osc, QUASI, 0.1, 0.5, t_end="10*pi")
    inside = run.impacts.t > 2.0
    counts = (10.0 * math.pi - 2.0) / math.pi
    v = run.impacts.v_before[inside], run.impacts.v_after[inside]
    assert inside.sum() > 3
    assert data.impacts_per_period.item() == pytest.approx(inside.sum() / counts, rel=1e-14)
    lost = 0.5 * float((v[0] ** 2 - v[1] ** 2).sum())
    assert data.dissipated_energy.item() == pytest.approx(lost / counts, rel=1e-10)
    # What the forcing gives and impacts do not take is in the energy.
    first, last = (float(energy) for energy in run.energy([2.0, 10.0 * math.pi]))
    span = 10.0 * math.pi - 2.0
    assert data.mean_power.item() * span == pytest.approx(last - first + lost, rel=1e-9)
    assert "2 pi / sqrt(k)" in data.impacts_per_period.attrs["long_name"]


def test_of_a_forcing_with_a_period_it_is_the_same_as_whole_periods() -> None:
    force = pc.cosine(Fraction(2))
    names = ["peak_stop_force", "rms_displacement", "contact_share", "impacts_per_period"]
    over = {"oscillator.stops.0.at": [0.1, 0.2]}

    whole = pc.sweep(names, OSC, force, over=over, transient=3, periods=5)
    part = pc.sweep(names, OSC, force, over=over, between=("3*pi", "8*pi"))

    for name in names:
        np.testing.assert_allclose(part[name], whole[name], rtol=1e-12)


def test_a_function_of_a_run_takes_it_to_the_second_instant() -> None:
    def ends(run: pc.Trajectory) -> float:
        return run.t_end

    data = pc.sweep(ends, OSC, SEA, over={"start.v0": [0.5, 1.0]}, between=(10, 40))

    assert data.ends.values.tolist() == [40.0, 40.0]


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"between": 3}, r"between = 3: not two instants \(first, last\)"),
        ({"between": (3,)}, r"not two instants"),
        ({"between": (3, 2)}, "the second after the first"),
        ({"between": (3, 3)}, "the second after the first"),
        ({"between": (0, math.inf)}, "not two instants"),
        ({"between": (0, "pie")}, "not two instants"),
        ({"between": (1, 2), "start": (0, 0, 1.5)}, r"begins before the start at t0 = 1\.5"),
        ({"between": (1, 2), "over": {"start.t0": [0, 1.5]}}, r"begins before the start"),
        ({"between": (1, 2), "measure": "period"}, "counted over whole periods; give transient"),
        ({"between": (1, 2), "measure": ["growth_exponent"]}, "counted over whole periods"),
        ({"between": (1, 2), "measure": "largest_lyapunov_exponent"}, "over whole periods"),
    ],
)
def test_what_is_wrong_with_two_instants_is_said(keywords: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"measure": "max_displacement", "over": {}} | keywords
    with pytest.raises(pc.ParameterError, match=message):
        pc.sweep(given.pop("measure"), OSC, SEA, **given)


def test_a_store_tells_one_span_from_another(tmp_path: Path) -> None:
    def measured(**keywords: Any) -> float:
        data = pc.sweep(
            "max_displacement", OSC, SEA, over={}, store=tmp_path / "sea.zarr", **keywords
        )
        return float(data.max_displacement.item())

    assert measured(between=(0, 20)) == measured(between=(0, 20))
    with pytest.raises(pc.OutputError):
        measured(between=(0, 21))


def test_a_sweep_beyond_the_samples_of_a_record_says_what_acts_there() -> None:
    data = pc.sweep("contact_share", OSC, RECORD, over={}, between=(5.0, 31.0))
    assert data.attrs["record"] == "the record lasts from t = 0 to 9, its end values hold beyond"
    assert "record" not in pc.sweep("contact_share", OSC, RECORD, over={}, between=(5, 9)).attrs


def test_a_sweep_of_a_structure_beyond_a_record_says_so_too() -> None:
    two = pc.chain([1, 1], [1, 1, 1], "0.1")
    loads = pc.Loads({0: pc.cosine(1), 1: RECORD})

    data = pc.sweep("max_displacement", two, loads, over={}, on=0, between=(5.0, 31.0))

    run = pc.simulate(two, loads, t_end=31)
    assert data.attrs["record"] == run.beyond_record
    assert run.beyond_record.startswith("loads.1: the record lasts from t = 0 to 9")


@pytest.mark.parametrize(
    ("window", "peak"), [((5.0, 5.25), 1.3), ((5.1, 5.5), 0.7)], ids=["begins", "ends"]
)
@pytest.mark.parametrize("omega", ["0.300", "0.374", "0.411", "0.670", "1.003"])
def test_a_window_has_both_limits_of_a_jump_at_its_begin_and_the_first_at_its_end(
    window: tuple[float, float], peak: float, omega: str
) -> None:
    """The wall holds the mass by 0.7 and 1.3 in turn; rounding decided which jump was within."""
    period = 2.0 * math.pi / float(omega)
    between = (window[0] * period, window[1] * period)
    force = pc.square_wave(omega, "0.3") + pc.Forcing(constant=-1)
    wall = pc.Wall(0, side="below", restitution=0, on=0)
    held = pc.Structure([[1]], [[1]], stops=[wall])

    one = pc.sweep(
        "peak_stop_force", pc.impact_oscillator("0"), force, over={"start.x0": [0.0]},
        start=(0.0, 0.0), between=between,
    )  # fmt: skip
    other = pc.sweep(
        "peak_stop_force", held, pc.Loads({0: force}), over={"start.x0.0": [0.0]}, on=0,
        start=([0.0], [0.0]), between=between,
    )  # fmt: skip

    assert one.peak_stop_force.item() == pytest.approx(peak, rel=1e-14)
    assert other.peak_stop_force.item() == pytest.approx(peak, rel=1e-14)
