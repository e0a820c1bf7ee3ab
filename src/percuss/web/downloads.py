"""Files of a motion: pictures, tables, the study and the script."""

from __future__ import annotations

import tempfile
import threading
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

from percuss.studies.study import Draw, Save, Study
from percuss.web.code_text import python_text
from percuss.web.question import BadQuestion, motion_of

__all__ = ["FORMATS", "File", "file_of"]

# Of what the page follows anyway: a download waits, but not for ever.
MOST_IMPACTS = 200_000


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


def file_of(study: Study, extension: str) -> File:
    """Return a file of a motion.

    Parameters
    ----------
    study
        The motion.
    extension
        One of `FORMATS`; of anything but a motion one of `OF_ALL`.

    Returns
    -------
    File
        The file.

    Raises
    ------
    BadQuestion
        If there is no such format, or the motion has no impacts to list.
    """
    formats = tuple(FORMATS) if study.kind == "motion" else OF_ALL
    if extension not in formats:
        raise BadQuestion(f"{extension!r:.20} is none of {', '.join(formats)}")
    name, media_type, make = FORMATS[extension]
    return File(name.replace("motion", study.kind), media_type, make(study))


# What takes long to answer is computed where it is asked: of it there are the study and the code.
OF_ALL = ("toml", "py")
# matplotlib draws in one thread at a time.
_drawing = threading.Lock()


def _written(name: str) -> Callable[[Study], bytes]:
    """Return what makes one of the files that `percuss run` writes."""

    def make(study: Study) -> bytes:
        from percuss.studies.running import run_study

        suffix = Path(name).suffix
        motion = motion_of(study)
        limit = min(motion.limits.max_impacts or MOST_IMPACTS, MOST_IMPACTS)
        only = replace(
            study,
            question=replace(motion, limits=replace(motion.limits, max_impacts=limit)),
            save=Save(netcdf=suffix == ".nc", csv=suffix == ".csv"),
            draw=Draw(png=suffix == ".png", svg=suffix == ".svg"),
        )
        with _drawing, tempfile.TemporaryDirectory(prefix="percuss-") as folder:
            written = run_study(only, folder).files
            for file in written:
                if file.name == name:
                    return file.read_bytes()
        raise BadQuestion(f"this motion has no {name}")

    return make


FORMATS: dict[str, tuple[str, str, Callable[[Study], bytes]]] = {
    "png": ("motion.png", "image/png", _written("motion.png")),
    "svg": ("motion.svg", "image/svg+xml", _written("motion.svg")),
    "csv": ("impacts.csv", "text/csv; charset=utf-8", _written("impacts.csv")),
    "nc": ("motion.nc", "application/x-netcdf", _written("motion.nc")),
    "toml": ("study.toml", "application/toml", lambda study: study.text().encode()),
    "py": ("motion.py", "text/x-python; charset=utf-8", lambda study: python_text(study).encode()),
}
