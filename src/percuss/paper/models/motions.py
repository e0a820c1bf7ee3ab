"""The motions behind the figures, and their data as columns of a dataset."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from percuss import numerics
from percuss.arrays import Floats
from percuss.io.study_text import motion_text
from percuss.model.exact import Exact, as_float
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator, bilinear_oscillator, impact_oscillator
from percuss.motion.simulate import simulate
from percuss.motion.trajectory import Trajectory
from percuss.paper.models.runge_kutta import SteppedMotion, runge_kutta
from percuss.plotting.samples import sample_curve

if TYPE_CHECKING:
    from xarray import Dataset

TableColumn = tuple[str, NDArray[Any], dict[str, str]]

# The paper gives "w-/w+ = 2e4"; the square is not excluded.
STIFFNESS_BELOW = {"stiff": 4e8, "soft": 2e4}
MODEL_LABELS = {
    "limit": "impact oscillator, the limit",
    "stiff": r"bilinear, $\omega_-/\omega_+ = 2\cdot 10^4$",
    "soft": r"bilinear, $\omega_-^2/\omega_+^2 = 2\cdot 10^4$",
    "steps": r"bilinear, $\omega_-/\omega_+ = 2\cdot 10^4$, by Runge-Kutta",
}
# The article does not state its tolerance; this one is coarse enough to show.
STEP_TOLERANCE = 1e-2
# Of the 2^20 points of the paper so many are kept.
STEP_POINTS = 2**14


def oscillators() -> dict[str, Oscillator]:
    """Return the impact oscillator and the bilinear ones of the paper's own computations.

    Returns
    -------
    dict
        "limit", the impact oscillator; "stiff" and "soft", the bilinear oscillator with the
        printed 2e4 read as a ratio of frequencies and of their squares.

    Examples
    --------
    >>> list(oscillators())
    ['limit', 'stiff', 'soft']
    """
    bilinear = {
        name: bilinear_oscillator(stiffness_above=1, stiffness_below=below)
        for name, below in STIFFNESS_BELOW.items()
    }
    return {"limit": impact_oscillator(), **bilinear}


@cache
def simulate_all(force: Forcing, v0: Exact, t_end: Exact) -> dict[str, Trajectory]:
    """Return the motion from x = 0 of the three oscillators under one force.

    Parameters
    ----------
    force
        The force, in the paper's dimensionless units.
    v0
        Velocity at the start.
    t_end
        Time of the end.

    Returns
    -------
    dict
        A run for each of `oscillators`.
    """
    return {
        name: simulate(osc, force, x0=0, v0=v0, t_end=t_end) for name, osc in oscillators().items()
    }


def impact_speeds(run: Trajectory) -> tuple[Floats, Floats]:
    """Return when a motion hits its stop, and how fast it leaves it.

    Parameters
    ----------
    run
        A run with one stop, rigid or soft.

    Returns
    -------
    tuple of array
        Times of the impacts, or of the entries into a soft stop, and the velocities V_k after
        them; the two are as long only where every entry is followed by an exit.
    """
    if len(run.impacts):
        return run.impacts.t, run.impacts.v_after
    crossings = run.crossings
    entries = crossings.direction == "in"
    return crossings.t[entries], crossings.v[crossings.direction == "out"]


@cache
def step_through(force: Forcing, v0: Exact, t_end: Exact) -> SteppedMotion:
    """Return the motion of the stiff bilinear oscillator as the article computed it, by steps.

    Parameters
    ----------
    force
        A force of one harmonic of amplitude 1.
    v0, t_end
        As in `simulate_all`.

    Returns
    -------
    SteppedMotion
        A part of the 2^20 points, equally spaced.
    """
    (part,) = force.components()
    motion = runge_kutta(
        STIFFNESS_BELOW["stiff"],
        float(part.omega),
        numerics.atan2(-part.sin, part.cos),
        v0=as_float(v0),
        t_end=as_float(t_end),
        tolerance=STEP_TOLERANCE,
    )
    few = slice(None, None, (motion.t.size - 1) // STEP_POINTS)
    return SteppedMotion(motion.t[few], motion.x[few], motion.v[few], motion.n_steps)


def step_columns(name: str, motion: SteppedMotion) -> dict[str, TableColumn]:
    """Return a motion by steps as columns like those of `motion_dataset`, without impacts."""
    point = f"{name}_point"
    values = {"t": motion.t, "x": motion.x, "v": motion.v}
    return {f"{what}_{name}": (point, column, {}) for what, column in values.items()}


def motion_dataset(runs: Mapping[str, Trajectory], **parameters: float | str) -> Dataset:
    """Return runs as columns: the motion between its events, and the impacts.

    Parameters
    ----------
    runs
        Runs by name.
    **parameters
        What else to note among the attributes.

    Returns
    -------
    xarray.Dataset
        For each name: t, x, v over ``<name>_point`` (both limits at an impact, between which
        ``jump`` is 1), impact_t over ``<name>_impact`` and impact_v over ``<name>_exit``. The
        attributes ``study_<name>`` repeat the runs.

    Examples
    --------
    >>> import percuss as pc
    >>> run = pc.simulate(pc.impact_oscillator(), pc.sine(2), v0=1, t_end=7.0)
    >>> data = motion_dataset({"limit": run}, v0=1.0)
    >>> data.impact_v_limit.values.round(12).tolist()
    [2.333333333333, 3.666666666667]
    """
    import xarray as xr

    data: dict[str, TableColumn] = {}
    for name, run in runs.items():
        curve = sample_curve(run)
        times, speeds = impact_speeds(run)
        point, impact, leaving = (f"{name}_{what}" for what in ("point", "impact", "exit"))
        data |= {
            f"t_{name}": (point, curve.t, {"long_name": "time"}),
            f"x_{name}": (point, curve.x, {"long_name": "displacement"}),
            f"v_{name}": (point, curve.v, {"long_name": "velocity"}),
            f"jump_{name}": (point, curve.jumps.astype(np.int8), {"long_name": "velocity jumps"}),
            f"impact_t_{name}": (impact, times, {"long_name": "time of an impact"}),
            f"impact_v_{name}": (leaving, speeds, {"long_name": "velocity after an impact"}),
        }
    studies = {f"study_{name}": motion_text(run) for name, run in runs.items()}
    return xr.Dataset(data, attrs={**parameters, **studies})
