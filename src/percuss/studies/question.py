"""What every kind of study has to say about itself: the one place where kinds meet."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeAlias

from percuss.studies.parts import Parts
from percuss.studies.schema import Document

if TYPE_CHECKING:
    from percuss.studies.study import Study

__all__ = ["Kind", "Means", "Picture", "Question"]

Progress: TypeAlias = Callable[[float, float], bool]
# Draws a result of a study on an empty figure.
Picture: TypeAlias = "Callable[[Any, Study, Any], None]"


@dataclass(frozen=True, slots=True)
class Means:
    """How a study is run, which changes nothing about its answer.

    Attributes
    ----------
    store
        Folder of a Zarr store that a long run goes into and is resumed from; or None.
    engine
        "threads", "processes" or the address of a Dask scheduler.
    progress
        As in `percuss.simulate`.
    """

    store: Path | None = None
    engine: str = "threads"
    progress: Progress | bool | None = None


class Question(Protocol):
    """What a study asks, with all it needs besides the model; a frozen value.

    Attributes
    ----------
    kind
        Its name in ``[study]``.
    doing
        What is being done while it is answered, before a bar.
    stem
        Name of the NetCDF file, without suffix.
    is_ensemble
        Whether it is answered chunk by chunk, into a store and on an engine where wanted.
    """

    kind: ClassVar[str]
    doing: ClassVar[str]
    stem: ClassVar[str]
    is_ensemble: ClassVar[bool]

    def tables(self) -> dict[str, object]:
        """Return the tables of its own in a study file."""

    def csv(self, study: Study) -> Mapping[str, str]:
        """Return the tables saved as CSV, by the stem of the file."""

    def pictures(self, study: Study) -> Mapping[str, Picture]:
        """Return what draws its pictures, by the stem of the file."""

    def answer(self, study: Study, means: Means) -> Any:
        """Return the result."""

    def report(self, result: Any) -> dict[str, str]:
        """Return what was found, in a few lines: words by what they are about."""


@dataclass(frozen=True, slots=True)
class Kind:
    """A kind of study.

    Attributes
    ----------
    shape
        The tables and keys of its files.
    build
        Makes the question of the tables, None if they have faults; adds these to those found.
    """

    shape: type[Document]
    build: Callable[[Parts], Question | None]
