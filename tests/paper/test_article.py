"""The coverage table: no passage of the article is left out, and each is what the text says."""

from __future__ import annotations

import hashlib
import itertools
import os
import re
from pathlib import Path

import pytest

from percuss.paper.article import article_source, passages, passages_of
from percuss.paper.collection import items, statement_with_id

# Names the text that the article was read from; it is not percuss's to pass on.
TEXT = "PERCUSS_ARTICLE_TEXT"
# Characters between passages: the labels of the axes of figure A1 take 108 of them.
LABELS = 110


def references() -> dict[str, str]:
    """Return where the article has each statement."""
    statements = [statement_with_id(item) for item in items() if item.kind == "statement"]
    return {statement.id: statement.reference for statement in statements}


@pytest.fixture(scope="module")
def text() -> str:
    if TEXT not in os.environ:
        pytest.skip(f"{TEXT} names no text of the article")
    return Path(os.environ[TEXT]).read_text(encoding="utf-8")


def test_each_passage_is_examined_or_says_why_it_is_not() -> None:
    for passage in passages():
        assert bool(passage.records) != bool(passage.because), passage.id
        assert len(set(passage.records)) == len(passage.records), passage.id


def test_a_reason_is_a_short_sentence() -> None:
    for passage in passages():
        if not passage.is_examined:
            assert re.fullmatch(r"The .*\.", passage.because), passage.id
            assert len(passage.because.split()) <= 20, passage.id


def test_ids_are_unique() -> None:
    ids = [passage.id for passage in passages()]
    assert len(set(ids)) == len(ids)


def test_passages_stand_in_the_order_of_the_article() -> None:
    order = ("abstract", *"1234567", "A")
    for earlier, later in itertools.pairwise(passages()):
        assert earlier.at < later.at, later.id
        assert earlier.page <= later.page, later.id
        assert order.index(earlier.section) <= order.index(later.section), later.id
    # The references, which are not part of the text, end on 2873.
    assert {passage.page for passage in passages()} == set(range(2856, 2873))


def test_no_passage_begins_within_another_but_where_that_goes_round_it() -> None:
    for earlier, later in itertools.pairwise(passages()):
        assert earlier.at < earlier.end
        assert later.at >= earlier.end or later.end < earlier.end, later.id


def test_quotations_are_short() -> None:
    for passage in passages():
        assert 0 < len(passage.quote.split()) <= 30, passage.id
        assert passage.quote == passage.quote.strip(), passage.id


def test_a_formula_has_a_repaired_reading() -> None:
    for passage in passages():
        assert bool(passage.reading) >= (passage.kind == "formula"), passage.id
        # The glyphs that the text has for signs are gone.
        assert not set("þð¼Þ") & set(passage.reading), passage.id
        assert len(passage.reading.split()) <= 80, passage.id
        if " ... " in passage.reading and passage.kind != "formula":
            assert " ... " in passage.quote, passage.id


def test_every_formula_figure_table_and_property_is_there() -> None:
    kinds = {passage.id: passage.kind for passage in passages()}
    formulas = [f"eq{n}" for n in range(1, 41)] + [f"eqA{n}" for n in range(1, 9)]
    figures = [f"fig{n}" for n in range(1, 16)] + ["figA1"]
    assert [id for id, kind in kinds.items() if kind == "formula"] == formulas
    assert sorted(id for id, kind in kinds.items() if kind == "caption") == sorted(figures)
    assert [id for id, kind in kinds.items() if kind == "table"] == ["table1", "table2"]
    assert {"property1", "property2"} <= kinds.keys()


def test_passages_name_statements_that_are_there() -> None:
    known = references().keys()
    for passage in passages():
        assert known >= set(passage.records), passage.id


def test_every_statement_of_the_article_has_a_passage() -> None:
    of_the_article = {id for id, where in references().items() if where != "beyond the article"}
    assert [id for id in sorted(of_the_article) if not passages_of(id)] == []


def test_a_statement_of_a_formula_is_named_by_that_formula() -> None:
    named = {passage.id: passage.records for passage in passages()}
    for id in references():
        if named.get(id):
            assert id in named[id]


def test_the_text_is_the_one_that_is_described(text: str) -> None:
    source = article_source()
    assert hashlib.sha256(text.encode()).hexdigest() == source.sha256
    assert text.count(source.plus) == source.pluses
    assert "+" not in text
    assert str(source.pluses) in source.rule


def test_quotations_stand_verbatim_at_their_places(text: str) -> None:
    for passage in passages():
        whole = re.sub(r"\n+", " ", text[passage.at : passage.end])
        first, *last = passage.quote.split(" ... ")
        if last:
            assert whole.startswith(first), passage.id
            assert whole.endswith(last[0]), passage.id
        else:
            assert whole == first, passage.id


def test_nothing_but_labels_of_axes_lies_between_passages(text: str) -> None:
    end = 0
    for passage in passages():
        between = text[end : passage.at].strip()
        assert len(between) <= LABELS, f"before {passage.id}"
        assert not re.search("[a-z]{3}", between), f"a word before {passage.id}"
        end = max(end, passage.end)
    assert text[end:].strip() == ""
