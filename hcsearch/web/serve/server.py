"""The server: a socket, threads that answer, time limits of connections, and a clean shutdown.

waitress closes idle connections only. A byte every few seconds keeps a connection open, so a hundred such connections
would shut out all others. Here the time limit of a request begins with its first byte, and a new connection is always
accepted: the connection for which the server has waited longest is closed.
"""

from __future__ import annotations

import errno
import logging
import socket
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from typing import Any

from waitress.adjustments import Adjustments
from waitress.channel import HTTPChannel
from waitress.parser import HTTPRequestParser, ParsingError
from waitress.server import TcpWSGIServer

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database


@dataclass(frozen=True)
class ConnectionLimits:
    """The limits for clients.

    max_connections : largest number of open connections; beyond it, a new one closes one for which the server waits.
    request_seconds : from the first byte of a request to its last. idle_seconds : between two requests.
    min_bytes_per_pace, pace_seconds : an answer is ended if the client takes fewer bytes in this time.
    """

    max_connections: int = 128
    request_seconds: float = 10.0
    idle_seconds: int = 60
    min_bytes_per_pace: int = 64 * 1024
    pace_seconds: float = 30.0


class Parser(HTTPRequestParser):  # type: ignore[misc]
    """A parser of requests that treats addresses that cannot be split as malformed."""

    def parse_header(self, header_plus: bytes) -> None:
        """Parse the header; ParsingError if it is malformed."""
        try:
            super().parse_header(header_plus)
        except ValueError as error:
            raise ParsingError("Bad URI") from error


class Channel(HTTPChannel):  # type: ignore[misc]
    """A connection that records since when the server waits for the client."""

    parser_class = Parser

    def __init__(self, *arguments: Any, **options: Any) -> None:
        self._waiting_since = self._paced_at = time.monotonic()
        self._sent = self._sent_then = 0
        self._answering = False
        super().__init__(*arguments, **options)

    def received(self, data: bytes) -> bool:
        """Process received data; the time limit of a request begins with its first byte."""
        earlier_request = self.request
        accepted: bool = super().received(data)
        if self.request is not None and self.request is not earlier_request:
            self._waiting_since = time.monotonic()
        return accepted

    def service(self) -> None:
        """Answer a request; afterwards the server waits for the client to take the answer and to send a request."""
        self._answering = True
        try:
            super().service()
        finally:
            self._waiting_since = time.monotonic()
            self._answering = False

    def send(self, data: bytes, do_close: bool = True) -> int:
        """Send data and count the bytes that the client takes."""
        sent: int = super().send(data, do_close=do_close)
        self._sent += sent
        return sent

    @property
    def waiting_since(self) -> float | None:
        """The time since which the server waits for the client; None while it answers, or if the connection closes."""
        return None if self.requests or self._answering or self.will_close else self._waiting_since

    def is_late(self, patience: ConnectionLimits) -> bool:
        """Return whether a request is overdue or its answer is taken too slowly; called about once a second."""
        now, since = time.monotonic(), self.waiting_since
        if self.request is not None and since is not None and now - since > patience.request_seconds:
            return True
        if not self.total_outbufs_len:
            self._paced_at, self._sent_then = now, self._sent
        elif now - self._paced_at > patience.pace_seconds:
            taken_bytes, self._paced_at, self._sent_then = self._sent - self._sent_then, now, self._sent
            return taken_bytes < patience.min_bytes_per_pace
        return False

    def cut(self) -> None:
        """Make the loop close the connection, even if the client takes no more data; thread-safe."""
        self.will_close = True
        connection = self.socket  # None after the loop has closed it
        if connection is not None:
            # otherwise the loop, which closes only writable connections, would never reach it
            with suppress(OSError):
                connection.shutdown(socket.SHUT_RDWR)


