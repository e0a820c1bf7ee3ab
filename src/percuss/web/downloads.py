"""Files of what a view shows: pictures, tables, the study and the script."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from percuss.studies.kinds.motion import Motion
from percuss.studies.study import Study
from percuss.web.answer_cache import answer_of
from percuss.web.code_text import python_text
from percuss.web.proof import proof_in_time
from percuss.web.request import BadRequest, PageRequest, RunningRequest
from percuss.web.structure_view import mechanism_python
from percuss.web.view_study import check_size, study_of_view
from percuss.web.wording import name_axes

# Formats, and their media types.
FORMATS = {
    "png": "image/png",
    "svg": "image/svg+xml",
    "csv": "text/csv; charset=utf-8",
    "nc": "application/x-netcdf",
    "toml": "application/toml",
    "py": "text/x-python; charset=utf-8",
}
# Formats that need no computation.
QUICK = ("toml", "py")
# A motion is followed for so many impacts at most.
MOST_IMPACTS = 200_000
# A table with more rows is for other programs.
MOST_ROWS = 1_100_000
# matplotlib draws in one thread at a time.
_drawing = threading.Lock()


@dataclass(frozen=True, slots=True)
class File:
    """A file for the browser.

    Parameters
    ----------
    name
        Its name, with the extension.
    media_type
        Its MIME type.
    data
        Its bytes.
    """

    name: str
    media_type: str
    data: bytes


def file_of(request: PageRequest, extension: str, running: RunningRequest | None = None) -> File:
    """Return a file of what a view shows.

    Parameters
    ----------
    request
        Request for a motion, for a mechanism (Python alone), or of one of the kinds in
        `percuss.web.view_study.VIEWS`; for CSV its option ``table`` names the table, by default the
        first.
    extension
        One of `FORMATS`.
    running
        State of the answer; default: a new one.

    Returns
    -------
    File
        The file, as `percuss run` writes it.

    Raises
    ------
    BadRequest
        If there is no such format or table, or it takes too long.
    PercussError
        If there is no answer.
    """
    from percuss.io.record import make_record
    from percuss.io.table import write_columns

    if extension not in FORMATS:
        raise BadRequest(f"{extension!r:.20} is none of {', '.join(FORMATS)}")
    if request.kind == "mechanism":
        if extension != "py":
            raise BadRequest("of a structure the page writes Python")
        text = mechanism_python(request)
        return File("structure.py", FORMATS[extension], text.encode())
    study = study_of_view(request)
    if extension in QUICK:
        is_study = extension == "toml"
        text = study.text() if is_study else python_text(study)
        name = f"{'study' if is_study else study.kind}.{extension}"
        return File(name, FORMATS[extension], text.encode())
    check_size(request)
    running = running or RunningRequest()
    stem = study.question.stem
    if extension == "csv":
        stem = _table(study, request)
    elif extension != "nc":
        stem = next(iter(study.question.pictures(study)))
    answer = _answer(study, running)
    record = make_record(answer, study=study.text())
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder) / f"{stem}.{extension}"
        if extension == "nc":
            # A second of import.
            from percuss.io.netcdf import write_netcdf

            write_netcdf(answer, path, record, samples=study.save.samples)
        elif extension == "csv":
            write_columns(_columns(study, stem, answer, running), path, record)
        else:
            from percuss.io.figures import write_figure
            from percuss.studies.running import draw_picture

            with _drawing:
                figure = draw_picture(stem, answer, study)
                name_axes(figure, study)
                write_figure(figure, path, f".{extension}", record)
        return File(path.name, FORMATS[extension], path.read_bytes())


def _answer(study: Study, running: RunningRequest) -> Any:
    """Return the answer of a study, with a limit on the impacts of a motion."""
    motion = study.question
    if isinstance(motion, Motion):
        limit = min(motion.limits.max_impacts or MOST_IMPACTS, MOST_IMPACTS)
        limits = replace(motion.limits, max_impacts=limit)
        return answer_of(replace(study, question=replace(motion, limits=limits)), running)
    return answer_of(study, running)


def _table(study: Study, request: PageRequest) -> str:
    """Return the name of the requested table."""
    stems = [*study.question.csv(study), *(["certified"] if study.certify else [])]
    stem = request.options.get("table", stems[0])
    if stem not in stems:
        raise BadRequest(f"there is no table {stem!r:.20}, only {', '.join(stems)}")
    return str(stem)


def _columns(study: Study, stem: str, answer: Any, running: RunningRequest) -> Mapping[str, Any]:
    """Return the columns of a table of the answer of a study."""
    from percuss.io.results import kind_of

    if stem == "certified":
        columns: Mapping[str, Any] = proof_in_time(study, answer, running).columns
    else:
        columns = kind_of(answer).columns[study.question.csv(study)[stem]](answer)
    n_rows = max((len(column) for column in columns.values()), default=0)
    if n_rows > MOST_ROWS:
        raise BadRequest(f"a table of {n_rows:,} rows; NetCDF holds them in less")
    return columns
