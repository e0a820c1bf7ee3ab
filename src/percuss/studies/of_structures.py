"""Studies of structures: their checks, computations, pictures and reports."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, cast

from percuss.errors import ParameterError
from percuss.execution import Execution
from percuss.model.exact import phase_problem
from percuss.model.faults import draft, number_faults, phase_faults, positive_faults
from percuss.model.loads import loads_of
from percuss.model.oscillator import On, SoftStop, Wall
from percuss.model.start import Start, limit_faults, periods_faults
from percuss.model.structure import Structure, on_faults, structure_fields
from percuss.model.structure_start import StructureStart, check_start
from percuss.model.units import FORCE, in_units
from percuss.studies.structure_tables import has_size
from percuss.studies.study import (
    Study,
    StudyDraft,
    ends_in_words,
    multiplier_text,
    with_unit,
)
from percuss.studies.tables import MISSING, Limits, NumbersKey, Path, StartState, StudyFaults, shown
from percuss.wording import counted

if TYPE_CHECKING:
    from percuss.motion.structures import StructureTrajectory
    from percuss.orbits import StructureOrbit

# Displacements in one picture, and in a report.
MOST_SHOWN = 12


def checked_start(
    start: Start | StructureStart, study: StudyDraft, place: Path = ("start",)
) -> StructureStart:
    """Return a start with a number for each coordinate, and add its faults.

    Parameters
    ----------
    start
        The start as it was read: a list, or one number for zeros or the only coordinate.
    study
        The structure.
    place
        Path of its table, or of its row in a list.
    """
    structure, faults = _structure(study), study.faults
    names: dict[str, str | int] = {"x0": "x0", "v0": "v0", "t0": "t0"}
    if place[0] != "start":
        names = {name: i for i, name in enumerate(names)}
    dotted = ".".join(map(str, place))
    for name in ("x0", "v0"):
        value = getattr(start, name)
        own = f"{dotted}.{names[name]}"
        rows = enumerate(value) if isinstance(value, tuple) else ()
        problems = [fault for i, number in rows for fault in number_faults(f"{own}.{i}", number)]
        problems += [] if isinstance(value, tuple) else number_faults(own, value)
        faults.add_from_model(problems)
    faults.add_from_model(phase_faults(f"{dotted}.{names['t0']}", start.t0))
    is_right = not faults.is_wrong("structure")
    if not (is_right or has_size(structure)):
        return cast("StructureStart", start)
    zeros = (0.0,) * structure.n
    if faults.is_wrong(dotted):
        # Its numbers are no parameters, but there is one for each coordinate.
        return StructureStart(zeros, zeros)
    try:
        # Of a structure with faults the size is known, but not where its walls are.
        bare = draft(Structure, **structure_fields(structure.mass, structure.stiffness))
        return check_start(structure if is_right else bare, start.x0, start.v0, start.t0)
    except ParameterError as error:
        first, _, rest = error.name.removeprefix("start.").partition(".")
        entry = (int(rest),) if rest.isdecimal() else ()
        path: Path = (*place, names.get(first, first), *entry)
        is_given = place[0] != "start" or "start" in study.document
        reason = error.reason if is_given else f"missing; by default {error}"
        faults.add(path if is_given else ("start",), reason, shown(error.value) if is_given else "")
        return StructureStart(zeros, zeros)


def check_on(on: On | None, path: Path, study: StudyDraft, *, is_needed: bool = False) -> None:
    """Add the fault of a direction that the structure does not have.

    Without one, and where none is needed, there is no fault.
    """
    structure = _structure(study)
    if study.faults.is_wrong("structure") or (on is None and not is_needed):
        return
    study.faults.add_from_model(on_faults(structure, on, ".".join(map(str, path))))


def check_measured(
    names: tuple[str, ...], on: On | None, path: Path, study: StudyDraft, *, section: Any = None
) -> None:
    """Add the faults of measures that structures do not have, and of the section and direction.

    Parameters
    ----------
    names
        Names of measures.
    on
        The displacement that is observed.
    path
        Where the names stand.
    study
        The structure.
    section
        The section that is taken; None for none.
    """
    from percuss.ensembles.measures import MEASURES

    table, faults = path[0], study.faults
    known = ", ".join(name for name, measure in MEASURES.items() if measure.of_structures)
    for index, name in enumerate(names):
        if name in MEASURES and not MEASURES[name].of_structures:
            faults.add((*path, index), f"not for structures; there are {known}", shown(name))
    of_points = section is not None and section.kind == "stroboscopic"
    of_measures = any(name in MEASURES and MEASURES[name].of_displacement for name in names)
    if section is not None and section.kind == "passages":
        reason = 'no section of a structure; take "stroboscopic", a cycle, or "impacts"'
        faults.add((table, "section"), reason, shown(section.given))
    if section is not None and section.kind == "impacts":
        n_stops = len(study.model.stops)
        if on is not None and (not isinstance(on, int) or not 0 <= on < n_stops):
            reason = f"at impacts the number of a stop, of which there are {n_stops}"
            faults.add((table, "on"), reason, shown(on))
        return
    check_on(on, (table, "on"), study, is_needed=of_points or of_measures)


def checked_motion(begin: StartState, limits: Limits, study: StudyDraft) -> StructureStart:
    """Return the start of a motion of a structure, and add the faults of start and limits."""
    faults = study.faults
    start = checked_start(begin, study)
    if limits.periods is not None:
        # Loads with faults may have no period.
        is_known = not (faults.is_wrong("loads") or faults.is_wrong("structure.loads_period"))
        faults.add_from_model(
            periods_faults(study.force, limits.periods, limits.t_end, run="run")
            if is_known or limits.t_end is not None
            else positive_faults("run.periods", limits.periods)
        )
    elif limits.t_end is None and not faults.is_wrong("run"):
        faults.add(("run",), "missing an end; give t_end or periods: stops may never be met")
    if limits.t_end is not None or limits.max_impacts is not None:
        t0 = start.t0 if phase_problem(start.t0) is None else 0.0
        faults.add_from_model(limit_faults(t0, limits.t_end, limits.max_impacts, run="run"))
    check_drawn(study)
    if study.draw.on is not None and not 0 < len(study.draw.on) <= MOST_SHOWN:
        reason = f"{counted(len(study.draw.on), 'displacement')}; give 1 to {MOST_SHOWN}"
        faults.add(("draw", "on"), reason)
    return start


def check_sought(x0: NumbersKey | None, v0: NumbersKey | None, study: StudyDraft) -> None:
    """Add the faults of a structure's orbit that is sought: its guess, and what draws it."""
    given: dict[str, Any] = {"x0": x0, "v0": v0}
    missing = [name for name, value in given.items() if value is None]
    if len(missing) == 1 and not study.faults.is_wrong("orbit"):
        study.faults.add(("orbit", missing[0]), "missing; a guess is a state, x0 and v0")
    if not missing:
        values = {name: 0.0 if value is MISSING else value for name, value in given.items()}
        _check_guess(draft(StructureStart, **values), study)
    check_drawn(study)
    study.needs_period("a periodic orbit of a structure needs periodic loads")


