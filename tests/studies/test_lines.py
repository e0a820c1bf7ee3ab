"""Every key of a TOML text is found on its line."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from percuss.io.study_text import toml_text
from percuss.studies.tables import Path, line_of
from percuss.studies.toml_lines import key_lines

EVERYTHING = '''\
title = "a # b [c]" # a comment = 1
long = """
[not.a.table]
key = 2 \\""" still
"""
'single quoted' = 'C:\\'
raw = \'\'\'
x = 1\'\'\'

[one.two]
dotted . "key" = 1.5
when = 1979-05-27T07:32:00Z
numbers = [ 1,
  2, # two
  [3, 4],
]
inline = { a = 1, b = { c = [ {d = 2},
  {d = 3} ] } }

[[list.of]]
x = 1
[[list.of]]
x = 2
[list.of.inner]
y = 3
[[list.of.deep]]
z = 4
[[list.of.deep]]
z = 5
'''


def leaves(value: Any, path: Path = ()) -> Iterator[Path]:
    """Give the path of everything inside a document."""
    if path:
        yield path
    items = dict(enumerate(value)) if isinstance(value, list) else value
    for key, item in items.items() if isinstance(items, dict) else ():
        yield from leaves(item, (*path, key))


@pytest.mark.parametrize(
    ("path", "line"),
    [
        (("long",), 2),
        (("single quoted",), 6),
        (("raw",), 7),
        (("one", "two"), 10),
        (("one", "two", "dotted", "key"), 11),
        (("one", "two", "when"), 12),
        (("one", "two", "numbers", 1), 14),
        (("one", "two", "numbers", 2, 1), 15),
        (("one", "two", "inline", "b", "c", 0, "d"), 17),
        (("one", "two", "inline", "b", "c", 1, "d"), 18),
        (("list", "of", 0, "x"), 21),
        (("list", "of", 1), 22),
        (("list", "of", 1, "inner", "y"), 25),
        (("list", "of", 1, "deep", 1, "z"), 29),
    ],
)
def test_a_key_is_found_on_its_line_whatever_stands_around_it(path: Path, line: int) -> None:
    assert line_of(key_lines(EVERYTHING), path) == line


def test_every_key_that_tomllib_knows_has_a_line_of_its_own() -> None:
    lines = key_lines(EVERYTHING)

    # "list" and "one" are made by the headers of the tables inside them.
    unknown = set(leaves(tomllib.loads(EVERYTHING))) - set(lines)
    assert unknown == {("list",), ("one",)}


def test_an_unknown_key_has_the_line_of_the_table_around_it() -> None:
    assert line_of(key_lines("[a]\n\n[[a.b]]\nx = 1"), ("a", "b", 0, "missing")) == 3
    assert line_of({}, ("a",)) is None


@given(text=st.text(alphabet="[]{}=,.\"'#\n an\\", max_size=60))
def test_the_scanner_ends_on_any_text_and_knows_the_keys_of_valid_ones(text: str) -> None:
    lines = key_lines(text)

    try:
        document = tomllib.loads(text)
    except ValueError:
        return
    assert {path[0] for path in lines} >= set(document)


texts = st.text(max_size=20).filter(lambda text: text.isprintable() or "\n" in text)
scalars = st.one_of(
    st.booleans(), st.integers(), st.floats(allow_nan=False, allow_infinity=False), texts
)
names = st.from_regex(r"[a-z_0-9-]{1,8}", fullmatch=True)
tables = st.dictionaries(names, scalars | st.lists(scalars, max_size=3), max_size=4)


@given(document=st.dictionaries(names, tables, max_size=4))
def test_what_is_written_is_read_back_equal(document: dict[str, dict[str, Any]]) -> None:
    assert tomllib.loads(toml_text(document)) == document
