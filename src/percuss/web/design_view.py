"""The best setting of free parameters on the page, or the front between two outcomes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from percuss.arrays import Floats
from percuss.ensembles.measures import outcome_dimensions
from percuss.execution import Execution
from percuss.model.oscillator import Oscillator
from percuss.model.units import in_units, is_unit
from percuss.motion.trajectory import Trajectory
from percuss.optimization import Design as DesignResult
from percuss.optimization import ParetoFront
from percuss.optimization.outcomes import outcome_names
from percuss.plotting.samples import reduce_to_columns, sample_curve
from percuss.studies.kinds.design import Design as DesignQuestion
from percuss.studies.study import Study
from percuss.web.answer_cache import ANSWERS
from percuss.web.frame import frame
from percuss.web.request import BadRequest, PageRequest, RunningRequest
from percuss.web.wording import plain
from percuss.wording import counted

# Limits, restarts and designs of a front on the page.
MOST_LIMITS, MOST_RESTARTS, MOST_DESIGNS = 8, 16, 24
# Points of the curve of the motion.
POINTS = 4000
MOTIONS = ("orbit", "run")
# Ends of an outcome without limits, in a study file.
UNLIMITED = (-math.inf, math.inf)


def outcomes_of_page() -> dict[str, list[str]]:
    """Return the names of the outcomes of an orbit and of a run.

    Examples
    --------
    >>> outcomes_of_page()["orbit"][-3:]
    ['grazing_margin', 'multiplier', 'period']
    """
    model = Oscillator()
    return {on: list(outcome_names(model, of_orbit=on == "orbit")) for on in MOTIONS}


def design_tables(request: PageRequest, motion: Study) -> Mapping[str, Any]:  # noqa: ARG001
    """Return the tables of the study of a design.

    Parameters
    ----------
    request
        With the options ``outcomes``, one or two names; ``goals``, "least", "largest" or a number
        for each; ``free``, ranges by path; ``limits``, pairs by outcome, None for no limit;
        ``on``, "orbit" or "run"; ``restarts``, and ``n`` of a front.
    motion
        The motion that is set.
    """
    options = request.options
    without = "tick the parameters that are free, and give their ranges"
    free, limits = request.free_parameters(without, "takes"), options.get("limits", {})
    if not isinstance(limits, Mapping) or len(limits) > MOST_LIMITS:
        raise BadRequest(f"limits of outcomes: {MOST_LIMITS} at most")
    outcomes, goals = options.get("outcomes"), options.get("goals")
    if not isinstance(outcomes, list) or not isinstance(goals, list):
        raise BadRequest("choose an outcome and what it shall be")
    on = request.choice("on", MOTIONS)
    design: dict[str, Any] = {
        "outcome": outcomes,
        "free": free,
        "goal": goals,
        "subject_to": {name: _ends(ends) for name, ends in limits.items()},
        "on": on,
        "restarts": int(request.number("restarts", 2, 0, MOST_RESTARTS)),
    }
    if len(outcomes) > 1:
        design["n"] = int(request.number("n", 8, 2, MOST_DESIGNS))
    names = ("start", "run") if on == "run" else ()
    return {"design": design} | {name: request.tables.get(name, {}) for name in names}


def _ends(given: object) -> object:
    """Return the ends of a limit as a study file has them."""
    if not isinstance(given, list) or len(given) != 2:
        return given
    return [free if end is None else end for end, free in zip(given, UNLIMITED, strict=True)]


def answer_design(study: Study, request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield the design of a study, or the front.

    Parameters
    ----------
    study
        The study of the design.
    request
        As `design_tables` takes it.
    running
        State of the answer.

    Yields
    ------
    bytes
        One frame: `told`, how the search ended; `report`, rows of a name and words; `outcomes`,
        named with their units; `designs`, each with `values` by path, its `outcomes` and the
        `start` of its motion;
        arrays ``t``, ``x``, ``portrait_x``, ``portrait_v`` of the motion at the first of them.
    """
    question = study.question
    assert isinstance(question, DesignQuestion)
    result: Any = question.answer(study, Execution(progress=running.progress(0.0, 1.0)))
    if running.is_cancelled:
        return
    ANSWERS.put(study, result)
    designs = list(result.designs) if question.is_front else [result]
    pairs = result.values.tolist() if question.is_front else [[result.value]]
    # As the page has asked: the paths of a mass are others in the model.
    asked = dict(zip(designs[0].values, map(str, request.options["free"]), strict=True))
    header = {
        "id": request.id,
        "kind": request.kind,
        "done": True,
        "share": 1.0,
        "outcomes": [_named(name, designs[0]) for name in question.outcome],
        "converged": not any(best.reason for best in designs),
        "told": _told(result, designs),
        "report": [[asked.get(name, name), text] for name, text in question.report(result).items()],
        "designs": [
            {
                "values": {asked[path]: value for path, value in best.values.items()},
                "outcomes": pair,
                "start": _start(best),
            }
            for best, pair in zip(designs, pairs, strict=True)
        ],
    }
    yield frame(header, _curve(designs[0]))


def _named(name: str, best: DesignResult) -> str:
    """Return an outcome with its unit, as it stands over a column or along an axis."""
    osc = best.oscillator
    unit = in_units(osc.units, outcome_dimensions(name, osc))
    return name.replace("_", " ") + (f" ({unit})" if is_unit(unit) else "")


def _told(result: DesignResult | ParetoFront, designs: list[DesignResult]) -> str:
    """Return in a sentence how a search ended."""
    reason = next((best.reason for best in designs if best.reason), "")
    if reason:
        return f"No optimum: {plain(reason).replace('_', ' ')}. These are the best values found."
    if isinstance(result, DesignResult):
        return "An optimum that keeps all limits."
    left_out = f"; {result.n_left_out} more were no better in either outcome than one of these"
    return f"{counted(len(result), 'design')}{left_out if result.n_left_out else ''}."


def _start(best: DesignResult) -> list[float]:
    """Return x0, v0 and t0 of the motion at a setting."""
    run = best.run
    x, v = run(run.t0)
    return [float(x), float(v), run.t0]


def _curve(best: DesignResult) -> dict[str, Floats]:
    """Return the motion as it is drawn: the portrait of an orbit is closed."""
    run = best.run
    assert isinstance(run, Trajectory)
    curve = sample_curve(run)
    t, x, _ = reduce_to_columns(curve.t, curve.x, curve.jumps, columns=POINTS // 2, most=POINTS)
    rows = np.arange(len(curve.x))
    rows = rows[-POINTS:] if best.orbit is None else np.append(rows, 0)
    return {"t": t, "x": x, "portrait_x": curve.x[rows], "portrait_v": curve.v[rows]}
