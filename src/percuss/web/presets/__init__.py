"""Named motions to begin with: study files, each with a caption in the comment on top."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any

__all__ = ["Preset", "presets"]

# Which of them show the figures of the paper.
FIGURES = {
    "fig2": "fig02",
    "fig3": "fig03",
    "fig5": "fig05",
    "fig6": "fig06_below",
    "fig7": "fig06_below",
    "fig8": "fig06_below",
    "fig9": "fig09",
    "fig10": "fig10",
    "fig11": "fig10",
    "fig12": "fig10",
    "fig13": "fig10",
    "fig14": "fig14",
    "fig15": "fig14",
}


@dataclass(frozen=True, slots=True)
class Preset:
    """A motion with a name.

    Parameters
    ----------
    name
        Name of its file.
    title, caption
        What it is, in a few words and in a sentence or two.
    tables
        The study.
    """

    name: str
    title: str
    caption: str
    tables: dict[str, Any]


@cache
def presets() -> tuple[Preset, ...]:
    """Return all presets, the one to begin with first.

    Returns
    -------
    tuple of Preset
        In the order of the gallery.

    Examples
    --------
    >>> presets()[0].name
    'first_impacts'
    """
    files = [file for file in resources.files(__name__).iterdir() if file.name.endswith(".toml")]
    every = [_preset(file.name.removesuffix(".toml"), file.read_text("utf-8")) for file in files]
    return tuple(sorted(every, key=lambda preset: (preset.name != "first_impacts", preset.name)))


def _preset(name: str, text: str) -> Preset:
    lines = text.splitlines()
    comment = []
    while lines and lines[0].startswith("#"):
        comment.append(lines.pop(0).lstrip("# "))
    tables = tomllib.loads(text)
    return Preset(name, tables.pop("study")["title"], " ".join(comment), tables)
