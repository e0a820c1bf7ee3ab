"""What the page is told is what the package computes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.web.frames import read_frame

import percuss as pc
from percuss.errors import StudyError
from percuss.web.explore import answer_explore
from percuss.web.facts import answer_facts
from percuss.web.handle import Handle
from percuss.web.jobs import answer_job, levels_of
from percuss.web.presets import FIGURES, presets
from percuss.web.question import BadQuestion, Question, study_of


def asked(kind: str, study: dict[str, Any], **options: Any) -> Question:
    return Question(5, kind, study, options)


def test_curve_is_the_motion(study: dict[str, Any]) -> None:
    header, arrays = read_frame(answer_explore(asked("explore", study)))
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    run = pc.simulate(osc, pc.cosine("2.8"), v0="0.5", periods=40)

    assert header["id"] == 5
    assert header["n_impacts"] == len(run.impacts)
    x, _ = run(np.clip(arrays["t"].astype(float), run.t0, run.t_end))
    # Single precision of t moves x by v 1e-5.
    assert np.abs(x - arrays["x"]).max() < 1e-4
    assert arrays["speed"] == pytest.approx(np.abs(run.impacts.v_before), rel=1e-6)


def test_window_is_evaluated_anew_not_stretched(study: dict[str, Any]) -> None:
    header, arrays = read_frame(answer_explore(asked("explore", study, window=[10.0, 11.0])))

    assert header["window"] == [10.0, 11.0]
    assert arrays["t"][0] == 10.0
    assert arrays["t"][-1] == 11.0
    assert len(arrays["t"]) > 20


def test_window_of_an_earlier_motion_is_dropped(study: dict[str, Any]) -> None:
    header, _ = read_frame(answer_explore(asked("explore", study, window=[1e4, 2e4])))

    assert header["window"] is None


@pytest.mark.parametrize("preset", presets(), ids=lambda it: it.name)
def test_presets_move_and_are_quick(preset: Any) -> None:
    header, arrays = read_frame(answer_explore(asked("explore", preset.tables)))

    assert np.ptp(arrays["x"]) > 0.1
    assert len(arrays["t"]) <= 4200
    assert header["n_impacts"] + header["n_crossings"] > 5
    assert preset.title
    assert preset.caption.endswith(".")


def test_chatter_preset_chatters_and_the_figures_have_presets() -> None:
    by_name = {preset.name: preset for preset in presets()}
    header, _ = read_frame(answer_explore(asked("explore", by_name["chatter"].tables)))

    assert header["n_contacts"] > 3
    assert set(FIGURES.values()) <= set(by_name)


def test_nearest_orbit_is_the_attractor(study: dict[str, Any]) -> None:
    header, arrays = read_frame(answer_facts(asked("facts", study)))
    orbit = header["orbit"]

    assert orbit["stability"] == "asymptotic"
    assert orbit["admissible"]
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    run = pc.simulate(osc, pc.cosine("2.8"), v0="0.5", periods=400)
    last = run.impacts.v_after[-orbit["n_impacts"] :]
    assert min(abs(last - orbit["v0"])) < 1e-6
    assert len(arrays["orbit_x"]) > 100


def test_chaos_has_an_unstable_orbit_or_none(study: dict[str, Any]) -> None:
    study["oscillator"]["stops"][0]["at"] = 0
    study["oscillator"]["damping"] = 0
    orbit = read_frame(answer_facts(asked("facts", study)))[0]["orbit"]

    assert orbit is None or orbit["stability"] == "unstable"


def test_diagram_grows_finer_and_ends(study: dict[str, Any]) -> None:
    question = asked(
        "diagram", study, path="forcing.omega", low=2.5, high=2.9, values=256, points=8
    )
    frames = [read_frame(data) for data in answer_job(question, Handle())]

    assert [header["done"] for header, _ in frames] == [False] * (len(frames) - 1) + [True]
    values = np.sort(np.concatenate([arrays["value"] for _, arrays in frames]))
    assert values == pytest.approx(np.linspace(2.5, 2.9, 256), rel=1e-6)
    for header, arrays in frames:
        assert len(arrays["x"]) == header["n_points"] * len(arrays["value"])


def test_basins_grow_finer_and_name_their_attractors(study: dict[str, Any]) -> None:
    study["oscillator"]["stops"][0] |= {"at": "1.45789", "restitution": "0.7"}
    study["forcing"]["harmonics"][0]["omega"] = "1.5"
    box = {"x_low": -3.5, "x_high": 1.4, "v_low": -1.0, "v_high": 1.0}
    frames = [
        read_frame(data) for data in answer_job(asked("basins", study, starts=64, **box), Handle())
    ]

    header, arrays = frames[-1]
    assert header["done"]
    assert len(arrays["basin"]) == 64 * 64
    kinds = [attractor["kind"] for attractor in header["attractors"]]
    assert kinds.count("periodic") == 2
    shares = [attractor["fraction"] for attractor in header["attractors"]]
    assert sum(shares) == pytest.approx(1.0)


def test_a_job_that_nobody_wants_ends(study: dict[str, Any]) -> None:
    handle = Handle()
    question = asked("diagram", study, path="forcing.omega", low=2.5, high=2.9, values=4096)
    frames = answer_job(question, handle)
    next(frames)
    handle.is_stopped = True

    assert list(frames) == []


def test_levels_hold_each_value_once() -> None:
    values = np.arange(1000.0)
    levels = levels_of(values, 64)

    assert np.array_equal(np.sort(np.concatenate(levels)), values)
    assert len(levels[0]) <= 64


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"damping": "-1"}, "oscillator.damping"),
        ({"dampnig": 1}, "oscillator.dampnig"),
        ({"stops": [{"type": "wall", "at": "x", "side": "below"}]}, "oscillator.stops.0.at"),
        ({"stiffness": "__import__('os')"}, "oscillator.stiffness"),
    ],
)
def test_wrong_values_are_told_by_their_path(
    study: dict[str, Any], change: dict[str, Any], path: str
) -> None:
    study["oscillator"] |= change
    with pytest.raises(StudyError) as caught:
        study_of(study)
    assert [getattr(fault, "path", None) for fault in caught.value.faults] == [path]


@pytest.mark.parametrize(
    ("tables", "words"),
    [
        ({"save": {}}, "does not know"),
        ({"oscillator": {"stops": [{}] * 17}}, "17 stops"),
        ({"forcing": {"harmonics": [{}] * 65}}, "65 harmonics"),
        ({"run": {"periods": 30_000}}, "20000 at most"),
    ],
)
def test_what_is_too_large_is_refused(
    study: dict[str, Any], tables: dict[str, Any], words: str
) -> None:
    with pytest.raises(BadQuestion, match=words):
        study_of(study | tables)
