from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles import lyapunov, structure_batch
from percuss.model.acting_sets import StructureSystem

OMEGA = "loads.0.omega"
ABSORBER = pc.vibro_impact_absorber(
    1, 1, absorber_mass="0.1", gap="0.5", restitution="0.65", damping="0.05"
)
LOADS = pc.Loads({0: pc.cosine(1, amplitude="0.3")})
# A wall that is struck and sticks, a soft stop with a dashpot between the masses, coupled damping.
MIXED = pc.Structure(
    mass=[["1", "0.1"], ["0.1", "0.5"]],
    stiffness=[[3, -1], [-1, 1]],
    damping=[["0.2", "-0.02"], ["0.03", "0.1"]],
    stops=[
        pc.Wall(at="0.35", side="above", restitution="0.3", on=0),
        pc.SoftStop(at="-0.1", side="below", stiffness=40, damping="0.4", on=(1, -1)),
    ],
)
PUSHED = pc.Loads({0: pc.cosine("0.9", amplitude="1.4") + pc.Forcing(constant="0.3")})


def followed(structure: pc.Structure, omega: float, periods: int, **start: Any) -> Any:
    """Return a run, and the period of its loads."""
    loads = {ABSORBER: LOADS, MIXED: PUSHED}[structure]
    constant = loads.forcings[0].constant
    part = loads.forcings[0].harmonics[0]
    assert isinstance(part, pc.Harmonic)
    amplitude = part.amplitude
    force = pc.cosine(omega, amplitude=amplitude) + pc.Forcing(constant=constant)
    period = float(force.period or 0.0)
    begin = {"x0": [0, 0], "v0": [0, 0]} | start
    return pc.simulate(structure, {0: force}, t_end=(periods + 1) * period, **begin), period


CASES = [(ABSORBER, LOADS), (MIXED, PUSHED)]
NAMES = ["absorber", "soft and sticking"]


def test_bits_of_a_run_do_not_depend_on_which_sets_are_known() -> None:
    """The first run stops at each set of acting stops that it meets, the second at none."""
    omega = 0.8765
    first, period = followed(MIXED, omega, 100)
    second, _ = followed(MIXED, omega, 100)

    t = np.linspace(0, 100 * period, 1001)
    assert first(t)[0].tobytes() == second(t)[0].tobytes()


@pytest.mark.parametrize(("structure", "loads"), CASES, ids=NAMES)
@pytest.mark.parametrize("on", [0, 1, (1, -1)])
def test_strobes_are_those_of_plain_runs_to_the_bit(
    structure: pc.Structure, loads: pc.Loads, on: Any
) -> None:
    values = [0.8, 0.9, 1.1]

    diagram = pc.bifurcation_diagram(
        structure, loads, over={OMEGA: values}, on=on, follow=(), transient=30, points=90,
        start=([0, 0], [0.1, 0]),
    )  # fmt: skip

    for i, omega in enumerate(values):
        run, period = followed(structure, omega, 120, x0=[0, 0], v0=[0.1, 0])
        y, v = run.displacement(on, 30 * period + np.arange(90) * period)
        assert diagram.x.values[0, i].tobytes() == y.tobytes()
        assert diagram.v.values[0, i].tobytes() == v.tobytes()


@pytest.mark.parametrize(("structure", "loads"), CASES, ids=NAMES)
@pytest.mark.parametrize("stop", [None, 0, 1])
def test_impacts_are_the_last_of_plain_runs(
    structure: pc.Structure, loads: pc.Loads, stop: int | None
) -> None:
    diagram = pc.bifurcation_diagram(
        structure, loads, over={OMEGA: [0.8, 0.9]}, section="impacts", on=stop, follow=(),
        transient=20, points=30,
    )  # fmt: skip

    for i, omega in enumerate([0.8, 0.9]):
        run, period = followed(structure, omega, 49)
        entries = run.crossings.direction == "in"
        t = np.concatenate([run.impacts.t, run.crossings.t[entries]])
        v = np.concatenate([run.impacts.v_after, run.crossings.v[entries]])
        stops = np.concatenate([run.impacts.stop, run.crossings.stop[entries]])
        kept = (t >= 20 * period) & (t <= 49 * period)
        kept &= (stops == stop) if stop is not None else True
        order = np.argsort(t[kept], kind="stable")[-30:]
        ours = diagram.isel({"branch": 0, OMEGA: i})
        filled = np.isfinite(ours.v_after.values)
        assert filled.sum() == len(order)
        assert len(order) > 5
        np.testing.assert_array_equal(ours.v_after.values[filled], v[kept][order])
        np.testing.assert_array_equal(ours.bound.values[filled], stops[kept][order])
        np.testing.assert_array_equal(ours.cycle.values[filled], t[kept][order] / period % 1.0)


