"""`hcsearch rank`: designs by a weighted score, and their Pareto front."""

from __future__ import annotations

from collections.abc import Sequence

import click

from hcsearch.basics.errors import QueryError
from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog, named_numbers, query_argument
from hcsearch.store.columns import RANKING_CRITERIA
from hcsearch.store.result_files import FORMATS

_STYLES = tuple(style for style in FORMATS if style != "parquet")
_CRITERIA = "\n".join(
    f"  {quantity.name:22}{quantity.better} is better, worth 1/2 at {quantity.half:g} {quantity.unit}".rstrip()
    + ("" if quantity.weight else "; weight 0 unless given")
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
    help="The weight of a criterion; 0 leaves it out.  [default: 1, or as listed below]",
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
    from hcsearch.api.querying import rank_in_database, ranking_text

    ranked = rank_in_database(db, condition, _read(weights), scene, panel, save=save)
    for text in ranking_text(ranked, style, pareto=pareto, limit=limit):
        click.echo(text, nl=False)
    if ranked.unranked_ids:
        click.echo(f"left out: {len(ranked.unranked_ids):,} designs that are known not to deploy", err=True)
    if save:
        click.echo(f"scores saved: {len(ranked.result.rows):,} designs in {ranked.location}", err=True)


def _read(texts: Sequence[str]) -> dict[str, float]:
    """Parse texts such as dof=2 into weights by name."""
    weights: dict[str, float] = {}
    twice = "the weight of {} is given twice: give it once"
    for text, name, weight in named_numbers(texts, lambda name: QueryError(twice.format(name))):
        if weight is None:
            raise QueryError(f"cannot read the weight {text!r}: write NAME=W, such as dof=2")
        weights[name] = weight
    return weights
