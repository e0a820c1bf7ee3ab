"""Pictures of designs: where in their ranges the parameters are, and the front of two outcomes."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes

from percuss.ensembles.measures import outcome_dimensions
from percuss.model.oscillator import Oscillator
from percuss.model.structure import Structure
from percuss.model.units import Units
from percuss.optimization.design import Design
from percuss.optimization.pareto import ParetoFront
from percuss.plotting.labels import label_of, with_unit
from percuss.plotting.style import BLACK, BLUE, GREY, check_kind, picture, shared_docs, units_of

LINE: dict[str, Any] = {"marker": "o", "markersize": 4.5, "linewidth": 1.0, "color": BLUE}
BEST: dict[str, Any] = {"marker": "o", "markersize": 6.5, "color": BLUE}
OTHERS: dict[str, Any] = {"marker": "o", "markersize": 6.0, "markeredgecolor": BLACK,
                          "markerfacecolor": "none", "linestyle": "none"}  # fmt: skip
BESIDE: dict[str, Any] = {"textcoords": "offset points", "fontsize": "small"}


@shared_docs
def plot_design(
    design: Design,
    ax: Axes | None = None,
    *,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw the best value of each free parameter within its range, and where other searches ended.

    Each range is a line from its least to its largest value, which stand at its ends.

    Parameters
    ----------
    design
        What `percuss.design` has returned.

    Raises
    ------
    ParameterError
        If it is no design.
    """
    check_kind("design", design, Design)
    osc, paths = design.oscillator, list(design.values)
    units = units_of(units, osc)
    with picture(ax, (6.4, 0.8 + 0.7 * len(paths)), labels=(xlabel, ylabel)) as ax:
        for row, path in enumerate(paths):
            low, high = design.bounds[path]
            ends = [search.values[path] for search in design.attempts[1:]]
            place = (design.values[path] - low) / (high - low)
            ax.plot([0.0, 1.0], [row, row], color=GREY, linewidth=1.0)
            ax.plot([(end - low) / (high - low) for end in ends], [row] * len(ends), **OTHERS)
            ax.plot([place], [row], **BEST)
            ax.annotate(
                f"{design.values[path]:.6g}", (place, row), xytext=(0.0, 7.0), ha="center", **BESIDE
            )
            ax.annotate(f"{low:.6g}", (0.0, row), xytext=(-8.0, -3.0), ha="right", **BESIDE)
            ax.annotate(f"{high:.6g}", (1.0, row), xytext=(8.0, -3.0), ha="left", **BESIDE)
            name = label_of(osc, design.forcing, path, units) if "." in path else path
            ax.annotate(name, (0.5, row), xytext=(0.0, -15.0), ha="center", **BESIDE)
        ax.set(xticks=[], yticks=[], xlim=(-0.08, 1.08), ylim=(len(paths) - 0.4, -0.6))
        ax.spines[:].set_visible(False)
        goal = f"{design.goal} " if isinstance(design.goal, str) else ""
        ax.set_xlabel(f"{goal}{_label(design.outcome, osc, units)}: {design.value:.6g}")
    return ax


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


def _label(name: str, osc: Oscillator | Structure, units: Units) -> str:
    return with_unit(name.replace("_", " "), outcome_dimensions(name, osc), units)
