"""Studies of a bifurcation diagram."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, PlainSerializer, PlainValidator, TypeAdapter, WithJsonSchema

from percuss.ensembles.diagram import Direction, bifurcation_diagram
from percuss.execution import Execution
from percuss.io.study_text import start_table
from percuss.model.faults import draft
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start, start_faults
from percuss.model.structure_start import StructureStart
from percuss.model.units import is_unit
from percuss.motion.sections import section_of
from percuss.studies.axes import OverAxes, over_of, values_over
from percuss.studies.measured import MeasureNames, SectionKey, check_measures, check_section
from percuss.studies.study import (
    AT_REST,
    Question,
    StudyDraft,
    ends_of,
    failure_rows,
    interruption_rows,
    known_walls,
    only_axes,
)
from percuss.studies.tables import (
    NumbersKey,
    OnKey,
    PhaseKey,
    Whole,
    default,
    exact_phase,
    raw_table,
    shown,
    table,
    words_of_file,
)

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.studies.study import Study

_ROW = TypeAdapter(Annotated[list[PhaseKey], Field(min_length=2, max_length=3)])
_ROW_OF_STRUCTURE = TypeAdapter(Annotated[list[NumbersKey], Field(min_length=2, max_length=3)])
_NAMES = ("x0", "v0", "t0")


def _start(row: Any) -> Start | StructureStart:
    """Return a start in a list, not checked; of a structure x0 and v0 are lists."""
    if isinstance(row, Start | StructureStart):
        return row
    if isinstance(row, list) and any(isinstance(part, list) for part in row):
        parts = [exact_phase(part) for part in _ROW_OF_STRUCTURE.validate_python(row)]
        return draft(StructureStart, **dict(zip(_NAMES, parts, strict=False)))
    return draft(Start, **dict(zip(_NAMES, _ROW.validate_python(row), strict=False)))


StartRow = Annotated[
    Any,
    PlainValidator(_start),
    PlainSerializer(lambda start: [*start_table(start).values()]),
    WithJsonSchema({"type": "array"}),
]


@table
class Diagram(Question):
    """The points of the attractors over a parameter, as `bifurcation_diagram` takes them."""

    doing: ClassVar = "following the motions"
    is_ensemble: ClassVar = True
    needed: ClassVar = ("over",)
    needed_of_structures: ClassVar = ("over",)
    of_structures: ClassVar = ("on",)
    columns: ClassVar = {"diagram": "table"}

    over: OverAxes
    section: SectionKey = default(bifurcation_diagram, "section")
    starts: Annotated[tuple[StartRow, ...], Field(min_length=1)] = (AT_REST,)
    follow: tuple[Direction, ...] = default(bifurcation_diagram, "follow")
    transient: Whole = default(bifurcation_diagram, "transient")
    points: Annotated[Whole, Field(ge=2)] = default(bifurcation_diagram, "points")
    measures: Annotated[MeasureNames, PlainSerializer(lambda names: [*names] or None)] = default(
        bifurcation_diagram, "measures"
    )
    on: OnKey = None

    def checked(self, study: StudyDraft) -> Self:
        """Check the period of the forcing, the measures and the starts, and read the axis."""
        check_section(self.section, "diagram", "a diagram needs a periodic forcing", study)
        check_measures(self.measures, ("diagram", "measures"), self.over, study)
        if study.structure is not None:
            return self._of_structure(study)
        self._check_starts(study)
        # A list of numbers, which is at fault here, is a start of a structure.
        first = self.starts[0] if isinstance(self.starts[0], Start) else AT_REST
        return replace(self, over=values_over(study, 1, first))

    def _of_structure(self, study: StudyDraft) -> Self:
        """Return the diagram of a structure with its starts and its axis, and add their faults."""
        from percuss.studies.of_structures import check_measured, checked_start

        path = ("diagram", "measures")
        section = section_of(self.section)
        check_measured(self.measures, self.on, path, study, section=section)
        starts = tuple(
            checked_start(start, study, ("diagram", "starts", index))
            for index, start in enumerate(self.starts)
        )
        return replace(self, starts=starts, over=values_over(study, 1, starts[0]))

    def _check_starts(self, study: StudyDraft) -> None:
        walls = draft(Oscillator, stops=known_walls(study))
        path = ("diagram", "starts")
        is_given = "starts" in raw_table(study.document, "diagram")
        for index, start in enumerate(self.starts):
            for fault in start_faults(walls, start.x0, start.v0, start.t0, max_impacts=1):
                reason = words_of_file(fault.reason)
                if is_given:
                    place = (*path, index, _NAMES.index(fault.name))
                    study.faults.add(place, reason, shown(fault.value))
                else:
                    study.faults.add(path, f"missing; the default x0 = 0 lies {reason}")

    def answer(self, study: Study, execution: Execution) -> Dataset:
        """Return the points."""
        arguments = self.arguments() | {"over": over_of(self.over)} | execution.keywords()
        if self.starts == (AT_REST,):
            del arguments["starts"]
        return bifurcation_diagram(study.model, study.force, **arguments)

    def draw(self, result: Dataset, study: Study, figure: Any) -> None:
        """Draw the diagram."""
        from percuss.plotting import plot_diagram

        plot_diagram(result, only_axes(figure, 7.6, 5.0), units=study.draw.units())

    def report(self, result: Dataset) -> dict[str, str]:
        """Return the periods on each branch, and what failed."""
        rows = {"over": ends_of(result)}
        reasons: list[str] = []
        for branch in result.branch.values:
            part = result.sel(branch=branch)
            count = Counter(
                _period_words(period, is_there)
                for period, is_there in zip(part.period.values, _has_points(part), strict=True)
                if period >= 0
            )
            words = [f"{period}: {n}" for period, n in count.most_common(8)]
            rows[f"{branch}, periods"] = ", ".join(words) or "nothing"
            reasons += [str(text) for text in part.reason.values if text]
        for name in self.measures:
            values = result[name].values
            finite = values[np.isfinite(values)]
            unit = str(result[name].attrs.get("units", ""))
            ends = f"{finite.min():.8g} to {finite.max():.8g}" if finite.size else "none"
            rows[name] = f"{ends} {unit}" if is_unit(unit) and finite.size else ends
        return rows | interruption_rows(result) | failure_rows(reasons, result.period.size)


def _period_words(period: float, has_points: bool) -> str:
    """Return a period in words; without a forcing it is a time."""
    if not has_points:
        return "no point on the section"
    return f"{period:.6g}" if period else "none found"


def _has_points(part: Dataset) -> Any:
    """Return at which values a branch of a diagram has a point on its section."""
    points = next(values for values in part.data_vars.values() if "sample" in values.dims)
    others = [name for name in points.dims if name not in part.period.dims]
    return points.notnull().any(others).values
