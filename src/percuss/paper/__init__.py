"""Dyskin, Pasternak & Pelinovsky (2012), recomputed and held against evidence.

Needs the extra ``percuss[paper]``: python-flint for ball arithmetic, SymPy for the formulas and
what is deduced from them, and Typst for the PDF.
"""

from importlib.util import find_spec

from percuss.errors import MissingExtraError

for _module, _library in (("flint", "python-flint"), ("sympy", "SymPy"), ("typst", "Typst")):
    try:
        _missing = find_spec(_module) is None
    except ValueError:
        _missing = True
    if _missing:
        raise MissingExtraError(f"the report on the paper needs {_library}", "paper")
