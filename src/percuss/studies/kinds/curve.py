"""Studies of curves in two parameters: special points of a branch followed further."""

from __future__ import annotations

import warnings
from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self, get_args

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.execution import Execution
from percuss.model.exact import as_float
from percuss.model.paths import long_form
from percuss.orbits import continue_curve
from percuss.studies.axes import OverRanges, ParameterRange, ranges_over
from percuss.studies.kinds.branch import Steps, follow
from percuss.studies.kinds.orbit import Sought
from percuss.studies.study import Question, StudyDraft, only_axes
from percuss.studies.tables import Text, raw_table, shown, table, unknown_value

if TYPE_CHECKING:
    from percuss.orbits import Curve as CurveResult
    from percuss.orbits import StructureCurve
    from percuss.studies.study import Study

# Two curves are one whose ends differ by so little of the ranges, or of closed ones whose extents do.
SAME_END, SAME_BOX = 1e-6, 0.01
PointKind = Literal["fold", "period_doubling", "symmetry_breaking", "grazing", "torus"]
OF_OSCILLATORS: tuple[PointKind, ...] = get_args(PointKind)[:4]
OF_STRUCTURES: tuple[PointKind, ...] = get_args(PointKind)


@table
class Curve(Question):
    """The curves in two parameters on which special points of a branch lie.

    Parameters
    ----------
    sought
        The orbit to begin with.
    over
        Two parameters by their paths, and their ranges.
    along
        The one of them along which the branch is followed first; default: the first.
    points
        Kinds of special points of that branch at which curves begin.
    steps
        How the branch is followed.
    """

    doing: ClassVar = "following the curves"
    stem: ClassVar = "curves"
    needed: ClassVar = ("over",)
    needed_of_structures: ClassVar = ("over",)
    # One row a point of a curve.
    columns: ClassVar = {"curves": "curves"}

    sought: Sought
    over: OverRanges
    along: Text | None = None
    points: tuple[PointKind, ...] = OF_OSCILLATORS
    steps: Steps = Steps()

    def checked(self, study: StudyDraft) -> Self:
        """Check the orbit sought, and read the ranges and the parameter of the branch."""
        self.sought.check(study)
        over = ranges_over(study, 2, holds_own=True)
        own = replace(self, over=over, along=self._first_of(over, study))
        if study.structure is None:
            own._check_points(study)
        elif "points" not in raw_table(study.document, "curve"):
            own = replace(own, points=OF_STRUCTURES)
        return own

    def _check_points(self, study: StudyDraft) -> None:
        """Add the faults of points that an oscillator does not have."""
        for index, name in enumerate(self.points):
            if name not in OF_OSCILLATORS:
                reason = unknown_value(name, list(OF_OSCILLATORS))
                study.faults.add(("curve", "points", index), reason, shown(name))

    def _first_of(self, over: dict[str, ParameterRange], study: StudyDraft) -> str:
        """Return the parameter of the branch, and add its faults."""
        given = self.along
        if given is None or len(over) < 2:
            return given or next(iter(over), "")
        # In its long or its short form, in both places.
        names = {long_form(path, study.model, study.force): path for path in over}
        try:
            name = long_form(given, study.model, study.force)
        except ParameterError:
            name = ""
        if name not in names:
            reason = f"not one of the parameters in [over], {' and '.join(over)}"
            study.faults.add(("curve", "along"), reason, shown(given))
        return names.get(name, given)

    def answer(self, study: Study, execution: Execution) -> list[CurveResult | StructureCurve]:
        """Follow the orbit, and each special point."""
        along = self.along or next(iter(self.over))
        branch = follow(study, self.sought, {along: self.over[along]}, self.steps, execution)
        ends = [(as_float(low), as_float(high)) for low, high in self.over.values()]
        widths = np.array([high - low for low, high in ends])
        curves: list[CurveResult | StructureCurve] = []
        for point in branch.special_points:
            if point.kind not in self.points:
                continue
            try:
                curve = continue_curve(point, self.over, progress=execution.progress)
            except ParameterError as error:
                # The others have their curves.
                what = f"no curve from {point.kind} at {point.path} = {point.value:.6g}"
                warnings.warn(f"{what}: {error.reason}", stacklevel=2)
                continue
            if not any(_is_same(curve, other, widths) for other in curves):
                curves.append(curve)
        return curves

    def draw(self, result: list[CurveResult | StructureCurve], study: Study, figure: Any) -> None:
        """Draw the curves in the plane of the parameters."""
        from percuss.plotting import plot_curves

        if result:
            plot_curves(result, only_axes(figure, 7.0, 5.0), units=study.draw.units())
        else:
            figure.set_size_inches(7.0, 5.0)
            figure.text(0.5, 0.5, "no such points on the branch", ha="center")

    def report(self, result: list[CurveResult | StructureCurve]) -> dict[str, str]:
        """Return each curve, its special points and why it ends."""
        rows = {"curves": str(len(result)) if result else "none: no such points on the branch"}
        for i, curve in enumerate(result):
            first, last = (", ".join(f"{v:.8g}" for v in curve.values[row]) for row in (0, -1))
            kind = curve.kind.replace("_", " ")
            lines = [f"{kind}, {len(curve)} points from ({first}) to ({last})"]
            for point in curve.special_points:
                at = ", ".join(f"{value:.10g}" for value in point.values)
                detail = f": {point.detail}" if hasattr(point, "detail") else ""
                lines.append(f"{point.kind.replace('_', ' ')} at ({at}){detail}")
            rows[f"curve {i}"] = "\n".join([*lines, f"ends: {curve.end_reason}"])
        return rows


def _is_same(
    one: CurveResult | StructureCurve, other: CurveResult | StructureCurve, widths: Floats
) -> bool:
    """Return whether two curves are one, on which the branch has two points: by their ends."""
    if one.kind != other.kind:
        return False
    first, second = (curve.values / widths for curve in (one, other))
    if one.end_reason.endswith("closed") and other.end_reason.endswith("closed"):
        boxes = [np.array([part.min(axis=0), part.max(axis=0)]) for part in (first, second)]
        return bool(np.abs(boxes[0] - boxes[1]).max() < SAME_BOX)
    ends = first[[0, -1]]
    return any(np.abs(ends - second[rows]).max() < SAME_END for rows in ([0, -1], [-1, 0]))