@pytest.mark.parametrize(("structure", "loads"), CASES, ids=NAMES)
def test_measures_are_those_of_densely_sampled_runs(
    structure: pc.Structure, loads: pc.Loads
) -> None:
    names = [
        "max_displacement", "min_displacement", "peak_displacement", "peak_stop_force",
        "contact_share", "peak_impact_velocity", "impacts_per_period",
    ]  # fmt: skip

    found = pc.sweep(
        names, structure, loads, over={OMEGA: [0.9]}, on=(1, -1), transient=20, periods=20
    ).isel({OMEGA: 0})

    run, period = followed(structure, 0.9, 40)
    t = np.linspace(20 * period, 40 * period, 400_001)
    y, v = run.displacement((1, -1), t)
    assert 0.0 <= float(found.max_displacement) - y.max() < 1e-6
    assert 0.0 <= y.min() - float(found.min_displacement) < 1e-6
    assert float(found.peak_displacement) == max(
        float(found.max_displacement), -float(found.min_displacement)
    )
    late = (run.impacts.t >= 20 * period) & (run.impacts.t <= 40 * period)
    speeds = np.abs(run.impacts.v_before[late])
    count, share, force = late.sum(), np.zeros(len(t)), 0.0
    if structure is MIXED:
        entries = (run.crossings.direction == "in") & (run.crossings.t >= 20 * period)
        entries &= run.crossings.t <= 40 * period
        speeds = np.concatenate([speeds, np.abs(run.crossings.v[entries])])
        count = count + entries.sum()
        depth = np.maximum(-0.1 - y, 0.0)
        share = depth > 0.0
        force = np.abs(40.0 * depth - 0.4 * v)[share].max()
        # The wall holds the first mass: its force is what the others leave of 0.
        for start, release in zip(run.contacts.start, run.contacts.release, strict=True):
            share = share | ((t >= start) & ~(t > release))
        x, w = run(t)
        # With x0'' = 0 the second equation gives x1'', and the first the wall's force.
        soft = np.where(depth > 0.0, 40.0 * depth - 0.4 * v, 0.0)
        on_first, on_second = soft, -soft
        pull_second = on_second - (-x[:, 0] + x[:, 1]) - (0.03 * w[:, 0] + 0.1 * w[:, 1])
        drive = 0.3 + 1.4 * np.cos(0.9 * t)
        pull_first = on_first + drive - (3 * x[:, 0] - x[:, 1]) - (0.2 * w[:, 0] - 0.02 * w[:, 1])
        held = pull_first - 0.1 / 0.5 * pull_second
        for start, release in zip(run.contacts.start, run.contacts.release, strict=True):
            inside = (t > start) & ~(t > release)
            force = max(force, held[inside].max(initial=0.0))
    assert float(found.impacts_per_period) == count / 20
    assert float(found.peak_impact_velocity) == speeds.max()
    assert float(found.contact_share) == pytest.approx(np.mean(share), abs=1e-4)
    assert float(found.peak_stop_force) == pytest.approx(force, rel=1e-3, abs=1e-12)
    assert float(found.peak_stop_force) >= force * (1.0 - 1e-12)


def test_one_coordinate_has_the_measures_of_the_oscillator() -> None:
    force = pc.cosine("2.5", amplitude="0.9")
    osc = pc.Oscillator.from_mass(
        2, 3, damping_coefficient="0.2",
        stops=(pc.SoftStop("0.2", "above", 30, "0.6"), pc.Wall("-0.9", "below", "0.7")),
    )  # fmt: skip
    structure = pc.Structure(mass=2, stiffness=3, damping="0.2", stops=osc.stops)
    names = [
        "max_displacement", "min_displacement", "peak_displacement", "peak_stop_force",
        "contact_share", "peak_impact_velocity", "impacts_per_period", "period",
        "largest_lyapunov_exponent", "rms_displacement", "peak_acceleration", "mean_power",
    ]  # fmt: skip
    values = [2.4, 2.5]

    ours = pc.sweep(
        names, structure, pc.Loads({0: force}), over={OMEGA: values}, transient=100, periods=64
    )
    known = pc.sweep(names, osc, force, over={"forcing.omega": values}, transient=100, periods=64)

    for name in names:
        np.testing.assert_allclose(ours[name], known[name].values, rtol=1e-6, atol=1e-9)
        assert ours[name].attrs == known[name].attrs


