"""The parts in which a job array computes a study of many motions, and what they are merged into.

Part i of n has a store of its own, ``run.zarr.parts/i-of-n.zarr``, with the description of the
whole study and every n-th of its chunks, which are smaller where the study has few. Nothing but
that folder is shared by the processes. `merge_parts` puts the chunks of all parts together into the
store that one process would have written.
"""

from __future__ import annotations

import contextlib
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from percuss.arrays import Integers
from percuss.ensembles.job import Answer, Block, Column, Dimension, Job
from percuss.ensembles.store import (
    Chunks,
    Store,
    make_folder,
    motions_of_a_point,
    own_attributes,
    store_faults,
    stored_chunks,
    stores_of_study,
)
from percuss.errors import OutputError
from percuss.execution import ArrayPart, folder_of, folder_of_parts
from percuss.progress import Progress, Report
from percuss.version import __version__

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

NAME = re.compile(r"0*(\d+)-of-(\d+)\.zarr")
# Parts named in a message.
FEW = 5


@dataclass(frozen=True, slots=True)
class PartOfJob:
    """A job of which one part of an array computes every n-th chunk."""

    job: Job
    part: ArrayPart

    @property
    def size(self) -> int:
        """Number of points of the whole job."""
        return self.job.size

    @property
    def chunk(self) -> int:
        """Points of a chunk: at most those of the whole job, and the same number for each part."""
        each = -(-self.job.size // (self.part.count * min(self.job.chunk, self.job.size)))
        return max(1, -(-self.job.size // (self.part.count * each)))

    @property
    def columns(self) -> Mapping[str, Column]:
        """The columns of the answer."""
        return self.job.columns

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The axes of the whole job."""
        return self.job.dimensions

    @property
    def part_of(self) -> dict[str, int]:
        """Which part it is, for its store, and the points of a chunk of the whole job."""
        part = self.part
        return {"number": part.number, "count": part.count, "chunk": self.job.chunk}

    @property
    def each(self) -> str:
        """What is counted, in the plural."""
        return getattr(self.job, "each", "points")

    @property
    def measure(self) -> object:
        """The function of the user, if the job has one."""
        return getattr(self.job, "measure", None)

    def identity(self) -> dict[str, object]:
        """Return what tells this study from others."""
        return self.job.identity()

    def compute(self, first: int, last: int) -> Block:
        """Return the answer for the points of a chunk."""
        return self.job.compute(first, last)


def part_dataset(answers: Sequence[Answer], part: ArrayPart) -> Dataset:
    """Return what a call gives that has computed a part: how much of it is done, and no data."""
    import xarray

    return xarray.Dataset(
        attrs={
            "percuss": __version__,
            "part": str(part),
            "points": sum(answer.n_done for answer in answers),
            "n_impacts": sum(answer.n_impacts for answer in answers),
            "complete": int(all(answer.complete for answer in answers)),
        }
    )


def parts_of_array(store: Path) -> list[Path]:
    """Return the stores of the parts of a store, in order.

    Raises
    ------
    OutputError
        If there are none, or they are those of several arrays.
    """
    folder = folder_of_parts(store)
    folders: dict[int, dict[int, Path]] = defaultdict(dict)
    for path in sorted(folder.glob("*-of-*.zarr")):
        match = NAME.fullmatch(path.name)
        if match is not None and stores_of_study(path):
            folders[int(match[2])][int(match[1])] = path
    if not folders:
        reason = "no parts there; percuss run STUDY --store STORE --part i/n makes them"
        raise OutputError(folder, reason)
    if len(folders) > 1:
        counts = " and ".join(f"{count:,}" for count in sorted(folders))
        reason = f"holds parts of several arrays, of {counts} parts; remove those of all but one"
        raise OutputError(folder, reason)
    return [path for _, path in sorted(next(iter(folders.values())).items())]


def merge_parts(store: str | Path, *, progress: Report = None) -> int:
    """Put the parts of a job array together into one store.

    The same call in which the parts were computed, without ``part=``, finds every chunk in the
    store and returns the whole answer, to the same bits as without parts.

    Parameters
    ----------
    store
        The folder that was given as ``store`` to all parts, which lie in ``STORE.parts`` beside
        it; they stay there.
    progress
        As in `percuss.sweep`.

    Returns
    -------
    int
        The number of points in the store, as `status_of_store` counts them.

    Raises
    ------
    OutputError
        If there are no parts, some are missing or not complete, they are of different studies, or
        the store holds another study or cannot be written.

    Examples
    --------
    >>> import tempfile, percuss as pc
    >>> call = dict(osc=pc.impact_oscillator(0.8), force=pc.cosine(2.5), periods=2, transient=9,
    ...             over={"start.v0": [1.0, 2.0, 3.0]})
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = f"{folder}/run.zarr"
    ...     for i in (1, 2):
    ...         part = pc.sweep("mean_power", **call, store=path, part=(i, 2))
    ...     n_points = pc.merge_parts(path)
    ...     data = pc.sweep("mean_power", **call, store=path)
    >>> n_points, data.identical(pc.sweep("mean_power", **call))
    (3, True)
    """
    path = folder_of(store)
    parts = parts_of_array(path)
    with store_faults(path):
        names = [inner.name if inner != parts[0] else "" for inner in stores_of_study(parts[0])]
        studies = [_Whole([part / name for part in parts]) for name in names]
        for study in studies:
            study.check_complete()
        if names != [""]:
            make_folder(path)
        reported = Progress(progress, sum(study.size for study in studies), "points")
        with contextlib.closing(reported):
            return sum(
                study.merge(path / name, reported)
                for name, study in zip(names, studies, strict=True)
            )


class _Whole:
    """The job whose chunks the parts of an array hold, as their stores describe it."""

    def __init__(self, parts: Sequence[Path]) -> None:
        self._own = own_attributes(parts[0])
        self._folder = parts[0].parent
        self._chunks = [_checked_chunks(part, self._own) for part in parts]
        self.size = int(self._own["size"])
        self.chunk = int(self._own["part_of"]["chunk"])
        self.columns = self._chunks[0].columns
        self.dimensions = tuple(map(Dimension.of_description, self._own["dimensions"]))
        self._marks, self._times = self._all_marks()

    def identity(self) -> dict[str, object]:
        """Return what tells this study from others."""
        return dict(self._own["study"])

    def compute(self, first: int, last: int) -> Block:
        """Return the points from first to last out of the chunks of the parts."""
        each = self._chunks[0].chunk
        block = Block.empty(self.columns, last - first)
        for number in range(first // each, -(-last // each)):
            begin, end = self._chunks[0].span(number)
            part = self._read(number)
            low, high = max(first, begin), min(last, end)
            for name, values in part.arrays.items():
                block.arrays[name][low - first : high - first] = values[low - begin : high - begin]
            block.reasons |= {
                begin + i - first: text
                for i, text in part.reasons.items()
                if low <= begin + i < high
            }
            # The impacts of a chunk are counted once.
            block.n_impacts += int(self._marks[number]) - 1 if begin >= first else 0
        return block

    def _read(self, number: int) -> Block:
        """Return a chunk from the part that has computed it."""
        block = self._chunks[self._part_of(number)].read(number)
        if block is None:
            part = self._part_of(number) + 1
            raise OutputError(self._folder, f"a chunk of part {part} is damaged; run it again")
        return block

    def _part_of(self, number: int) -> int:
        return number % int(self._own["part_of"]["count"])

    def _all_marks(self) -> tuple[Integers, Integers]:
        """Return the mark of each chunk in its part, 0 where it is not done, and its time."""
        count = self._own["part_of"]["count"]
        marks = np.zeros((self._chunks[0].count, 2), dtype=np.int64)
        for chunks, number in zip(self._chunks, self._numbers(), strict=True):
            marks[number - 1 :: count] = chunks.marks()[number - 1 :: count]
        return marks[:, 0], marks[:, 1]

    def _numbers(self) -> list[int]:
        """Return the numbers of the parts that are there."""
        return [int(own_attributes(chunks.path)["part_of"]["number"]) for chunks in self._chunks]

    def check_complete(self) -> None:
        """Raise an `OutputError` unless all parts are there and done."""
        count = int(self._own["part_of"]["count"])
        undone = {self._part_of(i) + 1 for i in np.flatnonzero(self._marks == 0).tolist()}
        undone |= set(range(1, count + 1)) - set(self._numbers())
        if undone:
            named = [str(number) for number in sorted(undone)]
            more = f" and {len(named) - FEW:,} others" if len(named) > FEW else ""
            parts, are, them = ("part", "is", "it") if len(named) == 1 else ("parts", "are", "them")
            reason = (
                f"{parts} {', '.join(named[:FEW])}{more} of {count:,} {are} not complete; "
                f"the same commands with --part go on with {them}"
            )
            raise OutputError(self._folder, reason)

    def merge(self, path: Path, progress: Progress) -> int:
        """Write the chunks of all parts into one store; return the number of motions in it."""
        each = self._chunks[0].chunk
        with contextlib.closing(Store(path, self)) as store:
            for number in store.todo():
                first, last = Chunks(path, self.columns, self.size, self.chunk).span(number)
                # As old as the last of its parts, for what `percuss status` says of rates.
                finished = int(self._times[first // each : -(-last // each)].max())
                store.write(number, self.compute(first, last), finished=finished)
                progress.advance(last - first)
        return self.size * motions_of_a_point(self)


def _checked_chunks(path: Path, first: Mapping[str, Any]) -> Chunks:
    """Return the chunks of a part, once it is clear that it belongs to the first one."""
    own = own_attributes(path)
    for key in ("study", "size", "chunk", "code"):
        if own[key] != first[key]:
            what = "another version of percuss" if key == "code" else "another study"
            raise OutputError(path, f"a part of {what} than the others; remove it and run it again")
    return stored_chunks(path, own)
