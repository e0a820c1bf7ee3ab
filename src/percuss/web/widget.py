"""The workbench in a notebook cell."""

from __future__ import annotations

import json
from functools import cache
from typing import Any

from percuss.errors import MissingExtraError, ParameterError
from percuss.io.study_text import model_tables
from percuss.model.exact import Exact
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.studies.kinds.motion import Limits, Motion
from percuss.web.cell import Cells
from percuss.web.front import facts_of_page
from percuss.web.modules import modules_in_order, text_of
from percuss.web.presets import presets

__all__ = ["explore"]

PERIODS = 60


def explore(
    osc: Oscillator | None = None,
    force: Forcing | None = None,
    *,
    x0: Exact = 0.0,
    v0: Exact = 0.0,
    periods: Exact = PERIODS,
) -> Any:
    """Return the workbench as a widget: sliders and pictures of a motion, in a notebook.

    Parameters
    ----------
    osc, force
        What moves; default: a motion to begin with.
    x0, v0
        Where it begins [length], [length/time].
    periods
        How many forcing periods are shown.

    Returns
    -------
    anywidget.AnyWidget
        To be shown in a cell; its trait `study` holds the tables of the motion as it is set now.

    Raises
    ------
    MissingExtraError
        If anywidget is missing.
    ParameterError
        If there is no forcing, or no such start.
    """
    try:
        return _widget_class()(_tables(osc, force, x0, v0, periods))
    except ImportError as error:
        raise MissingExtraError("the widget needs anywidget", "notebook") from error


def _tables(
    osc: Oscillator | None, force: Forcing | None, x0: Exact, v0: Exact, periods: Exact
) -> dict[str, Any]:
    """Return the study that a widget begins with."""
    if osc is None:
        return presets()[0].tables
    if force is None:
        raise ParameterError("force", None, "the workbench follows a motion for forcing periods")
    asked = Motion(Start(x0, v0), Limits(periods=periods))
    tables = model_tables(osc, force) | asked.tables()
    plain: dict[str, Any] = json.loads(json.dumps(tables))
    return {name: _without_none(table) for name, table in plain.items()}


def _without_none(table: dict[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in table.items() if value is not None}


@cache
def _widget_class() -> Any:
    import anywidget
    import traitlets

    class Workbench(anywidget.AnyWidget):
        """The page of `percuss serve` in a cell."""

        _esm = text_of("js/widget.js")
        _css = text_of("vendor/uPlot.min.css") + text_of("style.css")
        modules = traitlets.List(modules_in_order()).tag(sync=True)
        facts = traitlets.Dict().tag(sync=True)
        study = traitlets.Dict().tag(sync=True)

        def __init__(self, study: dict[str, Any]) -> None:
            super().__init__(study=study, facts=facts_of_page())

            def say(content: dict[str, Any], buffers: list[bytes]) -> None:
                self.send(content, buffers)

            self.cells = Cells(say)
            self.on_msg(self.cells.take)

        def close(self) -> None:
            """End what is in work, and the widget."""
            self.cells.close()
            super().close()

    return Workbench
