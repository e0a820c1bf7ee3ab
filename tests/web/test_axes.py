"""Axes end, whatever their ends are; a plot that fails leaves the others."""

from __future__ import annotations

import pytest
from playwright.sync_api import Page, expect
from tests.web.hands import drawn, limits, set_box, slider_of, wait_for_drawing

# Ends over all orders of magnitude, half of them of a log axis, from a generator with a seed.
_TICKS = """async (count) => {
  const { isAxis, ticksOf } = await import('/static/js/scales.js');
  let seed = 1;
  const random = () => {
    seed = (seed * 48271) % 2147483647;
    return seed / 2147483647;
  };
  let [axes, most, fewest] = [0, 0, 99];
  const wrong = [];
  for (let k = 0; k < count; k += 1) {
    const low = (1 + 9 * random()) * 10 ** Math.floor(-290 + 560 * random());
    const isLog = k % 2 === 0;
    const high = isLog ? low * 10 ** (12 * random()) : low + low * 10 ** (6 - 18 * random());
    if (!isAxis([low, high], isLog)) continue;
    const ticks = ticksOf(low, high, isLog);
    axes += 1;
    most = Math.max(most, ticks.length);
    if (high / low > 1 + 1e-9) fewest = Math.min(fewest, ticks.length);
    const room = 1e-8 * (high - low) + 1e-8 * (isLog ? high : 0) + 2e-15 * high;
    const isRight = ticks.every((tick, i) => tick >= low * (1 - 1e-8) - room && tick <= high + room && (i === 0 || tick >= ticks[i - 1]));
    if (!isRight) wrong.push([low, high, ticks]);
  }
  return { axes, most, fewest, wrong: wrong.slice(0, 3) };
}"""

# A plot of its own, whose lower end goes over mantissas of 1 to 10 in many decades.
_DRAWN = """async (count) => {
  const { Plot } = await import('/static/js/plots.js');
  const plot = new Plot({ title: 'A', x: 'x', y: 'y', kind: 'line', logY: true });
  plot.root.style.width = '400px';
  document.querySelector('.percuss main').append(plot.root);
  await new Promise((resolve) => setTimeout(resolve, 100));
  const began = performance.now();
  let n = 0;
  for (; n < count && performance.now() - began < 20000; n += 1) {
    const low = (9.4 + 0.6 * (n / count)) * 10 ** (-12 + (n % 11));
    plot.show([{ x: [0, 1], y: [low, 1e3 * low], colour: '--curve' }], [], { x: [0, 1], y: [low, 1e7 * low] });
  }
  const says = plot.empty.hidden ? '' : plot.empty.textContent;
  plot.close();
  plot.root.remove();
  return { n, says };
}"""


@pytest.mark.parametrize("count", [4_000, pytest.param(100_000, marks=pytest.mark.nightly)])
def test_ticks_end_for_all_ends_of_axes(page: Page, count: int) -> None:
    found = page.evaluate(_TICKS, count)

    assert found["wrong"] == []
    assert found["axes"] > 0.9 * count
    # Enough to read a value by, and never too many to draw.
    assert 1 < found["fewest"] < found["most"] <= 26


def test_a_log_axis_is_drawn_for_every_mantissa_of_its_lower_end(page: Page) -> None:
    assert page.evaluate(_DRAWN, 200) == {"n": 200, "says": ""}


def test_what_is_no_log_axis_gets_no_ticks(page: Page) -> None:
    none = [[0, 1], [1, 1], [2, 1], [-1, 1], [1e-320, 1], [1, float("inf")], [float("nan"), 1]]
    code = """async (all) => {
      const { isAxis, ticksOf } = await import('/static/js/scales.js');
      return all.map(([low, high]) => [isAxis([low, high], true), ticksOf(low, high, true).length]);
    }"""

    assert page.evaluate(code, none) == [[False, 0]] * len(none)


def test_a_slider_dragged_over_its_whole_range_leaves_the_page_alive(page: Page) -> None:
    slider = slider_of(page, "oscillator.stops.0.restitution")
    slider.focus()
    code = """async (slider) => {
      const view = document.querySelector('.explore');
      slider.dispatchEvent(new PointerEvent('pointerdown', { bubbles: true }));
      let n = 0;
      for (let value = 800; value >= 0; value -= 16) {
        const seen = new Promise((resolve) => view.addEventListener('drawn', resolve, { once: true }));
        slider.value = String(value);
        slider.dispatchEvent(new Event('input', { bubbles: true }));
        await seen;
        n += 1;
      }
      dispatchEvent(new PointerEvent('pointerup'));
      return n;
    }"""

    assert slider.evaluate(code) == 51


def test_a_motion_that_grows_beyond_all_bounds_leaves_axes_finite(page: Page) -> None:
    before = drawn(page)
    set_box(page, "oscillator.stiffness", "-1")
    wait_for_drawing(page, before)

    for k in range(4):
        shown = limits(page, k)
        assert all(end is not None for ends in shown.values() for end in ends), (k, shown)
    assert limits(page, 5)["y"][0] > 0


def test_a_plot_that_fails_says_so_and_leaves_the_others(tab: Page, address: str) -> None:
    tab.goto("about:blank")
    tab.goto(f"http://{address}/")
    tab.wait_for_selector(".explore[data-drawn]")
    # The impacts are squares: now none can be drawn.
    tab.evaluate(
        "() => { CanvasRenderingContext2D.prototype.fillRect = () => { throw new Error('no ink'); }; }"
    )
    before = [drawn(tab), *(str(limits(tab, k)) for k in (0, 1, 3))]
    set_box(tab, "forcing.harmonics.0.amplitude", "2")
    wait_for_drawing(tab, before[0])
    impacts = tab.locator(".explore .plot:has(.canvas)").nth(2)

    expect(impacts.locator(".empty")).to_contain_text("cannot be drawn: no ink")
    for k, was in zip((0, 1, 3), before[1:], strict=True):
        assert tab.locator(".explore .plot:has(.canvas)").nth(k).locator(".empty").is_hidden()
        assert str(limits(tab, k)) != was


def test_a_view_that_fails_in_one_plot_still_tells_what_it_knows(tab: Page, address: str) -> None:
    tab.goto("about:blank")
    tab.goto(f"http://{address}/")
    tab.wait_for_selector(".explore[data-drawn]")
    # A curve cannot be drawn, in any of the plots.
    tab.evaluate(
        "() => { CanvasRenderingContext2D.prototype.lineTo = () => { throw new Error('no line'); }; }"
    )
    before = drawn(tab)
    set_box(tab, "forcing.harmonics.0.omega", "2.9")
    wait_for_drawing(tab, before)
    facts = tab.locator(".facts .card").all_inner_texts()

    assert any("impact" in text for text in facts)