@pytest.mark.parametrize(("structure", "loads"), CASES, ids=NAMES)
def test_means_are_those_of_densely_sampled_runs(structure: pc.Structure, loads: pc.Loads) -> None:
    names = ["rms_displacement", "mean_power", "peak_acceleration"]

    found = pc.sweep(
        names, structure, loads, over={OMEGA: [0.9]}, on=(1, -1), transient=20, periods=20
    ).isel({OMEGA: 0})

    run, period = followed(structure, 0.9, 40)
    # Middles of intervals: no sample is an instant of the span's ends.
    t = 20 * period + 20 * period * (np.arange(400_000) + 0.5) / 400_000
    y, _ = run.displacement((1, -1), t)
    _, v = run(t)
    force = run.forces(t[::100])
    assert float(found.rms_displacement) == pytest.approx(np.sqrt(np.mean(y * y)), rel=1e-6)
    push = 0.3 * np.cos(0.9 * t) if structure is ABSORBER else 0.3 + 1.4 * np.cos(0.9 * t)
    assert float(found.mean_power) == pytest.approx(np.mean(push * v[:, 0]), rel=1e-3)
    # M x'' is the sum of all forces.
    total = force.spring.values + force.damping.values + force.loads.values
    total = total + force.stops.values.T @ structure.stop_directions
    acceleration = np.linalg.solve(structure.mass_matrix, total.T)
    sampled = np.abs(acceleration[0] - acceleration[1]).max()
    assert sampled <= float(found.peak_acceleration) * (1.0 + 1e-12)
    assert float(found.peak_acceleration) == pytest.approx(sampled, rel=0.1)


@pytest.mark.parametrize(("structure", "loads"), CASES, ids=NAMES)
@pytest.mark.parametrize("direction", ["up", "both"])
def test_passages_of_a_place_are_those_of_plain_runs(
    structure: pc.Structure, loads: pc.Loads, direction: Any
) -> None:
    diagram = pc.bifurcation_diagram(
        structure, loads, over={OMEGA: [0.8, 0.9]}, on=(1, -1), follow=(), transient=20, points=30,
        section={"at": "0.1", "direction": direction},
    )  # fmt: skip

    for i, omega in enumerate([0.8, 0.9]):
        run, period = followed(structure, omega, 49)
        section = run.section(at=0.1, direction=direction, on=(1, -1))
        t, v = section.t.values, (section.v.values * [1.0, -1.0]).sum(axis=1)
        kept = (t >= 20 * period) & (t <= 49 * period)
        t, v = t[kept][-30:], v[kept][-30:]
        ours = diagram.isel({"branch": 0, OMEGA: i})
        filled = np.isfinite(ours.v.values)
        assert filled.sum() == len(t)
        assert len(t) > 5
        assert ours.cycle.values[filled] == pytest.approx(t / period % 1.0, abs=1e-12)
        assert np.abs(ours.v.values[filled] - v).max() < 1e-9


def test_one_coordinate_passes_a_place_as_the_oscillator_does() -> None:
    osc = pc.impact_oscillator("0.8", wall="0.2", side="above", damping="0.05")
    structure = pc.Structure(1, 1, "0.1", stops=osc.stops)
    keywords: dict[str, Any] = {"section": {"at": "-0.3"}, "transient": 50, "points": 40}

    ours = pc.bifurcation_diagram(structure, pc.cosine(2), over={OMEGA: [1.8, 2.0]}, **keywords)
    known = pc.bifurcation_diagram(
        osc, pc.cosine(2), over={"forcing.omega": [1.8, 2.0]}, **keywords
    )

    for name in ("cycle", "v", "period"):
        np.testing.assert_allclose(ours[name].values, known[name].values, atol=1e-9)


