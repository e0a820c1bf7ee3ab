"""The shape of a study file: which tables, which keys, what kind of value. No physics."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

NO_NUMBER = 'not a number; write 2.8, or "2.8" for that decimal'


def _number(value: object) -> object:
    # Whether a text is a number is the model's question; true is an int for Python only.
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise PydanticCustomError("number", NO_NUMBER)
    return value


Number = Annotated[int | float | str, BeforeValidator(_number)]


class Table(BaseModel):
    """A table that knows all its keys."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class StudyTable(Table):
    """``[study]``: what is asked."""

    kind: Literal["motion"] = "motion"
    title: str = ""


class WallTable(Table):
    """``[[oscillator.stops]]`` with ``type = "wall"``."""

    type: Literal["wall"]
    at: Number
    side: Literal["above", "below"]
    restitution: Number = 1.0


class SoftTable(Table):
    """``[[oscillator.stops]]`` with ``type = "soft"``."""

    type: Literal["soft"]
    at: Number
    side: Literal["above", "below"]
    stiffness: Number
    damping: Number = 0.0


class OscillatorTable(Table):
    """``[oscillator]``: x'' + 2 damping x' + stiffness x."""

    stiffness: Number = 1.0
    damping: Number = 0.0
    stops: list[Annotated[WallTable | SoftTable, Field(discriminator="type")]] = []


class HarmonicTable(Table):
    """``[[forcing.harmonics]]``: amplitude cos(omega t + phase)."""

    amplitude: Number
    omega: Number
    phase: Number = 0.0


class ForcingTable(Table):
    """``[forcing]``: a constant and harmonics, or the coefficients of a Fourier sum."""

    constant: Number = 0.0
    period: Number | None = None
    harmonics: list[HarmonicTable] = []
    omega: Number | None = None
    cos: list[Number] = []
    sin: list[Number] = []


class StartTable(Table):
    """``[start]``: the state in which the motion begins."""

    x0: Number
    v0: Number
    t0: Number = 0.0


class RunTable(Table):
    """``[run]``: how long the motion is followed."""

    t_end: Number | None = None
    periods: Number | None = None
    max_impacts: int | None = None


class SaveTable(Table):
    """``[save]``: which files."""

    netcdf: bool = True
    csv: bool = True
    samples: Annotated[int, Field(ge=2, le=100_000_000)] = 2001


class DrawTable(Table):
    """``[draw]``: which pictures, and how."""

    png: bool = True
    svg: bool = True
    window: Annotated[list[Number], Field(min_length=2, max_length=2)] | None = None
    length_unit: str = ""
    time_unit: str = ""


class Document(Table):
    """A whole study file."""

    record: dict[str, object] = {}
    study: StudyTable = StudyTable()
    oscillator: OscillatorTable
    forcing: ForcingTable | None = None
    start: StartTable
    run: RunTable
    save: SaveTable = SaveTable()
    draw: DrawTable = DrawTable()
