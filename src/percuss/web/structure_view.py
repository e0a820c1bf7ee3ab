"""A motion of a structure as the page shows it: its masses over time, stops, forces and orbit."""

from __future__ import annotations

import contextlib
import math
import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError, PercussError
from percuss.model.exact import Exact, as_float
from percuss.model.loads import Loads
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.simulate import simulate
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Outcome
from percuss.orbits.finding.find import find_orbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.web.explore import MOST_IMPACTS, PATIENCE, SHOWN_IMPACTS, header_of_run, window_of
from percuss.web.frame import frame
from percuss.web.mechanisms import MECHANISMS, Mechanism, elements_of
from percuss.web.request import BadRequest, PageRequest, RunningRequest

# The longest motion, in periods of the force.
MOST_PERIODS = 5000
# Periods at the end of a motion, of which the phase portrait and the mean powers are.
END_PERIODS = 20
# Periods after which a motion is near its attractor; the longest orbit looked for; how near a
# motion must come to where it was, as a part of its size.
SETTLING, LONGEST, NEAR = 200, 12, 1e-3
# How far an orbit may lie from the motion, as a part of its size.
SAME = 1e-2
# Vibrations of the fastest mass in a motion: above, a slider would wait for seconds.
MOST_CYCLES = 200_000
# A wall in a sentence of the library.
BEYOND = re.compile(r"y = (\S+) is (above|below) the wall stops\.(\d+) at y = ([^;]+)")
MechanismParts = tuple[Structure, Loads, StructureStart]


def mechanism_rows() -> list[dict[str, object]]:
    """Return what the page shows of the mechanisms before any of them moves.

    Examples
    --------
    >>> [row["name"] for row in mechanism_rows()][:2]
    ['impact_pair', 'two_masses']
    """
    rows: list[dict[str, object]] = []
    for mechanism in MECHANISMS.values():
        structure, loads, _ = mechanism.system(mechanism.defaults)
        parameters = [
            {
                "path": row.path,
                "group": row.group,
                "label": row.label,
                "about": row.about,
                "value": row.value,
                "range": [row.low, row.high],
                "step": 1 if row.path == "periods" else None,
            }
            for row in mechanism.parameters
        ]
        elements = elements_of(structure, loads)
        words = {"name": mechanism.name, "title": mechanism.title, "caption": mechanism.caption}
        rows.append({**words, "rows": parameters, "elements": elements})
    return rows


def answer_mechanism(request: PageRequest, running: RunningRequest | None = None) -> bytes:
    """Return the curves of a motion of a mechanism.

    Parameters
    ----------
    request
        With the options ``name`` of a mechanism, ``values`` of its parameters by path, ``points``
        of a curve and, for a part of the run, ``window``.
    running
        State of the answer; default: a new one.

    Returns
    -------
    bytes
        A frame: t, x0, x1, ... of the masses and force0, ... of the stops in the window;
        portrait_t, portrait_x0, portrait_v0, ... of its end; event_t, event_stop, cycle, speed and
        impulse of impacts and entries; `elements` of the picture, and facts.

    Raises
    ------
    ParameterError, BadRequest
        If there is no such motion.
    """
    running = running or RunningRequest()
    points = int(request.number("points", 4000, 100, 20_000))
    mechanism, values = _given(request)
    model = mechanism.system(values)
    # A motion may grow until its energy has no number.
    with np.errstate(over="ignore", invalid="ignore"):
        return _answer(request, model, values["periods"], points, running)


def _answer(
    request: PageRequest,
    model: MechanismParts,
    periods: Exact,
    points: int,
    running: RunningRequest,
) -> bytes:
    structure, loads, _ = model
    began = running.seconds()
    run = _followed(model, periods, running)
    window = window_of(request, run.t0, run.t_end)
    events = _events(run)
    t, x, _ = _sampled(run, window or (run.t0, run.t_end), events["event_t"], points)
    end = _sampled(run, window or _end_of(run), events["event_t"], points)
    last = {name: column[-SHOWN_IMPACTS:] for name, column in events.items()}
    header = {
        **header_of_run(request, run, window, loads.period, None),
        "elements": elements_of(structure, loads),
        "stops": _stop_facts(run, structure),
        "energy": _energy_facts(run, end),
        "milliseconds": 1e3 * (running.seconds() - began),
    }
    arrays = {"t": t, "portrait_t": end[0], **last}
    for i in range(structure.n):
        arrays |= {f"x{i}": x[:, i]}
        arrays |= {f"portrait_x{i}": end[1][:, i], f"portrait_v{i}": end[2][:, i]}
    arrays |= {f"force{i}": row for i, row in enumerate(run.forces(t)["stops"].values)}
    return frame(header, arrays)


