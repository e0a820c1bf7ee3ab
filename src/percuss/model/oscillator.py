"""The oscillator: a spring, a dashpot and stops, rigid or soft, as frozen values."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Literal, TypeAlias, cast

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
    draft,
    faults,
    field_values,
    is_row,
    make_numbers,
    make_plain,
    not_negative_faults,
    number_faults,
    plain_number,
    positive_faults,
    raise_first,
    scale_faults,
)
from percuss.model.restitution import Restitution, RestitutionTable
from percuss.model.units import Units

Side: TypeAlias = Literal["above", "below"]
# Where something acts on a structure: a coordinate, a direction or the name of a point.
On: TypeAlias = int | str | tuple[Exact, ...]


@dataclass(frozen=True, slots=True, repr=False)
class Wall:
    """A rigid stop: the motion stays on one side of it, and an impact turns v into -r v.

    On a structure it acts on y = c . x, where ``on`` gives c, and an impact turns y' into -r y'.

    Parameters
    ----------
    at
        Position [length], finite.
    side
        On which side of the free motion the wall lies: a wall ``"below"`` keeps x >= at.
    restitution
        Coefficient of restitution r, in [0, 1], or a `restitution_table` over the speed of impacts.
    on
        Where it acts on a `Structure`: the index of a coordinate, a direction c as a tuple of n
        numbers, which is not normalised, or the name of a point. An oscillator needs none.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> Wall(at=-1.0, side="below", restitution="0.7")
    Wall(at=-1.0, side='below', restitution='0.7')
    >>> Wall(at=1.0, side="above", on=(1, -1))
    Wall(at=1.0, side='above', restitution=1.0, on=(1, -1))
    """

    at: Exact
    side: Side
    restitution: Restitution = 1.0
    on: On | None = None

    def __post_init__(self) -> None:
        make_plain(self, "side")
        make_numbers(self, "at", "restitution")
        object.__setattr__(self, "on", plain_on(self.on))
        raise_first(faults(self))

    def __repr__(self) -> str:
        return _stop_text(self)


@dataclass(frozen=True, slots=True, repr=False)
class SoftStop:
    """A compliant stop: it adds the force -k_s (x - at) - 2 a_s x' while x is beyond it.

    Beside a mass (`Oscillator.from_mass`, `Structure`) it is in engineers' units: ``stiffness`` is
    then a force per length and ``damping`` the coefficient c_s of the force -c_s x'. Contact is by
    geometry, so the dashpot may pull. With a_s > 0 the force jumps where the stop is reached, with
    a_s = 0 it is continuous there. On a structure it acts on y = c . x, where ``on`` gives c.

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
    on
        Where it acts on a `Structure`: the index of a coordinate, a direction c as a tuple of n
        numbers, which is not normalised, or the name of a point. An oscillator needs none.

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
    on: On | None = None

    def __post_init__(self) -> None:
        make_plain(self, "side")
        make_numbers(self, "at", "stiffness", "damping")
        object.__setattr__(self, "on", plain_on(self.on))
        raise_first(faults(self))

    def __repr__(self) -> str:
        return _stop_text(self)


Stop: TypeAlias = Wall | SoftStop


def _stop_text(stop: Stop) -> str:
    """Return the call that makes a stop; where nothing is given, ``on`` is not shown."""
    values = field_values(stop)
    if stop.on is None:
        # Stores know a study by this text.
        del values["on"]
    own = ", ".join(f"{name}={value!r}" for name, value in values.items())
    return f"{type(stop).__name__}({own})"


def plain_on(value: object) -> Any:
    """Return what a stop or a load acts on with Python's numbers, a list as a tuple."""
    value = plain(value)
    if not is_row(value):
        return value
    return tuple(plain(number) for number in value)


