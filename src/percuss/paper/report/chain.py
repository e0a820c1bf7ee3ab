"""The derivation from (27) to (35), line by line, and what falls with the line at which it breaks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape

from percuss.paper.chain import LINES, ChainLine
from percuss.paper.claim import Claim
from percuss.paper.dependence import DEPENDS, LABELS, falls_with
from percuss.paper.report.claims import badge, formula_pair
from percuss.paper.report.prose import prose

# Of the graph, in its own units: a box, and the gaps between boxes and between layers.
BOX, HEIGHT, GAP, RISE = 160, 32, 20, 36


def chain(claims: Mapping[str, Claim]) -> str:
    """Return the derivation as a section; empty where no line of it was examined."""
    if not any(line.record in claims for line in LINES):
        return ""
    broken = next((line.record for line in LINES if line.is_break), "")
    return (
        '<section id="chain"><h2>The derivation from (27) to (35), line by line</h2>'
        f"{derivation(LINES, claims)}<h3>What follows from what</h3>"
        "<p>Each arrow leads from a statement to one that is derived from it. Those with a heavy "
        "frame are derived from the line at which the derivation breaks; the colour is the verdict "
        f"that each has by itself.</p>{dependence_graph(DEPENDS, broken, claims)}</section>"
    )


def derivation(lines: Sequence[ChainLine], claims: Mapping[str, Claim]) -> str:
    """Return the lines as a list, printed beside right."""
    rows = "".join(_line(line, claims) for line in lines)
    return f'<ol class="chain">{rows}</ol>'


def _line(line: ChainLine, claims: Mapping[str, Claim]) -> str:
    said = ""
    if line.record in claims:
        claim = claims[line.record]
        said = f'<a href="#{escape(claim.id)}">{escape(claim.reference)}</a> {badge(claim)} '
    broken = '<p class="break">Here the derivation breaks.</p>' if line.is_break else ""
    right = line.formula.tex(right=True) if line.formula.right is not None else ""
    survives = f" What survives: {line.survives}" if line.survives else ""
    return (
        f"<li{' class=broken' if line.is_break else ''}>{broken}"
        f"<p>{said}{prose(line.step + survives)}</p>"
        f"{formula_pair(line.formula.tex(), right)}</li>"
    )


def _layers(depends: Mapping[str, Sequence[str]]) -> list[list[str]]:
    """Return the statements by the longest way on which they are derived."""
    names = list(dict.fromkeys([*(use for uses in depends.values() for use in uses), *depends]))
    depth = dict.fromkeys(names, 0)
    for _ in names:
        for name, uses in depends.items():
            depth[name] = max([depth[name], *(depth[use] + 1 for use in uses)])
    last = max(depth.values(), default=0)
    return [[name for name in names if depth[name] == k] for k in range(last + 1)]


def dependence_graph(
    depends: Mapping[str, Sequence[str]], broken: str, claims: Mapping[str, Claim]
) -> str:
    """Return the graph of what is derived from what, as an inline SVG.

    Parameters
    ----------
    depends
        For each record those that it is derived from; it has no circles.
    broken
        Id of the record at which the derivation breaks.
    claims
        What was examined: it gives the colours and the links.
    """
    layers = _layers(depends)
    fallen = {broken, *falls_with(broken, depends)}
    width = max(map(len, layers), default=0) * (BOX + GAP) + GAP
    height = len(layers) * (HEIGHT + RISE)
    place = {
        name: (
            width / 2 + (i - (len(layer) - 1) / 2) * (BOX + GAP),
            k * (HEIGHT + RISE) + HEIGHT / 2 + 2,
        )
        for k, layer in enumerate(layers)
        for i, name in enumerate(layer)
    }
    edges = ((use, name) for name, uses in depends.items() for use in uses)
    return (
        f'<div class="scroll"><svg class="graph" viewBox="0 0 {width} {height}" '
        f'style="width:{width}px" role="group" aria-label="What follows from what">'
        f"{_arrows(edges, place)}"
        f"{''.join(_node(name, place[name], name in fallen, claims) for name in place)}</svg></div>"
    )


def _arrows(edges: Iterable[tuple[str, str]], place: Mapping[str, tuple[float, float]]) -> str:
    lines = "".join(
        f'<line x1="{place[a][0]:g}" y1="{place[a][1] + HEIGHT / 2:g}" x2="{place[b][0]:g}" '
        f'y2="{place[b][1] - HEIGHT / 2 - 3:g}" marker-end="url(#tip)"/>'
        for a, b in edges
    )
    tip = (
        '<defs><marker id="tip" viewBox="0 0 8 8" refX="6" refY="4" markerWidth="7" '
        'markerHeight="7" orient="auto"><path d="M0 0L8 4L0 8Z"/></marker></defs>'
    )
    return f"{tip}{lines}"


def _node(name: str, at: tuple[float, float], is_fallen: bool, claims: Mapping[str, Claim]) -> str:
    claim = claims.get(name)
    kind, words = (claim.kind, claim.reference) if claim else ("undecided", name)
    said = f"<title>{escape(claim.claim)}</title>" if claim else ""
    label = LABELS.get(name, words)
    box = (
        f'<g class="{kind}{" fallen" if is_fallen else ""}">{said}<rect x="{at[0] - BOX / 2:g}" '
        f'y="{at[1] - HEIGHT / 2:g}" width="{BOX}" height="{HEIGHT}" rx="6"/>'
        f'<text x="{at[0]:g}" y="{at[1] + 5:g}" text-anchor="middle">{escape(label)}</text></g>'
    )
    if claim is None:
        return box
    page = "" if claim.scope == "article" else "beyond.html"
    return f'<a href="{page}#{escape(name)}">{box}</a>'
