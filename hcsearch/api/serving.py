"""Serve a database as web pages on this machine."""

from __future__ import annotations

from collections.abc import Callable
from importlib.util import find_spec

from hcsearch.api.kinds import check_kinds
from hcsearch.basics.errors import HcsearchError
from hcsearch.store import check_scene, open_readonly
from hcsearch.store.queries import STATEMENT_SECONDS
from hcsearch.subjects.names import database_location
from hcsearch.subjects.stored_scenes import scene_asked_for
from hcsearch.system.terminal import write_notice


def serve(
    db: str | None = None,
    *,
    host: str = "127.0.0.1",
    port: int = 8000,
    scene: str | None = None,
    panel: str | None = None,
    started: Callable[[str], None] | None = None,
) -> None:
    """Show a database in a browser on this machine, as `hcsearch serve` does, until Ctrl-C.

    Parameters
    ----------
    db
        A path or a URL.
    host, port
        Where the server answers; port 0 chooses any free one.
    scene, panel
        As in `read`.
    started
        Called with a sentence that gives the address, once the server answers.

    Raises
    ------
    KeyboardInterrupt
        For Ctrl-C.
    """
    check_kinds(serve, locals())
    for name in ("werkzeug", "waitress"):
        if find_spec(name) is None:
            raise HcsearchError(f"hcsearch serve needs {name}: pip install 'hcsearch[serve]'")
    from hcsearch.web.serve.requests import is_local  # noqa: PLC0415 - needs the extra `serve`
    from hcsearch.web.serve.server import open_socket, run_server, socket_address  # noqa: PLC0415 - as above

    location = database_location(db)
    with open_readonly(location, timeout=STATEMENT_SECONDS) as database:
        scene_name = scene_asked_for(database, scene, panel)
        check_scene(database, scene_name)
        with open_socket(host, port) as listening:
            if not is_local(host):
                write_notice(f"warning: whoever reaches {host} can read this database; there is no password")
            sentence = f"{socket_address(listening, host)} shows {database.location}; Ctrl-C ends it"
            run_server(
                database,
                location,
                listening,
                host=host,
                scene=scene_name,
                started=lambda: None if started is None else started(sentence),
            )
