"""The result of a fit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from numpy.typing import ArrayLike

from percuss.arrays import Flags, Floats
from percuss.errors import ParameterError
from percuss.fitting.effort import go_on
from percuss.fitting.measured import MeasuredSamples, quantity_name, quantity_number
from percuss.fitting.noise import NOT_WHITE, whiteness_of
from percuss.fitting.search import FitCandidate, FitSearch
from percuss.fitting.shooting import Layout, motion_between, start_at
from percuss.fitting.solver import FIRM, TAUT, FitPoint, FitProblem, descend, point_at
from percuss.kernels.segments import DISPLACEMENT, VELOCITY
from percuss.kernels.structure.segments import OF_PLACE
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.oscillator import Oscillator
from percuss.model.paths import long_form, replace_parameters
from percuss.model.start import Start
from percuss.model.structure import Structure
from percuss.model.structure_start import StructureStart
from percuss.motion.html_table import html_table
from percuss.motion.simulate import run_of
from percuss.motion.structures import StructureTrajectory
from percuss.motion.trajectory import Trajectory
from percuss.numerics.linear import directions
from percuss.pictures import HasPicture

if TYPE_CHECKING:
    from xarray import Dataset


class ValuesByPath(dict[str, float]):
    """Numbers by the long paths of parameters, found by the names that were asked for too.

    Attributes
    ----------
    asked
        The names that were asked for, by the long paths.

    Examples
    --------
    >>> values = ValuesByPath({"oscillator.damping": 0.4}, {"oscillator.damping": "oscillator.c"})
    >>> values["oscillator.c"], list(values)
    (0.4, ['oscillator.damping'])
    """

    def __init__(self, values: Mapping[str, float], asked: Mapping[str, str]) -> None:
        super().__init__(values)
        self.asked = dict(asked)

    def __missing__(self, name: str) -> float:
        """Return the number of a parameter by the name that was asked for."""
        for path, asked in self.asked.items():
            if asked == name and path != name:
                return self[path]
        raise KeyError(name)

    def __reduce__(self) -> tuple[type[ValuesByPath], tuple[dict[str, float], dict[str, str]]]:
        """Return what it is made of."""
        return ValuesByPath, (dict(self), self.asked)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Fit(HasPicture):
    """Parameters fitted to a record; made by `percuss.fit`.

    Attributes
    ----------
    values, errors
        The free parameters by their long paths, also found by the names that were asked for, and
        their standard errors: infinite where the data do not say anything, 0 at an end of a range.
    covariance
        (n_parameters, n_parameters) array, in the order of ``values``.
    chi2
        The mean of the squares of the residuals in standard deviations of the noise: 1 where the
        model explains the data. Where the noise was estimated from the residuals it is 1 by that.
    noise
        Standard deviations by quantity, given or estimated; of several records those of the first.
    whiteness
        By how many standard deviations the number of runs of one sign among the residuals differs
        from that of a random sequence: far below 0, the residuals hang together and the model
        misses something.
    unidentifiable
        Directions in the space of the parameters about which the data say nothing, each its shares
        by the paths, as ``values``.
    converged, reason
        Whether it is a least-squares solution that explains the data, and why not.
    n_runs
        How often the whole record was followed.
    at_bounds
        Long paths of the parameters at an end of their ranges; `end_of` takes all names.
    oscillator, forcing, start
        The fitted model, of a structure with its loads; forcing and start of the first record.
    nodes
        (n_nodes, 3) array, instants, displacements and velocities from which the motion was
        followed to the next; of all records, one after the other. (n_nodes, 1 + 2 n) for n
        coordinates.
    impacts
        (n_impacts,) array, the impacts and entries into soft stops of the fitted motion over the
        first record [time].
    residuals
        Dataset over ``sample``: t, value, fitted, residual (value less fitted), noise, quantity and
        record.
    problem
        The least-squares problem.
    profiles
        The profiles that were asked for, by path.
    """

    picture: ClassVar = "plot_fit"

    values: ValuesByPath
    errors: ValuesByPath
    covariance: Floats
    chi2: float
    noise: dict[str, float]
    whiteness: float
    unidentifiable: tuple[ValuesByPath, ...]
    converged: bool
    reason: str
    n_runs: int
    at_bounds: tuple[str, ...]
    oscillator: Oscillator | Structure
    forcing: Forcing | Loads | None
    start: Start | StructureStart
    nodes: Floats
    impacts: Floats
    residuals: Dataset
    problem: FitProblem
    profiles: dict[str, Dataset] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Return the parameters with their errors in a line."""
        values = ", ".join(
            f"{self.values.asked.get(path, path)} = {with_error(value, self.errors[path])}"
            for path, value in self.values.items()
        )
        return f"<Fit: {values}; chi2 {self.chi2:.3g}{self._end}>"

    @property
    def _end(self) -> str:
        """What is wrong with it, after a semicolon; empty if nothing is."""
        if self.reason:
            return f"; {self.reason}"
        is_white = self.whiteness >= NOT_WHITE
        return "" if is_white else "; the residuals hang together: the model misses something"

    def _repr_html_(self) -> str:
        columns = {
            "parameter": np.array([self.values.asked.get(path, path) for path in self.values]),
            "value": np.array(list(self.values.values())),
            "error": np.array(list(self.errors.values())),
        }
        return html_table(f"Fit: chi2 {self.chi2:.3g}, {self.n_runs} runs{self._end}", columns)

    @property
    def run(self) -> Trajectory | StructureTrajectory:
        """The motion of the fitted model over the first record.

        In chaos it departs from the record after some time, as any single run does; the fitted
        motion, which begins anew at each node, does not.
        """
        first = self.problem.layouts[0]
        end = float(first.spans[-1, 1])
        return run_of(self.oscillator, self.forcing, self.start, t_end=end)

    def __call__(self, t: ArrayLike) -> tuple[Floats, Floats]:
        """Return x and v of the fitted motion over the first record at times t.

        Parameters
        ----------
        t
            Times between its first node and its last sample, of any shape [time].

        Returns
        -------
        tuple of arrays
            x and v, of t's shape, of a structure of t's shape + (n,); from the nodes, so that chaos
            does not lead it astray.

        Raises
        ------
        ParameterError
            If a time lies outside the record.

        Examples
        --------
        >>> import numpy as np
        >>> import percuss as pc
        >>> t = np.linspace(0, 9, 40)
        >>> data = {"t": t, "displacement": 2 * np.cos(t)}
        >>> fit = pc.fit(data, pc.Oscillator(), free={"oscillator.stiffness": 1.3})
        >>> x, v = fit([0, 1.5])
        >>> abs(x - 2 * np.cos([0, 1.5])).max() < 1e-9
        np.True_
        """
        if isinstance(self.oscillator, Structure):
            kinds = (DISPLACEMENT, VELOCITY)
            n = self.oscillator.n
            x, v = (self._at(t, [kind + OF_PLACE * i for i in range(n)]) for kind in kinds)
            return x, v
        return self.of("displacement", t), self.of("velocity", t)

    def of(self, quantity: str, t: ArrayLike) -> Floats:
        """Return a quantity of the fitted motion over the first record at times t.

        Parameters
        ----------
        quantity
            "displacement", "velocity", "acceleration", "stop_force" or "stop_force_1" and so on; of
            a structure "displacement_0" of a coordinate, "displacement_tip" of a point.
        t
            Times between its first node and its last sample, of any shape [time].

        Returns
        -------
        array
            Of t's shape.

        Raises
        ------
        ParameterError
            If there is no such quantity, or a time lies outside the record.
        """
        return self._at(t, [quantity_number(quantity, self.oscillator)])[..., 0]

    def _at(self, t: ArrayLike, quantities: list[int]) -> Floats:
        """Return quantities by their numbers at times t, of t's shape + (n_quantities,)."""
        first, times = self.problem.layouts[0], np.asarray(t, dtype=np.float64)
        nodes, end = self.nodes[: len(first)], float(first.spans[-1, 1])
        quantity_values = motion_between(
            self.oscillator, self.forcing, nodes, end, times.ravel(), quantities
        )
        return quantity_values.reshape(*times.shape, len(quantities))

    def end_of(self, path: str) -> str:
        """Return at which end of its range a parameter is, "least" or "largest"; "" if at none."""
        path = long_form(path, self.oscillator, self.forcing, self.start)
        if path not in self.at_bounds:
            return ""
        which = self.problem.paths.index(path)
        value, low = self.values[path], float(self.problem.low[which])
        return "least" if value <= low else "largest"

    def profile(self, path: str, n: int = 9, width: float = 3.0) -> Dataset:
        """Return how the misfit grows with one parameter, all others fitted anew.

        Where the errors are those of a straight line, ``growth`` is the square of the distance in
        standard errors; else the values between which it stays below 1 hold the parameter with
        68 per cent, and below 3.84 with 95.

        Parameters
        ----------
        path
            The parameter.
        n
            Number of values, >= 3.
        width
            How far they go to each side, in standard errors.

        Returns
        -------
        Dataset
            Over ``value``: ``growth`` of the sum of the losses, NaN where no motion was found; and
            each other parameter.

        Raises
        ------
        ParameterError
            If it is no parameter of the fit, or has no error.

        Examples
        --------
        >>> import numpy as np
        >>> import percuss as pc
        >>> t = np.linspace(0, 20, 100)
        >>> x = np.cos(t) + 0.01 * np.sin(37 * t**2)
        >>> data = {"t": t, "displacement": x}
        >>> fit = pc.fit(data, pc.Oscillator(), free={"oscillator.stiffness": 1.1}, noise=0.007)
        >>> fit.profile("oscillator.stiffness", n=3, width=1).growth.values.round(1) + 0.0
        array([1., 0., 1.])
        """
        import xarray as xr

        name = long_form(path, self.oscillator, self.forcing, self.start)
        if name not in self.values:
            raise ParameterError("path", path, "none of the fitted parameters")
        error = self.errors[name]
        if not 0.0 < error < math.inf:
            raise ParameterError("path", path, f"its error is {error:g}; there is no profile")
        if n < 3:
            raise ParameterError("n", n, "less than 3")
        which = self.problem.paths.index(name)
        values = self.values[name] + error * width * np.linspace(-1.0, 1.0, n)
        rows = np.full((n, len(self.values)), math.nan)
        growth = np.full(n, math.nan)
        own = point_at(self.problem, np.array(list(self.values.values())), self.nodes[:, 1:].copy())
        assert own is not None
        # Descended as its neighbours are: what the search has left undone is no growth of theirs.
        best = _at_fixed(self.problem, own, which, self.values[name]) or own
        least = best.cost(self.problem, FIRM)
        middle = int(np.argmin(np.abs(values - self.values[name])))
        for side in (range(middle, n), range(middle - 1, -1, -1)):
            point = best
            for i in side:
                descent = _at_fixed(self.problem, point, which, float(values[i]))
                if descent is None:
                    break
                point, rows[i] = descent, descent.values
                growth[i] = descent.cost(self.problem, FIRM) - least
        columns = {key: ("value", rows[:, j]) for j, key in enumerate(self.values) if j != which}
        self.profiles[name] = xr.Dataset(
            {"growth": ("value", growth), **columns}, {"value": values}
        )
        return self.profiles[name]


