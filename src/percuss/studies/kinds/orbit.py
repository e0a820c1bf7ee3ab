"""Studies of one periodic orbit: which one is looked for, and from where."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field
from pydantic_core import PydanticCustomError

from percuss.io.study_text import number
from percuss.model.exact import Exact, as_float
from percuss.model.faults import number_faults
from percuss.studies.parts import Parts, add_faults
from percuss.studies.question import Kind, Means, Picture
from percuss.studies.schema import CertifyTable, Document, Number, SampledSaveTable, Table

if TYPE_CHECKING:
    from percuss.orbits import PeriodicOrbit
    from percuss.studies.study import Study

__all__ = ["KIND", "Orbit", "Sought", "counted", "find", "impacts_in_words", "orbit_rows", "sought"]


def _impacts(value: object) -> object:
    whole = isinstance(value, int) and not isinstance(value, bool) and value >= 0
    if not whole and value not in ("inf", math.inf):
        raise PydanticCustomError("impacts", 'neither a whole number nor "inf", for sticking')
    return value


Count = Annotated[int, Field(ge=1)]


class OrbitTable(Table):
    """``[orbit]``: which orbit, and where to look for it."""

    impacts: Annotated[int | float | str, BeforeValidator(_impacts)] = 1
    periods: Count = 1
    sequence: list[Annotated[int, Field(ge=0)]] | None = None
    cycle: Number | None = None
    v_after: Number | None = None
    seed: Annotated[int, Field(ge=0)] = 0


class OrbitDocument(Document):
    """A study file of one orbit."""

    orbit: OrbitTable
    certify: CertifyTable | None = None
    save: SampledSaveTable = SampledSaveTable()


@dataclass(frozen=True, slots=True)
class Sought:
    """Which orbit is looked for, as `percuss.find_orbit` takes it.

    Parameters
    ----------
    impacts, periods, sequence, seed
        As there; infinitely many impacts are sticking.
    guess
        (cycle, v_after) of an impact; or None.
    """

    impacts: float = 1
    periods: int = 1
    sequence: tuple[int, ...] | None = None
    guess: tuple[Exact, Exact] | None = None
    seed: int = 0

    def table(self) -> dict[str, object]:
        """Return it as an ``[orbit]`` table."""
        cycle, v_after = (None, None) if self.guess is None else map(number, self.guess)
        return {
            "impacts": "inf" if math.isinf(self.impacts) else int(self.impacts),
            "periods": self.periods,
            "sequence": None if self.sequence is None else list(self.sequence),
            "cycle": cycle,
            "v_after": v_after,
            "seed": self.seed or None,
        }


def sought(parts: Parts) -> Sought:
    """Return which orbit a document looks for, and add what is wrong with it."""
    given, found = parts.keys("orbit"), parts.found
    impacts = math.inf if given.get("impacts", 1) == "inf" else given.get("impacts", 1)
    sequence = given.get("sequence")
    parts_of_guess = [given.get(name) for name in ("cycle", "v_after")]
    for name, value in zip(("cycle", "v_after"), parts_of_guess, strict=True):
        if value is not None:
            add_faults(number_faults(f"orbit.{name}", value), found)
    if (parts_of_guess[0] is None) != (parts_of_guess[1] is None):
        there, missing = ("v_after", "cycle") if parts_of_guess[0] is None else ("cycle", "v_after")
        if not found.is_wrong("orbit"):
            found.add(("orbit", missing), f"missing; a guess is a cycle and a v_after, and {there} "
                                          "is given")  # fmt: skip
    _check(parts, impacts, sequence)
    if parts.forcing is not None and parts.forcing.harmonics:
        parts.needs_period("a periodic orbit needs a periodic forcing")
    guess = None if None in parts_of_guess else (parts_of_guess[0], parts_of_guess[1])
    return Sought(
        impacts,
        given.get("periods", 1),
        None if sequence is None else tuple(sequence),
        guess,  # type: ignore[arg-type]  # numbers, or a fault
        given.get("seed", 0),
    )


def _check(parts: Parts, impacts: float, sequence: list[int] | None) -> None:
    """Add where the stops do not go with the impacts."""
    found, stops = parts.found, parts.oscillator.stops
    if found.is_wrong("oscillator") or found.is_wrong("orbit"):
        return
    if impacts != 0 and not stops:
        found.add(("orbit", "impacts"), "the oscillator has no stops to meet", f"{impacts:g}")
    elif sequence is not None and len(sequence) != impacts:
        reason = f"not one stop for each of the {impacts:g} impacts"
        found.add(("orbit", "sequence"), reason, str(sequence))
    elif sequence and max(sequence) >= len(stops):
        reason = f"the oscillator has {counted(len(stops), 'stop')}, counted from 0"
        found.add(("orbit", "sequence"), reason, str(sequence))


def find(study: Study, wanted: Sought) -> PeriodicOrbit:
    """Find the orbit that a study is about."""
    # The report and the files say where an orbit is formal.
    from percuss.orbits.finding.find import find_formal_orbit

    guess = None
    if wanted.guess is not None:
        guess = as_float(wanted.guess[0]), as_float(wanted.guess[1])
    return find_formal_orbit(
        study.oscillator,
        study.forcing,
        wanted.impacts,
        wanted.periods,
        wanted.sequence,
        guess,
        seed=wanted.seed,
    )


@dataclass(frozen=True, slots=True)
class Orbit:
    """One periodic orbit.

    Parameters
    ----------
    sought
        Which one.
    """

    kind: ClassVar[str] = "orbit"
    doing: ClassVar[str] = "looking for the orbit"
    stem: ClassVar[str] = "orbit"
    is_ensemble: ClassVar[bool] = False

    sought: Sought = Sought()

    def tables(self) -> dict[str, object]:
        """Return ``[orbit]``."""
        return {"orbit": self.sought.table()}

    def csv(self, study: Study) -> dict[str, str]:  # noqa: ARG002
        """Return the impacts of a period."""
        return {"impacts": "impacts"}

    def pictures(self, study: Study) -> dict[str, Picture]:  # noqa: ARG002
        """Return the orbit in the plane, and its multipliers."""
        return {"orbit": _draw}

    def answer(self, study: Study, means: Means) -> PeriodicOrbit:  # noqa: ARG002
        """Find it."""
        return find(study, self.sought)

    def report(self, result: PeriodicOrbit) -> dict[str, str]:
        """Tell what it is and how stable."""
        return orbit_rows(result)


def orbit_rows(orbit: PeriodicOrbit) -> dict[str, str]:
    """Return what there is to say of an orbit."""
    count = impacts_in_words(orbit.n_impacts)
    turns = f" in {counted(orbit.n_periods, 'forcing period')}" if orbit.n_periods else ""
    values = ", ".join(_shown(value) for value in orbit.multipliers)
    rows = {
        "orbit": f"{count}{turns}, period {orbit.period:.10g}",
        "stability": f"{orbit.stability}, multipliers {values}",
    }
    if len(orbit.impacts):
        cycle, v = orbit.impacts.cycle[0], orbit.impacts.v_after[0]
        rows["first impact"] = f"at t = {orbit.t0:.12g}, v_after = {v:.12g}" + (
            f", cycle {cycle:.12g}" if orbit.n_periods else ""
        )
    rows["grazing margin"] = f"{orbit.grazing_margin:.6g}"
    if not orbit.admissible:
        times = counted(len(orbit.passages), "time")
        rows["not physical"] = f"it passes through a stop {times} a round"
    if not orbit.isolated:
        rows["not isolated"] = "one of a family of orbits in this same system"
    return rows | {"residual": f"{orbit.residual:.2g}"}


def impacts_in_words(n_impacts: float) -> str:
    """Return a number of impacts in words."""
    return "sticking" if math.isinf(n_impacts) else counted(n_impacts, "impact")


def counted(n: float, thing: str) -> str:
    """Return a number and what it counts."""
    return f"{n:g} {thing}" + ("" if n == 1 else "s")


def _shown(value: complex) -> str:
    return f"{value.real:.6g}" if value.imag == 0.0 else f"{value.real:.6g}{value.imag:+.6g}i"


def _draw(orbit: PeriodicOrbit, study: Study, figure: Any) -> None:
    from percuss.plotting import Units, plot_multipliers, plot_orbit

    figure.set_size_inches(9.6, 4.8)
    left, right = figure.subplots(1, 2, width_ratios=[1.3, 1.0])
    plot_orbit(orbit, left, units=Units(study.draw.length_unit, study.draw.time_unit))
    plot_multipliers(orbit, right)
    figure.suptitle(study.title, parse_math=False)


def build(parts: Parts) -> Orbit | None:
    """Return the question of a document, None if it has faults."""
    wanted = sought(parts)
    return None if parts.found.faults else Orbit(wanted)


KIND = Kind(OrbitDocument, build)
