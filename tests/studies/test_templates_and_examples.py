"""Every study file that comes with percuss runs, and is what it says."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.errors import ParameterError
from percuss.execution import Execution
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Trajectory
from percuss.studies.kinds.motion import Motion
from percuss.studies.reading import load_study, parse_study
from percuss.studies.study import Study, kind_names
from percuss.studies.templates import template_names, template_text

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))


def answer_of(study: Study) -> Trajectory | StructureTrajectory:
    assert isinstance(study.question, Motion)
    return study.question.answer(study, Execution())


def run_of(study: Study) -> Trajectory:
    run = answer_of(study)
    assert isinstance(run, Trajectory)
    return run


def motions(names: Iterable[str]) -> list[str]:
    return [name for name in names if parse_study(template_text(name)).kind == "motion"]


MOTIONS = motions(template_names())


def example(name: str) -> Study:
    (path,) = (path for path in EXAMPLES if path.stem == name)
    return load_study(path)


@pytest.mark.parametrize("name", MOTIONS)
def test_a_template_runs_to_its_end_and_meets_its_stops(name: str) -> None:
    study = parse_study(template_text(name))

    run = answer_of(study)

    assert run.outcome.name == "reached_t_end"
    assert len(run.impacts) + len(run.crossings) >= 10


@pytest.mark.parametrize("name", MOTIONS)
def test_the_ends_that_a_template_names_are_those_of_its_periods(name: str) -> None:
    text = template_text(name)

    t_end = float(text.split("or t_end = ")[1].split()[0])

    study = parse_study(text)
    assert isinstance(study.question, Motion)
    assert study.question.t_end(study.force) == pytest.approx(t_end, abs=0.05)


@pytest.mark.parametrize("name", template_names())
def test_what_a_template_calls_a_default_is_one(name: str) -> None:
    text = template_text(name)

    short = text[: text.index("# The rest is optional")]

    assert parse_study(short) == parse_study(text)


@pytest.mark.parametrize("kind", [kind for kind in kind_names() if kind != "motion"])
def test_every_kind_has_a_template_of_its_name(kind: str) -> None:
    assert parse_study(template_text(kind)).kind == kind


def test_an_unknown_template_is_refused_with_the_known_ones() -> None:
    with pytest.raises(ParameterError, match="backlash, ball, basins, bilinear, branch, curve"):
        template_text("spring")


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_every_example_says_what_it_is_and_how_to_run_it(path: Path) -> None:
    study = load_study(path)

    assert study.title
    assert f"percuss run {path.name}" in path.read_text()
    if study.kind == "motion":
        assert run_of(study).outcome.name == "reached_t_end"


def test_the_third_harmonic_stays_on_the_eigenset_above_its_critical_velocity() -> None:
    """Dyskin et al. 2012, fig. 6a."""
    run = run_of(example("n3_above"))

    assert pc.classify_impact_times(run).kind == "eigenset"
    # 30 impacts in [0, 30 pi]: the last one at its very end.
    np.testing.assert_allclose(run.impacts.t, np.arange(1, 31)[: len(run.impacts)] * math.pi)
    np.testing.assert_allclose(run.impacts.v_after, 0.51, rtol=1e-12)


def test_the_third_harmonic_leaves_the_eigenset_below_its_critical_velocity() -> None:
    """Dyskin et al. 2012, fig. 6b."""
    assert pc.classify_impact_times(run_of(example("n3_below"))).kind != "eigenset"


def test_the_half_harmonic_grows_like_the_square_root_of_time() -> None:
    """Dyskin et al. 2012, figs 10 and 11: 0.61 sqrt(t), fitted by eye."""
    impacts = run_of(example("half_harmonic")).impacts

    late = impacts.t > 200.0
    assert impacts.v_after[late] == pytest.approx(0.61 * np.sqrt(impacts.t[late]), rel=0.12)


def test_the_moored_buoy_slams_into_its_line_once_a_wave_in_the_end() -> None:
    run = run_of(example("mooring"))

    entries = run.crossings.t[run.crossings.direction == "in"]
    assert np.diff(entries[-10:]) == pytest.approx(2 * math.pi / 0.7854, rel=1e-2)


def test_the_example_of_the_ball_is_the_ball_on_a_table() -> None:
    osc, force = pc.ball_on_table(1, 120, gravity=9810, restitution="0.8")
    study = example("ball")

    table = pc.simulate(osc, force, x0=5, v0=-120, t_end=1)

    np.testing.assert_array_equal(run_of(study).impacts.t, table.impacts.t)


def test_the_mooring_in_engineers_units_is_that_of_unit_mass() -> None:
    study = example("mooring")

    line = pc.SoftStop("0.5", "above", 8.0, Fraction(1, 10))
    unit = study.oscillator.of_unit_mass()
    assert unit == pc.Oscillator(Fraction(2, 5), Fraction(1, 25), (line,))
    assert study.forcing is not None
    wave = study.forcing.acceleration_of(study.oscillator.mass)
    assert wave.components() == pc.cosine("0.7854", amplitude="0.8").components()


def test_the_mooring_of_the_how_to_is_that_of_the_example(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    page = Path(__file__).parents[2] / "docs" / "howto" / "moorings.md"
    first = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), re.DOTALL)[0]
    monkeypatch.chdir(tmp_path)
    reported: dict[str, Any] = {}
    exec(compile(first, str(page), "exec"), reported)  # noqa: S102  our own text

    run, own = reported["run"], run_of(example("mooring"))

    assert run.t_end == own.t_end
    assert len(run.crossings) == len(own.crossings)
    np.testing.assert_allclose(run.crossings.t, own.crossings.t, rtol=0, atol=1e-8)
    assert (
        reported["buoy"].of_unit_mass().damping
        == example("mooring").oscillator.of_unit_mass().damping
    )


@pytest.mark.parametrize("name", MOTIONS)
def test_a_template_says_what_max_impacts_counts(name: str) -> None:
    (line,) = (line for line in template_text(name).splitlines() if "max_impacts" in line)

    assert line.endswith("counts impacts and entries into soft stops")
