"""The state of a store, and the data in it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.arrays import Floats, Integers
from percuss.ensembles.basins import no_starts
from percuss.ensembles.datasets import attributes_of, dataset_of
from percuss.ensembles.diagram import failed_values
from percuss.ensembles.job import Answer, Dimension
from percuss.ensembles.store import (
    RESULT,
    Chunks,
    described,
    own_attributes,
    store_faults,
    stored_chunks,
    stores_of_study,
)
from percuss.errors import OutputError
from percuss.execution import folder_of

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

# An interval between two chunks is a pause if it exceeds a minute and so many median intervals.
PAUSE, USUAL = 60.0, 20.0
# The rate is that of the last so many chunks.
RECENT = 200


def status_of_store(path: str | Path) -> dict[str, Any]:
    """Return the study of a store and how much of it is done.

    Parameters
    ----------
    path
        The folder.

    Returns
    -------
    dict
        ``study`` (a description), ``version``, ``points``, ``points_done``,
        ``chunks``, ``done``, ``n_impacts``; ``impacts_per_second`` and ``seconds_left`` at the
        rate of the last chunks without pauses, None where too few are done; and
        ``seconds_since``, the time since the last chunk was finished, None where none is.
        ``running`` is False if the store is complete, or if the last chunk is long ago compared
        with the usual interval; None if too few are done. A killed process leaves no marker.

    Raises
    ------
    OutputError
        If there is no store, there are several, or it is damaged.

    Examples
    --------
    >>> import tempfile, percuss as pc
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     data = pc.sweep("period", pc.impact_oscillator(0.8), pc.cosine(2.5),
    ...                     over={"start.v0": [1.0, 2.0]}, store=f"{folder}/run.zarr")
    ...     status = pc.status_of_store(f"{folder}/run.zarr")
    >>> status["points_done"], status["points"], status["seconds_left"]
    (2, 2, 0.0)
    """
    parts = [_status_of_part(part) for part in _parts(folder_of(path))]
    total: dict[str, Any] = {"study": parts[0]["study"], "version": parts[0]["version"]}
    for name in ("points", "points_done", "chunks", "done", "n_impacts"):
        total[name] = sum(part[name] for part in parts)
    rates = [part["points_per_second"] for part in parts if part["points_per_second"]]
    left = total["points"] - total["points_done"]
    impacts = [part["impacts_per_second"] for part in parts if part["impacts_per_second"]]
    total["impacts_per_second"] = impacts[-1] if impacts else None
    total["seconds_left"] = 0.0 if left == 0 else left / rates[-1] if rates else None
    ages = [part["seconds_since"] for part in parts if part["seconds_since"] is not None]
    total["seconds_since"] = since = min(ages) if ages else None
    pauses = [part["pause"] for part in parts if part["pause"] is not None]
    total["running"] = None
    if left == 0:
        total["running"] = False
    elif pauses and since is not None:
        total["running"] = bool(since <= max(pauses))
    return total


def stores_in(path: str | Path) -> list[Path]:
    """Return the stores that a folder is or holds, one for each study.

    Raises
    ------
    OutputError
        If there is none.
    """
    folder = Path(path)
    if stores_of_study(folder):
        return [folder]
    inside = (inner for inner in sorted(folder.glob("*")) if not _is_foreign(inner))
    stores = [inner for inner in inside if stores_of_study(inner)]
    if not stores:
        of_fit = "a file and no store; if a fit keeps its search there, percuss run goes on with it"
        raise OutputError(path, of_fit if folder.is_file() else "no store there")
    return stores


def load_store(path: str | Path) -> Dataset:
    """Return what a store holds as a dataset, finished or not.

    Parameters
    ----------
    path
        The folder.

    Returns
    -------
    xarray.Dataset
        The result of the call, and of an unfinished sweep its result so far. Of other unfinished
        studies the stored columns over the axes of the study, NaN and -1 where a chunk is missing,
        with the attribute ``complete`` at 0; basins are not numbered yet.

    Raises
    ------
    OutputError
        If there is no store, or it is damaged.
    """
    import xarray

    where = folder_of(path)
    parts = _parts(where)
    with store_faults(where):
        if all(_is_complete(part) for part in parts) and (where / RESULT).exists():
            try:
                with xarray.open_dataset(where / RESULT, engine="h5netcdf") as result:
                    if "percuss" in result.attrs:
                        return result.load()
            except (OSError, ValueError, RuntimeError, KeyError) as error:
                reason = f"its {RESULT} is damaged; remove that file, and the same call writes it"
                raise OutputError(path, reason) from error
        loaded = [_load_part(part) for part in parts]
        if len(loaded) == 1:
            return loaded[0]
        return xarray.concat(loaded, "branch", combine_attrs="drop_conflicts")


def _parts(path: Path) -> list[Path]:
    """Return the stores of one study in a folder."""
    parts = stores_of_study(path)
    if not parts:
        several = [store.name for store in stores_in(path)]
        raise OutputError(path, f"no store, but holds {', '.join(several)}; name one of them")
    return parts


def _is_foreign(path: Path) -> bool:
    """Return whether a folder is Zarr data of another program, or an array without its store."""
    try:
        return described(path) is None
    except (OSError, ValueError):
        return False


def _is_complete(path: Path) -> bool:
    chunks = stored_chunks(path, own_attributes(path))
    marks = chunks.marks()[:, 0].tolist()
    return all(mark > 0 and chunks.seems_whole(i) for i, mark in enumerate(marks))


def _status_of_part(path: Path) -> dict[str, Any]:
    with store_faults(path):
        own = own_attributes(path)
        # A store whose making was interrupted has neither marks nor arrays.
        marks = Chunks(path, {}, own["size"], min(own["chunk"], own["size"])).marks()
        done = np.flatnonzero(marks[:, 0])
        if len(done):
            # By the lengths of their files: reading every byte would take long.
            chunks = stored_chunks(path, own)
            done = np.array([i for i in done.tolist() if chunks.seems_whole(i)], dtype=np.int64)
    each = own["motions_of_a_point"]
    sizes = np.full(len(marks), own["chunk"] * each)
    sizes[-1] = (own["size"] - own["chunk"] * (len(marks) - 1)) * each
    part = own.get("part_of", {"number": 1, "count": 1})
    own_sizes = sizes[part["number"] - 1 :: part["count"]]
    times = marks[done, 1] / 1e6
    points, impacts = rates_of(times, sizes[done], marks[done, 0] - 1)
    return {
        "study": own["study"],
        "version": own["version"],
        "points": int(own_sizes.sum()),
        "points_done": int(sizes[done].sum()),
        "chunks": len(own_sizes),
        "done": len(done),
        "n_impacts": int((marks[done, 0] - 1).sum()),
        "points_per_second": points,
        "impacts_per_second": impacts,
        "pause": _pause(np.diff(np.sort(times)[-RECENT:])) if len(times) > 1 else None,
        "seconds_since": max(0.0, time.time() - times.max()) if len(times) else None,
    }


def rates_of(
    times: Floats, points: Integers, impacts: Integers
) -> tuple[float | None, float | None]:
    """Return the rates of points and impacts [1/s] from the times at which chunks were finished."""
    order = np.argsort(times)[-RECENT:]
    steps = np.diff(times[order])
    if len(steps) == 0:
        return None, None
    working = steps <= _pause(steps)
    took = float(steps[working].sum())
    if took <= 0.0:
        return None, None
    ends = order[1:][working]
    return float(points[ends].sum() / took), float(impacts[ends].sum() / took)


def _pause(steps: Floats) -> float:
    """Return the interval between two chunks from which on it is a pause [s]."""
    return max(PAUSE, USUAL * float(np.median(steps)))


def _load_part(path: Path) -> Dataset:
    own = own_attributes(path)
    dimensions = map(Dimension.of_description, own["dimensions"])
    chunks = stored_chunks(path, own)
    answer, columns = chunks.answer(), chunks.columns
    study = own["study"]
    is_sweep = study["kind"] == "sweep"
    names = ("oscillator", "forcing", "start") if is_sweep else study.keys() - {"over"}
    words = {name: str(value) for name, value in study.items() if name in names}
    about = attributes_of(words, answer, own["version"])
    about |= {} if is_sweep else {"failed": _failed(answer)}
    return dataset_of(dimensions, columns, answer, about, with_reasons=is_sweep)


def _failed(answer: Answer) -> int:
    """Return the number of motions of a diagram, or starts of basins, without an answer."""
    if "kind" in answer.arrays:
        return no_starts(answer)
    return failed_values(answer.arrays) if "status" in answer.arrays else len(answer.reasons)
