from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from percuss.errors import ParameterError
from percuss.model import (
    Fault,
    Forcing,
    Harmonic,
    Oscillator,
    RestitutionTable,
    SoftStop,
    Start,
    Wall,
    draft,
    faults,
    impact_oscillator,
    sine,
    start_faults,
)

BELOW = Wall(0.0, "below")
ABOVE = Wall(1.0, "above")


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda: Wall(0.0, "below", 1.1),
            "restitution = 1.1: outside [0, 1]; above 1 an impact would create energy",
        ),
        (
            lambda: Wall(0.0, "below", -0.5),
            "restitution = -0.5: outside [0, 1]; below 0 the motion would pass through the wall",
        ),
        (lambda: Wall(0.0, "left"), 'side = \'left\': neither "above" nor "below"'),  # type: ignore[arg-type]
        (lambda: Wall(0.0, 1), "side = 1: neither"),  # type: ignore[arg-type]
        (lambda: Wall(math.nan, "below"), "at = nan: not finite"),
        (lambda: SoftStop(0.0, "below", math.inf), "stiffness = inf: not finite"),
        (
            lambda: SoftStop(0.0, "below", 1.0, -math.inf),
            "damping = -inf: not finite",
        ),
        (
            lambda: Oscillator(damping="-"),
            "damping = '-': not a number; give an int",
        ),
        (lambda: Oscillator(stiffness="soft"), "stiffness = 'soft': not a number; give an int"),
        (lambda: Oscillator(stops=BELOW), "stops = Wall("),  # type: ignore[arg-type]
        (lambda: Oscillator(stops=(0.0,)), "stops.0 = 0.0: neither a Wall nor a SoftStop"),  # type: ignore[arg-type]
        (
            lambda: Oscillator(stops=(BELOW, ABOVE, Wall(-1.0, "below"))),
            "stops.2.side = 'below': a second wall below; stops.0 at x = 0.0 is one, keep the inner",
        ),
        (
            lambda: Oscillator(stops=(ABOVE, Wall(2.0, "below"))),
            "stops.0.at = 1.0: not above the lower wall at x = 2.0; the walls leave no room",
        ),
        (
            lambda: Oscillator(stops=(ABOVE, Wall(1, "below"))),
            "stops.0.at = 1.0: not above the lower wall at x = 1; the walls leave no room",
        ),
        (
            lambda: Oscillator(stops=(BELOW, SoftStop(-0.5, "below", 3.0))),
            "stops.1.at = -0.5: behind the wall below at x = 0.0, where it would never act",
        ),
        (
            lambda: Oscillator(stops=(SoftStop("1", "above", 3.0), ABOVE)),
            "stops.0.at = '1': at the wall above at x = 1.0, where it would never act",
        ),
        (
            lambda: Oscillator(stops=(SoftStop(-1.0, "above", 3.0), BELOW)),
            "stops.0.at = -1.0: behind the wall below at x = 0.0, where it would always act",
        ),
        (
            lambda: Oscillator(stops=ABOVE),  # type: ignore[arg-type]
            "stops = Wall(at=1.0, side='above', restitution=1.0): not a sequence of stops; of one alone it is [stop]",
        ),
        (
            lambda: Oscillator.from_mass(2, 1, stops=ABOVE),  # type: ignore[arg-type]
            "stops = Wall(at=1.0, side='above', restitution=1.0): not a sequence of stops",
        ),
        (lambda: Harmonic(math.nan, 1.0), "amplitude = nan: not finite"),
        (lambda: Harmonic(1.0, 1.0, "right"), "phase = 'right': not a number"),
        (lambda: sine(1.0, phase=math.inf), "phase = inf: not finite"),
        (lambda: sine(1.0, constant=None), "constant = None: not a number"),  # type: ignore[arg-type]
        (lambda: Forcing(3.0), "harmonics = 3.0: not a tuple"),  # type: ignore[arg-type]
        (lambda: Start(0.0, math.nan), "v0 = nan: not finite"),
        (lambda: sine(1.0).per_mass(0), "mass = 0: not positive"),
    ],
)
def test_a_bad_value_is_refused_in_one_sentence_with_its_number(
    make: Callable[[], object], message: str
) -> None:
    with pytest.raises(ParameterError) as caught:
        make()

    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "stops",
    [
        (BELOW, ABOVE, SoftStop(0.5, "above", 2.0), SoftStop(0.5, "below", -2.0)),
        (SoftStop(0.5, "above", 2.0), SoftStop(0.7, "above", 2.0), SoftStop(0.9, "below", 0.0)),
        (Wall("0.1", "below", 0), Wall("0.2", "above", "1")),
    ],
)
def test_stops_that_fit_are_accepted(stops: tuple[Wall | SoftStop, ...]) -> None:
    assert faults(Oscillator(stops=stops)) == []


