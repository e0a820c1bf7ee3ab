"""The house in one picture, from its imports: python examples/architecture_picture.py [--out FOLDER].

A package stands above all that it imports. Lines show the imports that no longer way implies.
Needs grimp, which comes with the development requirements.
"""

from __future__ import annotations

import argparse
import importlib
import textwrap
from collections import defaultdict
from pathlib import Path

import grimp
import matplotlib.pyplot as plt

import percuss

# What everything may use; lines to it would hide the others.
COMMON = ("arrays", "errors", "execution", "lazy", "pictures", "processes", "progress", "version")
WIDTH, HEIGHT, GAP = 5.2, 1.5, 0.45


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, default=Path())
    arguments = parser.parse_args()
    below = imports()
    rows = rows_of(below)
    # As many inches as the widest row and the number of rows take.
    width, height = max(map(len, rows)) * (WIDTH + GAP), len(rows) * (HEIGHT + GAP)
    fig, axes = plt.subplots(figsize=(0.58 * width, 0.58 * height), layout="constrained")
    places = {}
    for row, names in enumerate(reversed(rows)):
        for k, name in enumerate(names):
            x = (k - 0.5 * (len(names) - 1)) * (WIDTH + GAP)
            places[name] = (x, -row * (HEIGHT + GAP))
    for name, (x, y) in places.items():
        for other in reduced(name, below):
            x_other, y_other = places[other]
            axes.plot(
                [x, x_other], [y - HEIGHT / 2, y_other + HEIGHT / 2], color="0.6", lw=1, zorder=1
            )
        axes.add_patch(
            plt.Rectangle(
                (x - WIDTH / 2, y - HEIGHT / 2), WIDTH, HEIGHT, fc="#eef3fb", ec="#33527a", zorder=2
            )
        )
        axes.text(x, y + 0.5, name, ha="center", va="center", weight="bold", size=10, zorder=3)
        says = "\n".join(textwrap.wrap(purpose(name), 42))
        axes.text(x, y - 0.18, says, ha="center", va="center", size=7.5, zorder=3)
    axes.set_aspect("equal")
    axes.axis("off")
    axes.autoscale_view()
    arguments.out.mkdir(parents=True, exist_ok=True)
    fig.savefig(arguments.out / "architecture.png", dpi=150)


def imports() -> dict[str, set[str]]:
    """Return what each package of percuss imports of the others."""
    graph = grimp.build_graph("percuss")
    below: dict[str, set[str]] = defaultdict(set)
    for module in graph.modules:
        name = part(module)
        if not name or name.startswith("__") or name in COMMON:
            continue
        others = {part(other) for other in graph.find_modules_directly_imported_by(module)}
        below[name] |= {other for other in others if other and other not in (name, *COMMON)}
    return dict(below)


def part(module: str) -> str:
    """Return which package of percuss a module belongs to, "" for percuss itself."""
    return module.split(".")[1] if "." in module else ""


def rows_of(below: dict[str, set[str]]) -> list[list[str]]:
    """Return the packages in rows, from the ground up: each stands on the row below it."""
    rows: list[list[str]] = []
    placed: set[str] = set()
    while len(placed) < len(below):
        row = sorted(name for name in below if name not in placed and below[name] <= placed)
        assert row, "imports go round in a circle"
        rows.append(row)
        placed |= set(row)
    return rows


def reduced(name: str, below: dict[str, set[str]]) -> set[str]:
    """Return what a package imports and no other of its imports leads to."""

    def reached(start: str) -> set[str]:
        return below[start].union(*(reached(other) for other in below[start]))

    return below[name] - set().union(*(reached(other) for other in below[name]))


def purpose(name: str) -> str:
    """Return the first line of a package's docstring."""
    text = importlib.import_module(f"{percuss.__name__}.{name}").__doc__ or ""
    return text.splitlines()[0].rstrip(".").replace("`", "")


if __name__ == "__main__":
    main()
