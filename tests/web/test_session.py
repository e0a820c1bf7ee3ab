"""In each queue one request runs, and one waits."""

from __future__ import annotations

import asyncio
import json
import threading
import time
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from tests.loops import run
from tests.web.frames import read_frame

from percuss.web import session as sessions
from percuss.web.frame import frame
from percuss.web.request import BadRequest, PageRequest, RunningRequest
from percuss.web.session import Schedulers, Session

SCHEDULERS = Schedulers.create()


def message(number: int, kind: str, study: dict[str, Any], **options: Any) -> str:
    return json.dumps({"id": number, "kind": kind, "study": study, **options})


def ids_answered(texts: list[str]) -> list[dict[str, Any]]:
    """Return the headers of the answers to messages that come at once."""
    headers: list[dict[str, Any]] = []

    async def talk() -> None:
        async def send(data: bytes) -> None:
            headers.append(read_frame(data)[0])

        session = Session(send, SCHEDULERS)
        for text in texts:
            await session.receive(text)
            await asyncio.sleep(0)
        for queue in session._queues.values():
            if queue.loop is not None:
                await queue.loop
        await session.close()

    run(talk())
    return headers


def test_of_many_moves_of_a_slider_the_last_is_answered(
    monkeypatch: pytest.MonkeyPatch, study: dict[str, Any]
) -> None:
    begun, gate = threading.Event(), threading.Event()

    def slow(request: PageRequest, _running: RunningRequest) -> bytes:
        begun.set()
        gate.wait(10.0)
        return frame({"id": request.id, "kind": "explore"})

    monkeypatch.setattr(sessions, "answer_explore", slow)
    answered: dict[str, list[int]] = {"one": [], "other": []}

    async def talk() -> None:
        async def move(name: str, numbers: range) -> Session:
            async def send(data: bytes) -> None:
                answered[name].append(read_frame(data)[0]["id"])

            session = Session(send, SCHEDULERS)
            for number in numbers:
                await session.receive(message(number, "explore", study))
                await asyncio.sleep(0)
            return session

        # One client holds the scheduler; the other moves its slider and waits.
        one = await move("one", range(1, 2))
        while not begun.is_set():
            await asyncio.sleep(0.01)
        other = await move("other", range(1, 41))
        await one.receive(message(2, "explore", study))
        gate.set()
        for session in (one, other):
            task = session._queues["explore"].loop
            assert task is not None
            await task

    run(talk())

    assert answered == {"one": [1, 2], "other": [40]}


def test_a_new_job_ends_the_one_before(study: dict[str, Any]) -> None:
    job = {"path": "forcing.omega", "low": 2.5, "high": 2.9, "points": 8}
    headers = ids_answered(
        [
            message(1, "diagram", study, values=8192, **job),
            message(2, "diagram", study, values=64, **job),
        ]
    )

    done = [header["id"] for header in headers if header.get("done")]
    assert done == [2]


def test_a_job_that_fails_before_its_first_frame_is_answered_with_its_fault(
    monkeypatch: pytest.MonkeyPatch, study: dict[str, Any]
) -> None:
    def failing(_request: PageRequest, _running: RunningRequest) -> Iterator[bytes]:
        raise BadRequest("no values")

    monkeypatch.setattr(sessions, "answer_job", failing)
    headers = ids_answered([message(1, "diagram", study), message(2, "diagram", study)])

    assert [(each["id"], each["kind"]) for each in headers] == [(2, "fault")]
    assert "no values" in headers[0]["faults"][0]["reason"]


def test_cancel_ends_a_job_without_a_last_frame(study: dict[str, Any]) -> None:
    job = {"path": "forcing.omega", "low": 2.5, "high": 2.9, "points": 8, "values": 8192}
    headers = ids_answered([message(1, "diagram", study, **job), message(0, "cancel", {})])

    assert not any(header.get("done") for header in headers)


def test_a_proof_and_saddles_do_not_end_a_job_nor_it_them(study: dict[str, Any]) -> None:
    job = {"path": "forcing.omega", "low": 2.5, "high": 2.9, "points": 8, "values": 64}
    headers = ids_answered(
        [
            message(1, "diagram", study, **job),
            message(2, "saddles", study),
            message(3, "certify", study, digits=12),
            message(0, "cancel", {}, queue="saddles"),
        ]
    )

    assert {header["id"] for header in headers if header.get("done")} == {1, 3}


def test_a_job_ends_with_its_client(study: dict[str, Any]) -> None:
    job = {"path": "forcing.omega", "low": 2.5, "high": 2.9, "points": 240, "values": 8192}

    async def talk() -> float:
        async def send(_data: bytes) -> None:
            begun.set()

        begun = asyncio.Event()
        session = Session(send, SCHEDULERS)
        await session.receive(message(1, "diagram", study, **job))
        await begun.wait()
        began = time.monotonic()
        await session.close()
        return time.monotonic() - began

    # Two million points take longer than this, by far.
    assert run(talk()) < 1.0


def test_faults_come_back_with_their_paths(study: dict[str, Any]) -> None:
    study["oscillator"]["damping"] = "x"
    (header,) = ids_answered([message(3, "explore", study)])

    assert header["kind"] == "fault"
    assert header["id"] == 3
    assert header["faults"][0]["path"] == "oscillator.damping"


def test_an_unexpected_exception_is_sent_without_its_details(
    monkeypatch: pytest.MonkeyPatch, study: dict[str, Any]
) -> None:
    def broken(_request: PageRequest, _running: RunningRequest) -> bytes:
        raise ZeroDivisionError("a secret path")

    monkeypatch.setattr(sessions, "answer_explore", broken)
    (header,) = ids_answered([message(3, "explore", study)])

    assert "secret" not in json.dumps(header)
    assert header["kind"] == "fault"


values = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=6), inner, max_size=3)
    ),
    max_leaves=8,
)
tables = st.fixed_dictionaries(
    {},
    optional={
        "oscillator": st.fixed_dictionaries(
            {}, optional={"stiffness": values, "damping": values, "stops": values}
        )
        | values,
        "forcing": st.fixed_dictionaries(
            {}, optional={"constant": values, "harmonics": values, "period": values}
        )
        | values,
        "start": st.fixed_dictionaries({}, optional={"x0": values, "v0": values}) | values,
        "run": st.fixed_dictionaries(
            {}, optional={"periods": values, "t_end": values, "max_impacts": values}
        )
        | values,
    },
)


@settings(max_examples=150, deadline=None, suppress_health_check=list(HealthCheck))
@given(
    kind=st.sampled_from(
        ["explore", "facts", "diagram", "basins", "response", "saddles", "certify", "cancel"]
    )
    | values,
    study=tables | values,
    options=st.dictionaries(
        st.sampled_from(
            ["points", "window", "path", "low", "high", "values", "starts", "digits", "queue"]
        ),
        values,
        max_size=4,
    ),
)
def test_no_message_breaks_a_session(kind: Any, study: Any, options: dict[str, Any]) -> None:
    reported: list[BaseException] = []

    async def talk() -> None:
        async def send(data: bytes) -> None:
            read_frame(data)

        session = Session(send, SCHEDULERS, reported.append)
        await session.receive(json.dumps({"id": 1, "kind": kind, "study": study, **options}))
        for queue in session._queues.values():
            if queue.loop is not None:
                await queue.loop
        await session.close()

    run(talk())
    assert reported == []