def _at_fixed(problem: FitProblem, near: FitPoint, which: int, value: float) -> FitPoint | None:
    """Return the solution at a fixed value of one parameter, None if there is none."""
    low, high, values = problem.low.copy(), problem.high.copy(), near.values.copy()
    low[which] = high[which] = values[which] = value
    fixed = replace(problem, low=low, high=high)
    begin = point_at(fixed, values, near.shots.nodes)
    if begin is None:
        return None
    descent = descend(fixed, begin, TAUT)
    return descent.point if descent.is_settled and not len(descent.torn(fixed)) else None


def with_error(value: float, error: float) -> str:
    """Return a value with its error to two digits, and as many digits as that leaves.

    Examples
    --------
    >>> with_error(0.19981, 0.00056), with_error(15858.2, 3840.0), with_error(2.0, math.inf)
    ('0.19981 ± 0.00056', '15900 ± 3800', '2 ± inf')
    """
    if not 0.0 < error < math.inf:
        return f"{value:.6g} ± {error:g}"
    digits = 1 - int(f"{error:.1e}".partition("e")[2])
    if not -6 < digits < 12:
        return f"{value:.6g} ± {error:.2g}"
    if digits < 0:
        return f"{round(value, digits):.0f} ± {round(error, digits):.0f}"
    return f"{value:.{digits}f} ± {error:.{digits}f}"


