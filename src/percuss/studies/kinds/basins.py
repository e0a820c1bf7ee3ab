"""Studies of basins of attraction."""

from __future__ import annotations

import math
import re
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import Field, PlainSerializer

from percuss.ensembles import basins
from percuss.errors import PercussError
from percuss.execution import Execution
from percuss.model.exact import Phase, as_float
from percuss.model.faults import phase_faults, positive_faults
from percuss.model.oscillator import Wall
from percuss.studies.axes import (
    AxisValues,
    OverAxes,
    StartAxis,
    axes_of,
    direction_of,
    over_of,
    values_over,
)
from percuss.studies.measured import MeasureNames, check_measures
from percuss.studies.study import (
    AT_REST,
    Question,
    StudyDraft,
    check_start,
    interruption_rows,
    only_axes,
    with_unit,
)
from percuss.studies.tables import (
    NumberKey,
    OnKey,
    PhaseKey,
    StartState,
    Whole,
    default,
    raw_table,
    table,
)
from percuss.wording import counted, impacts_in_words

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.orbits import Manifolds
    from percuss.studies.study import Study

STATES, IMPACTS = ("x0", "v0"), ("cycle", "v")
START_PATHS = ("start.x0", "start.v0")
# Impacts and periods of the saddles whose manifolds are drawn.
MOST_IMPACTS = MOST_PERIODS = 2


@table
class Basins(Question):
    """The attractor of each start of a grid, as `percuss.basins` finds it.

    Parameters
    ----------
    x0, v0, cycle, v
        The axes: x0 and v0, or cycle and v.
    stop, t0, periods, escape, measures
        As there.
    over, start
        In place of these axes two numbers of the start, "start.x0" and "start.v0", of a structure
        such as "start.x0.0", or directions in which it moves, such as "[1, 0, 0.5, 0]"; and the
        start itself, which then has the instant.
    on
        Of a structure, as there.
    """

    doing: ClassVar = "following the starts"
    is_ensemble: ClassVar = True
    needed: ClassVar = ("basins",)
    needed_of_structures: ClassVar = ("over",)
    of_oscillators: ClassVar = ("x0", "v0", "cycle", "v", "stop", "t0")
    of_structures: ClassVar = ("on",)
    draw_keys: ClassVar = ("manifolds",)
    columns: ClassVar = {"basins": "table", "attractors": "attractors"}

    x0: StartAxis = None
    v0: StartAxis = None
    cycle: StartAxis = None
    v: StartAxis = None
    stop: Whole = default(basins, "stop")
    t0: PhaseKey = default(basins, "t0")
    # Motions are followed forty periods at a time.
    periods: Annotated[Whole, Field(ge=40)] = default(basins, "periods")
    escape: NumberKey = default(basins, "escape")
    measures: Annotated[MeasureNames, PlainSerializer(lambda names: [*names] or None)] = default(
        basins, "measures"
    )
    over: OverAxes = Field(default_factory=dict)
    start: StartState = AT_REST
    on: OnKey = None

    def checked(self, study: StudyDraft) -> Self:
        """Check the period of the forcing and the numbers, and read the axes."""
        study.needs_period("basins need a periodic forcing")
        check_measures(self.measures, ("basins", "measures"), {}, study)
        if study.structure is not None:
            return self._of_structure(study)
        if self.over:
            return self._over_starts(study)
        if self.start is not AT_REST:
            reason = "the start of axes in [over]; with x0 and v0 in [basins] give t0 there"
            study.faults.add(("start",), reason)
        given = {name: raw for name in (*STATES, *IMPACTS)
                 if (raw := getattr(self, name)) is not None}  # fmt: skip
        _check_pair(given, study)
        axes: dict[str, Any] = axes_of(study, "basins", given)
        study.faults.add_from_model(phase_faults("basins.t0", self.t0))
        study.faults.add_from_model(positive_faults("basins.escape", self.escape))
        self._check_impacts(axes, study)
        return replace(self, **axes)

    def _over_starts(self, study: StudyDraft) -> Self:
        """Return basins over both numbers of the start of an oscillator, and add their faults."""
        for name in (*STATES, *IMPACTS, "stop", "t0"):
            if name in raw_table(study.document, "basins"):
                reason = "given together with [over]; the start is that of [start]"
                study.faults.add(("basins", name), reason)
        check_start(self.start, study)
        study.faults.add_from_model(positive_faults("basins.escape", self.escape))
        over = values_over(study, 2, self.start)
        for path in over:
            if path not in START_PATHS:
                reason = f"no number of the start; a basin is over {' and '.join(START_PATHS)}"
                study.faults.add(("over", path), reason)
        return replace(self, over=over)

    @property
    def begin(self) -> Phase:
        """The instant of the starts."""
        return self.start.t0 if self.over else self.t0

    @property
    def of_states(self) -> tuple[StartAxis, StartAxis]:
        """The axes of places and of velocities, None of impacts."""
        if not self.over:
            return self.x0, self.v0
        return self.over[START_PATHS[0]], self.over[START_PATHS[1]]

    def tables(self) -> dict[str, object]:
        """Return the tables of the question: its axes stand in one of them."""
        tables: dict[str, Any] = Question.tables(self)
        if not self.over:
            return {name: keys for name, keys in tables.items() if name not in ("over", "start")}
        return {**tables, "basins": {**tables["basins"], "t0": None, "stop": None}}

    def _of_structure(self, study: StudyDraft) -> Self:
        """Return basins in a plane of starts of a structure, and add their faults."""
        from percuss.studies.of_structures import check_measured, checked_start

        check_measured(self.measures, self.on, ("basins", "measures"), study)
        study.faults.add_from_model(positive_faults("basins.escape", self.escape))
        start = checked_start(self.start, study)
        over = values_over(study, 2, start)
        for path in over:
            if direction_of(path) is None and not re.fullmatch(r"start\.[xv]0\.\d+", path):
                reason = 'no number of the start; a basin is over two, such as "start.x0.0"'
                study.faults.add(("over", path), reason)
        return replace(self, start=start, over=over)

    def _check_impacts(self, axes: dict[str, AxisValues], study: StudyDraft) -> None:
        """Add the faults of starts at a wall."""
        if not set(axes) & set(IMPACTS) or study.faults.is_wrong("oscillator"):
            return
        stops = study.oscillator.stops
        if self.stop >= len(stops) or not isinstance(stops[self.stop], Wall):
            reason = "the number of no wall; give x0 and v0"
            study.faults.add(("basins", "stop"), reason, str(self.stop))
        for name, below in (("cycle", 1.0), ("v", math.inf)):
            values = [as_float(value) for value in over_of(axes).get(name, [])]
            if values and not (min(values) >= 0.0 and max(values) < below):
                reason = "not all in [0, 1)" if name == "cycle" else "not all at least 0"
                study.faults.add(("basins", name), reason)

    def answer(self, study: Study, execution: Execution) -> Dataset:
        """Return the attractor of each start."""
        arguments = self.arguments() | {"escape": as_float(self.escape)} | execution.keywords()
        others = self.of_oscillators if study.structure is not None else ("over", "start", "on")
        arguments = {name: value for name, value in arguments.items() if name not in others}
        if study.structure is not None:
            return basins(study.structure, study.force, **arguments | {"over": over_of(self.over)})
        axes = {name: arguments[name] for name in (*STATES, *IMPACTS) if name in arguments}
        if self.over:
            axes = {path.removeprefix("start."): axis for path, axis in self.over.items()}
            arguments["t0"] = self.begin
        return basins(study.oscillator, study.forcing, **arguments | over_of(axes))

    def draw(self, result: Dataset, study: Study, figure: Any) -> None:
        """Draw the basins in the plane of the starts."""
        from percuss.plotting import plot_basins

        curves = _manifolds(study) if study.draw.manifolds else ()
        axes = only_axes(figure, 7.4, 5.6)
        plot_basins(result, axes, manifolds=curves, units=study.draw.units())

    def report(self, result: Dataset) -> dict[str, str]:
        """Return the attractors and the fraction of the starts that go to each."""
        basin = result.basin.values
        inside = int((basin == -2).sum())
        rows = {"starts": f"{basin.size - inside:,}"}
        rows |= interruption_rows(result)
        rows |= {"inside a wall": f"{inside:,} of {basin.size:,}"} if inside else {}
        for i in range(result.sizes["attractor"]):
            attractor = result.isel(attractor=i)
            share, error = float(attractor.fraction), float(attractor.fraction_error)
            words = str(attractor.kind.values)
            if words == "periodic":
                count = impacts_in_words(float(attractor.n_impacts))
                words = f"{count} in {counted(int(attractor.n_periods), 'forcing period')}"
            rows[f"attractor {i}"] = f"{words}: {share:.4%} ± {error:.1%} of the starts"
            for name in self.measures:
                unit = str(attractor[name].attrs.get("units", ""))
                rows[f"attractor {i}, {name}"] = with_unit(float(attractor[name]), unit)
        undecided = float(result.attrs["undecided"])
        return rows | ({"undecided": f"{undecided:.4%}"} if inside < basin.size else {})


