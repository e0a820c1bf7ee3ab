"""The reference cases as problems, and what is read off a run of each."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath

import percuss as pc
from percuss.model import Side

# A run of percuss or of the oracle: both have impacts.t, crossings.v, ..., and run(t).
Run = Any

SIDES: dict[str, Side] = {"lower": "below", "upper": "above"}
# Starts that are given as formulas, which no exact number can hold: 40 digits do.
with mpmath.workdps(40):
    FORMULAS = {
        "-0.3/2.8": Fraction(-3, 28),
        "asin(1/1.2)": mpmath.nstr(mpmath.asin(mpmath.mpf(5) / 6), 40),
        "pi/(2 omega)": mpmath.nstr(mpmath.pi / mpmath.mpf("5.6"), 40),
        "-(1-1e-6)": "-0.999999",
    }


@dataclass(frozen=True)
class Case:
    """One reference case that a single run decides."""

    id: str
    params: dict[str, Any]
    expected: list[float]
    tolerance: float

    def oscillator(self) -> pc.Oscillator:
        """Return the oscillator, every number exact."""
        p = self.params
        if "kp" in p:
            return pc.bilinear_oscillator(
                _exact(p["kp"]), stiffness_below=_exact(p["km"]), damping=_exact(p["a"])
            )
        stops = tuple(pc.Wall(_exact(w["x"]), SIDES[w["side"]], _exact(p["r"])) for w in p["walls"])
        return pc.Oscillator(_exact(p["k"]), _exact(p["a"]), stops)

    def force(self) -> pc.Forcing:
        """Return the forcing, phases as multiples of pi."""
        parts = [
            pc.Harmonic(_exact(h["A"]), _exact(h["omega"]), _phase(h["phi"]))
            for h in self.params["harmonics"]
        ]
        return pc.Forcing(tuple(parts), constant=_exact(self.params["F0"]))

    def start(self) -> tuple[Any, Any, Any]:
        """Return x0, v0, t0."""
        init = self.params["init"]
        return _exact(init["x"]), _exact(init["v"]), _exact(init["t"])

    def limits(self) -> dict[str, Any]:
        """Return the limit of the run."""
        return LIMITS[self.id]

    def measured(self, run: Run) -> list[float]:
        """Return what stands in ``expected``, read off a run."""
        found = MEASURES[self.id](run)
        return [float(value) for value in (found if isinstance(found, list) else [found])]


def load_cases() -> list[Case]:
    """Return the cases that a single run decides, in the order of the file."""
    rows = json.loads((Path(__file__).parent / "cases.json").read_text(encoding="utf-8"))
    cases = []
    for row in rows:
        if row["id"] in MEASURES:
            value = row["value"] if isinstance(row["value"], list) else [row["value"]]
            expected = [float(number) for number in value]
            cases.append(Case(row["id"], row["params"], expected, row["tolerance"]))
    return cases


def _exact(value: object) -> Any:
    # JSON wrote decimals; a float is read back as the decimal that stood there.
    text = str(value)
    return FORMULAS.get(text, text)


def _phase(value: object) -> Any:
    match = re.fullmatch(r"(-?)pi/(\d+)", str(value))
    return pc.pi_times(int(match[1] + "1"), int(match[2])) if match else _exact(value)


def _impacts(*numbers: int) -> Callable[[Run], list[float]]:
    return lambda run: [run.impacts.t[n - 1] for n in numbers]


def _after(t: float, run: Run) -> int:
    """Return the index of the first impact after t."""
    return next(i for i, instant in enumerate(run.impacts.t) if instant > t)


def _free_bilinear(run: Run) -> list[float]:
    down, up = run.crossings.t[0], run.crossings.t[1]
    # Half a swing below 0 lies between the crossings; unforced, its middle is the deepest.
    return [2 * math.pi / float(up), run.crossings.t[19], -run((down + up) / 2)[0]]


def _damped_bilinear(run: Run) -> list[float]:
    return [2 * math.pi / float(run.crossings.t[1]), run.crossings.t[9], run.crossings.v[9]]


def _forced_chatter(run: Run) -> list[float]:
    release = run.contacts.release[0]
    i = _after(release, run)
    times = [run.impacts.t[n - 1] for n in (1, 2, 5, 10)]
    last = [run.impacts.t[i], run.impacts.t[i + 1], *run.impacts.v_after[i : i + 2]]
    return [*times, run.contacts.start[0], release, *last]


def _locking_ball(run: Run) -> list[float]:
    lock = next(i for i, t in enumerate(run.contacts.start) if t > 2)
    release = run.contacts.release[lock]
    first, again = run.impacts.t[0], run.impacts.t[_after(release, run)]
    period = (again - first) / (2 * math.pi)
    take_off = release - 2 * math.pi
    return [take_off, first, -run.impacts.v_before[0], run.contacts.start[lock], period]


def _stick_start(run: Run) -> list[float]:
    return [run.contacts.release[0], *run.impacts.t[:3]]


def _plastic(run: Run) -> list[float]:
    return [*run.impacts.t[:4], *(abs(v) for v in run.impacts.v_before[:4])]


def _overdamped(run: Run) -> list[float]:
    return [len(run.impacts.t), run.impacts.t[0], run.impacts.v_before[0], run(1.0)[0]]


def _graze(run: Run) -> list[float]:
    return [run.impacts.t[0], -run.impacts.v_before[0], run.impacts.t[1]]


MEASURES: dict[str, Callable[[Run], Any]] = {
    "seed-resonance-n2-V20": lambda run: run.impacts.v_after[19],
    "seed-resonance-n4-V20": lambda run: run.impacts.v_after[19],
    "seed-n3-V0.51-t30": lambda run: [run.impacts.t[29], run.impacts.v_after[29]],
    "seed-n3-V0.45-impacts": _impacts(*range(1, 9)),
    "seed-half-first": _impacts(1),
    "seed-half-impacts": _impacts(2, 5, 10, 20, 100),
    "seed-cos-resonant": lambda run: [*run.impacts.v_after[:4]],
    "free-damped-impact": lambda run: [run.impacts.t[24], run.impacts.v_after[24]],
    "overdamped-one-impact": _overdamped,
    "graze-free-1e-6": _graze,
    "bouncing-ball-g9.81": lambda run: [*run.impacts.t[:10], run.contacts.start[0]],
    "gap-never-chatter": lambda run: [run.impacts.t[29], run.impacts.v_after[29]],
    "zeno-ball": lambda run: run.contacts.start[0],
    "stick-start-release": _stick_start,
    "chatter-forced-r0.8": _forced_chatter,
    "ball-locking-G1.2-r0.5": _locking_ball,
    "r0-plastic": _plastic,
    "bilin-free-1-4": _free_bilinear,
    "bilin-free-1-400": _free_bilinear,
    "bilin-free-damped": _damped_bilinear,
    "bilin-to-impact-1e4": lambda run: [run.crossings.t[19], run.crossings.v[19]],
    "elastic-long-w2.7": _impacts(20, 50),
    "preload-shift": _impacts(1, 6, 12),
}

LIMITS: dict[str, dict[str, Any]] = {
    "seed-resonance-n2-V20": {"max_impacts": 20},
    "seed-resonance-n4-V20": {"max_impacts": 20},
    "seed-n3-V0.51-t30": {"max_impacts": 30},
    "seed-n3-V0.45-impacts": {"max_impacts": 8},
    "seed-half-first": {"max_impacts": 1},
    "seed-half-impacts": {"max_impacts": 100},
    "seed-cos-resonant": {"max_impacts": 4},
    "free-damped-impact": {"max_impacts": 25},
    "overdamped-one-impact": {"t_end": 50},
    "graze-free-1e-6": {"max_impacts": 2},
    "bouncing-ball-g9.81": {"t_end": 3},
    "gap-never-chatter": {"max_impacts": 30},
    "zeno-ball": {"t_end": 5},
    "stick-start-release": {"max_impacts": 3},
    "chatter-forced-r0.8": {"t_end": 6},
    "ball-locking-G1.2-r0.5": {"t_end": 12},
    "r0-plastic": {"max_impacts": 4},
    "bilin-free-1-4": {"t_end": 48},
    "bilin-free-1-400": {"t_end": 34},
    "bilin-free-damped": {"t_end": 22},
    "bilin-to-impact-1e4": {"t_end": 32},
    "elastic-long-w2.7": {"max_impacts": 50},
    "preload-shift": {"max_impacts": 12},
}
