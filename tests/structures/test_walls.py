"""Branches of structures through the grazes of walls, and their formal orbits."""

from __future__ import annotations

import functools
import math

import numpy as np
import pytest

import percuss as pc

# One mass with its wall, as a structure and as an oscillator.
ONE = pc.Structure(1, 1, "0.1", stops=[pc.Wall(1, "above", "0.8")])
SAME = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
# Two masses of which the second meets a wall.
TWO = pc.chain([1, "0.6"], ["1.2", 1, "0.4"], "0.06", [pc.Wall("0.5", "above", "0.7", on=1)])
LOADS = pc.Loads({0: pc.cosine("1.2", amplitude="0.3")})


@functools.cache
def two_masses() -> pc.StructureBranch:
    """Return a branch that is closed, and formal between grazes."""
    orbit = pc.find_orbit(TWO, LOADS)
    return pc.continue_orbit(orbit, {"loads.0.omega": (0.6, 2.4)}, largest_step=0.1)


@pytest.mark.parametrize("n_impacts", [0, 1])
def test_one_coordinate_has_the_branch_of_the_oscillator(n_impacts: int) -> None:
    guess = None if n_impacts else ([0], [0])
    amplitude = 1 if n_impacts else "0.05"
    own = pc.find_orbit(ONE, pc.cosine(1, amplitude=amplitude), guess=guess)
    other = pc.find_orbit(SAME, pc.cosine(1, amplitude=amplitude), n_impacts=n_impacts)
    over = (1.0, 0.05) if n_impacts else (0.05, 0.5)

    branch = pc.continue_orbit(own, {"loads.0.amplitude": over}, largest_step=0.1)

    expected = pc.continue_orbit(other, {"forcing.amplitude": over}, largest_step=0.1)
    kinds = {"fold", "grazing", "period_doubling"}
    assert {point.kind for point in branch.special_points} <= kinds
    for kind in kinds:
        found, known = (
            sorted(point.value for point in one.special_points if point.kind == kind)
            for one in (branch, expected)
        )
        assert found == pytest.approx(known, abs=1e-10)
    low, high = (
        [one.values[flags].min() if flags.any() else math.nan
         for flags in (one.admissible, ~one.admissible)]
        for one in (branch, expected)
    )  # fmt: skip
    # Formal orbits begin at the graze, which is a row, and may have either flag there.
    assert low == pytest.approx(high, abs=1e-2)
    assert max(orbit.residual for orbit in branch.orbits) < 1e-12


def test_orbits_that_are_flagged_as_motions_are_motions_and_no_others() -> None:
    branch = two_masses()

    assert branch.end_reason == "the branch closed"
    assert 0.2 < branch.admissible.mean() < 0.8
    special = {point.row for point in branch.special_points}
    for row in sorted({*range(0, len(branch), 5)} - special):
        orbit = branch[row]
        start = orbit.x0.tolist(), orbit.v0.tolist()
        if orbit.x0[1] > 0.5:
            assert not orbit.admissible
            continue
        run = pc.simulate(TWO, orbit.loads, start=start, t_end=orbit.period)
        comes_back = np.allclose(run(run.t_end), start, atol=1e-9)
        assert (comes_back and len(run.impacts) == len(orbit.run.impacts)) == orbit.admissible


def test_formal_orbits_pass_through_the_wall_and_obey_its_law_at_their_impacts() -> None:
    branch = two_masses()
    row = int(np.argmin([orbit.run.impacts.v_before.min() for orbit in branch.orbits]))
    orbit = branch[row]

    # It comes from behind the wall: as an impact would be that runs backwards.
    assert not orbit.admissible
    (before,), (after,) = orbit.run.impacts.v_before, orbit.run.impacts.v_after
    assert after == pytest.approx(-0.7 * before)
    (t,) = orbit.run.impacts.t
    x, _ = orbit.run(t)
    assert x[1] == pytest.approx(0.5, abs=1e-12)
    ends = [np.concatenate(orbit.run(at)) for at in (0.0, orbit.period)]
    assert ends[0] == pytest.approx(ends[1], abs=1e-10)


