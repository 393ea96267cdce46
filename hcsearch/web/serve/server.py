"""The server: a socket, threads that answer, and an end in good order."""

from __future__ import annotations

import errno
import logging
import socket
import threading
from collections.abc import Callable

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database
from hcsearch.web.serve.connections import Patience, Server

SETTINGS = {
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


def address_of(listening: socket.socket, host: str) -> str:
    """The address to open in a browser."""
    port = listening.getsockname()[1]
    return f"http://[{host}]:{port}/" if ":" in host else f"http://{host}:{port}/"


def in_one_line(record: logging.LogRecord) -> bool:
    """Let one line say why an answer was cut off in its midst, as by a damaged row; faults keep their traceback."""
    error = record.exc_info[1] if record.exc_info else None
    if isinstance(error, HcsearchError):
        record.msg, record.args, record.exc_info = f"hcsearch: {record.getMessage()}: {error}", (), None
    return True


def run(
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
    logger.addFilter(in_one_line)
    started()
    from hcsearch.web.serve.application import Application  # noqa: PLC0415 - takes long, and requests can wait

    application = Application(database, db, scene=scene, host=host)
    server = Server(application, listening, Patience(), SETTINGS)
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
        logger.removeFilter(in_one_line)
        logger.setLevel(logging.CRITICAL + 1)  # who is cut off complains
        application.close()
        server.close()
