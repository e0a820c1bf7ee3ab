"""How a computation is carried out: its store, its engine and workers, its progress."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from percuss.progress import Report

__all__ = ["Execution"]


@dataclass(frozen=True, slots=True)
class Execution:
    """How a computation is carried out; the answer does not depend on it.

    Attributes
    ----------
    store
        Folder of a Zarr store that a long job goes into and is resumed from; None keeps the
        answer in memory alone.
    engine, n_workers
        "threads", "processes", or a Dask client or the address of its scheduler; and how many
        workers.
    progress
        True shows a line on the error stream after two seconds; a function
        ``(done, total) -> bool`` is called with what is done and how much there is, and stops the
        work by returning False.
    """

    store: Path | None = None
    engine: Any = "threads"
    n_workers: int | None = None
    progress: Report = None

    def of_part(self, name: str) -> Execution:
        """Return the execution of one part of a job, whose store is a folder in this one."""
        return self if self.store is None else replace(self, store=self.store / name)

    def keywords(self) -> dict[str, Any]:
        """Return its fields as keywords of `percuss.sweep`, `percuss.basins` and the like."""
        return {"store": self.store, "engine": self.engine, "n_workers": self.n_workers,
                "progress": self.progress}  # fmt: skip
