"""`hcsearch report`: an HTML file on the designs that a query selects."""

from __future__ import annotations

import click

from hcsearch.basics.errors import printable
from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog, query_argument


@click.command(epilog=examples_epilog("hcsearch report 'grid=hex n=12' --output hex-12.html"))
@query_argument
@database_option
@scene_options
@click.option("--output", default="reports/report.html", show_default=True, metavar="FILE", help="The file to write.")
@click.option(
    "--limit", type=click.IntRange(min=0), default=20_000, show_default=True, help="The greatest number of designs."
)
def report(condition: str, db: str, scene: str | None, panel: str | None, output: str, limit: int) -> None:
    """Write one HTML page with all designs of a query.

    The page shows how many circuits pass each stage and a card for each design, with motions to play; it makes no
    network request. QUERY consists of conditions such as n=12, dof<=6 or untwisted, as in hcsearch query.
    """
    from hcsearch.api import reporting

    path = reporting.report(output, condition, db=db, scene=scene, panel=panel, limit=limit)
    click.echo(printable(str(path)))
    click.echo(f"open it in a browser: {path.absolute().as_uri()}", err=True)
