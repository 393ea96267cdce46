"""Requests to a WSGI application in this process, as bare as the interface has them."""

import io
from dataclasses import dataclass
from typing import Any

HERE = "127.0.0.1:8000"


@dataclass(frozen=True)
class Answer:
    status: int
    headers: dict[str, str]
    body: bytes

    @property
    def text(self) -> str:
        return self.body.decode()


class Asking:
    def __init__(self, application: Any) -> None:
        self.application = application

    def __call__(self, address: str, method: str = "GET", **environ: Any) -> Answer:
        """The answer to an address, whose path is as the interface has it: decoded, in Latin-1."""
        path, _, query = address.partition("?")
        given = {
            "REQUEST_METHOD": method,
            "SCRIPT_NAME": "",
            "PATH_INFO": path,
            "QUERY_STRING": query,
            "SERVER_NAME": "127.0.0.1",
            "SERVER_PORT": "8000",
            "SERVER_PROTOCOL": "HTTP/1.1",
            "HTTP_HOST": HERE,
            "wsgi.version": (1, 0),
            "wsgi.url_scheme": "http",
            "wsgi.input": io.BytesIO(),
            "wsgi.errors": io.StringIO(),
            "wsgi.multithread": True,
            "wsgi.multiprocess": False,
            "wsgi.run_once": False,
        } | environ
        starts: list[Any] = []
        pieces = self.application(given, lambda status, headers, _error=None: starts.append((status, headers)))
        try:
            body = b"".join(pieces)
        finally:
            if hasattr(pieces, "close"):
                pieces.close()
        ((status, headers),) = starts
        return Answer(int(status.split()[0]), dict(headers), body)
