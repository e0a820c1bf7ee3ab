"""Impact times that are Y_m exactly, for ever, with the constant of the force exactly."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.certified.statements import keeps_subset
from percuss.errors import ParameterError


@pytest.mark.parametrize("m", range(2, 16))
def test_motions_below_the_critical_velocity_keep_to_the_subset_for_ever(m: int) -> None:
    limit = pc.subset_critical_velocity(m)

    for part in (0.01, 0.3, 0.7, 1 - 1e-9):
        verdict = keeps_subset(m, part * limit)
        assert verdict.holds is True, (part, verdict)
        assert math.isinf(verdict.n_impacts)
    for part in (1 + 1e-9, 1.2, 3.0):
        assert keeps_subset(m, part * limit).holds is False, part


def test_table_1_of_the_paper() -> None:
    for m, v in {5: 1.5, 7: 0.984, 9: 0.675, 11: 0.486, 13: 0.365, 15: 0.283}.items():
        assert keeps_subset(m, v - 0.0005).holds is True
        assert keeps_subset(m, v + 0.0005).holds is False


@pytest.mark.parametrize("m", [2, 4])
def test_an_impact_without_velocity_is_open(m: int) -> None:
    # At V* = 2q of even m, which no fraction but that of a double next to it is.
    assert keeps_subset(2, 0).holds is None
    assert keeps_subset(m, pc.subset_critical_velocity(m) * (1 + 1e-15)).holds in (False, None)


def test_a_verdict_agrees_with_runs() -> None:
    for m in (2, 3, 6, 7):
        force = pc.subset_forcing(m)
        for v0 in np.linspace(0.05, 2.3, 14):
            run = pc.simulate(pc.impact_oscillator(), force, v0=float(v0), max_impacts=8)
            expected = pc.SubsetMotion(m, 0).impact_times(8)
            on = bool(np.abs(run.impacts.t - expected).max() < 1e-8)
            assert keeps_subset(m, float(v0)).holds is on, (m, v0)


@pytest.mark.parametrize("m", [1, 0, 2.5])
def test_other_numbers_are_refused(m: int) -> None:
    with pytest.raises(ParameterError):
        keeps_subset(m, 1)


def test_a_start_into_the_wall_is_refused() -> None:
    with pytest.raises(ParameterError, match="into the wall"):
        keeps_subset(3, -1)
