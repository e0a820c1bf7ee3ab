"""A table that is loaded on the page as the record of a force."""

from __future__ import annotations

from typing import Any

from percuss.errors import ParameterError
from percuss.fitting.columns import name_and_unit
from percuss.fitting.data_file import forces_of_text, titles_of_text
from percuss.model.force_record import ForceRecord
from percuss.studies.link import check_size
from percuss.studies.record_file import quantity_of_force
from percuss.studies.study import Study
from percuss.web.frame import frame
from percuss.web.request import BadRequest, PageRequest, RunningRequest, study_of

# Usual names of the two columns, without their units.
TIMES, FORCES = ("t", "time"), ("f", "force")


def answer_record(request: PageRequest, running: RunningRequest | None = None) -> bytes:  # noqa: ARG001
    """Return the samples in two columns of a table, in the units of the model.

    Parameters
    ----------
    request
        With the options ``csv``, the text of the table, and ``time`` and ``force``, names of the
        columns; None for those that seem meant.
    running
        State of the answer.

    Returns
    -------
    bytes
        A frame: `names` of the columns, `time` and `force`; with `fault` why these two are no
        record, or else `t`, `f`, and a `note` where the unit of the force is another quantity's.

    Raises
    ------
    BadRequest
        If the table has no columns.
    """
    text = request.options.get("csv")
    if not isinstance(text, str):
        raise BadRequest("the table is not a text")
    study, names = study_of(request.tables), titles_of_text(text)
    if len(names) < 2:
        raise BadRequest(_why_none(text, names))
    time = _chosen(request.options.get("time"), names, TIMES, 0)
    force = _chosen(request.options.get("force"), names, FORCES, 1)
    header = {"id": request.id, "kind": request.kind, "names": names, "time": time, "force": force}
    return frame(header | _samples(text, study, time, force))


def _why_none(text: str, names: list[str]) -> str:
    """Return why a table has no two columns."""
    if names:
        return "it has one column; a record needs instants and forces"
    try:
        forces_of_text(text)
    except ValueError as error:
        return str(error)
    return "no line of names above numbers"


def _chosen(given: object, names: list[str], usual: tuple[str, ...], place: int) -> str:
    """Return the name of a column: the one that is given, a usual one, or that at a place."""
    if given in names:
        return str(given)
    bare = [name_and_unit(name)[0].lower() for name in names]
    return next(
        (name for name, plain in zip(names, bare, strict=True) if plain in usual), names[place]
    )


def _samples(text: str, study: Study, time: str, force: str) -> dict[str, Any]:
    """Return the samples, or why there are none."""
    osc, forcing = study.oscillator, study.forcing
    quantity = quantity_of_force(osc.units, forcing is not None and forcing.is_per_mass)
    note = ""
    for has_amplitude in (False, True):
        try:
            t, f = forces_of_text(
                text, osc.units, time, force, quantity=quantity, has_amplitude=has_amplitude
            )
        except ValueError as error:
            note = note or str(error)
            continue
        record = ForceRecord(tuple(t.tolist()), tuple(f.tolist()))
        try:
            check_size({"t": record.t, "f": record.f})
        except ParameterError as error:
            return {"fault": f"{error.value}: {error.reason}"}
        return {"t": record.t, "f": record.f, "note": note}
    return {"fault": note}
