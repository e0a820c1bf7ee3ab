"""What the cards say of settled motions, of patterns, of entries and of narrow ranges."""

from __future__ import annotations

import copy
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from tests.web.frames import read_frame
from tests.web.hands import (
    compute,
    drawn,
    fact,
    field,
    fill,
    middle,
    open_preset,
    set_box,
    view_of,
    wait_for_drawing,
)

from percuss.web.explore import answer_explore
from percuss.web.facts import answer_facts
from percuss.web.jobs import answer_job
from percuss.web.presets import presets
from percuss.web.request import BadRequest, PageRequest, RunningRequest
from percuss.web.view_study import study_of_view


def preset(name: str, periods: int) -> dict[str, Any]:
    tables = copy.deepcopy(next(it.tables for it in presets() if it.name == name))
    return {**tables, "run": {"periods": periods}}


def test_the_smallest_pattern_of_a_motion_that_still_settles_is_told() -> None:
    request = PageRequest(1, "explore", preset("gear_rattle", 150), {})
    reported = read_frame(answer_explore(request))[0]["impact_times"]
    orbit = read_frame(answer_facts(request))[0]["orbit"]

    assert (reported["n_impacts"], reported["n_periods"]) == (
        orbit["n_impacts"],
        orbit["n_periods"],
    )
    assert (reported["n_impacts"], reported["n_periods"]) == (2, 1)


def test_neighbours_of_a_settling_motion_meet() -> None:
    exponents = {
        name: read_frame(answer_facts(PageRequest(1, "facts", preset(name, 60), {})))[0]["exponent"]
        for name in ("two_attractors", "chaos")
    }
    assert exponents["two_attractors"]["is_settling"]
    assert not exponents["chaos"]["is_settling"]


@pytest.mark.parametrize(
    ("name", "periods", "words", "more"),
    [
        ("two_attractors", "60", "periodic", "1 impact in 1 forcing period"),
        ("coco", "60", "periodic", "1 impact in 1 forcing period"),
        ("first_impacts", "150", "periodic", "2 impacts in 4 forcing periods"),
        ("first_impacts", "80", "settling", "towards 2 impacts in 4 forcing periods"),
        ("gear_rattle", "150", "periodic", "2 entries into a stop in 1 forcing period"),
    ],
)
def test_a_motion_that_settles_is_never_neither(
    page: Page, name: str, periods: str, words: str, more: str
) -> None:
    open_preset(page, name)
    if periods != "60":
        before = drawn(page)
        set_box(page, "run.periods", periods)
        wait_for_drawing(page, before)
    times = page.locator(".facts .card").nth(1)
    expect(times).to_contain_text("largest exponent")
    expect(times).to_contain_text(words)
    expect(times).to_contain_text(more)
    expect(times).not_to_contain_text("neither")
    if name == "gear_rattle":
        assert "entries into a stop" in fact(page, 0)
        assert "crossing" not in fact(page, 0)
        assert "2 entries into a stop in 1 forcing period" in fact(page, 2)


def test_words_of_a_motion_without_memory_agree(page: Page) -> None:
    said = page.evaluate(
        """async () => {
          const { Facts } = await import('/static/js/facts.js');
          const tell = (settling) => {
            const facts = new Facts();
            facts.kind = 'no_period_found';
            facts.pattern = '';
            facts.showExponent({ orbit: null, ...settling });
            return facts.times.root.innerText || facts.times.root.textContent;
          };
          return [
            tell({ exponent: { value: null, error: 0, is_chaotic: false, is_settling: true } }),
            tell({ exponent: { value: 0, error: 1e-3, is_chaotic: false, is_settling: false } }),
          ];
        }"""
    )
    assert "no period found" not in said[0]
    assert "settles from contact to contact" in said[0]
    assert "neither part nor meet" in said[1]


NARROW = {"path": "start.v0", "low": 0.49999959, "high": 0.50000043, "values": 64, "points": 2}


def test_values_of_a_narrow_range_stay_apart(study: dict[str, Any]) -> None:
    frames = answer_job(PageRequest(1, "diagram", study, NARROW), RunningRequest())
    values = np.concatenate([read_frame(data)[1]["value"] for data in frames])

    wanted = np.linspace(NARROW["low"], NARROW["high"], 64)  # type: ignore[call-overload]
    assert np.sort(values) == pytest.approx(wanted, abs=1e-13)


def test_a_narrow_range_has_ticks_and_a_cursor_that_tell_neighbours_apart(page: Page) -> None:
    texts = page.evaluate(
        """async () => {
          const { tickTexts } = await import('/static/js/scales.js');
          return [tickTexts([0.4999996, 0.4999998, 0.5, 0.5000002]), tickTexts([0, 0.5, 1])];
        }"""
    )
    assert texts == [["0.4999996", "0.4999998", "0.5", "0.5000002"], ["0", "0.5", "1"]]
    view = view_of(page, "Diagram")
    field(view, "over").select_option("start.v0")
    fill(view, "from", "0.499999590000001")
    fill(view, "to", "0.50000043")
    fill(view, "values", "200")
    compute(view)
    for name in ("from", "to"):
        box = field(view, name)
        assert box.evaluate("it => it.scrollWidth <= it.clientWidth")
    over = view.locator(".u-over").first
    seen = set()
    for across in (0.2, 0.21, 0.22):
        page.mouse.move(*middle(over, across))
        seen.add(view.locator(".readout").first.inner_text().split(",")[0])
    assert len(seen) == 3
    before = drawn(page)
    page.mouse.click(*middle(over, 0.25))
    wait_for_drawing(page, before)
    v0 = float(page.locator("#p-start-v0").input_value())
    assert v0 == pytest.approx(0.49999959 + 0.25 * 8.4e-7, abs=2e-8)


def test_cards_dim_with_the_plots_after_a_wrong_value(page: Page) -> None:
    expect(page.locator(".facts .card").nth(1)).to_contain_text("largest exponent")
    orbit = fact(page, 2)
    set_box(page, "oscillator.damping", "x")
    expect(page.locator(".explore")).to_have_class("explore stale")
    page.wait_for_timeout(600)
    assert page.locator(".facts").evaluate("it => Number(getComputedStyle(it).opacity)") < 1
    assert fact(page, 2) == orbit


@pytest.mark.parametrize("kind", ["diagram", "response", "basins"])
def test_without_harmonics_a_plain_sentence(study: dict[str, Any], kind: str) -> None:
    study["forcing"] = {"harmonics": []}
    study["run"] = {"t_end": 100}
    with pytest.raises(BadRequest, match="a periodic force: add a harmonic in Explore"):
        study_of_view(PageRequest(1, kind, study, {**NARROW}))


def test_an_orbit_that_is_unstable_is_called_so(page: Page) -> None:
    open_preset(page, "chaos")
    expect(page.locator(".facts .card").nth(2)).to_contain_text("unstable")
    expect(page.locator(".facts .card").nth(2)).to_contain_text("the motion cannot stay on it")
