"""A study of every kind is read, written, run and loaded again."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.studies.texts import WALL_ABOVE

import percuss as pc
from percuss.errors import OutputError, ParameterError
from percuss.execution import Execution
from percuss.io import load_netcdf, load_record
from percuss.studies.link import link_of
from percuss.studies.reading import load_study, parse_study
from percuss.studies.running import StudyResult, output_files, run_study
from percuss.studies.study import Study, kind_names
from percuss.studies.templates import template_text

MODEL = f"{WALL_ABOVE}[draw]\nsvg = false\n"
# Of this model from rest, its displacement rounded to six digits.
T = [0.5 * i for i in range(26)]
X = [
    0.0,
    0.117875,
    0.406809,
    0.710415,
    0.845601,
    0.674499,
    0.163043,
    -0.593955,
    -1.390976,
    -1.969399,
    -2.098093,
    -1.652655,
    -0.668212,
    0.652442,
    0.201432,
    -0.694217,
    -1.29981,
    -1.599965,
    -1.644542,
    -1.507448,
    -1.250158,
    -0.902782,
    -0.467503,
    0.059725,
    0.660415,
    0.781538,
]
QUESTIONS = {
    "motion": "[start]\nx0 = 0\nv0 = 0\n[run]\nperiods = 3\n",
    "orbit": "[orbit]\nimpacts = 1\ncycle = 0.01\nv_after = -1.3\nsequence = [0]\n",
    "orbits": "[orbits]\nmax_impacts = 1\nmax_periods = 1\neffort = 0.5\n",
    "branch": '[orbit]\n[branch]\nlargest_step = 0.1\n[over]\n"forcing.amplitude" = [1, "0.09"]\n',
    "curve": '[over]\n"forcing.amplitude" = ["0.09", 1]\n"forcing.omega" = ["0.99", "1.01"]\n'
    '[curve]\npoints = ["grazing"]\n',
    "response": '[over]\n"forcing.omega" = [1, "1.5"]\n'
    "[response]\nmax_impacts = 1\nmax_periods = 1\nn_seeds = 1\n",
    "sweep": '[sweep]\nmeasure = ["period", "peak_displacement"]\ntransient = 60\nperiods = 8\n'
    '[over]\n"forcing.omega" = {from = "0.9", to = "1.1", count = 3}\n"start.v0" = [0, "1/3"]\n',
    "diagram": "[diagram]\nstarts = [[0, 1], [0, 0, 'pi']]\ntransient = 20\npoints = 8\n"
    '[over]\n"forcing.omega" = {from = "0.9", to = "1.1", count = 3}\n',
    "basins": "[basins]\nx0 = {from = -1, to = 1, count = 3}\nv0 = [0, 1]\nperiods = 80\n",
    "lyapunov": "[lyapunov]\ntransient = 10\nperiods = 64\n",
    "design": '[design]\noutcome = "peak_impact_velocity"\nrestarts = 0\n'
    '[design.free]\n"oscillator.stops.0.restitution" = ["0.7", "0.9"]\n',
    # A free motion that meets the wall once, which gives the damping and the restitution.
    "fit": '[fit.free]\n"oscillator.damping" = 0.1\n"oscillator.stops.0.restitution" = [0.5, 0.9]\n'
    f"[[fit.records]]\nnoise = 0.01\nt = {T}\ndisplacement = {X}\n",
}


def study_of(kind: str) -> Study:
    more = "manifolds = true\n" if kind == "basins" else ""
    return parse_study(
        f'{MODEL}{more}{QUESTIONS[kind]}[study]\nkind = "{kind}"\ntitle = "A $ {kind}"\n'
    )


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> dict[str, tuple[Study, StudyResult]]:
    folder = tmp_path_factory.mktemp("studies")
    studies = {kind: study_of(kind) for kind in kind_names()}
    return {kind: (study, run_study(study, folder / kind, command="percuss run x.toml"))
            for kind, study in studies.items()}  # fmt: skip


Done = dict[str, tuple[Study, StudyResult]]


@pytest.mark.parametrize("kind", kind_names())
def test_a_study_is_read_back_equal_from_its_text(kind: str) -> None:
    study = study_of(kind)

    again = parse_study(study.text())

    assert study.kind == kind
    assert again == study
    assert again.text() == study.text()


@pytest.mark.parametrize("kind", kind_names())
def test_all_its_files_are_written_and_hold_the_study(kind: str, done: Done) -> None:
    study, result = done[kind]

    assert result.is_whole
    folder = result.files[0].parent
    assert result.files == output_files(study, folder)
    assert {path.name for path in folder.iterdir()} == {file.name for file in result.files}
    assert {".nc", ".csv"} <= {file.suffix for file in result.files}
    for file in result.files:
        assert load_study(file) == study
        assert load_record(file).command == "percuss run x.toml"


@pytest.mark.parametrize("kind", [kind for kind in kind_names() if kind != "lyapunov"])
def test_a_picture_is_drawn(kind: str, done: Done) -> None:
    pictures = [file for file in done[kind][1].files if file.suffix == ".png"]

    assert pictures
    assert all(file.stat().st_size > 10_000 for file in pictures)


@pytest.mark.parametrize("kind", kind_names())
def test_the_report_has_short_lines(kind: str, done: Done) -> None:
    report = done[kind][1].report

    assert report
    assert all(report.values())
    assert all(len(line) < 250 for words in report.values() for line in words.splitlines())


@pytest.mark.parametrize("kind", [kind for kind in kind_names() if kind != "motion"])
def test_its_answer_is_what_the_function_of_that_name_returns(kind: str, done: Done) -> None:
    study, result = done[kind]
    osc, force = study.oscillator, study.forcing

    loaded = load_netcdf(result.files[0])

    if kind == "orbit":
        orbit = pc.find_orbit(osc, force, guess=(0.01, -1.3))
        assert loaded.impacts.v_after[0] == orbit.impacts.v_after[0]
    elif kind == "orbits":
        assert [it.v0 for it in loaded] == [it.v0 for it in pc.find_orbits(osc, force, 1, 1)]
    elif kind == "branch":
        assert [point.kind for point in loaded.special_points][:2] == ["fold", "grazing"]
        assert loaded.special_points[1].value == pytest.approx(0.1, abs=1e-12)
    elif kind == "curve":
        # Where the orbit without impacts touches the wall.
        (curve,) = loaded
        amplitude, omega = curve.values.T
        grazing = np.hypot(1.0 - omega**2, 0.1 * omega)
        np.testing.assert_allclose(amplitude, grazing, atol=1e-10)
    elif kind == "response":
        assert [(f.n_impacts, f.n_periods) for f in loaded.families][-1] == (1, 1)
    elif kind == "sweep":
        assert loaded.period.dims == ("forcing.omega", "start.v0")
        np.testing.assert_array_equal(loaded["forcing.omega"], [0.9, 1.0, 1.1])
        np.testing.assert_array_equal(loaded["start.v0"], [0.0, 1 / 3])
        assert (loaded.period.values == 1).all()
    elif kind == "diagram":
        names = ["forward", "backward", "start 0", "start 1"]
        assert loaded.branch.values.tolist() == names
        assert loaded.x.shape == (4, 3, 8)
    elif kind == "basins":
        assert loaded.n_impacts.values.tolist() == [1.0]
        assert (loaded.basin.values == 0).all()
    elif kind == "fit":
        data = {"t": np.array(T), "displacement": np.array(X)}
        free: dict[str, Any] = {
            "oscillator.damping": 0.1,
            "oscillator.stops.0.restitution": (0.5, 0.9),
        }
        fit = pc.fit(data, osc, force, free=free, noise=0.01)
        assert loaded["value"].values.tolist() == list(fit.values.values())
        np.testing.assert_allclose(loaded["value"], [0.05, 0.8], atol=1e-3)
    elif kind == "design":
        free = {"oscillator.stops.0.restitution": (0.7, 0.9)}
        best = pc.design("peak_impact_velocity", osc, force, free=free, restarts=0)
        assert loaded["best"]["value"].values.tolist() == [best.value, *best.values.values()]
        np.testing.assert_array_equal(loaded["motion"]["x"], best.run.sample(2001)["x"])
    else:
        # Both multipliers have the modulus sqrt(det) = r exp(-2 pi a) in a period of 2 pi.
        rate = np.log(0.8) / (2.0 * np.pi) - 0.05
        np.testing.assert_allclose(loaded.exponent, rate, rtol=1e-9)
        assert float(loaded.total) == pytest.approx(2.0 * rate, rel=1e-9)


def test_a_study_without_any_picture_or_table_writes_only_what_it_says(tmp_path: Path) -> None:
    text = QUESTIONS["orbit"] + "[save]\ncsv = false\nsamples = 5\n"
    study = parse_study(f'{MODEL.replace("svg", "png = false; svg")}'.replace("; ", "\n") + text
                        + '[study]\nkind = "orbit"\n')  # fmt: skip

    run_study(study, tmp_path)

    assert [path.name for path in tmp_path.iterdir()] == ["orbit.nc"]


def test_a_store_is_for_many_motions_only(tmp_path: Path) -> None:
    with pytest.raises(
        ParameterError, match="for studies of many motions and of fits; this one is of kind orb"
    ):
        run_study(study_of("orbit"), tmp_path / "out", store=tmp_path / "a.zarr")
    with pytest.raises(ParameterError, match="for studies of many motions"):
        run_study(study_of("branch"), tmp_path / "out", engine="processes")
    assert list(tmp_path.iterdir()) == []


def long_sweep() -> Study:
    """Return a study of several chunks, of 128 points each."""
    return parse_study(f"""{MODEL}
