"""Links to the workbench that percuss writes: of a study, and of the records of the report."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Error, Page, expect
from tests.web.hands import WAIT
from tests.web.serving import served

from percuss.errors import ParameterError
from percuss.model.exact import pi_times
from percuss.model.harmonic_forces import cosine, sine
from percuss.model.oscillator import (
    Oscillator,
    SoftStop,
    bilinear_oscillator,
    impact_oscillator,
)
from percuss.model.start import Start
from percuss.model.units import Units
from percuss.paper.run import run_paper
from percuss.studies import (
    Basins,
    Design,
    Diagram,
    Fit,
    Limits,
    Lyapunov,
    Motion,
    Response,
    Span,
    Study,
    Sweep,
    parse_study,
)
from percuss.studies.fit_records import FitRecord
from percuss.studies.kinds.orbit import Sought
from percuss.studies.link import MEASURED, link_of
from percuss.web.app import create_app
from percuss.web.facts import PERIODS
from percuss.web.request import PageRequest
from percuss.web.view_study import study_of_view

LOSSY = impact_oscillator("0.8", wall="0.2")
FORCE = cosine("2.8")
STUDIES = {
    "motion": Study(LOSSY, FORCE, Motion(Start("0.5", 0, pi_times(1, 3)), Limits(periods=7))),
    "impacts": Study(impact_oscillator(), sine(1), Motion(Start(0, 1.5), Limits(max_impacts=12))),
    "free": Study(
        bilinear_oscillator(stiffness_below=4e8), None, Motion(Start(0, 1e-3), Limits(t_end=20.0))
    ),
    "diagram": Study(
        LOSSY,
        FORCE,
        Diagram(
            over={"forcing.omega": Span("2.5", "2.9", 16)}, starts=(Start("0.5", 0),), points=8
        ),
    ),
    "diagram at a place": Study(
        LOSSY,
        FORCE,
        Diagram(
            over={"forcing.omega": Span("2.5", "2.9", 16)},
            section={"at": 0.4, "direction": "down"},
            starts=(Start("0.5", 0),),
            points=8,
        ),
    ),
    "diagram of impacts": Study(
        LOSSY,
        FORCE,
        Diagram(
            over={"forcing.omega": Span("2.5", "2.9", 16)},
            section="impacts",
            starts=(Start("0.5", 0),),
            points=8,
        ),
    ),
    "diagram at a cycle": Study(
        LOSSY,
        FORCE,
        Diagram(
            over={"forcing.omega": Span("2.5", "2.9", 16)},
            section={"cycle": 0.25},
            starts=(Start("0.5", 0),),
            points=8,
        ),
    ),
    "response": Study(
        LOSSY, FORCE, Response(over={"forcing.omega": ("2.7", "2.9")}, max_impacts=1)
    ),
    "sweep": Study(
        LOSSY,
        FORCE,
        Sweep(
            measure=("peak_impact_velocity",),
            over={
                "forcing.omega": Span("2.5", "2.8", 16),
                "oscillator.stops.0.restitution": Span("0.6", "0.9", 16),
            },
            start=Start("0.5", 0),
        ),
    ),
    "mass": Study(
        Oscillator.from_mass(
            50, 20, 4, stops=(SoftStop("0.5", "above", 400, 10),), units=Units("m", "s", "t")
        ),
        cosine("0.7854", 40, constant=10),
        Motion(Start(0, 0), Limits(periods=20)),
    ),
    "fit": Study(
        LOSSY,
        FORCE,
        Fit(
            records=(
                FitRecord(
                    {"t": (0.0, 0.5, 1.0), "displacement": (0.5, None, 0.25)},
                    noise=0.01,
                    start=Start("0.5", 0),
                ),
            ),
            free={"oscillator.stops.0.restitution": (0.5, 1.0), "start.v0": 0.25},
        ),
    ),
    "design": Study(
        LOSSY,
        FORCE,
        Design(
            outcome=("max_displacement", "peak_impact_velocity"),
            goal=("largest", "least"),
            free={"forcing.omega": ("2.5", "2.9")},
            subject_to={"contact_share": (None, 2)},
            on="run",
            n=4,
            start=Start("0.5", 0),
            limits=Limits(periods=30),
        ),
    ),
    "basins": Study(LOSSY, FORCE, Basins(x0=Span("0.25", "1.75", 16), v0=Span(-1, 1, 16))),
}
# The button at which the page writes its state into the address anew.
COPY = "Copy link"
# What a view says that has computed all that its link asks for.
DONE = re.compile(r"done in [\d.]+ m?s")


def value_at(page: Page, path: str) -> str:
    return page.locator(f"#p-{path.replace('.', '-')}").input_value()


def written(page: Page) -> str:
    """The fragment that the page writes itself."""
    page.get_by_role("button", name=COPY).click()
    return page.url.split("#", 1)[1]


@pytest.mark.parametrize("name", STUDIES)
def test_a_link_is_what_the_page_writes_itself(tab: Page, address: str, name: str) -> None:
    link = link_of(STUDIES[name])
    errors: list[str] = []

    def hear(error: Error) -> None:
        errors.append(str(error))

    tab.on("pageerror", hear)
    tab.goto("about:blank")
    tab.goto(f"http://{address}/#{link}")
    if name.startswith("diagram") or name in ("response", "basins", "sweep"):
        view = "Basins" if name == "basins" else "Diagram"
        shown = tab.locator(f"section[aria-label={view}]")
        expect(shown).to_be_visible()
        # The picture is whole, and the page has kept it in its state.
        expect(shown).to_contain_text(DONE, timeout=WAIT)
    elif name == "fit":
        expect(tab.locator("section[aria-label=Fit]")).to_contain_text("2 values of displacement")
    elif name == "design":
        expect(tab.locator("section[aria-label=Design] .limits")).to_contain_text("limit of")
    else:
        tab.wait_for_selector(".explore[data-drawn]", timeout=WAIT)

    assert written(tab) == link
    tab.remove_listener("pageerror", hear)
    assert errors == []


def test_the_page_shows_the_limit_of_the_motion(tab: Page, address: str) -> None:
    tab.goto("about:blank")
    tab.goto(f"http://{address}/#{link_of(STUDIES['impacts'])}")
    tab.wait_for_selector(".explore[data-drawn]", timeout=WAIT)

    assert value_at(tab, "run.max_impacts") == "12"
    expect(tab.locator(".explore")).to_contain_text("12 impacts")
    # Not the page has ended it.
    expect(tab.locator(".explore")).not_to_contain_text("the page follows")


def test_the_page_shows_mass_dashpot_and_units(tab: Page, address: str) -> None:
    tab.goto("about:blank")
    tab.goto(f"http://{address}/#{link_of(STUDIES['mass'])}")
    tab.wait_for_selector(".explore[data-drawn]", timeout=WAIT)

    panel = tab.locator("fieldset", has_text="mass m")
    for label in ("mass m (t)", "stiffness k (kN/m)", "damping c (kN s/m)"):
        expect(panel).to_contain_text(label)
    expect(tab.get_by_text("k x = F(t) + stops")).to_be_visible()
    expect(tab.get_by_text("amplitude (kN)", exact=True)).to_be_visible()
    assert value_at(tab, "oscillator.mass") == "50"
    assert value_at(tab, "oscillator.damping_coefficient") == "4"


def test_a_chart_takes_exponents_over_as_many_periods_as_a_motion_on_the_page() -> None:
    assert MEASURED["largest_lyapunov_exponent"] == PERIODS


def test_a_study_that_the_page_does_not_show_is_refused() -> None:
    with pytest.raises(ParameterError, match=r"study\.kind = 'lyapunov': not on the page"):
        link_of(Study(LOSSY, FORCE, Lyapunov()))
    edges = Basins(cycle=Span(0, "0.9", 4), v=Span(0, 1, 4))
    with pytest.raises(ParameterError, match="basins over x0, v0"):
        link_of(Study(LOSSY, FORCE, edges))
    fit = STUDIES["fit"].question
    assert isinstance(fit, Fit)
    (record,) = fit.records
    many = replace(
        record, data={"t": tuple(map(float, range(9000))), "displacement": (0.5,) * 9000}
    )
    each = replace(record, noise={"displacement": 0.1, "velocity": 0.2})
    chart = STUDIES["sweep"].question
    assert isinstance(chart, Sweep)
    omega, restitution = chart.over
    for other, words in (
        (replace(chart, over={omega: chart.over[omega]}), "not on the page, whose charts have"),
        (replace(chart, paired=True), "paired = True: not on the page, whose charts have all"),
        (replace(chart, over={**chart.over, omega: Span(2, 3, 17)}), "with one count"),
        (
            replace(chart, over={path: Span("0.5", "0.9", 300) for path in (omega, restitution)}),
            "over.count = 300: not on the page, whose charts have 16 to 256 cells",
        ),
        (replace(chart, measure=("mean_power",)), "whose charts show one of period"),
        (replace(chart, transient=300), "sweep.transient = 300: not on the page, .* takes 200"),
        (replace(chart, between=(0, 9)), r"sweep.between = \(0, 9\): not on the page"),
        (
            replace(chart, over={"start.x0": Span(0, 1, 16), omega: Span(2, 3, 16)}),
            "over.start.x0 = 'given': not on the page",
        ),
        (replace(fit, records=(record, record)), "the page fits one"),
        (replace(fit, records=(many,)), r"links of the page hold 56 kB, some \d+ of these rows"),
        (replace(fit, records=(each,)), "one for each quantity"),
        (replace(fit, loss="huber"), r"fit\.loss = 'given': not on the page"),
        (Design(outcome=("period",), sought=Sought()), "the orbits that attract"),
    ):
        with pytest.raises(ParameterError, match=words):
            link_of(Study(LOSSY, FORCE, other))


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A report with the record of a motion, and one without."""
    folder = tmp_path_factory.mktemp("report")
    run_paper(folder, only="fig9,eq24-other-root")
    return folder


