"""Requests: refusal of foreign requests, and parsing of addresses with limits.

A page of another site must neither read this one (by DNS rebinding) nor trigger computations; no value may run as a
script.
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

FACETS = ("status", "grid", "n", "array")
"""Columns of designs whose values are offered as filters, each with the number of designs that have it."""
MAX_PARAMETER_LENGTHS = {"q": 2000, "sort": 200, "scene": 200, "columns": 1000, "page": 9, "limit": 12, "as": 5}
MAX_PARAMETER_LENGTHS |= dict.fromkeys(FACETS, 500)
"""Maximal length of each parameter of a list."""
MAX_QUERY_STRING_LENGTH = 8000
_FACET_VALUE = re.compile("[A-Za-z0-9_.:-]+")
_NUMBER = re.compile(r"(?<![^\s(])#([0-9]+)(?![^\s)])")
MAX_QUERY_SHAPES, MAX_QUERY_CELLS = 10, 2500
"""Largest number of arrays and circuits in a query, and of cells of each, since canonical forms are computed."""


class AddressError(HcsearchError):
    """An address that cannot be parsed."""


@dataclass(frozen=True)
class ListRequest:
    """A request for a list: the rows of a view that satisfy a query, sorted, on a page; `shape` is for designs.

    default_scene : the one scene, for addresses that name none.
    facets : chosen values by column, as pairs; a design has one of the values of each. columns : those on cards, in
    tables, and in CSV and JSON; the usual ones by default. limit : only for CSV and JSON; all by default.
    page : from 1; None for all rows, in CSV and JSON.
    """

    view: str
    query: str = ""
    sort: str = ""
    page: int | None = None
    scene: str = DEFAULT_SCENE_NAME
    default_scene: str = DEFAULT_SCENE_NAME
    shape: ListShape = "cards"
    columns: str = ""
    limit: int | None = None
    facets: tuple[tuple[str, tuple[str, ...]], ...] = ()

    @property
    def selection(self) -> str:
        """The query together with the facets, as one query."""
        return self.selection_but(None)

    def selection_but(self, facet: str | None) -> str:
        """Return the query together with all facets but one; the query alone must have been checked."""
        chosen = [
            " or ".join(f"{name}={value}" for value in values)
            for name, values in self.facets
            if name != facet and values
        ]
        return " ".join(f"({part})" for part in (self.query, *chosen) if part) if chosen else self.query

    def toggled(self, facet: str, value: object) -> ListRequest:
        """Return the request for the first page with a value of a facet chosen, or no longer chosen."""
        chosen, text = dict(self.facets), str(value)
        values = chosen.get(facet, ())
        chosen[facet] = tuple(v for v in values if v != text) if text in values else (*values, text)
        return replace(self, facets=tuple((name, chosen[name]) for name in FACETS if chosen.get(name)), page=None)

    @property
    def scene_parameter(self) -> str:
        """The scene as a parameter of addresses; empty for the default one."""
        return "" if self.scene == self.default_scene else self.scene

    @property
    def number(self) -> int:
        """The page number, from 1."""
        return self.page or 1


def read_parameters(pairs: Sequence[tuple[str, str]], max_lengths: Mapping[str, int]) -> dict[str, str]:
    """Return parameters by name; AddressError for unknown, repeated, too long and undecodable ones.

    max_lengths : maximal length of each parameter in characters.
    """
    values: dict[str, str] = {}
    for name, value in pairs:
        if name not in max_lengths:
            raise AddressError(
                f"addresses here have no parameter {name!r}: they have {', '.join(max_lengths) or 'none'}"
            )
        if name in values:
            raise AddressError(f"the parameter {name} is given twice: give it once")
        if len(value) > max_lengths[name]:
            raise AddressError(f"the parameter {name} has {len(value)} characters: give {max_lengths[name]} at most")
        if not value.isprintable() or "\ufffd" in value:
            raise AddressError(f"the parameter {name} holds what is no text in UTF-8: write it anew")
        values[name] = value
    return values


def read_list_request(view: str, pairs: Sequence[tuple[str, str]], scene: str) -> ListRequest:
    """Return the request in the parameters of a list, with its query unparsed; scene : the default one.

    `#24` in a query of designs means `id=24`, as on cards.
    """
    values = read_parameters(pairs, MAX_PARAMETER_LENGTHS)
    shapes: dict[str, ListShape] = {"": "cards", "cards": "cards", "table": "table"}
    shape = values.get("as", "")
    if shape not in shapes:
        raise AddressError(f"there is no list as {shape!r}: write as=cards or as=table")
    query = values.get("q", "").strip()
    if view == "designs":
        query = _NUMBER.sub(r"id=\1", query)
    return ListRequest(
        view=view,
        query=query,
        sort=values.get("sort", ""),
        page=_whole("page", values["page"], 1) if values.get("page") else None,
        scene=values.get("scene") or scene,
        default_scene=scene,
        shape=shapes[shape],
        columns=values.get("columns", ""),
        limit=_whole("limit", values["limit"], 0) if values.get("limit") else None,
        facets=tuple((name, _facet_values(view, name, values[name])) for name in FACETS if values.get(name)),
    )


def _facet_values(view: str, name: str, text: str) -> tuple[str, ...]:
    """Return the chosen values of a facet."""
    if view != "designs":
        raise AddressError(f"the parameter {name} is one of /designs: write it into q, as in {name}=VALUE")
    values = tuple(dict.fromkeys(filter(None, text.split(","))))
    if not all(_FACET_VALUE.fullmatch(value) for value in values):
        raise AddressError(f"{text!r} is no list of values of {name}: separate them by commas")
    if name == "array" and not all(":" in value for value in values):  # others may be large, and slow to translate
        raise AddressError("the parameter array takes notations such as hex:6.7.7: write others into q, as array=6x5")
    return values


def _whole(name: str, text: str, minimum: int) -> int:
    if not (text.isascii() and text.isdigit()) or int(text) < minimum:
        raise AddressError(f"{name} is a whole number from {minimum} on, not {text!r}: write {name}={max(1, minimum)}")
    return int(text)


def check_query(query: str, view: str) -> None:
    """Raise AddressError for a query on a view that would read a local file, or is slow to translate to SQL.

    QueryError for one that cannot be parsed.
    """
    shapes = [value for name, value in _conditions(parse_conditions(query, view)) if name in ("array", "circuit")]
    if len(shapes) > MAX_QUERY_SHAPES:
        raise AddressError(f"the query has {len(shapes)} arrays and circuits: give {MAX_QUERY_SHAPES} at most")
    for value in shapes:
        if value.startswith("@"):
            raise AddressError("files are not read here: write the array as 6x5, 3-4-3 or by its notation")
        sizes = [int(size) for size in re.findall("[0-9]+", value)] if ":" not in value else []
        if sizes and (sum(sizes) if "-" in value else max(sizes) ** 2) > MAX_QUERY_CELLS:
            raise AddressError(f"the array {value!r} has more than {MAX_QUERY_CELLS} cells: give a smaller one")


def _conditions(tree: ConditionTree) -> Iterator[tuple[str, str]]:
    """Yield names and values of all conditions."""
    match tree:
        case AllOf(parts) | AnyOf(parts):
            for part in parts:
                yield from _conditions(part)
        case Not(part):
            yield from _conditions(part)
        case Condition(name=name, value=value):
            yield name, value or ""


def list_address_of(list_request: ListRequest, ending: str = "", **changes: Any) -> str:
    """Return the address of a list without default parameters; ending : such as `.csv`, for all rows."""
    changed = replace(list_request, **changes)
    values = {"q": changed.query, "sort": changed.sort, "scene": changed.scene_parameter}
    values |= {name: ",".join(chosen) for name, chosen in changed.facets} | {"columns": changed.columns}
    if not ending:
        values |= {"page": "" if changed.number == 1 else str(changed.number)}
        values |= {"as": "" if changed.shape == "cards" else changed.shape}
    return _joined(f"/{changed.view}{ending}", values)


def design_address(number: object, scene_parameter: str = "", subpath: str = "", **more: str) -> str:
    """Return the address of a design's page or of a resource below it.

    scene_parameter : name of the scene, empty for the default one.
    """
    return _joined(f"/designs/{number}{subpath}", {"scene": scene_parameter} | more)


def motion_address(number: int, crease: int, scene_parameter: str = "") -> str:
    """Return the address of the stored path of a folding as data of the player."""
    return design_address(number, scene_parameter, f"/foldings/{crease}/motion.json")


def _joined(path: str, values: Mapping[str, str]) -> str:
    # `=`, `<` and commas may stand in a query string, where they are easier to read
    text = urlencode({name: value for name, value in values.items() if value}, quote_via=quote, safe="=,:/<>!()-")
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
"""Content security policy of pages with scripts and styles in files; a design's page has its own, with hashes."""
FRAME_POLICY = "frame-ancestors 'none'; base-uri 'none'; form-action 'none'; connect-src 'none'; object-src 'none'"

