"""Requests: what is refused before it is answered, and what an address asks for, read with limits.

A page of another site must neither read this one (by a name that is made to lead here, DNS rebinding) nor make it
compute; nothing in a value may run as a script.
"""

from __future__ import annotations

import ipaddress
import re
import socket
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal
from urllib.parse import quote, urlencode

from hcsearch.basics.errors import HcsearchError
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store.conditions import AllOf, AnyOf, Condition, ConditionTree, Not, parse_conditions

ListShape = Literal["cards", "table"]

MAX_PARAMETER_LENGTHS = {"q": 2000, "sort": 200, "scene": 200, "columns": 1000, "page": 9, "limit": 12, "as": 5}
"""Characters of each parameter of a list."""
MAX_QUERY_STRING_LENGTH = 8000
_NUMBER = re.compile(r"(?<![^\s(])#([0-9]+)(?![^\s)])")
MAX_QUERY_SHAPES, MAX_QUERY_CELLS = 10, 2500
"""Arrays and circuits in a query, and cells of such an array: each is brought to its canonical form first."""


class AddressError(HcsearchError):
    """An address that cannot be read."""


@dataclass(frozen=True)
class ListRequest:
    """What a list shows: rows of a view that satisfy a query, in an order, from a page on; `shape` is of designs.

    usual : the scene that is shown where an address names none.
    columns, limit : of CSV and JSON alone; all where not given. page : from 1; None for all rows, in CSV and JSON.
    """

    view: str
    query: str = ""
    sort: str = ""
    page: int | None = None
    scene: str = DEFAULT_SCENE_NAME
    usual: str = DEFAULT_SCENE_NAME
    shape: ListShape = "cards"
    columns: str = ""
    limit: int | None = None

    @property
    def named(self) -> str:
        """The scene as addresses name it: not at all where it is the usual one."""
        return "" if self.scene == self.usual else self.scene

    @property
    def number(self) -> int:
        """The number of the page."""
        return self.page or 1


def read_parameters(pairs: Sequence[tuple[str, str]], known: Mapping[str, int]) -> dict[str, str]:
    """Parameters by name; AddressError for unknown, repeated, long and undecodable ones.

    known : the longest that each may be, in characters.
    """
    given: dict[str, str] = {}
    for name, value in pairs:
        if name not in known:
            raise AddressError(f"addresses here have no parameter {name!r}: they have {', '.join(known)}")
        if name in given:
            raise AddressError(f"the parameter {name} is given twice: give it once")
        if len(value) > known[name]:
            raise AddressError(f"the parameter {name} has {len(value)} characters: give {known[name]} at most")
        if not value.isprintable() or "\ufffd" in value:
            raise AddressError(f"the parameter {name} holds what is no text in UTF-8: write it anew")
        given[name] = value
    return given


def read_list_request(view: str, pairs: Sequence[tuple[str, str]], scene: str) -> ListRequest:
    """What the parameters of a list ask for; its query is not yet read. scene : where they name none.

    `#24` in a query of designs is read as `id=24`, as cards name them.
    """
    given = read_parameters(pairs, MAX_PARAMETER_LENGTHS)
    shapes: dict[str, ListShape] = {"": "cards", "cards": "cards", "table": "table"}
    shape = given.get("as", "")
    if shape not in shapes:
        raise AddressError(f"there is no list as {shape!r}: write as=cards or as=table")
    query = given.get("q", "").strip()
    if view == "designs":
        query = _NUMBER.sub(r"id=\1", query)
    return ListRequest(
        view=view,
        query=query,
        sort=given.get("sort", ""),
        page=_whole("page", given["page"], 1) if given.get("page") else None,
        scene=given.get("scene") or scene,
        usual=scene,
        shape=shapes[shape],
        columns=given.get("columns", ""),
        limit=_whole("limit", given["limit"], 0) if given.get("limit") else None,
    )


def _whole(name: str, text: str, least: int) -> int:
    if not (text.isascii() and text.isdigit()) or int(text) < least:
        raise AddressError(f"{name} is a whole number from {least} on, not {text!r}: write {name}={max(1, least)}")
    return int(text)


