"""Every fault of a table of some kind of study is told with its line and path."""

from __future__ import annotations

import pytest
from tests.studies.texts import faults_of

from percuss.errors import StudyError
from percuss.studies.reading import parse_study

MODEL = """\
[oscillator]
damping = "0.05"
[[oscillator.stops]]
type = "wall"
at = 1
side = "above"
[[forcing.harmonics]]
amplitude = 1
omega = 1
"""
WRITE = 'not a number; write 2.8, or "2.8" for that decimal, "1/3" for that fraction'
PHASE = f'{WRITE}, "pi/2" for that multiple of pi'
SPAN = "write {from = 2, to = 3, count = 101}"


def text_of(kind: str, own: str, model: str = MODEL) -> str:
    return f'{model}[study]\nkind = "{kind}"\n{own}'


@pytest.mark.parametrize(
    ("kind", "own", "fault"),
    [
        ("branch", "", "s.toml: over: missing; a table [over] is needed"),
        ("branch", "[over]", "s.toml:12: over: 0 parameters; one is needed"),
        (
            "branch",
            '[over]\n"forcing.amplitud" = [1, 2]',
            (
                "s.toml:13: over.forcing.amplitud: no such parameter; did you mean "
                "forcing.amplitude or forcing.period or forcing.harmonics.0.amplitude?"
            ),
        ),
        (
            "branch",
            '[over]\n"forcing.amplitude" = [2, 3]',
            (
                "s.toml:13: over.forcing.amplitude = [2, 3]: does not hold the model's own value 1, "
                "where the branch begins"
            ),
        ),
        (
            "branch",
            '[over]\n"forcing.amplitude" = [1, 1]',
            "s.toml:13: over.forcing.amplitude = [1, 1]: an empty range",
        ),
        (
            "branch",
            '[over]\n"forcing.amplitude" = 3',
            "s.toml:13: over.forcing.amplitude = 3: not a range; write [first, last]",
        ),
        (
            "branch",
            '[over]\n"forcing.amplitude" = {}',
            "s.toml:13: over.forcing.amplitude = {}: not a range; write [first, last]",
        ),
        (
            "branch",
            '[over]\n"forcing.amplitude" = ["a", 1]',
            f's.toml:13: over.forcing.amplitude.0 = "a": {PHASE}',
        ),
        (
            "branch",
            '[over]\n"oscillator.stops.0.restitution" = [\n -1,\n 1]',
            (
                "s.toml:14: over.oscillator.stops.0.restitution.0 = -1: outside [0, 1]; below 0 the "
                "motion would pass through the wall"
            ),
        ),
        (
            "branch",
            '[over]\n"forcing.amplitude" = [0, 1]\n"forcing.omega" = [0.5, 1]',
            "s.toml:12: over: 2 parameters; one is needed",
        ),
        (
            "branch",
            '[over]\n"forcing.amplitude" = [0, 1]\n[run]\nt_end = 4',
            (
                "s.toml:14: run: no table of this kind of study; its tables are study, oscillator, "
                "forcing, save, draw, orbit, over, branch, certify, parameters"
            ),
        ),
        (
            "branch",
            '[over]\n"forcing.amplitude" = [0, 1]\n[branch]\nlargest_step = 2',
            "s.toml:15: branch.largest_step = 2: more than 1.0",
        ),
        (
            "orbit",
            "[orbit]\nimpacts = 1.5",
            's.toml:13: orbit.impacts = 1.5: neither a whole number nor "inf", for sticking',
        ),
        (
            "orbit",
            "[orbit]\nimpacts = 2\nsequence = [0]",
            "s.toml:14: orbit.sequence = [0]: not one stop for each of the 2 impacts",
        ),
        (
            "orbit",
            "[orbit]\nsequence = [1]",
            "s.toml:13: orbit.sequence = [1]: the oscillator has 1 stop, counted from 0",
        ),
        (
            "orbit",
            "[orbit]\ncycle = 0.3",
            "s.toml:12: orbit.v_after: missing; a guess is a cycle and a v_after, and cycle is given",
        ),
        (
            "curve",
            '[over]\n"forcing.amplitude" = [0, 1]\n"forcing.omega" = [0, 1]\n[curve]\nalong = "x"',
            (
                "s.toml:14: over.forcing.omega.0 = 0: not positive; "
                "a part of zero frequency is the constant"
            ),
        ),
        (
            "curve",
            (
                '[over]\n"forcing.amplitude" = [0, 1]\n"forcing.omega" = ["1/2", 1]\n'
                '[curve]\nalong = "forcing.phase"'
            ),
            (
                's.toml:16: curve.along = "forcing.phase": not one of the parameters in [over], '
                "forcing.amplitude and forcing.omega"
            ),
        ),
        (
            "sweep",
            '[sweep]\nmeasure = "perod"\n[over]\n"start.x0" = [0]',
            (
                's.toml:13: sweep.measure = "perod": did you mean "period"? There are '
                "peak_displacement, min_displacement, max_displacement, peak_impact_velocity, "
                "impacts_per_period, period, dissipated_energy, peak_stop_force, peak_acceleration, "
                "rms_displacement, contact_share, mean_power, largest_lyapunov_exponent or "
                "growth_exponent"
            ),
        ),
        (
            "sweep",
            '[sweep]\nmeasure = "period"\n[over]\n"start.x0" = []',
            "s.toml:15: over.start.x0 = []: an axis without values",
        ),
        (
            "sweep",
            '[sweep]\nmeasure = "period"\n[over]\n"start.x0" = {from = 0, count = 3}',
            f"s.toml:15: over.start.x0.to: missing; {SPAN}",
        ),
        (
            "sweep",
            '[sweep]\nmeasure = "period"\n[over]\n"forcing.omega" = {from = 1, to = 1, count = 3}',
            "s.toml:15: over.forcing.omega: an empty range: from and to are the same",
        ),
        (
            "sweep",
            '[sweep]\nmeasure = "period"\n[over]\n"forcing.omega" = {from = 1, to = 2, count = 1}',
            "s.toml:15: over.forcing.omega.count = 1: not from 2 to 100000000",
        ),
        (
            "sweep",
            (
                '[sweep]\nmeasure = "period"\n[over]\n'
                '"start.v0" = {from = -1, to = 2, count = 3, spacing = "log"}'
            ),
            's.toml:15: over.start.v0.spacing = "log": of values that are not all positive',
        ),
        (
            "sweep",
            (
                '[sweep]\nmeasure = "period"\npaired = true\n[over]\n'
                '"start.v0" = [1, 2]\n"forcing.omega" = {from = 1, to = 2, count = 3}'
            ),
            (
                "s.toml:17: over.forcing.omega: 3 values, and start.v0 has 2; paired, "
                "each has as many"
            ),
        ),
        (
            "sweep",
            (
                '[sweep]\nmeasure = "period"\n[over]\n'
                '"oscillator.stops.0.restitution" = {from = "1/2", to = "3/2", count = 11}'
            ),
            (
                's.toml:15: over.oscillator.stops.0.restitution = "11/10": outside [0, 1]; '
                "above 1 an impact would create energy"
            ),
        ),
        (
            "diagram",
            '[diagram]\nstarts = [[0, 0],\n [2, 0]]\n[over]\n"forcing.omega" = [1, 2]',
            (
                "s.toml:14: diagram.starts.1.0 = 2: above the wall at x = 1; "
                "start on its other side, or use a SoftStop, which can be entered"
            ),
        ),
        (
            "basins",
            "[basins]",
            "s.toml:12: basins: missing; give x0 and v0, or cycle and v of impacts",
        ),
        ("basins", "[basins]\nx0 = [1]", "s.toml:12: basins.v0: missing"),
        (
            "basins",
            "[basins]\nx0 = [1]\nv0 = [0]\ncycle = [0]",
            "s.toml:15: basins.cycle: given together with x0 or v0; give x0 and v0, or these",
        ),
        (
            "basins",
            "[basins]\ncycle = [1]\nv = [0]",
            "s.toml:13: basins.cycle: not all in [0, 1)",
        ),
        (
            "basins",
            "[basins]\nx0 = 4\nv0 = [0]",
            (
                "s.toml:13: basins.x0 = 4: neither a list of values nor {from = 2, to = 3, count = 101}"
            ),
        ),
        ("lyapunov", "[lyapunov]\nperiods = 3", "s.toml:13: lyapunov.periods = 3: less than 64"),
        ("orbits", "[orbits]\neffort = 0.05", "s.toml:13: orbits.effort = 0.05: less than 0.1"),
    ],
)
def test_one_fault_is_one_sentence_with_its_line_and_path(kind: str, own: str, fault: str) -> None:
    assert faults_of(text_of(kind, own)) == [fault]


