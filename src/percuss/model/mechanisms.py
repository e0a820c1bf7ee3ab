"""Structures of few parameters: chains, cantilevers, impact pairs and absorbers."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from fractions import Fraction

from percuss.errors import ParameterError
from percuss.model.exact import (
    Exact,
    PiTimes,
    as_float,
    as_fraction,
    cos_sin,
    kept,
    operand,
    range_problem,
    whole,
)
from percuss.model.exact import plain as plain_number
from percuss.model.faults import (
    Fault,
    check_mapping,
    not_negative_faults,
    positive_faults,
    raise_first,
)
from percuss.model.oscillator import Stop, Wall
from percuss.model.ratios import PI
from percuss.model.restitution import Restitution
from percuss.model.structure import Structure, exact_numbers, one_each
from percuss.model.units import Units
from percuss.numerics import atan2, exp

# An angle whose parts must not leave the range of floats, and which no angle beside it shows.
NOTHING = 1e-200
# The matrices of a beam are full of zeros: of more modes they are no use.
MOST_MODES = 1000


def chain(
    masses: Iterable[Exact],
    springs: Exact | Iterable[Exact],
    dashpots: Exact | Iterable[Exact] = 0,
    stops: Iterable[Stop] = (),
    *,
    points: Mapping[str, Iterable[Exact]] | None = None,
    units: Units | None = None,
) -> Structure:
    """Return masses in a row, each joined to the next, and the first and the last to the ground.

    Parameters
    ----------
    masses
        The n masses [mass], > 0.
    springs
        Stiffnesses [force/length] of the n + 1 springs: from the ground to the first mass, between
        the masses, and from the last to the ground; 0 for none; or one number for all.
    dashpots
        Coefficients [force time/length] of the n + 1 dashpots beside them, of any sign; or one
        number for all.
    stops
        Stops, ``on`` a mass, on a direction such as (1, -1) between two, or at a point.
    points
        Named points, such as ``{"top": [0, 0, 1]}``, each with a number for each mass.
    units
        What the numbers are measured in.

    Returns
    -------
    Structure
        With exact sums of the stiffnesses.

    Raises
    ------
    ParameterError
        If a value is outside its domain, or there is not one spring more than masses.

    Examples
    --------
    >>> chain(masses=[1, 1], springs=[0, 1, 1]).stiffness, chain([1, 1], springs=2).stiffness
    (((1.0, -1.0), (-1.0, 2.0)), ((4.0, -2.0), (-2.0, 4.0)))
    """
    m = exact_numbers("masses", masses)
    raise_first(fault for i, mass in enumerate(m) for fault in positive_faults(f"masses.{i}", mass))
    n = len(m) + 1
    elements = f"the {n} gaps from ground to ground"
    stiffness = one_each("springs", springs, n, elements)
    damping = one_each("dashpots", dashpots, n, elements)
    matrices = m, _tridiagonal(stiffness), _tridiagonal(damping)
    return Structure(*matrices, stops, units, {} if points is None else points)


def _tridiagonal(joints: tuple[Exact, ...]) -> tuple[tuple[Exact, ...], ...]:
    n = len(joints) - 1
    rows: list[list[Exact]] = [[0.0] * n for _ in range(n)]
    for i in range(n):
        rows[i][i] = kept(operand(joints[i]) + operand(joints[i + 1]))
        if i:
            rows[i][i - 1] = rows[i - 1][i] = kept(-operand(joints[i]))
    return tuple(map(tuple, rows))


def impact_pair(
    masses: Iterable[Exact],
    gap: Exact,
    restitution: Restitution = 1.0,
    *,
    springs: Exact | Iterable[Exact] = 0,
    dashpots: Exact | Iterable[Exact] = 0,
    units: Units | None = None,
) -> Structure:
    """Return two masses that hit each other: the second moves in a cavity of the first.

    Parameters
    ----------
    masses
        The two masses [mass], > 0.
    gap
        Distance [length] of either wall from the middle of the cavity, > 0: impacts are where
        x1 - x0 = -gap and gap.
    restitution
        Coefficient of restitution of both walls, in [0, 1], or a `restitution_table`.
    springs, dashpots
        Stiffnesses [force/length] and coefficients [force time/length] from the ground to the
        first mass, between the two, and from the second to the ground; or one number for all.
    units
        What the numbers are measured in.

    Returns
    -------
    Structure
        With stop 0 below at -gap and stop 1 above at gap, on the direction (-1, 1).

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> pair = impact_pair(masses=[1, 2], gap="0.5", restitution="0.7")
    >>> [(stop.at, stop.side, stop.on) for stop in pair.stops]
    [(-0.5, 'below', (-1, 1)), ('0.5', 'above', (-1, 1))]
    """
    both = exact_numbers("masses", masses)
    if len(both) != 2:
        raise_first([Fault("masses", both, f"{len(both)} masses; a pair has two")])
    raise_first(positive_faults("gap", plain_number(gap), "not positive; the walls leave no room"))
    walls = (
        Wall(kept(-operand(gap)), "below", restitution, on=(-1, 1)),
        Wall(gap, "above", restitution, on=(-1, 1)),
    )
    return chain(both, one_each("springs", springs, 3, "the joints"), dashpots, walls, units=units)


def vibro_impact_absorber(
    mass: Exact,
    stiffness: Exact,
    absorber_mass: Exact,
    gap: Exact,
    restitution: Restitution = 1.0,
    *,
    damping: Exact = 0,
    absorber_damping: Exact = 0,
    units: Units | None = None,
) -> Structure:
    """Return a main mass on a spring, and a small mass that is free in a cavity of it.

    Parameters
    ----------
    mass, stiffness
        The main mass [mass] and its spring to the ground [force/length].
    absorber_mass
        The small mass [mass], > 0.
    gap
        Distance [length] of either wall from the middle of the cavity, > 0.
    restitution
        Coefficient of restitution of both walls, in [0, 1], or a `restitution_table`.
    damping
        Coefficient of the main mass's dashpot to the ground [force time/length].
    absorber_damping
        Coefficient of a dashpot between the two [force time/length].
    units
        What the numbers are measured in.

    Returns
    -------
    Structure
        Coordinate 0 is the main mass, 1 the absorber; stop 0 is the lower wall, stop 1 the upper.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> absorber = vibro_impact_absorber(1, 1, absorber_mass="0.01", gap=1, restitution="0.65")
    >>> absorber.mass, absorber.stiffness
    (((1, 0), (0, '0.01')), ((1.0, 0.0), (0.0, 0.0)))
    """
    raise_first(positive_faults("mass", plain_number(mass)))
    raise_first(positive_faults("absorber_mass", plain_number(absorber_mass)))
    joints, dashpots = (stiffness, 0, 0), (damping, absorber_damping, 0)
    return impact_pair(
        (mass, absorber_mass), gap, restitution, springs=joints, dashpots=dashpots, units=units
    )


def cantilever(
    n_modes: int,
    *,
    length: Exact = 1,
    bending_stiffness: Exact = 1,
    mass_per_length: Exact = 1,
    damping_ratio: Exact | Iterable[Exact] = 0,
    points: Mapping[str, Exact] | None = None,
    stops: Iterable[Stop] = (),
    units: Units | None = None,
) -> Structure:
    """Return the first bending modes of a uniform beam that is clamped at one end.

    The modes are those of Euler and Bernoulli: b is a root of cos b cosh b = -1, the frequency
    b^2 sqrt(EI / m) / L^2, the shape cosh - cos - s (sinh - sin) of b times the part of the length
    (Blevins 1979, table 8-1). Roots and shapes have all digits of a double, high modes, too.

    Parameters
    ----------
    n_modes
        Number of modes, which are the coordinates.
    length
        Length L [length].
    bending_stiffness
        Bending stiffness EI [force length^2].
    mass_per_length
        Mass per length m [mass/length].
    damping_ratio
        Fraction of critical damping of each mode, or one number for all.
    points
        By name the place of a point as part of the length, above 0 at the clamp and up to 1 at the
        tip; by default ``{"tip": 1}``.
    stops
        Stops, ``on`` a point by its name.
    units
        What the numbers are measured in.

    Returns
    -------
    Structure
        Its coordinates are the amplitudes of mass-normalised modes.

    Raises
    ------
    ParameterError
        If a value is outside its domain.

    Examples
    --------
    >>> import percuss as pc
    >>> wall = pc.Wall(at="0.01", side="above", restitution="0.6", on="tip")
    >>> beam = cantilever(3, points={"tip": 1, "middle": "0.5"}, stops=[wall])
    >>> (beam.stiffness_matrix.diagonal() ** 0.5).round(6)
    array([ 3.516015, 22.034492, 61.697214])
    >>> beam.direction("middle").round(6)
    array([0.679046, 1.427332, 0.039375])
    """
    n = whole("n_modes", n_modes, 1, MOST_MODES)
    for name, value in (
        ("length", length),
        ("bending_stiffness", bending_stiffness),
        ("mass_per_length", mass_per_length),
    ):
        raise_first(positive_faults(name, plain_number(value)))
    ratios = one_each("damping_ratio", damping_ratio, n, "the modes")
    square = as_fraction(bending_stiffness) / as_fraction(mass_per_length)
    square /= as_fraction(length) ** 4
    offsets = [_root_offset(k) for k in range(1, n + 1)]
    inertia, highest = as_fraction(mass_per_length) * as_fraction(length), _root(n, offsets[-1])
    for what, number in (("mass", inertia), ("highest frequency", highest**4 * square)):
        problem = range_problem(number)
        if problem is not None:
            reason = f"the {what} of such a beam is {problem}; choose other units"
            raise ParameterError("length", length, reason)
    size = math.sqrt(inertia)
    stiffness = [float(_root(k, e) ** 4 * square) for k, e in enumerate(offsets, 1)]
    shapes = {}
    points = {"tip": 1} if points is None else points
    check_mapping("points", points, '{name: place}, such as {"tip": 1}')
    for name, place in points.items():
        raise_first(_place_faults(f"points.{name}", plain_number(place)))
        part = as_fraction(place)
        shapes[name] = [_amplitude(k, e, part) / size for k, e in enumerate(offsets, 1)]
    damping = [
        2.0 * as_float(ratio) * math.sqrt(k) for ratio, k in zip(ratios, stiffness, strict=True)
    ]
    return Structure((1.0,) * n, stiffness, damping, stops, units, shapes)


def _place_faults(name: str, place: object) -> list[Fault]:
    problems = not_negative_faults(name, place, "negative; it is a part of the length, from 0 to 1")
    if not problems and as_float(place) == 0.0:  # type: ignore[arg-type]
        return [Fault(name, place, "at the clamp, where nothing moves")]
    if not problems and as_float(place) > 1.0:  # type: ignore[arg-type]
        return [Fault(name, place, "above 1; it is a part of the length, from 0 to 1")]
    return problems


def _root_offset(k: int) -> float:
    """Return the difference e of the k-th root b of cos b cosh b = -1 and (k - 1/2) pi.

    With it the equation is sin e = -(-1)^k / cosh b, which loses no digits where cosh b is large.
    """
    sign = 1.0 if k % 2 else -1.0
    offset = 0.0
    # Each time the error falls by a third at least, from below 0.4.
    for _ in range(60):
        s = sign * _sech(float(_root(k, offset)))
        offset = atan2(s, math.sqrt((1.0 - s) * (1.0 + s)))
    return offset if abs(offset) > NOTHING else 0.0


def _root(k: int, offset: float) -> Fraction:
    return PI * Fraction(2 * k - 1, 2) + Fraction(offset)


def _sech(b: float) -> float:
    small = exp(-b)
    return 2.0 * small / (1.0 + small * small)


def _amplitude(k: int, offset: float, part: Fraction) -> float:
    """Return the k-th shape, whose mean square is 1, at a part of the length.

    It is (1 - s) e^(b part) / 2 + (1 + s) e^(-b part) / 2 - cos(b part) + s sin(b part): 1 - s is
    as small as e^-b, and its closed form keeps its digits, as cosh - sinh does not.
    """
    b = float(_root(k, offset))
    small = exp(-b)
    cos_e, _ = cos_sin(offset)
    sine = cos_e if k % 2 else -cos_e
    cosine = -_sech(b)
    # cosh b + cos b and (1 - s)(cosh b + cos b), both times 2 e^-b.
    whole_part = 1.0 + small * small + 2.0 * small * cosine
    rest = 2.0 * small * (small + cosine + sine)
    place = float(part)
    growing = 2.0 * exp(b * (place - 1.0)) * (small + cosine + sine) / whole_part
    slope = 1.0 - rest / whole_part
    phase = PiTimes(Fraction(2 * k - 1, 2) * part, Fraction(offset) * part)
    cos_b, sin_b = cos_sin(phase)
    return 0.5 * (growing + (1.0 + slope) * exp(-b * place)) - cos_b + slope * sin_b
