"""Every fault of a study file is told with its line and path."""

from __future__ import annotations

import pytest
from tests.studies.texts import HEAD, RUN, faults_of

from percuss.errors import StudyError
from percuss.studies import StudyFault, parse_study

HARMONIC = "[[forcing.harmonics]]\namplitude = 1\nomega = 2.8\n"
TWO_HARMONICS = "".join(
    f"[[forcing.harmonics]]\namplitude = 1\nomega = {omega}\n" for omega in ('"4.2"', '"2.9"')
)


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        (
            HEAD.replace("[start]", "restitutoin = 1\n[start]") + RUN,
            (
                "s.toml:2: oscillator.restitutoin: unknown key; known here: "
                "stiffness, damping, mass, damping_coefficient, damping_ratio, units, stops"
            ),
        ),
        (
            HEAD.replace("[start]", "Stiffnes = 1\n[start]") + RUN,
            's.toml:2: oscillator.Stiffnes: unknown key; did you mean "stiffness"?',
        ),
        (
            'kind = "motion"\n' + HEAD + RUN,
            "s.toml:1: kind: unknown key; it belongs to the table [study]",
        ),
        (
            HEAD + RUN + "[oscilator]\n",
            's.toml:7: oscilator: unknown key; did you mean "oscillator"?',
        ),
        (
            HEAD + RUN + '[[oscillator.stops]]\ntype = "wall"\nat = 0\nside = "below"\n'
            "restitutoin = 1\n",
            's.toml:11: oscillator.stops.0.restitutoin: unknown key; did you mean "restitution"?',
        ),
        (
            HEAD + RUN + '[[oscillator.stops]]\ntype = "wall"\nat = 0\nside = "below"\n'
            "restitution = 1.1\n",
            (
                "s.toml:11: oscillator.stops.0.restitution = 1.1: outside [0, 1]; "
                "above 1 an impact would create energy"
            ),
        ),
        (
            HEAD + RUN + '[[oscillator.stops]]\ntype = "wal"\nat = 0\nside = "below"\n',
            's.toml:8: oscillator.stops.0.type = "wal": neither "wall" nor "soft"',
        ),
        (
            HEAD + RUN + '[[oscillator.stops]]\ntype = "soft"\nat = 0\nside = "below"\n',
            "s.toml:7: oscillator.stops.0.stiffness: missing",
        ),
        (
            HEAD + RUN + '[[oscillator.stops]]\ntype = "soft"\nat = 0\nside = "below"\n'
            'stiffness = 9\nrestitution = "0.5"\n',
            (
                "s.toml:12: oscillator.stops.0.restitution: unknown key; known here: "
                "type, at, side, stiffness, damping"
            ),
        ),
        (
            HEAD + RUN + "[oscillator.stops]\nat = 0\n",
            (
                "s.toml:7: oscillator.stops = {at = 0}: not a list; "
                "begin each of them with [[oscillator.stops]]"
            ),
        ),
        (
            HEAD.replace("v0 = 1", "v0 = true") + RUN,
            (
                's.toml:4: start.v0 = true: not a number; write 2.8, or "2.8" for that decimal, '
                '"1/3" for that fraction'
            ),
        ),
        (
            HEAD.replace("v0 = 1", 'v0 = "fast"') + RUN,
            (
                's.toml:4: start.v0 = "fast": not a number; write 2.8, or "2.8" for that decimal, '
                '"1/3" for that fraction'
            ),
        ),
        (HEAD.replace("v0 = 1", "v0 = nan") + RUN, "s.toml:4: start.v0 = nan: not finite"),
        # As the file has them, not as Python does.
        (
            HEAD + RUN + "[draw]\npng = 2026-11-27\n",
            "s.toml:8: draw.png = 2026-11-27: neither true nor false",
        ),
        (
            HEAD + RUN + '[[save]]\nnetcdf = true\ncsv = ["a"]\n',
            's.toml:7: save = [{netcdf = true, csv = ["a"]}]: not a table',
        ),
        (HEAD, "s.toml: run: missing; a table [run] is needed"),
        (HEAD + "[run]", "s.toml:5: run: missing a limit; give t_end, periods or max_impacts"),
        (HEAD + "[run]\nt_end = 0", "s.toml:6: run.t_end = 0: not after t0 = 0.0"),
        (
            HEAD + "[run]\nperiods = 1e308\n" + HARMONIC,
            (
                "s.toml:6: run.periods = 1e+308: the end is beyond the range of floats, 5e-324 "
                "to 1.8e308"
            ),
        ),
        (
            HEAD.replace("v0 = 1", "v0 = 1\nt0 = 1e308") + "[run]\nperiods = 3\n" + HARMONIC,
            "s.toml:7: run.periods = 3: the end is not after t0 = 1e+308",
        ),
        (
            HEAD + "[run]\nperiods = 3",
            "s.toml:6: run.periods = 3: without harmonics there is no period; give t_end",
        ),
        (
            HEAD + "[run]\nperiods = 3\n" + TWO_HARMONICS,
            (
                "s.toml:6: run.periods = 3: the forcing has no period; "
                'give forcing.period = "20*pi", or t_end instead'
            ),
        ),
        (
            HEAD + RUN + '[[forcing.harmonics]]\namplitude = 1\nomega = 3\nphase = "half"',
            (
                's.toml:10: forcing.harmonics.0.phase = "half": not a number; write 2.8, or "2.8" '
                'for that decimal, "1/3" for that fraction, "pi/2" for that multiple of pi'
            ),
        ),
        (
            HEAD.replace("[start]", "damping_ratio = 0.1\n[start]") + RUN,
            (
                "s.toml:2: oscillator.damping_ratio: needs oscillator.mass; "
                "mass = 1 leaves all else as it is"
            ),
        ),
        (
            HEAD.replace("[start]", "mass = 0\nstiffness = 1\n[start]") + RUN,
            "s.toml:2: oscillator.mass = 0: not positive",
        ),
        (
            HEAD.replace("[start]", "mass = 2\n[start]") + RUN,
            "s.toml:1: oscillator.stiffness: missing; with a mass it has no default",
        ),
        (
            HEAD.replace("[start]", "mass = 2\nstiffness = 1\ndamping = 1\n[start]") + RUN,
            (
                "s.toml:4: oscillator.damping = 1: given together with mass; "
                "give damping_coefficient or damping_ratio"
            ),
        ),
        (
            HEAD.replace(
                "[start]",
                "mass = 2\nstiffness = 1\ndamping_ratio = 1\ndamping_coefficient = 3\n[start]",
            )
            + RUN,
            (
                "s.toml:4: oscillator.damping_ratio = 1: "
                "given together with damping_coefficient = 3; give one"
            ),
        ),
        (
            HEAD.replace("[start]", "mass = 1e-60\nstiffness = 1e60\n[start]") + RUN,
            (
                "s.toml:2: oscillator.mass = 1e-60: after the division by it, "
                "oscillator.stiffness is not between 1e-70 and 1e+70; "
                "choose units in which it is nearer to 1"
            ),
        ),
        (
            HEAD + "[run]\nmax_impacts = 1.5",
            "s.toml:6: run.max_impacts = 1.5: not a whole number",
        ),
        (HEAD + "[run]\nmax_impacts = 0", "s.toml:6: run.max_impacts = 0: not at least 1"),
        (
            HEAD + RUN + "[forcing]\nomega = 1\ncos = [1]\nperiod = 3",
            "s.toml:10: forcing.period: given together with omega; omega, cos and sin stand alone",
        ),
        (
            HEAD + RUN + "[forcing]\ncos = [1]",
            "s.toml:7: forcing.omega: missing; cos and sin need the base frequency",
        ),
        (
            HEAD + RUN + "[forcing]\nomega = 1\ncos = [1, inf]",
            "s.toml:9: forcing.cos.1 = inf: not finite",
        ),
        (
            HEAD + RUN + "[draw]\nwindow = [3, 2]",
            "s.toml:8: draw.window = [3, 2]: the first time is not before the last",
        ),
        (
            HEAD + RUN + "[draw]\nwindow = [10, 12]",
            "s.toml:8: draw.window = [10, 12]: outside the run",
        ),
        (
            HEAD + RUN + "[draw]\nwindow = [3]",
            "s.toml:8: draw.window = [3]: 1 values; 2 are needed",
        ),
        (HEAD + RUN + "[save]\nsamples = 1", "s.toml:8: save.samples = 1: less than 2"),
        (
            HEAD + RUN + '[study]\nkind = "sweeep"',
            (
                's.toml:8: study.kind = "sweeep": did you mean "sweep"? There are motion, orbit, '
                "orbits, branch, curve, response, sweep, diagram, basins, lyapunov, design or fit"
            ),
        ),
        (HEAD + RUN + "x = ", 's.toml:7: invalid value: "x ="'),
        (
            HEAD + RUN + "x = below  # the wall",
            's.toml:7: invalid value: "x = below  # the wall"; put it in quotes: x = "below"',
        ),
        (
            HEAD + RUN + "x = 1/3",
            (
                "s.toml:7: expected newline or end of document after a statement: "
                '"x = 1/3"; put it in quotes: x = "1/3"'
            ),
        ),
        (HEAD + RUN + "x = True", 's.toml:7: invalid value: "x = True"'),
        (
            HEAD + RUN + 2 * "[oscillator.stops]\nat = 0\n",
            "s.toml:9: [oscillator.stops] twice; begin each of them with [[oscillator.stops]]",
        ),
        (HEAD + RUN + "[start]\n", "s.toml:7: [start] twice; put its keys under one"),
        (HEAD + "[run\n", "s.toml:5: expected ']' at the end of a table declaration: \"[run\""),
        ("a = " + 5000 * "[", "s.toml: lists or tables are nested too deeply"),
    ],
)
def test_one_fault_is_one_sentence_with_its_line_and_path(text: str, fault: str) -> None:
    assert faults_of(text) == [fault]


