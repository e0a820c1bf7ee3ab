"""Bifurcation diagrams: the points of the attractors over a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.checks import check_means
from percuss.ensembles.datasets import attributes_of, coordinates_of, motion_of
from percuss.ensembles.diagram_jobs import (
    FAULTY,
    NOT_DONE,
    SECTIONS,
    Afresh,
    Followed,
    failed_values,
)
from percuss.ensembles.engines import Engine, make_ready
from percuss.ensembles.failures import warn_of_failures, warn_of_some
from percuss.ensembles.grid import Grid, make_grid, whole
from percuss.ensembles.job import Answer, check_room
from percuss.ensembles.lanes import MOST_IMPACTS, Plan, reason_of
from percuss.ensembles.measures import Window
from percuss.ensembles.running import Report, keep, run_job, unanswered
from percuss.ensembles.sizes import too_large
from percuss.ensembles.store import (
    Store,
    has_store,
    is_vacant,
    make_folder,
    own_attributes,
    told,
)
from percuss.errors import OutputError, ParameterError
from percuss.model.exact import Phase
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

__all__ = ["bifurcation_diagram"]

Floats = NDArray[np.float64]
Section = Literal["stroboscopic", "impacts"]
Direction = Literal["forward", "backward"]
# Values that a range (low, high) of the parameter stands for.
VALUES = 401


def bifurcation_diagram(
    osc: Oscillator,
    force: Forcing | None,
    *,
    over: Mapping[str, object],
    section: Section = "stroboscopic",
    starts: Sequence[Start | Sequence[Phase]] = ((0.0, 0.0),),
    follow: Sequence[Direction] = ("forward", "backward"),
    transient: int = 200,
    points: int = 64,
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
) -> Dataset:
    """Return the points of the attractors over a parameter.

    A branch is *followed* when each value of the parameter begins where the motion at the value
    before ended, at the same cycle: forward and backward then show which attractors coexist
    (hysteresis). Besides, every value begins afresh from each of the starts.

    Parameters
    ----------
    osc, force
        What moves; the forcing has a period.
    over
        One path, and a range (low, high) that is taken in 401 values, or the values themselves,
        in the order in which they are followed forward. A path of the start takes ``follow=()``.
    section
        "stroboscopic": (x, v) once a forcing period; "impacts": (cycle, v_after) at impacts and
        at entries into soft stops.
    starts
        Starts, each a `Start` or x0, v0. The first is where the followed branches begin; at
        values where it lies beyond a wall they have nothing until they have begun.
    follow
        Any of "forward" and "backward".
    transient
        Forcing periods that are left out at each value.
    points
        Points kept at each value, >= 2: forcing periods that are followed; of impacts the last.
    store, engine, n_workers, progress
        As in `sweep`. A followed branch is one piece of work.

    Returns
    -------
    xarray.Dataset
        Over (branch, path, sample): `x` [length] and `v` [length/time], or `cycle`, `v_after`
        and `bound`, the stop; NaN where there are fewer impacts. Stops are counted upwards along
        x, from 0 where the lowest is a wall below, else from 1. Over (branch, path): `period`,
        after how many forcing periods the motion repeats itself (0: none up to half of those
        followed, -1: there is no motion), and `reason`, why there is none. The attribute `failed`
        counts those without.

    Warns
    -----
    UserWarning
        If a branch has nothing at any value, or at some: with their number, the first of them, and
        the commonest reason and its count.

    Raises
    ------
    ParameterError
        If there is no such path, or an axis is empty or not finite.

    Examples
    --------
    Period doubling at omega = 2.6533 (Budd & Dux 1994, in closed form):

    >>> import percuss as pc
    >>> found = pc.bifurcation_diagram(
    ...     pc.impact_oscillator(restitution=0.8), pc.cosine(2.5),
    ...     over={"forcing.omega": [2.64, 2.67]}, starts=[(0.0, 1.0)], follow=["forward"],
    ... )
    >>> found.period.sel(branch="forward").values
    array([1, 2])
    """
    check_means(store, engine, n_workers, progress)
    _check_lists(starts, follow)
    grids = [make_grid(osc, force, start, over, VALUES) for start in starts]
    _check(grids, force, section, follow, points)
    window = Window(transient, points - 1)
    if store is not None and has_store(Path(store)):
        with told(Path(store)):
            own_attributes(Path(store))
        raise OutputError(store, "holds another study, no diagram; choose another name")
    followed = Followed(grids[0], tuple(follow), section, window)
    afresh = Afresh(tuple(grids), section, window)
    parts = [(job, name) for job, name in ((followed, "followed"), (afresh, "afresh")) if job.size]
    for job, _ in parts:
        # Whether it is too large, before any of it is written.
        check_room(job)
    if store is not None:
        is_new = not any(has_store(Path(store) / name) for _, name in parts)
        if is_new and not is_vacant(Path(store), [name for _, name in parts]):
            reason = "exists and is no store of percuss; it is left as it is; choose another name"
            raise OutputError(store, reason)
        make_ready(parts[0][0], engine, is_new=is_new)
        make_folder(Path(store))
        # Both at once: how much there is to do is known from the beginning.
        for job, name in parts:
            Store(Path(store) / name, job)
    answers: list[Answer] = []
    for job, name in parts:
        folder = None if store is None else Path(store) / name
        if any(not answer.complete for answer in answers):
            # Whoever has stopped one part wants no other.
            answers.append(unanswered(job))
        else:
            answers.append(run_job(job, folder, engine, n_workers, progress))
    names = [*follow, *(f"start {i}" for i in range(len(grids)))]
    # Followed branches begin at the first start.
    of_branches = [*(grids[0] for _ in follow), *grids]
    found = _dataset(of_branches, names, section, answers)
    _tell(found)
    return keep(found, store)


def _tell(found: Dataset) -> None:
    """Warn of branches that have nothing anywhere, and of values where a branch has nothing."""
    reasons = found["reason"].values
    empty = (reasons != "").all(axis=1)
    if not found.attrs["complete"]:
        return
    branches, values = np.nonzero((reasons != "") & ~empty[:, np.newaxis])
    if len(values):
        path = str(found["reason"].dims[1])
        first = f"{path} = {found[path].values[values[0]]} of {found['branch'].values[branches[0]]}"
        warn_of_some("values", reasons[branches, values], reasons.size, first, stacklevel=4)
    if empty.any():
        those = " and ".join(str(name) for name in found["branch"].values[empty])
        what = f"{those}: no points at any of {reasons.shape[1]:,} values"
        warn_of_failures(what, reasons[empty].ravel().tolist(), stacklevel=4)


def _check_lists(starts: object, follow: object) -> None:
    """See to it that what should be lists are lists."""
    is_list = hasattr(starts, "__iter__") and not isinstance(starts, str)
    if not is_list or not all(isinstance(it, Start) or hasattr(it, "__iter__") for it in starts):  # type: ignore[attr-defined]  # just seen
        raise ParameterError("starts", starts, "not a list of starts, such as [(0.0, 1.0)]")
    if isinstance(follow, str) or not hasattr(follow, "__iter__"):
        raise ParameterError("follow", follow, 'not a list, such as ["forward"]')
    names = list(follow)
    if len(set(names)) < len(names):
        raise ParameterError("follow", names, "the same twice")


def _check(
    grids: list[Grid], force: Forcing | None, section: str, follow: Sequence[str], points: int
) -> None:
    if not grids:
        raise ParameterError("starts", (), "none at all; give (x0, v0)")
    given = [axis.path for axis in grids[0].axes]
    if len(given) != 1:
        raise ParameterError("over", given, "a diagram has one axis, a parameter")
    if grids[0].axes[0].of_start and follow:
        reason = (
            "a diagram has one axis, of the motion; followed branches have no start, give follow=()"
        )
        raise ParameterError("over", given, reason)
    if section not in SECTIONS:
        raise ParameterError("section", section, f"neither {' nor '.join(SECTIONS)}")
    for name in follow:
        if name not in ("forward", "backward"):
            raise ParameterError("follow", name, "neither forward nor backward")
    points = whole("points", points, 2)
    problem = too_large([len(grids) + len(follow), grids[0].size], 3 * points)
    if problem is not None:
        raise ParameterError("points", points, f"{points:,} at each of {problem}")
    if force is None or force.period is None:
        raise ParameterError("forcing.period", None, "a diagram needs a periodic forcing")


def _dataset(grids: list[Grid], names: list[str], section: str, answers: list[Answer]) -> Dataset:
    import xarray

    grid = grids[0]
    n = grid.size
    parts = {
        name: np.concatenate(
            [
                a.arrays[name].reshape(-1, n, *a.arrays[name].shape[a.arrays["period"].ndim :])
                for a in answers
            ]
        )
        for name in ("points", "period", "status")
    }
    path = grid.axes[0].path
    sampled = ("branch", path, "sample")
    if section == "stroboscopic":
        data: dict[str, Any] = {
            "x": (sampled, parts["points"][..., 0], {"units": "length"}),
            "v": (sampled, parts["points"][..., 1], {"units": "length/time"}),
        }
    else:
        data = {
            "cycle": (sampled, parts["points"][..., 0], {"units": "1"}),
            "v_after": (sampled, parts["points"][..., 1], {"units": "length/time"}),
            "bound": (sampled, parts["points"][..., 2], {"units": "1"}),
        }
    data["period"] = (("branch", path), parts["period"], {"units": "1"})
    data["reason"] = (("branch", path), _reasons(grids, parts["status"]))
    complete = all(answer.complete for answer in answers)
    total = sum(answer.n_impacts for answer in answers)
    return xarray.Dataset(
        data,
        coords=coordinates_of(grid.dimensions) | {"branch": names},
        attrs=attributes_of(motion_of(grid), Answer({}, {}, total, complete))
        | {"section": section, "failed": failed_values(parts)},
    )


def _reasons(grids: list[Grid], status: NDArray[np.generic]) -> NDArray[np.object_]:
    found = np.full(status.shape, "", dtype=object)
    still = np.zeros(1)
    for branch, k in zip(*np.nonzero(status != 0), strict=True):
        code = int(status[branch, k])
        reason = reason_of(code, Plan(still, still, still, max_impacts=MOST_IMPACTS))
        if code == FAULTY:
            _, faults = grids[branch].lanes(int(k), int(k) + 1)
            reason = faults.get(0, "the branch does not begin outside the walls")
        elif code == NOT_DONE:
            reason = "not done yet"
        found[branch, k] = reason or ""
    return found
