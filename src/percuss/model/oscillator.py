"""The oscillator: a spring, a dashpot and stops, rigid or soft, as frozen values."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

from percuss.errors import ParameterError
from percuss.model.exact import (
    Exact,
    as_float,
    as_fraction,
    kept,
    operand,
    plain,
    scaled,
    square_root,
)
from percuss.model.faults import (
    Fault,
    as_tuple,
    dotted,
    faults,
    make_plain,
    not_negative_faults,
    number_faults,
    positive_faults,
    raise_first,
    scale_faults,
)
from percuss.model.restitution import Restitution, RestitutionTable

__all__ = [
    "Oscillator",
    "Side",
    "SoftStop",
    "Stop",
    "Wall",
    "backlash_oscillator",
    "bilinear_oscillator",
    "impact_oscillator",
]


Side: TypeAlias = Literal["above", "below"]


@dataclass(frozen=True, slots=True)
class Wall:
    """A rigid stop: the motion stays on one side of it, and an impact turns v into -r v.

    Parameters
    ----------
    at
        Position [length], finite.
    side
        On which side of the free motion the wall lies: a wall ``"below"`` keeps x >= at.
    restitution
        Coefficient of restitution r, in [0, 1], or a `restitution_table` over the speed of impacts.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> Wall(at=-1.0, side="below", restitution="0.7")
    Wall(at=-1.0, side='below', restitution='0.7')
    """

    at: Exact
    side: Side
    restitution: Restitution = 1.0

    def __post_init__(self) -> None:
        make_plain(self, "at", "side", "restitution")
        raise_first(faults(self))


@dataclass(frozen=True, slots=True)
class SoftStop:
    """A compliant stop: it adds the force -k_s (x - at) - 2 a_s x' while x is beyond it.

    Contact is by geometry, so the dashpot may pull. With a_s > 0 the force jumps where the
    stop is reached, with a_s = 0 it is continuous there.

    Parameters
    ----------
    at
        Position [length], finite.
    side
        On which side of the free motion the stop lies: ``"above"`` acts on x > at.
    stiffness
        Stiffness k_s per unit mass [1/time^2], of any sign.
    damping
        Damping a_s per unit mass [1/time], of any sign: a negative one feeds energy in.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> SoftStop(at=1.0, side="above", stiffness=29.0)
    SoftStop(at=1.0, side='above', stiffness=29.0, damping=0.0)
    """

    at: Exact
    side: Side
    stiffness: Exact
    damping: Exact = 0.0

    def __post_init__(self) -> None:
        make_plain(self, "at", "side", "stiffness", "damping")
        raise_first(faults(self))


Stop: TypeAlias = Wall | SoftStop


@dataclass(frozen=True, slots=True)
class Oscillator:
    """The oscillator x'' + 2 a x' + k x = f(t) + stops, of unit mass.

    Parameters
    ----------
    stiffness
        Stiffness k per unit mass [1/time^2], of any sign; 0 is free flight.
    damping
        Damping a [1/time], of any sign: a negative one feeds energy in.
    stops
        Soft stops, any number, and at most one wall a side. They keep their order, which is
        the ``stop`` index in results.

    Raises
    ------
    ParameterError
        If a value is outside its domain, the walls leave no room between them, or a soft stop
        is not in front of the walls.

    Examples
    --------
    >>> Oscillator(damping=0.01, stops=(Wall(at=0.0, side="below"),))
    Oscillator(stiffness=1.0, damping=0.01, stops=(Wall(at=0.0, side='below', restitution=1.0),))
    """

    stiffness: Exact = 1.0
    damping: Exact = 0.0
    stops: tuple[Stop, ...] = ()

    def __post_init__(self) -> None:
        make_plain(self, "stiffness", "damping")
        object.__setattr__(self, "stops", as_tuple(self.stops))
        raise_first(faults(self, ""))

    @classmethod
    def from_mass(
        cls,
        mass: Exact,
        stiffness: Exact,
        damping_coefficient: Exact | None = None,
        damping_ratio: Exact | None = None,
        stops: Iterable[Stop] = (),
    ) -> Oscillator:
        """Return the oscillator m x'' + c x' + k x = F(t) + stops, divided by its mass.

        Everything is in the engineers' units, the stops too: the stiffness of a `SoftStop` is
        a force per length and its ``damping`` the coefficient c_s of the force c_s x'. They
        become k_s/m and c_s/(2 m), as k becomes k/m and c becomes a = c/(2 m). Forces are
        divided by the mass as well: give `Forcing.per_mass` of the force.

        Parameters
        ----------
        mass
            Mass m [mass], > 0.
        stiffness
            Stiffness k [force/length].
        damping_coefficient
            Coefficient c [force time/length], of any sign; 0 if neither it nor the ratio is given.
        damping_ratio
            Fraction of critical damping c / (2 sqrt(k m)), of any sign, in place of the coefficient;
            needs k > 0.
        stops
            Stops in the same units; restitutions and positions stay as they are.

        Returns
        -------
        Oscillator
            The oscillator of unit mass; quotients are exact, as fractions where no float is.

        Raises
        ------
        ParameterError
            If a value is outside its domain, or both forms of damping are given.

        Examples
        --------
        >>> Oscillator.from_mass(mass=2.0, stiffness=50.0, damping_coefficient=0.5)
        Oscillator(stiffness=25.0, damping=0.125, stops=())
        >>> Oscillator.from_mass(mass=2.0, stiffness=50.0, damping_ratio="0.25").damping
        1.25
        """
        raise_first(positive_faults("mass", plain(mass)))
        per_mass = 1 / operand(mass)
        raise_first(number_faults("stiffness", plain(stiffness)))
        if damping_ratio is None:
            damping = _damping_of_coefficient(damping_coefficient, per_mass)
        elif damping_coefficient is None:
            damping = _damping_of_ratio(damping_ratio, stiffness, per_mass)
        else:
            raise ParameterError(
                "damping_ratio",
                damping_ratio,
                f"given together with damping_coefficient = {damping_coefficient!r}; give one",
            )
        return cls(
            stiffness=scaled(stiffness, per_mass),
            damping=damping,
            stops=tuple(_stop_per_mass(stop, per_mass) for stop in stops),
        )


def impact_oscillator(
    restitution: Restitution = 1.0,
    *,
    wall: Exact = 0.0,
    side: Side = "below",
    stiffness: Exact = 1.0,
    damping: Exact = 0.0,
) -> Oscillator:
    """Return an oscillator with one wall.

    Parameters
    ----------
    restitution
        Coefficient of restitution, in [0, 1], or a `restitution_table`.
    wall
        Position of the wall [length].
    side
        On which side of the motion the wall lies.
    stiffness
        Stiffness k per unit mass [1/time^2].
    damping
        Damping a [1/time], of any sign.

    Returns
    -------
    Oscillator
        With the wall as its only stop.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> impact_oscillator(restitution=0.8).stops
    (Wall(at=0.0, side='below', restitution=0.8),)
    """
    return Oscillator(stiffness, damping, (Wall(wall, side, restitution),))


def bilinear_oscillator(
    stiffness_above: Exact = 1.0, *, stiffness_below: Exact, damping: Exact = 0.0
) -> Oscillator:
    """Return an oscillator with one stiffness on x > 0 and another on x < 0.

    It is a spring with one soft stop at 0 that adds the exact difference (Dyskin et al. 2012,
    eq. 1).

    Parameters
    ----------
    stiffness_above
        Stiffness per unit mass on x > 0 [1/time^2].
    stiffness_below
        Stiffness per unit mass on x < 0 [1/time^2].
    damping
        Damping a on either side [1/time], of any sign.

    Returns
    -------
    Oscillator
        With one soft stop at 0, ``side="below"``.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> bilinear_oscillator(stiffness_below=400.0).stops
    (SoftStop(at=0.0, side='below', stiffness=399.0, damping=0.0),)
    """
    for name, value in (
        ("stiffness_above", stiffness_above),
        ("stiffness_below", stiffness_below),
    ):
        raise_first(number_faults(name, plain(value)))
    difference = kept(operand(stiffness_below) - operand(stiffness_above))
    return Oscillator(stiffness_above, damping, (SoftStop(0.0, "below", difference),))


def backlash_oscillator(
    gap: Exact,
    stiffness: Exact,
    damping: Exact = 0.0,
    *,
    stiffness_inside: Exact = 0.0,
    stop_damping: Exact = 0.0,
) -> Oscillator:
    """Return a body that is free for |x| < gap and meets a soft stop on either side.

    Parameters
    ----------
    gap
        Distance of either stop from 0 [length], >= 0.
    stiffness
        Stiffness k_s of each stop per unit mass [1/time^2].
    damping
        Damping a everywhere [1/time], of any sign.
    stiffness_inside
        Stiffness k everywhere [1/time^2], to which the stops add.
    stop_damping
        Damping a_s of each stop [1/time], of any sign.

    Returns
    -------
    Oscillator
        With stop 0 below at -gap and stop 1 above at gap.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> [(stop.at, stop.side) for stop in backlash_oscillator(gap=1.0, stiffness=100.0).stops]
    [(-1.0, 'below'), (1.0, 'above')]
    """
    raise_first(not_negative_faults("gap", plain(gap), "negative; the stops would overlap"))
    stops = (
        SoftStop(kept(-operand(gap)), "below", stiffness, stop_damping),
        SoftStop(gap, "above", stiffness, stop_damping),
    )
    return Oscillator(stiffness_inside, damping, stops)


@faults.register
def _(value: Wall, prefix: str | None = None) -> list[Fault]:
    problems = [
        *number_faults(dotted(prefix, "at"), value.at),
        *_side_faults(dotted(prefix, "side"), value.side),
    ]
    name = dotted(prefix, "restitution")
    if isinstance(value.restitution, RestitutionTable):
        return problems + faults(value.restitution, name)
    not_a_number = number_faults(name, value.restitution)
    if not_a_number:
        return problems + not_a_number
    restitution = as_float(value.restitution)
    if restitution > 1.0:
        reason = "outside [0, 1]; above 1 an impact would create energy"
        problems.append(Fault(name, value.restitution, reason))
    elif restitution < 0.0:
        reason = "outside [0, 1]; below 0 the motion would pass through the wall"
        problems.append(Fault(name, value.restitution, reason))
    return problems


@faults.register
def _(value: SoftStop, prefix: str | None = None) -> list[Fault]:
    return [
        *number_faults(dotted(prefix, "at"), value.at),
        *_side_faults(dotted(prefix, "side"), value.side),
        *scale_faults(dotted(prefix, "stiffness"), value.stiffness),
        *scale_faults(dotted(prefix, "damping"), value.damping),
    ]


@faults.register
def _(value: Oscillator, prefix: str | None = None) -> list[Fault]:
    prefix = "oscillator" if prefix is None else prefix
    problems = [
        *scale_faults(dotted(prefix, "stiffness"), value.stiffness),
        *scale_faults(dotted(prefix, "damping"), value.damping),
    ]
    if not isinstance(value.stops, tuple):
        return [*problems, Fault(dotted(prefix, "stops"), value.stops, "not a tuple of stops")]
    wrong = []
    for index, stop in enumerate(value.stops):
        name = dotted(prefix, f"stops.{index}")
        if isinstance(stop, Wall | SoftStop):
            wrong += faults(stop, name)
        else:
            wrong.append(Fault(name, stop, "neither a Wall nor a SoftStop"))
    return problems + (wrong or _stops_faults(value.stops, prefix))


def _stops_faults(stops: tuple[Stop, ...], prefix: str | None = None) -> list[Fault]:
    """Return the faults of stops, each right in itself, that do not fit together."""
    problems: list[Fault] = []
    walls: dict[Side, int] = {}
    for index, stop in enumerate(stops):
        if not isinstance(stop, Wall):
            continue
        first = walls.setdefault(stop.side, index)
        if first != index:
            reason = (
                f"a second wall {stop.side}; stops.{first} at x = {stops[first].at} is one,"
                " keep the inner of the two"
            )
            problems.append(Fault(dotted(prefix, f"stops.{index}.side"), stop.side, reason))
    if len(walls) == 2:
        below, above = stops[walls["below"]], stops[walls["above"]]
        if as_float(below.at) >= as_float(above.at):
            reason = f"not above the lower wall at x = {below.at}; the walls leave no room"
            problems.append(Fault(dotted(prefix, f"stops.{walls['above']}.at"), above.at, reason))
    for index in walls.values():
        problems += _behind_faults(stops, stops[index], prefix)
    return problems


def _behind_faults(stops: tuple[Stop, ...], wall: Stop, prefix: str | None) -> list[Fault]:
    sign = 1.0 if wall.side == "above" else -1.0
    problems = []
    for index, stop in enumerate(stops):
        # Compared as the doubles they become: two texts of one double are one position.
        depth = sign * (as_float(stop.at) - as_float(wall.at))
        if isinstance(stop, Wall) or depth < 0.0:
            continue
        place = "at" if depth == 0.0 else "behind"
        effect = (
            "it would never act"
            if stop.side == wall.side
            else "it would always act, as stiffness, damping and a constant force do"
        )
        reason = f"{place} the wall {wall.side} at x = {wall.at}, where {effect}"
        problems.append(Fault(dotted(prefix, f"stops.{index}.at"), stop.at, reason))
    return problems


def _side_faults(name: str, side: object) -> list[Fault]:
    if isinstance(side, str) and side in {"above", "below"}:
        return []
    return [Fault(name, side, 'neither "above" nor "below"')]


def _damping_of_coefficient(coefficient: Exact | None, per_mass: Any) -> Exact:
    if coefficient is None:
        return 0.0
    raise_first(scale_faults("damping_coefficient", plain(coefficient)))
    damping: Exact = scaled(coefficient, per_mass / 2)
    return damping


def _damping_of_ratio(ratio: Exact, stiffness: Exact, per_mass: Any) -> Exact:
    raise_first(scale_faults("damping_ratio", plain(ratio)))
    if as_fraction(stiffness) <= 0:
        reason = f"needs a stiffness above 0, not {stiffness}; give damping_coefficient"
        raise ParameterError("damping_ratio", ratio, reason)
    size: Exact = square_root(operand(ratio) ** 2 * operand(stiffness) * per_mass)
    negative: Exact = kept(-operand(size))
    return negative if as_fraction(ratio) < 0 else size


def _stop_per_mass(stop: Stop, per_mass: Any) -> Stop:
    if isinstance(stop, Wall):
        return stop
    return SoftStop(
        stop.at,
        stop.side,
        scaled(stop.stiffness, per_mass),
        scaled(stop.damping, per_mass / 2),
    )
