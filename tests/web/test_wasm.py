"""The kernels as WebAssembly give the bits that they give here."""

from __future__ import annotations

import base64
import json
import shutil
import subprocess
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.web.frames import read_frame

import percuss
from percuss.execution import Execution
from percuss.model.paths import replace_parameters
from percuss.studies.axes import over_of
from percuss.studies.kinds.sweep import Sweep
from percuss.studies.study import Study
from percuss.web.explore import answer_explore, followed
from percuss.web.facts import exponent_of
from percuss.web.presets import presets
from percuss.web.request import PageRequest, motion_of, study_of
from percuss.web.view_study import study_of_view
from percuss.web.wasm.sources import kept_hash, sources_hash

HERE = Path(__file__).parent
STATIC = HERE.parents[1] / "src" / "percuss" / "web" / "static"
NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="node is not installed")


def wall(at: Any = 0, side: str = "above", restitution: Any = "0.8") -> dict[str, Any]:
    return {"type": "wall", "at": at, "side": side, "restitution": restitution}


def soft(at: Any, side: str, stiffness: Any, damping: Any = 0) -> dict[str, Any]:
    return {"type": "soft", "at": at, "side": side, "stiffness": stiffness, "damping": damping}


def wave(omega: Any, amplitude: Any = 1, phase: Any = 0) -> dict[str, Any]:
    return {"amplitude": amplitude, "omega": omega, "phase": phase}


def study(
    oscillator: dict[str, Any], forcing: dict[str, Any], run: dict[str, Any], **start: Any
) -> dict[str, Any]:
    return {
        "oscillator": oscillator,
        "forcing": forcing,
        "start": {"x0": 0, "v0": 0} | start,
        "run": run,
    }


# Each number in the form in which it is exact; every kind of region, stop and end of a motion.
OWN = [
    study({"stops": [wall("-1/3", "below"), wall(1.25)]}, {"harmonics": [wave(0.9, "1.1", "pi/6")]},
          {"periods": 50}, x0="0.1", v0=0.3),
    study({"damping": "0.02", "stops": [wall(0, "below", 0.9), soft(1, "above", 8, "0.05")]},
          {"harmonics": [wave(2), wave(4, 0.3, "0.3 + pi/7"), wave("6", "1/7", 1.7)], "constant": "1e-2"},
          {"t_end": "60*pi"}, x0="0.5"),
    study({"stiffness": "4/9", "damping": "2/3", "stops": [wall()]}, {"harmonics": [wave("2/3")]},
          {"t_end": 80}, x0=-1, t0="-pi/2"),
    study({"stiffness": 0, "stops": [soft(-1, "below", 25, "0.1"), soft("1.0", "above", 25), soft(1, "above", -2)]},
          {"harmonics": [wave("1.5", "2.0")], "constant": "0.3"}, {"periods": "40.5"}),
    study({"stiffness": "0.25", "damping": 1.5, "stops": [wall(0.2, "above", 0)]},
          {"harmonics": [wave("0.5", 2, -2.5)]}, {"t_end": 90.5}, v0=1),
    study({"mass": "2.5", "stiffness": 40, "damping_coefficient": "0.7", "stops": [wall("0.01", "above", "0.75"),
          soft("-0.02", "below", "300", 4)]}, {"harmonics": [wave("4.2", 3, "pi/3")], "constant": -1},
          {"periods": 60}),
    study({"mass": 3, "stiffness": 2, "stops": [wall()]}, {"harmonics": [wave("2.7")], "per_mass": True},
          {"periods": 30, "max_impacts": 25}, x0=-1),
    study({"stiffness": 1, "stops": [wall(0, "below", "0.5")]}, {"constant": "-0.6"}, {"t_end": 30}, x0=1),
    study({"stiffness": 1, "damping": "0.1", "stops": [wall("0.5")]}, {"harmonics": [wave(1, "0.05")]},
          {"t_end": 300}),
]  # fmt: skip
# What has to be left to Python: expressions, faults, motions that may grow without bound.
LEFT = [
    {**OWN[0], "parameters": {"w": 2}, "forcing": {"harmonics": [wave("w")]}},
    study({"stops": [wall(0, "above", "1.2")]}, {"harmonics": [wave(2)]}, {"periods": 5}),
    study({"stops": [wall()]}, {"harmonics": [wave(2)]}, {"periods": 5}, x0=1),
    study({"stiffness": -1, "stops": [wall()]}, {"harmonics": [wave(2)]}, {"t_end": 5}, x0=-1),
    study({}, {"harmonics": [wave(2), wave(3)]}, {"periods": 5}),
]


