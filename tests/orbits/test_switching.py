"""Other families from special points, and cascades of period doublings."""

from __future__ import annotations

import math

import numpy as np
import pytest

import percuss as pc
from percuss.orbits import Branch, SpecialPoint

OMEGA, AMPLITUDE = "forcing.omega", "forcing.amplitude"
FEIGENBAUM = 4.669201609


def point_of(branch: Branch, kind: str) -> SpecialPoint:
    return next(point for point in branch.special_points if point.kind == kind)


def is_fixed(orbit: pc.PeriodicOrbit, rounds: int) -> bool:
    """Whether the impact map, applied so often, brings the first impact back."""
    assert orbit.forcing is not None
    impact = pc.impact_map(orbit.oscillator, orbit.forcing)
    start = state = (float(orbit.impacts.cycle[0]), float(orbit.impacts.v_after[0]))
    for _ in range(rounds):
        cycle, v = impact(*state)
        state = float(cycle), float(v)
    return bool(np.abs(np.subtract(start, state)).max() < 1e-9)


@pytest.fixture(scope="module")
def single() -> Branch:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6))
    return pc.continue_orbit(orbit, over={OMEGA: (2.6, 2.75)})


def test_a_doubling_leads_to_an_orbit_that_closes_after_two_rounds(single: Branch) -> None:
    doubled = pc.switch_branch(point_of(single, "period_doubling"))

    assert (doubled.n_impacts, doubled.n_periods) == (2, 2)
    assert is_fixed(doubled, 2)
    assert not is_fixed(doubled, 1)


def test_the_doubled_family_starts_with_a_square_root(single: Branch) -> None:
    """Near a supercritical doubling the two speeds part as the root of the parameter."""
    point = point_of(single, "period_doubling")

    branch = pc.continue_orbit(pc.switch_branch(point), over={OMEGA: (2.6533, 2.654)})

    beyond = branch.values - point.value
    apart = np.abs(np.diff(branch.impact_velocity, axis=1))[:, 0]
    near = (beyond > 1e-7) & (beyond < 1e-4)
    assert near.sum() > 5
    slope = np.polyfit(np.log(beyond[near]), np.log(apart[near]), 1)[0]
    assert slope == pytest.approx(0.5, abs=2e-3)


def test_both_sides_of_a_doubling_are_one_orbit_a_period_apart(single: Branch) -> None:
    point = point_of(single, "period_doubling")

    one, other = pc.switch_branch(point), pc.switch_branch(point, other_side=True)

    speeds = other.impacts.v_after[::-1]
    np.testing.assert_allclose(one.impacts.v_after, speeds, atol=1e-6)
    assert one.impacts.v_after[0] != pytest.approx(one.impacts.v_after[1], abs=1e-5)


def test_the_end_of_a_doubled_family_is_located_and_leads_back(single: Branch) -> None:
    point = point_of(single, "period_doubling")
    doubled = pc.continue_orbit(pc.switch_branch(point), over={OMEGA: (2.65, 2.7)})

    end = point_of(doubled, "period_doubling")

    assert end.status == "located"
    assert end.value == pytest.approx(point.value, abs=1e-12)
    back = pc.switch_branch(end)
    assert (back.n_impacts, back.n_periods) == (1, 1)
    assert is_fixed(back, 1)


def test_where_a_symmetry_breaks_two_mirrored_families_start(mirrored: Branch) -> None:
    point = point_of(mirrored, "symmetry_breaking")

    one, other = pc.switch_branch(point), pc.switch_branch(point, other_side=True)

    assert point.orbit.symmetric
    assert not one.symmetric
    assert not other.symmetric
    assert is_fixed(one, 2)
    np.testing.assert_allclose(one.impacts.v_after, -other.impacts.v_after[::-1], atol=1e-7)


def test_a_broken_family_ends_where_it_is_symmetric(mirrored: Branch) -> None:
    point = point_of(mirrored, "symmetry_breaking")

    branch = pc.continue_orbit(pc.switch_branch(point), over={AMPLITUDE: (0.55, 0.7)})

    end = point_of(branch, "symmetry_breaking")
    assert end.value == pytest.approx(point.value, abs=1e-11)
    assert end.status == "located"
    assert "symmetric" in branch.end_reason


