"""A study as a link of the workbench, which holds everything that the page shows."""

from __future__ import annotations

import base64
import json
import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from itertools import zip_longest
from typing import Any

from percuss.errors import ParameterError
from percuss.fitting.measured import measurable
from percuss.io.study_text import TomlTable, model_tables, number, start_table
from percuss.model.exact import as_float
from percuss.model.expression import parameters_in
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Wall
from percuss.model.paths import long_form, replace_parameters
from percuss.model.start import Start
from percuss.motion.sections import section_of
from percuss.studies.axes import Span, axis_values
from percuss.studies.fit_records import FitRecord
from percuss.studies.kinds.basins import Basins
from percuss.studies.kinds.design import Design
from percuss.studies.kinds.diagram import Diagram
from percuss.studies.kinds.fit import Fit
from percuss.studies.kinds.motion import Motion
from percuss.studies.kinds.response import Response
from percuss.studies.kinds.sweep import Sweep
from percuss.studies.study import Study

# Of diagrams and charts of the page: the forcing periods in which motions settle, the measures of
# two parameters with those in which each is taken (of the exponent `web.facts.PERIODS`), and the
# cells along a side.
SETTLING = 200
MEASURED = {
    "period": 64,
    "largest_lyapunov_exponent": 1000,
    "peak_impact_velocity": 64,
}
CELLS = 16, 256

# How long the motion beside a diagram, a chart or basins is followed, which have no end of their
# own.
FOLLOWED = {"periods": 60}
# Of the samples of a record; the server takes 65,536 bytes with the rest of a study.
MOST_BYTES = 56_000
# Floats below it that are whole numbers are written without a point in JavaScript.
WHOLE = 2.0**53
# What the page writes as null; None is what is not given.
NULL = object()


def link_of(study: Study) -> str:
    """Return the fragment of the workbench's address, behind its "#", that shows a study.

    It is what the page writes itself (``encode`` in web/static/js/state.js), to the letter but for
    floats below 1e-4 and above 1e16, which JavaScript writes in another way.

    Parameters
    ----------
    study
        A motion, a diagram, a response, a sweep of one measure over two parameters, basins over x0
        and v0, a fit of one record, or a design.

    Returns
    -------
    str
        The state of the page: JSON in base64, with the letters that an address may hold.

    Raises
    ------
    ParameterError
        If the page shows no such study.

    Examples
    --------
    >>> from percuss.model import impact_oscillator, sine
    >>> from percuss.studies import Limits
    >>> study = Study(impact_oscillator(), sine(3), Motion(Start(0, "0.51"), Limits(periods=10)))
    >>> state = json.loads(base64.urlsafe_b64decode(link_of(study) + "=="))
    >>> state["view"], state["study"]["start"]
    ('explore', {'x0': 0, 'v0': '0.51', 't0': 0})
    """
    if study.structure is not None:
        reason = (
            "not on the page, which opens studies of oscillators; percuss run computes it, and the "
            "page's structures have sliders of their own"
        )
        raise ParameterError("study", "a structure", reason)
    shown = _SHOWN.get(type(study.question))
    if shown is None:
        known = "a motion, a diagram, a response, a sweep, basins, a fit or a design"
        raise ParameterError("study.kind", study.kind, f"not on the page, which shows {known}")
    if isinstance(study.question, Fit):
        # On the page the sliders are the guesses.
        study = _with_guesses(study.question, study)
    view, tables, settings = shown(study.question, study)
    motion: dict[str, Any] = {
        "forcing": {},
        **model_tables(study.oscillator, study.forcing),
        **tables,
    }
    check_size(motion["forcing"].get("record"))
    state: dict[str, Any] = {"view": view, "study": motion, "ranges": {}, "zooms": {}}
    if view in ("fit", "design"):
        # Its search is begun by a button.
        state[view] = settings
    elif settings:
        # The page computes the picture at once, and keeps the motion that it belongs to.
        state[view] = {**settings, "isComputed": True, "study": motion}
    text = json.dumps(_as_in_javascript(state), ensure_ascii=False, separators=(",", ":"))
    return base64.urlsafe_b64encode(text.encode()).decode().rstrip("=")


