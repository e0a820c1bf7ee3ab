"""A study file that is dropped on the page, as the link that shows it."""

from __future__ import annotations

from percuss.errors import StudyError
from percuss.studies import parse_study
from percuss.studies.link import link_of
from percuss.web.frame import frame
from percuss.web.request import BadRequest, PageRequest, RunningRequest

# Faults that the page tells at once.
MOST_TOLD = 6


def answer_study_file(request: PageRequest, running: RunningRequest | None = None) -> bytes:  # noqa: ARG001
    """Return the link of a study.

    Parameters
    ----------
    request
        With the option ``toml``, the text of the file.
    running
        State of the answer.

    Returns
    -------
    bytes
        A frame: `link`, the fragment of the page's address.

    Raises
    ------
    BadRequest
        With the faults of the file and their lines.
    ParameterError
        If the page shows no such study.
    """
    text = request.options.get("toml")
    if not isinstance(text, str):
        raise BadRequest("the study file is not a text")
    try:
        study = parse_study(text)
    except StudyError as error:
        texts = [str(fault).removeprefix("study:").strip() for fault in error.faults]
        told = [f"line {text}" if text[0].isdigit() else text for text in texts[:MOST_TOLD]]
        more = len(error.faults) - len(told)
        told += [f"and {more} more"] if more else []
        raise BadRequest("; ".join(told)) from error
    return frame({"id": request.id, "kind": request.kind, "link": link_of(study)})
