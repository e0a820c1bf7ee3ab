"""Answers on disk, chunk by chunk: finished chunks outlive the process that computed them.

A store is a Zarr group: an array for each column of the answer, whose chunks are those of the job,
and ``done``, which holds a mark for each chunk. The mark is two numbers, one more than the impacts
of the chunk and the time at which it was finished, and is written after the data. Each file ends
with a checksum, so that a chunk which was cut off by a kill, a full disk or a crash of the machine
is noticed, counts as not done, and is computed again.

The ``zarr.json`` of the group is the marker of a store: it is written first, under another name
that is then linked to this one, and it describes the study. A folder that has content but no such
marker belongs to another program, and is left as it is. No folder is ever removed.

Zarr describes the arrays; the chunks are written here, as Zarr's codecs "bytes" and "crc32c" do:
docs/decisions/016-stores.md.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import re
import tempfile
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Integers
from percuss.ensembles.datasets import write_whole
from percuss.ensembles.fingerprint import code_hash
from percuss.ensembles.job import Answer, Block, Column, Job, chunks_of, too_large
from percuss.ensembles.lock import StoreLock
from percuss.errors import OutputError, PercussError, check_installed

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

FORMAT = 3
# The finished result, for `load_store`.
RESULT = "result.nc"
# The description of the study, and the name under which it is written first.
MARKER = "zarr.json"
PART = re.compile(r"zarr\.json\.\d+\.part")
# The folders of the parts of a study that has several.
OF_DIAGRAM = ("followed", "afresh")
# The types of columns, by their names in Zarr.
_KINDS = {"float64": "f8", "int64": "i8"}
# The suffix of the folder of the parts of a job array.
PARTS = ".parts"
# Numbers of a mark, and bytes of a checksum.
MARK, CHECKSUM = 2, 4
# Bytes for the reasons of a chunk: longer texts are cut.
REASON_BYTES = 1 << 18


def write_chunk(file: Path, values: NDArray[np.generic]) -> None:
    """Write the numbers of a chunk, the little end first, and their checksum (CRC-32C)."""
    # Imported here: only stores need it.
    from google_crc32c import value as checksum

    content = values.astype(values.dtype.newbyteorder("<"), copy=False).tobytes()
    left = memoryview(content + checksum(content).to_bytes(CHECKSUM, "little"))
    file.parent.mkdir(parents=True, exist_ok=True)
    # With a file object Ctrl-C could come after it is opened and before its `with` block.
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0)
    descriptor = os.open(file, flags, 0o666)
    try:
        while left:
            left = left[os.write(descriptor, left) :]
    finally:
        os.close(descriptor)


def read_chunk(file: Path) -> bytes | None:
    """Return the bytes of a chunk; None if its file is missing or damaged."""
    from google_crc32c import value as checksum

    try:
        content = file.read_bytes()
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        return None
    inner, stored = content[:-CHECKSUM], content[-CHECKSUM:]
    return inner if inner and checksum(inner).to_bytes(CHECKSUM, "little") == stored else None


@dataclass(frozen=True, slots=True)
class Chunks:
    """The chunks of a store, as files in a folder.

    An answer of ``size`` points is cut into chunks of ``chunk`` points; the last one is stored at
    full length.
    """

    path: Path
    columns: Mapping[str, Column]
    size: int
    chunk: int

    @property
    def count(self) -> int:
        """Number of chunks."""
        return -(-self.size // self.chunk)

    def span(self, number: int) -> tuple[int, int]:
        """Return first and last point of a chunk, the last not included."""
        return number * self.chunk, min((number + 1) * self.chunk, self.size)

    def file(self, name: str, number: int) -> Path:
        """Return the file of a chunk of one array."""
        tail = {"reasons": 1, "done": 0}.get(name) if name not in self.columns else None
        depth = len(self.columns[name].tail) if tail is None else tail
        return self.path.joinpath(name, "c", str(number), *("0" * depth))

    def _bytes(self, column: Column) -> int:
        return self.chunk * math.prod(column.tail) * np.dtype(column.dtype).itemsize

    def write(self, number: int, block: Block, *, finished: int | None = None) -> None:
        """Write a chunk, and its mark after it: finished now, or at that time [us since 1970]."""
        first, last = self.span(number)
        for name, column in self.columns.items():
            values = np.asarray(block.arrays[name], dtype=column.dtype)
            rest = column.empty(self.chunk - (last - first))
            write_chunk(self.file(name, number), np.concatenate([values, rest]))
        if block.reasons:
            _opened(self.path / "reasons", "r+")[number] = reasons_as_bytes(block.reasons)
        when = time.time_ns() // 1000 if finished is None else finished
        mark = np.array([1 + block.n_impacts, when], dtype=np.int64)
        write_chunk(self.file("done", number), mark)

    def marks(self) -> Integers:
        """Return the marks of all chunks, (n, 2) array; 0 where one is missing or damaged."""
        marks = np.zeros((self.count, MARK), dtype=np.int64)
        folder = self.path / "done" / "c"
        for entry in os.scandir(folder) if folder.is_dir() else ():
            if entry.name.isdecimal() and int(entry.name) < len(marks):
                content = read_chunk(Path(entry.path))
                if content is not None and len(content) == marks[0].nbytes:
                    marks[int(entry.name)] = np.frombuffer(content, dtype="<i8")
        return marks

    def seems_whole(self, number: int) -> bool:
        """Return whether the files of a chunk have their full lengths."""
        try:
            return all(
                self.file(name, number).stat().st_size == self._bytes(column) + CHECKSUM
                for name, column in self.columns.items()
            )
        except (FileNotFoundError, NotADirectoryError):
            return False

    def read(self, number: int) -> Block | None:
        """Return the data of a chunk; None if a part is missing or damaged."""
        first, last = self.span(number)
        arrays: dict[str, NDArray[np.generic]] = {}
        for name, column in self.columns.items():
            content = read_chunk(self.file(name, number))
            if content is None or len(content) != self._bytes(column):
                return None
            values = np.frombuffer(content, dtype=np.dtype(column.dtype).newbyteorder("<"))
            arrays[name] = values.reshape(self.chunk, *column.tail)[: last - first]
        reasons = self.file("reasons", number)
        # Most chunks have none.
        if not reasons.exists():
            return Block(arrays)
        if read_chunk(reasons) is None:
            return None
        text = bytes(_opened(reasons.parents[2])[number]).rstrip(b"\0")
        return Block(
            arrays, {i: reason for reason, points in json.loads(text or "[]") for i in points}
        )

    def answer(self) -> Answer:
        """Return the answer; NaN and -1 where a chunk is missing."""
        arrays = {
            name: _array_for(self.path, column, self.size) for name, column in self.columns.items()
        }
        reasons: dict[int, str] = {}
        n_impacts, complete = 0, True
        for number, (impacts, _) in enumerate(self.marks().tolist()):
            first, last = self.span(number)
            block = self.read(number) if impacts > 0 else None
            for name, column in self.columns.items():
                arrays[name][first:last] = (
                    column.empty(last - first) if block is None else block.arrays[name]
                )
            if block is None:
                complete = False
            else:
                reasons |= {first + i: text for i, text in block.reasons.items()}
                n_impacts += impacts - 1
        return Answer(arrays, dict(sorted(reasons.items())), n_impacts, complete=complete)


def _array_for(path: Path, column: Column, size: int) -> NDArray[np.generic]:
    """Return an empty array for a column, in an unnamed file of the folder if memory is small."""
    shape = (size, *column.tail)
    if too_large([size], math.prod(column.tail)) is None:
        return np.empty(shape, dtype=column.dtype)
    with tempfile.TemporaryFile(dir=path) as file:
        return np.memmap(file, dtype=column.dtype, mode="w+", shape=shape)


def reasons_as_bytes(reasons: dict[int, str]) -> NDArray[np.uint8]:
    """Return reasons as JSON, each text once with the numbers of its points.

    Texts are cut where there is no room; the numbers of a whole chunk fit (`sweep.LARGEST_OF_ALL`).
    """
    by_text: dict[str, list[int]] = {}
    for i, text in sorted(reasons.items()):
        by_text.setdefault(text, []).append(i)
    for longest in (None, 2000, 300, 40, 0):
        short: dict[str, list[int]] = {}
        for text, points in by_text.items():
            cut = text if longest is None else text[-longest:] if longest else ""
            short.setdefault(cut, []).extend(points)
        content = json.dumps(list(short.items())).encode()
        if len(content) <= REASON_BYTES:
            break
    return np.frombuffer(content.ljust(REASON_BYTES, b"\0"), dtype=np.uint8)


def check_stores() -> None:
    """Raise a `MissingExtraError` unless the packages that stores need are installed."""
    check_installed("a store", "stores", "zarr", "google_crc32c", "h5netcdf", "h5py")


class Store:
    """The store of a job: a new one, or one that the same job has begun.

    Parameters
    ----------
    path
        The folder; it does not exist, is empty, or holds a store of the same job.
    job
        The job.

    Raises
    ------
    OutputError
        If it holds something else, another study, the work of other code, cannot be written, or
        another process is writing it.
    """

    def __init__(self, path: Path, job: Job) -> None:
        check_stores()
        self.path = path
        self._chunks = Chunks(path, job.columns, job.size, min(job.chunk, job.size))
        self._lock = StoreLock(path)
        # As JSON gives it back: tuples as lists.
        about = json.loads(json.dumps(_description(job)))
        arrays = _arrays_of(job)
        with store_faults(path):
            if not has_store(path):
                check_vacant(path)
                make_folder(path)
                _mark(path, about)
            _check_description(path, about)
            if self._is_whole(arrays):
                # Any number of processes may read it.
                return
            self._lock.acquire()
            try:
                for name, array in arrays.items():
                    _make_array(path / name, array)
                for number in self._damaged():
                    # Without its mark the chunk is computed again.
                    self._chunks.file("done", number).unlink()
            except BaseException:
                self.close()
                raise

    def _is_whole(self, arrays: Mapping[str, dict[str, Any]]) -> bool:
        """Return whether nothing is left to be written."""
        is_done = bool((self._chunks.marks()[:, 0] > 0).all())
        if not is_done or not all(_has_array(self.path / name, arrays[name]) for name in arrays):
            return False
        return not self._damaged()

    def _damaged(self) -> list[int]:
        """Return the numbers of the chunks that have a mark, and whose data are lost or cut off."""
        marked = np.flatnonzero(self._chunks.marks()[:, 0]).tolist()
        return [number for number in marked if self._chunks.read(number) is None]

    def renew(self) -> None:
        """Show other machines, now and then, that this process is at work."""
        self._lock.renew()

    def close(self) -> None:
        """Let other processes write the store."""
        self._lock.release()

    def done(self) -> tuple[int, int]:
        """Return the number of points that are done, and that of their impacts."""
        with store_faults(self.path):
            marks = self._chunks.marks()[:, 0]
        spans = [self._chunks.span(number) for number in np.flatnonzero(marks).tolist()]
        return sum(last - first for first, last in spans), int((marks[marks > 0] - 1).sum())

    def todo(self) -> list[int]:
        """Return the numbers of the chunks without a mark."""
        with store_faults(self.path):
            return np.flatnonzero(self._chunks.marks()[:, 0] == 0).tolist()

    def write(self, number: int, block: Block, *, finished: int | None = None) -> None:
        """Write a chunk, and its mark after it: finished now, or at that time [us since 1970]."""
        with store_faults(self.path):
            self._chunks.write(number, block, finished=finished)
        self._lock.renew()

    def read(self) -> Answer:
        """Return the answer as far as it is done."""
        with store_faults(self.path):
            return self._chunks.answer()


@contextlib.contextmanager
def store_faults(path: Path) -> Iterator[None]:
    """Turn what is raised about a damaged or unwritable store into an `OutputError`."""
    try:
        yield
    except PercussError:
        raise
    except OSError as error:
        kept = ""
        # The path itself may be the fault.
        with contextlib.suppress(OSError):
            kept = "; what was finished is kept" if (path / "done" / "c").exists() else ""
        raise OutputError(path, f"{error.strerror or error}{kept}") from error
    except json.JSONDecodeError as error:
        raise OutputError(path, _cut_off(path)) from error
    except KeyError as error:
        reason = f"a damaged store, which has lost its {error}; choose another name"
        raise OutputError(path, reason) from error
    except (ValueError, TypeError, RuntimeError) as error:
        raise OutputError(path, f"a damaged store ({error}); choose another name") from error


def _cut_off(path: Path) -> str:
    """Return which description of a damaged store is cut off, and how to mend it."""
    cut = [file for file in sorted(path.glob(f"*/{MARKER}")) if not _is_json(file)]
    if cut and _is_json(path / MARKER):
        name = cut[0].relative_to(path)
        return (
            f"a damaged store: {name} is cut off or changed; the command that began it mends that"
        )
    return (
        "a damaged store: its zarr.json, which says what study it is, is cut off or changed; "
        "put a copy of that file back, or choose another name"
    )


def _is_json(file: Path) -> bool:
    try:
        json.loads(file.read_bytes())
    except ValueError:
        return False
    return True


def has_store(path: Path) -> bool:
    """Return whether a folder is Zarr data: a store of percuss, or of another program."""
    return (path / MARKER).exists()


def described(path: Path) -> dict[str, Any] | None:
    """Return the description of a store of percuss, None for Zarr data of another program.

    Raises
    ------
    OSError, ValueError
        If there is none, or it cannot be read.
    """
    about = json.loads((path / MARKER).read_bytes())
    attributes = about.get("attributes") if isinstance(about, dict) else None
    own = attributes.get("percuss") if isinstance(attributes, dict) else None
    return own if isinstance(own, dict) and about.get("node_type") == "group" else None


def own_attributes(path: Path) -> dict[str, Any]:
    """Return the description of a store.

    Raises
    ------
    MissingExtraError
        If the packages that stores need are not installed.
    OutputError
        If it is no store of percuss, or of another format.
    """
    check_stores()
    own = described(path)
    if own is None:
        reason = "Zarr data that are no store of percuss, and are left as they are"
        raise OutputError(path, f"{reason}; choose another name for a store")
    if own.get("format") != FORMAT:
        reason = (
            f"a store of format {own.get('format')}, written by percuss {own.get('version')}; "
            f"this is percuss {metadata.version('percuss')} and reads format {FORMAT}"
        )
        raise OutputError(path, reason)
    return own


def stored_chunks(path: Path, own: Mapping[str, Any]) -> Chunks:
    """Return the chunks of a store, with the columns that its arrays describe."""
    columns: dict[str, Column] = {}
    for name, about in own["columns"].items():
        file = path / name / "zarr.json"
        if not file.exists():
            # The process was killed before it made the array, or the file has been removed.
            reason = "was begun, and holds nothing yet; the same command goes on"
            if (path / "done" / "c").exists():
                reason = f"has lost its {name}/zarr.json; the command that began it mends that"
            raise OutputError(path, reason)
        array = json.loads(file.read_bytes())
        columns[name] = Column(
            tuple(array["shape"][1:]),
            _KINDS[array["data_type"]],
            tuple(about["dims"]),
            about["units"],
            about.get("meaning", ""),
        )
    return Chunks(path, columns, own["size"], min(own["chunk"], own["size"]))


def stores_of_study(path: Path) -> list[Path]:
    """Return a folder that is a store, or else the stores of the parts of a study in it."""
    if has_store(path):
        return [path]
    return [path / name for name in OF_DIAGRAM if has_store(path / name)]


def check_vacant(path: Path, parts: Sequence[str] = ()) -> None:
    """Raise an `OutputError` unless a folder is free for a store.

    Parameters
    ----------
    path
        The folder: missing, empty, or with the leftovers of a process that was killed while it
        made a store.
    parts
        Names of folders in it that may exist if they are vacant themselves.
    """
    if not _is_vacant(path, parts):
        reason = "exists and is no store of percuss; it is left as it is; choose another name"
        raise OutputError(path, reason)


def _is_vacant(path: Path, parts: Sequence[str] = ()) -> bool:
    if not path.exists():
        return True
    return path.is_dir() and all(
        PART.fullmatch(entry.name) or (entry.name in parts and _is_vacant(entry))
        for entry in path.iterdir()
    )


def make_folder(path: Path) -> None:
    """Make the folder of a store; a missing parent is taken for a mistyped path."""
    with store_faults(path):
        if path.parent.suffix == PARTS:
            make_folder(path.parent)
        if not path.parent.exists():
            raise OutputError(path, f"there is no folder {path.parent}; make it first")
        path.mkdir(exist_ok=True)


def keep_result(path: Path, dataset: Dataset) -> None:
    """Write the finished result into its store, for `load_store`."""
    part = (path / RESULT).with_suffix(f".{os.getpid()}.part")
    with store_faults(path):
        try:
            write_whole(dataset, part)
            part.replace(path / RESULT)
        finally:
            part.unlink(missing_ok=True)


def motions_of_a_point(job: Job) -> int:
    """Return the number of motions that a point of a job stands for: several of a whole branch."""
    return min(math.prod(column.tail) for column in job.columns.values())


def _description(job: Job) -> dict[str, Any]:
    # Of a part of a job array which one it is, and the chunks of the whole.
    part_of = getattr(job, "part_of", None)
    return {
        "format": FORMAT,
        "version": metadata.version("percuss"),
        "code": code_hash(),
        "size": job.size,
        "chunk": job.chunk,
        "motions_of_a_point": motions_of_a_point(job),
        "dimensions": [axis.description() for axis in job.dimensions],
        "columns": {
            name: {"dims": list(column.dims), "units": column.units, "meaning": column.meaning}
            for name, column in job.columns.items()
        },
        "study": job.identity(),
        **({} if part_of is None else {"part_of": part_of}),
    }


def _mark(path: Path, about: dict[str, object]) -> None:
    """Write the description of a store, in one step and never over another."""
    marker, part = path / MARKER, path / f"{MARKER}.{os.getpid()}.part"
    group = {"zarr_format": 3, "node_type": "group", "attributes": {"percuss": about}}
    try:
        with part.open("w", encoding="utf-8") as file:
            json.dump(group, file, allow_nan=False)
            file.flush()
            os.fsync(file.fileno())
        try:
            os.link(part, marker)
        except FileExistsError:
            # Another process was first; whether its study is the same is checked next.
            return
        except OSError:
            # A file system without links.
            if not marker.exists():
                part.replace(marker)
    finally:
        part.unlink(missing_ok=True)


def _check_description(path: Path, wanted: Mapping[str, Any]) -> None:
    """Raise an `OutputError` unless a store is of this job, and begun by this code."""
    own = own_attributes(path)
    study, asked = own["study"], wanted["study"]
    different = [key for key in sorted({*study, *asked}) if study.get(key) != asked.get(key)]
    if different or any(own[key] != wanted[key] for key in ("size", "chunk")):
        what = ", ".join(different) or "the chunks"
        raise OutputError(
            path, f"holds another study, which differs in {what}; choose another name"
        )
    if own["code"] != wanted["code"]:
        reason = (
            f"was begun by other code (percuss {own['version']}, code {own['code']}; this is "
            f"{wanted['version']}, code {wanted['code']}), whose last bits may differ; "
            "finish it with that or choose another name"
        )
        raise OutputError(path, reason)


def _opened(path: Path, mode: Literal["r", "r+"] = "r") -> Any:
    """Return the Zarr array in a folder."""
    # Half a second of import, which only stores should wait for.
    import zarr

    return zarr.open_array(str(path), mode=mode, zarr_format=3)


def _arrays_of(job: Job) -> dict[str, dict[str, Any]]:
    """Return the arrays of a store by their names, as Zarr makes them."""
    from zarr.codecs import Crc32cCodec, ZstdCodec

    n, sums = len(chunks_of(job)), [Crc32cCodec()]
    arrays: dict[str, dict[str, Any]] = {
        name: {
            "shape": (job.size, *column.tail),
            "chunks": (min(job.chunk, job.size), *column.tail),
            "dtype": column.dtype,
            "fill_value": np.nan if column.dtype == "f8" else -1,
            "dimension_names": ("point", *column.dims) if column.dims or not column.tail else None,
            "compressors": sums,
        }
        for name, column in job.columns.items()
    }
    arrays["reasons"] = {
        "shape": (n, REASON_BYTES), "chunks": (1, REASON_BYTES), "dtype": "u1", "fill_value": 0,
        "compressors": [ZstdCodec(), *sums],
    }  # fmt: skip
    arrays["done"] = {
        "shape": (MARK * n,), "chunks": (MARK,), "dtype": "i8", "fill_value": 0,
        "compressors": sums,
    }  # fmt: skip
    return arrays


def _has_array(path: Path, about: Mapping[str, Any]) -> bool:
    """Return whether a store has an array, chunks aside."""
    try:
        return bool(_opened(path).shape == about["shape"])
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _make_array(path: Path, about: dict[str, Any]) -> None:
    """Describe an array of a store, or one whose description is lost; its chunks stay."""
    import zarr

    try:
        array = _opened(path)
    except (OSError, ValueError, KeyError, TypeError):
        is_of_store = path.is_dir() and {entry.name for entry in path.iterdir()} <= {MARKER, "c"}
        if not _is_vacant(path) and not is_of_store:
            reason = f"holds a {path.name} that is no array of this store, and is left as it is"
            raise OutputError(path.parent, f"{reason}; move it away") from None
        (path / MARKER).unlink(missing_ok=True)
        zarr.create_array(str(path), zarr_format=3, **about)
        return
    if array.shape != about["shape"]:
        reason = f"holds a {path.name} that is no array of shape {about['shape']}"
        raise OutputError(path.parent, f"{reason}, as this store has it; move it away")
