"""Pictures of what was proven of orbits and of branches."""

from __future__ import annotations

from pathlib import Path

import pytest

import percuss as pc
from percuss.studies import Branch, Certify, Orbit, Sought, Study, run_study
from percuss.studies.tables import Draw

pytest.importorskip("flint")

PNG = Draw(svg=False)
WALL = pc.impact_oscillator("0.8")


@pytest.mark.parametrize(
    ("question", "osc", "omega"),
    [
        (Orbit(), WALL, "2.5"),
        # The force holds a mass without rebound on its stop: the orbit passes through it.
        (Orbit(), pc.impact_oscillator(0, damping="0.05"), "2"),
        (Branch(Sought(), {"forcing.omega": ("2.3", "2.8")}), WALL, "2.5"),
        (Branch(Sought(), {"forcing.omega": ("2.45", "2.55")}), WALL, "2.5"),
    ],
)
def test_a_picture_is_written_whatever_was_proven(
    tmp_path: Path, question: Orbit | Branch, osc: pc.Oscillator, omega: str
) -> None:
    study = Study(osc, pc.cosine(omega), question, draw=PNG, certify=Certify())

    result = run_study(study, tmp_path)

    assert "certified" in result.report
    assert (tmp_path / "certified.png").stat().st_size > 10_000


def test_without_a_proof_there_is_no_picture_of_one(tmp_path: Path) -> None:
    study = Study(pc.impact_oscillator("0.8"), pc.cosine("2.5"), Orbit(), draw=PNG)

    bare = run_study(study, tmp_path)

    assert not any("certified" in file.name for file in bare.files)
