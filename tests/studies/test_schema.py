"""The JSON schema of studies takes what percuss takes, and marks what an editor should mark."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from percuss.studies import kind_names, study_schema, template_names, template_text

jsonschema = pytest.importorskip("jsonschema", reason="comes with nbclient")

ROOT = Path(__file__).parents[2]
EXAMPLES = sorted((ROOT / "examples").glob("*.toml"))


@pytest.fixture(scope="module")
def faults() -> Callable[[str], list[str]]:
    schema = study_schema()
    jsonschema.Draft7Validator.check_schema(schema)
    validator = jsonschema.Draft7Validator(schema)

    def of(text: str) -> list[str]:
        return [error.message for error in validator.iter_errors(tomllib.loads(text))]

    return of


def test_templates_and_examples_have_no_faults(faults: Callable[[str], list[str]]) -> None:
    texts = {name: template_text(name) for name in template_names()}
    texts |= {file.name: file.read_text(encoding="utf-8") for file in EXAMPLES}

    assert {name: faults(text) for name, text in texts.items() if faults(text)} == {}


# A line of a template, and what stands in its place.
WRONG = [
    ("sweep", "transient = 200", "transeint = 200"),
    ("sweep", "transient = 200", "transient = true"),
    ("sweep", "count = 101", "cuont = 101"),
    ("impact", 'side = "below"', 'side = "left"'),
    ("impact", "\n[oscillator]\n", "\n[oscilator]\n"),
    ("diagram", 'kind = "diagram"', 'kind = "diagrm"'),
    ("basins", "[basins]", "[basin]"),
    ("structure", "[structure]", "[structrue]"),
    ("sweep", "[save]", "[orbit]\nimpacts = 1\n[save]"),
]


@pytest.mark.parametrize(("template", "right", "wrong"), WRONG)
def test_a_mistake_is_marked(
    template: str, right: str, wrong: str, faults: Callable[[str], list[str]]
) -> None:
    text = template_text(template)
    assert right in text

    assert faults(text.replace(right, wrong, 1))


def test_keys_are_explained(faults: Callable[[str], list[str]]) -> None:  # noqa: ARG001
    schema = study_schema()
    by_kind: dict[str, Any] = dict(zip(kind_names(), schema["allOf"], strict=True))
    basins = by_kind["basins"]["then"]["else"]["properties"]["basins"]

    assert schema["properties"]["study"]["properties"]["kind"]["enum"] == kind_names()
    assert (
        basins["description"]
        == "The attractor of each start of a grid, as percuss.basins finds it."
    )
    assert set(basins["properties"]) == {
        "x0", "v0", "cycle", "v", "stop", "t0", "periods", "escape", "measures",
    }  # fmt: skip
    assert basins["properties"]["periods"]["default"] == 1000
    draw = by_kind["motion"]["then"]["else"]["properties"]["draw"]["properties"]
    assert re.match("Whether to write the picture", draw["png"]["description"])