def test_grazes_are_located_where_motions_end() -> None:
    branch = two_masses()

    grazes = [point for point in branch.special_points if point.kind == "grazing"]
    assert len(grazes) == 4
    for point in grazes:
        assert point.status == "located"
        sides = {branch[row % len(branch)].admissible for row in (point.row - 1, point.row + 1)}
        assert sides == {True, False}
        t = np.linspace(0.0, point.orbit.period, 2001)
        touched = float(np.abs(point.orbit.run.impacts.v_before).min())
        nearest = float(np.abs(point.orbit.run(t)[0][:, 1] - 0.5).min())
        assert min(touched, nearest) < 1e-5


@pytest.mark.parametrize(
    "stop", [pc.Wall("0.5", "above", "0.7", on=1), pc.SoftStop("0.5", "above", 10, on=1)]
)
def test_curves_of_grazes_are_where_the_linear_response_reaches_the_stop(
    stop: pc.Wall | pc.SoftStop,
) -> None:
    structure = pc.Structure(
        TWO.mass_matrix, TWO.stiffness_matrix, TWO.damping_matrix, stops=[stop]
    )
    calm = pc.find_orbit(structure, pc.Loads({0: pc.cosine("1.2", amplitude="0.02")}))
    branch = pc.continue_orbit(calm, {"loads.0.amplitude": (0.02, 0.35)}, largest_step=0.2)
    (graze,) = (point for point in branch.special_points if point.kind == "grazing")

    ranges = {"loads.0.omega": (0.8, 1.6), "loads.0.amplitude": (0.001, 0.5)}
    curve = pc.continue_curve(graze, ranges, largest_step=0.2)

    assert curve.kind == "grazing"
    assert np.ptp(curve.values[:, 0]) > 0.6
    mass, damping, stiffness = (
        TWO.mass_matrix, TWO.damping_matrix, TWO.stiffness_matrix,
    )  # fmt: skip
    for omega, amplitude in curve.values:
        dynamic = stiffness - omega**2 * mass + 1j * omega * damping
        reached = amplitude * abs(np.linalg.solve(dynamic, [1.0, 0.0])[1])
        assert reached == pytest.approx(0.5, abs=1e-12)


def test_curves_of_folds_are_those_of_the_oscillator() -> None:
    own = pc.continue_orbit(
        pc.find_orbit(ONE, pc.cosine(1)), {"loads.0.amplitude": (1.0, 0.05)}, largest_step=0.1
    )
    other = pc.continue_orbit(
        pc.find_orbit(SAME, pc.cosine(1)), {"forcing.amplitude": (1.0, 0.05)}, largest_step=0.1
    )
    ends = []
    for branch, name in ((own, "loads.0"), (other, "forcing")):
        fold = next(point for point in branch.special_points if point.kind == "fold")
        ranges = {f"{name}.omega": (1.0, 1.02), f"{name}.amplitude": (0.05, 0.3)}
        ends.append(pc.continue_curve(fold, ranges, largest_step=0.2).values[-1])

    assert ends[0] == pytest.approx(ends[1], abs=1e-9)
    assert ends[0][0] == 1.02


def test_orbits_of_two_periods_on_a_branch_are_their_motions() -> None:
    """Impacts in the second period of the loads were listed a period early: all was wrong there."""
    wall = pc.Wall("0.3", "above", "0.7", on=1)
    chain = pc.chain([1, 1], [1, 1, 0], dashpots="0.05", stops=[wall])
    over = {"loads.0.omega": ("0.7", "1.2")}
    (one,) = pc.find_orbits(chain, pc.Loads({0: pc.cosine("0.9", amplitude="0.5")}), 1, 1)
    (doubling, formal) = (
        point
        for point in pc.continue_orbit(one, over=over).special_points
        if point.kind == "period_doubling"
    )

    branch = pc.continue_orbit(pc.switch_branch(doubling), over=over)

    with pytest.raises(pc.ParameterError, match="its orbit is formal, it passes through a wall"):
        pc.switch_branch(formal)
    assert branch.special_points[0].value == pytest.approx(doubling.value, rel=1e-11)
    rows = np.flatnonzero(branch.admissible)
    assert len(rows) > 10
    for orbit in (branch[int(row)] for row in rows[1:-1:4]):
        assert orbit.n_periods == 2
        run = pc.simulate(chain, orbit.loads, x0=orbit.x0, v0=orbit.v0, t_end=orbit.period)
        assert orbit.run.impacts.t == pytest.approx(run.impacts.t, abs=1e-9)
        assert np.abs(np.concatenate(run(run.t_end)) - [*orbit.x0, *orbit.v0]).max() < 1e-9
        found = pc.find_orbit(chain, orbit.loads, guess=orbit)
        assert found.n_periods == 2
        assert np.abs(found.multipliers - orbit.multipliers).max() < 1e-6
    # Where the orbits are formal, the shorter one is, too, and doubles at the other end.
    end = branch.special_points[-1]
    assert branch.end_reason.count("the orbit is the two-fold cover of a shorter one") == 2
    assert (end.kind, end.status, end.orbit.n_periods) == ("period_doubling", "located", 1)
    assert end.value == pytest.approx(formal.value, rel=1e-11)
    assert (end.orbit.admissible, branch[-1].admissible) == (False, False)
    assert end.orbit.run.impacts.t == pytest.approx(formal.orbit.run.impacts.t, abs=1e-9)
    half = np.concatenate(branch[-1].run(0.5 * branch[-1].period))
    assert np.abs(half - np.concatenate([branch[-1].x0, branch[-1].v0])).max() < 1e-9


