"""The option --certify."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.cli.commands import percuss

from percuss.studies import Certify, load_study, template_text

pytest.importorskip("flint")

KINDS = "for studies of kind motion, orbit and branch"


def test_option_proves_and_stands_in_the_record() -> None:
    Path("s.toml").write_text(template_text("impact"), encoding="utf-8")

    status, out, err = percuss("run", "s.toml", "--certify", "15")

    assert (status, err) == (0, "")
    assert "certified       20 impacts up to t = [41.88790204" in out
    assert "proof           proven up to t_end" in out
    assert Path("s/certified.csv").exists()
    assert load_study("s/certified.png").certify == Certify(15)
    # Repeating a file proves again.
    assert percuss("run", "s/motion.nc", "--out", "again")[0] == 0
    assert Path("again/certified.svg").exists()


@pytest.mark.parametrize(
    ("template", "digits", "sentence"),
    [
        ("impact", "0", "certify.digits = 0: not a whole number from 1 to 1000\n"),
        (
            "basins",
            "12",
            f"certify = 12: {KINDS}; this one is of kind basins\n",
        ),
    ],
)
def test_what_cannot_be_is_one_sentence(template: str, digits: str, sentence: str) -> None:
    Path("s.toml").write_text(template_text(template), encoding="utf-8")

    assert percuss("run", "s.toml", "--certify", digits) == (2, "", sentence)
    assert not Path("s").exists()
