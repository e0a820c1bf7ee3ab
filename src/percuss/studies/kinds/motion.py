"""Studies of one motion: its start and its end."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, ClassVar, Self

from percuss.execution import Execution
from percuss.model import exact
from percuss.model.exact import as_float, phase_problem
from percuss.model.faults import positive_faults
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import SoftStop
from percuss.model.start import end_after_periods, limit_faults, periods_faults
from percuss.model.units import FORCE
from percuss.studies.study import Question, StudyDraft, check_start, ends_in_words, span_in_words
from percuss.studies.tables import Limits, StartState, shown, table
from percuss.wording import counted

if TYPE_CHECKING:
    from percuss.motion.impact_times import ImpactTimes
    from percuss.motion.structures import StructureTrajectory
    from percuss.motion.trajectory import Trajectory
    from percuss.plotting.animation import Film
    from percuss.studies.study import Study


@table
class Motion(Question):
    """The motion from a start.

    Parameters
    ----------
    start
        The state in which it begins.
    limits
        Its end.
    """

    doing: ClassVar = "simulating"
    is_certifiable: ClassVar = True
    needed: ClassVar = ("run",)
    needed_of_structures: ClassVar = ("run",)
    save_keys: ClassVar = ("samples",)
    draw_keys: ClassVar = ("window", "animation")
    draw_keys_of_structures: ClassVar = ("window", "animation", "on")

    start: StartState
    limits: Limits

    def end(self, forcing: Forcing | Loads | None) -> exact.Phase | None:
        """Return the exact time of the end, None if only the number of impacts limits the run.

        Under loads of a structure the end after whole periods is a double, as `simulate` has it.
        """
        limits = self.limits
        if limits.t_end is not None or limits.periods is None:
            return limits.t_end
        if forcing is None or forcing.period is None:
            return None
        if isinstance(forcing, Loads):
            return as_float(self.start.t0) + as_float(limits.periods) * forcing.period
        return end_after_periods(forcing, self.start.t0, limits.periods)

    def t_end(self, forcing: Forcing | Loads | None) -> float | None:
        """Return the time of the end as a float."""
        end = self.end(forcing)
        return None if end is None else as_float(end)

    def checked(self, study: StudyDraft) -> Self:
        """Check the start, the limits, and the part that is drawn."""
        limits, faults = self.limits, study.faults
        if study.structure is not None:
            from percuss.studies.of_structures import checked_motion

            if study.draw.window is not None:
                self._check_window(study.draw.window, study)
            return replace(self, start=checked_motion(self.start, self.limits, study))
        if limits.periods is not None:
            # A forcing with faults may have no period.
            faults.add_from_model(
                positive_faults("run.periods", limits.periods)
                if faults.is_wrong("forcing")
                else periods_faults(study.forcing, limits.periods, limits.t_end, run="run")
            )
        self._check_start(study)
        if study.draw.window is not None:
            self._check_window(study.draw.window, study)
        return self

    def _check_start(self, study: StudyDraft) -> None:
        """Add the faults of the start and of the limits that do not follow from others."""
        start, limits, faults = self.start, self.limits, study.faults
        t_end = limits.t_end
        if limits.periods is not None:
            # Unknown where the periods, the forcing or t0 have faults.
            is_right = not any(map(faults.is_wrong, ("run", "forcing", "start.t0")))
            is_right = is_right and phase_problem(start.t0) is None
            t_end = self.end(study.forcing) if is_right else None
        is_open = t_end is None and limits.periods is None and limits.max_impacts is None
        if is_open and not faults.is_wrong("run"):
            faults.add(("run",), "missing a limit; give t_end, periods or max_impacts")
        check_start(start, study)
        wrong = limit_faults(start.t0, t_end, limits.max_impacts, limits.periods, run="run")
        faults.add_from_model(
            fault for fault in wrong if fault.name != "run.t_end" or t_end is not None
        )

    def _check_window(self, window: tuple[exact.Phase, ...], study: StudyDraft) -> None:
        path, faults, t_end = ("draw", "window"), study.faults, self.limits.t_end
        for index, time in enumerate(window):
            problem = phase_problem(time)
            if problem is not None:
                faults.add((*path, index), problem, shown(time))
        if any(map(faults.is_wrong, ("draw.window", "start.t0", "run"))):
            return
        first, last = (as_float(time) for time in window)
        if first >= last:
            reason = "the first time is not before the last"
            faults.add(path, reason, shown(list(window)))
        elif last <= as_float(self.start.t0) or (t_end is not None and first >= as_float(t_end)):
            faults.add(path, "outside the run", shown(list(window)))

    def answer(self, study: Study, execution: Execution) -> Trajectory | StructureTrajectory:
        """Compute the motion."""
        if study.structure is not None:
            from percuss.studies.of_structures import motion_of

            return motion_of(self.start, self.limits, study, execution)
        return self.simulated(
            study,
            t_end=self.end(study.forcing),
            max_impacts=self.limits.max_impacts,
            progress=execution.progress,
        )

    def simulated(self, study: Study, **limits: Any) -> Trajectory:
        """Return the motion from the start up to limits, which are keywords of `simulate`."""
        from percuss.motion.simulate import simulate

        start = self.start
        return simulate(study.oscillator, study.forcing, start.x0, start.v0, start.t0, **limits)

    def csv(self, study: Study) -> dict[str, str]:
        """Return impacts and, where there are soft stops, crossings."""
        soft = any(isinstance(stop, SoftStop) for stop in study.model.stops)
        names = ["impacts", *(["crossings"] if soft else []), "motion"]
        return {name: name for name in names}

    def draw(self, result: Any, study: Study, figure: Any) -> None:
        """Draw displacement, velocity, phase plane and section; of a structure displacements."""
        window = _drawn_window(result, study)
        if study.structure is not None:
            from percuss.studies.of_structures import draw_motion

            draw_motion(result, study, figure, window)
            return
        from percuss.plotting.motion_plot import plot_motion

        plot_motion(result, figure, window=window, units=study.draw.units())

    def film(self, result: Any, study: Study) -> Film:
        """Return the film of the motion."""
        from percuss.plotting.animation import MOST_TRACKS, animate

        on = None
        if study.structure is not None:
            from percuss.studies.of_structures import shown_directions

            on = shown_directions(study)[:MOST_TRACKS]
        return animate(
            result,
            on=on,
            window=_drawn_window(result, study),
            units=study.draw.units(),
            title=study.title,
        )

    def report(self, result: Any) -> dict[str, str]:
        """Return the events, the class of the impact times, and how it ended."""
        if hasattr(result, "structure"):
            from percuss.studies.of_structures import extremes_in_words

            extremes, units = extremes_in_words(result), result.structure.units
        else:
            extremes, units = _extremes_in_words(result), result.oscillator.units
        contacts = result.contacts
        first = f", the first from t = {contacts.start[0]:.10g}" if len(contacts) else ""
        return {
            **({"record": result.beyond_record} if result.beyond_record else {}),
            **extremes,
            "impacts": str(len(result.impacts)),
            "crossings": str(len(result.crossings)),
            "contacts": f"{len(contacts)}{first}",
            "grazes": str(len(result.grazes)),
            **_times_in_words(result),
            "outcome": str(result.outcome.value),
            "time": span_in_words(result.t0, result.t_end, units),
        }


def _drawn_window(run: Any, study: Study) -> tuple[float, float] | None:
    """Return the part of a run that is drawn, None for all."""
    if study.draw.window is None:
        return None
    first, last = (as_float(time) for time in study.draw.window)
    # A run may end before the window begins: it was interrupted, or came to rest.
    return (first, last) if first < run.t_end and last > run.t0 else None


def _extremes_in_words(run: Trajectory) -> dict[str, str]:
    """Return the least and the largest displacement, and force of each stop that bears one."""
    osc = run.oscillator
    force = FORCE if osc.mass is not None else FORCE.removeprefix("mass ")
    rows = {"displacement": ends_in_words(run.extremes("displacement"), osc.units, "length")}
    for stop in range(len(osc.stops)):
        extrema = run.extremes("stop_force", stop=stop)
        if extrema.peak > 0.0:
            rows[f"force of stop {stop}"] = ends_in_words(extrema, osc.units, force)
    return rows


def _times_in_words(run: Trajectory | StructureTrajectory) -> dict[str, str]:
    """Return the class of the times of the impacts, without any of the entries into soft stops."""
    from percuss.motion.impact_times import classify_impact_times

    entries = len(run.crossings) > 0 and len(run.impacts) == 0
    words = impact_times_words(classify_impact_times(run))
    return {"entry times" if entries else "impact times": words}


def impact_times_words(times: ImpactTimes) -> str:
    """Return the class of the impact times in words."""
    pattern = f"{times.n_impacts} in {counted(times.n_periods, 'forcing period')}"
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
