from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import percuss as pc
from percuss.ensembles.attractors import Chaos, StrobedSystem, same_chaos

TWO = pc.impact_oscillator(restitution=0.7, wall="1.45789", side="above", damping=0.05)
FORCE = pc.cosine(1.5)


@pytest.mark.parametrize("boundary", [-3.366271675, 0.375914774])
def test_the_boundary_on_a_line_is_where_the_reference_has_it(boundary: float) -> None:
    """Case basin-boundary-line: on v0 = 0, to 1e-7."""
    basins = pc.basins(TWO, FORCE, x0=[boundary - 1e-7, boundary + 1e-7], v0=[0.0])

    assert sorted(basins.basin.values[:, 0].tolist()) == [0, 1]
    assert basins.kind.values.tolist() == ["periodic", "periodic"]
    assert sorted(basins.n_impacts.values.tolist()) == [0.0, 1.0]
    assert basins.n_periods.values.tolist() == [1, 1]


def test_the_motion_without_impacts_is_the_steady_response() -> None:
    basins = pc.basins(TWO, FORCE, x0=[0.0, 0.1], v0=[0.0, 0.2])

    gain = 1.0 / complex(1.0 - 1.5**2, 2 * 0.05 * 1.5)
    (free,) = np.flatnonzero(basins.n_impacts.values == 0.0)
    # To the rounding of the strobe's instant: at t = 2300 a float is good to 5e-13.
    np.testing.assert_allclose(basins.x[free], gain.real, rtol=0, atol=2e-12)
    np.testing.assert_allclose(basins.v_strobe[free], -1.5 * gain.imag, rtol=0, atol=2e-12)


def test_attractors_are_refined_to_full_accuracy_and_named() -> None:
    """Case hyst-upper-a0.05-r0.7-w1.5: impact speed and time in closed form, and the multipliers.

    With a damping of 1e-3 a motion comes nearer by 0.4 % a period: alone it would give six digits.
    """
    basins = pc.basins(TWO, FORCE, cycle=[0.1, 0.6], v=[0.1, 2.6])
    strikes = int(np.flatnonzero(basins.name.values == "(1, 1)")[0])

    period = float(FORCE.period or 0.0)
    cycle, v = (float(basins[name][strikes, 0]) for name in ("attractor_cycle", "attractor_v"))
    assert cycle * period == pytest.approx(0.68131386001706276354, abs=1e-12)
    assert v == pytest.approx(0.7 * 3.715736427838396744, abs=1e-12)
    modulus = np.hypot(0.43659025896978035511, 0.36290906918183299344)
    assert float(basins.exponent[strikes]) == pytest.approx(np.log(modulus) / period, abs=1e-12)

    slow = pc.basins(pc.Oscillator(1.0, 1e-3), FORCE, x0=[0.3], v0=[0.1], periods=4000)
    gain = 1.0 / complex(1.0 - 1.5**2, 2e-3 * 1.5)
    np.testing.assert_allclose(slow.x[0], gain.real, rtol=0, atol=1e-14)
    assert float(slow.residual[0]) < 1e-14


def test_sticking_and_long_orbits_have_their_names() -> None:
    """At 2.74 a motion repeats itself after 18 periods only."""
    osc, x0, v0 = pc.impact_oscillator(0.8), np.linspace(0.0, 3.0, 5), np.linspace(-3.0, 3.0, 5)

    sticking = pc.basins(osc, pc.cosine(2.7), x0=x0, v0=v0)
    long = pc.basins(osc, pc.cosine(2.74), x0=x0, v0=v0)

    assert "(inf, 6)" in sticking.name.values
    assert np.isneginf(sticking.exponent[sticking.name.values == "(inf, 6)"])
    assert long.n_periods.values.max() > 16
    assert np.isfinite(long.residual.values[long.n_periods.values > 16]).all()


def test_fractions_add_up_and_have_errors() -> None:
    basins = pc.basins(
        TWO, FORCE, x0=np.linspace(-4.0, 1.5, 30), v0=np.linspace(-4.0, 4.0, 25), periods=400
    )

    inside = basins.basin.values == -2
    # 1.5 lies beyond the wall.
    assert inside[-1].all()
    assert not inside[:-1].any()
    assert float(basins.fraction.sum()) + basins.attrs["undecided"] == pytest.approx(1.0)
    p, n = basins.fraction.values, 29 * 25
    np.testing.assert_allclose(basins.fraction_error, np.sqrt(p * (1 - p) / n))
    assert len(basins.attractor) == 2


def test_the_same_numbers_for_any_number_of_workers() -> None:
    x0, v0 = np.linspace(-4.0, 1.4, 60), np.linspace(-4.0, 4.0, 40)

    one, two = (pc.basins(TWO, FORCE, x0=x0, v0=v0, n_workers=n) for n in (1, 2))

    assert one.identical(two)


