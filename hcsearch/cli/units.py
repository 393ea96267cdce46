"""`hcsearch units`: single-DoF units made of copies of one element."""

from __future__ import annotations

import json
from collections import Counter
from typing import TYPE_CHECKING

import click

from hcsearch.basics.errors import printable
from hcsearch.cli.options import FiniteNumber, examples_epilog
from hcsearch.cli.progress import ProgressMeter
from hcsearch.designs.grid import GRIDS

if TYPE_CHECKING:
    from hcsearch.library.unit_search.unit_search import ElementSearchResult

_SHOWN = ("copies", "panels", "hinges", "directions", "kutzbach", "dof_folded", "dof_flat", "deployment_ratio")


@click.command(
    epilog=examples_epilog("hcsearch units --grid triangle --n 10", "hcsearch units --grid triangle --n 10 --alpha 70")
)
@click.option("--grid", type=click.Choice(tuple(GRIDS)), required=True, help="The tiling whose cells are the panels.")
@click.option("--n", type=int, required=True, metavar="N", help="The number of panels of an element.")
@click.option("--alpha", type=FiniteNumber(), metavar="DEGREES", help="Use isosceles triangles with this base angle.")
@click.option(
    "--max-dof", type=click.IntRange(min=1), metavar="D", help="Leave out elements with more degrees of freedom."
)
@click.option(
    "--copies",
    type=click.Choice(("2", "4", "both")),
    default="both",
    show_default=True,
    help="How many copies of the element make a unit.",
)
@click.option(
    "--most",
    type=click.IntRange(min=1),
    default=20_000,
    show_default=True,
    help="The greatest number of unions that are tried for one element.",
)
@click.option(
    "--seconds",
    type=FiniteNumber(min=0),
    metavar="S",
    help="The greatest time for one element, s.  [default: no limit]",
)
@click.option(
    "--db", metavar="PATH|URL", help="The database in which units are stored.  [default: they are only printed]"
)
@click.option("--json", "as_json", is_flag=True, help="Print each unit as a line of JSON.")
def units(
    grid: str,
    n: int,
    alpha: float | None,
    max_dof: int | None,
    copies: str,
    most: int,
    seconds: float | None,
    db: str | None,
    as_json: bool,
) -> None:
    """Search for units with one degree of freedom.

    A unit consists of two or four copies of an element that share panels, so that some of their hinges become one.
    Elements are the foldings without twist of all designs of N panels, with rigid flat creases. All positions of two
    copies and of rings of four are tried. A unit is reported if it moves from the folded to the flat state with one
    degree of freedom, by rank and path in floating-point numbers.
    """
    from hcsearch.api import searching_units

    counts = {"2": (2,), "4": (4,), "both": (2, 4)}[copies]
    count = n_new = 0
    with ProgressMeter("union") as meter:
        for result, added in searching_units.search_units(
            grid, n, alpha=alpha, max_dof=max_dof, copies=counts, most=most, seconds=seconds, db=db, progress=meter
        ):
            count, n_new = count + len(result.units), n_new + added
            if as_json:
                for unit in result.units:
                    click.echo(json.dumps(unit.row()))
            else:
                _print(result)
    if not as_json:
        stored = "" if db is None else f", {n_new} of them new in {printable(db)}"
        click.echo(f"{count} units{stored}")


def _print(result: ElementSearchResult) -> None:
    element = result.element
    if result.skipped:
        click.echo(f"{element.name}  {result.skipped}")
        return
    against = Counter(unit.proof.verdict for unit in result.refuted)
    suffix = "".join(f", {count} {verdict}" for verdict, count in sorted(against.items()))
    suffix += "" if result.complete else ", not all within the limits"
    click.echo(
        f"{element.name}  dof {element.dof}, {result.placements} placements, {result.unions} unions, "
        f"{result.foldable} that fold, {result.single_dof} with one degree of freedom, "
        f"{len(result.units)} units{suffix}"
    )
    for unit in result.units:
        row = unit.row()
        numbers = ", ".join(f"{name} {row[name]:g}" for name in _SHOWN)
        contact = "panels cut through each other" if row["contact"] else "no contact"
        click.echo(f"    {row['known'] or 'unit'}: {numbers}, {contact}")
