"""Studies of a branch: an orbit followed along a parameter."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import Field

from percuss.execution import Execution
from percuss.orbits import continue_orbit
from percuss.studies.axes import OverRanges, ParameterRange, ranges_over
from percuss.studies.kinds.orbit import Sought
from percuss.studies.of_structures import check_on
from percuss.studies.study import Question, StudyDraft, only_axes
from percuss.studies.tables import Count, default, shown, table, unknown_value, values_of
from percuss.wording import counted

if TYPE_CHECKING:
    from percuss.orbits import Branch as BranchResult
    from percuss.orbits import StructureBranch
    from percuss.studies.study import Study

# What pictures show of branches.
OF_OSCILLATORS = ["impact_velocity", "grazing_margin", "multiplier", "period"]
OF_STRUCTURES = ["amplitude", "multiplier"]


@table
class Steps:
    """How far and how finely an orbit is followed, as `percuss.continue_orbit` takes it."""

    max_points: Count = default(continue_orbit, "max_points")
    largest_step: Annotated[float, Field(strict=True, gt=0.0, le=1.0)] = default(
        continue_orbit, "largest_step"
    )


def follow(
    study: Study,
    sought: Sought,
    over: dict[str, ParameterRange],
    steps: Steps,
    execution: Execution,
) -> BranchResult | StructureBranch:
    """Find the orbit of a study, and follow it along a parameter."""
    orbit = sought.find(study)
    return continue_orbit(orbit, over, **values_of(steps), progress=execution.progress)


@table
class Branch(Question):
    """A periodic orbit followed along a parameter.

    Parameters
    ----------
    sought
        The orbit to begin with.
    over
        One parameter by its path, and its first and last value.
    steps
        How it is followed.
    """

    doing: ClassVar = "following the orbit"
    is_certifiable: ClassVar = True
    needed: ClassVar = ("over",)
    needed_of_structures: ClassVar = ("over",)
    draw_keys: ClassVar = ("quantity",)
    draw_keys_of_structures: ClassVar = ("quantity", "on", "coordinate")
    columns: ClassVar = {"branch": "branch", "special_points": "special_points"}

    sought: Sought
    over: OverRanges
    steps: Steps = Steps()

    def checked(self, study: StudyDraft) -> Self:
        """Check the orbit sought, and read the range."""
        self.sought.check(study)
        self._check_drawn(study)
        return replace(self, over=ranges_over(study, 1, holds_own=True))

    def _check_drawn(self, study: StudyDraft) -> None:
        """Add the fault of a quantity that the branch does not have."""
        structure, quantity = study.structure, study.draw.quantity
        known = OF_OSCILLATORS if structure is None else OF_STRUCTURES
        if quantity is not None and quantity not in known:
            study.faults.add(("draw", "quantity"), unknown_value(quantity, known), shown(quantity))
        if structure is None:
            return
        on, coordinate = study.draw.on, study.draw.coordinate
        if coordinate is not None and study.has_right_model and coordinate >= structure.n:
            reason = f"no such coordinate; the coordinates are 0 to {structure.n - 1}"
            study.faults.add(("draw", "coordinate"), reason, str(coordinate))
        if on is not None and coordinate is not None:
            study.faults.add(("draw", "coordinate"), "given together with on; give one")
        if on is not None and len(on) != 1:
            reason = f"{counted(len(on), 'displacement')}; of a branch one is drawn"
            study.faults.add(("draw", "on"), reason)
        for index, line in enumerate(on or ()):
            check_on(line, ("draw", "on", index), study, is_needed=True)

    def answer(self, study: Study, execution: Execution) -> BranchResult | StructureBranch:
        """Find the orbit and follow it."""
        return follow(study, self.sought, self.over, self.steps, execution)

    def draw(self, result: BranchResult | StructureBranch, study: Study, figure: Any) -> None:
        """Draw the branch over its parameter."""
        from percuss.plotting import plot_branch

        axes = only_axes(figure, 7.0, 4.6)
        draw = study.draw
        plot_branch(
            result,
            axes,
            quantity=draw.quantity,
            on=draw.on[0] if draw.on else None,
            coordinate=draw.coordinate,
            units=draw.units(),
        )

    def report(self, result: BranchResult | StructureBranch) -> dict[str, str]:
        """Return the branch, its special points and why it ends."""
        low, high = result.values.min(), result.values.max()
        stable, physical = int(result.is_stable.sum()), int(result.admissible.sum())
        points = [
            f"{point.kind.replace('_', ' ')} at {point.value:.12g} ({point.status}): {point.detail}"
            for point in result.special_points
        ]
        # Of forced motion it is known.
        cycles = [orbit.period for orbit in result] if result[0].n_periods == 0 else []
        periods = {"period": f"from {min(cycles):.10g} to {max(cycles):.10g}"} if cycles else {}
        return {
            "branch": f"{len(result)} orbits, {result.path} from {low:.10g} to {high:.10g}",
            "of these": f"{stable} stable, {physical} physical",
            **periods,
            "special points": "\n".join(points) or "none",
            "ends": result.end_reason,
        }
