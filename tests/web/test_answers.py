"""What the page is told is what the package computes."""

from __future__ import annotations

import runpy
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from tests.web.frames import read_frame

import percuss as pc
from percuss.errors import StudyError
from percuss.execution import Execution
from percuss.studies import parse_study
from percuss.web.code_text import python_text
from percuss.web.explore import answer_explore
from percuss.web.facts import answer_facts
from percuss.web.jobs import answer_job, levels_of
from percuss.web.presets import FIGURES, presets
from percuss.web.request import BadRequest, PageRequest, RunningRequest, motion_of, study_of
from percuss.web.view_study import study_of_view


def distance_to_line(points: NDArray[Any], line: NDArray[Any]) -> NDArray[Any]:
    """Return how far complex points are from a line through others."""
    begin, along = line[:-1], np.diff(line)
    lengths = np.where(along == 0.0, 1.0, np.abs(along) ** 2)
    share = ((points[:, None] - begin) * along.conj()).real / lengths
    near = begin + np.clip(share, 0.0, 1.0) * along
    return np.asarray(np.abs(near - points[:, None]).min(axis=1))


@pytest.mark.parametrize("name", ["chatter", "first_impacts", "gear_rattle", "coco"])
def test_the_nearest_orbit_is_drawn_through_its_impacts_and_never_through_free_space(
    name: str,
) -> None:
    tables = next(preset.tables for preset in presets() if preset.name == name)
    header, arrays = read_frame(answer_facts(request_for("facts", tables)))
    orbit = header["orbit"]
    study = study_of(tables)
    once = pc.simulate(
        study.oscillator,
        study.forcing,
        orbit["x0"],
        orbit["v0"],
        orbit["t0"],
        t_end=orbit["t0"] + orbit["period"],
    )
    line = arrays["orbit_x"] + 1j * arrays["orbit_v"]
    scale = np.ptp(arrays["orbit_v"])

    at = np.array([float(stop.at) for stop in study.oscillator.stops])
    # Each side of each impact is a corner of the line.
    for v in (once.impacts.v_before, once.impacts.v_after):
        corners = at[once.impacts.stop] + 1j * v
        fast = np.abs(v) > 0.01 * scale
        assert (np.abs(corners[fast, None] - line).min(axis=1) < 1e-4 * scale).all()
    # A line that is long goes from one side of an impact to the other, along the stop.
    steps = np.diff(line)
    long = np.abs(steps) > 0.1 * scale
    assert (np.abs(steps[long].real) < 1e-4 * scale).all()


def request_for(kind: str, study: dict[str, Any], **options: Any) -> PageRequest:
    return PageRequest(5, kind, study, options)


def test_curve_is_the_motion(study: dict[str, Any]) -> None:
    header, arrays = read_frame(answer_explore(request_for("explore", study)))
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    run = pc.simulate(osc, pc.cosine("2.8"), v0="0.5", periods=40)

    assert header["id"] == 5
    assert header["n_impacts"] == len(run.impacts)
    x, _ = run(np.clip(arrays["t"].astype(float), run.t0, run.t_end))
    # Single precision of t moves x by v 1e-5.
    assert np.abs(x - arrays["x"]).max() < 1e-4
    assert arrays["speed"] == pytest.approx(np.abs(run.impacts.v_before), rel=1e-6)


def test_window_is_evaluated_anew_not_stretched(study: dict[str, Any]) -> None:
    header, arrays = read_frame(answer_explore(request_for("explore", study, window=[10.0, 11.0])))

    assert header["window"] == [10.0, 11.0]
    assert arrays["t"][0] == 10.0
    assert arrays["t"][-1] == 11.0
    assert len(arrays["t"]) > 20


def test_window_of_an_earlier_motion_is_dropped(study: dict[str, Any]) -> None:
    header, _ = read_frame(answer_explore(request_for("explore", study, window=[1e4, 2e4])))

    assert header["window"] is None


@pytest.mark.parametrize("preset", presets(), ids=lambda it: it.name)
def test_presets_move_and_are_quick(preset: Any) -> None:
    header, arrays = read_frame(answer_explore(request_for("explore", preset.tables)))

    assert np.ptp(arrays["x"]) > 0.1
    assert len(arrays["t"]) <= 4200
    assert header["n_impacts"] + header["n_crossings"] > 5
    assert preset.title
    assert preset.caption.endswith(".")


def test_chatter_preset_chatters_and_the_figures_have_presets() -> None:
    by_name = {preset.name: preset for preset in presets()}
    header, _ = read_frame(answer_explore(request_for("explore", by_name["chatter"].tables)))

    assert header["n_contacts"] > 3
    assert set(FIGURES.values()) <= set(by_name)


def test_nearest_orbit_is_the_attractor(study: dict[str, Any]) -> None:
    header, arrays = read_frame(answer_facts(request_for("facts", study)))
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
    orbit = read_frame(answer_facts(request_for("facts", study)))[0]["orbit"]

    assert orbit is None or orbit["stability"] == "unstable"


