"""The workbench in a notebook cell."""

from __future__ import annotations

import asyncio
import atexit
import json
import re
from collections.abc import Callable, Coroutine
from contextlib import nullcontext
from functools import cache
from importlib import resources
from typing import Any

from percuss.errors import MissingExtraError, ParameterError, PercussError
from percuss.io.study_text import model_tables
from percuss.model.exact import Exact
from percuss.model.forcing import Forcing
from percuss.model.oscillator import Oscillator
from percuss.model.start import Start
from percuss.studies.kinds.motion import Motion
from percuss.studies.tables import Limits
from percuss.web.downloads import QUICK, File, file_of
from percuss.web.page_data import page_data
from percuss.web.presets import presets
from percuss.web.request import BadRequest, PageRequest, RunningRequest, read_request
from percuss.web.scheduler import Task
from percuss.web.session import FAILED, Schedulers, Session
from percuss.web.view_study import VIEWS

PERIODS = 60
# Cells that show one widget and are answered at once.
MOST_VIEWS = 16
_IMPORT = re.compile(r'from "(\.{1,2}/[\w./]+)"')

SendToCells = Callable[[dict[str, Any], list[bytes]], None]


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
        The oscillator and its forcing; default: those of the first preset.
    x0, v0
        Start of the motion [length], [length/time].
    periods
        Number of forcing periods that are shown.

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
    motion = Motion(Start(x0, v0), Limits(periods=periods))
    tables = model_tables(osc, force, motion) | motion.tables()
    plain: dict[str, Any] = json.loads(json.dumps(tables))
    return {name: _without_none(table) for name, table in plain.items()}


def _without_none(value: Any) -> Any:
    """Return a table without the keys that have no value, in all tables inside it too."""
    if isinstance(value, dict):
        return {name: _without_none(part) for name, part in value.items() if part is not None}
    return [_without_none(part) for part in value] if isinstance(value, list) else value


@cache
def _widget_class() -> Any:
    import anywidget
    import traitlets

    class Workbench(anywidget.AnyWidget):
        """The page of `percuss serve` in a cell."""

        _esm = text_of("js/import_texts.js") + text_of("js/widget.js")
        _css = text_of("vendor/uPlot.min.css") + text_of("style.css")
        modules = traitlets.List(modules_in_order()).tag(sync=True)
        facts = traitlets.Dict().tag(sync=True)
        study = traitlets.Dict().tag(sync=True)

        def __init__(self, study: dict[str, Any]) -> None:
            super().__init__(study=study, facts=page_data())

            def send(content: dict[str, Any], buffers: list[bytes]) -> None:
                self.send(content, buffers)

            self.cells = CellSessions(send)
            self.on_msg(self.cells.take)

        def close(self) -> None:
            """Close the sessions, and the widget."""
            self.cells.close()
            super().close()

    return Workbench


class CellSessions:
    """The cells that show a widget, each with a session of its own.

    Parameters
    ----------
    send
        Sends a message, and its buffers, to all of them.
    """

    def __init__(self, send: SendToCells) -> None:
        self._send = send
        self._tasks: set[asyncio.Task[None]] = set()
        self.sessions: dict[str, Session] = {}

    def take(self, _widget: Any, message: dict[str, Any], _buffers: list[Any]) -> None:
        """Answer a message of a cell."""
        kind, view = message.get("kind"), str(message.get("view", ""))[:40]
        if kind == "file":
            self._file(message)
        elif kind == "close":
            self._end(view)
        else:
            self._run(self._session_of(view).receive(str(message.get("text", ""))))

    def close(self) -> None:
        """Close the sessions of all cells."""
        for view in list(self.sessions):
            self._end(view)

    def _end(self, view: str) -> None:
        session = self.sessions.pop(view, None)
        if session is not None:
            self._run(session.close())

    def _run(self, coroutine: Coroutine[Any, Any, None]) -> None:
        try:
            task = asyncio.get_running_loop().create_task(coroutine)
        except RuntimeError:
            # The notebook is gone, and its loop with it.
            coroutine.close()
            return
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _session_of(self, view: str) -> Session:
        """Return the session of a cell; beyond so many the oldest one is closed."""
        if view not in self.sessions:
            while len(self.sessions) >= MOST_VIEWS:
                self._end(next(iter(self.sessions)))

            async def send(data: bytes) -> None:
                self._send({"kind": "frame", "view": view}, [data])

            self.sessions[view] = Session(send, schedulers())
        return self.sessions[view]

    def _file(self, message: dict[str, Any]) -> None:
        answer, extension = {"kind": "file", "id": message.get("id")}, str(message.get("extension"))

        def send(file: File | str) -> None:
            if isinstance(file, File):
                self._send({**answer, "name": file.name}, [file.data])
            else:
                self._send({**answer, "fault": file}, [])

        async def compute(request: PageRequest) -> None:
            file = schedulers().long.submit(lambda task: _file_or_fault(request, extension, task))
            send(await asyncio.wrap_future(file))

        try:
            request = read_request(
                json.dumps(message.get("request")), ("motion", "mechanism", *VIEWS)
            )
        except BadRequest as error:
            send(str(error))
            return
        if extension in QUICK:
            send(_file_or_fault(request, extension))
        else:
            self._run(compute(request))


def _file_or_fault(request: PageRequest, extension: str, task: Task | None = None) -> File | str:
    """Return a file, or the reason why there is none."""
    running = RunningRequest()
    try:
        with running.in_task(task) if task else nullcontext():
            return file_of(request, extension, running)
    except (BadRequest, PercussError) as error:
        return str(error)
    except Exception:  # noqa: BLE001 - reported without its details
        return FAILED


@cache
def schedulers() -> Schedulers:
    """Return the schedulers that all widgets share."""
    shared = Schedulers.create()
    atexit.register(shared.close)
    return shared


def text_of(name: str) -> str:
    """Return the text of a static file."""
    return (resources.files("percuss.web") / "static" / name).read_text("utf-8")


def modules_in_order(first: str = "js/main.js") -> list[list[str]]:
    """Return the page's scripts as [name, text], each after those that it imports.

    A notebook cell has no address to import them from: the widget makes one for each text in turn,
    and puts them in place of the names.

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
        text = text_of(name)
        for imported in _IMPORT.findall(text):
            visit(_resolved(name, imported))
        named = _IMPORT.sub(lambda match: f'from "percuss:{_resolved(name, match[1])}"', text)
        order.append([name, named])

    visit(first)
    return order


def _resolved(name: str, imported: str) -> str:
    """Return the name of a script that another one imports by a relative name."""
    parts = name.split("/")[:-1]
    for part in imported.split("/"):
        if part == "..":
            parts.pop()
        elif part != ".":
            parts.append(part)
    return "/".join(parts)
