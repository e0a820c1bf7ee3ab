from __future__ import annotations

import numpy as np
import pytest

import percuss as pc

TWO = pc.impact_oscillator(restitution=0.7, wall="1.45789", side="above", damping=0.05)
FORCE = pc.cosine(1.5)


@pytest.mark.parametrize("boundary", [-3.366271675, 0.375914774])
def test_the_boundary_on_a_line_is_where_the_reference_has_it(boundary: float) -> None:
    """Case basin-boundary-line: on v0 = 0, to 1e-7."""
    found = pc.basins(TWO, FORCE, x0=[boundary - 1e-7, boundary + 1e-7], v0=[0.0])

    assert sorted(found.basin.values[:, 0].tolist()) == [0, 1]
    assert found.kind.values.tolist() == ["periodic", "periodic"]
    assert sorted(found.n_impacts.values.tolist()) == [0.0, 1.0]
    assert found.n_periods.values.tolist() == [1, 1]


def test_the_motion_without_impacts_is_the_steady_response() -> None:
    found = pc.basins(TWO, FORCE, x0=[0.0, 0.1], v0=[0.0, 0.2])

    gain = 1.0 / complex(1.0 - 1.5**2, 2 * 0.05 * 1.5)
    (free,) = np.flatnonzero(found.n_impacts.values == 0.0)
    # To the rounding of the strobe's instant: at t = 2300 a float is good to 5e-13.
    np.testing.assert_allclose(found.x[free], gain.real, rtol=0, atol=2e-12)
    np.testing.assert_allclose(found.v_strobe[free], -1.5 * gain.imag, rtol=0, atol=2e-12)


def test_fractions_add_up_and_have_errors() -> None:
    found = pc.basins(
        TWO, FORCE, x0=np.linspace(-4.0, 1.5, 30), v0=np.linspace(-4.0, 4.0, 25), periods=400
    )

    inside = found.basin.values == -2
    # 1.5 lies beyond the wall.
    assert inside[-1].all()
    assert not inside[:-1].any()
    assert float(found.fraction.sum()) + found.attrs["undecided"] == pytest.approx(1.0)
    p, n = found.fraction.values, 29 * 25
    np.testing.assert_allclose(found.fraction_error, np.sqrt(p * (1 - p) / n))
    assert len(found.attractor) == 2


def test_the_same_numbers_for_any_number_of_workers() -> None:
    x0, v0 = np.linspace(-4.0, 1.4, 60), np.linspace(-4.0, 4.0, 40)

    one, two = (pc.basins(TWO, FORCE, x0=x0, v0=v0, n_workers=n) for n in (1, 2))

    assert one.identical(two)


def test_chaos_is_told_from_order() -> None:
    osc, x0, v0 = pc.impact_oscillator(restitution=0.8), [0.0, 0.5], [1.0, -0.3]

    chaos = pc.basins(osc, pc.cosine(2.8), x0=x0, v0=v0)
    order = pc.basins(osc, pc.cosine(2.7), x0=x0, v0=v0)

    assert chaos.kind.values.tolist() == ["chaotic"]
    assert (chaos.basin.values == 0).all()
    assert set(order.kind.values) == {"periodic"}
    assert 2 in order.n_periods.values


def test_rest_at_the_stop_is_a_class_of_its_own() -> None:
    held = pc.cosine(2.0, amplitude=0.5, constant=-1.0)

    found = pc.basins(pc.impact_oscillator(0.3), held, x0=[0.0, 1.0], v0=[0.0, 2.0])

    assert found.kind.values.tolist() == ["rest"]
    assert float(found.x[0]) == 0.0


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

    found = pc.basins(TWO, FORCE, cycle=cycles, v=speeds)

    assert found.basin.dims == ("cycle", "v")
    for i, cycle in enumerate(cycles):
        for j, speed in enumerate(speeds):
            run = pc.simulate(
                TWO, FORCE, "1.45789", -speed, cycle * period, t_end=(cycle + 300) * period
            )
            strikes = bool((run.impacts.t > 290 * period).any())
            assert found.n_impacts.values[found.basin.values[i, j]] == float(strikes)


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
    ],
)
def test_what_is_wrong_with_a_call_is_said(keywords: dict[str, object], message: str) -> None:
    with pytest.raises(pc.ParameterError, match=message):
        pc.basins(TWO, FORCE, **keywords)  # type: ignore[arg-type]
