"""Findings about the article: six, in words, each resting on records.

A finding says nothing of its own: it names the records that it sums up and the verdicts that they
must have. If one has another verdict, the finding is not told.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

from percuss.paper.chain import LINES, wrong_lines
from percuss.paper.claim import Claim
from percuss.paper.dependence import own_errors
from percuss.paper.statement import VerdictKind


@dataclass(frozen=True)
class FormulaPair:
    """A printed formula and the right one.

    Parameters
    ----------
    record
        Id of the record that it belongs to; where that has a right formula, both are the record's.
    name
        What stands above them: the formula's number, or a few words.
    printed, right
        Mathtext without dollar signs.
    is_printed
        Whether the article prints the formula; else it puts words into symbols.
    """

    record: str
    name: str
    printed: str
    right: str
    is_printed: bool = True

    def formulas(self, claims: Mapping[str, Claim]) -> tuple[str, str]:
        """Return the printed formula and the right one."""
        claim = claims.get(self.record)
        if claim is None or not claim.right_formula:
            return self.printed, self.right
        return claim.formula, claim.right_formula


@dataclass(frozen=True)
class Headline:
    """A finding in words, and the records that it rests on.

    Parameters
    ----------
    title
        The finding in a line.
    text
        The same in two or three sentences.
    kinds
        Which verdicts each record may have for the finding to be true.
    pairs
        Formulas as printed and as right.
    record
        The record that a reader should open first.
    figure
        Name of a figure that shows it.
    """

    title: str
    text: str
    kinds: Mapping[str, tuple[VerdictKind, ...]]
    pairs: tuple[FormulaPair, ...]
    record: str
    figure: str

    def is_told_by(self, claims: Mapping[str, Claim]) -> bool:
        """Return whether all of its records were examined and have a verdict that it names."""
        return all(
            record in claims and claims[record].kind in kinds
            for record, kinds in self.kinds.items()
        )


def headlines_of(claims: Mapping[str, Claim]) -> tuple[Headline, ...]:
    """Return the findings that the records support.

    Parameters
    ----------
    claims
        What was examined, by id.

    Examples
    --------
    >>> headlines_of({})
    ()
    """
    return tuple(headline for headline in HEADLINES if headline.is_told_by(claims))


def errors_of_their_own(claims: Iterable[Claim]) -> tuple[str, ...]:
    """Return the statements of the article in which an error arises.

    Parameters
    ----------
    claims
        What was examined.

    Returns
    -------
    tuple of str
        Their ids. The other statements that do not hold are derived from one of these, or
        illustrate it, and repeat its error.

    Examples
    --------
    >>> errors_of_their_own([])
    ()
    """
    kinds = {claim.id: claim.kind for claim in claims if claim.scope == "article"}
    anew = wrong_lines() if any(line.record in kinds for line in LINES) else ()
    return own_errors(kinds, anew)


HEADLINES = (
    Headline(
        "The law of growth is right, its derivation is not.",
        "The printed (33) is the right (32) applied twice, with the next impact put at t_k + pi. It "
        "comes pi a_k later, and what this shift of the phase adds cancels the term in cos^2 t_k. The rest has "
        "the mean zero, so that (34) has nothing to average; and the phase stands still, so that "
        "nothing may be averaged. The growth as sqrt t survives, with another constant in (34).",
        {"eq33": ("corrected",), "eq34": ("corrected",), "eq35": ("holds",)},
        (
            FormulaPair(
                "eq33",
                "(33)",
                r"V_{k+2} = V_k + \frac{\pi}{2}\,\frac{\frac{\pi}{2}\cos^2 t_k + \sin 2t_k}{V_k}",
                r"V_{k+2} = V_k + \frac{\pi}{2}\,\frac{\sin 2t_k}{V_k} + O(V_k^{-2})",
            ),
            FormulaPair(
                "eq34",
                "(34)",
                r"\frac{dV}{dt} = \frac{a}{\pi V}",
                r"\frac{dV}{dt} = \frac{\sin 2\psi}{4V}",
            ),
        ),
        "eq34",
        "fig11",
    ),
    Headline(
        "The factor b of sqrt t depends on the start.",
        "By (34) b is the same for every start. But b depends on the phase psi that the impacts "
        "approach, and psi on the start. No b exceeds 1/sqrt 2.",
        {"eq35-constant": ("corrected",)},
        (
            FormulaPair(
                "eq35-constant",
                "(34), b of (35),",
                r"b = \sqrt{\frac{2a}{\pi}}",
                r"b = \sqrt{\frac{\sin 2\psi}{2}}",
                is_printed=False,
            ),
        ),
        "eq35-constant",
        "fig10",
    ),
    Headline(
        "Impact times approach the eigenset shifted by psi, not the eigenset itself.",
        "Under sin t the intervals between impacts tend to pi, as (31) says. The times tend to "
        "multiples of pi plus a phase psi that the start decides.",
        {"periodicity-subharmonic": ("corrected",), "eq31": ("holds",)},
        (
            FormulaPair(
                "periodicity-subharmonic",
                "section 5,",
                r"t_k - \pi k \to 0",
                r"t_k - \pi k \to \psi,\quad 0 < \psi < \frac{\pi}{2}",
                is_printed=False,
            ),
        ),
        "periodicity-subharmonic",
        "fig13",
    ),
    Headline(
        "The motion of fig 6b is periodic.",
        "Below the critical velocity the impact times are others than the eigenset, but they do "
        "not lose periodicity: from V0 = 0.45 the motion repeats itself after 4 pi, that is after "
        "six impacts and six periods of the force, and so do all motions near it.",
        {"periodicity-fig6b-lost": ("fails",), "periodicity-outside-range": ("corrected",)},
        (
            FormulaPair(
                "periodicity-fig6b-lost",
                "fig 6b,",
                r"x(t + T) \neq x(t)\ \ \mathrm{for\ every}\ T",
                r"x(t + 4\pi) = x(t)",
                is_printed=False,
            ),
        ),
        "periodicity-fig6b-lost",
        "fig6",
    ),
    Headline(
        "The growth of figs 14 and 15 is no property of the model.",
        "Under cos t from rest the motion has the period 2 pi: at multiples of 2 pi it touches the "
        "wall without speed. The article derives the growth from an impact at pi/2, where the mass "
        "is off the wall.",
        {"fig14": ("fails",), "fig15": ("fails",), "cosine-half-pi": ("corrected",)},
        (
            FormulaPair(
                "fig14",
                "fig 14",
                r"V \approx 0.31\sqrt{t}",
                r"V = \frac{\pi}{2}\ \ \mathrm{at}\ \ t = \pi, 3\pi, 5\pi, \ldots",
            ),
        ),
        "fig14",
        "fig14",
    ),
    Headline(
        "Slips in single formulas, with the right forms.",
        "In the force (12) both factors before the cosine are wrong; in the amplitude (13) of the "
        "long flight a plus, which no extraction makes, stands for a minus; (26) gives the critical "
        "velocity for the largest root of (25) only, which the article does not say.",
        {"eq12": ("corrected",), "eq13-long": ("corrected",), "eq26": ("corrected",)},
        (
            FormulaPair(
                "eq12",
                "(12)",
                r"f = \frac{(3-m)(m+5)}{(m+1)^2}\cos\frac{2t+\pi}{m+1} + \ldots",
                r"f = \frac{(1-m)(m+3)}{(m+1)^2}\cos\frac{2t+\pi}{m+1} + \ldots",
            ),
            FormulaPair(
                "eq13-long",
                "(13)",
                r"A = V_0 + \frac{2}{m+1}\sin\frac{\pi}{m+1}",
                r"A = V_0 - \frac{2}{m+1}\sin\frac{\pi}{m+1}",
            ),
        ),
        "eq12",
        "fig3",
    ),
)
