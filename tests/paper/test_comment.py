"""The comment to a journal: it says what the claims say, and is a few pages long."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import pytest
import typst
from tests.paper.test_report import CORRECTED, FAILS, HOLDS, OPEN, result, statement

from percuss.paper.article import passages
from percuss.paper.chain import LINES
from percuss.paper.comment import comment_data, comment_pdf, template
from percuss.paper.evidence import compare
from percuss.paper.result import PaperResult
from percuss.paper.run import run_paper
from percuss.paper.statement import Finding


def text_of(runs: Any) -> str:
    return "".join(text for _, text in runs)


def n_pages(found: PaperResult) -> int:
    pages = typst.compile(
        template(), format="png", ppi=10, sys_inputs={"data": comment_data(found)}
    )
    # Of one page there is no list.
    return len(pages) if isinstance(pages, list) else 1  # type: ignore[redundant-expr]


def test_each_record_stands_under_its_verdict(tmp_path: Path) -> None:
    found = json.loads(comment_data(result(tmp_path, HOLDS, CORRECTED, FAILS, OPEN)))

    assert [text_of(row["claim"]) for row in found["holds"]["rows"]] == ["claim of good"]
    for kind, name in (("corrected", "mended"), ("fails", "bad"), ("undecided", "open")):
        assert [text_of(r["claim"]) for r in found[kind]["records"]] == [f"claim of {name}"]
    abstract = text_of(found["abstract"])
    assert "in 4 records. 1 hold as printed, 1 with a correction, 1 fail" in abstract
    assert f"of its {len(passages())} sentences" in abstract
    (mended,) = found["corrected"]["records"]
    assert text_of(mended["evidence"]) == "a: 2, where 1 is stated; a: 2, where 2 is stated."
    assert found["holds"]["rows"][0]["grade"] == "measured"


def test_a_pdf_is_set_without_figures_and_with_an_unfinished_run(tmp_path: Path) -> None:
    pdf = comment_pdf(result(tmp_path, HOLDS, CORRECTED))

    assert pdf.startswith(b"%PDF-")
    assert n_pages(result(tmp_path, HOLDS)) >= 1


def test_the_derivation_is_shown_line_by_line_and_breaks_once(tmp_path: Path) -> None:
    differs = Finding((compare("a", 2.0, 1.0),), (compare("a", 2.0, 2.0),), "2")
    claims = [statement(line.record, differs, f"({line.formula.number})") for line in LINES]
    found = result(tmp_path, *claims)
    data = json.loads(comment_data(found))

    rows = data["chain"]["rows"]
    assert [row["number"] for row in rows] == [f"({n})" for n in range(27, 36)]
    assert [row["number"] for row in rows if row["breaks"]] == ["(33)"]
    for row, line in zip(rows, LINES, strict=True):
        assert row["follows"] == line.follows
        assert bool(row["right"]) == (line.formula.right is not None)
    assert text_of(data["chain"]["about"]).endswith("On (33) rest (34), (35).")
    assert all(record["in_table"] for record in data["corrected"]["records"])
    assert comment_pdf(found).startswith(b"%PDF-")


def test_a_formula_brings_the_outlines_of_its_signs(tmp_path: Path) -> None:
    wrong = Finding((compare("a", 2.0, 1.0),))
    (record,) = json.loads(
        comment_data(result(tmp_path, statement("bad", wrong, formula=r"\frac{a}{b} = \sin x")))
    )["fails"]["records"]
    (picture,) = record["printed"]

    used = set(re.findall(r'href="#([\w-]+)"', picture["svg"]))
    assert len(used) >= 7
    assert used == set(re.findall(r'<path id="([\w-]+)"', picture["svg"]))


@pytest.mark.nightly
def test_the_whole_comment_has_six_to_eight_pages(tmp_path: Path) -> None:
    assert 6 <= n_pages(run_paper(tmp_path / "out")) <= 8
