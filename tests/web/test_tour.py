"""The tour of the page: five steps, each in the link, and what its texts say."""

from __future__ import annotations

import numpy as np
from playwright.sync_api import Page, expect
from tests.web.hands import link_of

import percuss as pc


def test_the_tour_goes_through_its_steps(page: Page) -> None:
    page.get_by_role("button", name="Tour", exact=True).click()
    tour = page.locator(".tour")
    facts = page.locator(".explore .facts")
    expect(tour).to_contain_text("1 of 5")
    expect(facts).to_contain_text("(1, 1) stable")
    tour.get_by_role("button", name="Next").click()
    expect(facts).to_contain_text("2 impacts in 2 forcing periods")
    tour.get_by_role("button", name="Next").click()
    expect(page.locator("section[aria-label=Diagram] .status")).to_contain_text("done")
    link = link_of(page)
    tour.get_by_role("button", name="Next").click()
    expect(tour).to_contain_text("4 of 5")
    tour.get_by_role("button", name="Next").click()
    expect(facts).to_contain_text("chatter and contact in 1 forcing period")
    tour.get_by_role("button", name="Done").click()
    expect(tour).to_be_hidden()
    page.goto("about:blank")
    page.goto(link)
    expect(tour).to_contain_text("3 of 5")
    tour.get_by_role("button", name="End").click()
    expect(tour).to_be_hidden()


def test_the_tour_is_taken_by_the_keyboard_alone(page: Page) -> None:
    begin = page.get_by_role("button", name="Tour", exact=True)
    begin.focus()
    page.keyboard.press("Enter")
    tour = page.locator(".tour")
    for step in range(1, 5):
        expect(tour).to_contain_text(f"{step} of 5")
        expect(tour.get_by_role("button", name="Next")).to_be_focused()
        page.keyboard.press("Enter")
    expect(tour.get_by_role("button", name="Done")).to_be_focused()
    page.keyboard.press("Enter")
    expect(tour).to_be_hidden()
    expect(begin).to_be_focused()


def test_each_step_is_seen_from_its_start(page: Page) -> None:
    page.get_by_role("button", name="Tour", exact=True).click()
    tour = page.locator(".tour")
    expect(tour).to_contain_text("The card of the nearest periodic orbit says (1, 1), stable.")
    readout = page.locator(".explore .drawing .readout")
    expect(readout).to_have_text("t = 2.37")
    page.locator(".explore").get_by_label("time of the picture").press("End")
    expect(readout).not_to_have_text("t = 2.37")
    # A slider moves the motion, not the time of its picture.
    slider = page.locator(".row", has=page.locator("#p-forcing-harmonics-0-omega"))
    slider.locator("input[type=range]").press("ArrowRight")
    expect(readout).not_to_have_text("t = 2.37")
    page.locator("[data-view=gallery]").click()
    page.locator("[data-name=chatter]").click()
    expect(readout).to_have_text("t = 0")


def test_what_the_tour_says_is_so() -> None:
    osc = pc.impact_oscillator("0.8")
    orbit = pc.find_orbit(osc, pc.cosine("2.6"))
    cascade = pc.follow_cascade(orbit, over={"forcing.omega": (2.6, 2.75)})
    assert round(float(cascade.values[0]), 4) == 2.6533
    assert round(float(cascade.values[1]), 3) == 2.716
    assert 2.7315 < cascade.values[-1] < 2.7325
    assert abs(cascade.ratios[-1] - 4.67) < 0.2
    # The starts of the steps lead to that family.
    for omega, impacts in (("2.6", 1), ("2.68", 2), ("2.72", 4)):
        run = pc.simulate(osc, pc.cosine(omega), v0="0.4", t0="2.37", periods=400)
        last = run.impacts.v_before[-8:]
        np.testing.assert_allclose(last[impacts:], last[:-impacts], atol=1e-6)
    graze = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    speeds = [
        run.impacts.v_before[-1] if len(run.impacts) and run.impacts.t[-1] > 1200 else 0.0
        for run in (
            pc.simulate(graze, pc.cosine(1, a), periods=200) for a in ("0.102", "0.1001", "0.0999")
        )
    ]
    assert speeds[0] > 2 * speeds[1] > speeds[2] == 0.0