def group_noise(samples: MeasuredSamples) -> float:
    """Return the root of the mean square of the noise of samples."""
    return math.sqrt(float(np.mean(np.square(samples.noise)))) if len(samples) else math.nan


# A direction in which the error is as many times the sizes of the parameters is named as unknown.
UNKNOWN = 1e3
# Shares of a direction below this are left out of its name.
LEAST_SHARE = 0.05


def result_of(search: FitSearch, best: FitCandidate) -> Fit:
    """Return the result of a search."""
    problem, point = best.problem, best.descent.point
    values = dict(zip(problem.paths, point.values.tolist(), strict=True))
    at_bound = (point.values <= problem.low) | (point.values >= problem.high)
    covariance, errors, unknown = _uncertainty(search, best, at_bound)
    layouts = tuple(problem.layouts)
    first = layouts[0].record
    osc, force, start = replace_parameters(problem.osc, first.force, first.start, values)
    spans = np.concatenate([layout.spans for layout in layouts])
    nodes = np.concatenate([spans[:, :1], point.shots.nodes], axis=1)
    if start is None:
        start = start_at(osc, nodes[0])
    residuals, hits = point.equations.residuals, point.shots.hits
    noise = {}
    for samples in (first.samples, first.impacts):
        for quantity in np.unique(samples.quantities).tolist():
            of = samples.quantities == quantity
            noise[quantity_name(quantity, osc)] = group_noise(samples.taken(of))
    return Fit(
        values=ValuesByPath(values, search.asked),
        errors=ValuesByPath(dict(zip(problem.paths, errors.tolist(), strict=True)), search.asked),
        covariance=covariance,
        chi2=float(np.mean(residuals * residuals)),
        noise=noise,
        whiteness=whiteness_of(layouts, residuals),
        unidentifiable=tuple(ValuesByPath(direction, search.asked) for direction in unknown),
        converged=not best.reason,
        reason=best.reason,
        n_runs=search.n_runs,
        at_bounds=tuple(path for path, at in zip(problem.paths, at_bound, strict=True) if at),
        oscillator=osc,
        forcing=force,
        start=start,
        nodes=nodes,
        impacts=np.sort(hits[hits[:, 0] < len(layouts[0]), 1]),
        residuals=_table(osc, layouts, residuals),
        problem=replace(problem, ask=go_on, keep=None, effort=None),
    )


