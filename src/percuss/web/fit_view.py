"""A record on the page, and the parameters fitted to it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.execution import Execution
from percuss.fitting.data_file import columns_of_text, quantities_of_text, titles_of_text
from percuss.fitting.measured import IMPACT_TIMES, measurable, quantity_number
from percuss.fitting.result import Fit
from percuss.fitting.summaries import impacts_of, motion_of
from percuss.model.exact import as_float
from percuss.studies.kinds.fit import Fit as FitQuestion
from percuss.studies.study import Study
from percuss.web.answer_cache import ANSWERS
from percuss.web.frame import frame
from percuss.web.request import BadRequest, PageRequest, RunningRequest, study_of
from percuss.web.wording import plain, quantity_words

# Values that the page fits, and points of the curve of a fit.
MOST_VALUES, POINTS = 20_000, 3000
# Rows of the report of a fit that the page says in its own words, or draws.
SHOWN_ELSEWHERE = ("fit", "impacts")


def answer_measured(request: PageRequest, running: RunningRequest | None = None) -> bytes:  # noqa: ARG001
    """Return what is in a table of measurements.

    Parameters
    ----------
    request
        With the options ``csv``, the text of the table, and ``columns``, the names of its columns
        by quantity, "" for none; None for those that the names say.
    running
        State of the answer.

    Returns
    -------
    bytes
        A frame: `titles` of all columns, `columns`, the title by each quantity that may be
        measured, "" for none; with `fault` why these are no record, or else `quantities`, `n`
        values, and arrays ``t{i}`` and ``y{i}`` of the i-th quantity.

    Raises
    ------
    BadRequest
        If the table has no columns.
    """
    study, text = study_of(request.tables), _text(request)
    if "\0" in text[:1000]:
        raise BadRequest("no text, but a binary file; save it as CSV")
    titles = titles_of_text(text)
    known = _titles(request) or quantities_of_text(text)
    columns = {name: known.get(name, "") for name in measurable(study.oscillator)}
    header = {"id": request.id, "kind": request.kind, "titles": titles, "columns": columns}
    try:
        read = _columns(request, study)
    except BadRequest as error:
        if len(titles) < 2:
            raise
        return frame(header | {"fault": str(error)})
    names = [name for name in read if name not in ("t", "noise")]
    arrays: dict[str, Floats] = {}
    for i, name in enumerate(names):
        is_given = np.isfinite(read[name])
        arrays[f"y{i}"] = read[name][is_given]
        arrays[f"t{i}"] = (read["t"] if name != IMPACT_TIMES else read[name])[is_given]
    n = sum(len(arrays[f"y{i}"]) for i in range(len(names)))
    if n == 0:
        return frame(header | {"fault": f"no values of {', '.join(names)}: all are missing"})
    return frame(header | {"quantities": names, "n": n}, arrays)


def _text(request: PageRequest) -> str:
    text = request.options.get("csv")
    if not isinstance(text, str) or not text:
        is_read = text == "" and request.kind == "measured"
        first = "load a record first: a table with a column t and one of displacement"
        raise BadRequest("the file is empty" if is_read else first)
    return text


def _titles(request: PageRequest) -> dict[str, str]:
    """Return the names of columns by quantity that were chosen, {} if none were."""
    chosen = request.options.get("columns") or {}
    if not isinstance(chosen, Mapping):
        raise BadRequest("columns are no names of columns by quantity")
    return {str(name): str(title) for name, title in chosen.items()}


def _columns(request: PageRequest, study: Study) -> dict[str, Floats]:
    """Return the columns of the table in a request."""
    text, osc = _text(request), study.oscillator
    try:
        columns = columns_of_text(text, osc.units, _titles(request))
        for name in columns:
            if name not in ("t", "noise"):
                quantity_number(name, osc)
    except ParameterError as error:
        raise BadRequest(f"{error.value}: {error.reason}") from error
    except ValueError as error:
        raise BadRequest(str(error)) from error
    count = sum(len(column) for name, column in columns.items() if name not in ("t", "noise"))
    if count > MOST_VALUES:
        reason = f"{count:,} values; the page fits {MOST_VALUES:,} at most, percuss run any number"
        raise BadRequest(reason)
    return columns


def fit_tables(request: PageRequest, motion: Study) -> Mapping[str, Any]:
    """Return the tables of the study of a fit.

    Parameters
    ----------
    request
        With the options ``csv`` and ``columns``, as `answer_measured` takes them; ``free``, ranges
        or guesses by path; ``noise``, None where it is estimated; ``start``, whether that of the
        motion is known.
    motion
        The motion that is set.
    """
    columns = _columns(request, motion)
    free = request.free_parameters("tick the parameters that are not known", "fits")
    record: dict[str, Any] = {name: values.tolist() for name, values in columns.items()}
    noise = request.options.get("noise")
    if "noise" not in record and noise is not None:
        record["noise"] = request.number("noise", 1.0, 1e-300, 1e300)
    tables: dict[str, Any] = {"fit": {"free": free, "records": [record]}}
    if request.options.get("start") is True:
        tables["start"] = request.tables.get("start", {})
    return tables


def answer_fit(study: Study, request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
    """Yield the fit of a record.

    Parameters
    ----------
    study
        The study of the fit.
    request
        As `fit_tables` takes it.
    running
        State of the answer.

    Yields
    ------
    bytes
        One frame: `values` by the path that was asked for, with value, error and both in words;
        `notes`, rows of a name and words on the residuals, the noise and what is not told; arrays
        ``t{i}``, ``y{i}``, ``residual{i}`` [standard deviations], ``curve_t{i}``, ``curve{i}`` of
        the i-th quantity, and ``impact_t``, ``impact_v`` of the impacts of the fitted motion.
    """
    question = study.question
    assert isinstance(question, FitQuestion)
    fit = question.answer(study, Execution(progress=running.progress(0.0, 1.0)))
    if running.is_cancelled:
        return
    ANSWERS.put(study, fit)
    header = {"id": request.id, "kind": request.kind, "done": True, "share": 1.0}
    yield frame(header | _facts(fit, question, list(request.options["free"])), _arrays(fit))


def _facts(fit: Fit, question: FitQuestion, asked: list[str]) -> dict[str, object]:
    """Return what the page says of a fit whose free parameters have these paths on the page."""
    names = list(dict.fromkeys(fit.residuals.quantity.values.tolist()))
    words = question.report(fit)
    rows = [
        {"path": path, "value": value, "error": error, "text": words.pop(own)}
        for path, own, value, error in zip(
            asked, question.free, fit.values.values(), fit.errors.values(), strict=True
        )
    ]
    start = fit.start
    return {
        "quantities": names,
        "values": rows,
        "converged": fit.converged,
        "reason": plain(fit.reason),
        "n_runs": fit.n_runs,
        "chi2": fit.chi2,
        "notes": [
            [name, quantity_words(text) if name == "noise" else text]
            for name, text in words.items()
            if name not in SHOWN_ELSEWHERE
        ],
        "start": [as_float(value) for value in (start.x0, start.v0, start.t0)],  # type: ignore[arg-type]
    }


def _arrays(fit: Fit) -> dict[str, Floats]:
    """Return samples, curves, residuals and impacts."""
    table = fit.residuals
    arrays: dict[str, Floats] = {}
    begin, end = float(fit.nodes[0, 0]), float(fit.problem.layouts[0].spans[-1, 1])
    for i, name in enumerate(dict.fromkeys(table.quantity.values.tolist())):
        rows = np.flatnonzero(table.quantity.values == name)
        arrays[f"t{i}"] = table.t.values[rows]
        arrays[f"y{i}"] = table.value.values[rows]
        arrays[f"residual{i}"] = table.residual.values[rows] / table.noise.values[rows]
        if name == "impact_times":
            arrays[f"curve_t{i}"] = arrays[f"curve{i}"] = table.fitted.values[rows]
        else:
            t = np.linspace(begin, end, POINTS)
            arrays[f"curve_t{i}"], arrays[f"curve{i}"] = t, motion_of(fit, name, t)
    hits = impacts_of(fit)
    return arrays | {"impact_t": hits["t"], "impact_v": np.abs(hits["v_before"])}
