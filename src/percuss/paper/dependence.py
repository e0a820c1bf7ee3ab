"""Dependence of the statements on each other, and so which errors are errors of their own."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

from percuss.paper.statement import VerdictKind

# Which statements of the article each one is derived from, or illustrates.
DEPENDS: dict[str, tuple[str, ...]] = {
    "eq27": (),
    "eq28": ("eq27",),
    "eq29": ("eq28",),
    "eq30": ("eq29",),
    "eq31": ("eq29", "eq30"),
    "periodicity-subharmonic": ("eq31",),
    "eq32": ("eq28", "eq31"),
    "eq33": ("eq32",),
    "large-times": ("eq31",),
    "eq34": ("eq33", "large-times"),
    "chain": ("eq33", "eq34"),
    "eq35": ("eq34",),
    "eq35-constant": ("eq34",),
    "fig10": ("eq35",),
    "fig11": ("eq35",),
    "fig11-bilinear": ("eq35",),
    "fig11-asymptotic": ("eq35",),
    "accuracy-argument": ("eq35", "fig10", "fig11"),
    "fig10-accuracy": ("accuracy-argument",),
    "fig13": ("periodicity-subharmonic",),
    "poincare-maps": ("eq27",),
    "eq37": (),
    "eq38": ("eq37",),
    "eq38-velocity": ("eq37",),
    "eq39": ("eq38-velocity",),
    "eq40": ("eq38",),
    "cosine-half-pi": ("eq39", "eq40"),
    "cosine-steady": ("eq39", "eq40"),
    "cosine-becomes-sine": ("eq27", "cosine-half-pi"),
    "fig14": ("eq35", "cosine-becomes-sine"),
    "fig15": ("eq35", "cosine-becomes-sine"),
    "fig14-numerics": ("fig14", "fig15"),
    "eq14": (),
    "family-period": ("eq14",),
    "family-commensurate": ("family-period",),
    "periodicity-outside-range": (),
    "periodicity-fig6b-lost": ("periodicity-outside-range",),
}

# What a graph says of those that have no number of their own.
LABELS: dict[str, str] = {
    "periodicity-subharmonic": "near the eigenset",
    "large-times": "time of two flights",
    "chain": "(27) to (35)",
    "eq35-constant": "b, by (34)",
    "fig11-bilinear": "fig 11, bilinear",
    "fig11-asymptotic": "b = 0.61",
    "accuracy-argument": "accuracy, argued",
    "fig10-accuracy": "accuracy",
    "poincare-maps": "Poincaré maps",
    "eq38-velocity": "x' of (38)",
    "cosine-half-pi": "impact at π/2",
    "cosine-steady": "steady for V0 > 0",
    "cosine-becomes-sine": "(36) turns into (27)",
    "fig14-numerics": "figs 14-15, method",
    "family-period": "period of the example",
    "family-commensurate": "the same, m = 2, 3",
    "periodicity-outside-range": "periodicity is lost",
    "periodicity-fig6b-lost": "the same, fig 6b",
}


def falls_with(record: str, depends: Mapping[str, Sequence[str]] = DEPENDS) -> tuple[str, ...]:
    """Return the statements whose argument rests on one, directly or through others.

    Examples
    --------
    >>> falls_with("eq35-constant")
    ()
    >>> falls_with("cosine-half-pi")
    ('cosine-becomes-sine', 'fig14', 'fig15', 'fig14-numerics')
    """
    fallen = {record}
    while more := {id for id, needs in depends.items() if fallen & set(needs)} - fallen:
        fallen |= more
    return tuple(id for id in depends if id in fallen - {record})


def own_errors(
    kinds: Mapping[str, VerdictKind],
    anew: Collection[str] = (),
    depends: Mapping[str, Sequence[str]] = DEPENDS,
) -> tuple[str, ...]:
    """Return the statements in which an error arises; the others in error repeat one of theirs.

    Parameters
    ----------
    kinds
        The verdict on each statement that was examined.
    anew
        Those that do not follow even from the right forms of what they rest on: their error is
        their own, whatever other errors precede it.
    depends
        On which statements each one rests.

    Returns
    -------
    tuple of str
        In the order of ``kinds``.

    Examples
    --------
    >>> kinds = {"eq29": "corrected", "eq30": "corrected", "eq31": "holds", "eq32": "corrected"}
    >>> own_errors(kinds)
    ('eq29', 'eq32')
    """
    wrong = {id for id, kind in kinds.items() if kind in ("corrected", "fails")}
    return tuple(
        id for id in kinds if id in wrong and (id in anew or not wrong & set(depends.get(id, ())))
    )
