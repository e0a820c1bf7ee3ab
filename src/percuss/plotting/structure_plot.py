"""Pictures of structures: several coordinates over one time, and the shapes of modes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.figure import Figure

from percuss.errors import ParameterError
from percuss.model.oscillator import On
from percuss.model.structure import Structure
from percuss.model.units import Units
from percuss.motion.structures import StructureTrajectory
from percuss.numerics import cholesky, inverse, matmul
from percuss.numerics.modes import symmetric_modes
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.plotting.direction_view import direction_name, shown_lines
from percuss.plotting.motion_plot import plot_displacement
from percuss.plotting.style import (
    BLUE,
    GREY,
    check_kind,
    draw_legend,
    fix_ticks,
    given_figure,
    shared_docs,
    style,
    title_figure,
    units_of,
)

# Panels of one figure; more would be too low to be read.
MOST_PANELS = 12
HEIGHT = 1.5
# Places along the axis of mode shapes that are chosen.
MOST_SHOWN = 1000


@shared_docs
def plot_coordinates(
    run: StructureTrajectory | StructureOrbit,
    figure: Figure | None = None,
    *,
    on: On | Sequence[On] | None = None,
    window: tuple[float, float] | None = None,
    units: Units | None = None,
    title: str | None = None,
) -> Figure:
    """Draw several displacements of a structure, one below the other over the same time.

    Parameters
    ----------
    run
        The run, or an orbit over its period.
    on
        Coordinates, directions and names of points; default: all points, or where the structure has
        none all coordinates.
    units
        Units on the axes; default: those of the structure, or dimensionless.
    title
        Title of the figure.

    Returns
    -------
    Figure
        The figure, a panel for each displacement with the stops on its line.

    Raises
    ------
    ParameterError
        If there is no such coordinate or direction, or there are more than 12.
    """
    run = run.run if isinstance(run, StructureOrbit) else run
    check_kind("run", run, StructureTrajectory)
    shown = shown_lines(run.structure, on, MOST_PANELS, "panels")
    units = units_of(units, run.structure)
    with style(is_own=figure is None):
        figure = given_figure(figure, 8.0, 1.0 + HEIGHT * len(shown))
        panels = figure.subplots(len(shown), 1, sharex=True, squeeze=False)[:, 0]
        for ax, direction in zip(panels, shown, strict=True):
            plot_displacement(run, ax, window=window, units=units, on=direction)
            name = direction_name(run.structure, direction)
            ax.set_ylabel(f"${name}$ ({units.length})" if units.length else f"${name}$")
            ax.label_outer()
        figure.align_ylabels()
        if title:
            title_figure(figure, title)
        draw_legend(figure, panels)
    return figure


@shared_docs
def plot_mode_shapes(
    structure: Structure,
    figure: Figure | None = None,
    *,
    n: int | None = None,
    on: Sequence[On] | None = None,
    units: Units | None = None,
) -> Figure:
    """Draw the undamped modes of a structure that touches no stop.

    Parameters
    ----------
    structure
        The structure; its stiffness is symmetric.
    n
        Number of modes, the slowest first; default: up to 6.
    on
        The coordinates, directions and points, in the order of the picture, such as the deflections
        of a beam without its rotations; default: all coordinates.
    units
        Units of the frequencies; default: those of the structure, or dimensionless.

    Returns
    -------
    Figure
        The figure: a panel for each mode, its amplitudes at what is shown, the largest 1, with
        its angular frequency. At a negative square of it the rate of growth is given.

    Raises
    ------
    ParameterError
        If the stiffness is not symmetric, there are not so many modes, or no such coordinate.
    """
    check_kind("structure", structure, Structure)
    stiffness = structure.stiffness_matrix
    if not np.array_equal(stiffness, stiffness.T):
        reason = "not symmetric; its modes are complex and have no one shape"
        raise ParameterError("structure.stiffness", structure.stiffness, reason)
    count = min(structure.n, 6) if n is None else n
    if not 1 <= count <= min(structure.n, MOST_PANELS):
        reason = f"not 1 to {min(structure.n, MOST_PANELS)}, the modes that there are to be drawn"
        raise ParameterError("n", n, reason)
    back = inverse(cholesky(structure.mass_matrix)[0])
    squares, rows = symmetric_modes(matmul(matmul(back, stiffness), back.T))
    lines = (
        list(range(structure.n)) if on is None else shown_lines(structure, on, MOST_SHOWN, "places")
    )
    directions = np.array([structure.direction(line) for line in lines])
    shapes = matmul(matmul(rows, back), directions.T)
    units = units_of(units, structure)
    per_time = f"1/{units.time}" if units.time else "dimensionless"
    with style(is_own=figure is None):
        figure = given_figure(figure, 6.4, 1.0 + 1.2 * count)
        panels = figure.subplots(count, 1, sharex=True, squeeze=False)[:, 0]
        places = np.arange(len(lines))
        largest = max(float(np.abs(squares).max()), 1e-300)
        for i, ax in enumerate(panels):
            peak = shapes[i, int(np.argmax(np.abs(shapes[i])))] or 1.0
            ax.axhline(0.0, color=GREY, linewidth=0.7)
            ax.plot(places, shapes[i] / peak, "o-", color=BLUE, linewidth=1.3, markersize=4.5)
            ax.set_ylim(-1.2, 1.2)
            square = 0.0 if abs(squares[i]) < 1e-13 * largest else float(squares[i])
            name = "free" if square == 0.0 else rf"$\omega = {abs(square) ** 0.5:.5g}$ ({per_time})"
            if square < 0.0:
                name = f"grows at {abs(square) ** 0.5:.5g} ({per_time})"
            ax.set_title(f"mode {i + 1}: {name}", loc="left", fontsize="small")
            fix_ticks(ax)
        shown = places if len(lines) <= 20 else places[:: len(lines) // 10]
        names = [f"${direction_name(structure, lines[i])}$" for i in shown.tolist()]
        are_indices = all(isinstance(line, int) for line in lines)
        panels[-1].set_xlabel("coordinate" if are_indices else "")
        panels[-1].set_xticks(shown, [str(lines[i]) for i in shown] if are_indices else names)
        figure.supylabel("amplitude", fontsize="medium")
    return figure
