"""What a search keeps of where it is, in a file, so that the same call goes on from there."""

from __future__ import annotations

import os
import time
from collections.abc import Sequence
from dataclasses import dataclass, fields
from hashlib import sha256
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from percuss.arrays import Floats
from percuss.errors import OutputError
from percuss.fitting.losses import Loss
from percuss.fitting.measured import MeasuredRecord, MeasuredSamples
from percuss.fitting.shooting import Layout
from percuss.fitting.solver import FitPoint, FitProblem
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.structure import Structure

# Of the file, whose first entry it is.
FORM = "percuss-fit-1"
# Seconds between two times at which a running search writes.
PAUSE = 2.0
SAMPLES = tuple(field.name for field in fields(MeasuredSamples))


@dataclass(eq=False)
class KeptSearch:
    """The file of a search.

    Attributes
    ----------
    path
        The file; a NumPy archive (.npz), whatever its name.
    osc
        The oscillator, or the structure.
    records
        What was measured.
    paths
        The free parameters.
    """

    path: Path
    osc: Oscillator | Structure
    records: Sequence[MeasuredRecord]
    paths: tuple[str, ...]
    _written: float = -PAUSE

    def keep(self, problem: FitProblem, point: FitPoint) -> None:
        """Write where a search is, unless it was written just before."""
        now = time.monotonic()
        if now - self._written >= PAUSE:
            self.write(problem, point)
            self._written = now

    def write(self, problem: FitProblem, point: FitPoint) -> None:
        """Write where a search is, or has ended.

        Raises
        ------
        OutputError
            If the file cannot be written.
        """
        entries: dict[str, Any] = {
            "form": FORM, "of": self._fingerprint(), "values": point.values,
            "nodes": point.shots.nodes, "node_errors": problem.node_errors,
        }  # fmt: skip
        for i, layout in enumerate(problem.layouts):
            entries[f"{i}.spans"], entries[f"{i}.first"] = layout.spans, layout.first
            entries[f"{i}.is_fixed"] = layout.is_fixed
            entries[f"{i}.keys"] = np.array(sorted(layout.keys), dtype=np.int64)
            for table in ("samples", "impacts"):
                some = getattr(layout.record, table)
                entries |= {f"{i}.{table}.{name}": getattr(some, name) for name in SAMPLES}
        part = self.path.with_name(f"{self.path.name}.part")
        try:
            with part.open("wb") as file:
                np.savez(file, allow_pickle=False, **entries)
            part.replace(self.path)
        except OSError as error:
            reason = (error.strerror or "not written").lower()
            raise OutputError(self.path, f"the search cannot be kept there: {reason}") from error

    def begun(self) -> tuple[FitProblem, Floats, dict[str, float]] | None:
        """Return problem, nodes and parameters of the search in the file; None without one.

        Raises
        ------
        OutputError
            If the file is none of a fit, or of one of other data, parameters or another model.
        """
        if not self.path.exists():
            if not self.path.parent.is_dir():
                raise OutputError(self.path, "the folder for it does not exist")
            return None
        reason = "holds no fit; give another name for the store of this one"
        try:
            # Of a damaged file NumPy leaves open what it opens itself.
            with self.path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
                entries = {name: archive[name] for name in archive.files}
        except (OSError, ValueError, TypeError, EOFError, BadZipFile) as error:
            raise OutputError(self.path, reason) from error
        if str(entries.get("form")) != FORM:
            raise OutputError(self.path, reason)
        if str(entries["of"]) != self._fingerprint():
            reason = "holds a fit of other data, parameters or another model; delete it, or give another name"
            raise OutputError(self.path, reason)
        layouts = [self._layout(entries, i) for i in range(len(self.records))]
        values = entries["values"]
        none = np.zeros(len(values))
        # Bounds, priors and loss are those of the search that goes on.
        problem = FitProblem(
            self.osc, layouts, self.paths, none, none, entries["node_errors"],
            np.zeros((0, 3)), Loss("linear"), lambda: True,
        )  # fmt: skip
        return problem, entries["nodes"], dict(zip(self.paths, values.tolist(), strict=True))

    def _layout(self, entries: dict[str, Any], i: int) -> Layout:
        """Return the segments of a record, with the noise that its samples had."""
        given = self.records[i]
        tables = []
        for table in ("samples", "impacts"):
            own: dict[str, Any] = {name: entries[f"{i}.{table}.{name}"] for name in SAMPLES}
            tables.append(MeasuredSamples(**{**own, "reach": float(own["reach"])}))
        samples, impacts = tables
        record = MeasuredRecord(samples, impacts, given.force, given.start)
        keys = set(entries[f"{i}.keys"].tolist())
        is_fixed = bool(entries[f"{i}.is_fixed"])
        return Layout(record, entries[f"{i}.spans"], entries[f"{i}.first"], is_fixed, keys)

    def _fingerprint(self) -> str:
        """Return a digest of the data, the noise that was given, the parameters and the model."""
        digest = sha256(repr((self.paths, _told(self.osc))).encode())
        for record in self.records:
            force = record.force
            forces = force.forcings if isinstance(force, Loads) else (force,)
            records = [f.record for f in forces if f is not None and f.record is not None]
            samples = [(some.t, some.f) for some in records]
            digest.update(repr((force, samples, record.start)).encode())
            for some in (record.samples, record.impacts):
                for array in (some.t, some.values, some.quantities, some.noise, some.is_estimated):
                    digest.update(np.ascontiguousarray(array).tobytes())
        return digest.hexdigest()


def _told(osc: Oscillator | Structure) -> object:
    """Return all that a model is made of: a large structure is shown without its entries."""
    if isinstance(osc, Oscillator):
        return osc
    return osc.mass, osc.stiffness, osc.damping, osc.stops, osc.points


def file_of(path: str | os.PathLike[str]) -> Path:
    """Return the file of a store.

    Raises
    ------
    OutputError
        If a folder is there.
    """
    file = Path(path)
    if file.is_dir():
        raise OutputError(file, "a folder; the store of a fit is a file, such as rig.fit")
    return file