def test_diagram_grows_finer_and_ends(study: dict[str, Any]) -> None:
    request = request_for(
        "diagram", study, path="forcing.omega", low=2.5, high=2.9, values=256, points=8
    )
    frames = [read_frame(data) for data in answer_job(request, RunningRequest())]

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
        read_frame(data)
        for data in answer_job(request_for("basins", study, starts=64, **box), RunningRequest())
    ]

    header, arrays = frames[-1]
    assert header["done"]
    assert len(arrays["basin"]) == 64 * 64
    kinds = [attractor["kind"] for attractor in header["attractors"]]
    assert kinds.count("periodic") == 2
    shares = [attractor["fraction"] for attractor in header["attractors"]]
    assert sum(shares) == pytest.approx(1.0)


def test_a_job_that_nobody_wants_ends(study: dict[str, Any]) -> None:
    running = RunningRequest()
    request = request_for("diagram", study, path="forcing.omega", low=2.5, high=2.9, values=4096)
    frames = answer_job(request, running)
    next(frames)
    running.is_cancelled = True

    assert list(frames) == []


def test_levels_hold_each_value_once() -> None:
    values = np.arange(1000.0)
    levels = levels_of(values, 64)

    assert np.array_equal(np.sort(np.concatenate(levels)), values)
    assert len(levels[0]) <= 64