def answer_mechanism_facts(request: PageRequest, running: RunningRequest | None = None) -> bytes:
    """Return the periodic orbit that a motion of a mechanism settles to.

    Parameters
    ----------
    request
        As for `answer_mechanism`.
    running
        State of the answer; default: a new one.

    Returns
    -------
    bytes
        A frame: `orbit`, its counts, period and multipliers, None where none was found; orbit_x0,
        orbit_v0, ... of one period of it.

    Raises
    ------
    ParameterError, BadRequest
        If there is no such motion.
    """
    mechanism, values = _given(request)
    with np.errstate(over="ignore", invalid="ignore"):
        orbit = _settled_orbit(mechanism.system(values), running or RunningRequest())
    header: dict[str, object] = {"id": request.id, "kind": request.kind, "orbit": None}
    if orbit is None:
        return frame(header)
    header["orbit"] = {
        "n_impacts": orbit.n_impacts,
        "n_periods": orbit.n_periods,
        "period": orbit.period,
        "is_stable": orbit.is_stable,
        "multipliers": [[value.real, value.imag] for value in orbit.multipliers.tolist()],
    }
    events = _events(orbit.run)["event_t"]
    _, x, v = _sampled(orbit.run, (orbit.run.t0, orbit.run.t_end), events, 600)
    arrays: dict[str, Floats] = {}
    for i in range(orbit.structure.n):
        arrays |= {f"orbit_x{i}": x[:, i], f"orbit_v{i}": v[:, i]}
    return frame(header, arrays)


def mechanism_python(request: PageRequest) -> str:
    """Return the motion of a mechanism that a request is for as Python.

    Raises
    ------
    ParameterError, BadRequest
        If there is no such motion.
    """
    mechanism, values = _given(request)
    # Without a structure there is no script.
    mechanism.system(values)
    return mechanism.python(values)


def _given(request: PageRequest) -> tuple[Mechanism, dict[str, Exact]]:
    """Return the mechanism of a request, and the values of all its parameters."""
    mechanism = MECHANISMS[request.choice("name", tuple(MECHANISMS))]
    given = request.options.get("values", {})
    if not isinstance(given, Mapping):
        raise BadRequest("the values are not a JSON object")
    unknown = [path for path in given if path not in mechanism.defaults]
    if unknown:
        raise BadRequest(f"{mechanism.title} has no parameter {unknown[0]!r:.40}")
    values: dict[str, Any] = {**mechanism.defaults, **given}
    numbers = {path: _number(path, value) for path, value in values.items()}
    for path, most in (("omega", math.inf), ("periods", MOST_PERIODS)):
        if not 0.0 < numbers[path] <= most:
            within = (
                "not positive" if numbers[path] <= 0.0 else f"the page follows {most:g} at most"
            )
            raise ParameterError(path, values[path], within)
    return mechanism, values


def _number(path: str, value: object) -> float:
    """Return a value as a finite number."""
    number = math.nan
    if isinstance(value, str | int | float) and not isinstance(value, bool):
        with contextlib.suppress(ParameterError, ValueError, OverflowError, ZeroDivisionError):
            number = as_float(value)
    if not math.isfinite(number):
        raise ParameterError(path, value, "not a finite number, such as 2.8 or 1/3")
    return number


def _cycles(model: MechanismParts, periods: float) -> float:
    """Return a bound on the vibrations of the fastest mass in so many periods of the force."""
    structure, loads, _ = model
    rates = np.abs(structure.stiffness_matrix).sum(axis=1) / structure.mass_matrix.diagonal()
    return math.sqrt(float(rates.max())) * periods * (loads.period or 0.0) / (2.0 * math.pi)


def _followed(
    model: MechanismParts, periods: Exact, running: RunningRequest
) -> StructureTrajectory:
    """Follow a motion for as long as a slider can wait."""
    structure, loads, start = model
    if (cycles := _cycles(model, as_float(periods))) > MOST_CYCLES:
        least = f"the fastest mass vibrates some {cycles:.0e} times in this motion"
        raise BadRequest(f"{least}; the page follows {MOST_CYCLES:,} at most")
    progress = running.progress(0.0, 0.0, PATIENCE)
    try:
        return simulate(
            structure,
            loads,
            start.x0,
            start.v0,
            periods=periods,
            max_impacts=MOST_IMPACTS,
            progress=progress,
        )
    except ParameterError as error:
        beyond = BEYOND.search(error.reason)
        if beyond is None:
            raise
        # The distance of two masses has no slider: the sentence stands over the pictures.
        y, side, stop, at = beyond.groups()
        name = _name_of(structure.stop_directions[int(stop)])
        raise BadRequest(f"the start: {name} = {y} is {side} the wall at {at}") from error


def _name_of(direction: Floats) -> str:
    """Return a displacement as the page calls it, such as x2 - x1."""
    terms = [(f"{abs(c):g} " if abs(c) != 1.0 else "", c) for c in direction]
    signed = [(c < 0.0, f"{part}x{i + 1}") for i, (part, c) in enumerate(terms) if c != 0.0]
    text = "".join(f" {'-' if minus else '+'} {term}" for minus, term in sorted(signed))
    return text.removeprefix(" + ").removeprefix(" ")


