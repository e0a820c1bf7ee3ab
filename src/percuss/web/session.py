"""The requests of one client: each queue holds one that runs and one that waits."""

from __future__ import annotations

import asyncio
import threading
import time
from collections.abc import Awaitable, Callable, Iterator
from dataclasses import dataclass, field

from percuss.errors import ParameterError, PercussError, StudyError
from percuss.web.explore import answer_explore
from percuss.web.facts import answer_facts
from percuss.web.fit_view import answer_measured
from percuss.web.frame import frame
from percuss.web.jobs import JOBS, answer_job
from percuss.web.proof import answer_certify
from percuss.web.record_table import answer_record
from percuss.web.request import BadRequest, PageRequest, RunningRequest, read_request
from percuss.web.saddles import answer_saddles
from percuss.web.scheduler import Scheduler, Task
from percuss.web.structure_view import answer_mechanism, answer_mechanism_facts
from percuss.web.study_file import answer_study_file
from percuss.web.wording import plain

SendBytes = Callable[[bytes], Awaitable[None]]
# Seconds between two reports of progress, and after which a share that has not grown is sent
# again: the client sees that the server is still computing.
PROGRESS_INTERVAL, HEARTBEAT = 0.3, 3.0
# A newer request of the long kinds cancels the one that runs in the same queue.
QUICK = (
    "explore",
    "thumb",
    "beside",
    "facts",
    "mechanism",
    "mechanism_facts",
    "measured",
    "record",
    "study_file",
)
LONG = (*JOBS, "saddles", "certify")
FAILED = "percuss could not compute this; the terminal of the server says more"


@dataclass(frozen=True, slots=True)
class Schedulers:
    """The schedulers of a session: for motions under a slider, quick facts, and long jobs."""

    short: Scheduler
    facts: Scheduler
    long: Scheduler

    @classmethod
    def create(cls) -> Schedulers:
        """Return schedulers for a machine of any size.

        One thread at a time computes motions under sliders: two would wait for each other's lock.
        """
        return cls(Scheduler(1), Scheduler(1), Scheduler(2))

    def close(self) -> None:
        """Cancel all tasks, without waiting for them."""
        for scheduler in (self.short, self.facts, self.long):
            scheduler.close()


