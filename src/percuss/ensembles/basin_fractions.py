"""Basin fractions over one parameter or two, with attractors matched from value to value."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Floats, Integers
from percuss.ensembles.array_parts import part_dataset
from percuss.ensembles.attractors import (
    AnyStrobed,
    Attractor,
    StrobedStructure,
    StrobedSystem,
    label_starts,
)
from percuss.ensembles.basins import (
    COLUMN_UNITS,
    about_measure,
    checked_call,
    columns_of,
    fractions_of,
    measures_of,
    no_starts,
    start_ranges,
    warn_without_starts,
)
from percuss.ensembles.classification import Arrays, Classification, Rules
from percuss.ensembles.datasets import attributes_of, coordinates_of, with_units
from percuss.ensembles.engines import Engine
from percuss.ensembles.grid import Grid, make_grid, off_the_walls
from percuss.ensembles.groups import AnyGroup, Group, StructureGroup, walls_of
from percuss.ensembles.job import Answer, Dimension
from percuss.ensembles.run_job import execution_of, keep, run_job
from percuss.ensembles.sweep import check_structure, named_measures
from percuss.errors import ParameterError
from percuss.model.acting_sets import StructureSystem, within_walls
from percuss.model.exact import Phase, as_float, real, two_of, whole
from percuss.model.faults import is_row
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import On, Oscillator
from percuss.model.start import Start, late_problem
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.model.system import law, most_turns
from percuss.progress import Report

if TYPE_CHECKING:
    # A second of import, which no worker needs.
    from xarray import Dataset

# Values that a range (low, high) of the parameter stands for, and of each where there are two.
VALUES, OF_TWO = 51, 21


def basin_fractions(
    osc: Oscillator | Structure,
    force: Forcing | Loads | None,
    *,
    over: Mapping[str, object],
    on: On | None = None,
    x0: Sequence[Any] | None = None,
    v0: Sequence[Any] | None = None,
    start: Sequence[Any] | None = None,
    t0: Phase = 0.0,
    n_starts: int = 1000,
    seed: int = 0,
    periods: int = 1000,
    escape: float = 1e6,
    measures: Sequence[str] = (),
    store: str | Path | None = None,
    engine: Engine = "threads",
    n_workers: int | None = None,
    progress: Report = None,
    part: Sequence[int] | None = None,
) -> Dataset:
    """Return the fractions of random starts in each basin, over one parameter or two.

    The same starts are taken at each value of the parameter. An attractor is continued from one
    value to the next: the motion from its points at one value leads to the same attractor at the
    next, through changes of its period and into chaos. Where two lead to the same attractor, the
    nearer is continued and the other has ended. An attractor whose basin holds none of the starts
    is continued as well: its fraction is 0 until it ends.

    Over two parameters attractors are continued along both. Two that appear at different places and
    meet are one attractor, unless both exist at the same values somewhere.

    Parameters
    ----------
    osc, force
        The oscillator, and a forcing with a period; or a structure, and loads with a period.
    over
        One path or two, and for each a range (low, high), which stands for 51 values, or for 21
        where there are two, or the values themselves.
    on
        The coordinate, direction or point of a structure of which measures are taken.
    x0, v0
        Ranges (low, high) in which the starts are drawn uniformly [length], [length/time]. Of a
        structure each has a range, or one value, for every coordinate; default: zeros.
    start
        The same as (x0, v0) or (x0, v0, t0), in place of these: ``start=((-4, 0.7), (-4, 4))``.
    t0
        Time of the starts [time].
    n_starts
        Number of starts, >= 1. Those inside a wall do not count.
    seed
        Seed of the random numbers.
    periods, escape, measures
        As in `basins`.
    store, engine, n_workers, progress, part
        As in `sweep`.

    Returns
    -------
    xarray.Dataset
        Over the attractors and the paths: `fraction`, and `fraction_error`, its standard error,
        both NaN where no start is outside the walls or the parameters make no motion;
        `exists`; `kind`, `name`, `n_periods`, `n_impacts`, `x`, `v_strobe`, `exponent`,
        `exponent_error`, `residual` and the measures as in `basins`, NaN and empty where it does
        not exist; `x` and `v_strobe` of a structure over `coordinate`, too.
        Over the paths: `undecided`, the undecided part of the starts, and `n_starts`, those outside
        the walls. Attractors are numbered as they appear. The attribute `failed` counts the starts
        inside walls, at all values.

    Warns
    -----
    UserWarning
        If all starts lie inside walls at all values.

    Raises
    ------
    ParameterError
        If there is no such path, a range is wrong, or the forcing has no period.

    Examples
    --------
    The motion without impacts begins where it no longer touches the wall, at 0.794:

    >>> import percuss as pc
    >>> osc = pc.impact_oscillator(restitution=0.7, wall=1.0, side="above", damping=0.05)
    >>> data = pc.basin_fractions(osc, pc.cosine(1.5), n_starts=100, x0=(-4, 0.7), v0=(-4, 4),
    ...                           over={"oscillator.stops.0.at": [0.7, 1.2, 1.7]})
    >>> data.name.values.tolist()
    [['(1, 1)', '(1, 1)', '(1, 1)'], ['', '(0, 1)', '(0, 1)']]
    """
    execution = execution_of(store, engine, n_workers, progress, part)
    if on is not None and not isinstance(osc, Structure):
        raise ParameterError("on", on, "given for an oscillator, which has one displacement")
    force, periods, escape = checked_call(osc, force, periods, escape)
    n_starts, seed = whole("n_starts", n_starts, 1), whole("seed", seed, 0, math.inf)
    x0_range, v0_range, t0 = start_ranges(start, x0, v0, t0)
    begin = _begin(osc, t0)
    grid = make_grid(osc, force, begin, over, VALUES, on)
    names = named_measures(measures, grid.axes)
    if len(grid.axes) == 2:
        grid = make_grid(osc, force, begin, over, OF_TWO, on)
    if len(grid.axes) not in (1, 2) or any(axis.of_start for axis in grid.axes):
        given = [axis.path for axis in grid.axes]
        reason = "fractions have one axis or two, parameters of the motion"
        raise ParameterError("over", given, reason)
    if isinstance(osc, Structure):
        check_structure(names, grid)
        box = (*_ranges("x0", x0_range, osc.n), *_ranges("v0", v0_range, osc.n))
    else:
        box = (_range("x0", x0_range), _range("v0", v0_range))
    rules = Rules(as_float(t0), False, periods, escape)
    identity = grid.identity() | {
        "kind": "basin fractions", "box": repr(box), "n_starts": n_starts, "seed": seed,
    }  # fmt: skip
    identity |= {"measures": list(names)} if names else {}
    drawn = Scattered(grid, box, n_starts, seed)
    count = osc.n if isinstance(osc, Structure) else 1
    job = Classification(drawn, rules, tuple(identity.items()), count)
    answer = run_job(job, execution)
    if execution.part is not None:
        return part_dataset([answer], execution.part)
    warn_without_starts(drawn, answer)
    followed = follow_attractors(grid, rules, answer.arrays, n_starts)
    return keep(_dataset(grid, answer, followed, names, rules.t0), execution)


def _begin(osc: Oscillator | Structure, t0: Phase) -> Start | StructureStart:
    """Return a start at rest, in whose place others are drawn."""
    if not isinstance(osc, Structure):
        return Start(0.0, 0.0, t0)
    rest = within_walls(osc, np.zeros(2 * osc.n))
    return StructureStart(rest[: osc.n].tolist(), rest[osc.n :].tolist(), t0)


def _ranges(name: str, given: object, n: int) -> list[tuple[float, float]]:
    """Return the ranges of n coordinates, of which a single value is one of no width."""
    if given is None:
        return [(0.0, 0.0)] * n
    parts = tuple(given) if is_row(given) else ()
    if len(parts) != n:
        raise ParameterError(name, given, f"not {n} ranges or values, one for each coordinate")
    return [
        _range(f"{name}.{i}", part) if hasattr(part, "__len__") and not isinstance(part, str)
        else (real(f"{name}.{i}", as_float(part)),) * 2
        for i, part in enumerate(parts)
    ]  # fmt: skip


def _range(name: str, ends: object) -> tuple[float, float]:
    low, high = two_of(as_float, name, ends, "not a range (low, high)")
    if not (math.isfinite(low) and math.isfinite(high) and low < high):
        raise ParameterError(name, ends, "not a range from a low to a higher finite number")
    return low, high


@dataclass(frozen=True, slots=True)
class Scattered:
    """The same random starts at each point of a grid; the starts are the fastest axis."""

    grid: Grid
    box: tuple[tuple[float, float], ...]
    n_starts: int
    seed: int

    @property
    def size(self) -> int:
        """Number of starts, counted at each point."""
        return self.grid.size * self.n_starts

    @property
    def dimensions(self) -> tuple[Dimension, ...]:
        """The parameters, and the number of the start."""
        numbers = tuple(float(i) for i in range(self.n_starts))
        return (*self.grid.dimensions, Dimension("start", numbers))

    def groups(self, first: int, last: int) -> tuple[list[AnyGroup], dict[int, str]]:
        """Return the starts from first to last, in groups of one shape of law."""
        draw = np.random.default_rng(self.seed).random((self.n_starts, len(self.box)))
        low, high = np.array(self.box).T
        places = low + draw * (high - low)
        groups: list[AnyGroup] = []
        faults: dict[int, str] = {}
        for k in range(first // self.n_starts, (last - 1) // self.n_starts + 1):
            begin = k * self.n_starts
            numbers = np.arange(max(first - begin, 0), min(last - begin, self.n_starts))
            rows = begin + numbers - first
            # The start of the grid may be inside a wall; the law does not depend on it.
            try:
                osc, force, start = self.grid.point(k)
            except ParameterError as error:
                faults |= {int(row): str(error) for row in rows}
                continue
            t0 = as_float(start.t0)
            if isinstance(osc, Structure):
                system = StructureSystem(osc, force)
                groups.append(self._of_structure(system, places[numbers], t0, rows, faults))
                continue
            own_law = law(osc, force)
            problem = late_problem(t0, most_turns(own_law))
            if problem is not None:
                faults |= {int(row): f"t0 = {t0}: {problem}" for row in rows}
                continue
            walls = walls_of(own_law[np.newaxis])
            inside = (places[numbers, 0] < walls[0][0]) | (places[numbers, 0] > walls[1][0])
            faults |= {int(row): "inside a wall" for row in rows[inside]}
            outside = numbers[~inside]
            starts = np.column_stack([places[outside], np.full(len(outside), t0)])
            which = np.zeros(len(outside), dtype=np.int64)
            groups.append(Group(own_law[np.newaxis], which, starts, rows[~inside]))
        return groups, faults

    def _of_structure(
        self,
        system: StructureSystem,
        places: Floats,
        t0: float,
        rows: Integers,
        faults: dict[int, str],
    ) -> StructureGroup:
        """Return the starts of one structure, and add the faults of those behind a wall."""
        starts = np.column_stack([places, np.full(len(places), t0)])
        which, every = np.zeros(len(rows), dtype=np.int64), np.arange(len(rows))
        behind: dict[int, str] = {}
        free = off_the_walls((system,), which, every, starts, behind)
        faults |= {int(rows[i]): text for i, text in behind.items()}
        return StructureGroup((system,), which[free], starts[free], rows[free], self.grid.direction)


def _strobed_at(grid: Grid, k: int, t0: float) -> AnyStrobed:
    """Return the system at a point of the parameters."""
    osc, force, _ = grid.point(k)
    if isinstance(osc, Structure):
        return StrobedStructure(StructureSystem(osc, force), t0, grid.direction)
    return StrobedSystem.of(osc, force, t0)


def _dataset(
    grid: Grid,
    answer: Answer,
    followed: Sequence[AttractorsAt],
    measures: Sequence[str],
    t0: float,
) -> Dataset:
    import xarray

    paths = tuple(axis.dimension for axis in grid.axes)
    n = 1 + max((number for at_point in followed for number in at_point.attractors), default=-1)
    shape = (n, len(followed))
    dims = ("attractor", *paths)
    texts = {name: np.full(shape, "", dtype=object) for name in ("kind", "name")}
    numbers = {name: np.full(shape, np.nan) for name in (*columns_of(None), *measures)}
    # Of no starts there is no part.
    parts = np.where([at_point.n_starts > 0 for at_point in followed], 0.0, np.nan)
    fraction, error = np.tile(parts, (n, 1)), np.tile(parts, (n, 1))
    exists = np.zeros(shape, dtype=np.bool_)
    for k, at_point in enumerate(followed):
        for number, attractor in at_point.attractors.items():
            exists[number, k] = True
            texts["kind"][number, k], texts["name"][number, k] = attractor.kind, attractor.name
            fraction[number, k], error[number, k] = at_point.fractions[number]
            for name, value in columns_of(attractor).items():
                numbers[name][number, k] = value
        for number, row in _measured(grid, k, at_point, measures, t0):
            for name, value in row.items():
                numbers[name][number, k] = value
    columns: dict[str, tuple[tuple[str, ...], NDArray[Any], dict[str, str]]] = {
        "fraction": (dims, fraction, {}),
        "fraction_error": (dims, error, {}),
        "exists": (dims, exists, {}),
        **{name: (dims, values, {}) for name, values in texts.items()},
        **{
            name: (
                dims,
                values,
                about_measure(name, grid.osc)
                if name in measures
                else {"units": COLUMN_UNITS.get(name, "1")},
            )
            for name, values in numbers.items()
        },
        "undecided": (paths, np.array([at_point.undecided for at_point in followed]), {}),
        "n_starts": (
            paths,
            np.array([at_point.n_starts for at_point in followed], dtype=np.int64),
            {},
        ),
    }
    if isinstance(grid.osc, Structure):
        columns |= _strobes_of(followed, n, grid.osc.n, paths)
    data = {
        name: (names, values.reshape(*values.shape[:-1], *grid.shape), about)
        for name, (names, values, about) in columns.items()
    }
    dataset = xarray.Dataset(
        data,
        coords=coordinates_of(grid.dimensions),
        attrs=attributes_of(grid.motion(), answer) | {"failed": no_starts(answer)},
    )
    return with_units(dataset, grid.osc.units)


def _strobes_of(
    followed: Sequence[AttractorsAt], n: int, n_coordinates: int, paths: tuple[str, ...]
) -> dict[str, tuple[tuple[str, ...], NDArray[Any], dict[str, str]]]:
    """Return a strobe of each attractor of a structure, by coordinate."""
    places = np.full((n, 2 * n_coordinates, len(followed)), np.nan)
    for k, at_point in enumerate(followed):
        for number, attractor in at_point.attractors.items():
            if attractor.strobes.shape[1] == 2 * n_coordinates:
                places[number, :, k] = attractor.strobes[0]
    dims = ("attractor", "coordinate", *paths)
    parts = {"x": places[:, :n_coordinates], "v_strobe": places[:, n_coordinates:]}
    return {name: (dims, part, {"units": COLUMN_UNITS[name]}) for name, part in parts.items()}


def _measured(
    grid: Grid, k: int, at_point: AttractorsAt, names: Sequence[str], t0: float
) -> Iterator[tuple[int, dict[str, float]]]:
    """Yield the measures of the attractors at a point of the parameters, by number."""
    if not names or not at_point.attractors:
        return
    system = _strobed_at(grid, k, t0)
    for number, attractor in at_point.attractors.items():
        yield number, measures_of(system, attractor, names)


# Points of a chaotic attractor that are followed at the next value, where most of them show which
# attractor continues it; of an orbit all points are followed.
SEEDS = 9


@dataclass(frozen=True, slots=True)
class AttractorsAt:
    """The attractors at one point of the parameters.

    Attributes
    ----------
    attractors
        By number, the same from point to point.
    fractions
        Fraction of the starts that go to each and its standard error, by number.
    undecided
        Fraction of the undecided starts.
    n_starts
        Starts outside the walls.
    """

    attractors: dict[int, Attractor]
    fractions: dict[int, tuple[float, float]]
    undecided: float
    n_starts: int


# At a point whose parameters are outside their domains.
NO_MOTION = AttractorsAt({}, {}, math.nan, 0)


def follow_attractors(
    grid: Grid, rules: Rules, arrays: Arrays, n_starts: int
) -> list[AttractorsAt]:
    """Return the attractors at each point of a grid of parameters, in the order of its points.

    Parameters
    ----------
    grid
        The values of one parameter or of several.
    rules
        The rules of the classification.
    arrays
        The classes of the starts, by the names of `CLASS_COLUMNS`, point after point.
    n_starts
        Starts at each point.
    """
    points: list[AttractorsAt] = []
    n_known = 0
    merged: list[tuple[int, int]] = []
    for k in range(grid.size):
        own = {name: array[k * n_starts : (k + 1) * n_starts] for name, array in arrays.items()}
        try:
            system = _strobed_at(grid, k, rules.t0)
        except ParameterError:
            # An impossible model has neither starts nor attractors.
            points.append(NO_MOTION)
            continue
        known = [
            numbered
            for before in points_before(points, grid.shape, k)
            for numbered in before.attractors.items()
        ]
        seeds = [
            (owner, place)
            for owner, (_, attractor) in enumerate(known)
            for place in _seeds(attractor)
        ]
        classes = _classes(system, rules, [place for _, place in seeds])
        both = {name: np.concatenate([own[name], classes[name]]) for name in own}
        labels, attractors = label_starts(system, both)
        owners = [owner for owner, _ in seeds]
        numbers, pairs = _matched(known, attractors, labels[n_starts:], owners)
        merged += pairs
        for i in range(len(attractors)):
            if i not in numbers:
                numbers[i], n_known = n_known, n_known + 1
        part, error, undecided, n = fractions_of(labels[:n_starts], len(attractors))
        order = sorted((numbers[i], i) for i in range(len(attractors)))
        points.append(
            AttractorsAt(
                {number: attractors[i] for number, i in order},
                {number: (float(part[i]), float(error[i])) for number, i in order},
                undecided,
                n,
            )
        )
    return with_joined_numbers(points, merged)


def points_before(
    points: Sequence[AttractorsAt], shape: Sequence[int], k: int
) -> list[AttractorsAt]:
    """Return the attractors at the point before along each axis, the last axis first."""
    before = []
    stride = 1
    for length in reversed(shape):
        for steps in range(1, k // stride % length + 1):
            earlier = points[k - steps * stride]
            if earlier is not NO_MOTION:
                before.append(earlier)
                break
        stride *= length
    return before


def with_joined_numbers(
    points: Sequence[AttractorsAt], merged: Sequence[tuple[int, int]]
) -> list[AttractorsAt]:
    """Give one number to attractors that merge and never exist at the same point.

    An attractor that appears at two places of a chart and is continued from both is one.
    """
    where: dict[int, set[int]] = {}
    for k, at_point in enumerate(points):
        for number in at_point.attractors:
            where.setdefault(number, set()).add(k)
    root = {number: number for number in where}
    for pair in merged:
        low, high = sorted(root[number] for number in pair)
        if low != high and not where[low] & where[high]:
            where[low] |= where.pop(high)
            root = {number: low if own == high else own for number, own in root.items()}
    dense = {number: i for i, number in enumerate(sorted(where))}
    return [
        replace(
            at_point,
            attractors={dense[root[i]]: value for i, value in at_point.attractors.items()},
            fractions={dense[root[i]]: value for i, value in at_point.fractions.items()},
        )
        for at_point in points
    ]


def _seeds(attractor: Attractor) -> Floats:
    """Return points of an attractor to be followed; none of unbounded motions."""
    if attractor.kind == "unbounded":
        return np.empty((0, 2))
    points = attractor.strobes
    return points[:: max(1, len(points) // SEEDS)][:SEEDS] if len(points) > SEEDS else points


def _classes(system: AnyStrobed, rules: Rules, places: Sequence[Floats]) -> Arrays:
    """Return the classes of points of the attractors before."""
    if isinstance(system, StrobedStructure):
        structure = system.system.structure
        inside = [within_walls(structure, place) for place in places]
        states = np.reshape(inside, (len(places), 2 * structure.n))
        begin = np.column_stack([states, np.full(len(places), rules.t0)])
        return replace(rules, within=False).follow(system.group(begin))[0]
    starts = np.column_stack([np.reshape(places, (len(places), 2)), np.full(len(places), rules.t0)])
    low, high = walls_of(system.law[np.newaxis])
    # A wall may have moved past them.
    starts[:, 0] = np.clip(starts[:, 0], low[0], high[0])
    which = np.zeros(len(starts), dtype=np.int64)
    group = Group(system.law[np.newaxis], which, starts, which)
    return replace(rules, within=False).follow(group)[0]


def _matched(
    known: Sequence[tuple[int, Attractor]],
    attractors: Sequence[Attractor],
    labels: Integers,
    owners: Sequence[int],
) -> tuple[dict[int, int], list[tuple[int, int]]]:
    """Return the numbers of the attractors to which points of known ones have gone.

    And the pairs of numbers whose points have gone to the same one.
    """
    links: list[tuple[float, int, int]] = []
    for k, (number, before) in enumerate(known):
        reached = np.array([label for label, owner in zip(labels, owners, strict=True)
                            if owner == k and label >= 0], dtype=np.int64)  # fmt: skip
        if before.kind == "unbounded":
            links += [
                (0.0, number, i) for i, now in enumerate(attractors) if now.kind == before.kind
            ]
        elif len(reached):
            most = int(np.bincount(reached).argmax())
            links.append((_distance(before, attractors[most]), number, most))
    numbers: dict[int, int] = {}
    taken: set[int] = set()
    for _, number, i in sorted(links):
        if i not in numbers and number not in taken:
            numbers[i] = number
            taken.add(number)
    pairs = [(numbers[i], number) for _, number, i in links if number not in taken]
    return numbers, pairs


def _distance(one: Attractor, other: Attractor) -> float:
    """Return the mean distance between the points of two attractors."""
    if one.kind == "unbounded" or other.kind == "unbounded":
        return float("inf")
    finite = (part[np.isfinite(part).all(axis=1)] for part in (one.strobes, other.strobes))
    a, b = (part[:500] for part in finite)
    distances = np.abs(a[:, np.newaxis] - b).max(axis=2)
    return float(0.5 * (distances.min(axis=0).mean() + distances.min(axis=1).mean()))
