"""Structures: two masses with a soft stop and a wall, a beam of ten modes, and up to forty modes."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

import percuss as pc
from benchmarks.report import Report, installed
from benchmarks.timing import race
from percuss.ensembles.diagram import Direction
from percuss.model import as_float

Floats = NDArray[np.float64]
Motion = tuple[pc.Structure, pc.Loads, list[float], list[float]]

# Events of a run, and of the runs whose instants are compared.
N, CHECKED = 5_000, 20
# By how much heyoka's instants may differ: its steps add up.
TOLERANCE = 1e-9
MODES = (1, 2, 5, 10, 20, 40)
# Sweeps of a diagram that follow the motion from one value to the next.
BOTH_WAYS: tuple[Direction, ...] = ("forward", "backward")
# Special points of NLvib's example 03 from w = 0.8 down to 0.5.
NLVIB_POINTS = [
    "grazing", "fold", "fold", "period_doubling", "period_doubling", "torus", "torus", "grazing",
]  # fmt: skip


def run(report: Report) -> None:
    """Time an event of motions of 2, 10 and up to 40 coordinates, beside heyoka with its callback."""
    report.section(
        "Structures",
        "Two masses: springs 1, 1, 0, a soft stop of 20 before the first and a wall with r = 0.9 "
        "before the second, driven. Beam: a cantilever of n modes with damping ratios of 0.005, "
        "driven at its middle, with a soft stop of 50 at the tip. An event is an impact, or an "
        "entry or exit of a soft stop. heyoka: Taylor steps at full tolerance, events with "
        "callbacks; each mode is an equation of its own. Least processor time of seven turns. NLvib 03 "
        "is the branch of docs/nlvib-example.md, at the default largest step of 0.02 and at 0.1. The "
        "diagram: two masses on springs with a gap of 1 either way and r = 0.7, 600 points at each of "
        "500 frequencies after 200 periods; once from rest, then also up and down.",
    )
    cases = {"two masses": two_masses(), "a beam of 10 modes": beam(10)}
    for name, motion in cases.items():
        error = reference_error(motion)
        assert error < 1e-11, f"error of the instants of {name}: {error}"
        report.line(f"percuss, {name}, largest error of {CHECKED} instants", f"{error:.1e}")
        contenders: dict[str, Callable[[], object]] = {"percuss": partial(follow, motion, N)}
        if installed("heyoka"):
            peer = HeyokaStructure(motion)
            times = peer.run(CHECKED)
            off = float(np.abs(times - event_times(follow(motion, 2 * CHECKED))[:CHECKED]).max())
            assert off < TOLERANCE, f"heyoka's instants of {name} differ by {off}"
            contenders["heyoka"] = partial(peer.run, N // 10)
        taken = race(contenders, of_processor=True)
        each = taken["percuss"] / len(event_times(follow(motion, N)))
        report.line(f"percuss, {name}, us an event", f"{each * 1e6:.2f} us")
        if "heyoka" in taken:
            theirs = taken["heyoka"] / (N // 10)
            report.line(f"heyoka, {name}, us an event", f"{theirs * 1e6:.1f} us")
            report.ratio(f"heyoka : percuss, {name}", theirs / each, 10)
    costs = race({f"{n}": partial(follow, beam(n), N) for n in MODES}, of_processor=True)
    counts = {f"{n}": len(event_times(follow(beam(n), N))) for n in MODES}
    for n in MODES:
        each = costs[f"{n}"] / counts[f"{n}"]
        if n == 2:
            report.below("percuss, a beam of 2 modes, us an event (aim)", each * 1e6, 1.0, "us")
        else:
            report.line(f"percuss, a beam of {n} modes, us an event", f"{each * 1e6:.2f} us")
    diagrams = {"one": partial(pair_diagram, ()), "three": partial(pair_diagram, BOTH_WAYS)}
    taken = race(diagrams, of_processor=True)
    report.below("an impact pair, diagram of 500 x 600 points", taken["one"], 1.0, "s")
    report.line(
        "an impact pair, three such diagrams: up, down, from rest", f"{taken['three']:.2f} s"
    )
    orbit = pc.find_orbit(*nlvib_03())
    over = {"loads.0.omega": (0.8, 0.5)}
    for step in (0.02, 0.1):
        branch = pc.continue_orbit(orbit, over=over, largest_step=step)
        kinds = [point.kind for point in branch.special_points]
        assert kinds == NLVIB_POINTS, f"special points of NLvib 03: {kinds}"
        closing = max(each.residual for each in branch.orbits)
        assert closing < 1e-12, f"orbits of NLvib 03 fail to close by {closing}"
        follow_it = partial(pc.continue_orbit, orbit, over, largest_step=step)
        taken = race({"branch": follow_it}, of_processor=True)["branch"]
        name = f"NLvib 03, frequency response 0.8 to 0.5, {len(branch)} orbits"
        report.line(f"{name}, largest residual", f"{closing:.1e}")
        report.below(name, taken, 1.0, "s")


def pair_diagram(follow: tuple[Direction, ...]) -> Any:
    """Return the bifurcation diagram of two masses that meet at both ends of their gap."""
    pair = pc.impact_pair([1, 1], gap=1, restitution="0.7", springs="0.5", dashpots="0.05")
    diagram = pc.bifurcation_diagram(
        pair,
        pc.Loads({0: pc.cosine(1, amplitude="0.8")}),
        over={"loads.0.omega": np.linspace(0.8, 1.2, 500)},
        on=0,
        points=600,
        n_workers=1,
        follow=follow,
    )
    assert diagram.x.shape == (1 + len(follow), 500, 600)
    assert diagram.attrs["failed"] == 0
    return diagram


def nlvib_03() -> tuple[pc.Structure, pc.Loads]:
    """Return the structure of NLvib's example 03 and its loads at w = 0.8."""
    stop = pc.SoftStop(at=1, side="above", stiffness=100, on=0)
    chain = pc.chain([1, 1], [0, 1, 1], [0, "0.03", "0.03"], [stop])
    return chain, pc.Loads({1: pc.cosine("0.8", amplitude="0.1")})


