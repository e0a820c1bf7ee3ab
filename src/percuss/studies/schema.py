"""The shape of what all study files share: tables, keys, kinds of value. No physics."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import PydanticCustomError

NO_NUMBER = 'not a number; write 2.8, or "2.8" for that decimal, "1/3" for that fraction'
NO_PHASE = f'{NO_NUMBER}, "pi/2" for that multiple of pi'

# As `percuss.certify` takes them.
MOST_DIGITS = 1000


def _is_number(value: object) -> bool:
    # Whether a text is a number is the model's question; true is an int for Python only.
    return not isinstance(value, bool) and isinstance(value, int | float | str)


def _number(value: object) -> object:
    if not _is_number(value):
        raise PydanticCustomError("number", NO_NUMBER)
    return value


def _phase(value: object) -> object:
    if not _is_number(value):
        raise PydanticCustomError("number", NO_PHASE)
    return value


Number = Annotated[int | float | str, BeforeValidator(_number)]
# May be a multiple of pi.
Phase = Annotated[int | float | str, BeforeValidator(_phase)]


class Table(BaseModel):
    """A table that knows all its keys."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class StudyTable(Table):
    """``[study]``: what is asked."""

    kind: str = "motion"
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
    """``[oscillator]``: x'' + 2 damping x' + stiffness x, or with a mass m x'' + c x' + k x."""

    stiffness: Number = 1.0
    damping: Number = 0.0
    mass: Number | None = None
    damping_coefficient: Number | None = None
    damping_ratio: Number | None = None
    stops: list[Annotated[WallTable | SoftTable, Field(discriminator="type")]] = []


class HarmonicTable(Table):
    """``[[forcing.harmonics]]``: amplitude cos(omega t + phase)."""

    amplitude: Number
    omega: Number
    phase: Phase = 0.0


class ForcingTable(Table):
    """``[forcing]``: a constant and harmonics, or the coefficients of a Fourier sum."""

    constant: Number = 0.0
    period: Phase | None = None
    harmonics: list[HarmonicTable] = []
    omega: Number | None = None
    cos: list[Number] = []
    sin: list[Number] = []


class StartTable(Table):
    """``[start]``: the state in which the motion begins."""

    x0: Number
    v0: Number
    t0: Phase = 0.0


class SaveTable(Table):
    """``[save]``: which files."""

    netcdf: bool = True
    csv: bool = True


class SampledSaveTable(SaveTable):
    """``[save]`` of what is sampled in time."""

    samples: Annotated[int, Field(ge=2, le=100_000_000)] = 2001


class DrawTable(Table):
    """``[draw]``: which pictures, and how."""

    png: bool = True
    svg: bool = True
    length_unit: str = ""
    time_unit: str = ""


class CertifyTable(Table):
    """``[certify]``: to how many digits the answer is proven."""

    digits: Annotated[int, Field(ge=1, le=MOST_DIGITS)] = 12


class Document(Table):
    """What a study file of any kind may hold; the kinds add their tables."""

    record: dict[str, object] = {}
    study: StudyTable = StudyTable()
    oscillator: OscillatorTable
    forcing: ForcingTable | None = None
    save: SaveTable = SaveTable()
    draw: DrawTable = DrawTable()


# Of a file whose kind is not known: what all kinds share is looked at, the rest is not.
class AnyDocument(Document):
    """A study file of no known kind."""

    model_config = ConfigDict(extra="ignore", strict=True, frozen=True)
