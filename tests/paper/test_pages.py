"""What stands on the pages: findings, the coverage, the page beyond, the chain, claims.json."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from dataclasses import replace
from html import escape
from pathlib import Path

import pytest
from tests.paper.test_report import CORRECTED, FAILS, HOLDS, OPEN, outline, result, statement

from percuss.cli.terminal import print_verdicts
from percuss.model.harmonic_forces import sine
from percuss.model.oscillator import impact_oscillator
from percuss.model.start import Start
from percuss.paper.article import article_source, passages, passages_of
from percuss.paper.chain import LINES
from percuss.paper.claim import Claim, examine
from percuss.paper.collection import items, statement_with_id
from percuss.paper.dependence import falls_with
from percuss.paper.evidence import Deduction, Step, compare
from percuss.paper.figure_files import Drawn
from percuss.paper.findings import HEADLINES, Headline, headlines_of
from percuss.paper.records import records_text, schema_text
from percuss.paper.report.chain import BOX, chain, dependence_graph
from percuss.paper.report.coverage import coverage_page
from percuss.paper.report.filters import RecordEntry, counts, records
from percuss.paper.report.formulas import display, formula_svg
from percuss.paper.report.front import findings
from percuss.paper.report.page import beyond_page, page, pages
from percuss.paper.report.pictures import FLAT, THUMBNAIL, thumbnail
from percuss.paper.report.prose import prose
from percuss.paper.run import run_paper
from percuss.paper.statement import Finding, Statement
from percuss.studies import Limits, Motion, Study, study_text
from percuss.studies.link import link_of

KNOWN = {item.name: item for item in items()}
PROOF = Deduction("all cases", (Step("a step", r"\frac{1}{2} = 0.5", True, "algebra"),))


def supporting(claims: Mapping[str, Claim] | None = None) -> dict[str, Claim]:
    """Return claims with the verdicts that all findings rest on."""
    made = {
        id: replace(HOLDS, id=id, kind=kinds[0], reference=id)
        for headline in HEADLINES
        for id, kinds in headline.kinds.items()
    }
    return {**made, **(claims or {})}


@pytest.mark.parametrize("headline", HEADLINES, ids=lambda headline: headline.record)
def test_a_finding_says_what_its_records_say(headline: Headline) -> None:
    kinds = headline.kinds
    claims = {id: examine(statement_with_id(KNOWN[id])) for id in kinds}

    assert {id: claim.kind for id, claim in claims.items() if claim.kind not in kinds[id]} == {}
    assert headline in headlines_of(claims)


@pytest.mark.parametrize("headline", HEADLINES, ids=lambda headline: headline.record)
def test_a_finding_names_a_record_and_a_figure_that_there_are(headline: Headline) -> None:
    assert headline.record in headline.kinds
    assert set(headline.kinds) <= {name for name, item in KNOWN.items() if item.kind == "statement"}
    assert any(item.name == headline.figure and item.kind == "figure" for item in items())
    for pair in headline.pairs:
        assert pair.record in headline.kinds
        for formula in (pair.printed, pair.right):
            assert formula_svg(formula).startswith("<svg"), formula


def test_there_are_six_findings_and_each_falls_with_any_of_its_records() -> None:
    claims = supporting()
    assert headlines_of(claims) == HEADLINES
    assert len(HEADLINES) == 6
    for headline in HEADLINES:
        for id, kinds in headline.kinds.items():
            assert "undecided" not in kinds
            changed = {**claims, id: replace(claims[id], kind="undecided")}
            assert headline not in headlines_of(changed)
            assert headline not in headlines_of(
                {name: c for name, c in claims.items() if name != id}
            )


def test_findings_show_both_formulas_a_small_picture_and_one_record(tmp_path: Path) -> None:
    from matplotlib import image
    from numpy import ones

    files = tuple(tmp_path / f"fig11{suffix}" for suffix in (".svg", ".png"))
    image.imsave(files[1], ones((900, 600, 3)))
    drawn = Drawn("fig11", "growth", "", files)
    right = statement("eq33", Finding((compare("a", 1.0, 2.0),), (compare("a", 1.0, 1.0),), "so"))
    right = replace(right, formula="V = 7", right_formula="V = 8")

    text = findings(supporting({"eq33": right}), {"fig11": drawn})

    assert outline(text).ids == ["findings"]
    assert text.count('class="finding"') == len(HEADLINES)
    # The record's own formulas come first.
    assert 'aria-label="V = 7"' in text
    assert 'aria-label="V = 8"' in text
    assert text.count('href="#figure-fig11"') == 1
    for headline in HEADLINES:
        assert f'href="#{headline.record}"' in text
    assert findings({}, {}) == ""


def test_a_small_picture_is_the_upper_part(tmp_path: Path) -> None:
    import base64
    from io import BytesIO

    from matplotlib import image
    from numpy import zeros

    file = tmp_path / "fig1.png"
    pixels = zeros((1200, 800, 3))
    pixels[: int(FLAT * 800)] = 1.0
    image.imsave(file, pixels)

    found = re.search(r'base64,([^"]+)"', thumbnail(Drawn("fig1", "t", "", (file,))))

    assert found is not None
    small = image.imread(BytesIO(base64.b64decode(found[1])))
    assert small.shape[:2] == (int(FLAT * 800) // 4, THUMBNAIL)
    assert small[..., :3].mean() > 0.99


def test_what_fails_stands_first_then_what_is_corrected() -> None:
    entries: list[RecordEntry] = [
        (claim, "impact-times") for claim in (HOLDS, OPEN, CORRECTED, FAILS)
    ]

    found = re.findall(r'class="record (\w+)"', records(entries))

    assert found == ["fails", "corrected", "undecided", "holds"]


def test_a_record_opens_to_quotation_formulas_evidence_and_code() -> None:
    proven = examine(
        Statement("eq33", "(33)", "V grows.", "by hand", lambda: Finding((PROOF,)), "V_k", "x.md")
    )
    text = records([(replace(proven, right_formula="V_{k+1}"), "half-harmonic")])

    outline(text)
    quoted = next(passage for passage in passages() if "eq33" in passage.records)
    assert quoted.quote in text
    assert f"<b>Read:</b> {prose(passages_of('eq33')[1].reading)}</p>" in text
    assert f"Section {quoted.section}, p. {quoted.page}" in text
    assert text.index('aria-label="V_k"') < text.index('aria-label="V_{k+1}"')
    assert r'aria-label="\frac{1}{2} = 0.5"' in text
    assert "algebra, by SymPy" in text
    assert "Proof: page <em>x</em> of the documentation" in text
    assert f"Computed by <code>{__name__}:" in text
    assert "lambda: Finding((PROOF,))" in text


def test_a_record_shows_its_study_its_commands_and_its_link(tmp_path: Path) -> None:
    study = Study(impact_oscillator(), sine(3), Motion(Start(0, "0.51"), Limits(periods=9)))
    claim = replace(HOLDS, finding=replace(HOLDS.finding, study=study_text(study)))
    shown = page(result(tmp_path, claim))

    outline(shown)
    assert 'href="studies/good.toml"' in shown
    assert f'href="../#{link_of(study)}"' in shown
    assert "percuss run studies/good.toml" in shown
    assert "percuss serve studies/good.toml" in shown
    assert escape('v0 = "0.51"') in shown
    assert "good.toml" not in page(result(tmp_path, HOLDS))


def test_only_what_the_article_says_holds_as_printed() -> None:
    assert "<span>hold as printed</span>" in counts([(HOLDS, "half-harmonic")])
    assert "<span>hold</span>" in counts([(replace(HOLDS, scope="beyond"), "half-harmonic")])


def test_what_goes_beyond_the_article_has_a_page_and_counts_of_its_own(tmp_path: Path) -> None:
    own = replace(FAILS, scope="beyond")
    whole = result(tmp_path, HOLDS, own)
    here, there = page(whole), beyond_page(whole)

    number = r'<b class="(\w+)">(\d+)</b>'
    assert dict(re.findall(number, here))["fails"] == "0"
    assert dict(re.findall(number, here))["holds"] == "1"
    assert dict(re.findall(number, there))["fails"] == "1"
    assert dict(re.findall(number, there))["holds"] == "0"
    # A link to the record on the first page leads to it on the other.
    assert '<li id="bad"><a href="beyond.html#bad">' in here
    assert 'id="bad"' in there
    outline(there)


def test_the_page_says_what_it_was_read_from(tmp_path: Path) -> None:
    text = page(result(tmp_path, HOLDS))

    assert article_source().extraction in text
    assert article_source().rule in text
    assert text.index('id="source"') < text.index('id="records"')


def test_every_passage_is_covered_by_records_or_a_reason(tmp_path: Path) -> None:
    claims = {id: replace(HOLDS, id=id) for id in ("eq9", "eq33")}
    text = coverage_page(claims)
    outlines = outline(text)

    assert {passage.id for passage in passages()} <= set(outlines.ids)
    examined = sum(passage.is_examined for passage in passages())
    total = len(passages())
    assert f"Of {total} passages, {examined} are examined" in text
    assert text.count("not examinable:") == total - examined
    assert 'href="index.html#eq33"' in text
    assert set(pages(result(tmp_path, HOLDS))) == {"index.html", "beyond.html", "coverage.html"}


def test_the_chain_marks_the_line_at_which_it_breaks() -> None:
    claims = {line.record: replace(HOLDS, id=line.record) for line in LINES}

    text = chain(claims)

    outline(text)
    broken = re.findall(r"<li( class=broken)?>", text)
    assert [line.record for line, mark in zip(LINES, broken, strict=True) if mark] == ["eq33"]
    assert chain({}) == ""


def test_what_is_derived_from_a_line_falls_with_it() -> None:
    depends = {"b": ["a"], "c": ["b"], "d": ["a"], "e": ["d", "c"]}

    assert falls_with("b", depends) == ("c", "e")
    drawn = dependence_graph(depends, "b", {"b": replace(FAILS, id="b", reference="b")})
    assert drawn.count("fallen") == 3
    assert drawn.count("<line") == 5
    assert 'href="#b"' in drawn
    # No box covers another.
    boxes = [(float(x), y) for x, y in re.findall(r'<rect x="([-\d.]+)" y="([\d.]+)"', drawn)]
    for x, y in boxes:
        assert [other for other, row in boxes if row == y and abs(other - x) <= BOX] == [x]
    # From top to bottom: each below all that it is derived from.
    heights = dict(zip("abcde", (0, 1, 2, 1, 3), strict=True))
    rows = {name: y for y, name in re.findall(r'y="([\d.]+)" width.*?>(\w+)</text>', drawn)}
    order = sorted({float(y) for y in rows.values()})
    assert {name: order.index(float(y)) for name, y in rows.items()} == heights


def test_fractions_stand_at_the_size_of_a_display() -> None:
    assert display(r"\frac{\frac{a}{b}}{c}") == r"\dfrac{\frac{a}{b}}{c}"
    height = re.compile(r"height:([\d.]+)em")
    found = height.search(formula_svg(r"\frac{V}{2}"))
    assert found is not None
    assert float(found[1]) > 1.7


def test_claims_json_has_the_form_that_its_schema_describes() -> None:
    jsonschema = pytest.importorskip("jsonschema")
    proven = statement("eq33", Finding((PROOF, compare("c", 1.0, 1.0, radius=0.0))))
    claims = (HOLDS, FAILS, CORRECTED, OPEN, replace(proven, scope="beyond"))
    written, schema = json.loads(records_text(claims)), json.loads(schema_text())

    jsonschema.Draft202012Validator.check_schema(schema)
    jsonschema.validate(written, schema)
    assert written["counts"]["beyond"]["holds"] == 1
    assert sum(written["counts"]["article"].values()) == 4
    assert written["records"][4]["quotations"][0]["section"] == "5"
    assert written["source"]["doi"] == article_source().doi
    for broken in ({**written, "counts": {}}, {**written, "records": [{"id": "eq1"}]}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(broken, schema)


def test_the_terminal_ends_with_findings_failures_and_the_page(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    claims = supporting({"bad": replace(FAILS, claim="It never grows")})
    print_verdicts(result(tmp_path, *claims.values()))

    lines = capsys.readouterr().out.splitlines()
    kinds = [claim.kind for claim in claims.values()]
    assert lines[0].startswith(f"{len(claims)} statements: {kinds.count('holds')} holds, ")
    assert [line.strip() for line in lines[2:8]] == [headline.title for headline in HEADLINES]
    failing = [line for line in lines[8:-1] if "fails, measured" in line]
    assert len(failing) == kinds.count("fails")
    assert any("It never grows" in line for line in failing)
    assert not [line for line in lines[8:-1] if "holds" in line]
    assert str(tmp_path / "index.html") in "".join(lines[-2:])


def test_a_statement_that_fails_says_what_is_against_it() -> None:
    text = records([(FAILS, "model")])
    assert "Against it:</b> a &lt;b&gt; &amp; c: 2 instead of 1." in text
    refuted = statement("no", Finding((replace(PROOF, concludes="differs"),)))
    assert "Against it:</b> All cases." in records([(refuted, "model")])


def test_all_pages_and_the_schema_are_written(tmp_path: Path) -> None:
    run_paper(tmp_path, only="eq2")

    names = {path.name for path in tmp_path.iterdir()}
    assert names == {
        "index.html", "beyond.html", "coverage.html", "comment.pdf", "claims.json", "claims.schema.json",
        "studies",
    }  # fmt: skip
    assert (tmp_path / "claims.schema.json").read_text() == schema_text()
