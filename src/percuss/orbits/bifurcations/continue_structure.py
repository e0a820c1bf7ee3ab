"""The continuation of a structure's periodic orbits along a parameter."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TypeAlias, cast

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ConvergenceError, PercussError
from percuss.model.exact import Phase
from percuss.model.faults import check_mapping
from percuss.numerics import dot, norm
from percuss.orbits.bifurcations.bifurcation_origin import (
    ENDS,
    MIRRORS,
    ONE_AND_THE_SAME,
    Origin,
)
from percuss.orbits.bifurcations.border_collision import border_reached, effect_of
from percuss.orbits.bifurcations.detector import COINCIDENCE, STANDING
from percuss.orbits.bifurcations.parameter_ranges import range_about
from percuss.orbits.bifurcations.special_points import SpecialPointKind
from percuss.orbits.bifurcations.structure_branch import (
    StructureBranch,
    StructureEquations,
    StructureSpecialPoint,
    amplitudes,
    begun_anew,
    structure_parameter,
)
from percuss.orbits.bifurcations.wall_equations import WallEquations, meets_walls_in_turn
from percuss.orbits.continuation.follow import (
    Segment,
    StepLimits,
    follow_both_ways,
    hides_zeros,
    special_points_of,
    unbounded_growth,
)
from percuss.orbits.continuation.locate import (
    Zero,
    changes_sign,
    locate,
    locate_near,
    turns_through_zero,
)
from percuss.orbits.continuation.problem import Point, along_parameter
from percuss.orbits.orbit.resonance import COARSE, passes_modal_resonance
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.orbits.orbit.symmetry import MIRRORED
from percuss.progress import Progress, Report
from percuss.wording import counted

# Difference of the halves of an orbit at the origin of its family, as a part of its neighbours'.
COVERED = 1e-3
# A pair of multipliers on the unit circle nearer than this to a root of unity of low order is a
# strong resonance.
RESONANT = 1e-3
# A bracket in the parameter that is a location, as a part of it.
LOCATED = 1e-9
# Points next to a zero that are farther apart lie on two families: beside a fold of one the
# corrector finds the other.
APART = 1e-6
# Of the origins of families the simpler orbits' test, its kind and detail.
ORIGINS: dict[Origin, tuple[str, SpecialPointKind, str]] = {
    "doubled": (
        "multiplier -1",
        "period_doubling",
        "the family of doubled orbits begins here; the orbit is the one that doubles",
    ),
    "mirrored": ("multiplier 1", "symmetry_breaking", MIRRORS),
}
StructureRow: TypeAlias = tuple[Point[StructureEquations], StructureSpecialPoint | None]
# A row after the part of a chord at which it lies.
PlacedRow: TypeAlias = tuple[float, Point[StructureEquations], StructureSpecialPoint | None]


class _BranchDetector:
    """Finds special points between neighbours."""

    def between(
        self, here: Point[StructureEquations], new: Point[StructureEquations]
    ) -> Segment[StructureEquations, StructureSpecialPoint]:
        """Return the special points between two neighbours, in order."""
        equations = here.problem
        too_long = _is_coarse(here, new) or passes_modal_resonance(here.orbit, new.orbit)
        fell = _fell_on_simpler(here, new) or _fell_on_another(here, new)
        if too_long or fell or _hides_grazes(here, new):
            return Segment([], is_astray=True)
        rows: list[PlacedRow] = []
        is_astray = False
        end = _origin_between(here, new)
        for name in equations.kinds:
            ends = (here.tests[name], new.tests[name])
            if name == "contacts":
                middle = 0.5 * (ends[0] + ends[1])
                ends = (ends[0] - middle, ends[1] - middle)
            else:
                middle = 0.0
            if not changes_sign(*ends) or (ends[0] == 0.0 == ends[1]):
                continue
            if name in equations.of_motions and not (here.orbit.admissible or new.orbit.admissible):
                continue

            def test(z: Floats, name: str = name, middle: float = middle) -> float:
                return equations.tests(z, equations.solution(z))[name] - middle

            zero = locate(here, new, test, ends)
            if name == "multiplier 1":
                origin = None if zero is None else _origin_at(here, new, zero)
                if origin is not None:
                    rows.append(origin)
                    end = end if equations.is_symmetric(here.orbit) else origin
                    continue
                if zero is not None and end is not None and _is_one_and_the_same(equations, zero):
                    # The end itself, where the multiplier is 1 to rounding.
                    continue
                if zero is None or norm(zero.ends[1] - zero.ends[0]) > APART:
                    is_astray = True
                    continue
            if zero is None:
                is_astray = True
                continue
            row = _special_at(here, new, zero, name, ends)
            if row is not None:
                rows.append(row)
        if end is not None:
            rows = [*(row for row in rows if row[0] < end[0]), end]
        why = _end_reason(here, new, end)
        rows.sort(key=lambda row: row[0])
        found: list[StructureRow] = [(point, special) for _, point, special in rows]
        is_astray = is_astray or hides_zeros(here, new, found)
        if not why:
            size = float(np.abs(new.z[: equations.size]).max())
            why = unbounded_growth(new, size, STANDING)
            found += [(new, None)] if why else []
        return Segment(found, why, is_astray=is_astray)

    def stopped(
        self,
        here: Point[StructureEquations],
        reason: str,
    ) -> Segment[StructureEquations, StructureSpecialPoint]:
        """Return what is beyond the last point: the same branch where an event is at t = 0.

        Or where an impact meets a jump of the loads.
        """
        equations = here.problem
        if isinstance(equations, WallEquations) and equations.border is not None:
            return self._across(cast("Point[WallEquations]", here), reason)
        return Segment([], reason, begun_anew(here))

    def _across(
        self, here: Point[WallEquations], reason: str
    ) -> Segment[StructureEquations, StructureSpecialPoint]:
        """Return the special points up to a border, the border, and the branch beyond it."""
        equations = here.problem
        try:
            border = border_reached(here)
        except PercussError as error:
            return Segment([], f"beyond {here.text} {reason}: {error}")
        assert border is not None
        rows: list[StructureRow] = []
        point = cast("Point[StructureEquations]", border.point)
        if border.before.z is not here.z:
            rows += self.between(
                cast("Point[StructureEquations]", here),
                cast("Point[StructureEquations]", border.before),
            ).rows
        if equations.jumps_at(border.event, point.z):
            stop = equations.walls[border.event]
            special = StructureSpecialPoint(
                "border_collision",
                equations.paths[0],
                equations.values(point.z)[0],
                "located",
                cast("StructureOrbit", point.orbit),
                -1,
                f"an impact on stop {stop} meets a jump of the loads{effect_of(border)}",
            )
            rows.append((point, special))
        beyond = cast("Point[StructureEquations] | None", border.beyond)
        return Segment(rows, border.end_reason, beyond)


def _hides_grazes(here: Point[StructureEquations], new: Point[StructureEquations]) -> bool:
    """Return whether a response reaches a wall, or comes off one, within a step alone."""
    ends = here.tests.get("clearance", math.nan), new.tests.get("clearance", math.nan)
    if not (here.is_response and new.is_response):
        return False
    problem, chord = here.problem, new.z - here.z
    normal = along_parameter(len(chord))

    def clearance(part: float) -> float:
        z = problem.corrected(here.z + part * chord, normal)
        return problem.tests(z, problem.solution(z))["clearance"]

    try:
        return turns_through_zero(clearance, ends)
    except ConvergenceError:
        return False


def _is_coarse(here: Point[StructureEquations], new: Point[StructureEquations]) -> bool:
    """Return whether a response changes much within a step, in which it may graze a stop twice.

    Or whether soft stops press on one of two all along that do not press on the other.
    """
    if not (here.is_response and new.is_response):
        return False
    if here.orbit.acting_first != new.orbit.acting_first:
        return True
    states = [point.z[: point.problem.size] for point in (here, new)]
    change = float(np.abs(states[1] - states[0]).max())
    return change > COARSE * max(1.0, float(np.abs(states).max()))


def _end_reason(
    here: Point[StructureEquations], new: Point[StructureEquations], end: PlacedRow | None
) -> str:
    """Return why a branch ends between two neighbours, "" where it goes on.

    ``end`` is the origin of its family, None where that is not there. Places that are not located
    have as many digits as are right.
    """
    equations = here.problem
    near = f"near {equations.paths[0]} ="
    if end is not None:
        rough = f"{near} {equations.values(end[1].z)[0]:.5g}"
        where = rough if end[2] is None else f"at {end[1].text}"
        return f"{where} {ENDS[equations.origin]}"
    if isinstance(equations, WallEquations) and equations.coincide(here.z, new.z):
        return f"{near} {equations.values(new.z)[0]:.5g} {COINCIDENCE}"
    return ""


def _fell_on_simpler(here: Point[StructureEquations], new: Point[StructureEquations]) -> bool:
    """Return whether a step has left a family for the simpler orbits from which it originates.

    These go on beyond its origin, and a corrector that keeps the parameter finds them alone there.
    """
    equations = here.problem
    return (
        equations.simpler(here.orbit) is not None
        and float(np.abs(equations.halves(here.orbit)).max()) >= MIRRORED
        and float(np.abs(equations.halves(new.orbit)).max()) < MIRRORED
    )


def _fell_on_another(here: Point[StructureEquations], new: Point[StructureEquations]) -> bool:
    """Return whether a step has left a branch: the parameter turns, and no multiplier passes 1.

    Along a branch both change sign where it folds (Allgower & Georg 1990); a family also turns where
    it comes back from the simpler orbits from which it originates.
    """
    if here.problem.simpler(here.orbit) is not None:
        return False
    tests = here.tests["multiplier 1"], new.tests["multiplier 1"]
    return _turns(here, new) and tests[0] * tests[1] > 0.0


def _origin_between(
    here: Point[StructureEquations], new: Point[StructureEquations]
) -> PlacedRow | None:
    """Return where the family originates from a simpler one, None where it nowhere does.

    A family of doubled orbits begins or ends where they are two-fold covers, one of mirrored pairs
    where they are symmetric: beyond lie the same orbits once more, half a period later, or
    mirrored. The difference of an orbit's halves goes through zero there as a whole. Returned are
    the part of the chord, the last point of the branch, and the simpler orbit, if it is a motion.
    """
    equations = here.problem
    if equations.simpler(here.orbit) is None:
        return None
    ends = equations.halves(here.orbit), equations.halves(new.orbit)
    if dot(*ends) >= 0.0 or min(float(np.abs(end).max()) for end in ends) < MIRRORED:
        return None
    along = ends[1] - ends[0]
    origin = _origin_near(here, new, norm(ends[0]) / norm(along))
    if origin is not None:
        return origin

    def test(z: Floats) -> float:
        return dot(along, equations.halves(equations.solution(z)))

    cover = locate(here, new, test, (dot(along, ends[0]), dot(along, ends[1])))
    if cover is None or norm(equations.halves(cover.orbit)) > COVERED * norm(along):
        return None
    return cover.part, Point(cover.z, new.tangent, cover.orbit, new.tests, equations), None


def _origin_at(
    here: Point[StructureEquations], new: Point[StructureEquations], zero: Zero
) -> PlacedRow | None:
    """Return a multiplier of 1 as that of the simpler orbit from which a family starts, if it is.

    There the equations have two small singular values: it is located along the simpler orbits.
    """
    equations = here.problem
    if _turns(here, new) == equations.is_symmetric(here.orbit):
        # No family starts; or symmetric orbits fold.
        return None
    if not _is_one_and_the_same(equations, zero):
        return None
    return _origin_near(here, new, zero.part)


def _is_one_and_the_same(equations: StructureEquations, zero: Zero) -> bool:
    """Return whether an orbit of a family is the simpler one from which that originates."""
    return float(np.abs(equations.halves(zero.orbit)).max()) <= ONE_AND_THE_SAME


def _turns(here: Point[StructureEquations], new: Point[StructureEquations]) -> bool:
    """Return whether the parameter turns between two neighbours."""
    return bool(here.tangent[-1] * new.tangent[-1] < 0.0)


def _special_at(
    here: Point[StructureEquations],
    new: Point[StructureEquations],
    zero: Zero,
    name: str,
    ends: tuple[float, float],
) -> PlacedRow | None:
    """Return the zero of a test between two neighbours as a special point, None where it is none.

    The test is given by its name, and its values at both.
    """
    equations, orbit = here.problem, cast("StructureOrbit", zero.orbit)
    kind, tests = equations.kinds[name], equations.tests(zero.z, orbit)
    if name in equations.of_motions and any(
        tests[other] < 0.0 for other in equations.of_motions if other != name
    ):
        return None
    if name == "multiplier 1" and _turns(here, new):
        kind = "fold"
    elif name == "multiplier 1" and equations.is_symmetric(here.orbit):
        # The square of -1, of the map over half an orbit.
        kind = "symmetry_breaking"
    detail = _detail(kind, orbit, ends, name)
    if detail is None:
        return None
    width = abs(zero.ends[0][-1] - zero.ends[1][-1])
    special = StructureSpecialPoint(
        kind,
        equations.paths[0],
        equations.values(zero.z)[0],
        "located" if width <= LOCATED else "bracketed",
        orbit,
        -1,
        detail,
    )
    return zero.part, Point(zero.z, new.tangent, zero.orbit, tests, equations), special


def _origin_near(
    here: Point[StructureEquations],
    new: Point[StructureEquations],
    part: float,
) -> PlacedRow | None:
    """Return where the simpler orbits have the multiplier near a part of a chord, None for nowhere.

    Newton's method fails next to the origin, but not for the simpler orbit.
    """
    equations, chord = here.problem, new.z - here.z
    family = equations.simpler(here.orbit)
    if family is None:
        return None
    rough = here.z + part * chord
    normal = along_parameter(len(family.scale) + 1)
    name, kind, detail = ORIGINS[equations.origin]

    def test(z: Floats) -> float:
        return family.tests(z, family.solution(z))[name]

    try:
        z = family.corrected(equations.once(rough), normal)
        start = family.point(z, Point(z, normal, None, {}, family))
        zero = locate_near(family, start.z, start.tangent, test)
        if zero is None:
            return None
        lifted = equations.twice(zero.z)
        orbit = equations.solution(lifted)
    except PercussError:
        return None
    if norm(lifted - rough) > max(norm(chord), ONE_AND_THE_SAME):
        return None
    special = StructureSpecialPoint(
        kind,
        equations.paths[0],
        family.values(zero.z)[0],
        "located",
        cast("StructureOrbit", zero.orbit),
        -1,
        detail,
    )
    return part, Point(lifted, new.tangent, orbit, new.tests, equations), special


def _detail(
    kind: SpecialPointKind, orbit: StructureOrbit, ends: tuple[float, float], test: str
) -> str | None:
    """Return a point in words, None where it is none.

    They say nothing of an order: the walk to one end is against that of the rows.
    """
    values = orbit.multipliers
    if kind == "grazing" and test != "contacts":
        what = "an impact without velocity" if "velocity" in test else "a wall is touched"
        return f"{what}; the orbits on one side are formal"
    if kind == "grazing":
        return f"{counted(round(abs(ends[1] - ends[0])), 'contact')} more on one side"
    if kind == "symmetry_breaking":
        return ORIGINS["mirrored"][2]
    if kind in ("fold", "branch_point"):
        return "two orbits meet and end" if kind == "fold" else "a multiplier of 1"
    if kind == "period_doubling":
        return "a multiplier of -1"
    above = values[values.imag > 1e-9]
    if len(above) == 0:
        return None
    sizes = np.abs(np.array([math.hypot(z.real, z.imag) for z in above.tolist()]) - 1.0)
    z = complex(above[int(np.argmin(sizes))])
    if float(sizes.min()) > 1e-4:
        return None
    for q, cosine in ((3, -0.5), (4, 0.0)):
        if abs(z.real - cosine) < RESONANT:
            return f"a pair of multipliers on the unit circle, strong resonance 1:{q}"
    return f"a pair of multipliers {z.real:.6g} ± {z.imag:.6g} i on the unit circle"


def continue_structure_orbit(
    orbit: StructureOrbit,
    over: Mapping[str, tuple[Phase, Phase]],
    *,
    max_points: int = 2000,
    largest_step: float = 0.02,
    progress: Report = None,
) -> StructureBranch:
    """Follow a structure's orbit along a parameter, both ways, stable or not.

    The arguments are those of `continue_orbit`. The equations are those of the map over the period:
    all orbits on the branch exist, and it passes the grazes of soft stops. Where an orbit meets
    walls at instants of its own, these are unknowns too, and the branch passes the grazes of walls:
    beyond its orbits are formal. A family of doubled orbits ends where these are two-fold covers of
    shorter ones, one of pairs that mirror each other where they are symmetric.

    Raises
    ------
    ParameterError
        If there is no such parameter, or the range does not hold the orbit's value.
    """
    check_mapping("over", over, "one parameter by its path and range", 1)
    ((path, ends),) = over.items()
    value = structure_parameter(orbit, path)
    first, last = range_about(value, path, ends, "orbit")
    steps = StepLimits.checked(max_points, largest_step)
    reported = Progress(progress, 2 * steps.max_points, "orbits", is_bound=True)
    ranges = {path: (min(first, last), max(first, last))}
    in_turn = meets_walls_in_turn(orbit)
    equations = WallEquations(orbit, ranges) if in_turn else StructureEquations(orbit, ranges)
    start = equations.started(orbit, [value])
    rows, why = follow_both_ways(start, last - first, _BranchDetector(), steps, reported)
    orbits = tuple(cast("StructureOrbit", point.orbit) for point, _ in rows)
    return StructureBranch(
        path=path,
        values=np.array([equations.values(point.z)[0] for point, _ in rows]),
        multipliers=np.array([each.multipliers for each in orbits]),
        is_stable=np.array([each.is_stable for each in orbits]),
        n_impacts=np.array([each.n_impacts for each in orbits]),
        amplitude=np.array([amplitudes(each) for each in orbits]),
        orbits=orbits,
        special_points=special_points_of(rows),
        end_reason=why,
    )
