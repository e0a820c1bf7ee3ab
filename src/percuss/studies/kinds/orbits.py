"""Studies of all periodic orbits that a search finds."""

from __future__ import annotations

import math
from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from percuss.studies.kinds.orbit import Count
from percuss.studies.parts import Parts
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import Document, Table

if TYPE_CHECKING:
    from percuss.orbits import PeriodicOrbit
    from percuss.studies.study import Study

__all__ = ["KIND", "Orbits"]

# More lines and panels say nothing more.
MOST_ROWS, MOST_PANELS = 20, 12


class OrbitsTable(Table):
    """``[orbits]``: how long the orbits are that are looked for."""

    max_impacts: Count = 3
    max_periods: Count = 4
    seed: Annotated[int, Field(ge=0)] = 0
    formal: bool = False


class OrbitsDocument(Document):
    """A study file of all orbits."""

    orbits: OrbitsTable = OrbitsTable()


@dataclass(frozen=True, slots=True)
class Orbits:
    """All periodic orbits that a search finds; the parameters are those of `find_orbits`."""

    kind: ClassVar[str] = "orbits"
    doing: ClassVar[str] = "looking for orbits"
    stem: ClassVar[str] = "orbits"
    is_ensemble: ClassVar[bool] = False

    max_impacts: int = 3
    max_periods: int = 4
    seed: int = 0
    formal: bool = False

    def tables(self) -> dict[str, object]:
        """Return ``[orbits]``."""
        table = {"max_impacts": self.max_impacts, "max_periods": self.max_periods}
        return {"orbits": {**table, "seed": self.seed, "formal": self.formal}}

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return the table of the orbits."""
        return {"orbits": "orbits"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return all of them in one plane."""
        return {"orbits": _draw}

    def answer(self, study: Study, means: Means) -> list[PeriodicOrbit]:  # noqa: ARG002
        """Search."""
        from percuss.orbits import find_orbits

        return find_orbits(
            study.oscillator,
            study.forcing,
            self.max_impacts,
            self.max_periods,
            self.seed,
            formal=self.formal,
        )

    def report(self, result: list[PeriodicOrbit]) -> dict[str, str]:
        """Tell how many there are, each in a line, and how many may be unseen."""
        from percuss.orbits.finding.find import FoundOrbits

        count = Counter(orbit.stability for orbit in result)
        words = ", ".join(f"{n} {name}" for name, n in count.items())
        rows = {"orbits": f"{len(result)}: {words}" if result else "none found"}
        for i, orbit in enumerate(result[:MOST_ROWS]):
            text = repr(orbit).removeprefix("<PeriodicOrbit: ").removesuffix(">")
            rows[f"orbit {i}"] = text
        if len(result) > MOST_ROWS:
            rows["and"] = f"{len(result) - MOST_ROWS} more in the files"
        if isinstance(result, FoundOrbits):
            rows["search"] = result.completeness()
        return rows


def _draw(orbits: list[PeriodicOrbit], study: Study, figure: Any) -> None:
    from percuss.plotting import Units, plot_orbit

    units = Units(study.draw.length_unit, study.draw.time_unit)
    shown = orbits[:MOST_PANELS]
    columns = max(1, math.ceil(math.sqrt(len(shown))))
    rows = max(1, math.ceil(len(shown) / columns))
    figure.set_size_inches(max(5.0, 3.6 * columns), max(4.2, 3.3 * rows))
    for i, orbit in enumerate(shown):
        ax = plot_orbit(orbit, figure.add_subplot(rows, columns, i + 1), units=units)
        turns = f", {orbit.n_periods})" if orbit.n_periods else ")"
        ax.set_title(f"({orbit.n_impacts:g}{turns} {orbit.stability}", fontsize=9.0)
    left_out = len(orbits) - len(shown)
    if left_out or not shown:
        figure.supxlabel(f"and {left_out} more" if left_out else "no orbits found")
    figure.suptitle(study.title, parse_math=False)


def build(parts: Parts) -> Orbits | None:
    """Return the question of a document, None if it has faults."""
    parts.needs_period("a search for orbits needs a periodic forcing")
    if not parts.oscillator.stops and not parts.found.is_wrong("oscillator"):
        parts.found.add(("oscillator",), "without stops, which orbits could meet")
    return None if parts.found.faults else Orbits(**parts.table("orbits"))


KIND = Kind(OrbitsDocument, build)
