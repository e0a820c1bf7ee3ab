"""``[structure]`` and ``[[loads]]`` of a study file: matrices, modes or a mechanism, and forces."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path as FilePath
from typing import Annotated, Any

from pydantic import Field as KeyField
from pydantic import PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from percuss.errors import ParameterError
from percuss.model.exact import plain
from percuss.model.faults import Fault, draft, number_faults
from percuss.model.faults import faults as model_faults
from percuss.model.loads import Loads
from percuss.model.mechanisms import cantilever, chain, impact_pair, vibro_impact_absorber
from percuss.model.oscillator import plain_on
from percuss.model.structure import Structure, on_faults, structure_fields
from percuss.studies.matrix_file import read_matrix
from percuss.studies.model_tables import (
    FORCING,
    ForcingShape,
    RestitutionKey,
    Shape,
    Shapes,
    SoftShape,
    UnitsShape,
    WallShape,
    check_shape,
    forcing_of,
    list_of,
    stop_of,
    units_of_table,
)
from percuss.studies.tables import (
    MATRIX_FILES,
    MISSING,
    NumberKey,
    NumbersKey,
    OnKey,
    Path,
    PhaseKey,
    RawTable,
    StudyFaults,
    exact_phase,
    is_matrix_file,
    raw_table,
    shown,
)

NO_PLACE = "a study that is no file has no files beside it; give the numbers"
_MATRICES = ("mass", "stiffness", "damping")


def _matrix(value: object) -> object:
    rows = value if isinstance(value, list) else [value]
    numbers = [number for row in rows for number in (row if isinstance(row, list) else [row])]
    if not numbers or any(isinstance(number, bool | Mapping | list) for number in numbers):
        raise PydanticCustomError("matrix", NO_MATRIX)
    return value


NO_MATRIX = "neither rows of numbers, nor those of a diagonal, nor the name of a file"
MatrixKey = Annotated[
    Any, PlainValidator(_matrix), WithJsonSchema({"type": ["number", "string", "array"]})
]


class StructureWallShape(WallShape):
    """A wall on a structure."""

    on: OnKey = None


class StructureSoftShape(SoftShape):
    """A soft stop on a structure."""

    on: OnKey = None


class LoadShape(ForcingShape):
    """A force, and on what it acts."""

    on: OnKey = None


class ModesShape(Shape):
    """The arguments of `Structure.from_modes`."""

    frequencies: NumbersKey
    damping_ratios: NumbersKey = 0
    shapes: dict[str, NumbersKey]


class ChainShape(Shape):
    """The arguments of `chain`."""

    masses: NumbersKey
    springs: NumbersKey
    dashpots: NumbersKey = 0


class CantileverShape(Shape):
    """The arguments of `cantilever`."""

    n_modes: int
    length: NumberKey = 1
    bending_stiffness: NumberKey = 1
    mass_per_length: NumberKey = 1
    damping_ratio: NumbersKey = 0
    points: dict[str, NumberKey] | None = None


class ImpactPairShape(Shape):
    """The arguments of `impact_pair`."""

    masses: NumbersKey
    gap: NumberKey
    restitution: RestitutionKey = 1.0
    springs: NumbersKey = 0
    dashpots: NumbersKey = 0


class AbsorberShape(Shape):
    """The arguments of `vibro_impact_absorber`."""

    mass: NumberKey
    stiffness: NumberKey
    absorber_mass: NumberKey
    gap: NumberKey
    restitution: RestitutionKey = 1.0
    damping: NumberKey = 0
    absorber_damping: NumberKey = 0


class StructureShape(Shape):
    """The keys of ``[structure]``."""

    mass: MatrixKey = None
    stiffness: MatrixKey = None
    damping: MatrixKey = 0
    modes: ModesShape | None = None
    chain: ChainShape | None = None
    cantilever: CantileverShape | None = None
    impact_pair: ImpactPairShape | None = None
    absorber: AbsorberShape | None = None
    points: dict[str, NumbersKey] | None = None
    units: UnitsShape | None = None
    loads_period: PhaseKey | None = None
    stops: (
        list[Annotated[StructureWallShape | StructureSoftShape, KeyField(discriminator="type")]]
        | None
    ) = None


_MADE: dict[str, Callable[..., Structure]] = {
    "modes": Structure.from_modes,
    "chain": chain,
    "cantilever": cantilever,
    "impact_pair": impact_pair,
    "absorber": vibro_impact_absorber,
}
STRUCTURE = Shapes(
    StructureShape,
    {
        "units": UnitsShape,
        "modes": ModesShape,
        "chain": ChainShape,
        "cantilever": CantileverShape,
        "impact_pair": ImpactPairShape,
        "absorber": AbsorberShape,
    },
    {"wall": StructureWallShape, "soft": StructureSoftShape},
)
LOAD = Shapes(LoadShape, FORCING.inner)


def read_structure(
    document: RawTable, faults: StudyFaults, folder: FilePath | None
) -> tuple[Structure, Loads | None]:
    """Return the structure of a document and its loads, and add their faults.

    Parameters
    ----------
    document, faults, folder
        As `percuss.studies.reading.build_study` takes them.

    Returns
    -------
    Structure, Loads or None
        The model; drafts where they have faults.
    """
    table = raw_table(document, "structure")
    if isinstance(document["structure"], Mapping):
        check_shape(STRUCTURE, table, ("structure",), faults)
    structure = _StructureReader(table, folder, faults).structure()
    rows = document.get("loads", [])
    rows = rows if isinstance(rows, list) else []
    if not rows and "loads_period" in table:
        reason = "given without loads; there is nothing to repeat"
        faults.add(("structure", "loads_period"), reason, shown(table["loads_period"]))
    if not rows:
        return structure, None
    return structure, _loads(rows, table, structure, folder, faults)


class _StructureReader:
    """Makes the structure of a table, and adds its faults."""

    def __init__(self, table: RawTable, folder: FilePath | None, faults: StudyFaults) -> None:
        self.table, self.folder, self.faults = table, folder, faults
        self.units = units_of_table(table, "structure", faults)
        self.stops = tuple(stop_of(row) for row in list_of(table, "stops"))
        # By the key of a matrix the file that holds it.
        self.files: dict[str, str] = {}

    def structure(self) -> Structure:
        """Return the structure."""
        for i, stop in enumerate(self.stops):
            # Also where the matrices have faults, without which the others cannot be told.
            self.faults.add_from_model(model_faults(stop, f"structure.stops.{i}"))
        source = self._source()
        if source is None:
            return self._checked(self._given_matrices(), 0)
        made = self._made(source)
        if made is None:
            own = {"stops": self.stops, "units": self.units}
            return draft(Structure, mass=MISSING, stiffness=MISSING, damping=MISSING, **own)
        points = dict(made.points) | self._points()
        # Those of the mechanism come first, as in Python.
        fields = structure_fields(
            made.mass, made.stiffness, made.damping, (*made.stops, *self.stops), self.units, points
        )
        return self._checked(draft(Structure, **fields), len(made.stops))

    def _source(self) -> str | None:
        """Return the table from which the structure is made; None for matrices."""
        given = [name for name in _MADE if name in self.table]
        matrices = [name for name in _MATRICES if name in self.table]
        for name in (*given[1:], *(matrices if given else ())):
            reason = f"given together with structure.{given[0]}; a structure has one source"
            self.faults.add(("structure", name), reason)
        if not given and "mass" not in self.table:
            others = ", ".join(_MADE)
            reason = f"missing; give mass, stiffness and damping, or one of the tables {others}"
            self.faults.add(("structure", "mass"), reason)
        elif not given and "stiffness" not in self.table:
            self.faults.add(("structure", "stiffness"), "missing")
        return given[0] if given else None

    def _given_matrices(self) -> Structure:
        matrices = {name: self._matrix(name) for name in _MATRICES}
        fields = structure_fields(
            **matrices, stops=self.stops, units=self.units, points=self._points()
        )
        return draft(Structure, **fields)

    def _matrix(self, name: str) -> Any:
        """Return a matrix as it is given, or as its file holds it; a faulty one is `MISSING`."""
        path = ("structure", name)
        value = self.table.get(name, 0 if name == "damping" else MISSING)
        if self.faults.is_wrong(".".join(path)) or value is MISSING:
            return MISSING
        if not isinstance(value, str) or not (is_matrix_file(value) or _looks_like_file(value)):
            return value
        problem: str
        if not is_matrix_file(value):
            problem = f"not a file of a matrix; these end with {', '.join(MATRIX_FILES)}"
        elif self.folder is None:
            problem = NO_PLACE
        else:
            try:
                self.files[name] = value
                return read_matrix(self.folder / value, name)
            except OSError as error:
                problem = (error.strerror or "cannot be read").lower()
            except ValueError as error:
                problem = str(error)
        self.faults.add(path, problem, shown(value))
        return MISSING

    def _points(self) -> dict[str, Any]:
        points = self.table.get("points", {})
        if not isinstance(points, Mapping) or self.faults.is_wrong("structure.points"):
            return {}
        return {
            name: tuple(numbers) if isinstance(numbers, list) else numbers
            for name, numbers in points.items()
        }

    def _made(self, source: str) -> Structure | None:
        """Return the structure of modes or a mechanism, None with faults; add these."""
        table, path = raw_table(self.table, source), f"structure.{source}"
        if self.faults.is_wrong(path):
            return None
        arguments: dict[str, Any] = {}
        for name, value in table.items():
            self._check_numbers(f"{path}.{name}", value)
            arguments[name] = tuple(value) if isinstance(value, list) else value
        if isinstance(table.get("restitution"), Mapping):
            stop = stop_of({"type": "wall", "at": 0, "side": "above", **table})
            arguments["restitution"] = stop.restitution  # type: ignore[union-attr]
            self.faults.add_from_model(
                model_faults(arguments["restitution"], f"{path}.restitution")
            )
        if source == "modes":
            arguments.setdefault("damping_ratios", 0)
        if source == "cantilever" and not arguments.get("points"):
            arguments.pop("points", None)
        if self.faults.is_wrong(path):
            return None
        try:
            return _MADE[source](**arguments)
        except ParameterError as error:
            self.faults.add_from_model(
                [Fault(_argument(error.name, source, table), error.value, error.reason)]
            )
            return None

    def _check_numbers(self, path: str, value: Any) -> None:
        """Add the faults of all numbers of an argument, of which the model tells the first."""
        if isinstance(value, list):
            for i, number in enumerate(value):
                self.faults.add_from_model(number_faults(f"{path}.{i}", plain(number)))
        elif isinstance(value, Mapping) and not path.endswith(".restitution"):
            for name, inner in value.items():
                self._check_numbers(f"{path}.{name}", inner)
        elif not isinstance(value, Mapping):
            self.faults.add_from_model(number_faults(path, plain(value)))

    def _checked(self, structure: Structure, n_made: int) -> Structure:
        """Return the structure, and add its faults, of which some lie in what it was made of."""
        problems = model_faults(structure, "structure")
        if has_size(structure):
            # The model tells these of a structure without other faults only.
            for i, stop in enumerate(structure.stops):
                problems += on_faults(structure, stop.on, f"structure.stops.{i}.on")
        for fault in problems:
            self.faults.add_from_model([self._placed(fault, n_made)])
        return structure

    def _placed(self, fault: Fault, n_made: int) -> Fault:
        """Return a fault with the path that its value has in the file."""
        parts = fault.name.split(".")
        name = parts[1] if len(parts) > 1 else ""
        if name == "stops" and n_made and len(parts) > 2:
            index = int(parts[2])
            source = next(name for name in _MADE if name in self.table)
            place = f"structure.{source}" if index < n_made else None
            rest = ".".join([str(index - n_made), *parts[3:]])
            return Fault(place or f"structure.stops.{rest}", fault.value, fault.reason)
        if name in self.files and fault.value is not MISSING:
            entry = ".".join(parts[2:])
            reason = f"entry {entry} = {fault.value}: {fault.reason}" if entry else fault.reason
            return Fault(f"structure.{name}", self.files[name], reason)
        if name == "points" and "modes" in self.table and len(parts) > 2:
            point = parts[2]
            if point in raw_table(raw_table(self.table, "modes"), "shapes"):
                return Fault(
                    ".".join(["structure.modes.shapes", *parts[2:]]), fault.value, fault.reason
                )
        return fault


def has_size(structure: Structure) -> bool:
    """Return whether the matrices of a draft have one size, which is that of directions."""
    matrices = [getattr(structure, name) for name in _MATRICES]
    return all(
        isinstance(matrix, tuple)
        and matrix != ((MISSING,),)
        and len(matrix) == len(matrices[0])
        and all(isinstance(row, tuple) and len(row) == len(matrix) for row in matrix)
        for matrix in matrices
    )


def _looks_like_file(value: str) -> bool:
    """Return whether a text that is no number was meant as the name of a file."""
    return bool(number_faults("", value)) and "." in value


def _argument(name: str, source: str, table: RawTable) -> str:
    """Return the path of an argument of a mechanism, of which the model tells a fault."""
    first, _, rest = name.partition(".")
    if source == "modes" and first == "points":
        first = "shapes"
    if first in table or first in STRUCTURE.inner[source].model_fields:
        return ".".join(["structure", source, first, *([rest] if rest else [])])
    return f"structure.{source}"


def _loads(
    rows: list[Any],
    table: RawTable,
    structure: Structure,
    folder: FilePath | None,
    faults: StudyFaults,
) -> Loads:
    """Return the loads, and add their faults."""
    items, units = [], getattr(structure, "units", None)
    for i, row in enumerate(rows):
        path: Path = ("loads", i)
        own = row if isinstance(row, Mapping) else {}
        check_shape(LOAD, own, path, faults)
        on = plain_on(own.get("on"))
        if on is None and has_size(structure) and structure.n == 1:
            on = 0
        items.append((on, forcing_of(own, path, folder, faults, units=units)))
        if has_size(structure) and not any(map(faults.is_wrong, (*_MADE_OF, f"loads.{i}.on"))):
            faults.add_from_model(on_faults(structure, on, f"loads.{i}.on"))
    period = exact_phase(table.get("loads_period"))
    loads = draft(Loads, items=tuple(items), period=period)
    for fault in model_faults(loads, "loads"):
        if fault.name == "loads.period":
            faults.add_from_model([replace(fault, name="structure.loads_period")])
        elif fault.name.count(".") > 1:
            # What it acts on has been checked against the structure.
            faults.add_from_model([fault])
    return loads


# With faults of these there is no structure, and nothing that a load could act on.
_MADE_OF = tuple(f"structure.{name}" for name in _MADE)
