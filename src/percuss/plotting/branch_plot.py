"""Branches of orbits over one parameter, curves of special points over two; points on both."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from percuss.arrays import Flags, Floats, Integers
from percuss.errors import ParameterError
from percuss.model.oscillator import On, Oscillator
from percuss.model.structure import Structure
from percuss.model.system import law
from percuss.model.units import Units
from percuss.orbits.bifurcations.branch import Branch
from percuss.orbits.bifurcations.curve import Curve
from percuss.orbits.bifurcations.structure_branch import AnyBranch, StructureBranch
from percuss.orbits.bifurcations.structure_curve import StructureCurve
from percuss.orbits.orbit.periodic_orbit import PeriodicOrbit
from percuss.orbits.orbit.structure_orbit import StructureOrbit
from percuss.orbits.orbit.turning_points import turning_points_of
from percuss.plotting.direction_view import first_line, line_in_words
from percuss.plotting.labels import parameter_label
from percuss.plotting.style import (
    BLACK,
    BLUE,
    COLOUR_CYCLE,
    GREEN,
    ORANGE,
    VERMILION,
    label_once,
    picture,
    shared_docs,
    units_of,
)

BranchQuantity: TypeAlias = Literal[
    "impact_velocity", "grazing_margin", "multiplier", "period", "amplitude"
]
AnyCurve: TypeAlias = Curve | StructureCurve

# A stretch that is not drawn: its ends meet different numbers of stops, or their nearest turning
# points are not the same one.
GAP = -1
# Where a slope is so many times its neighbours, a turning point may have vanished.
LEAP = 3.0
# Multipliers above this are drawn on a logarithmic axis.
HUGE = 100.0
# Values beyond the first factor times those of nearly all of a parameter's way, a part of it, grow
# without bound, as at a resonance without damping: axes show the second factor times these.
UNBOUNDED, SHOWN, NEARLY_ALL = 1e4, 4.0, 0.95
# How the kinds of orbits are drawn, in the order of the legend.
STABLE, UNSTABLE, FORMAL_STABLE, FORMAL_UNSTABLE = range(4)
LOOKS: dict[int, dict[str, Any]] = {
    STABLE: {"linestyle": "-", "linewidth": 1.6, "label": "stable"},
    UNSTABLE: {"linestyle": (0, (4, 2)), "linewidth": 1.3, "label": "unstable"},
}
FAINT: dict[str, Any] = {"linewidth": 1.0, "alpha": 0.3}
LOOKS[FORMAL_STABLE] = LOOKS[STABLE] | FAINT | {"label": "stable, not physical"}
LOOKS[FORMAL_UNSTABLE] = LOOKS[UNSTABLE] | FAINT | {"label": "unstable, not physical"}
MARKERS = {
    "fold": "o",
    "period_doubling": "s",
    "symmetry_breaking": "D",
    "branch_point": "X",
    "grazing": "v",
    "chatter": "^",
    "corner": "*",
    "strong_resonance": "P",
    "torus": "p",
    "border_collision": "h",
}
# How special points are marked.
POINT_LOOK: dict[str, Any] = {"color": BLACK, "linestyle": "none", "markersize": 4.5, "zorder": 3.0}

CURVE_LOOKS: dict[str, dict[str, Any]] = {
    "fold": {"color": BLUE, "label": "fold"},
    "period_doubling": {"color": VERMILION, "label": "period doubling"},
    "symmetry_breaking": {"color": ORANGE, "label": "symmetry breaking"},
    "grazing": {"color": BLACK, "label": "grazing"},
    "torus": {"color": GREEN, "label": "torus"},
}
# Curves of orbits that are not physical.
FORMAL = "not physical"
DOTTED: dict[str, Any] = {"alpha": 0.5, "linewidth": 1.0, "linestyle": (0, (1, 1.5))}
CURVE_MARKERS = {
    "cusp": "^",
    "fold_grazing": "o",
    "period_doubling_grazing": "s",
    "symmetry_breaking_grazing": "D",
    "resonant_grazing": "o",
    "double_grazing": "X",
    "degenerate_grazing": "v",
    "degenerate_period_doubling": "*",
    "degenerate_symmetry_breaking": "*",
    "fold_doubling": "s",
    "fold_torus": "o",
    "doubling_torus": "D",
    "fold_symmetry_breaking": "o",
    "torus_symmetry_breaking": "D",
    "resonance_1_1": "P",
    "resonance_1_2": "P",
    "resonance_1_3": "P",
    "resonance_1_4": "P",
}
# Points of codimension two nearer than this, as parts of the width and height, are named once.
SAME = 1e-3
# Width and height of a new figure [inch].
CURVES_SIZE = 7.6, 4.4
# Where the legend stands: the curves may go through any part of the plane.
BESIDE = (1.01, 1.0)
# Labels nearer than these parts stand below each other.
CURVE_NEAR, CURVE_LINE = (0.3, 0.08), 12.0
# Points beyond these parts of the axes are labelled on their left, and above.
CURVE_RIGHT, CURVE_LOW = 0.7, 0.12
RESONANT = "resonant grazing"


@shared_docs
def plot_branch(
    branch: AnyBranch | Sequence[AnyBranch],
    ax: Axes | None = None,
    *,
    quantity: BranchQuantity | None = None,
    on: On | None = None,
    coordinate: int | None = None,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
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
        largest modulus; "period", as of limit cycles; "amplitude", of a structure.
        The first two jump where an impact more or less is made: there the line is broken. Default:
        the first, where a branch has no impacts the second, and the third where there is no stop
        either; of a structure the amplitude.
    on
        The coordinate, direction or point of a structure whose amplitude it is; default: the line
        of its first stop.
    coordinate
        In place of `on` the index of a coordinate.

    Returns
    -------
    Axes
        The axes; special points are marked.

    Raises
    ------
    ParameterError
        If there is no such quantity or coordinate, the orbits have no impacts, or the branches are
        none or not over one parameter.
    """
    branches = _branches(branch)
    units = units_of(units, owner_of(branches[0]))
    name = quantity or _default(branches)
    line = _line(branches[0], on, coordinate)
    columns = [_values(each, name, line) for each in branches]
    with picture(ax, labels=(xlabel, ylabel)) as ax:
        for k, (each, values) in enumerate(zip(branches, columns, strict=True)):
            breaks = _breaks(each, name)
            _draw(ax, each, values, COLOUR_CYCLE[k % len(COLOUR_CYCLE)], breaks)
        ax.set_xlabel(parameter_of(branches[0], units))
        ax.set_ylabel(_label(name, units, branches, line))
        together = np.concatenate(columns)
        # Orbits without impacts have a place on the axis, too.
        parameters = np.concatenate([each.values for each in branches])
        ends = float(parameters.min()), float(parameters.max())
        ax.update_datalim([(end, float(np.nanmin(together))) for end in ends])
        ax.autoscale_view(scaley=False)
        if name != "multiplier" and (together < 0.0).any() and (together > 0.0).any():
            ax.axhline(0.0, color=BLACK, linewidth=0.5, zorder=0.5)
        if name == "multiplier" and np.nanmax(together) > HUGE:
            # At a graze it goes to infinity: linear up to the unit circle, logarithmic beyond.
            ax.set_yscale("symlog", linthresh=1.0)
            ax.set_ylim(0.0, 10.0 * max(HUGE, float(np.nanmedian(together))))
        elif math.isfinite(reach := reach_of(branches, columns)):
            low, high = (
                max(float(np.nanmin(together)), -reach),
                min(float(np.nanmax(together)), reach),
            )
            ax.set_ylim(low - 0.05 * (high - low), high)
        _mark(ax, branches, columns)
        _explain(ax, BLACK if len(branches) > 1 else None)
    return ax


