"""Paired settings: the values of several parameters are taken together, as of random samples."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.io import load_netcdf, save_csv, save_netcdf
from percuss.plotting import plot_chart, plot_sweep
from percuss.studies import load_study, run_study

OSC, FORCE = pc.impact_oscillator(), pc.cosine(2.5)
OMEGA, RESTITUTION, V0 = "forcing.omega", "oscillator.stops.0.restitution", "start.v0"
MEASURES = ["period", "peak_impact_velocity"]


def samples(n: int) -> dict[str, Any]:
    rng = np.random.default_rng(7)
    return {
        OMEGA: rng.normal(2.6, 0.1, n),
        RESTITUTION: rng.uniform(0.5, 1.0, n),
        V0: rng.uniform(0.0, 2.0, n),
    }


def test_each_sample_is_the_motion_of_its_own_setting() -> None:
    over = samples(40)
    data = pc.sweep(MEASURES, OSC, FORCE, over=over, paired=True)

    assert data.sizes["sample"] == 40
    assert all(data[name].dims == ("sample",) for name in (*MEASURES, *over))
    for k in range(40):
        omega, restitution, v0 = (float(values[k]) for values in over.values())
        osc = pc.impact_oscillator(restitution)
        own = pc.sweep(MEASURES, osc, pc.cosine(omega), over={}, start=(0, v0))
        for name in MEASURES:
            assert float(own[name]) == float(data[name][k])
    assert data[V0].attrs["units"] == "length/time"
    assert list(data.drop_dims("failure").to_dataframe()) == [*MEASURES, *over]


def test_a_structure_and_a_function_have_samples_too() -> None:
    pair = pc.impact_pair(masses=[1, 1], gap="0.5", restitution=0.8)
    over = {"structure.stops.0.restitution": [0.5, 0.9], "start.v0.0": [1.0, 2.0]}

    def first(run: Any) -> float:
        return float(run.impacts.v_after[0])

    data = pc.sweep(first, pair, over=over, paired=True, start=([0, 0], [1, 0]), between=(0, 1))
    assert data["first"].values.tolist() == [0.5, 1.8]


def test_samples_without_a_motion_say_which_they_are() -> None:
    over = {OMEGA: [2.5, 2.6, 2.7], RESTITUTION: [0.8, 1.2, 0.7]}
    with pytest.warns(UserWarning, match=r"forcing.omega = 2.6, .*restitution = 1.2"):
        data = pc.sweep("peak_impact_velocity", OSC, FORCE, over=over, paired=True)
    assert data.point.values.tolist() == [1]
    assert np.isnan(data.peak_impact_velocity.values).tolist() == [False, True, False]


def test_stores_parts_and_files_hold_the_samples(tmp_path: Path) -> None:
    def asked(**keywords: Any) -> Any:
        return pc.sweep("period", OSC, FORCE, over=samples(3300), paired=True, **keywords)

    data = asked()
    assert asked(store=tmp_path / "whole.zarr").identical(data)
    assert pc.load_store(tmp_path / "whole.zarr").identical(data)
    for i in (1, 2):
        asked(store=tmp_path / "parts.zarr", part=(i, 2))
    pc.merge_parts(tmp_path / "parts.zarr")
    assert pc.load_store(tmp_path / "parts.zarr").identical(data)

    save_netcdf(data, tmp_path / "a.nc")
    assert load_netcdf(tmp_path / "a.nc").equals(data)
    save_csv(data, tmp_path / "a.csv")
    header, first, *_ = (tmp_path / "a.csv").read_text(encoding="utf-8").splitlines()
    assert header == f"sample,{OMEGA},{RESTITUTION},{V0},period"
    assert [float(x) for x in first.split(",")[1:4]] == [
        float(v[0]) for v in samples(3300).values()
    ]


def test_a_store_of_samples_is_not_that_of_the_grid(tmp_path: Path) -> None:
    over = {OMEGA: [2.5], RESTITUTION: [0.8]}
    pc.sweep("period", OSC, FORCE, over=over, store=tmp_path / "a.zarr")
    with pytest.raises(pc.OutputError, match="another study"):
        pc.sweep("period", OSC, FORCE, over=over, paired=True, store=tmp_path / "a.zarr")


def test_a_study_file_pairs_its_axes(tmp_path: Path) -> None:
    file = tmp_path / "s.toml"
    file.write_text(
        """[study]
        kind = "sweep"
        [[oscillator.stops]]
        type = "wall"
        at = 0
        side = "below"
        restitution = "0.8"
        [forcing]
        constant = 0
        [[forcing.harmonics]]
        amplitude = 1
        omega = "2.5"
        [over]
        "forcing.omega" = {from = "2.4", to = "2.7", count = 4}
        "start.v0" = [0, 1, 2, 3]
        [sweep]
        measure = ["period", "peak_impact_velocity"]
        paired = true
        transient = 20
        """,
        encoding="utf-8",
    )
    study = load_study(file)
    assert "paired = true" in study.text()
    files = run_study(study, tmp_path / "s").files
    loaded = load_netcdf(next(one for one in files if one.suffix == ".nc"))
    osc = pc.impact_oscillator("0.8")
    over = {OMEGA: ["2.4", "2.5", "2.6", "2.7"], V0: [0, 1, 2, 3]}
    own = pc.sweep(MEASURES, osc, pc.cosine("2.5"), over=over, paired=True, transient=20)
    for name in (*over, *MEASURES):
        np.testing.assert_array_equal(loaded[name], own[name])
    assert {one.name for one in files if one.suffix == ".png"} == {
        "period.png",
        "peak_impact_velocity.png",
    }


@pytest.mark.parametrize(
    ("over", "message"),
    [
        ({}, "over = {}: no parameter, whose values could be taken together"),
        (
            {OMEGA: [1, 2], V0: [1, 2, 3]},
            "over = 'start.v0': 3 values, and forcing.omega has 2; paired, each has as many",
        ),
    ],
)
def test_what_is_no_pair_is_a_sentence(over: dict[str, Any], message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.sweep("period", OSC, FORCE, over=over, paired=True)


def test_pictures_draw_dots_over_the_parameters_asked_for() -> None:
    data = pc.sweep([*MEASURES, "largest_lyapunov_exponent"], OSC, FORCE, over=samples(60),
                    paired=True)  # fmt: skip
    ax = plot_chart(data, "largest_lyapunov_exponent", over=[V0, OMEGA])
    assert ax.get_xlabel().startswith("initial velocity")
    assert ax.get_ylabel().startswith("forcing frequency")
    assert sum(len(dots.get_offsets()) for dots in ax.collections) == 60

    ax = plot_sweep(data, "peak_impact_velocity", over=RESTITUTION)
    x, y = (np.asarray(numbers, dtype=float) for numbers in ax.lines[0].get_data())
    order = np.argsort(data[RESTITUTION].values)
    np.testing.assert_array_equal(x, data[RESTITUTION].values[order])
    np.testing.assert_array_equal(y, data.peak_impact_velocity.values[order])
    assert ax.lines[0].get_linestyle() == "None"

    for wrong in ([V0], [V0, V0], [V0, "forcing.amplitude"]):
        with pytest.raises(pc.ParameterError, match="not 2 different parameters of the data"):
            plot_chart(data, "period", over=wrong)
    with pytest.raises(pc.ParameterError, match=r"the data; these are forcing\.omega"):
        plot_sweep(data, "period", over="forcing.amplitude")