@pytest.mark.parametrize(
    ("change", "path"),
    [
        ({"damping": "x"}, "oscillator.damping"),
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
    with pytest.raises(BadRequest, match=words):
        study_of(study | tables)


def test_a_motion_of_very_many_terms_is_answered_in_time(study: dict[str, Any]) -> None:
    study["oscillator"]["stops"] = [
        {"type": "soft", "at": 0.1 * i, "side": "above", "stiffness": 10} for i in range(16)
    ]
    study["forcing"] = {"harmonics": [{"amplitude": 1, "omega": 0.37 * i} for i in range(1, 65)]}
    study["run"] = {"t_end": 1e6}
    began = time.process_time()
    header, arrays = read_frame(answer_explore(request_for("explore", study)))
    seconds = time.process_time() - began

    # It is followed for a second, and shown in a part of another.
    assert seconds < 2.0
    assert header["outcome"] != "the run reached t_end"
    # The portrait shows the end of it, with all its arcs.
    assert len(arrays["portrait_t"]) == 4000
    assert arrays["portrait_t"][-1] == pytest.approx(header["t_end"])
    assert arrays["portrait_t"][0] > 0.9 * header["t_end"]
    assert len(arrays["t"]) > 1000


def test_the_portrait_of_a_motion_that_comes_to_rest_shows_how_it_got_there(
    study: dict[str, Any],
) -> None:
    wall = {"type": "wall", "at": 0, "side": "below", "restitution": "0.8"}
    study["oscillator"] = {"stiffness": 0, "damping": "0.05", "stops": [wall]}
    study["forcing"] = {"constant": -1, "harmonics": [{"amplitude": "0.5", "omega": "2.8"}]}
    study["start"] = {"x0": "0.5", "v0": 0}
    study["run"] = {"periods": 400}
    header, arrays = read_frame(answer_explore(request_for("explore", study)))

    assert header["contacts"][0][0] < 0.1 * header["t_end"]
    # All of it, from the start on, and not only the long rest.
    assert arrays["portrait_t"][0] == 0.0
    assert arrays["portrait_x"].max() == pytest.approx(0.5)


def test_facts_of_a_motion_with_an_endless_period_are_answered_in_time(
    study: dict[str, Any],
) -> None:
    study["forcing"]["harmonics"][0]["omega"] = 1e-9
    began = time.process_time()
    header, _ = read_frame(answer_facts(request_for("facts", study)))

    assert header["kind"] == "facts"
    assert time.process_time() - began < 3.0


@pytest.mark.parametrize(
    ("name", "n_impacts", "n_periods"),
    [
        ("first_impacts", 2, 4),
        ("coco", 1, 1),
        ("moored_tower", 1, 2),
        ("gear_rattle", 2, 1),
        ("cracked_beam", 2, 1),
        ("chatter", None, 1),
    ],
)
def test_the_motion_settles_on_the_orbit_that_is_told(
    name: str, n_impacts: int | None, n_periods: int
) -> None:
    tables = next(preset.tables for preset in presets() if preset.name == name)
    header, arrays = read_frame(answer_facts(request_for("facts", tables)))
    orbit = header["orbit"]
    assert (orbit["n_impacts"], orbit["n_periods"]) == (n_impacts, n_periods)
    assert orbit["stability"] == "asymptotic"

    study = study_of(tables)
    motion = motion_of(study)
    run = pc.simulate(
        study.oscillator, study.forcing, motion.start.x0, motion.start.v0, periods=400
    )
    x, v = run(np.linspace(run.t_end - 0.9 * orbit["period"], run.t_end, 50))
    apart = distance_to_line(x + 1j * v, arrays["orbit_x"] + 1j * arrays["orbit_v"])
    # A chord of a 64th of a cycle is so far from its arc.
    assert apart.max() < 0.003 * np.ptp(arrays["orbit_v"])


@pytest.mark.parametrize("name", ["fig05", "fig10"])
def test_a_motion_that_grows_for_ever_has_no_orbit_near(name: str) -> None:
    tables = next(preset.tables for preset in presets() if preset.name == name)
    header, _ = read_frame(answer_facts(request_for("facts", tables)))

    assert header["orbit"] is None


def test_families_of_a_chart_come_one_by_one(study: dict[str, Any]) -> None:
    request = request_for(
        "response", study, path="forcing.omega", low=3.0, high=3.2, max_impacts=1, max_periods=2
    )
    frames = [read_frame(data) for data in answer_job(request, RunningRequest())]

    done = [header["done"] for header, _ in frames]
    assert done == [False] * (len(done) - 1) + [True]
    # The first families come one by one.
    numbers = [len(header["families"]) for header, _ in frames[:-1]]
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) >= 2
    header, arrays = frames[-1]
    kinds = {
        (int(m), int(n))
        for i in range(len(header["families"]))
        for m, n in zip(arrays[f"impacts{i}"], arrays[f"periods{i}"], strict=True)
    }
    assert (1, 2) in kinds
    # Each start that comes with an orbit is on it: a round later it is there again.
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    for i in range(len(header["families"])):
        k = len(arrays[f"value{i}"]) // 2
        if not (arrays[f"admissible{i}"][k] and arrays[f"stable{i}"][k]):
            continue
        x, v, t, omega = (float(arrays[f"{name}{i}"][k]) for name in ("x", "v", "t", "value"))
        run = pc.simulate(
            osc, pc.cosine(omega), min(x, 0.2), v, t, periods=int(arrays[f"periods{i}"][k])
        )
        assert run(run.t_end)[0] == pytest.approx(x, abs=1e-4)


@pytest.mark.parametrize("kind", ["diagram", "response", "basins"])
def test_the_study_of_a_view_and_its_python_ask_the_same(
    study: dict[str, Any], kind: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    every: dict[str, dict[str, Any]] = {
        "diagram": {"path": "forcing.omega", "low": 2.9, "high": 3.0, "values": 3, "points": 4},
        "response": {
            "path": "forcing.omega", "low": 3.0, "high": 3.05, "max_impacts": 1, "max_periods": 1,
        },
        "basins": {"x_low": -1, "x_high": 0, "v_low": -1, "v_high": 1, "starts": 16},
    }  # fmt: skip
    parsed = study_of_view(PageRequest(1, kind, study, every[kind]))
    # The file is a study, and holds the same.
    again = parse_study(parsed.text())
    assert again.question == parsed.question
    assert again.oscillator == parsed.oscillator

    text = python_text(parsed)
    monkeypatch.chdir(tmp_path)
    if kind == "response":
        compile(text, "chart", "exec")
        assert "pc.response_curve(" in text
        return
    script = tmp_path / "script.py"
    script.write_text(text)
    names = runpy.run_path(str(script))
    found = parsed.question.answer(parsed, Execution())
    column = "basin" if kind == "basins" else "x"
    # The values between the ends are rounded otherwise, by a unit in the last place.
    assert names["result"][column].values == pytest.approx(found[column].values, abs=1e-9)
    assert (tmp_path / f"{kind}.png").is_file()


@pytest.mark.parametrize(
    "path", ["run.periods", "oscillator.stiffness", "forcing.omega", "start.v0", "oscillator.stops"]
)
def test_every_number_may_be_a_fraction(study: dict[str, Any], path: str) -> None:
    third: Any = "1/3"
    if path == "oscillator.stops":
        third = [{"type": "wall", "at": "1/3", "side": "above", "restitution": "1/3"}]
    if path == "forcing.omega":
        path, third = "forcing.harmonics", [{"amplitude": "1/3", "omega": "1/3", "phase": "1/3"}]
    table, name = path.split(".")
    study[table][name] = third
    header, _ = read_frame(answer_explore(request_for("explore", study)))
    read_frame(answer_facts(request_for("facts", study)))

    assert header["n_impacts"] >= 0
    if path == "run.periods":
        assert header["t_end"] == pytest.approx(2 * np.pi / 2.8 / 3)


@pytest.mark.parametrize("points", [10**400, -(10**400), float("nan"), float("inf")])
def test_a_number_beyond_all_numbers_is_refused_in_words(
    study: dict[str, Any], points: float
) -> None:
    with pytest.raises(BadRequest, match=r"points at each = .* is not between"):
        answer_explore(request_for("explore", study, points=points))
    with pytest.raises(BadRequest, match="finite times"):
        answer_explore(request_for("explore", study, window=[0, points]))


def test_a_motion_from_near_the_largest_number_has_no_spectrum(study: dict[str, Any]) -> None:
    study["oscillator"]["stops"][0]["at"] = "1.5"
    study["start"] = {"x0": -1e308, "v0": 1}
    study["run"] = {"periods": 1}

    _, arrays = read_frame(answer_explore(request_for("explore", study)))

    assert np.isfinite(arrays["amplitude"]).all()
