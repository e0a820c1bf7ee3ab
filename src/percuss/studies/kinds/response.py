"""Studies of a response: all families of orbits over one parameter."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

from percuss.execution import Execution
from percuss.orbits import response_curve
from percuss.studies.axes import OverRanges, ranges_over
from percuss.studies.study import Question, StudyDraft, intervals_in_words
from percuss.studies.tables import Count, OnKey, Whole, default, table

if TYPE_CHECKING:
    from percuss.orbits import Response as ResponseResult
    from percuss.studies.study import Study


@table
class Response(Question):
    """All families of orbits over one parameter, as `percuss.response_curve` takes it."""

    doing: ClassVar = "looking for families of orbits"
    needed: ClassVar = ("over",)
    needed_of_structures: ClassVar = ("over",)
    of_structures: ClassVar = ("on",)
    # One row an orbit, or a special point, with the number of its branch.
    columns: ClassVar = {"response": "response", "special_points": "special_points"}

    over: OverRanges
    max_impacts: Count = default(response_curve, "max_impacts")
    max_periods: Count = default(response_curve, "max_periods")
    seed: Whole = default(response_curve, "seed")
    n_seeds: Count = default(response_curve, "n_seeds")
    on: OnKey = None

    def checked(self, study: StudyDraft) -> Self:
        """Check the period of the forcing and what is measured, and read the range."""
        study.needs_period("a response is one to a periodic forcing")
        if study.structure is not None:
            from percuss.studies.of_structures import check_on

            check_on(self.on, ("response", "on"), study, is_needed=True)
        return replace(self, over=ranges_over(study, 1))

    def answer(self, study: Study, execution: Execution) -> ResponseResult:
        """Find and follow the families."""
        # A study without one was refused.
        assert study.force is not None
        arguments = self.arguments() | {"progress": execution.progress}
        return response_curve(study.model, study.force, **arguments)

    def draw(self, result: ResponseResult, study: Study, figure: Any) -> None:
        """Draw amplitude and impact velocity over the parameter."""
        from percuss.plotting import plot_response

        if not result.branches:
            figure.supxlabel("no branches found")
            return
        figure.set_size_inches(8.0, 9.0)
        upper, lower = figure.subplots(2, 1)
        plot_response(result, "amplitude", upper, units=study.draw.units())
        plot_response(result, "impact_velocity", lower, units=study.draw.units())
        # Once is enough.
        if lower.get_legend() is not None:
            lower.get_legend().remove()

    def report(self, result: ResponseResult) -> dict[str, str]:
        """Return the families, where they are stable, special points, and what was missed."""
        rows = {"branches": str(len(result.branches))}
        for family in result.families:
            physical = intervals_in_words(family.ranges)
            stable = intervals_in_words(family.stable_ranges)
            where = f"stable {stable}" if stable else "nowhere stable"
            rows[f"({family.n_impacts}, {family.n_periods})"] = (
                f"physical {physical}; {where}"
                if physical
                else "formal everywhere: each orbit would pass through a stop"
            )
        places: dict[str, list[str]] = {}
        for point in sorted(result.special_points, key=lambda point: point.value):
            places.setdefault(point.kind.replace("_", " "), []).append(f"{point.value:.9g}")
        # A doubling lies on two branches.
        words = [f"{kind} at {', '.join(dict.fromkeys(each))}" for kind, each in places.items()]
        rows["special points"] = "\n".join(words) or "none"
        compared = f"{len(result.attractors)} attractors of direct simulation"
        missed = len(result.missed)
        away = sum(attractor.branch is None for attractor in result.attractors) - missed
        seen = [f"{missed} of them on no branch"] if missed else []
        # As with sticking, or where a motion has not settled.
        seen += [f"{away} of them of no kind that was looked for"] if away else []
        where = ", ".join(seen) or "all of them on a branch"
        rows["compared"] = f"{compared}, {where}" if result.attractors else "no attractor"
        return rows
