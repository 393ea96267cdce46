"""The server: a socket, threads that answer, time limits of connections, and an end in good order.

waitress closes a connection on which nothing has moved for a while. A byte every few seconds is enough to stay, so a
hundred such connections would keep everybody else out. Here the time that counts begins with the first byte of a
request, and a new connection always finds a place: whoever has kept the server waiting for the longest time goes.
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

    def is_late(self, patience: ConnectionLimits) -> bool:
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
        self,
        application: Callable[..., Any],
        listening: socket.socket,
        patience: ConnectionLimits,
        adjustments: dict[str, Any],
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


WAITRESS_SETTINGS = {
    "threads": 32,
    "ident": "hcsearch",
    "max_request_header_size": 32 * 1024,
    "max_request_body_size": 1024,
    "clear_untrusted_proxy_headers": True,
}
"""Of waitress. Of the threads, computations take four at most, long lists twelve, files of all rows three: the others
answer what is quick all the time."""


def open_socket(host: str, port: int) -> socket.socket:
    """Listen on a port, any free one for 0; HcsearchError with the remedy where that cannot be."""
    try:
        family, _, _, _, place = socket.getaddrinfo(host, port, type=socket.SOCK_STREAM)[0]
        return socket.create_server(place[:2], family=family, backlog=128)
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
    """The address to open in a browser."""
    port = listening.getsockname()[1]
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


def shorten_log_record(record: logging.LogRecord) -> bool:
    """Let one line say why an answer was cut off in its midst, as by a damaged row; faults keep their traceback."""
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
    """Answer requests until KeyboardInterrupt, which is raised again when everything has ended.

    listening : from `open_socket`. started : called when requests may come; the pages themselves load after that.
    """
    logger = logging.getLogger("waitress")
    logger.setLevel(logging.ERROR)
    logger.addFilter(shorten_log_record)
    started()
    from hcsearch.web.serve.application import Application  # noqa: PLC0415 - takes long, and requests can wait

    application = Application(database, db, scene=scene, host=host)
    server = Server(application, listening, ConnectionLimits(), WAITRESS_SETTINGS)
    ended = threading.Event()

    def run() -> None:
        try:
            server.run()
        except (OSError, ValueError):
            if not application.closed:  # else its socket was closed while it waited there
                raise
        finally:
            ended.set()

    try:
        # in a thread, as it would swallow an interrupt and wait for those who answer
        threading.Thread(target=run, daemon=True).start()
        ended.wait()
    finally:
        logger.removeFilter(shorten_log_record)
        logger.setLevel(logging.CRITICAL + 1)  # who is cut off complains
        application.close()
        server.close()
