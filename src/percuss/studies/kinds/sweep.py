"""Studies of a measure over any grid of parameters and starts."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, PlainSerializer

from percuss.ensembles import sweep
from percuss.ensembles.measures import MEASURES
from percuss.ensembles.sweep import span_of
from percuss.errors import ParameterError
from percuss.execution import Execution
from percuss.model.exact import as_float, phase_problem
from percuss.model.units import is_unit
from percuss.motion.sections import section_of
from percuss.studies.axes import OverAxes, over_of, values_over
from percuss.studies.measured import MeasureNames, SectionKey, check_measures, check_section
from percuss.studies.study import (
    AT_REST,
    Picture,
    Question,
    StudyDraft,
    check_start,
    ends_of,
    failure_rows,
    interruption_rows,
    only_axes,
)
from percuss.studies.tables import (
    Count,
    OnKey,
    PhaseKey,
    StartState,
    Whole,
    default,
    raw_table,
    shown,
    table,
)

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.studies.study import Study

NO_VALUES = "no values"
IN_PERIODS = "measures count in forcing periods"


def _section_unless_strobes(section: Any) -> Any:
    """Return a section as a file holds it; the default is left out."""
    given = section_of(section).given
    return None if given == "stroboscopic" else given


@table
class Sweep(Question):
    """Measures over a grid, as `percuss.sweep` takes them.

    Parameters
    ----------
    measure
        Names of built-in measures.
    over
        The axes by path.
    paired
        Whether their values are taken together.
    start
        Where the motions start.
    transient, periods, between, section, max_impacts, on
        As there; None is the default.
    """

    doing: ClassVar = "measuring"
    is_ensemble: ClassVar = True
    needed: ClassVar = ("over", "sweep")
    needed_of_structures: ClassVar = ("over", "sweep")
    of_structures: ClassVar = ("on",)
    columns: ClassVar = {"sweep": "table"}

    measure: MeasureNames
    over: OverAxes
    paired: bool = default(sweep, "paired")
    start: StartState = AT_REST
    transient: Whole = default(sweep, "transient")
    periods: Count = default(sweep, "periods")
    between: Annotated[tuple[PhaseKey, ...], Field(min_length=2, max_length=2)] | None = None
    section: Annotated[SectionKey, PlainSerializer(_section_unless_strobes)] = default(
        sweep, "section"
    )
    max_impacts: Count | None = None
    on: OnKey = None

    def checked(self, study: StudyDraft) -> Self:
        """Check the measures, the period of the forcing and the start, and read the axes."""
        path = ("sweep", "measure")
        check_measures(self.measure, path, self.over, study)
        if not self.measure:
            study.faults.add(path, f"none at all; there are {', '.join(MEASURES)}", "[]")
        if self.between is not None:
            self._check_between(study)
        elif "between" in raw_table(study.document, "sweep"):
            # It has a fault already.
            pass
        elif any(name in MEASURES and MEASURES[name].needs_strobes for name in self.measure):
            check_section(self.section, "sweep", IN_PERIODS, study)
        elif study.force is not None and not study.force.is_constant:
            study.needs_period(IN_PERIODS)
        start = self.start
        if study.structure is None:
            check_start(start, study)
        else:
            from percuss.studies.of_structures import check_measured, checked_start

            start = checked_start(start, study)
            counts = any(name in MEASURES and MEASURES[name].needs_strobes for name in self.measure)
            section = section_of(self.section) if counts else None
            check_measured(self.measure, self.on, path, study, section=section)
        return replace(self, start=start, over=values_over(study, None, start, paired=self.paired))

    def tables(self) -> dict[str, object]:
        """Return the tables of the question; two instants stand in place of whole periods."""
        tables: dict[str, Any] = Question.tables(self)
        if self.between is not None:
            tables["sweep"] = {**tables["sweep"], "transient": None, "periods": None}
        return tables

    def _check_between(self, study: StudyDraft) -> None:
        """Add the faults of the two instants, and of what is given together with them."""
        raw = raw_table(study.document, "sweep")
        for name in ("transient", "periods"):
            if name in raw:
                study.faults.add(("sweep", name), "given together with between; give one")
        problems = [phase_problem(time) for time in self.between or ()]
        for index, problem in enumerate(problems):
            if problem is not None:
                study.faults.add(("sweep", "between", index), problem, shown(raw["between"][index]))
        if any(problems) or study.faults.is_wrong("sweep") or study.faults.is_wrong("start"):
            return
        try:
            span_of(self.between, as_float(self.start.t0), self.measure)
        except ParameterError as error:
            place = "measure" if error.name == "measure" else "between"
            study.faults.add(("sweep", place), error.reason, shown(raw.get(place)))

    def answer(self, study: Study, execution: Execution) -> Dataset:
        """Return the measures at each point."""
        arguments = self.arguments() | {"over": over_of(self.over)} | execution.keywords()
        return sweep(osc=study.model, force=study.force, **arguments)

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return a picture of each measure over one axis or two, the first two of paired ones."""
        if len(self.over) > 2 and not self.paired:
            return {}
        several = len(self.measure) > 1
        return {name if several else "sweep": _draw(name, len(self.over)) for name in self.measure}

    def report(self, result: Dataset) -> dict[str, str]:
        """Return the grid, the range of each measure, and what failed."""
        n_points = int(np.prod([result.sizes[dim] for dim in result[self.measure[0]].dims]))
        rows = {"points": f"{n_points:,}", "over": ends_of(result)}
        for name in self.measure:
            is_count = name == "period" and study_counts(result)
            unit = str(result[name].attrs.get("units", ""))
            words = _range(result[name].values.ravel(), is_count=is_count)
            rows[name] = f"{words} {unit}" if is_unit(unit) and words != NO_VALUES else words
        if "record" in result.attrs:
            rows["record"] = result.attrs["record"]
        return (
            rows
            | interruption_rows(result)
            | failure_rows([str(text) for text in result.reason.values], n_points)
        )


def study_counts(result: Dataset) -> bool:
    """Return whether periods are numbers of forcing periods, not times."""
    return str(result["period"].attrs.get("units", "1")) == "1"


def _range(values: Any, *, is_count: bool) -> str:
    values = values[~np.isnan(values)]
    if values.size == 0:
        return NO_VALUES
    if is_count:
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
        plot(result, measure, only_axes(figure, 7.0, height), units=study.draw.units())

    return draw
