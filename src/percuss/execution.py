"""How a computation is carried out: its store, its engine and workers, its part, its progress."""

from __future__ import annotations

import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from percuss.errors import ParameterError
from percuss.progress import Report

# More parts than this are a mistyped number.
MOST_PARTS = 1_000_000


@dataclass(frozen=True, slots=True)
class ArrayPart:
    """One of the parts in which a job array computes a study of many motions.

    Attributes
    ----------
    number
        Which one, from 1 to `count`.
    count
        How many parts there are.

    Examples
    --------
    >>> part = ArrayPart.of((3, 100))
    >>> str(part), part.name
    ('3/100', '003-of-100.zarr')
    """

    number: int
    count: int

    @classmethod
    def of(cls, given: object) -> ArrayPart:
        """Return the part of a pair (i, n), or of the text "i/n".

        Raises
        ------
        ParameterError
            If they are not two whole numbers, 1 <= i <= n.
        """
        pair: Any = given.split("/") if isinstance(given, str) else given
        try:
            number, count = (int(each) for each in pair)
            exact = isinstance(given, str) or (number, count) == tuple(pair)
        except (TypeError, ValueError) as error:
            reason = "not a part and their number, such as 3/100"
            raise ParameterError("part", given, reason) from error
        if not (exact and 1 <= number <= count <= MOST_PARTS):
            reason = f"not a part from 1 to their number, which is at most {MOST_PARTS:,}"
            raise ParameterError("part", given, reason)
        return cls(number, count)

    @property
    def name(self) -> str:
        """The name of its store in the folder of the parts."""
        width = len(str(self.count))
        return f"{self.number:0{width}d}-of-{self.count}.zarr"

    def __str__(self) -> str:
        return f"{self.number}/{self.count}"


def folder_of(store: object) -> Path:
    """Return the folder of a store.

    Examples
    --------
    >>> folder_of(3)
    Traceback (most recent call last):
    percuss.errors.ParameterError: store = 3: not the path of a folder, such as "run.zarr"
    """
    if not isinstance(store, str | os.PathLike) or store == "":
        raise ParameterError("store", store, 'not the path of a folder, such as "run.zarr"')
    return Path(store)


def folder_of_parts(store: Path) -> Path:
    """Return the folder in which the parts of a store lie until they are merged.

    Examples
    --------
    >>> folder_of_parts(Path("run.zarr")).name
    'run.zarr.parts'
    """
    named = store if store.name else store.absolute()  # the folder "." has no name
    return named.parent / f"{named.name}.parts"


@dataclass(frozen=True, slots=True)
class Execution:
    """The execution of a computation; the answer does not depend on it.

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
    part
        The part of a job array that is computed, i of n; None: all.
    """

    store: Path | None = None
    engine: Any = "threads"
    n_workers: int | None = None
    progress: Report = None
    part: ArrayPart | None = None

    def of_part(self, name: str) -> Execution:
        """Return the execution of one part of a job, whose store is a folder in this one."""
        return self if self.store is None else replace(self, store=self.store / name)

    def keywords(self) -> dict[str, Any]:
        """Return its fields as keywords of `percuss.sweep`, `percuss.basins` and the like."""
        part = None if self.part is None else (self.part.number, self.part.count)
        return {"store": self.store, "engine": self.engine, "n_workers": self.n_workers,
                "progress": self.progress, "part": part}  # fmt: skip
