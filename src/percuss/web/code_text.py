"""A study as Python: the same run in code."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from percuss.io.study_text import forcing_table, number, oscillator_table
from percuss.model.exact import Phase, as_float, phase_problem
from percuss.model.expression import Expression, expression_problem, parameters_in
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.studies.study import Study
from percuss.studies.tables import exact_phase
from percuss.web.request import motion_of
from percuss.web.saddles import SADDLE_LIMIT

# The call that answers a study, and the one that draws the answer.
_LONG = {
    "diagram": ("bifurcation_diagram", "plot_diagram"),
    "response": ("response_curve", "plot_response"),
    "basins": ("basins", "plot_basins"),
    "sweep": ("sweep", "plot_chart"),
}
_STOPS = {"wall": "Wall", "soft": "SoftStop"}


def python_text(study: Study) -> str:
    """Return a script that computes the answer of a study and draws it.

    Every number stands as it was given.

    Examples
    --------
    >>> import percuss as pc
    >>> from percuss.studies import Limits, Motion
    >>> motion = Motion(pc.Start(0, "0.5"), Limits(t_end=9))
    >>> study = Study(pc.impact_oscillator("0.8"), pc.sine(3), motion)
    >>> print(python_text(study))
    import percuss as pc
    from percuss import plotting
    <BLANKLINE>
    osc = pc.Oscillator(
        stiffness=1.0,
        damping=0.0,
        stops=(
            pc.Wall(at=0.0, side='below', restitution='0.8'),
        ),
    )
    force = pc.Forcing(
        harmonics=(
            pc.Harmonic(amplitude=1.0, omega=3, phase='-pi/2'),
        ),
    )
    run = pc.simulate(osc, force, x0=0, v0='0.5', t_end=9)
    print(run)
    plotting.plot_motion(run).savefig("motion.png")
    <BLANKLINE>
    """
    lines = ["import percuss as pc", "from percuss import plotting", ""]
    parameters = parameters_in(study.oscillator, study.forcing, study.question)
    lines += _oscillator(study.oscillator, parameters)
    lines += ["force = None"] if study.forcing is None else _forcing(study.forcing, parameters)
    if study.kind == "fit":
        return "\n".join(["import numpy as np", *lines, *_fit(study), ""])
    if study.kind == "design":
        return "\n".join([*lines, *_design(study), ""])
    if study.kind in _LONG:
        return "\n".join(["import numpy as np", *lines, *_long(study), ""])
    motion = motion_of(study)
    start, limits = motion.start, motion.limits
    given: dict[str, Any] = {"x0": number(start.x0), "v0": number(start.v0)}
    if start.t0 != 0:
        given["t0"] = number(start.t0)
    for name, value in (("t_end", limits.t_end), ("periods", limits.periods)):
        given |= {} if value is None else {name: number(value)}
    given |= {} if limits.max_impacts is None else {"max_impacts": limits.max_impacts}
    lines.append(f"run = pc.simulate(osc, force, {_arguments(_in_code(given, parameters))})")
    lines += ["print(run)", 'plotting.plot_motion(run).savefig("motion.png")']
    if study.certify is not None:
        lines.append(f"print(pc.certify(run, digits={study.certify.digits}))")
    return "\n".join([*lines, ""])


def _long(study: Study) -> list[str]:
    """Return the call of a diagram, a chart or basins, and of its picture."""
    tables: dict[str, Any] = study.question.tables()
    call, draw = _LONG[study.kind]
    options: dict[str, Any] = {**tables.get(study.kind, {})}
    if tables.get("over"):
        options = {"over": tables["over"]} | options
    measured = options.pop("measure", ())
    if study.kind == "sweep":
        options["start"] = tuple(tables["start"].values())
    rows = [f"    {name}={_value(value)}," for name, value in options.items() if value is not None]
    curves = _saddles(study) if study.draw.manifolds else []
    drawn = "result, manifolds=curves" if curves else "result"
    return [
        f"result = pc.{call}(",
        *(f"    {name!r}," for name in measured),
        "    osc,",
        "    force,",
        *rows,
        "    progress=True,",
        ")",
        "print(result)",
        *curves,
        f'plotting.{draw}({drawn}).figure.savefig("{study.kind}.png")',
    ]


def _fit(study: Study) -> list[str]:
    """Return the call of a fit, with the record in the script."""
    table: dict[str, Any] = study.question.tables()
    own = table["fit"]
    (record,) = own["records"]
    noise = record.pop("noise")
    values = {key: column for key, column in record.items() if isinstance(column, list)}
    rows = [f"    {name!r}: np.array({column!r})," for name, column in values.items()]
    free = {
        path: tuple(guess) if isinstance(guess, list) else guess
        for path, guess in own["free"].items()
    }
    start = table.get("start")
    given = '"free"' if start is None else repr(tuple(start[name] for name in ("x0", "v0", "t0")))
    return [
        "nan = np.nan",
        "data = {",
        *rows,
        "}",
        f"result = pc.fit(data, osc, force, free={free!r}, start={given}, noise={noise!r})",
        "print(result)",
        'plotting.plot_fit(result).savefig("fit.png")',
    ]


def _design(study: Study) -> list[str]:
    """Return the call of a design or a front, and of its picture."""
    tables: dict[str, Any] = study.question.tables()
    own = tables["design"]
    names, goals = own.pop("outcome"), own.pop("goal")
    is_front = not isinstance(names, str) and len(names) > 1
    first = tuple(names) if is_front else _alone(names)
    pair = goals if isinstance(goals, list | tuple) else [goals, goals]
    given: dict[str, Any] = {"goals": tuple(pair)} if is_front else {"goal": _alone(goals)}
    given["free"] = {path: tuple(ends) for path, ends in own.pop("free").items()}
    limits = own.pop("subject_to", None) or {}
    given["subject_to"] = {
        name: tuple(None if end in (-math.inf, math.inf) else end for end in ends)
        for name, ends in limits.items()
    } or None
    given |= own
    start, run = tables.get("start"), tables.get("run") or {}
    if start is not None:
        given["start"] = tuple(start[name] for name in ("x0", "v0", "t0"))
    given |= {name: run.get(name) for name in ("t_end", "periods", "max_impacts")}
    call, draw = ("pareto_front", "plot_pareto") if is_front else ("design", "plot_design")
    rows = [f"    {name}={value!r}," for name, value in given.items() if value is not None]
    return [
        f"best = pc.{call}(",
        f"    {first!r},",
        "    osc,",
        "    force,",
        *rows,
        "    progress=True,",
        ")",
        "print(best)",
        f'plotting.{draw}(best).figure.savefig("design.png")',
    ]


def _alone(value: Any) -> Any:
    """Return the one value of a list, and anything else as it is."""
    return value[0] if isinstance(value, list | tuple) else value


def _saddles(study: Study) -> list[str]:
    """Return the lines that compute the stable manifolds of saddles, to be drawn over basins."""
    period = None if study.forcing is None else study.forcing.period
    begin = getattr(study.question, "t0", 0.0)
    cycle = (as_float(begin) / period) % 1.0 if period else 0.0
    return [
        "curves = [",
        f'    pc.manifolds(orbit, cycle={cycle!r}, kinds=("stable",))',
        f"    for orbit in pc.find_orbits(osc, force, {SADDLE_LIMIT}, {SADDLE_LIMIT})",
        "    if 0 < min(abs(orbit.multipliers)) < 1 < max(abs(orbit.multipliers))",
        "]",
    ]


def _value(value: Any) -> str:
    """Return a value of a study file as Python: an axis as its values."""
    if isinstance(value, dict) and set(value) == {"from", "to", "count"}:
        return f"np.linspace({value['from']!r}, {value['to']!r}, {value['count']})"
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key!r}: {_value(part)}" for key, part in value.items()) + "}"
    return repr(value)


@dataclass(frozen=True)
class _Code:
    """A text that stands in the script as it is."""

    text: str

    def __repr__(self) -> str:
        return self.text


def _in_code(value: Any, parameters: Mapping[str, Phase]) -> Any:
    """Return a part of a study file with its expressions as Python."""
    if isinstance(value, dict):
        return {name: _in_code(part, parameters) for name, part in value.items()}
    if isinstance(value, list | tuple):
        return [_in_code(part, parameters) for part in value]
    is_text = isinstance(value, str) and phase_problem(exact_phase(value)) is not None
    if not is_text or expression_problem(value, list(parameters)) is not None:
        return value
    return _Code(f"pc.{Expression(value, tuple(parameters.items()))!r}")


def _oscillator(osc: Oscillator, parameters: Mapping[str, Phase]) -> list[str]:
    table: dict[str, Any] = _in_code(oscillator_table(osc), parameters)
    stops = table.pop("stops", None) or []
    rows = [
        (_STOPS[stop["type"]], {k: _call(v) for k, v in stop.items() if k != "type"})
        for stop in stops
    ]
    units = table.pop("units", None)
    own = _lines(table) + ([] if units is None else [f"    units=pc.Units({_arguments(units)}),"])
    made = "Oscillator" if osc.mass is None else "Oscillator.from_mass"
    return [f"osc = pc.{made}(", *own, *_tuple("stops", rows), ")"]


def _call(value: Any) -> Any:
    """Return a table of restitutions as the call that makes it, anything else as it is."""
    return _Code(f"pc.restitution_table({_arguments(value)})") if isinstance(value, dict) else value


def _forcing(force: Forcing, parameters: Mapping[str, Phase]) -> list[str]:
    table: dict[str, Any] = _in_code(forcing_table(force), parameters)
    marked = ".per_mass(1)" if table.pop("per_mass", False) else ""
    record = table.pop("record", None)
    if record is not None:
        samples = {name: tuple(record.pop(name)) for name in ("t", "f")}
        table["record"] = _Code(f"pc.model.ForceRecord({_arguments(samples | record)})")
    if "omega" in table:
        added = "" if record is None else f" + pc.Forcing(record={table.pop('record')!r})"
        marked = f"{added}){marked}" if added else marked
        opened = "(" if added else ""
        return [f"force = {opened}pc.fourier({_arguments(table)}){marked}"]
    rows = [("Harmonic", row) for row in table.pop("harmonics", None) or []]
    rest = {name: value for name, value in table.items() if value not in (0, None)}
    return ["force = pc.Forcing(", *_tuple("harmonics", rows), *_lines(rest), f"){marked}"]


def _tuple(name: str, rows: list[tuple[str, dict[str, Any]]]) -> list[str]:
    if not rows:
        return []
    calls = [f"        pc.{kind}({_arguments(row)})," for kind, row in rows]
    return [f"    {name}=(", *calls, "    ),"]


def _lines(table: dict[str, Any]) -> list[str]:
    return [f"    {name}={value!r}," for name, value in table.items() if value is not None]


def _arguments(table: dict[str, Any]) -> str:
    return ", ".join(f"{name}={value!r}" for name, value in table.items() if value is not None)
