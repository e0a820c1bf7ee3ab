"""The jump of the velocity at an impact: a vertical dashed line."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from matplotlib.artist import allow_rasterization
from matplotlib.axes import Axes
from matplotlib.backend_bases import RendererBase
from matplotlib.collections import LineCollection

from percuss.plotting.style import BLUE

Floats = npt.NDArray[np.float64]

# Length of a dash and of a gap [point].
DASH, GAP = 3.2, 2.2


class Jumps(LineCollection):
    """Vertical dashed lines whose dashes fall on the same heights.

    In a phase portrait all impacts on one stop lie on one another: dashes counted from the start
    of each line would fill each other's gaps and look solid.
    """

    @allow_rasterization  # type: ignore[untyped-decorator]
    def draw(self, renderer: RendererBase) -> None:
        """Draw the lines; the offsets follow the size and the limits of the axes."""
        bottoms = [np.asarray(path.vertices)[0] for path in self.get_paths()]
        figure = self.get_figure(root=True)
        if bottoms and figure is not None:
            heights = self.get_transform().transform(np.array(bottoms))[:, 1]
            points = heights * 72.0 / figure.dpi
            offsets = np.nan_to_num(np.mod(points, DASH + GAP))
            self.set_linestyle([(float(offset), (DASH, GAP)) for offset in offsets])
        super().draw(renderer)


def draw_jumps(ax: Axes, at: Floats, before: Floats, after: Floats, **options: Any) -> Jumps:
    """Draw the jumps of the velocity from `before` to `after` at the abscissas `at`.

    Parameters
    ----------
    ax
        The axes.
    at, before, after
        (n,) arrays.
    **options
        Properties of the collection.

    Returns
    -------
    Jumps
        One line for each impact.
    """
    low, high = np.minimum(before, after), np.maximum(before, after)
    lines = np.stack([np.column_stack([at, low]), np.column_stack([at, high])], axis=1)
    # A width of 1 keeps dashes in points: matplotlib scales them with the width.
    jumps = Jumps(list(lines), colors=BLUE, linewidths=1.0, linestyles=(0, (DASH, GAP)), **options)
    jumps.set_label("impact")
    jumps.set_capstyle("butt")
    ax.add_collection(jumps)
    ax.autoscale_view()
    return jumps
