"""The phase portrait of a periodic orbit."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from percuss.errors import ParameterError
from percuss.model.exact import as_float
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit, counted
from percuss.plotting.jumps import draw_jumps
from percuss.plotting.samples import Curve, sample_curve, window_of
from percuss.plotting.stops import draw_rest_points, draw_stops, stop_places
from percuss.plotting.style import BLUE, Units, axes_for, draw_legend, fix_ticks, style, units_of

Floats = npt.NDArray[np.float64]


def plot_orbit(orbit: PeriodicOrbit, ax: Axes | None = None, *, units: Units | None = None) -> Axes:
    """Draw a periodic orbit: velocity over displacement, with its stops.

    Impacts are dashed jumps. What a formal orbit does beyond a wall, or beyond the edge of a
    soft stop that it does not notice, is drawn faint and dashed.

    Parameters
    ----------
    orbit
        The orbit.
    ax
        Axes to draw on; default: those of a new figure.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes; the title tells impacts, periods, stability. Those of a new figure have a
        legend.

    Raises
    ------
    ParameterError
        If it is no `PeriodicOrbit`.
    """
    if not isinstance(orbit, PeriodicOrbit):
        raise ParameterError("orbit", orbit, "not a PeriodicOrbit")
    units = units_of(units)
    run = orbit.trajectory()
    low, high = window_of(run, None)
    curve = sample_curve(run, (low, high))
    with style():
        is_alone, ax = ax is None, axes_for(ax)
        t, x, v = _broken_at_jumps(curve)
        beyond = _beyond(orbit, t, x)
        ax.plot(np.where(beyond, np.nan, x), v, color=BLUE, linewidth=1.5, label="orbit")
        if beyond.any():
            near = beyond | np.roll(beyond, 1) | np.roll(beyond, -1)
            ax.plot(
                np.where(near, x, np.nan), v, color=BLUE, linewidth=1.2, alpha=0.45,
                linestyle=(0, (4, 2)), label="passes through a stop",
            )  # fmt: skip
        impacts = run.impacts
        if len(impacts):
            places = stop_places(run, impacts.stop)
            draw_jumps(ax, places, impacts.v_before, impacts.v_after)
        draw_stops(ax, run, curve.x, "x")
        draw_rest_points(ax, run, low, high)
        ax.set_xlabel(f"displacement $x$ ({units.displacement})")
        ax.set_ylabel(f"velocity $v$ ({units.velocity})")
        ax.set_title(_title(orbit, units))
        fix_ticks(ax)
        if is_alone:
            draw_legend(ax.figure, [ax])
    return ax


def _title(orbit: PeriodicOrbit, units: Units) -> str:
    met = "sticking" if math.isinf(orbit.n_impacts) else counted(orbit.n_impacts, "impact")
    turns = f" in {counted(orbit.n_periods, 'forcing period')}" if orbit.n_periods else ""
    unit = f" {units.duration}" if units.time else ""
    formal = "" if orbit.admissible else ", not physical"
    return f"{met}{turns}, T = {orbit.period:.6g}{unit}, {orbit.stability}{formal}"


def _broken_at_jumps(curve: Curve) -> tuple[Floats, Floats, Floats]:
    """Return t, x and v with a gap after each sample that a jump follows."""
    after = np.flatnonzero(curve.jumps[:-1]) + 1
    t, x, v = (np.insert(values, after, np.nan) for values in (curve.t, curve.x, curve.v))
    return t, x, v


def _beyond(orbit: PeriodicOrbit, t: Floats, x: Floats) -> npt.NDArray[np.bool_]:
    """Tell which samples of a formal orbit lie beyond a stop while it passes through that."""
    found = np.zeros(len(x), dtype=np.bool_)
    if orbit.admissible:
        return found
    passages = orbit.passages
    for instant, i in zip(passages.t, passages.stop, strict=True):
        stop = orbit.oscillator.stops[int(i)]
        place = as_float(stop.at)
        outside = x < place if stop.side == "below" else x > place
        # The samples without a gap around the instant.
        edges = np.flatnonzero(np.diff(outside.astype(np.int8), prepend=0, append=0))
        for first, last in edges.reshape(-1, 2):
            if np.nanmin(t[first:last]) <= instant <= np.nanmax(t[max(first - 1, 0) : last + 1]):
                found[first:last] = True
    return found
