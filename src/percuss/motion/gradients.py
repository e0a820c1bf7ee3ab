"""The gradient of a measure of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, cast

from percuss.arrays import Floats
from percuss.errors import ParameterError
from percuss.model.exact import Exact, Phase
from percuss.model.forcing import Forcing
from percuss.model.loads import Loads
from percuss.model.moved_law import check_paths
from percuss.model.oscillator import On, Oscillator
from percuss.model.structure import Structure
from percuss.motion.moved_measures import MovedMeasure
from percuss.motion.simulate import simulate


def gradient(
    measure: MovedMeasure,
    osc: Oscillator | Structure,
    force: Forcing | Loads | Mapping[Any, Forcing] | None = None,
    *,
    wrt: Sequence[str],
    on: On | None = None,
    start: Any = None,
    t_end: Phase | None = None,
    periods: Exact | None = None,
    max_impacts: int | None = None,
) -> Floats:
    """Return the gradient of a measure of a run, exact to rounding.

    Parameters
    ----------
    measure
        The measure, as `Sensitivity.of` takes it.
    osc, force
        The oscillator and its forcing, None for free motion; or a structure and its loads.
    wrt
        Paths of the parameters by which it is taken, those of the start among them.
    on
        Of a structure the coordinate, direction or point whose displacement or acceleration it is.
    start, t_end, periods, max_impacts
        Start and limits of the run, as `simulate` takes them. The end after so many periods moves
        with the period and the start, as it does in a sweep; `t_end` moves with its parameters.

    Returns
    -------
    (n_parameters,) array
        The derivatives, in the order of ``wrt``; NaN where the run grazes a wall before.

    Raises
    ------
    ParameterError
        If there is no such measure, or parameter, or the run is none that `simulate` follows.

    Examples
    --------
    The peak of x'' + x = 0 from rest at 0 with velocity 3 is 3:

    >>> import percuss as pc
    >>> pc.gradient("max_displacement", pc.Oscillator(), wrt=["start.v0"], start=(0, 3), t_end=4)
    array([1.])
    """
    check_paths("wrt", wrt)
    limits: dict[str, Any] = {"t_end": t_end, "periods": periods, "max_impacts": max_impacts}
    if isinstance(osc, Structure):
        return simulate(osc, force, start=start, **limits).sensitivity(wrt).of(measure, on)
    if on is not None:
        raise ParameterError("on", on, "of structures; an oscillator has one displacement")
    return simulate(osc, cast("Forcing", force), start=start, **limits).sensitivity(wrt).of(measure)
