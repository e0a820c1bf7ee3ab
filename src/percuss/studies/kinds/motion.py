"""Studies of one motion: where it starts, how long it is followed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import Field

from percuss.io.study_text import number, start_table
from percuss.model.exact import Exact, as_float, phase_problem
from percuss.model.exact import Phase as PhaseValue
from percuss.model.faults import draft, positive_faults
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start, end_after_periods, periods_faults, start_faults
from percuss.model.stops import SoftStop, Stop
from percuss.studies.faults import shown
from percuss.studies.parts import MISSING, Parts, Table, add_faults, drafted, exact_phase, rows_of
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import (
    CertifyTable,
    Document,
    DrawTable,
    Number,
    Phase,
    SampledSaveTable,
    StartTable,
)
from percuss.studies.schema import Table as Shape
from percuss.studies.shape import Found

if TYPE_CHECKING:
    from percuss.motion.impact_times import ImpactTimes
    from percuss.motion.trajectory import Trajectory
    from percuss.studies.study import Study

__all__ = ["KIND", "Limits", "Motion", "end_time", "right_walls", "start_of"]

NO_LIMIT = "missing a limit; give t_end, periods or max_impacts"
_PLACE = ("at", "side")


class RunTable(Shape):
    """``[run]``: how long the motion is followed."""

    t_end: Phase | None = None
    periods: Number | None = None
    max_impacts: int | None = None


class MotionDrawTable(DrawTable):
    """``[draw]`` of a motion."""

    window: Annotated[list[Phase], Field(min_length=2, max_length=2)] | None = None


class MotionDocument(Document):
    """A study file of one motion."""

    start: StartTable
    run: RunTable
    certify: CertifyTable | None = None
    save: SampledSaveTable = SampledSaveTable()
    draw: MotionDrawTable = MotionDrawTable()


@dataclass(frozen=True, slots=True)
class Limits:
    """How long a motion is followed.

    Parameters
    ----------
    t_end
        Time of the end [time]; or None.
    periods
        Number of forcing periods from the start, in place of `t_end`; or None.
    max_impacts
        Number of impacts and entries into soft stops after which to stop; or None.
    """

    t_end: PhaseValue | None = None
    periods: Exact | None = None
    max_impacts: int | None = None


@dataclass(frozen=True, slots=True)
class Motion:
    """The motion from a start.

    Parameters
    ----------
    start
        From where.
    limits
        How long.
    """

    kind: ClassVar[str] = "motion"
    doing: ClassVar[str] = "simulating"
    stem: ClassVar[str] = "motion"
    is_ensemble: ClassVar[bool] = False

    start: Start
    limits: Limits

    def end(self, forcing: Forcing | None) -> PhaseValue | None:
        """Return the time of the end, None if only the number of impacts limits the run."""
        return end_time(self.limits, forcing, self.start.t0)

    def t_end(self, forcing: Forcing | None) -> float | None:
        """Return the same as a float."""
        end = self.end(forcing)
        return None if end is None else as_float(end)

    def tables(self) -> dict[str, object]:
        """Return ``[start]`` and ``[run]``."""
        limits = self.limits
        run = {
            "t_end": None if limits.t_end is None else number(limits.t_end),
            "periods": None if limits.periods is None else number(limits.periods),
            "max_impacts": limits.max_impacts,
        }
        return {"start": start_table(self.start), "run": run}

    def csv(self, study: Study) -> dict[str, str]:
        """Return impacts and, where there are soft stops, crossings."""
        soft = any(isinstance(stop, SoftStop) for stop in study.oscillator.stops)
        tables = {"impacts": "impacts"} | ({"crossings": "crossings"} if soft else {})
        return tables | {"motion": "motion"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return the one with four panels."""
        return {"motion": _draw}

    def answer(self, study: Study, means: Means) -> Trajectory:
        """Simulate."""
        from percuss.motion.simulate import simulate

        start = self.start
        return simulate(
            study.oscillator,
            study.forcing,
            start.x0,
            start.v0,
            start.t0,
            t_end=self.end(study.forcing),
            max_impacts=self.limits.max_impacts,
            progress=means.progress,
        )

    def report(self, result: Trajectory) -> dict[str, str]:
        """Tell the events, the class of the impact times, and how it ended."""
        from percuss.motion.impact_times import classify_impact_times

        contacts = result.contacts
        first = f", the first from t = {contacts.start[0]:.10g}" if len(contacts) else ""
        entries = len(result.crossings) > 0 and len(result.impacts) == 0
        return {
            "impacts": str(len(result.impacts)),
            "crossings": str(len(result.crossings)),
            "contacts": f"{len(contacts)}{first}",
            "grazes": str(len(result.grazes)),
            "entry times" if entries else "impact times": impact_times_words(
                classify_impact_times(result)
            ),
            "outcome": str(result.outcome.value),
            "time": f"t = {result.t0:.10g} to {result.t_end:.10g}",
        }