def check_query(query: str) -> None:
    """AddressError for a query that would read a file of this machine, or take long before anything is asked.

    QueryError for one that cannot be read.
    """
    shapes = [value for name, value in _conditions(parse_conditions(query)) if name in ("array", "circuit")]
    if len(shapes) > MAX_QUERY_SHAPES:
        raise AddressError(f"the query has {len(shapes)} arrays and circuits: give {MAX_QUERY_SHAPES} at most")
    for value in shapes:
        if value.startswith("@"):
            raise AddressError("files are not read here: write the array as 6x5, 3-4-3 or by its notation")
        sizes = [int(size) for size in re.findall("[0-9]+", value)] if ":" not in value else []
        if sizes and (sum(sizes) if "-" in value else max(sizes) ** 2) > MAX_QUERY_CELLS:
            raise AddressError(f"the array {value!r} has more than {MAX_QUERY_CELLS} cells: give a smaller one")


def _conditions(tree: ConditionTree) -> Iterator[tuple[str, str]]:
    """Names and values of all conditions."""
    match tree:
        case AllOf(parts) | AnyOf(parts):
            for part in parts:
                yield from _conditions(part)
        case Not(of):
            yield from _conditions(of)
        case Condition(name=name, value=value):
            yield name, value or ""


def list_address_of(asked: ListRequest, ending: str = "", **changes: Any) -> str:
    """The address of a list, with what is as usual left out. ending : as `.csv`, where all rows are asked for."""
    wanted = replace(asked, **changes)
    said = {"q": wanted.query, "sort": wanted.sort, "scene": wanted.named}
    if not ending:
        said |= {"page": "" if wanted.number == 1 else str(wanted.number)}
        said |= {"as": "" if wanted.shape == "cards" else wanted.shape}
    return _joined(f"/{wanted.view}{ending}", said)


def design_address(number: object, named: str = "", after: str = "", **more: str) -> str:
    """The address of a design's page, or of what lies below it; named : its scene, empty for the usual one."""
    return _joined(f"/designs/{number}{after}", {"scene": named} | more)


def motion_address(number: int, crease: int, named: str = "") -> str:
    """The address of the stored path of a folding, as the player takes it."""
    return design_address(number, named, f"/foldings/{crease}/motion.json")


def _joined(path: str, said: Mapping[str, str]) -> str:
    # `=`, `<` and commas may stand in a query string, and are read more easily there
    text = urlencode({name: value for name, value in said.items() if value}, quote_via=quote, safe="=,:/<>!()-")
    return f"{path}?{text}" if text else path


_HOST = re.compile(r"(\[[0-9A-Fa-f:.]{2,45}\]|[A-Za-z0-9._-]{1,255})(:[0-9]{1,5})?")
_PATH = re.compile("/|(/[A-Za-z0-9._-]+)+")
_HERE = ("localhost", "127.0.0.1", "::1")
_FRAMES = ("iframe", "frame", "fencedframe", "embed", "object")
_EVERYWHERE = ("0.0.0.0", "::")

CONTENT_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; connect-src 'self'; img-src data:; "
    "form-action 'self'; base-uri 'none'; frame-ancestors 'none'"
)
"""Of pages whose scripts and styles are files here. The design page admits its own by their hashes, in itself."""
FRAME_POLICY = "frame-ancestors 'none'; base-uri 'none'; form-action 'none'; connect-src 'none'; object-src 'none'"

SECURITY_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}


def refusal_response(environ: Mapping[str, Any], host: str) -> tuple[int, str] | None:
    """Status and reason where a request is refused; host : the one that the server listens on."""
    if environ["REQUEST_METHOD"] not in ("GET", "HEAD"):
        return 405, "this page is read only: send GET or HEAD"
    if not is_known_host(environ.get("HTTP_HOST", ""), host):
        return 403, "this page answers to localhost and the host it was started with (--host), to no other name"
    if len(environ.get("QUERY_STRING", "")) > MAX_QUERY_STRING_LENGTH or len(environ.get("PATH_INFO", "")) > 500:
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