@pytest.mark.parametrize(
    ("orbit", "path", "last"),
    [
        (lambda: pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6)), OMEGA, 2.75),
        (
            lambda: pc.find_orbit(*pc.ball_on_table(amplitude=0.9, omega=1.0, gravity=1.0,
                                                    restitution=0.8)),
            AMPLITUDE,
            1.4,
        ),
    ],
    ids=["wall", "ball"],
)  # fmt: skip
def test_a_cascade_of_six_doublings_approaches_feigenbaum(orbit, path, last) -> None:  # type: ignore[no-untyped-def]
    start = orbit()
    value = pc.model.get_parameter(start.oscillator, start.forcing, None, path)

    cascade = pc.follow_cascade(start, over={path: (float(value), last)}, max_doublings=6)

    assert len(cascade) == 6
    assert [point.orbit.n_periods for point in cascade.points] == [1, 2, 4, 8, 16, 32]
    assert all(point.status == "located" for point in cascade.points)
    # Two dimensions shrink to one as 0.8^(2 n): the last ratio is near, those before less so.
    assert cascade.ratios[-1] == pytest.approx(FEIGENBAUM, abs=0.02)
    assert abs(cascade.ratios[-1] - FEIGENBAUM) < abs(cascade.ratios[0] - FEIGENBAUM)
    assert (cascade.ratio_errors < 1e-6).all()
    assert cascade.end_reason == "max_doublings = 6 reached"


def test_without_losses_the_ratios_are_those_of_conservative_maps() -> None:
    """Greene, MacKay, Vivaldi & Feigenbaum, Physica D 3 (1981) 468."""
    orbit = pc.find_orbit(pc.impact_oscillator(1), pc.cosine(2.6))

    cascade = pc.follow_cascade(orbit, over={OMEGA: (2.6, 2.8)}, max_doublings=6)

    assert orbit.stability == "elliptic"
    assert cascade.ratios[-1] == pytest.approx(8.7211, abs=0.02)


def test_a_cascade_ends_where_another_family_crosses() -> None:
    """A multiplier of the elliptic orbits goes through 1 there, and they are unstable beyond."""
    osc = pc.impact_oscillator(1, wall=0.3)
    orbit = min(
        pc.orbits.single_impact_orbits(osc, pc.cosine(2.6)),
        key=lambda each: each.stability != "elliptic" or not each.admissible,
    )

    cascade = pc.follow_cascade(orbit, over={OMEGA: (2.6, 6.0)}, max_doublings=3)

    assert len(cascade) == 2
    assert "meet another family at forcing.omega = 3.849" in cascade.end_reason
    branch = pc.continue_orbit(cascade.orbits[-1], over={OMEGA: (2.6, 6.0)})
    assert branch.stability[branch.values < 3.848][-1] == "elliptic"
    assert branch.stability[branch.values > 3.85][0] == "unstable"


def test_a_cascade_tells_its_progress_and_is_stopped() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6))
    over, told, most = {OMEGA: (2.6, 2.75)}, [], math.inf

    def report(done: float, total: float) -> bool:
        told.append((done, total))
        return len(told) < most

    whole = pc.follow_cascade(orbit, over=over, max_doublings=3, progress=report)
    n_orbits = len(told)
    told, most = [], n_orbits - 1
    stopped = pc.follow_cascade(orbit, over=over, max_doublings=3, progress=report)

    assert told == [(k, 4000) for k in range(1, n_orbits)]
    assert 0 < len(stopped) < len(whole)
    np.testing.assert_array_equal(stopped.values, whole.values[: len(stopped)])
    assert stopped.end_reason == "stopped by progress"


