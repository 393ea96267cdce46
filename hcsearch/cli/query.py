"""`hcsearch query`: designs by conditions, or any read-only SQL."""

from __future__ import annotations

from functools import partial

import click

from hcsearch.basics.errors import printable
from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog, query_argument
from hcsearch.store.columns import column_names
from hcsearch.store.result_files import FORMATS
from hcsearch.system.outputs import check_output

_COLUMNS = "id,grid,n,array,circuit,symmetry,n_foldings,n_untwisted,min_twist,status"


@click.command(
    epilog=examples_epilog(
        "hcsearch query 'grid=hex n=12 untwisted' -c id,array,symmetry -s -symmetry",
        "hcsearch query 'array=4-4-4 (symmetry>1 or not min_twist=1)'",
        "hcsearch query --sql 'SELECT status, count(*) FROM designs GROUP BY status'",
    )
    + "\n\n"
    f"Columns: {', '.join(column_names('designs'))}."
)
@query_argument
@database_option
@scene_options
@click.option("-c", "--columns", help=f"The columns to print, separated by commas.  [default: {_COLUMNS}]")
@click.option("-s", "--sort", help="The columns to sort by, separated by commas; -NAME sorts in descending order.")
@click.option("--limit", type=click.IntRange(min=0), help="The greatest number of rows.")
@click.option("--format", "style", type=click.Choice(FORMATS), default="table", show_default=True)
@click.option("--output", metavar="FILE", help="The file to write, which parquet needs.  [default: standard output]")
@click.option(
    "--sql",
    help="Run one SELECT, in place of QUERY, on the views designs, foldings, motions, deployments, evaluations, runs "
    "and units.",
)
def query(
    condition: str,
    db: str,
    scene: str | None,
    panel: str | None,
    columns: str | None,
    sort: str | None,
    limit: int | None,
    style: str,
    output: str | None,
    sql: str | None,
) -> None:
    """Print the designs that satisfy a query.

    QUERY consists of conditions such as n=12, dof<=6 or untwisted, all of which must hold. They can also be combined by
    and, or, not and brackets. A value contains no spaces. array= takes any array (6x5, 3-4-3, p5x4, t5, h3, s1,
    @FILE), circuit= a circuit in any position, order or direction. An unknown value satisfies neither a condition nor
    its negation.
    """
    from hcsearch.api.querying import Query, query_text, save_query

    selected_columns = columns or (_COLUMNS if sql is None else "")
    selection = Query(condition, "designs", selected_columns, sort or "", limit, scene, panel, sql)
    if output is None:
        announce = partial(click.echo, err=True) if style == "table" else None
        for text in query_text(selection, db, style, announce):
            click.echo(text, nl=False)
        return
    check_output(output)
    save_query(selection, db, style, output)
    click.echo(printable(output))
