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

# An oscillator with a wall above it, and its force.
WALL_ABOVE = """\
[oscillator]
damping = "0.05"
[[oscillator.stops]]
type = "wall"
at = 1
side = "above"
restitution = "0.8"
[[forcing.harmonics]]
amplitude = 1
omega = 1
"""
# An oscillator with a wall at 0 below it, and its force.
WALL_BELOW = """\
[[oscillator.stops]]
type = "wall"
at = 0
side = "below"
restitution = "{restitution}"
[[forcing.harmonics]]
amplitude = 1
omega = "{omega}"
"""
# A motion above a wall up to t = 30.
MOTION_TO_30 = f"""\
{WALL_BELOW.format(restitution="0.5", omega="0.5")}\
[start]
x0 = 1
v0 = 0
[run]
t_end = 30
[draw]
png = false
"""


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
