"""Errors of the article that stand on their own, and those that repeat another."""

from __future__ import annotations

from tests.paper.findings import RECORDS, finding

from percuss.paper.article import passages_of
from percuss.paper.chain import wrong_lines
from percuss.paper.collection import statement_with_id
from percuss.paper.dependence import DEPENDS, LABELS, falls_with, own_errors
from percuss.paper.statement import VerdictKind, verdict_kind

DIAMOND = {"a": (), "b": ("a",), "c": ("a",), "d": ("b", "c")}


def test_an_error_that_is_handed_on_is_counted_once() -> None:
    kinds: dict[str, VerdictKind] = {"a": "fails", "b": "corrected", "c": "holds", "d": "fails"}

    assert own_errors(kinds, depends=DIAMOND) == ("a",)
    # Where what lies between holds, the error is another one.
    assert own_errors({**kinds, "b": "holds"}, depends=DIAMOND) == ("a", "d")
    assert own_errors(kinds, {"b"}, DIAMOND) == ("a", "b")
    assert own_errors({**kinds, "a": "undecided"}, depends=DIAMOND) == ("b",)


def test_what_falls_with_a_statement() -> None:
    assert falls_with("a", DIAMOND) == ("b", "c", "d")
    assert falls_with("d", DIAMOND) == ()


def test_the_graph_has_no_circle_and_names_statements_of_the_article() -> None:
    for id, needs in DEPENDS.items():
        assert id in RECORDS
        assert passages_of(id)
        assert set(needs) <= DEPENDS.keys()
        assert id not in falls_with(id)


def test_each_statement_has_a_label_of_its_own() -> None:
    labels = [LABELS.get(id, statement_with_id(RECORDS[id]).reference) for id in DEPENDS]

    assert len(set(labels)) == len(labels)
    assert LABELS.keys() <= DEPENDS.keys()


def test_the_errors_of_section_5() -> None:
    kinds = {id: verdict_kind(finding(id)) for id in DEPENDS}
    own = own_errors(kinds, wrong_lines())

    repeated = {id for id, kind in kinds.items() if kind in ("corrected", "fails")} - set(own)
    assert repeated == {
        "eq30", "chain", "eq35-constant", "eq38-velocity", "cosine-becomes-sine", "fig14", "fig15",
        "family-commensurate", "periodicity-fig6b-lost",
    }  # fmt: skip
    assert {"eq29", "eq32", "eq33", "eq34", "cosine-half-pi"} <= set(own)
