"""The article, passage by passage: what it says, where, and which statement examines it."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any, Literal

PassageKind = Literal["sentence", "formula", "caption", "table", "proof"]


@dataclass(frozen=True)
class ArticleSource:
    """What the article was read from.

    Parameters
    ----------
    citation
        Authors, title, journal, year and pages.
    doi
        Its digital object identifier.
    extraction
        What was read in place of the printed pages, in a sentence.
    rule
        How its lost signs are treated, in a sentence.
    plus
        The glyph that stands there for a plus.
    pluses
        How often it stands there.
    sha256
        Of the file of the text.
    """

    citation: str
    doi: str
    extraction: str
    rule: str
    plus: str
    pluses: int
    sha256: str


@dataclass(frozen=True)
class Passage:
    """A sentence, formula, caption, table or step of a proof of the article.

    Parameters
    ----------
    id
        Short name, unique: "abstract-3", "s5-14", "eq33", "fig12", "table1", "property2".
    page
        Printed number of the page on which it begins.
    section
        "abstract" with all before the introduction, "1" to "7", or "A" for the appendix.
    kind
        "sentence", also for several that stand together, "formula", "caption", "table", or "proof"
        for a step of a proof.
    quote
        The passage as it stands in the text; of a long one the first and the last words, with
        " ... " between them. Each run of line breaks is one blank.
    reading
        How it reads in print where the text has its lines in disorder or has lost its signs, in
        plain text with formulas as `percuss.paper.report.prose` has them; empty elsewhere.
    at, end
        Where it begins and ends in the text, in characters.
    records
        Ids of the statements that examine it; empty where none can.
    because
        Why none can; empty where one does.

    Examples
    --------
    >>> formula = passages_of("eq25")[1]
    >>> formula.id, formula.page, formula.section, formula.is_examined
    ('eq25', 2863, '4', True)
    """

    id: str
    page: int
    section: str
    kind: PassageKind
    quote: str
    at: int
    end: int
    records: tuple[str, ...]
    because: str
    reading: str = ""

    @property
    def is_examined(self) -> bool:
        """Whether a statement examines it."""
        return bool(self.records)


@cache
def article_source() -> ArticleSource:
    """Return what the article was read from.

    Returns
    -------
    ArticleSource
        With the sentences that the report prints about it.

    Examples
    --------
    >>> article_source().doi
    '10.1016/j.jsv.2012.01.031'
    """
    return ArticleSource(**_tables()["source"])


@cache
def passages() -> tuple[Passage, ...]:
    """Return all passages of the article.

    Returns
    -------
    tuple of Passage
        In the order of the text, from the title to the end of Appendix A.

    Examples
    --------
    >>> passages()[0].quote[:16]
    'Periodic motions'
    """
    return tuple(_passage(**table) for table in _tables()["passage"])


def passages_of(record: str) -> tuple[Passage, ...]:
    """Return the passages that a statement examines.

    Parameters
    ----------
    record
        Id of the statement.

    Returns
    -------
    tuple of Passage
        In the order of the text; empty for a statement that goes beyond the article.

    Examples
    --------
    >>> [passage.id for passage in passages_of("eq9")][:3]
    ['abstract-3', 's3-2', 'eq7']
    """
    return tuple(passage for passage in passages() if record in passage.records)


def _passage(*, records: list[str] | None = None, because: str = "", **rest: Any) -> Passage:
    return Passage(records=tuple(records or ()), because=because, **rest)


@cache
def _tables() -> dict[str, Any]:
    text = (resources.files(__package__) / "article.toml").read_text(encoding="utf-8")
    return tomllib.loads(text)
