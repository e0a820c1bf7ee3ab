"""Pictures of sections: singularity sets and manifolds."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from matplotlib.axes import Axes

from percuss.arrays import Floats
from percuss.model.exact import as_float
from percuss.model.oscillator import On, Stop, Wall
from percuss.model.units import Units
from percuss.orbits.surface.manifolds import Manifolds
from percuss.orbits.surface.singularity_set import SingularityCurve, SingularitySet
from percuss.orbits.surface.structure_manifolds import StructureManifolds
from percuss.plotting.direction_view import first_line, names_of, view_of
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    GREY,
    ORANGE,
    PURPLE,
    SKY_BLUE,
    VERMILION,
    check_kind,
    label_once,
    label_phase_plane,
    picture,
    shared_docs,
    units_of,
)

# Colours of the iterates of a singularity set, and lines of the stops that are touched.
ITERATES = (BLACK, BLUE, ORANGE, GREEN, PURPLE, SKY_BLUE, VERMILION)
LINES = ("-", (0, (5, 2)), (0, (1, 1.5)), (0, (4, 1.5, 1, 1.5)))
KINDS = {"unstable": VERMILION, "stable": BLUE}


@shared_docs
def plot_singularity_set(
    found: SingularitySet,
    ax: Axes | None = None,
    *,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw the curves of a singularity set in the impact surface, a colour an iterate.

    Curves of grazing contacts with other stops than the set's own have lines of their own.

    Parameters
    ----------
    found
        What `percuss.singularity_set` has returned.

    Raises
    ------
    ParameterError
        If it is no `SingularitySet`.
    """
    check_kind("found", found, SingularitySet)
    units = units_of(units, found.oscillator)
    several = len({curve.touched for curve in found}) > 1
    is_alone = ax is None
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        for curve in sorted(found, key=lambda curve: -curve.iterate):
            look = LINES[0] if curve.touched == found.stop else LINES[1 + curve.touched % 3]
            label = _label(curve, several=several)
            for cycle, v in _in_the_cycle(curve):
                ax.plot(
                    cycle, v, color=ITERATES[(curve.iterate - 1) % len(ITERATES)], linestyle=look,
                    linewidth=1.4 if curve.iterate == 1 else 1.0,
                    label=label_once(ax, label),
                )  # fmt: skip
        label_impact_surface(ax, units)
        explain(ax, alone=is_alone)
    return ax


def _label(curve: SingularityCurve, *, several: bool) -> str:
    what = f"touch of stop {curve.touched}" if several else "touch"
    return f"{what} at impact {curve.iterate}"


def _in_the_cycle(curve: SingularityCurve) -> list[tuple[Floats, Floats]]:
    """Return the parts of a curve in each cycle that it enters, moved to [0, 1]."""
    first, last = int(np.floor(curve.cycle.min())), int(np.floor(curve.cycle.max()))
    parts = []
    for whole in range(first, last + 1):
        cycle = curve.cycle - whole
        inside = (cycle >= 0.0) & (cycle <= 1.0)
        # With one neighbour beyond each edge the line goes on to it; the axes cut it off.
        near = inside | np.append(inside[1:], False) | np.append(False, inside[:-1])
        if near.any():
            parts.append((np.where(near, cycle, np.nan), curve.v_after))
    return parts


@shared_docs
def plot_manifolds(
    found: Manifolds | StructureManifolds,
    ax: Axes | None = None,
    *,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
    on: On | None = None,
) -> Axes:
    """Draw the manifolds of a saddle orbit in their section: stable ones blue, unstable ones red.

    Parameters
    ----------
    found
        What `percuss.manifolds` has returned.
    on
        Of a structure the coordinate, direction or point in whose plane of displacement and
        velocity the curves are drawn; default: the line of its first stop.

    Returns
    -------
    Axes
        The axes; the saddle is marked.

    Raises
    ------
    ParameterError
        If it is no `Manifolds`, or there is no such coordinate.
    """
    if isinstance(found, StructureManifolds):
        return _plot_projected(found, ax, units, (xlabel, ylabel), on)
    check_kind("found", found, Manifolds)
    units, is_alone = units_of(units, found.orbit.oscillator), ax is None
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        for kind, colour in KINDS.items():
            pieces = [p for b in found.branches if b.kind == kind for p in b.pieces]
            if not pieces:
                continue
            x, y = _with_gaps(pieces, wraps=found.section == "impact").T
            label = label_once(ax, f"{kind} manifold")
            ax.plot(x, y, color=colour, linewidth=0.8, label=label, rasterized=x.size > 20_000)
        label = label_once(ax, "saddle")
        ax.plot(*found.saddles.T, "o", color=BLACK, markersize=5.0, zorder=3.0, label=label)
        if found.section == "impact":
            label_impact_surface(ax, units)
        else:
            _draw_stops(ax, found.orbit.oscillator.stops)
            label_phase_plane(ax, units)
            ax.set_title(f"once a forcing period, at cycle {found.cycle:g}")
        explain(ax, alone=is_alone)
    return ax


