"""A motion, chaos, all orbits or basins, proven in ball arithmetic while the page waits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from percuss.errors import ParameterError
from percuss.motion.trajectory import Trajectory
from percuss.studies.proving import (
    ProofOfStudy,
    basins_of,
    basins_rows,
    chaos_of,
    chaos_rows,
    check_certify,
    list_of,
    list_rows,
    proof_of,
)
from percuss.studies.study import Study
from percuss.studies.tables import Certify
from percuss.web.explore import followed
from percuss.web.frame import frame
from percuss.web.request import (
    PageRequest,
    RunningRequest,
    digits_of,
    motion_of,
    range_of,
    study_of,
)

if TYPE_CHECKING:
    # Needs python-flint.
    from percuss.certified import CertifiedRun

# A proof may take so long [s]; what is proven by then is shown.
PATIENCE = 10.0
# Cells along a side of the square of starts of which basins are proven.
CELLS = 60
# Number of impacts that are shown in all their digits: the last ones.
SHOWN = 3
# Double precision follows the motion while its impacts are so near the proven [forcing periods].
NEAR = 1e-3


def can_certify() -> bool:
    """Return whether python-flint is there."""
    return find_spec("flint") is not None


def proof_in_time(
    study: Study, run: Trajectory, running: RunningRequest | None = None
) -> ProofOfStudy:
    """Return what can be proven of the run of a study in a limited time.

    Raises
    ------
    MissingExtraError
        If python-flint is not there.
    """
    check_certify(study)
    return proof_of(study, run, (running or RunningRequest()).progress(0.0, 1.0, PATIENCE))


def answer_certify(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield what is proven of a motion, or of chaos, all orbits or basins of its system.

    Parameters
    ----------
    request
        With the option ``of``, "run", "chaos", "orbits" or "basins"; for a run ``digits``, for
        basins ``x_low``, ``x_high``, ``v_low`` and ``v_high``.
    running
        State of the answer.

    Yields
    ------
    bytes
        One frame: `report`, lines of what is proven by their names; `until`, the time up to which
        it is (None: for ever); `lines`, the last impacts in all their digits; `followed`, how many
        of the impacts and until when double precision agrees. Of all else `report`, `complete` and
        `some`: whether all or some of what was asked for is proven.

    Raises
    ------
    PercussError, BadRequest
        If there is no such motion.
    """
    of = request.choice("of", ("run", "chaos", "orbits", "basins"))
    if of != "run":
        yield from _answer_of_system(of, request, running)
        return
    digits = digits_of(request)
    study = replace(study_of(request.tables), certify=Certify(digits or 12))
    run = followed(study, running).run
    proof = proof_in_time(study, run, running)
    if running.is_cancelled:
        return
    proven: CertifiedRun = proof.result
    header = {
        "id": request.id,
        "kind": "certify",
        "of": "run",
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


def _answer_of_system(of: str, request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    study, progress = study_of(request.tables), running.progress(0.0, 1.0, PATIENCE)
    try:
        if of == "chaos":
            chaos = chaos_of(study, progress)
            report, is_complete, is_some = chaos_rows(chaos), bool(chaos), bool(chaos)
        elif of == "orbits":
            proven_list = list_of(study, 1, 1, progress=progress)
            report, is_complete, is_some = (
                list_rows(proven_list),
                proven_list.complete,
                proven_list.complete,
            )
        else:
            ends = (
                range_of(request, *(f"{name}_{end}" for end in ("low", "high"))) for name in "xv"
            )
            begin = motion_of(study).start.t0
            proven = basins_of(
                study, *ends, t0=begin, cells=(CELLS, CELLS), depth=0, progress=progress
            )
            report, is_complete = basins_rows(proven), proven.open_area == 0.0
            is_some = bool((proven.labels >= 0).any())
    except ParameterError as error:
        report = {"certified": f"nothing: {error.reason.partition(';')[0]}"}
        is_complete = is_some = False
    if running.is_cancelled:
        return
    header = {"id": request.id, "kind": "certify", "of": of, "done": True, "share": 1.0}
    yield frame(header | {"report": report, "complete": is_complete, "some": is_some})


def _lines(proven: CertifiedRun) -> list[list[str]]:
    """Return number, time and velocity of the last impacts, as decimals with their radii."""
    impacts, digits = proven.impacts, min(proven.wanted_digits + 3, 40)
    first = max(0, len(impacts) - SHOWN)
    return [
        [str(k + 1), impacts.t[k].text(digits), impacts.v_before[k].text(digits)]
        for k in range(first, len(impacts))
    ]


def _followed(run: Trajectory, proven: CertifiedRun) -> dict[str, object] | None:
    """Return how many of the proven impacts double precision follows; None if there are none."""
    count = min(len(run.impacts), len(proven.impacts))
    if count == 0:
        return None
    period = None if run.forcing is None else run.forcing.period
    exact = proven.impacts.t.mid()
    near = np.abs(run.impacts.t[:count] - exact[:count]) < NEAR * (period or 1.0)
    first = int(np.argmin(near)) if not near.all() else count
    whole = bool(near.all()) and count == len(exact)
    return {"n": first, "t": float(exact[first - 1]) if first else run.t0, "whole": whole}
