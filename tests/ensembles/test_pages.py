"""What the pages on many motions and on clusters show and reckon."""

from __future__ import annotations

import ast
import inspect
import re
from pathlib import Path

import pytest

import percuss as pc

DOCS = Path(__file__).parents[2] / "docs"
PAGES = ["ensembles.md", "cluster.md"]
CALLS = ("sweep", "bifurcation_diagram", "basins", "basin_fractions", "lyapunov_exponents")


def blocks(page: str) -> list[str]:
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(r"```python\n(.*?)```", text, flags=re.DOTALL)


@pytest.mark.parametrize("page", PAGES)
def test_code_is_python_and_calls_have_the_arguments_they_are_given(page: str) -> None:
    found = 0
    for block in blocks(page):
        for node in ast.walk(ast.parse(block)):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute):
                if node.func.attr not in CALLS:
                    continue
                taken = inspect.signature(getattr(pc, node.func.attr)).parameters
                assert {keyword.arg for keyword in node.keywords} <= set(taken)
                found += 1

    assert found >= 1


@pytest.mark.parametrize("page", PAGES)
def test_pictures_scripts_and_pages_that_are_named_are_there(page: str) -> None:
    text = (DOCS / page).read_text(encoding="utf-8")

    linked = re.findall(r"\]\(([^)#]+)\)", text)
    scripts = re.findall(r"python (examples/\w+\.py)", text)
    assert linked
    assert [name for name in linked if not (DOCS / name).exists()] == []
    assert [name for name in scripts if not (DOCS.parent / name).exists()] == []


def rate(text: str, what: str, unit: str) -> float:
    """Return the seconds that the page's table gives."""
    found = re.search(rf"^\| {re.escape(what)} \| ([0-9.]+) {unit} \|", text, re.MULTILINE)
    assert found is not None, what
    return float(found[1]) * {"us": 1e-6, "ms": 1e-3}[unit]


def test_what_a_trillion_impacts_need_follows_from_the_rates() -> None:
    text = (DOCS / "cluster.md").read_text(encoding="utf-8")
    impact, exponent, both = (
        rate(text, f"an impact, {name}", "us")
        for name in ("`period`", "`largest_lyapunov_exponent`", "both")
    )
    law = rate(text, "a new law, for each combination of parameters", "ms")

    hours, of_laws = 1e12 * impact / 3600, 1e9 * law / 3600
    assert f"are {1e12 * impact:.1e} s, **{hours:.0f} core hours**".replace("e+0", "e") in text
    assert f"largest exponent {1e12 * exponent / 3600:.0f}, " in text
    assert f"list of both {1e12 * both / 3600:.0f}." in text
    assert f"which is {of_laws:.0f} core hours more" in text
    assert f"the laws are {of_laws / 100:.1f}" in text
    assert f"{1e12 * impact / 640 / 60:.0f} minutes for the impacts" in text
    assert f"{(1e12 * impact + 1e9 * law) / 640 / 60:.0f} with 1e9 laws" in text
    chunk, own = 32_768 * 1000 * impact, 32_768 * law
    assert f"take {chunk:.0f} s of a core and {own:.0f} s for their laws" in text
    assert f"finish {640 / (chunk + own):.0f} chunks a second" in text
    assert f"up to {round(500 * (chunk + own), -3):,.0f} cores" in text
    assert f"in {round(1e9 / 32_768, -3):,.0f} chunks" in text
    dollars = [0.05 * time for time in (hours, 2 * hours, hours + of_laws, 2 * (hours + of_laws))]
    assert "{:.0f} to {:.0f} dollars, ".format(*dollars[:2]) in text
    assert f"and {hours + of_laws:.0f} with the laws" in text
    assert "laws {:.0f} to {:.0f};".format(*dollars[2:]) in text


def test_a_list_with_an_exponent_follows_each_motion_once_more() -> None:
    def impacts(*names: str) -> int:
        data = pc.sweep(
            names, pc.impact_oscillator(restitution=0.8), pc.cosine(2.5),
            over={"start.v0": [1.0]}, transient=10, periods=64,
        )  # fmt: skip
        return int(data.attrs["n_impacts"])

    once = impacts("period")
    assert impacts("period", "peak_displacement", "dissipated_energy") == once
    assert impacts("period", "largest_lyapunov_exponent") == 2 * once
