"""The oscillator and the forcing of a study file, with every fault of their shape and physics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field
from pydantic import ValidationError as ShapeError

from percuss.errors import ParameterError
from percuss.io.study_text import forcing_table, number, stop_table
from percuss.model import exact
from percuss.model.faults import Fault, damping_faults, draft, positive_faults
from percuss.model.faults import faults as model_faults
from percuss.model.forcing import Forcing
from percuss.model.harmonics import FourierTerm, Harmonic
from percuss.model.oscillator import Oscillator
from percuss.model.stops import SoftStop, Stop, Wall
from percuss.studies.faults import MISSING, StudyFaults, shown, unknown_key
from percuss.studies.tables import NumberKey, PhaseKey, RawTable, exact_phase, raw_table, sentence

__all__ = ["EngineersModel", "read_model"]

ModelPart = TypeVar("ModelPart", Wall, SoftStop, Harmonic)

_FOURIER = ("omega", "cos", "sin")
_DAMPINGS = ("damping_coefficient", "damping_ratio")


class _Shape(BaseModel):
    """A table of the model that knows all its keys; its numbers are the model's question."""

    model_config = ConfigDict(extra="forbid", strict=True, arbitrary_types_allowed=True)


class _WallShape(_Shape):
    type: Literal["wall"]
    at: NumberKey
    side: Literal["above", "below"]
    restitution: NumberKey = 1.0


class _SoftShape(_Shape):
    type: Literal["soft"]
    at: NumberKey
    side: Literal["above", "below"]
    stiffness: NumberKey
    damping: NumberKey = 0.0


class _OscillatorShape(_Shape):
    stiffness: NumberKey = 1.0
    damping: NumberKey = 0.0
    mass: NumberKey | None = None
    damping_coefficient: NumberKey | None = None
    damping_ratio: NumberKey | None = None
    stops: list[Annotated[_WallShape | _SoftShape, Field(discriminator="type")]] = []


class _HarmonicShape(_Shape):
    amplitude: NumberKey
    omega: NumberKey
    phase: PhaseKey = 0.0


class _ForcingShape(_Shape):
    constant: NumberKey = 0.0
    period: PhaseKey | None = None
    harmonics: list[_HarmonicShape] = []
    omega: NumberKey | None = None
    cos: list[NumberKey] = []
    sin: list[NumberKey] = []


_SHAPES: dict[str, type[_Shape]] = {"oscillator": _OscillatorShape, "forcing": _ForcingShape}
_STOPS: dict[object, type[_Shape]] = {"wall": _WallShape, "soft": _SoftShape}


@dataclass(frozen=True, slots=True)
class EngineersModel:
    """An oscillator and its forcing in engineers' units, before they are divided by the mass.

    Parameters
    ----------
    mass, stiffness, damping_coefficient, damping_ratio, stops
        As `Oscillator.from_mass` takes them.
    forcing
        The force on the mass [force]; or None.

    Examples
    --------
    >>> from percuss.model import cosine
    >>> model = EngineersModel(mass=2.0, stiffness=50.0, forcing=cosine(3.0, amplitude=5.0))
    >>> model.oscillator().stiffness, model.forcing_per_mass().harmonics[0].amplitude
    (25.0, 2.5)
    """

    mass: exact.Exact
    stiffness: exact.Exact
    damping_coefficient: exact.Exact | None = None
    damping_ratio: exact.Exact | None = None
    stops: tuple[Stop, ...] = ()
    forcing: Forcing | None = None

    def oscillator(self) -> Oscillator:
        """Return the oscillator of unit mass."""
        return Oscillator.from_mass(
            self.mass, self.stiffness, self.damping_coefficient, self.damping_ratio, self.stops
        )

    def forcing_per_mass(self) -> Forcing | None:
        """Return the forcing divided by the mass."""
        return None if self.forcing is None else self.forcing.per_mass(self.mass)

    def tables(self) -> dict[str, object]:
        """Return the model as the tables of a study."""
        names = ("mass", "stiffness", "damping_coefficient", "damping_ratio")
        given = {name: getattr(self, name) for name in names}
        row = {name: number(value) for name, value in given.items() if value is not None}
        stops = [stop_table(stop) for stop in self.stops] or None
        tables: dict[str, object] = {"oscillator": {**row, "stops": stops}}
        if self.forcing is not None:
            tables["forcing"] = forcing_table(self.forcing)
        return tables


