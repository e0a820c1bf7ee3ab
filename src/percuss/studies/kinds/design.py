"""Studies of a design: the setting at which an outcome is best, or the front between two."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, Self, TypeAlias

from pydantic import Field, PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from percuss.ensembles.measures import outcome_dimensions
from percuss.execution import Execution
from percuss.io.study_text import number
from percuss.model.dimensions import unit_of_setting
from percuss.model.exact import Exact, as_float, number_problem
from percuss.model.units import in_units
from percuss.optimization import design, pareto_front
from percuss.optimization.outcomes import outcome_names
from percuss.studies.axes import OverRanges, ranges_in
from percuss.studies.kinds.motion import Motion
from percuss.studies.kinds.orbit import Sought
from percuss.studies.measured import MeasureNames
from percuss.studies.study import AT_REST, Question, StudyDraft, only_axes, with_unit
from percuss.studies.tables import (
    NUMBERS_SCHEMA,
    Limits,
    Path,
    StartState,
    Whole,
    default,
    raw_table,
    shown,
    table,
    table_only,
    unknown_value,
    words_of_file,
)
from percuss.wording import counted

if TYPE_CHECKING:
    from percuss.optimization import Design as DesignResult
    from percuss.optimization import ParetoFront
    from percuss.studies.study import Study

GOALS = ("least", "largest")
NO_GOAL = 'neither "least" nor "largest", nor a number, the wanted value'
NO_LIMIT = "not [least, largest], where inf is no limit"
# Parameters and tables of a front have no room for more lines.
MOST_ROWS = 20

# The least and the largest value of an outcome; None: no limit.
LimitEnds: TypeAlias = "tuple[Exact | None, Exact | None]"


def _goals(value: object) -> object:
    goals = tuple(value) if isinstance(value, list | tuple) else (value,)
    if not all(goal in GOALS or number_problem(goal) is None for goal in goals):
        raise PydanticCustomError("goal", NO_GOAL)
    return goals


def _written_goals(goals: Any) -> object:
    rows = [number(goal) for goal in (goals if isinstance(goals, tuple) else (goals,))]
    return rows if len(rows) > 1 else rows[0]


def _written_limits(limits: Any) -> object:
    return {
        name: [
            written if end is None else number(end)
            for end, written in zip(ends, (-math.inf, math.inf), strict=True)
        ]
        for name, ends in limits.items()
    } or None


GoalKeys = Annotated[
    tuple[Exact, ...],
    PlainValidator(_goals),
    PlainSerializer(_written_goals),
    WithJsonSchema(NUMBERS_SCHEMA),
]
LimitKeys = Annotated[
    dict[str, LimitEnds],
    PlainValidator(table_only),
    PlainSerializer(_written_limits),
    WithJsonSchema({"type": "object"}),
]


@table
class Design(Question):
    """The best setting of free parameters, as `percuss.design` takes it, or a front.

    Parameters
    ----------
    outcome
        The outcome; of two of them `percuss.pareto_front` finds the front between.
    free
        The free parameters by their paths, and their ranges.
    goal
        "least", "largest" or a value; of a front one for each outcome, or one for both.
    subject_to
        Least and largest values of other outcomes; None: no limit.
    on
        "orbit": one period of an attracting orbit, or of that which `sought` finds; "run": a
        motion from a start.
    restarts, seed, n
        As there.
    start, limits
        Where a run starts, and its end.
    sought
        The orbit that is followed, stable or not; None: the attracting ones.
    """

    doing: ClassVar = "searching"
    needed: ClassVar = ("design",)
    needed_of_structures: ClassVar = ("design",)

    outcome: MeasureNames
    free: OverRanges = Field(default_factory=dict)
    goal: GoalKeys = (default(design, "goal"),)
    subject_to: LimitKeys = Field(default_factory=dict)
    on: Literal["orbit", "run"] = default(design, "on")
    restarts: Whole = default(design, "restarts")
    seed: Whole = default(design, "seed")
    n: Annotated[int, Field(strict=True, ge=2)] = default(pareto_front, "n")
    start: StartState = AT_REST
    limits: Limits = Limits()
    sought: Sought | None = None

    @property
    def is_front(self) -> bool:
        """Whether it asks for the front between two outcomes."""
        return len(self.outcome) == 2

    @property
    def goals(self) -> tuple[Any, ...]:
        """The goal of each outcome."""
        return self.goal * len(self.outcome) if len(self.goal) == 1 else self.goal

    def checked(self, study: StudyDraft) -> Self:
        """Check the names, the goals and the motion, and read the ranges and the limits."""
        self._check_outcomes(study)
        self._check_goals(study)
        start = self._checked_motion(study)
        place = ("design", "free")
        is_run = self.on == "run"
        free = ranges_in(study, place, start if is_run else None)
        if not raw_table(raw_table(study.document, "design"), "free"):
            study.faults.add(place, 'missing; such as {"forcing.omega" = [1, 2]}')
        return replace(self, free=free, subject_to=self._limits(study), start=start)

    def _check_outcomes(self, study: StudyDraft) -> None:
        """Add the faults of the names of outcomes."""
        known = list(outcome_names(study.model, of_orbit=self.on == "orbit"))
        path: Path = ("design", "outcome")
        raw = raw_table(study.document, "design").get("outcome")
        if not study.faults.is_wrong("design.outcome"):
            for index, name in enumerate(self.outcome):
                if name not in known:
                    place = path if isinstance(raw, str) else (*path, index)
                    study.faults.add(place, unknown_value(name, known), shown(name))
        if not 1 <= len(self.outcome) <= 2:
            reason = f"{counted(len(self.outcome), 'outcome')}; give one, or two for a front"
            study.faults.add(path, reason)
        elif len(set(self.outcome)) < len(self.outcome):
            study.faults.add(path, "twice the same outcome", shown(self.outcome))

    def _check_goals(self, study: StudyDraft) -> None:
        """Add the faults of goals that do not fit the outcomes, and of what is not of a front."""
        path, faults = ("design", "goal"), study.faults
        is_told = faults.is_wrong("design.outcome") or faults.is_wrong("design.goal")
        if not is_told and len(self.goals) != len(self.outcome):
            of = counted(len(self.outcome), "outcome")
            faults.add(path, f"{counted(len(self.goals), 'goal')} for {of}", shown(self.goal))
        elif not is_told and self.is_front and not set(self.goals) <= set(GOALS):
            reason = 'a front is between outcomes that are "least" or "largest"'
            faults.add(path, reason, shown(_written_goals(self.goal)))
        if not is_told and not self.is_front and "n" in raw_table(study.document, "design"):
            faults.add(("design", "n"), "of a front, which is between two outcomes", str(self.n))

    def _checked_motion(self, study: StudyDraft) -> Any:
        """Return the start of the run; add the faults of run or orbit, and tables of the other."""
        if study.faults.is_wrong("design.on"):
            return self.start
        others = {"run": ("orbit",), "orbit": ("start", "run")}[self.on]
        for name in others:
            if name in study.document:
                reason = f'given though design.on is "{self.on}"'
                study.faults.add((name,), reason)
        if self.on == "run":
            return Motion(self.start, self.limits).checked(study).start
        if self.sought is not None:
            self.sought.check(study)
        elif study.structure is not None or (
            study.forcing is not None and not study.forcing.is_constant
        ):
            study.needs_period("a periodic orbit needs a periodic forcing")
        return self.start

    def _limits(self, study: StudyDraft) -> dict[str, LimitEnds]:
        """Return the limits of outcomes, and add their faults."""
        known = list(outcome_names(study.model, of_orbit=self.on == "orbit"))
        limits: dict[str, LimitEnds] = {}
        for name, given in self.subject_to.items():
            place: Path = ("design", "subject_to", name)
            if name not in known:
                study.faults.add(place, unknown_value(name, known))
                continue
            ends = _limit_ends(place, given, study)
            if ends is not None:
                limits[name] = ends
        return limits

    def tables(self) -> dict[str, object]:
        """Return the tables of the question without those of other motions."""
        tables: dict[str, Any] = Question.tables(self)
        if not self.is_front:
            tables["design"] = {**tables["design"], "n": None}
        left = ("start", "run") if self.on == "orbit" else ()
        return {name: own for name, own in tables.items() if name not in left}

    def answer(self, study: Study, execution: Execution) -> DesignResult | ParetoFront:
        """Search."""
        settings: dict[str, Any] = {
            "free": self.free,
            "subject_to": self.subject_to,
            "on": self.on,
            "restarts": self.restarts,
            "seed": self.seed,
            "progress": execution.progress,
        }
        if self.on == "run":
            limits = self.limits
            settings |= {"start": self.start, "t_end": limits.t_end, "periods": limits.periods}
            settings |= {"max_impacts": limits.max_impacts}
        elif self.sought is not None:
            settings["on"] = self.sought.find(study)
        model, names = (study.model, study.force), self.outcome
        if self.is_front:
            return pareto_front(names, *model, goals=self.goals, n=self.n, **settings)  # type: ignore[arg-type]
        return design(names[0], *model, goal=self.goals[0], **settings)

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return the table of a front; or those of the searches and of the best setting."""
        return {"design": "front"} if self.is_front else {"design": "searches", "best": "best"}

    def draw(self, result: Any, study: Study, figure: Any) -> None:
        """Draw the front; or the motion at the best setting above the ranges."""
        from percuss.plotting import plot_design, plot_displacement, plot_pareto

        units = study.draw.units()
        if self.is_front:
            plot_pareto(result, only_axes(figure, 7.0, 4.6), units=units)
            return
        below = 0.6 + 0.7 * len(result.values)
        figure.set_size_inches(8.0, 3.4 + below)
        upper, lower = figure.subplots(2, 1, height_ratios=[3.4, below])
        plot_displacement(result.run, upper, units=units)
        plot_design(result, lower, units=units)

    def report(self, result: Any) -> dict[str, str]:
        """Return the best setting with its limits and why the search ended; or the front."""
        if self.is_front:
            return _report_of_front(result)
        words = self.goals[0] if isinstance(self.goals[0], str) else ""
        goal = f", {words}" if words in GOALS else f", wanted {as_float(self.goals[0]):.10g}"
        rows = {"design": _outcome(result, result.outcome, result.value) + goal}
        for path, value in result.values.items():
            low, high = result.bounds[path]
            end = f", {_which(value, low, high)} of its range" if path in result.active else ""
            rows[path] = (
                f"{_setting(result, path, value, 8)}{end}; free from {low:.6g} to {high:.6g}"
            )
        for name, value in result.outcomes.items():
            met = ", at its limit" if name in result.active else ""
            rows[name] = f"{_value(result, name, value)}{met}; {_kept(result.limits[name])}"
        optima = sum(not attempt.reason for attempt in result.attempts)
        rows["searches"] = (
            f"{len(result.attempts)} from {result.begun}, {optima} of them to an optimum"
        )
        rows["motions"] = f"{result.n_motions:,}"
        return rows | ({"no optimum": result.reason} if result.reason else {})