def _end_of(run: StructureTrajectory) -> tuple[float, float]:
    """Return the last periods of a run, at most all of it."""
    period = run.system.period
    return (max(run.t0, run.t_end - END_PERIODS * period) if period else run.t0, run.t_end)


def _events(run: StructureTrajectory) -> dict[str, Floats]:
    """Return the impacts and the entries into soft stops, in the order of time."""
    impacts, crossings = run.impacts, run.crossings
    entered = np.flatnonzero(crossings.direction == "in")
    t = np.concatenate([impacts.t, crossings.t[entered]])
    order = np.argsort(t, kind="stable")
    period = run.system.period
    columns = {
        "event_t": t,
        "event_stop": np.concatenate([impacts.stop, crossings.stop[entered]]).astype(float),
        "cycle": t / period % 1.0 if period else np.zeros(len(t)),
        "speed": np.abs(np.concatenate([impacts.v_before, crossings.v[entered]])),
        "impulse": np.concatenate([impacts.impulse, np.full(len(entered), np.nan)]),
    }
    return {name: column[order] for name, column in columns.items()}


def _sampled(
    run: StructureTrajectory, window: tuple[float, float], events: Floats, points: int
) -> tuple[Floats, Floats, Floats]:
    """Return times, x and v of a curve; each event has two points, before and after it."""
    low, high = window
    within = events[(events >= low) & (events <= high)]
    # A band of very many events needs no point at each.
    within = within[:: max(1, 2 * len(within) // points)]
    even = np.setdiff1d(np.linspace(low, high, points), within)
    t = np.sort(np.concatenate([even, within, within]))
    x, v = run(t)
    first = np.flatnonzero(np.diff(t, append=math.inf) == 0.0)
    v[first] = run(t[first], "before")[1]
    return t, x, v


def _stop_facts(run: StructureTrajectory, structure: Structure) -> list[dict[str, object]]:
    """Return by stop how often it is met, and its largest force and impulse."""
    entered = run.crossings.stop[run.crossings.direction == "in"]
    facts: list[dict[str, object]] = []
    for i in range(len(structure.stops)):
        impulses = np.abs(run.impacts.impulse[run.impacts.stop == i])
        force = run.extremes("stop_force", stop=i)
        facts.append(
            {
                "n_impacts": len(impulses),
                "n_entries": int((entered == i).sum()),
                "largest_impulse": float(impulses.max(initial=0.0)),
                "largest_force": max(abs(force.minimum), abs(force.maximum)),
            }
        )
    return facts


def _energy_facts(
    run: StructureTrajectory, end: tuple[Floats, Floats, Floats]
) -> dict[str, float | None]:
    """Return the mean powers, over the end of a run, of the loads, impacts and dashpots.

    What an impact takes is half of its impulse times the sum of the velocities: exact. The work of
    the loads is a sum over the curve; what is left of the balance went into the dashpots.
    """
    t, _, v = end
    duration = float(t[-1] - t[0])
    if duration <= 0.0:
        return {"loads": None, "impacts": None, "dashpots": None}
    power = (run.forces(t)["loads"].values * v).sum(axis=1)
    work = float((0.5 * (power[1:] + power[:-1]) * np.diff(t)).sum())
    within = (run.impacts.t >= t[0]) & (run.impacts.t <= t[-1])
    taken = run.impacts.impulse * (run.impacts.v_before + run.impacts.v_after)
    impacts = float(0.0 - 0.5 * taken[within].sum())
    before, after = run.energy(t[[0, -1]])
    dashpots = work - impacts - float(after - before)
    return {
        "loads": work / duration,
        "impacts": impacts / duration,
        "dashpots": dashpots / duration,
    }


def _settled_orbit(model: MechanismParts, running: RunningRequest) -> StructureOrbit | None:
    """Return the orbit that the motion of a mechanism repeats after many periods, if it does."""
    structure, loads, _ = model
    if loads.period is None or _cycles(model, SETTLING + LONGEST) > MOST_CYCLES:
        return None
    run = _followed(model, SETTLING + LONGEST, running)
    if run.outcome is not Outcome.reached_t_end:
        return None
    strobes = loads.period * (SETTLING + np.arange(LONGEST + 1))
    x, v = run(np.minimum(strobes, run.t_end))
    states = np.concatenate([x, v * loads.period], axis=1)
    size = float(np.abs(states).max())
    distance = np.abs(states[:-1] - states[-1]).max(axis=1)[::-1]
    near = np.flatnonzero(distance <= NEAR * size)
    if size == 0.0 or len(near) == 0:
        return None
    try:
        orbit = find_orbit(structure, loads, n_periods=int(near[0]) + 1, guess=(x[-1], v[-1]))
    except PercussError:
        return None
    state = np.concatenate([orbit.x0, orbit.v0 * loads.period])
    return orbit if float(np.abs(state - states[-1]).max()) <= SAME * size else None
