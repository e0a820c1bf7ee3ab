"""Certified runs: time to 12 digits, and bits spent beside those that the motion demands."""

from __future__ import annotations

import math
import time

import numpy as np

import percuss as pc
from benchmarks.report import Report, installed

# What the derivatives demand may be exceeded by a quarter and a tenth of a bit, and O(log N).
PART, MORE, LOGARITHMS = 1.25, 0.1, 2.0


def run(report: Report) -> None:
    """Time the two motions of the aim."""
    report.section(
        "Certified: ball arithmetic to 12 digits",
        "Every impact proven to be the first, with its error. Seconds of processor time, from "
        "the float run to the result.",
    )
    if not installed("python-flint"):
        report.line("python-flint", "not installed")
        return
    elastic = pc.simulate(pc.impact_oscillator(), pc.sine(3), v0="0.45", max_impacts=1000)
    _measure(report, "1,000 elastic impacts, n = 3, v0 = 0.45", elastic, pc.Start(0, "0.45"), 1.0)
    osc = pc.impact_oscillator("0.8", side="above")
    chaotic = pc.simulate(osc, pc.cosine("2.8"), v0=-1, max_impacts=200)
    _measure(report, "200 chaotic impacts, omega = 2.8, r = 0.8", chaotic, pc.Start(0, -1), 2.0)
    _orbits(report)


def _orbits(report: Report) -> None:
    """Time the proof of an orbit, of a family of 78 impacts, and of special points."""
    orbit = pc.find_orbit(pc.impact_oscillator("0.8"), pc.cosine("2.5"))
    wall, force = pc.impact_oscillator(), pc.sine(3)
    family = pc.find_orbit(wall, force, n_impacts=78, n_periods=60, guess=(0.0, 0.4985))
    doubling = pc.continue_orbit(orbit, over={"forcing.omega": (2.3, 2.8)}).special_points[0]
    walls = pc.Wall("0.3", "above", "0.7"), pc.Wall("-0.3", "below", "0.7")
    mirrored = pc.find_orbit(pc.Oscillator(1, "0.02", walls), pc.cosine("1.5"), 2, 1)
    breaking = pc.continue_orbit(mirrored, over={"forcing.amplitude": (0.4, 1.1)}).special_points[0]
    for name, what in (
        ("an orbit of one impact", orbit),
        ("a family of 78 impacts in 60 periods", family),
        ("a period doubling", doubling),
        ("a symmetry breaking", breaking),
    ):
        begin = time.process_time()
        proven = pc.certify(what)
        seconds = time.process_time() - begin
        assert proven.exists, proven
        report.line(f"{name}, to 12 digits", f"{1e3 * seconds:.0f} ms")


def _measure(report: Report, name: str, motion: pc.Trajectory, start: pc.Start, aim: float) -> None:
    begin = time.process_time()
    proven = pc.certify(motion, digits=12, start=start)
    seconds = time.process_time() - begin
    n = len(proven.impacts)
    assert proven.complete
    assert n == len(motion.impacts)
    assert min(proven.impacts.t.digits()) >= 12
    report.below(f"{name} (aim)", seconds, aim, "s")
    demanded = growth_in_bits(proven) / n
    allowed = PART * demanded + MORE + LOGARITHMS * math.log2(n) / n
    assert proven.bits_per_impact <= allowed
    report.line(
        "bits an impact, spent and demanded by the derivatives",
        f"{proven.bits_per_impact:.2f}, {demanded:.2f}",
    )


def growth_in_bits(proven: pc.certified.CertifiedRun) -> float:
    """Return log2 of the derivative over all impacts, in floats; one harmonic, k = 1, a = 0."""
    force, wall = proven.forcing, proven.oscillator.stops[0]
    assert force is not None
    assert isinstance(wall, pc.Wall)
    assert not isinstance(wall.restitution, pc.model.RestitutionTable)
    part = force.components()[0]
    omega, r = float(part.omega), float(pc.model.as_float(wall.restitution))
    times = [0.0, *proven.impacts.t.mid()]
    after = [float(pc.model.as_float(proven.start.v0)), *proven.impacts.v_after.mid()]
    product, logarithm = np.eye(2), 0.0
    for i, v1 in enumerate(proven.impacts.v_before.mid()):
        c, d = math.cos(times[i + 1] - times[i]), math.sin(times[i + 1] - times[i])
        a0, a1 = (
            part.cos * math.cos(omega * t) + part.sin * math.sin(omega * t)
            for t in times[i : i + 2]
        )
        t_by = np.array([c * after[i] + d * a0, -d]) / v1
        v_by = np.array([d * after[i] - c * a0, c])
        product = np.array([t_by, -r * (v_by + a1 * t_by)]) @ product
        size = float(np.abs(product).max())
        product, logarithm = product / size, logarithm + math.log2(size)
    return logarithm
