"""Saddle orbits and their stable manifolds, which part the basins."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.model.exact import as_float
from percuss.orbits import Manifolds, PeriodicOrbit, find_orbits, manifolds
from percuss.web.frame import frame
from percuss.web.handle import Handle
from percuss.web.question import BadQuestion, PageQuestion, motion_of, study_of

__all__ = ["MOST_ROUNDS", "answer_saddles"]


# Impacts and forcing periods of a round of the saddles: those that `percuss run` draws, too.
MOST_ROUNDS = 2
# Manifolds may take so long to grow [s].
PATIENCE = 20.0
# The part of the work that is the search.
SEARCH = 0.2


def answer_saddles(question: PageQuestion, handle: Handle) -> Iterator[bytes]:
    """Yield the saddle orbits and their stable manifolds, one after another.

    Parameters
    ----------
    question
        With a study, whose start tells the instant of the section.
    handle
        As in `percuss.web.jobs.answer_job`.

    Yields
    ------
    bytes
        A frame for each saddle: its counts and multipliers, arrays ``x``, ``v`` of its points, and
        ``curve_x``, ``curve_v`` of its stable manifold, NaN between its pieces. The last one has
        none of these, but ``done``, and in `late` whether the time was up.

    Raises
    ------
    PercussError, BadQuestion
        If there is no answer.
    """
    study = study_of(question.tables)
    force = study.forcing
    if force is None or force.period is None:
        raise BadQuestion("basins need a periodic forcing")
    end = handle.seconds() + PATIENCE
    cycle = (as_float(motion_of(study).start.t0) / force.period) % 1.0
    header = {"id": question.id, "kind": "saddles"}
    found = find_orbits(study.oscillator, force, MOST_ROUNDS, MOST_ROUNDS)
    saddles = [orbit for orbit in found if _is_saddle(orbit)]
    late = False
    for k, orbit in enumerate(saddles):
        share = [SEARCH + (1.0 - SEARCH) * i / len(saddles) for i in (k, k + 1)]
        told = handle.part(*share)

        def go_on(done: float, total: float, told: object = told) -> bool:
            assert callable(told)
            return bool(told(done, total)) and handle.seconds() < end

        try:
            grown = manifolds(orbit, cycle=cycle, kinds=("stable",), progress=go_on)
            arrays, reason = _columns(grown), ""
        except PercussError as error:
            # The basins are worth a look without it.
            arrays, reason = {}, str(error)
        late = handle.seconds() >= end
        if handle.is_stopped:
            return
        yield frame(
            {**header, "done": False, "share": share[1], "reason": reason, **_told(orbit)}, arrays
        )
        if late:
            break
    yield frame({**header, "done": True, "share": 1.0, "n_saddles": len(saddles), "late": late})


def _is_saddle(orbit: PeriodicOrbit) -> bool:
    inside, outside = sorted(abs(orbit.multipliers))
    return bool(0.0 < inside < 1.0 < outside)


def _told(orbit: PeriodicOrbit) -> dict[str, object]:
    return {
        "n_impacts": orbit.n_impacts,
        "n_periods": orbit.n_periods,
        "multipliers": orbit.multipliers.real.tolist(),
    }


def _columns(grown: Manifolds) -> dict[str, Floats]:
    """Return the points of a saddle and its stable manifold."""
    gap = np.full((1, 2), np.nan)
    pieces = [part for branch in grown.stable for piece in branch.pieces for part in (piece, gap)]
    curve = np.concatenate(pieces) if pieces else gap
    return {
        "x": grown.saddles[:, 0],
        "v": grown.saddles[:, 1],
        "curve_x": curve[:, 0],
        "curve_v": curve[:, 1],
    }
