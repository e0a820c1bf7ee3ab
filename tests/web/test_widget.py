"""The workbench in a notebook, and its scripts as one."""

from __future__ import annotations

import asyncio
import json
import re
from collections.abc import Iterator
from typing import Any

import pytest
from playwright.sync_api import Browser, Page
from tests.loops import run
from tests.notebooks import executed

import percuss as pc
from percuss.errors import ParameterError
from percuss.web.presets import presets
from percuss.web.widget import explore, modules_in_order

CELL = """
import asyncio, json
import percuss as pc
widget = pc.explore(pc.impact_oscillator("0.8"), pc.cosine("2.8"), v0="0.5")
sent = []
widget.send = lambda content, buffers=None: sent.append((content, buffers))
request = {"id": 4, "kind": "explore", "study": widget.study}
widget.cells.take(widget, {"kind": "request", "view": "a", "text": json.dumps(request)}, [])
for _ in range(600):
    await asyncio.sleep(0.1)
    if sent:
        break
widget.cells.take(widget, {"kind": "file", "id": "a", "extension": "py", "request": {**request, "kind": "motion"}}, [])
data = sent[0][1][0]
header = json.loads(data[4 : 4 + int.from_bytes(data[:4], "little")])
print(header["id"], header["n_impacts"], sent[1][0]["name"])
"""


def test_widget_answers_in_a_notebook() -> None:
    (cell,) = executed([CELL])
    text = cell.outputs[-1]["text"]

    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.8")
    found = pc.simulate(osc, force, v0="0.5", periods=60)
    assert text.split() == ["4", str(len(found.impacts)), "motion.py"]


def test_widget_holds_the_motion_that_it_is_given() -> None:
    widget = explore(pc.impact_oscillator("0.8", wall="0.2", side="above"), pc.sine(3), x0="0.1")

    assert widget.study["oscillator"]["stops"][0]["restitution"] == "0.8"
    assert widget.study["start"]["x0"] == "0.1"
    assert widget.study["run"] == {"periods": 60}
    assert explore().study == presets()[0].tables


def test_free_motion_has_no_workbench() -> None:
    with pytest.raises(ParameterError, match="forcing periods"):
        explore(pc.impact_oscillator())


def test_each_module_comes_after_those_that_it_imports() -> None:
    known: set[str] = set()
    for name, text in modules_in_order():
        assert set(re.findall(r'from "percuss:([^"]+)"', text)) <= known, name
        assert 'from ".' not in text
        known.add(name)
    assert "vendor/uPlot.esm.js" in known


# What a notebook gives the script, less the notebook: two widgets, each in a cell of its own.
HOST = """async ([script, modules, facts, studies]) => {
  const address = URL.createObjectURL(new Blob([script], { type: 'text/javascript' }));
  const { default: widget } = await import(address);
  const cells = [];
  for (const study of studies) {
    const values = { modules, facts, study };
    const cell = { sent: [], heard: 0, listeners: {}, el: document.createElement('div'), values };
    document.body.append(cell.el);
    const model = {
      get: (name) => values[name],
      set: (name, value) => { values[name] = value; },
      save_changes: () => {},
      send: (message) => cell.sent.push(message),
      on: (name, listener) => { cell.heard += 1; cell.listeners[name] = listener; },
      off: () => { cell.heard -= 1; },
    };
    cell.end = await widget.render({ model, el: cell.el });
    cells.push(cell);
  }
  window.cells = cells;
  await new Promise((resolve) => setTimeout(resolve, 400));
  return cells.map(({ sent, el }) => ({
    sent,
    tabs: [...el.querySelectorAll('nav button')].map((it) => it.textContent),
    height: el.getBoundingClientRect().height,
  }));
}"""


@pytest.fixture
def cells(browser: Browser) -> Iterator[tuple[Page, list[dict[str, Any]]]]:
    """A page with two widgets, and what is known of each; any error of a script fails the test."""
    widgets = [explore(), explore(pc.impact_oscillator("0.5"), pc.cosine("2.2"), v0="0.25")]
    page = browser.new_page(viewport={"width": 1300, "height": 900})
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.add_style_tag(content=str(widgets[0]._css))
    first = widgets[0]
    found = page.evaluate(
        HOST, [str(first._esm), first.modules, first.facts, [it.study for it in widgets]]
    )
    yield page, found
    page.close()
    assert errors == []


