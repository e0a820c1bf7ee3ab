"""Studies of a measure over any grid of parameters and starts."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import field_validator

from percuss.io.study_text import start_table
from percuss.model.start import Start
from percuss.studies.axes import Axis, axes_table, values_of
from percuss.studies.faults import shown
from percuss.studies.kinds.many import Whole, ends_of, failure_rows, means_of, over_of
from percuss.studies.kinds.orbit import Count
from percuss.studies.kinds.starting import AT_REST, checked_start
from percuss.studies.parts import Parts
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import Document, StartTable, Table
from percuss.studies.shape import unknown_value

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.studies.study import Study

__all__ = ["KIND", "Sweep"]


class SweepTable(Table):
    """``[sweep]``: what is measured, and when."""

    measure: list[str]
    transient: Whole = 200
    periods: Count = 64
    max_impacts: Count | None = None

    @field_validator("measure", mode="before")
    @classmethod
    def _as_list(cls, value: object) -> object:
        return [value] if isinstance(value, str) else value


class SweepDocument(Document):
    """A study file of a sweep."""

    start: StartTable | None = None
    over: dict[str, object]
    sweep: SweepTable


@dataclass(frozen=True, slots=True)
class Sweep:
    """Measures over a grid, as `percuss.sweep` takes them.

    Parameters
    ----------
    measures
        Names of built-in measures.
    over
        The axes by path.
    start
        Where the motions start.
    transient, periods, max_impacts
        As there; None is the default.
    """

    kind: ClassVar[str] = "sweep"
    doing: ClassVar[str] = "measuring"
    stem: ClassVar[str] = "sweep"
    is_ensemble: ClassVar[bool] = True

    measures: tuple[str, ...]
    over: dict[str, Axis]
    start: Start = AT_REST
    transient: int = 200
    periods: int = 64
    max_impacts: int | None = None

    def tables(self) -> dict[str, object]:
        """Return ``[start]``, ``[over]`` and ``[sweep]``."""
        own = {
            "measure": list(self.measures),
            "transient": self.transient,
            "periods": self.periods,
            "max_impacts": self.max_impacts,
        }
        start = start_table(self.start)
        return {"start": start, "over": axes_table(self.over), "sweep": own}

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return one row a point."""
        return {"sweep": "table"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return a picture of each measure over one axis or two."""
        if len(self.over) > 2:
            return {}
        several = len(self.measures) > 1
        return {
            measure if several else "sweep": _draw(measure, len(self.over))
            for measure in self.measures
        }

    def answer(self, study: Study, means: Means) -> Dataset:
        """Measure."""
        from percuss.ensembles import sweep

        most: dict[str, Any] = {} if self.max_impacts is None else {"max_impacts": self.max_impacts}
        return sweep(
            self.measures,
            study.oscillator,
            study.forcing,
            over=over_of(self.over),
            start=self.start,
            transient=self.transient,
            periods=self.periods,
            **means_of(means),
            **most,
        )

    def report(self, result: Dataset) -> dict[str, str]:
        """Tell the grid, the range of each measure, and what failed."""
        n_points = int(np.prod([result.sizes[dim] for dim in result[self.measures[0]].dims]))
        rows = {"points": f"{n_points:,}", "over": ends_of(result)}
        for measure in self.measures:
            rows[measure] = _range(measure, result[measure].values.ravel())
        return rows | failure_rows([str(text) for text in result.reason.values], n_points)


def _range(measure: str, values: Any) -> str:
    values = values[~np.isnan(values)]
    if values.size == 0:
        return "no values"
    if measure == "period":
        found, counts = np.unique(values.astype(int), return_counts=True)
        most = sorted(zip(counts.tolist(), found.tolist(), strict=True), reverse=True)[:6]
        return ", ".join(f"{period or 'none found'}: {count:,}" for count, period in most)
    finite = values[np.isfinite(values)]
    # An exponent is -inf after a contact, which ends all memory.
    words = [f"{finite.min():.8g} to {finite.max():.8g}"] if finite.size else []
    words += [f"-inf at {values.size - finite.size:,} points"] if finite.size < values.size else []
    return "; ".join(words)


def _draw(measure: str, n_axes: int) -> Picture:
    def draw(result: Any, study: Study, figure: Any) -> None:
        from percuss.plotting import Units, plot_chart, plot_sweep

        plot, height = (plot_sweep, 4.6) if n_axes == 1 else (plot_chart, 5.4)
        figure.set_size_inches(7.0, height)
        units = Units(study.draw.length_unit, study.draw.time_unit)
        plot(result, measure, figure.add_subplot(), units=units)
        figure.suptitle(study.title, parse_math=False)

    return draw


def build(parts: Parts) -> Sweep | None:
    """Return the question of a document, None if it has faults."""
    from percuss.ensembles.measures import MEASURES

    own = parts.keys("sweep")
    given = own.pop("measure", [])
    measures = [given] if isinstance(given, str) else list(given)
    for index, name in enumerate(measures):
        if name not in MEASURES:
            place = ("sweep", "measure") if isinstance(given, str) else ("sweep", "measure", index)
            parts.found.add(place, unknown_value(name, list(MEASURES)), shown(name))
    if not measures and "measure" in parts.table("sweep"):
        parts.found.add(("sweep", "measure"), f"none at all; there are {', '.join(MEASURES)}", "[]")
    parts.needs_period("measures count in forcing periods")
    start = checked_start(parts)
    over = values_of(parts, None, start)
    return None if parts.found.faults else Sweep(tuple(measures), over, start, **own)


KIND = Kind(SweepDocument, build)
