"""The mass moves in its picture: its place, time, sound, and the start that a hand gives it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Locator, Page, expect
from tests.web.frames import read_frame
from tests.web.hands import (
    WAIT,
    box_of,
    drag,
    drawn,
    follow_link,
    middle,
    open_preset,
    set_box,
    view_of,
    wait_for_drawing,
)

import percuss as pc
from percuss.web.explore import answer_explore
from percuss.web.mechanisms import elements_of_oscillator
from percuss.web.request import PageRequest

# The script of the page, and what is seen of a mass and of the marks of the plots.
PLACE = """() => {
  const { x, width } = document.querySelector('.explore .handle').getBoundingClientRect();
  const wall = document.querySelector('.explore .mechanism .wall').getBoundingClientRect();
  return [x + width, wall.left];
}"""
MARKS = """() => [...document.querySelectorAll('.explore .plot')].flatMap((plot) => {
  const [over, dot, line] = ['.u-over', '.dot', '.time'].map((it) => plot.querySelector(it));
  if (!over) return [];
  const [{ x: [low, high], y: [bottom, top] }, box] = [JSON.parse(plot.querySelector('.canvas').dataset.limits), over.getBoundingClientRect()];
  const at = (it) => {
    if (it.hidden) return null;
    const { left, top: up, width, height } = it.getBoundingClientRect();
    return [low + (high - low) * (left + width / 2 - box.left) / box.width, top - (top - bottom) * (up + height / 2 - box.top) / box.height];
  };
  return [{ title: plot.querySelector('strong').textContent, dot: at(dot), line: at(line)?.[0] ?? null, unit: [(high - low) / box.width, (top - bottom) / box.height] }];
})"""


def asked(tables: dict[str, Any], **options: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    return read_frame(answer_explore(PageRequest(1, "explore", tables, options)))


def displacement(page: Page) -> float:
    """Return the displacement at which the picture is drawn."""
    text = page.locator(".explore svg.mechanism").get_attribute("data-x")
    return float(json.loads(text or "")[0])


def slider(page: Page) -> Locator:
    return page.locator(".explore").get_by_label("time of the picture")


def go(page: Page, share: float) -> float:
    """Move the slider of the time, and return the time that it says."""
    slider(page).evaluate(
        "(it, value) => { it.value = value; it.dispatchEvent(new Event('input')); }",
        str(round(1000 * share)),
    )
    return float((slider(page).get_attribute("aria-valuetext") or "")[4:])


def first_run() -> Any:
    """Return the run of the first preset, which the page begins with."""
    osc = pc.impact_oscillator(damping="0.05", restitution="0.8", wall="0.2", side="above")
    return pc.simulate(osc, pc.cosine("2.8"), v0="0.5", periods=60)


def test_the_answer_has_velocities_forces_and_the_picture(study: dict[str, Any]) -> None:
    header, arrays = asked(study)
    run = pc.simulate(
        pc.impact_oscillator(damping="0.05", restitution="0.8", wall="0.2", side="above"),
        pc.cosine("2.8"),
        v0="0.5",
        periods=40,
    )
    made = header["elements"]

    assert (made["n"], made["springs"], made["dashpots"]) == (1, [[-1, 0]], [[-1, 0]])
    assert made["stops"] == [{"on": [1.0], "at": 0.2, "side": "above", "type": "wall"}]
    assert made["loads"] == [[1.0]]
    assert "force0" not in arrays
    np.testing.assert_allclose(arrays["impulse"], run.impacts.impulse, rtol=1e-6)
    # Both sides of each jump are there.
    at = np.searchsorted(arrays["velocity_t"], arrays["event_t"], "right") - 1
    np.testing.assert_allclose(arrays["v"][at], run.impacts.v_after, atol=1e-5)
    np.testing.assert_allclose(arrays["v"][at - 1], run.impacts.v_before, atol=1e-5)


def test_the_forces_of_soft_stops_and_of_contacts_are_those_of_the_run(
    study: dict[str, Any],
) -> None:
    soft = {"type": "soft", "at": "0.1", "side": "above", "stiffness": 9, "damping": "0.1"}
    rest = {"type": "wall", "at": "-0.2", "side": "below", "restitution": 0}
    study["oscillator"]["stops"] = [soft, rest]
    study["start"] = {"x0": 0, "v0": 0}
    study["run"] = {"periods": 8}
    _, arrays = asked(study)
    osc = pc.Oscillator(
        damping="0.05",
        stops=(
            pc.SoftStop(at="0.1", side="above", stiffness=9, damping="0.1"),
            pc.Wall(at="-0.2", side="below", restitution=0),
        ),
    )
    run = pc.simulate(osc, pc.cosine("2.8"), periods=8)

    assert len(run.contacts) > 0
    for i in range(2):
        t = arrays[f"force_t{i}"].astype(float)
        # Away from the ends of contacts, where a force jumps.
        ends = np.concatenate([run.contacts.start, run.contacts.release, run.crossings.t])
        far = (np.abs(t[:, np.newaxis] - ends) > 1e-4).all(axis=1) & (t <= run.t_end)
        wanted = run.forces(t[far])["stops"].values[i]
        assert np.abs(wanted).max() > 0.1
        np.testing.assert_allclose(arrays[f"force{i}"][far], wanted, atol=1e-3)


def test_what_is_not_there_is_not_in_the_picture() -> None:
    free = pc.impact_oscillator(stiffness=0)
    assert elements_of_oscillator(free, None)["loads"] == []
    assert elements_of_oscillator(free, pc.Forcing(constant="0"))["loads"] == []
    both = pc.Forcing(pc.cosine(2).harmonics, constant=-1)
    assert elements_of_oscillator(free, both)["loads"] == [[1.0]]
    assert elements_of_oscillator(free, None)["dashpots"] == []


def test_the_mass_is_where_the_curve_is_and_one_cursor_goes_through_all_plots(page: Page) -> None:
    run = first_run()
    scale = None
    for share in (0.137, 0.5, 0.731, 1.0):
        t = go(page, share)
        x = displacement(page)
        marks = {it["title"]: it for it in page.evaluate(MARKS)}

        # The time is told in five digits; the mass moves at 1 at most.
        assert x == pytest.approx(float(run(min(t, run.t_end))[0]), abs=0.012)
        right, wall = page.evaluate(PLACE)
        scale = scale or (wall - right) / (0.2 - x)
        # A pixel of the picture, but for the width of the line.
        assert wall - right == pytest.approx(scale * (0.2 - x), abs=1.5)
        for name in ("Displacement", "Velocity", "Impulses at stops"):
            assert marks[name]["line"] == pytest.approx(t, abs=1.5 * marks[name]["unit"][0])
        (at, to), (width, height) = (marks["Displacement"][it] for it in ("dot", "unit"))
        assert at == pytest.approx(t, abs=1.5 * width)
        assert to == pytest.approx(x, abs=height)
        (at, v), (width, height) = (marks["Phase portrait"][it] for it in ("dot", "unit"))
        assert at == pytest.approx(x, abs=width)
        assert marks["Velocity"]["dot"][1] == pytest.approx(v, abs=1.5 * height)
        last = int(np.searchsorted(run.impacts.t, t)) - 1
        assert marks["Impacts"]["dot"][0] == pytest.approx(float(run.impacts.cycle[last]), abs=0.01)


def test_play_moves_pause_stops_and_speed_changes_how_fast(page: Page) -> None:
    view = page.locator(".explore")
    # Nothing moves by itself.
    before = displacement(page)
    page.wait_for_timeout(120)
    assert displacement(page) == before
    moving = page.evaluate(
        """async () => {
          const { Player } = await import('/static/js/player.js');
          const times = [];
          const player = new Player((time) => times.push(time));
          document.querySelector('.explore').append(player.root);
          const frames = [];
          const { requestAnimationFrame: asked } = window;
          window.requestAnimationFrame = (step) => frames.push(step);
          player.take(0, 100, 3);
          player.button.click();
          const run = (now) => frames.pop()(now);
          [0, 50, 100].forEach(run);
          const usual = player.time;
          player.speed.select.value = '0.25';
          player.speed.select.dispatchEvent(new Event('change'));
          run(150);
          const slow = player.time - usual;
          window.requestAnimationFrame = asked;
          player.root.remove();
          player.close();
          return [usual, slow];
        }"""
    )
    # A period of 3 in 1.5 s: 0.2 in a tenth of a second; then a quarter of that.
    assert moving == pytest.approx([0.2, 0.025])
    view.get_by_role("button", name="Play").click()
    page.wait_for_function(
        "x => document.querySelector('.explore svg.mechanism').dataset.x !== x",
        arg=json.dumps([before]),
    )
    view.get_by_role("button", name="Pause").click()
    before = displacement(page)
    page.wait_for_timeout(100)
    assert displacement(page) == before


def test_a_hover_shows_its_time_and_then_that_of_the_player_again(page: Page) -> None:
    go(page, 0.25)
    kept = displacement(page)
    for k in (0, 1, 3):
        over = page.locator(".explore .u-over").nth(k)
        over.scroll_into_view_if_needed()
        page.mouse.move(*middle(over, 0.6))
        page.wait_for_function(
            "x => document.querySelector('.explore svg.mechanism').dataset.x !== x",
            arg=json.dumps([kept]),
        )
        page.mouse.move(5, 5)
        expect(page.locator(".explore svg.mechanism")).to_have_attribute(
            "data-x", json.dumps([kept])
        )


def test_the_mass_is_dragged_to_its_start_and_moved_by_keys(page: Page) -> None:
    go(page, 0.5)
    handle = page.locator(".explore .handle")
    right, wall = page.evaluate(PLACE)
    scale = (wall - right) / (0.2 - displacement(page))
    begin = middle(handle)
    x = displacement(page)
    seen = drawn(page)
    drag(page, begin, (begin[0] - 30, begin[1]))
    wait_for_drawing(page, seen)

    x0 = float(box_of(page, "start.x0").input_value())
    assert x0 == pytest.approx(x - 30 / scale, abs=2 / scale)
    expect(slider(page)).to_have_value("0")
    page.wait_for_function(
        "x0 => JSON.parse(document.querySelector('.explore svg.mechanism').dataset.x)[0].toFixed(4) === x0.toFixed(4)",
        arg=x0,
    )

    # No further than the wall, which has words of its own.
    set_box(page, "oscillator.stops.0.at", "1/5")
    begin = middle(handle)
    drag(page, begin, (begin[0] + 400, begin[1]))
    expect(box_of(page, "start.x0")).to_have_value("1/5")
    expect(handle).to_be_focused()
    page.keyboard.press("ArrowLeft")
    expect(box_of(page, "start.x0")).to_have_value("0.19")
    # Each key counts from the start that is set, also before its motion is drawn.
    handle.evaluate(
        """it => {
          for (const [key, shiftKey] of [['ArrowLeft', false], ['ArrowDown', true]]) {
            it.dispatchEvent(new KeyboardEvent('keydown', { key, shiftKey, bubbles: true }));
          }
        }"""
    )
    expect(box_of(page, "start.x0")).to_have_value("0.179")
    expect(handle).to_have_attribute("aria-valuetext", "x0 = 0.179")
    expect(page.locator(".explore .stage > .fault")).to_be_empty()


def test_what_an_expression_sets_no_hand_moves(
    page: Page, address: str, study: dict[str, Any]
) -> None:
    state = {
        "view": "explore",
        "study": {**study, "parameters": {"h": "0.1"}, "start": {"x0": "h", "v0": 0}},
    }
    follow_link(page, address, state)

    assert displacement(page) == pytest.approx(0.1, abs=1e-6)
    expect(page.locator(".explore .handle")).to_be_hidden()


def test_a_ball_stands_upright_on_its_table(page: Page) -> None:
    open_preset(page, "ball_on_table")
    picture = page.locator(".explore svg.mechanism")
    expect(picture.locator("circle.mass")).to_have_count(1)
    expect(picture.locator(".spring")).to_have_count(0)
    places = {}
    for share in (0.0, 0.02, 0.04, 0.06):
        go(page, share)
        bottom, table = picture.evaluate(
            """it => ['circle.mass', '.wall'].map((name) => it.querySelector(name).getBoundingClientRect().bottom)"""
        )
        places[displacement(page)] = table - bottom
    low, *_, high = sorted(places)
    assert high > low
    # Up is above.
    assert [places[x] for x in sorted(places)] == sorted(places.values())
    assert min(places.values()) > -1
    begin = middle(picture.locator(".handle"))
    x = displacement(page)
    drag(page, begin, (begin[0], begin[1] - 20))
    page.wait_for_function("x => Number(document.querySelector('#p-start-x0').value) > x", arg=x)


SCHEDULE = """async (impacts) => {
  const { clicksBetween } = await import('/static/js/clicks.js');
  const found = [];
  // Frames of 1/60 s, each from where the one before ended.
  for (let now = 0; now < impacts.end; now += 0.03) {
    for (const it of clicksBetween(impacts, now, now + 0.03, 1.8)) found.push([it.time, now + 1.8 * it.delay, it.loudness]);
  }
  return found;
}"""
# Sounds are written down instead.
SILENCE = """() => {
  window.sounds = [];
  const value = () => ({ setValueAtTime() {}, exponentialRampToValueAtTime() {} });
  const node = () => ({ frequency: value(), gain: value(), connect: (to) => to, start: (at) => window.sounds.push(at), stop() {} });
  window.AudioContext = class {
    get currentTime() { return performance.now() / 1000; }
    resume() {}
    close() {}
    createOscillator() { return node(); }
    createGain() { return node(); }
  };
}"""


def test_clicks_are_scheduled_at_the_impacts_and_as_loud_as_these_are_fast(page: Page) -> None:
    run = first_run()
    speeds = np.abs(run.impacts.v_before)
    impacts = {
        "times": run.impacts.t.tolist(),
        "speeds": speeds.tolist(),
        "fastest": float(speeds.max()),
        "end": float(run.t_end),
    }
    found = np.array(page.evaluate(SCHEDULE, impacts))
    heard = speeds >= 0.02 * speeds.max()

    assert heard.sum() > 20
    np.testing.assert_allclose(found[:, 0], run.impacts.t[heard])
    np.testing.assert_allclose(found[:, 1], run.impacts.t[heard], rtol=1e-12)
    np.testing.assert_allclose(found[:, 2], speeds[heard] / speeds.max())


@pytest.mark.parametrize("name", ["Explore", "Structure"])
def test_the_sound_is_mute_until_it_is_put_on(page: Page, name: str) -> None:
    page.evaluate(SILENCE)
    view = view_of(page, name)
    page.wait_for_selector(f".{name.lower()}[data-drawn]", timeout=WAIT)
    view.locator(".speed select").select_option("4")
    view.get_by_role("button", name="Play").click()
    page.wait_for_timeout(400)
    assert page.evaluate("window.sounds.length") == 0
    sound = view.get_by_role("button", name="Sound")
    expect(sound).to_have_attribute("aria-pressed", "false")
    sound.click()
    expect(sound).to_have_attribute("aria-pressed", "true")
    page.wait_for_function("() => window.sounds.length > 1")
    sound.click()
    view.get_by_role("button", name="Pause").click()
    before = page.evaluate("window.sounds.length")
    page.wait_for_timeout(100)
    assert page.evaluate("window.sounds.length") == before
    page.goto("about:blank")


def test_who_wants_less_motion_scrubs_and_drags(page: Page) -> None:
    page.emulate_media(reduced_motion="reduce")
    expect(page.locator(".explore .player button:visible")).to_have_count(0)
    before = displacement(page)
    go(page, 0.3)
    assert displacement(page) != before
    page.emulate_media(reduced_motion="no-preference")


def test_paper_has_a_still_in_light_colours(tab: Page, address: str) -> None:
    opened = tab.context.new_page()
    opened.emulate_media(color_scheme="dark")
    opened.goto(f"http://{address}/")
    opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
    root = opened.locator("#percuss")
    opened.emulate_media(media="print")
    opened.evaluate("() => { dispatchEvent(new Event('beforeprint')); }")
    expect(root).to_have_attribute("data-theme", "light")
    expect(opened.locator(".explore .player")).to_be_hidden()
    expect(opened.locator(".explore svg.mechanism")).to_be_visible()
    opened.evaluate("() => { dispatchEvent(new Event('afterprint')); }")
    expect(root).to_have_attribute("data-theme", "dark")
    opened.close()


def test_a_zoom_of_the_velocity_is_one_of_all_times(page: Page) -> None:
    over = page.locator(".explore .u-over").nth(3)
    over.scroll_into_view_if_needed()
    seen = drawn(page)
    drag(page, middle(over, 0.25), middle(over, 0.5))
    wait_for_drawing(page, seen)
    ends = page.evaluate(
        "() => [0, 3, 4].map((k) => JSON.parse(document.querySelectorAll('.explore .plot .canvas')[k].dataset.limits).x)"
    )
    width = first_run().t_end
    for low, high in ends:
        assert low == pytest.approx(0.25 * width, abs=0.02 * width)
        assert high == pytest.approx(0.5 * width, abs=0.02 * width)
    seen = drawn(page)
    page.locator(".explore .canvas").nth(3).focus()
    page.keyboard.press("0")
    wait_for_drawing(page, seen)
    assert slider(page).get_attribute("aria-valuetext") is not None
