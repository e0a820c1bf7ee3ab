"""The last answers of long questions: files are made of what the page has computed already."""

from __future__ import annotations

import threading
import time
from collections import OrderedDict
from dataclasses import replace
from typing import Any

from percuss.motion.outcome import Outcome
from percuss.studies.question import Means
from percuss.studies.study import Draw, Save, Study
from percuss.web.question import BadQuestion

__all__ = ["KEPT", "Kept", "answer_of"]

# How many answers are kept: the largest have some fifty megabytes.
MOST_KEPT = 4
# A file may take so long to compute [s].
PATIENCE = 60.0


class Kept:
    """Answers by what was asked; of many the newest.

    Parameters
    ----------
    most
        How many are kept.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.studies import Limits, Motion
    >>> study = Study(pc.impact_oscillator(), None, Motion(pc.Start(1, 0), Limits(t_end=9)))
    >>> kept = Kept(1)
    >>> kept.put(study, "an answer")
    >>> kept.get(replace(study, draw=Draw(svg=False)))
    'an answer'
    """

    def __init__(self, most: int = MOST_KEPT) -> None:
        self._most = most
        self._answers: OrderedDict[str, Any] = OrderedDict()
        self._lock = threading.Lock()

    def put(self, study: Study, answer: Any) -> None:
        """Keep the answer of a study."""
        with self._lock:
            self._answers[_key(study)] = answer
            self._answers.move_to_end(_key(study))
            while len(self._answers) > self._most:
                self._answers.popitem(last=False)

    def get(self, study: Study) -> Any:
        """Return the answer of a study, whatever is saved and drawn of it; None if it is gone."""
        with self._lock:
            return self._answers.get(_key(study))


def _key(study: Study) -> str:
    return replace(study, title="", save=Save(), draw=Draw()).text()


# Of all clients: the answer to a question is the same for each.
KEPT = Kept()


def answer_of(study: Study) -> Any:
    """Return the answer of a study: the one that is kept, or one computed in the time for files.

    Parameters
    ----------
    study
        What is asked.

    Returns
    -------
    object
        As `percuss run` computes it.

    Raises
    ------
    BadQuestion
        If it takes longer than a minute.
    """
    found = KEPT.get(study)
    if found is not None:
        return found
    end = time.monotonic() + PATIENCE
    late = []

    def go_on(done: float, total: float) -> bool:
        if time.monotonic() < end:
            return True
        late.append(done < total)
        return False

    answer = study.question.answer(study, Means(progress=go_on))
    if any(late) or getattr(answer, "outcome", None) is Outcome.interrupted:
        reason = f"this takes longer than {PATIENCE:g} s; take study.toml, for percuss run"
        raise BadQuestion(reason)
    return answer