def _check_pair(given: dict[str, Any], study: StudyDraft) -> None:
    """Add the faults of missing axes, or of axes of both pairs."""
    of_state, of_impact = ([name for name in pair if name in given] for pair in (STATES, IMPACTS))
    if of_state and of_impact:
        reason = "given together with x0 or v0; give x0 and v0, or these"
        study.faults.add(("basins", of_impact[0]), reason)
    elif not given and "basins" in study.document:
        reason = "missing; give x0 and v0, or cycle and v of impacts"
        study.faults.add(("basins",), reason)
    elif given:
        (missing,) = set(STATES if of_state else IMPACTS) - set(given) or ("",)
        if missing:
            study.faults.add(("basins", missing), "missing")


def _manifolds(study: Study) -> list[Manifolds]:
    """Return the stable manifolds of the saddles, which bound the basins."""
    from percuss.orbits import find_orbits, manifolds

    question = study.question
    # Only studies of basins, with a period, are drawn here.
    assert isinstance(question, Basins)
    assert study.forcing is not None
    assert study.forcing.period is not None
    at_wall = question.cycle is not None
    cycle = (as_float(question.begin) / study.forcing.period) % 1.0
    curves = []
    for orbit in find_orbits(study.oscillator, study.forcing, MOST_IMPACTS, MOST_PERIODS):
        # Where it is no saddle or has no manifold, the picture shows the basins without it.
        with suppress(PercussError):
            curves.append(
                manifolds(
                    orbit,
                    section="impact" if at_wall else "stroboscopic",
                    cycle=0.0 if at_wall else cycle,
                    stop=question.stop if at_wall else None,
                    kinds=("stable",),
                )
            )
    return curves
