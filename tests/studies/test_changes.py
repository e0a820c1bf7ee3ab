"""Values of a study that are changed for one run."""

from __future__ import annotations

import pytest

import percuss as pc
from percuss.studies import Study, Sweep, parse_study

TEXT = """\
[oscillator]
damping = "0.1"
[[oscillator.stops]]
type = "wall"
at = 0
side = "below"
restitution = 0.8
[[forcing.harmonics]]
amplitude = 1
omega = "2.5"
[study]
kind = "sweep"
[over]
"forcing.omega" = {from = 2, to = 3, count = 11}
[sweep]
measure = "period"
"""


def changed(*changes: str) -> Study:
    return parse_study(TEXT, "study.toml", changes=changes)


def test_values_lists_and_tables_are_changed_and_others_stay() -> None:
    study = changed(
        "oscillator.damping=0.2",
        "oscillator.stops.0.restitution = 1/3",
        'over."forcing.omega".count=5',
        'forcing.harmonics.0 = {amplitude = 2, omega = "3"}',
        'sweep.measure = ["period", "mean_power"]',
        "study.title=a = b, c",
        "draw.png=false",
    )

    osc = study.oscillator
    assert (osc.damping, osc.stops[0].restitution) == (0.2, "1/3")
    assert study.forcing is not None
    assert study.forcing.frequency == 3.0
    assert isinstance(study.question, Sweep)
    assert study.question.measure == ("period", "mean_power")
    assert study.question.tables()["over"] == {"forcing.omega": {"from": 2, "to": 3, "count": 5}}
    assert (study.title, study.draw.png, study.draw.svg) == ("a = b, c", False, True)
    # The results hold what was computed.
    assert parse_study(study.text()) == study


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            "oscillator.stops.0.restitution=2",
            "study.toml: oscillator.stops.0.restitution = 2: outside [0, 1]; above 1 an impact",
        ),
        (
            "oscillator.dampnig=1",
            'study.toml: oscillator.dampnig: unknown key; did you mean "damping"?',
        ),
        (
            "oscillator.stops.1.at=1",
            "oscillator.stops.1: --set names an element that is not there; there is none beyond 0",
        ),
        (
            "stops.0.at=1",
            "stops: --set names an element of a list that is not there; there are oscillator, ",
        ),
        (
            "oscillator.stops.at=1",
            "oscillator.stops: --set names 'at' of a list; name an element first, by its number",
        ),
        (
            "oscillator.damping.x=1",
            'study.toml:2: oscillator.damping: --set names a key in what is no table but "0.1"',
        ),
        ("oscillator.damping", "--set oscillator.damping: not path=value, such as"),
        ("=1", "--set =1: not path=value, such as"),
    ],
)
def test_a_wrong_change_is_one_sentence(change: str, message: str) -> None:
    with pytest.raises(pc.StudyError) as error:
        changed(change)

    assert message in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("path", ['over."forcing.omega"', "over.forcing.omega"])
def test_a_key_of_the_file_that_has_dots_needs_no_quotes(path: str) -> None:
    study = changed(f"{path}.count=7")

    assert isinstance(study.question, Sweep)
    assert study.question.over["forcing.omega"].count == 7
    # The fault of a change is in no line of the file.
    with pytest.raises(
        pc.StudyError, match=r'^study\.toml: over\."?forcing\.omega"?\.count'
    ) as error:
        changed(f"{path}.count=1.5")
    assert "\n" not in str(error.value)
