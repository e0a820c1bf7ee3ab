from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.motion.entries import entry_rows

WALL = pc.impact_oscillator()


@pytest.mark.parametrize(
    ("force", "v0", "kind", "pattern"),
    [
        (None, 1.0, "eigenset", (1, 0)),
        (pc.sine(2), 1.0, "eigenset", (1, 1)),
        (pc.sine(3), 0.51, "eigenset", (2, 3)),
        (pc.sine(3), 0.45, "periodic", None),
        (pc.sine(1), 0.0, "approaching_eigenset", (0, 0)),
    ],
)
def test_impact_times_of_the_paper_are_told_apart(
    force: pc.Forcing | None, v0: float, kind: str, pattern: tuple[int, int] | None
) -> None:
    run = pc.simulate(WALL, force, v0=v0, t_end=400.0)

    answer = pc.classify_impact_times(run)

    assert answer.kind == kind
    if pattern is not None:
        assert (answer.n_impacts, answer.n_periods) == pattern


def test_a_pattern_of_gaps_in_the_eigenset_is_a_subset_of_it() -> None:
    """Equation (10) with m = 2: gaps 2 pi and pi in turn."""
    gaps = np.tile([2.0, 1.0], 20) * math.pi

    answer = pc.classify_impact_times(np.cumsum(gaps), WALL, pc.sine("2/3"))

    assert (answer.kind, answer.n_impacts, answer.n_periods) == ("eigenset_subset", 2, 1)
    assert answer.deviation < 1e-12


def test_a_transient_may_come_before_the_period() -> None:
    osc = pc.impact_oscillator(0.7)
    run = pc.simulate(osc, pc.sine(2.5), v0=2.0, t_end=600.0)

    answer = pc.classify_impact_times(run)

    assert (answer.kind, answer.n_impacts, answer.n_periods) == ("periodic", 1, 1)
    assert answer.n_used < len(run.impacts)


def test_irregular_times_have_no_period() -> None:
    times = np.cumsum(np.random.default_rng(3).uniform(1.0, 5.0, 300))

    assert pc.classify_impact_times(times, WALL, pc.sine(2.0)).kind == "no_period_found"


def test_few_times_show_nothing_and_times_must_increase() -> None:
    assert pc.classify_impact_times([1.0, 2.0, 3.0], WALL).kind == "too_few"
    with pytest.raises(pc.ParameterError, match="increasing"):
        pc.classify_impact_times([1.0, 3.0, 2.0], WALL)
    with pytest.raises(pc.ParameterError, match="oscillator"):
        pc.classify_impact_times([1.0, 2.0, 3.0])


def test_impact_times_of_a_structure_are_classified_as_those_of_an_oscillator() -> None:
    """One mass, given by matrices: the same times, and the same class of them."""
    force, wall = pc.cosine("2.1"), pc.Wall(at=0, side="below", restitution="0.8")
    one = pc.Structure(1, 1, stops=[pc.Wall(at=0, side="below", restitution="0.8", on=0)])

    run = pc.simulate(one, pc.Loads({0: force}), v0=0.3, periods=40)

    answer = pc.classify_impact_times(run)
    as_oscillator = pc.classify_impact_times(
        pc.simulate(pc.Oscillator(1, 0, (wall,)), force, v0=0.3, periods=40)
    )
    assert (answer.kind, answer.n_impacts, answer.n_periods) == ("settling", 1, 1)
    assert answer.rate == pytest.approx(as_oscillator.rate, rel=1e-6)


def test_entries_of_a_structure_into_soft_stops_count_where_there_are_no_impacts() -> None:
    stop = pc.SoftStop(at="0.2", side="above", stiffness=50, on=1)
    chain = pc.chain([1, 1], [1, 1, 0], dashpots="0.2", stops=[stop])

    run = pc.simulate(chain, pc.Loads({0: pc.cosine(1)}), periods=200)

    answer = pc.classify_impact_times(run)
    assert len(run.impacts) == 0
    assert answer.kind == "periodic"
    assert answer.n_impacts >= 1


def test_stops_that_share_an_edge_are_entered_once() -> None:
    """As in `max_impacts`, in sweeps and in orbits."""
    parts = [pc.SoftStop("0.3", "above", stiffness) for stiffness in (9, 4)]
    osc, force = pc.Oscillator(1, "0.05", parts), pc.cosine("1.5")
    run = pc.simulate(osc, force, t_end=400.0)

    pattern = pc.classify_impact_times(run)

    assert (pattern.n_impacts, pattern.n_periods) == (1, 1)
    over = {"forcing.amplitude": [1.0]}
    found = pc.sweep("impacts_per_period", osc, force, over=over, transient=60, periods=10)
    assert float(found.impacts_per_period.item()) == pc.find_orbit(osc, force, guess=run).n_impacts
    assert len(pc.simulate(osc, force, max_impacts=7).crossings) == 2 * 13
    assert len(entry_rows(pc.simulate(osc, force, max_impacts=7))) == 7
    assert len(np.unique(run.crossings.t)) == len(run.crossings) // 2