def in_node(what: str, studies: list[dict[str, Any]]) -> list[Any]:
    assert NODE is not None
    answers = subprocess.run(
        [NODE, str(HERE / "wasm_answers.mjs"), str(STATIC), what],
        input=json.dumps(studies), capture_output=True, text=True, check=True, timeout=120,
    )  # fmt: skip
    return list(json.loads(answers.stdout))


def all_studies() -> list[dict[str, Any]]:
    return [json.loads(json.dumps(row.tables)) for row in presets()] + OWN


def bits(text: str) -> bytes:
    return base64.b64decode(text)


def test_the_file_is_that_of_the_kernels_as_they_are() -> None:
    assert kept_hash() == sources_hash(), "the kernels of the page have changed: run make wasm"


@needs_node
def test_laws_events_and_ends_have_the_bits_of_python() -> None:
    studies = all_studies()
    for tables, found in zip(studies, in_node("record", studies), strict=True):
        run = followed(study_of(tables)).run
        events, marks = run.record
        assert bits(found["law"]) == run.system.law.tobytes(), tables
        assert bits(found["events"]) == events.tobytes(), tables
        assert found["marks"] == marks.ravel().tolist()
        assert (found["end"], found["outcome"]) == (run.t_end, run.outcome.value)


@needs_node
def test_what_needs_python_is_left_to_it() -> None:
    assert in_node("answer", LEFT) == [None] * len(LEFT)


@needs_node
def test_the_page_is_given_the_numbers_of_the_server() -> None:
    studies = all_studies()
    for tables, found in zip(studies, in_node("answer", studies), strict=True):
        header, arrays = read_frame(answer_explore(PageRequest(1, "explore", tables, {})))
        for name in set(header) - {"id", "arrays", "milliseconds", "impact_times"}:
            assert found["header"][name] == header[name], (name, tables)
        assert set(found["arrays"]) == set(arrays)
        for name, wanted in arrays.items():
            values = np.frombuffer(bits(found["arrays"][name]))
            if name in ("omega", "amplitude"):
                # The transform sums in another order.
                np.testing.assert_allclose(values, wanted, rtol=1e-5, atol=1e-7 * wanted.max())
            elif name.startswith("force"):
                # So do the forces of stops.
                np.testing.assert_allclose(values, wanted, rtol=1e-6, atol=1e-6 * abs(wanted).max())
            else:
                np.testing.assert_array_equal(values.astype(np.float32), wanted, name)


# Each section, parameters of all tables, values behind a wall, and ends that are other doubles.
DIAGRAMS: list[dict[str, Any]] = [
    {"path": "forcing.harmonics.0.omega", "low": 2.6, "high": 2.9},
    {"path": "oscillator.stops.0.restitution", "low": 0, "high": 1, "section": "impacts"},
    {
        "path": "forcing.harmonics.0.phase",
        "low": 0.3,
        "high": 2.5,
        "section": "cycle",
        "cycle": 0.25,
    },
    {"path": "start.v0", "low": -0.3, "high": 1, "section": "place", "at": -0.1, "direction": "up"},
]


@needs_node
def test_the_points_of_diagrams_have_the_bits_of_python() -> None:
    sizes = {"values": 6, "points": 5}
    asked = [{"study": all_studies()[0], **sizes, **options} for options in DIAGRAMS]
    for request, found in zip(asked, in_node("diagram", asked), strict=True):
        tables = request["study"]
        options = {name: value for name, value in request.items() if name != "study"}
        study = study_of_view(PageRequest(1, "diagram", tables, options))
        data = study.question.answer(study, Execution())
        assert found["failed"] == 0
        for name, text in found["columns"].items():
            assert bits(text) == data[name].values[0].tobytes(), (name, request["path"])


# Over two parameters of other tables, through periodic windows, chaos and places behind the wall.
CHART: dict[str, Any] = {
    "kind": "sweep", "path": "forcing.harmonics.0.omega", "low": 2.2, "high": 3.0,
    "path2": "oscillator.stops.0.restitution", "low2": 0.3, "high2": 1.0, "size": 8,
}  # fmt: skip