def _limit_ends(place: Path, given: Any, study: StudyDraft) -> LimitEnds | None:
    """Return the limits of an outcome, None if they have faults; add these."""
    if not isinstance(given, list) or len(given) != 2:
        study.faults.add(place, NO_LIMIT, shown(given))
        return None
    ends = [
        None if end == side else end for end, side in zip(given, (-math.inf, math.inf), strict=True)
    ]
    for index, end in enumerate(ends):
        problem = None if end is None else number_problem(end)
        if problem is not None:
            study.faults.add((*place, index), words_of_file(problem), shown(end))
    if study.faults.is_wrong(".".join(map(str, place))):
        return None
    low, high = ends
    if low is None is high:
        study.faults.add(place, "give the least value, the largest or both")
    elif low is not None and high is not None and as_float(low) > as_float(high):
        study.faults.add(place, "the least is above the largest", shown(given))
    return low, high


def _value(result: DesignResult, name: str, value: float) -> str:
    """Return an outcome with its unit."""
    osc = result.oscillator
    return with_unit(value, in_units(osc.units, outcome_dimensions(name, osc)), 8)


def _setting(result: DesignResult, path: str, value: float, digits: int) -> str:
    """Return a parameter with its unit."""
    return with_unit(value, unit_of_setting(path, result.oscillator, result.forcing), digits)


