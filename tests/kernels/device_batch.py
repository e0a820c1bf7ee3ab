"""A batch as a kernel for a CUDA device: one thread follows one motion.

Run as a program it says what it has found, as JSON: ``types`` type-checks and lowers the kernels
named after it for the CUDA target, for which neither a device nor its libraries are needed;
``values`` runs one in the simulator.
"""

from __future__ import annotations

import importlib
import json
import sys
from types import SimpleNamespace
from typing import Any

import numpy as np

import percuss as pc
from percuss.kernels import batch, lockstep, members, observables
from percuss.kernels import record as columns
from percuss.kernels.linear_observables import Scratch
from percuss.model.system import law, stop_rows

# numba has no types for these.
cuda: Any = importlib.import_module("numba.cuda")
types: Any = importlib.import_module("numba.types")

MOST_IMPACTS, PATIENCE = 1_000, 20_000


def follow_on_device(arrays: Any, buffers: Any, section: int, with_extremes: bool) -> None:
    """Follow the motion of this thread to its end; each thread has a workspace of its own."""
    i = cuda.grid(1)
    laws, which, states, counters, status, plans, values, points, stops = arrays
    if i < status.shape[0]:
        motions = batch.Batch(laws, which, states, counters, status, plans, values, points, stops)
        events, marks, grazes, phases, derived = buffers
        search = Scratch(phases[i, 3], phases[i, 4], phases[i, 5], phases[i, 6], phases[i, 7])
        loads = observables.LoadSpace(derived[i], derived[i, 0], search)
        workspace = batch.Workspace(events[i], marks[i], grazes[i], phases[i, :3], loads)
        options = members.Options(
            MOST_IMPACTS, section, with_extremes, with_extremes, False, False, PATIENCE
        )
        member = batch.member_of(motions, workspace, i)
        members.begin_member(member, options)
        status[i] = members.follow(member, options, False)


def broken_on_device(numbers: Any) -> None:
    """Add a number to a text: what a check of types must refuse."""
    numbers[0] = numbers[0] + "1"


def _checked(function: Any, arguments: tuple[Any, ...]) -> str:
    """Type-check and lower for the CUDA target; return what is wrong, or an empty text."""
    compiler: Any = importlib.import_module("numba.cuda.compiler")
    dispatcher: Any = importlib.import_module("numba.cuda.dispatcher")
    templates: Any = importlib.import_module("numba.core.typing.templates")
    utils: Any = importlib.import_module("numba.core.utils")
    errors: Any = importlib.import_module("numba.core.errors")

    # Asked for its generation only; there need not be one.
    device = SimpleNamespace(compute_capability=(7, 0))
    dispatcher.get_current_device = lambda: device
    whole = dispatcher.CUDADispatcher.get_call_template

    def with_varargs(self: Any, args: Any, kws: Any) -> Any:
        # From 0.66 on max and min take *args, which numba's own CUDA target passes on unfolded
        # (github.com/numba/numba/issues/10753).
        folded = templates.fold_arguments(
            utils.pysignature(self.py_func),
            tuple(args),
            dict(kws),
            lambda _i, _parameter, value: value,
            lambda _i, _parameter, default: types.Omitted(default),
            lambda _i, _parameter, values: types.StarArgTuple(values),
        )
        return whole(self, folded, {})

    dispatcher.CUDADispatcher.get_call_template = with_varargs
    try:
        compiler.compile_cuda(function, types.void, arguments, cc=(7, 0))
    except errors.NumbaError as error:
        return f"{type(error).__name__}: {error}"
    finally:
        dispatcher.CUDADispatcher.get_call_template = whole
    return ""


def _types(*names: str) -> dict[str, str]:
    def array(kind: Any, n: int) -> Any:
        return types.Array(kind, n, "C")

    real, whole = types.float64, types.int64
    arrays = types.Tuple(
        [
            *(array(real, 3), array(whole, 1), array(real, 2), array(whole, 2)),
            *(array(whole, 1), array(real, 2), array(real, 2), array(real, 3)),
            array(real, 3),
        ]
    )
    buffers = types.Tuple(
        [array(real, 3), array(whole, 3), array(real, 3), array(real, 4), array(real, 3)]
    )
    kernels = {
        "follow": (follow_on_device, (arrays, buffers, whole, types.boolean)),
        "lockstep": (_round_on_device, (array(real, 1),)),
        "broken": (broken_on_device, (array(real, 1),)),
    }
    return {name: _checked(*kernels[name]) for name in names}


def _round_on_device(block: Any) -> None:
    lockstep.fly_round(block)


def _values() -> dict[str, list[Any]]:
    osc, force = pc.impact_oscillator(restitution=0.8), pc.cosine(2.8)
    starts = np.array([(0.0, 1.0, 0.0), (0.7, -2.0, 0.0), (2.9, 0.3, 0.2)])
    n = len(starts)
    states = np.zeros((n, columns.STATE_ENTRIES))
    states[:, [columns.X, columns.V, columns.T]] = starts
    arrays = (
        law(osc, force)[np.newaxis],
        np.zeros(n, dtype=np.int64),
        states,
        np.zeros((n, columns.COUNTERS), dtype=np.int64),
        np.full(n, batch.NEW, dtype=np.int64),
        np.tile([0.0, 1.0, 9.0], (n, 1)),
        np.zeros((n, observables.N_OBSERVABLES)),
        np.full((n, 40, observables.POINT_COLUMNS), np.nan),
        stop_rows(osc)[np.newaxis],
    )
    buffers = (
        np.zeros((n, batch.BUFFER, columns.EVENT_COLUMNS)),
        np.zeros((n, batch.BUFFER, columns.MARK_COLUMNS), dtype=np.int64),
        np.zeros((n, batch.GRAZES, columns.GRAZE_COLUMNS)),
        np.zeros((n, 8, 1, 2)),
        np.zeros((n, *arrays[0].shape[1:])),
    )
    cuda.jit(follow_on_device)[2, 2](arrays, buffers, observables.IMPACT_POINTS, False)
    counts = arrays[3][:, columns.N_IMPACTS]
    runs = [pc.simulate(osc, force, *start, t_end=9.0).impacts for start in starts]
    return {
        "status": arrays[4].tolist(),
        "speeds": [arrays[7][i, : counts[i], observables.SECOND].tolist() for i in range(n)],
        "expected": [run.v_after.tolist() for run in runs],
    }


if __name__ == "__main__":
    what, *names = sys.argv[1:]
    print(json.dumps(_types(*names) if what == "types" else _values()))  # noqa: T201