@dataclass(frozen=True, slots=True, init=False, repr=False)
class Oscillator:
    """The oscillator x'' + 2 a x' + k x = f(t) + stops, of unit mass; or with a mass.

    With a mass it is m x'' + c x' + k x = F(t) + stops, in engineers' units: ``stiffness`` is k,
    ``damping`` is c, stops are as `SoftStop` says, and a force is a force. `from_mass` makes it.

    Parameters
    ----------
    stiffness
        Stiffness k per unit mass [1/time^2], of any sign; 0 is free flight. With a mass
        [force/length].
    damping
        Damping a [1/time], of any sign: a negative one feeds energy in. With a mass the
        coefficient c [force time/length].
    stops
        Soft stops, any number, and at most one wall a side. They keep their order, which is
        the ``stop`` index in results.
    mass
        Mass m [mass], > 0; default: all is per unit mass, forces and results too.
    units
        What the numbers are measured in: the labels of tables, files and pictures.

    Raises
    ------
    ParameterError
        If a value is outside its domain, the walls leave no room between them, a soft stop is not
        in front of the walls, or the units name a mass where there is none, or none where there
        is.

    Examples
    --------
    >>> Oscillator(damping=0.01, stops=(Wall(at=0.0, side="below"),))
    Oscillator(stiffness=1.0, damping=0.01, stops=(Wall(at=0.0, side='below', restitution=1.0),))
    """

    stiffness: Exact = 1.0
    damping: Exact = 0.0
    stops: tuple[Stop, ...] = ()
    mass: Exact | None = None
    units: Units | None = None

    def __init__(
        self,
        stiffness: Exact = 1.0,
        damping: Exact = 0.0,
        stops: Iterable[Stop] = (),
        mass: Exact | None = None,
        units: Units | None = None,
    ) -> None:
        given = {"stiffness": stiffness, "damping": damping, "mass": mass}
        for name, value in given.items():
            object.__setattr__(self, name, value)
        make_numbers(self, *given)
        object.__setattr__(self, "stops", _without_on(as_tuple(stops)))
        object.__setattr__(self, "units", units)
        raise_first(faults(self, ""))

    def __repr__(self) -> str:
        # Beside a mass a dashpot is a coefficient, and is named so. Stores know a study by this text.
        units = "" if self.units is None else f", units={self.units!r}"
        stops = f"stops={self.stops!r}{units}"
        if self.mass is None:
            return f"Oscillator(stiffness={self.stiffness!r}, damping={self.damping!r}, {stops})"
        own = f"mass={self.mass!r}, stiffness={self.stiffness!r}"
        return f"Oscillator.from_mass({own}, damping_coefficient={self.damping!r}, {stops})"

    @classmethod
    def from_mass(
        cls,
        mass: Exact,
        stiffness: Exact,
        damping_coefficient: Exact | None = None,
        damping_ratio: Exact | None = None,
        stops: Iterable[Stop] = (),
        *,
        units: Units | None = None,
    ) -> Oscillator:
        """Return the oscillator m x'' + c x' + k x = F(t) + stops, in engineers' units.

        The stops are in the same units: the stiffness of a `SoftStop` is a force per length and
        its ``damping`` the coefficient c_s of the force c_s x'. So is the force on it, and what
        comes out: forces are forces, impulses are changes of momentum, energies are energies.

        Parameters
        ----------
        mass
            Mass m [mass], > 0.
        stiffness
            Stiffness k [force/length].
        damping_coefficient
            Coefficient c [force time/length], of any sign; 0 if neither it nor the ratio is given.
        damping_ratio
            Fraction of critical damping c / (2 sqrt(k m)), of any sign, in place of the
            coefficient, which it is turned into; needs k > 0.
        stops
            Stops in the same units.
        units
            What the numbers are measured in.

        Returns
        -------
        Oscillator
            The oscillator with its mass. `of_unit_mass` divides it by that, exactly.

        Raises
        ------
        ParameterError
            If a value is outside its domain, or both forms of damping are given.

        Examples
        --------
        >>> Oscillator.from_mass(mass=2.0, stiffness=50.0, damping_coefficient=0.5)
        Oscillator.from_mass(mass=2.0, stiffness=50.0, damping_coefficient=0.5, stops=())
        >>> Oscillator.from_mass(mass=2.0, stiffness=50.0, damping_ratio="0.25").damping
        5.0
        """
        mass, stiffness, damping_coefficient, damping_ratio = (
            plain_number(value) for value in (mass, stiffness, damping_coefficient, damping_ratio)
        )
        raise_first(positive_faults("mass", mass))
        raise_first(number_faults("stiffness", stiffness))
        if damping_ratio is None:
            damping: Exact = 0.0 if damping_coefficient is None else damping_coefficient
            raise_first(scale_faults("damping_coefficient", damping))
        elif damping_coefficient is None:
            damping = _damping_of_ratio(damping_ratio, stiffness, mass)
        else:
            raise ParameterError(
                "damping_ratio",
                damping_ratio,
                f"given together with damping_coefficient = {damping_coefficient!r}; give one",
            )
        return cls(stiffness, damping, cast("tuple[Stop, ...]", stops), mass, units)

    def of_unit_mass(self) -> Oscillator:
        """Return the oscillator of unit mass that has the same motions.

        Returns
        -------
        Oscillator
            Stiffnesses divided by m and dashpots by 2 m, exactly; itself without a mass.

        Examples
        --------
        >>> Oscillator.from_mass(mass=2.0, stiffness=50.0, damping_coefficient=0.5).of_unit_mass()
        Oscillator(stiffness=25.0, damping=0.125, stops=())
        """
        return self if self.mass is None else _of_unit_mass(self)


