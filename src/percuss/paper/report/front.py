"""The first screen of the report: what was found, in words, formulas and small pictures."""

from __future__ import annotations

from collections.abc import Mapping
from html import escape

from percuss.paper.claim import Claim
from percuss.paper.figure_files import Drawn
from percuss.paper.findings import Headline, headlines_of
from percuss.paper.report.claims import badge, formula_pair
from percuss.paper.report.pictures import thumbnail
from percuss.paper.report.prose import prose


def findings(claims: Mapping[str, Claim], figures: Mapping[str, Drawn]) -> str:
    """Return the findings that the records support, each as a card.

    Parameters
    ----------
    claims, figures
        What was examined and drawn, by name.

    Returns
    -------
    str
        A section; empty where no finding can be told.
    """
    headlines = headlines_of(claims)
    if not headlines:
        return ""
    cards = "".join(
        f'<li class="finding">{_card(headline, claims, figures)}</li>' for headline in headlines
    )
    return (
        f'<section id="findings"><h2>What was found</h2><ol class="findings">{cards}</ol></section>'
    )


def _card(headline: Headline, claims: Mapping[str, Claim], figures: Mapping[str, Drawn]) -> str:
    pairs = "".join(
        formula_pair(*pair.formulas(claims), pair.name, is_printed=pair.is_printed)
        for pair in headline.pairs
    )
    small = ""
    if headline.figure in figures:
        picture = thumbnail(figures[headline.figure])
        small = f'<a class="small-figure" href="#figure-{escape(headline.figure)}">{picture}</a>'
    claim = claims[headline.record]
    link = (
        f'<p class="more"><a href="#{escape(claim.id)}">The record of {escape(claim.reference)}'
        f"</a> {badge(claim)}</p>"
    )
    return (
        f'<div class="words"><h3>{prose(headline.title)}</h3><p>{prose(headline.text)}</p></div>'
        f'{small}<div class="formulas">{pairs}</div>{link}'
    )