def reach_of(branches: Sequence[AnyBranch], columns: Sequence[Floats]) -> float:
    """Return how far from zero an axis shows values, infinite but where they grow without bound."""
    weights, sizes = [], []
    for branch, values in zip(branches, columns, strict=True):
        half = 0.5 * np.abs(np.diff(branch.values))
        is_known = np.isfinite(values)
        weights.append((np.append(half, 0.0) + np.append(0.0, half))[is_known])
        sizes.append(np.abs(values[is_known]))
    weight, size = np.concatenate(weights), np.concatenate(sizes)
    order = np.argsort(size)
    part = np.cumsum(weight[order])
    if len(size) == 0 or part[-1] == 0.0:
        return math.inf
    usual = float(size[order[np.searchsorted(part, NEARLY_ALL * part[-1])]])
    if not size.max() > UNBOUNDED * usual > 0.0:
        return math.inf
    # Where there are motions, what is formal needs no more room than they.
    largest = 0.0
    for branch, values in zip(branches, columns, strict=True):
        largest = float(np.fmax.reduce(np.abs(values[branch.admissible]), initial=largest))
    return SHOWN * (usual if largest == 0.0 else min(usual, largest))


def owner_of(branch: AnyBranch) -> Oscillator | Structure:
    """Return what moves."""
    first = branch.orbits[0]
    return first.structure if isinstance(first, StructureOrbit) else first.oscillator


