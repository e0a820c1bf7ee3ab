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


def test_what_a_trillion_impacts_need_follows_from_the_rates() -> None:
    text = (DOCS / "cluster.md").read_text(encoding="utf-8")
    impact, fast = 0.30e-6, 0.55e-6
    law = 0.13e-3

    hours = 1e12 * impact / 3600
    assert f"**{hours:.0f} core hours**" in text
    assert f"soft stop {1e12 * fast / 3600:.0f}" in text
    assert f"which is {1e9 * law / 3600:.0f} core hours more" in text
    assert f"the laws are {1e7 * law / 3600:.1f}" in text
    assert f"{1e12 * impact / 640 / 60:.0f} minutes for the impacts" in text
    assert f"{(1e12 * impact + 1e9 * law) / 640 / 60:.0f} with 1e9 laws" in text
    chunks = 1e9 / 32_768
    assert f"in {round(chunks, -3):,.0f} chunks" in text
    assert f"and {hours + 1e9 * law / 3600:.0f} with the laws" in text
