"""TeX to MathML."""

from __future__ import annotations

import re
from typing import Literal

from latex2mathml.converter import convert

# Bars are set as operators, with room on both sides.
BAR = re.compile(r"<mo[^>]*>(\||&#x0*7C;)</mo>", re.IGNORECASE)

# The converter leaves no room between a function and what it is of.
NAMES = "arctan|arg|cosh|cos|cot|csc|exp|ln|log|sinh|sin|tanh|tan"
FUNCTION = re.compile(
    rf"((?<!<msup>)(?<!<msub>)<mi>(?:{NAMES})</mi>"
    rf"|<msup><mi>(?:{NAMES})</mi><m[ion]>[^<]*</m[ion]></msup>)(?=<m(?:i|n|frac|sub|sup|sqrt)>)"
)

# Commands of TeX that the converter lacks.
KNOWN = {r"\arg ": r"\operatorname{arg} "}


def mathml(text: str, display: Literal["inline", "block"]) -> str:
    r"""Return a formula as MathML.

    A command that is not known raises ValueError; the converter would show it as it stands.
    """
    for command, known in KNOWN.items():
        text = text.replace(command, known)
    found = convert(text, display=display).replace("\\_", "_")
    if "\\" in found:
        command = found[found.index("\\") :].split("<")[0]
        raise ValueError(f"{command} is not known to the converter")
    found = FUNCTION.sub(r'\1<mspace width="0.17em"/>', found)
    return BAR.sub(r'<mo stretchy="false" lspace="0.05em" rspace="0.05em">\1</mo>', found)