def _uncertainty(
    search: FitSearch, best: FitCandidate, at_bound: Flags
) -> tuple[Floats, Floats, tuple[dict[str, float], ...]]:
    """Return covariance, standard errors, and the directions that the data leave open."""
    paths, n = search.paths, len(search.paths)
    values = best.descent.point.values
    width = np.where(search.ranged, search.high - search.low, 0.0)
    scales = np.maximum(np.abs(values), width)
    scales = np.where(scales > 0.0, scales, 1.0)
    covariance, errors = np.zeros((n, n)), np.zeros(n)
    matrix = best.descent.triangle[:, :-1] * scales
    # Where the data do not feel a parameter at all they do not hold it at the end of its range.
    is_felt = np.sqrt((matrix * matrix).sum(axis=0)) * UNKNOWN >= 1.0
    free = np.flatnonzero(~at_bound | ~is_felt)
    unknown = []
    if len(free):
        sizes, rows = directions(matrix[:, free])
        for size, row in zip(sizes.tolist(), rows, strict=True):
            if size * UNKNOWN < 1.0:
                shares = np.where(np.abs(row) < LEAST_SHARE, 0.0, row)
                named = {
                    paths[i]: float(share) for i, share in zip(free, shares, strict=True) if share
                }
                unknown.append(named)
                errors[free[shares != 0.0]] = math.inf
                continue
            along = row * scales[free] / size
            covariance[np.ix_(free, free)] += along[:, None] * along
    errors = np.where(np.isinf(errors), math.inf, np.sqrt(np.diag(covariance)))
    return covariance, errors, tuple(unknown)


def _table(osc: Oscillator | Structure, layouts: tuple[Layout, ...], residuals: Floats) -> Dataset:
    """Return the residuals as a table."""
    import xarray as xr

    columns: dict[str, list[Any]] = {
        name: [] for name in ("t", "value", "noise", "quantity", "record")
    }
    for number, layout in enumerate(layouts):
        for samples in (layout.record.samples, layout.record.impacts):
            names = [quantity_name(quantity, osc) for quantity in samples.quantities.tolist()]
            columns["t"].append(samples.t)
            columns["value"].append(samples.values)
            columns["noise"].append(samples.noise)
            columns["quantity"].append(np.array(names, dtype=object))
            columns["record"].append(np.full(len(samples), number))
    joined = {name: np.concatenate(parts) for name, parts in columns.items()}
    joined["residual"] = residuals * joined["noise"]
    joined["fitted"] = joined["value"] - joined["residual"]
    return xr.Dataset({name: ("sample", joined[name]) for name in joined})
