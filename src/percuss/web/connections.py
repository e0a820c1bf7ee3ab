"""Connections with a limit on the time in which the head of a request must arrive."""

from __future__ import annotations

import asyncio
from typing import Any

import h11
from uvicorn.protocols.http.h11_impl import H11Protocol

# The head of a request may take so long [s].
PATIENCE = 10.0
# Connections without a complete head, of which the oldest is closed; and connections at all.
MOST_HALF_OPEN, MOST = 256, 800


class BoundedProtocol(H11Protocol):
    """uvicorn's protocol with a clock on the head of each request, and a number of connections."""

    _clock: asyncio.TimerHandle | None = None

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Accept a connection, unless there are too many."""
        super().connection_made(transport)
        if len(self.connections) > MOST:
            transport.abort()
            return
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Forget a connection."""
        self._stop()
        super().connection_lost(exc)

    def data_received(self, data: bytes) -> None:
        """Read data, and start or stop the clock of the head."""
        super().data_received(data)
        if self.transport.is_closing() or self.conn.their_state is not h11.IDLE:
            self._stop()
        elif self._clock is None and self in self.connections:
            self._wait()

    def handle_websocket_upgrade(self, event: h11.Request) -> None:
        """Hand over to a web socket, which has time limits of its own."""
        self._stop()
        super().handle_websocket_upgrade(event)

    @property
    def _half_open(self) -> dict[BoundedProtocol, None]:
        """The connections of the same server that wait for a head, the oldest first."""
        shared: dict[str, Any] = vars(self.server_state)
        waiting: dict[BoundedProtocol, None] = shared.setdefault("half_open", {})
        return waiting

    def _wait(self) -> None:
        self._clock = self.loop.call_later(PATIENCE, self._late)
        self._half_open[self] = None
        if len(self._half_open) > MOST_HALF_OPEN:
            next(iter(self._half_open))._late()

    def _stop(self) -> None:
        self._half_open.pop(self, None)
        if self._clock is not None:
            self._clock.cancel()
            self._clock = None

    def _late(self) -> None:
        self._stop()
        self.transport.abort()
