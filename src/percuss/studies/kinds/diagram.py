"""Studies of a bifurcation diagram."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field

from percuss.io.study_text import number
from percuss.model.faults import draft
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start, start_faults
from percuss.studies.axes import Axis, axes_table, values_of
from percuss.studies.faults import shown
from percuss.studies.kinds.many import Whole, ends_of, failure_rows, means_of, over_of
from percuss.studies.kinds.motion import right_walls
from percuss.studies.kinds.starting import AT_REST
from percuss.studies.parts import Parts, exact_phase, reason_in_file
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import Document, Phase, Table

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.studies.study import Study

__all__ = ["KIND", "Diagram"]

Direction = Literal["forward", "backward"]
Section = Literal["stroboscopic", "impacts"]


class DiagramTable(Table):
    """``[diagram]``: which points, from where, and when."""

    section: Section = "stroboscopic"
    starts: Annotated[
        list[Annotated[list[Phase], Field(min_length=2, max_length=3)]], Field(min_length=1)
    ] = Field(default=[[0.0, 0.0]])
    follow: list[Direction] = Field(default=["forward", "backward"])
    transient: Whole = 200
    points: Annotated[int, Field(ge=2)] = 64


class DiagramDocument(Document):
    """A study file of a bifurcation diagram."""

    over: dict[str, object]
    diagram: DiagramTable = DiagramTable()


@dataclass(frozen=True, slots=True)
class Diagram:
    """The points of the attractors over a parameter, as `bifurcation_diagram` takes them."""

    kind: ClassVar[str] = "diagram"
    doing: ClassVar[str] = "following the motions"
    stem: ClassVar[str] = "diagram"
    is_ensemble: ClassVar[bool] = True

    over: dict[str, Axis]
    starts: tuple[Start, ...] = (AT_REST,)
    section: Section = "stroboscopic"
    follow: tuple[Direction, ...] = ("forward", "backward")
    transient: int = 200
    points: int = 64

    def tables(self) -> dict[str, object]:
        """Return ``[over]`` and ``[diagram]``."""
        starts = [[number(value) for value in (it.x0, it.v0, it.t0)] for it in self.starts]
        own = {
            "section": self.section,
            "starts": starts,
            "follow": list(self.follow),
            "transient": self.transient,
            "points": self.points,
        }
        return {"over": axes_table(self.over), "diagram": own}

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return one row a point."""
        return {"diagram": "table"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return the diagram."""
        return {"diagram": _draw}

    def answer(self, study: Study, means: Means) -> Dataset:
        """Follow the motions."""
        from percuss.ensembles import bifurcation_diagram

        return bifurcation_diagram(
            study.oscillator,
            study.forcing,
            over=over_of(self.over),
            section=self.section,
            starts=self.starts,
            follow=self.follow,
            transient=self.transient,
            points=self.points,
            **means_of(means),
        )

    def report(self, result: Dataset) -> dict[str, str]:
        """Tell the periods found on each branch, and what failed."""
        rows = {"over": ends_of(result)}
        reasons: list[str] = []
        for branch in result.branch.values:
            part = result.sel(branch=branch)
            count = Counter(int(p) for p in part.period.values if p >= 0)
            words = [f"{p or 'none found'}: {n}" for p, n in count.most_common(8)]
            rows[f"{branch}, periods"] = ", ".join(words) or "nothing"
            reasons += [str(text) for text in part.reason.values if text]
        return rows | failure_rows(reasons, result.period.size)


def _draw(result: Dataset, study: Study, figure: Any) -> None:
    from percuss.plotting import Units, plot_diagram

    figure.set_size_inches(7.6, 5.0)
    units = Units(study.draw.length_unit, study.draw.time_unit)
    plot_diagram(result, figure.add_subplot(), units=units)
    figure.suptitle(study.title, parse_math=False)


def _starts(parts: Parts) -> tuple[Start, ...]:
    """Return the starts of a document, and add what is wrong with them."""
    walls = draft(Oscillator, stops=right_walls(parts.oscillator, parts.found))
    found = []
    names = ("x0", "v0", "t0")
    given = parts.keys("diagram").get("starts")
    for index, row in enumerate([[0.0, 0.0]] if given is None else given):
        values = [exact_phase(value) for value in row]
        start = draft(Start, **dict(zip(names, values, strict=False)))
        for fault in start_faults(walls, start.x0, start.v0, start.t0, max_impacts=1):
            if given is None:
                reason = f"missing; the default x0 = 0 lies {fault.reason}"
                parts.found.add(("diagram", "starts"), reason)
            else:
                place = ("diagram", "starts", index, names.index(fault.name))
                parts.found.add(place, reason_in_file(fault.reason), shown(fault.value))
        found.append(start)
    return tuple(found)


def build(parts: Parts) -> Diagram | None:
    """Return the question of a document, None if it has faults."""
    own = parts.keys("diagram")
    parts.needs_period("a diagram needs a periodic forcing")
    starts = _starts(parts)
    over = values_of(parts, 1, starts[0] if starts else None)
    if parts.found.faults:
        return None
    own |= {"follow": tuple(own["follow"])} if "follow" in own else {}
    return Diagram(over, **{**own, "starts": starts})


KIND = Kind(DiagramDocument, build)
