"""The noise of data that came without one, from the residuals of each quantity of each record.

A residual is smaller than its noise, for the parameters follow the noise: it has one degree of
freedom less its leverage. So the sum of squares of a quantity is divided by its number of values
less the sum of their leverages, which are those of the whole fit; the next fit weighs the values by
the noise that was found, until nothing changes (restricted maximum likelihood of the variances;
Patterson and Thompson 1971, Biometrika 58, 545).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.fitting.losses import Loss
from percuss.fitting.measured import MeasuredRecord, MeasuredSamples, quantity_name
from percuss.fitting.shooting import Layout
from percuss.fitting.solver import UNSEEN, WEAK, FitPoint, FitProblem
from percuss.model.oscillator import Oscillator
from percuss.model.structure import Structure
from percuss.numerics.linear import leverages, matmul

# The number of runs of one sign is so many standard deviations below that of noise: residuals that
# hang together.
NOT_WHITE = -4.0
# The median of the squares of normal variables.
MEDIAN_SQUARE = 0.4549364231195724
# The noise of a quantity is estimated beside other data from so many values at least.
FEWEST = 5


def groups_of(samples: MeasuredSamples) -> list[int]:
    """Return the numbers of the quantities of samples."""
    numbers: list[int] = np.unique(samples.quantities).tolist()
    return numbers


def check_noise(osc: Oscillator | Structure, records: Sequence[MeasuredRecord]) -> None:
    """Refuse data without a noise beside others that are too few to show it."""
    tables = [some for record in records for some in (record.samples, record.impacts)]
    if sum(len(groups_of(samples)) for samples in tables) < 2:
        return
    counts: dict[int, int] = {}
    for samples in tables:
        for quantity in samples.quantities[samples.is_estimated].tolist():
            counts[quantity] = counts.get(quantity, 0) + 1
    for quantity, count in counts.items():
        if count < FEWEST:
            name = quantity_name(quantity, osc)
            values = "1 value is" if count == 1 else f"{count} values are"
            reason = f"not given, and {values} too few to estimate it beside other data; give it"
            raise ParameterError(f"noise.{name}", None, reason)


def leverages_of(problem: FitProblem, point: FitPoint) -> Floats:
    """Return the leverage of each residual, in the order of `FitEquations.residuals`.

    Parameters
    ----------
    problem, point
        The fit, and where it has ended: the motion goes on through all nodes.

    Returns
    -------
    array
        (n_values,), 0 to 1; equal shares where chaos takes the derivatives out of all numbers.
    """
    equations, shots, n_p = point.equations, point.shots, len(problem.paths)
    d, free = equations.defects.shape[1], 0
    width = n_p + d * sum(not layout.is_fixed for layout in problem.layouts)
    states, row = np.zeros((len(equations.defects), d, width)), 0
    with np.errstate(over="ignore", invalid="ignore"):
        for layout in problem.layouts:
            state = np.zeros((d, width))
            if not layout.is_fixed:
                state[:, n_p + d * free : n_p + d * (free + 1)] = np.eye(d)
                free += 1
            for k in range(row, row + len(layout)):
                states[k] = state
                state = matmul(shots.end_rows[k, :, n_p:], state)
                state[:, :n_p] += shots.end_rows[k, :, :n_p]
            row += len(layout)
        own = equations.rows[:, n_p:, None] * states[equations.segment]
        matrix = own.sum(axis=1)
    matrix[:, :n_p] += equations.rows[:, :n_p]
    matrix *= problem.loss.weights(equations.right)[:, None]
    priors = np.zeros((len(problem.priors), width))
    for i, (number, _, sigma) in enumerate(problem.priors.tolist()):
        priors[i, int(number)] = 1.0 / sigma
    whole = np.concatenate([matrix, priors])
    whole[:, :n_p][:, (point.values <= problem.low) | (point.values >= problem.high)] = 0.0
    with np.errstate(over="ignore"):
        squares = np.square(whole)
    if not np.isfinite(squares).all():
        return np.full(len(matrix), min(width / len(matrix), 1.0))
    in_order = np.empty(len(matrix))
    in_order[equations.order] = leverages(whole, WEAK)[: len(matrix)]
    return in_order


def _sum_of_squares(residuals: Floats, loss: Loss) -> float:
    """Return the sum of squares; with a loss that bears outliers that of normal ones like most."""
    squares = np.square(residuals)
    if loss.name == "linear" or not len(squares):
        return float(squares.sum())
    return len(squares) * float(np.median(squares)) / MEDIAN_SQUARE


def with_noise_of_residuals(problem: FitProblem, point: FitPoint) -> tuple[list[Layout], float]:
    """Return the records with the noise that residuals have where none was given.

    Parameters
    ----------
    problem, point
        The fit, and where it has ended.

    Returns
    -------
    list of Layout and float
        The records, and the factor by which a noise has changed most, at least 1.
    """
    residuals, rest = point.equations.residuals, 1.0 - leverages_of(problem, point)
    sums: dict[tuple[int, int], Floats] = {}
    row = 0
    for number, layout in enumerate(problem.layouts):
        for samples in (layout.record.samples, layout.record.impacts):
            own = slice(row, row + len(samples))
            row += len(samples)
            for quantity in groups_of(samples):
                # An impact that no motion has says nothing of the noise.
                of = (samples.quantities == quantity) & samples.is_estimated
                of &= residuals[own] != UNSEEN
                square = _sum_of_squares(residuals[own][of] * samples.noise[of], problem.loss)
                sums[number, quantity] = np.array([of.sum(), square, rest[own][of].sum()])
    layouts, most = [], 1.0
    for number, layout in enumerate(problem.layouts):
        tables = []
        for samples in (layout.record.samples, layout.record.impacts):
            noise = samples.noise.copy()
            for quantity in groups_of(samples):
                count, square, freedom = sums[number, quantity].tolist()
                if count < FEWEST:
                    # Too few to say it alone: as large as in the other records.
                    same = [found for (_, other), found in sums.items() if other == quantity]
                    count, square, freedom = np.sum(same, axis=0).tolist()
                of = (samples.quantities == quantity) & samples.is_estimated
                if of.any() and freedom > 0.0 and square > 0.0:
                    size = math.sqrt(square / freedom)
                    change = size / float(noise[of][0])
                    most = max(most, change, 1.0 / change)
                    noise[of] = size
            tables.append(replace(samples, noise=noise))
        record = replace(layout.record, samples=tables[0], impacts=tables[1])
        layouts.append(replace(layout, record=record))
    return layouts, most


def whiteness_of(layouts: Sequence[Layout], residuals: Floats) -> float:
    """Return by how many standard deviations their runs of one sign are more than those of noise.

    Parameters
    ----------
    layouts
        The records.
    residuals
        (n_values,) array, of the samples of each record, then of its impacts.
    """
    runs = mean = variance = 0.0
    row = 0
    for layout in layouts:
        for samples in (layout.record.samples, layout.record.impacts):
            own = residuals[row : row + len(samples)]
            row += len(samples)
            for quantity in groups_of(samples):
                some = _runs_score(own[samples.quantities == quantity])
                runs, mean, variance = runs + some[0], mean + some[1], variance + some[2]
    return (runs - mean) / math.sqrt(variance) if variance > 0.0 else 0.0


def _runs_score(residuals: Floats) -> tuple[float, float, float]:
    """Return the number of runs of one sign, and its mean and variance in a random sequence.

    (Wald and Wolfowitz 1940, Ann. Math. Statist. 11, 147.)
    """
    signs = residuals > 0.0
    n, above = len(signs), int(signs.sum())
    below = n - above
    if above == 0 or below == 0:
        return 1.0, 1.0 + 0.5 * n, 0.25 * max(n - 1, 1)
    mean = 1.0 + 2.0 * above * below / n
    variance = (mean - 1.0) * (mean - 2.0) / max(n - 1, 1)
    return float(1 + np.count_nonzero(signs[1:] != signs[:-1])), mean, variance