class Server(TcpWSGIServer):  # type: ignore[misc]
    """A waitress server with limits for clients; `application` is a WSGI application, `listening` a socket."""

    channel_class = Channel

    def __init__(
        self,
        application: Callable[..., Any],
        listening: socket.socket,
        patience: ConnectionLimits,
        adjustments: dict[str, Any],
    ) -> None:
        self._patience = patience
        # waitress accepts no connections at its own limit, which is reached only if all await answers
        limits = {"connection_limit": patience.max_connections + 50, "channel_timeout": patience.idle_seconds}
        super().__init__(
            application,
            _sock=listening,
            bind_socket=False,
            sockinfo=(listening.family, listening.type, listening.proto, listening.getsockname()),
            adj=Adjustments(sockets=[listening], cleanup_interval=1, **limits, **adjustments),
        )

    def handle_accept(self) -> None:
        """Accept a connection; above the limit, close the one for which the server has waited longest."""
        super().handle_accept()
        if len(self.active_channels) <= self._patience.max_connections:
            return
        waiting = [(since, key) for key, channel in self.active_channels.items() if (since := channel.waiting_since)]
        if len(waiting) > 1:  # otherwise it would be the new one itself
            self.active_channels[min(waiting)[1]].cut()

    def maintenance(self, now: float) -> None:
        """Close idle connections, as waitress does, and late ones."""
        super().maintenance(now)
        for channel in list(self.active_channels.values()):
            if channel.is_late(self._patience):
                channel.cut()


WAITRESS_SETTINGS = {
    "threads": 32,
    "ident": "hcsearch",
    "max_request_header_size": 32 * 1024,
    "max_request_body_size": 1024,
    "clear_untrusted_proxy_headers": True,
}
"""Settings of waitress. Computations occupy at most four threads, slow lists twelve, downloads of all rows three; the
others stay free for quick answers."""


def open_socket(host: str, port: int) -> socket.socket:
    """Open a listening socket on a port, 0 for any free one; HcsearchError with the remedy on failure."""
    try:
        family, _, _, _, socket_address = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        return socket.create_server(socket_address[:2], family=family, backlog=128)
    except (OSError, UnicodeError) as error:
        raise HcsearchError(_remedy(host, port, error)) from error


def _remedy(host: str, port: int, error: Exception) -> str:
    code = error.errno if isinstance(error, OSError) else None
    if isinstance(error, socket.gaierror | UnicodeError) or code == errno.EADDRNOTAVAIL:
        return f"this machine has no address {host!r}: leave out --host, or give one of its own"
    if code == errno.EADDRINUSE:
        return f"port {port} is in use: stop who uses it, or give another with --port"
    if code == errno.EACCES:
        return f"port {port} may not be used: give one above 1023 with --port"
    return f"cannot listen on {host} port {port} ({error}): give another --port"


def socket_address(listening: socket.socket, host: str) -> str:
    """Return the address to open in a browser."""
    port = listening.getsockname()[1]
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


def shorten_log_record(record: logging.LogRecord) -> bool:
    """Reduce the log record of an answer cut off by an HcsearchError to one line; faults keep tracebacks."""
    error = record.exc_info[1] if record.exc_info else None
    if isinstance(error, HcsearchError):
        record.msg, record.args, record.exc_info = f"hcsearch: {record.getMessage()}: {error}", (), None
    return True


def run_server(
    database: Database,
    db: str,
    listening: socket.socket,
    *,
    host: str,
    scene: str = DEFAULT_SCENE_NAME,
    started: Callable[[], None] = lambda: None,
) -> None:
    """Answer requests until KeyboardInterrupt, which is raised again after shutdown.

    listening : from `open_socket`. started : called when requests are accepted, before the pages are loaded.
    """
    logger = logging.getLogger("waitress")
    logger.setLevel(logging.ERROR)
    logger.addFilter(shorten_log_record)
    started()
    from hcsearch.web.serve.application import Application  # noqa: PLC0415 - slow to import, and requests can wait

    application = Application(database, db, scene=scene, host=host)
    server = Server(application, listening, ConnectionLimits(), WAITRESS_SETTINGS)
    ended = threading.Event()

    def run() -> None:
        try:
            server.run()
        except (OSError, ValueError):
            if not application.closed:  # otherwise its socket was closed while it waited
                raise
        finally:
            ended.set()

    try:
        # in a thread, since the server would swallow an interrupt and wait for answers
        threading.Thread(target=run, daemon=True).start()
        ended.wait()
    finally:
        logger.removeFilter(shorten_log_record)
        logger.setLevel(logging.CRITICAL + 1)  # connections that are cut off log errors
        application.close()
        server.close()
