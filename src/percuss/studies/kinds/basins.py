"""Studies of basins of attraction."""

from __future__ import annotations

import math
from contextlib import suppress
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import Field

from percuss.errors import PercussError
from percuss.io.study_text import number
from percuss.model.exact import Exact, as_float
from percuss.model.exact import Phase as PhaseValue
from percuss.model.faults import phase_faults, positive_faults
from percuss.model.stops import Wall
from percuss.studies.axes import Axis, axis_table, axis_values, own_axes
from percuss.studies.kinds.many import Whole, means_of
from percuss.studies.kinds.orbit import counted, impacts_in_words
from percuss.studies.parts import Parts, add_faults, exact_phase
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import Document, DrawTable, Number, Phase, Table

if TYPE_CHECKING:
    from xarray import Dataset

    from percuss.orbits import Manifolds
    from percuss.studies.study import Study

__all__ = ["KIND", "Basins"]

PLACES, IMPACTS = ("x0", "v0"), ("cycle", "v")
# Impacts and periods of a round of the saddles whose manifolds are drawn.
MOST_ROUNDS = 2
NO_AXES = "missing; give x0 and v0, or cycle and v of impacts"


class BasinsTable(Table):
    """``[basins]``: the grid of the starts, and how long they are followed."""

    x0: object = None
    v0: object = None
    cycle: object = None
    v: object = None
    stop: Whole = 0
    t0: Phase = 0.0
    # Motions are followed forty periods at a time.
    periods: Annotated[int, Field(ge=40)] = 1000
    escape: Number = 1e6


class BasinsDrawTable(DrawTable):
    """``[draw]`` of basins."""

    manifolds: bool = False


class BasinsDocument(Document):
    """A study file of basins."""

    basins: BasinsTable
    draw: BasinsDrawTable = BasinsDrawTable()


@dataclass(frozen=True, slots=True)
class Basins:
    """To which attractor each start of a grid goes, as `percuss.basins` takes it.

    Parameters
    ----------
    axes
        x0 and v0, or cycle and v.
    stop, t0, periods, escape
        As there.
    """

    kind: ClassVar[str] = "basins"
    doing: ClassVar[str] = "following the starts"
    stem: ClassVar[str] = "basins"
    is_ensemble: ClassVar[bool] = True

    axes: dict[str, Axis]
    stop: int = 0
    t0: PhaseValue = 0.0
    periods: int = 1000
    escape: Exact = 1e6

    def tables(self) -> dict[str, object]:
        """Return ``[basins]``."""
        own = {"stop": self.stop, "t0": number(self.t0), "periods": self.periods}
        axes = {name: axis_table(axis) for name, axis in self.axes.items()}
        return {"basins": {**axes, **own, "escape": number(self.escape)}}

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return one row a start, and one an attractor."""
        return {"basins": "table", "attractors": "attractors"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return the basins in the plane of the starts."""
        return {"basins": _draw}

    def answer(self, study: Study, means: Means) -> Dataset:
        """Follow the starts."""
        from percuss.ensembles import basins

        axes: dict[str, Any] = {name: list(axis_values(axis)) for name, axis in self.axes.items()}
        return basins(
            study.oscillator,
            study.forcing,
            **axes,
            stop=self.stop,
            t0=self.t0,
            periods=self.periods,
            escape=as_float(self.escape),
            **means_of(means),
        )

    def report(self, result: Dataset) -> dict[str, str]:
        """Tell the attractors and how many of the starts go to each."""
        basin = result.basin.values
        inside = int((basin == -2).sum())
        rows = {"starts": f"{basin.size - inside:,}"}
        rows |= {"inside a wall": f"{inside:,} of {basin.size:,}"} if inside else {}
        for i in range(result.sizes["attractor"]):
            one = result.isel(attractor=i)
            fraction, error = float(one.fraction), float(one.fraction_error)
            rows[f"attractor {i}"] = f"{_words(one)}: {fraction:.4%} +- {error:.1%} of the starts"
        undecided = float(result.attrs["undecided"])
        return rows | ({"undecided": f"{undecided:.4%}"} if inside < basin.size else {})


