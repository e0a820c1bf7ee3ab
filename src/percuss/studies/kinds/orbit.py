"""Studies of one periodic orbit: the orbit sought, and the guess."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import PlainSerializer, PlainValidator, WithJsonSchema
from pydantic_core import PydanticCustomError

from percuss.execution import Execution
from percuss.model.exact import as_float
from percuss.model.faults import number_faults
from percuss.model.loads import loads_of
from percuss.studies.study import (
    Question,
    StudyDraft,
    multiplier_text,
)
from percuss.studies.tables import Count, NumberKey, NumbersKey, Whole, table
from percuss.wording import counted, counts_in_words

if TYPE_CHECKING:
    from percuss.orbits import PeriodicOrbit, StructureOrbit
    from percuss.studies.study import Study


def _impacts(value: object) -> object:
    whole = isinstance(value, int) and not isinstance(value, bool) and value >= 0
    if not whole and value not in ("inf", math.inf):
        raise PydanticCustomError("impacts", 'neither a whole number nor "inf", for sticking')
    return value if whole else math.inf


ImpactCount = Annotated[
    float,
    PlainValidator(_impacts),
    PlainSerializer(lambda n: "inf" if math.isinf(n) else n),
    WithJsonSchema({"anyOf": [{"type": "integer", "minimum": 0}, {"const": "inf"}]}),
]


@table
class Sought:
    """The orbit sought, as `percuss.find_orbit` takes it.

    Parameters
    ----------
    impacts, periods, sequence, seed
        As there; infinitely many impacts stand for sticking.
    cycle, v_after
        The guess, an impact: both or none.
    x0, v0
        Of a structure the guess, a state at t = 0: both or none.
    """

    of_oscillators: ClassVar = ("impacts", "sequence", "cycle", "v_after", "seed")
    of_structures: ClassVar = ("x0", "v0")

    impacts: ImpactCount = 1
    periods: Count = 1
    sequence: tuple[Whole, ...] | None = None
    cycle: NumberKey | None = None
    v_after: NumberKey | None = None
    seed: Annotated[Whole, PlainSerializer(lambda seed: seed or None)] = 0
    x0: NumbersKey | None = None
    v0: NumbersKey | None = None

    @property
    def guess(self) -> tuple[float, float] | None:
        """The guess as `percuss.find_orbit` takes it."""
        if self.cycle is None or self.v_after is None:
            return None
        return as_float(self.cycle), as_float(self.v_after)

    def check(self, study: StudyDraft) -> None:
        """Add the faults of the guess, the sequence and the forcing."""
        if study.structure is not None:
            from percuss.studies.of_structures import check_sought

            check_sought(self.x0, self.v0, study)
            return
        faults, guess = study.faults, {"cycle": self.cycle, "v_after": self.v_after}
        for name, value in guess.items():
            if value is not None:
                faults.add_from_model(number_faults(f"orbit.{name}", value))
        missing = [name for name, value in guess.items() if value is None]
        if len(missing) == 1 and not faults.is_wrong("orbit"):
            (given,) = guess.keys() - set(missing)
            reason = f"missing; a guess is a cycle and a v_after, and {given} is given"
            faults.add(("orbit", missing[0]), reason)
        self._check_stops(study)
        if study.forcing is not None and not study.forcing.is_constant:
            study.needs_period("a periodic orbit needs a periodic forcing")

    def _check_stops(self, study: StudyDraft) -> None:
        faults, stops, sequence = study.faults, study.oscillator.stops, self.sequence
        if faults.is_wrong("oscillator") or faults.is_wrong("orbit"):
            return
        path = ("orbit", "sequence")
        if self.impacts != 0 and not stops:
            reason = "the oscillator has no stops to meet"
            faults.add(("orbit", "impacts"), reason, f"{self.impacts:g}")
        elif sequence is not None and len(sequence) != self.impacts:
            reason = f"not one stop for each of the {self.impacts:g} impacts"
            faults.add(path, reason, str(list(sequence)))
        elif sequence and max(sequence) >= len(stops):
            reason = f"the oscillator has {counted(len(stops), 'stop')}, counted from 0"
            faults.add(path, reason, str(list(sequence)))

    def find(self, study: Study) -> PeriodicOrbit | StructureOrbit:
        """Find the orbit of a study."""
        # The report and the files say where an orbit is formal.
        from percuss.orbits.finding.find import find_orbit

        if study.structure is not None:
            guess = None if self.x0 is None else (self.x0, self.v0)
            loads = loads_of(study.structure, study.force)
            return find_orbit(study.structure, loads, n_periods=self.periods, guess=guess)
        return find_orbit(
            study.oscillator,
            study.forcing,
            self.impacts,
            self.periods,
            self.sequence,
            self.guess,
            seed=self.seed,
            formal=True,
        )


@table
class Orbit(Question):
    """One periodic orbit.

    Parameters
    ----------
    sought
        The orbit sought.
    """

    doing: ClassVar = "looking for the orbit"
    is_certifiable: ClassVar = True
    save_keys: ClassVar = ("samples",)
    draw_keys_of_structures: ClassVar = ("on",)
    # The impacts of a period.
    columns: ClassVar = {"impacts": "impacts"}

    sought: Sought = Sought()

    def checked(self, study: StudyDraft) -> Self:
        """Check the orbit sought."""
        self.sought.check(study)
        return self

    def answer(self, study: Study, execution: Execution) -> PeriodicOrbit | StructureOrbit:  # noqa: ARG002
        """Find the orbit."""
        return self.sought.find(study)

    def draw(self, result: Any, study: Study, figure: Any) -> None:
        """Draw the orbit in the plane, and its multipliers."""
        from percuss.plotting import plot_multipliers, plot_orbit, plot_phase_portrait

        figure.set_size_inches(9.6, 4.8)
        left, right = figure.subplots(1, 2, width_ratios=[1.3, 1.0])
        if study.structure is None:
            plot_orbit(result, left, units=study.draw.units())
        else:
            from percuss.studies.of_structures import shown_directions

            (on, *_) = shown_directions(study)
            plot_phase_portrait(result.run, left, units=study.draw.units(), on=on)
        plot_multipliers(result, right)

    def report(self, result: Any) -> dict[str, str]:
        """Return the orbit and its stability."""
        if hasattr(result, "structure"):
            from percuss.studies.of_structures import report_of_orbit

            return report_of_orbit(result)
        counts = counts_in_words(result.n_impacts, result.n_periods)
        values = ", ".join(multiplier_text(value) for value in result.multipliers)
        rows = {
            "orbit": f"{counts}, period {result.period:.10g}",
            "stability": f"{result.stability}, multipliers {values}",
        }
        if len(result.impacts):
            cycle, v = result.impacts.cycle[0], result.impacts.v_after[0]
            rows["first impact"] = f"at t = {result.t0:.12g}, v_after = {v:.12g}" + (
                f", cycle {cycle:.12g}" if result.n_periods else ""
            )
        rows["grazing margin"] = f"{result.grazing_margin:.6g}"
        if not result.admissible:
            times = counted(len(result.passages), "time")
            rows["not physical"] = f"it passes through a stop {times} per period"
        if not result.isolated:
            rows["not isolated"] = "one of a family of orbits in this same system"
        return rows | {"residual": f"{result.residual:.2g}"}
