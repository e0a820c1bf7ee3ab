"""Studies of curves in two parameters: special points of a branch followed further."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Literal

from pydantic import Field

from percuss.model.paths import long_form
from percuss.studies.axes import Range, axes_table, ranges_of
from percuss.studies.faults import shown
from percuss.studies.kinds.branch import DEFAULT_STEPS, BranchTable, Steps, follow, steps_of
from percuss.studies.kinds.orbit import OrbitTable, Sought, find, sought
from percuss.studies.parts import Parts
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import Document, Table

if TYPE_CHECKING:
    from percuss.orbits import Curve as CurveResult
    from percuss.studies.study import Study

__all__ = ["KIND", "Curve"]

PointKind = Literal["fold", "period_doubling", "symmetry_breaking", "grazing"]
ALL: tuple[PointKind, ...] = ("fold", "period_doubling", "symmetry_breaking", "grazing")


class CurveTable(Table):
    """``[curve]``: where the curves begin."""

    along: str | None = None
    points: list[PointKind] = Field(default=list(ALL))


class CurveDocument(Document):
    """A study file of curves."""

    orbit: OrbitTable = OrbitTable()
    over: dict[str, object]
    branch: BranchTable = BranchTable()
    curve: CurveTable = CurveTable()


@dataclass(frozen=True, slots=True)
class Curve:
    """The curves in two parameters on which special points of a branch lie.

    Parameters
    ----------
    sought
        The orbit to begin with.
    over
        Two parameters by their paths, and their ranges.
    along
        The one of them along which the branch is followed first.
    points
        Kinds of special points of that branch at which curves begin.
    steps
        How the branch is followed.
    """

    kind: ClassVar[str] = "curve"
    doing: ClassVar[str] = "following the curves"
    stem: ClassVar[str] = "curves"
    is_ensemble: ClassVar[bool] = False

    sought: Sought
    over: dict[str, Range]
    along: str
    points: tuple[PointKind, ...] = ALL
    steps: Steps = DEFAULT_STEPS

    def tables(self) -> dict[str, object]:
        """Return ``[orbit]``, ``[over]``, ``[branch]`` and ``[curve]``."""
        return {
            "orbit": self.sought.table(),
            "over": axes_table(self.over),
            "branch": self.steps.table(),
            "curve": {"along": self.along, "points": list(self.points)},
        }

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return one row a point of a curve."""
        return {"curves": "curves"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return the curves in the plane of the parameters."""
        return {"curves": _draw}

    def answer(self, study: Study, means: Means) -> list[CurveResult]:
        """Follow the orbit, and each special point."""
        from percuss.orbits import continue_curve

        over = {self.along: self.over[self.along]}
        branch = follow(find(study, self.sought), over, self.steps, means)
        return [
            continue_curve(point, self.over, progress=means.progress)
            for point in branch.special_points
            if point.kind in self.points
        ]

    def report(self, result: list[CurveResult]) -> dict[str, str]:
        """Tell each curve, its special points and why it ends."""
        rows = {"curves": str(len(result)) if result else "none: no such points on the branch"}
        for i, curve in enumerate(result):
            first, last = (", ".join(f"{v:.8g}" for v in curve.values[row]) for row in (0, -1))
            kind = curve.kind.replace("_", " ")
            lines = [f"{kind}, {len(curve)} points from ({first}) to ({last})"]
            for point in curve.special_points:
                at = ", ".join(f"{value:.10g}" for value in point.values)
                lines.append(f"{point.kind.replace('_', ' ')} at ({at}): {point.detail}")
            rows[f"curve {i}"] = "\n".join([*lines, f"ends: {curve.end_reason}"])
        return rows


def _draw(curves: list[CurveResult], study: Study, figure: Any) -> None:
    from percuss.plotting import plot_curves

    figure.set_size_inches(7.0, 5.0)
    if curves:
        plot_curves(curves, figure.add_subplot())
    else:
        figure.text(0.5, 0.5, "no such points on the branch", ha="center")
    figure.suptitle(study.title, parse_math=False)


def _along(parts: Parts, over: dict[str, Range]) -> str:
    """Return the parameter of the branch, and add what is wrong with it."""
    given: str | None = parts.keys("curve").get("along")
    if given is None or len(over) < 2:
        return given or next(iter(over), "")
    # In its long or its short form, in both places.
    names = {long_form(path, parts.oscillator, parts.forcing): path for path in over}
    try:
        name = long_form(given, parts.oscillator, parts.forcing)
    except ValueError:
        name = ""
    if name not in names:
        reason = f"not one of the parameters in [over], {' and '.join(over)}"
        parts.found.add(("curve", "along"), reason, shown(given))
    return names.get(name, given)


def build(parts: Parts) -> Curve | None:
    """Return the question of a document, None if it has faults."""
    wanted = sought(parts)
    over = ranges_of(parts, 2, holds_own=True)
    along = _along(parts, over)
    points = tuple(parts.keys("curve").get("points", ALL))
    if parts.found.faults:
        return None
    return Curve(wanted, over, along, points, steps_of(parts))


KIND = Kind(CurveDocument, build)
