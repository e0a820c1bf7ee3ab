"""Records in study files: samples in the study, or in a table beside it."""

from __future__ import annotations

import base64
import json
from pathlib import Path
from typing import Any

import pytest

import percuss as pc
from percuss.errors import StudyError
from percuss.io.exact_json import decoded, encoded
from percuss.model import ForceRecord
from percuss.model.paths import replace_parameter
from percuss.studies import load_study, parse_study
from percuss.studies.link import link_of
from percuss.studies.running import run_study

HEAD = '[oscillator]\nstiffness = 1\n[start]\nx0 = 0\nv0 = "0.5"\n[run]\nt_end = 5\n'
RECORD = "[forcing.record]\n"


def study_file(folder: Path, body: str, table: str | None = None) -> Path:
    if table is not None:
        (folder / "waves.csv").write_text(table, encoding="utf-8")
    path = folder / "s.toml"
    path.write_text(HEAD + RECORD + body, encoding="utf-8")
    return path


def test_a_table_beside_the_study_is_read_by_the_names_of_its_columns(tmp_path: Path) -> None:
    table = "# measured\n\ntime, height, force\n0, 9, 0.5\n1, 9, -1e-1\n\n2.5, 9, 0\n"
    body = 'file = "waves.csv"\ntime = "time"\nforce = "force"\namplitude = "0.1"\nkind = "hold"\n'
    study = load_study(study_file(tmp_path, body, table))
    assert study.forcing is not None
    assert study.forcing.record == ForceRecord(
        (0.0, 1.0, 2.5), (0.5, -0.1, 0.0), "hold", amplitude="0.1"
    )


def test_a_study_that_is_written_holds_its_samples(tmp_path: Path) -> None:
    study = load_study(study_file(tmp_path, 'file = "waves.csv"\n', "t,f\n0,1\n1,0.1\n"))
    again = parse_study(study.text())
    assert again.forcing == study.forcing
    wave = (
        't = [0, "pi", "2*pi"]\nf = [1, "-1/3", 1]\nkind = "hold"\nrepeat = true\nomega = "1.7"\n'
    )
    study = parse_study(HEAD + RECORD + wave)
    assert parse_study(study.text()).forcing == study.forcing
    assert study.forcing is not None
    assert decoded(json.loads(json.dumps(encoded(study.forcing)))) == study.forcing
    state = json.loads(base64.urlsafe_b64decode(link_of(study) + "=="))
    assert state["study"]["forcing"]["record"]["f"] == [1, "-1/3", 1]


def test_tables_of_spreadsheets_are_read_as_they_are_saved(tmp_path: Path) -> None:
    tables = {
        "semicolons": b"t;f\r\n0;0,5\r\n1,5;-1e-1\r\n",
        "tabs": b"t\tf\n0\t0.5\n1.5\t-0.1\n",
        "wide": "t;f\n0;0,5\n1,5;-0,1\n".encode("utf-16"),
        "logger": b"Logger 7;rev 2\n\nrate;2 Hz\nt;f\n0;0,5\n1,5;-0,1\n",
        "old": "# Höhe\nt,f\n0,0.5\n1.5,-0.1\n".encode("cp1252"),
    }
    for name, table in tables.items():
        path = study_file(tmp_path, 'file = "waves.csv"\n')
        (tmp_path / "waves.csv").write_bytes(table)
        study = load_study(path)
        assert study.forcing is not None, name
        assert study.forcing.record == ForceRecord((0.0, 1.5), (0.5, -0.1)), name


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("t,f\n0,0\n1,nan\n", ['line 3: f = "nan" is no finite number']),
        (
            "t,f\n0,0\n1,\n2\n",
            ['line 3: f = ""', "line 4: 1 cell between commas, where the names have 2"],
        ),
        ("t,f,t\n0,0,0\n1,1,1\n", ['"t" is the name of 2 columns']),
        (
            "Buoy;7\n\nZeit [s];Kraft [kN]\n0;1\n1;2\n",
            ['no column "t", "f"; its columns are Zeit [s], Kraft [kN]'],
        ),
        ("t,f\n0,0\n1,2\n1,3\n", ["line 4: t = 1.0 is there twice"]),
        ("t,f\n0,0\n2,2\n1,3\n", ["line 4: t = 1.0 comes after 2.0; instants must rise"]),
        ("time,f\n0,0\n", ['no column "t"; its columns are time, f']),
        ("t,f\n0,0\n", ["1 sample; a record needs two at least"]),
        ("", ['no column "t", "f"; it is empty']),
        ("t;force\n0;1\n1;2\n", ['no column "f"; its columns are t, force']),
        ("t;f\n0;1,5\n1;x\n", ['line 3: f = "x" is no finite number']),
        ("0,1\n1,2\n", ["its first line holds numbers; write the names above them"]),
        ("t,f\n2,0\n1,2\n0,3\n", ["the samples are in reverse order, the last one first"]),
        ("t,f\n" + "x,y\n" * 20, ["line 2: t", "line 6: f", "and 30 more"]),
    ],
)
def test_faults_of_a_table_are_told_by_its_lines_all_at_once(
    tmp_path: Path, table: str, words: list[str]
) -> None:
    with pytest.raises(StudyError) as error:
        load_study(study_file(tmp_path, 'file = "waves.csv"\n', table))
    assert len(error.value.faults) == 1
    assert '9: forcing.record.file = "waves.csv": ' in str(error.value)
    for word in words:
        assert word in str(error.value)


