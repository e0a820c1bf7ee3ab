"""Periodic orbits of structures and their branches."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest
from tests.oracle.structures import simulate_structure, structure_problem

import percuss as pc
from percuss.arrays import Floats
from percuss.model.acting_sets import StructureSystem
from percuss.orbits.bifurcations.structure_branch import structure_parameter
from percuss.orbits.bifurcations.wall_equations import WallEquations
from percuss.orbits.continuation.problem import along_parameter
from percuss.orbits.orbit.structure_orbit import period_map

# Example 03 of NLvib (Krack & Gross), whose parameters alone are taken.
NLVIB = pc.Structure(
    mass=[1, 1],
    stiffness=[[1, -1], [-1, 2]],
    damping=[["0.03", "-0.03"], ["-0.03", "0.06"]],
    stops=[pc.SoftStop(at=1, side="above", stiffness=100, on=0)],
)


def nlvib_loads(omega: str) -> pc.Loads:
    return pc.Loads({1: pc.cosine(omega, amplitude="0.1")})


def by_differences(system: StructureSystem, state: Floats, n_periods: int) -> Floats:
    columns = []
    for k in range(len(state)):
        step = np.zeros(len(state))
        step[k] = 1e-6
        high, low = (
            period_map(system, state + sign * step, n_periods, derivative=False).image
            for sign in (1.0, -1.0)
        )
        columns.append((high - low) / 2e-6)
    return np.array(columns).T


@pytest.mark.parametrize(
    ("omega", "contact", "penetration"),
    [
        ("0.65", [0.148007457, 0.442556446], 0.030303),
        ("0.60", [0.121462407, 0.380362607], 0.009533),
    ],
)
def test_published_parameters_give_the_contact_of_the_exact_motion(
    omega: str, contact: list[float], penetration: float
) -> None:
    orbit = pc.find_orbit(NLVIB, nlvib_loads(omega))

    assert orbit.residual < 1e-12
    assert orbit.run.crossings.t == pytest.approx(contact, abs=5.1e-10)
    first, last = orbit.run.crossings.t
    t = np.linspace(first, last, 2001)
    assert orbit.run(t)[0][:, 0].max() - 1.0 == pytest.approx(penetration, abs=6e-7)


def test_multipliers_of_the_published_case_leave_the_circle_as_a_pair() -> None:
    orbit = pc.find_orbit(NLVIB, nlvib_loads("0.60"))

    assert orbit.multipliers[:2] == pytest.approx(
        [complex(-0.26575, 1.36536), complex(-0.26575, -1.36536)], abs=6e-6
    )
    assert not orbit.is_stable
    assert orbit.stability == "unstable"
    # Their product is what all dashpots take away in a period: exp(-trace(C) T).
    assert math.log(np.prod(orbit.multipliers).real) == pytest.approx(-0.09 * orbit.period)


def test_a_frequency_response_has_all_its_special_points() -> None:
    orbit = pc.find_orbit(NLVIB, nlvib_loads("0.8"))

    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (0.8, 0.5)}, largest_step=0.2)

    kinds = [point.kind for point in branch.special_points]
    assert kinds == [
        "grazing", "fold", "fold", "period_doubling", "period_doubling", "torus", "torus", "grazing",
    ]  # fmt: skip
    assert all(point.status == "located" for point in branch.special_points)
    assert max(one.residual for one in branch.orbits) < 1e-12
    doublings = [point.orbit for point in branch.special_points if "doubling" in point.kind]
    for one in doublings:
        assert np.abs(one.multipliers + 1.0).min() < 1e-6
    for point in branch.special_points:
        if point.kind == "torus":
            sizes = np.abs(point.orbit.multipliers[np.abs(point.orbit.multipliers.imag) > 1e-6])
            assert np.abs(sizes - 1.0).min() < 1e-6
    # Beyond a doubling neighbours go to a motion of twice the period.
    first = branch.special_points[4]
    unstable = branch[first.row - 3]
    run = pc.simulate(NLVIB, unstable.loads, x0=unstable.x0 + 1e-4, v0=unstable.v0, periods=800)
    x, v = run(run.t_end)
    doubled = pc.find_orbit(NLVIB, unstable.loads, guess=(x, v), n_periods=2)
    assert doubled.is_stable
    assert np.abs(doubled.run(0.5 * doubled.period)[0] - doubled.x0).max() > 1e-3


def test_a_run_that_settles_leads_to_its_orbit_with_its_periods() -> None:
    """A motion of two periods attracts beside that without a contact."""
    loads = nlvib_loads("0.75")
    near = pc.find_orbits(NLVIB, loads, 2, 2)[-1]
    run = pc.simulate(NLVIB, loads, x0=near.x0 + 1e-3, v0=near.v0, periods=1200.3)

    orbit = pc.find_orbit(NLVIB, loads, guess=run)

    assert orbit.n_periods == 2
    assert orbit.is_stable
    x, v = run(run.stroboscopic(cycle=0.0).t.values[-1])
    off = min(
        np.abs(np.concatenate(orbit.run(k * orbit.period / 2)) - np.concatenate([x, v])).max()
        for k in range(2)
    )
    assert off < 1e-8
    # An orbit as the guess has its periods, too.
    assert pc.find_orbit(NLVIB, loads, guess=orbit).n_periods == 2


def test_in_chaos_an_orbit_is_found_from_one_of_the_states_that_the_motion_passes() -> None:
    wall = pc.Wall(at="0.5", side="above", restitution="0.7", on=0)
    chain = pc.chain([1, 1], [1, 1, 0], ["0.1", "0.1", 0], stops=(wall,))
    orbit = pc.find_orbit(chain, pc.Loads({0: pc.square_wave(2)}))
    assert not orbit.is_stable
    again = pc.simulate(chain, orbit.loads, x0=orbit.x0, v0=orbit.v0, t_end=orbit.period)
    assert np.abs(np.concatenate(again(orbit.period)) - [*orbit.x0, *orbit.v0]).max() < 1e-12


def test_a_doubled_branch_ends_at_the_doublings_at_both_ends() -> None:
    """It went on with the same orbits half a period later: each of its points came twice or more."""
    over = {"loads.0.omega": (0.6, 0.9)}
    shorter, doubled = pc.find_orbits(NLVIB, nlvib_loads("0.75"), 2, 2)[1::2]
    expected = [
        point.value
        for point in pc.continue_orbit(shorter, over=over).special_points
        if point.kind == "period_doubling"
    ]

    branch = pc.continue_orbit(doubled, over=over)

    kinds = [point.kind for point in branch.special_points]
    assert sorted(kinds) == ["fold", "period_doubling", "period_doubling"]
    assert (kinds[0], kinds[-1]) == ("period_doubling", "period_doubling")
    ends = [branch.special_points[0], branch.special_points[-1]]
    assert sorted(point.value for point in ends) == pytest.approx(sorted(expected), rel=1e-11)
    assert branch.end_reason.count("the orbit is the two-fold cover of a shorter one") == 2
    for point in ends:
        # The shorter orbit doubles there; the row is the same motion for two of its periods.
        assert (point.status, point.orbit.n_periods, branch[point.row].n_periods) == (
            "located",
            1,
            2,
        )
        assert np.abs(point.orbit.multipliers + 1.0).min() < 1e-7
        half = np.concatenate(branch[point.row].run(0.5 * branch[point.row].period))
        start = np.concatenate([branch[point.row].x0, branch[point.row].v0])
        assert np.abs(half - start).max() < 1e-9
    assert pc.switch_branch(ends[0]).n_periods == 2


def test_a_doubled_branch_reaches_its_doublings_over_any_range_in_any_steps() -> None:
    """Next to a doubling the tangent of a chord was wrong, and no step went on, or one went astray."""
    stiffness = np.array([[3000, -2000, 0], [-2000, 3500, -1500], [0, -1500, 1500]])
    masses = np.diag([2, 1, 1])
    stop = pc.SoftStop("0.002", "above", 50_000, 5, on=2)
    three = pc.Structure(masses, stiffness, 0.002 * stiffness + 0.05 * masses, [stop])
    orbit = pc.find_orbit(three, pc.Loads({0: pc.cosine("20.6", amplitude=10)}))
    base = pc.continue_orbit(orbit, over={"loads.0.omega": (20, 22.5)})
    first, second = (point for point in base.special_points if point.kind == "period_doubling")
    doubled = pc.continue_orbit(pc.switch_branch(first), over={"loads.0.omega": (20, 22.5)})

    branches = [doubled]
    for row in (20, 40, 60):
        for ends, step in (((20, 22.5), 0.02), ((20.5, 21.7), 0.05), ((19.1, 23.8), 0.05)):
            over = {"loads.0.omega": ends}
            branches.append(pc.continue_orbit(doubled[row], over=over, largest_step=step))

    for branch in branches:
        points = branch.special_points[0], branch.special_points[-1]
        assert [point.kind for point in points] == ["period_doubling"] * 2
        values = [point.value for point in points]
        assert values == pytest.approx([first.value, second.value], rel=1e-11)
        assert branch.values[[0, -1]].tolist() == values


def test_a_doubled_branch_ends_at_a_doubling_next_to_a_fold_of_the_shorter_orbits() -> None:
    """At the parameters of the bracket about it there were no shorter orbits."""
    stops: list[pc.Wall | pc.SoftStop] = [
        pc.Wall("0.339", "above", "0.565", on=1),
        pc.SoftStop("-0.44", "below", "15.34", "0.478", on=2),
        pc.SoftStop("0.237", "above", "8.881", "0.221", on=3),
    ]
    four = pc.chain(
        ["0.799", "0.633", "1.48", "1.189"],
        ["1.982", "1.777", "1.755", "0.577", "1.333"],
        dashpots="0.025",
        stops=stops,
    )
    loads = pc.Loads({0: pc.cosine("1.42", amplitude="0.387")})
    orbit = pc.find_orbits(four, loads, 4, 1, effort=0.3)[0]
    base = pc.continue_orbit(orbit, over={"loads.0.omega": (1.38, 1.45)})
    doubling = next(point for point in base.special_points if point.kind == "period_doubling")
    doubled = pc.switch_branch(doubling)

    for ends in ((1.27, 2.2), (1.0, 2.0), (1.25, 2.5), (1.0, 3.0)):
        branch = pc.continue_orbit(doubled, over={"loads.0.omega": ends}, max_points=8)

        end = branch.special_points[0]
        assert (end.kind, end.row, end.status) == ("period_doubling", 0, "located")
        assert end.value == pytest.approx(doubling.value, rel=1e-11)


def test_a_doubled_branch_does_not_fall_on_the_orbits_that_double() -> None:
    """It missed its doubling, and went on along the shorter orbits as if they were its own."""
    stops = [
        pc.SoftStop("0.3566", "above", "48.2", "0.3323", on=(1, -1)),
        pc.SoftStop("-0.3566", "below", "49.84", "0.3665", on=(1, -1)),
    ]
    two = pc.chain(["1.6305", "1.1978"], ["0.6556", "1.9503", 0], dashpots="0.1058", stops=stops)
    over = {"loads.0.omega": ("0.798", "1.383")}
    loads = pc.Loads({0: pc.cosine("1.0638", amplitude="0.9144")})
    base = pc.continue_orbit(pc.find_orbits(two, loads, 4, 2, effort=0.3)[0], over=over)
    doublings = [point for point in base.special_points if point.kind == "period_doubling"]
    assert len(doublings) == 2

    for doubling in doublings:
        branch = pc.continue_orbit(pc.switch_branch(doubling), over=over)

        ends = [branch.special_points[0].value, branch.special_points[-1].value]
        assert ends == pytest.approx(sorted(point.value for point in doublings), rel=1e-10)
        for orbit in branch.orbits[1:-1]:
            halves = np.concatenate(orbit.run(0.5 * orbit.period)) - [*orbit.x0, *orbit.v0]
            assert np.abs(halves).max() > 1e-8


def test_the_family_of_a_symmetry_breaking_next_to_its_fold_is_found() -> None:
    """A symmetric orbit at another parameter was taken for one of the pair that starts there."""
    stops = [
        pc.SoftStop("0.1565", "above", "31.587", "0.4018", on=1),
        pc.SoftStop("-0.1565", "below", "31.587", "0.4018", on=1),
    ]
    four = pc.chain(
        ["1.3527", "1.8622", "0.8814", "1.3832"],
        ["1.0387", "1.6346", "1.3146", "0.8031", 0],
        dashpots="0.025",
        stops=stops,
    )
    loads = pc.Loads({0: pc.cosine("0.475", amplitude="0.632")})
    over = {"loads.0.omega": ("0.465", "0.4785")}
    base = pc.continue_orbit(pc.find_orbit(four, loads), over=over)
    breaking = next(point for point in base.special_points if point.kind == "symmetry_breaking")

    for side in (False, True):
        other = pc.switch_branch(breaking, other_side=side)

        x, v = other.run(0.5 * other.period)
        assert np.abs([x + other.x0, v + other.v0]).max() > 1e-6


def test_a_family_of_mirrored_pairs_ends_where_its_orbits_are_symmetric() -> None:
    """It turned at the symmetric orbits without a special point, and came back mirrored."""
    stops = [
        pc.SoftStop("0.25", "above", "9.7", "0.43", on=1),
        pc.SoftStop("-0.25", "below", "9.7", "0.43", on=1),
    ]
    two = pc.chain(["0.97", "0.68"], ["0.985", "1.897", 0], dashpots="0.05", stops=stops)
    over = {"loads.0.omega": ("1.2", "1.57")}
    symmetric = pc.find_orbit(two, pc.Loads({0: pc.cosine("1.55", amplitude="0.56")}))
    ends = pc.continue_orbit(symmetric, over=over).special_points

    family = pc.continue_orbit(pc.switch_branch(ends[0]), over=over)

    assert [point.kind for point in ends] == ["symmetry_breaking", "symmetry_breaking"]
    assert family.end_reason.count("symmetric; beyond it lies the mirrored family") == 2
    first, last = family.special_points[0], family.special_points[-1]
    assert (first.row, last.row) == (0, len(family) - 1)
    for point, other in zip((first, last), sorted(ends, key=lambda end: end.value), strict=True):
        assert (point.kind, point.status) == ("symmetry_breaking", "located")
        assert point.value == pytest.approx(other.value, rel=1e-10)
        x, v = point.orbit.run(0.5 * point.orbit.period)
        assert np.abs([x + point.orbit.x0, v + point.orbit.v0]).max() < 1e-6
        assert np.abs(point.orbit.multipliers - 1.0).min() < 1e-6


def test_a_symmetry_between_walls_breaks_where_that_of_the_oscillator_does() -> None:
    walls = pc.Wall("0.5", "above", "0.6"), pc.Wall("-0.5", "below", "0.6")
    osc = pc.Oscillator(stiffness=1, damping="0.05", stops=walls)
    one = pc.Structure(mass=1, stiffness=1, damping="0.1", stops=walls)
    force = pc.cosine("1.5")
    (orbit, *_) = pc.find_orbits(osc, force, 2, 1)
    alone = pc.continue_orbit(orbit, over={"forcing.omega": ("1.1", "1.5")})
    expected = [point.value for point in alone.special_points if point.kind == "symmetry_breaking"]
    over = {"loads.0.omega": ("1.1", "1.5")}

    symmetric = pc.continue_orbit(pc.find_orbit(one, pc.Loads({0: force})), over=over)
    breaks = [point for point in symmetric.special_points if point.kind == "symmetry_breaking"]
    family = pc.continue_orbit(pc.switch_branch(breaks[0]), over=over)

    assert [point.value for point in breaks] == pytest.approx(expected, rel=1e-9)
    assert len(expected) == 2
    ends = [point for point in family.special_points if point.kind == "symmetry_breaking"]
    assert sorted(point.value for point in ends) == pytest.approx(sorted(expected), rel=1e-9)
    assert {point.row for point in ends} == {0, len(family) - 1}


def test_a_branch_folds_where_orbits_of_another_family_lie_beside_the_fold() -> None:
    """It went on along the other one, with a "branch point" without a multiplier of 1."""
    stops = [
        pc.SoftStop("0.3566", "above", "48.2", "0.3323", on=(1, -1)),
        pc.SoftStop("-0.3566", "below", "49.84", "0.3665", on=(1, -1)),
    ]
    two = pc.chain(["1.6305", "1.1978"], ["0.65559", "1.9503", 0], dashpots="0.10578", stops=stops)
    loads = pc.Loads({0: pc.cosine("1.0638", amplitude="0.91443")})
    orbit = pc.find_orbits(two, loads, 4, 1, effort=0.3)[2]

    branch = pc.continue_orbit(orbit, over={"loads.0.omega": ("1.01", "1.1")}, largest_step=0.1)

    kinds = [point.kind for point in branch.special_points]
    assert "branch_point" not in kinds
    folds = [point for point in branch.special_points if point.kind == "fold"]
    assert [fold.value for fold in folds] == pytest.approx([1.015213361563, 1.014813901241])
    assert all(np.abs(fold.orbit.multipliers - 1.0).min() < 1e-5 for fold in folds)


def test_a_branch_of_formal_orbits_ends_where_two_impacts_coincide() -> None:
    """It went on among instants that are solutions to rounding, with false folds and doublings."""
    wall = pc.Wall("0.4662", "above", "0.8305", on=(1, -1, 0))
    three = pc.chain(
        ["1.652", "0.689", "1.74"],
        ["1.774", "1.025", "1.267", 0],
        dashpots="0.08218",
        stops=[wall],
    )
    loads = pc.Loads({0: pc.cosine("1.058", amplitude="1.176")})
    orbit = pc.find_orbits(three, loads, 4, 2, effort=0.3)[1]

    branch = pc.continue_orbit(orbit, over={"loads.0.omega": ("0.79", "1.38")}, largest_step=0.1)

    assert branch.end_reason.count("impacts coincide") == 2
    for end in (branch[0], branch[-1]):
        nearest = int(np.argmin(np.diff(end.run.impacts.t)))
        assert np.abs(end.run.impacts.v_before[nearest : nearest + 2]).max() < 1e-2
    ends = branch.values[[0, -1]]
    points = np.array([point.value for point in branch.special_points])
    assert np.abs(points[:, None] - ends).min() > 1e-4


@pytest.mark.parametrize(
    "path",
    [
        "loads.0.omega",
        "loads.0.amplitude",
        "structure.stiffness.0.1",
        "structure.damping.1.1",
        "structure.stops.1.stiffness",
    ],
)
def test_equations_between_walls_have_their_derivatives_by_parameters(path: str) -> None:
    """They were differences, wrong where a soft stop is grazed within these."""
    stops: list[pc.Wall | pc.SoftStop] = [
        pc.Wall("0.36", "above", "0.88", on=0),
        pc.SoftStop("-0.2", "below", 55, "0.41", on=1),
    ]
    two = pc.chain(["1.2", "0.8"], ["0.9", "1.3", "1.1"], dashpots="0.06", stops=stops)
    orbit = pc.find_orbit(two, pc.Loads({0: pc.cosine("0.9", amplitude="0.6")}))
    value = structure_parameter(orbit, path)
    low, high = sorted((0.9 * value, 1.1 * value))
    equations = WallEquations(orbit, {path: (low, high)})
    z = np.append(equations.unknowns(orbit), 0.5)
    assert len(orbit.run.impacts) > 0
    assert len(orbit.run.crossings) > 0

    found = equations.derivatives(z)[:, -1]

    def difference(step: float) -> Floats:
        along = along_parameter(len(z))
        ahead, behind = (equations.missed(z + sign * step * along) for sign in (1.0, -1.0))
        return np.asarray((ahead - behind) / (2.0 * step))

    # Without the error of the second order.
    expected = (4.0 * difference(1e-4) - difference(2e-4)) / 3.0
    assert found == pytest.approx(expected, abs=1e-10 * max(1.0, np.abs(expected).max()))


def test_a_doubled_orbit_is_found_where_the_branch_of_the_shorter_one_grazes_soon() -> None:
    """The family bends within a thousandth of its size: all steps onto it were longer."""
    stops: list[pc.Wall | pc.SoftStop] = [
        pc.Wall("0.315", "above", "0.7945", on=3),
        pc.SoftStop("-0.41", "below", "59.1", "0.222", on=0),
    ]
    four = pc.chain(
        ["1.27", "1.96", "0.62", "1.41"],
        ["1.06", "1.7", "0.76", "1.81", "1.32"],
        dashpots="0.0677",
        stops=stops,
    )
    loads = pc.Loads({2: pc.cosine("1.77", amplitude="0.809")})
    (orbit,) = pc.find_orbits(four, loads, 4, 1, effort=0.3)
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": ("1.75", "1.81")})
    doubling = next(point for point in branch.special_points if point.kind == "period_doubling")

    doubled = pc.switch_branch(doubling)

    assert (doubled.n_periods, doubled.n_impacts) == (2, 4)
    run = pc.simulate(four, doubled.loads, x0=doubled.x0, v0=doubled.v0, t_end=doubled.period)
    assert np.abs(np.concatenate(run(run.t_end)) - [*doubled.x0, *doubled.v0]).max() < 1e-10
    assert np.abs(run(0.5 * run.t_end)[0] - doubled.x0).max() > 1e-6


@pytest.mark.parametrize("seed", range(4))
def test_the_derivative_of_a_run_is_that_of_differences(seed: int) -> None:
    random = np.random.default_rng(seed)
    stops: list[pc.Wall | pc.SoftStop] = [
        pc.Wall(at=0.3, side="above", restitution=float(random.choice([0.5, 0.8])), on=0),
        pc.Wall(at=-0.2, side="below", restitution=pc.restitution_table([0, 1], [0.9, 0.6]),
                on=(1, -1, 0)),
        pc.SoftStop(at=0.02, side="above", stiffness=50, damping=0.3, on=2),
    ]  # fmt: skip
    structure = pc.chain(
        masses=[1, 1, 2], springs=[1, 2, 1, 0.5], dashpots=[0.05, 0.1, 0.02, 0.03], stops=stops
    )
    push = pc.cosine(1.3, amplitude=1.0) + pc.Forcing(constant=0.5)
    loads = pc.Loads({0: push, 2: pc.sine(2.6, amplitude=0.7)}, period=2 * math.pi / 1.3)
    system = StructureSystem.of(structure, loads)
    state = np.concatenate([np.zeros(3), random.normal(size=3) * 0.3])

    found = period_map(system, state, 2)

    assert found.derivative == pytest.approx(by_differences(system, state, 2), abs=3e-7, rel=3e-7)


def test_one_coordinate_has_the_multipliers_of_the_oscillator() -> None:
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine("2.0"))
    structure = pc.Structure(
        mass=1, stiffness=1, damping="0.1", stops=[pc.Wall("0.2", "above", "0.8")]
    )
    run = orbit.trajectory()
    # At phase 0 of the force: the orbit's own run starts at an impact.
    t = math.ceil(run.t0 / orbit.period) * orbit.period
    x, v = run(t)

    found = pc.find_orbit(structure, pc.cosine("2.0"), guess=([float(x)], [float(v)]))

    assert found.n_impacts == orbit.n_impacts
    assert found.multipliers == pytest.approx(orbit.multipliers, abs=1e-9)


def test_a_motion_that_sticks_has_a_multiplier_zero() -> None:
    structure = pc.Structure(
        mass=[1, 3], stiffness=[[2, -1], [-1, 2]], damping=[["0.2", 0], [0, "0.2"]],
        stops=[pc.Wall(at=0, side="below", restitution=0, on=0)],
    )  # fmt: skip

    orbit = pc.find_orbit(structure, pc.Loads({0: pc.cosine("0.7", amplitude=2)}))

    assert len(orbit.run.contacts) > 0
    assert np.abs(orbit.multipliers).min() < 1e-12
    state = np.concatenate([orbit.x0, orbit.v0])
    differences = by_differences(StructureSystem.of(structure, orbit.loads), state, 1)
    assert orbit.monodromy == pytest.approx(differences, abs=1e-6)


@pytest.mark.parametrize(
    ("loads", "keywords", "message"),
    [
        (
            pc.Loads({0: pc.cosine(1), 1: pc.cosine(2**0.5)}),
            {},
            "a periodic orbit needs loads of one period",
        ),
        (nlvib_loads("1"), {"guess": 3.0}, "not a state"),
        (nlvib_loads("1"), {"guess": ([0.0], [0.0])}, "1 number for 2 coordinates"),
        (nlvib_loads("1"), {"n_periods": 0}, "at least 1"),
    ],
)
def test_what_does_not_fit_is_told(
    loads: pc.Loads, keywords: dict[str, object], message: str
) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.find_orbit(NLVIB, loads, **keywords)  # type: ignore[call-overload]


@pytest.mark.parametrize(
    ("restitution", "omega"),
    [("0.5", "0.7"), pytest.param("0.8", "0.35", marks=pytest.mark.nightly)],
)
def test_the_derivative_over_a_chatter_a_contact_and_a_release_is_that_of_the_oracle(
    restitution: str, omega: str
) -> None:
    """A difference of two motions of 77 digits; dashpots couple the mass that chatters to the other."""
    wall = pc.Wall("-0.1", "below", restitution, on=0)
    chain = pc.chain([1, 2], [1, 2, 1], ["0.1", "0.1", "0.05"], [wall])
    pushed = pc.cosine(omega, amplitude="0.3", constant="-0.4")
    loads = pc.Loads([(0, pushed), (1, pc.sine(omega, amplitude="0.2"))])
    system = StructureSystem.of(chain, loads)
    start, way = np.array([0.05, 0.1, 0.3, -0.2]), np.array([0.5, -0.25, 0.75, 1.0])

    derivative = period_map(system, start, 1).derivative @ way

    step, problem, ends = Fraction(1, 2**40), structure_problem(chain, loads), []
    end = Fraction(loads.period or 0.0)
    for sign in (1, -1):
        state = [Fraction(a) + sign * step * Fraction(b) for a, b in zip(start, way, strict=True)]
        run = simulate_structure(problem, state[:2], state[2:], t_end=end)
        assert [event.kind for event in run.events if event.kind != "impact"] == ["rest", "release"]
        x, v = run(end)
        ends.append([*x, *v])
    exact = [float((a - b) / (2 * float(step))) for a, b in zip(*ends, strict=True)]
    np.testing.assert_allclose(derivative, exact, rtol=0, atol=1e-13)


def test_a_range_without_the_own_value_is_refused() -> None:
    orbit = pc.find_orbit(NLVIB, nlvib_loads("0.65"))

    with pytest.raises(pc.ParameterError, match=r"no range that holds the orbit's own value"):
        pc.continue_orbit(orbit, over={"loads.0.omega": (0.8, 0.9)})


def test_curves_of_folds_and_doublings_meet_at_one_orbit() -> None:
    orbit = pc.find_orbit(NLVIB, nlvib_loads("0.8"))
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (0.8, 0.65)}, largest_step=0.2)
    ranges = {"loads.0.omega": (0.7, 0.8), "loads.0.amplitude": (0.09, 0.12)}

    places = []
    for kind, row in (("fold", 1), ("period_doubling", 0)):
        point = [one for one in branch.special_points if one.kind == kind][row]
        curve = pc.continue_curve(point, over=ranges, largest_step=0.1)
        assert max(one.residual for one in curve.orbits) < 1e-11
        (place,) = (one for one in curve.special_points if one.kind == "fold_doubling")
        places.append(place.values)

    # Located on either curve, with derivatives that are differences.
    assert places[0] == pytest.approx(places[1], abs=1e-9)


def folds_of(structure: pc.Structure) -> list[pc.StructureSpecialPoint]:
    orbit = pc.find_orbit(structure, pc.Loads({0: pc.cosine("1.5", amplitude=2)}))
    branch = pc.continue_orbit(orbit, over={"loads.0.amplitude": (3.0, 1.0)}, largest_step=0.1)
    return [point for point in branch.special_points if point.kind == "fold"]


def test_curves_of_folds_meet_in_a_cusp() -> None:
    soft = pc.SoftStop(1, "above", 9, on=0)
    one = pc.Structure(1, 1, "0.1", stops=[soft])
    two = pc.chain([1, "0.2"], [1, "0.1", 0], "0.05", [soft])
    ranges = {"loads.0.omega": (1.4, 1.7), "loads.0.amplitude": (1.0, 1.6)}
    places = []
    for structure in (one, two):
        curves = [pc.continue_curve(fold, ranges, largest_step=0.1) for fold in folds_of(structure)]
        assert len(curves) == 2
        (place,), (other,) = ([p for p in c.special_points if p.kind == "cusp"] for c in curves)
        assert place.values == pytest.approx(other.values, abs=1e-10)
        places.append(place.values)

    # That of the oscillator, which has equations of its own (tests/orbits/test_curve_points.py).
    assert places[0] == pytest.approx((1.5061875042422, 1.3294810409536), abs=1e-10)
    # Beyond that of two masses no orbit of the family folds.
    omega, amplitude = places[1]
    for part, count in ((0.995, 2), (1.005, 0)):
        loads = pc.Loads({0: pc.cosine(omega - 0.04, amplitude=part * amplitude)})
        branch = pc.continue_orbit(
            pc.find_orbit(two, loads), over={"loads.0.omega": (omega - 0.06, omega + 0.06)}
        )
        assert sum(point.kind == "fold" for point in branch.special_points) == count


def test_a_curve_of_torus_points_has_its_strong_resonances() -> None:
    orbit = pc.find_orbit(NLVIB, nlvib_loads("0.60"))
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (0.57, 0.63)}, largest_step=0.2)
    torus = [point for point in branch.special_points if point.kind == "torus"][-1]
    ranges = {"loads.0.omega": (0.57, 0.63), "loads.0.amplitude": (0.07, 0.11)}

    curve = pc.continue_curve(torus, over=ranges, largest_step=0.1)

    assert curve.kind == "torus"
    (resonance,) = (point for point in curve.special_points if point.kind == "resonance_1_4")
    # A quarter of a turn in each period.
    assert np.abs(resonance.orbit.multipliers - 1j).min() < 1e-7


def test_points_on_two_curves_are_found_on_both_under_one_name() -> None:
    """Of torus points and doublings, or folds, those on the curve of torus points were missing."""
    stop = pc.SoftStop("0.223", "above", "39.48", "0.364", on=(1, -1))
    two = pc.chain(["1.645", "1.935"], ["1.137", "1.316", 0], dashpots="0.05", stops=[stop])
    orbit = pc.find_orbit(two, pc.Loads({0: pc.cosine("0.661", amplitude="0.44")}))
    branch = pc.continue_orbit(
        orbit, over={"loads.0.omega": ("0.56185", "0.76015")}, largest_step=0.1
    )
    found = []
    cases = (("fold", 0.6203188, ("0.3955", "0.445")), ("torus", 0.6239615, ("0.22", "0.66")))
    for kind, value, amplitudes in cases:
        (point,) = (
            point
            for point in branch.special_points
            if point.kind == kind and abs(point.value - value) < 1e-6
        )
        ranges = {"loads.0.omega": ("0.46", "0.86"), "loads.0.amplitude": amplitudes}
        curve = pc.continue_curve(point, ranges, largest_step=0.3)
        found.append([(place.kind, place.values) for place in curve.special_points])

    (folds, others) = found
    assert {kind for kind, _ in folds} == {"fold_torus", "resonance_1_1"}
    for kind, values in folds:
        assert (
            min(np.abs(np.subtract(values, place)).max() for also, place in others if also == kind)
            < 1e-9
        )


def test_a_closed_family_of_three_periods_is_followed_once() -> None:
    """Once round it is the same orbit one period of the loads later."""
    mass = np.diag([2.0, 1.0, 1.0])
    stiffness = np.array([[3000, -2000, 0], [-2000, 3500, -1500], [0, -1500, 1500]])
    stop = pc.SoftStop(at=0.002, side="above", stiffness=50e3, damping=5, on=2)
    structure = pc.Structure(mass, stiffness, 0.002 * stiffness + 0.05 * mass, [stop])
    guess = [-0.007111, -0.005252, -0.00414], [0.00973, -0.2771, -0.2361]
    orbit = pc.find_orbit(structure, pc.Loads({0: pc.cosine(57, 10)}), n_periods=3, guess=guess)
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (50, 60)})

    assert branch.end_reason == "the branch closed"
    doublings = [p.value for p in branch.special_points if p.kind == "period_doubling"]
    assert sorted(doublings) == pytest.approx([54.05925, 54.96796, 56.35956, 57.78761], abs=1e-5)


def test_the_end_of_a_doubled_branch_is_one_special_point() -> None:
    """A branch point stood in the row before the doubling, 1e-12 from it: the doubling itself."""
    stops: list[pc.Wall | pc.SoftStop] = [
        pc.Wall(0.3604964468042833, "above", 0.8820828121902569, on=0),
        pc.SoftStop(-0.4686453808455683, "below", 54.947017975263776, 0.40665947628200344, on=1),
    ]
    two = pc.Structure(
        [[1.8082653714058134, 0], [0, 0.8641135814066214]],
        [[2.702730521247475, -1.226138574454947], [-1.226138574454947, 2.908938815706251]],
        [[0.21994439929536996, -0.10997219964768498], [-0.10997219964768498, 0.21994439929536996]],
        stops,
    )
    omega = 0.7323213781582661
    loads = pc.Loads({1: pc.cosine(omega, amplitude=1.199501739191368)})
    over = {"loads.0.omega": (0.75 * omega, 1.3 * omega)}
    for orbit in pc.find_orbits(two, loads, 4, 2, effort=0.3)[:3]:
        base = pc.continue_orbit(orbit, over=over, max_points=600)
        first = [p for p in base.special_points if abs(p.value - 0.870194149412) < 1e-9]
        if first:
            break
    branch = pc.continue_orbit(pc.switch_branch(first[0]), over=over, max_points=600)

    assert "two-fold cover" in branch.end_reason
    # The orbit at the second graze has a multiplier above 1: it lies between two folds.
    assert [point.kind for point in branch.special_points] == [
        "period_doubling", "grazing", "fold", "grazing", "fold", "period_doubling",
    ]  # fmt: skip
    largest = [abs(point.orbit.multipliers[0]) for point in branch.special_points[2:5]]
    assert largest[::2] == pytest.approx([1.0, 1.0], abs=1e-6)
    assert largest[1] > 1.001


def test_orbits_of_one_displacement_and_of_several_are_read_alike() -> None:
    wall = pc.Wall(at="0.2", side="above", restitution="0.7")
    one = pc.find_orbit(pc.Oscillator(1, "0.1", [wall]), pc.cosine(2))
    walls = [pc.Wall(at="0.2", side="above", restitution="0.7", on=0)]
    several = pc.find_orbit(pc.Structure(1, 1, "0.2", walls), {0: pc.cosine(2)})

    for orbit in (one, several):
        assert orbit.run.t_end - orbit.run.t0 == pytest.approx(orbit.period)
        np.testing.assert_allclose(orbit.run.impacts.v_after, orbit.impacts.v_after, rtol=1e-12)
    assert len(one.impacts) == len(several.impacts) == 1
    np.testing.assert_allclose(one.impacts.v_before, several.impacts.v_before, rtol=1e-9)


def test_without_damping_orbits_are_elliptic_and_have_no_torus_points() -> None:
    two = pc.chain([1, 1], [1, 1, 1])
    orbit = pc.find_orbit(two, {0: pc.cosine("0.7")})
    assert (orbit.stability, orbit.is_stable) == ("elliptic", False)
    assert "elliptic" in repr(orbit)
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (0.6, 0.95)})
    # All multipliers stay on the unit circle: their distance from it is rounding.
    assert branch.special_points == ()
    assert set(branch.stability) == {"elliptic"}


def test_between_elastic_walls_orbits_have_the_stability_of_the_oscillators() -> None:
    osc, force = pc.Oscillator(1, 0, (pc.Wall("0.5", "above", 1),)), pc.cosine("0.7", "0.3")
    one = pc.Structure([1], [1], stops=[pc.Wall("0.5", "above", 1, on=0)])
    found = pc.find_orbits(one, {0: force}, 2, 1), pc.find_orbits(osc, force, 2, 1)
    ours, theirs = (sorted((each.n_impacts, each.stability) for each in orbits) for orbits in found)
    assert ours == theirs == [(1, "elliptic"), (2, "elliptic"), (2, "unstable")]
