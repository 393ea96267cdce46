"""`hcsearch serve`: a database as web pages on this machine."""

from __future__ import annotations

import signal

import click

from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog
from hcsearch.system.interrupts import exit_interrupted


@click.command(epilog=examples_epilog("hcsearch serve --db hcsearch.sqlite"))
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
    and sorted, and show each design with its motions to play. Exports, and lists as CSV and JSON, have separate
    addresses. The database is only read. Every user of this machine can read the pages.
    """
    from hcsearch.api import serving

    try:
        serving.serve(db, host=host, port=port, scene=scene, panel=panel, started=click.echo)
    except KeyboardInterrupt:
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        exit_interrupted(message="hcsearch: the server has ended")
