"""The page and the records that `percuss paper` writes."""

from __future__ import annotations

import base64
import json
import math
import re
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from percuss.paper.claim import Claim, examine
from percuss.paper.collection import Item
from percuss.paper.evidence import compare, counted
from percuss.paper.figure_files import Drawn
from percuss.paper.records import records_text
from percuss.paper.report.filters import COUNTS
from percuss.paper.report.formulas import formula_svg, glyphs
from percuss.paper.report.page import page
from percuss.paper.report.pictures import LARGEST_SVG
from percuss.paper.report.prose import prose
from percuss.paper.report.tables import table_rows
from percuss.paper.result import INTERRUPTED, PaperResult
from percuss.paper.statement import Finding, Statement

VOID = {"meta", "img", "br", "path", "input", "use", "line", "rect"}

OTHER_PAGES = {"index.html", "beyond.html", "coverage.html", "claims.json", "claims.schema.json"}


class Outline(HTMLParser):
    """Fails on tags that do not close in order, and collects ids and addresses."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.ids: list[str] = []
        self.addresses: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = dict(attrs)
        self.ids += [values["id"]] if values.get("id") else []  # type: ignore[list-item]
        self.addresses += [value for name, value in attrs if name in ("href", "src") and value]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        if tag not in VOID:
            assert self.open.pop() == tag


def statement(id: str, finding: Finding, reference: str = "(1)", formula: str = "") -> Claim:
    return examine(Statement(id, reference, f"claim of {id}", "by hand", lambda: finding, formula))


def result(tmp_path: Path, *claims: Claim, **changes: object) -> PaperResult:
    items = tuple(Item("statement", claim.id, "family", "impact-times") for claim in claims)
    values = {
        "folder": tmp_path,
        "items": items,
        "claims": {claim.id: claim for claim in claims},
        "figures": {},
        "missing": {},
        "command": "percuss paper",
        "seconds": 1.0,
        **changes,
    }
    return PaperResult(**values)  # type: ignore[arg-type]


HOLDS = statement("good", Finding((compare("a", 1.0, 1.0),)), formula=r"\frac{a}{b} = \sin x")
FAILS = statement(
    "bad",
    Finding(
        (compare("a <b> & c", 2.0, 1.0, error=0.25), compare("V*(5) = 1.4", 1.4, 1.5)),
        instead="a is 2",
    ),
    "table 1",
)
CORRECTED = statement(
    "mended", Finding((compare("a", 2.0, 1.0),), (compare("a", 2.0, 2.0),), "2 for V_k^2"), "(A3)"
)
OPEN = statement("open", Finding((compare("a", math.nan, 1.0),)))


def outline(text: str) -> Outline:
    parser = Outline()
    parser.feed(text)
    parser.close()
    assert parser.open == []
    return parser


def test_the_page_needs_nothing_from_outside(tmp_path: Path) -> None:
    outlines = outline(page(result(tmp_path, HOLDS, FAILS, CORRECTED, OPEN)))

    local = [address for address in outlines.addresses if not address.startswith(("#", "data:"))]
    views = {address for address in local if address.startswith("?")}
    assert {f"?verdict={kind}#records" for kind in COUNTS} <= views
    assert set(local) - views == OTHER_PAGES
    assert {a[1:] for a in outlines.addresses if a.startswith("#")} <= set(outlines.ids)
    assert len(set(outlines.ids)) == len(outlines.ids)


def test_verdicts_are_counted_from_the_evidence(tmp_path: Path) -> None:
    text = page(result(tmp_path, HOLDS, FAILS, CORRECTED, OPEN))

    counts = dict(re.findall(r'<b class="(\w+)">(\d+)</b>', text))
    assert counts == {"holds": "1", "corrected": "1", "fails": "1", "undecided": "1"}
    assert "2 for <i>V</i><sub>k</sub><sup>2</sup>." in text
    assert "Undecided because the evidence leaves open: a." in text


def test_what_is_measured_stands_beside_what_is_expected(tmp_path: Path) -> None:
    text = page(result(tmp_path, FAILS))

    assert "a &lt;b&gt; &amp; c" in text
    row = re.search(r"<td>a &lt;b&gt; &amp; c <span[^>]*>measured</span></td>(.*?)</tr>", text)
    assert row is not None
    assert re.findall(r'number">([^<]*)', row[1]) == ["2", "\u00b1 0.25", "1"]


def test_a_count_says_that_it_is_one(tmp_path: Path) -> None:
    text = page(result(tmp_path, statement("whole", Finding((counted("impacts", 3, 3),)))))

    row = re.search(r"<td>impacts <span[^>]*>measured</span></td>(.*?)</tr>", text)
    assert row is not None
    assert re.findall(r'number">([^<]*)', row[1]) == ["3", "a count", "3"]


def test_what_fails_stands_with_what_is_true_instead(tmp_path: Path) -> None:
    text = page(result(tmp_path, HOLDS, FAILS))

    assert re.findall(r'id="failures">.*?<li>(.*?)</li>', text) == [
        '<a href="#bad">table 1</a> claim of bad <b>Instead:</b> a is 2.'
    ]
    assert "<b>Instead:</b> a is 2.</p>" in text
    assert 'id="failures"' not in page(result(tmp_path, HOLDS, CORRECTED))


def test_the_page_says_how_many_errors_are_independent(tmp_path: Path) -> None:
    differs = Finding((compare("a", 2.0, 1.0),), (compare("a", 2.0, 2.0),), "2")
    claims = [statement(id, differs) for id in ("family-period", "family-commensurate", "eq12")]
    found = result(tmp_path, *claims)

    assert (
        "Of 3 statements 3 hold with a correction. Behind the 3 that do not hold as printed stand 2 "
        "independent errors; the other one repeats an error in what the article derives them from."
    ) in page(found)
    records = json.loads(records_text(claims))
    assert records["own_errors"] == ["family-period", "eq12"]
    assert "independent error" not in page(result(tmp_path, HOLDS))


def test_a_formula_in_our_symbols_says_so(tmp_path: Path) -> None:
    stated = replace(CORRECTED, formula="t_k", right_formula="t_k + 1", is_printed=False)

    assert "as stated, in our symbols" in page(result(tmp_path, stated))
    assert "as printed</span>" in page(result(tmp_path, replace(stated, is_printed=True)))


def test_tables_show_printed_computed_and_difference(tmp_path: Path) -> None:
    rows = table_rows([HOLDS, FAILS], "table 1")
    text = page(result(tmp_path, FAILS))

    assert [(check.expected, check.value) for check, _ in rows] == [(1.5, 1.4)]
    row = re.search(r"<td>V\*\(5\)</td>(.*?)</tr>", text)
    assert row is not None
    assert re.findall(r'number">([^<]*)', row[1]) == ["1.5", "1.400000000000", "\u22120.1"]
    assert "0 of 2 comparisons agree" in text
    assert "Table 1" not in page(result(tmp_path, HOLDS))


def test_what_is_missing_stands_at_the_top(tmp_path: Path) -> None:
    gone = Item("figure", "fig6", "third_harmonic", "harmonics")
    text = page(
        result(tmp_path, HOLDS, missing={gone: INTERRUPTED}, items=(gone,)),
    )

    assert "Missing: 1 of 1" in text
    assert f"<strong>fig6</strong>: {INTERRUPTED}" in text


@pytest.mark.parametrize(
    ("size", "kind"), [(LARGEST_SVG, "image/svg+xml"), (LARGEST_SVG + 1, "image/png")]
)
def test_a_large_svg_is_replaced_by_its_png(size: int, kind: str, tmp_path: Path) -> None:
    files = tuple(tmp_path / f"fig1{suffix}" for suffix in (".svg", ".png", ".nc", ".csv"))
    contents = {files[0]: b"s" * size, files[1]: b"png"}
    for file, content in contents.items():
        file.write_bytes(content)
    drawn = Drawn("fig1", "x < y", "V_0 = 1.", files)
    item = Item("figure", "fig1", "bilinear_motion", "model")

    text = page(result(tmp_path, items=(item,), figures={"fig1": drawn}))

    embedded = re.search(r'src="data:([^;]+);base64,([^"]+)"', text)
    assert embedded is not None
    assert embedded[1] == kind
    expected = contents[files[0] if kind.endswith("xml") else files[1]]
    assert base64.b64decode(embedded[2]) == expected
    assert {file.name for file in files} <= set(outline(text).addresses)


def test_a_figure_and_a_statement_may_share_a_name(tmp_path: Path) -> None:
    claim = statement("fig1", Finding((compare("a", 1.0, 1.0),)), "fig 1")
    items = (
        Item("figure", "fig1", "bilinear_motion", "model"),
        Item("statement", "fig1", "family", "model"),
    )

    text = page(result(tmp_path, items=items, claims={"fig1": claim}))

    assert text.count('id="fig1"') == 1


def test_formulas_are_outlines_in_the_colour_of_the_text() -> None:
    svg = formula_svg(r"\frac{V_k}{2} \sin t")

    assert svg.count("<svg") == 1
    outlines = glyphs(svg)
    for name in re.findall(r'<use href="#([^"]+)"', svg):
        assert re.search(rf'<path id="{name}" d="M[-0-9. MLQCZ]+Z"/>', outlines)
    # The bar of the fraction.
    assert re.search(r'<path d="M[-0-9. MLQCZ]+Z"/>', svg)
    assert glyphs("<p>no formula</p>") == ""
    assert formula_svg("a\nb").count("<svg") == 2


def test_a_formula_that_is_no_mathtext_stands_as_text() -> None:
    assert formula_svg(r"\nonsense{<x>}") == r"<code>\nonsense{&lt;x&gt;}</code>"


@pytest.mark.parametrize(
    ("plain", "html"),
    [
        ("t_(k+1) - t_k", "<i>t</i><sub>k+1</sub> &minus; <i>t</i><sub>k</sub>"),
        ("w-^2/w+^2", "<i>ω</i><sub>&minus;</sub><sup>2</sup>/<i>ω</i><sub>+</sub><sup>2</sup>"),
        ("half-harmonic, 1e-10, 10-13", "half-harmonic, 1e-10, 10-13"),
        ("a spire, max_impacts", "a spire, max_impacts"),
        ("V_{k+2} = t^{1/2}", "<i>V</i><sub>k+2</sub> = t<sup>1/2</sup>"),
        ("<script>", "&lt;script&gt;"),
    ],
)
def test_formulas_in_sentences_get_their_signs(plain: str, html: str) -> None:
    assert prose(plain) == html


def test_records_hold_the_evidence_and_no_nan() -> None:
    text = json.dumps([claim.record() for claim in (HOLDS, CORRECTED, OPEN)], allow_nan=False)
    good, mended, unknown = json.loads(text)

    assert set(good) == {
        "id", "scope", "kind", "verdict", "grade", "reference", "claim", "quotations", "formula",
        "is_printed", "right_formula", "method", "evidence", "instead", "remark", "theory", "study",
        "code",
    }  # fmt: skip
    assert mended["verdict"] == "holds with the correction 2 for V_k^2"
    assert mended["evidence"]["corrected"][0]["outcome"] == "agrees"
    assert unknown["evidence"]["printed"][0]["value"] is None
