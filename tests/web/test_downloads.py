"""Files of what a view shows are those that `percuss run` writes."""

from __future__ import annotations

import csv
import io
import runpy
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray

from percuss.errors import PercussError
from percuss.execution import Execution
from percuss.motion.simulate import simulate
from percuss.studies import parse_study, run_study
from percuss.studies.kinds.basins import Basins
from percuss.studies.kinds.diagram import Diagram
from percuss.web import answer_cache
from percuss.web.answer_cache import ANSWERS, AnswerCache, size_of
from percuss.web.downloads import file_of
from percuss.web.jobs import answer_job
from percuss.web.request import BadRequest, PageRequest, RunningRequest
from percuss.web.view_study import study_of_view

OPTIONS: dict[str, dict[str, Any]] = {
    "diagram": {"path": "forcing.omega", "low": 2.5, "high": 2.9, "values": 70, "points": 4},
    "response": {
        "path": "forcing.omega", "low": 3.0, "high": 3.05, "max_impacts": 1, "max_periods": 1,
    },
    "basins": {"x_low": -1, "x_high": 0.2, "v_low": -1, "v_high": 1, "starts": 49},
    "sweep": {
        "path": "forcing.omega", "low": 2.95, "high": 3.9, "path2": "start.v0", "low2": 0,
        "high2": 1, "size": 16, "of": "period",
    },
}  # fmt: skip
BEGINS = {"png": b"\x89PNG", "svg": b"<?xml", "nc": b"\x89HDF", "csv": b""}


def request_for(kind: str, study: dict[str, Any], **more: Any) -> PageRequest:
    return PageRequest(1, kind, study, {**OPTIONS[kind], **more})


def rows_of(data: bytes) -> list[list[str]]:
    return list(csv.reader(io.StringIO(data.decode())))


@pytest.mark.parametrize("kind", ["diagram", "basins"])
def test_what_the_page_computes_is_what_its_study_computes(
    study: dict[str, Any], kind: str
) -> None:
    request = request_for(kind, study)
    frames = list(answer_job(request, RunningRequest()))
    assert len(frames) > 1
    found = ANSWERS.get(study_of_view(request))
    again = parse_study(study_of_view(request).text())

    assert found.identical(again.question.answer(again, Execution()))


@pytest.mark.parametrize("extension", ["png", "svg", "csv", "nc"])
@pytest.mark.parametrize("kind", ["diagram", "basins"])
def test_files_are_made_of_what_is_computed_already(
    study: dict[str, Any], kind: str, extension: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    request = request_for(kind, study)
    if ANSWERS.get(study_of_view(request)) is None:
        list(answer_job(request, RunningRequest()))

    def again(*_: Any) -> None:
        raise AssertionError("it is computed again")

    monkeypatch.setattr({"diagram": Diagram, "basins": Basins}[kind], "answer", again)
    made = file_of(request, extension)

    assert made.name == f"{kind}.{extension}"
    assert made.data.startswith(BEGINS[extension])


def test_files_of_a_diagram_are_those_of_percuss_run(study: dict[str, Any], tmp_path: Path) -> None:
    request = request_for("diagram", study)
    again = parse_study(file_of(request, "toml").data.decode())
    run_study(again, tmp_path)

    assert rows_of(file_of(request, "csv").data) == rows_of((tmp_path / "diagram.csv").read_bytes())
    target = tmp_path / "page.nc"
    target.write_bytes(file_of(request, "nc").data)
    for name in ("x", "v", "period"):
        with (
            xarray.open_dataset(target) as one,
            xarray.open_dataset(tmp_path / "diagram.nc") as two,
        ):
            assert one[name].equals(two[name])


def test_a_chart_of_two_parameters_comes_out_as_files(study: dict[str, Any]) -> None:
    request = request_for("sweep", study)
    rows = rows_of(file_of(request, "csv").data)
    again = parse_study(file_of(request, "toml").data.decode())
    text = file_of(request, "py").data.decode()
    told: dict[str, Any] = {}
    exec(text[: text.index("plotting.plot")], told)  # noqa: S102  our own text

    assert again.question == study_of_view(request).question
    assert len([row for row in rows if row[0][0].isdigit()]) == 256
    wanted = again.question.answer(again, Execution()).period
    np.testing.assert_array_equal(told["result"].period.values, wanted.values)
    for extension in ("png", "svg", "nc"):
        assert file_of(request, extension).data.startswith(BEGINS[extension])


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        ({}, "under one harmonic"),
        ({"size": 1000}, "cells along a side = 1000 is not between 16 and 256"),
        ({"path2": "forcing.omega"}, "the two parameters are the same"),
        ({"low2": 1}, "and from = 1 is not below and to = 1"),
        ({"of": "x"}, "of is none of period"),
    ],
)
def test_the_server_says_which_charts_the_page_has(
    study: dict[str, Any], options: dict[str, Any], sentence: str
) -> None:
    with pytest.raises(BadRequest, match=sentence):
        list(answer_job(request_for("sweep", study, **options), RunningRequest()))


def test_a_response_chart_comes_out_as_files(study: dict[str, Any]) -> None:
    request = request_for("response", study, max_impacts=1, max_periods=1)
    if ANSWERS.get(study_of_view(request)) is None:
        list(answer_job(request, RunningRequest()))
    rows = rows_of(file_of(request, "csv").data)

    assert ANSWERS.get(study_of_view(request)).complete
    assert "arclength" in rows[0]
    assert len(rows) > 10
    assert file_of(request, "png").data.startswith(b"\x89PNG")