def two_masses() -> Motion:
    """Return a motion that meets a soft stop and a wall."""
    structure = pc.chain(
        [1, 1],
        [1, 1, 0],
        ["0.02", "0.02", 0],
        [
            pc.SoftStop("0.2", "above", 20, "0.1", on=0),
            pc.Wall("-0.3", "below", "0.9", on=1),
        ],
    )
    return structure, pc.Loads({0: pc.cosine("1.3")}), [0.0, 0.0], [0.1, 0.4]


def beam(n: int) -> Motion:
    """Return a motion of a cantilever's tip against a soft stop."""
    structure = pc.cantilever(
        n,
        damping_ratio="0.005",
        points={"tip": 1, "middle": "0.5"},
        stops=[pc.SoftStop("0.05", "above", 50, "0.1", on="tip")],
    )
    return structure, pc.Loads({"middle": pc.cosine("3.1", amplitude=2)}), [0.0] * n, [0.0] * n


def follow(motion: Motion, n: int) -> Any:
    """Return the run of n impacts and entries."""
    structure, loads, x0, v0 = motion
    return pc.simulate(structure, loads, x0=x0, v0=v0, t_end=1e9, max_impacts=n)


def event_times(run: Any) -> Floats:
    """Return the instants of impacts, entries and exits, in order."""
    return np.sort(np.concatenate([run.impacts.t, run.crossings.t]))


def reference_error(motion: Motion) -> float:
    """Return how far the first instants are from those of the reference of 40 digits."""
    from tests.oracle.structures import simulate_structure, structure_problem

    structure, loads, x0, v0 = motion
    times = event_times(follow(motion, 2 * CHECKED))[:CHECKED]
    end = float(times[-1]) + 1e-6
    exact = simulate_structure(structure_problem(structure, loads), x0, v0, t_end=end)
    theirs = [float(event.t) for event in exact.events if event.kind in ("impact", "in", "out")]
    return float(np.abs(times - np.array(theirs[:CHECKED])).max())