def test_a_draft_reports_all_its_faults_with_their_paths() -> None:
    wall = draft(Wall, at=math.inf, side="left", restitution=2.0)
    soft = draft(SoftStop, at=0.0, side="above", stiffness="x", damping="y")
    osc = draft(Oscillator, stiffness=math.nan, damping=math.inf, stops=[wall, soft, 3])
    force = draft(
        Forcing,
        harmonics=[draft(Harmonic, amplitude=True, omega=0.0, phase="north")],
        constant=None,
    )

    assert [fault.name for fault in faults(osc) + faults(force)] == [
        "oscillator.stiffness",
        "oscillator.damping",
        "oscillator.stops.0.at",
        "oscillator.stops.0.side",
        "oscillator.stops.0.restitution",
        "oscillator.stops.1.stiffness",
        "oscillator.stops.1.damping",
        "oscillator.stops.2",
        "forcing.constant",
        "forcing.harmonics.0.amplitude",
        "forcing.harmonics.0.omega",
        "forcing.harmonics.0.phase",
    ]


def test_a_draft_without_faults_is_the_value_itself() -> None:
    wall = draft(Wall, at=np.float64(0.0), side="below")

    assert draft(Oscillator, stops=[wall]) == impact_oscillator()
    assert draft(Forcing, harmonics=sine(2.0).harmonics, period="pi").period == math.pi


def test_a_draft_needs_the_fields_of_its_kind() -> None:
    with pytest.raises(TypeError, match="Wall needs side"):
        draft(Wall, at=0.0)
    with pytest.raises(TypeError, match="Wall has no stiffness"):
        draft(Wall, at=0.0, side="below", stiffness=1.0)


@pytest.mark.parametrize(
    ("limits", "messages"),
    [
        (
            {"x0": -0.1, "v0": 1.0, "t_end": 1.0},
            [
                "x0 = -0.1: below the wall at x = 0.0; start on its other side, or use a SoftStop, which can be entered"
            ],
        ),
        (
            {"x0": 1.5, "v0": 1.0, "t_end": 1.0},
            [
                "x0 = 1.5: above the wall at x = 1.0; start on its other side, or use a SoftStop, which can be entered"
            ],
        ),
        ({"x0": 0.5, "v0": 1.0, "t0": 10.0, "t_end": 0.0}, ["t_end = 0.0: not after t0 = 10.0"]),
        ({"x0": 0.5, "v0": 1.0, "t_end": 0}, ["t_end = 0: not after t0 = 0.0"]),
        (
            {"x0": 0.5, "v0": 1.0},
            ["t_end = None: no limit at all; give t_end, max_impacts or both"],
        ),
        ({"x0": 0.5, "v0": 1.0, "max_impacts": 0}, ["max_impacts = 0: not at least 1"]),
        (
            {"x0": 0.5, "v0": 1.0, "max_impacts": 2.5},
            ["max_impacts = 2.5: not a whole number of at least 1"],
        ),
        (
            {"x0": 0.5, "v0": 1.0, "max_impacts": True},
            ["max_impacts = True: not a whole number of at least 1"],
        ),
        (
            {"x0": math.nan, "v0": math.inf, "t0": "now", "t_end": math.inf},
            ["x0 = nan: not", "v0 = inf: not", "t0 = 'now': not", "t_end = inf: not finite"],
        ),
    ],
)
def test_all_faults_of_a_start_and_its_limits_are_found(
    limits: dict[str, Any], messages: list[str]
) -> None:
    problems = start_faults(Oscillator(stops=(BELOW, ABOVE)), **limits)

    assert len(problems) == len(messages)
    for fault, message in zip(problems, messages, strict=True):
        assert str(fault).startswith(message)


def test_a_start_on_a_wall_is_none_inside_it_however_both_are_written() -> None:
    """The double 0.2 is above 1/5, and still at the wall."""
    osc = impact_oscillator(wall="0.2", side="above")

    assert start_faults(osc, 0.2, np.float64(1.0), max_impacts=np.int64(3)) == []


def test_faults_of_a_study_carry_their_paths() -> None:
    problems = start_faults(impact_oscillator(), -1.0, 0.0, t_end=-1.0, start="start", run="run")

    assert [fault.name for fault in problems] == ["start.x0", "run.t_end"]


def test_all_faults_of_a_restitution_table_are_told_at_once() -> None:
    table = draft(RestitutionTable, speeds=(-1, "a", 3, 2, 5), values=("0.9", 0, 2))

    names = [fault.name for fault in faults(table, "r")]

    assert names == [
        "r.speeds.0",
        "r.speeds.1",
        "r.values.1",
        "r.values.2",
        "r.speeds.3",
        "r.values",
    ]


def test_only_parts_of_the_model_have_faults() -> None:
    with pytest.raises(TypeError, match="str is no part of the model"):
        faults("oscillator")


def test_a_fault_reads_like_the_error_it_becomes() -> None:
    fault = Fault("damping", -0.1, "negative")

    assert str(fault) == str(ParameterError(fault.name, fault.value, fault.reason))
