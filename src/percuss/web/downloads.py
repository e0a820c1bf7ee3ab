"""Files of what a view shows: pictures, tables, the study and the script."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from percuss.studies.kinds.motion import Motion
from percuss.studies.study import Study
from percuss.web.asked import asked_study, check_size
from percuss.web.code_text import python_text
from percuss.web.handle import Handle
from percuss.web.kept import answer_of
from percuss.web.proof import proof_in_time
from percuss.web.question import BadQuestion, PageQuestion
from percuss.web.wording import name_axes

__all__ = ["FORMATS", "QUICK", "File", "file_of"]

# What comes out, and as which type.
FORMATS = {
    "png": "image/png",
    "svg": "image/svg+xml",
    "csv": "text/csv; charset=utf-8",
    "nc": "application/x-netcdf",
    "toml": "application/toml",
    "py": "text/x-python; charset=utf-8",
}
# Those of which nothing has to be computed.
QUICK = ("toml", "py")
# Of a motion: it is followed no further.
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
        What it is called.
    media_type
        What it is.
    data
        What is in it.
    """

    name: str
    media_type: str
    data: bytes


def file_of(question: PageQuestion, extension: str, handle: Handle | None = None) -> File:
    """Return a file of what a view shows.

    Parameters
    ----------
    question
        Of a motion or one of the kinds in `percuss.web.asked.ASKED`; for CSV its option ``table``
        names the table, by default the first.
    extension
        One of `FORMATS`.
    handle
        Where others get their turns, and where it is seen that nobody waits any more.

    Returns
    -------
    File
        The file, as `percuss run` writes it.

    Raises
    ------
    BadQuestion
        If there is no such format or table, or it takes too long.
    PercussError
        If there is no answer.
    """
    if extension not in FORMATS:
        raise BadQuestion(f"{extension!r:.20} is none of {', '.join(FORMATS)}")
    study = asked_study(question)
    if extension in QUICK:
        text, stem = (
            (study.text(), "study") if extension == "toml" else (python_text(study), study.kind)
        )
        return File(f"{stem}.{extension}", FORMATS[extension], text.encode())
    check_size(question)
    handle = handle or Handle()
    stem = study.question.stem
    if extension == "nc":
        write = _netcdf(study, handle)
    elif extension == "csv":
        stem = _table(study, question)
        write = _csv(study, stem, handle)
    else:
        ((stem, _),) = study.question.pictures(study).items()
        write = _picture(study, extension, handle)
    with tempfile.TemporaryDirectory(prefix="percuss-") as folder:
        path = Path(folder) / f"{stem}.{extension}"
        write(path)
        return File(path.name, FORMATS[extension], path.read_bytes())


def _answer(study: Study, handle: Handle) -> Any:
    """Return the answer of a study; a motion is followed for so many impacts at most."""
    motion = study.question
    if isinstance(motion, Motion):
        limit = min(motion.limits.max_impacts or MOST_IMPACTS, MOST_IMPACTS)
        limits = replace(motion.limits, max_impacts=limit)
        return answer_of(replace(study, question=replace(motion, limits=limits)), handle)
    return answer_of(study, handle)


def _netcdf(study: Study, handle: Handle) -> Callable[[Path], None]:
    from percuss.io.netcdf import write_netcdf
    from percuss.io.record import make_record

    answer = _answer(study, handle)
    record = make_record(answer, study=study.text())
    return lambda path: write_netcdf(answer, path, record, samples=study.save.samples)


def _table(study: Study, question: PageQuestion) -> str:
    """Return the stem of the table that is asked for."""
    stems = [*study.question.csv(study), *(["certified"] if study.certify else [])]
    stem = question.options.get("table", stems[0])
    if stem not in stems:
        raise BadQuestion(f"there is no table {stem!r:.20}, only {', '.join(stems)}")
    return str(stem)


def _csv(study: Study, stem: str, handle: Handle) -> Callable[[Path], None]:
    from percuss.io.record import make_record
    from percuss.io.results import kind_of
    from percuss.io.table import write_columns

    answer = _answer(study, handle)
    record = make_record(answer, study=study.text())
    columns: Mapping[str, Any]
    if stem == "certified":
        columns = proof_in_time(study, answer, handle).columns
    else:
        table = study.question.csv(study)[stem]
        columns = kind_of(answer).columns[table](answer)
    n_rows = max((len(column) for column in columns.values()), default=0)
    if n_rows > MOST_ROWS:
        raise BadQuestion(f"a table of {n_rows:,} rows; NetCDF holds them in less")
    return lambda path: write_columns(columns, path, record)


def _picture(study: Study, extension: str, handle: Handle) -> Callable[[Path], None]:
    from percuss.io.figures import write_figure
    from percuss.io.record import make_record
    from percuss.plotting.style import offscreen_figure, style

    answer = _answer(study, handle)
    record = make_record(answer, study=study.text())
    ((_, draw),) = study.question.pictures(study).items()

    def write(path: Path) -> None:
        with _drawing, style():
            figure = offscreen_figure()
            draw(answer, study, figure)
            name_axes(figure, study)
            write_figure(figure, path, f".{extension}", record)

    return write