def test_the_front_end_of_the_widget_begins_and_asks(
    cells: tuple[Page, list[dict[str, Any]]],
) -> None:
    for found in cells[1]:
        assert found["tabs"] == [
            "Explore",
            "Diagram",
            "Basins",
            "Fit",
            "Design",
            "Structure",
            "Gallery",
        ]
        assert '"kind":"explore"' in found["sent"][0]["text"]
        # A cell is as high as what is in it, not as the window.
        assert 500 < found["height"] < 1000
    assert cells[1][0]["sent"][0]["view"] != cells[1][1]["sent"][0]["view"]


@pytest.mark.parametrize(("width", "is_wide"), [(860, True), (700, False)])
def test_the_width_of_the_cell_decides_the_layout(
    cells: tuple[Page, list[dict[str, Any]]], width: int, is_wide: bool
) -> None:
    page, _ = cells
    asides = page.evaluate(
        """(width) => [...document.querySelectorAll('.explore')].map((explore) => {
          explore.closest('.percuss').style.width = `${width}px`;
          const [aside, plot] = ['aside', '.plot'].map((it) => explore.querySelector(it).getBoundingClientRect());
          return plot.left >= aside.right && explore.scrollWidth <= width;
        })""",
        width,
    )

    assert asides == [is_wide, is_wide]


def test_two_widgets_on_a_page_do_not_disturb_each_other(
    cells: tuple[Page, list[dict[str, Any]]],
) -> None:
    page, _ = cells
    ids = page.evaluate("[...document.querySelectorAll('[id]')].map((it) => it.id)")
    assert len(ids) > 40
    assert len(set(ids)) == len(ids)

    boxes = page.locator("[data-path='start.v0']")
    boxes.nth(1).fill("0.75")
    studies = page.evaluate("cells.map(({ values }) => values.study.start.v0)")
    assert studies == ["0.5", "0.75"]
    assert boxes.nth(0).input_value() == "0.5"


def test_a_cell_says_that_its_kernel_has_ended(cells: tuple[Page, list[dict[str, Any]]]) -> None:
    page, _ = cells
    # As the notebook tells it when a kernel is restarted.
    page.evaluate("cells[0].listeners.comm_live_update()")
    told = page.locator(".banner")
    assert told.nth(0).inner_text() == "The kernel has ended: run the cell again."
    assert not told.nth(1).is_visible()


def test_a_cell_that_is_cleared_leaves_nothing(cells: tuple[Page, list[dict[str, Any]]]) -> None:
    page, _ = cells
    left = page.evaluate(
        """() => {
          const [cell, other] = cells;
          cell.end();
          return [cell.heard, cell.sent.at(-1).kind, cell.el.querySelectorAll('canvas').length,
                  other.el.querySelectorAll('.explore canvas').length];
        }"""
    )

    assert left == [0, "close", 0, 6]


def test_views_of_a_widget_are_answered_each_and_end_with_it() -> None:
    widget = explore()
    sent: list[dict[str, Any]] = []
    widget.send = lambda content, buffers=None: sent.append(content)  # noqa: ARG005
    request = json.dumps({"id": 1, "kind": "explore", "study": widget.study})

    async def talk() -> None:
        for view in ("a", "b"):
            widget.cells.take(widget, {"kind": "request", "view": view, "text": request}, [])
        while len(sent) < 2:
            await asyncio.sleep(0.01)
        widget.cells.take(widget, {"kind": "close", "view": "a"}, [])
        assert set(widget.cells.sessions) == {"b"}
        widget.close()
        assert widget.cells.sessions == {}

    run(talk())
    assert {content["view"] for content in sent} == {"a", "b"}


def test_a_file_that_cannot_be_made_says_why() -> None:
    widget = explore()
    sent: list[dict[str, Any]] = []
    widget.send = lambda content, buffers=None: sent.append(content)  # noqa: ARG005
    for request in (None, {"kind": "no such"}, {"kind": "motion", "study": {}}):
        message = {"kind": "file", "id": "a", "extension": "py", "request": request}
        widget.cells.take(widget, message, [])

    assert len(sent) == 3
    assert all(len(content["fault"]) > 10 for content in sent)
