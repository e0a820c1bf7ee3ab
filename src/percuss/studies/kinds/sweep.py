"""Studies of a measure over any grid of parameters and starts."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import BeforeValidator

from percuss.ensembles import sweep
from percuss.ensembles.measures import MEASURES
from percuss.ensembles.sweep import SAME_NAME
from percuss.execution import Execution
from percuss.studies.axes import OverAxes, over_of, values_over
from percuss.studies.study import (
    AT_REST,
    Picture,
    Question,
    StudyDraft,
    check_start,
    ends_of,
    failure_rows,
    titled_axes,
)
from percuss.studies.tables import (
    MISSING,
    Count,
    StartState,
    Text,
    Whole,
    default,
    raw_table,
    shown,
    table,
    unknown_value,
)

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.studies.study import Study

__all__ = ["Sweep"]


def _as_list(value: object) -> object:
    return [value] if isinstance(value, str) else [] if value is MISSING else value


@table
class Sweep(Question):
    """Measures over a grid, as `percuss.sweep` takes them.

    Parameters
    ----------
    measure
        Names of built-in measures.
    over
        The axes by path.
    start
        Where the motions start.
    transient, periods, max_impacts
        As there; None is the default.
    """

    doing: ClassVar = "measuring"
    is_ensemble: ClassVar = True
    needed: ClassVar = ("over", "sweep")
    columns: ClassVar = {"sweep": "table"}

    measure: Annotated[tuple[Text, ...], BeforeValidator(_as_list)]
    over: OverAxes
    start: StartState = AT_REST
    transient: Whole = default(sweep, "transient")
    periods: Count = default(sweep, "periods")
    max_impacts: Count | None = None

    def checked(self, study: StudyDraft) -> Self:
        """Check the measures, the period of the forcing and the start, and read the axes."""
        path, known = ("sweep", "measure"), list(MEASURES)
        is_one = isinstance(raw_table(study.document, "sweep").get("measure"), str)
        for index, name in enumerate(self.measure):
            if name in self.over:
                study.faults.add(("over", name), SAME_NAME)
            if name not in MEASURES:
                place = path if is_one else (*path, index)
                study.faults.add(place, unknown_value(name, known), shown(name))
        if not self.measure:
            study.faults.add(path, f"none at all; there are {', '.join(MEASURES)}", "[]")
        study.needs_period("measures count in forcing periods")
        check_start(self.start, study)
        return replace(self, over=values_over(study, None, self.start))

    def answer(self, study: Study, execution: Execution) -> Dataset:
        """Return the measures at each point."""
        arguments = self.arguments() | {"over": over_of(self.over)} | execution.keywords()
        if self.max_impacts is None:
            del arguments["max_impacts"]
        return sweep(osc=study.oscillator, force=study.forcing, **arguments)

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return a picture of each measure over one axis or two."""
        if len(self.over) > 2:
            return {}
        several = len(self.measure) > 1
        return {name if several else "sweep": _draw(name, len(self.over)) for name in self.measure}

    def report(self, result: Dataset) -> dict[str, str]:
        """Return the grid, the range of each measure, and what failed."""
        n_points = int(np.prod([result.sizes[dim] for dim in result[self.measure[0]].dims]))
        rows = {"points": f"{n_points:,}", "over": ends_of(result)}
        for name in self.measure:
            rows[name] = _range(name, result[name].values.ravel())
        return rows | failure_rows([str(text) for text in result.reason.values], n_points)


def _range(measure: str, values: Any) -> str:
    values = values[~np.isnan(values)]
    if values.size == 0:
        return "no values"
    if measure == "period":
        periods, counts = np.unique(values.astype(int), return_counts=True)
        most = sorted(zip(counts.tolist(), periods.tolist(), strict=True), reverse=True)[:6]
        return ", ".join(f"{period or 'none found'}: {count:,}" for count, period in most)
    finite = values[np.isfinite(values)]
    # An exponent is -inf after a contact, which ends all memory.
    words = [f"{finite.min():.8g} to {finite.max():.8g}"] if finite.size else []
    words += [f"-inf at {values.size - finite.size:,} points"] if finite.size < values.size else []
    return "; ".join(words)


def _draw(measure: str, n_axes: int) -> Picture:
    def draw(result: Any, study: Study, figure: Any) -> None:
        from percuss.plotting import plot_chart, plot_sweep

        plot, height = (plot_sweep, 4.6) if n_axes == 1 else (plot_chart, 5.4)
        plot(result, measure, titled_axes(study, figure, 7.0, height), units=study.draw.units())

    return draw
