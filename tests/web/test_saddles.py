"""Saddles and their manifolds are what they are called."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.web.frames import read_frame

import percuss as pc
from percuss.web import saddles
from percuss.web.presets import presets
from percuss.web.request import BadRequest, PageRequest, RunningRequest
from percuss.web.saddles import answer_saddles

OSC = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
FORCE = pc.cosine("2.8")


@pytest.fixture(autouse=True)
def _patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine that does much else finds them all, too."""
    monkeypatch.setattr(saddles, "PATIENCE", 600.0)


def found_of(study: dict[str, Any], running: RunningRequest | None = None) -> list[tuple[Any, Any]]:
    request = PageRequest(3, "saddles", study, {})
    return [read_frame(data) for data in answer_saddles(request, running or RunningRequest())]


def after(place: Any, periods: int) -> Any:
    x, v = place
    run = pc.simulate(OSC, FORCE, min(float(x), 0.2), float(v), periods=periods)
    return np.array(run(run.t_end), float)


def test_saddles_return_and_their_manifolds_lead_to_them(study: dict[str, Any]) -> None:
    *frames, (last, _) = found_of(study)

    assert last["done"]
    assert last["n_saddles"] == len(frames) == 2
    assert not last["late"]
    for header, arrays in frames:
        assert not header["done"]
        n_periods = header["n_periods"]
        points = np.column_stack([arrays["x"], arrays["v"]]).astype(float)
        assert len(points) == n_periods
        assert after(points[0], n_periods) == pytest.approx(points[0], abs=1e-4)
        inside, outside = sorted(abs(value) for value in header["multipliers"])
        assert inside < 1.0 < outside
        # Some way along its manifold a motion comes nearer to the saddle, by its multiplier.
        curve = np.column_stack([arrays["curve_x"], arrays["curve_v"]]).astype(float)
        curve = curve[np.isfinite(curve).all(axis=1)]
        away = np.hypot(*(curve - points[0]).T)
        start = curve[np.flatnonzero(away > 0.02)[0]]
        begin = np.hypot(*(start - points[0]))
        end = np.hypot(*(after(start, 2 * n_periods) - points[0]))
        assert end < 0.7 * begin


def test_a_system_without_saddles_says_so() -> None:
    tables = next(it.tables for it in presets() if it.name == "coco")
    ((header, _),) = found_of(tables)

    assert header["done"]
    assert header["n_saddles"] == 0


def test_the_time_is_bounded_and_what_is_done_is_told(
    study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(saddles, "PATIENCE", 0.0)
    *frames, (last, _) = found_of(study)

    assert last["late"]
    assert len(frames) == 1


def test_nobody_is_told_who_wants_it_no_more(study: dict[str, Any]) -> None:
    assert found_of(study, RunningRequest(is_cancelled=True)) == []


def test_free_motion_has_no_saddles_to_draw(study: dict[str, Any]) -> None:
    study |= {"forcing": {}, "run": {"t_end": 9}}
    with pytest.raises(BadRequest, match="periodic forcing"):
        found_of(study)