[study]
kind = "sweep"
[sweep]
measure = "peak_displacement"
transient = 8000
periods = 8
[over]
"start.v0" = {{from = -1, to = 1, count = 600}}
""")


def test_a_run_into_a_store_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
    store, folder = tmp_path / "a.zarr", tmp_path / "out"

    stopped = run_study(long_sweep(), folder, store=store, progress=lambda done, _: done == 0)

    assert not stopped.is_whole
    assert stopped.files == ()
    assert not folder.exists()
    done = pc.status_of_store(store)
    assert 0 < done["points_done"] < done["points"] == 600

    seen: list[float] = []

    def watch(done: float, _: float) -> bool:
        seen.append(done)
        return True

    resumed = run_study(long_sweep(), folder, store=store, progress=watch)

    assert resumed.is_whole
    assert seen[0] >= done["points_done"]
    whole = run_study(long_sweep(), tmp_path / "whole")
    np.testing.assert_array_equal(resumed.answer.peak_displacement, whole.answer.peak_displacement)


def test_a_run_without_a_store_that_is_stopped_is_written_as_far_as_it_came(tmp_path: Path) -> None:
    result = run_study(long_sweep(), tmp_path / "out", progress=lambda done, _: done == 0)

    assert not result.is_whole
    outcome = load_record(result.files[0]).outcome
    assert outcome == "it was interrupted; it holds what was done"
    missing = np.isnan(load_netcdf(result.files[0]).peak_displacement)
    assert 0 < int(missing.sum()) < 600
    # What goes to a log says so, too.
    assert result.report["outcome"] == "interrupted; what was not done is left empty"


def test_a_store_of_another_study_is_refused(tmp_path: Path) -> None:
    run_study(study_of("sweep"), tmp_path / "a", store=tmp_path / "a.zarr")

    other = parse_study(study_of("sweep").text().replace("periods = 8", "periods = 9"))
    with pytest.raises(OutputError, match="holds another study, which differs in periods"):
        run_study(other, tmp_path / "b", store=tmp_path / "a.zarr")
    assert not (tmp_path / "b").exists()


def test_a_branch_that_is_stopped_is_written_as_far_as_it_came(tmp_path: Path) -> None:
    steps: list[float] = []

    def stop(done: float, _: float) -> bool:
        steps.append(done)
        return len(steps) < 3

    result = run_study(study_of("branch"), tmp_path, progress=stop)

    assert not result.is_whole
    assert 0 < len(result.answer) < len(run_study(study_of("branch"), tmp_path / "whole").answer)
    assert len(load_netcdf(result.files[0])) == len(result.answer)


def test_a_branch_without_special_points_has_no_curves_and_all_files(tmp_path: Path) -> None:
    text = template_text("curve").replace("max_points = 2000", "max_points = 2")

    result = run_study(parse_study(text), tmp_path)

    assert result.answer == []
    assert result.report == {"curves": "none: no such points on the branch"}
    assert {path.name for path in tmp_path.iterdir()} == {file.name for file in result.files}
    assert (tmp_path / "curves.csv").read_text().startswith("curve")


FOLDS = """\
[study]
kind = "curve"
[oscillator]
damping = "0.03"
[[oscillator.stops]]
type = "soft"
at = 1
side = "above"
stiffness = 9
[[forcing.harmonics]]
amplitude = "0.66"
omega = "1.2"
[orbit]
[over]
"forcing.omega" = ["1.2", "1.7"]
"oscillator.stops.0.at" = ["0.4", "1.1"]
[curve]
points = ["fold"]
[branch]
largest_step = 0.1
"""


@pytest.mark.parametrize(
    ("ends", "reason", "count"),
    [
        # Followed from either fold, over their cusp; the third is another curve.
        ([(1.46, 1.1), (1.26, 1.1)], "reached", 1),
        ([(1.26, 1.1), (1.46, 1.1)], "reached", 1),
        ([(1.46, 1.1), (1.27, 1.1)], "reached", 2),
        ([], "the curve closed", 1),
    ],
)
def test_a_curve_with_two_points_of_the_branch_is_there_once(
    monkeypatch: pytest.MonkeyPatch, ends: list[tuple[float, float]], reason: str, count: int
) -> None:
    first = [(1.46, 1.1), (1.26, 1.1)]
    if reason == "the curve closed":
        # The same extent, begun elsewhere.
        first, ends = [*first, (1.3, 0.6)], [(1.3, 0.6), (1.26, 1.1), (1.46, 1.1)]
    made = iter([first, ends])

    def followed(point: Any, *_: Any, **__: Any) -> SimpleNamespace:
        return SimpleNamespace(kind=point.kind, values=np.array(next(made)), end_reason=reason)

    monkeypatch.setattr("percuss.studies.kinds.curve.continue_curve", followed)
    study = parse_study(FOLDS)
    assert len(study.question.answer(study, Execution())) == count


OVER_STARTS = """[basins]
periods = 80
[start]
x0 = 0
v0 = 0
t0 = "0.3"
[over]
"start.x0" = {from = -1, to = 1, count = 3}
"start.v0" = {from = 0, to = 1, count = 2}
"""


@pytest.mark.parametrize("zero", ["stiffness", "amplitude"])
def test_a_response_that_is_stopped_before_any_branch_or_at_rest_has_all_its_files(
    zero: str, tmp_path: Path
) -> None:
    text = re.sub(f"(?m)^{zero} = .*", f"{zero} = 0", template_text("response"))
    result = run_study(parse_study(text), tmp_path, progress=lambda *_: False)

    assert not result.is_whole
    assert all(file.exists() for file in result.files)


def test_forces_beyond_the_largest_double_are_written_without_a_warning(tmp_path: Path) -> None:
    text = template_text("backlash").replace("at = -1 ", "at = -1e308 ")
    study = parse_study(text.replace("png = true", "png = false").replace("svg = true", ""))

    assert run_study(study, tmp_path).is_whole


def test_basins_over_numbers_of_the_start_are_those_of_their_short_forms() -> None:
    study = parse_study(kind_of("basins") + MODEL + OVER_STARTS)
    data = study.question.answer(study, Execution())
    assert parse_study(study.text()) == study
    spans = '[basins]\nt0 = "0.3"\nperiods = 80\nx0 = {from = -1, to = 1, count = 3}\n'
    short = parse_study(kind_of("basins") + MODEL + spans + "v0 = {from = 0, to = 1, count = 2}\n")
    assert link_of(study) == link_of(short)
    expected = pc.basins(
        study.oscillator, study.forcing, x0=[-1, 0, 1], v0=[0, 1], t0="0.3", periods=80
    )
    np.testing.assert_array_equal(data.basin, expected.basin)
    assert data.basin.dims == ("start.x0", "start.v0")
    for wrong, fault in (
        (OVER_STARTS.replace("start.v0", "forcing.omega"), "no number of the start; a basin is"),
        (OVER_STARTS.replace("periods", "x0 = [1]\nperiods"), "given together with [over]"),
        ("[basins]\nx0 = [0]\nv0 = [1]\n[start]\nx0 = 0\nv0 = 0\n", "give t0 there"),
    ):
        with pytest.raises(Exception, match=re.escape(fault)):
            parse_study(kind_of("basins") + MODEL + wrong)


def kind_of(kind: str) -> str:
    return f'[study]\nkind = "{kind}"\n'


def test_a_record_that_no_link_holds_is_refused_with_its_numbers() -> None:
    run = "[start]\nx0 = 0\nv0 = 0\n[run]\nt_end = 1\n"
    for n, is_short in ((1000, True), (20_000, False)):
        samples = ", ".join(str(0.1 * k) for k in range(n))
        record = f"[forcing.record]\nt = [{samples}]\nf = [{samples}]\n"
        study = parse_study(kind_of("motion") + MODEL.replace("[draw]", record + "[draw]") + run)
        if is_short:
            assert link_of(study)
            continue
        with pytest.raises(
            ParameterError, match=r"20000 samples.* kB; links of the page hold 56 kB"
        ):
            link_of(study)
