"""The tables of a study file to a study, with every fault that the model finds in them."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar

from percuss.errors import ParameterError
from percuss.model.exact import (
    NOT_A_NUMBER,
    NOT_A_PHASE,
    Phase,
    PiTimes,
    angle,
    as_float,
    as_fraction,
    number_problem,
    phase_problem,
)
from percuss.model.faults import Fault, damping_faults, draft, faults, positive_faults
from percuss.model.forcing import Forcing
from percuss.model.harmonics import FourierTerm, Harmonic
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start, periods_faults, start_faults
from percuss.model.stops import SoftStop, Wall
from percuss.studies.faults import shown
from percuss.studies.schema import NO_NUMBER, NO_PHASE
from percuss.studies.shape import Found
from percuss.studies.study import Draw, EngineersModel, Limits, Save, Study, end_time

Table = Mapping[str, Any]
Part = TypeVar("Part")

# In place of a key that is missing, which is a fault already.
_MISSING: Any = object()
NO_LIMIT = "missing a limit; give t_end, periods or max_impacts"
_PLACE = ("at", "side")
_FOURIER = ("omega", "cos", "sin")
_DAMPINGS = ("damping_coefficient", "damping_ratio")
# What the model says, and what it is called in a file.
_REASONS = {NOT_A_NUMBER: NO_NUMBER, NOT_A_PHASE: NO_PHASE}


def build(document: Table, found: Found) -> Study | None:
    """Return the study of a document, None if it has faults; add the faults to those found.

    Parameters
    ----------
    document
        The tables as `tomllib` reads them, faulty ones too.
    found
        The faults found so far.

    Returns
    -------
    Study or None
        The study.
    """
    oscillator = _oscillator(_table(document, "oscillator"), found)
    forcing = _forcing(_table(document, "forcing"), found) if "forcing" in document else None
    given = _engineers_model(_table(document, "oscillator"), oscillator, forcing, found)
    if given is not None:
        oscillator, forcing = _per_mass(given, found)
    state = {**_table(document, "start")}
    state |= {"t0": exact_phase(state["t0"])} if "t0" in state else {}
    start = _draft(Start, state, {"x0": _MISSING, "v0": _MISSING, "t0": 0.0})
    limits = _limits(_table(document, "run"), forcing, found)
    _check_start(oscillator, forcing, start, limits, found)
    window = _window(_table(document, "draw"), start, limits, found)
    if found.faults:
        return None
    head, save, draw = (_table(document, name) for name in ("study", "save", "draw"))
    return Study(
        oscillator=oscillator,
        forcing=forcing,
        start=start,
        run=limits,
        title=head.get("title", ""),
        save=Save(**save),
        draw=Draw(**{**draw, "window": window}),
        kind=head.get("kind", "motion"),
        given=given,
    )


def _table(document: Table, name: str) -> Table:
    table = document.get(name, {})
    return table if isinstance(table, Mapping) else {}


def _rows(table: Table, name: str) -> list[Any]:
    rows = table.get(name, [])
    return rows if isinstance(rows, list) else []


def _draft(kind: type[Part], table: Any, defaults: Table) -> Part:
    """Return a part of the model from the keys of a table that it has, not checked."""
    given = table if isinstance(table, Mapping) else {}
    return draft(kind, **{name: given.get(name, value) for name, value in defaults.items()})


def _add(wrong: list[Fault], found: Found) -> None:
    """Add the faults that the model found."""
    for fault in wrong:
        if fault.value is _MISSING:
            continue
        path = tuple(int(part) if part.isdecimal() else part for part in fault.name.split("."))
        found.add(path, _REASONS.get(fault.reason, fault.reason), shown(fault.value))


def _oscillator(table: Table, found: Found) -> Oscillator:
    stops = tuple(_stop(row) for row in _rows(table, "stops"))
    values = {"stiffness": 1.0, "damping": 0.0}
    values = {name: table.get(name, value) for name, value in values.items()}
    oscillator = draft(Oscillator, **values, stops=stops)
    _add(faults(oscillator, "oscillator"), found)
    return oscillator


def _engineers_model(
    table: Table, oscillator: Oscillator, forcing: Forcing | None, found: Found
) -> EngineersModel | None:
    """Return the model in engineers' units if a mass is given and nothing is wrong with it."""
    dampings = {name: table[name] for name in _DAMPINGS if name in table}
    if "mass" not in table:
        for name in dampings:
            found.add(
                ("oscillator", name), "needs oscillator.mass; mass = 1 leaves all else as it is"
            )
        return None
    _add(positive_faults("oscillator.mass", table["mass"]), found)
    for name, value in dampings.items():
        _add(damping_faults(f"oscillator.{name}", value), found)
    if "stiffness" not in table:
        found.add(("oscillator", "stiffness"), "missing; with a mass it has no default")
    if "damping" in table:
        reason = "given together with mass; give damping_coefficient or damping_ratio"
        found.add(("oscillator", "damping"), reason, shown(table["damping"]))
    if found.is_wrong("oscillator") or found.is_wrong("forcing"):
        return None
    return EngineersModel(
        table["mass"], table["stiffness"], **dampings, stops=oscillator.stops, forcing=forcing
    )


