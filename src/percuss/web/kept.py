"""The last answers of long questions: files are made of what the page has computed already."""

from __future__ import annotations

import pickle
import threading
from collections import OrderedDict
from dataclasses import replace
from typing import Any

from percuss.execution import Execution
from percuss.motion.outcome import Outcome
from percuss.studies.study import Study
from percuss.studies.tables import Draw, Save
from percuss.web.handle import Handle
from percuss.web.question import BadQuestion

__all__ = ["KEPT", "Kept", "answer_of", "size_of"]

# How much is kept [bytes]: four of the largest answers, which have some fifty megabytes.
MOST_KEPT = 200_000_000
# A file may take so long to compute [s].
PATIENCE = 60.0


class Kept:
    """Answers by what was asked; of many those that were asked for last.

    Parameters
    ----------
    most
        How much is kept [bytes]; what alone is larger is not.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.studies import Limits, Motion
    >>> study = Study(pc.impact_oscillator(), None, Motion(pc.Start(1, 0), Limits(t_end=9)))
    >>> kept = Kept(1000)
    >>> kept.put(study, "an answer")
    >>> kept.get(replace(study, draw=Draw(svg=False)))
    'an answer'
    """

    def __init__(self, most: int = MOST_KEPT) -> None:
        self._most = most
        self._answers: OrderedDict[str, tuple[Any, int]] = OrderedDict()
        self._lock = threading.Lock()

    def put(self, study: Study, answer: Any) -> None:
        """Keep the answer of a study."""
        size = size_of(answer)
        if size > self._most:
            return
        with self._lock:
            self._answers.pop(_key(study), None)
            self._answers[_key(study)] = answer, size
            while sum(size for _, size in self._answers.values()) > self._most:
                self._answers.popitem(last=False)

    def get(self, study: Study) -> Any:
        """Return the answer of a study, whatever is saved and drawn of it; None if it is gone."""
        with self._lock:
            found = self._answers.get(_key(study))
            if found is None:
                return None
            self._answers.move_to_end(_key(study))
            return found[0]


def size_of(answer: Any) -> int:
    """Return how much memory an answer takes [bytes]: what it is pickled to, but for arrays.

    Examples
    --------
    >>> import numpy as np
    >>> 8_000_000 < size_of(np.zeros(1_000_000)) < 8_001_000
    True
    """
    apart: list[pickle.PickleBuffer] = []
    text = pickle.dumps(answer, protocol=5, buffer_callback=apart.append)
    return len(text) + sum(part.raw().nbytes for part in apart)


def _key(study: Study) -> str:
    return replace(study, title="", save=Save(), draw=Draw()).text()


# Of all clients: the answer to a question is the same for each.
KEPT = Kept()


def answer_of(study: Study, handle: Handle) -> Any:
    """Return the answer of a study: the one that is kept, or one computed in the time for files.

    Parameters
    ----------
    study
        What is asked.
    handle
        As in `percuss.web.jobs.answer_job`.

    Returns
    -------
    object
        As `percuss run` computes it.

    Raises
    ------
    BadQuestion
        If it takes longer than a minute, or nobody waits for it any more.
    """
    found = KEPT.get(study)
    if found is not None:
        return found
    part = handle.part(0.0, 1.0, PATIENCE)
    late = []

    def go_on(done: float, total: float) -> bool:
        if part(done, total):
            return True
        late.append(done < total)
        return False

    answer = study.question.answer(study, Execution(progress=go_on))
    if handle.is_stopped:
        raise BadQuestion("nobody waits for this file any more")
    if any(late) or getattr(answer, "outcome", None) is Outcome.interrupted:
        reason = f"this takes longer than {PATIENCE:g} s; take study.toml, for percuss run"
        raise BadQuestion(reason)
    return answer