def parameter_of(branch: AnyBranch, units: Units) -> str:
    """Return the label of the axis of the parameter."""
    return parameter_label(branch.orbits[0], branch.path, units)


def _default(branches: list[AnyBranch]) -> BranchQuantity:
    if any(isinstance(each, StructureBranch) for each in branches):
        return "amplitude"
    has_impacts = all(
        isinstance(each, Branch) and each.impact_velocity.shape[1] > 0 for each in branches
    )
    if has_impacts:
        return "impact_velocity"
    near_stops = any(
        isinstance(each, Branch) and bool(np.isfinite(each.grazing_margin).any())
        for each in branches
    )
    return "grazing_margin" if near_stops else "multiplier"


def _branches(given: AnyBranch | Sequence[AnyBranch]) -> list[AnyBranch]:
    branches = _listed(given, AnyBranch)
    if not branches or not all(isinstance(each, AnyBranch) for each in branches):
        raise ParameterError("branch", given, "neither a branch nor a list of branches")
    paths = sorted({each.path for each in branches})
    if len(paths) > 1:
        reason = f"branches over different parameters, {' and '.join(paths)}"
        raise ParameterError("branch", given, reason)
    return branches


def _listed(given: Any, kind: Any) -> list[Any]:
    """Return what is given as a list: one, several, or what is refused."""
    return [given] if isinstance(given, kind) or not isinstance(given, Iterable) else list(given)


def _breaks(branch: AnyBranch, name: BranchQuantity) -> Flags:
    """Return between which neighbouring rows a quantity is discontinuous."""
    if isinstance(branch, StructureBranch) or name in ("multiplier", "period"):
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
    end = orbit.t0 + orbit.period
    own_law = law(orbit.oscillator, orbit.forcing)
    return len(turning_points_of(own_law, *orbit.record, orbit.x0, end).t)


def _draw(ax: Axes, branch: AnyBranch, values: Floats, colour: str, breaks: Flags) -> None:
    kinds = _kinds(branch)
    kinds[breaks] = GAP
    for rows, kind in stretches(kinds):
        if kind != GAP:
            look = LOOKS[kind] | {"label": label_once(ax, LOOKS[kind]["label"])}
            ax.plot(branch.values[rows], values[rows], color=colour, **look)


def _explain(ax: Axes, colour: str | None) -> None:
    """Add the legend; with a colour its lines have that, as it holds for all of them."""
    handles, labels = ax.get_legend_handles_labels()
    entries = dict(zip(labels, handles, strict=True))
    looks = [look for look in LOOKS.values() if look["label"] in entries]
    order = [str(look["label"]) for look in looks]
    shown = [entries[label] for label in order]
    if colour is not None:
        shown = [Line2D([], [], color=colour, **look) for look in looks]
    marked = [name for name in map(_name_of, MARKERS) if name in entries]
    shown += [entries[name] for name in marked]
    # Over the line at zero.
    ax.legend(shown, order + marked, loc="best", frameon=True, framealpha=1.0, edgecolor="none")


def _line(branch: AnyBranch, on: On | None, coordinate: int | None) -> On | None:
    """Return the displacement of a structure that is drawn; None for an oscillator's own."""
    if on is not None and coordinate is not None:
        raise ParameterError("coordinate", coordinate, f"given together with on = {on!r}; give one")
    if not isinstance(branch, StructureBranch):
        if on is not None:
            raise ParameterError(
                "on", on, "given for branches of an oscillator, which has one displacement"
            )
        return None
    n = branch.amplitude.shape[1]
    if coordinate is not None and not 0 <= coordinate < n:
        raise ParameterError("coordinate", coordinate, f"the coordinates are 0 to {n - 1}")
    line = on if coordinate is None else coordinate
    return first_line(branch.orbits[0].structure) if line is None else line


