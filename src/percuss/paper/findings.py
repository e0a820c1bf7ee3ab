"""What was found out about the article: six findings in words, each resting on records.

A finding says nothing of its own: it names the records that it sums up and the verdicts that they
must have. If one has another verdict, the finding is not told.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from percuss.paper.claim import Claim
from percuss.paper.statement import VerdictKind

__all__ = ["HEADLINES", "FormulaPair", "Headline", "told"]


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
    """

    record: str
    name: str
    printed: str
    right: str

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


def told(claims: Mapping[str, Claim]) -> tuple[Headline, ...]:
    """Return the findings that the records support.

    Parameters
    ----------
    claims
        What was examined, by id.

    Examples
    --------
    >>> told({})
    ()
    """
    return tuple(headline for headline in HEADLINES if headline.is_told_by(claims))


HEADLINES = (
    Headline(
        "The law of growth is right, its derivation is not.",
        "Over two impacts the term in cos^2 t_k of (33) cancels. What is left has no mean over the "
        "phase; but the phase of the impacts stands still, and there is nothing to average. So (34) "
        "has the wrong constant. The growth as sqrt t survives.",
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
        "The factor b of sqrt t is no constant of the equation.",
        "It depends on the phase psi that the impacts approach, and psi on the start. Every b up to "
        "1/sqrt 2 occurs; that of the article belongs to a start from rest.",
        {"eq35-constant": ("corrected",)},
        (
            FormulaPair(
                "eq35-constant",
                "(35)",
                r"V = b\sqrt{t},\quad b = \mathrm{const}",
                r"V = b\sqrt{t},\quad b = \sqrt{\frac{\sin 2\psi}{2}}",
            ),
        ),
        "eq35-constant",
        "fig10",
    ),
    Headline(
        "Impact times approach the eigenset shifted by psi, not the eigenset itself.",
        "Under sin t the intervals between impacts tend to pi, as (31) says. The times tend to "
        "multiples of pi plus a phase psi that the start decides.",
        {"periodicity-subharmonic": ("corrected",), "eq31": ("corrected",)},
        (
            FormulaPair(
                "periodicity-subharmonic",
                "section 5",
                r"t_k - \pi k \to 0",
                r"t_k - \pi k \to \psi,\quad 0 < \psi < \frac{\pi}{2}",
            ),
        ),
        "periodicity-subharmonic",
        "fig13",
    ),
    Headline(
        "The periodicity that fig 6b has lost is there.",
        "Below the critical velocity the impacts of fig 6b leave the eigenset, but the motion "
        "repeats itself after two periods of the free oscillator, and so do all motions near it.",
        {"periodicity-fig6b-lost": ("fails",)},
        (
            FormulaPair(
                "periodicity-fig6b-lost",
                "fig 6b",
                r"x(t + T) \neq x(t)\ \ \mathrm{for\ every}\ T",
                r"x(t + 4\pi) = x(t)",
            ),
        ),
        "periodicity-fig6b-lost",
        "fig6",
    ),
    Headline(
        "The growth of figs 14 and 15 is no property of the model.",
        "Under cos t from rest the motion has period 2 pi: at multiples of 2 pi it touches the wall "
        "without speed. The additional impact at pi/2, from which the article derives growth, does "
        "not occur.",
        {"fig14": ("fails",), "fig15": ("fails",), "cosine-half-pi": ("corrected", "fails")},
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
        "Misprints, with the right forms.",
        "The force (12) of the example, the amplitude (13) of its long flight, and (26), which does "
        "not say that the largest root of (25) is meant.",
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
