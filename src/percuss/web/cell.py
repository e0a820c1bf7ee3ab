"""What a widget and the cells that show it say to each other."""

from __future__ import annotations

import asyncio
import atexit
import json
from collections.abc import Callable, Coroutine
from contextlib import nullcontext
from functools import cache
from typing import Any

from percuss.errors import PercussError
from percuss.web.asked import ASKED
from percuss.web.downloads import QUICK, File, file_of
from percuss.web.handle import Handle
from percuss.web.question import BadQuestion, PageQuestion, read_question
from percuss.web.session import FAILED, Pools, Session
from percuss.web.turns import Turn

__all__ = ["Cells"]

# Cells that show one widget and answer at once.
MOST_VIEWS = 16

SendFrame = Callable[[dict[str, Any], list[bytes]], None]


class Cells:
    """The cells that show a widget, each with its questions.

    Parameters
    ----------
    send
        Takes a message, and its buffers, to all of them.
    """

    def __init__(self, send: SendFrame) -> None:
        self._send = send
        self._tasks: set[asyncio.Task[None]] = set()
        self.sessions: dict[str, Session] = {}

    def take(self, _widget: Any, message: dict[str, Any], _buffers: list[Any]) -> None:
        """Take a message of a cell."""
        kind, view = message.get("kind"), str(message.get("view", ""))[:40]
        if kind == "file":
            self._file(message)
        elif kind == "close":
            self._end(view)
        else:
            self._run(self._session_of(view).receive(str(message.get("text", ""))))

    def close(self) -> None:
        """End what is in work."""
        for view in list(self.sessions):
            self._end(view)

    def _end(self, view: str) -> None:
        session = self.sessions.pop(view, None)
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
        """Return the session of a cell; the oldest gives way."""
        if view not in self.sessions:
            while len(self.sessions) >= MOST_VIEWS:
                self._end(next(iter(self.sessions)))

            async def give(data: bytes) -> None:
                self._send({"kind": "frame", "view": view}, [data])

            self.sessions[view] = Session(give, pools())
        return self.sessions[view]

    def _file(self, message: dict[str, Any]) -> None:
        answer, extension = {"kind": "file", "id": message.get("id")}, str(message.get("extension"))

        def say(made: File | str) -> None:
            if isinstance(made, File):
                self._send({**answer, "name": made.name}, [made.data])
            else:
                self._send({**answer, "fault": made}, [])

        async def compute(question: PageQuestion) -> None:
            work = pools().long.submit(lambda turn: _made(question, extension, turn))
            say(await asyncio.wrap_future(work))

        try:
            question = read_question(json.dumps(message.get("question")), ("motion", *ASKED))
        except BadQuestion as error:
            say(str(error))
            return
        if extension in QUICK:
            say(_made(question, extension))
        else:
            self._run(compute(question))


def _made(question: PageQuestion, extension: str, turn: Turn | None = None) -> File | str:
    """Return a file, or why there is none."""
    handle = Handle()
    try:
        with handle.during(turn) if turn else nullcontext():
            return file_of(question, extension, handle)
    except (BadQuestion, PercussError) as error:
        return str(error)
    except Exception:  # noqa: BLE001 - told without its details
        return FAILED


@cache
def pools() -> Pools:
    """Return what computes for all widgets."""
    made = Pools.made()
    atexit.register(made.close)
    return made