def test_orbits_of_the_cascade_attract_between_its_doublings() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(0.8), pc.cosine(2.6))
    cascade = pc.follow_cascade(orbit, over={OMEGA: (2.6, 2.75)}, max_doublings=4)

    for k in range(3):
        omega = 0.5 * (cascade.values[k] + cascade.values[k + 1])
        start = cascade.orbits[k + 1]
        run = pc.simulate(
            start.oscillator, pc.cosine(float(omega)), x0=start.x0, v0=start.v0, t0=start.t0,
            max_impacts=3000,
        )  # fmt: skip
        last = run.impacts.v_after[-64:]
        round_ = 2 ** (k + 1)
        np.testing.assert_allclose(last[round_:], last[:-round_], atol=1e-8)
        assert np.abs(last[round_ // 2 :] - last[: -(round_ // 2)]).max() > 1e-5


@pytest.mark.parametrize(
    ("restitution", "omega", "last", "n", "reason"),
    [
        (0.5, 1.3, 0.6, 1, "2 impacts in 2 periods graze"),
        (0.8, 2.6, 2.66, 1, "forcing.omega = 2.66 reached"),
        (0.8, 2.6, 2.1, 0, "forcing.omega = 2.1 reached"),
    ],
)
def test_a_cascade_says_why_it_ends(
    restitution: float, omega: float, last: float, n: int, reason: str
) -> None:
    orbit = pc.find_orbit(pc.impact_oscillator(restitution), pc.cosine(omega))

    cascade = pc.follow_cascade(orbit, over={OMEGA: (omega, last)})

    assert len(cascade) == n
    assert reason in cascade.end_reason
    assert reason in repr(cascade)


def test_a_symmetric_orbit_loses_its_symmetry_before_it_doubles(mirrored: Branch) -> None:
    row = point_of(mirrored, "symmetry_breaking").row - 1
    value = float(mirrored.values[row])

    cascade = pc.follow_cascade(mirrored[row], over={AMPLITUDE: (value, 2.0)})

    assert len(cascade) == 0
    assert "lose their symmetry" in cascade.end_reason


def test_a_graze_leads_from_orbits_without_impacts_to_those_with_one_and_back() -> None:
    osc = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    free = pc.continue_orbit(
        pc.find_orbit(osc, pc.cosine(1, amplitude="0.05"), 0), over={AMPLITUDE: (0.05, 0.2)}
    )
    graze = point_of(free, "grazing")

    impacting = pc.switch_branch(graze)

    assert impacting.n_impacts == 1
    assert impacting.admissible
    assert is_fixed(impacting, 1)
    # They come back below the graze, by less than the fold.
    branch = pc.continue_orbit(impacting, over={AMPLITUDE: (0.05, 0.2)})
    assert point_of(branch, "fold").value == pytest.approx(0.1 - 2.9246e-5, abs=1e-8)
    back = pc.switch_branch(point_of(branch, "grazing"))
    assert back.n_impacts == 0
    assert back.admissible


def test_a_graze_of_an_impacting_orbit_leads_to_one_with_two_impacts() -> None:
    osc = pc.impact_oscillator(0.5, wall=-0.3)
    orbit = pc.find_orbit(osc, pc.cosine(1.3))
    branch = pc.continue_orbit(orbit, over={OMEGA: (1.3, 0.6)})
    graze = point_of(branch, "grazing")

    other = pc.switch_branch(graze)

    assert (other.n_impacts, other.n_periods) == (2, 1)
    assert other.admissible
    assert is_fixed(other, 2)
    assert other.min_impact_speed < 0.1 * float(np.abs(other.impacts.v_before).max())


def test_a_subcritical_doubling_ends_a_cascade(
    single: Branch, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As told by where the doubled orbit lies: here one from before the doubling stands in."""
    monkeypatch.setattr("percuss.orbits.bifurcations.cascade.switch_branch", lambda _: single[3])

    cascade = pc.follow_cascade(single[0], over={OMEGA: (2.6, 2.75)})

    assert len(cascade) == 1
    assert "subcritical" in cascade.end_reason


def test_bad_input_is_named(single: Branch) -> None:
    orbit = pc.find_orbit(
        pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05"), pc.cosine(1)
    )
    fold = point_of(pc.continue_orbit(orbit, over={AMPLITUDE: (1.0, 0.09)}), "fold")

    with pytest.raises(pc.ParameterError, match="fold; the family turns there"):
        pc.switch_branch(fold)
    with pytest.raises(pc.ParameterError, match="no special point"):
        pc.switch_branch(single)  # type: ignore[call-overload]
    with pytest.raises(pc.ParameterError, match="unstable; a cascade starts"):
        pc.follow_cascade(single[len(single) - 1], over={OMEGA: (2.75, 2.6)})
    with pytest.raises(pc.ParameterError, match="max_doublings"):
        pc.follow_cascade(single[0], over={OMEGA: (2.6, 2.7)}, max_doublings=0)
    with pytest.raises(pc.ParameterError, match="at its end"):
        pc.follow_cascade(single[0], over={OMEGA: (2.7, 2.6)})
