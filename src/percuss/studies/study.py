"""A study: one question to percuss, as a frozen value."""

from __future__ import annotations

from dataclasses import dataclass

from percuss.io.study_text import model_tables, toml_text
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.studies.model_tables import EngineersModel
from percuss.studies.question import Question
from percuss.studies.tables import DRAW_ALL, SAVE_ALL, Certify, Draw, Save, as_written

__all__ = ["Certify", "Draw", "EngineersModel", "Save", "Study", "study_text"]


@dataclass(frozen=True, slots=True)
class Study:
    """A model, what is asked about it, and what to keep of the answer.

    Parameters
    ----------
    oscillator, forcing
        What is moving, under what force (None: free).
    question
        What is asked: a value of `percuss.studies.kinds`, such as `Motion`.
    title
        A line about it.
    save, draw
        Files and pictures.
    given
        The model in the engineers' units of the study file, if it names a mass; `oscillator` and
        `forcing` are then those of unit mass that follow from it.
    certify
        To how many digits the answer is proven, of a motion, an orbit or a branch; None: not.

    Examples
    --------
    >>> from percuss.model import Start, impact_oscillator, sine
    >>> from percuss.studies import Limits, Motion
    >>> study = Study(impact_oscillator(), sine(3), Motion(Start(0, "0.51"), Limits(periods=10)))
    >>> study.kind
    'motion'
    """

    oscillator: Oscillator
    forcing: Forcing | None
    question: Question
    title: str = ""
    save: Save = SAVE_ALL
    draw: Draw = DRAW_ALL
    given: EngineersModel | None = None
    certify: Certify | None = None

    @property
    def kind(self) -> str:
        """The kind of question."""
        return self.question.kind

    def text(self) -> str:
        """Return the study as TOML text, in which `parse_study` finds the same numbers."""
        return study_text(self)


def study_text(study: Study) -> str:
    """Return a study as TOML text, with every number exactly as it was given.

    Parameters
    ----------
    study
        The study.

    Returns
    -------
    str
        The text of a study file.
    """
    engineers = {} if study.given is None else study.given.tables()
    certify = {} if study.certify is None else {"certify": as_written(study.certify)}
    return toml_text(
        {
            "study": {"kind": study.kind, "title": study.title},
            **model_tables(study.oscillator, study.forcing),
            **engineers,
            **study.question.tables(),
            **certify,
            "save": as_written(study.save),
            "draw": as_written(study.draw),
        }
    )
