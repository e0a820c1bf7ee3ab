"""One client's questions: in each lane one in work and one waiting."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass, field

from percuss.errors import ParameterError, PercussError, StudyError
from percuss.web.explore import answer_explore
from percuss.web.facts import answer_facts
from percuss.web.frame import frame
from percuss.web.handle import Handle
from percuss.web.jobs import JOBS, answer_job
from percuss.web.proof import answer_certify
from percuss.web.question import BadQuestion, PageQuestion, read_question
from percuss.web.saddles import answer_saddles
from percuss.web.turns import Turn, Turns
from percuss.web.wording import plain

__all__ = ["FAILED", "Pools", "Session"]

SendBytes = Callable[[bytes], Awaitable[None]]
# Seconds between two reports of progress.
TELLING = 0.3
# Seconds after which a share that has not grown is told again: the work goes on.
QUIET = 3.0
# What a newer question of its kind ends.
LONG = (*JOBS, "saddles", "certify")
FAILED = "percuss could not compute this; the terminal of the server says more"


@dataclass(frozen=True, slots=True)
class Pools:
    """Where answers are computed: what a slider waits for, what takes a moment, what takes long."""

    short: Turns
    facts: Turns
    long: Turns

    @classmethod
    def made(cls) -> Pools:
        """Return pools for a machine of any size.

        One thread at a time computes what sliders wait for: two would wait for each other's lock.
        """
        return cls(Turns(1), Turns(1), Turns(2))

    def close(self) -> None:
        """End all work, without waiting for it."""
        for turns in (self.short, self.facts, self.long):
            turns.close()


class Session:
    """The questions of one client, answered one after another in each lane.

    Parameters
    ----------
    send
        Takes a frame to the client; the next one of a lane waits for it.
    pools
        Where the answers are computed.
    report
        Called with an exception that should not have been.
    """

    def __init__(
        self, send: SendBytes, pools: Pools, report: Callable[[BaseException], None] | None = None
    ) -> None:
        self._report = report
        self._lanes = {
            "explore": Lane(send, pools.short, _once(answer_explore), self._failed),
            "thumb": Lane(send, pools.short, _once(answer_explore), self._failed),
            "facts": Lane(send, pools.facts, _once(answer_facts), self._failed),
            "job": Lane(send, pools.long, answer_job, self._failed),
            "saddles": Lane(send, pools.long, answer_saddles, self._failed),
            "certify": Lane(send, pools.long, answer_certify, self._failed),
        }
        self._send = send

    async def receive(self, text: str | bytes) -> None:
        """Take a message; what it asks is answered when its lane is free."""
        try:
            question = read_question(text, ("explore", "thumb", "facts", "cancel", *LONG))
            lane = question.choice("lane", ("job", "saddles", "certify"))
        except BadQuestion as error:
            await self._send(
                frame({"kind": "fault", "faults": [{"path": "", "reason": str(error)}]})
            )
            return
        if question.kind == "cancel":
            self._lanes[lane].cancel()
        else:
            self._lanes[question.kind if question.kind in self._lanes else "job"].ask(question)

    async def close(self) -> None:
        """Drop what is waiting, and wait for what is in work."""
        for lane in self._lanes.values():
            await lane.close()

    def _failed(self, question: PageQuestion, error: BaseException) -> bytes:
        """Return the frame for a question that has no answer."""
        header = {"id": question.id, "kind": "fault", "of": question.kind}
        if isinstance(error, StudyError):
            return frame({**header, "faults": [_fault(fault) for fault in error.faults]})
        if isinstance(error, ParameterError):
            row = {"path": error.name, "reason": f"{error.value!r:.60}: {plain(error.reason)}"}
            return frame({**header, "faults": [row]})
        if isinstance(error, BadQuestion | PercussError):
            return frame({**header, "faults": [{"path": "", "reason": plain(str(error))}]})
        if self._report is not None:
            self._report(error)
        return frame({**header, "faults": [{"path": "", "reason": FAILED}]})


def _fault(fault: object) -> dict[str, str]:
    path = getattr(fault, "path", "")
    reason = plain(getattr(fault, "reason", str(fault)))
    value = getattr(fault, "value", "")
    return {"path": path, "reason": f"{value}: {reason}" if value else reason}


def _once(
    answer: Callable[[PageQuestion, Handle], bytes],
) -> Callable[[PageQuestion, Handle], Iterator[bytes]]:
    """Return an answer of one frame as one of many."""

    def frames(question: PageQuestion, handle: Handle) -> Iterator[bytes]:
        yield answer(question, handle)

    return frames


@dataclass(slots=True)
class Lane:
    """Answers one question after another; a newer one replaces the one that waits.

    Parameters
    ----------
    send, pool
        As in `Session`.
    answer
        From a question to the frames of its answer.
    failed
        From a question and what it raised to a frame.
    """

    send: SendBytes
    pool: Turns
    answer: Callable[[PageQuestion, Handle], Iterator[bytes]]
    failed: Callable[[PageQuestion, BaseException], bytes]
    waiting: PageQuestion | None = None
    # In work: None until its turn has begun, so that the newest is answered and not the one that
    # was newest a round ago.
    question: PageQuestion | None = None
    frames: Iterator[bytes] = field(default_factory=lambda: iter(()))
    handle: Handle = field(default_factory=Handle)
    task: asyncio.Task[None] | None = None
    lock: threading.Lock = field(default_factory=threading.Lock)

    def ask(self, question: PageQuestion) -> None:
        """Put a question in the place of the one that waits."""
        with self.lock:
            self.waiting = question
            if question.kind in LONG and self.question is not None:
                # The answer to the one before is wanted no more.
                self.handle.is_stopped = True
        if self.task is None or self.task.done():
            self.task = asyncio.get_running_loop().create_task(self._work())

    def cancel(self) -> None:
        """End what is in work, and drop what waits."""
        with self.lock:
            self.waiting, self.handle.is_stopped = None, True

    async def close(self) -> None:
        """End what is in work, and wait for its end."""
        self.cancel()
        if self.task is not None:
            await asyncio.gather(self.task, return_exceptions=True)

    async def _work(self) -> None:
        while self.waiting is not None:
            with self.lock:
                self.question, handle = None, Handle()
                self.handle = handle
            while not handle.is_stopped and (data := await self._frame(handle)) is not None:
                if not handle.is_stopped:
                    await self.send(data)

    async def _frame(self, handle: Handle) -> bytes | None:
        """Return the next frame of an answer, None after the last; tell the progress meanwhile."""
        work = asyncio.wrap_future(self.pool.submit(lambda turn: self._next(handle, turn)))
        told, when = handle.share, time.monotonic()
        while True:
            done, _ = await asyncio.wait([work], timeout=TELLING)
            if done:
                return work.result()
            is_news = handle.share > told or time.monotonic() - when > QUIET
            if self.question is not None and is_news and not handle.is_stopped:
                told, when = handle.share, time.monotonic()
                header = {"id": self.question.id, "kind": "progress", "share": told}
                await self.send(frame(header))

    def _next(self, handle: Handle, turn: Turn) -> bytes | None:
        """Return the next frame of an answer, None after the last."""
        with self.lock:
            if handle.is_stopped:
                return None
            if self.question is None:
                self.question, self.waiting = self.waiting, None
                assert self.question is not None
                self.frames = self.answer(self.question, handle)
            question = self.question
        with handle.during(turn):
            try:
                return next(self.frames, None)
            except Exception as error:  # noqa: BLE001 - told to the client, and reported
                return self.failed(question, error)