def test_chaos_is_distinguished_from_order() -> None:
    osc, x0, v0 = pc.impact_oscillator(restitution=0.8), [0.0, 0.5], [1.0, -0.3]

    chaos = pc.basins(osc, pc.cosine(2.8), x0=x0, v0=v0)
    order = pc.basins(osc, pc.cosine(2.7), x0=x0, v0=v0)

    assert chaos.kind.values.tolist() == ["chaotic"]
    # Reference case lyap-chaos-w2.8-s0.0.
    assert chaos.exponent.values[0] == pytest.approx(
        0.14192, abs=4 * chaos.exponent_error.values[0]
    )
    assert (chaos.basin.values == 0).all()
    assert set(order.kind.values) == {"periodic"}
    assert 2 in order.n_periods.values


def test_chaotic_motions_with_another_exponent_or_place_are_on_another_attractor() -> None:
    system = StrobedSystem.of(pc.impact_oscillator(restitution=0.8), pc.cosine(2.8), 0.0)
    chaos = Chaos.of(system, np.array([0.0, 1.0]))
    there = chaos.strobes[[7, 90]]
    arrays = {
        "strobe": np.concatenate([there, there + 2.0]),
        "exponent": np.full(4, chaos.exponent),
        "exponent_error": np.full(4, 0.01),
    }

    same = same_chaos(system, chaos, arrays, np.arange(4))
    other = same_chaos(system, replace(chaos, exponent=0.3, error=0.001), arrays, np.arange(2))

    assert chaos.persists
    # Those two units away come back to the same attractor, but not at once.
    assert same.tolist() == [True, True, False, False]
    assert other.tolist() == [False, False]


