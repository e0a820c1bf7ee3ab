"""Studies of fits: their records and faults, what they write, and that they are those of Python."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from tests.studies.texts import faults_of

import percuss as pc
from percuss.errors import ParameterError, StudyError
from percuss.execution import Execution
from percuss.fitting.summaries import impacts_of, interval_of
from percuss.io import load_netcdf, save_csv
from percuss.studies import Fit, FitRecord, Study, load_study, parse_study, run_study
from percuss.studies.kinds.fit import Fit as FitQuestion

EXAMPLE = Path(__file__).parents[2] / "examples" / "fit.toml"
GAP, RESTITUTION = "oscillator.stops.0.at", "oscillator.stops.0.restitution"
MODEL = """\
[study]
kind = "fit"
[oscillator]
damping = "0.05"
units = {length = "m", time = "s"}
[[oscillator.stops]]
type = "wall"
at = "0.3"
side = "above"
restitution = "0.5"
[[forcing.harmonics]]
amplitude = 1
omega = 2
"""
OWN = """\
[fit.free]
"oscillator.stops.0.at" = [0.05, 0.5]
"oscillator.stops.0.restitution" = 0.6
[[fit.records]]
file = "rig.csv"
noise = 0.01
"""
HEAD = MODEL.count("\n")


def record(v0: float = 0.5, omega: float = 2.0, noise: float = 0.01) -> tuple[list[float], ...]:
    rig = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    t = np.linspace(0, 12, 160)
    x, _ = pc.simulate(rig, pc.cosine(omega), v0=v0, t_end=12)(t)
    x += noise * np.random.default_rng(3).standard_normal(len(t))
    return t.tolist(), x.tolist()


def file_of(folder: Path, text: str, table: str | None = None) -> Path:
    if table is None:
        rows = "".join(f"{1e3 * t!r};{1e3 * x!r}\n" for t, x in zip(*record(), strict=True))
        table = "Time (ms);x [mm]\n" + rows.replace(".", ",")
    (folder / "rig.csv").write_text(table, encoding="utf-8")
    (folder / "s.toml").write_text(text, encoding="utf-8")
    return folder / "s.toml"


def told(folder: Path, text: str, table: str = "t,x\n0,1\n1,2\n2,3\n3,4\n4,5\n") -> list[str]:
    with pytest.raises(StudyError) as error:
        load_study(file_of(folder, text, table))
    return [str(fault).split("s.toml", 1)[1] for fault in error.value.faults]


def question(study: Study) -> FitQuestion:
    assert isinstance(study.question, FitQuestion)
    return study.question


def test_a_study_is_that_of_python_and_its_files_hold_all_of_the_fit(tmp_path: Path) -> None:
    study = load_study(file_of(tmp_path, MODEL + OWN + f'[fit]\nprofiles = "{GAP}"\n'))

    result = run_study(study, tmp_path / "out")

    t, x = record()
    fit = pc.fit(
        {"t": np.array(t), "displacement": np.array(x)}, study.oscillator, study.forcing,
        free={GAP: (0.05, 0.5), RESTITUTION: 0.6}, noise=0.01,
    )  # fmt: skip
    assert fit.converged
    assert result.answer.values == pytest.approx(fit.values, rel=1e-6)
    assert result.report["fit"].startswith("converged; ")
    assert result.report[GAP].endswith(" m")
    assert "like noise" in result.report["residuals"]
    assert {file.name for file in result.files} >= {
        "fit.nc", "fit.csv", "covariance.csv", "residuals.csv", "impacts.csv", "profiles.csv",
        "fit.png", "profiles.png",
    }  # fmt: skip
    tree = load_netcdf(tmp_path / "out" / "fit.nc")
    assert tree["path"].values.tolist() == list(fit.values)
    assert tree.attrs["converged"] == 1
    np.testing.assert_array_equal(tree["covariance"], result.answer.covariance)
    np.testing.assert_allclose(tree["residuals"]["value"], x, rtol=1e-12)
    np.testing.assert_array_equal(tree["impacts"]["t"], impacts_of(result.answer)["t"])
    np.testing.assert_array_equal(tree["motion"]["x"], result.answer(tree["motion"]["t"].values)[0])
    assert tree["profiles"]["growth"].sizes == {"row": 9}
    save_csv(result.answer, tmp_path / "impacts.csv", table="impacts")
    own = (tmp_path / "out" / "impacts.csv").read_text(encoding="utf-8")
    assert (tmp_path / "impacts.csv").read_text(encoding="utf-8") == own
    # The files hold the samples: they repeat the study without the table.
    assert all(load_study(file) == study for file in result.files)


def test_the_example_finds_the_rig_that_scipy_moved() -> None:
    study = load_study(EXAMPLE)
    assert len(question(study).records[0].data["t"]) == 801

    from percuss.execution import Execution

    fit = question(study).answer(study, Execution())

    assert fit.converged
    truth = {GAP: 1.2e-3, RESTITUTION: 0.72, "oscillator.damping": 6.0}
    for path, value in (truth | {"forcing.harmonics.0.phase": 0.7}).items():
        assert fit.values[path] == pytest.approx(value, abs=3.5 * fit.errors[path])
    assert fit.errors[GAP] < 2e-6
    assert fit.errors[RESTITUTION] < 1e-3


def test_several_records_with_starts_and_forces_of_their_own(tmp_path: Path) -> None:
    rows = []
    for v0, omega in ((0.5, 2.0), (-0.3, 2.2)):
        t, x = record(v0, omega)
        rows.append(
            f"[[fit.records]]\nnoise = {{displacement = 0.01}}\nstart = [0, {v0}]\n"
            f'settings = {{"forcing.omega" = {omega}}}\nt = {t}\ndisplacement = {x}\n'
        )
    head = f'[fit.free]\n"{GAP}" = 0.25\n"{RESTITUTION}" = 0.7\n[fit.prior]\n"{GAP}" = [0.2, 0.1]\n'
    study = parse_study(MODEL + head + "".join(rows))
    assert parse_study(study.text()) == study

    result = run_study(study, tmp_path)

    fit = result.answer
    assert fit.converged
    assert set(fit.residuals.record.values.tolist()) == {0, 1}
    assert set(impacts_of(fit)["record"].tolist()) == {0, 1}
    for path, value in ((GAP, 0.2), (RESTITUTION, 0.8)):
        assert fit.values[path] == pytest.approx(value, abs=4 * fit.errors[path])
    assert all(load_study(file) == study for file in result.files)


ROW = """\
[study]
kind = "fit"
[structure]
mass = [1, "1.5"]
stiffness = [[3, -1], [-1, 2]]
damping = [["0.2", "-0.05"], ["-0.05", "0.2"]]
points = {tip = [0, 1]}
units = {length = "m", time = "s", mass = "kg"}
[[structure.stops]]
type = "wall"
on = "tip"
at = "0.55"
side = "above"
restitution = "0.6"
[[loads]]
on = 0
[[loads.harmonics]]
amplitude = 2
omega = "1.4"
[fit.free]
"structure.stops.0.at" = 0.52
"structure.stops.0.restitution" = 0.6
"structure.damping.1.1" = 0.24
[[fit.records]]
file = "rig.csv"
columns = {acceleration_tip = "Accelerometer"}
"""


def of_the_row() -> str:
    """Return what an accelerometer at the tip of a structure has measured, as a logger writes it."""
    wall = pc.Wall(at="0.5", side="above", restitution="0.7", on=1)
    row = pc.Structure([1, 1.5], [[3, -1], [-1, 2]], [[0.2, -0.05], [-0.05, 0.2]], stops=[wall])
    t = np.arange(300) / 15
    forces = pc.simulate(row, pc.Loads({0: pc.cosine("1.4", amplitude=2)}), t_end=20).forces(t)
    own = [forces[name].values[:, 1] for name in ("spring", "damping", "loads")]
    a = np.sum([*own, forces.stops.values[0]], axis=0) / 1.5
    a += 0.02 * np.std(a) * np.random.default_rng(2).standard_normal(len(t))
    lines = [f"{u:.6f},{b:.6f}" for u, b in zip(t.tolist(), a.tolist(), strict=True)]
    return "\n".join(["time [s],Accelerometer (m/s^2)", *lines])


def test_a_structure_from_one_accelerometer_goes_on_from_its_store(tmp_path: Path) -> None:
    study = load_study(file_of(tmp_path, ROW + "[start]\n", of_the_row()))
    assert parse_study(study.text()) == study
    store = tmp_path / "rig.fit"

    part = run_study(study, tmp_path / "a", store=store, progress=lambda done, _: done < 2)
    assert (part.is_whole, part.files) == (False, ())
    result = run_study(study, tmp_path / "a", store=store)

    assert result.is_whole
    fit = result.answer
    assert fit.converged
    for path, true in zip(fit.values, (0.5, 0.7, 0.2), strict=True):
        assert fit.values[path] == pytest.approx(true, abs=4 * fit.errors[path])
    assert result.report["structure.stops.0.at"].endswith(" m")
    nodes, motion = (load_netcdf(tmp_path / "a" / "fit.nc")[name] for name in ("nodes", "motion"))
    assert nodes["x"].dims == ("node", "coordinate")
    np.testing.assert_allclose(motion["x"].values, fit(motion["t"].values)[0], atol=1e-12)
    assert all(load_study(file) == study for file in result.files)


def test_starts_and_loads_of_records_of_a_structure(tmp_path: Path) -> None:
    own = 'start = [[0, "0.1"], [0, 0], 0]\nsettings = {"loads.0.omega" = "1.5"}\n'
    study = load_study(file_of(tmp_path, ROW + own, of_the_row()))
    assert parse_study(study.text()) == study
    (one,) = question(study).records
    assert one.start == pc.model.StructureStart((0, "0.1"), (0, 0), 0)
    assert one.forcing(study.model, study.force) == pc.Loads({0: pc.cosine("1.5", amplitude=2)})

    more = own.replace("[0, 0]", "[0]").replace("loads.0.omega", "structure.mass.0.0")
    faults = told(tmp_path, ROW + more, of_the_row())
    assert "fit.records.0.start.1 = [0]: 1 number for 2 coordinates; give one for each" in faults[0]
    assert faults[1].endswith(
        "of the structure, which all records share; only the loads may differ"
    )
    of_no_place = ROW.replace("acceleration_tip =", "acceleration_top =")
    assert "of no place; there are acceleration_0" in told(tmp_path, of_no_place, of_the_row())[0]


@pytest.mark.parametrize("is_file", [True, False])
def test_impact_times_alone_are_a_record(tmp_path: Path, *, is_file: bool) -> None:
    ball = pc.Oscillator(0, 0, (pc.Wall(0, "below", "0.85"),))
    times = pc.simulate(ball, pc.Forcing(constant="-9.81"), x0=1, max_impacts=9).impacts.t
    inline = f"impact_times = {times.tolist()!r}\n"
    own = 'file = "rig.csv"\n' if is_file else inline
    text = (
        '[study]\nkind = "fit"\n[oscillator]\nstiffness = 0\n[[oscillator.stops]]\ntype = "wall"\n'
        'at = 0\nside = "below"\nrestitution = "0.7"\n[forcing]\nconstant = "-9.81"\n'
        f"[fit.free]\n{RESTITUTION!r} = 0.7\n[[fit.records]]\nnoise = 1e-4\n{own}"
    ).replace("'", '"')
    table = "impact_times\n" + "".join(f"{t!r}\n" for t in times.tolist())
    study = load_study(file_of(tmp_path, text, table))
    result = study.question.answer(study, Execution())

    assert result.converged
    assert result.values[RESTITUTION] == pytest.approx(0.85, abs=1e-6)
    assert parse_study(study.text()).question == study.question


def test_missing_values_and_noise_of_each_value_are_read_back() -> None:
    t, x = record()
    values = ", ".join("nan" if i == 5 else repr(value) for i, value in enumerate(x))
    own = OWN.replace('file = "rig.csv"\nnoise = 0.01\n', "")
    own += f"t = {t}\ndisplacement = [{values}]\nnoise = {[0.01] * len(t)}\n"
    study = parse_study(MODEL + own)
    assert question(study).records[0].data["displacement"][5] is None

    again = parse_study(study.text())

    assert again == study
    assert again.text() == study.text()


def test_a_start_whose_numbers_are_free() -> None:
    t, x = record()
    own = f'[fit.free]\n"{GAP}" = 0.25\n"start.v0" = 0.4\n[start]\nx0 = 0\nv0 = "0.4"\n'
    own += f"[[fit.records]]\nt = {t}\ndisplacement = {x}\n"
    study = parse_study(MODEL.replace('"0.5"', '"0.8"') + own)
    assert parse_study(study.text()) == study

    from percuss.execution import Execution

    fit = question(study).answer(study, Execution())

    assert fit.values["start.v0"] == pytest.approx(0.5, abs=5 * fit.errors["start.v0"])


def test_a_fit_that_is_stopped_is_written_with_the_best_so_far(tmp_path: Path) -> None:
    study = load_study(file_of(tmp_path, MODEL + OWN))

    result = run_study(study, tmp_path / "out", progress=lambda done, _: done < 2)

    assert not result.is_whole
    assert result.report["fit"].startswith("not converged: the search was stopped; ")
    tree = load_netcdf(tmp_path / "out" / "fit.nc")
    assert tree.attrs["reason"] == "the search was stopped"


def test_what_no_motion_explains_is_told_with_the_reason(tmp_path: Path) -> None:
    t = record()[0][:40]
    noise = np.random.default_rng(0).standard_normal(len(t)).tolist()
    own = OWN.replace('file = "rig.csv"\n', f"t = {t}\ndisplacement = {noise}\n")

    result = run_study(parse_study(MODEL + own), tmp_path)

    assert result.report["fit"].startswith("not converged: ")
    assert (tmp_path / "fit.png").stat().st_size > 10_000


def test_a_fit_of_python_is_written_and_read() -> None:
    data = {"t": (0.0, 0.5, 1.0, 1.5), "displacement": (2.0, 1.7, None, 0.1)}
    osc = pc.Oscillator()
    study = Study(osc, None, Fit((FitRecord(data, noise="0.1"),), {"oscillator.stiffness": 1.3}))

    assert parse_study(study.text()) == study
    with pytest.raises(ParameterError, match=r"fit\.loss = 'square'"):
        Fit((), {}, loss="square")
    with pytest.raises(ParameterError, match=r"fit\.loss_scale = -1"):
        Fit((), {}, loss_scale=-1.0)


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('"rig.csv"', '"none.csv"', 'fit.records.0.file = "none.csv": no such file or directory'),
        ('"rig.csv"', "3", "fit.records.0.file = 3: not a text"),
        ('file = "rig.csv"\n', "", f":{HEAD + 4}: fit.records.0: no values; give a file, or t and"),
        ('file = "rig.csv"', "t = [0, 1]\ndisplacement = [1]", "fit.records.0.displacement = 1: 1 v"),
        ('file = "rig.csv"', 't = [0, "a"]\nx = [1, 2]', 'fit.records.0.t.1 = "a": not a number'),
        ('file = "rig.csv"', "t = [0, 1]\nx = [1, 2]", "fit.records.0.x: unknown key; known here"),
        ('file = "rig.csv"', "t = 3", "fit.records.0.t = 3: not a list of numbers"),
        ('file = "rig.csv"', "displacement = [1, 2]", 'without instants; give them as "t"'),
        ('file = "rig.csv"', "t = [0, 1]", "no column of displacement"),
        ('file = "rig.csv"', "t = [0, 1]\nstop_force_1 = [0, 1]", "of stop 1, where the oscillator"),
        ('file = "rig.csv"', "t = [0]\ndisplacement = [nan]", "all values are NaN"),
        ('file = "rig.csv"', 'file = "rig.csv"\nt = [1]', "fit.records.0.t: given together with fi"),
        ("noise = 0.01", "noise = 0", "fit.records.0.noise = 0: not a standard deviation"),
        ("noise = 0.01", "noise = {velocity = 1}", "fit.records.0.noise.velocity = 1: none of the"),
        ("noise = 0.01", 'columns = {t = "Zeit"}', 'no column "Zeit"'),
        ("noise = 0.01", 'columns = {height = "x"}', 'columns.height = "x": none of the quantities'),
        ("noise = 0.01", "start = 3", "fit.records.0.start = 3: not a start; write [x0, v0]"),
        ("noise = 0.01", "start = [0.4, 0]", "fit.records.0.start = [0.4, 0]: above the wall"),
        ("noise = 0.01", "start = [0, 0, 1]", "the first value is of t = 0.0, before the start at"),
        ("noise = 0.01", 'settings = {"forcing.omga" = 1}', "settings.forcing.omga = 1: no such par"),
        ("noise = 0.01", f'settings = {{"{GAP}" = 1}}', "of the oscillator, which all records share"),
        ("[[fit.records]]\n", "[fit.records]\n", "fit.records = {file = "),
        (OWN[OWN.index("[[fit") :], "", "fit.records: missing; begin each record with [[fit.records"),
        ("[fit.free]", "[fit.fre]", 'fit.fre: unknown key; did you mean "free"?'),
        ("[0.05, 0.5]", "[0.5, 0.05]", f"fit.free.{GAP} = [0.5, 0.05]: the least is above the larg"),
        ("[0.05, 0.5]", "[0.5]", f"fit.free.{GAP} = [0.5]: not a range"),
        ("= 0.6", '= "soft"', f'fit.free.{RESTITUTION} = "soft": not a number'),
        ("= 0.6", "= 1.6", f"fit.free.{RESTITUTION} = 1.6: outside [0, 1]; above 1"),
        (f'"{RESTITUTION}"', '"start.v0"', "fit.free.start.v0: of a start that is unknown as a whole"),
        (f'"{RESTITUTION}"', '"oscillator.dampng"', "fit.free.oscillator.dampng: no such parameter"),
        ("[[fit", '[fit.prior]\n"oscillator.damping" = [0, 1]\n[[fit', "none of the free parameters"),
        ("[[fit", f'[fit.prior]\n"{GAP}" = 0.2\n[[fit', f"fit.prior.{GAP} = 0.2: not [mean, standard"),
        ("[[fit", f'[fit.prior]\n"{GAP}" = [0.2, 0]\n[[fit', "not [mean, standard deviation]"),
        ("[fit.free]", '[fit]\nloss = "square"\n[fit.free]', 'fit.loss = "square": not "linear", "'),
        ("[fit.free]", "[fit]\nloss_scale = 0\n[fit.free]", "fit.loss_scale = 0: not more than 0"),
        ("[fit.free]", '[fit]\nprofiles = ["start.x0"]\n[fit.free]', 'profiles.0 = "start.x0": none'),
    ],
)  # fmt: skip
def test_a_fault_is_told_with_its_line_and_path(
    tmp_path: Path, old: str, new: str, words: str
) -> None:
    assert old in OWN
    found = told(tmp_path, MODEL + OWN.replace(old, new))
    assert any(words in fault for fault in found), found
    assert len(found) <= 2
    assert all(fault.startswith(":") for fault in found), found


@pytest.mark.parametrize(
    ("table", "words"),
    [
        (
            "t,x\n0,1\n1,2\n2,\n",
            ": fit.records: 2 values for 4 unknowns; a start that is not given",
        ),
        ("t,x\n0,far\n1\n", 'line 2: x = "far" is no finite number; line 3: 1 cell'),
        ("t,x [V]\n0,1\n", '"x [V]": no unit that percuss knows'),
        ("t,x\n0,\n1,nan\n", "all values are NaN"),
        ("0,1\n1,2\n", "its first line holds numbers"),
    ],
)
def test_faults_of_the_table_are_told_at_its_name(tmp_path: Path, table: str, words: str) -> None:
    (fault,) = told(tmp_path, MODEL + OWN, table)
    assert words in fault


def test_all_faults_are_told_at_once(tmp_path: Path) -> None:
    own = OWN.replace("0.01", "-1") + '[fit]\nloss = "x"\nlos = 1\n'
    found = told(tmp_path, MODEL.replace('"0.05"', '"soft"') + own, "t,y\n0,a\n")
    paths = [fault.split(" ")[1].rstrip(":") for fault in found]
    assert paths == [
        "oscillator.damping",
        "fit.records.0.file",
        "fit.records.0.noise",
        "fit.loss",
        "fit.los",
    ]


def test_a_text_without_a_place_has_no_tables_beside_it() -> None:
    (fault,) = faults_of(MODEL + OWN)
    assert 'fit.records.0.file = "rig.csv": a study that is no file has no files beside it' in fault


def test_columns_with_units_need_those_of_the_model(tmp_path: Path) -> None:
    text = MODEL.replace('units = {length = "m", time = "s"}\n', "") + OWN
    (fault,) = told(tmp_path, text, "t [ms],x\n0,1\n")
    assert "the model has no units to convert ms into; give oscillator.units" in fault


def test_a_profile_without_an_end_is_open() -> None:
    import xarray as xr

    from percuss.fitting.summaries import interval_of

    value = np.arange(5.0)
    profile = xr.Dataset({"growth": ("value", [9.0, 4.0, 0.0, 0.5, 0.6])}, {"value": value})
    low, high = interval_of(profile)
    assert low == 1.5
    assert high == math.inf


def test_a_fit_that_is_stopped_has_no_profiles(tmp_path: Path) -> None:
    study = load_study(file_of(tmp_path, MODEL + OWN + f'[fit]\nprofiles = "{GAP}"\n'))

    result = run_study(study, tmp_path / "out", progress=lambda done, _: done < 4)

    assert not result.is_whole
    assert result.answer.profiles == {}
    assert result.report[f"profile of {GAP}"] == "none, the search was stopped"


def test_the_report_says_what_is_wrong_with_noise_ends_and_profiles(tmp_path: Path) -> None:
    text = MODEL + OWN.replace("[0.05, 0.5]", "[0.25, 0.5]").replace("0.01\n", "10\n")
    study = load_study(file_of(tmp_path, text + f'[fit]\nprofiles = "{GAP}"\n'))

    result = run_study(study, tmp_path / "out")

    assert "the least of its range: the data ask for less" in result.report[GAP]
    assert "times theirs: is it in the model's units?" in result.report["residuals"]
    assert result.report["noise"] == "displacement 10 m"
    assert result.report[f"profile of {GAP}"] == "none, it has no error"
    assert (tmp_path / "out" / "profiles.png").stat().st_size > 1000
    nothing = interval_of(
        xr.Dataset({"growth": ("value", np.full(3, math.nan))}, {"value": np.arange(3.0)})
    )
    assert np.isnan(nothing).all()


def test_each_quantity_and_all_pairs_of_parameters_have_a_picture(tmp_path: Path) -> None:
    t, x = record()
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    _, v = pc.simulate(osc, pc.cosine(2), v0=0.5, t_end=12)(t)
    rows = zip(t, x, v.tolist(), strict=True)
    table = "t;x;v\n" + "".join(f"{a!r};{b!r};{c!r}\n" for a, b, c in rows)
    text = MODEL + OWN.replace("noise = 0.01", "noise = {displacement = 0.01, velocity = 0.01}")
    text = text.replace("[fit.free]\n", '[fit.free]\n"oscillator.damping" = 0.04\n')
    result = run_study(load_study(file_of(tmp_path, text, table)), tmp_path / "out")
    pictures = {file.name for file in result.files if file.suffix == ".png"}
    assert pictures == {"fit.png", "fit_velocity.png", "confidence.png"}


def test_tables_have_the_names_that_were_asked_for(tmp_path: Path) -> None:
    text = MODEL.replace("[oscillator]\n", "[oscillator]\nmass = 1\nstiffness = 1\n") + OWN
    text = text.replace('time = "s"}', 'time = "s", mass = "kg"}')
    text = text.replace('damping = "0.05"', 'damping_coefficient = "0.1"').replace(
        "[fit.free]\n",
        '[fit.free]\n"oscillator.damping_coefficient" = 0.08\n"forcing.phase" = 0.0\n',
    )
    result = run_study(load_study(file_of(tmp_path, text)), tmp_path / "out")
    assert result.answer.converged
    names = [*("oscillator.damping_coefficient", "forcing.phase"), GAP, RESTITUTION]
    for table in ("fit", "covariance"):
        lines = (tmp_path / "out" / f"{table}.csv").read_text(encoding="utf-8").splitlines()
        rows = [line.partition(",")[0] for line in lines if line.startswith(("osc", "forc"))]
        assert rows == names


def test_free_motion_after_a_pulse_has_the_pulse_in_its_summary() -> None:
    text = (
        '[study]\nkind = "fit"\n[oscillator]\nstiffness = 4\ndamping = "0.1"\n[forcing.record]\n'
        't = [0, "0.1"]\nf = [5, 5]\noutside = "zero"\n[start]\nx0 = 0\n'
        '[fit.free]\n"oscillator.damping" = "0.12"\n[[fit.records]]\n'
    )
    t = np.linspace(0.05, 4, 40)
    model, pulse = pc.Oscillator(4, "0.1"), pc.record([0, "0.1"], [5, 5], outside="zero")
    x, _ = pc.simulate(model, pulse, t_end=4)(t)
    lists = f"t = {t.tolist()}\ndisplacement = {(x + 1e-4 * np.sin(37 * t**2)).tolist()}\n"
    study = parse_study(text + lists)
    result = study.question.answer(study, Execution())
    assert result.converged
    assert study.question.report(result)["record"] == (
        "of the force the record lasts from t = 0 to 0.1, nothing acts beyond"
    )
