"""Studies of the Lyapunov exponents of a motion."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, ClassVar, Self

from pydantic import Field

from percuss.ensembles.lyapunov import lyapunov_exponents
from percuss.execution import Execution
from percuss.studies.study import (
    AT_REST,
    Picture,
    Question,
    StudyDraft,
    check_start,
)
from percuss.studies.tables import StartState, Whole, default, table

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.studies.study import Study


@table
class Lyapunov(Question):
    """The Lyapunov exponents of the motion from a start, as `lyapunov_exponents` takes them."""

    doing: ClassVar = "following the motion and its neighbours"
    columns: ClassVar = {"lyapunov": "table"}

    start: StartState = AT_REST
    transient: Whole = default(lyapunov_exponents, "transient")
    # The error comes from the means of 64 blocks.
    periods: Annotated[Whole, Field(ge=64)] = default(lyapunov_exponents, "periods")

    def checked(self, study: StudyDraft) -> Self:
        """Check the period of the forcing and the start."""
        if study.force is not None and not study.force.is_constant:
            study.needs_period("exponents are taken over forcing periods")
        if study.structure is not None:
            from percuss.studies.of_structures import checked_start

            return replace(self, start=checked_start(self.start, study))
        check_start(self.start, study)
        return self

    def answer(self, study: Study, execution: Execution) -> Dataset:  # noqa: ARG002
        """Return the exponents as a dataset."""
        import xarray

        rates = lyapunov_exponents(study.model, study.force, **self.arguments())
        rate = {"units": "1/time"}
        data = {
            "exponent": ("number", rates.exponents, rate),
            "error": ("number", rates.errors, rate),
        }
        scalars = {"total": rates.total, "impact_rate": rates.impact_rate}
        return xarray.Dataset(
            data | {name: ((), value, rate) for name, value in scalars.items()},
            attrs={"duration": rates.duration},
        )

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return none: two numbers make no picture."""
        return {}

    def report(self, result: Dataset) -> dict[str, str]:
        """Return the exponents, their errors and their sum."""
        pairs = zip(result.exponent.values, result.error.values, strict=True)
        (first, *others, last) = (f"{value:.8g} ± {error:.1g}" for value, error in pairs)
        between = (
            {"the others": "\n".join(f"{exponent} per time" for exponent in others)}
            if others
            else {}
        )
        total = float(result.exponent.sum())
        return {
            "largest": f"{first} per time",
            **between,
            "smallest": f"{last} per time",
            "their sum": f"{total:.8g}; by the sum rule {float(result.total):.8g}",
            "impacts": f"{float(result.impact_rate):.8g} per time",
        }
