"""What the pages on studies and on COCO's example show is what comes out."""

from __future__ import annotations

import doctest
from collections.abc import Iterator
from pathlib import Path

import pytest

from percuss.studies.reading import known_keys
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
