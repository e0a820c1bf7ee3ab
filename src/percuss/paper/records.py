"""claims.json: the records of a run as one object, whose form claims.schema.json describes."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Sequence
from importlib import resources
from typing import get_args

from percuss.paper.article import article_source
from percuss.paper.claim import Claim
from percuss.paper.figure_files import versions
from percuss.paper.findings import errors_of_their_own
from percuss.paper.statement import Scope, VerdictKind

# Named in claims.json and written beside it.
SCHEMA_FILE = "claims.schema.json"


def schema_text() -> str:
    """Return the JSON schema of claims.json.

    Examples
    --------
    >>> json.loads(schema_text())["type"]
    'object'
    """
    return (resources.files(__package__) / SCHEMA_FILE).read_text(encoding="utf-8")


def records_text(claims: Sequence[Claim]) -> str:
    """Return claims.json: what was examined, with which versions, and each record.

    Parameters
    ----------
    claims
        The records, in the order of the report.

    Returns
    -------
    str
        JSON of the form that `schema_text` describes.
    """
    source = article_source()
    contents = {
        "schema": SCHEMA_FILE,
        "versions": versions(),
        "source": {
            "citation": source.citation,
            "doi": source.doi,
            "extraction": source.extraction,
            "rule": source.rule,
            "sha256": source.sha256,
        },
        "counts": {scope: _counts(claims, scope) for scope in get_args(Scope)},
        "own_errors": list(errors_of_their_own(claims)),
        "records": [claim.record() for claim in claims],
    }
    return json.dumps(contents, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def _counts(claims: Sequence[Claim], scope: Scope) -> dict[str, int]:
    number = Counter(claim.kind for claim in claims if claim.scope == scope)
    return {kind: number[kind] for kind in get_args(VerdictKind)}
