"""Pictures of designs: the front between two outcomes."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from percuss.ensembles.measures import MEASURES
from percuss.model.oscillator import Oscillator
from percuss.model.units import Units
from percuss.optimization.pareto import ParetoFront
from percuss.plotting.labels import with_unit
from percuss.plotting.style import BLUE, check_kind, picture, shared_docs, units_of

LINE: dict[str, Any] = {"marker": "o", "markersize": 4.5, "linewidth": 1.0, "color": BLUE}
# Dimensions of the outcomes that are no measures of runs.
OF_ORBIT = {"period": "time", "multiplier": "1", "grazing_margin": "length"}


@shared_docs
def plot_pareto(
    front: ParetoFront,
    ax: Axes | None = None,
    *,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw the designs between two outcomes, the second over the first.

    Parameters
    ----------
    front
        What `percuss.pareto_front` has returned.

    Raises
    ------
    ParameterError
        If it is no front.
    """
    check_kind("front", front, ParetoFront)
    osc = front.designs[0].oscillator
    units = units_of(units, osc)
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        ax.plot(front.values[:, 0], front.values[:, 1], **LINE)
        first, second = front.outcomes
        ax.set_xlabel(_label(first, osc, units))
        ax.set_ylabel(_label(second, osc, units))
    return ax


def _label(name: str, osc: Oscillator, units: Units) -> str:
    dimensions = OF_ORBIT.get(name) or MEASURES[name].dimensions_of(osc)
    return with_unit(name.replace("_", " "), dimensions, units)
