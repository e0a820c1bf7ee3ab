"""The forms of data, what the result says of them, and the sentences of faults."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr

import percuss as pc
from percuss import plotting
from percuss.arrays import Floats

GAP = "oscillator.stops.0.at"
RESTITUTION = "oscillator.stops.0.restitution"
NOISE = 0.01
T_SHORT = np.linspace(0, 6, 60)


def rig(at: float = 0.2, restitution: float = 0.8) -> pc.Oscillator:
    return pc.impact_oscillator(restitution, wall=at, side="above", damping="0.05")


def record(seed: int = 0, v0: float = 0.5, t_end: float = 30.0) -> dict[str, Floats]:
    random = np.random.default_rng(seed)
    t = np.sort(random.uniform(0, t_end, 400))
    x, _ = pc.simulate(rig(), pc.cosine(2), v0=v0, t_end=t_end)(t)
    return {"t": t, "displacement": x + NOISE * random.standard_normal(len(t))}


def fitted(data: Any, **more: Any) -> pc.Fit:
    given: dict[str, Any] = {"free": {GAP: 0.25, RESTITUTION: 0.7}, "noise": NOISE} | more
    return pc.fit(data, rig(0.25, 0.7), given.pop("force", pc.cosine(2)), **given)


@pytest.fixture(scope="module")
def plain() -> pc.Fit:
    return fitted(record())


def test_data_may_be_a_dataset_a_frame_a_mapping_or_a_file(plain: pc.Fit, tmp_path: Path) -> None:
    import pandas as pd
    import xarray as xr

    data = record()
    t, x = data["t"], data["displacement"]
    path = tmp_path / "rig.csv"
    lines = [f"{a!r},{b!r}" for a, b in zip(t.tolist(), x.tolist(), strict=True)]
    path.write_text("\n".join(["# a rig", "t,displacement", *lines, "31.0,"]), encoding="utf-8")
    array = xr.DataArray(x, {"t": t}, ("t",), name="displacement", attrs={"noise": NOISE})
    forms = [
        (path, NOISE),
        (array, None),
        (array.to_dataset(), None),
        (pd.DataFrame(data), NOISE),
        (pd.Series(x, index=t, name="displacement"), {"displacement": np.full(len(t), NOISE)}),
    ]
    for form, noise in forms:
        assert fitted(form, noise=noise).values == plain.values


def test_gaps_and_missing_values_are_left_out(plain: pc.Fit) -> None:
    data = record()
    data["displacement"][100:160] = np.nan
    fit = fitted(data)
    assert fit.converged
    assert fit.residuals.sizes["sample"] == 340
    assert fit.values[GAP] == pytest.approx(0.2, abs=5 * fit.errors[GAP])
    assert fit.errors[GAP] > plain.errors[GAP]


def test_the_guess_is_looked_for_in_a_range() -> None:
    fit = fitted(record(), free={GAP: (0.05, 0.5), RESTITUTION: (0.4, 0.9)})
    assert fit.converged
    assert fit.values[GAP] == pytest.approx(0.2, abs=5 * fit.errors[GAP])


def test_an_end_of_a_range_that_binds_is_named() -> None:
    fit = fitted(record(), free={GAP: 0.25, RESTITUTION: (0.5, 0.75)}, noise=0.3)
    assert fit.at_bounds == (RESTITUTION,)
    assert fit.values[RESTITUTION] == 0.75
    assert fit.errors[RESTITUTION] == 0.0


def test_several_records_say_more_than_one(plain: pc.Fit) -> None:
    fit = fitted([record(), record(1, v0=-0.3)])
    assert fit.converged
    assert fit.errors[GAP] < plain.errors[GAP]
    assert set(fit.residuals.record.values.tolist()) == {0, 1}


def test_several_quantities_with_noise_of_their_own() -> None:
    data = record()
    t = data["t"]
    _, v = pc.simulate(rig(), pc.cosine(2), v0=0.5, t_end=30)(t)
    data["velocity"] = v + 0.2 * np.random.default_rng(5).standard_normal(len(t))
    fit = fitted(data, noise=None)
    assert fit.noise["displacement"] == pytest.approx(NOISE, rel=0.15)
    assert fit.noise["velocity"] == pytest.approx(0.2, rel=0.15)
    assert fit.values[GAP] == pytest.approx(0.2, abs=5 * fit.errors[GAP])


def test_a_prior_that_is_sharper_than_the_data_wins() -> None:
    fit = fitted(record(), prior={RESTITUTION: (0.82, 1e-6)}, noise=0.3)
    assert fit.values[RESTITUTION] == pytest.approx(0.82, abs=1e-5)


def test_a_robust_loss_bears_outliers() -> None:
    data = record()
    data["displacement"][::20] += 1.0
    fit = fitted(data, loss="cauchy")
    assert fit.values[GAP] == pytest.approx(0.2, abs=5 * fit.errors[GAP])
    assert fit.values[RESTITUTION] == pytest.approx(0.8, abs=5 * fit.errors[RESTITUTION])


def test_a_start_that_is_known_and_one_of_its_numbers_that_is_not() -> None:
    model = pc.fit(
        record(), rig(), pc.cosine(2), noise=NOISE, free={GAP: 0.25, "start.v0": 0.4},
        start=(0, 0.4),
    )  # fmt: skip
    assert model.converged
    assert model.values["start.v0"] == pytest.approx(0.5, abs=5 * model.errors["start.v0"])
    assert model.start.v0 == model.values["start.v0"]


def test_a_bouncing_ball_from_its_sound() -> None:
    ball = pc.Oscillator(0, stops=(pc.Wall(at=0, side="below", restitution=0.7),))
    weight = pc.Forcing(constant=-9.81)
    r, h = 0.85, 1.2
    first = math.sqrt(2 * h / 9.81)
    flights = 2 * first * r ** np.arange(1, 12)
    heard = first + np.concatenate([[0], np.cumsum(flights)])
    heard += 1e-4 * np.random.default_rng(3).standard_normal(12)
    fit = pc.fit({"impact_times": heard}, ball, weight, free={RESTITUTION: 0.7}, noise=1e-4)
    assert fit.converged
    assert fit.values[RESTITUTION] == pytest.approx(r, abs=5 * fit.errors[RESTITUTION])
    dropped = pc.fit(
        {"impact_times": heard}, ball, weight, free={RESTITUTION: 0.7, "start.x0": 1.0},
        noise=1e-4, start=(1, 0),
    )  # fmt: skip
    assert dropped.values["start.x0"] == pytest.approx(h, abs=5 * dropped.errors["start.x0"])


def test_the_force_of_a_soft_stop() -> None:
    def model(at: float, stiffness: float) -> pc.Oscillator:
        stop = pc.SoftStop(at=at, side="above", stiffness=stiffness, damping=0.3)
        return pc.Oscillator(damping=0.05, stops=(stop,))

    run = pc.simulate(model(0.2, 20), pc.cosine(2), v0=0.5, t_end=30)
    t = np.linspace(0, 30, 900)
    force = run.forces(t).stops.values[0]
    force = force + 0.05 * np.random.default_rng(2).standard_normal(len(t))
    free = {GAP: 0.3, "oscillator.stops.0.stiffness": 10}
    fit = pc.fit({"t": t, "stop_force": force}, model(0.3, 10), pc.cosine(2), free=free, noise=0.05)
    assert fit.converged
    for path, true in ((GAP, 0.2), ("oscillator.stops.0.stiffness", 20)):
        assert fit.values[path] == pytest.approx(true, abs=5 * fit.errors[path])


def test_the_motion_of_the_fit_passes_the_samples(plain: pc.Fit) -> None:
    data = record()
    x, v = plain(data["t"])
    fitted_values = plain.residuals.fitted.values
    np.testing.assert_allclose(x, fitted_values, rtol=0, atol=1e-12)
    assert x.shape == v.shape
    np.testing.assert_allclose(plain.run(data["t"])[0], x, rtol=0, atol=1e-6)
    assert np.mean(np.square(plain.residuals.residual / NOISE)) == pytest.approx(plain.chi2)
    assert abs(plain.whiteness) < 4


def test_a_fit_survives_pickling(plain: pc.Fit) -> None:
    again = pickle.loads(pickle.dumps(plain))
    assert repr(again) == repr(plain)
    assert again(3.0) == plain(3.0)


def test_a_profile_is_a_parabola_where_errors_are_those_of_a_line(plain: pc.Fit) -> None:
    profile = plain.profile(GAP, n=5, width=2)
    np.testing.assert_allclose(profile.growth, [4, 1, 0, 1, 4], rtol=0.15, atol=1e-6)
    covariance, error = plain.covariance[0, 1], plain.errors[GAP]
    slope = np.polyfit(profile.value - 0.2, profile[RESTITUTION], 1)[0]
    assert slope == pytest.approx(covariance / error**2, rel=0.1)
    with pytest.raises(pc.ParameterError, match="none of the fitted parameters"):
        plain.profile("oscillator.damping")
    with pytest.raises(pc.ParameterError, match="less than 3"):
        plain.profile(GAP, n=2)


def test_the_result_in_a_line_and_as_a_table(plain: pc.Fit) -> None:
    assert repr(plain).startswith(f"<Fit: {GAP} = 0.19985 ± 0.00019, ")
    assert "<table>" in plain._repr_html_()


def test_what_the_data_do_not_say_is_named() -> None:
    osc = pc.Oscillator(damping="0.05", stops=(pc.Wall(at=5, side="above", restitution=0.8),))
    run = pc.simulate(osc, pc.cosine(2), v0=0.5, t_end=30)
    t = np.linspace(0, 30, 300)
    x = run(t)[0] + NOISE * np.random.default_rng(0).standard_normal(300)
    free = {"oscillator.damping": 0.04, RESTITUTION: 0.7}
    fit = pc.fit({"t": t, "displacement": x}, osc, pc.cosine(2), free=free, noise=NOISE)
    assert [list(direction) for direction in fit.unidentifiable] == [[RESTITUTION]]
    assert fit.errors[RESTITUTION] == math.inf
    assert fit.values["oscillator.damping"] == pytest.approx(
        0.05, abs=5 * fit.errors["oscillator.damping"]
    )


def test_data_that_no_motion_explains_are_returned_with_the_reason() -> None:
    fit = fitted({"t": T_SHORT, "displacement": np.random.default_rng(0).standard_normal(60)})
    assert not fit.converged
    assert fit.reason
    assert fit.reason in repr(fit)


def test_a_search_may_be_stopped() -> None:
    fit = fitted(record(), progress=lambda done, _: done < 2)
    assert not fit.converged
    assert fit.reason == "the search was stopped"


def test_a_search_that_was_stopped_goes_on(plain: pc.Fit) -> None:
    data = record()
    stopped = fitted(data, progress=lambda done, _: done < 3)
    again = fitted(data, resume=pickle.loads(pickle.dumps(stopped)))
    assert again.converged
    assert again.values == pytest.approx(plain.values, rel=1e-7)
    assert again.n_runs < plain.n_runs
    with pytest.raises(pc.ParameterError, match="a fit of other data"):
        fitted(record(1), resume=stopped)
    with pytest.raises(pc.ParameterError, match="not of"):
        fitted(data, free={GAP: 0.3}, resume=stopped)


def test_impact_times_alone_go_on_too() -> None:
    """The first impact is the start of such a motion, and none of its data."""
    run = pc.simulate(rig(), pc.cosine(2), v0=0.5, t_end=40)
    data = {"impact_times": run.impacts.t[3:]}
    stopped = fitted(data, free={RESTITUTION: 0.7}, progress=lambda done, _: done < 2)
    again = fitted(data, free={RESTITUTION: 0.7}, resume=stopped)
    assert list(again.values) == [RESTITUTION]


def interrupt(done: float, _: float) -> bool:
    if done >= 3:
        raise KeyboardInterrupt
    return True


def test_a_search_that_was_killed_goes_on_from_its_store(plain: pc.Fit, tmp_path: Path) -> None:
    data, store = record(), tmp_path / "rig.fit"
    with pytest.raises(KeyboardInterrupt):
        fitted(data, store=store, progress=interrupt)
    again = fitted(data, store=store)
    assert again.converged
    assert again.values == pytest.approx(plain.values, rel=1e-7)
    assert again.n_runs < plain.n_runs
    once_more = fitted(data, store=store)
    assert once_more.values == pytest.approx(plain.values, rel=1e-7)
    assert once_more.n_runs <= plain.n_runs
    assert [file.name for file in tmp_path.iterdir()] == ["rig.fit"]
    # By other bounds or another loss the same search may go on, by other data or models it may not.
    fitted(data, store=store, free={GAP: (0.1, 0.3), RESTITUTION: 0.7}, loss="huber")
    for other in (record(1), {**data, "displacement": data["displacement"] + 1e-9}):
        with pytest.raises(pc.OutputError, match="a fit of other data"):
            fitted(other, store=store)
    with pytest.raises(pc.OutputError, match="another model"):
        fitted(data, store=store, force=pc.cosine("2.1"))


def test_stores_that_hold_no_fit_are_refused(tmp_path: Path) -> None:
    data, store = record(), tmp_path / "rig.fit"
    for content in (b"", b"words", b"PK\x03\x04"):
        store.write_bytes(content)
        with pytest.raises(pc.OutputError, match="holds no fit"):
            fitted(data, store=store)
    np.savez(store.with_suffix(".npz"), a=np.ones(2))
    with pytest.raises(pc.OutputError, match="holds no fit"):
        fitted(data, store=store.with_suffix(".npz"))
    with pytest.raises(pc.OutputError, match="is a file"):
        fitted(data, store=tmp_path)
    with pytest.raises(pc.OutputError, match="does not exist"):
        fitted(data, store=tmp_path / "none" / "rig.fit")


@pytest.mark.parametrize("is_structure", [False, True])
def test_a_start_beyond_the_wall_of_the_model_is_right_where_its_range_holds_it(
    is_structure: bool,
) -> None:
    t = np.linspace(0, 30, 400)
    x, _ = pc.simulate(rig(at=0.5), pc.cosine(2), x0=0.4, t_end=30)(t)
    x += NOISE * np.random.default_rng(1).standard_normal(400)
    model: Any = rig(at=0.2)
    start: Any = (0.4, 0)
    gap = GAP
    if is_structure:
        model = pc.Structure([1], [1], [["0.1"]], model.stops)
        start, gap = ([0.4], [0]), GAP.replace("oscillator", "structure")

    found = pc.fit({"t": t, "displacement": x}, model, pc.cosine(2), noise=NOISE,
                   free={gap: (0.1, 0.9)}, start=start)  # fmt: skip

    assert found.converged
    assert abs(found.values[gap] - 0.5) < 4 * found.errors[gap]


@pytest.mark.parametrize(
    ("data", "more", "words"),
    [
        ({"t": T_SHORT, "stop_force": T_SHORT}, {}, "not told by the force of a rigid wall alone"),
        ({"t": [0, 1, 2], "displacement": [0, 1]}, {}, "2 values at 3 instants"),
        ({"t": [0, 1, 2], "displacement": [0, 1, 2]}, {}, "3 values for 4 unknowns"),
        ({"t": [0, 1], "displacement": [np.nan, np.nan]}, {}, "all values are NaN"),
        ({"t": [0, 1], "height": [0, 1]}, {}, "none of the quantities displacement"),
        ({"displacement": [0, 1]}, {}, 'without instants; give them as "t"'),
        ({"t": [0, 1]}, {}, "no column of displacement"),
        ({"t": [0, np.inf], "displacement": [0, 1]}, {}, "no finite number"),
        ({"t": [0, 1], "stop_force_1": [0, 1]}, {}, "of stop 1, where the oscillator has 1"),
        (3.0, {}, "none of a Dataset, a DataFrame"),
        (None, {"start": (0, 0, 1)}, "before the start at t0 = 1"),
        (None, {"start": (0.3, 0)}, "above the wall"),
        (None, {"start": (0.3, 0), "free": {GAP: (0.1, 0.2)}}, "above the wall at x = 0.2"),
        (None, {"start": "given"}, 'neither "free" nor a start'),
        (None, {"free": {}}, "no parameter"),
        (None, {"free": {GAP: (0.5, 0.1)}}, "not a range"),
        (None, {"free": {RESTITUTION: (0.5, 1.2)}}, "the model does not allow it"),
        (None, {"free": {"start.v0": 1}}, "of a start that is free as a whole"),
        (None, {"free": {GAP: 0.3, "oscillator.stops.0.position": 1}}, "no such parameter"),
        (None, {"noise": -1.0}, "noise.displacement = -1.0: no finite number above 0"),
        (None, {"noise": np.inf}, "noise.displacement = inf: no finite number above 0"),
        ({"t": [0.0, np.inf], "displacement": [1.0, 2.0]}, {}, "data.t = inf: an instant"),
        ({"t": [0.0], "displacement": [1.0]}, {}, "1 value for 4 unknowns; a free start has two"),
        (None, {"noise": "2%"}, "noise.displacement = '2%': not a number"),
        (None, {"noise": [1.0, 2.0]}, "of 400 values"),
        (None, {"noise": {"velocity": 1.0}}, "none of the data's displacement"),
        (None, {"prior": {"oscillator.damping": (0, 1)}}, "none of the free parameters"),
        (None, {"prior": {GAP: 0.2}}, "not (mean, standard deviation)"),
        (None, {"loss": "square"}, "none of linear"),
        (None, {"force": [pc.cosine(2), pc.cosine(3)]}, "of 1 records"),
    ],
)
def test_faults_are_sentences(data: Any, more: dict[str, Any], words: str) -> None:
    with pytest.raises(pc.ParameterError) as reported:
        fitted(record() if data is None else data, **more)
    assert words in str(reported.value)


def test_faults_of_files_name_their_lines(tmp_path: Path) -> None:
    path = tmp_path / "rig.csv"
    for text, words in (
        ("t,displacement\n0,1\n1,far\n", 'line 3: displacement = "far" is no finite number'),
        ("t,displacement\n0\n", "line 2: 1 cell between commas, where the names have 2"),
        ("t,displacement\n", "no line of values"),
        (
            "t,displacement\n0,1\n1,2\n1,3\n1,4\n",
            "line 4: the instant 1 of line 3 is there again, and 1 more",
        ),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(pc.ParameterError, match=r"rig\.csv") as reported:
            fitted(path)
        assert words in str(reported.value)
    with pytest.raises(pc.ParameterError, match="no such file"):
        fitted(tmp_path / "none.csv")


def test_impact_times_without_a_noise_are_fitted_and_have_a_profile() -> None:
    """The first guess of their noise is no reason to call a fit a failure."""
    truth = pc.impact_oscillator("0.72", wall="0.2", side="above", damping="0.05")
    force = pc.cosine("2.2")
    exact = pc.simulate(truth, force, v0="0.5", max_impacts=25).impacts.t
    guess = pc.impact_oscillator(0.65, wall=0.22, side="above", damping=0.05)
    free = {"oscillator.stops.0.at": 0.22, "oscillator.stops.0.restitution": 0.65}
    for seed in range(4):
        times = exact + 0.01 * np.random.default_rng(seed).standard_normal(len(exact))
        unknown = pc.fit({"impact_times": times}, guess, force, free=free, start=(0, "0.5"))
        known = pc.fit(
            {"impact_times": times}, guess, force, free=free, start=(0, "0.5"), noise=0.01
        )
        assert unknown.converged, unknown
        assert known.converged, known
        for name in free:
            assert unknown.values[name] == pytest.approx(known.values[name], rel=1e-6)
        assert 0.004 < unknown.noise["impact_times"] < 0.02
        growth = known.profile("oscillator.stops.0.restitution", n=5, width=1).growth.values
        assert growth[2] == pytest.approx(0.0, abs=1e-6)
        assert (np.delete(growth, 2) > 0.1).all()


def test_a_range_in_whose_middle_there_is_no_model_is_searched_beside_it() -> None:
    rig = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    t = np.linspace(0, 12, 160)
    x, _ = pc.simulate(rig, pc.cosine(2), v0=0.5, t_end=12)(t)
    s = pc.parameter("s", 0.3)

    def fit(low: float, high: float) -> pc.Fit:
        model = pc.impact_oscillator(
            "1.1" - (s - 1) * (s - 1), wall="0.2", side="above", damping="0.05"
        )
        data = {"t": t, "displacement": x + 1e-3 * np.cos(37 * t)}
        return pc.fit(data, model, pc.cosine(2), free={"s": (low, high)}, start=(0, 0.5))

    # Between 0.68 and 1.32 an impact would create energy.
    found = fit(0.1, 1.8)
    assert found.converged
    assert abs(found.values["s"] - 1) == pytest.approx(math.sqrt(0.3), abs=1e-2)
    with pytest.raises(pc.ParameterError, match=r"^free = .*no values tried in the ranges make a"):
        fit(0.68, 1.32)


def scores_beside_samples(n: int) -> Floats:
    """Return (n, 2) differences from the truth in standard errors; one fit in 50 may not converge."""
    truth = pc.impact_oscillator("0.72", wall="0.2", side="above", damping="0.05")
    force, names = pc.cosine("2.2"), ("displacement", "impact_times")
    run = pc.simulate(truth, force, v0="0.5", t_end=50)
    t, hits, found = np.linspace(0, 50, 40), run.impacts.t, []
    for seed in range(n):
        random = np.random.default_rng(seed)
        heard = hits + 0.02 * random.standard_normal(len(hits))
        x = run(t)[0] + 0.01 * random.standard_normal(len(t))
        data = xr.Dataset(
            {names[0]: ("t", x, {"noise": 0.01}), names[1]: ("impact", heard)}, coords={"t": t}
        )
        free = {GAP: 0.21, RESTITUTION: 0.69}
        fit = pc.fit(data, truth, force, free=free, start=(0, "0.5"))
        if fit.converged:
            assert fit.noise["displacement"] == pytest.approx(0.01)
            assert 0.008 < fit.noise["impact_times"] < 0.04
            found.append(
                [(fit.values[p] - v) / fit.errors[p] for p, v in ((GAP, 0.2), (RESTITUTION, 0.72))]
            )
    assert len(found) >= n - max(1, n // 50)
    return np.array(found)


def test_impact_times_without_a_noise_beside_samples_with_one() -> None:
    """Their noise is that of their own residuals, and the best values are those for that noise."""
    found = scores_beside_samples(6)
    assert 0.4 < float((np.abs(found) < 1).mean()) < 0.95
    assert float(np.abs(found).max()) < 4


@pytest.mark.nightly
def test_errors_beside_a_noise_from_residuals_hold_the_truth_in_two_thirds() -> None:
    found = scores_beside_samples(100)
    np.testing.assert_allclose((np.abs(found) < 1).mean(axis=0), 0.683, atol=0.1)
    np.testing.assert_allclose(np.sqrt((found**2).mean(axis=0)), 1, atol=0.15)


def test_too_few_values_to_show_their_noise_beside_others_are_refused() -> None:
    data = {**record(), "impact_times": np.array([1.9, 5.0])}
    with pytest.raises(pc.ParameterError, match="2 values are too few to estimate it beside other"):
        fitted(data, noise={"displacement": NOISE})


@pytest.mark.parametrize(
    "free",
    [
        {RESTITUTION: (0.3, 0.95), "oscillator.damping": 0.05},
        {"oscillator.stiffness": 1.0, "forcing.omega": 2.0},
    ],
)
def test_data_beyond_a_wall_end_a_fit_with_the_reason(free: dict[str, Any]) -> None:
    """The search goes to dampings of 1e5, whose motions took it minutes each."""
    t = np.linspace(0, 40, 600)
    osc = pc.impact_oscillator("0.8", wall="0.3", side="above", damping="0.05")
    for data in (np.abs(np.sin(t)) + 3, 1e6 * np.sin(5 * t)):
        fit = pc.fit({"t": t, "displacement": data}, osc, pc.cosine(2), free=free, noise=0.01)
        assert not fit.converged
        assert fit.reason.startswith("no admissible motion explains the samples between t = 0")


def test_columns_of_a_file_are_chosen_by_name(plain: pc.Fit, tmp_path: Path) -> None:
    data, path = record(), tmp_path / "rig.csv"
    rows = zip(data["t"].tolist(), data["displacement"].tolist(), strict=True)
    lines = [f"{t!r};{10 * x!r};{x!r}" for t, x in rows]
    path.write_text("\n".join(["Clock;Laser 1;Laser 2", *lines]), encoding="utf-8")
    fit = fitted(path, columns={"t": "Clock", "displacement": "Laser 2"})
    assert fit.values == pytest.approx(plain.values, rel=1e-9)
    for columns, words in (
        ({"t": "Clock", "displacement": "Laser 3"}, 'no column "Laser 3"'),
        ({"t": "Clock", "height": "Laser 1"}, "none of the quantities displacement"),
        ({"t": "Clock", "displacement": 2}, "not a text, the name of a column"),
    ):
        with pytest.raises(pc.ParameterError) as told:
            fitted(path, columns=columns)
        assert words in str(told.value)
    with pytest.raises(pc.ParameterError, match="names columns of a file, and data are dict"):
        fitted(data, columns={"t": "Clock"})


def test_a_parameter_is_found_by_the_name_that_was_asked_for() -> None:
    osc = pc.Oscillator.from_mass(
        2,
        50,
        damping_coefficient="0.4",
        stops=(pc.Wall(at="0.2", side="above", restitution="0.8"),),
    )
    force = pc.cosine(4, amplitude=20)
    t = np.linspace(0, 20, 400)
    x = pc.simulate(osc, force, t_end=20)(t)[0] + 1e-3 * np.sin(991 * t)
    free = {"oscillator.damping_coefficient": 0.3, "forcing.amplitude": 19}
    fit = pc.fit({"t": t, "displacement": x}, osc, force, free=free)
    for found in (fit, pickle.loads(pickle.dumps(fit))):
        assert found.values["oscillator.damping_coefficient"] == pytest.approx(0.4, rel=0.01)
        assert found.values["forcing.amplitude"] == pytest.approx(20, rel=0.01)
        assert found.errors["oscillator.damping_coefficient"] > 0
        assert found.values == pytest.approx(dict(found.values))
        assert repr(found).startswith("<Fit: oscillator.damping_coefficient = ")
    with pytest.raises(KeyError):
        fit.values["oscillator.stiffness"]
    # An end of a range, and what the data leave open: all forces may be twice as large.
    held = pc.fit(
        {"t": t, "displacement": x}, osc, force, free={"oscillator.damping_coefficient": (0, 0.3)}
    )
    assert held.end_of("oscillator.damping_coefficient") == "largest"
    free |= {"oscillator.mass": 2, "oscillator.stiffness": 50}
    open_ = pc.fit({"t": t, "displacement": x}, osc, force, free=free)
    (shares,) = pickle.loads(pickle.dumps(open_)).unidentifiable
    assert [shares[path] for path in free] == pytest.approx([0.5] * 4, rel=1e-6)
    ellipse = plotting.plot_fit(fit).axes[-1]
    assert "$c$" in ellipse.get_xlabel()


@pytest.mark.parametrize(
    ("more", "sentence"),
    [
        (
            {"free": [GAP]},
            r"^free = \['.*'\]: not \{path: \(least, largest\)\} or \{path: guess\}$",
        ),
        ({"prior": [GAP]}, r"^prior = \['.*'\]: not \{path: \(mean, standard deviation\)\}$"),
    ],
)
def test_a_list_of_parameters_is_told_in_a_sentence(more: dict[str, Any], sentence: str) -> None:
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above")
    arguments: dict[str, Any] = {"free": {GAP: 0.3}} | more
    with pytest.raises(pc.ParameterError, match=sentence):
        pc.fit({"impact_times": [1.0, 2.0, 3.0]}, osc, pc.cosine(2), **arguments)


@pytest.mark.parametrize("lowest", [0.5, 5.0])
def test_a_gap_that_the_motion_does_not_reach_is_told_at_an_end_of_its_range_too(
    lowest: float,
) -> None:
    """It has no error of 0 there: the data say nothing about it."""
    wall = pc.Wall(at=50, side="above", restitution=0.7)
    osc, force = pc.Oscillator(4.0, 0.08, stops=(wall,)), pc.cosine(2.3)
    t = np.linspace(0.0, 25.0, 250)
    x = pc.simulate(osc, force, 0.1, 0.2, t_end=25)(t)[0]
    data = {"t": t, "displacement": x + 0.01 * np.random.default_rng(1).normal(size=len(t))}
    gap = "oscillator.stops.0.at"

    fit = pc.fit(
        data, osc, force, start=(0.1, 0.2), noise=0.01,
        free={gap: (lowest, 80), "oscillator.damping": (0, 0.3)},
    )  # fmt: skip

    assert fit.errors[gap] == np.inf
    assert fit.errors["oscillator.damping"] < 1e-3
    assert [list(direction) for direction in fit.unidentifiable] == [[gap]]


def test_instants_that_are_there_twice_show_their_noise_too() -> None:
    """As of a clock that is too coarse: the noise of neighbours came out as nothing."""
    first = record()
    x = pc.simulate(rig(), pc.cosine(2), v0=0.5, t_end=30)(first["t"])[0]
    other = x + NOISE * np.random.default_rng(5).standard_normal(len(x))
    twice = {
        "t": np.concatenate([first["t"], first["t"]]),
        "displacement": np.concatenate([first["displacement"], other]),
    }
    fit = fitted(twice, noise=None)
    assert fit.converged
    assert fit.noise["displacement"] == pytest.approx(NOISE, rel=0.1)


@pytest.mark.parametrize("loss", ["soft_l1", "huber", "cauchy", "arctan"])
def test_a_robust_loss_finds_the_noise_of_most_values(loss: Any) -> None:
    """That of all held the outliers, and errors were ten times too large."""
    data = record()
    data["displacement"][::20] += 50.0 * NOISE
    known, unknown = fitted(data, loss=loss), fitted(data, loss=loss, noise=None)
    assert unknown.converged
    assert unknown.noise["displacement"] == pytest.approx(NOISE, rel=0.15)
    for path, error in known.errors.items():
        assert unknown.errors[path] == pytest.approx(error, rel=0.2)


def test_a_zero_of_the_sensor_that_is_off_is_told_and_is_a_constant_force() -> None:
    data = record()
    data["displacement"] += 0.05
    damping = {"oscillator.damping": 0.06}
    told = fitted(data, noise=None, free={GAP: 0.25, RESTITUTION: 0.7} | damping)
    assert "the residuals hang together: the model misses something" in repr(told)
    force = pc.Forcing(constant=0.0, harmonics=pc.cosine(2).harmonics)
    free = {GAP: 0.25, RESTITUTION: 0.7, "forcing.constant": 0.0}
    fit = fitted(data, force=force, free=free)
    assert fit.converged
    assert fit.values["forcing.constant"] == pytest.approx(0.05, abs=0.003)
    assert fit.values[GAP] == pytest.approx(0.25, abs=0.003)


def test_the_noise_of_a_record_in_which_chaos_takes_derivatives_out_of_all_numbers() -> None:
    """Their squares overflow, which is no warning to the caller."""
    t = np.arange(9000) * math.pi / 12.5
    x, _ = pc.simulate(rig(), pc.cosine("2.5"), v0=0.5, t_end=float(t[-1]))(t)
    data = {"t": t, "displacement": x + 1e-3 * np.random.default_rng(0).standard_normal(9000)}
    fit = pc.fit(
        data, rig(), pc.cosine("2.5"), free={"oscillator.damping": 0.0505},
        progress=lambda done, _: done < 6,
    )  # fmt: skip
    assert fit.reason == "the search was stopped"
    assert 0.0 < fit.noise["displacement"] < 1.0