def read_model(
    document: RawTable, faults: StudyFaults
) -> tuple[Oscillator, Forcing | None, EngineersModel | None]:
    """Return the model of a document, and add what is wrong with it.

    Parameters
    ----------
    document
        The tables as `tomllib` reads them.
    faults
        The faults found so far.

    Returns
    -------
    Oscillator, Forcing or None, EngineersModel or None
        What moves under what force, drafts where they have faults; and both in engineers' units
        if a mass is given and nothing is wrong.
    """
    for name in _SHAPES:
        if isinstance(document.get(name), Mapping):
            _check_shape(name, document[name], faults)
    table = raw_table(document, "oscillator")
    oscillator = _oscillator(table, faults)
    forcing = _forcing(raw_table(document, "forcing"), faults) if "forcing" in document else None
    given = _engineers_model(table, oscillator, forcing, faults)
    if given is not None:
        oscillator, forcing = _per_mass(given, faults)
    return oscillator, forcing, given


def _check_shape(name: str, table: RawTable, faults: StudyFaults) -> None:
    """Add the faults of the shape of a table: unknown keys, missing keys, wrong types."""
    shape = _SHAPES[name]
    try:
        shape.model_validate(table)
    except ShapeError as error:
        for wrong in error.errors(include_url=False):
            place, kind, value = wrong["loc"], wrong["type"], wrong["input"]
            known = shape
            if place[:1] == ("stops",) and place[2:3] in (("wall",), ("soft",)):
                # pydantic puts the type of a stop into its path.
                known, place = _STOPS[place[2]], (*place[:2], *place[3:])
            elif place[:1] == ("harmonics",) and len(place) > 1:
                known = _HarmonicShape
            path = (name, *place)
            if kind == "extra_forbidden":
                faults.add(path, unknown_key(path[-1], list(known.model_fields)))
            elif kind == "union_tag_not_found":
                _add_missing_type(path, value, faults)
            elif kind == "union_tag_invalid":
                faults.add((*path, "type"), sentence(wrong), shown(value["type"]))
            elif kind == "missing":
                is_side = path[-1] == "side"
                faults.add(path, 'missing; "above" or "below"' if is_side else "missing")
            elif kind == "list_type" and path[-1] in ("stops", "harmonics"):
                reason = f"not a list; begin each of them with [[{'.'.join(map(str, path))}]]"
                faults.add(path, reason, shown(value))
            else:
                faults.add(path, sentence(wrong), shown(value))


def _add_missing_type(path: tuple[str | int, ...], stop: RawTable, faults: StudyFaults) -> None:
    """Add what is wrong with a stop without a type, whose other keys are not checked yet."""
    known = list(dict.fromkeys(key for shape in _STOPS.values() for key in shape.model_fields))
    for key in stop:
        if key not in known:
            faults.add((*path, key), unknown_key(key, known))
    faults.add((*path, "type"), 'missing; "wall" or "soft"')


def _oscillator(table: RawTable, faults: StudyFaults) -> Oscillator:
    stops = tuple(_stop(row) for row in _rows(table, "stops"))
    values = {"stiffness": 1.0, "damping": 0.0}
    values = {name: table.get(name, value) for name, value in values.items()}
    oscillator = draft(Oscillator, **values, stops=stops)
    faults.add_from_model(model_faults(oscillator, "oscillator"))
    return oscillator


def _stop(row: Any) -> Wall | SoftStop:
    needed = {"at": MISSING, "side": MISSING}
    kind = row.get("type") if isinstance(row, Mapping) else None
    if kind == "soft":
        return _drafted(SoftStop, row, {**needed, "stiffness": MISSING, "damping": 0.0})
    # What is neither has a fault already; as a wall without a place it gets no second one.
    return _drafted(Wall, row, {**needed, "restitution": 1.0})


