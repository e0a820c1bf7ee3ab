"""What a call cannot take is a sentence, whatever its type, before anything is done."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc

OSC, FORCE = pc.impact_oscillator(restitution=0.8), pc.cosine(2.5)
OVER = {"forcing.omega": [2.5]}


def own(osc: pc.Oscillator, force: pc.Forcing) -> float:  # noqa: ARG001
    return 1.0


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"measure": None}, "measure = None: none of peak_displacement"),
        ({"measure": [["period"]]}, "did you mean period"),
        ({"measure": [own]}, "measure = 'own': one function at a time; a list holds names"),
        ({"measure": ["period", own]}, "measure = 'own': one function at a time"),
        ({"osc": None}, "osc = None: no oscillator"),
        ({"force": 2.5}, "force = 2.5: no forcing"),
        ({"store": 3}, "store = 3: not the path of a folder"),
        ({"store": [1]}, r"store = \[1\]: not the path of a folder"),
        ({"n_workers": -1}, "n_workers = -1: not a whole number of at least 1"),
        ({"n_workers": 0}, "n_workers = 0: not a whole number of at least 1"),
        ({"n_workers": 1.5}, "n_workers = 1.5: not a whole number of at least 1"),
        ({"progress": "yes"}, "progress = 'yes': neither True nor a function"),
        ({"over": {"wall": [1.0]}}, r"did you mean oscillator\.stops\.0\.at\?"),
        ({"over": {"gap": [1.0]}}, r"did you mean oscillator\.stops\.0\.at\?"),
        ({"over": {"omega": [1.0]}}, r"did you mean forcing\.omega\?"),
        ({"over": {"restitution": [1.0]}}, r"did you mean oscillator\.stops\.0\.restitution\?"),
        ({"over": {"x0": [1.0]}}, r"did you mean start\.x0\?"),
        ({"over": {3: [1.0]}}, "path = 3: no such parameter"),
    ],
)
def test_what_a_sweep_cannot_take_is_a_sentence(keywords: dict[str, Any], message: str) -> None:
    given: dict[str, Any] = {"measure": "period", "osc": OSC, "force": FORCE, "over": OVER}
    given |= keywords
    with pytest.raises(pc.ParameterError, match=message):
        pc.sweep(given.pop("measure"), given.pop("osc"), given.pop("force"), **given)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"starts": (0, 1)}, r"starts = \(0, 1\): not a list of starts"),
        ({"starts": None}, "starts = None: not a list of starts"),
        ({"starts": "rest"}, "starts = 'rest': not a list of starts"),
        ({"follow": "forward"}, "follow = 'forward': not a list"),
        ({"follow": None}, "follow = None: not a list"),
        ({"follow": ["forward", "forward"]}, "the same twice"),
        ({"store": 3}, "store = 3"),
        ({"progress": 1}, "progress = 1"),
    ],
)
def test_what_a_diagram_cannot_take_is_a_sentence(keywords: dict[str, Any], message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.bifurcation_diagram(OSC, FORCE, **({"over": OVER} | keywords))


def test_a_parameter_named_twice_is_shown_as_it_was_written() -> None:
    short, long = "forcing.omega", "forcing.harmonics.0.omega"
    for first, second in ((short, long), (long, short)):
        with pytest.raises(pc.ParameterError, match=rf"\('{first}', '{second}'\).*named twice"):
            pc.sweep("period", OSC, FORCE, over={first: [1.0], second: [2.0]})


@pytest.mark.parametrize("call", [pc.load_store, pc.status_of_store])
def test_what_is_no_path_holds_no_store(call: Any) -> None:
    with pytest.raises(pc.ParameterError, match="store = 3: not the path of a folder"):
        call(3)


def test_only_the_folder_of_a_store_is_made(tmp_path: Path) -> None:
    deep = tmp_path / "runs" / "may" / "a.zarr"
    calls: tuple[Callable[[Path], object], ...] = (
        lambda store: pc.sweep("period", OSC, FORCE, over=OVER, transient=5, store=store),
        lambda store: pc.bifurcation_diagram(
            OSC, FORCE, over=OVER, transient=5, points=4, store=store
        ),
    )
    for number, call in enumerate(calls):
        with pytest.raises(pc.OutputError, match=r"there is no folder .*may; make it first"):
            call(deep)
        assert not (tmp_path / "runs").exists()

        call(tmp_path / f"{number}.zarr")
        assert (tmp_path / f"{number}.zarr").is_dir()


def test_an_array_is_no_number_and_the_measure_is_named() -> None:
    def speeds(osc: pc.Oscillator, force: pc.Forcing) -> Any:  # noqa: ARG001
        return np.zeros((2, 2))

    with pytest.warns(UserWarning, match=r"measure = 'speeds': returned array\(.*is no number"):
        data = pc.sweep(speeds, OSC, FORCE, over=OVER)
    assert "\n" not in data.reason.values[0]


def test_a_sweep_without_axes_is_one_point(tmp_path: Path) -> None:
    data = pc.sweep("period", OSC, FORCE, over={}, start=(0.0, 1.0), store=tmp_path / "a.zarr")

    assert data.period.dims == ()
    assert float(data.period) == 1.0
    assert float(pc.load_store(tmp_path / "a.zarr").period) == 1.0