@pytest.fixture
def shown(browser: Browser, report: Path) -> Iterator[Page]:
    with served(create_app(report=report)) as address:
        opened = browser.new_page(viewport={"width": 1366, "height": 850})
        opened.goto(f"http://{address}/")
        opened.wait_for_selector(".explore[data-drawn]", timeout=WAIT)
        yield opened
        opened.close()


def test_a_record_opens_in_the_workbench_around_the_report(shown: Page, report: Path) -> None:
    study = parse_study((report / "studies" / "fig9.toml").read_text("utf-8"))
    shown.evaluate("globalThis.isSame = true")
    shown.get_by_role("tab", name="Paper").click()
    record = shown.frame_locator("iframe").locator("details#fig9")
    record.locator("> summary").click()
    record.get_by_role("link", name="Open in the workbench").click()

    expect(shown.locator("section[aria-label=Explore]")).to_be_visible()
    assert isinstance(study.oscillator, Oscillator)
    assert isinstance(study.question, Motion)
    assert value_at(shown, "start.v0") == str(study.question.start.v0) == "0.139"
    assert value_at(shown, "forcing.harmonics.0.omega") == "9"
    assert value_at(shown, "oscillator.stops.0.restitution") == "1"
    # The page was not loaded anew, so that the report behind it stands where it was.
    assert shown.evaluate("globalThis.isSame")
    assert written(shown) == link_of(study)
    shown.get_by_role("tab", name="Paper").click()
    expect(record).to_have_attribute("open", "")


def test_on_disk_a_record_tells_the_commands_instead(browser: Browser, report: Path) -> None:
    opened = browser.new_page()
    opened.goto((report / "index.html").as_uri() + "#fig9")
    record = opened.locator("details#fig9")

    expect(record.locator("a.workbench")).to_be_hidden()
    expect(record).to_contain_text("percuss serve studies/fig9.toml")
    command = record.locator(".command").first
    command.click()
    assert opened.evaluate("getSelection().toString()").strip() == "percuss run studies/fig9.toml"
    expect(opened.locator("details#eq24-other-root .command")).to_have_count(0)
    opened.close()


def test_a_diagram_over_a_parameter_keeps_its_range() -> None:
    text = Path("examples/bouncing_ball.toml").read_text(encoding="utf-8")
    state = json.loads(base64.urlsafe_b64decode(link_of(parse_study(text)) + "=="))

    diagram = state["diagram"]
    assert diagram["path"] == "parameters.w"
    assert (diagram["low"], diagram["high"]) == (1.66, 1.79)
    options = {key: value for key, value in diagram.items() if key != "study"}
    study = study_of_view(PageRequest(1, "diagram", state["study"], options))
    assert list(study.question.over) == ["w"]  # type: ignore[attr-defined]