class HeyokaStructure:
    """The same motion by heyoka: its callbacks strike walls and switch soft stops."""

    def __init__(self, motion: Motion) -> None:
        import heyoka as hy

        structure, loads, x0, v0 = motion
        n = structure.n
        self.start = [*x0, *v0]
        x = [hy.make_vars(f"x{i}") for i in range(n)]
        v = [hy.make_vars(f"v{i}") for i in range(n)]
        inverse = np.linalg.inv(structure.mass_matrix)
        pull, drag = inverse @ structure.stiffness_matrix, inverse @ structure.damping_matrix
        rows = structure.stop_directions
        ways = rows @ inverse.T
        force = loads.directions(structure) @ inverse.T
        waves = [
            hy.sum([part.cos * hy.cos(float(part.omega) * hy.time) for part in one.components()])
            for one in loads.forcings
        ]
        places = [_sum(hy, row, x) - as_float(s.at) for s, row in zip(structure.stops, rows, strict=True)]  # fmt: skip
        speeds = [_sum(hy, row, v) for row in rows]
        self.soft = [i for i, s in enumerate(structure.stops) if isinstance(s, pc.SoftStop)]
        accelerations = []
        for i in range(n):
            terms = [-_sum(hy, pull[i], x), -_sum(hy, drag[i], v)]
            terms += [float(force[k, i]) * wave for k, wave in enumerate(waves) if force[k, i]]
            for k, j in enumerate(self.soft):
                stop: Any = structure.stops[j]
                if ways[j, i]:
                    size = as_float(stop.stiffness) * places[j] + as_float(stop.damping) * speeds[j]
                    terms.append(-float(ways[j, i]) * hy.par[k] * size)
            accelerations.append(hy.sum(terms))
        system = [*zip(x, v, strict=True), *zip(v, accelerations, strict=True)]
        self.times: list[float] = []
        self.limit = 1
        events = [
            hy.t_event(places[j], callback=self._callback(structure, j, rows[j], ways[j]))
            for j in range(len(structure.stops))
        ]
        self.ta = hy.taylor_adaptive(
            system, self.start, t_events=events, pars=[0.0] * len(self.soft)
        )

    def _callback(self, structure: pc.Structure, j: int, row: Floats, way: Floats) -> Any:
        peer, n, stop = self, structure.n, structure.stops[j]
        sign = 1.0 if stop.side == "above" else -1.0
        kick = way / float(row @ way)

        class Met:
            def __call__(self, ta: Any, _: int) -> bool:
                speed = float(row @ ta.state[n:])
                if isinstance(stop, pc.SoftStop):
                    ta.pars[peer.soft.index(j)] = 1.0 if sign * speed > 0.0 else 0.0
                elif sign * speed > 0.0:
                    ta.state[n:] -= (1.0 + as_float(stop.restitution)) * speed * kick  # type: ignore[arg-type]
                else:
                    return True
                peer.times.append(ta.time)
                return len(peer.times) < peer.limit

            def __deepcopy__(self, _: object) -> Met:
                return self

        return Met()

    def run(self, n: int) -> Floats:
        """Return the instants of the first n events."""
        self.times.clear()
        self.limit = n
        self.ta.time = 0.0
        self.ta.state[:] = self.start
        self.ta.pars[:] = 0.0
        self.ta.reset_cooldowns()
        self.ta.propagate_until(1e9)
        return np.array(self.times)


def _sum(hy: Any, factors: Floats, variables: list[Any]) -> Any:
    terms = [float(c) * x for c, x in zip(factors, variables, strict=True) if c]
    return hy.sum(terms) if terms else hy.expression(0.0)
