"""Studies of the Lyapunov exponents of a motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, ClassVar

from pydantic import Field

from percuss.io.study_text import start_table
from percuss.model.start import Start
from percuss.studies.kinds.starting import checked_start
from percuss.studies.parts import Parts
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import Document, StartTable, Table

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.studies.study import Study

__all__ = ["KIND", "Lyapunov"]


class LyapunovTable(Table):
    """``[lyapunov]``: when the exponents are taken."""

    transient: Annotated[int, Field(ge=0)] = 1000
    # The error comes from the means of 64 blocks.
    periods: Annotated[int, Field(ge=64)] = 20_000


class LyapunovDocument(Document):
    """A study file of exponents."""

    start: StartTable | None = None
    lyapunov: LyapunovTable = LyapunovTable()


@dataclass(frozen=True, slots=True)
class Lyapunov:
    """Both Lyapunov exponents of the motion from a start, as `lyapunov_exponents` takes them."""

    kind: ClassVar[str] = "lyapunov"
    doing: ClassVar[str] = "following the motion and its neighbours"
    stem: ClassVar[str] = "lyapunov"
    is_ensemble: ClassVar[bool] = False

    start: Start
    transient: int = 1000
    periods: int = 20_000

    def tables(self) -> dict[str, object]:
        """Return ``[start]`` and ``[lyapunov]``."""
        own = {"transient": self.transient, "periods": self.periods}
        return {"start": start_table(self.start), "lyapunov": own}

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return the exponents."""
        return {"lyapunov": "table"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return none: two numbers make no picture."""
        return {}

    def answer(self, study: Study, means: Means) -> Dataset:  # noqa: ARG002
        """Take them."""
        import xarray

        from percuss.ensembles import lyapunov_exponents

        found = lyapunov_exponents(
            study.oscillator,
            study.forcing,
            start=self.start,
            transient=self.transient,
            periods=self.periods,
        )
        rate = {"units": "1/time"}
        data = {
            "exponent": ("number", found.exponents, rate),
            "error": ("number", found.errors, rate),
        }
        scalars = {"total": found.total, "impact_rate": found.impact_rate}
        return xarray.Dataset(
            data | {name: ((), value, rate) for name, value in scalars.items()},
            attrs={"duration": found.duration},
        )

    def report(self, result: Dataset) -> dict[str, str]:
        """Tell the exponents, their errors and their sum."""
        pairs = zip(result.exponent.values, result.error.values, strict=True)
        (first, second) = (f"{value:.8g} +- {error:.1g}" for value, error in pairs)
        total = float(result.exponent.sum())
        return {
            "largest": f"{first} per time",
            "smallest": f"{second} per time",
            "their sum": f"{total:.8g}; by the sum rule {float(result.total):.8g}",
            "impacts": f"{float(result.impact_rate):.8g} per time",
        }


def build(parts: Parts) -> Lyapunov | None:
    """Return the question of a document, None if it has faults."""
    parts.needs_period("exponents are taken over forcing periods")
    start = checked_start(parts)
    return None if parts.found.faults else Lyapunov(start, **parts.keys("lyapunov"))


KIND = Kind(LyapunovDocument, build)
