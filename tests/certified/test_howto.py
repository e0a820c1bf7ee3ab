"""What the how-to shows runs, and the example and the benchmark say what they should."""

from __future__ import annotations

import re
import runpy
import sys
from pathlib import Path

import pytest
from benchmarks.certified import growth_in_bits

import percuss as pc

ROOT = Path(__file__).parents[2]


BLOCKS = re.findall(
    r"```python\n(.*?)```",
    (ROOT / "docs" / "certified-howto.md").read_text(encoding="utf-8"),
    flags=re.DOTALL,
)
# What the blocks show, by their numbers.
SHOWN = {
    0: ("429.795037514336",),
    4: ("True True True asymptotic",),
    6: ("6 impacts in 6 periods",),
    7: ("True [31.41592653589793238462643383279502884197169",),
    8: ("certified: 2 flights end on Y_5",),
    10: ("loops of 1 and 10 and 12 impacts, topological entropy >= 0.214584",),
    12: ("2 orbits with 1 impact in 1 period, all that there are", "asymptotic"),
    13: ("64 cells, proven basins of",),
    15: ("symmetry_breaking at forcing.harmonics.0.amplitude = [0.593424241364",),
    17: (
        "certified: the first two flights",
        "certified: the last impact is at the start's zero",
    ),
}
# The same chaos is proven twice; the second time it is written to a file.
AGAIN = 16


@pytest.mark.parametrize(
    "k",
    [pytest.param(k, marks=pytest.mark.nightly) if k == AGAIN else k for k in range(len(BLOCKS))],
)
def test_the_code_of_the_howto_runs(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, k: int
) -> None:
    monkeypatch.chdir(tmp_path)

    exec(compile(BLOCKS[k], "certified-howto.md", "exec"), {})  # noqa: S102  our own text

    shown = capsys.readouterr().out
    for text in SHOWN.get(k, ()):
        assert text in shown


def test_the_howto_shows_all_that_is_looked_at() -> None:
    assert len(BLOCKS) == 18
    assert "save_certificate" in BLOCKS[AGAIN]


def test_the_example_tells_where_doubles_lose_the_motion(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(sys, "argv", ["certified.py", "--impacts", "160"])

    runpy.run_path(str(ROOT / "examples" / "certified.py"), run_name="__main__")

    assert "Doubles have lost the motion from impact 1" in capsys.readouterr().out


def test_the_benchmark_counts_the_bits_that_a_known_exponent_demands() -> None:
    # The multipliers of a 1/1 orbit are its growth an impact.
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.8"))
    run = orbit.trajectory(12)
    proven = pc.certify(
        pc.simulate(orbit.oscillator, orbit.forcing, 0, orbit.v0, orbit.t0, max_impacts=12)
    )

    bits = growth_in_bits(proven) / 12

    assert len(run.impacts) == 12
    assert abs(2**bits / abs(orbit.multipliers[0]) - 1) < 0.2
