"""Branches of periodic orbits over their parameter, with their special points."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.model.law import law
from percuss.orbits.bifurcations.branch import Branch
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.turning_points import turns_of
from percuss.plotting.style import (
    BLACK,
    BLUE,
    GREEN,
    ORANGE,
    PURPLE,
    SKY_BLUE,
    VERMILION,
    Units,
    picture,
    units_of,
)

BranchQuantity: TypeAlias = Literal["impact_velocity", "grazing_margin", "multiplier"]

# Of several branches, in turn.
COLOURS = (BLUE, VERMILION, GREEN, PURPLE, ORANGE, SKY_BLUE)
# A stretch that is not drawn: its ends meet different numbers of stops, or their nearest turning
# points are not the same one.
GAP = -1
# Slopes so many times their neighbours are looked at for a turning point that vanishes.
LEAP = 3.0
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
# Labels of special points nearer than these parts of the width and height stand below each other,
# above each other where they are in this part of the height.
NEAR, LINE, LOW = (0.25, 0.12), 13.0, 0.15


def plot_branch(
    branch: Branch | Sequence[Branch],
    ax: Axes | None = None,
    *,
    quantity: BranchQuantity | None = None,
    units: Units | None = None,
) -> Axes:
    """Draw a branch: stable orbits solid, unstable ones dashed, those that are not physical faint.

    Parameters
    ----------
    branch
        What `percuss.continue_orbit` has returned, or several of them over one parameter, which
        have colours of their own.
    ax
        Axes to draw on; default: those of a new figure. Several branches may share them.
    quantity
        What to draw over the parameter: "impact_velocity", the least one into a stop;
        "grazing_margin", the least distance of a turning point to a stop; "multiplier", the
        largest modulus. The first two jump where an impact more or less is made: there the line
        is broken. Default: the first, or where a branch has no impacts the second.
    units
        Units on the axes; default: dimensionless.

    Returns
    -------
    Axes
        The axes; special points are marked and labelled.

    Raises
    ------
    ParameterError
        If there is no such quantity, the orbits have no impacts, or the branches are none or not
        over one parameter.
    """
    branches = _branches(branch)
    units = units_of(units)
    has_impacts = all(each.impact_velocity.shape[1] > 0 for each in branches)
    name = quantity or ("impact_velocity" if has_impacts else "grazing_margin")
    columns = [_values(each, name) for each in branches]
    with picture(ax) as ax:
        for k, (each, values) in enumerate(zip(branches, columns, strict=True)):
            breaks = _breaks(each, name)
            _draw(ax, each, values, COLOURS[k % len(COLOURS)], breaks)
        ax.set_xlabel(branches[0].path)
        ax.set_ylabel(_label(name, units, branches))
        together = np.concatenate(columns)
        if name != "multiplier" and (together < 0.0).any() and (together > 0.0).any():
            ax.axhline(0.0, color=BLACK, linewidth=0.5, zorder=0.5)
        _mark(ax, branches, columns)
        _explain(ax, BLACK if len(branches) > 1 else None)
    return ax


def _branches(given: Branch | Sequence[Branch]) -> list[Branch]:
    found = [given] if isinstance(given, Branch) else list(given)
    if not found or not all(isinstance(each, Branch) for each in found):
        raise ParameterError("branch", given, "neither a branch nor a list of branches")
    paths = sorted({each.path for each in found})
    if len(paths) > 1:
        reason = f"branches over different parameters, {' and '.join(paths)}"
        raise ParameterError("branch", given, reason)
    return found


def _breaks(branch: Branch, name: BranchQuantity) -> Flags:
    """Return between which neighbouring rows a quantity is discontinuous."""
    if name == "multiplier":
        return np.zeros(len(branch) - 1, dtype=np.bool_)
    met = (~np.isnan(branch.impact_velocity)).sum(axis=1)
    breaks = np.diff(met) != 0
    if name == "grazing_margin":
        for row in np.flatnonzero(_leaps(branch)).tolist():
            # A turning point that is the nearest vanishes with a neighbour.
            breaks[row] |= _turns(branch[row]) != _turns(branch[row + 1])
    return np.asarray(breaks)


def _leaps(branch: Branch) -> Flags:
    """Return between which rows the distance to grazing changes much faster than around them."""
    margin = np.where(np.isfinite(branch.grazing_margin), branch.grazing_margin, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        slopes = np.abs(np.diff(margin) / np.diff(branch.arclength))
    slopes = np.nan_to_num(slopes, nan=0.0, posinf=0.0)
    around = np.concatenate([[0.0], slopes, [0.0]])
    return np.asarray(slopes > LEAP * np.maximum(around[:-2], around[2:]))


def _turns(orbit: PeriodicOrbit) -> int:
    """Return how many turning points the flights of an orbit have."""
    table = law(orbit.oscillator, orbit.forcing)
    end = orbit.t0 + orbit.period
    return len(turns_of(table, *orbit.record, orbit.x0, end).t)


def _draw(ax: Axes, branch: Branch, values: Floats, colour: str, breaks: Flags) -> None:
    kinds = _kinds(branch)
    kinds[breaks] = GAP
    known = set(ax.get_legend_handles_labels()[1])
    for first, last in _stretches(kinds):
        if kinds[first] == GAP:
            continue
        look = dict(LOOKS[int(kinds[first])])
        if look.get("label") in known:
            del look["label"]
        known.add(look.get("label", ""))
        part = slice(first, last + 2)
        ax.plot(branch.values[part], values[part], color=colour, **look)


def _explain(ax: Axes, colour: str | None) -> None:
    """Add the legend; with a colour its lines have that, as it holds for all of them."""
    handles, labels = ax.get_legend_handles_labels()
    entries = dict(zip(labels, handles, strict=True))
    looks = [look for look in LOOKS.values() if look["label"] in entries]
    order = [str(look["label"]) for look in looks]
    shown = [entries[label] for label in order]
    if colour is not None:
        shown = [Line2D([], [], color=colour, **look) for look in looks]
    ax.legend(shown, order, loc="best")


def _values(branch: Branch, name: BranchQuantity) -> Floats:
    if name == "impact_velocity":
        if branch.impact_velocity.shape[1] == 0:
            raise ParameterError("quantity", name, "the orbits have no impacts")
        # Where fewer stops are met a row ends with NaN; where none is, it holds nothing else.
        met = np.where(np.isnan(branch.impact_velocity), np.inf, branch.impact_velocity)
        least = met.min(axis=1)
        return np.where(np.isinf(least), np.nan, least)
    if name == "grazing_margin":
        finite = np.isfinite(branch.grazing_margin)
        return np.where(finite, branch.grazing_margin, np.nan)
    if name == "multiplier":
        return np.asarray(np.abs(branch.multipliers).max(axis=1))
    reason = "none of impact_velocity, grazing_margin and multiplier"
    raise ParameterError("quantity", name, reason)


def _label(name: BranchQuantity, units: Units, branches: list[Branch]) -> str:
    if name == "impact_velocity":
        # With sticking there is no least one, and a branch holds the largest.
        sticks = {math.isinf(each[0].n_impacts) for each in branches}
        which = "" if len(sticks) > 1 else "largest " if True in sticks else "least "
        return f"{which}impact velocity ({units.velocity})"
    if name == "grazing_margin":
        return f"distance to grazing ({units.displacement})"
    return "modulus of the larger multiplier"


def _kinds(branch: Branch) -> Integers:
    """Return how the stretch from each row to the next is drawn.

    A special point stands between two kinds: there the neighbouring row decides.
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