def impact_times_words(times: ImpactTimes) -> str:
    """Return the class of the impact times in words."""
    pattern = f"{times.n_impacts} in {times.n_periods} forcing periods"
    if not times.n_periods:
        pattern = f"every {times.n_impacts}"
    return {
        "eigenset": f"the eigenset, within {times.deviation:.1e}",
        "eigenset_subset": f"a part of the eigenset, within {times.deviation:.1e}",
        "periodic": f"periodic: {pattern}",
        "settling": f"settling towards {pattern}, as exp(-{times.rate:.3g} t)",
        "approaching_eigenset": f"approaching the eigenset, now within {times.deviation:.1e}",
        "no_period_found": f"no period found in {times.n_used}",
        "too_few": f"too few to tell: {times.n_used}",
    }[times.kind]


def _draw(run: Trajectory, study: Study, figure: Any) -> None:
    from percuss.plotting.motion_plot import plot_motion
    from percuss.plotting.style import Units

    window = None
    if study.draw.window is not None:
        first, last = (as_float(time) for time in study.draw.window)
        # A run may end before the window begins: it was interrupted, or came to rest.
        window = (first, last) if first < run.t_end and last > run.t0 else None
    units = Units(study.draw.length_unit, study.draw.time_unit)
    plot_motion(run, figure, title=study.title, window=window, units=units)


def end_time(run: Limits, forcing: Forcing | None, t0: PhaseValue) -> PhaseValue | None:
    """Return the time at which a run ends, exactly; None without `t_end` and without periods."""
    if run.t_end is not None:
        return run.t_end
    if run.periods is None or forcing is None or forcing.period is None:
        return None
    return end_after_periods(forcing, t0, run.periods)


def start_of(parts: Parts) -> Start:
    """Return the start of a document, a draft where it has faults."""
    state = {**parts.table("start")}
    state |= {"t0": exact_phase(state["t0"])} if "t0" in state else {}
    return drafted(Start, state, {"x0": MISSING, "v0": MISSING, "t0": 0.0})


def build(parts: Parts) -> Motion | None:
    """Return the question of a document, None if it has faults."""
    found = parts.found
    start = start_of(parts)
    limits = _limits(parts.table("run"), parts.forcing, found)
    _check_start(parts.oscillator, parts.forcing, start, limits, found)
    _check_window(parts.table("draw"), start, limits, found)
    return None if found.faults else Motion(start, limits)


def _limits(table: Table, forcing: Forcing | None, found: Found) -> Limits:
    t_end, periods = exact_phase(table.get("t_end")), table.get("periods")
    if periods is not None:
        if found.is_wrong("forcing"):
            # Then whether it has a period cannot be told.
            add_faults(positive_faults("run.periods", periods), found)
        else:
            add_faults(periods_faults(forcing, periods, t_end, run="run"), found)
    return Limits(t_end, periods, table.get("max_impacts"))


def _check_start(
    oscillator: Oscillator, forcing: Forcing | None, start: Start, limits: Limits, found: Found
) -> None:
    """Add the faults of the start and of the limits that do not follow from others."""
    t_end: Any = limits.t_end
    if limits.periods is not None:
        # Any end will do where the periods, the forcing or t0 have faults of their own.
        is_right = not any(map(found.is_wrong, ("run", "forcing", "start.t0")))
        is_right = is_right and phase_problem(start.t0) is None
        t_end = end_time(limits, forcing, start.t0) if is_right else None
    is_open = t_end is None and limits.periods is None and limits.max_impacts is None
    if is_open and not found.is_wrong("run"):
        found.add(("run",), NO_LIMIT)
    walls = right_walls(oscillator, found)
    wrong = start_faults(
        draft(Oscillator, stops=walls),
        start.x0,
        start.v0,
        start.t0,
        t_end,
        limits.max_impacts,
        start="start",
        run="run",
    )
    add_faults([fault for fault in wrong if fault.name != "run.t_end" or t_end is not None], found)


def right_walls(oscillator: Oscillator, found: Found) -> tuple[Stop, ...]:
    """Return the stops whose place is known: only in such a wall can a start be."""
    return tuple(
        stop
        for index, stop in enumerate(oscillator.stops)
        if not any(found.is_wrong(f"oscillator.stops.{index}.{name}") for name in _PLACE)
        and MISSING not in (stop.at, stop.side)
    )


def _check_window(table: Table, start: Start, limits: Limits, found: Found) -> None:
    """Add what is wrong with the part that is drawn."""
    times = [exact_phase(time) for time in rows_of(table, "window")]
    if len(times) != 2 or found.is_wrong("draw.window"):
        return
    for index, time in enumerate(times):
        problem = phase_problem(time)
        if problem is not None:
            found.add(("draw", "window", index), problem, shown(time))
    if found.is_wrong("draw.window") or found.is_wrong("start.t0") or found.is_wrong("run"):
        return
    first, last = (as_float(time) for time in times)
    if first >= last:
        found.add(("draw", "window"), "the first time is not before the last", shown(times))
    elif last <= as_float(start.t0) or (
        limits.t_end is not None and first >= as_float(limits.t_end)
    ):
        found.add(("draw", "window"), "outside the run", shown(times))


KIND = Kind(MotionDocument, build)
