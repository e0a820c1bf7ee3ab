"""The workbench in a notebook cell."""

from __future__ import annotations

import asyncio
import atexit
import json
import re
from collections.abc import Coroutine
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib import resources
from typing import Any

from percuss.errors import MissingExtraError, ParameterError, PercussError
from percuss.io.study_text import model_tables
from percuss.model.exact import Exact
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.studies.kinds.motion import Limits, Motion
from percuss.web.asked import ASKED, asked_study
from percuss.web.downloads import file_of
from percuss.web.presets import presets
from percuss.web.question import BadQuestion, read_question
from percuss.web.session import Pools, Session

__all__ = ["explore"]

PERIODS = 60
# What computes: see `Pools`.
THREADS = ((1, "slider"), (1, "facts"), (2, "job"))
# Views of one widget that answer at once.
MOST_VIEWS = 16
_IMPORT = re.compile(r'from "(\.{1,2}/[\w./]+)"')


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

        _esm = _text("js/widget.js")
        _css = _text("vendor/uPlot.min.css") + _text("style.css")
        modules = traitlets.List(modules_in_order()).tag(sync=True)
        facts = traitlets.Dict().tag(sync=True)
        study = traitlets.Dict().tag(sync=True)

        def __init__(self, study: dict[str, Any]) -> None:
            rows = [{"name": p.name, "title": p.title, "caption": p.caption, "study": p.tables}
                    for p in presets()]  # fmt: skip
            super().__init__(study=study, facts={"presets": rows, "report": False, "figures": {}})
            self._sessions: dict[str, Session] = {}
            self._tasks: set[asyncio.Task[None]] = set()
            self.on_msg(self._take)

        def close(self) -> None:
            """End what is in work, and the widget."""
            for view in list(self._sessions):
                self._end(view)
            super().close()

        def _end(self, view: str) -> None:
            session = self._sessions.pop(view, None)
            if session is not None:
                self._run(session.close())

        def _run(self, work: Coroutine[Any, Any, None]) -> None:
            try:
                task = asyncio.get_running_loop().create_task(work)
            except RuntimeError:
                # The notebook is gone, and with it what was in work.
                work.close()
                return
            self._tasks.add(task)
            task.add_done_callback(self._tasks.discard)

        def _session_of(self, view: str) -> Session:
            """Return the session of a cell that shows the widget; the oldest gives way."""
            if view not in self._sessions:
                while len(self._sessions) >= MOST_VIEWS:
                    self._end(next(iter(self._sessions)))

                async def give(data: bytes) -> None:
                    self.send({"kind": "frame", "view": view}, buffers=[data])

                self._sessions[view] = Session(give, _pools())
            return self._sessions[view]

        def _take(self, _widget: Any, message: dict[str, Any], _buffers: list[Any]) -> None:
            kind, view = message.get("kind"), str(message.get("view", ""))[:40]
            if kind == "file":
                self._file(message)
            elif kind == "close":
                self._end(view)
            else:
                self._run(self._session_of(view).receive(str(message.get("text", ""))))

        def _file(self, message: dict[str, Any]) -> None:
            answer = {"kind": "file", "id": message.get("id")}
            try:
                question = read_question(json.dumps(message.get("question")), ("motion", *ASKED))
                made = file_of(asked_study(question), str(message.get("extension")))
            except (BadQuestion, PercussError) as error:
                self.send({**answer, "fault": str(error)})
            else:
                self.send({**answer, "name": made.name}, buffers=[made.data])

    return Workbench


@cache
def _pools() -> Pools:
    pools = Pools(*(ThreadPoolExecutor(n, name) for n, name in THREADS))
    for pool in (pools.short, pools.facts, pools.long):
        atexit.register(pool.shutdown, wait=False)
    return pools


def _text(name: str) -> str:
    return (resources.files("percuss.web") / "static" / name).read_text("utf-8")


def modules_in_order(first: str = "js/main.js") -> list[list[str]]:
    """Return the page's modules as [name, text], each after those that it imports.

    A cell has no address to import from: the widget makes one for each text in turn, and puts
    them in place of the names.

    Examples
    --------
    >>> [name for name, _ in modules_in_order()][-1]
    'js/main.js'
    """
    order: list[list[str]] = []
    seen: set[str] = set()

    def visit(name: str) -> None:
        if name in seen:
            return
        seen.add(name)
        text = _text(name)
        for imported in _IMPORT.findall(text):
            visit(_resolved(name, imported))
        named = _IMPORT.sub(lambda match: f'from "percuss:{_resolved(name, match[1])}"', text)
        order.append([name, named])

    visit(first)
    return order


def _resolved(name: str, imported: str) -> str:
    """Return the name of a module that another one imports by a relative one."""
    parts = name.split("/")[:-1]
    for part in imported.split("/"):
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)
