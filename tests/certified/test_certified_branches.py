"""Branches that are proven whole: by strips that go on in each other, through folds."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from flint import arb

import percuss as pc
from percuss.certified import CertifiedBranch
from percuss.orbits.bifurcations.branch import Branch

DAMPED = pc.impact_oscillator("0.7", damping="0.05", wall="0.2")
SOFT = pc.Oscillator(1, "0.1", (pc.SoftStop("0.5", "above", 9, "0.2"),))
BETWEEN = pc.Oscillator(
    1, "0.02", (pc.Wall("-0.6", "below", "0.6"), pc.Wall("0.7", "above", "0.8"))
)


def branch_of(
    osc: pc.Oscillator, force: pc.Forcing, path: str, low: float, high: float, events: int
) -> Branch:
    orbits = pc.find_orbits(osc, force, max_impacts=3, max_periods=2)
    orbit = next(o for o in orbits if o.admissible and len(o.itinerary) == events)
    return pc.continue_orbit(orbit, over={path: (low, high)})


@pytest.fixture(scope="module")
def doubling() -> Branch:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.64"))
    return pc.continue_orbit(orbit, over={"forcing.omega": (2.63, 2.67)})


@pytest.fixture(scope="module")
def proven(doubling: Branch) -> CertifiedBranch:
    return pc.certify(doubling)


def test_a_branch_through_a_doubling_is_one_curve(proven: CertifiedBranch) -> None:
    assert proven.complete, proven.reason
    assert [s.stability for s in proven.stretches] == ["asymptotic", "undecided", "unstable"]
    assert [s.admissible for s in proven.stretches] == [True] * 3
    assert [s.joined for s in proven.stretches] == [False, True, True]
    assert proven.stretches[0].low <= 2.63
    assert proven.stretches[-1].high >= 2.67

    (point,) = proven.special_points
    assert point.kind == "period_doubling"
    # 20 digits by another way: see tests/reference/cases.json, pd-r0.8-n1.
    assert point.value.arb.contains(arb("2.6533477278553229342"))
    assert float(point.value.radius()) < 1e-4
    assert "from end to end" in repr(proven)


def test_orbits_that_are_proven_alone_lie_in_its_strips(proven: CertifiedBranch) -> None:
    for value in ("2.6301", "2.6487", "2.6533477", "2.669"):
        alone = pc.certify(pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine(value)), digits=30)
        ((t, v),) = proven.events_at(value)

        (_, (own_t, own_v)) = alone.events[0]
        period = alone.period.arb
        turns = ((t.arbs[0] - own_t) / period + 0.5).mid().floor()
        assert t.arbs[0].contains(own_t + turns * period), value
        assert v.arbs[0].contains(own_v), value
        assert float(v.arbs[0].rad()) < 0.01
    with pytest.raises(pc.ParameterError, match=r"no strip has an orbit there; proven is 2\.63"):
        proven.events_at("2.7")


def impacting(wall: str, *, stable: bool) -> pc.PeriodicOrbit:
    osc = pc.impact_oscillator("0.7", damping="0.05", wall=wall, side="above")
    orbits = pc.find_orbits(osc, pc.cosine("1.5"), max_impacts=1, max_periods=1)
    return next(o for o in orbits if o.n_impacts == 1 and o.is_stable == stable)


def test_a_branch_goes_on_round_a_fold() -> None:
    branch = pc.continue_orbit(
        impacting("2.05", stable=True), over={"oscillator.stops.0.at": (2.0, 2.5)}
    )
    assert [p.kind for p in branch.special_points] == ["fold"]

    proven = pc.certify(branch)

    assert proven.complete, proven.reason
    assert [s.stability for s in proven.stretches if s.stability != "undecided"] in (
        ["asymptotic", "unstable"],
        ["unstable", "asymptotic"],
    )
    (fold,) = proven.special_points
    # sigma = G sqrt(1 + (omega k_x / k_d)^2): tests/reference/cases.json, fold-a0.05-r0.7-w1.5.
    assert fold.kind == "fold"
    assert fold.value.arb.contains(arb("2.1214694431410491882"))
    assert float(fold.value.radius()) < 1e-8
    assert len(proven.events_at("2.03")) >= 2


@pytest.mark.nightly
def test_what_a_graze_ends_is_no_whole_branch() -> None:
    branch = pc.continue_orbit(
        impacting("0.95", stable=False), over={"oscillator.stops.0.at": (0.75, 0.96)}
    )

    proven = pc.certify(branch)

    assert not proven.complete
    assert proven.reason
    assert "with gaps" in repr(proven)
    # No motion is told of where there is none: the graze is at 0.7943014707895...
    assert all(s.low > 0.7943 for s in proven.stretches if s.admissible)


@pytest.mark.parametrize(
    ("osc", "force", "path", "low", "high", "events"),
    [
        (SOFT, pc.cosine("1.1"), "forcing.omega", 1.09, 1.12, 2),
        (BETWEEN, pc.cosine("1.3"), "oscillator.damping", 0.02, 0.03, 2),
        (DAMPED, pc.fourier(2, cos=(1, "0.2")), "forcing.cos.1", 0.15, 0.25, 1),
        (DAMPED, pc.cosine("1.5"), "oscillator.stops.0.restitution", 0.69, 0.72, 1),
        (DAMPED, pc.square_wave("2.1"), "forcing.record.amplitude", 0.99, 1.02, 1),
    ],
    ids=["soft stop", "two walls", "two harmonics", "restitution", "square wave"],
)
def test_branches_of_other_systems(
    osc: pc.Oscillator, force: pc.Forcing, path: str, low: float, high: float, events: int
) -> None:
    branch = branch_of(osc, force, path, low, high, events)

    proven = pc.certify(branch)

    assert len(proven) > 3
    for row in range(0, len(branch), max(1, len(branch) // 5)):
        if not any(s.low <= branch.values[row] <= s.high for s in proven.stretches):
            assert not proven.complete
            continue
        orbit = branch.orbits[row]
        v = np.asarray(orbit.itinerary.vector[1 + len(orbit.itinerary) :])
        boxes = [box for _, box in proven.events_at(float(branch.values[row]))]
        assert any(
            (np.abs(np.array([float(b.mid()) for b in box.arbs]) - v)
             <= np.array([float(b.rad()) for b in box.arbs]) + 1e-9).all()
            for box in boxes
        ), (row, boxes, v)  # fmt: skip


def test_an_orbit_that_is_not_on_the_curve_is_not_reached(doubling: Branch) -> None:
    """The last row gets the orbit of the first, at the parameter of the last."""
    proven = pc.certify(
        dataclasses.replace(doubling, orbits=(*doubling.orbits[:-1], doubling.orbits[0]))
    )

    assert not proven.complete
    assert "does not come to the last of the orbits" in proven.reason


def test_an_orbit_with_events_of_its_own_is_a_gap(doubling: Branch) -> None:
    doubled = pc.find_orbit(
        pc.impact_oscillator("0.8"), pc.cosine("2.67"), n_impacts=2, n_periods=2
    )
    assert len(doubled.itinerary) == 2

    proven = pc.certify(
        dataclasses.replace(doubling, orbits=(*doubling.orbits[:-1], doubled)),
        progress=lambda done, _: done < 3,
    )

    assert not proven.complete
    assert f"the orbit of row {len(doubling) - 1} alone has its events" in proven.reason


def test_it_goes_to_the_end_of_what_a_restitution_may_be() -> None:
    osc = pc.impact_oscillator("0.99", damping="0.2", wall="-0.1")
    orbit = pc.find_orbit(osc, pc.cosine("1.5"))
    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.restitution": (0.98, 1.0)})

    proven = pc.certify(branch)

    assert proven.complete, proven.reason
    assert max(stretch.high for stretch in proven.stretches) == 1.0


def test_it_can_be_stopped_and_refuses_what_it_cannot_prove(doubling: Branch) -> None:
    told: list[float] = []

    def stop(done: float, _: float) -> bool:
        told.append(done)
        return len(told) < 3

    proven = pc.certify(doubling, progress=stop)

    assert len(proven) == 3
    assert not proven.complete
    assert "stopped" in proven.reason
    with pytest.raises(pc.ParameterError, match="along its own parameter"):
        pc.certify(doubling, over={"forcing.amplitude": (1, 2)})  # type: ignore[call-overload]

    steady = pc.find_orbit(pc.impact_oscillator(wall="-1"), pc.cosine("9.5"), n_impacts=0)
    branch = pc.continue_orbit(steady, over={"forcing.omega": (9.5, 9.6)})
    assert "linear response" in pc.certify(branch).reason
    assert "nothing is proven" in repr(pc.certify(branch))


def test_a_steep_branch_says_where_it_has_orbits_and_where_not() -> None:
    """Its strips go along velocities; they told of restitutions from 0.648 to 0.880."""
    osc = pc.Oscillator("0.312", "0.033", (pc.Wall("0.06", "above", "0.756"),))
    force = pc.cosine("2.703", amplitude="1.666")
    orbit = pc.find_orbit(osc, force)
    assert abs(orbit.multipliers).max() > 50
    branch = pc.continue_orbit(orbit, over={"oscillator.stops.0.restitution": (0.70308, 0.8316)})
    proven = pc.certify(branch)

    (stretch,) = proven.stretches
    assert stretch.stability == "unstable"
    assert 0.70308 - 1e-9 < stretch.low <= 0.70308
    assert 0.8316 <= stretch.high < 0.8316 + 1e-9
    for restitution in ("0.70309", "0.75", "0.8"):
        other = pc.Oscillator("0.312", "0.033", (pc.Wall("0.06", "above", restitution),))
        alone = pc.certify(pc.find_orbit(other, force, guess=orbit), digits=30)
        ((t, v),) = proven.events_at(restitution)
        assert t.arbs[0].contains(alone.impacts.t.arbs[0])
        assert v.arbs[0].contains(alone.impacts.v_after.arbs[0])
        assert float(v.arbs[0].rad()) < 2e-5
    with pytest.raises(pc.ParameterError, match=r"no strip has an orbit there; proven is 0\.703"):
        proven.events_at("0.7")