def test_nothing_is_said_of_the_lines_below_one_with_too_many_cells(tmp_path: Path) -> None:
    """They were not read, and were told to hold no numbers."""
    with pytest.raises(StudyError) as error:
        load_study(study_file(tmp_path, 'file = "waves.csv"\n', "t,f\n0,1\n1,3,4\n2,5\n"))
    assert str(error.value).endswith(
        "line 3: 3 cells between commas, where the names have 2; with decimal commas separate the "
        "columns with semicolons"
    )


@pytest.mark.parametrize(
    ("body", "fault"),
    [
        ('file = "none.csv"\n', '9: forcing.record.file = "none.csv": no such file or directory'),
        ("t = [0, 1]\n", "8: forcing.record.f: missing; give t and f, or a file"),
        ("t = [0, 1]\nf = [1]\n", "9: forcing.record.t = [0, 1]: 2 instants for 1 forces"),
        ("t = [0]\nf = [1]\n", "9: forcing.record.t = [0]: a record needs two samples at least"),
        ("t = [0, 1]\nf = [1, 2]\nkindd = 1\n", "11: forcing.record.kindd: unknown key; did you"),
        ("t = [0, 0]\nf = [1, 2]\n", "9: forcing.record.t.1 = 0: the instant of t.0, too"),
        ('file = "waves.csv"\nt = [0]\n', "10: forcing.record.t: given together with file"),
        ("t = [0, 1]\nf = [1, 2]\nomega = -1\n", "11: forcing.record.omega = -1: not positive"),
    ],
)
def test_faults_of_a_record_have_line_and_path(tmp_path: Path, body: str, fault: str) -> None:
    with pytest.raises(StudyError) as error:
        load_study(study_file(tmp_path, body, "t,f\n0,0\n1,1\n"))
    assert fault in str(error.value)


def test_a_text_without_a_place_has_no_tables_beside_it() -> None:
    with pytest.raises(StudyError, match="a study that is no file has no files beside it"):
        parse_study(HEAD + RECORD + 'file = "waves.csv"\n')


def test_a_study_under_a_record_runs_and_its_results_repeat_it(tmp_path: Path) -> None:
    table = "t,f\n0,0\n1,2\n3,-2\n5,0\n"
    study = load_study(study_file(tmp_path, 'file = "waves.csv"\n', table))
    run_study(study, tmp_path / "out")
    again = load_study(tmp_path / "out" / "motion.nc")
    assert again.forcing == study.forcing


def test_a_record_may_have_a_frequency_that_a_study_ranges_over() -> None:
    text = (
        '[study]\nkind = "diagram"\n[oscillator]\n[[oscillator.stops]]\ntype = "wall"\nat = 0\n'
        'side = "below"\n[forcing.record]\nt = [0, "pi", "2*pi"]\nf = [1, -1, 1]\nkind = "hold"\n'
        'repeat = true\nomega = 2\n[over]\n"forcing.record.omega" = {from = 2, to = 3, count = 5}\n'
    )
    assert parse_study(text).kind == "diagram"


