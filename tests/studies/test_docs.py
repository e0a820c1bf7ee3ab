"""What the pages on studies and on COCO's example show is what comes out."""

from __future__ import annotations

import doctest
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from percuss.studies.reading import known_keys, parse_study
from percuss.studies.structure_tables import STRUCTURE
from percuss.studies.study import kind_named, kind_names
from percuss.studies.templates import template_text

DOCS = Path(__file__).parents[2] / "docs"
# Keys of which a template says enough by its others, and pictures of what has none.
RARE = {
    ("basins", "cycle"),
    ("basins", "v"),
    ("sweep", "max_impacts"),
    *(("draw", key) for key in ("png", "svg", "length_unit", "time_unit")),
}


@pytest.mark.parametrize("name", ["coco-example.md", "studies.md"])
def test_the_code_of_a_page_gives_what_it_shows(name: str) -> None:
    found = doctest.testfile(str(DOCS / name), module_relative=False)

    assert found.attempted > 5
    assert found.failed == 0


def keys_of(kind: str) -> Iterator[tuple[str, str]]:
    """Give table and key of everything that files of a kind hold besides the model."""
    for table, keys in known_keys(kind_named(kind)).items():
        yield from ((table, key) for key in keys)


@pytest.mark.parametrize("kind", kind_names())
def test_every_table_and_key_of_a_kind_stands_on_the_page(kind: str) -> None:
    page = (DOCS / "studies.md").read_text(encoding="utf-8")

    assert f'`"{kind}"`' in page
    for table, key in keys_of(kind):
        part = page[page.index(f"\n| `[{table}]`") + 1 :]
        assert f"`{key}`" in part.split("\n\n")[0], (table, key)


def test_every_example_stands_on_the_page() -> None:
    page = (DOCS / "studies.md").read_text(encoding="utf-8")
    names = [study.stem for study in (DOCS.parent / "examples").glob("*.toml")]

    assert len(names) > 9
    assert [name for name in names if f"`{name}`" not in page] == []


@pytest.mark.parametrize("kind", kind_names())
def test_every_key_stands_in_the_template_of_its_kind(kind: str) -> None:
    text = template_text("impact" if kind == "motion" else kind)

    missing = {
        (table, key)
        for table, key in keys_of(kind)
        if f"{key} =" not in text and f"[{table}.{key}]" not in text
    }

    assert missing <= RARE


def test_the_studies_of_the_page_on_finite_elements_are_those_of_its_python(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = (DOCS / "howto" / "finite-elements.md").read_text(encoding="utf-8")
    code = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    response, diagram, forces, modes = re.findall(r"```toml\n(.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    reported: dict[str, Any] = {}
    exec(code[0] + code[1].split("orbit =")[0], reported)  # noqa: S102  our own text
    model = response[response.index("[structure]") : response.index("[over]")]
    from_modes = modes + model[model.index("units") :].replace("units =", "[structure.units]\n#", 1)

    studies = {
        name: parse_study(text, folder=tmp_path)
        for name, text in {
            "branch": response,
            "diagram": diagram + model,
            "motion": forces + model.replace('"44.5"', "42"),
            "modes": forces.replace("[0, 0, 0, 0]", "[0, 0]") + from_modes,
        }.items()
    }

    assert [studies[name].kind for name in studies] == ["branch", "diagram", "motion", "motion"]
    beam = reported["beam"]
    for name in ("branch", "diagram", "motion"):
        assert studies[name].model.mass == beam.mass
        assert studies[name].model.stops == beam.stops
    # The numbers of the modes are rounded to three or four digits.
    squares = np.linalg.eigvals(np.linalg.solve(reported["M"], reported["K"])).real
    reduced = studies["modes"].structure
    assert reduced is not None
    np.testing.assert_allclose(
        np.sqrt(np.diag(np.array(reduced.stiffness, dtype=float))),
        np.sqrt(np.sort(squares))[:2],
        rtol=1e-3,
    )


def test_the_studies_of_the_reference_can_be_read_and_each_key_of_structures_is_told() -> None:
    page = (DOCS / "studies.md").read_text(encoding="utf-8")
    texts = [
        text for text in re.findall(r"```toml\n(.*?)```", page, re.DOTALL) if "[study]" in text
    ]

    assert [parse_study(text).kind for text in texts] == ["orbit", "basins", "design", "fit"]
    part = page[page.index("## The model: a structure") :].split("\n## ")[0]
    shapes = [STRUCTURE.own, *STRUCTURE.inner.values()]
    names = {name for shape in shapes for name in shape.model_fields} - {"stops"}
    assert [
        name for name in sorted(names) if f"`{name}`" not in part and f"{name} =" not in part
    ] == []
