"""The frames of the article's figures: the numbers printed along their axes.

The source is a text extraction of the article, in which minus signs are lost: numbers that go down
to 0 and up again are negative on one side.
"""

from __future__ import annotations

from percuss.paper.figure import PrintedFrame


def _to(last: int, step: int = 1, first: int = 0) -> tuple[float, ...]:
    """Return the numbers from first to last."""
    return tuple(range(first, last + 1, step))


def _decades(last: int, first: int) -> tuple[float, ...]:
    """Return every second power of ten."""
    return tuple(float(f"1e{power}") for power in range(first, last + 1, 2))


FRAMES: dict[str, tuple[PrintedFrame, ...]] = {
    "fig2": (
        PrintedFrame("a", _to(7), _to(8, 2)),
        PrintedFrame("b", _to(60, first=56), _to(40, 10)),
    ),
    "fig3": (PrintedFrame("", _to(5), (0, 0.5, 1, 1.5)),),
    "fig4": (PrintedFrame("", _to(7), (0, 0.7, 1.4)),),
    "fig5": (PrintedFrame("", _to(8, 2), (0, 5, 10)),),
    "fig6": (
        PrintedFrame("a", (0, 10, 20), (0, 0.4, 0.8), x_end=30),
        PrintedFrame("b", (0, 10, 20), (0, 0.2, 0.4, 0.6, 0.8), x_end=30),
    ),
    "fig7": (
        PrintedFrame("a", (0, 0.5, 1, 1.5), (-1, -0.333, 0.333, 1)),
        PrintedFrame("b", (0, 0.333, 0.667, 1), (-1, -0.333, 0.333, 1)),
    ),
    "fig8": (
        PrintedFrame("a", _to(36, 4), _decades(5, -9)),
        PrintedFrame("b", _to(36, 4), _decades(5, -3)),
    ),
    "fig9": (PrintedFrame("", _to(2), (0, 0.06, 0.12, 0.18, 0.24)),),
    "fig10": (PrintedFrame("", _to(320, 80), (-15, -9, -3, 0, 3, 9), x_end=400),),
    "fig11": (PrintedFrame("", _to(320, 80), _to(12, 3), x_end=400),),
    "fig12": (PrintedFrame("", _to(5), _to(6, 3, first=-6)),),
    "fig13": (PrintedFrame("", _to(30, 10), _decades(7, -3)),),
    "fig14": (PrintedFrame("", _to(900, 100), _to(8, 2, first=-10)),),
    "fig15": (PrintedFrame("", _to(900, 100), _to(8, 2)),),
    "figA1": (
        PrintedFrame("a", _to(3), _to(1, first=-2)),
        PrintedFrame("b", _to(3), _to(2, first=-2)),
    ),
}