SECURITY_HEADERS = {
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
    "Referrer-Policy": "no-referrer",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Cross-Origin-Opener-Policy": "same-origin",
}


def refusal_response(environ: Mapping[str, Any], host: str) -> tuple[int, str] | None:
    """Return status and reason of a refused request, else None; host : on which the server listens."""
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
    """Return the reason to refuse a request of another site's page, by the fetch metadata of the browser, else None.

    Links from other sites are allowed. Frames are not: the headers of pages here forbid them on any site.
    """
    if environ.get("HTTP_SEC_FETCH_DEST", "") in _FRAMES:
        return "pages here are shown in no frame of another page: open the address itself"
    site, mode = environ.get("HTTP_SEC_FETCH_SITE", ""), environ.get("HTTP_SEC_FETCH_MODE", "")
    followed = mode == "navigate" and "prefetch" not in environ.get("HTTP_SEC_PURPOSE", "")
    if site in ("cross-site", "same-site") and not followed:
        return "another site's page asks for this: open the address itself"
    return None


def is_known_host(header: str, host: str) -> bool:
    """Return whether a Host header is an allowed name of this machine; any IP address if the server listens on all."""
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
    """Return whether a host can be reached only from this machine."""
    if host == "localhost":
        return True
    return _is_number(host) and ipaddress.ip_address(host).is_loopback


def _is_number(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
