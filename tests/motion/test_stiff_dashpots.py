"""Soft stops with dashpots far above critical: the fast decay is over soon and leaves no trace."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from mpmath import mp, mpf

import percuss as pc
from percuss.kernels import law_columns as at
from percuss.kernels import record as columns
from percuss.kernels.flight import uncertainty
from percuss.kernels.observables import parts_of_a_sum
from percuss.kernels.overdamped import pace_until
from percuss.kernels.record import MotionRecord, flight_after
from percuss.model.system import law
from percuss.motion.moved_measures import nodes_of

DASHPOTS = [1e5, 1e6, 1e9]
OMEGA, AT, STIFFNESS = "0.8", "0.5", 1000
T_END = 40.0


def stopped(dashpot: float) -> pc.Oscillator:
    stop = pc.SoftStop(at=AT, side="above", stiffness=STIFFNESS, damping=dashpot)
    return pc.Oscillator(stiffness=1, damping="0.05", stops=(stop,))


def run_of(dashpot: float) -> pc.Trajectory:
    return pc.simulate(stopped(dashpot), pc.cosine(OMEGA), v0=0.5, t_end=T_END)


class Contact:
    """A stay in the stop: u = x - at from u = 0, u'' + 2 a u' + K u = cos(w t) - at."""

    def __init__(self, dashpot: float, enters: mpf, v: float) -> None:
        self.drag = 2 * mpf(dashpot)
        a, self.omega = mpf("0.05") + mpf(dashpot), mpf(OMEGA)
        k = 1 + mpf(STIFFNESS)
        self.fast = -(a + mp.sqrt(a * a - k))
        self.slow = k / self.fast
        self.middle = -mpf(AT) / k
        self.gain = 1 / (k - self.omega**2 + 2j * a * self.omega) * mp.expj(self.omega * enters)
        z = -self.middle - mp.re(self.gain)
        w = mpf(v) - mp.re(1j * self.omega * self.gain)
        self.z_slow = (w - self.fast * z) / (self.slow - self.fast)
        self.z_fast = z - self.z_slow

    def derivative(self, s: mpf, order: int) -> mpf:
        """Return u or one of its derivatives a time s after the entry."""
        free = self.z_slow * self.slow**order * mp.exp(self.slow * s)
        free += self.z_fast * self.fast**order * mp.exp(self.fast * s)
        turned = (1j * self.omega) ** order * self.gain * mp.expj(self.omega * s)
        return free + mp.re(turned) + (self.middle if order == 0 else 0)

    def force(self, s: mpf) -> mpf:
        """Return the stop's force."""
        return -STIFFNESS * self.derivative(s, 0) - self.drag * self.derivative(s, 1)

    def slope(self, s: mpf) -> mpf:
        """Return its derivative."""
        return -STIFFNESS * self.derivative(s, 1) - self.drag * self.derivative(s, 2)

    def forces(self, duration: mpf) -> list[mpf]:
        """Return the force at both ends and at its turning points."""
        grid = [mp.exp(e) for e in mp.linspace(mp.log(-1 / self.fast), mp.log(duration), 200)]
        found = [self.force(mpf(0)), self.force(duration)]
        for ends in itertools.pairwise(grid):
            if self.slope(ends[0]) * self.slope(ends[1]) < 0:
                turn = mp.findroot(self.slope, ends, solver="anderson", verify=False)
                found.append(self.force(turn))
        return found


def contacts_of(run: pc.Trajectory, dashpot: float) -> list[tuple[Contact, mpf]]:
    """Return the contacts that begin with an event of a run, and how long the run has them last."""
    events, marks = run.record
    instants = [mpf(row[columns.EVENT_T]) + mpf(row[columns.EVENT_T_LOW]) for row in events]
    inside = int(run.system.law[:, at.NUMBER].argmax())
    return [
        (Contact(dashpot, instants[i], float(events[i, columns.V_AFTER])), after - instants[i])
        for i, after in enumerate([*instants[1:], mpf(run.t_end)])
        if marks[i, columns.NEXT_REGION] == inside
    ]


@pytest.mark.parametrize("dashpot", DASHPOTS)
def test_the_mass_leaves_the_stop_where_its_closed_form_does(dashpot: float) -> None:
    """At 1e9 the rounding was bounded by the forces' own, and the mass left it 1.5e-5 late."""
    with mp.workdps(60):
        contacts = contacts_of(run_of(dashpot), dashpot)

        assert len(contacts) > 3
        for contact, lasts in contacts[:-1]:
            late = contact.derivative(lasts, 0) / contact.derivative(lasts, 1)
            assert abs(late) < 1e-14