class Session:
    """The requests of one client, answered one after another in each queue.

    Parameters
    ----------
    send
        Sends a frame to the client; the next one of a queue waits for it.
    schedulers
        Where the answers are computed.
    report
        Called with each unexpected exception.
    """

    def __init__(
        self,
        send: SendBytes,
        schedulers: Schedulers,
        report: Callable[[BaseException], None] | None = None,
    ) -> None:
        self._report = report
        self._send = send
        short, facts, long = schedulers.short, schedulers.facts, schedulers.long
        self._queues = {
            "explore": RequestQueue(send, short, _once(answer_explore), self._failed),
            "thumb": RequestQueue(send, short, _once(answer_explore), self._failed),
            "beside": RequestQueue(send, short, _once(answer_explore), self._failed),
            "facts": RequestQueue(send, facts, _once(answer_facts), self._failed),
            "measured": RequestQueue(send, facts, _once(answer_measured), self._failed),
            "record": RequestQueue(send, facts, _once(answer_record), self._failed),
            "study_file": RequestQueue(send, facts, _once(answer_study_file), self._failed),
            "mechanism": RequestQueue(send, short, _once(answer_mechanism), self._failed),
            "mechanism_facts": RequestQueue(
                send, facts, _once(answer_mechanism_facts), self._failed
            ),
            "job": RequestQueue(send, long, answer_job, self._failed),
            "saddles": RequestQueue(send, long, answer_saddles, self._failed),
            "certify": RequestQueue(send, long, answer_certify, self._failed),
        }

    async def receive(self, text: str | bytes) -> None:
        """Put the request in a message into its queue."""
        try:
            request = read_request(text, (*QUICK, "cancel", *LONG))
            name = request.choice("queue", ("job", "saddles", "certify"))
        except BadRequest as error:
            faults = [{"path": "", "reason": str(error)}]
            await self._send(frame({"kind": "fault", "faults": faults}))
            return
        if request.kind == "cancel":
            self._queues[name].cancel()
        else:
            self._queues[request.kind if request.kind in self._queues else "job"].put(request)

    async def close(self) -> None:
        """Cancel all requests, and wait until none runs."""
        for queue in self._queues.values():
            await queue.close()

    def _failed(self, request: PageRequest, error: BaseException) -> bytes:
        """Return the frame for a request that has no answer."""
        header = {"id": request.id, "kind": "fault", "of": request.kind}
        if isinstance(error, StudyError):
            return frame({**header, "faults": [_fault(fault) for fault in error.faults]})
        if isinstance(error, ParameterError):
            row = {"path": error.name, "reason": f"{error.value!r:.60}: {plain(error.reason)}"}
            return frame({**header, "faults": [row]})
        if isinstance(error, BadRequest | PercussError):
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
    answer: Callable[[PageRequest, RunningRequest], bytes],
) -> Callable[[PageRequest, RunningRequest], Iterator[bytes]]:
    """Return a function that yields the one frame of an answer."""

    def frames(request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
        yield answer(request, running)

    return frames


@dataclass(slots=True)
class RequestQueue:
    """Answers one request after another; a newer one replaces the one that waits.

    Parameters
    ----------
    send, scheduler
        As in `Session`.
    answer
        Yields the frames of the answer to a request.
    failed
        Returns the frame for a request and the exception that it raised.
    """

    send: SendBytes
    scheduler: Scheduler
    answer: Callable[[PageRequest, RunningRequest], Iterator[bytes]]
    failed: Callable[[PageRequest, BaseException], bytes]
    waiting: PageRequest | None = None
    # The request that runs. It is taken from `waiting` only when its first slice begins, so that
    # the newest one is answered and not the one that was newest when the task was submitted.
    request: PageRequest | None = None
    frames: Iterator[bytes] = field(default_factory=lambda: iter(()))
    running: RunningRequest = field(default_factory=RunningRequest)
    loop: asyncio.Task[None] | None = None
    lock: threading.Lock = field(default_factory=threading.Lock)

    def put(self, request: PageRequest) -> None:
        """Replace the request that waits; cancel the one that runs if the new one is long."""
        with self.lock:
            self.waiting = request
            if request.kind in LONG and self.request is not None:
                self.running.is_cancelled = True
        if self.loop is None or self.loop.done():
            self.loop = asyncio.get_running_loop().create_task(self._answer_all())

    def cancel(self) -> None:
        """Cancel the request that runs, and drop the one that waits."""
        with self.lock:
            self.waiting, self.running.is_cancelled = None, True

    async def close(self) -> None:
        """Cancel all requests, and wait until none runs."""
        self.cancel()
        if self.loop is not None:
            await asyncio.gather(self.loop, return_exceptions=True)

    async def _answer_all(self) -> None:
        while self.waiting is not None:
            with self.lock:
                self.request, self.running = None, RunningRequest()
                running = self.running
            while not running.is_cancelled and (data := await self._frame(running)) is not None:
                if not running.is_cancelled:
                    await self.send(data)

    async def _frame(self, running: RunningRequest) -> bytes | None:
        """Return the next frame of an answer, None after the last; send progress meanwhile."""
        work = asyncio.wrap_future(self.scheduler.submit(lambda task: self._next(running, task)))
        sent, when = running.share, time.monotonic()
        while True:
            done, _ = await asyncio.wait([work], timeout=PROGRESS_INTERVAL)
            if done:
                return work.result()
            is_due = running.share > sent or time.monotonic() - when > HEARTBEAT
            if self.request is not None and is_due and not running.is_cancelled:
                sent, when = running.share, time.monotonic()
                header = {"id": self.request.id, "kind": "progress", "share": sent}
                await self.send(frame(header))

    def _frames(self, request: PageRequest, running: RunningRequest) -> Iterator[bytes]:
        """Yield the frames of an answer; what the answer's own call raises, the first one does."""
        yield from self.answer(request, running)

    def _next(self, running: RunningRequest, task: Task) -> bytes | None:
        """Return the next frame of an answer, None after the last."""
        with self.lock:
            if running.is_cancelled:
                return None
            if self.request is None:
                self.request, self.waiting = self.waiting, None
                assert self.request is not None
                self.frames = self._frames(self.request, running)
            request = self.request
        with running.in_task(task):
            try:
                return next(self.frames, None)
            except Exception as error:  # noqa: BLE001 - reported, and sent to the client
                return self.failed(request, error)