def _per_mass(given: EngineersModel, found: Found) -> tuple[Oscillator, Forcing | None]:
    """Return the oscillator and the forcing of unit mass; add what the division makes wrong."""
    oscillator, forcing = Oscillator(stops=given.stops), given.forcing
    owner = "oscillator"
    try:
        oscillator = given.oscillator()
        owner = "forcing"
        forcing = given.forcing_per_mass()
    except ParameterError as error:
        if error.name in _DAMPINGS:
            _add([Fault(f"{owner}.{error.name}", error.value, error.reason)], found)
        else:
            reason = f"after the division by it, {owner}.{error.name} is {error.reason}"
            found.add(("oscillator", "mass"), reason, shown(given.mass))
    return oscillator, forcing


def _stop(row: Any) -> Wall | SoftStop:
    needed = {"at": _MISSING, "side": _MISSING}
    kind = row.get("type") if isinstance(row, Mapping) else None
    if kind == "soft":
        return _draft(SoftStop, row, {**needed, "stiffness": _MISSING, "damping": 0.0})
    # What is neither has a fault already; as a wall without a place it gets no second one.
    return _draft(Wall, row, {**needed, "restitution": 1.0})


def _forcing(table: Table, found: Found) -> Forcing:
    constant, period = table.get("constant", 0.0), table.get("period")
    given = [name for name in _FOURIER if name in table]
    if not given:
        defaults = {"amplitude": _MISSING, "omega": _MISSING, "phase": 0.0}
        harmonics = tuple(_harmonic(row, defaults) for row in _rows(table, "harmonics"))
        forcing = draft(Forcing, harmonics=harmonics, constant=constant, period=exact_phase(period))
    else:
        for name in ("harmonics", "period"):
            if name in table:
                reason = f"given together with {given[0]}; omega, cos and sin stand alone"
                found.add(("forcing", name), reason)
        if "omega" not in table:
            found.add(("forcing", "omega"), "missing; cos and sin need the base frequency")
        forcing = _fourier(table, constant)
    _add(faults(forcing, "forcing"), found)
    return forcing


def _harmonic(row: Any, defaults: Table) -> Harmonic:
    given = dict(row) if isinstance(row, Mapping) else {}
    if "phase" in given:
        given["phase"] = exact_phase(given["phase"])
    return _draft(Harmonic, given, defaults)


def _fourier(table: Table, constant: Any) -> Forcing:
    cos, sin = _rows(table, "cos"), _rows(table, "sin")
    count = max(len(cos), len(sin))
    pairs = zip(*(values + [0.0] * (count - len(values)) for values in (cos, sin)), strict=True)
    terms = tuple(draft(FourierTerm, n=n, cos=c, sin=s) for n, (c, s) in enumerate(pairs, 1))
    base = table.get("omega", _MISSING)
    return draft(Forcing, harmonics=terms, constant=constant, base=base)


def exact_phase(value: Any) -> Any:
    """Return ``"pi/2 + 1/3"`` as the exact phase it means; anything else unchanged.

    Examples
    --------
    >>> exact_phase("-pi/2 + 0.25"), exact_phase("pi/2")
    (pi_times(-1, 2) + 0.25, 'pi/2')
    """
    if not isinstance(value, str) or value.count("+") != 1 or "pi" not in value:
        return value
    multiple, _, rest = value.partition("+")
    if phase_problem(multiple) is not None or number_problem(rest) is not None:
        return value
    times, _ = angle(multiple)
    return PiTimes(times, as_fraction(rest))


def _limits(table: Table, forcing: Forcing | None, found: Found) -> Limits:
    t_end, periods = exact_phase(table.get("t_end")), table.get("periods")
    if periods is not None:
        if found.is_wrong("forcing"):
            # Then whether it has a period cannot be told.
            _add(positive_faults("run.periods", periods), found)
        else:
            _add(periods_faults(forcing, periods, t_end, run="run"), found)
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
    # Only in a wall whose place is known can a start be.
    walls = tuple(
        stop
        for index, stop in enumerate(oscillator.stops)
        if not any(found.is_wrong(f"oscillator.stops.{index}.{name}") for name in _PLACE)
        and _MISSING not in (stop.at, stop.side)
    )
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
    _add([fault for fault in wrong if fault.name != "run.t_end" or t_end is not None], found)


def _window(table: Table, start: Start, limits: Limits, found: Found) -> tuple[Phase, Phase] | None:
    """Return the part that is drawn, and add what is wrong with it."""
    times = [exact_phase(time) for time in _rows(table, "window")]
    if len(times) != 2 or found.is_wrong("draw.window"):
        return None
    for index, time in enumerate(times):
        problem = phase_problem(time)
        if problem is not None:
            found.add(("draw", "window", index), problem, shown(time))
    if found.is_wrong("draw.window") or found.is_wrong("start.t0") or found.is_wrong("run"):
        return None
    first, last = (as_float(time) for time in times)
    if first >= last:
        found.add(("draw", "window"), "the first time is not before the last", shown(times))
    elif last <= as_float(start.t0) or (
        limits.t_end is not None and first >= as_float(limits.t_end)
    ):
        found.add(("draw", "window"), "outside the run", shown(times))
    return times[0], times[1]