@pytest.mark.parametrize("section", ["stroboscopic", "impacts"])
def test_bits_do_not_depend_on_threads_or_company(section: Any) -> None:
    on = 1 if section == "stroboscopic" else None
    over = {"structure.stops.0.at": np.linspace(0.3, 0.6, 25)}
    keywords: dict[str, Any] = {"section": section, "on": on, "transient": 20, "points": 20}

    one = pc.bifurcation_diagram(MIXED, PUSHED, over=over, n_workers=1, **keywords)
    two = pc.bifurcation_diagram(MIXED, PUSHED, over=over, n_workers=2, **keywords)

    assert one.identical(two)
    (path,) = over
    alone = pc.bifurcation_diagram(
        MIXED, PUSHED, over={path: over[path][7:8]}, follow=(), **keywords
    )
    for name in ("x", "v") if section == "stroboscopic" else ("cycle", "v_after"):
        ours = one[name].sel(branch="start 0").values[7]
        assert ours.tobytes() == alone[name].values[0, 0].tobytes()


def test_processes_give_the_bits_of_threads() -> None:
    grid = {OMEGA: [0.85, 0.95], "structure.stops.1.restitution": [0.5, 0.7]}
    names = ["max_displacement", "largest_lyapunov_exponent"]
    found = [
        pc.sweep(names, ABSORBER, LOADS, over=grid, on=1, transient=10, periods=64, engine=engine)
        for engine in ("threads", "processes")
    ]

    assert found[0].identical(found[1])