def _plot_projected(
    found: StructureManifolds,
    ax: Axes | None,
    units: Units | None,
    labels: tuple[str | None, str | None],
    on: On | None,
) -> Axes:
    """Draw the unstable manifold of a structure in the plane of one displacement."""
    structure, view = found.orbit.structure, view_of(found.orbit, on)
    on = first_line(structure) if on is None else on
    units, is_alone, n = units_of(units, view.oscillator), ax is None, structure.n
    c = structure.direction(on)
    with picture(ax, labels=labels) as ax:
        x, v = _with_gaps(found.displacement(on), wraps=False).T
        label = label_once(ax, "unstable manifold")
        ax.plot(x, v, color=KINDS["unstable"], linewidth=0.8, label=label)
        places = ((part * c).sum(axis=1) for part in (found.saddles[:, :n], found.saddles[:, n:]))
        label = label_once(ax, "saddle")
        ax.plot(*places, "o", color=BLACK, markersize=5.0, zorder=3.0, label=label)
        _draw_stops(ax, view.oscillator.stops)
        label_phase_plane(ax, units, names_of(view))
        ax.set_title(f"once a period of the loads, at cycle {found.cycle:g}")
        explain(ax, alone=is_alone)
    return ax


def _draw_stops(ax: Axes, stops: Sequence[Stop]) -> None:
    """Draw the stops within the picture as lines."""
    low, high = ax.get_xlim()
    for stop in stops:
        if low <= as_float(stop.at) <= high:
            colour = GREY if isinstance(stop, Wall) else ORANGE
            ax.axvline(as_float(stop.at), color=colour, linewidth=0.8, zorder=0.8)


def _with_gaps(pieces: list[Floats], *, wraps: bool) -> Floats:
    """Return all pieces as one line with gaps between them, and where a cycle begins anew."""
    rows: list[Floats] = []
    gap = np.full((1, 2), np.nan)
    for piece in pieces:
        leaps = np.abs(np.diff(piece[:, 0])) > 0.5
        cuts = np.flatnonzero(leaps & wraps) + 1
        for part in np.split(piece, cuts):
            rows += [part, gap]
    return np.concatenate(rows)


def label_impact_surface(ax: Axes, units: Units) -> None:
    """Label the axes of an impact surface."""
    ax.set_xlim(0.0, 1.0)
    ax.set_xlabel("cycle of the impact ($t$/period, mod 1)")
    ax.set_ylabel(f"velocity after it ({units.velocity})")


def explain(ax: Axes, *, alone: bool) -> None:
    """Add the legend: below the picture where it is alone in its figure."""
    handles, labels = ax.get_legend_handles_labels()
    order = np.lexsort((labels, [_rank(label) for label in labels]))
    entries = [handles[i] for i in order], [labels[i] for i in order]
    figure = ax.figure
    # What is drawn onto a picture with its legend below joins that legend.
    below = alone or (len(figure.axes) == 1 and len(figure.legends) == 1)
    if below and labels:
        for legend in list(figure.legends):
            legend.remove()
        figure.legend(*entries, loc="outside lower center", ncols=min(len(labels), 3))
    elif labels:
        ax.legend(*entries, loc="best")


def _rank(label: str) -> int:
    """Return the place of a label in the legend."""
    order = ("saddle", "unstable", "stable", "touch", "loop")
    return next((i for i, word in enumerate(order) if label.startswith(word)), len(order))
