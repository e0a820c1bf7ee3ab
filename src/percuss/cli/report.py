"""What happened in a run, as a short table."""

from __future__ import annotations

from rich.console import Console
from rich.text import Text

from percuss.motion.impact_times import ImpactTimes
from percuss.motion.trajectory import Trajectory
from percuss.studies.running import StudyResult
from percuss.studies.study import Study

WIDTH = len("impact times") + 2


def print_report(study: Study, result: StudyResult) -> None:
    """Print a table of the events, the class of the impact times, the outcome and the files."""
    run = result.run
    rows = {
        "impacts": str(len(run.impacts)),
        "crossings": str(len(run.crossings)),
        "contacts": _contacts(result),
        "grazes": str(len(run.grazes)),
        _times_name(run): impact_times_words(result.impact_times),
        "outcome": str(run.outcome.value),
        "time": f"t = {run.t0:.10g} to {run.t_end:.10g}, simulated in {result.seconds:.3g} s",
        "files": f"\n{' ' * WIDTH}".join(map(str, result.files)) or "none",
    }
    # Text, not markup: a path may hold square brackets. No wrapping: it may be copied.
    console = Console(highlight=False, soft_wrap=True)
    if study.title:
        console.print(Text(study.title, style="bold"))
    for name, words in rows.items():
        console.print(Text.assemble((name.ljust(WIDTH), "dim"), words))


def _times_name(run: Trajectory) -> str:
    """Return which times are classified: those of impacts, or else of entries."""
    return "entry times" if len(run.crossings) and not len(run.impacts) else "impact times"


def _contacts(result: StudyResult) -> str:
    contacts = result.run.contacts
    if not len(contacts):
        return "0"
    return f"{len(contacts)}, the first from t = {contacts.start[0]:.10g}"


def impact_times_words(times: ImpactTimes) -> str:
    """Return the class of the impact times in words."""
    pattern = f"{times.n_impacts} in {times.n_periods} forcing periods"
    return {
        "eigenset": f"the eigenset, within {times.deviation:.1e}",
        "eigenset_subset": f"a part of the eigenset, within {times.deviation:.1e}",
        "periodic": f"periodic: {pattern if times.n_periods else f'every {times.n_impacts}'}",
        "approaching_eigenset": f"approaching the eigenset, now within {times.deviation:.1e}",
        "no_period_found": f"no period found in {times.n_used}",
        "too_few": f"too few to tell: {times.n_used}",
    }[times.kind]
