"""What is refused before it is answered, and what browsers are asked not to do with an answer.

A page of another site must neither read this one (by a name that is made to lead here, DNS rebinding) nor make it
compute; nothing in a value may run as a script.
"""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Mapping
from typing import Any

from hcsearch.web.serve.addresses import LONGEST_QUERY_STRING

_HOST = re.compile(r"(\[[0-9A-Fa-f:.]{2,45}\]|[A-Za-z0-9._-]{1,255})(:[0-9]{1,5})?")
_PATH = re.compile("/|(/[A-Za-z0-9._-]+)+")
_HERE = ("localhost", "127.0.0.1", "::1")
_FRAMES = ("iframe", "frame", "fencedframe", "embed", "object")
_EVERYWHERE = ("0.0.0.0", "::")

POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
    "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
"""Of pages whose scripts and styles are files here. The design page admits its own by their hashes, in itself."""
FRAMED = "frame-ancestors 'none'; base-uri 'none'; form-action 'none'; connect-src 'none'; object-src 'none'"

HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}


def refusal(environ: Mapping[str, Any], host: str) -> tuple[int, str] | None:
    """Status and reason where a request is refused; host : the one that the server listens on."""
    if environ["REQUEST_METHOD"] not in ("GET", "HEAD"):
        return 405, "this page is read only: send GET or HEAD"
    if not is_known_host(environ.get("HTTP_HOST", ""), host):
        return 403, "this page answers to localhost and the host it was started with (--host), to no other name"
    if len(environ.get("QUERY_STRING", "")) > LONGEST_QUERY_STRING or len(environ.get("PATH_INFO", "")) > 500:
        return 414, "the address is too long: shorten the query"
    if not _PATH.fullmatch(environ.get("PATH_INFO", "")):
        return 404, "there is nothing at this address: begin at /designs"
    reason = _uninvited(environ)
    return None if reason is None else (403, reason)


def _uninvited(environ: Mapping[str, Any]) -> str | None:
    """Why a page of another site may not have this, by what its browser says of the request; None where it may.

    A link there may lead here. A frame would show nothing, as the headers of pages here forbid it, on any site.
    """
    if environ.get("HTTP_SEC_FETCH_DEST", "") in _FRAMES:
        return "pages here are shown in no frame of another page: open the address itself"
    site, mode = environ.get("HTTP_SEC_FETCH_SITE", ""), environ.get("HTTP_SEC_FETCH_MODE", "")
    followed = mode == "navigate" and "prefetch" not in environ.get("HTTP_SEC_PURPOSE", "")
    if site in ("cross-site", "same-site") and not followed:
        return "another site's page asks for this: open the address itself"
    return None


def is_known_host(header: str, host: str) -> bool:
    """Whether a Host header names this machine as it may be named; of all addresses listened on, any number does."""
    match = _HOST.fullmatch(header)
    if match is None:
        return False
    name = match[1].strip("[]").lower().removesuffix(".")
    if name in (*_HERE, host.lower()):
        return True
    if host in _EVERYWHERE:
        return _is_number(name) or name == socket.gethostname().lower()
    return False


def is_local(host: str) -> bool:
    """Whether only this machine reaches a host."""
    if host == "localhost":
        return True
    return _is_number(host) and ipaddress.ip_address(host).is_loopback


def _is_number(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