def _words(one: Dataset) -> str:
    kind = str(one.kind.values)
    if kind != "periodic":
        return kind
    count = impacts_in_words(float(one.n_impacts))
    return f"{count} in {counted(int(one.n_periods), 'forcing period')}"


def _draw(result: Dataset, study: Study, figure: Any) -> None:
    from percuss.plotting import Units, plot_basins

    figure.set_size_inches(7.4, 5.6)
    curves = _manifolds(study) if study.draw.manifolds else ()
    units = Units(study.draw.length_unit, study.draw.time_unit)
    plot_basins(result, figure.add_subplot(), manifolds=curves, units=units)
    figure.suptitle(study.title, parse_math=False)


def _manifolds(study: Study) -> list[Manifolds]:
    """Return the stable manifolds of the saddles, which bound the basins."""
    from percuss.orbits import find_orbits, manifolds

    question = study.question
    # Studies of basins alone come here, with a period.
    assert isinstance(question, Basins)
    assert study.forcing is not None
    assert study.forcing.period is not None
    at_wall = "cycle" in question.axes
    cycle = (as_float(question.t0) / study.forcing.period) % 1.0
    found = []
    for orbit in find_orbits(study.oscillator, study.forcing, MOST_ROUNDS, MOST_ROUNDS):
        inside, outside = sorted(abs(orbit.multipliers))
        if not 0.0 < inside < 1.0 < outside:
            continue
        # Where one cannot be grown, the basins are worth a picture without it.
        with suppress(PercussError):
            found.append(
                manifolds(
                    orbit,
                    section="impact" if at_wall else "stroboscopic",
                    cycle=0.0 if at_wall else cycle,
                    stop=question.stop if at_wall else None,
                    kinds=("stable",),
                )
            )
    return found


def _axes(parts: Parts) -> dict[str, Axis]:
    """Return the axes of a document, and add what is wrong with them."""
    table, found = parts.table("basins"), parts.found
    given = {name for name in (*PLACES, *IMPACTS) if name in table}
    for pair, other in ((PLACES, IMPACTS), (IMPACTS, PLACES)):
        if given & set(pair) and given & set(other) and pair is IMPACTS:
            name = next(name for name in pair if name in given)
            found.add(("basins", name), "given together with x0 or v0; give x0 and v0, or these")
        for name in pair:
            if given & set(pair) and name not in given and not given & set(other):
                found.add(("basins", name), "missing")
    if not given and "basins" in parts.document:
        found.add(("basins",), NO_AXES)
    return own_axes(parts, "basins", (*PLACES, *IMPACTS))


def build(parts: Parts) -> Basins | None:
    """Return the question of a document, None if it has faults."""
    found = parts.found
    parts.needs_period("basins need a periodic forcing")
    axes = _axes(parts)
    own = {key: value for key, value in parts.keys("basins").items()
           if key not in (*PLACES, *IMPACTS)}  # fmt: skip
    own |= {"t0": exact_phase(own["t0"])} if "t0" in own else {}
    add_faults(phase_faults("basins.t0", own.get("t0", 0.0)), found)
    add_faults(positive_faults("basins.escape", own.get("escape", 1.0)), found)
    _check_impacts(parts, axes, own.get("stop", 0))
    if found.faults:
        return None
    return Basins(axes, **own)


def _check_impacts(parts: Parts, axes: dict[str, Axis], stop: int) -> None:
    """Add what is wrong with starts at a wall."""
    found = parts.found
    if not set(axes) & set(IMPACTS) or found.is_wrong("oscillator"):
        return
    stops = parts.oscillator.stops
    if stop >= len(stops) or not isinstance(stops[stop], Wall):
        found.add(("basins", "stop"), "the number of no wall; give x0 and v0", str(stop))
    for name, below in (("cycle", 1.0), ("v", math.inf)):
        if name in axes:
            values = np.array([as_float(value) for value in axis_values(axes[name])])
            if values.min() < 0.0 or values.max() >= below:
                reason = "not all in [0, 1)" if name == "cycle" else "not all at least 0"
                found.add(("basins", name), reason)


KIND = Kind(BasinsDocument, build)
