"""`hcsearch count`: exact counts, without storing circuits."""

from __future__ import annotations

import click

from hcsearch.basics.vocabulary import Keep
from hcsearch.cli.options import examples_epilog, target_options, worker_options
from hcsearch.cli.progress import ProgressMeter


@click.command(
    epilog=examples_epilog(
        "hcsearch count --grid square --array 12x12", "hcsearch count --grid hex --n 20 --keep untwisted"
    )
)
@target_options
@worker_options
def count(
    grid: str, n: int | None, array_spec: str | None, keep: Keep, jobs: int | None, scheduler: str | None
) -> None:
    """Count circuits, or designs that fold, exactly.

    The command prints the number of all circuits and their number up to symmetry; with --keep it counts only those that
    fold. Circuits of one array are counted by the states of a frontier, without listing them; designs that fold, over
    all arrays of N cells, by joining half-chains; all others by listing them.
    """
    from hcsearch.api import counting
    from hcsearch.designs.folding import no_folding_reason
    from hcsearch.search.enumeration import ArraySearch

    is_single_array = array_spec is not None and keep == "all"
    with ProgressMeter("edge" if is_single_array else "batch") as meter:
        counted = counting.count(
            grid=grid,
            n=n,
            array=array_spec,
            keep=keep,
            jobs=jobs,
            scheduler=scheduler,
            progress=meter,
            announce=lambda sentence: click.echo(sentence, err=True),
        )
    search = counted.search
    if isinstance(search, ArraySearch):
        click.echo(f"array              {search.array.notation}")
        click.echo(f"cells              {search.array.n}")
        click.echo(f"array symmetry     {search.group_order}")
    else:
        click.echo(f"panels             {search.n}")
    circuits = "circuits" if isinstance(search, ArraySearch) else "fixed circuits"
    if keep != "all":
        click.echo(f"kept               {keep}")
    click.echo(f"{circuits:<19}{counted.circuits}")
    click.echo(f"{'up to symmetry':<19}{counted.classes}")
    if keep != "all" and search.n % 2:
        click.echo(f"nothing folds: {no_folding_reason(search.n)}", err=True)