def test_all_faults_of_a_file_are_reported_at_once_in_the_order_of_lines() -> None:
    text = """\
[oscillator]
stifness = 1
damping = inf
stops = [
  {type = "wall", at = 0.5, side = "below", restitution = 2},
  {type = "spring", at = 1},
  {type = "soft", at = "here", side = "left"},
]
[[forcing.harmonics]]
amplitude = inf
omega = 0
phase = "pie"
[start]
x0 = -3
t0 = 10
[run]
t_end = 5
[draw]
png = "yes"
"""

    with pytest.raises(StudyError) as caught:
        parse_study(text)

    faults = [fault for fault in caught.value.faults if isinstance(fault, StudyFault)]
    places = [(fault.line, fault.path) for fault in faults]
    assert places == [
        (2, "oscillator.stifness"),
        (3, "oscillator.damping"),
        (5, "oscillator.stops.0.restitution"),
        (6, "oscillator.stops.1.type"),
        (7, "oscillator.stops.2.at"),
        (7, "oscillator.stops.2.side"),
        (7, "oscillator.stops.2.stiffness"),
        (10, "forcing.harmonics.0.amplitude"),
        (11, "forcing.harmonics.0.omega"),
        (12, "forcing.harmonics.0.phase"),
        (14, "start.x0"),
        (17, "run.t_end"),
        (19, "draw.png"),
    ]


