"""An irregular sea holds the energy of its spectrum."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.model.sea_state import HIGHEST, LOWEST, SeaKind, sea_faults, spectrum_at


@pytest.mark.parametrize("kind", ["jonswap", "pierson-moskowitz"])
def test_the_sea_has_its_wave_height_and_its_peak(kind: SeaKind) -> None:
    sea = pc.sea_state(3.0, 9.0, kind, n=500, seed=2)
    amplitude = np.array([float(h.amplitude) for h in sea.harmonics])  # type: ignore[union-attr]
    omega = np.array([float(c.omega) for c in sea.components()])
    assert 4.0 * math.sqrt(0.5 * (amplitude**2).sum()) == pytest.approx(3.0, rel=1e-14)
    peak = 2.0 * math.pi / 9.0
    assert omega[amplitude.argmax()] == pytest.approx(peak, rel=0.02)
    assert LOWEST * peak <= omega.min() < omega.max() <= HIGHEST * peak
    assert (np.diff(omega) > 0.0).all()
    assert sea.period is None


def test_height_and_period_of_a_sea_may_be_parameters() -> None:
    tp, hs = pc.parameter("tp", 9), pc.parameter("hs", "2.5")
    tied = pc.parameter("a", "20e3") * pc.sea_state(hs, tp, n=30, seed=3)
    plain = 20e3 * pc.sea_state("2.5", 9, n=30, seed=3)
    for mine, theirs in zip(tied.components(), plain.components(), strict=True):
        assert mine.cos == pytest.approx(theirs.cos, rel=1e-14, abs=1e-11)
        assert float(mine.omega) == pytest.approx(float(theirs.omega), rel=1e-15)
    assert tied.constant == 0
    buoy = pc.Oscillator.from_mass(50e3, 20e3, 4e3, stops=(pc.SoftStop(0.5, "above", 400e3, 10e3),))
    found = pc.sweep("peak_stop_force", buoy, tied, over={"tp": [8, "10.5"]}, between=(0, 60))
    for value, pull in zip(("8", "10.5"), found.peak_stop_force.values, strict=True):
        sea = 20e3 * pc.sea_state("2.5", value, n=30, seed=3)
        run = pc.simulate(buoy, sea, t_end=60)
        assert pull == pytest.approx(-run.extremes("stop_force").minimum, rel=1e-9)


def test_the_band_holds_nearly_all_of_the_energy() -> None:
    """Of the Pierson-Moskowitz spectrum in closed form: exp(-1.25 w^-4) of it lies below w."""
    share = math.exp(-1.25 * HIGHEST**-4) - math.exp(-1.25 * LOWEST**-4)
    assert share > 0.995
    w = np.linspace(LOWEST, HIGHEST, 200_001)
    values = np.array([spectrum_at(float(x), "pierson-moskowitz") for x in w[::10]])
    step = float(w[10] - w[0])
    integral = step * (values.sum() - 0.5 * (values[0] + values[-1]))
    assert integral == pytest.approx(share / 5.0, rel=1e-6)


def test_a_seed_gives_a_sea_and_another_another() -> None:
    assert pc.sea_state(2, 8, seed=5) == pc.sea_state(2, 8, seed=5)
    assert pc.sea_state(2, 8, seed=5) != pc.sea_state(2, 8, seed=6)
    # The generator of NumPy and the arithmetic of this package: the same on every machine.
    first = pc.sea_state(2, 8, n=3, seed=0).harmonics[0]
    assert repr(first) == repr(pc.sea_state("2", 8.0, n=3).harmonics[0])


@pytest.mark.parametrize(
    ("given", "name"),
    [
        ({"hs": 0}, "hs"),
        ({"tp": -1}, "tp"),
        ({"kind": "neumann"}, "kind"),
        ({"n": 0}, "n"),
        ({"n": 10**6}, "n"),
        ({"seed": -1}, "seed"),
        ({"hs": "high"}, "hs"),
    ],
)
def test_what_is_no_sea_is_told(given: dict[str, object], name: str) -> None:
    with pytest.raises(pc.ParameterError, match=f"^{name} = "):
        pc.sea_state(**({"hs": 2, "tp": 8} | given))  # type: ignore[arg-type]


def test_all_faults_of_a_sea_are_told_at_once() -> None:
    found = sea_faults("high", 0, "neumann", 0, -1)
    assert [fault.name for fault in found] == ["hs", "tp", "kind", "n", "seed"]
