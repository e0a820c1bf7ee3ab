"""Studies of a branch: an orbit followed along a parameter."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field

from percuss.studies.axes import Range, axes_table, ranges_of
from percuss.studies.kinds.orbit import Count, OrbitTable, Sought, find, sought
from percuss.studies.parts import Parts
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import CertifyTable, Document, DrawTable, Table

if TYPE_CHECKING:
    from percuss.orbits import Branch as BranchResult
    from percuss.orbits import PeriodicOrbit
    from percuss.studies.study import Study

__all__ = [
    "DEFAULT_STEPS",
    "KIND",
    "Branch",
    "BranchTable",
    "Steps",
    "branch_rows",
    "follow",
    "steps_of",
]


class BranchTable(Table):
    """``[branch]``: how the orbit is followed."""

    max_points: Count = 2000
    largest_step: Annotated[float, Field(gt=0.0, le=1.0)] = 0.02


class BranchDrawTable(DrawTable):
    """``[draw]`` of a branch."""

    quantity: Literal["impact_velocity", "grazing_margin", "multiplier"] | None = None


class BranchDocument(Document):
    """A study file of a branch."""

    orbit: OrbitTable = OrbitTable()
    over: dict[str, object]
    branch: BranchTable = BranchTable()
    certify: CertifyTable | None = None
    draw: BranchDrawTable = BranchDrawTable()


@dataclass(frozen=True, slots=True)
class Steps:
    """How far and how finely an orbit is followed, as `percuss.continue_orbit` takes it."""

    max_points: int = 2000
    largest_step: float = 0.02

    def table(self) -> dict[str, object]:
        """Return it as a ``[branch]`` table."""
        return {"max_points": self.max_points, "largest_step": self.largest_step}


DEFAULT_STEPS = Steps()


def steps_of(parts: Parts) -> Steps:
    """Return how a document follows an orbit."""
    return Steps(**parts.keys("branch"))


def follow(
    orbit: PeriodicOrbit, over: dict[str, Range], steps: Steps, means: Means
) -> BranchResult:
    """Follow an orbit along a parameter."""
    from percuss.orbits import continue_orbit

    return continue_orbit(
        orbit,
        over,
        max_points=steps.max_points,
        largest_step=steps.largest_step,
        progress=means.progress,
    )


@dataclass(frozen=True, slots=True)
class Branch:
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

    kind: ClassVar[str] = "branch"
    doing: ClassVar[str] = "following the orbit"
    stem: ClassVar[str] = "branch"
    is_ensemble: ClassVar[bool] = False

    sought: Sought
    over: dict[str, Range]
    steps: Steps = DEFAULT_STEPS

    def tables(self) -> dict[str, object]:
        """Return ``[orbit]``, ``[over]`` and ``[branch]``."""
        return {
            "orbit": self.sought.table(),
            "over": axes_table(self.over),
            "branch": self.steps.table(),
        }

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return the branch and its special points."""
        return {"branch": "branch", "special_points": "special_points"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return the branch over its parameter."""
        return {"branch": _draw}

    def answer(self, study: Study, means: Means) -> BranchResult:
        """Find the orbit and follow it."""
        return follow(find(study, self.sought), self.over, self.steps, means)

    def report(self, result: BranchResult) -> dict[str, str]:
        """Tell the branch, its special points and why it ends."""
        return branch_rows(result)


def branch_rows(branch: BranchResult) -> dict[str, str]:
    """Return what there is to say of a branch."""
    low, high = branch.values.min(), branch.values.max()
    stable, physical = int(branch.is_stable.sum()), int(branch.admissible.sum())
    rows = {
        "branch": f"{len(branch)} orbits, {branch.path} from {low:.10g} to {high:.10g}",
        "of these": f"{stable} stable, {physical} physical",
    }
    points = [
        f"{point.kind.replace('_', ' ')} at {point.value:.12g} ({point.status}): {point.detail}"
        for point in branch.special_points
    ]
    return rows | {"special points": "\n".join(points) or "none", "ends": branch.end_reason}


def _draw(branch: BranchResult, study: Study, figure: Any) -> None:
    from percuss.plotting.branch_plot import plot_branch
    from percuss.plotting.style import Units

    figure.set_size_inches(7.0, 4.6)
    units = Units(study.draw.length_unit, study.draw.time_unit)
    plot_branch(branch, figure.add_subplot(), quantity=study.draw.quantity, units=units)  # type: ignore[arg-type]  # its shape was checked
    figure.suptitle(study.title, parse_math=False)


def build(parts: Parts) -> Branch | None:
    """Return the question of a document, None if it has faults."""
    wanted = sought(parts)
    over = ranges_of(parts, 1, holds_own=True)
    return None if parts.found.faults else Branch(wanted, over, steps_of(parts))


KIND = Kind(BranchDocument, build)
