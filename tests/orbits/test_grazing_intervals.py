"""When the force leads a mass off a stop."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from numpy.typing import NDArray

import percuss as pc
from percuss.model.system import law
from percuss.orbits.surface.grazing_intervals import grazing_intervals

OSC = pc.impact_oscillator()


def inside_of(
    intervals: Sequence[tuple[float, float]], t: NDArray[np.float64], period: float
) -> NDArray[np.bool_]:
    """Return which instants of a period lie in intervals that begin in it."""
    inside = np.zeros(len(t), dtype=np.bool_)
    for begin, end in intervals:
        assert 0.0 <= begin < period
        inside |= (t > begin) & (t < end)
        inside |= (t + period > begin) & (t + period < end)
    return inside


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_intervals_are_those_of_the_sign_on_a_fine_grid(seed: int, sign: float) -> None:
    rng = np.random.default_rng(seed)
    cos, sin = rng.normal(size=(2, 1 + seed))
    constant = float(rng.normal())
    force = pc.fourier(1.3, cos=tuple(cos), sin=tuple(sin))
    assert force.period is not None
    t = (np.arange(20_000) + 0.5) / 20_000 * force.period
    phases = 1.3 * np.outer(t, np.arange(1, 2 + seed))
    value = constant + np.cos(phases) @ cos + np.sin(phases) @ sin

    intervals = grazing_intervals(law(OSC, force), constant, sign)

    inside = inside_of(intervals, t, force.period)
    np.testing.assert_array_equal(inside, sign * value > 0.0)


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_intervals_under_a_record_are_those_of_the_sign_on_a_fine_grid(
    seed: int, sign: float
) -> None:
    rng = np.random.default_rng(seed)
    instants = -0.4 + np.cumsum(rng.uniform(0.1, 1.0, 6 + seed))
    samples = rng.normal(size=6 + seed)
    force = pc.record(instants, samples, "hold" if seed % 2 else "linear", repeat=True)
    assert force.period is not None
    constant = float(rng.normal())
    if seed > 3:
        tone = pc.cosine(2 * np.pi / force.period, amplitude=1.5)
        assert force.record is not None
        force = pc.Forcing(tone.harmonics, period=force.record.period, record=force.record)
    assert force.period is not None
    t = (np.arange(20_000) + 0.5) / 20_000 * force.period
    free = pc.simulate(pc.Oscillator(), force, t_end=force.period)
    value = constant + free.forces(t)["forcing"].values

    intervals = grazing_intervals(law(OSC, force), constant, sign)

    inside = inside_of(intervals, t, force.period)
    np.testing.assert_array_equal(inside, sign * value > 0.0)


def test_force_that_has_a_double_zero_leads_off_all_but_one_instant() -> None:
    table = law(OSC, pc.cosine(1.0))

    lengths = [end - begin for begin, end in grazing_intervals(table, 1.0, 1.0)]
    assert sum(lengths) == pytest.approx(2.0 * np.pi, abs=1e-6)
    assert sum(end - begin for begin, end in grazing_intervals(table, 1.0, -1.0)) < 1e-6


def test_force_of_one_sign_leads_off_always_or_never() -> None:
    table = law(OSC, pc.cosine(2.0, amplitude=0.3))

    assert grazing_intervals(table, 1.0, 1.0) == [(0.0, np.pi)]
    assert grazing_intervals(table, 1.0, -1.0) == []
    assert grazing_intervals(law(OSC, pc.cosine(2.0, amplitude=0.0)), 0.0, 1.0) == []
