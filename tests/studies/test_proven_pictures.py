"""Pictures of what was proven of orbits and of branches."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

import percuss as pc
from percuss.studies import Branch, Certify, Orbit, Sought, Study, run_study
from percuss.studies.tables import Draw

pytest.importorskip("flint")

PNG = Draw(svg=False)


@pytest.mark.parametrize(
    ("question", "omega"),
    [
        (Orbit(), "2.5"),
        # Nothing is proven of an impact without velocity; the picture says so.
        (Orbit(), "0.5"),
        (Branch(Sought(), {"forcing.omega": ("2.3", "2.8")}), "2.5"),
        (Branch(Sought(), {"forcing.omega": ("2.45", "2.55")}), "2.5"),
    ],
)
def test_a_picture_is_written_whatever_was_proven(
    tmp_path: Path, question: Orbit | Branch, omega: str
) -> None:
    osc = pc.impact_oscillator("0.8")
    study = Study(osc, pc.cosine(omega), question, draw=PNG, certify=Certify())

    result = run_study(study, tmp_path)

    assert "certified" in result.report
    assert (tmp_path / "certified.png").stat().st_size > 10_000
    bare = run_study(replace(study, certify=None), tmp_path / "bare")
    assert not any("certified" in file.name for file in bare.files)