def _outcome(result: DesignResult, name: str, value: float) -> str:
    return f"{name} {_value(result, name, value)}"


def _which(value: float, low: float, high: float) -> str:
    return "the least" if value - low < high - value else "the largest"


def _kept(ends: tuple[float | None, float | None]) -> str:
    """Return the limits of an outcome in words."""
    low, high = ends
    words = [f"at least {low:.6g}"] if low is not None else []
    return ", ".join(words + ([f"at most {high:.6g}"] if high is not None else []))


def _report_of_front(front: ParetoFront) -> dict[str, str]:
    """Return the designs of a front, each in a line."""
    one, other = front.outcomes
    rows = {
        "front": f"{counted(len(front), 'design')}, {one} {front.goals[0]} to {other} {front.goals[1]}"
    }
    for i, (best, pair) in enumerate(zip(front.designs[:MOST_ROWS], front.values, strict=False)):
        where = ", ".join(
            f"{path} = {_setting(best, path, value, 6)}" for path, value in best.values.items()
        )
        values = (
            _outcome(best, name, value) for name, value in zip(front.outcomes, pair, strict=True)
        )
        rows[f"design {i}"] = f"{', '.join(values)} at {where}"
    if len(front) > MOST_ROWS:
        rows["and"] = f"{len(front) - MOST_ROWS} more in the files"
    if front.n_left_out:
        rows["left out"] = f"{front.n_left_out}, which one of these betters in both outcomes, or is"
    reasons = [best.reason for best in front.designs if best.reason]
    words = f"{len(reasons)} of {len(front)}: {reasons[0]}" if reasons else ""
    return rows | ({"no optimum": words} if words else {})
