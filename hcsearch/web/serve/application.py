"""The WSGI application: addresses, answers and error pages.

| address | answer |
|---|---|
| `/` | redirect to `/designs` |
| `/VIEW`, with `q`, `sort`, `page`, `scene`, `as` | a list: of designs as cards or a table, of other views as a table |
| `/VIEW.csv`, `/VIEW.json`, the same with `columns`, `limit` | all rows of it, or those of a page |
| `/designs/ID` | the page of a design |
| `/designs/ID/export.ENDING` | an export of its array |
| `/designs/ID/foldings/CREASE/export.ENDING` | an export of a folding |
| `/designs/ID/foldings/CREASE/motion.json` | the motion of a folding with a stored path, as data of the player |
| `/assemblies`, `/assemblies/NAME` | the known assemblies, the page of one |
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Hashable, Iterable
from dataclasses import replace
from typing import Any

from werkzeug.exceptions import HTTPException, NotFound
from werkzeug.routing import Map, Rule
from werkzeug.wrappers import Request, Response

from hcsearch.basics.errors import DatabaseError, HcsearchError, QueryError
from hcsearch.designs.circuit import Circuit
from hcsearch.scenes import DEFAULT_SCENE_NAME
from hcsearch.store import Database, foldings_with_paths, scene_names
from hcsearch.store.columns import VIEWS
from hcsearch.subjects.names import circuit_with_id
from hcsearch.subjects.resolve import kind_of
from hcsearch.web.serve import jobs
from hcsearch.web.serve.downloads import MEDIA_TYPES, ResultStreams, asks_for_few_rows, read_export, text_of_few_rows
from hcsearch.web.serve.jobs import BusyError, ComputingPool
from hcsearch.web.serve.listing import RowCounts, order_of_list, render_list
from hcsearch.web.serve.long_lists import LongLists
from hcsearch.web.serve.overviews import Overviews
from hcsearch.web.serve.requests import (
    CONTENT_POLICY,
    FRAME_POLICY,
    MAX_PARAMETER_LENGTHS,
    SECURITY_HEADERS,
    check_query,
    read_list_request,
    read_parameters,
    refusal_response,
)
from hcsearch.web.serve.template_pages import render_assembly_list, render_page, static_files


class MissingError(HcsearchError):
    """There is no object of this name."""


_VIEWS = f"<any({', '.join(VIEWS)}):view>"
_SCENE = {"scene": MAX_PARAMETER_LENGTHS["scene"]}
"""Parameters of a design's address, with their maximal length."""
_STATUSES = ((BusyError, 503), (MissingError, 404), (DatabaseError, 500), (HcsearchError, 400))
_FOREVER = "public, max-age=31536000, immutable"

ROUTES = Map(
    [
        Rule("/", endpoint="home"),
        Rule(f"/{_VIEWS}", endpoint="listed"),
        Rule(f"/{_VIEWS}.<any(csv, json):style>", endpoint="rows"),
        Rule("/designs/<int:number>", endpoint="design"),
        Rule("/designs/<int:number>/export.<ending>", endpoint="export"),
        Rule("/designs/<int:number>/foldings/<int:crease>/export.<ending>", endpoint="export"),
        Rule("/designs/<int:number>/foldings/<int:crease>/motion.json", endpoint="motion"),
        Rule("/assemblies", endpoint="assemblies"),
        Rule("/assemblies/<name>", endpoint="assembly"),
        Rule("/static/<version>/<name>", endpoint="static"),
    ],
    strict_slashes=False,
    merge_slashes=False,
    redirect_defaults=False,
)


