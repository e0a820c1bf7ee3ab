"""Trace, determinant and multipliers of an orbit as balls, and the stability that they prove."""

from __future__ import annotations

from dataclasses import dataclass

from flint import acb, arb

from percuss.certified.chain import Link
from percuss.certified.cloud import Matrix
from percuss.certified.law import law_of
from percuss.certified.numbers import span
from percuss.certified.system import System

__all__ = ["Monodromy", "monodromy_of", "multipliers_of", "stability_of"]


@dataclass(frozen=True)
class Monodromy:
    """The derivative over one orbit.

    Attributes
    ----------
    matrix
        Of instant and velocity after the first event, or of (x, v) without events.
    trace, determinant
        The determinant from its closed form.
    conservative
        Whether the determinant is 1 exactly.
    multipliers
        Its eigenvalues, the larger first where that is known.
    stability
        "asymptotic", "elliptic", "parabolic", "unstable" or "undecided".
    """

    matrix: Matrix
    trace: arb
    determinant: arb
    conservative: bool
    multipliers: tuple[acb, acb]
    stability: str


def monodromy_of(
    system: System, chain: list[Link], durations: list[arb], matrix: Matrix
) -> Monodromy:
    """Return the derivative over an orbit with its determinant from the closed form.

    That is the product of r^2 over the impacts times exp(-2 integral of the damping).
    """
    law = law_of(system)
    conservative = True
    factor, decay = arb(1), arb(0)
    for link, duration in zip(chain, durations, strict=True):
        if link.wall:
            path = f"oscillator.stops.{link.stop}.restitution"
            r = law.number(path)
            factor = factor * r * r
            conservative = conservative and r == 1
        region = law.regions[link.after]
        if region.dashpot:
            conservative = False
            decay = decay + region.damping * duration
    determinant = factor if decay.is_zero() else factor * (-2 * decay).exp()
    trace = matrix[0][0] + matrix[1][1]
    return completed(matrix, trace, determinant, conservative=conservative)


def completed(matrix: Matrix, trace: arb, determinant: arb, *, conservative: bool) -> Monodromy:
    """Return a derivative with its multipliers and stability."""
    return Monodromy(
        matrix,
        trace,
        determinant,
        conservative,
        multipliers_of(trace, determinant),
        stability_of(trace, determinant, conservative=conservative),
    )


def multipliers_of(trace: arb, determinant: arb) -> tuple[acb, acb]:
    """Return the roots of z^2 - trace z + determinant.

    Examples
    --------
    >>> [str(value.real) for value in multipliers_of(arb(5), arb(4))]
    ['4.00000000000000', '1.00000000000000']
    """
    if determinant.is_zero():
        return acb(trace), acb(0)
    half = trace / 2
    inside = half * half - determinant
    if inside < 0:
        turn = (-inside).sqrt()
        return acb(half, turn), acb(half, -turn)
    root = acb(inside).sqrt()
    if not inside > 0:
        # Real, equal or a pair: all of these lie in the square.
        size = span(inside.abs_upper().sqrt())
        return acb(half + size, size), acb(half + size, size)
    first = acb(half) - root if half < 0 else acb(half) + root
    return first, acb(determinant) / first


def stability_of(trace: arb, determinant: arb, *, conservative: bool) -> str:
    """Return the stability that trace and determinant prove, at most 1 the determinant.

    Examples
    --------
    >>> stability_of(arb(1), arb("0.5"), conservative=False)
    'asymptotic'
    >>> stability_of(arb(2), arb(1), conservative=True)
    'undecided'
    """
    edge = 1 + determinant
    if abs(trace) > edge:
        return "unstable"
    if abs(trace) < edge:
        if conservative:
            return "elliptic"
        if abs(determinant) < 1:
            return "asymptotic"
    return "undecided"
