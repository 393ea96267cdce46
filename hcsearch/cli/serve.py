"""`hcsearch serve`: a database as web pages on this machine."""

from __future__ import annotations

import signal

import click

from hcsearch.cases.stored_scenes import scene_asked_for
from hcsearch.cli.options import database_option, examples
from hcsearch.cli.scenes import scene_options
from hcsearch.errors import HcsearchError
from hcsearch.system.interrupts import leave


@click.command(epilog=examples("hcsearch serve --db hcsearch.sqlite"))
@database_option
@click.option(
    "--port", type=click.IntRange(0, 65535), default=8000, show_default=True, help="The port; 0 chooses any free one."
)
@click.option(
    "--host", default="127.0.0.1", show_default=True, help="The address of this machine at which the server answers."
)
@scene_options
def serve(db: str, port: int, host: str, scene: str | None, panel: str | None) -> None:
    """Show a database in a browser on this machine.

    The command prints an address to open in a browser; Ctrl-C ends it. The pages list the designs of a query, filtered
    and sorted, and show each design with its motions to play. Exports, CSV and JSON have addresses of their own. The
    database is only read. Every user of this machine can read the pages.
    """
    from importlib.util import find_spec

    for name in ("werkzeug", "waitress"):
        if find_spec(name) is None:
            raise HcsearchError(f"hcsearch serve needs {name}: pip install 'hcsearch[serve]'")
    from hcsearch.serve.guards import is_local
    from hcsearch.serve.server import address_of, open_socket
    from hcsearch.serve.server import serve as run
    from hcsearch.store import check_scene, open_readonly
    from hcsearch.store.pages import SECONDS

    with open_readonly(db, timeout=SECONDS) as database:
        asked = scene_asked_for(database, scene, panel)
        check_scene(database, asked)
        with open_socket(host, port) as listening:
            if not is_local(host):
                click.echo(f"warning: whoever reaches {host} can read this database; there is no password", err=True)
            shown = f"{address_of(listening, host)} shows {database.location}; Ctrl-C ends it"
            try:
                run(database, db, listening, host=host, scene=asked, started=lambda: click.echo(shown))
            except KeyboardInterrupt:
                signal.signal(signal.SIGINT, signal.SIG_IGN)
                leave(said="hcsearch: the server has ended")