def check_drawn(study: StudyDraft) -> None:
    """Add the faults of the displacements that pictures show."""
    for index, on in enumerate(study.draw.on or ()):
        check_on(on, ("draw", "on", index), study, is_needed=True)


def _check_guess(start: StructureStart, study: StudyDraft) -> None:
    """Add the faults of a state in ``[orbit]``, as those of a start."""
    own = StudyFaults(study.faults.file, study.faults.lines, list(study.faults.faults))
    known = len(own.faults)
    checked_start(start, replace(study, faults=own, document={**study.document, "start": {}}))
    for fault in own.faults[known:]:
        path = fault.path.replace("start", "orbit", 1).split(".")
        keys = tuple(int(part) if part.isdecimal() else part for part in path)
        study.faults.add(keys, fault.reason, fault.value)


def motion_of(
    begin: StartState, limits: Limits, study: Study, execution: Execution
) -> StructureTrajectory:
    """Return the motion of a structure."""
    from percuss.motion.simulate import simulate

    structure = study.structure
    # Only studies of structures are computed here.
    assert structure is not None
    return simulate(
        structure,
        loads_of(structure, study.force),
        start=begin if isinstance(begin, StructureStart) else None,
        t_end=limits.t_end,
        periods=limits.periods,
        max_impacts=limits.max_impacts,
        progress=execution.progress,
    )


