"""Dyskin, Pasternak & Pelinovsky (2012), recomputed and held against evidence.

Needs python-flint, the extra ``percuss[paper]``: what can be proven is proven in ball arithmetic.
"""

from percuss.errors import MissingExtraError

try:
    import flint as _flint  # noqa: F401
except ImportError:
    raise MissingExtraError("the report on the paper needs python-flint", "paper") from None
