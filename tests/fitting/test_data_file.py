"""Files of measurements as loggers and spreadsheets write them, and the sentences about their faults."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import percuss as pc
from percuss.fitting.data_file import columns_of_file, columns_of_text, forces_of_text
from percuss.model.units import Units

SI = Units("m", "s", "kg")


def read(text: str, units: Units | None = SI, **names: str) -> dict[str, list[float]]:
    found = columns_of_text(text, units, names)
    return {name: values.tolist() for name, values in found.items()}


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("t,displacement\n0,1\n0.5,2\n", {"t": [0, 0.5], "displacement": [1, 2]}),
        ("Time;Position\n0;1,5\n0,5;-2e-1\n", {"t": [0, 0.5], "displacement": [1.5, -0.2]}),
        ("t\tx\tv\n0\t1\t2\n", {"t": [0], "displacement": [1], "velocity": [2]}),
        ("t  x\n 0   1\n 1e0 2\n", {"t": [0, 1], "displacement": [1, 2]}),
        ("Time (ms),x [mm]\n1,2\n", {"t": [0.001], "displacement": [0.002]}),
        ("t / ms,v / mm/s\n1,2\n", {"t": [0.001], "velocity": [0.002]}),
        ('"Time, us","a_mm/s²"\n1,2\n', {"t": [1e-6], "acceleration": [0.002]}),
        ("t_ms,x_mm\n1,2\n", {"t": [0.001], "displacement": [0.002]}),
        ("t [min],a [g]\n1,2\n", {"t": [60], "acceleration": [2 * 9.80665]}),
        ("t [s],stop_force_1 (kN)\n1,2\n", {"t": [1], "stop_force_1": [2000]}),
        ("t,x\n[ms],[um]\n1,2\n", {"t": [0.001], "displacement": [2e-6]}),
        (
            "Logger 3000, serial 12\nRate: 100 Hz\n\nt,x\ns,in\n# a note\n1,2\n\n",
            {"t": [1], "displacement": [0.0508]},
        ),
        ("n,t,temperature,x\n0,1,20,3\n", {"t": [1], "displacement": [3]}),
        ("Impact times [ms]\n1\n2\n", {"impact_times": [0.001, 0.002]}),
        ("t,x,noise\n1,2,0.1\n", {"t": [1], "displacement": [2], "noise": [0.1]}),
        ('"t";"x"\n"0";"1,5"\n', {"t": [0], "displacement": [1.5]}),
        ("t,x,\n0,1,\n1,2,\n", {"t": [0, 1], "displacement": [1, 2]}),
        ("t;x\n\u22121;\u22120,5\n", {"t": [-1], "displacement": [-0.5]}),
    ],
)
def test_forms_of_tables(text: str, found: dict[str, list[float]]) -> None:
    assert read(text) == found


@pytest.mark.parametrize("cell", ["", "NaN", "n/a", "-", "#N/A"])
def test_cells_without_a_number_are_missing_values(cell: str) -> None:
    values = read(f"t,x\n0,1\n1,{cell}\n")["displacement"]
    assert values[0] == 1
    assert math.isnan(values[1])


def test_units_are_those_of_the_model() -> None:
    text = "t [ms],x [mm],v [m/s]\n1,2,3\n"
    assert read(text, Units("mm", "ms")) == {"t": [1], "displacement": [2], "velocity": [3]}
    assert read(text, Units("um", "s"))["displacement"] == [2000]
    # Without units of the model SI is taken as it is, as are units that say nothing.
    assert read("t [s],x [m],v [-]\n1,2,3\n", None)["velocity"] == [3]


def test_columns_may_be_named() -> None:
    names = {"t": "Zeit", "displacement": "Weg (mm)", "velocity": "v2"}
    text = "Zeit;Weg (mm);v;v2\n1;2;3;4\n"
    assert read(text, SI, **names) == {"t": [1], "displacement": [0.002], "velocity": [4]}
    assert read(text, SI, **(names | {"displacement": "Weg"})) == read(text, SI, **names)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", ["the file is empty"]),
        ("t,x\n", ["no line of values under a line of names"]),
        ("0,1\n1,2\n", ["its first line holds numbers; write the names above them"]),
        ("height,temperature\n0,1\n", ["no column t and one of displacement, velo", "its columns"]),
        ("time,hight\n0,1\n", ["no column of displacement, velocity", "time, hight"]),
        ("x,v\n0,1\n", ["no column of instants, t or time; its columns are x, v"]),
        ("t,x,position\n0,1,2\n", ['"x" and "position" are both displacement; keep one of them']),
        ("t,x,velocty\n0,1,2\n", ['column "velocty": did you mean "velocity"?']),
        ("t,x\n0,far\n1,inf\n2\n", ['line 2: x = "far" is no finite', "line 3:", "line 4: 1 cell"]),
        ("t,x\n0,1_0\n1,\uff11\n", ['x = "1_0" is no finite', 'x = "\uff11" is no finite number']),
        ("t,x\n0,1\n,2\n", ["line 3: a value without its instant"]),
        ("t,x\n0,1,0,5\n1,0,2,0\n", ["line 2: 4 cells between commas, where the names have 2"]),
        # 0 and 1.5, of a logger with decimal commas: 1 was read.
        ("t,x\n0,1,5\n1,2,5\n", ["line 2: 3 cells between commas", "with decimal commas sep"]),
        (
            't,x\n"0","1"\n"0,5","2"\n',
            [
                'line 3: t = "0,5" is no finite number; with decimal commas separate the columns with'
            ],
        ),
        ("t;x\n0;1\n1;2;5\n", ["line 3: 3 cells between semicolons, where the names have 2"]),
        ("t,x\n" + "a,b\n" * 20, ["line 2: t", "line 6: x", "and 30 more"]),
        ("t [m],x\n0,1\n", ['"t [m]": m is no unit of time']),
        ("t,x [V]\n0,1\n", ['"x [V]": no unit that percuss knows']),
    ],
)
def test_faults_are_told_by_lines_all_at_once(text: str, words: list[str]) -> None:
    with pytest.raises(ValueError, match=r".") as reported:
        read(text)
    for word in words:
        assert word in str(reported.value)


def test_units_without_those_of_a_model_are_refused() -> None:
    with pytest.raises(ValueError, match=r'"t \[ms\]": the model has no units to convert ms into'):
        read("t [ms],x\n0,1\n", None)
    with pytest.raises(ValueError, match="mm cannot be converted for the model's unit d"):
        read("t,x [mm]\n0,1\n", Units("d", "s"))
    with pytest.raises(ValueError, match="N cannot be converted for a model without all of its"):
        read("t,stop_force [N]\n0,1\n", Units("m", "s"))


def test_a_name_that_is_not_there_is_told_with_what_resembles_it() -> None:
    with pytest.raises(ValueError, match='no column "Wegg"; did you mean "Weg"'):
        read("t,Weg\n0,1\n", displacement="Wegg")


def test_encodings_of_spreadsheets_and_files_that_are_no_text(tmp_path: Path) -> None:
    path = tmp_path / "rig.csv"
    text = "t (µs);x (µm)\n1;2,5\n"
    for encoding in ("utf-8", "utf-8-sig", "utf-16", "cp1252"):
        path.write_bytes(text.encode(encoding))
        found = columns_of_file(path, Units("mm", "ms"))
        assert {name: values.tolist() for name, values in found.items()} == {
            "t": [0.001],
            "displacement": [0.0025],
        }
    path.write_bytes(b"PK\x03\x04\0\0t,x\n")
    with pytest.raises(ValueError, match="no text, but a binary file; save it as CSV"):
        columns_of_file(path)


def test_a_fit_takes_a_file_in_the_units_of_its_oscillator(tmp_path: Path) -> None:
    import numpy as np

    t = np.linspace(0, 6, 60)
    rows = "".join(f"{1000 * a!r};{2000 * math.cos(a)!r}\n" for a in t.tolist())
    path = tmp_path / "rig.csv"
    path.write_text("t [ms];x [mm]\n" + rows.replace(".", ","), encoding="utf-8")

    osc = pc.Oscillator(units=Units("m", "s"))
    fit = pc.fit(path, osc, free={"oscillator.stiffness": 1.3})

    assert fit.values["oscillator.stiffness"] == pytest.approx(1, abs=1e-9)
    assert fit(0.0)[0] == pytest.approx(2, abs=1e-9)


@pytest.mark.parametrize(
    ("head", "time", "force"),
    [
        ("t_ms;f_kN", "t_ms", "f_kN"),
        ("t_ms;f_kN", "t", "f"),
        ("Time / ms;Force / kN", "Time", "Force"),
        ("Zeit / ms;Kraft / kN", "Zeit / ms", "Kraft / kN"),
        ("Zeit in ms;Kraft in kN", "Zeit", "Kraft"),
        ("t, ms;f, kN", "t, ms", "f, kN"),
        ("Time ms;Force kN", "Time", "Force"),
    ],
)
def test_a_record_is_converted_however_its_heads_name_the_units(
    head: str, time: str, force: str
) -> None:
    t, f = forces_of_text(f"{head}\n0;1\n10;2\n", SI, time, force, quantity="force")
    assert (t.tolist(), f.tolist()) == ([0.0, 0.01], [1000.0, 2000.0])


def test_an_elevation_with_an_amplitude_is_converted_too() -> None:
    text = "t [s];eta [mm]\n0;1\n50;2\n"
    t, eta = forces_of_text(text, SI, "t", "eta", quantity="force", has_amplitude=True)
    assert (t.tolist(), eta.tolist()) == ([0.0, 50.0], [0.001, 0.002])
    with pytest.raises(ValueError, match=r"give amplitude, the force of each m$"):
        forces_of_text(text, SI, "t", "eta", quantity="force")
    with pytest.raises(ValueError, match='did you mean "kN"'):
        forces_of_text("t;f [KN]\n0;1\n1;2\n", SI, quantity="force")


@pytest.mark.parametrize(
    "cells", ["0,0;1.234\n50,0;2.000", "0;1.234,5\n50;2.000,0", "0;1,234.5\n5;1,5"]
)
def test_marks_of_thousands_are_refused_not_taken_for_decimals(cells: str) -> None:
    with pytest.raises(ValueError, match=r"line 2: f .* remove marks of thousands"):
        forces_of_text(f"t;f\n{cells}\n")


def test_a_blank_in_a_name_separates_nothing_where_semicolons_do() -> None:
    with pytest.raises(ValueError, match=r"its columns are Zeit, Weg x$"):
        columns_of_text("Zeit;Weg x\n0;1,5\n1;2\n")
    found = columns_of_text(
        "Zeit;Weg x\n0;1,5\n1;2\n", None, {"t": "Zeit", "displacement": "Weg x"}
    )
    assert found["displacement"].tolist() == [1.5, 2.0]


def test_an_instant_that_is_there_twice_is_told_once() -> None:
    text = "t;f;x\n0;1;1\n1;2;2\n1;3;3\n"
    with pytest.raises(ValueError, match=r"^line 4: t = 1.0 is there twice; instants must rise$"):
        forces_of_text(text)
    with pytest.raises(ValueError, match=r"^line 4: the instant 1 of line 3 is there again$"):
        columns_of_text(text)


def test_one_column_is_not_named_for_two_quantities() -> None:
    with pytest.raises(ValueError, match=r'^"x" is named for displacement and velocity$'):
        columns_of_text("t,x\n0,1\n", columns={"displacement": "x", "velocity": "x"})


@pytest.mark.parametrize(
    ("head", "name", "value"),
    [
        ("Tip (m/s2)", "acceleration_tip", 2000),
        ("Tip (g)", "acceleration_tip", 2 * 9806.65),
        ("Laser, um", "displacement_2", 0.002),
        ("Laser", "velocity_2", 2),
        ("Cell (N)", "stop_force_1", 2000),
    ],
)
def test_columns_of_a_structure_are_converted_too(head: str, name: str, value: float) -> None:
    """Their names go on with a coordinate or a point, and their units were passed over."""
    found = read(
        f"t (s);{head}\n1;2\n",
        Units("mm", "s", "kg"),
        **{name: head.split(" ", maxsplit=1)[0].strip(",")},
    )
    assert found[name] == pytest.approx([value])
    with pytest.raises(ValueError, match="km/h is no unit of"):
        read("t (s);Tip (km/h)\n1;2\n", SI, acceleration_tip="Tip")


def test_a_column_named_as_of_a_structure_says_where_its_name_goes() -> None:
    with pytest.raises(
        ValueError, match='of a structure it is named in columns, acceleration_2 = "acceleration_2"'
    ):
        read("t,acceleration_2\n1,2\n")
