"""A read-only web page over a database, for this machine. The only home of Werkzeug and waitress."""

from __future__ import annotations

from hcsearch.system.lazy import importing

TYPE_CHECKING = False
if TYPE_CHECKING:
    from hcsearch.serve.application import Application
    from hcsearch.serve.server import serve

_HOMES = {"application": ("Application",), "server": ("serve",)}

__all__ = ["Application", "serve"]

__getattr__ = importing(__name__, _HOMES)
