"""Summaries of a fit for files and pictures: the impacts of its motion, intervals of a profile."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from percuss.arrays import Floats
from percuss.fitting.measured import quantity_number
from percuss.fitting.result import Fit
from percuss.fitting.shooting import motion_between, start_at
from percuss.model.paths import replace_parameters
from percuss.motion.simulate import run_of


def impacts_of(fit: Fit) -> dict[str, NDArray[Any]]:
    """Return the impacts and entries into soft stops of the fitted motion, each from its node.

    Parameters
    ----------
    fit
        The fit.

    Returns
    -------
    dict
        Columns of one length: `record`, `t` [time], `stop`, `kind` ("impact" or "entry"),
        `v_before` and `v_after` [length/time], the same for an entry.

    Examples
    --------
    >>> import numpy as np
    >>> import percuss as pc
    >>> ball = pc.Oscillator(0, stops=(pc.Wall(at=0, side="below", restitution=0.5),))
    >>> t = np.linspace(0, 2.3, 30)
    >>> x = pc.simulate(ball, pc.Forcing(constant=-2), x0=1, v0=0, t_end=2.3)(t)[0]
    >>> fit = pc.fit({"t": t, "displacement": x}, ball, pc.Forcing(constant=-2),
    ...              free={"oscillator.stops.0.restitution": 0.6}, start=(1, 0))
    >>> impacts_of(fit)["v_before"].round(9)
    array([-2., -1.])
    """
    rows: list[tuple[int, float, int, str, float, float]] = []
    first = 0
    for number, layout in enumerate(fit.problem.layouts):
        record = layout.record
        osc, force, _ = replace_parameters(fit.problem.osc, record.force, record.start, fit.values)
        nodes = fit.nodes[first : first + len(layout)]
        first += len(layout)
        for node, end in zip(nodes, layout.spans[:, 1].tolist(), strict=True):
            if node[0] >= end:
                continue
            run = run_of(osc, force, start_at(osc, node), t_end=end)
            hits, entries = run.impacts, run.crossings
            rows += [
                (number, *row, "impact", before, after)
                for *row, before, after in zip(
                    hits.t.tolist(), hits.stop.tolist(), hits.v_before.tolist(),
                    hits.v_after.tolist(), strict=True,
                )
            ]  # fmt: skip
            rows += [
                (number, at, stop, "entry", speed, speed)
                for at, stop, speed, direction in zip(
                    entries.t.tolist(), entries.stop.tolist(), entries.v.tolist(),
                    entries.direction.tolist(), strict=True,
                )
                if direction == "in"
            ]  # fmt: skip
    rows.sort(key=lambda row: row[:2])
    columns = list(zip(*rows, strict=True)) or [()] * 6
    kinds = (np.int64, np.float64, np.int64, object, np.float64, np.float64)
    names = ("record", "t", "stop", "kind", "v_before", "v_after")
    return {
        name: np.array(column, dtype=kind)
        for name, column, kind in zip(names, columns, kinds, strict=True)
    }


def motion_of(fit: Fit, quantity: str, t: Floats, record: int = 0) -> Floats:
    """Return a quantity of the fitted motion over any of its records.

    Parameters
    ----------
    fit
        The fit.
    quantity, t
        As `Fit.of` takes them.
    record
        The number of the record.
    """
    layouts = fit.problem.layouts
    layout = layouts[record]
    first = sum(len(before) for before in layouts[:record])
    osc, force, _ = replace_parameters(
        fit.problem.osc, layout.record.force, layout.record.start, fit.values
    )
    number = quantity_number(quantity, osc)
    nodes, end = fit.nodes[first : first + len(layout)], float(layout.spans[-1, 1])
    return motion_between(osc, force, nodes, end, t, [number])[:, 0]


def interval_of(profile: Any, level: float = 1.0) -> tuple[float, float]:
    """Return the values between which a profile stays below a level.

    Parameters
    ----------
    profile
        What `Fit.profile` has returned.
    level
        Of its growth: 1 for 68 per cent, 3.84 for 95.

    Returns
    -------
    tuple of float
        Least and largest value, between its points as of a parabola; infinite where the profile
        does not reach the level, NaN where it has no points.

    Examples
    --------
    >>> import numpy as np
    >>> import xarray as xr
    >>> value = np.linspace(-3, 3, 7)
    >>> profile = xr.Dataset({"growth": ("value", value**2)}, {"value": value})
    >>> interval_of(profile, 4.0)
    (-2.0, 2.0)
    """
    value, growth = profile.value.values, profile.growth.values
    if np.isnan(growth).all():
        return math.nan, math.nan
    middle = int(np.nanargmin(growth))
    ends = []
    for sign in (-1, 1):
        side = slice(middle, None) if sign > 0 else slice(middle, None, -1)
        at, rise = value[side], np.sqrt(np.maximum(growth[side], 0.0))
        above = np.flatnonzero(rise >= math.sqrt(level))
        if not len(above):
            ends.append(sign * math.inf)
            continue
        # The root of a parabola is a line.
        i = int(above[0])
        share = (math.sqrt(level) - rise[i - 1]) / (rise[i] - rise[i - 1]) if i else 0.0
        ends.append(float(at[i - 1] + share * (at[i] - at[i - 1])) if i else float(at[0]))
    return ends[0], ends[1]
