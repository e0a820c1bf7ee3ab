"""Structures of two and three masses on the page: answers of the server, and what is seen."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect
from tests.web.frames import read_frame
from tests.web.hands import WAIT, link_of
from tests.web.test_server import fetched

import percuss as pc
from percuss.errors import ParameterError
from percuss.web.mechanisms import MECHANISMS, elements_of
from percuss.web.request import BadRequest, PageRequest
from percuss.web.structure_view import (
    answer_mechanism,
    answer_mechanism_facts,
    mechanism_python,
    mechanism_rows,
)


def request(name: str, values: Any = None, **options: Any) -> PageRequest:
    return PageRequest(1, "mechanism", {}, {"name": name, "values": values or {}, **options})


def asked(
    name: str, values: Any = None, answer: Callable[..., bytes] = answer_mechanism, **options: Any
) -> tuple[dict[str, Any], dict[str, Any]]:
    return read_frame(answer(request(name, values, **options)))


def scripted(name: str, values: Any = None) -> Any:
    """Return the run of the script that the page copies."""
    found: dict[str, Any] = {}
    code = mechanism_python(request(name, values))
    # The picture is left out.
    exec("\n".join(code.splitlines()[:-1]), found)  # noqa: S102 - the page's own script
    return found["run"]


@pytest.mark.parametrize("name", MECHANISMS)
def test_the_copied_script_has_the_motion_of_the_page(name: str) -> None:
    header, arrays = asked(name)
    run = scripted(name)
    met = np.concatenate([run.impacts.t, run.crossings.t[run.crossings.direction == "in"]])

    assert header["outcome"] == run.outcome.value
    assert sum(it["n_impacts"] + it["n_entries"] for it in header["stops"]) == len(met) > 50
    np.testing.assert_allclose(arrays["event_t"], np.sort(met), rtol=1e-6)
    x, _ = run(np.clip(arrays["t"].astype(float), run.t0, run.t_end))
    # Times are sent in single precision.
    for i in range(run.structure.n):
        np.testing.assert_allclose(arrays[f"x{i}"], x[:, i], atol=2e-4)


def test_at_an_impact_the_masses_are_a_gap_apart_and_the_portrait_jumps() -> None:
    header, arrays = asked("impact_pair", {"periods": 8})
    apart = arrays["x1"] - arrays["x0"]
    # An event has two points; to what is sent in single precision others may be equal, too.
    at = np.searchsorted(arrays["t"], arrays["event_t"])

    assert len(at) == sum(it["n_impacts"] for it in header["stops"]) > 10
    np.testing.assert_allclose(np.abs(apart[at]), 0.5, atol=1e-5)
    speed = arrays["portrait_v1"] - arrays["portrait_v0"]
    last = np.searchsorted(arrays["portrait_t"], arrays["event_t"], "right") - 1
    np.testing.assert_allclose(np.abs(speed[last - 1]), arrays["speed"], rtol=1e-3)
    np.testing.assert_allclose(speed[last], -0.7 * speed[last - 1], rtol=1e-3)


def test_what_the_force_gives_goes_into_impacts_and_dashpots() -> None:
    header, _ = asked("impact_pair")
    run = scripted("impact_pair")
    period = run.loads.period
    t = np.linspace(run.t_end - 20 * period, run.t_end, 200_001)
    power = (run.forces(t)["damping"].values * run(t)[1]).sum(axis=1)
    taken = -float(((power[1:] + power[:-1]) * np.diff(t)).sum()) / 2 / (t[-1] - t[0])

    assert header["energy"]["dashpots"] == pytest.approx(taken, rel=1e-3)
    assert header["energy"]["impacts"] > header["energy"]["dashpots"]


def test_the_orbit_is_the_one_that_the_motion_settles_to() -> None:
    header, arrays = asked("two_masses", answer=answer_mechanism_facts)
    orbit = header["orbit"]
    run = scripted("two_masses", {"periods": 200})
    x, v = run(run.t_end)

    assert (orbit["n_impacts"], orbit["n_periods"], orbit["is_stable"]) == (1, 1, True)
    assert len(orbit["multipliers"]) == 4
    for i in range(2):
        assert arrays[f"orbit_x{i}"][0] == pytest.approx(x[i], abs=1e-4)
        assert arrays[f"orbit_v{i}"][0] == pytest.approx(v[i], abs=1e-4)


def test_where_nothing_repeats_there_is_no_orbit() -> None:
    # No loss: the start is never forgotten.
    values = {"restitution": 1, "dashpots.0": 0, "dashpots.1": 0}
    assert asked("impact_pair", values, answer_mechanism_facts)[0]["orbit"] is None
    assert asked("impact_pair", {"amplitude": 0}, answer_mechanism_facts)[0]["orbit"] is None


def test_masses_that_stay_together_are_in_contact() -> None:
    header, arrays = asked("impact_pair", {"restitution": 0, "periods": 20})
    held = np.abs(arrays["force0"]) + np.abs(arrays["force1"]) > 1e-6

    assert header["n_contacts"] > 0
    assert held.any()
    np.testing.assert_allclose(np.abs(arrays["x1"] - arrays["x0"])[held], 0.5, atol=1e-6)


@pytest.mark.parametrize(
    ("values", "path"),
    [
        ({"masses.0": 0}, "masses.0"),
        ({"gap": "-1/2"}, "gap"),
        ({"restitution": "1.2"}, "restitution"),
        ({"omega": 0}, "omega"),
        ({"omega": "fast"}, "omega"),
        ({"periods": 0}, "periods"),
        ({"periods": 1e9}, "periods"),
        ({"v.1": True}, "v.1"),
        ({"amplitude": "1e400"}, "amplitude"),
        ({"springs.2": None}, "springs.2"),
        ({"springs.2": math.nan}, "springs.2"),
    ],
)
def test_a_wrong_value_is_told_beside_its_slider(values: dict[str, Any], path: str) -> None:
    with pytest.raises(ParameterError) as caught:
        asked("impact_pair", values)
    assert caught.value.name == path


@pytest.mark.parametrize(
    ("name", "values", "sentence"),
    [
        ("impact_pair", {"x.1": 1}, "the start: x2 - x1 = 1 is above the wall at 0.5"),
        ("impact_pair", {"x.0": "0.75"}, "the start: x2 - x1 = -0.75 is below the wall at -0.5"),
        ("three_masses", {"x.2": 1}, "the start: x3 = 1 is above the wall at 0.4"),
        ("two_masses", {"masses.1": 1e-9}, "3e.06 times in this motion; .* 200,000 at most"),
        ("two_masses", {"mass": 1}, "Two masses with a stop has no parameter 'mass'"),
        ("two_masses", [1], "the values are not a JSON object"),
        ("pendulum", {}, "name is none of impact_pair, "),
    ],
)
def test_what_has_no_slider_is_told_in_a_sentence(name: str, values: Any, sentence: str) -> None:
    with pytest.raises(BadRequest, match=sentence):
        asked(name, values)


def test_a_motion_that_grows_beyond_all_numbers_has_an_answer() -> None:
    header, _ = asked("absorber", {"stiffness": -1})
    assert header["n_grazes"] >= 0
    assert asked("absorber", {"stiffness": -1}, answer_mechanism_facts)[0]["orbit"] is None


def test_a_window_is_sampled_more_finely() -> None:
    _, arrays = asked("two_masses", window=[10.0, 12.0], points=400)
    assert arrays["t"][0] == 10.0
    assert arrays["t"][-1] == 12.0
    assert 400 <= len(arrays["t"]) < 420


def test_pictures_are_made_of_what_the_matrices_join() -> None:
    three = MECHANISMS["three_masses"]
    made = elements_of(*three.system(three.defaults)[:2])
    assert made["springs"] == [[-1, 0], [-1, 2], [0, 1], [1, 2]]
    assert made["loads"] == [[1.0, 0.0, 0.0]]
    # A rotor's gyroscopic matrix joins both ways, and no mass to the ground.
    rotor = pc.Structure(mass=[1, 1], stiffness=[1, 1], damping=[[0, "0.3"], ["-0.3", 0]])
    assert elements_of(rotor, pc.Loads())["springs"] == [[-1, 0], [-1, 1]]
    assert [row["name"] for row in mechanism_rows()] == list(MECHANISMS)


def test_the_script_of_a_structure_is_a_file(address: str) -> None:
    body = {"kind": "mechanism", "name": "absorber", "values": {"gap": "1/3"}}
    status, _, text = fetched(address, "/api/file/py", json.dumps(body).encode())
    assert status == 200
    assert b"gap='1/3'" in text
    assert fetched(address, "/api/file/png", json.dumps(body).encode())[0] == 422


def structure(page: Page, name: str) -> Locator:
    """Open a structure of the gallery, and wait until it is drawn."""
    page.locator("[data-view=gallery]").click()
    page.locator(f"[data-mechanism={name}]").click()
    view = page.locator("section[aria-label=Structure]")
    page.wait_for_function("() => document.querySelector('.structure').dataset.drawn", timeout=WAIT)
    return view


def places(view: Locator) -> list[float]:
    """Return the displacements that the picture shows."""
    found: list[float] = json.loads(view.locator("svg.mechanism").get_attribute("data-x") or "")
    return found


def test_the_picture_is_the_structure_and_follows_its_time(page: Page) -> None:
    view = structure(page, "three_masses")
    picture = view.locator("svg.mechanism")
    expect(picture).to_have_attribute("aria-label", "3 masses, 4 springs, 4 dashpots, 2 stops")
    for name, n in (("mass", 3), ("spring", 4), ("dashpot", 4), ("wall", 1), ("soft", 1)):
        expect(picture.locator(f".{name}")).to_have_count(n)
    assert places(view) == [0, 0, 0]
    time = view.get_by_label("time of the picture")
    time.focus()
    page.keyboard.press("End")
    run = scripted("three_masses")
    assert places(view) == pytest.approx(run(run.t_end)[0].tolist(), abs=1e-4)
    assert time.get_attribute("aria-valuetext") == "t = 418.88"

    # It plays until it is stopped, from its beginning again.
    view.get_by_role("button", name="Play").click()
    page.wait_for_function("() => Number(document.querySelector('.player input').value) !== 1000")
    view.get_by_role("button", name="Pause").click()
    before = places(view)
    page.wait_for_timeout(100)
    assert places(view) == before


def test_entries_into_a_soft_stop_are_no_impacts(page: Page) -> None:
    view = structure(page, "two_masses")
    expect(view.locator(".card").nth(2)).to_contain_text("1 entry into a stop in 1 forcing period")
    expect(view.locator(".card").nth(1)).to_contain_text("59 entries into a stop")
    view = structure(page, "three_masses")
    orbit = "4 impacts and entries into a stop in 1 forcing period"
    expect(view.locator(".card").nth(2)).to_contain_text(orbit)


def test_who_wants_less_motion_gets_the_slider_of_the_time_alone(page: Page) -> None:
    page.emulate_media(reduced_motion="reduce")
    view = structure(page, "impact_pair")
    expect(view.locator(".player button:visible")).to_have_count(0)
    expect(view.get_by_label("time of the picture")).to_be_visible()
    page.emulate_media(reduced_motion="no-preference")


def test_a_link_holds_the_structure_and_keys_reach_its_controls(page: Page) -> None:
    view = structure(page, "impact_pair")
    view.get_by_label("mass m2", exact=True).fill("1/4")
    of = view.get_by_label("phase portrait of")
    of.focus()
    page.keyboard.press("End")
    expect(of).to_have_value("1")
    expect(of).to_be_focused()
    link = link_of(page)
    page.goto("about:blank")
    page.goto(link)

    expect(view.get_by_label("mass m2", exact=True)).to_have_value("1/4", timeout=WAIT)
    expect(of).to_have_value("1")
    expect(view.get_by_label("Preset")).to_have_value("impact_pair")
    unnamed = view.evaluate(
        """it => [...it.querySelectorAll('button, input, select')].filter((one) => one.offsetParent
          && !one.ariaLabel && !one.labels?.length && !one.textContent.trim()).length"""
    )
    assert unnamed == 0


def test_faults_stand_where_they_are_and_the_picture_stays(page: Page) -> None:
    view = structure(page, "impact_pair")
    restitution = view.get_by_label("restitution r", exact=True)
    restitution.fill("2")
    row = view.locator(".row", has=page.get_by_label("restitution r", exact=True))
    expect(row.locator(".fault")).to_contain_text("outside [0, 1]")
    expect(view).to_have_class("structure stale")
    restitution.fill("0.6")
    expect(row.locator(".fault")).to_have_text("")
    view.get_by_label("x2", exact=True).fill("1")
    said = view.locator(".stage > .fault")
    expect(said).to_have_text("the start: x2 - x1 = 1 is above the wall at 0.5")
    view.get_by_label("x2", exact=True).fill("0.1")
    expect(said).to_have_text("")
    view.get_by_label("Preset").select_option("absorber")
    expect(view.locator(".facts")).to_contain_text("in 2 forcing periods", timeout=WAIT)
    # A motion without a period of its own, here one that runs away, says so.
    view.get_by_label("beam k", exact=True).fill("-1")
    expect(view.locator(".facts")).to_contain_text("none found", timeout=WAIT)
    expect(view.locator(".mass")).to_have_count(2)


def test_the_script_is_copied(page: Page) -> None:
    page.evaluate(
        """() => { Object.defineProperty(navigator, 'clipboard', { configurable: true,
          value: { writeText: async (text) => { window.copied = text; } } }); }"""
    )
    structure(page, "two_masses")
    page.get_by_role("button", name="Copy as Python").click()
    page.wait_for_function("() => window.copied")
    assert "pc.SoftStop(at='0.5', side='above', stiffness=20" in page.evaluate("window.copied")
    page.goto("about:blank")
