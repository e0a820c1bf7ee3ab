"""Proven basins: against motions of the float engine from the cells, and orbits that are refused."""

from __future__ import annotations

from collections.abc import Callable

import matplotlib as mpl
import numpy as np
import pytest
import xarray as xr

import percuss as pc
from percuss import progress
from percuss.certified import CertifiedBasins, prove_basins
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.certify import certify
from percuss.certified.numbers import precision
from percuss.certified.system import system_of
from percuss.certified.trapping import traps_about
from percuss.plotting import plot_enclosure

OSC, FORCE = pc.impact_oscillator("0.6"), pc.cosine("2.2")
# An orbit with an impact and the motion without one, both stable (a gap, with damping).
GAP, SLOW = (
    pc.impact_oscillator("0.7", wall="1.45789", side="above", damping="0.05"),
    pc.cosine("1.5"),
)


@pytest.fixture(scope="module")
def orbit() -> pc.PeriodicOrbit:
    return pc.find_orbit(OSC, FORCE)


@pytest.fixture(scope="module")
def basins(orbit: pc.PeriodicOrbit) -> CertifiedBasins:
    # Of the columns of cells the first two lie beyond the wall, the third touches it.
    return prove_basins(orbit, x0=("-0.08", "0.4"), v0=("0.1", "0.4"), cells=(12, 6), depth=1)


def test_motions_from_all_proven_cells_come_to_the_orbit(
    basins: CertifiedBasins, orbit: pc.PeriodicOrbit
) -> None:
    rng = np.random.default_rng(3)
    assert basins.decided > 0.7
    assert (basins.labels == 0).sum() > 40
    period = orbit.period
    for i, k in rng.permutation(np.argwhere(basins.labels == 0))[:25]:
        x = rng.uniform(basins.x0[i], basins.x0[i + 1])
        v = rng.uniform(basins.v0[k], basins.v0[k + 1])
        run = pc.simulate(OSC, FORCE, x0=x, v0=v, t_end=80 * period)
        assert run.impacts.cycle[-1] == pytest.approx(float(orbit.impacts.cycle[0]), abs=1e-4)
        assert run.impacts.v_after[-1] == pytest.approx(float(orbit.impacts.v_after[0]), abs=1e-4)


def test_areas_are_those_of_cells_and_of_their_parts(basins: CertifiedBasins) -> None:
    assert (basins.labels[:2] == -2).all()
    assert (basins.labels[2] == -1).all()
    assert sum(basins.areas) + basins.open_area == pytest.approx(0.4 * 0.3)
    assert (basins.labels == 0).sum() * 0.04 * 0.05 <= basins.areas[0] * (1.0 + 1e-12)
    assert dict(basins.to_xarray().sizes) == {"x0": 12, "v0": 6, "attractor": 1}
    assert f"60 cells, proven basins of {100.0 * basins.decided:.1f} %" in repr(basins)


@pytest.mark.parametrize("names", [["(0, 1)"], ["(0, 1)", "(1, 1)"]], ids=["one", "both"])
def test_cells_next_to_attractors_are_proven_to_be_in_their_basins(names: list[str]) -> None:
    known = {f"({o.n_impacts:g}, 1)": o for o in pc.find_orbits(GAP, SLOW, 1, 1) if o.is_stable}
    assert sorted(known) == ["(0, 1)", "(1, 1)"]
    attractors = [known[name] for name in names]
    for label, (name, near) in enumerate(zip(names, attractors, strict=True)):
        x, v = (float(value) for value in near.trajectory(2)(near.period))
        ends = (x - 1e-3, x + 1e-3), (v - 1e-3, v + 1e-3)
        proven = prove_basins(attractors, x0=ends[0], v0=ends[1], cells=1, depth=0)
        data = pc.basins(GAP, SLOW, x0=list(ends[0]), v0=list(ends[1]))
        assert proven.labels.tolist() == [[label]]
        assert {str(value) for value in data.name.values} == {name}