def check_size(record: Mapping[str, Any] | None) -> None:
    """Refuse a record of which a link, and a question of the page, do not hold all samples."""
    if record is None:
        return
    n, samples = len(record["t"]), [record["t"], record["f"]]
    size = len(json.dumps(_as_in_javascript(samples), separators=(",", ":")))
    if size > MOST_BYTES:
        reason = (
            f"{math.ceil(size / 1000)} kB; links of the page hold {MOST_BYTES // 1000} kB, some "
            f"{n * MOST_BYTES // size} of these samples: take fewer, or `percuss run` with all"
        )
        raise ParameterError("forcing.record", f"{n} samples", reason)


def _as_in_javascript(value: object) -> object:
    """Return a value as JSON of the page holds it: without what is not given, 2.0 as 2."""
    if value is NULL:
        return None
    if isinstance(value, Mapping):
        return {key: _as_in_javascript(inner) for key, inner in value.items() if inner is not None}
    if isinstance(value, list | tuple):
        return [_as_in_javascript(item) for item in value]
    if isinstance(value, float) and value.is_integer() and abs(value) < WHOLE:
        return int(value)
    return value


Shown = tuple[str, TomlTable, TomlTable]


# What the page's diagrams begin with of a second parameter.
_OF_CHARTS: TomlTable = {"path2": "", "low2": 0, "high2": 1, "size": 96}
_STROBES: TomlTable = {
    "section": "strobes",
    "at": 0,
    "direction": "up",
    "cycle": 0,
    "isLive": False,
}


def _motion(motion: Motion, _: Study) -> Shown:
    return "explore", motion.tables(), {}


def _diagram(diagram: Diagram, study: Study) -> Shown:
    ((path, axis),) = diagram.over.items()
    start = diagram.starts[0]
    low, high, count = _ends(axis)
    over = {
        "path": _path_of_page(path, study, start),
        "low": low,
        "high": high,
        **_OF_CHARTS,
    }
    first = {"impacts": "v_after", "passages": "v"}.get(section_of(diagram.section).kind, "x")
    sizes = {"values": count, "points": diagram.points, "of": first, "max_impacts": 3}
    follow = "both" if len(diagram.follow) > 1 else "".join(diagram.follow) or "start"
    own = {"max_periods": 2, "follow": follow, **_section(diagram)}
    settings = {"kind": "diagram", **over, **sizes, **own}
    return "diagram", _from(start), settings


def _section(diagram: Diagram) -> TomlTable:
    """Return where the points of a diagram are taken, as the settings of the page."""
    section = section_of(diagram.section)
    name = {"passages": "place", "impacts": "impacts"}.get(section.kind, "strobes")
    name = "cycle" if section.cycle is not None else name
    return {
        "section": name,
        "at": section.at,
        "direction": section.direction if name == "place" else "up",
        "cycle": section.cycle or 0,
        "isLive": False,
    }


def _response(response: Response, study: Study) -> Shown:
    ((path, (first, last)),) = response.over.items()
    low, high = sorted((as_float(first), as_float(last)))
    over = {"path": _path_of_page(path, study), "low": low, "high": high, **_OF_CHARTS}
    sizes = {"values": 1600, "points": 128, "of": "amplitude", "max_impacts": response.max_impacts}
    rest = {**sizes, "max_periods": response.max_periods, "follow": "start"}
    return "diagram", _from(_at_rest(study)), {"kind": "response", **over, **rest, **_STROBES}


def _sweep(sweep: Sweep, study: Study) -> Shown:
    start = sweep.start
    assert isinstance(start, Start)
    _check_chart(sweep)
    over: TomlTable = {}
    for (path, axis), end in zip(sweep.over.items(), ("", "2"), strict=True):
        if path.startswith("start."):
            raise ParameterError(
                f"over.{path}", "given", "not on the page, whose charts are over parameters"
            )
        low, high, _ = _edges(axis)
        over |= {f"path{end}": _path_of_page(path, study), f"low{end}": low, f"high{end}": high}
    count = _ends(next(iter(sweep.over.values())))[2]
    sizes = {"size": count, "values": 1600, "points": 128, "of": sweep.measure[0]}
    rest = {"max_impacts": 3, "max_periods": 2, "follow": "start", **_STROBES}
    return "diagram", _from(start), {"kind": "sweep", **over, **sizes, **rest}


