"""Bifurcation diagrams: the points of the attractors over a parameter."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.datasets import attributes_of, coordinates_of
from percuss.ensembles.diagram_jobs import FAULTY, NOT_DONE, SECTIONS, Afresh, Followed
from percuss.ensembles.engines import Engine
from percuss.ensembles.grid import Grid, check_whole, make_grid
from percuss.ensembles.lanes import MOST_IMPACTS, Plan, reason_of
from percuss.ensembles.measures import Window
from percuss.ensembles.running import Answer, Report, keep, run_job, unanswered
from percuss.ensembles.store import Store, has_store
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
        in the order in which they are followed forward.
    section
        "stroboscopic": (x, v) once a forcing period; "impacts": (cycle, v_after) at impacts and
        at entries into soft stops.
    starts
        Starts, each a `Start` or x0, v0. The first is where the followed branches begin.
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
        and `stop`; NaN where there are fewer impacts. Over (branch, path): `period`, after how
        many forcing periods the motion repeats itself (0: none up to half of those followed), and
        `reason`, why there is nothing.

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
    grids = [make_grid(osc, force, start, over, VALUES) for start in starts]
    _check(grids, force, section, follow, points)
    window = Window(transient, points - 1)
    if store is not None and has_store(Path(store)):
        raise OutputError(store, "holds another study, no diagram; choose another name")
    followed = Followed(grids[0], tuple(follow), section, window)
    afresh = Afresh(tuple(grids), section, window)
    parts = [(job, name) for job, name in ((followed, "followed"), (afresh, "afresh")) if job.size]
    if store is not None:
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
    return keep(_dataset(grids[0], names, section, answers), store)


def _check(
    grids: list[Grid], force: Forcing | None, section: str, follow: Sequence[str], points: int
) -> None:
    if not grids:
        raise ParameterError("starts", (), "none at all; give (x0, v0)")
    if len(grids[0].axes) != 1 or grids[0].axes[0].of_start:
        given = [axis.path for axis in grids[0].axes]
        raise ParameterError("over", given, "a diagram has one axis, a parameter of the motion")
    if section not in SECTIONS:
        raise ParameterError("section", section, f"neither {' nor '.join(SECTIONS)}")
    for name in follow:
        if name not in ("forward", "backward"):
            raise ParameterError("follow", name, "neither forward nor backward")
    check_whole("points", points, 2)
    if force is None or force.period is None:
        raise ParameterError("forcing.period", None, "a diagram needs a periodic forcing")


def _dataset(grid: Grid, names: list[str], section: str, answers: list[Answer]) -> Dataset:
    import xarray

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
    data["reason"] = (("branch", path), _reasons(grid, parts["status"]))
    complete = all(answer.complete for answer in answers)
    total = sum(answer.n_impacts for answer in answers)
    return xarray.Dataset(
        data,
        coords=coordinates_of(grid) | {"branch": names},
        attrs=attributes_of(grid, Answer({}, {}, total, complete)) | {"section": section},
    )


def _reasons(grid: Grid, status: NDArray[np.generic]) -> NDArray[np.object_]:
    found = np.full(status.shape, "", dtype=object)
    still = np.zeros(1)
    for branch, k in zip(*np.nonzero(status != 0), strict=True):
        code = int(status[branch, k])
        reason = reason_of(code, Plan(still, still, still, max_impacts=MOST_IMPACTS))
        if code == FAULTY:
            _, faults = grid.lanes(int(k), int(k) + 1)
            reason = faults.get(0, "the branch does not begin outside the walls")
        elif code == NOT_DONE:
            reason = "not done yet"
        found[branch, k] = reason or ""
    return found