@pytest.mark.parametrize("kind", ["period_doubling", "torus"])
def test_curves_of_orbits_that_meet_walls_keep_their_multipliers(kind: str) -> None:
    """The impact that begins a period was taken to be as late at its end, whatever the multiplier."""
    absorber = pc.vibro_impact_absorber(1, 1, "0.1", gap="0.5", restitution="0.6", damping="0.05")
    loads = pc.Loads({0: pc.cosine("1.2", amplitude="0.3")})
    orbit = next(o for o in pc.find_orbits(absorber, loads, 3, 1) if o.n_impacts == 3)
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": ("1.15", "1.3")})
    point = next(one for one in branch.special_points if one.kind == kind)
    over = {"loads.0.omega": ("1.15", "1.3"), "structure.stops.0.at": ("-0.52", "-0.48")}

    curve = pc.continue_curve(point, over=over, largest_step=0.1)

    assert len(curve) > 8
    for row in range(0, len(curve), 3):
        found = pc.find_orbit(curve[row].structure, curve[row].loads, guess=curve[row])
        if kind == "period_doubling":
            assert np.abs(found.multipliers + 1.0).min() < 1e-7
        else:
            pairs = found.multipliers[np.abs(found.multipliers.imag) > 1e-6]
            assert np.abs(np.abs(pairs) - 1.0).min() < 1e-7


def test_curves_of_folds_and_doublings_meet_that_of_torus_points_in_strong_resonances() -> None:
    """A neutral saddle, two real multipliers whose product is 1, is no point of theirs."""
    structure = pc.chain((1, 0.486), (1, 0.6, 0), 0.1, (pc.Wall(0.283, "above", 0.618, on=1),))
    loads = pc.Loads({0: pc.cosine(1.324, amplitude=0.576)})
    amplitude, omega = "loads.0.harmonics.0.amplitude", "loads.0.harmonics.0.omega"
    orbit = pc.find_orbit(structure, loads)
    branch = pc.continue_orbit(orbit, over={amplitude: (0.173, 0.6)})
    ranges = {amplitude: (0.19, 0.26), omega: (1.15, 1.55)}

    special = {
        point.kind: pc.continue_curve(point, ranges, largest_step=0.1).special_points
        for point in branch.special_points
        if point.kind != "grazing"
    }

    places = {
        kind: {point.kind: point.values for point in found} for kind, found in special.items()
    }
    assert set(places["torus"]) >= {"resonance_1_1", "resonance_1_2"}
    assert [point.kind for point in special["period_doubling"]].count("doubling_torus") == 0
    assert [point.kind for point in special["fold"]].count("fold_torus") == 0
    doubled = places["period_doubling"]["resonance_1_2"]
    assert doubled == pytest.approx(places["torus"]["resonance_1_2"], abs=1e-7)
    folds = [point.values for point in special["fold"] if point.kind == "resonance_1_1"]
    assert any(each == pytest.approx(places["torus"]["resonance_1_1"], abs=1e-7) for each in folds)