def _engineers_model(
    table: RawTable, oscillator: Oscillator, forcing: Forcing | None, faults: StudyFaults
) -> EngineersModel | None:
    """Return the model in engineers' units if a mass is given and nothing is wrong with it."""
    dampings = {name: table[name] for name in _DAMPINGS if name in table}
    if "mass" not in table:
        for name in dampings:
            faults.add(
                ("oscillator", name), "needs oscillator.mass; mass = 1 leaves all else as it is"
            )
        return None
    faults.add_from_model(positive_faults("oscillator.mass", table["mass"]))
    for name, value in dampings.items():
        faults.add_from_model(damping_faults(f"oscillator.{name}", value))
    if "stiffness" not in table:
        faults.add(("oscillator", "stiffness"), "missing; with a mass it has no default")
    if "damping" in table:
        reason = "given together with mass; give damping_coefficient or damping_ratio"
        faults.add(("oscillator", "damping"), reason, shown(table["damping"]))
    if faults.is_wrong("oscillator") or faults.is_wrong("forcing"):
        return None
    return EngineersModel(
        table["mass"], table["stiffness"], **dampings, stops=oscillator.stops, forcing=forcing
    )


def _per_mass(given: EngineersModel, faults: StudyFaults) -> tuple[Oscillator, Forcing | None]:
    """Return the oscillator and the forcing of unit mass; add what the division makes wrong."""
    oscillator, forcing = Oscillator(stops=given.stops), given.forcing
    owner = "oscillator"
    try:
        oscillator = given.oscillator()
        owner = "forcing"
        forcing = given.forcing_per_mass()
    except ParameterError as error:
        if error.name in _DAMPINGS:
            faults.add_from_model([Fault(f"{owner}.{error.name}", error.value, error.reason)])
        else:
            reason = f"after the division by it, {owner}.{error.name} is {error.reason}"
            faults.add(("oscillator", "mass"), reason, shown(given.mass))
    return oscillator, forcing


def _forcing(table: RawTable, faults: StudyFaults) -> Forcing:
    constant, period = table.get("constant", 0.0), table.get("period")
    given = [name for name in _FOURIER if name in table]
    if not given:
        harmonics = tuple(_harmonic(row) for row in _rows(table, "harmonics"))
        forcing = draft(Forcing, harmonics=harmonics, constant=constant, period=exact_phase(period))
    else:
        for name in ("harmonics", "period"):
            if name in table:
                reason = f"given together with {given[0]}; omega, cos and sin stand alone"
                faults.add(("forcing", name), reason)
        if "omega" not in table:
            faults.add(("forcing", "omega"), "missing; cos and sin need the base frequency")
        forcing = _fourier(table, constant)
    faults.add_from_model(model_faults(forcing, "forcing"))
    return forcing


def _harmonic(row: Any) -> Harmonic:
    given = dict(row) if isinstance(row, Mapping) else {}
    if "phase" in given:
        given["phase"] = exact_phase(given["phase"])
    return _drafted(Harmonic, given, {"amplitude": MISSING, "omega": MISSING, "phase": 0.0})


def _fourier(table: RawTable, constant: Any) -> Forcing:
    cos, sin = _rows(table, "cos"), _rows(table, "sin")
    count = max(len(cos), len(sin))
    pairs = zip(*(values + [0.0] * (count - len(values)) for values in (cos, sin)), strict=True)
    terms = tuple(draft(FourierTerm, n=n, cos=c, sin=s) for n, (c, s) in enumerate(pairs, 1))
    base = table.get("omega", MISSING)
    return draft(Forcing, harmonics=terms, constant=constant, base=base)


def _rows(table: RawTable, name: str) -> list[Any]:
    """Return a list in a table, empty where there is none."""
    rows = table.get(name, [])
    return rows if isinstance(rows, list) else []


def _drafted(kind: type[ModelPart], row: Any, defaults: RawTable) -> ModelPart:
    """Return a part of the model from the keys that a row has, not checked."""
    given = row if isinstance(row, Mapping) else {}
    return draft(kind, **{name: given.get(name, value) for name, value in defaults.items()})