def mass_of(osc: Oscillator) -> float | None:
    """Return the mass of an oscillator as a float, None without one."""
    return None if osc.mass is None else as_float(osc.mass)


@lru_cache(maxsize=256)
def _of_unit_mass(osc: Oscillator) -> Oscillator:
    unit = _unit_draft(osc)
    raise_first(faults(unit))
    return unit


def _without_on(stops: Any) -> Any:
    """Return stops on coordinate 0, the only one of an oscillator, as they are without ``on``."""
    if not isinstance(stops, tuple):
        return stops
    return tuple(
        dataclasses.replace(stop, on=None)
        if isinstance(stop, Wall | SoftStop) and type(stop.on) is int and stop.on == 0
        else stop
        for stop in stops
    )


def _unit_draft(osc: Oscillator) -> Oscillator:
    """Return the quotients of an oscillator and its mass, which may have left their ranges."""
    assert osc.mass is not None
    per_mass = 1 / operand(osc.mass)
    return draft(
        Oscillator,
        stiffness=scaled(osc.stiffness, per_mass),
        damping=scaled(osc.damping, per_mass / 2),
        stops=tuple(_stop_per_mass(stop, per_mass) for stop in osc.stops),
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
    above, below = (plain_number(k) for k in (stiffness_above, stiffness_below))
    raise_first(number_faults("stiffness_above", above))
    raise_first(number_faults("stiffness_below", below))
    difference = kept(operand(below) - operand(above))
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
    gap = plain_number(gap)
    raise_first(not_negative_faults("gap", gap, "negative; the stops would overlap"))
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
    if callable(value.restitution):
        reason = "a function; a restitution over the speed is a restitution_table(speeds, values)"
        return [*problems, Fault(name, value.restitution, reason)]
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
    if value.mass is not None:
        problems += positive_faults(dotted(prefix, "mass"), value.mass)
    problems += _units_faults(value, prefix)
    if not isinstance(value.stops, tuple):
        reason = "not a sequence of stops; of one alone it is [stop]"
        return [*problems, Fault(dotted(prefix, "stops"), value.stops, reason)]
    wrong = faults_of_each_stop(value.stops, prefix, _faults_of_on)
    problems += wrong or stops_faults(dict(enumerate(value.stops)), prefix)
    if problems or value.mass is None:
        return problems
    return [
        Fault(
            dotted(prefix, "mass"),
            value.mass,
            f"after the division by it, {fault.name} is {fault.reason}",
        )
        for fault in faults(_unit_draft(value), prefix)
    ]


def _units_faults(osc: Oscillator, prefix: str) -> list[Fault]:
    """Return the faults of units that do not fit the oscillator."""
    name, units = dotted(prefix, "units"), osc.units
    if units is None:
        return []
    if not isinstance(units, Units):
        return [Fault(name, units, 'not a Units; write Units("m", "s")')]
    if units.mass and osc.mass is None:
        reason = "a unit of mass for an oscillator without one; Oscillator.from_mass has a mass"
        return [Fault(f"{name}.mass", units.mass, reason)]
    if osc.mass is not None and not units.mass and (units.length or units.time):
        return [Fault(f"{name}.mass", units.mass, f"no unit for the mass of {osc.mass}")]
    return []


def _faults_of_on(on: On | None, name: str) -> list[Fault]:
    """Return the faults of where a stop of an oscillator acts."""
    reason = "an oscillator has one coordinate; a Structure has several"
    return [] if on is None or on == 0 else [Fault(name, on, reason)]


def faults_of_each_stop(
    stops: tuple[Stop, ...], prefix: str, faults_of_on: Callable[[On | None, str], list[Fault]]
) -> list[Fault]:
    """Return the faults of stops, of each by itself.

    Parameters
    ----------
    stops
        The stops.
    prefix
        Dotted path of the system that has them.
    faults_of_on
        Takes where a stop acts and the path of that, and returns its faults.
    """
    problems: list[Fault] = []
    for index, stop in enumerate(stops):
        name = dotted(prefix, f"stops.{index}")
        if isinstance(stop, Wall | SoftStop):
            problems += faults(stop, name) + faults_of_on(stop.on, f"{name}.on")
        else:
            problems.append(Fault(name, stop, "neither a Wall nor a SoftStop"))
    return problems


def stops_faults(
    stops: Mapping[int, Stop], prefix: str | None = None, of: str = "x"
) -> list[Fault]:
    """Return the faults of stops on one line, each right in itself, that do not fit together.

    Parameters
    ----------
    stops
        Stops by their index.
    prefix
        Dotted path of the system that has them.
    of
        Name of the line.
    """
    problems: list[Fault] = []
    walls: dict[Side, int] = {}
    for index, stop in stops.items():
        if not isinstance(stop, Wall):
            continue
        first = walls.setdefault(stop.side, index)
        if first != index:
            reason = (
                f"a second wall {stop.side}; stops.{first} at {of} = {stops[first].at} is one,"
                " keep the inner of the two"
            )
            problems.append(Fault(dotted(prefix, f"stops.{index}.side"), stop.side, reason))
    if len(walls) == 2:
        below, above = stops[walls["below"]], stops[walls["above"]]
        if as_float(below.at) >= as_float(above.at):
            reason = f"not above the lower wall at {of} = {below.at}; the walls leave no room"
            problems.append(Fault(dotted(prefix, f"stops.{walls['above']}.at"), above.at, reason))
    for index in walls.values():
        problems += _behind_faults(stops, stops[index], prefix, of)
    return problems


def _behind_faults(
    stops: Mapping[int, Stop], wall: Stop, prefix: str | None, of: str
) -> list[Fault]:
    sign = 1.0 if wall.side == "above" else -1.0
    problems = []
    for index, stop in stops.items():
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
        reason = f"{place} the wall {wall.side} at {of} = {wall.at}, where {effect}"
        problems.append(Fault(dotted(prefix, f"stops.{index}.at"), stop.at, reason))
    return problems


def _side_faults(name: str, side: object) -> list[Fault]:
    if isinstance(side, str) and side in {"above", "below"}:
        return []
    return [Fault(name, side, 'neither "above" nor "below"')]


def _damping_of_ratio(ratio: Exact, stiffness: Exact, mass: Exact) -> Exact:
    raise_first(scale_faults("damping_ratio", ratio))
    if as_fraction(stiffness) <= 0:
        reason = f"needs a stiffness above 0, not {stiffness}; give damping_coefficient"
        raise ParameterError("damping_ratio", ratio, reason)
    size: Exact = square_root(4 * operand(ratio) ** 2 * operand(stiffness) * operand(mass))
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


def stops_in_words(osc: Oscillator) -> str:
    """Return how many stops an oscillator has, for messages about their numbers.

    Examples
    --------
    >>> stops_in_words(impact_oscillator())
    'the oscillator has 1 stop, counted from 0'
    """
    n = len(osc.stops)
    count = "no stops" if n == 0 else "1 stop, counted from 0" if n == 1 else ""
    return f"the oscillator has {count or f'{n} stops, counted from 0'}"
