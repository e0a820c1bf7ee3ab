"""Studies of all periodic orbits that a search finds."""

from __future__ import annotations

import math
from collections import Counter
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import Field, PlainSerializer

from percuss.execution import Execution
from percuss.model.loads import loads_of
from percuss.orbits import find_orbits
from percuss.orbits.finding.found import LEAST_EFFORT, MOST_EFFORT
from percuss.studies.study import Question, StudyDraft
from percuss.studies.tables import Count, Flag, Whole, default, table

if TYPE_CHECKING:
    from percuss.studies.study import Study

# More lines and panels say nothing more.
MOST_ROWS, MOST_PANELS = 20, 12


@table
class Orbits(Question):
    """All periodic orbits that a search finds; the parameters are those of `find_orbits`."""

    doing: ClassVar = "looking for orbits"
    columns: ClassVar = {"orbits": "orbits"}
    of_oscillators: ClassVar = ("formal",)
    draw_keys_of_structures: ClassVar = ("on",)

    max_impacts: Count = default(find_orbits, "max_impacts")
    max_periods: Count = default(find_orbits, "max_periods")
    seed: Whole = default(find_orbits, "seed")
    effort: Annotated[
        float,
        Field(strict=True, ge=LEAST_EFFORT, le=MOST_EFFORT),
        PlainSerializer(lambda effort: None if effort == 1.0 else effort),
    ] = default(find_orbits, "effort")
    formal: Flag = default(find_orbits, "formal")

    def checked(self, study: StudyDraft) -> Self:
        """Check the period of the forcing, the stops and what is drawn."""
        study.needs_period("a search for orbits needs a periodic forcing")
        if study.structure is not None:
            from percuss.studies.of_structures import check_drawn

            check_drawn(study)
            return self
        if not study.oscillator.stops and not study.faults.is_wrong("oscillator"):
            study.faults.add(("oscillator",), "without stops, which orbits could meet")
        return self

    def answer(self, study: Study, execution: Execution) -> list[Any]:
        """Search."""
        arguments = self.arguments() | {"progress": execution.progress}
        if study.structure is not None:
            return find_orbits(study.structure, loads_of(study.structure, study.force), **arguments)
        return find_orbits(study.oscillator, study.forcing, **arguments)

    def draw(self, result: list[Any], study: Study, figure: Any) -> None:
        """Draw each orbit in a panel."""
        from percuss.plotting import plot_orbit

        shown, on = result[:MOST_PANELS], (study.draw.on or (None,))[0]
        columns = max(1, math.ceil(math.sqrt(len(shown))))
        rows = max(1, math.ceil(len(shown) / columns))
        figure.set_size_inches(max(5.0, 3.6 * columns), max(4.2, 3.3 * rows))
        for i, orbit in enumerate(shown):
            ax = figure.add_subplot(rows, columns, i + 1)
            plot_orbit(orbit, ax, units=study.draw.units(), on=on)
            turns = f", {orbit.n_periods})" if orbit.n_periods else ")"
            ax.set_title(f"({orbit.n_impacts:g}{turns} {orbit.stability}", fontsize=9.0)
        left_out = len(result) - len(shown)
        if left_out or not shown:
            figure.supxlabel(f"and {left_out} more" if left_out else "no orbits found")

    def report(self, result: list[Any]) -> dict[str, str]:
        """Return how many there are, each in a line, and how many may be unseen."""
        from percuss.orbits.finding.found import FoundOrbits

        count = Counter(orbit.stability for orbit in result)
        words = ", ".join(f"{n} {name}" for name, n in count.items())
        rows = {"orbits": f"{len(result)}: {words}" if result else "none found"}
        for i, orbit in enumerate(result[:MOST_ROWS]):
            rows[f"orbit {i}"] = repr(orbit).split(": ", 1)[1].removesuffix(">")
        if len(result) > MOST_ROWS:
            rows["and"] = f"{len(result) - MOST_ROWS} more in the files"
        if isinstance(result, FoundOrbits):
            rows["search"] = result.completeness()
        return rows
