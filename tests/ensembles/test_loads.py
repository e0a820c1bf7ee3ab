"""Peaks and means of sweeps: against 20 digits, the run's own extremes, and the energy's balance."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from tests.oracle.event_driven import simulate
from tests.oracle.extremes import extremes
from tests.oracle.from_model import problem_of
from tests.oracle.loads import integrals

import percuss as pc

EPS = 2.0**-52
LOADS = ["peak_stop_force", "peak_acceleration", "rms_displacement", "contact_share", "mean_power"]
PERIODS = 3
# Impacts multiply rounding by less than that in three periods of these motions.
AFTER_IMPACTS = 1e-11
FORCE = pc.Forcing((pc.Harmonic(1, "1.3"),), constant="-0.3")

# Every linear regime, and every way in which a stop bears a force.
CASES = {
    "undamped": (pc.Oscillator(2.0), FORCE, (0.5, 1.0)),
    "resonant": (pc.Oscillator("1.69"), FORCE, (0.0, 0.0)),
    "critical": (pc.Oscillator(4.0, 2.0), FORCE, (0.5, 1.0)),
    "overdamped": (pc.Oscillator(1.0, 3.0), FORCE, (0.5, 1.0)),
    "free": (pc.Oscillator(0.0), FORCE, (0.5, 1.0)),
    "dragged": (pc.Oscillator(0.0, 0.3), FORCE, (0.5, 1.0)),
    "growing": (pc.Oscillator(-0.5, 0.1), FORCE, (0.01, 0.0)),
    "self-excited": (pc.Oscillator(1.0, -0.05), FORCE, (0.1, 0.0)),
    "soft stop with a dashpot": (
        pc.Oscillator(1.0, 0.05, (pc.SoftStop(0.2, "above", 29.0, 3.0),)), FORCE, (0.0, 1.0),
    ),
    "gap of zero": (pc.backlash_oscillator(0.0, 25.0, 0.1, stop_damping=0.5), FORCE, (0.0, 1.0)),
    "two stops at one edge, one within the other": (
        pc.Oscillator(
            1.0,
            0.02,
            (
                pc.SoftStop(0.2, "above", 9.0, 0.1),
                pc.SoftStop(0.2, "above", 4.0),
                pc.SoftStop(0.6, "above", 100.0, 1.0),
            ),
        ),
        FORCE,
        (0.0, 1.0),
    ),
    "impacts": (pc.impact_oscillator(0.8, damping=0.01), pc.cosine("2.5"), (0.0, 1.0)),
    "chatter, sticking and release": (
        pc.impact_oscillator(0.4, wall=0.1, side="above", damping=0.05),
        pc.cosine("0.9", constant="0.4"),
        (0.0, 0.2),
    ),
    "landings that stay": (
        pc.impact_oscillator(0, stiffness=4, damping=2),
        pc.cosine("0.9149", amplitude="0.7", constant="-0.05"),
        (0.3, 0.0),
    ),
    "square wave and a soft stop": (
        pc.Oscillator(1.0, 0.05, (pc.SoftStop(0.2, "above", 29.0, 3.0),)),
        pc.square_wave("1.3"),
        (0.0, 1.0),
    ),
    "samples, sticking over knots and release": (
        pc.impact_oscillator(0.3, stiffness="0.5", damping=0.05),
        pc.record([0, "0.5", 1, 2, 4, "4.5", 6], [-1, -2, "-0.5", -1, 2, -3, -1], repeat=True),
        (0.1, 0.0),
    ),
    "start at rest on the wall, pressed": (
        pc.impact_oscillator(0.4, wall=0.1, side="above"),
        pc.cosine("0.9", constant="0.4"),
        (0.1, 0.0),
    ),
    "sticking under a record, over its knots": (
        pc.impact_oscillator(0.4, wall=0.1, side="above", damping=0.05),
        pc.triangle_wave("1.3") + pc.cosine("1.3", constant="0.2"),
        (0.0, 0.5),
    ),
    "a release where a record jumps": (
        pc.impact_oscillator(0.4, wall=0.1, side="above", damping=0.05),
        pc.square_wave("1.3"),
        (0.0, 0.5),
    ),
    "at rest for good": (
        pc.impact_oscillator(0.5), pc.cosine("1.3", amplitude="0.1", constant=-2), (0.3, 0.0),
    ),
    "soft stop in front of a wall that holds": (
        pc.Oscillator(
            1.0, 0.1, (pc.Wall(0.3, "above", 0.2), pc.SoftStop(0.1, "above", 5.0, 0.5))
        ),
        pc.cosine("0.7", amplitude=2, constant=3),
        (0.0, 0.0),
    ),
    "a graze of the soft stop": (
        # x = 1 - cos t, whose summits touch the edge at 2.
        pc.Oscillator(0.0, 0.0, (pc.SoftStop(2.0, "above", 30.0, 1.0),)),
        pc.cosine(1),
        (0.0, 0.0),
    ),
}  # fmt: skip


def measured(
    osc: pc.Oscillator, force: pc.Forcing, start: tuple[float, float], periods: int = PERIODS
) -> dict[str, float]:
    data = pc.sweep(LOADS, osc, force, over={}, start=start, transient=0, periods=periods)
    return {name: float(data[name]) for name in LOADS}


@pytest.mark.parametrize("periods", [2, pytest.param(PERIODS, marks=pytest.mark.nightly)])
@pytest.mark.parametrize("name", CASES)
def test_loads_are_those_of_the_oracle(name: str, periods: int) -> None:
    osc, force, start = CASES[name]
    loads, problem = measured(osc, force, start, periods), problem_of(osc, force)
    assert force.period is not None
    t_end = periods * force.period

    exact = simulate(problem, *start, t_end=t_end, digits=20)
    square, work, touch = integrals(problem, exact, t_end)
    least, _, most, _ = extremes(exact, (0, 0, 1), t_end)

    size = max(1.0, abs(float(least)), abs(float(most)))
    peak = max(abs(float(least)), abs(float(most)))
    assert loads["peak_acceleration"] == pytest.approx(peak, abs=AFTER_IMPACTS * size)
    mean = float(mpmath.sqrt(square / t_end))
    assert loads["rms_displacement"] == pytest.approx(mean, rel=AFTER_IMPACTS)
    assert loads["contact_share"] == pytest.approx(float(touch / t_end), abs=AFTER_IMPACTS)
    power = float(work / t_end)
    scale = max(1.0, mean)
    assert loads["mean_power"] == pytest.approx(power, abs=AFTER_IMPACTS * scale)


@pytest.mark.parametrize("name", CASES)
def test_peaks_are_the_extremes_of_the_run(name: str) -> None:
    osc, force, start = CASES[name]
    measures = measured(osc, force, start)
    run = pc.simulate(osc, force, *start, periods=PERIODS)
    if run.outcome is pc.Outcome.at_rest:
        run = pc.simulate(osc, force, *start, t_end=PERIODS * float(force.period or 0.0))

    peaks = [run.extremes("stop_force", i).peak for i in range(len(osc.stops))]

    assert measures["peak_stop_force"] == pytest.approx(max(peaks, default=0.0), rel=1e-13)
    wanted = run.extremes("acceleration").peak
    assert measures["peak_acceleration"] == pytest.approx(wanted, rel=1e-13)


def test_one_flight_is_measured_to_rounding() -> None:
    """x = sin t over three periods of 2 pi: the mean square is 1/2, the peak 1; no force, no work."""
    osc, force = pc.Oscillator(1.0), pc.cosine(1, amplitude=0)

    measures = measured(osc, force, (0.0, 1.0))

    assert measures["rms_displacement"] == pytest.approx(np.sqrt(0.5), abs=2 * EPS)
    assert measures["peak_acceleration"] == pytest.approx(1.0, abs=2 * EPS)
    assert measures["mean_power"] == 0.0
    assert measures["contact_share"] == 0.0
    assert measures["peak_stop_force"] == 0.0


def test_a_mass_that_stays_at_the_wall_is_held_by_the_largest_force() -> None:
    """x'' + x = -2 + cos 1.3 t / 10 at the wall at 0: it bears 2.1 at most, all the time."""
    osc, force = pc.impact_oscillator(0.5), pc.cosine("1.3", amplitude="0.1", constant=-2)

    measures = measured(osc, force, (0.0, 0.0))

    assert measures["peak_stop_force"] == pytest.approx(2.1, rel=2 * EPS)
    assert measures["contact_share"] == 1.0
    assert (measures["peak_acceleration"], measures["rms_displacement"]) == (0.0, 0.0)


def test_the_forcing_gives_what_impacts_and_dashpots_take() -> None:
    line = pc.SoftStop("0.5", "above", 400, 400)
    units = pc.Units("m", "s", "t")
    buoy = pc.Oscillator.from_mass(50, 20, 4, stops=(line,), units=units)
    waves = pc.cosine("0.7854", amplitude=40, constant=10)
    measures = ["mean_power", "dissipated_energy", "peak_stop_force"]

    data = pc.sweep(measures, buoy, waves, over={}, transient=400, periods=5)

    per_period = float(data.mean_power) * float(waves.period or 0.0)
    # Of the dissipated energy, which is summed with fewer nodes.
    assert per_period == pytest.approx(float(data.dissipated_energy), rel=1e-11)
    assert round(float(data.peak_stop_force), 2) == 883.04
    assert [data[name].attrs["units"] for name in measures] == ["kW", "kJ", "kN"]
    assert "per unit mass" not in data.mean_power.attrs["long_name"]


def test_loads_do_not_depend_on_what_else_is_measured_or_computed_together() -> None:
    osc = pc.impact_oscillator(0.4, wall=0.1, side="above", damping=0.05)
    over = {"forcing.omega": np.linspace(0.8, 2.6, 37)}
    force = pc.cosine("0.9", constant="0.1")

    alone = pc.sweep("peak_stop_force", osc, force, over=over, transient=20, periods=4)
    # A period takes strobes, an exponent a run of its own.
    others = [*LOADS, "period", "max_displacement", "largest_lyapunov_exponent"]
    together = pc.sweep(others, osc, force, over=over, transient=20, periods=4)
    single = pc.sweep(
        "peak_stop_force", osc, force, over={"forcing.omega": over["forcing.omega"][5:6]},
        transient=20, periods=4,
    )  # fmt: skip

    np.testing.assert_array_equal(alone.peak_stop_force, together.peak_stop_force)
    assert float(single.peak_stop_force[0]) == float(alone.peak_stop_force[5])
