"""What is wrong with measurements before any motion is fitted to them."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from percuss.errors import ParameterError
from percuss.fitting.measured import MeasuredRecord, quantity_name
from percuss.fitting.noise import groups_of
from percuss.kernels.segments import OF_STOP
from percuss.kernels.structure.segments import OF_PLACE
from percuss.model.oscillator import Oscillator
from percuss.model.structure import Structure
from percuss.motion.trajectory import beyond_record_of

# A record at rest has so many equal values at least.
FEWEST_AT_REST = 3
# Forces of a stop that push towards it: so many of them at least, and so many times the others.
FEWEST_TURNED, MUCH_TURNED = 5, 10.0
# Samples in a period of the force: below the first the time has another unit, below the second the
# samples do not show the motion, so that their residuals say nothing of the noise.
LEAST_SAMPLES, FEW_SAMPLES = 0.5, 3.0


def check_plausible(osc: Oscillator | Structure, records: Sequence[MeasuredRecord]) -> None:
    """Refuse records at rest, forces of the wrong sign, and times that have another unit.

    Raises
    ------
    ParameterError
        With what was found.
    """
    _check_motion(osc, records)
    for record in records:
        _check_signs(osc, record)
        rate = samples_a_period(record)
        if rate < LEAST_SAMPLES:
            reason = (
                f"{rate:.2g} samples in a period of the force, {_period(record):.6g}; are the times in "
                "the units of the model?"
            )
            raise ParameterError("data.t", record.begin, reason)


def too_coarse(records: Sequence[MeasuredRecord]) -> str:
    """Return why no motion can be trusted to be that of records without a noise; empty if it can."""
    for record in records:
        rate = samples_a_period(record)
        if rate < FEW_SAMPLES and record.samples.is_estimated.any():
            return (
                f"{rate:.2g} samples in a period of the force do not show the motion: other motions "
                "pass through them, too; give their noise, by which the fit is judged"
            )
    return ""


def beyond_force(records: Sequence[MeasuredRecord]) -> str:
    """Return that data go beyond the samples of a measured force; empty where none do.

    It may be free motion after a pulse, or the clocks of two loggers that differ.
    """
    texts = (beyond_record_of(record.force, record.begin, record.end) for record in records)
    return next((f"of the force {text}" for text in texts if text), "")


def samples_a_period(record: MeasuredRecord) -> float:
    """Return the number of instants in a period of the force; infinite without one."""
    t = np.unique(record.samples.t)
    period = _period(record)
    if len(t) < 2 or len(record.impacts) or not 0.0 < period < math.inf:
        return math.inf
    return (len(t) - 1) * period / float(t[-1] - t[0])


def _period(record: MeasuredRecord) -> float:
    force = record.force
    if force is None or force.is_constant or force.period is None:
        return math.inf
    return float(force.period)


def _check_motion(osc: Oscillator | Structure, records: Sequence[MeasuredRecord]) -> None:
    """Refuse records that are all at rest."""
    still: list[tuple[str, float]] = []
    for record in records:
        if len(record.impacts):
            return
        for quantity in groups_of(record.samples):
            values = record.samples.values[record.samples.quantities == quantity]
            if len(values) < FEWEST_AT_REST or float(np.ptp(values)) > 0.0:
                return
            still.append((quantity_name(quantity, osc), float(values[0])))
    if still:
        name, value = still[0]
        raise ParameterError(
            f"data.{name}", value, "the same at all instants; rest tells no parameters"
        )


def _check_signs(osc: Oscillator | Structure, record: MeasuredRecord) -> None:
    """Refuse forces of stops that push the mass towards the stop."""
    for quantity in groups_of(record.samples):
        which = quantity % int(OF_PLACE) - int(OF_STOP)
        if not 0 <= which < len(osc.stops):
            continue
        side = osc.stops[which].side
        values = record.samples.values[record.samples.quantities == quantity]
        towards = values if side == "above" else -values
        turned, right = towards[towards > 0.0], -towards[towards < 0.0]
        if len(turned) >= FEWEST_TURNED and float(turned.sum()) > MUCH_TURNED * float(right.sum()):
            sign = "negative" if side == "above" else "positive"
            reason = (
                f"pushes towards the stop; that of a stop {side} on the mass is {sign}: turn the "
                "sign of the column"
            )
            worst = float(values[int(np.argmax(towards))])
            raise ParameterError(f"data.{quantity_name(quantity, osc)}", worst, reason)
