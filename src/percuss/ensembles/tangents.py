"""How the exponents of many motions are taken: their plan, and the numbers from what is left."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from percuss.ensembles.lanes import Lanes, Plan
from percuss.kernels import survey

__all__ = ["BLOCKS", "drift_of", "exponents_of", "tangent_plan"]

Floats = NDArray[np.float64]

# Stretches of time whose means tell the error: long against the memory of a motion, and many
# enough to know their spread to a tenth.
BLOCKS = 64
# Halves that differ by more than so many standard errors of their difference do not by chance.
CHANCE = 3.0


def tangent_plan(period: Floats, t0: Floats, transient: int, periods: int) -> Plan:
    """Return the plan of lanes whose exponents are wanted.

    Parameters
    ----------
    period, t0
        (n,) arrays [time]: what transient and periods are multiples of, and the starts.
    transient, periods
        What is left out, and what is measured.
    """
    since = t0 + transient * period
    every = periods / BLOCKS * period
    return Plan(
        since,
        every,
        since + BLOCKS * every,
        section=survey.TANGENTS,
        n_points=BLOCKS + 1,
    )


def exponents_of(lanes: Lanes, plan: Plan) -> tuple[Floats, Floats, Floats, Floats]:
    """Return largest and smallest exponent, the standard error of either, and their sum.

    Parameters
    ----------
    lanes
        What is left of lanes that followed a `tangent_plan`.
    plan
        That plan.

    Returns
    -------
    tuple of (n,) arrays
        In 1/time; -inf where there was a contact, with an error of 0.
    """
    logs = lanes.points[:, :, survey.FIRST]
    shrunk = lanes.points[:, :, survey.SECOND]
    with np.errstate(invalid="ignore"):
        rates = np.diff(logs, axis=1) / plan.every[:, np.newaxis]
        largest = (logs[:, -1] - logs[:, 0]) / (plan.until - plan.since)
        total = (shrunk[:, -1] - shrunk[:, 0]) / (plan.until - plan.since)
        error = rates.std(axis=1, ddof=1) / math.sqrt(BLOCKS)
    # Once all memory is lost the logarithm stays what it is.
    forgotten = np.isneginf(logs[:, -1])
    for values, there in ((largest, -np.inf), (total, -np.inf), (error, 0.0)):
        values[forgotten] = there
    smallest = np.where(forgotten, -np.inf, total - np.where(forgotten, 0.0, largest))
    return largest, smallest, error, total


def drift_of(lanes: Lanes, plan: Plan) -> Floats:
    """Return by how much the largest exponent of the second half differs from that of the first.

    Means of blocks scatter little about a slow transient, so that their spread does not tell of
    it. Halves of equal worth differ by twice the standard error of the whole; 0 stands for what
    is within three times that.

    Parameters
    ----------
    lanes, plan
        As `exponents_of` takes them.

    Returns
    -------
    (n,) array
        In 1/time, >= 0.
    """
    logs = lanes.points[:, :, survey.FIRST]
    with np.errstate(invalid="ignore"):
        rates = np.diff(logs, axis=1) / plan.every[:, np.newaxis]
        error = rates.std(axis=1, ddof=1) / math.sqrt(BLOCKS)
        first, second = rates[:, : BLOCKS // 2], rates[:, BLOCKS // 2 :]
        drift = np.abs(second.mean(axis=1) - first.mean(axis=1))
        # After a contact there is nothing to drift.
        return np.where(drift > 2.0 * CHANCE * error, drift, 0.0)
