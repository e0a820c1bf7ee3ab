"""A cache of the last long answers: files are written from what the page has computed."""

from __future__ import annotations

import pickle
import threading
from collections import OrderedDict
from dataclasses import replace
from typing import Any

from percuss.execution import Execution
from percuss.motion.trajectory import Outcome
from percuss.studies.study import Study
from percuss.studies.tables import Draw, Save
from percuss.web.request import BadRequest, RunningRequest

# Size of the cache [bytes]: four of the largest answers, which have some fifty megabytes.
CACHE_BYTES = 200_000_000
# A file may take so long to compute [s].
PATIENCE = 60.0


class AnswerCache:
    """Answers by their studies; the least recently used are dropped first.

    Parameters
    ----------
    most
        Size of the cache [bytes]; an answer that is larger is not stored.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.studies import Limits, Motion
    >>> study = Study(pc.impact_oscillator(), None, Motion(pc.Start(1, 0), Limits(t_end=9)))
    >>> cache = AnswerCache(1000)
    >>> cache.put(study, "an answer")
    >>> cache.get(replace(study, draw=Draw(svg=False)))
    'an answer'
    """

    def __init__(self, most: int = CACHE_BYTES) -> None:
        self._most = most
        self._answers: OrderedDict[str, tuple[Any, int]] = OrderedDict()
        self._lock = threading.Lock()

    def put(self, study: Study, answer: Any) -> None:
        """Store the answer of a study."""
        size = size_of(answer)
        if size > self._most:
            return
        with self._lock:
            self._answers.pop(_key(study), None)
            self._answers[_key(study)] = answer, size
            while sum(size for _, size in self._answers.values()) > self._most:
                self._answers.popitem(last=False)

    def get(self, study: Study) -> Any:
        """Return the answer of a study, whatever it saves and draws; None if there is none."""
        with self._lock:
            entry = self._answers.get(_key(study))
            if entry is None:
                return None
            self._answers.move_to_end(_key(study))
            return entry[0]


def size_of(answer: Any) -> int:
    """Return the memory that an answer takes [bytes]: its pickle, and its arrays.

    Examples
    --------
    >>> import numpy as np
    >>> 8_000_000 < size_of(np.zeros(1_000_000)) < 8_001_000
    True
    """
    arrays: list[pickle.PickleBuffer] = []
    text = pickle.dumps(answer, protocol=5, buffer_callback=arrays.append)
    return len(text) + sum(array.raw().nbytes for array in arrays)


def _key(study: Study) -> str:
    return replace(study, title="", save=Save(), draw=Draw()).text()


# Shared by all clients: the answer of a study is the same for each.
ANSWERS = AnswerCache()


def answer_of(study: Study, running: RunningRequest) -> Any:
    """Return the answer of a study: from the cache, or computed in the time for files.

    Raises
    ------
    BadRequest
        If it takes longer than a minute, or nobody waits for it any more.
    """
    cached = ANSWERS.get(study)
    if cached is not None:
        return cached
    progress = running.progress(0.0, 1.0, PATIENCE)
    is_late = False

    def go_on(done: float, total: float) -> bool:
        nonlocal is_late
        wanted = progress(done, total)
        is_late = is_late or (not wanted and done < total)
        return wanted

    answer = study.question.answer(study, Execution(progress=go_on))
    if running.is_cancelled:
        raise BadRequest("nobody waits for this file any more")
    if is_late or getattr(answer, "outcome", None) is Outcome.interrupted:
        reason = f"this takes longer than {PATIENCE:g} s; take study.toml, for percuss run"
        raise BadRequest(reason)
    return answer
