"""`hcsearch count`: exact numbers, nothing stored."""

from __future__ import annotations

import click

from hcsearch.cli.options import make_search, target_options
from hcsearch.cli.progress import Meter


@click.command(epilog="Example: hcsearch count --grid square --array 12x12")
@target_options
def count(grid: str, n: int | None, array_spec: str | None) -> None:
    """Count circuits exactly: all of them, and up to symmetry.

    On an array they are counted by frontier states, without listing; over all arrays of N cells by listing.
    """
    from hcsearch.enumeration import ArraySearch, count_array  # noqa: PLC0415

    search = make_search(grid, n, array_spec)
    if isinstance(search, ArraySearch):
        with Meter("edge") as meter:
            counted = count_array(search.array, meter)
        click.echo(f"array              {search.array.notation}")
        click.echo(f"cells              {search.array.n}")
        click.echo(f"array symmetry     {counted.symmetry}")
        click.echo(f"circuits           {counted.circuits}")
        click.echo(f"up to symmetry     {counted.classes}")
        return
    classes = fixed = 0
    with Meter("batch") as meter:
        for done, prefix in enumerate(search.prefixes, 1):
            for batch in search.circuits(prefix):
                classes += len(batch)
                fixed += int((search.group_order // batch.symmetry).sum())
            meter(done, len(search.prefixes), f"{classes:,} circuits")
    click.echo(f"panels             {search.n}")
    click.echo(f"fixed circuits     {fixed}")
    click.echo(f"up to symmetry     {classes}")