def chart_of(**options: Any) -> tuple[Any, Study, dict[str, Any]]:
    """Return a chart as the page computes it; its study, and what `percuss.sweep` is given."""
    asked = {**CHART, **options}
    tables = all_studies()[0]
    (levels,) = in_node("chart", [{"study": tables, **asked}])
    study = study_of_view(PageRequest(1, "sweep", tables, asked))
    question = study.question
    assert isinstance(question, Sweep)
    names = ("start", "transient", "periods")
    given = {name: getattr(question, name) for name in names} | {"over": over_of(question.over)}
    size = asked["size"]
    return np.frombuffer(bits(levels[-1]["value"])).reshape(size, size), study, given


def measured_by_sweep(of: str) -> tuple[Any, Any]:
    """Return a chart as the page computes it, and as `percuss.sweep` does."""
    found, study, given = chart_of(of=of)
    return found, percuss.sweep(of, study.oscillator, study.forcing, **given)[of].values


@needs_node
def test_peak_velocities_of_a_chart_are_those_of_a_sweep() -> None:
    found, wanted = measured_by_sweep("peak_impact_velocity")
    assert len(np.unique(wanted)) > 4
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


@needs_node
def test_periods_of_a_chart_are_those_of_a_sweep() -> None:
    found, wanted = measured_by_sweep("period")
    # What a sweep finds no period of may be chaotic, or settle later than it looks.
    np.testing.assert_array_equal(found[wanted > 0], wanted[wanted > 0])
    assert {1, 2} <= set(wanted.ravel())
    assert -1 in found[wanted == 0]


@needs_node
def test_exponents_of_a_chart_are_those_of_its_motions() -> None:
    found, study, given = chart_of(of="largest_lyapunov_exponent", size=5)
    axes = given.pop("over")
    for (i, value), (j, other) in product(*(enumerate(axes[name]) for name in axes)):
        changes = dict(zip(axes, (value, other), strict=True))
        osc, force, _ = replace_parameters(study.oscillator, study.forcing, None, changes)
        wanted = percuss.lyapunov_exponents(osc, force, **given).exponents[0]
        assert found[i, j] == pytest.approx(wanted, rel=1e-12)
    assert 2 < (found > 0.05).sum() < found.size


@needs_node
def test_cells_without_a_motion_are_left_clear() -> None:
    tables = all_studies()[0]
    (levels,) = in_node("chart", [{"study": tables, **CHART, "path2": "start.x0", "low2": 0.0, "high2": 0.4, "of": "period"}])  # fmt: skip
    rows = np.isnan(np.frombuffer(bits(levels[-1]["value"])).reshape(8, 8))
    # The wall is in the middle.
    assert (rows == np.tile(np.arange(8) >= 4, (8, 1))).all()


@needs_node
def test_coarser_charts_are_some_of_the_cells() -> None:
    ((coarse, fine),) = in_node("chart", [{"study": all_studies()[0], **CHART, "of": "peak_impact_velocity", "size": 66}])  # fmt: skip
    whole = np.frombuffer(bits(fine["value"])).reshape(66, 66)
    places = np.minimum(4 * np.arange(17) + 2, 65)
    assert (coarse["size"], fine["size"], coarse["done"], fine["done"]) == (17, 66, False, True)
    np.testing.assert_array_equal(
        np.frombuffer(bits(coarse["value"])), whole[np.ix_(places, places)].ravel()
    )


@needs_node
def test_charts_that_need_python_are_left_to_it() -> None:
    asked = [{"study": it, **CHART, "of": "period"} for it in (LEFT[0], LEFT[-1])]
    assert in_node("chart", asked) == [None, None]


# Of every kind of long motion: orbits with and without impacts, one that sticks, chaos and chaotic
# transients, an orbit for each start, rest, unbounded motions, and starts inside walls.
HELD = study({"stops": [wall(0, "above", "0.3")]}, {"harmonics": [wave(2, "0.5")], "constant": -1},
             {"periods": 9}, x0="1e-3")  # fmt: skip
HELD["oscillator"]["stops"][0]["side"] = "below"
GROWING = study({"stiffness": "-0.5", "stops": [wall(0, "below")]}, {"harmonics": [wave("1.1", "0.1")]},
                {"periods": 9}, x0=1)  # fmt: skip
STRONG = study({"damping": "1e-3", "stops": [soft("0.5", "above", 9)]}, {"harmonics": [wave("1.5", 1, "pi/5")]},
               {"periods": 9}, t0="-0.7")  # fmt: skip