def _stretches(kinds: Integers) -> list[tuple[int, int]]:
    """Return first and last index of each run of equal numbers."""
    if kinds.size == 0:
        return []
    cuts = np.flatnonzero(np.diff(kinds)) + 1
    firsts = [0, *cuts.tolist()]
    return [(i, j - 1) for i, j in zip(firsts, [*firsts[1:], len(kinds)], strict=True)]


def _mark(ax: Axes, branches: list[Branch], columns: list[Floats]) -> None:
    x_all = np.concatenate([branch.values for branch in branches])
    y_all = np.concatenate(columns)
    wide = float(np.ptp(x_all)) or 1.0
    high = float(np.nanmax(y_all) - np.nanmin(y_all)) or 1.0
    middle = 0.5 * float(x_all.max() + x_all.min())
    placed: list[tuple[float, float, str]] = []
    for branch, values in zip(branches, columns, strict=True):
        for point in branch.special_points:
            x, y = point.value, float(values[point.row])
            if not np.isfinite(y):
                continue
            ax.plot([x], [y], MARKERS[point.kind], color=BLACK, markersize=4.5)
            neighbours = [
                kind
                for u, w, kind in placed
                if abs(x - u) < NEAR[0] * wide and abs(y - w) < NEAR[1] * high
            ]
            if point.kind in neighbours:
                # One label serves all of a kind that stand together.
                continue
            placed.append((x, y, point.kind))
            # Below the others, or near the axis above them.
            step = LINE if y - float(np.nanmin(y_all)) < LOW * high else -LINE
            on_right = x > middle + 0.25 * wide
            ax.annotate(
                point.kind.replace("_", " "),
                (x, y),
                xytext=(-7.0 if on_right else 7.0, 3.0 + step * len(neighbours)),
                textcoords="offset points",
                ha="right" if on_right else "left",
                fontsize=9.0,
            )
