"""Response charts of structures, and the families that start at their special points."""

from __future__ import annotations

import functools

import numpy as np
import pytest

import percuss as pc
import percuss.plotting as pp

# Example 03 of NLvib (Krack & Gross), whose parameters alone are taken.
STOP = pc.SoftStop(at=1, side="above", stiffness=100, on=0)
NLVIB = pc.chain([1, 1], [0, 1, 1], [0, "0.03", "0.03"], [STOP])
LOADS = pc.Loads({1: pc.cosine(1, "0.1")})
OMEGA = "loads.0.omega"


@functools.cache
def nlvib_chart() -> pc.Response:
    """Return the chart around the doublings, where three families lie above each other."""
    return pc.response_curve(NLVIB, LOADS, {OMEGA: (0.752, 0.757)}, on=0, max_periods=2, n_seeds=1)


def test_all_families_are_found_and_no_attractor_is_on_none() -> None:
    chart = nlvib_chart()

    kinds = {(family.n_impacts, family.n_periods): family for family in chart.families}
    assert set(kinds) == {(0, 1), (1, 1), (2, 2)}
    assert chart.complete
    assert chart.missed == ()
    single, double = kinds[1, 1], kinds[2, 2]
    # The orbit with one contact is stable from its doubling to its fold, the doubled one, which
    # comes back from beyond, to its own; all these are those of `continue_orbit`.
    assert single.stable_ranges[0][0] == pytest.approx(0.755586159, abs=1e-9)
    assert single.ranges[-1][1] == pytest.approx(0.755627353, abs=1e-9)
    assert double.stable_ranges[-1][1] == pytest.approx(0.755662738, abs=1e-9)


def test_each_number_of_a_branch_is_that_of_its_motion() -> None:
    chart = nlvib_chart()

    for k, branch in enumerate(chart.branches):
        for row in range(0, len(branch), 17):
            run = branch[row].run
            x, _ = run(np.linspace(0.0, run.t_end, 4001))
            amplitude = 0.5 * np.ptp(x[:, 0])
            assert amplitude <= chart.amplitude[k][row] * (1.0 + 1e-12)
            assert chart.amplitude[k][row] == pytest.approx(amplitude, rel=1e-5)
            assert chart.largest_displacement[k][row] == pytest.approx(abs(x[:, 0]).max(), rel=1e-5)
            entries = run.crossings.v[run.crossings.direction == "in"]
            found = chart.impact_velocity[k][row]
            assert found == max(entries) if len(entries) else np.isnan(found)


def test_one_coordinate_has_the_chart_of_the_oscillator() -> None:
    # The ranges of the oscillator's chart are in the docstring of `response_curve`.
    structure = pc.Structure(1, 1, "0.1", stops=[pc.Wall("0.2", "above", "0.8")])

    chart = pc.response_curve(
        structure, pc.cosine(1), {OMEGA: (1.0, 1.5)}, max_impacts=1, max_periods=1, n_seeds=2
    )

    (family,) = (one for one in chart.families if one.n_impacts == 1)
    ends = [end for stable in family.stable_ranges for end in stable]
    assert ends == pytest.approx([1.0, 1.064834, 1.130040, 1.5], abs=6e-7)


def test_a_branch_goes_on_where_an_impact_passes_the_strobe() -> None:
    structure = pc.Structure(1, 1, "0.1", stops=[pc.Wall("0.2", "above", "0.8")])
    orbit = pc.find_orbit(structure, pc.cosine("1.01"))

    branch = pc.continue_orbit(orbit, over={OMEGA: (1.0, 1.02)}, largest_step=0.3)

    assert (branch.values.min(), branch.values.max()) == (1.0, 1.02)
    # Its instant goes through 0, where the state that is solved for jumps.
    parts = np.array([orbit.run.impacts.t[0] / orbit.period for orbit in branch.orbits])
    assert np.abs(np.diff(parts)).max() > 0.9
    assert np.ptp((parts + 0.5) % 1.0) < 0.1
    assert branch.special_points == ()


