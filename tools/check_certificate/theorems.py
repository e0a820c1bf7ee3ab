"""The theorem of a certificate.

Proven here: what one of the modules of its kind proves, of the law that the certificate gives. That
the law has a meaning, and a period where it needs one, is section 11.1 of docs/theory/certified.md.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from arithmetic import NotProvenError
from basins import proven_basins
from branches import proven_branch
from chaos import proven_chaos
from flights import Law, TooLongError, Work
from lists import proven_list
from orbits import proven_orbit
from reading import certificate_of, check_period, law_of
from runs import proven_run
from words import equation

KINDS: dict[str, Callable[[Law, Any], str]] = {
    "orbit": proven_orbit,
    "list": proven_list,
    "basins": proven_basins,
    "chaos": proven_chaos,
}


def theorem(text: str) -> str:
    """Return the theorem of a certificate, proven; NotProvenError says why it is not."""
    claims = certificate_of(text)
    Work.states = 0
    try:
        proven = _proven(claims)
    except TooLongError as error:
        raise NotProvenError(str(error)) from None
    return f"{proven}\nWhat moves:\n{equation(claims['law'])}"


def _proven(claims: Any) -> str:
    # The law of a branch is another one at each parameter.
    if claims["kind"] == "branch":
        return proven_branch(claims)
    law = law_of(claims["law"])
    # A run has nothing to do with a period.
    if claims["kind"] == "run":
        return proven_run(law, claims)
    check_period(law)
    return KINDS[claims["kind"]](law, claims)
