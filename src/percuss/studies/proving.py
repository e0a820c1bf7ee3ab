"""The proof of the answer of a study: its lines in the report, its table, its picture."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from percuss.errors import ParameterError
from percuss.execution import Execution
from percuss.model.exact import Exact, Phase, as_float
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, Wall
from percuss.motion.trajectory import Trajectory
from percuss.orbits.bifurcations.branch import Branch
from percuss.progress import Report
from percuss.studies.axes import axis_values
from percuss.wording import counted

if TYPE_CHECKING:
    # Needs python-flint.
    from percuss.certified import (
        Ball,
        CertifiedBasins,
        CertifiedBranch,
        CertifiedChaos,
        CertifiedOrbit,
        CertifiedPoint,
        CertifiedRun,
        CompleteList,
    )
    from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
    from percuss.studies.study import Study

# Of the files: certified.csv, certified.png.
STEM = "certified"
# Digits of a number in the table beyond those asked for, and at least.
MORE_DIGITS, LEAST_DIGITS = 4, 17
# Impacts and periods of the attractors that are looked for.
MOST_IMPACTS = MOST_PERIODS = 2
# Speeds of a complete list, from the slowest and the fastest impact of the orbits that are found.
SLOWER, FASTER = 0.1, 1.5
OF_STRUCTURE = "of a structure, of which there are no proofs"
# Digits of a number in the report, at most.
MOST_SHOWN = 30


@dataclass(frozen=True, slots=True)
class ProofOfStudy:
    """The proof of the answer of a study.

    Parameters
    ----------
    result
        The result of `percuss.certify` for a run or an orbit; for a branch, a tuple of those of its
        special points.
    report
        The proven statements in a few lines: words by their names.
    columns
        The table saved as certified.csv.
    branch
        The branch of special points.
    """

    result: Any
    report: dict[str, str]
    columns: dict[str, NDArray[Any]]
    branch: Any = None


def check_certify(study: Study) -> None:
    """Refuse a study whose answer cannot be certified.

    Raises
    ------
    ParameterError
        If it is not of kind motion, orbit or branch.
    MissingExtraError
        If python-flint is not installed.
    """
    if study.certify is None:
        return
    if study.structure is not None:
        reason = "for oscillators; of structures there are no proofs"
        raise ParameterError("certify", study.certify.digits, reason)
    if not study.question.is_certifiable:
        reason = f"for studies of kind motion, orbit and branch; this one is of kind {study.kind}"
        raise ParameterError("certify", study.certify.digits, reason)
    import percuss.certified  # noqa: F401  says what to install


def proof_of(study: Study, answer: Any, progress: Report) -> ProofOfStudy:
    """Certify the answer of a study to the digits that it asks for."""
    from percuss.certified import certify

    assert study.certify is not None
    digits = study.certify.digits
    if study.kind == "motion":
        run = certify(answer, digits, progress=progress)
        return ProofOfStudy(run, _run_rows(run), _run_columns(run, digits))
    if study.kind == "orbit":
        orbit = certify(answer, digits)
        return ProofOfStudy(orbit, _orbit_rows(orbit), _orbit_columns(orbit, digits))
    points = []
    for done, point in enumerate(answer.special_points):
        if callable(progress) and progress(done, len(answer.special_points)) is False:
            break
        points.append(certify(point, digits))
    left = len(answer.special_points) - len(points)
    rows, columns = _point_rows(points, left), _point_columns(points, digits)
    return ProofOfStudy(tuple(points), rows, columns, answer)


def proven(
    study: Study,
    digits: int,
    progress: Report = None,
    *,
    chaos: bool = False,
    orbits: tuple[int, int] | None = None,
    speeds: tuple[Exact, Exact] | None = None,
    point: int | None = None,
) -> (
    CertifiedRun
    | CertifiedOrbit
    | CertifiedPoint
    | CertifiedBranch
    | CertifiedBasins
    | CertifiedChaos
    | CompleteList
):
    """Prove the motion, orbit, branch or basins of a study, or chaos or all orbits of its system.

    Parameters
    ----------
    study
        Of kind motion, orbit, branch or basins; for chaos and all orbits of any kind.
    digits
        Digits of the enclosures of a motion or an orbit.
    progress
        True shows a line on the error stream; a function is called as in `certify`.
    chaos
        Whether chaos is to be proven.
    orbits, speeds
        Impacts and periods of the orbits of which all are to be found, and the range of speeds
        after impacts, as in `list_of`.

    point
        Number of the special point of a branch that is to be proven by itself, from 1.

    Returns
    -------
    CertifiedRun, CertifiedOrbit, CertifiedPoint, CertifiedBranch, CertifiedBasins, CertifiedChaos
    or CompleteList
        What has a certificate, or says what is open.

    Raises
    ------
    ParameterError
        If the study has a structure, no motion, orbit, branch or basins, or no forcing that chaos
        and lists need; if speeds are given without the orbits, or these together with chaos; if a
        branch has no special point of that number.
    MissingExtraError
        If python-flint is not installed.
    """
    from percuss.certified import certify

    if orbits is None and speeds is not None:
        raise ParameterError("speeds", speeds, "those of a list of orbits, which is not asked for")
    if chaos and orbits is not None:
        raise ParameterError(
            "chaos", chaos, "together with a list of orbits; prove one, then the other"
        )
    if chaos:
        return chaos_of(study, progress)
    if orbits is not None:
        return list_of(study, *orbits, speeds=speeds, progress=progress)
    if study.structure is not None:
        raise ParameterError("study", study.kind, OF_STRUCTURE)
    if study.kind == "basins":
        return _basins_of_study(study, progress)
    if study.kind not in ("motion", "orbit", "branch"):
        reason = (
            "not of kind motion, orbit, branch or basins, which alone have certificates, but for "
            "--chaos and --list"
        )
        raise ParameterError("study", study.kind, reason)
    answer: Trajectory | PeriodicOrbit | Branch
    if point is not None and study.kind != "branch":
        raise ParameterError("point", point, "a special point of a branch; the study has none")
    answer = study.question.answer(study, Execution(progress=progress))
    if isinstance(answer, Trajectory):
        return certify(answer, digits, progress=progress)
    if not isinstance(answer, Branch):
        return certify(answer, digits)
    if point is None:
        return certify(answer, progress=progress)
    number = len(answer.special_points)
    if not 1 <= point <= number:
        reason = f"the branch has {counted(number, 'special point')}"
        raise ParameterError("point", point, reason)
    return certify(answer.special_points[point - 1], digits)


def chaos_of(study: Study, progress: Report = None) -> CertifiedChaos:
    """Prove that motions of a study's system are chaotic.

    Raises
    ------
    ParameterError
        If the study has a structure or no forcing, or no saddle is found.
    MissingExtraError
        If python-flint is not installed.
    """
    from percuss.certified import prove_chaos

    force = _forcing_of(study, "by which chaos is proven")
    return prove_chaos(study.oscillator, force, progress=progress)


def _forcing_of(study: Study, why: str) -> Forcing:
    if study.structure is not None:
        raise ParameterError("study", study.kind, OF_STRUCTURE)
    if study.forcing is None:
        raise ParameterError("study", study.kind, f"without forcing, {why}")
    if study.forcing.period is None:
        raise ParameterError("study", study.kind, f"without a period of the forcing, {why}")
    return study.forcing


def list_of(
    study: Study,
    impacts: int,
    periods: int,
    *,
    speeds: tuple[Exact, Exact] | None = None,
    progress: Report = None,
) -> CompleteList:
    """Find and prove all orbits of a study's system with so many impacts in so many periods.

    Parameters
    ----------
    study
        Of an oscillator.
    impacts, periods, speeds
        As in `list_orbits`. Without speeds they go from a tenth of the slowest impact of the orbits
        that a search finds to one and a half times the fastest.
    progress
        As in `list_orbits`.

    Raises
    ------
    ParameterError
        If the study has a structure or no periodic forcing, or if no speeds are given and no such
        orbit is found.
    MissingExtraError
        If python-flint is not installed.
    """
    from percuss.certified import list_orbits
    from percuss.orbits import find_orbits

    force = _forcing_of(study, "by which orbits repeat themselves")
    if speeds is None:
        orbits = find_orbits(study.oscillator, force, impacts, periods)
        impacts_found = [abs(orbit.impacts.v_after) for orbit in orbits if len(orbit.impacts)]
        slowest = min((float(min(v)) for v in impacts_found), default=0.0)
        if not slowest > 0.0:
            reason = "missing, and no orbit is found from which to take them; give the least and the greatest"
            raise ParameterError("speeds", speeds, reason)
        fastest = max(float(max(v)) for v in impacts_found)
        speeds = f"{SLOWER * slowest:.2g}", f"{FASTER * fastest:.2g}"
    return list_orbits(study.oscillator, force, impacts, periods, speeds=speeds, progress=progress)


def list_rows(proven: CompleteList) -> dict[str, str]:
    """Return what is proven of all orbits in a few lines: words by their names."""
    low, high = (f"{float(speed):g}" for speed in proven.speeds)
    kind = f"{counted(proven.impacts, 'impact')} in {counted(proven.periods, 'forcing period')}"
    scope = f"with {kind}, all of speeds from {low} to {high} after an impact"
    if not proven.complete:
        return {"certified": f"not all orbits {scope}: {proven.reason}"}
    orbits = [*proven.orbits, *proven.shorter]
    rows = {
        "certified": f"{counted(len(orbits), 'orbit')} {scope}, and no others"
        if orbits
        else f"no orbit {scope}"
    }
    for number, orbit in enumerate(orbits, start=1):
        t, v = (
            _shown(part[0], orbit.wanted_digits)
            for part in (orbit.impacts.t, orbit.impacts.v_after)
        )
        rows[f"orbit {number}"] = f"at t = {t}, v_after = {v}; {orbit.stability}"
    return rows


def _basins_of_study(study: Study, progress: Report) -> CertifiedBasins:
    """Prove basins between the first and the last values of the axes of a study of basins."""
    from percuss.studies.kinds.basins import Basins

    assert isinstance(study.question, Basins)
    if study.question.cycle is not None:
        reason = "of starts on a wall; basins are proven over x0 and v0"
        raise ParameterError("study", study.kind, reason)
    x0, v0 = (
        [as_float(value) for value in axis_values(axis)]
        for axis in study.question.of_states
        if axis is not None
    )
    if len(x0) < 2 or len(v0) < 2:
        raise ParameterError("study", study.kind, "of one line of starts, which has no cells")
    return basins_of(
        study,
        (min(x0), max(x0)), (min(v0), max(v0)),
        t0=study.question.begin, cells=(len(x0) - 1, len(v0) - 1), progress=progress,
    )  # fmt: skip


def basins_of(
    study: Study,
    x0: tuple[Exact, Exact],
    v0: tuple[Exact, Exact],
    *,
    t0: Phase,
    cells: tuple[int, int],
    depth: int = 2,
    progress: Report = None,
) -> CertifiedBasins:
    """Prove the basins of the stable orbits of a study's system that a search finds.

    Parameters
    ----------
    study
        Of an oscillator.
    x0, v0, t0, cells, depth
        As in `prove_basins`.
    progress
        As in `prove_basins`.

    Raises
    ------
    ParameterError
        If the study has a structure or no periodic forcing, if no stable orbit without contacts is
        found, or one is not proven.
    MissingExtraError
        If python-flint is not installed.
    """
    from percuss.certified import prove_basins
    from percuss.orbits import find_orbits

    force = _forcing_of(study, "by which basins are proven")
    orbits = [
        orbit
        for orbit in find_orbits(study.oscillator, force, MOST_IMPACTS, MOST_PERIODS)
        if orbit.is_stable and math.isfinite(orbit.n_impacts)
    ]
    if not orbits:
        reason = (
            f"without a stable orbit of up to {MOST_IMPACTS} impacts in {MOST_PERIODS} periods, "
            "about which a basin is proven"
        )
        raise ParameterError("study", study.kind, reason)
    return prove_basins(orbits, x0=x0, v0=v0, t0=t0, cells=cells, depth=depth, progress=progress)


def basins_rows(basins: CertifiedBasins) -> dict[str, str]:
    """Return what is proven of basins in a few lines: words by their names."""
    total = sum(basins.areas) + basins.open_area
    n_proven = int((basins.labels >= 0).sum())
    if n_proven == 0:
        return {"certified": "nothing: of no cell all motions are proven to go to one orbit"}
    rows = {
        "certified": f"of {n_proven:,} cells of starts all motions go to one orbit, told by cell; "
        f"of {int((basins.labels == -1).sum()):,} it is open"
    }
    for number, (attractor, area) in enumerate(zip(basins.attractors, basins.areas, strict=True)):
        kind = f"{counted(len(attractor.impacts), 'impact')} in {counted(attractor.n_periods, 'period')}"
        rows[f"attractor {number}"] = f"{kind}: {area / total:.1%} of the area of starts is proven"
    return rows


def chaos_rows(chaos: CertifiedChaos) -> dict[str, str]:
    """Return what is proven of chaos in a few lines: words by their names."""
    if not chaos:
        return {"certified": f"nothing: {chaos.reason}"}
    lengths = " and ".join(str(len(loop)) for loop in chaos.loops)
    return {
        "certified": f"for every order of loops of {lengths} impacts there is a motion that follows "
        "it; for every order that repeats itself, a periodic one",
        "entropy": f"of the impact map at least {chaos.entropy.mid():.6g} an impact",
        "proof": f"{counted(len(chaos.transitions), 'covering relation')} between "
        f"{counted(len(chaos.sets), 'set')} that have no common state",
    }


def draw_proof(proof: ProofOfStudy, study: Study, figure: Any) -> None:
    """Draw the proof with its enclosure on an empty figure."""
    from percuss.plotting.enclosure_plot import plot_enclosure
    from percuss.plotting.style import draw_legend

    figure.set_size_inches(9.0 if study.kind == "orbit" else 8.0, 5.0)
    if study.kind == "orbit" and not proof.result.is_drawable:
        reason = proof.result.reason or "it has contacts, of which no motion is enclosed"
        figure.text(0.5, 0.5, f"no enclosure to draw: {reason}", ha="center", wrap=True)
        return
    plot_enclosure(
        proof.result, figure.add_subplot(), branch=proof.branch, units=study.draw.units()
    )
    if study.kind != "branch":
        draw_legend(figure, figure.axes)


def _run_rows(run: CertifiedRun) -> dict[str, str]:
    """Return how far a run is proven, why not farther, and how accurately."""
    last = run.t_end
    place = (
        f"up to t = {_shown(last, run.wanted_digits)}" if last.arb.is_finite() else "for all times"
    )
    counts = [
        counted(len(table), name)
        for name, table in (
            ("impact", run.impacts), ("crossing", run.crossings), ("contact", run.contacts)
        )
        if len(table)
    ]  # fmt: skip
    infinite = ", and infinitely many impacts in each accumulation" if run.accumulations else ""
    rows = {
        "certified": f"{', '.join(counts) or 'no events'} {place}{infinite}",
        "proof": run.outcome.value + (f": {run.reason}" if run.reason else ""),
    }
    radii = [
        f"{_largest_radius(columns)} of {name}"
        for name, columns in (
            ("times", [*run.impacts.t, *run.crossings.t]),
            ("velocities", [*run.impacts.v_before, *run.crossings.v]),
        )
        if columns
    ]
    asked = f"{run.wanted_digits} asked for"
    known = f"; largest radius {', '.join(radii)}" if radii else ""
    spent = f"{run.precision} bits, {max(0.0, run.bits_per_impact):.2g} spent an impact"
    if run.start != run.start_given:
        given = run.start_given.x0
        rows["start, proven"] = f"on the stop, at x0 = {run.start.x0} for the double {given}"
    return rows | {"digits": f"{asked}{known} ({spent})"} | _doubles_row(run)


def _doubles_row(result: CertifiedRun | CertifiedOrbit) -> dict[str, str]:
    """Return the numbers that were doubles, not the decimals in which they were written."""
    return {"taken as doubles": ", ".join(result.doubles)} if result.doubles else {}


def _orbit_rows(orbit: CertifiedOrbit) -> dict[str, str]:
    """Return the proven and the open statements about an orbit."""
    if not orbit.exists:
        return {"certified": f"nothing: {orbit.reason}"}
    digits = orbit.wanted_digits
    physical = {
        True: "passes through no stop",
        False: "passes through a stop",
        None: "whether it passes through a stop is open",
    }
    alone = (
        f"no other with these events{_within(orbit)}"
        if orbit.isolated
        else "not proven to be alone"
    )
    what = "an orbit" if orbit.admissible else "a solution of the formal equations of an orbit"
    stability = orbit.stability
    if stability == "undecided":
        stability = "stability undecided"
    rows = {"certified": f"{what} exists, {alone}; {physical[orbit.admissible]}; {stability}"}
    if len(orbit.impacts):
        t, v = orbit.impacts.t[0], orbit.impacts.v_after[0]
        rows["first, proven"] = f"at t = {_shown(t, digits)}, v_after = {_shown(v, digits)}"
    formal = "" if orbit.admissible else " of the formal map"
    rows["trace, proven"] = (
        f"{_shown(orbit.trace, digits)}, determinant {_shown(orbit.determinant, digits)}{formal}"
    )
    return rows | ({"open": orbit.reason} if orbit.reason else {}) | _doubles_row(orbit)


def _within(orbit: CertifiedOrbit) -> str:
    if math.isinf(orbit.unique_within):
        return ""
    return f" within {orbit.unique_within:.1e} of its period and speed"


def _point_rows(points: Sequence[CertifiedPoint], left: int) -> dict[str, str]:
    """Return the proven place of each special point, or why it is open."""
    lines = []
    for point in points:
        name = point.kind.replace("_", " ")
        if point.exists:
            formal = {
                True: ", formal, the orbit passes through a stop",
                False: "",
                None: ", whether the orbit passes through a stop is open",
            }[point.is_formal]
            value = _shown(point.value, point.wanted_digits)
            lines.append(f"{name} at {value}{formal}: {point.statement}")
        else:
            lines.append(f"{name} at {point.point.value:.12g}: not proven; {point.reason}")
    if left:
        lines.append(f"interrupted before {counted(left, 'more special point')}")
    return {"certified": "\n".join(lines) or "no special points, so nothing to prove"}


def _run_columns(run: CertifiedRun, digits: int) -> dict[str, NDArray[Any]]:
    """Return the events of a run in the order of time."""
    impacts, crossings, contacts, grazes = run.impacts, run.crossings, run.contacts, run.grazes
    rows = [
        ("impact", int(stop), t, before, after)
        for stop, t, before, after in zip(
            impacts.stop, impacts.t, impacts.v_before, impacts.v_after, strict=True
        )
    ]
    events: list[tuple[str, int, Ball, Ball | None, Ball | None]] = [*rows]
    events += [
        (str(direction), int(stop), t, v, v)
        for direction, stop, t, v in zip(
            crossings.direction, crossings.stop, crossings.t, crossings.v, strict=True
        )
    ]
    for name, stops, column in (
        ("contact", contacts.stop, contacts.start),
        ("release", contacts.stop, contacts.release),
        ("graze", grazes.stop, grazes.t),
    ):
        events += [
            (name, int(stop), t, None, None)
            for stop, t in zip(stops, column, strict=True)
            if not t.arb.is_nan()
        ]
    # The sort is stable: the last impact of a chatter comes before the contact in which it ends.
    return _event_columns(sorted(events, key=lambda row: float(row[2])), digits)


def _orbit_columns(orbit: CertifiedOrbit, digits: int) -> dict[str, NDArray[Any]]:
    """Return the impacts of a period, and entries into soft stops."""
    impacts = orbit.impacts
    rows = zip(impacts.stop, impacts.t, impacts.v_before, impacts.v_after, strict=True)
    return _event_columns(
        [(_name(orbit.oscillator, stop), int(stop), t, b, a) for stop, t, b, a in rows], digits
    )


def _name(oscillator: Oscillator, stop: int) -> str:
    return "impact" if isinstance(oscillator.stops[stop], Wall) else "in"


def _event_columns(
    rows: Sequence[tuple[str, int, Ball, Ball | None, Ball | None]], digits: int
) -> dict[str, NDArray[Any]]:
    columns: dict[str, NDArray[Any]] = {
        "event": np.array([row[0] for row in rows], dtype=object),
        "stop": np.array([row[1] for row in rows], dtype=np.int64),
    }
    for place, name in enumerate(("t", "v_before", "v_after"), start=2):
        columns |= _decimals(name, [row[place] for row in rows], digits)  # type: ignore[misc]
    return columns


def _point_columns(points: Sequence[CertifiedPoint], digits: int) -> dict[str, NDArray[Any]]:
    path = points[0].path if points else "value"
    values = [point.value if point.exists else None for point in points]
    texts = {
        "kind": [point.kind for point in points],
        "proven": ["yes" if point.exists else "no" for point in points],
        "formal": [{True: "yes", False: "no", None: "open"}[point.is_formal] for point in points],
        "statement": [point.statement or point.reason for point in points],
    }
    columns = {name: np.array(column, dtype=object) for name, column in texts.items()}
    return {"kind": columns["kind"], **_decimals(path, values, digits), **columns}


def _decimals(name: str, balls: Sequence[Ball | None], digits: int) -> dict[str, NDArray[Any]]:
    """Return midpoints in decimals and their radii, empty where there is no number."""
    n = max(LEAST_DIGITS, digits + MORE_DIGITS)
    pairs = [("", "") if ball is None else ball.decimals(n) for ball in balls]
    return {
        name: np.array([pair[0] for pair in pairs], dtype=object),
        f"{name}_radius": np.array([pair[1] for pair in pairs], dtype=object),
    }


def _largest_radius(balls: Sequence[Ball]) -> str:
    """Return the largest radius in words, rounded up; it may lie below the smallest float."""
    from percuss.certified.ball_arithmetic import upwards

    return upwards(max(ball.arb.rad() for ball in balls), 2)


def _shown(ball: Ball, digits: int) -> str:
    """Return a ball with about the digits asked for, as far as a line has room."""
    return ball.text(min(digits + 3, MOST_SHOWN))
