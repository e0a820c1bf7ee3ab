"""What a notebook shows of pictures and results."""

from __future__ import annotations

import numpy as np
from tests.notebooks import executed

import percuss as pc
from percuss.motion.html_table import html_table

CELLS = [
    "%matplotlib inline",
    "import percuss as pc\nrun = pc.simulate(pc.impact_oscillator(), v0=1, t_end=9)",
    "from percuss import plotting\nplotting.plot_motion(run)",
    "figure = plotting.plot_motion(run)",
    "figure",
    "plotting.plot_displacement(run)",
    "run.impacts",
]


def test_a_picture_is_shown_once_and_a_table_as_one() -> None:
    cells = executed(CELLS)
    shown = [
        sum("image/png" in output.get("data", {}) for output in cell.outputs) for cell in cells
    ]

    assert shown == [0, 0, 1, 1, 1, 1, 0]
    (table,) = cells[-1].outputs
    assert table["data"]["text/html"].startswith("<table><caption>Impacts: 2, t = ")


def test_every_cell_shows_its_picture_without_a_magic_line() -> None:
    cells = executed(
        [CELLS[1], "from percuss import plotting", *["plotting.plot_displacement(run);"] * 3]
    )
    shown = [
        sum("image/png" in output.get("data", {}) for output in cell.outputs) for cell in cells
    ]

    assert shown == [0, 0, 1, 1, 1]


def test_a_long_table_shows_its_first_and_last_rows() -> None:
    text = html_table("many", {"n": np.arange(1000), "x": np.linspace(0.0, 1.0, 1000)})

    assert text.count("<tr>") == 12
    assert "&#8942;" in text
    assert "<th>994</th>" not in text
    assert "<th>995</th><td>995</td><td>0.995996</td>" in text


def test_orbits_and_branches_are_tables_too() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.5))
    branch = pc.continue_orbit(orbit, over={"forcing.omega": (2.5, 2.8)}, max_points=5)

    assert "<caption>PeriodicOrbit: 1 impact in 1 forcing period" in orbit._repr_html_()
    assert "forcing.omega" in branch._repr_html_()
    assert pc.simulate(pc.Oscillator(), t_end=1).impacts._repr_html_().count("<tr>") == 1
