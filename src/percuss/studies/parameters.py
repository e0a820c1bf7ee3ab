"""``[parameters]`` of a study file, and the numbers that are expressions of them."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from percuss.model.exact import NOT_A_PHASE, Phase, number_problem, phase_problem
from percuss.model.expression import (
    Expression,
    expression_problem,
    name_problem,
    value_problem,
)
from percuss.studies.tables import (
    MISSING,
    Path,
    RawTable,
    StudyFaults,
    exact_phase,
    is_matrix_file,
    raw_table,
    shown,
    words_of_file,
)

# Tables, and their keys, that may be expressions: the numbers of a motion.
_TABLES = ("oscillator", "forcing", "structure", "loads", "start", "run")
_KEYS = frozenset(
    [
        "stiffness",
        "damping",
        "mass",
        "damping_coefficient",
        "damping_ratio",
        "at",
        "restitution",
        "speeds",
        "values",
        "amplitude",
        "omega",
        "phase",
        "constant",
        "hs",
        "tp",
        "period",
        "cos",
        "sin",
        "x0",
        "v0",
        "t0",
        "t_end",
        "periods",
        "frequencies",
        "damping_ratios",
        "masses",
        "springs",
        "dashpots",
        "gap",
        "absorber_mass",
        "absorber_damping",
        "loads_period",
    ]
)

# Those of them that are kept as multiples of pi: angles and times.
_PHASES = frozenset(["phase", "period", "t0", "t_end", "loads_period"])

_OPERATION = re.compile(r"[\w.)]\s*[-+*/]\s*[A-Za-z(]|[a-z]\(")
UNUSED = "no number of the model uses it"
NO_NAMES = "an expression; a parameter is a number, and others are expressions of it"
NO_TABLE = "; a table [parameters] gives them their values"


def with_expressions(document: RawTable, faults: StudyFaults) -> tuple[RawTable, list[str]]:
    """Return a document with expressions for their texts, and the parameters without use.

    Parameters
    ----------
    document
        The tables as `tomllib` reads them.
    faults
        The faults found so far.

    Returns
    -------
    Mapping
        The document itself where no number is an expression.
    list of str
        The parameters that no number uses, where the expressions have no faults.
    """
    numbers = _parameters(document, faults)
    reader = _ExpressionReader(numbers, faults)
    tables = {
        name: reader.converted(document[name], (name,)) for name in _TABLES if name in document
    }
    unused = [] if faults.faults else [name for name in numbers if name not in reader.used]
    return ({**document, **tables} if reader.used or reader.found else document), unused


def _parameters(document: RawTable, faults: StudyFaults) -> dict[str, Any]:
    """Return the parameters; the value of a faulty one is `MISSING`."""
    numbers: dict[str, Any] = {}
    table = raw_table(document, "parameters")
    for name, given in table.items():
        value = exact_phase(given)
        problem = name_problem(name) or value_problem(value)
        if problem is not None:
            if problem == NOT_A_PHASE:
                problem = _problem_of_text(value, list(table))
            faults.add(("parameters", name), words_of_file(problem), shown(given))
        numbers[name] = value if problem is None else MISSING
    return numbers


def _problem_of_text(value: Any, names: list[str]) -> str:
    """Return why a text that is no number is no value of a parameter."""
    problem = expression_problem(value, names)
    if problem is not None:
        return problem if isinstance(value, str) and _OPERATION.search(value) else NOT_A_PHASE
    without_names = expression_problem(value, []) is None
    return (without_names and Expression(value).problem()) or NO_NAMES


class _ExpressionReader:
    """Turns texts into expressions of some parameters."""

    def __init__(self, numbers: Mapping[str, Phase], faults: StudyFaults) -> None:
        self.numbers, self.faults = numbers, faults
        self.used: set[str] = set()
        self.found = False

    def converted(self, value: Any, path: Path) -> Any:
        """Return a table or a list with the expressions in it."""
        if isinstance(value, Mapping):
            # Names of units are no numbers, though a parameter may be called m.
            return {
                key: inner if key == "units" else self.converted(inner, (*path, key))
                for key, inner in value.items()
            }
        if isinstance(value, list):
            return [self.converted(inner, (*path, index)) for index, inner in enumerate(value)]
        keys = [key for key in path if isinstance(key, str)]
        # The matrix of a structure may be the name of a file.
        is_file = keys[0] == "structure" and is_matrix_file(value)
        return self._number(value, path) if keys[-1] in _KEYS and not is_file else value

    def _number(self, value: Any, path: Path) -> Any:
        if not isinstance(value, str) or number_problem(exact_phase(value)) is None:
            return value
        if path[-1] in _PHASES and phase_problem(exact_phase(value)) is None:
            return value
        problem = expression_problem(value, list(self.numbers))
        if problem is not None:
            # A word alone was meant as a number.
            if self.numbers or _OPERATION.search(value):
                hint = "" if self.numbers or "parameter" not in problem else NO_TABLE
                self.faults.add(path, problem.split("; there are none")[0] + hint, shown(value))
            return value
        zeros = tuple((name, 0) for name in self.numbers)
        names = Expression(value, zeros).names
        self.found = True
        self.used.update(names)
        rows = tuple((name, self.numbers[name]) for name in names)
        return MISSING if any(number is MISSING for _, number in rows) else Expression(value, rows)
