"""The tables of a fit: parameters, covariance, residuals, impacts, profiles, motion."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from percuss.io.column_units import Columns
from percuss.model.dimensions import unit_of_setting
from percuss.model.oscillator import Oscillator
from percuss.model.units import is_unit

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.fitting.result import Fit


def fitted_columns(fit: Fit) -> Columns:
    """Return the parameters as a table: value, error, unit and ends of the range of each."""
    units = [unit_of_setting(path, fit.oscillator, fit.forcing) for path in fit.values]
    return {
        "parameter": _asked(fit),
        "value": np.array(list(fit.values.values())),
        "error": np.array(list(fit.errors.values())),
        "unit": np.array([unit if is_unit(unit) else "" for unit in units], dtype=object),
        "least": np.array(fit.problem.low),
        "largest": np.array(fit.problem.high),
        "at_bound": np.array([path in fit.at_bounds for path in fit.values]),
    }


def covariance_columns(fit: Fit) -> Columns:
    """Return the covariance as a table, a row and a column for each parameter."""
    names = _asked(fit)
    return {"parameter": names, **dict(zip(names.tolist(), fit.covariance.T, strict=True))}


def _asked(fit: Fit) -> Any:
    """Return the parameters by the names that they were asked for by."""
    return np.array([fit.values.asked.get(path, path) for path in fit.values], dtype=object)


def residual_columns(fit: Fit) -> Columns:
    """Return each value with what the model says, and the difference."""
    names = ("record", "quantity", "t", "value", "fitted", "residual", "noise")
    return {name: np.asarray(fit.residuals[name].values) for name in names}


def fit_impact_columns(fit: Fit) -> Columns:
    """Return the impacts and entries into soft stops of all records."""
    from percuss.fitting.summaries import impacts_of

    return impacts_of(fit)


def profile_columns(fit: Fit) -> Columns:
    """Return the profiles one below the other: all parameters, and how the misfit grows."""
    asked = dict(zip(fit.values, _asked(fit).tolist(), strict=True))
    parts: dict[str, list[Any]] = {"profile": [], **{name: [] for name in asked.values()}}
    parts["growth"] = []
    for path, profile in fit.profiles.items():
        parts["profile"] += [asked[path]] * profile.sizes["value"]
        parts["growth"] += profile.growth.values.tolist()
        for other, name in asked.items():
            own = profile.value if other == path else profile[other]
            parts[name] += own.values.tolist()
    return {
        name: np.array(column, dtype=object if name == "profile" else np.float64)
        for name, column in parts.items()
    }


def _states(fit: Fit) -> tuple[NDArray[Any], ...]:
    """Return t, x and v of the nodes; of a structure x and v have a column for each coordinate."""
    if isinstance(fit.oscillator, Oscillator):
        t, x, v = fit.nodes.T
        return t, x, v
    n = fit.oscillator.n
    return fit.nodes[:, 0], fit.nodes[:, 1 : n + 1], fit.nodes[:, n + 1 :]


def fit_datasets(fit: Fit, samples: int) -> dict[str, Dataset]:
    """Return a fit as datasets by the names of their groups, the parameters at the root.

    Parameters
    ----------
    fit
        The fit.
    samples
        Number of equally spaced times of its motion.
    """
    import xarray as xr

    columns = {name if name != "parameter" else "path": column
               for name, column in fitted_columns(fit).items()}  # fmt: skip
    main = xr.Dataset({name: ("parameter", column) for name, column in columns.items()})
    main["covariance"] = (("parameter", "other"), fit.covariance)
    main.attrs = {
        "chi2": fit.chi2,
        "whiteness": fit.whiteness,
        "converged": int(fit.converged),
        "reason": fit.reason,
        "n_runs": fit.n_runs,
        "at_bounds": ", ".join(fit.values.asked.get(path, path) for path in fit.at_bounds),
    }
    t = np.linspace(fit.nodes[0, 0], float(fit.problem.layouts[0].spans[-1, 1]), samples)
    x, v = fit(t)
    tables = {
        "residuals": residual_columns(fit),
        "impacts": fit_impact_columns(fit),
        "nodes": dict(zip("txv", _states(fit), strict=True)),
        "motion": {"t": t, "x": x, "v": v},
    }
    if fit.profiles:
        tables["profiles"] = profile_columns(fit)
    dims = {
        "residuals": "sample_of_record",
        "impacts": "impact",
        "nodes": "node",
        "motion": "sample",
    }
    groups = {
        name: xr.Dataset(
            {
                # Of a structure x and v have a number for each coordinate.
                key: ((dims.get(name, "row"), "coordinate")[: column.ndim], column)
                for key, column in table.items()
            }
        )
        for name, table in tables.items()
    }
    return {"/": main, **{f"/{name}": group for name, group in groups.items()}}
