"""``[forcing.record]`` of a study file: samples in the study, or in a table beside it."""

from __future__ import annotations

from pathlib import Path as FilePath
from typing import Any, TypeAlias

from percuss.errors import ParameterError
from percuss.model.exact import Exact
from percuss.model.faults import draft
from percuss.model.force_record import ForceRecord, Outside, RecordKind
from percuss.model.forcing import Forcing
from percuss.model.units import Units
from percuss.model.waves import record
from percuss.studies.tables import Path, RawTable, StudyFaults, exact_phase, shown

Samples: TypeAlias = tuple[tuple[Any, ...], tuple[Any, ...]]

PATH: Path = ("forcing", "record")
NO_PLACE = "a study that is no file has no files beside it; give t and f"


def read_record(
    path: FilePath | str,
    time: str = "t",
    force: str = "f",
    *,
    kind: RecordKind = "linear",
    repeat: bool = False,
    outside: Outside = "end",
    amplitude: Exact | None = None,
    units: Units | None = None,
    per_mass: bool = False,
) -> Forcing:
    r"""Return the force in a table as spreadsheets and data loggers save it.

    Commas, semicolons or tabs separate its columns, numbers may have decimal commas; lines above
    the names and those that begin with # are notes.

    Parameters
    ----------
    path
        The file.
    time, force
        Names of the columns, with their units or without.
    kind, repeat, outside
        As `record` takes them.
    amplitude
        Factor of the force, default 1; of a column of another quantity, such as the elevation of
        waves, the force of each unit of it, in those of the model where both have units.
    units
        Those of the model, into which columns with a unit are converted.
    per_mass
        Whether the force is an acceleration, of an oscillator with a mass.

    Returns
    -------
    Forcing
        With the record.

    Raises
    ------
    ParameterError
        With all faults of the table and their lines.
    OSError
        If the file cannot be read.

    Examples
    --------
    >>> import tempfile, percuss as pc
    >>> file = FilePath(tempfile.mkdtemp()) / "wave.csv"
    >>> _ = file.write_text("Buoy 7\n\nt (ms);f [kN]\n0;0,5\n500;2\n")
    >>> pc.read_record(file, units=pc.Units("m", "s", "kg")).record
    ForceRecord(t=(0.0, 0.5), f=(500.0, 2000.0), kind='linear', repeat=False, outside='end')
    """
    from percuss.fitting.data_file import forces_of_text, text_of_file

    if units is not None and not isinstance(units, Units):
        raise ParameterError("units", units, 'not a Units; write Units("m", "s", "kg")')
    try:
        t, f = forces_of_text(
            text_of_file(FilePath(path)),
            units,
            time,
            force,
            quantity=quantity_of_force(units, per_mass),
            has_amplitude=amplitude is not None,
        )
    except ValueError as error:
        raise ParameterError("path", str(path), str(error)) from error
    read = record(t, f, kind, repeat, outside)
    strength = read if amplitude is None else read * amplitude
    return strength.per_mass(1) if per_mass else strength


def record_of(
    table: RawTable,
    folder: FilePath | None,
    faults: StudyFaults,
    path: Path = PATH,
    *,
    units: Units | None = None,
    is_per_mass: bool = False,
) -> ForceRecord | None:
    """Return the record of a table, not checked by the model; None where it has no samples.

    Parameters
    ----------
    table
        The table ``[forcing.record]``.
    folder
        The folder of the study file, None for a study without one.
    faults
        The faults found so far.
    path
        Where the table stands.
    units
        Those of the model, which units in the heads of columns have to fit.
    is_per_mass
        Whether the force is an acceleration of a model with a mass.
    """
    samples = _samples(table, folder, faults, path, units, quantity_of_force(units, is_per_mass))
    if samples is None:
        return None
    defaults = {"kind": "linear", "repeat": False, "outside": "end", "amplitude": 1, "omega": None}
    given = {name: table.get(name, value) for name, value in defaults.items()}
    return draft(ForceRecord, t=samples[0], f=samples[1], **given)


def quantity_of_force(units: Units | None, is_per_mass: bool) -> str:
    """Return what the unit of a record's forces is of: without units of a model of either."""
    if units is None:
        return "stop_force"
    return "force" if units.mass and not is_per_mass else "acceleration"


def _samples(
    table: RawTable,
    folder: FilePath | None,
    faults: StudyFaults,
    path: Path,
    units: Units | None,
    quantity: str,
) -> Samples | None:
    if "file" in table:
        for name in ("t", "f"):
            if name in table:
                faults.add((*path, name), "given together with file; give one of the two")
        if folder is None:
            faults.add((*path, "file"), NO_PLACE, shown(table["file"]))
        elif isinstance(table["file"], str):
            return _columns(folder / table["file"], table, faults, path, units, quantity)
        return None
    for name in ("t", "f"):
        if name not in table:
            faults.add((*path, name), "missing; give t and f, or a file")
    t, f = table.get("t"), table.get("f")
    if not isinstance(t, list) or not isinstance(f, list):
        return None
    return tuple(exact_phase(value) for value in t), tuple(f)


def _columns(
    file: FilePath,
    table: RawTable,
    faults: StudyFaults,
    path: Path,
    units: Units | None,
    quantity: str,
) -> Samples | None:
    """Return the columns of a file that a record names, or add all its faults as one."""
    # Few studies need it.
    from percuss.fitting.data_file import forces_of_text, text_of_file

    given: dict[str, Any] = {"has_omega": "omega" in table, "has_amplitude": "amplitude" in table}
    names = str(table.get("time", "t")), str(table.get("force", "f"))
    try:
        text = text_of_file(file)
        t, f = forces_of_text(text, units, *names, quantity=quantity, **given)
        return tuple(t.tolist()), tuple(f.tolist())
    except OSError as error:
        words = error.strerror or "not readable"
        faults.add((*path, "file"), words.lower(), shown(str(table["file"])))
    except ValueError as error:
        faults.add((*path, "file"), str(error), shown(str(table["file"])))
    return None
