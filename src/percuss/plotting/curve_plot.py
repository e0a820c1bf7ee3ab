"""Curves of special points in two parameters, with the points of codimension two on them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patheffects import withStroke

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.orbits.bifurcations.curve import Curve, CurveKind
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    VERMILION,
    picture,
)

__all__ = ["plot_curves"]


LOOKS: dict[CurveKind, dict[str, Any]] = {
    "fold": {"color": BLUE, "label": "fold"},
    "period_doubling": {"color": VERMILION, "label": "period doubling"},
    "symmetry_breaking": {"color": ORANGE, "label": "symmetry breaking"},
    "grazing": {"color": BLACK, "label": "grazing"},
}
# Curves of orbits that are not physical.
FORMAL = "not physical"
FAINT: dict[str, Any] = {"alpha": 0.5, "linewidth": 1.0, "linestyle": (0, (1, 1.5))}
MARKERS = {
    "cusp": "^",
    "fold_grazing": "o",
    "period_doubling_grazing": "s",
    "symmetry_breaking_grazing": "D",
    "resonant_grazing": "o",
    "double_grazing": "X",
    "degenerate_grazing": "v",
}
# Points of codimension two nearer than this, as parts of the width and height, are named once.
SAME = 1e-3
# Width and height of a new figure [inch].
SIZE = 7.6, 4.4
# Where the legend stands: the curves may go through any part of the plane.
BESIDE = (1.01, 1.0)
# Labels nearer than these parts stand below each other.
NEAR, LINE = (0.3, 0.08), 12.0
# Points beyond these parts of the axes are labelled on their left, and above.
RIGHT, LOW = 0.7, 0.12
RESONANT = "resonant grazing"


def plot_curves(curves: Curve | Iterable[Curve], ax: Axes | None = None) -> Axes:
    """Draw curves in the plane of their two parameters: physical orbits solid, others faint.

    Parameters
    ----------
    curves
        What `percuss.continue_curve` has returned, once or several times, over one pair of
        parameters.
    ax
        Axes to draw on; default: those of a new figure.

    Returns
    -------
    Axes
        The axes; points of codimension two are marked and named.

    Raises
    ------
    ParameterError
        If there is no curve, or they have not the same two parameters.
    """
    several = [curves] if isinstance(curves, Curve) else list(curves)
    if not several:
        raise ParameterError("curves", curves, "none to draw")
    paths = several[0].paths
    for curve in several:
        if curve.paths != paths:
            reason = f"not over the parameters of the first, {paths[0]} and {paths[1]}"
            raise ParameterError("curves", curve.paths, reason)
    with picture(ax, SIZE) as ax:
        for curve in several:
            _draw(ax, curve)
        ax.set_xlabel(paths[0])
        ax.set_ylabel(paths[1])
        _explain(ax)
        _mark(ax, several)
    return ax


def _draw(ax: Axes, curve: Curve) -> None:
    look = dict(LOOKS[curve.kind])
    label = look.pop("label")
    # Curves that touch stay distinct by drawing grazing, which most others touch, below.
    order = 1.9 if curve.kind == "grazing" else 2.0
    for first, last, physical in _stretches(curve):
        known = set(ax.get_legend_handles_labels()[1])
        x, y = curve.values[first : last + 1].T
        more = {} if physical else FAINT
        name = None if label in known or not physical else label
        ax.plot(x, y, label=name, zorder=order, **look, **more)
        if not physical and FORMAL not in known:
            ax.plot([], [], label=FORMAL, color=BLACK, **FAINT)
    if label not in ax.get_legend_handles_labels()[1]:
        ax.plot([], [], label=label, **look)


def _stretches(curve: Curve) -> list[tuple[int, int, bool]]:
    """Return first and last row and kind of each stretch that is drawn in one way.

    A point of codimension two stands between two kinds: there the neighbouring rows decide.
    """
    special = np.zeros(len(curve), dtype=np.bool_)
    special[[point.row for point in curve.special_points]] = True
    flags = curve.admissible
    # Of the stretch from each row to the next.
    kinds = np.where(special[:-1] & ~special[1:], flags[1:], flags[:-1])
    both = special[:-1] & special[1:]
    kinds = np.where(both, flags[:-1] | flags[1:], kinds)
    if len(kinds) == 0:
        return []
    cuts = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist(), len(kinds)]
    return [(i, j, bool(kinds[i])) for i, j in pairwise(cuts)]


def _explain(ax: Axes) -> None:
    handles, labels = ax.get_legend_handles_labels()
    entries = dict(zip(labels, handles, strict=True))
    names = [*(str(look["label"]) for look in LOOKS.values()), FORMAL]
    order = [name for name in names if name in entries]
    ax.legend([entries[name] for name in order], order, loc="upper left", bbox_to_anchor=BESIDE)


def _mark(ax: Axes, curves: Sequence[Curve]) -> None:
    """Mark the points of codimension two; those of several curves at one place are named once."""
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    size = np.array([right - left, top - bottom])
    places: list[tuple[Floats, list[str]]] = []
    for curve in curves:
        for point in curve.special_points:
            at = np.array(point.values)
            name = point.kind.replace("_", " ")
            same = [names for there, names in places if (abs(there - at) < SAME * size).all()]
            if same:
                if name not in same[0]:
                    same[0].append(name)
                continue
            places.append((at, [name]))
            ax.plot(*at, MARKERS[point.kind], color=BLACK, mfc=GREEN, markersize=5.5, zorder=3.0)
    for i, (at, names) in enumerate(places):
        others = [there for there, _ in places[:i]]
        nearby = sum(bool((abs(there - at) < NEAR * size).all()) for there in others)
        part = (at - [left, bottom]) / size
        on_right, low = part[0] > RIGHT, part[1] < LOW
        sign = 1.0 if low else -1.0
        ax.annotate(
            ", ".join(_shown_names(names)),
            (float(at[0]), float(at[1])),
            xytext=(-7.0 if on_right else 7.0, sign * (4.0 + LINE * nearby)),
            textcoords="offset points",
            ha="right" if on_right else "left",
            va="bottom" if low else "top",
            fontsize=8.5,
            path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )


def _shown_names(names: list[str]) -> list[str]:
    """Return the names of a place: a resonant graze is on curves of all three kinds."""
    if RESONANT not in names:
        return names
    return [name for name in names if name not in ("fold grazing", "period doubling grazing")]