def test_a_branch_goes_on_where_an_entry_passes_the_strobe_next_to_a_fold() -> None:
    """The dashpot makes a kink there; a start on the stop itself was taken to be inside it."""
    stops = [
        pc.SoftStop("0.3175", "above", "51.12", "0.2354", on=(1, -1, 0, 0)),
        pc.SoftStop("-0.3175", "below", "31.1", "0.406", on=(1, -1, 0, 0)),
    ]
    four = pc.chain(
        [1.71, 1.27, 0.93, 0.58], [1.08, 1.11, 0.57, 0.57, 2], dashpots="0.04345", stops=stops
    )
    near = [0.9281, 1.2486, 1.1661, 0.483], [0.4344, 0.2039, 0.334, 0.0757]
    orbit = pc.find_orbit(four, pc.Loads({3: pc.cosine("0.58", amplitude="0.4715")}), guess=near)

    branch = pc.continue_orbit(orbit, {OMEGA: (0.5, 1.0)}, max_points=40, largest_step=0.05)

    assert branch.end_reason.count("max_points = 40 reached") == 2


def test_a_direction_is_measured_and_drawn() -> None:
    chart = pc.response_curve(
        NLVIB, LOADS, {OMEGA: (0.8, 0.9)}, on=(1, -1), max_impacts=1, max_periods=1, n_seeds=1
    )

    (branch,) = chart.branches
    x, _ = branch[0].run(np.linspace(0.0, branch[0].period, 4001))
    assert chart.amplitude[0][0] == pytest.approx(0.5 * np.ptp(x[:, 0] - x[:, 1]), rel=1e-6)
    ax = pp.plot_response(chart)
    assert ax.get_ylabel().startswith("amplitude, half peak to peak, $x_{0} - x_{1}$")
    assert chart.to_xarray().sizes["point"] == len(branch)


def test_the_doubled_orbit_starts_at_the_doubling() -> None:
    branch = nlvib_chart().branches[1]
    point = next(one for one in branch.special_points if one.kind == "period_doubling")

    one, other = (pc.switch_branch(point, other_side=side) for side in (False, True))

    assert (one.n_periods, one.n_impacts, one.is_stable) == (2, 2, False)
    x, _ = one.run([0.0, 0.5 * one.period])
    assert np.abs(x[0] - x[1]).max() > 1e-3
    # On the other side lies its other half, at almost the same frequency.
    off = [orbit.x0 - point.orbit.x0 for orbit in (one, other)]
    assert (off[0] * off[1]).sum() < -0.9 * (off[0] * off[0]).sum()


def test_no_family_of_a_structure_starts_at_a_fold() -> None:
    branch = nlvib_chart().branches[1]
    fold = next(point for point in branch.special_points if point.kind == "fold")

    with pytest.raises(pc.ParameterError, match="of kind fold of a structure"):
        pc.switch_branch(fold)


@pytest.mark.parametrize(
    ("loads", "over", "keywords", "message"),
    [
        (LOADS, {OMEGA: (0.7, 0.8)}, {}, "on"),
        (LOADS, {OMEGA: (0.7, 0.7)}, {"on": 0}, "not a range of two different finite numbers"),
        (LOADS, {"forcing.omega": (0.7, 0.8)}, {"on": 0}, "forcing"),
        (pc.Loads({0: pc.cosine(1), 1: pc.cosine(2**0.5)}), {OMEGA: (1, 2)}, {"on": 0},
         "a periodic orbit needs a periodic forcing"),
        (pc.Loads({0: pc.record([0, 1], [0, 1])}), {"structure.mass.0.0": (1, 2)}, {"on": 0},
         "a periodic orbit needs a periodic forcing"),
        (None, {OMEGA: (0.7, 0.8)}, {"on": 0}, "a response is one to a forcing"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_told(
    loads: pc.Loads, over: dict[str, object], keywords: dict[str, object], message: str
) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.response_curve(NLVIB, loads, over, **keywords)  # type: ignore[arg-type]


def test_an_oscillator_has_one_displacement() -> None:
    with pytest.raises(pc.ParameterError, match="which has one displacement"):
        pc.response_curve(
            pc.impact_oscillator("0.8"), pc.cosine(1), {"forcing.omega": (1, 2)}, on=0
        )
