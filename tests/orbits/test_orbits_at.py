"""The orbits of a branch at one value of its parameter."""

import numpy as np
import pytest

import percuss as pc

OMEGA = "forcing.omega"


def test_a_branch_that_turns_back_has_an_orbit_for_each_of_its_parts() -> None:
    two = pc.Structure(
        mass=[1, 1],
        stiffness=[[1, -1], [-1, 2]],
        damping=[["0.03", "-0.03"], ["-0.03", "0.06"]],
        stops=[pc.SoftStop(at=1, side="above", stiffness=100, on=0)],
    )
    orbit = pc.find_orbit(two, pc.Loads({1: pc.cosine("0.8", amplitude="0.1")}))
    branch = pc.continue_orbit(orbit, over={"loads.0.omega": (0.8, 0.65)}, largest_step=0.2)
    folds = sorted(point.value for point in branch.special_points if point.kind == "fold")
    value = 0.5 * (folds[0] + folds[1])
    parts = np.diff(np.sign(branch.values - value)) != 0.0

    found = pc.orbits_at(branch, value)

    assert len(found) == parts.sum() > 1
    assert max(one.residual for one in found) < 1e-11
    for one in found:
        assert isinstance(one.loads, pc.Loads)
        assert float(one.loads.forcings[0].components()[0].omega) == value
    # In the order of the rows, each like its neighbours and like no other.
    rows = np.flatnonzero(parts)
    for one, row in zip(found, rows, strict=True):
        largest = abs(one.multipliers[0])
        near = [abs(branch.multipliers[k, 0]) for k in (row, row + 1)]
        assert min(near) - 0.05 < largest < max(near) + 0.05
    states = np.array([one.x0 for one in found])
    assert len(np.unique(states.round(8), axis=0)) == len(found)


def test_rows_themselves_ends_and_values_elsewhere() -> None:
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    branch = pc.continue_orbit(orbit, over={OMEGA: ("2.5", "2.8")})

    for row in (0, 5, len(branch) - 1):
        (same,) = pc.orbits_at(branch, float(branch.values[row]))
        assert same is branch.orbits[row]
    assert pc.orbits_at(branch, "2.9") == []
    (doubling,) = (point for point in branch.special_points if point.kind == "period_doubling")
    (beyond,) = pc.orbits_at(branch, doubling.value + 1e-3)
    assert beyond.multipliers.real.min() < -1.0
    with pytest.raises(pc.ParameterError, match="value = nan: "):
        pc.orbits_at(branch, float("nan"))
    with pytest.raises(pc.ParameterError, match="value = 'fast': "):
        pc.orbits_at(branch, "fast")


def test_orbits_that_stick_have_them_too() -> None:
    stuck = pc.find_orbit(pc.impact_oscillator(0.3, damping=0.05), pc.cosine(0.8), np.inf)
    branch = pc.continue_orbit(stuck, over={OMEGA: (0.7, 0.9)})

    (other,) = pc.orbits_at(branch, 0.7654)

    assert other.n_impacts == np.inf
    assert other.forcing == pc.cosine(0.7654)


def test_limit_cycles_have_them_too() -> None:
    stops = (pc.SoftStop("0.5", "above", 20, "0.4"), pc.Wall(-1, "below", "0.5"))
    cycle = pc.find_orbit(pc.Oscillator(damping="-0.02", stops=stops))
    branch = pc.continue_orbit(cycle, over={"oscillator.damping": ("-0.02", "-0.03")})

    (other,) = pc.orbits_at(branch, "-0.0256")

    assert other.residual < 1e-10
    assert float(other.oscillator.damping) == -0.0256


def test_a_branch_says_how_many_of_its_orbits_are_formal() -> None:
    osc = pc.impact_oscillator("0.8", wall=1, side="above", damping="0.05")
    orbit = pc.find_orbit(osc, pc.cosine("0.4", amplitude="0.5"), n_impacts=0)
    branch = pc.continue_orbit(orbit, over={OMEGA: ("0.4", "0.9")})
    n_formal = int((~branch.admissible).sum())
    assert 0 < n_formal < len(branch)

    assert repr(branch).startswith(f"<Branch: {len(branch)} orbits, {n_formal} formal, forcing.")
    (graze,) = (point for point in branch.special_points if point.kind == "grazing")
    analysis = graze.graze
    assert analysis in {analysis, None}