@pytest.mark.parametrize("dashpot", DASHPOTS)
def test_extremes_of_the_force_are_those_of_the_closed_form(dashpot: float) -> None:
    """The force falls by as many orders as the dashpot has, and then has its other extreme."""
    run = run_of(dashpot)
    with mp.workdps(60):
        forces = [f for contact, lasts in contacts_of(run, dashpot) for f in contact.forces(lasts)]
        least, most = float(min(forces)), float(max(forces))

    found = run.extremes("stop_force")

    assert found.minimum == pytest.approx(least, rel=1e-14)
    assert found.maximum == pytest.approx(most, rel=1e-14)


@pytest.mark.parametrize("dashpot", DASHPOTS)
def test_extremes_of_the_acceleration_are_those_of_entry_and_free_motion(dashpot: float) -> None:
    run = run_of(dashpot)
    entries = run.crossings.v[run.crossings.direction == "in"]
    x = float(AT)

    found = run.extremes("acceleration")

    assert found.t_minimum in run.crossings.t
    force = math.cos(float(OMEGA) * found.t_minimum)
    least = force - x - 2.0 * (dashpot + 0.05) * entries.max()
    assert found.minimum == pytest.approx(least, rel=1e-14)
    # The rest of the motion hardly knows of the dashpot.
    assert found.maximum == pytest.approx(1.932, abs=2e-3)


@pytest.mark.parametrize("dashpot", DASHPOTS)
def test_measures_of_a_sweep_are_those_of_the_run(dashpot: float) -> None:
    osc, force = stopped(dashpot), pc.cosine(OMEGA)
    names = ["max_displacement", "peak_stop_force", "rms_displacement", "dissipated_energy"]
    found = pc.sweep(
        names, osc, force, over={"oscillator.stiffness": [1.0]}, transient=0, periods=3
    ).isel({"oscillator.stiffness": 0})
    run = pc.simulate(osc, force, periods=3)

    assert float(found["max_displacement"]) == run.extremes("displacement").maximum
    assert float(found["peak_stop_force"]) == run.extremes("stop_force").peak
    # Gauss's rule between the events of the run, from which the stop's own 1e-9 are far.
    events = [*run.record[0][:, columns.EVENT_T], run.t_end]
    parts = [nodes_of((a, b), 10.0) for a, b in itertools.pairwise(events)]
    square = sum(float((w * run(t)[0] ** 2).sum()) for t, w in parts)
    assert float(found["rms_displacement"]) == pytest.approx(
        math.sqrt(square / run.t_end), rel=1e-9
    )
    # What the force has done and neither mass nor springs have, per period: its work by parts,
    # because x hardly knows of the fast decay.
    omega = float(OMEGA)
    work = math.cos(omega * run.t_end) * float(run(run.t_end)[0])
    work += sum(float((w * omega * np.sin(omega * t) * run(t)[0]).sum()) for t, w in parts)
    stored = float(run.energy(run.t_end)[()]) - float(run.energy(0.0)[()])
    assert float(found["dissipated_energy"]) == pytest.approx((work - stored) / 3.0, rel=1e-9)


@pytest.mark.parametrize("dashpot", DASHPOTS)
def test_a_sum_takes_few_parts(dashpot: float) -> None:
    """200 radians of the decay, and then those of the forcing: 1e9 steps would take minutes."""
    table = law(stopped(dashpot), pc.cosine(OMEGA))
    region = int(table[:, at.NUMBER].argmax())
    total, s = 0, 0.0
    while s < 3.0:
        until = pace_until(table, region, s, 3.0)
        count, step = parts_of_a_sum(table, region, s, until)
        assert count * step == pytest.approx(until - s)
        total += count
        s = until
    assert total < 100


def test_the_rounding_of_a_slow_motion_is_bounded_by_its_own_size() -> None:
    run = run_of(1e9)
    events, marks = run.record
    inside = int(run.system.law[:, at.NUMBER].argmax())
    row = int(np.flatnonzero(marks[:, columns.NEXT_REGION] == inside)[0])
    record = MotionRecord(run.system.law, 0.0, events, marks)
    flight = flight_after(record, row, np.empty((1, 2)), np.empty((1, 2)))

    # The mass creeps by 1e-9.
    assert uncertainty(flight, 2.0) < 1e-22


def test_the_mean_of_a_power_takes_few_nodes() -> None:
    t, w = nodes_of((1.0, 4.0), 2e9, fades=1e-7, slow_rate=0.8)

    assert len(t) < 2000
    assert w.sum() == pytest.approx(3.0, rel=1e-15)
    assert (np.diff(t) > 0.0).all()