class Application:
    """A database as web pages; read-only.

    database : from `open_readonly`. db : its name as given, for processes that open it themselves.
    scene : default scene of verdicts. host : on which the server listens.
    """

    def __init__(
        self, database: Database, db: str, *, scene: str = DEFAULT_SCENE_NAME, host: str = "127.0.0.1"
    ) -> None:
        self.database, self.db, self.scene, self.host = database.watched(), db, scene, host
        self.closed = False
        self.computing, self._counts, self._streams = ComputingPool(), RowCounts(), ResultStreams()
        self._long_lists, self._overviews = LongLists(), Overviews()

    def close(self) -> None:
        """End all computations."""
        self.closed = True
        self.computing.close()

    def __call__(self, environ: dict[str, Any], start_response: Callable[..., Any]) -> Iterable[bytes]:
        """Answer a request."""
        answer = self._answer(environ)
        for name, value in SECURITY_HEADERS.items():
            answer.headers[name] = value
        answer.headers.setdefault("Content-Security-Policy", CONTENT_POLICY)
        answer.headers.setdefault("Cache-Control", "no-cache")
        body: Iterable[bytes] = answer(environ, start_response)
        return body

    def _answer(self, environ: dict[str, Any]) -> Response:
        refused = refusal_response(environ, self.host)
        if refused is not None:
            return _error(*refused)
        try:
            endpoint, values = ROUTES.bind("localhost").match(environ.get("PATH_INFO", ""), method="GET")
            answer: Response = getattr(self, f"_{endpoint}")(Request(environ), **values)
            return answer
        except Exception as error:
            return _failed(error)

    def _home(self, request: Request) -> Response:
        return Response(status=302, headers={"Location": "/designs"})

    def _static(self, request: Request, version: str, name: str) -> Response:
        if name not in static_files():
            raise NotFound
        text, kind = static_files()[name]
        return Response(text, mimetype=kind, headers={"Cache-Control": _FOREVER})

    def _listed(self, request: Request, view: str) -> Response:
        list_request = read_list_request(view, _pairs(request), self.scene)
        text, status = render_list(self.database, list_request, self._counts, self._overviews, self._long_lists)
        return Response(text, status=status, mimetype="text/html")

    def _rows(self, request: Request, view: str, style: str) -> Response:
        list_request = read_list_request(view, _pairs(request), self.scene)
        check_query(list_request.query, list_request.view)
        headers = {"Content-Disposition": f"attachment; filename={view}.csv"} if style == "csv" else {}
        order = self._long_lists(lambda seconds: order_of_list(self.database, list_request, self._counts, seconds))
        if asks_for_few_rows(list_request):
            text = self._long_lists(
                lambda seconds: text_of_few_rows(self.database, list_request, style, order, seconds)
            )
            return Response(text, mimetype=MEDIA_TYPES[style], headers=headers)
        pieces = self._streams.start(self.database, list_request, style, order)
        if request.method == "HEAD":
            pieces.close()
        return Response(pieces, mimetype=MEDIA_TYPES[style], headers=headers)

    def _design(self, request: Request, number: int) -> Response:
        scene = self._scene_of(request)
        scene_parameter = "" if scene == self.scene else scene
        self._circuit(number)  # raises without a known design
        text = self._computed(jobs.subject_page, str(number), scene, scene_parameter)
        return Response(text, mimetype="text/html", headers={"Content-Security-Policy": FRAME_POLICY})

    def _motion(self, request: Request, number: int, crease: int) -> Response:
        scene = self._scene_of(request)
        self._circuit(number)  # raises without a known design
        if (number, crease) not in foldings_with_paths(self.database, [number], scene):
            raise MissingError(f"the database has no path of folding {crease} of design {number} in the scene {scene}")
        text = self._computed(jobs.motion_data, f"{number}:{crease}", scene)
        return Response(text, mimetype="application/json")

    def _assemblies(self, request: Request) -> Response:
        read_parameters(_pairs(request), {})
        return Response(render_assembly_list(), mimetype="text/html")

    def _assembly(self, request: Request, name: str) -> Response:
        read_parameters(_pairs(request), {})
        if kind_of(name) != "assembly":
            raise MissingError(f"no assembly {name!r}: choose one of those at /assemblies")
        text = self.computing((jobs.subject_page, name), jobs.subject_page, self.db, name, None, "")  # no stored design
        return Response(text, mimetype="text/html", headers={"Content-Security-Policy": FRAME_POLICY})

    def _export(self, request: Request, number: int, ending: str, crease: int | None = None) -> Response:
        form, settings, motion, scene_parameter = read_export(ending, _pairs(request))
        scene = self._scene(scene_parameter)
        self._circuit(number)  # raises without a known format
        subject, stem = str(number), f"design-{number}"
        if crease is not None:
            subject, stem = f"{subject}:{crease}", f"{stem}-folding-{crease}"
        elif form.subject != "array":
            below = f"/designs/{number}/foldings/CREASE/export.{ending}"
            raise QueryError(f"{form.name} exports one folding: request {below}")
        stem += f"-{form.name}" if form.only_by_name else ""  # another format has this ending, too
        settings = replace(settings, stem=stem, ending=f".{ending}")
        file = self._computed(jobs.export_file, subject, form, settings, motion, scene)
        headers = {"Content-Disposition": f"attachment; filename={file.name}"}
        return Response(file.content, mimetype="application/octet-stream", headers=headers)

    def _computed(self, call: Callable[..., Any], *arguments: Hashable) -> Any:
        """Return the result of a call with the database, perhaps from the cache of results of this state of it."""
        return self.computing((call, arguments, self.database.fingerprint()), call, self.db, *arguments)

    def _circuit(self, number: int) -> Circuit:
        """Return a design's circuit; MissingError for an unknown id."""
        try:
            return circuit_with_id(number, self.database)
        except QueryError:
            missing = f"no design {number} in {self.database.location}: choose one of those at /designs"
            raise MissingError(missing) from None

    def _scene_of(self, request: Request) -> str:
        """Return the scene in an address without other parameters."""
        return self._scene(read_parameters(_pairs(request), _SCENE).get("scene", ""))

    def _scene(self, name: str) -> str:
        """Return a scene with verdicts in the database; other names, which may denote files, are not looked up."""
        name, stored_names = name or self.scene, scene_names(self.database)
        if name not in stored_names and (name != DEFAULT_SCENE_NAME or stored_names):
            raise QueryError(f"no verdicts of the scene {name!r} in {self.database.location}: see /deployments")
        return name


def _pairs(request: Request) -> list[tuple[str, str]]:
    return list(request.args.items(multi=True))


def _failed(error: Exception) -> Response:
    """Return the answer to a failed request."""
    if isinstance(error, HTTPException):
        status = error.code or 500
        return _error(status, "there is nothing at this address: begin at /designs" if status == 404 else error.name)
    for kind, status in _STATUSES:
        if isinstance(error, kind):
            return _error(status, str(error))
    traceback.print_exception(error, file=sys.stderr)
    return _error(500, "this is a fault of hcsearch: the terminal in which it runs says more; please report it")


def _error(status: int, reason: str) -> Response:
    headers = {"Allow": "GET, HEAD"} if status == 405 else {"Retry-After": "5"} if status == 503 else {}
    text = render_page("error.html", status=status, reason=reason)
    return Response(text, status=status, mimetype="text/html", headers=headers)
