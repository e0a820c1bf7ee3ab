"""What stands in for numba's own functions while kernels compile does the same."""

from __future__ import annotations

import inspect
from types import ModuleType
from typing import Any

import pytest
from numba.core import compiler, ir, targetconfig

from percuss.kernels import march, plain, search
from percuss.kernels.compile import OWN, hastened, values, variables_in

OWN_VALUES, OWN_VARIABLES = OWN
# numba has no types of its own.
COMPILER: Any = compiler


def functions_of(module: ModuleType) -> list[Any]:
    found = (getattr(value, "py_func", None) for value in vars(module).values())
    return [function for function in found if inspect.isfunction(function)]


@pytest.mark.parametrize("module", [plain, march, search])
def test_variables_of_every_statement(module: ModuleType) -> None:
    statements = 0
    for function in functions_of(module):
        for block in COMPILER.run_frontend(function).blocks.values():
            for statement in block.body:
                for part in vars(statement).values():
                    found = variables_in(statement, part)
                    own = OWN_VARIABLES(statement, part)
                    assert [(type(it), it.name) for it in found] == [
                        (type(it), it.name) for it in own
                    ]
                statements += 1
    assert statements > 500


def test_values_of_flags_that_are_set_and_of_others() -> None:
    flags = COMPILER.Flags()
    assert values(flags) == OWN_VALUES(flags)
    before = flags.copy()
    flags.nrt = True
    flags.error_model = "numpy"
    assert values(flags) == OWN_VALUES(flags)
    assert list(values(flags)) == list(OWN_VALUES(flags))
    assert values(flags)["nrt"] is True
    with hastened():
        assert flags != before
        assert flags == flags.copy()


def test_numba_has_its_own_back() -> None:
    with hastened():
        assert targetconfig.TargetConfig.values is values
    assert (targetconfig.TargetConfig.values, ir.Inst._rec_list_vars) == OWN
