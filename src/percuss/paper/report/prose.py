"""Plain sentences with formulas in them, as HTML with the signs of mathematics."""

from __future__ import annotations

import re
from html import escape

WORDS = {
    "xi": "ξ",
    "pi": "π",
    "omega": "ω",
    "Omega": "Ω",
    "rho": "&rho;",
    "tau": "τ",
    "lambda": "λ",
    "psi": "ψ",
    "phi": "φ",
    "eps": "ε",
    "sigma": "&sigma;",
}
SIGNS = {
    "&lt;=": "≤",
    "&gt;=": "≥",
    "-&gt;": "→",
    "+-": "±",
    "&#x27;&#x27;": "&Prime;",
    " - ": " &minus; ",
}
SYMBOL = "[A-Za-zξπωΩτψφ]"
# In order: braces of indices, the paper's frequencies, names of letters, roots, indices, exponents,
# primes, negative numbers.
RULES = (
    (r"([_^])\{([^{}]*)\}", r"\1(\2)"),
    (r"(?<![A-Za-z_])[wW]([+-])(?=[\s^/),.;:=]|$)", r"<i>ω</i><sub>\1</sub>"),
    (r"(?<![A-Za-z_])k([+-])(?=[\s^/),.;:=]|$)", r"<i>k</i><sub>\1</sub>"),
    (r"(?<![A-Za-z])W_r(?![A-Za-z])", r"<i>Ω</i><sub>r</sub>"),
    (rf"(?<![A-Za-z])({'|'.join(WORDS)})(?![A-Za-z])", lambda found: WORDS[found[1]]),
    (r"(?<=[0-9]) (?=[πψ])", ""),
    (r"\bsqrt\s?(?=[\w(])", "√"),
    (rf"(?<![A-Za-z])({SYMBOL})_([A-Za-z]+|[0-9]+|[+-](?![0-9]))", r"<i>\1</i><sub>\2</sub>"),
    (rf"(?<![A-Za-z])({SYMBOL})_\(([^()]+)\)", r"<i>\1</i><sub>\2</sub>"),
    (r"(?<![A-Za-z])([VYtx])([0-9])(?![0-9]|\.[0-9])", r"<i>\1</i><sub>\2</sub>"),
    (r"\^\(([^()]+)\)", r"<sup>\1</sup>"),
    (r"\^(-?\w+(?:\.[0-9]+)?)", r"<sup>\1</sup>"),
    (rf"(?<![A-Za-z])({SYMBOL})&#x27;", r"\1&prime;"),
    (r"(?<=</sub>)&#x27;", "&prime;"),
    (r"(?<![0-9]e)(?<=[A-Za-z)>])-(?=[0-9])", "&minus;"),
    (r"(?<![\w.\-<>/])-(?=[\w.(])", "&minus;"),
    (r"(?<=<su[bp]>)-", "&minus;"),
)


def prose(text: str) -> str:
    """Return a sentence as HTML.

    Parameters
    ----------
    text
        Plain text; formulas are written as in a program: V_k, t^2, sqrt t, pi, x''.

    Returns
    -------
    str
        Escaped, with Greek letters, indices, exponents and signs.

    Examples
    --------
    >>> prose("V_k >= pi/2, x'' + x = sin t, O(V^-2) & sqrt t")
    '<i>V</i><sub>k</sub> ≥ π/2, x&Prime; + x = sin t, O(V<sup>&minus;2</sup>) &amp; √t'
    """
    html = escape(text)
    for plain, sign in SIGNS.items():
        html = html.replace(plain, sign)
    for pattern, replacement in RULES:
        html = re.sub(pattern, replacement, html)
    return html


def sentence(text: str) -> str:
    """Return a text with a capital and a full stop.

    Examples
    --------
    >>> sentence("the phase stands still"), sentence("V_k grows")
    ('The phase stands still.', 'V_k grows.')
    """
    stripped = text.strip().rstrip(".")
    # A symbol stays as it is.
    first = stripped.split(" ", 1)[0]
    begun = stripped[:1].upper() + stripped[1:] if first.isalpha() and len(first) > 2 else stripped
    return f"{begun}." if stripped else ""
