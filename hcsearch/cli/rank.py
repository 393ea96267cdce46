"""`hcsearch rank`: designs by a weighted score, and their Pareto front."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import click

from hcsearch.basics.errors import QueryError
from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog, named_numbers, query_argument
from hcsearch.store.columns import RANKING_CRITERIA
from hcsearch.store.result_files import FORMATS

if TYPE_CHECKING:
    from hcsearch.search.ranking import RankedDesigns
    from hcsearch.store import Rows

_STYLES = tuple(style for style in FORMATS if style != "parquet")
_CRITERIA = "\n".join(
    f"  {quantity.name:18}{quantity.better} is better, worth 1/2 at {quantity.half:g} {quantity.unit}".rstrip()
    for quantity in RANKING_CRITERIA
)


@click.command(
    epilog=examples_epilog("hcsearch rank 'grid=hex untwisted' --weight dof=3 --limit 10")
    + f"\n\n\b\nCriteria:\n{_CRITERIA}"
)
@query_argument
@database_option
@scene_options
@click.option(
    "--weight",
    "weights",
    multiple=True,
    metavar="NAME=W",
    help="The weight of a criterion; 0 leaves it out.  [default: 1]",
)
@click.option(
    "--pareto",
    is_flag=True,
    help="Print only the Pareto front: no other design is as good in all criteria and better in one.",
)
@click.option("--limit", type=click.IntRange(min=0), help="The greatest number of rows.")
@click.option("--format", "style", type=click.Choice(_STYLES), default="table", show_default=True)
@click.option("--save", is_flag=True, help="Store the scores of all ranked designs in the column `score`.")
def rank(
    condition: str,
    db: str,
    scene: str | None,
    panel: str | None,
    weights: tuple[str, ...],
    pareto: bool,
    limit: int | None,
    style: str,
    save: bool,
) -> None:
    """Rank the designs of a query by a weighted score.

    QUERY consists of conditions such as n=12, dof<=6 or untwisted, as in hcsearch query. The score is the weighted mean
    of the worths of the criteria below, each from 0 to 1; a missing value is worth 0. Designs that are known not to
    deploy (without a folding, twisted or locked) are left out.
    """
    from hcsearch.api.querying import open_existing, rank_in_database
    from hcsearch.search.ranking import complete_weights
    from hcsearch.store import format_rows

    all_weights = complete_weights(_read(weights))
    with open_existing(db, to_write=save) as database:
        ranked = rank_in_database(database, condition, all_weights, scene, panel, save=save)
    for text in format_rows(_shown(ranked, pareto, limit, style), style):
        click.echo(text, nl=False)
    if ranked.unranked_ids:
        click.echo(f"left out: {len(ranked.unranked_ids):,} designs that are known not to deploy", err=True)
    if save:
        click.echo(f"scores saved: {len(ranked.result.rows):,} designs in {database.location}", err=True)


def _read(texts: Sequence[str]) -> dict[str, float]:
    """Parse texts such as dof=2 into weights by name."""
    weights: dict[str, float] = {}
    twice = "the weight of {} is given twice: give it once"
    for text, name, weight in named_numbers(texts, lambda name: QueryError(twice.format(name))):
        if weight is None:
            raise QueryError(f"cannot read the weight {text!r}: write NAME=W, such as dof=2")
        weights[name] = weight
    return weights


def _shown(ranked: RankedDesigns, pareto: bool, limit: int | None, style: str) -> Rows:
    """Return the table to print; in the style for people, column heads contain units."""
    from hcsearch.store import Rows

    names = ranked.result.columns
    on_front = names.index("pareto")
    rows = [row for row in ranked.result.rows if row[on_front] or not pareto][:limit]
    if style in ("table", "markdown"):
        units = {quantity.name: f" ({quantity.unit})" for quantity in RANKING_CRITERIA if quantity.unit}
        names = tuple(name + units.get(name, "") for name in names)
    return Rows(names, (None,) * len(names), iter([rows] if rows else []))