@pytest.mark.parametrize("rows", [1, 7, 33])
def test_measures_do_not_depend_on_how_many_events_are_kept_at_once(
    rows: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A stack of three masses: nine impacts of one instant, while a wall holds the lowest."""
    walls = [
        pc.Wall(at=0, side="below", restitution="0.5", on=on)
        for on in ((1, 0, 0), (-1, 1, 0), (0, -1, 1))
    ]
    stack = pc.Structure([1, 1, 1], [0, 0, 1], stops=walls)
    weight = pc.Forcing(constant=-1)
    loads = pc.Loads({0: weight + pc.cosine(1, amplitude="0.1"), 1: weight, 2: weight})
    measures = ["max_displacement", "peak_impact_velocity", "impacts_per_period"]

    def measured() -> Any:
        heights = {"start.x0.2": [0.5, 0.6]}
        return pc.sweep(measures, stack, loads, over=heights, on=0, transient=0, periods=2)

    known = measured()
    monkeypatch.setattr(structure_batch, "BUFFER", rows)

    assert known.impacts_per_period.values.min() > 100
    assert measured().identical(known)


def test_many_starts_of_one_structure_meet_new_sets_and_go_on() -> None:
    """One call of the kernel follows all starts: some wait for a set that others have met."""
    grid = {"start.x0.1": np.linspace(-2, 2, 21), "start.v0.0": [-1.0, 1.0]}

    found = pc.sweep(
        "max_displacement", MIXED, PUSHED, over=grid, on=0, transient=0, periods=3
    ).max_displacement

    for i in (0, 5, 20):
        for k, v0 in enumerate((-1.0, 1.0)):
            x1 = float(grid["start.x0.1"][i])  # type: ignore[index]
            run, period = followed(MIXED, 0.9, 3, x0=[0, x1], v0=[v0, 0])
            y, _ = run.displacement(0, np.linspace(0, 3 * period, 100_001))
            assert 0.0 <= float(found[i, k]) - y.max() < 1e-6


def test_starts_behind_walls_have_no_motion_and_say_why() -> None:
    with pytest.warns(UserWarning, match="1 of 3 points have no answer"):
        data = pc.sweep(
            "max_displacement", MIXED, PUSHED, over={"start.x0.0": [0.0, 0.35, 0.36]}, on=0,
            transient=0, periods=2,
        )  # fmt: skip

    assert data.point.values.tolist() == [2]
    assert "above the wall stops.0" in str(data.reason.values[0])
    assert np.isfinite(data.max_displacement.values[:2]).all()


def test_a_followed_branch_goes_on_where_a_wall_moves_past_it() -> None:
    gap = [0.5, 0.3, 0.1, -0.2]

    with pytest.warns(UserWarning, match="2 of 8 values have no answer"):
        found = pc.bifurcation_diagram(
            MIXED, PUSHED, over={"structure.stops.0.at": gap}, on=0,
            starts=[([0.2, 0], [0, 0])], transient=5, points=5, follow=["forward"],
        ).sel(branch="forward")  # fmt: skip

    assert (found.reason == "").all()
    assert (found.x.max("sample").values <= np.array(gap) + 1e-12).all()


def test_linear_motions_have_the_exponents_of_their_modes() -> None:
    """Without stops the largest exponent is less the least damping rate; without losses 0."""
    damped = pc.Structure(mass=[1, 1], stiffness=[1, 4], damping=["0.1", "0.3"])
    free = pc.Structure(mass=[1, 1], stiffness=[[2, -1], [-1, 2]])
    loads = pc.Loads({0: pc.cosine("0.77")})

    ours = pc.sweep("largest_lyapunov_exponent", damped, loads, over={}, periods=200)
    none = pc.sweep("largest_lyapunov_exponent", free, loads, over={}, periods=4000)

    assert float(ours.largest_lyapunov_exponent) == pytest.approx(-0.05, abs=1e-3)
    assert abs(float(none.largest_lyapunov_exponent)) < 1e-4


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: pc.sweep("max_displacement", ABSORBER, LOADS, over={}),
         "on = None: not said on what it acts; the coordinates are 0 to 1"),
        (lambda: pc.sweep("max_displacement", ABSORBER, LOADS, over={}, on=2),
         "no such coordinate; the coordinates are 0 to 1"),
        (lambda: pc.sweep("dissipated_energy", ABSORBER, LOADS, over={}, on=0),
         "measure = 'dissipated_energy': not for structures; there are peak_displacement"),
        (lambda: pc.sweep("rms_displacement", ABSORBER, LOADS, over={}),
         "on = None: not said on what it acts; the coordinates"),
        (lambda: pc.sweep("period", ABSORBER, over={}),
         "section = 'stroboscopic'"),
        (lambda: pc.sweep(
            "period", ABSORBER, pc.Loads({0: pc.cosine(1), 1: pc.cosine("1.3")}), over={}),
         "loads.period = None: time is counted in forcing periods, and this forcing has none"),
        (lambda: pc.sweep("period", ABSORBER, LOADS, over={"forcing.omega": [1.0]}),
         "no such parameter; did you mean loads.0.omega"),
        (lambda: pc.sweep("period", ABSORBER, LOADS, over={}, start=([0.0], [0.0])),
         "1 number for 2 coordinates"),
        (lambda: pc.sweep("period", ABSORBER, LOADS, over={}, start=5),  # type: ignore[arg-type]
         "start = 5: neither a StructureStart nor (x0, v0) nor (x0, v0, t0)"),
        (lambda: pc.sweep("period", pc.impact_oscillator(), pc.cosine(2), over={}, on=0),
         "on = 0: given for an oscillator, which has one displacement"),
        (lambda: pc.bifurcation_diagram(ABSORBER, LOADS, over={OMEGA: (1, 2)}),
         "on = None: not said on what it acts"),
        (lambda: pc.bifurcation_diagram(
            ABSORBER, LOADS, over={OMEGA: (1, 2)}, section="impacts", on=2),
         "on = 2: at impacts not the number of a stop; the stops are 0 to 1"),
        (lambda: pc.bifurcation_diagram(
            ABSORBER, LOADS, over={OMEGA: (1, 2)}, section={"at": 0.1}),
         "on = None: not said on what"),
        (lambda: pc.bifurcation_diagram(ABSORBER, None, over={"structure.mass.0.0": (1, 2)}, on=0),
         "section = 'stroboscopic': "),
    ],
)  # fmt: skip
def test_wrong_calls_are_told_in_a_sentence(call: Any, sentence: str) -> None:
    with pytest.raises(pc.ParameterError, match=re.escape(sentence)):
        call()


def test_exponents_of_one_coordinate_are_those_of_the_oscillator() -> None:
    force = pc.cosine("2.5", amplitude="0.9")
    stops = (pc.SoftStop("0.2", "above", 30, "0.6"), pc.Wall("-0.9", "below", "0.7"))
    osc = pc.Oscillator.from_mass(2, 3, damping_coefficient="0.2", stops=stops)
    structure = pc.Structure(mass=2, stiffness=3, damping="0.2", stops=stops)

    for omega in (2.4, 1.5):
        force = pc.cosine(omega, amplitude="0.9")
        ours = pc.lyapunov_exponents(structure, pc.Loads({0: force}), transient=200, periods=640)
        known = pc.lyapunov_exponents(osc, force, transient=200, periods=640)
        scatter = 6.0 * (known.errors.max() + ours.errors.max()) + 1e-9
        np.testing.assert_allclose(ours.exponents, known.exponents, rtol=0, atol=scatter)
        np.testing.assert_allclose(ours.total, known.total, rtol=1e-2)


@pytest.mark.parametrize("omega", [0.7, 0.8, 1.2, 1.3])
def test_exponents_add_up_to_the_mean_rate_at_which_volumes_shrink(omega: float) -> None:
    """Less the trace of M^-1 C, and two ln r for each impact."""
    loads = pc.Loads({0: pc.cosine(omega, amplitude="0.6")})

    exponents = pc.lyapunov_exponents(ABSORBER, loads, transient=100, periods=640)

    by_rule = -0.05 + 2.0 * np.log(0.65) * exponents.impact_rate
    assert exponents.total == pytest.approx(by_rule, abs=1e-12)
    assert exponents.exponents.sum() == pytest.approx(
        exponents.total, abs=1e-2 * abs(exponents.total)
    )
    assert (np.diff(exponents.exponents) <= 0.0).all()


def test_exponents_of_an_orbit_are_those_of_its_multipliers() -> None:
    loads = pc.Loads({0: pc.cosine("1.2", amplitude="0.3")})
    run, period = followed(ABSORBER, 1.2, 400)
    x, v = run(400 * period)
    orbit = pc.find_orbit(ABSORBER, loads, guess=(x.tolist(), v.tolist()))

    exponents = pc.lyapunov_exponents(ABSORBER, loads, transient=400, periods=64)

    sizes = np.sort(np.log(np.abs(orbit.multipliers)) / orbit.period)[::-1]
    np.testing.assert_allclose(exponents.exponents, sizes, atol=1e-8)


def test_an_integrable_structure_has_exponents_of_zero() -> None:
    """Elastic walls between two equal masses swap their velocities: as if there were none."""
    pair = pc.impact_pair([1, 1], gap="0.3", restitution=1, springs=[1, 0, 1])

    exponents = pc.lyapunov_exponents(pair, None, start=([0, 0], [0, 1]), transient=0, periods=4096)

    assert exponents.total == 0.0
    assert np.abs(exponents.exponents).max() < 2e-3


def test_areas_shrink_over_chatters_as_the_multipliers_say(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """What is carried along the motion, without the orbit that would be found at its end.

    Over whole periods the plane that the wall leaves comes back to itself: the sum of two exponents
    has no scatter.
    """
    orbit = pc.find_orbit(MIXED, PUSHED)
    assert len(orbit.run.contacts) == 1
    (a, b) = np.abs(orbit.multipliers[:2])
    monkeypatch.setattr(lyapunov, "_of_structure_orbit", lambda *_: None)

    start = (orbit.x0.tolist(), orbit.v0.tolist())
    exponents = pc.lyapunov_exponents(MIXED, PUSHED, start=start, transient=4, periods=64)

    assert exponents.exponents[:2].sum() == pytest.approx(np.log(a * b) / orbit.period, abs=2e-13)


def test_a_wall_that_holds_takes_two_exponents() -> None:
    exponents = pc.lyapunov_exponents(MIXED, PUSHED, transient=100, periods=64)

    assert np.isneginf(exponents.exponents[2:]).all()
    assert np.isfinite(exponents.exponents[:2]).all()
    assert exponents.total == -np.inf


TWO = pc.Structure(
    mass=[1, 2], stiffness=[[1, 0], [0, 3]], damping=["0.1", "0.2"],
    stops=[pc.Wall(at="1.45789", side="above", restitution="0.7", on=0)],
)  # fmt: skip
DRIVEN = pc.Loads({0: pc.cosine("1.5"), 1: pc.cosine("1.5", amplitude="0.3")})


def test_basins_of_a_part_that_moves_alone_are_those_of_the_oscillator() -> None:
    """The first mass is the oscillator of the second attractor; the second mass only follows."""
    osc = pc.impact_oscillator(restitution="0.7", wall="1.45789", side="above", damping="0.05")
    x0, v0 = np.linspace(-3.4, 1.4, 9), np.linspace(-2, 2, 5)
    known = pc.basins(osc, pc.cosine("1.5"), x0=x0, v0=v0)

    basins = pc.basins(
        TWO, DRIVEN, over={"start.x0.0": x0, "start.v0.0": v0}, start=([0, "0.1"], [0, 0]), on=0,
        measures=["max_displacement"],
    )  # fmt: skip

    assert basins.basin.values.tolist() == known.basin.values.tolist()
    assert basins.name.values.tolist() == known.name.values.tolist()
    assert len(np.unique(basins.basin)) == 2
    np.testing.assert_allclose(basins.x.values[:, 0], known.x.values, atol=1e-8)
    np.testing.assert_allclose(basins.v_strobe.values[:, 0], known.v_strobe.values, atol=1e-8)
    # The second mass settles at its own rate, 0.05 as well.
    np.testing.assert_allclose(basins.exponent, np.maximum(known.exponent, -0.05), atol=1e-8)
    assert (basins.residual < 1e-11).all()
    np.testing.assert_allclose(basins["attractor_x0.0"].values[:, 0], basins.x.values[:, 0])
    measured = pc.basins(osc, pc.cosine("1.5"), x0=x0, v0=v0, measures=["max_displacement"])
    np.testing.assert_allclose(basins.max_displacement, measured.max_displacement, atol=1e-8)


def test_basins_over_directions_are_those_of_the_starts_there() -> None:
    along = (1, 0, "0.5", 0)
    a = [-2.0, -1.0, 0.5]

    basins = pc.basins(
        TWO, DRIVEN, over={along: a, "start.v0.1": [0.0, 1.0]}, start=([0, 0], ["0.2", 0])
    )

    for i, value in enumerate(a):
        one = pc.basins(
            TWO, DRIVEN, over={"start.x0.0": [value], "start.v0.1": [0.0, 1.0]},
            start=([0, 0], [0.2 + 0.5 * value, 0]),
        )  # fmt: skip
        names = [one.name.values[k] for k in one.basin.values[0]]
        assert [basins.name.values[k] for k in basins.basin.values[i]] == names


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: pc.basins(TWO, DRIVEN, x0=(-1, 1), v0=(-1, 1)),
         "x0 = (-1, 1): given for a structure; give over="),
        (lambda: pc.basins(TWO, DRIVEN, over={"start.x0.0": (-1, 1)}),
         "not two axes"),
        (lambda: pc.basins(TWO, DRIVEN, over={"start.x0.0": (-1, 1), OMEGA: (1, 2)}),
         "no displacement or velocity of the start"),
        (lambda: pc.basins(TWO, DRIVEN, over={"start.x0.0": (-1, 1), (1, 1): (1, 2)}),
         "2 numbers; a direction of starts has 4, of x0 and v0"),
        (lambda: pc.basins(TWO, DRIVEN, over={"start.x0.0": (-1, 1), (0, 0, 0, 0): (1, 2)}),
         "a direction of zeros"),
        (lambda: pc.basins(TWO, None, over={"start.x0.0": (-1, 1), "start.v0.0": (-1, 1)}),
         "loads.period = None: basins need a periodic forcing"),
        (lambda: pc.basins(pc.impact_oscillator(), pc.cosine(2), over={"start.x0": (0, 1)}),
         "given for an oscillator"),
    ],
)  # fmt: skip
def test_wrong_planes_of_starts_are_told_in_a_sentence(call: Any, sentence: str) -> None:
    with pytest.raises(pc.ParameterError, match=re.escape(sentence)):
        call()


def test_basin_fractions_of_a_part_that_moves_alone_are_those_of_the_oscillator() -> None:
    osc = pc.impact_oscillator("0.7", wall="1", side="above", damping="0.05")
    # A second mass that nothing couples and nothing drives rests.
    structure = pc.Structure(
        [1, 1], [1, 1], ["0.1", "0.1"], stops=[pc.Wall("1", "above", "0.7", on=0)]
    )
    gaps = [0.7, 1.2]
    names = ["max_displacement"]

    ours = pc.basin_fractions(
        structure, pc.Loads({0: pc.cosine("1.5")}), over={"structure.stops.0.at": gaps}, on=0,
        x0=[(-4, 0.7), 0], v0=[(-4, 4), 0], n_starts=40, measures=names,
    )  # fmt: skip
    known = pc.basin_fractions(
        osc, pc.cosine("1.5"), over={"oscillator.stops.0.at": gaps}, x0=(-4, 0.7), v0=(-4, 4),
        n_starts=40, measures=names,
    )  # fmt: skip

    assert ours.name.values.tolist() == known.name.values.tolist()
    np.testing.assert_array_equal(ours.exists.values, known.exists.values)
    # Other numbers are drawn, of four in place of two: they agree within their errors.
    error = np.hypot(ours.fraction_error.values, known.fraction_error.values)
    assert (np.abs(ours.fraction.values - known.fraction.values) <= 4.0 * error + 1e-12).all()
    assert float(abs(ours.x.sel(coordinate=1)).max()) < 1e-9
    np.testing.assert_allclose(
        ours.max_displacement.values, known.max_displacement.values, rtol=1e-9
    )


@pytest.mark.parametrize(
    ("keywords", "sentence"),
    [
        ({"x0": (-1, 1, 0)}, "not 2 ranges or values, one for each coordinate"),
        ({"v0": [(1, -1), 0], "x0": [0, 0]}, "v0.0 = (1, -1): not a range from a low"),
        ({"measures": ["max_displacement"]}, "on = None: not said on what it acts"),
    ],
)  # fmt: skip
def test_ranges_of_starts_that_do_not_fit_are_told(keywords: dict[str, Any], sentence: str) -> None:
    structure = pc.Structure([1, 1], [1, 1], stops=[pc.Wall(1, "above", "0.7", on=0)])

    with pytest.raises(pc.ParameterError, match=re.escape(sentence)):
        pc.basin_fractions(
            structure, pc.Loads({0: pc.cosine(1)}), over={"structure.stops.0.at": [1, 2]},
            **keywords,
        )  # fmt: skip


def test_all_branches_of_a_diagram_share_the_systems_of_its_values(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    made: list[object] = []

    def system(structure: pc.Structure, loads: pc.Loads) -> StructureSystem:
        made.append(loads)
        return StructureSystem(structure, loads)

    monkeypatch.setattr("percuss.ensembles.grid._made_of", system)
    pair = pc.impact_pair([1, 1], gap=1, restitution="0.7", springs="0.5", dashpots="0.05")
    loads = pc.Loads({0: pc.cosine(1, amplitude="0.8")})
    over = {"loads.0.omega": np.linspace(0.8, 1.2, 7)}

    data = pc.bifurcation_diagram(pair, loads, over=over, on=0, points=8, n_workers=1)
    alone = pc.bifurcation_diagram(pair, loads, over=over, on=0, points=8, follow=(), n_workers=1)

    assert len(made) == 7 + 7
    assert np.array_equal(data.x.sel(branch="start 0"), alone.x.sel(branch="start 0"))


def test_a_wall_never_pulls_where_the_jump_of_a_load_ends_a_contact() -> None:
    """The force after the jump was the wall's until it let go, which it does at once."""
    structure = pc.Structure([1], [1], ["0.1"], [pc.Wall("0.1", "above", 0)])
    loads = pc.Loads({0: pc.square_wave("0.9")})
    run = pc.simulate(structure, loads, t_end=30)
    assert len(run.contacts) > 3
    peak = run.extremes("stop_force").peak
    assert peak == pytest.approx(0.9, rel=1e-14)
    data = pc.sweep("peak_stop_force", structure, loads, over={}, between=(0, 30))
    assert float(data.peak_stop_force) == pytest.approx(peak, rel=1e-14)


@pytest.mark.parametrize(("k", "damping"), [(0.0, 0.2775), (0.01, 0.01), (0.0, 0.0)])
def test_turns_of_slow_motions_under_a_wave_are_those_of_the_closed_form(
    k: float, damping: float
) -> None:
    """They turn twice between two nodes of a structure, or far from the secant of an oscillator."""
    force = pc.triangle_wave(3.56)
    osc = pc.Oscillator(stiffness=k, damping=damping)
    one = pc.Structure(mass=[1], stiffness=[k], damping=[2 * damping])
    names = ["max_displacement", "min_displacement"]
    starts = [-0.5, -0.29, -0.27, -0.005, 0.105, 0.185]
    runs = [pc.simulate(osc, force, v0=v0, periods=2) for v0 in starts]
    found = [run.extremes("displacement") for run in runs]
    known = np.array([(each.minimum, each.maximum) for each in found])

    ours = pc.sweep(names, osc, force, over={"start.v0": starts}, transient=0, periods=2)
    theirs = pc.sweep(
        names, one, pc.Loads({0: force}), over={"start.v0.0": starts}, transient=0, periods=2
    )

    for swept in (ours, theirs):
        np.testing.assert_allclose(swept.min_displacement, known[:, 0], rtol=0, atol=1e-14)
        np.testing.assert_allclose(swept.max_displacement, known[:, 1], rtol=0, atol=1e-14)
