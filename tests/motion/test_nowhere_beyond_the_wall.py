"""Motions from many starts stay on their side of the wall, and are on it at each impact."""

from __future__ import annotations

import numpy as np
import pytest

import percuss as pc

BASIN = pc.impact_oscillator(restitution=0.7, wall=1.45789, side="above", damping=0.05)


def deepest(osc: pc.Oscillator, force: pc.Forcing, x0: float, v0: float, t_end: float) -> float:
    """Return how far beyond its wall a motion goes, at 64 instants between two impacts."""
    run = pc.simulate(osc, force, x0=x0, v0=v0, t_end=t_end)
    cuts = np.concatenate([[0.0], run.impacts.t, [run.t_end]])
    share = np.linspace(0.0, 1.0, 64)
    t = (cuts[:-1, None] + share * np.diff(cuts)[:, None]).ravel()
    wall = osc.stops[0]
    x, _ = run(np.clip(t, 0.0, run.t_end))
    depth = x - float(wall.at) if wall.side == "above" else float(wall.at) - x
    return float(depth.max())


def test_a_series_that_vanishes_by_chance_is_no_impact() -> None:
    """Far from a root the series of the inverse function may vanish, and was once taken for one."""
    x0, v0 = 0.6500000000000004, 0.7651006711409387
    run = pc.simulate(BASIN, pc.cosine("1.5"), x0=x0, v0=v0, t_end=12.0)

    assert run.impacts.t == pytest.approx([5.8655468, 10.0446093], abs=1e-7)
    offsets = np.linspace(-1e-4, 1e-4, 201)
    assert max(deepest(BASIN, pc.cosine("1.5"), x0, v0 + d, 12.0) for d in offsets) < 1e-12


@pytest.mark.parametrize("count", [3000, pytest.param(300_000, marks=pytest.mark.nightly)])
def test_no_start_leads_beyond_the_wall(count: int) -> None:
    rng = np.random.default_rng(11)
    wrong = []
    for _ in range(count):
        side = "above" if rng.random() < 0.5 else "below"
        osc = pc.impact_oscillator(
            restitution=float(rng.uniform(0.3, 1.0)),
            wall=float(rng.uniform(-0.5, 1.5)) * (1 if side == "above" else -1),
            side=side,  # type: ignore[arg-type]
            damping=float(rng.choice([0.0, 0.05, 0.3])),
        )
        force = pc.cosine(float(rng.uniform(0.4, 5.0)))
        wall = float(osc.stops[0].at)
        x0 = wall + float(rng.uniform(0.0, 3.0)) * (-1 if side == "above" else 1)
        v0 = float(rng.uniform(-2.0, 2.0))
        if deepest(osc, force, x0, v0, 30.0) > 1e-11:
            wrong.append((osc, force, x0, v0))
    assert wrong == []


@pytest.mark.parametrize("side", ["below", "above"])
@pytest.mark.parametrize("restitution", [0.01, 0.3, 0.6, 0.9])
def test_summed_tail_of_a_chatter_hops_and_never_lies_beyond_the_wall(
    restitution: float, side: str
) -> None:
    sign = 1.0 if side == "below" else -1.0
    osc = pc.impact_oscillator(restitution, wall=0.3 * sign, side=side)  # type: ignore[arg-type]
    force = pc.cosine(1.3, amplitude=sign, constant=-1.2 * sign)
    run = pc.simulate(osc, force, 0.3 * sign, 0.7 * sign, t_end=40.0)

    assert len(run.contacts) > 0
    for end, count in zip(run.contacts.start, run.contacts.n_impacts, strict=True):
        begin, speed = run.impacts.t[count - 1], abs(run.impacts.v_after[count - 1])
        x, v = run(np.linspace(begin, end, 1001))
        height = sign * x - 0.3
        assert height.min() >= 0.0
        # The first hop is the highest: under the constant force it rises to v T (1 - r) / 4.
        rise = speed * (end - begin) * (1.0 - restitution) / 4.0
        assert height.max() <= rise * 1.001 + 1e-16
        assert np.abs(v).max() <= speed
        assert (np.diff(np.sign(v)) != 0).sum() >= 2


@pytest.mark.parametrize("gap", [2.0**-20, 2.0**-38, 2.0**-50])
def test_landing_is_as_exact_as_its_flight_is_short(gap: float) -> None:
    """A free motion between two walls: what is left of a longer guess may not remain in it."""
    walls = (pc.Wall(0.25, "below"), pc.Wall(0.25 + gap, "above"))
    for v in (0.9426761097673371, 1.7):
        run = pc.simulate(pc.Oscillator(0.0, 0.0, walls), None, 0.25, v, max_impacts=20)

        np.testing.assert_allclose(run.impacts.intervals, gap / v, rtol=1e-15)
