"""Studies of structures: what is read, what is refused, and that a text repeats a motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from tests.studies.texts import faults_of, motion_of

import percuss as pc
from percuss.errors import StudyError
from percuss.execution import Execution
from percuss.io.study_text import motion_text
from percuss.motion.structures import StructureTrajectory
from percuss.studies import Limits, Motion, Study, load_study, parse_study

TWO = """\
[structure]
mass = [1, 2]
stiffness = [[3, -1], [-1, 1]]
damping = [["0.03", "-0.01"], ["-0.01", "0.01"]]
points = {tip = [1, 1]}
"""
STOPS = """\
[[structure.stops]]
type = "wall"
at = "0.3"
side = "above"
restitution = "0.8"
on = 0
[[structure.stops]]
type = "soft"
at = "-0.2"
side = "below"
stiffness = 100
on = [1, -1]
"""
LOADS = """\
[[loads]]
on = "tip"
[[loads.harmonics]]
amplitude = 1
omega = 2
[[loads]]
on = [0, 1]
record = {t = [0, 1, 2, "pi"], f = [0, 1, 0, 0], repeat = true}
"""
RUN = '[start]\nx0 = [0, 0]\nv0 = [0, "0.1"]\n[run]\nperiods = 6\n'
WHOLE = TWO + STOPS + LOADS + RUN


def run_of(study: Study) -> StructureTrajectory:
    run = motion_of(study).answer(study, Execution())
    assert isinstance(run, StructureTrajectory)
    return run


def test_a_structure_is_read_as_python_makes_it() -> None:
    study = parse_study(WHOLE)

    assert study.model == pc.Structure(
        mass=[1, 2],
        stiffness=[[3, -1], [-1, 1]],
        damping=[["0.03", "-0.01"], ["-0.01", "0.01"]],
        stops=[
            pc.Wall("0.3", "above", "0.8", on=0),
            pc.SoftStop("-0.2", "below", 100, on=(1, -1)),
        ],
        points={"tip": [1, 1]},
    )
    record = pc.record([0, 1, 2, "pi"], [0, 1, 0, 0], repeat=True)
    assert study.force == pc.Loads({"tip": pc.cosine(2), (0, 1): record})
    with pytest.raises(TypeError, match="no oscillator"):
        _ = study.oscillator


def test_a_text_and_the_record_of_a_run_repeat_its_motion_to_the_bit() -> None:
    study = parse_study(WHOLE)
    run = run_of(study)

    again = parse_study(study.text())
    assert again == study
    assert again.text() == study.text()
    repeated = run_of(parse_study(motion_text(run)))
    assert len(run.impacts) > 5
    assert len(run.crossings) > 5
    np.testing.assert_array_equal(repeated.impacts.t, run.impacts.t)
    np.testing.assert_array_equal(repeated(run.t_end)[0], run(run.t_end)[0])


def test_the_record_of_a_run_that_ended_at_its_impacts_ends_there_again() -> None:
    text = WHOLE.replace("periods = 6", "t_end = 100\nmax_impacts = 7")
    run = run_of(parse_study(text))

    again = run_of(parse_study(motion_text(run)))
    assert run.outcome.name == "reached_max_impacts"
    assert (again.outcome, again.t_end) == (run.outcome, run.t_end)


def test_numbers_of_a_structure_may_follow_from_parameters() -> None:
    text = WHOLE.replace('at = "0.3"', 'at = "d"').replace("[3, -1]", '["k + 1", -1]')
    study = parse_study('[parameters]\nd = "0.3"\nk = 2\n' + text)

    assert study.model.stops[0].at == pc.parameter("d", "0.3")
    assert parse_study(study.text()) == study


def test_a_common_period_of_loads_is_read_and_written() -> None:
    two = "".join(
        f"[[loads]]\non = {i}\n[[loads.harmonics]]\namplitude = 1\nomega = {w}\n"
        for i, w in ((0, 2), (1, 3))
    )
    text = TWO + 'loads_period = "2*pi"\n' + two + RUN
    study = parse_study(text)

    assert study.force == pc.Loads({0: pc.cosine(2), 1: pc.cosine(3)}, period="2*pi")
    assert parse_study(study.text()) == study
    (fault,) = faults_of(text.replace('"2*pi"', '"pi"'))
    assert fault.startswith('s.toml:6: structure.loads_period = "pi": for loads.1: ')
    (fault,) = faults_of(text.replace('loads_period = "2*pi"\n', ""))
    assert fault.endswith("the loads have no common period; give structure.loads_period, or t_end "
                          "instead")  # fmt: skip


MADE = [
    (
        'chain = {masses = [1, "0.5"], springs = [1, 2, 0], dashpots = "0.1"}',
        pc.chain([1, "0.5"], [1, 2, 0], "0.1"),
    ),
    (
        'modes = {frequencies = [1, 6], damping_ratios = "0.01", shapes = {tip = [2, -2]}}',
        pc.Structure.from_modes([1, 6], "0.01", {"tip": [2, -2]}),
    ),
    (
        'cantilever = {n_modes = 2, damping_ratio = "0.01", points = {tip = 1, mid = "0.5"}}',
        pc.cantilever(2, damping_ratio="0.01", points={"tip": 1, "mid": "0.5"}),
    ),
    ("cantilever = {n_modes = 1}", pc.cantilever(1)),
    (
        'impact_pair = {masses = [1, 2], gap = "0.5", restitution = {speeds = [1], values = ["0.5"]}}',
        pc.impact_pair([1, 2], "0.5", pc.restitution_table([1], ["0.5"])),
    ),
    (
        'absorber = {mass = 1, stiffness = 1, absorber_mass = "0.1", gap = 1, damping = "0.01"}',
        pc.vibro_impact_absorber(1, 1, "0.1", 1, damping="0.01"),
    ),
]


@pytest.mark.parametrize(("line", "structure"), MADE)
def test_modes_and_mechanisms_are_those_of_python(line: str, structure: pc.Structure) -> None:
    study = parse_study(f"[structure]\n{line}\n[run]\nt_end = 1\n")

    assert study.model == structure
    again = parse_study(study.text())
    # A Fraction comes back as a text.
    assert again.text() == study.text()
    assert isinstance(again.model, pc.Structure)
    np.testing.assert_array_equal(again.model.damping_matrix, structure.damping_matrix)


def test_stops_of_a_file_follow_those_of_its_mechanism_and_are_told_on_their_lines() -> None:
    pair = '[structure]\nimpact_pair = {masses = [1, 2], gap = "0.5"}\n'
    soft = '[[structure.stops]]\ntype = "soft"\nat = 1\nside = "above"\nstiffness = 9\non = 0\n'
    study = parse_study(pair + soft + "[run]\nt_end = 1\n")

    assert [stop.at for stop in study.model.stops] == [-0.5, "0.5", 1]
    wrong = (pair + soft + "[run]\nt_end = 1\n").replace("on = 0", "on = 7")
    assert faults_of(wrong) == [
        "s.toml:8: structure.stops.0.on = 7: no such coordinate; the coordinates are 0 to 1"
    ]


FAULTS = [
    (
        {"mass = [1, 2]": "mass = [[1, 2], [2, 1]]", "on = 0\n": "on = 2\n", "[1, -1]\n": "[0, 0]\n"},
        (
            (
                "s.toml:2: structure.mass.1.1 = 1: the mass is not positive definite; -3 of this "
                "entry is left after elimination of the coordinates before it"
            ),
            "s.toml:11: structure.stops.0.on = 2: no such coordinate; the coordinates are 0 to 1",
            (
                "s.toml:17: structure.stops.1.on = [0, 0]: a direction of zeros; what acts on it "
                "moves nothing"
            ),
        ),
    ),
    (
        {"mass = [1, 2]": 'mass = [[1, "0.5"], ["0.4", 1]]', '"tip"': '"tpi"', '[0, "0.1"]': "[0]"},
        (
            (
                's.toml:2: structure.mass.0.1 = "0.5": not mass.1.0 = 0.4; a mass is symmetric, as '
                "(M + M.T) / 2 is"
            ),
            "s.toml:19: loads.0.on = \"tpi\": no such point; did you mean tip?",
            "s.toml:28: start.v0 = [0]: 1 number for 2 coordinates; give one for each",
        ),
    ),
    (
        {"[[3, -1], [-1, 1]]": "[1, 2, 3]", '"0.8"': "2"},
        (
            (
                "s.toml:3: structure.stiffness = [3, 3]: 3 x 3, but the mass is 2 x 2; all matrices"
                " have one size"
            ),
            (
                "s.toml:10: structure.stops.0.restitution = 2: outside [0, 1]; above 1 an impact "
                "would create energy"
            ),
        ),
    ),
    (
        {"x0 = [0, 0]": "x0 = [2, 0]"},
        (
            (
                "s.toml:27: start.x0 = [2, 0]: y = 2 is above the wall stops.0 at y = 0.3; "
                "start on its other side, or use a SoftStop, which can be entered"
            ),
        ),
    ),
    (
        {'type = "soft"': 'type = "wall"', "stiffness = 100\non = [1, -1]": "on = [2, 0]",
         '"-0.2"': "1"},
        (
            (
                's.toml:8: structure.stops.0.at = "0.3": not above the lower wall at x = 0.5; the '
                "walls leave no room"
            ),
        ),
    ),
    (
        {"periods = 6": "max_impacts = 6"},
        ("s.toml:29: run: missing an end; give t_end or periods: stops may never be met",),
    ),
    (
        {"[structure]": "[oscillator]\n[forcing]\n[structure]"},
        (
            "s.toml:1: oscillator: given together with [structure]; a study has one of the two",
            "s.toml:2: forcing: a force on one mass; those on a structure begin with [[loads]]",
        ),
    ),
    (
        {"omega = 2": 'omega = "x"\nphsae = 1', "on = 0\n": ""},
        (
            (
                "s.toml:6: structure.stops.0.on: not said on what it acts; the coordinates are 0 to"
                " 1; give one, or a direction, or a point: tip"
            ),
            ('s.toml:21: loads.0.harmonics.0.omega = "x": not a number; write 2.8, or "2.8" for that'
            ' decimal, "1/3" for that fraction'),
            's.toml:22: loads.0.harmonics.0.phsae: unknown key; did you mean "phase"?',
        ),
    ),
    (
        {"mass = [1, 2]": 'chain = {masses = [1], springs = [1, "a"]}'},
        (
            's.toml:2: structure.chain.springs.1 = "a": ',
            (
                "s.toml:3: structure.stiffness: given together with structure.chain; a structure "
                "has one source"
            ),
            (
                "s.toml:4: structure.damping: given together with structure.chain; a structure has "
                "one source"
            ),
        ),
    ),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "told"), FAULTS)
def test_all_faults_are_told_at_once(changes: dict[str, str], told: tuple[str, ...]) -> None:
    text = WHOLE
    for old, new in changes.items():
        assert old in text
        text = text.replace(old, new)

    faults = faults_of(text)

    assert len(faults) == len(told), faults
    for fault, begin in zip(faults, told, strict=True):
        assert fault.startswith(begin) if begin.endswith(": ") else fault == begin


MATRICES = TWO.replace("[1, 2]", '"M.mtx"').replace("[[3, -1], [-1, 1]]", '"K.csv"')
FILES = {
    "M.mtx": "%%MatrixMarket matrix coordinate real symmetric\n% note\n2 2 2\n1 1 1.0\n2 2 2\n",
    "K.csv": "# of a program\n3, -1\n-1, 1\n",
}


def written(folder: Path, files: dict[str, str], text: str) -> Path:
    for name, content in files.items():
        (folder / name).write_text(content, encoding="utf-8")
    (folder / "s.toml").write_text(text, encoding="utf-8")
    return folder / "s.toml"


def test_matrices_in_files_are_those_of_the_lists(tmp_path: Path) -> None:
    study = load_study(written(tmp_path, FILES, MATRICES + RUN.replace("periods", "t_end")))

    assert study.model == parse_study(TWO + RUN.replace("periods", "t_end")).model
    # The record of its results holds the numbers, and needs no file.
    assert parse_study(study.text()) == study


def test_matrices_of_numpy_and_sparse_ones_are_read(tmp_path: Path) -> None:
    np.save(tmp_path / "M.npy", np.array([1.0, 2.0]))
    np.savez(
        tmp_path / "K.npz", format=b"csr", shape=[2, 2], indptr=[0, 2, 4], indices=[0, 1, 0, 1],
        data=[3.0, -1.0, -1.0, 1.0],
    )  # fmt: skip
    text = MATRICES.replace("M.mtx", "M.npy").replace("K.csv", "K.npz")
    study = load_study(written(tmp_path, {}, text + "[run]\nt_end = 1\n"))

    assert study.model == parse_study(TWO + "[run]\nt_end = 1\n").model


def test_one_file_of_numpy_holds_all_matrices_by_their_names(tmp_path: Path) -> None:
    model = parse_study(TWO + "[run]\nt_end = 1\n").model
    assert isinstance(model, pc.Structure)
    stiffness, mass = model.stiffness_matrix, model.mass_matrix
    np.savez(tmp_path / "all.npz", K=stiffness, mass=mass, other=mass)
    text = MATRICES.replace("M.mtx", "all.npz").replace("K.csv", "all.npz") + "[run]\nt_end = 1\n"
    assert load_study(written(tmp_path, {}, text)).model == model

    np.savez(tmp_path / "all.npz", A=stiffness, mass=mass)
    with pytest.raises(StudyError) as refused:
        load_study(written(tmp_path, {}, text))
    assert (
        'structure.stiffness = "all.npz": one array, or one named K or stiffness, is wanted, '
        "the file has 2: A, mass" in str(refused.value)
    )


@pytest.mark.parametrize(
    ("name", "content", "told"),
    [
        ("K.csv", "", '"K.csv": it holds no numbers'),
        ("K.csv", "3, x\n-1, 1\n", '"K.csv": line 1: "x" is no number'),
        ("K.csv", "3, -1\n-1\n", '"K.csv": line 2: 1 numbers, but 2 in the first row'),
        ("K.csv", "3, nan\n-1, 1\n", '"K.csv": entry 0.1 is nan, not finite'),
        ("K.csv", "3,-1;\n-1,1;\n", '"K.csv": line 1: "-1;" is no number'),
        ("K.csv", "1 2\n3 4\n5 6\n", "the matrix is not square"),
        ("M.mtx", "3 3\n", 'does not begin with "%%MatrixMarket matrix"'),
        ("M.mtx", FILES["M.mtx"].replace("2 2 2\n1", "2 2 3\n1"), "2 entries, but it says that"),
        ("M.mtx", FILES["M.mtx"].replace("2 2 2\n1", "1 1 2\n1"), "no place (2, 2) in 1 x 1"),
        ("M.mtx", FILES["M.mtx"].replace("1 1 1.0", "1 1 -1"), "entry 0.0 = -1.0: not positive"),
        ("M.mtx", FILES["M.mtx"].replace(" real", " complex"), '"complex"; real, integer and'),
    ],
)
def test_a_file_that_is_no_matrix_is_told_in_a_sentence(
    tmp_path: Path, name: str, content: str, told: str
) -> None:
    file = written(tmp_path, FILES | {name: content}, MATRICES + "[run]\nt_end = 1\n")

    with pytest.raises(StudyError) as caught:
        load_study(file)
    (fault,) = caught.value.faults
    assert told in str(fault)
    assert f'"{name}"' in str(fault)


def test_between_semicolons_a_comma_is_that_of_a_decimal(tmp_path: Path) -> None:
    content = {"K.csv": "3,5;-1\n-1;1,25;\n"}
    study = load_study(written(tmp_path, FILES | content, MATRICES + "[run]\nt_end = 1\n"))
    assert isinstance(study.model, pc.Structure)
    assert study.model.stiffness_matrix.tolist() == [[3.5, -1.0], [-1.0, 1.25]]


def test_a_file_that_is_missing_or_of_another_kind_is_told(tmp_path: Path) -> None:
    text = MATRICES.replace("M.mtx", "N.mtx").replace("K.csv", "K.mat") + "[run]\nt_end = 1\n"

    with pytest.raises(StudyError) as caught:
        load_study(written(tmp_path, FILES, text))
    first, second = map(str, caught.value.faults)
    assert first.endswith('s.toml:2: structure.mass = "N.mtx": no such file or directory')
    assert second.endswith(
        's.toml:3: structure.stiffness = "K.mat": not a file of a matrix; these end with .csv, '
        ".txt, .npy, .npz, .mtx"
    )


def test_one_coordinate_needs_no_lists_and_no_directions() -> None:
    text = (
        "[structure]\nmass = 1\nstiffness = 4\n"
        '[[structure.stops]]\ntype = "wall"\nat = 0\nside = "below"\n'
        "[[loads]]\n[[loads.harmonics]]\namplitude = 1\nomega = 3\n"
        '[start]\nx0 = 0\nv0 = "0.5"\n[run]\nperiods = 3\n'
    )
    study = parse_study(text)

    assert study.model == pc.Structure(1, 4, stops=[pc.Wall(0, "below")])
    assert study.question == Motion(pc.StructureStart((0,), ("0.5",)), Limits(periods=3))
    assert len(run_of(study).impacts) > 2