def _values(branch: AnyBranch, name: BranchQuantity, line: On | None) -> Floats:
    if isinstance(branch, StructureBranch):
        if name == "multiplier":
            return np.asarray(np.abs(branch.multipliers).max(axis=1))
        if name != "amplitude":
            raise ParameterError("quantity", name, "none of amplitude and multiplier")
        assert line is not None
        return branch.amplitude_of(line)
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
    if name == "period":
        return branch.period
    reason = "none of impact_velocity, grazing_margin, multiplier and period"
    raise ParameterError("quantity", name, reason)


def _label(name: BranchQuantity, units: Units, branches: list[AnyBranch], line: On | None) -> str:
    if name == "amplitude" and line is not None:
        which = line_in_words(_structure_of(branches[0]), line)
        return f"amplitude of {which} ({units.displacement})"
    if name == "impact_velocity":
        # With sticking there is no least one, and a branch holds the largest.
        sticks = {math.isinf(each.orbits[0].n_impacts) for each in branches}
        which = "" if len(sticks) > 1 else "largest " if True in sticks else "least "
        return f"{which}impact velocity ({units.velocity})"
    if name == "grazing_margin":
        return f"distance to grazing ({units.displacement})"
    if name == "period":
        return f"period ({units.duration})"
    largest = "larger" if line is None else "largest"
    return f"modulus of the {largest} multiplier"


def _structure_of(branch: AnyBranch) -> Structure:
    owner = owner_of(branch)
    assert isinstance(owner, Structure)
    return owner


def _kinds(branch: AnyBranch) -> Integers:
    """Return how the stretch from each row to the next is drawn."""
    physical = between_rows(branch.admissible, branch)
    stable = between_rows(drawn_as_stable(branch), branch)
    return np.where(physical, STABLE, FORMAL_STABLE) + ~stable


def drawn_as_stable(branch: AnyBranch) -> Flags:
    """Return which orbits are drawn as stable: elliptic ones, too."""
    return np.isin(branch.stability, ["asymptotic", "elliptic"])


def between_rows(flags: Flags, followed: AnyBranch | AnyCurve) -> Flags:
    """Return whether the stretch from each row to the next has a property of the rows.

    It has where both rows have. A special point stands between two kinds: there the neighbouring
    row decides, and between two special points one row is enough.
    """
    special = np.zeros(len(flags), dtype=np.bool_)
    special[[point.row for point in followed.special_points]] = True
    left, right = flags[:-1], flags[1:]
    between = np.where(special[:-1], np.where(special[1:], left | right, right), left & right)
    return np.asarray(np.where(special[1:] & ~special[:-1], left, between))


def stretches(kinds: Integers | Flags) -> list[tuple[slice, int]]:
    """Return the rows and the kind of each run of equal kinds between neighbouring rows."""
    if kinds.size == 0:
        return []
    cuts = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist(), len(kinds)]
    return [(slice(i, j + 1), int(kinds[i])) for i, j in pairwise(cuts)]


def _mark(ax: Axes, branches: list[AnyBranch], columns: list[Floats]) -> None:
    """Mark the special points; the legend says what the marks are."""
    for branch, values in zip(branches, columns, strict=True):
        for point in branch.special_points:
            y = float(values[point.row])
            if np.isfinite(y):
                name = label_once(ax, _name_of(point.kind))
                ax.plot([point.value], [y], MARKERS[point.kind], label=name, **POINT_LOOK)


def _name_point(
    ax: Axes, text: str, at: tuple[float, float], rise: float, *, on_right: bool, **look: Any
) -> None:
    """Write the name of a special point beside it, on the side away from the nearer edge."""
    ax.annotate(
        text, at, xytext=(-7.0 if on_right else 7.0, rise), textcoords="offset points",
        ha="right" if on_right else "left", **{"fontsize": 9.0} | look,
    )  # fmt: skip