def test_faults_of_the_syntax_do_not_hide_the_others() -> None:
    text = HEAD.replace("x0 = 0", "x0 = 0 0").replace("v0 = 1", "v0 = 1\nv0 = 2")
    text += "[run]\nt_end = -5\n"

    assert faults_of(text) == [
        's.toml:3: expected newline or end of document after a statement: "x0 = 0 0"',
        's.toml:5: cannot overwrite a value: "v0 = 2"',
        "s.toml:7: run.t_end = -5: not after t0 = 0.0",
    ]


def test_what_may_follow_from_a_line_that_is_not_read_is_not_told() -> None:
    text = HEAD.replace("[start]", "damping_coefficient = 3\nmass = 2,5\n[start]") + RUN

    assert faults_of(text) == [
        's.toml:3: expected newline or end of document after a statement: "mass = 2,5"'
    ]


def test_a_start_is_checked_against_the_walls_that_are_right() -> None:
    text = HEAD.replace("x0 = 0", "x0 = 3") + RUN
    text += '[[oscillator.stops]]\ntype = "wall"\nat = 2\nside = "above"\nrestitution = 7\n'

    assert [fault.split(": ")[1] for fault in faults_of(text)] == [
        "start.x0 = 3",
        "oscillator.stops.0.restitution = 7",
    ]


UNITS = "[oscillator]\nmass = 2\nstiffness = 1\nunits = {units}\n[start]\nx0 = 0\nv0 = 1\n[run]\nt_end = 1\n"


@pytest.mark.parametrize(
    ("units", "fault"),
    [
        ('{length = "s", mass = "kg"}', 'units.length = "s": a unit of time, not of length'),
        ('{lenght = "m", mass = "kg"}', 'units.lenght: unknown key; did you mean "length"?'),
        ('{length = "m"}', "units.mass: missing; the oscillator has a mass"),
        ('{length = 1, mass = "kg"}', "units.length = 1: not a text; put it in quotes"),
    ],
)
def test_units_that_do_not_fit_are_faults_of_a_line(units: str, fault: str) -> None:
    assert faults_of(UNITS.format(units=units)) == [f"s.toml:4: oscillator.{fault}"]


def test_units_of_pictures_are_those_of_the_oscillator() -> None:
    text = UNITS.format(units='{length = "m", time = "s", mass = "kg"}')
    drawn = f'{text}[draw]\nlength_unit = "mm"\ntime_unit = "kg"\n'

    assert faults_of(drawn) == [
        's.toml:11: draw.length_unit = "mm": oscillator.units says m',
        's.toml:12: draw.time_unit = "kg": a unit of mass, not of time',
    ]
