"""Proofs with restitutions that depend on the speed."""

from __future__ import annotations

import numpy as np
import pytest
from flint import arb
from tests.certified.comparison import misses
from tests.oracle.random_problems import random_motion, with_tables

import percuss as pc
from percuss.certified import Ending
from percuss.certified.ball_arithmetic import Undecided
from percuss.certified.ball_law import law_of
from percuss.certified.numbers import precision
from percuss.certified.properties import stability_of
from percuss.certified.shooting import OrbitEvent
from percuss.certified.system import system_of

STEEL = pc.restitution_table(["0.1", 1, 5], ["0.9", "0.8", "0.65"])


@pytest.mark.parametrize(
    "seeds",
    [range(0, 90, 12), pytest.param(range(3000), marks=pytest.mark.nightly)],
    ids=lambda seeds: str(len(seeds)),
)
def test_no_enclosure_misses_the_truth(seeds: range) -> None:
    found = []
    for seed in seeds:
        motion = with_tables(random_motion(seed + 3_000_000), seed)
        found += misses(motion, bits=(None, 53))

    assert found == []


@pytest.mark.parametrize(
    ("speed", "after"),
    [("0.05", "0.045"), ("0.1", "0.09"), ("0.55", "0.4675"), (1, "0.8"), (3, "2.175"), (9, "5.85")],
)
def test_an_impact_of_each_speed_is_that_of_the_table(speed: str, after: str) -> None:
    run = pc.simulate(pc.impact_oscillator(STEEL), v0=speed, max_impacts=1)
    proven = pc.certify(run, digits=20)
    # The speed at a knot is a ball on both sides of it.
    assert proven.impacts.v_after[0].contains(after)
    assert proven.impacts.v_after[0].radius() < 1e-15


def test_a_wide_ball_takes_the_hull_of_all_lines_that_it_meets() -> None:
    with precision(100):
        law = law_of(system_of(pc.impact_oscillator(STEEL), None))
        rebound = law.rebound(0, arb(-1, "0.5"))
        assert rebound.at_knot
        for speed in ("0.5", "0.75", "1", "1.25", "1.5"):
            one = law.rebound(0, -arb(speed))
            assert rebound.after.contains(one.after)
            assert rebound.kept.contains(one.kept.mid())
        assert not law.rebound(0, arb("-0.5", "0.3")).at_knot
        assert law.slow_restitution(0, arb(1)).contains(law.rebound(0, arb("0.3")).restitution)


def test_a_chatter_with_a_table_ends_where_the_float_run_does() -> None:
    table = pc.restitution_table([0, 1], ["0.5", "0.3"])
    run = pc.simulate(
        pc.impact_oscillator(table, stiffness=0), pc.Forcing(constant=-1), x0=1, t_end=9.0
    )
    proven = pc.certify(run)
    assert proven.outcome is Ending.at_rest
    np.testing.assert_allclose(proven.contacts.start.mid(), run.contacts.start, rtol=1e-12)


def test_an_orbit_with_a_table_has_the_derivative_of_r_v() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(STEEL), pc.cosine("2.5"))
    proven = pc.certify(orbit, digits=20)
    assert (proven.exists, proven.admissible, proven.stability) == (True, True, "asymptotic")
    product = np.prod(orbit.multipliers).real
    assert abs(proven.determinant.mid() - product) < 1e-12
    with precision(100):
        u = abs(proven.impacts.v_before[0].arb)
        r, slope = arb("0.65") + (5 - u) * arb("0.0375"), -arb("0.0375")
        if u < 1:
            slope = -arb(1) / 9
            r = arb("0.8") + (1 - u) / 9
        assert proven.determinant.arb.overlaps(r * (r + slope * u))


def test_at_a_knot_an_orbit_has_no_derivative() -> None:
    system = system_of(pc.impact_oscillator(STEEL), None)
    event = OrbitEvent(0, 0, 0, 0, wall=True)
    with precision(100):
        with pytest.raises(Undecided, match="may be at a knot of the table of restitutions"):
            event.passed(system, arb(-1, 1e-9))
        assert event.passed(system, arb("-0.999")).kept < 1


def test_a_table_may_stretch_areas() -> None:
    assert stability_of(arb(0), arb(2), conservative=False) == "unstable"
