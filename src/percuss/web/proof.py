"""A motion proven in ball arithmetic, as far as the page can wait."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from percuss.motion.trajectory import Trajectory
from percuss.studies.proving import ProofOfStudy, check_certify, proof_of
from percuss.studies.study import Study
from percuss.studies.tables import Certify
from percuss.web.explore import followed
from percuss.web.frame import frame
from percuss.web.handle import Handle
from percuss.web.question import MOST_DIGITS, PageQuestion, digits_of, study_of

if TYPE_CHECKING:
    # Needs python-flint.
    from percuss.certified import CertifiedRun

__all__ = ["MOST_DIGITS", "answer_certify", "can_certify", "proof_in_time"]

# A proof may take so long [s]; what is proven by then is told.
PATIENCE = 10.0
# Impacts that are told in all their digits: the last ones.
SHOWN = 3
# Double precision is told to follow the motion while its impacts are so near [forcing periods].
NEAR = 1e-3


def can_certify() -> bool:
    """Return whether python-flint is there."""
    return find_spec("flint") is not None


def proof_in_time(study: Study, run: Trajectory, handle: Handle | None = None) -> ProofOfStudy:
    """Return what is proven of a run in a limited time.

    Parameters
    ----------
    study
        Its study, with the digits wanted.
    run
        The run.
    handle
        As in `percuss.web.jobs.answer_job`.

    Returns
    -------
    Proof
        Up to where it came.

    Raises
    ------
    MissingExtraError
        If python-flint is not there.
    """
    check_certify(study)
    return proof_of(study, run, (handle or Handle()).part(0.0, 1.0, PATIENCE))


def answer_certify(question: PageQuestion, handle: Handle) -> Iterator[bytes]:
    """Yield what is proven of a motion.

    Parameters
    ----------
    question
        With the option ``digits``.
    handle
        As in `percuss.web.jobs.answer_job`.

    Yields
    ------
    bytes
        One frame: `report`, lines of what is proven by their names; `until`, the time up to which
        it is (None: for ever); `lines`, the last impacts in all their digits; `followed`, how many
        of the impacts and until when double precision agrees.

    Raises
    ------
    PercussError, BadQuestion
        If there is no such motion.
    """
    digits = digits_of(question)
    study = replace(study_of(question.tables), certify=Certify(digits or 12))
    run = followed(study, handle).run
    proof = proof_in_time(study, run, handle)
    if handle.is_stopped:
        return
    proven: CertifiedRun = proof.result
    header = {
        "id": question.id,
        "kind": "certify",
        "done": True,
        "share": 1.0,
        "digits": proven.wanted_digits,
        "report": proof.report,
        "complete": proven.complete,
        "until": proven.t_end.mid(),
        "n_impacts": len(proven.impacts),
        "lines": _lines(proven),
        "followed": _followed(run, proven),
        "patience": PATIENCE,
    }
    yield frame(header)


def _lines(proven: CertifiedRun) -> list[list[str]]:
    """Return number, time and velocity of the last impacts, as decimals with their radii."""
    impacts, digits = proven.impacts, min(proven.wanted_digits + 3, 40)
    first = max(0, len(impacts) - SHOWN)
    return [
        [str(k + 1), impacts.t[k].text(digits), impacts.v_before[k].text(digits)]
        for k in range(first, len(impacts))
    ]


def _followed(run: Trajectory, proven: CertifiedRun) -> dict[str, object] | None:
    """Return how many of the proven impacts double precision has, too; None if there are none."""
    count = min(len(run.impacts), len(proven.impacts))
    if count == 0:
        return None
    period = None if run.forcing is None else run.forcing.period
    exact = proven.impacts.t.mid()
    near = np.abs(run.impacts.t[:count] - exact[:count]) < NEAR * (period or 1.0)
    first = int(np.argmin(near)) if not near.all() else count
    whole = bool(near.all()) and count == len(exact)
    return {"n": first, "t": float(exact[first - 1]) if first else run.t0, "whole": whole}
