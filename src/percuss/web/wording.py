"""Messages of the package in the words of the page, without code and names of files."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from percuss.model.exact import as_float
from percuss.model.start import BEHIND_A_WALL
from percuss.studies.kinds.diagram import Diagram

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from percuss.studies.study import Study

_WORDS = (
    (f"; {BEHIND_A_WALL}", "; a soft stop can be entered, a wall cannot"),
    ('; write 2.8, or "2.8" for that decimal, "1/3" for that fraction', ", such as 2.8 or 1/3"),
    ("give t_end", "give a duration"),
)
# Stops and harmonics where names of quantities, or axes of a picture, have them; the page counts
# them from 1.
_STOP_OF_FORCE = re.compile(r"stop_force_(\d+)")
_NUMBERED = re.compile(r"(of stop|, harmonic) (\d+)")


def plain(sentence: str) -> str:
    """Return a message in words that need no knowledge of code or study files.

    Examples
    --------
    >>> plain(f"below the wall at x = 0.0; {BEHIND_A_WALL}")
    'below the wall at x = 0.0; a soft stop can be entered, a wall cannot'
    """
    for words, on_page in _WORDS:
        sentence = sentence.replace(words, on_page)
    return sentence


def quantity_words(names: str) -> str:
    """Return names of quantities in words, with stops counted from 1, as on the page.

    Examples
    --------
    >>> quantity_words("impact_times 0.01, stop_force_1 2.5 N")
    'impact times 0.01, stop force 2 2.5 N'
    """
    counted = _STOP_OF_FORCE.sub(lambda match: f"stop_force_{int(match[1]) + 1}", names)
    return counted.replace("_", " ")


def axis_name(label: str) -> str:
    """Return the label of an axis with stops and harmonics counted from 1, as on the page.

    Examples
    --------
    >>> axis_name("restitution $r$ of stop 1 (m/s)"), axis_name("time t")
    ('restitution $r$ of stop 2 (m/s)', 'time t')
    """
    return _NUMBERED.sub(lambda match: f"{match[1]} {int(match[2]) + 1}", label)


def name_axes(figure: Figure, study: Study) -> None:
    """Put the names of parameters on the axes of a picture, and the phase of its section."""
    begin = 0.0
    if isinstance(study.question, Diagram):
        begin = as_float(study.question.starts[0].t0)
    for ax in figure.axes:
        ax.set_xlabel(axis_name(ax.get_xlabel()))
        ax.set_ylabel(axis_name(ax.get_ylabel()))
        if begin != 0.0:
            at = f"at $t$ = {begin:.4g} + whole periods"
            ax.set_ylabel(ax.get_ylabel().replace("at whole periods", at))
