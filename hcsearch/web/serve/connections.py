"""Connections: how long each may take to send a request and to take an answer, and which one makes room for a new one.

waitress closes a connection on which nothing has moved for a while. A byte every few seconds is enough to stay, so a
hundred such connections would keep everybody else out. Here the time that counts begins with the first byte of a
request, and a new connection always finds a place: whoever has kept the server waiting for the longest time goes.
"""

from __future__ import annotations

import socket
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from waitress.adjustments import Adjustments
from waitress.channel import HTTPChannel
from waitress.parser import HTTPRequestParser, ParsingError
from waitress.server import TcpWSGIServer


@dataclass(frozen=True)
class Patience:
    """What is expected of those who connect.

    connections : open at once, beyond which one that the server waits for is closed for each new one.
    request : seconds from the first byte of a request to its last. idle : seconds between two requests.
    pace, pace_seconds : an answer of which fewer bytes are taken in so many seconds is ended.
    """

    connections: int = 128
    request: float = 10.0
    idle: int = 60
    pace: int = 64 * 1024
    pace_seconds: float = 30.0


class Parser(HTTPRequestParser):  # type: ignore[misc]
    """Requests of which addresses that cannot be split are refused, as all else that is malformed."""

    def parse_header(self, header_plus: bytes) -> None:
        """Read the lines before the body; ParsingError for malformed ones."""
        try:
            super().parse_header(header_plus)
        except ValueError as error:
            raise ParsingError("Bad URI") from error


class Channel(HTTPChannel):  # type: ignore[misc]
    """A connection that knows since when the server waits for its other end."""

    parser_class = Parser

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._waiting_since = self._paced_at = time.monotonic()
        self._sent = self._sent_then = 0
        self._answering = False
        super().__init__(*arguments, **options)

    def received(self, data: bytes) -> bool:
        """Take what has come; the time of a request begins with its first byte."""
        before = self.request
        taken: bool = super().received(data)
        if self.request is not None and self.request is not before:
            self._waiting_since = time.monotonic()
        return taken

    def service(self) -> None:
        """Answer a request; from then on the server waits: for the answer to be taken, and for the next request."""
        self._answering = True
        try:
            super().service()
        finally:
            self._waiting_since = time.monotonic()
            self._answering = False

    def send(self, data: bytes, do_close: bool = True) -> int:
        """Send what the other end takes, and count it."""
        sent: int = super().send(data, do_close=do_close)
        self._sent += sent
        return sent

    @property
    def waiting_since(self) -> float | None:
        """Since when the server waits for the other end; None while it is the server's turn, or all is over."""
        return None if self.requests or self._answering or self.will_close else self._waiting_since

    def is_late(self, patience: Patience) -> bool:
        """Whether a request is not complete in time, or an answer is taken too slowly; asked about once a second."""
        now, since = time.monotonic(), self.waiting_since
        if self.request is not None and since is not None and now - since > patience.request:
            return True
        if not self.total_outbufs_len:
            self._paced_at, self._sent_then = now, self._sent
        elif now - self._paced_at > patience.pace_seconds:
            taken, self._paced_at, self._sent_then = self._sent - self._sent_then, now, self._sent
            return taken < patience.pace
        return False

    def cut(self) -> None:
        """Let the loop close the connection, also one that takes nothing more; any thread may ask, at any time."""
        self.will_close = True
        connection = self.socket  # None as soon as the loop has closed it
        if connection is not None:
            # else the loop, which closes what can be written to, would never come to it
            with suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)


class Server(TcpWSGIServer):  # type: ignore[misc]
    """A server of waitress with this patience; `application` is a WSGI application, `listening` a socket."""

    channel_class = Channel

    def __init__(
        self, application: Callable[..., Any], listening: socket.socket, patience: Patience, adjustments: dict[str, Any]
    ) -> None:
        self._patience = patience
        # its own limit, at which it takes no more connections, is met where all of them wait for their answers
        limits = {"connection_limit": patience.connections + 50, "channel_timeout": patience.idle}
        super().__init__(
            application,
            _sock=listening,
            bind_socket=False,
            sockinfo=(listening.family, listening.type, listening.proto, listening.getsockname()),
            adj=Adjustments(sockets=[listening], cleanup_interval=1, **limits, **adjustments),
        )

    def handle_accept(self) -> None:
        """Take a connection; where there are more than may be, the one that the server waits for the longest goes."""
        super().handle_accept()
        if len(self.active_channels) <= self._patience.connections:
            return
        waiting = [(since, key) for key, channel in self.active_channels.items() if (since := channel.waiting_since)]
        if len(waiting) > 1:  # else it would be the new one itself
            self.active_channels[min(waiting)[1]].cut()

    def maintenance(self, now: float) -> None:
        """Close connections on which nothing moves, as waitress does, and those that are late."""
        super().maintenance(now)
        for channel in list(self.active_channels.values()):
            if channel.is_late(self._patience):
                channel.cut()
