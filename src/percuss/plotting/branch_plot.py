"""A branch of periodic orbits over its parameter, with its special points."""

from __future__ import annotations

from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes

from percuss.errors import ParameterError
from percuss.orbits.families.branch import Branch
from percuss.plotting.style import BLACK, BLUE, Units, axes_for, fix_ticks, style, units_of

Floats = npt.NDArray[np.float64]
Quantity: TypeAlias = Literal["impact_velocity", "grazing_margin", "multiplier"]

# How the kinds of orbits are drawn, in the order of the legend.
STABLE, UNSTABLE, FORMAL_STABLE, FORMAL_UNSTABLE = range(4)
LOOKS: dict[int, dict[str, Any]] = {
    STABLE: {"linestyle": "-", "linewidth": 1.6, "label": "stable"},
    UNSTABLE: {"linestyle": (0, (4, 2)), "linewidth": 1.3, "label": "unstable"},
    FORMAL_STABLE: {
        "linestyle": "-",
        "linewidth": 1.0,
        "alpha": 0.3,
        "label": "stable, not physical",
    },
    FORMAL_UNSTABLE: {
        "linestyle": (0, (4, 2)),
        "linewidth": 1.0,
        "alpha": 0.3,
        "label": "unstable, not physical",
    },
}
MARKERS = {
    "fold": "o",
    "period_doubling": "s",
    "symmetry_breaking": "D",
    "branch_point": "X",
    "grazing": "v",
    "chatter": "^",
    "corner": "*",
    "strong_resonance": "P",
}
# Labels of special points nearer than these parts of the width and height stand below each other.
NEAR, LINE = (0.25, 0.12), 13.0


def plot_branch(
    branch: Branch,
    ax: Axes | None = None,
    *,
    quantity: Quantity | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw a branch: stable orbits solid, unstable ones dashed, those that are not physical faint.

    Parameters
    ----------
    branch
        What `percuss.continue_orbit` has returned.
    ax
        Axes to draw on; default: those of a new figure. Several branches may share them.
    quantity
        What to draw over the parameter: "impact_velocity", the least one into a stop;
        "grazing_margin", the least distance of a turning point to a stop; "multiplier", the
        largest modulus. Default: the first, or without impacts the second.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes; special points are marked and labelled.

    Raises
    ------
    ParameterError
        If there is no such quantity, or the orbits have no impacts.
    """
    units = units_of(units)
    name, values = _values(branch, quantity)
    kinds = _kinds(branch)
    with style():
        ax = axes_for(ax)
        known = set(ax.get_legend_handles_labels()[1])
        for first, last in _stretches(kinds):
            look = dict(LOOKS[int(kinds[first])])
            if look.get("label") in known:
                del look["label"]
            known.add(look.get("label", ""))
            part = slice(first, last + 2)
            ax.plot(branch.values[part], values[part], color=BLUE, **look)
        ax.set_xlabel(branch.path)
        ax.set_ylabel(_label(name, units))
        if name != "multiplier" and values.min() < 0.0 < values.max():
            ax.axhline(0.0, color=BLACK, linewidth=0.5, zorder=0.5)
        _mark(ax, branch, values)
        _explain(ax)
        fix_ticks(ax)
    return ax


def _explain(ax: Axes) -> None:
    handles, labels = ax.get_legend_handles_labels()
    entries = dict(zip(labels, handles, strict=True))
    order = [str(look["label"]) for look in LOOKS.values() if look.get("label") in entries]
    ax.legend([entries[label] for label in order], order, loc="best")


def _values(branch: Branch, quantity: Quantity | None) -> tuple[Quantity, Floats]:
    has_impacts = branch.impact_velocity.shape[1] > 0
    name = quantity or ("impact_velocity" if has_impacts else "grazing_margin")
    if name == "impact_velocity":
        if not has_impacts:
            raise ParameterError("quantity", name, "the orbits have no impacts")
        # Where fewer stops are met a row ends with NaN; where none is, it holds nothing else.
        met = np.where(np.isnan(branch.impact_velocity), np.inf, branch.impact_velocity)
        least = met.min(axis=1)
        return name, np.where(np.isinf(least), np.nan, least)
    if name == "grazing_margin":
        finite = np.isfinite(branch.grazing_margin)
        return name, np.where(finite, branch.grazing_margin, np.nan)
    if name == "multiplier":
        return name, np.abs(branch.multipliers).max(axis=1)
    reason = "none of impact_velocity, grazing_margin and multiplier"
    raise ParameterError("quantity", quantity, reason)


def _label(name: Quantity, units: Units) -> str:
    if name == "impact_velocity":
        return f"least impact velocity ({units.velocity})"
    if name == "grazing_margin":
        return f"distance to grazing ({units.displacement})"
    return "modulus of the larger multiplier"


def _kinds(branch: Branch) -> npt.NDArray[np.int64]:
    """Return how the stretch from each row to the next is drawn.

    A special point stands between two kinds: there the row beside it tells.
    """
    stable = np.isin(branch.stability, ["asymptotic", "elliptic"])
    special = np.zeros(len(branch), dtype=np.bool_)
    special[[point.row for point in branch.special_points]] = True
    found = []
    for flags in (stable, branch.admissible):
        left, right = flags[:-1], flags[1:]
        either = np.where(special[:-1] == special[1:], left | right, left)
        found.append(np.where(special[:-1] & ~special[1:], right, either))
    return np.where(found[1], STABLE, FORMAL_STABLE) + np.where(found[0], 0, 1)


def _stretches(kinds: npt.NDArray[np.int64]) -> list[tuple[int, int]]:
    """Return first and last index of each run of equal numbers."""
    if kinds.size == 0:
        return []
    cuts = np.flatnonzero(np.diff(kinds)) + 1
    firsts = [0, *cuts.tolist()]
    return [(i, j - 1) for i, j in zip(firsts, [*firsts[1:], len(kinds)], strict=True)]


def _mark(ax: Axes, branch: Branch, values: Floats) -> None:
    wide = float(np.ptp(branch.values)) or 1.0
    high = float(np.nanmax(values) - np.nanmin(values)) or 1.0
    middle = 0.5 * float(branch.values.max() + branch.values.min())
    placed: list[tuple[float, float, str]] = []
    for point in branch.special_points:
        x, y = point.value, float(values[point.row])
        if not np.isfinite(y):
            continue
        ax.plot([x], [y], MARKERS[point.kind], color=BLACK, markersize=4.5)
        beside = [
            kind
            for u, w, kind in placed
            if abs(x - u) < NEAR[0] * wide and abs(y - w) < NEAR[1] * high
        ]
        if point.kind in beside:
            # One label tells for all of a kind that stand together.
            continue
        placed.append((x, y, point.kind))
        on_right = x > middle + 0.25 * wide
        ax.annotate(
            point.kind.replace("_", " "),
            (x, y),
            xytext=(-7.0 if on_right else 7.0, 3.0 - LINE * len(beside)),
            textcoords="offset points",
            ha="right" if on_right else "left",
            fontsize=9.0,
        )
