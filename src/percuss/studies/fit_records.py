"""``[[fit.records]]`` of a study file: measurements in the study or in a file beside it."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, TypeAlias

import numpy as np

from percuss.errors import ParameterError
from percuss.fitting.data_file import columns_of_file
from percuss.fitting.measured import MeasuredSamples, quantity_number, read_samples
from percuss.io.study_text import number, start_table
from percuss.model.exact import Exact, Phase, as_float, number_problem, phase_problem
from percuss.model.faults import draft
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.paths import replace_parameters
from percuss.model.start import Start, start_faults
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.studies.study import StudyDraft
from percuss.studies.tables import Path, exact_phase, raw_table, shown, unknown_key, words_of_file

# Values by quantity, None where one is missing.
DataColumns: TypeAlias = "dict[str, tuple[float | None, ...]]"
KEYS = ("file", "columns", "noise", "start", "settings")
QUANTITIES = ("t", "displacement", "velocity", "acceleration", "stop_force", "impact_times")
# Of a stop, or of a coordinate or a point of a structure.
_OF_PLACE = tuple(f"{name}_" for name in QUANTITIES if name not in ("t", "impact_times"))
NO_PLACE = "a study that is no file has no files beside it; give t and displacement"
NO_START = "not a start; write [x0, v0] or [x0, v0, t0]"
NO_NOISE = "not a standard deviation, above 0, nor one for each quantity, {velocity = 0.1}"


@dataclass(frozen=True, slots=True)
class FitRecord:
    """One record of a fit.

    Parameters
    ----------
    data
        Instants `t` and values by quantity, of one length each, None where one is missing; or
        `impact_times`; `noise` for a standard deviation of each value.
    noise
        Standard deviation, or a mapping of these by quantity; None: estimated.
    start
        Its start; None: that of the study, or unknown.
    settings
        Parameters of the forcing that have other values in this record, by their paths.

    Examples
    --------
    >>> FitRecord({"t": (0.0, 0.1), "displacement": (1.0, None)}, noise=0.01).columns["displacement"]
    array([ 1., nan])
    """

    data: DataColumns
    noise: Exact | Mapping[str, Exact] | None = None
    start: Start | StructureStart | None = None
    settings: Mapping[str, Phase] = field(default_factory=dict)

    @property
    def columns(self) -> dict[str, Any]:
        """The data as arrays, missing values NaN."""
        return {
            name: np.array([math.nan if value is None else value for value in values])
            for name, values in self.data.items()
        }

    @property
    def deviation(self) -> Any:
        """The noise as `percuss.fit` takes it."""
        if isinstance(self.noise, Mapping):
            return {name: as_float(value) for name, value in self.noise.items()}
        return None if self.noise is None else as_float(self.noise)

    def forcing(
        self, model: Oscillator | Structure, force: Forcing | Loads | None
    ) -> Forcing | Loads | None:
        """Return the forcing, or the loads, with the settings of this record."""
        return replace_parameters(model, force, None, self.settings)[1] if self.settings else force


def written_record(record: FitRecord) -> dict[str, object]:
    """Return a record as a ``[[fit.records]]`` table that holds its values."""
    noise: Any = record.noise
    if isinstance(noise, Mapping):
        noise = {name: number(value) for name, value in noise.items()}
    elif noise is not None:
        noise = number(noise)
    start = None if record.start is None else list(start_table(record.start).values())
    own = {"start": start, "settings": {k: number(v) for k, v in record.settings.items()} or None}
    if "noise" in record.data:
        noise = [math.nan if value is None else value for value in record.data["noise"]]
    values = {
        name: [math.nan if value is None else value for value in column]
        for name, column in record.data.items()
        if name != "noise"
    }
    return {"noise": noise, **own, **values}


def fit_records(
    rows: Sequence[Any], start: Start | StructureStart | None, study: StudyDraft
) -> list[FitRecord]:
    """Return the records of a study, and add their faults.

    Parameters
    ----------
    rows
        The tables ``[[fit.records]]`` as they were read.
    start
        The start that holds for all; None: unknown.
    study
        The document and its model.
    """
    place: Path = ("fit", "records")
    if not rows and not study.faults.is_wrong("fit.records"):
        study.faults.add(place, "missing; begin each record with [[fit.records]]")
    records = []
    for index, row in enumerate(rows):
        path = (*place, index)
        if not isinstance(row, Mapping):
            study.faults.add(path, "not a table", shown(row))
            continue
        record = _record(row, path, start, study)
        if record is not None:
            records.append(record)
    return records


def _record(
    row: Mapping[str, Any], path: Path, start: Start | StructureStart | None, study: StudyDraft
) -> FitRecord | None:
    """Return a record, None where it has faults; add these."""
    faults = study.faults
    own = {key: value for key, value in row.items() if key not in KEYS}
    for name in own:
        if name.startswith(_OF_PLACE) and study.has_right_model:
            reason = _quantity_fault(name, study)
            if reason:
                faults.add((*path, name), reason)
        elif not name.startswith(_OF_PLACE) and name not in QUANTITIES:
            faults.add((*path, name), unknown_key(name, [*KEYS, *QUANTITIES]))
    data = _data(row, own, path, study)
    noise, deviations = _noise(row.get("noise"), data, path, study)
    begin = _start(row.get("start"), path, study)
    settings = _settings(raw_table(row, "settings"), path, study)
    if data is None or faults.is_wrong(".".join(map(str, path))):
        return None
    record = FitRecord(data | deviations, noise, begin, settings)
    if study.has_right_model:
        _check_samples(record, begin or start, "file" in row, path, study)
    return record


def _data(
    row: Mapping[str, Any], own: Mapping[str, Any], path: Path, study: StudyDraft
) -> DataColumns | None:
    """Return the values of a record, of its file or its lists; add their faults."""
    if "file" not in row:
        if not own:
            study.faults.add(path, "no values; give a file, or t and displacement")
        if "columns" in row:
            study.faults.add((*path, "columns"), "names columns of a file, which is not given")
        return _lists(own, path, study) if own else None
    for name in own:
        study.faults.add((*path, name), "given together with file; give one of the two")
    names = _names(row, path, study)
    file, place = row["file"], (*path, "file")
    if not isinstance(file, str):
        study.faults.add(place, "not a text; put it in quotes", shown(file))
    elif study.folder is None:
        study.faults.add(place, NO_PLACE, shown(file))
    elif names is not None:
        try:
            columns = columns_of_file(study.folder / file, study.model.units, names)
        except OSError as error:
            study.faults.add(place, (error.strerror or "not read").lower(), shown(file))
        except ValueError as error:
            study.faults.add(place, str(error), shown(file))
        else:
            return {
                name: tuple(None if math.isnan(value) else value for value in column.tolist())
                for name, column in columns.items()
            }
    return None


def _names(row: Mapping[str, Any], path: Path, study: StudyDraft) -> dict[str, str] | None:
    """Return the names of columns by quantity; add their faults."""
    given = row.get("columns", {})
    if not isinstance(given, Mapping):
        study.faults.add((*path, "columns"), 'not a table, such as {t = "Time"}', shown(given))
        return None
    right = True
    for name, title in given.items():
        place = (*path, "columns", name)
        reason = "" if isinstance(title, str) else "not a text, the name of a column"
        if name not in ("t", "noise"):
            reason = reason or _quantity_fault(name, study)
        if reason:
            study.faults.add(place, reason, shown(title))
            right = False
    return dict(given) if right else None


def _quantity_fault(name: str, study: StudyDraft) -> str:
    try:
        quantity_number(name, study.model)
    except ParameterError as error:
        return error.reason
    return ""


def _lists(own: Mapping[str, Any], path: Path, study: StudyDraft) -> DataColumns | None:
    """Return the values that stand in the study, NaN as missing ones; add their faults."""
    data: DataColumns = {}
    for name, values in own.items():
        if not isinstance(values, list):
            study.faults.add((*path, name), "not a list of numbers", shown(values))
            continue
        column: list[float | None] = []
        for index, value in enumerate(values):
            is_missing = isinstance(value, float) and math.isnan(value)
            given = exact_phase(value)
            if not is_missing and (isinstance(value, bool) or phase_problem(given) is not None):
                study.faults.add((*path, name, index), "not a number", shown(value))
                break
            column.append(None if is_missing else as_float(given))
        data[name] = tuple(column)
    return data if len(data) == len(own) else None


def _noise(
    given: Any, data: DataColumns | None, path: Path, study: StudyDraft
) -> tuple[Exact | dict[str, Exact] | None, DataColumns]:
    """Return the noise, and that of each value; add their faults."""
    if given is None:
        return None, {}
    if isinstance(given, list):
        # As a study that is written holds the noise of each value.
        column = _lists({"noise": given}, path, study)
        return None, column or {}
    entries = given if isinstance(given, Mapping) else {"": given}
    for name, value in entries.items():
        place = (*path, "noise", name) if name else (*path, "noise")
        if isinstance(value, bool) or number_problem(value) is not None or not as_float(value) > 0:
            study.faults.add(place, NO_NOISE, shown(value))
            return None, {}
        if name and data is not None and name not in data:
            columns = ", ".join(key for key in data if key not in ("t", "noise"))
            study.faults.add(place, f"none of the record's {columns}", shown(value))
            return None, {}
    return (dict(given) if isinstance(given, Mapping) else given), {}


def _start(given: Any, path: Path, study: StudyDraft) -> Start | StructureStart | None:
    """Return the start of a record; add its faults."""
    if given is None:
        return None
    place = (*path, "start")
    if not isinstance(given, list) or not 2 <= len(given) <= 3:
        study.faults.add(place, NO_START, shown(given))
        return None
    if study.structure is not None:
        from percuss.studies.of_structures import checked_start

        read = [
            tuple(map(exact_phase, value)) if isinstance(value, list) else exact_phase(value)
            for value in given
        ]
        values = dict(zip(("x0", "v0", "t0"), [*read, 0.0], strict=False))
        return checked_start(draft(StructureStart, **values), study, place)
    numbers = [exact_phase(value) for value in given]
    for index, value in enumerate(numbers):
        problem = phase_problem(value) if index == 2 else number_problem(value)
        if isinstance(value, bool) or problem is not None:
            reason = "not a number" if problem is None else words_of_file(problem)
            study.faults.add((*place, index), reason, shown(given[index]))
            return None
    start = draft(Start, **dict(zip(("x0", "v0", "t0"), [*numbers, 0.0][:3], strict=True)))
    if study.has_right_model:
        for fault in start_faults(study.oscillator, start.x0, start.v0, start.t0, max_impacts=1):
            study.faults.add(place, words_of_file(fault.reason), shown(given))
    return start


def _settings(given: Mapping[str, Any], path: Path, study: StudyDraft) -> dict[str, Phase]:
    """Return the parameters of the forcing that are others in a record; add their faults."""
    settings: dict[str, Phase] = {}
    for name, raw in given.items():
        place, value = (*path, "settings", name), exact_phase(raw)
        problem = "not a number" if isinstance(raw, bool) else phase_problem(value)
        if problem is not None:
            study.faults.add(place, words_of_file(problem), shown(raw))
            continue
        settings[name] = value
        if not study.has_right_model:
            continue
        try:
            model, _, _ = replace_parameters(study.model, study.force, None, {name: value})
        except ParameterError as error:
            study.faults.add(place, words_of_file(error.reason), shown(raw))
            continue
        if model != study.model:
            of, force = study.model_tables
            reason = f"of the {of}, which all records share; only the {force} may differ"
            study.faults.add(place, reason, shown(raw))
    return settings


def _check_samples(
    record: FitRecord,
    start: Start | StructureStart | None,
    is_file: bool,
    path: Path,
    study: StudyDraft,
) -> None:
    """Add what is wrong with the values of a record together."""
    try:
        # Sizes of any kind are read here; what is too large for a motion the fit says.
        with np.errstate(all="ignore"):
            samples = read_samples(record.columns, record.deviation, study.model)
    except ParameterError as error:
        owner, _, name = error.name.partition(".")
        key = (*path, "noise") if owner == "noise" else (*path, "file") if is_file else path
        if not is_file and name in record.data:
            key = (*path, name)
        value = shown(error.value) if isinstance(error.value, int | float) else ""
        study.faults.add(key, words_of_noise(error.reason), value)
        return
    first = min(_first(some) for some in samples)
    if start is not None and first < as_float(start.t0):
        reason = f"the first value is of t = {first!r}, before the start at t0 = {start.t0}"
        study.faults.add((*path, "file") if is_file else path, reason)


def words_of_noise(reason: str) -> str:
    """Return a sentence about data in the words of a file."""
    return reason.replace("give a mapping by ", "write noise = {...} with a number for each of ")


def _first(samples: MeasuredSamples) -> float:
    return float(samples.t[0]) if len(samples) else math.inf