def _check_chart(sweep: Sweep) -> None:
    """Refuse a sweep that the page's chart of two parameters would not take as it stands."""
    if sweep.paired:
        reason = "not on the page, whose charts have all combinations"
        raise ParameterError("sweep.paired", sweep.paired, reason)
    counts = [_ends(axis)[2] for axis in sweep.over.values() if isinstance(axis, Span)]
    fewest, most = CELLS
    if len(sweep.over) != 2 or len(counts) != 2 or counts[0] != counts[1]:
        reason = (
            "not on the page, whose charts have {from, to, count} of two parameters, with one count"
        )
        raise ParameterError("over", list(sweep.over), reason)
    if not fewest <= counts[0] <= most:
        reason = f"not on the page, whose charts have {fewest} to {most} cells along a side"
        raise ParameterError("over.count", counts[0], reason)
    if len(sweep.measure) != 1 or sweep.measure[0] not in MEASURED:
        reason = f"not on the page, whose charts show one of {', '.join(MEASURED)}"
        raise ParameterError("sweep.measure", list(sweep.measure), reason)
    taken = {"transient": SETTLING, "periods": MEASURED[sweep.measure[0]]}
    for name, value in {**taken, "between": None, "max_impacts": None}.items():
        if getattr(sweep, name) != value:
            own = "" if value is None else f", whose chart takes {value}"
            raise ParameterError(f"sweep.{name}", getattr(sweep, name), f"not on the page{own}")


def _path_of_page(path: str, study: Study, start: Start | None = None) -> str:
    """Return the path of a parameter by its key in the tables of a study, as the page has it."""
    name = long_form(path, study.oscillator, study.forcing, start)
    if name in parameters_in(study.oscillator, study.forcing, study.question):
        # On the page a parameter is a row of its table.
        return f"parameters.{name}"
    is_coefficient = name == "oscillator.damping" and study.oscillator.mass is not None
    return "oscillator.damping_coefficient" if is_coefficient else name


def _at_rest(study: Study) -> Start:
    """Return a start at rest: at x = 0, or where the wall is that bars it."""
    places = [
        stop.at
        for stop in study.oscillator.stops
        if isinstance(stop, Wall) and (as_float(stop.at) > 0.0) == (stop.side == "below")
    ]
    return Start(max(places, key=lambda at: abs(as_float(at)), default=0), 0)


def _basins(basins: Basins, _: Study) -> Shown:
    places, speeds = basins.of_states
    if places is None or speeds is None:
        raise ParameterError(
            "basins", "cycle, v", "not on the page, which shows basins over x0, v0"
        )
    ends: TomlTable = {}
    first: list[float] = []
    for name, axis in (("x", places), ("v", speeds)):
        low, high, least = _edges(axis)
        ends |= {f"{name}_low": low, f"{name}_high": high}
        first.append(least)
    settings = {**ends, "starts": _ends(places)[2], "manifolds": True}
    return "basins", _from(Start(first[0], first[1], basins.begin)), settings


def _with_guesses(fit: Fit, study: Study) -> Study:
    """Return a study of a fit with the guesses in its model, its forcing and its start."""
    (record, *others) = fit.records
    if others:
        reason = f"{len(fit.records)} records; the page fits one, percuss run any number"
        raise ParameterError("fit.records", len(fit.records), reason)
    start = record.start or fit.start
    guesses = {path: given for path, given in fit.free.items() if not isinstance(given, tuple)}
    force = record.forcing(study.oscillator, study.forcing)
    osc, force, start = replace_parameters(study.oscillator, force, start, guesses)
    assert isinstance(force, Forcing | None)
    own = replace(fit, start=start, records=(replace(record, start=start),))
    return replace(study, model=osc, force=force, question=own)


