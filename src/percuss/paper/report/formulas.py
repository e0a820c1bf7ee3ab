"""Formulas as small SVG pictures in the colour of the text around them."""

from __future__ import annotations

import re
from functools import cache
from html import escape
from typing import Any

# Units of matplotlib's outlines an em of the text.
SIZE = 100.0
MARGIN = 3.0
CODES = {1: "M", 2: "L", 3: "Q", 4: "C"}
POINTS = {1: 1, 2: 1, 3: 2, 4: 3}
CLOSE = 79
FRACTION = r"\frac"
# Of the signs that the formulas of this process have used, by their names.
OUTLINES: dict[str, str] = {}


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


def display(formula: str) -> str:
    r"""Return a formula with the fractions that stand in no other at the size of a display.

    Examples
    --------
    >>> display(r"\frac{\frac{a}{b}}{c} + \frac{1}{2}")
    '\\dfrac{\\frac{a}{b}}{c} + \\dfrac{1}{2}'
    """
    parts, depth, i = [], 0, 0
    while i < len(formula):
        if depth == 0 and formula.startswith(FRACTION, i):
            parts.append(r"\dfrac")
            i += len(FRACTION)
            continue
        depth += {"{": 1, "}": -1}.get(formula[i], 0)
        parts.append(formula[i])
        i += 1
    return "".join(parts)


def glyphs(page: str) -> str:
    """Return the outlines of all signs that the formulas of a page use, once each.

    Parameters
    ----------
    page
        HTML with formulas in it.

    Returns
    -------
    str
        An SVG element that takes no room.
    """
    outline = outlines(page)
    return f'<svg class="glyphs" aria-hidden="true">{outline}</svg>' if outline else ""


def outlines(text: str) -> str:
    """Return the outlines of all signs that the formulas of a text use, as SVG's definitions.

    Parameters
    ----------
    text
        What `formula_svg` returned, alone or with anything around it.

    Returns
    -------
    str
        A ``defs`` element, empty where no sign is used.
    """
    used = dict.fromkeys(re.findall(r'<use href="#g-([\w-]+)"', text))
    paths = "".join(f'<path id="g-{name}" d="{OUTLINES[name]}"/>' for name in used)
    return f"<defs>{paths}</defs>" if used else ""


def _line(text: str) -> str:
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    label = escape(text, quote=True)
    # mathtext sets no space before the name of a function.
    spaced = re.sub(r"(?<=[\w)}\]])\s*(?=\\(?:sin|cos|tan)\b)", r"\\,", display(text))
    font = FontProperties(math_fontfamily="cm")
    try:
        placed, shapes, bars = text_to_path.get_glyphs_mathtext(font, f"${spaced}$")
    except ValueError:
        return f"<code>{label}</code>"
    for name, (vertices, codes) in shapes.items():
        OUTLINES.setdefault(name, _outline(vertices, codes))
    signs = "".join(
        f'<use href="#g-{name}" transform="translate({x:.0f} {-y:.0f}) scale({scale:.3g})"/>'
        for name, x, y, scale in placed
    )
    lines = "".join(_outline(vertices, codes) for vertices, codes in bars)
    x, y, width, height = _box(placed, shapes, bars)
    return (
        f'<svg class="formula" role="img" aria-label="{label}" '
        f'viewBox="{x:.0f} {y:.0f} {width:.0f} {height:.0f}" '
        f'style="width:{width / SIZE:.3f}em;height:{height / SIZE:.3f}em">'
        f'{signs}<path d="{lines}"/></svg>'
    )


def _box(placed: Any, shapes: Any, bars: Any) -> tuple[float, float, float, float]:
    """Return left, top, width and height of a formula, with a margin; y points down."""
    import numpy as np

    parts = [
        np.asarray(shapes[name][0]) * scale + (x, y)
        for name, x, y, scale in placed
        if len(shapes[name][0])
    ]
    # The last point of a bar only closes it.
    parts += [np.asarray(vertices[:-1]) for vertices, _ in bars]
    points = np.vstack(parts)
    (left, low), (right, high) = points.min(axis=0) - MARGIN, points.max(axis=0) + MARGIN
    return float(left), float(-high), float(right - left), float(high - low)


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
        numbers = (f"{x:.0f} {-y:.0f}" for x, y in points[i : i + count])
        parts.append(CODES[kind] + " ".join(numbers))
        i += count
    return "".join(parts)
