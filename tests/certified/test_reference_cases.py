from __future__ import annotations

import json
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from flint import arb
from tests import reference
from tests.reference.measures import MEASURES, Case, load_cases

import percuss as pc
from percuss.certified import Balls, CertifiedRun

ROWS = {
    row["id"]: row
    for row in json.loads((Path(reference.__file__).parent / "cases.json").read_text("utf-8"))
}


class Columns:
    """A certified run whose columns are arrays of balls, as the measures read them."""

    def __init__(self, run: CertifiedRun) -> None:
        self.impacts = _Table(run.impacts)
        self.crossings = _Table(run.crossings)
        self.contacts = _Table(run.contacts)
        self.run = run

    def __call__(self, t: Any) -> tuple[arb, arb]:
        x, v = self.run(float(t))
        return x.arbs[0], v.arbs[0]


class _Table:
    def __init__(self, table: Any) -> None:
        for name in table.__dataclass_fields__:
            value = getattr(table, name)
            arrays = np.array(value.arbs, dtype=object) if isinstance(value, Balls) else value
            setattr(self, name, arrays)


@pytest.mark.parametrize("case", load_cases(), ids=lambda case: case.id)
def test_every_reference_value_lies_inside_its_enclosure(case: Case) -> None:
    x0, v0, t0 = case.start()
    run = pc.simulate(case.oscillator(), case.force(), x0, v0, t0, **case.limits())

    proven = pc.certify(run, start=pc.Start(x0, v0, t0), **case.limits())

    assert proven.complete, proven
    found = MEASURES[case.id](Columns(proven))
    written = ROWS[case.id]["value"]
    numbers = [str(n) for n in (written if isinstance(written, list) else [written])]
    for ball, number in zip(found if isinstance(found, list) else [found], numbers, strict=True):
        if isinstance(ball, arb):
            assert ball.rad() < 1e-11
            assert ball.overlaps(_rounded(number)), (ball, number)
        else:
            # Worked out from floats on the way.
            assert abs(ball - float(number)) < case.tolerance


def test_doubles_lose_a_motion_that_balls_keep() -> None:
    row = ROWS["elastic-long-w2.7-exact"]
    run = pc.simulate(pc.impact_oscillator(), pc.sine("2.7"), v0="0.3", max_impacts=200)

    proven = pc.certify(run, digits=16)

    for k, number in zip((100, 200), row["value"], strict=True):
        assert proven.impacts.t[k - 1].arb.overlaps(_rounded(number))
        assert proven.impacts.t[k - 1].radius() < 1e-12
    # The run of doubles is off by half a flight at the end, and so is the proof of its own start.
    of_doubles = pc.certify(run, start=pc.Start(run.x0, run.v0, run.t0), max_impacts=200)
    assert abs(of_doubles.impacts.t.mid()[99] - proven.impacts.t.mid()[99]) > 1e-12
    assert abs(run.impacts.t[199] - proven.impacts.t.mid()[199]) > 0.01


def _rounded(number: str) -> arb:
    """Return a ball of the numbers that are written so."""
    digits = number.partition("e")[0].partition(".")[2]
    exponent = int(number.partition("e")[2] or 0)
    half = Fraction(1, 2) * Fraction(10) ** (exponent - len(digits))
    return arb(number) + arb(0, float(half) * 1.001) if digits else arb(number)
