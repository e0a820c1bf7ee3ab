from __future__ import annotations

import percuss as pc
from percuss.io.study_text import motion_text


def test_an_exact_end_is_written_as_it_was_given() -> None:
    run = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.51", t_end="20*pi")

    assert run.end == "20*pi"
    assert 't_end = "20*pi"' in motion_text(run)