def test_all_faults_of_tables_and_model_are_reported_at_once() -> None:
    own = """\
[sweep]
measure = ["period", "speed"]
periods = 0
[start]
x0 = 3
v0 = "fast"
[over]
"oscillator.stops.0.rest" = [1]
"forcing.omega" = {from = nan, to = 2, count = 3}
"""
    paths = [
        fault.split(":")[2].split(" =")[0].strip() for fault in faults_of(text_of("sweep", own))
    ]

    # Which parameters there are is not asked of a model with faults; of this one it is.
    assert paths == [
        "sweep.measure.1",
        "sweep.periods",
        "start.x0",
        "start.v0",
        "over.oscillator.stops.0.rest",
        "over.forcing.omega.from",
    ]


@pytest.mark.parametrize("kind", ["orbits", "response", "diagram", "basins", "lyapunov"])
def test_a_kind_that_counts_in_periods_says_so_where_there_is_none(kind: str) -> None:
    free = MODEL.split("[[forcing", maxsplit=1)[0]
    two = MODEL + '[[forcing.harmonics]]\namplitude = 1\nomega = "1.1"\n'

    models = {"forcing: missing harmonics": free, "forcing.period: missing": two}
    if kind == "lyapunov":
        # Without a forcing exponents are taken over natural periods.
        parse_study(text_of(kind, "", models.pop("forcing: missing harmonics")))
    for path, model in models.items():
        with pytest.raises(StudyError) as caught:
            parse_study(text_of(kind, "", model))
        assert any(path in str(fault) for fault in caught.value.faults)


