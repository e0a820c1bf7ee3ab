"""Chaos, or still on its way: what the page says where no period is found."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from playwright.sync_api import Page, WebSocketRoute, expect
from tests.web.frames import read_frame
from tests.web.hands import WAIT

import percuss as pc
from percuss.errors import PercussError
from percuss.web import facts
from percuss.web.explore import answer_explore
from percuss.web.facts import answer_facts, exponent_of
from percuss.web.presets import presets
from percuss.web.request import PageRequest, study_of


def told(study: dict[str, Any]) -> dict[str, Any]:
    return read_frame(answer_facts(PageRequest(1, "facts", study, {})))[0]


def kind_of(study: dict[str, Any]) -> str:
    header = read_frame(answer_explore(PageRequest(1, "explore", study, {})))[0]
    return str(header["impact_times"]["kind"])


def test_a_forcing_so_slow_that_each_period_is_a_billion_swings_is_answered_at_once(
    study: dict[str, Any],
) -> None:
    study["forcing"]["harmonics"][0]["omega"] = "1e-9"

    # It took minutes, in which the page was told nothing of any other motion.
    assert told(study)["exponent"] is None


def test_chaos_has_an_exponent_above_its_error(study: dict[str, Any]) -> None:
    study["oscillator"]["damping"] = 0
    study["oscillator"]["stops"][0]["at"] = 0
    assert kind_of(study) == "no_period_found"
    exponent = told(study)["exponent"]

    osc = pc.impact_oscillator("0.8", side="above")
    exponents = pc.lyapunov_exponents(osc, pc.cosine("2.8"), start=(0, "0.5"), transient=500)
    assert exponent["is_chaotic"]
    assert exponent["value"] == pytest.approx(exponents.exponents[0], abs=5 * exponent["error"])


def test_a_motion_on_its_way_is_not_chaotic(study: dict[str, Any]) -> None:
    study["run"]["periods"] = 14
    assert kind_of(study) == "no_period_found"
    exponent = told(study)["exponent"]

    assert not exponent["is_chaotic"]
    assert exponent["is_settling"]


def test_neighbours_that_part_by_a_power_of_the_time_are_no_chaos(study: dict[str, Any]) -> None:
    study["oscillator"] = {
        "stiffness": 1,
        "damping": 0,
        "stops": [{"type": "wall", "at": 0, "side": "below", "restitution": 1}],
    }
    study["forcing"] = {"harmonics": [{"amplitude": 1, "omega": 1, "phase": 0}]}
    study["start"] = {"x0": 0, "v0": 0}
    exponent = told(study)["exponent"]

    assert exponent is None or not exponent["is_chaotic"]


def test_a_contact_that_ends_all_memory_has_no_finite_exponent(study: dict[str, Any]) -> None:
    study["oscillator"]["stops"][0] = {"type": "wall", "at": 0, "side": "below", "restitution": 0}
    study["forcing"] |= {"constant": "-0.6"}
    study["start"] = {"x0": 1, "v0": 0}

    assert told(study)["exponent"]["value"] is None


def test_what_is_slow_has_no_exponent(
    study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    found = study_of(study)
    run = pc.simulate(found.oscillator, found.forcing, v0="0.5", periods=10)

    assert exponent_of(found, run) is not None
    assert exponent_of(replace(found, force=None), run) is None
    monkeypatch.setattr(facts, "MOST_TERMS", 3)
    assert exponent_of(found, run) is None


def test_without_a_forcing_there_is_no_orbit_and_no_fault(study: dict[str, Any]) -> None:
    study["forcing"] = {"harmonics": []}
    study["run"] = {"t_end": 100}

    assert told(study)["orbit"] is None


def test_an_orbit_that_motions_follow_comes_before_a_formal_one(
    study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = pc.find_orbit
    calls = []

    def first_formal(*args: Any, **options: Any) -> Any:
        calls.append(options)
        orbit = real(*args, **options)
        return replace(orbit, admissible=False, grazing_margin=-0.1) if len(calls) == 1 else orbit

    returns = facts._returns
    monkeypatch.setattr(facts, "_returns", lambda *it: [next(returns(*it))] * 2)
    monkeypatch.setattr(facts, "find_orbit", first_formal)
    assert told(study)["orbit"]["admissible"]
    assert len(calls) == 2

    def formal(*args: Any, **options: Any) -> Any:
        return replace(real(*args, **options), admissible=False, grazing_margin=-0.1)

    monkeypatch.setattr(facts, "find_orbit", formal)
    orbit = told(study)["orbit"]
    assert not orbit["admissible"]
    assert not orbit["grazes"]


def test_a_clearance_below_the_error_of_its_orbit_is_a_graze(
    study: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    real = pc.find_orbit

    def hairy(*args: Any, **options: Any) -> Any:
        return replace(real(*args, **options), admissible=False, grazing_margin=-2.4e-34)

    monkeypatch.setattr(facts, "find_orbit", hairy)
    orbit = told(study)["orbit"]

    assert orbit["grazes"]
    assert orbit["grazing_margin"] == 0.0
    assert orbit["admissible"]


def test_no_orbit_of_a_motion_that_cannot_be_followed(study: dict[str, Any]) -> None:
    study["start"]["x0"] = 5
    with pytest.raises(PercussError):
        answer_facts(PageRequest(1, "facts", study, {}))


def test_an_orbit_that_is_known_before_its_curve_is_drawn(tab: Page, address: str) -> None:
    opened = tab.context.new_page()
    held: list[bytes] = []
    told: list[str] = []

    def relay(ours: WebSocketRoute) -> None:
        server = ours.connect_to_server()

        def hear(data: str | bytes) -> None:
            assert isinstance(data, bytes)
            kind = read_frame(data)[0]["kind"]
            if kind == "explore" and "facts" not in told:
                held.append(data)
                return
            told.append(kind)
            ours.send(data)
            while held:
                ours.send(held.pop(0))

        server.on_message(hear)

    opened.route_web_socket("**/api/socket", relay)
    opened.goto(f"http://{address}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    expect(opened.locator(".explore .plot:has(.canvas) .key").nth(1)).to_contain_text(
        "nearest orbit"
    )
    expect(opened.locator(".facts .card").nth(1)).to_contain_text("largest exponent")
    opened.close()


@pytest.mark.parametrize(("name", "is_chaotic"), [("chaos", True), ("two_attractors", False)])
def test_presets_show_what_their_names_say(name: str, is_chaotic: bool) -> None:
    tables = next(it.tables for it in presets() if it.name == name)
    assert told(tables)["exponent"]["is_chaotic"] == is_chaotic
    # A start elsewhere settles on the other motion.
    other = told({**tables, "start": {"x0": 0, "v0": 0}})["orbit"]
    if name == "two_attractors":
        assert (told(tables)["orbit"]["n_impacts"], other["n_impacts"]) == (1, 0)
