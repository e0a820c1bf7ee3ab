"""Studies of a response: all families of orbits over one parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from percuss.studies.axes import Range, axes_table, ranges_of
from percuss.studies.kinds.orbit import Count
from percuss.studies.parts import Parts
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import Document, Table

if TYPE_CHECKING:
    from percuss.orbits import Response as ResponseResult
    from percuss.studies.study import Study

__all__ = ["KIND", "Response"]


class ResponseTable(Table):
    """``[response]``: how long the orbits are that are looked for, and where."""

    max_impacts: Count = 4
    max_periods: Count = 3
    seed: Annotated[int, Field(ge=0)] = 0
    n_seeds: Count = 16


class ResponseDocument(Document):
    """A study file of a response."""

    over: dict[str, object]
    response: ResponseTable = ResponseTable()


@dataclass(frozen=True, slots=True)
class Response:
    """All families of orbits over one parameter, as `percuss.response_curve` takes it."""

    kind: ClassVar[str] = "response"
    doing: ClassVar[str] = "looking for families of orbits"
    stem: ClassVar[str] = "response"
    is_ensemble: ClassVar[bool] = False

    over: dict[str, Range]
    max_impacts: int = 4
    max_periods: int = 3
    seed: int = 0
    n_seeds: int = 16

    def tables(self) -> dict[str, object]:
        """Return ``[over]`` and ``[response]``."""
        names = ("max_impacts", "max_periods", "seed", "n_seeds")
        own = {name: getattr(self, name) for name in names}
        return {"over": axes_table(self.over), "response": own}

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return one row an orbit, with the number of its branch."""
        return {"response": "response"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return amplitude and impact velocity over the parameter."""
        return {"response": _draw}

    def answer(self, study: Study, means: Means) -> ResponseResult:
        """Find and follow the families."""
        from percuss.orbits import response_curve

        # A study without one was refused.
        assert study.forcing is not None
        return response_curve(
            study.oscillator,
            study.forcing,
            self.over,
            max_impacts=self.max_impacts,
            max_periods=self.max_periods,
            seed=self.seed,
            n_seeds=self.n_seeds,
            progress=means.progress,
        )

    def report(self, result: ResponseResult) -> dict[str, str]:
        """Tell the families, where they are stable, and what was missed."""
        rows = {"branches": str(len(result.branches))}
        for family in result.families:
            name = f"({family.n_impacts}, {family.n_periods})"
            rows[name] = _words(_intervals(family.ranges), _intervals(family.stable_ranges))
        compared = f"{len(result.attractors)} attractors of direct simulation"
        missed = len(result.missed)
        where = f"{missed} of them on no branch" if missed else "all of them on a branch"
        rows["compared"] = f"{compared}, {where}" if result.attractors else "no attractor"
        return rows


def _words(physical: str, stable: str) -> str:
    """Return where a family is physical, and stable, in words."""
    if not physical:
        return "formal everywhere: each orbit would pass through a stop"
    return f"physical {physical}; {f'stable {stable}' if stable else 'nowhere stable'}"


def _intervals(ranges: Any) -> str:
    return ", ".join(f"{low:.6g} to {high:.6g}" for low, high in ranges)


def _draw(response: ResponseResult, study: Study, figure: Any) -> None:
    from percuss.plotting import Units, plot_response

    units = Units(study.draw.length_unit, study.draw.time_unit)
    figure.set_size_inches(8.0, 9.0)
    upper, lower = figure.subplots(2, 1)
    plot_response(response, "amplitude", upper, units=units)
    plot_response(response, "impact_velocity", lower, units=units)
    figure.suptitle(study.title, parse_math=False)
    # Once is enough.
    if lower.get_legend() is not None:
        lower.get_legend().remove()


def build(parts: Parts) -> Response | None:
    """Return the question of a document, None if it has faults."""
    parts.needs_period("a response is one to a periodic forcing")
    over = ranges_of(parts, 1)
    return None if parts.found.faults else Response(over, **parts.keys("response"))


KIND = Kind(ResponseDocument, build)