def _fit(fit: Fit, study: Study) -> Shown:
    (record,) = fit.records
    start = fit.start
    if fit.prior or fit.loss != "linear":
        what = "prior" if fit.prior else "loss"
        raise ParameterError(f"fit.{what}", "given", "not on the page; percuss run has it")
    assert start is None or isinstance(start, Start)
    free = {
        _path_of_page(path, study, start): [as_float(end) for end in given]
        if isinstance(given, tuple)
        else NULL
        for path, given in fit.free.items()
    }
    text = _csv_of(record)
    if len(text) > MOST_BYTES:
        n = max(len(column) for column in record.data.values())
        reason = (
            f"{math.ceil(len(text) / 1000)} kB; links of the page hold {MOST_BYTES // 1000} kB, some "
            f"{n * MOST_BYTES // len(text)} of these rows: load the file on the page itself"
        )
        raise ParameterError("fit.records", f"{n} rows", reason)
    settings = {
        "name": "record.csv",
        "csv": text,
        "columns": {
            name: name if name in record.data else "" for name in measurable(study.oscillator)
        },
        "free": free,
        "noise": _noise_of_page(record) or NULL,
        "start": start is not None,
    }
    return "fit", _from(start or _at_rest(study)), settings


def _csv_of(record: FitRecord) -> str:
    """Return the values of a record as a table, empty where one is missing."""
    names = list(record.data)
    rows = zip_longest(*record.data.values())
    lines = (",".join("" if value is None else repr(value) for value in row) for row in rows)
    return "\n".join([",".join(names), *lines]) + "\n"


def _noise_of_page(record: FitRecord) -> float | None:
    """Return the one standard deviation of a record; None where it is in its table or estimated."""
    noise: float | Mapping[str, float] | None = record.deviation
    if isinstance(noise, Mapping):
        if len(set(noise.values())) > 1:
            reason = "one for each quantity; on the page a column of the table may hold it"
            raise ParameterError("fit.records.noise", dict(noise), reason)
        return next(iter(noise.values()))
    return noise


def _design(design: Design, study: Study) -> Shown:
    if design.sought is not None:
        reason = "not on the page, which follows the orbits that attract"
        raise ParameterError("orbit", "given", reason)
    is_run = design.on == "run"
    start = design.start if is_run else None
    assert start is None or isinstance(start, Start)
    outcome, second = (*design.outcome, "")[:2]
    wanted = [as_float(goal) for goal in design.goals if goal not in ("least", "largest")]
    goal, other = ("wanted", "least") if wanted else (*design.goals, "least")[:2]
    settings = {
        "outcome": outcome,
        "goal": goal,
        "wanted": wanted[0] if wanted else 1,
        "second": second,
        "secondGoal": other,
        "on": design.on,
        "restarts": design.restarts,
        "n": design.n,
        "free": {
            _path_of_page(path, study, start): [as_float(end) for end in ends]
            for path, ends in design.free.items()
        },
        "limits": [
            {
                "outcome": name,
                "low": NULL if low is None else as_float(low),
                "high": NULL if high is None else as_float(high),
            }
            for name, (low, high) in design.subject_to.items()
        ],
    }
    if start is not None:
        return "design", Motion(start, design.limits).tables(), settings
    return "design", _from(_at_rest(study)), settings


def _ends(axis: Any) -> tuple[float, float, int]:
    """Return the least and the largest value of an axis, and how many there are."""
    values = axis_values(axis)
    if isinstance(axis, Span) or len(values) > 1:
        low, high = sorted((as_float(values[0]), as_float(values[-1])))
        return low, high, len(values)
    raise ParameterError("axis", [number(value) for value in values], "a single value; no range")


def _edges(axis: Any) -> tuple[float, float, float]:
    """Return both edges of the cells of an axis, which the page has, and the least of their centres."""
    low, high, count = _ends(axis)
    half = 0.5 * (high - low) / (count - 1)
    return low - half, high + half, low


def _from(start: Start) -> TomlTable:
    return {"start": start_table(start), "run": FOLLOWED}


_SHOWN: dict[type, Callable[[Any, Study], Shown]] = {
    Motion: _motion,
    Diagram: _diagram,
    Response: _response,
    Sweep: _sweep,
    Basins: _basins,
    Fit: _fit,
    Design: _design,
}