def test_where_every_start_has_its_own_motion_a_few_are_distinguished(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Without a spring a damped mass stays wherever it came to."""
    monkeypatch.setattr("percuss.ensembles.attractors.MOST_ORBITS", 4)
    free = pc.Oscillator(0.0, 0.1)

    basins = pc.basins(free, FORCE, x0=np.linspace(0.1, 1.0, 6), v0=[0.0])

    assert basins.basin.values[:, 0].tolist() == [0, 1, 2, 3, -1, -1]
    assert basins.name.values.tolist() == ["(0, 1)"] * 4
    assert np.isnan(basins.residual).all()


def test_rest_at_the_stop_is_a_class_of_its_own() -> None:
    held = pc.cosine(2.0, amplitude=0.5, constant=-1.0)

    basins = pc.basins(pc.impact_oscillator(0.3), held, x0=[0.0, 1.0], v0=[0.0, 2.0])

    assert basins.kind.values.tolist() == ["rest"]
    assert float(basins.x[0]) == 0.0


def test_growth_without_bound_is_one_and_what_is_slow_is_not_decided() -> None:
    """The main resonance grows by 4/3 in each half period; the spring that pushes exponentially."""
    slow = pc.basins(pc.impact_oscillator(), pc.sine(2), x0=[0.0], v0=[1.0], periods=40)
    falls = pc.Oscillator(-1.0, 0.0, (pc.Wall(0.0, "below"),))
    fast = pc.basins(falls, pc.sine(2), x0=[1.0], v0=[1.0])
    seen = pc.basins(pc.impact_oscillator(), pc.sine(2), x0=[0.0], v0=[1.0], escape=50.0)

    assert slow.basin.values.tolist() == [[-1]]
    assert slow.attrs["undecided"] == 1.0
    assert fast.kind.values.tolist() == ["unbounded"]
    assert seen.kind.values.tolist() == ["unbounded"]


def test_starts_at_the_wall_are_those_of_their_cycle_and_speed() -> None:
    cycles, speeds = np.array([0.0, 0.3, 0.62]), np.array([0.5, 3.5])
    period = float(FORCE.period or 0.0)

    basins = pc.basins(TWO, FORCE, cycle=cycles, v=speeds)

    assert basins.basin.dims == ("cycle", "v")
    for i, cycle in enumerate(cycles):
        for j, speed in enumerate(speeds):
            run = pc.simulate(
                TWO, FORCE, "1.45789", -speed, cycle * period, t_end=(cycle + 300) * period
            )
            strikes = bool((run.impacts.t > 290 * period).any())
            assert basins.n_impacts.values[basins.basin.values[i, j]] == float(strikes)


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({}, "either x0 and v0"),
        ({"x0": [0.0]}, "give x0 and v0"),
        ({"x0": [0.0], "v0": [0.0], "cycle": [0.0], "v": [0.0]}, "either"),
        ({"x0": [], "v0": [0.0]}, "without values"),
        ({"cycle": [1.0], "v": [0.0]}, r"outside \[0, 1\)"),
        ({"cycle": [0.5], "v": [-1.0]}, "negative"),
        ({"cycle": [0.5], "v": [1.0], "stop": 3}, "no wall"),
        ({"x0": [0.0], "v0": [0.0], "periods": 3}, "at least 40"),
        ({"x0": [0.0], "v0": [0.0], "escape": 0.0}, "above 0"),
    ],
)
def test_what_is_wrong_with_a_call_is_said(keywords: dict[str, object], message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.basins(TWO, FORCE, **keywords)  # type: ignore[arg-type]


def test_refining_many_attractors_asks_whether_to_go_on() -> None:
    # Without damping every start has an orbit of its own, or none.
    calls: list[tuple[float, float]] = []

    def report(done: float, total: float) -> bool:
        calls.append((done, total))
        return calls.count((total, total)) < 4

    basins = pc.basins(
        pc.impact_oscillator(), pc.sine(3), x0=np.linspace(0.0, 0.2, 8),
        v0=np.linspace(0.1, 0.6, 8), periods=50, progress=report,
    )  # fmt: skip

    assert calls[-1] == (64, 64)
    assert calls.count((64, 64)) == 4
    assert basins.attrs["complete"] == 0
    assert (basins.basin.values == -1).any()


def test_one_start_stands_for_both_axes() -> None:
    axes = {"x0": (-1.0, 0.2), "v0": [0.0, 0.5]}
    both = pc.basins(TWO, FORCE, **axes, t0=0.5)  # type: ignore[arg-type]

    for start in ((axes["x0"], axes["v0"], 0.5), [axes["x0"], axes["v0"], 0.5]):
        assert pc.basins(TWO, FORCE, start=start).equals(both)
    assert pc.basins(TWO, FORCE, start=(axes["x0"], axes["v0"]), t0=0.5).equals(both)
    one = pc.basins(TWO, FORCE, start=pc.Start("0.1", "1/3", 0.5))
    assert one.basin.shape == (1, 1)
    assert one.equals(pc.basins(TWO, FORCE, x0=["0.1"], v0=["1/3"], t0=0.5))
    assert one.equals(pc.basins(TWO, FORCE, start=("0.1", "1/3", 0.5)))


@pytest.mark.parametrize(
    ("keywords", "message"),
    [
        ({"start": ((0, 1), (0, 1)), "x0": [0.0]}, "given together with x0 or v0"),
        ({"start": (0.0,)}, r"not \(x0, v0\) or \(x0, v0, t0\)"),
        ({"start": "0.1"}, r"not \(x0, v0\)"),
        ({"start": {0.1: 1, 0.3: 2}}, r"not \(x0, v0\)"),
        ({"start": (0.0, 0.0, 1.0), "t0": 1.0}, "holds t0"),
        ({"start": (0.0, 0.0), "cycle": [0.5], "v": [1.0]}, "give either"),
        ({"start": (0.0, 0.0), "measures": ["peak_force"]}, "did you mean peak_stop_force"),
        ({"start": (0.0, 0.0), "measures": [abs]}, "one function at a time"),
    ],
)
def test_what_is_wrong_with_a_start_is_said(keywords: dict[str, object], message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.basins(TWO, FORCE, **keywords)  # type: ignore[arg-type]


def test_measures_of_attractors_are_those_of_their_orbits() -> None:
    """An orbit that strikes and one that does not, a rest, and what grows for ever."""
    names = ["peak_impact_velocity", "max_displacement", "period", "peak_stop_force"]
    osc = pc.impact_oscillator(restitution=0.7, wall="1.45789", side="above", damping=0.05)

    basins = pc.basins(osc, pc.cosine(1.5), start=([-3.4, 0.37], [0.0]), measures=names)

    assert sorted(basins.name.values) == ["(0, 1)", "(1, 1)"]
    for i, name in enumerate(basins.name.values):
        orbit = pc.find_orbit(osc, pc.cosine(1.5), n_impacts=int(name[1]))
        run = orbit.trajectory()
        fastest = np.abs(run.impacts.v_before).max(initial=0.0)
        assert basins.peak_impact_velocity.values[i] == pytest.approx(fastest, rel=1e-10)
        assert basins.max_displacement.values[i] == pytest.approx(
            run.extremes("displacement").maximum, rel=1e-10
        )
        assert basins.period.values[i] == 1.0
        assert basins.peak_stop_force.values[i] == 0.0
    assert basins.max_displacement.attrs["units"] == "length"

    resting = pc.basins(
        pc.impact_oscillator(restitution=0.5),
        pc.cosine(2, amplitude="0.5", constant=-1),
        start=(0.1, 0.0),
        measures=names,
    )
    assert resting.kind.values.tolist() == ["rest"]
    assert resting.peak_stop_force.values == pytest.approx([1.5], rel=1e-12)
    unbounded = pc.basins(
        pc.Oscillator(1), pc.cosine(1), start=(0.0, 0.0), escape=100.0, measures=names
    )
    assert unbounded.kind.values.tolist() == ["unbounded"]
    assert np.isnan([unbounded[name].item() for name in names]).all()