def test_paths_may_stand_without_quotes() -> None:
    quoted = text_of("branch", '[over]\n"forcing.amplitude" = [0, 1]')
    bare = text_of("branch", "[over]\nforcing.amplitude = [0, 1]")

    assert parse_study(bare) == parse_study(quoted)


@pytest.mark.parametrize("given", ["x0", "v0"])
def test_what_a_start_leaves_out_is_zero(given: str) -> None:
    text = text_of("motion", f'[start]\n{given} = "1/4"\n[run]\nt_end = 1')

    start = parse_study(text).question.start  # type: ignore[attr-defined]
    assert (start.x0, start.v0) == (("1/4", 0) if given == "x0" else (0, "1/4"))


def test_a_start_that_is_left_out_must_be_one() -> None:
    model = MODEL.replace("at = 1", "at = -1")
    own = '[sweep]\nmeasure = "period"\n[over]\n"forcing.omega" = [1]'

    (fault,) = faults_of(text_of("sweep", own, model))
    assert fault.startswith(
        "s.toml: start: missing; the default x0 = 0 lies above the wall at x = -1"
    )


@pytest.mark.parametrize(
    ("right", "wrong", "path"),
    [
        ('damping = "0.05"', "damping = 1e200", "forcing.omgea"),
        ('damping = "0.05"', "damping = 1e200", "oscillator.dampin"),
        ("omega = 1", "omega = 0", "forcing.omgea"),
        ("at = 1", 'at = "x"', "oscillator.stops.0.att"),
    ],
)
def test_a_wrong_path_is_reported_with_a_wrong_value_of_the_model(
    right: str, wrong: str, path: str
) -> None:
    own = f'[over]\n"{path}" = [1, 2]\n[sweep]\nmeasure = "period"\n'

    faults = faults_of(text_of("sweep", own, MODEL.replace(right, wrong)))

    assert len(faults) == 2
    assert f"over.{path}: no such parameter; did you mean" in faults[1]


def test_where_the_stops_are_unclear_no_path_of_them_is_called_wrong() -> None:
    own = '[over]\n"oscillator.stops.0.stiffness" = [1, 2]\n[sweep]\nmeasure = "period"\n'

    (fault,) = faults_of(text_of("sweep", own, MODEL.replace('"wall"', '"sfot"')))

    assert "oscillator.stops.0.type" in fault


FREE = "[oscillator]\n[[forcing.harmonics]]\namplitude = 1\nomega = 1\n"


@pytest.mark.parametrize("measure", ["3", "true", "{}", "[1]"])
def test_a_measure_that_is_no_text_is_one_fault(measure: str) -> None:
    text = f'[study]\nkind = "sweep"\n{FREE}[over]\n"forcing.omega" = [1, 2]\n[sweep]\n'

    (fault,) = faults_of(f"{text}measure = {measure}\n")

    assert fault.startswith("s.toml:10: sweep.measure")
    assert "not a " in fault


def test_a_misspelt_type_of_a_stop_is_named() -> None:
    text = f'{FREE}[[oscillator.stops]]\ntpye = "wall"\nat = 0\nside = "below"\n'

    assert faults_of(f"{text}[start]\nx0 = 1\nv0 = 0\n[run]\nt_end = 1\n") == [
        's.toml:5: oscillator.stops.0.type: missing; "wall" or "soft"',
        's.toml:6: oscillator.stops.0.tpye: unknown key; did you mean "type"?',
    ]


def test_a_fault_stays_on_one_line_whatever_the_key_and_however_long_the_value() -> None:
    kind = "a" * 5000

    faults = faults_of(f'[study]\nkind = "{kind}"\n"ti\\ntle" = 1\n{FREE}')

    assert all(len(fault) < 300 for fault in faults)
    assert any(r"study.ti\ntle: unknown key" in fault for fault in faults)


def test_a_step_in_quotes_is_to_be_written_without() -> None:
    text = f'[study]\nkind = "branch"\n{FREE}[over]\n"forcing.omega" = [1, 2]\n[branch]\n'

    assert 's.toml:10: branch.largest_step = "0.1": not a number; write 2.8, without quotes' in (
        faults_of(f'{text}largest_step = "0.1"\n')
    )