def test_a_cell_that_is_too_wide_is_not_claimed_nor_what_a_caller_did_not_wait_for(
    orbit: pc.PeriodicOrbit,
) -> None:
    wide = prove_basins(
        orbit, x0=("0.1", 3), v0=(-2, 2), cells=(2, 1), depth=0,
        progress=lambda done, _: done < 1,
    )  # fmt: skip
    assert wide.labels.tolist() == [[-1], [-1]]
    assert wide.open_area == pytest.approx(2.9 * 4.0)


def test_motions_from_the_edge_of_a_trap_stay_in_it(
    basins: CertifiedBasins, orbit: pc.PeriodicOrbit
) -> None:
    step = pc.impact_map(OSC, FORCE)
    (trap,) = basins.traps[0]
    middle = np.array([orbit.impacts.cycle[0], orbit.impacts.v_after[0]])
    assert np.ptp(trap[:, 1]) > 0.02
    c, v = trap.T
    for _ in range(60):
        c, v = step(c, v)
    away = np.array([(c - middle[0] + 0.5) % 1.0 - 0.5, v - middle[1]])
    assert np.abs(away).max() < 1e-5


def test_no_trap_is_found_about_an_orbit_that_repels() -> None:
    """Deliberately wrong: the saddle of the same system, past the check of its stability."""
    osc, force = pc.impact_oscillator("0.8"), pc.cosine("2.8")
    saddle = pc.find_orbit(osc, force)
    with precision(64), pytest.raises(Undecided, match="mapped into itself"):
        traps_about(system_of(osc, force), certify(saddle), lambda: True)


def test_a_picture_has_a_colour_for_what_is_proven_and_one_for_what_is_open(
    basins: CertifiedBasins,
) -> None:
    mpl.use("agg")
    axes = plot_enclosure(basins)
    assert axes.get_xlabel().startswith("displacement")
    assert "open" in axes.get_title()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"x0": (1, 0)}, "the first is not below the second"),
        ({"v0": 3}, "not two numbers"),
        ({"cells": 0}, "cells"),
        ({"attractors": []}, "neither an orbit nor a list of orbits"),
    ],
)
def test_bad_input_is_refused_in_a_sentence(
    orbit: pc.PeriodicOrbit, given: dict[str, object], words: str
) -> None:
    arguments: dict[str, object] = {"attractors": orbit, "x0": (0, 1), "v0": (0, 1), "cells": 2}
    with pytest.raises(pc.ParameterError, match=words):
        prove_basins(**{**arguments, **given})  # type: ignore[arg-type]


def test_attractors_that_are_none_are_refused_in_a_sentence() -> None:
    saddle = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.8"))
    with pytest.raises(pc.ParameterError, match="not proven to be asymptotically stable: unstable"):
        prove_basins(saddle, x0=(0, 1), v0=(0, 1))
    sticks = pc.find_orbit(pc.impact_oscillator(0.3, damping=0.05), pc.cosine(0.8), np.inf)
    with pytest.raises(pc.ParameterError, match="it sticks"):
        prove_basins(sticks, x0=(0, 1), v0=(0, 1))
    stable = pc.find_orbit(OSC, FORCE)
    with pytest.raises(pc.ParameterError, match="not orbits of one oscillator"):
        prove_basins([stable, saddle], x0=(0, 1), v0=(0, 1))


class Clock:
    """A clock on which a second passes each time that it is read."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        self.now += 1.0
        return self.now


def test_progress_is_reported_while_the_sets_about_attractors_grow_and_within_rows(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.7"), pc.cosine("2.3"))
    monkeypatch.setattr(progress, "time", Clock())
    seen: list[float] = []

    def proven(goes_on: Callable[[float], bool]) -> CertifiedBasins:
        def report(done: float, total: float) -> bool:
            assert total == 2
            seen.append(done)
            return goes_on(done)

        return prove_basins(
            orbit, x0=("0.1", "0.2"), v0=("0.4", "0.5"), cells=2, depth=0, progress=report
        )

    assert proven(lambda _: True).decided == 1.0
    assert seen.count(0.0) > 10
    assert seen.count(1.0) >= 2
    seen.clear()
    stopped = proven(lambda _: False)
    assert (seen, stopped.decided) == ([0.0], 0.0)
    assert (stopped.labels == -1).all()
    assert isinstance(stopped.to_xarray(), xr.Dataset)