def test_basins_have_a_table_of_attractors_and_manifolds_where_they_are_wanted(
    study: dict[str, Any],
) -> None:
    with_them = request_for("basins", study, manifolds=True)
    rows = rows_of(file_of(request_for("basins", study, table="attractors"), "csv").data)

    assert len(rows) >= 2
    assert "manifolds = true" in file_of(with_them, "toml").data.decode()
    assert "manifolds" not in file_of(request_for("basins", study), "toml").data.decode()
    # Both are drawn of the same answer; that with the curves shows more.
    pictures = [file_of(it, "svg").data for it in (with_them, request_for("basins", study))]
    assert b"stable manifold" in pictures[0]
    assert b"stable manifold" not in pictures[1]


def test_the_python_of_basins_draws_the_manifolds_too(
    study: dict[str, Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from matplotlib.axes import Axes

    text = file_of(request_for("basins", study, starts=16, manifolds=True), "py").data.decode()
    monkeypatch.chdir(tmp_path)
    drawn: list[Any] = []
    plot = Axes.plot

    def watched(*args: Any, **more: Any) -> Any:
        drawn.append(more.get("linestyle"))
        return plot(*args, **more)

    monkeypatch.setattr(Axes, "plot", watched)
    (tmp_path / "script.py").write_text(text)
    runpy.run_path("script.py")

    assert (tmp_path / "basins.png").is_file()
    assert drawn.count("-") >= 2


def test_a_table_that_there_is_not_is_named(study: dict[str, Any]) -> None:
    with pytest.raises(BadRequest, match="no table 'crossings', only impacts"):
        file_of(PageRequest(1, "motion", study, {"table": "crossings"}), "csv")


def test_a_motion_that_is_certified_has_a_table_of_balls(study: dict[str, Any]) -> None:
    study["run"] = {"periods": 8}
    request = PageRequest(1, "motion", study, {"digits": 20, "table": "certified"})
    rows = rows_of(file_of(request, "csv").data)
    text = file_of(request, "toml").data.decode()

    again = parse_study(text)
    run = simulate(again.oscillator, again.forcing, v0="0.5", periods=8)
    assert len(rows) == 1 + len(run.impacts)
    columns = dict(zip(rows[0], rows[1], strict=True))
    assert float(columns["t"]) == pytest.approx(run.impacts.t[0], rel=1e-12)
    assert 0.0 < float(columns["t_radius"]) < 1e-20
    assert "digits = 20" in text
    assert "pc.certify(run, digits=20)" in file_of(request, "py").data.decode()


def test_what_takes_too_long_is_refused_and_not_kept(
    study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(answer_cache, "PATIENCE", 0.0)
    request = request_for("diagram", study, values=8000)
    with pytest.raises(BadRequest, match="takes longer than 0 s"):
        file_of(request, "csv")
    assert ANSWERS.get(study_of_view(request)) is None


@pytest.mark.parametrize(
    ("kind", "options"),
    [
        ("diagram", {"values": 8193}),
        ("diagram", {"values": 8000, "points": 1000}),
        ("basins", {"starts": 4000}),
        ("response", {"max_impacts": 40}),
    ],
)
def test_what_is_too_large_for_the_page_has_a_study_and_no_pictures(
    study: dict[str, Any], kind: str, options: dict[str, int]
) -> None:
    request = request_for(kind, study, **options)
    with pytest.raises(BadRequest):
        file_of(request, "png")
    with pytest.raises((BadRequest, PercussError)):
        list(answer_job(request, RunningRequest()))

    assert parse_study(file_of(request, "toml").data.decode()).kind == kind


def test_of_many_answers_as_many_bytes_are_kept_as_there_is_room_for(
    study: dict[str, Any],
) -> None:
    store = AnswerCache(2_500_000)
    studies = [study_of_view(request_for("diagram", study, values=n)) for n in (10, 11, 12, 13)]
    for number, it in enumerate(studies[:3]):
        store.put(it, np.full(125_000, number))
        # What is asked for again stays.
        store.get(studies[0])
    kept_now = [store.get(it) is not None for it in studies]
    assert kept_now == [True, False, True, False]

    # What alone is too large is not kept, and drives out no other.
    store.put(studies[3], np.zeros(400_000))
    assert [store.get(it) is not None for it in studies] == kept_now


def test_the_size_of_an_answer_is_that_of_its_arrays(study: dict[str, Any]) -> None:
    for kind, options in (("diagram", {"values": 50, "points": 8}), ("response", {})):
        request = request_for(kind, study, **options)
        found = study_of_view(request)
        # The chart is there already, if a test before has asked for it.
        answer = ANSWERS.get(found) or found.question.answer(found, Execution())
        assert 1_000 < size_of(answer) < 5_000_000


def test_a_large_study_is_written_at_once(study: dict[str, Any]) -> None:
    began = time.process_time()
    text = file_of(request_for("diagram", study, values=1_000_000), "toml").data.decode()
    assert "count = 1000000" in text
    # Each of its values was checked, in ten minutes.
    assert time.process_time() - began < 5.0
