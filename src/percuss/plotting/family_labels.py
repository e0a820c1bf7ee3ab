"""Labels of curves that lie on no curve and on no other label."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

__all__ = ["place_labels"]

Floats = npt.NDArray[np.float64]
Label = tuple[str, str, Floats, npt.NDArray[np.bool_]]

SIZE = 8.5
# Width of a letter and height of a line, as parts of the size of the font.
WIDE, HIGH = 0.56, 1.15
# Points of a curve at which its label is tried, and distances of its middle from them [lines].
TRIED, DISTANCES = 48, (0.95, 1.5, 2.3)
DIRECTIONS = ((0, 1), (0, -1), (1, 0), (-1, 0), (1, 1), (-1, 1), (1, -1), (-1, -1))
# Curves are taken as points at most so far apart; points farther than the second are two curves.
DENSE, TORN = 2.5, 80.0
# What it costs to cover a point of a curve, to be a line farther off, to stand at a worse place,
# and to stand at the foot of a curve and not at its top.
COVERED, FARTHER, WORSE, FOOT = 1.0, 0.4, 3.0, 2.0


def place_labels(ax: Axes, labels: list[Label], curves: list[Floats]) -> None:
    """Write a label beside each curve, where it covers least.

    Parameters
    ----------
    ax
        The axes, with their final limits.
    labels
        Text, colour, (n, 2) array of the points of the curve, and which of them are better.
    curves
        (n, 2) arrays, all that is not to be covered.
    """
    # In points of 1/72 inch, as offsets of texts are.
    figure = ax.get_figure(root=True)
    assert figure is not None
    # It gives the axes the place that they will have.
    figure.draw_without_rendering()
    scale = 72.0 / figure.dpi
    box = ax.get_window_extent()
    frame = scale * np.array([box.x0, box.y0, box.x1, box.y1])
    drawn = [scale * _dense(ax.transData.transform(curve)) for curve in curves if len(curve)]
    everything = np.concatenate(drawn) if drawn else np.empty((0, 2))
    taken: list[Floats] = []
    # Short curves have the least choice.
    for text, colour, points, better in sorted(labels, key=lambda label: len(label[2])):
        found = _best(scale, ax, text, points, better, everything, frame, taken)
        if found is None:
            continue
        anchor, offset, space = found
        taken.append(space)
        ax.annotate(text, anchor, xytext=offset, textcoords="offset points", ha="center",
                    va="center", fontsize=SIZE, color=colour, zorder=4.0,
                    annotation_clip=True)  # fmt: skip


def _dense(points: Floats) -> Floats:
    steps = np.diff(points, axis=0)
    far = np.abs(steps).max(axis=1)
    # What is far apart are two curves.
    near = far < TORN
    each = np.maximum(np.ceil(far[near] / DENSE).astype(int), 1)
    rows = np.repeat(np.flatnonzero(near), each)
    parts = np.concatenate([[], *(np.arange(n) / n for n in each)])[:, np.newaxis]
    return np.concatenate([points[rows] + parts * steps[rows], points])


def _best(
    scale: float,
    ax: Axes,
    text: str,
    points: Floats,
    better: npt.NDArray[np.bool_],
    everything: Floats,
    frame: Floats,
    taken: list[Floats],
) -> tuple[tuple[float, float], tuple[float, float], Floats] | None:
    """Return anchor, offset and space of the place that costs least, None if there is none."""
    half = 0.5 * SIZE * np.array([WIDE * len(text), HIGH])
    rows = np.unique(np.linspace(0, len(points) - 1, TRIED).round().astype(int))
    places = scale * ax.transData.transform(points[rows])
    top, height = places[:, 1].max(), float(np.ptp(places[:, 1])) or 1.0
    found, least = None, np.inf
    for row, place in zip(rows, places, strict=True):
        for distance in DISTANCES:
            for direction in DIRECTIONS:
                offset = np.array(direction) * (half + (distance - 0.5) * 0.5 * SIZE)
                middle = place + offset
                space = np.concatenate([middle - half, middle + half])
                if (space[:2] < frame[:2]).any() or (space[2:] > frame[2:]).any():
                    continue
                if any((space[:2] < it[2:]).all() and (it[:2] < space[2:]).all() for it in taken):
                    continue
                inside = (np.abs(everything - middle) < half).all(axis=1).sum()
                cost = COVERED * inside + FARTHER * distance
                cost += WORSE * (not better[row]) + FOOT * (top - place[1]) / height
                if cost < least:
                    least = cost
                    anchor = float(points[row, 0]), float(points[row, 1])
                    found = anchor, (float(offset[0]), float(offset[1])), space
    return found