@shared_docs
def plot_curves(
    curves: AnyCurve | Iterable[AnyCurve],
    ax: Axes | None = None,
    *,
    units: Units | None = None,
    xlabel: str | None = None,
    ylabel: str | None = None,
) -> Axes:
    """Draw curves in the plane of their two parameters: physical orbits solid, others faint.

    Parameters
    ----------
    curves
        What `percuss.continue_curve` has returned, once or several times, over one pair of
        parameters.

    Returns
    -------
    Axes
        The axes; points of codimension two are marked and named.

    Raises
    ------
    ParameterError
        If there is no curve, or they have not the same two parameters.
    """
    several = _listed(curves, AnyCurve)
    if not several:
        raise ParameterError("curves", curves, "none to draw")
    if not all(isinstance(curve, AnyCurve) for curve in several):
        raise ParameterError("curves", curves, "neither a curve nor a list of curves")
    paths = several[0].paths
    for curve in several:
        if curve.paths != paths:
            reason = f"not over the parameters of the first, {paths[0]} and {paths[1]}"
            raise ParameterError("curves", curve.paths, reason)
    with picture(ax, CURVES_SIZE, labels=(xlabel, ylabel)) as ax:
        for curve in several:
            _draw_curve(ax, curve)
        first = several[0]
        orbit: PeriodicOrbit | StructureOrbit = first.orbits[0]
        owner = orbit.structure if isinstance(orbit, StructureOrbit) else orbit.oscillator
        own = units_of(units, owner)
        over, up = (parameter_label(orbit, path, own) for path in paths)
        ax.set_xlabel(over)
        ax.set_ylabel(up)
        _explain_curves(ax)
        _mark_curves(ax, several)
    return ax


def _draw_curve(ax: Axes, curve: AnyCurve) -> None:
    look = dict(CURVE_LOOKS[curve.kind])
    label = look.pop("label")
    # Curves that touch stay distinct by drawing grazing, which most others touch, below.
    order = 1.9 if curve.kind == "grazing" else 2.0
    for rows, physical in stretches(between_rows(curve.admissible, curve)):
        name, more = (label_once(ax, label), {}) if physical else (None, DOTTED)
        ax.plot(*curve.values[rows].T, label=name, zorder=order, **look, **more)
        if not physical and label_once(ax, FORMAL):
            ax.plot([], [], label=FORMAL, color=BLACK, **DOTTED)
    if label_once(ax, label):
        ax.plot([], [], label=label, **look)


def _explain_curves(ax: Axes) -> None:
    handles, labels = ax.get_legend_handles_labels()
    entries = dict(zip(labels, handles, strict=True))
    names = [*(str(look["label"]) for look in CURVE_LOOKS.values()), FORMAL]
    order = [name for name in names if name in entries]
    ax.legend([entries[name] for name in order], order, loc="upper left", bbox_to_anchor=BESIDE)


def _mark_curves(ax: Axes, curves: Sequence[AnyCurve]) -> None:
    """Mark the points of codimension two; those of several curves at one place are named once."""
    (left, right), (bottom, top) = ax.get_xlim(), ax.get_ylim()
    size = np.array([right - left, top - bottom])
    places: list[tuple[Floats, list[str]]] = []
    for curve in curves:
        for point in curve.special_points:
            at = np.array(point.values)
            name = _name_of(point.kind)
            same = [names for place, names in places if (abs(place - at) < SAME * size).all()]
            if same:
                if name not in same[0]:
                    same[0].append(name)
                continue
            places.append((at, [name]))
            ax.plot(
                *at, CURVE_MARKERS[point.kind], color=BLACK, mfc=GREEN, markersize=5.5, zorder=3.0
            )
    for i, (at, names) in enumerate(places):
        earlier = [place for place, _ in places[:i]]
        nearby = sum(bool((abs(place - at) < CURVE_NEAR * size).all()) for place in earlier)
        part = (at - [left, bottom]) / size
        on_right, low = part[0] > CURVE_RIGHT, part[1] < CURVE_LOW
        sign = 1.0 if low else -1.0
        _name_point(
            ax, ", ".join(_shown_names(names)), (float(at[0]), float(at[1])),
            sign * (4.0 + CURVE_LINE * nearby), on_right=on_right, va="bottom" if low else "top",
            fontsize=8.5, path_effects=[withStroke(linewidth=2.5, foreground="white")],
        )  # fmt: skip


def _name_of(kind: str) -> str:
    """Return a kind of points in words: a resonance with its ratio."""
    words = kind.split("_")
    return f"1:{words[2]}" if words[0] == "resonance" else " ".join(words)


def _shown_names(names: list[str]) -> list[str]:
    """Return the names of a place: a resonant graze is on curves of all three kinds."""
    if RESONANT not in names:
        return names
    return [name for name in names if name not in ("fold grazing", "period doubling grazing")]
