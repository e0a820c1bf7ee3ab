"""The coverage of the article: every passage with the records that examine it, or why none can."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from html import escape

from percuss.paper.article import Passage, article_source, passages
from percuss.paper.claim import Claim
from percuss.paper.report.claims import badge, read_as
from percuss.paper.report.frame import framed

TITLES = {"abstract": "Title and abstract", "A": "Appendix A"}
OTHER = {"article": "index.html", "beyond": "beyond.html"}


def coverage_page(claims: Mapping[str, Claim]) -> str:
    """Return the table of all passages of the article as a page.

    Parameters
    ----------
    claims
        What was examined, by id.

    Returns
    -------
    str
        HTML, with counts by section.
    """
    every = passages()
    sections = list(dict.fromkeys(passage.section for passage in every))
    body = (
        f"<p>{escape(article_source().extraction)} {escape(article_source().rule)}</p>"
        f"{_counts(every, sections)}"
        f"{''.join(_section(name, every, claims) for name in sections)}"
    )
    return framed("What of the article is examined", body)


def _title(section: str) -> str:
    return TITLES.get(section, f"Section {section}")


def _anchor(section: str) -> str:
    return f"section-{section}"


def _counts(every: tuple[Passage, ...], sections: list[str]) -> str:
    number = Counter(passage.section for passage in every)
    examined = Counter(passage.section for passage in every if passage.is_examined)
    rows = "".join(
        f'<tr><th scope="row"><a href="#{_anchor(name)}">{_title(name)}</a></th>'
        f'<td class="number">{number[name]}</td><td class="number">{examined[name]}</td>'
        f'<td class="number">{number[name] - examined[name]}</td></tr>'
        for name in sections
    )
    heads = "".join(
        f'<th scope="col" class="number">{word}</th>'
        for word in ("passages", "examined", "not examinable")
    )
    total, done = len(every), examined.total()
    return (
        f"<p>Of {total} passages, {done} are examined by a record; {total - done} cannot be "
        'examined, and the reason stands beside each.</p><div class="scroll"><table '
        f'class="coverage-counts"><thead><tr><td></td>{heads}</tr></thead><tbody>{rows}</tbody>'
        "</table></div>"
    )


def _section(name: str, every: tuple[Passage, ...], claims: Mapping[str, Claim]) -> str:
    rows = "".join(_row(passage, claims) for passage in every if passage.section == name)
    return (
        f'<h2 id="{_anchor(name)}">{_title(name)}</h2><table class="coverage"><thead><tr>'
        '<th scope="col">Page</th><th scope="col">Passage</th><th scope="col">Examined by</th>'
        f"</tr></thead><tbody>{rows}</tbody></table>"
    )


def _row(passage: Passage, claims: Mapping[str, Claim]) -> str:
    by = ", ".join(_record(id, claims) for id in passage.records)
    said = by or f"<em>not examinable:</em> {escape(passage.because)}"
    return (
        f'<tr id="{escape(passage.id)}"><td>{passage.page}</td><td><span class="small">'
        f"{escape(passage.kind)}</span> {escape(passage.quote)}{read_as(passage)}</td>"
        f"<td>{said}</td></tr>"
    )


def _record(id: str, claims: Mapping[str, Claim]) -> str:
    if id not in claims:
        return f"<code>{escape(id)}</code>"
    claim = claims[id]
    return f'<a href="{OTHER[claim.scope]}#{escape(id)}">{escape(id)}</a> {badge(claim)}'