WINDOW = {"kind": "basins", "x_low": -2, "x_high": 2.1, "v_low": -1.9, "v_high": 2}


def basins_of_server(tables: dict[str, Any], size: int) -> Any:
    asked = study_of_view(PageRequest(1, "basins", tables, WINDOW | {"starts": size}))
    return asked.question.answer(asked, Execution())


def assert_basins_are(found: dict[str, Any], data: Any) -> None:
    """The same cells, and the same attractors in the same order."""
    assert found["basin"] == data.basin.values.ravel().tolist()
    names = [(str(k), str(n)) for k, n in zip(data.kind.values, data.name.values, strict=True)]
    assert [(it["kind"], it["name"]) for it in found["attractors"]] == names
    for name, column in (("fraction", data.fraction), ("error", data.fraction_error)):
        assert [it[name] for it in found["attractors"]] == column.values.tolist()
    for k in range(len(names)):
        wanted = np.stack([data.attractor_x0.values[k], data.attractor_v0.values[k]])
        wanted = wanted[:, np.isfinite(wanted).all(axis=0)]
        points = np.stack([np.frombuffer(bits(found["points"][f"{name}{k}"])) for name in "xv"])
        points = points[:, np.isfinite(points).all(axis=0)]
        # Python refines orbits once they are found.
        np.testing.assert_allclose(points, wanted, rtol=0, atol=1e-5 * abs(wanted).max(initial=1))


def assert_basins_of(studies: list[dict[str, Any]], size: int) -> None:
    """Compare the basins of studies, among which are all kinds of long motions."""
    answers = in_node("basins", [WINDOW | {"study": it, "starts": size} for it in studies])
    kinds: set[str] = set()
    for tables, found in zip(studies, answers, strict=True):
        (last,) = found
        assert last["done"]
        assert_basins_are(last, basins_of_server(tables, size))
        kinds |= {it["kind"] for it in last["attractors"]}
        kinds |= {it["name"] for it in last["attractors"] if "inf" in it["name"]}
    assert {"periodic", "chaotic", "rest", "unbounded", "(inf, 1)"} <= kinds


@needs_node
def test_basins_have_the_cells_and_the_attractors_of_python() -> None:
    named = {row.name: json.loads(json.dumps(row.tables)) for row in presets()}
    assert_basins_of([named["chaos"], named["chatter"], named["two_attractors"], HELD, GROWING], 5)


@needs_node
@pytest.mark.nightly
def test_basins_of_all_studies_are_those_of_python() -> None:
    simple = [it for it in all_studies() if len(it["forcing"].get("harmonics", [])) == 1]
    assert_basins_of([*simple, HELD, GROWING, STRONG], 18)


@needs_node
def test_coarser_basins_are_some_of_the_cells() -> None:
    size = 70
    tables = next(
        json.loads(json.dumps(row.tables)) for row in presets() if row.name == "two_attractors"
    )
    (levels,) = in_node("basins", [WINDOW | {"study": tables, "starts": size}])
    coarse, fine = levels
    whole = np.array(fine["basin"]).reshape(size, size)
    places = np.minimum(4 * np.arange(18) + 2, size - 1)
    assert (coarse["size"], fine["size"], coarse["done"], fine["done"]) == (18, size, False, True)
    assert coarse["basin"] == whole[np.ix_(places, places)].ravel().tolist()
    assert 0 < coarse["share"] < fine["share"] == 1


@needs_node
def test_basins_that_need_python_are_left_to_it() -> None:
    asked = [WINDOW | {"study": it, "starts": 16} for it in (LEFT[0], LEFT[-1])]
    assert in_node("basins", asked) == [None, None]


@needs_node
def test_exponents_have_the_bits_of_python() -> None:
    studies = [it for it in all_studies() if len(it["forcing"].get("harmonics", [])) == 1]
    told = {"chaotic": 0, "settling": 0, "forgotten": 0}
    for tables, found in zip(studies, in_node("exponent", studies), strict=True):
        asked = study_of(tables)
        wanted = exponent_of(asked, motion_of(asked).simulated(asked, periods=264))
        assert found == wanted, tables
        assert wanted is not None
        told["chaotic"] += bool(wanted["is_chaotic"])
        told["settling"] += bool(wanted["is_settling"])
        told["forgotten"] += wanted["value"] is None
    assert min(told.values()) > 0
