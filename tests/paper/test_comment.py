"""The comment to a journal: it says what the claims say, and is a few pages long."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
import typst
from tests.paper.test_report import CORRECTED, FAILS, HOLDS, OPEN, result

from percuss.paper.article import passages
from percuss.paper.comment import comment_data, comment_pdf, template
from percuss.paper.result import PaperResult
from percuss.paper.run import run_paper


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


@pytest.mark.nightly
def test_the_whole_comment_has_six_to_eight_pages(tmp_path: Path) -> None:
    assert 6 <= n_pages(run_paper(tmp_path / "out")) <= 8
