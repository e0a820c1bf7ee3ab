"""What calls of many motions are given besides the question, checked before anything is done."""

from __future__ import annotations

import os
from pathlib import Path

from percuss.ensembles.engines import Engine, check_engine
from percuss.errors import ParameterError

__all__ = ["check_means", "folder_of"]


def check_means(store: object, engine: Engine, n_workers: int | None, progress: object) -> None:
    """Raise a `ParameterError` unless a call can take all of them.

    Parameters
    ----------
    store, engine, n_workers, progress
        As `percuss.sweep` takes them.
    """
    if store is not None:
        folder_of(store)
    check_engine(engine, n_workers)
    if not (progress is None or isinstance(progress, bool) or callable(progress)):
        reason = "neither True nor a function (done, total) -> bool"
        raise ParameterError("progress", progress, reason)


def folder_of(store: object) -> Path:
    """Return the folder of a store.

    Examples
    --------
    >>> folder_of(3)
    Traceback (most recent call last):
    percuss.errors.ParameterError: store = 3: not the path of a folder, such as "run.zarr"
    """
    if not isinstance(store, str | os.PathLike):
        raise ParameterError("store", store, 'not the path of a folder, such as "run.zarr"')
    return Path(store)
