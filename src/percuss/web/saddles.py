"""Saddle orbits and their stable manifolds, which separate the basins."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from percuss.arrays import Floats
from percuss.errors import PercussError
from percuss.model.exact import as_float
from percuss.orbits import Manifolds, PeriodicOrbit, find_orbits, manifolds
from percuss.web.frame import frame
from percuss.web.request import BadRequest, PageRequest, RunningRequest, motion_of, study_of

# Most impacts and forcing periods of the saddles: as `percuss run` draws them.
SADDLE_LIMIT = 2
# Manifolds may take so long to grow [s].
PATIENCE = 20.0
# Share of the work that is the search.
SEARCH_SHARE = 0.2


def answer_saddles(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield the saddle orbits and their stable manifolds, one after another.

    Parameters
    ----------
    request
        With a study; the time of its start is the instant of the section.
    running
        State of the answer.

    Yields
    ------
    bytes
        A frame for each saddle: its counts and multipliers, arrays ``x``, ``v`` of its points, and
        ``curve_x``, ``curve_v`` of its stable manifold, NaN between its pieces. The last one has
        none of these, but ``done``, and in `late` whether the time was up.

    Raises
    ------
    PercussError, BadRequest
        If there is no answer.
    """
    study = study_of(request.tables)
    force = study.forcing
    if force is None or force.period is None:
        raise BadRequest("basins need a periodic forcing")
    end = running.seconds() + PATIENCE
    cycle = (as_float(motion_of(study).start.t0) / force.period) % 1.0
    header: dict[str, object] = {"id": request.id, "kind": "saddles"}
    orbits = find_orbits(study.oscillator, force, SADDLE_LIMIT, SADDLE_LIMIT)
    saddles = [orbit for orbit in orbits if _is_saddle(orbit)]
    late = False
    for k, orbit in enumerate(saddles):
        begin, share = (SEARCH_SHARE + (1 - SEARCH_SHARE) * i / len(saddles) for i in (k, k + 1))
        progress = running.progress(begin, share, end - running.seconds())
        try:
            stable = manifolds(orbit, cycle=cycle, kinds=("stable",), progress=progress)
            arrays, reason = _columns(stable), ""
        except PercussError as error:
            # The basins are shown without this manifold.
            arrays, reason = {}, str(error)
        late = running.seconds() >= end
        if running.is_cancelled:
            return
        state = {"done": False, "share": share, "reason": reason}
        yield frame(header | state | _orbit_header(orbit), arrays)
        if late:
            break
    yield frame({**header, "done": True, "share": 1.0, "n_saddles": len(saddles), "late": late})


def _is_saddle(orbit: PeriodicOrbit) -> bool:
    inside, outside = sorted(abs(orbit.multipliers))
    return bool(0.0 < inside < 1.0 < outside)


def _orbit_header(orbit: PeriodicOrbit) -> dict[str, object]:
    return {
        "n_impacts": orbit.n_impacts,
        "n_periods": orbit.n_periods,
        "multipliers": orbit.multipliers.real.tolist(),
    }


def _columns(curves: Manifolds) -> dict[str, Floats]:
    """Return the points of a saddle and its stable manifold."""
    gap = np.full((1, 2), np.nan)
    pieces = [part for branch in curves.stable for piece in branch.pieces for part in (piece, gap)]
    curve = np.concatenate(pieces) if pieces else gap
    return {
        "x": curves.saddles[:, 0],
        "v": curves.saddles[:, 1],
        "curve_x": curve[:, 0],
        "curve_v": curve[:, 1],
    }
