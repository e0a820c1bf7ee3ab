"""Formulas as small SVG pictures in the colour of the text around them."""

from __future__ import annotations

import re
from functools import cache
from html import escape

__all__ = ["formula_svg"]

# Points a letter of the formula is high; the picture is scaled to the text by its em.
SIZE = 10.0
CODES = {1: "M", 2: "L", 3: "Q", 4: "C"}
POINTS = {1: 1, 2: 1, 3: 2, 4: 3}
CLOSE = 79


@cache
def formula_svg(formula: str) -> str:
    """Return a formula in matplotlib's mathtext as an inline SVG, one line each.

    Parameters
    ----------
    formula
        Mathtext without dollar signs; lines are separated by newlines.

    Returns
    -------
    str
        SVG elements that take the colour and the size of the text; a line that is no mathtext
        stands as it is.

    Examples
    --------
    >>> formula_svg("x^2")[:30]
    '<svg class="formula" role="img'
    """
    return "".join(_line(line.strip()) for line in formula.splitlines() if line.strip())


def _line(text: str) -> str:
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import TextPath

    label = escape(text, quote=True)
    # mathtext sets no space before the name of a function.
    spaced = re.sub(r"(?<=[\w)}\]])\s*(?=\\(?:sin|cos|tan)\b)", r"\\,", text)
    try:
        path = TextPath(
            (0.0, 0.0), f"${spaced}$", size=SIZE, prop=FontProperties(math_fontfamily="cm")
        )
    except ValueError:
        return f"<code>{label}</code>"
    box = path.get_extents()
    width, height = box.width + 1.0, box.height + 1.0
    view = f"{box.x0 - 0.5:.2f} {-box.y1 - 0.5:.2f} {width:.2f} {height:.2f}"
    return (
        f'<svg class="formula" role="img" aria-label="{label}" viewBox="{view}" '
        f'style="width:{width / SIZE:.3f}em;height:{height / SIZE:.3f}em">'
        f'<path d="{_outline(path.vertices, path.codes)}"/></svg>'
    )


def _outline(vertices: object, codes: object) -> str:
    """Return the outline in SVG's words; its y axis points down."""
    import numpy as np

    points, kinds = np.asarray(vertices), np.asarray(codes)
    parts, i = [], 0
    while i < len(kinds):
        kind = int(kinds[i])
        if kind == CLOSE:
            parts.append("Z")
            i += 1
            continue
        count = POINTS[kind]
        numbers = (f"{x:.2f} {-y:.2f}" for x, y in points[i : i + count])
        parts.append(CODES[kind] + " ".join(numbers))
        i += count
    return "".join(parts)
