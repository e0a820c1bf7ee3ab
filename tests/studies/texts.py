"""Study texts that tests share, and the faults of a text."""

from __future__ import annotations

import pytest

from percuss.errors import StudyError
from percuss.studies.kinds.motion import Motion
from percuss.studies.reading import parse_study
from percuss.studies.study import Study

HEAD = """\
[oscillator]
[start]
x0 = 0
v0 = 1
"""
RUN = "[run]\nt_end = 10\n"


def faults_of(text: str) -> list[str]:
    """Return the faults of a text, each as it is shown."""
    with pytest.raises(StudyError) as caught:
        parse_study(text, "s.toml")
    assert str(caught.value).splitlines() == [str(fault) for fault in caught.value.faults]
    return [str(fault) for fault in caught.value.faults]


def motion_of(study: Study) -> Motion:
    """Return what a study of a motion asks."""
    assert isinstance(study.question, Motion)
    return study.question


def end_of(study: Study) -> float | None:
    """Return the time at which the motion of a study ends."""
    return motion_of(study).t_end(study.forcing)