def shown_directions(study: Study) -> tuple[On, ...]:
    """Return the displacements that pictures show: those asked for, else `_displacements`."""
    structure = study.structure
    # Only studies of structures are drawn here.
    assert structure is not None
    if study.draw.on is not None:
        return tuple(cast("On", on) for on in study.draw.on)
    return _displacements(structure)


def _displacements(structure: Structure) -> tuple[On, ...]:
    """Return the points of a structure, or else its first coordinates."""
    points: tuple[On, ...] = tuple(name for name, _ in structure.points)
    return (points or tuple(range(structure.n)))[:MOST_SHOWN]


def draw_motion(
    run: StructureTrajectory, study: Study, figure: Any, window: tuple[float, float] | None
) -> None:
    """Draw displacements one below the other."""
    from percuss.plotting import plot_coordinates

    on = shown_directions(study)
    figure.set_size_inches(8.0, 1.6 + 1.5 * len(on))
    plot_coordinates(run, figure, on=on, window=window, units=study.draw.units())


def extremes_in_words(run: StructureTrajectory) -> dict[str, str]:
    """Return the extremes of displacements, and the forces and impulses of the stops."""
    rows = {}
    for on in _displacements(run.structure):
        name = f"at {on}" if isinstance(on, str) else f"coordinate {on}"
        extrema = run.extremes("displacement", on=on)
        rows[name] = ends_in_words(extrema, run.structure.units, "length")
    return rows | _stops_in_words(run)


def _stops_in_words(run: StructureTrajectory) -> dict[str, str]:
    """Return the forces of soft stops that were met, and the impulses of walls."""
    structure, rows = run.structure, {}
    impulse = in_units(structure.units, "mass length/time")
    for i, stop in enumerate(structure.stops):
        if isinstance(stop, SoftStop):
            extrema = run.extremes("stop_force", stop=i)
            if extrema.peak > 0.0:
                rows[f"force of stop {i}"] = ends_in_words(extrema, structure.units, FORCE)
        elif isinstance(stop, Wall):
            own = abs(run.impacts.impulse[run.impacts.stop == i])
            if len(own):
                words = f"{counted(len(own), 'impact')}, impulses up to"
                rows[f"wall {i}"] = f"{words} {with_unit(float(own.max()), impulse)}"
    return rows


def report_of_orbit(orbit: StructureOrbit) -> dict[str, str]:
    """Return the orbit of a structure and its stability."""
    multipliers = orbit.multipliers.tolist()
    values = ", ".join(multiplier_text(complex(value)) for value in multipliers[:MOST_SHOWN])
    more = f" and {len(multipliers) - MOST_SHOWN} more" if len(multipliers) > MOST_SHOWN else ""
    turns = counted(orbit.n_periods, "period")
    impacts = counted(orbit.n_impacts, "impact")
    rows = {
        "orbit": f"{impacts} in {turns} of the loads, period {orbit.period:.10g}",
        "stability": f"{orbit.stability}, multipliers {values}{more}",
    }
    return rows | extremes_in_words(orbit.run) | {"residual": f"{orbit.residual:.2g}"}


def _structure(study: StudyDraft) -> Structure:
    structure = study.structure
    # Only studies of structures come here.
    assert structure is not None
    return structure
