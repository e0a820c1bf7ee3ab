"""An oscillator under a forcing as one value, with the law that the kernels read."""

from __future__ import annotations

from functools import cached_property
from typing import NamedTuple

from percuss.kernels.law_columns import Law
from percuss.model.faults import Fault, raise_first
from percuss.model.forcing import Forcing
from percuss.model.harmonics import Harmonic
from percuss.model.law import RegionBounds, law, lines
from percuss.model.oscillator import Oscillator

__all__ = ["System", "kind_faults"]


class _SystemFields(NamedTuple):
    oscillator: Oscillator
    forcing: Forcing | None


class System(_SystemFields):
    """An oscillator and what drives it.

    Parameters
    ----------
    oscillator
        Mass, spring, dashpot and stops.
    forcing
        None for free motion.

    Examples
    --------
    >>> import percuss as pc
    >>> system = System(pc.impact_oscillator("0.8", wall=0), pc.cosine("2.8"))
    >>> round(system.period, 6), len(system.lines.at)
    (2.243995, 2)
    """

    def __getstate__(self) -> None:
        """Return that a pickle holds the two fields alone."""

    @classmethod
    def of(cls, osc: object, force: object) -> System:
        """Return the system of a caller's two arguments; ParameterError for another type."""
        raise_first(kind_faults(osc, force))
        assert isinstance(osc, Oscillator)
        assert force is None or isinstance(force, Forcing)
        return cls(osc, force)

    # To find the law of equal values by their hash takes as long as several impacts.
    @cached_property
    def law(self) -> Law:
        """The numbers of the equation of motion, each rounded once; made once for equal systems."""
        return law(self.oscillator, self.forcing)

    @cached_property
    def lines(self) -> RegionBounds:
        """The bounds of the regions between the stops."""
        return lines(self.oscillator)

    @property
    def period(self) -> float | None:
        """The period of the forcing [time]; None without one."""
        return None if self.forcing is None else self.forcing.period


def kind_faults(osc: object, force: object) -> list[Fault]:
    """Return the faults of arguments that are no oscillator and no forcing."""
    if not isinstance(osc, Oscillator):
        return [Fault("osc", osc, "not an Oscillator; impact_oscillator() makes one")]
    if force is None or isinstance(force, Forcing):
        return []
    if isinstance(force, Harmonic):
        return [Fault("force", force, "not a Forcing; give Forcing((harmonic,))")]
    return [Fault("force", force, "not a Forcing; cosine(2) makes one, and forcings can be added")]
