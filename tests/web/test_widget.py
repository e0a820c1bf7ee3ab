"""The workbench in a notebook, and its scripts as one."""

from __future__ import annotations

import re

import nbformat
import pytest
from nbclient import NotebookClient
from playwright.sync_api import Browser
from tests.web.loops import run

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
question = {"id": 4, "kind": "explore", "study": widget.study}
widget._take(widget, {"kind": "ask", "text": json.dumps(question)}, [])
for _ in range(600):
    await asyncio.sleep(0.1)
    if sent:
        break
widget._take(widget, {"kind": "file", "id": "a", "extension": "py", "study": widget.study}, [])
data = sent[0][1][0]
header = json.loads(data[4 : 4 + int.from_bytes(data[:4], "little")])
print(header["id"], header["n_impacts"], sent[1][0]["name"])
"""


def test_widget_answers_in_a_notebook() -> None:
    cell = nbformat.v4.new_code_cell(CELL)  # type: ignore[no-untyped-call]
    notebook = nbformat.v4.new_notebook(cells=[cell])  # type: ignore[no-untyped-call]

    async def executed() -> None:
        await NotebookClient(notebook, timeout=100).async_execute()

    run(executed())
    text = notebook.cells[0].outputs[-1]["text"]

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


# What a notebook gives the script, less the notebook.
HOST = """async ([script, modules, facts, study]) => {
  const address = URL.createObjectURL(new Blob([script], { type: 'text/javascript' }));
  const { default: widget } = await import(address);
  const values = { modules, facts, study };
  const asked = [];
  const model = {
    get: (name) => values[name],
    set: (name, value) => { values[name] = value; },
    save_changes: () => {},
    send: (message) => asked.push(message),
    on: () => {},
    off: () => {},
  };
  await widget.render({ model, el: document.body });
  await new Promise((resolve) => setTimeout(resolve, 400));
  return { asked, tabs: [...document.querySelectorAll('nav button')].map((it) => it.textContent) };
}"""


def test_the_front_end_of_the_widget_begins_and_asks(browser: Browser) -> None:
    widget = explore()
    page = browser.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    given = [str(widget._esm), widget.modules, widget.facts, widget.study]
    found = page.evaluate(HOST, given)
    page.close()

    assert errors == []
    assert found["tabs"] == ["Explore", "Diagram", "Basins", "Gallery"]
    assert '"kind":"explore"' in found["asked"][0]["text"]