def test_columns_with_units_are_converted_into_those_of_the_model(tmp_path: Path) -> None:
    units = 'units = {length = "m", time = "s", mass = "kg"}\n'
    head = HEAD.replace("stiffness = 1\n", f"stiffness = 1\nmass = 2\n{units}")
    path = tmp_path / "s.toml"

    def read(time: str, force: str, more: str = "", below: str = "") -> Any:
        table = f"{time};{force}\n{below}0;0,1\n3;2\n"
        (tmp_path / "waves.csv").write_text(table, encoding="utf-8")
        body = f'file = "waves.csv"\ntime = "{time}"\nforce = "{force}"\n{more}'
        path.write_text(head + RECORD + body, encoding="utf-8")
        forcing = load_study(path).forcing
        return None if forcing is None else forcing.record

    with pytest.raises(StudyError) as wrong:
        read("t (kg)", "f [m]")
    assert '"t (kg)": kg is no unit of time; "f [m]": m is no unit of force; give amplitude' in str(
        wrong.value
    )
    plain = read("t (s)", "f (N)")
    assert (plain.t, plain.f) == ((0.0, 3.0), (0.1, 2.0))
    found = read("t (ms)", "f (kN)", "amplitude = 2\n")
    assert (found.t, found.f, found.amplitude) == ((0.0, 0.003), (100.0, 2000.0), 2)
    assert read("t", "f", below="ms;kN\n") == read("t (ms)", "f (kN)")
    # Of waves the amplitude is the force of each metre.
    assert read("t (s)", "eta (m)", "amplitude = 20\n").f == (0.1, 2.0)
    with pytest.raises(
        StudyError, match="V is no unit of force; give amplitude, the force of each V"
    ):
        read("t (s)", "f (V)")
    # Of a wave the first column holds phases.
    assert read("t (rad)", "f (N)", "repeat = true\nomega = 2\n").t == (0.0, 3.0)
    # Taken as a force, an acceleration would be divided by the mass.
    with pytest.raises(StudyError, match="m/s2 is no unit of force; with per_mass = true it is an"):
        read("t (s)", "f (m/s2)")
    # A gram would be a thousandth of what an accelerometer means, with an amplitude too.
    for amplitude in ("", "amplitude = 9810\n"):
        with pytest.raises(
            StudyError, match="g may be the acceleration of gravity, which it is with"
        ):
            read("t (s)", "f (g)", amplitude)
    head += "[forcing]\nper_mass = true\n"
    assert read("t (s)", "f (mm/s2)").f == (0.0001, 0.002)
    assert read("t (s)", "f (g)").f == (0.980665, 19.6133)
    with pytest.raises(StudyError, match="N is no unit of acceleration; without per_mass it is a"):
        read("t (s)", "f (N)")
    head = HEAD
    with pytest.raises(StudyError, match="the model has no units to convert ms into"):
        read("t (ms)", "f (N)")


def test_a_column_is_named_with_its_unit_or_without(tmp_path: Path) -> None:
    table = "# buoy\nZeit [s];Kraft [N];Notiz\n0;0,5;\n1;1;an\n"
    for names in (("Zeit", "Kraft"), ("Zeit [s]", "Kraft [N]")):
        body = 'file = "waves.csv"\ntime = "{}"\nforce = "{}"\n'.format(*names)
        study = load_study(study_file(tmp_path, body, table))
        assert study.forcing is not None
        assert study.forcing.record == ForceRecord((0.0, 1.0), (0.5, 1.0))


def test_a_table_is_read_in_python_as_in_a_study(tmp_path: Path) -> None:
    file = tmp_path / "wave.csv"
    file.write_text("Buoy;7\n\nZeit [ms];Kraft [kN];eta (m)\n0;0,5;1\n500;1;2\n", encoding="utf-8")
    units = pc.Units("m", "s", "kg")

    force = pc.read_record(file, "Zeit", "Kraft", units=units, kind="hold", amplitude=2)
    assert force.record == ForceRecord((0.0, 0.5), (500.0, 1000.0), kind="hold", amplitude=2)
    waves = pc.read_record(file, "Zeit", "eta", units=units, amplitude="20e3")
    assert waves.record == ForceRecord((0.0, 0.5), (1.0, 2.0), amplitude=20e3)
    assert pc.read_record(file, "Zeit", "eta", units=units, amplitude=1, per_mass=True).is_per_mass
    ground = tmp_path / "ground.csv"
    ground.write_text("t (s);a (g)\n0;0,1\n1;0,2\n", encoding="utf-8")
    for per_mass in (False, True):
        with pytest.raises(pc.ParameterError, match="without units of the model nothing says"):
            pc.read_record(ground, "t", "a", per_mass=per_mass)
    with pytest.raises(pc.ParameterError, match=r"m is no unit of force; give amplitude"):
        pc.read_record(file, "Zeit", "eta", units=units)
    with pytest.raises(pc.ParameterError, match=r'no column "t", "f"; its columns are Zeit'):
        pc.read_record(file)


def test_the_height_of_a_sea_may_be_swept() -> None:
    text = HEAD.replace(
        "[start]", '[forcing.sea_state]\nhs = "h"\ntp = 9\namplitude = 20e3\n[start]'
    )
    study = parse_study("[parameters]\nh = 2\n" + text)
    assert study.forcing is not None
    _, doubled, _ = replace_parameter(study.oscillator, study.forcing, None, "h", 4)
    assert doubled is not None
    one, two = (force.harmonics[0].amplitude for force in (study.forcing, doubled))
    assert float(two) == pytest.approx(2 * float(one), rel=1e-14)
