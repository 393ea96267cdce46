"""`hcsearch count`: exact numbers, nothing stored."""

from __future__ import annotations

import click

from hcsearch.cli.options import make_search, target_options


@click.command(epilog="Example: hcsearch count --grid square --array 12x12")
@target_options
def count(grid: str, n: int | None, array_spec: str | None) -> None:
    """Count circuits exactly: all of them, and up to symmetry.

    On an array they are counted by frontier states, without listing; over all arrays of N cells by listing.
    """
    from hcsearch.enumeration import ArraySearch, count_array  # noqa: PLC0415

    search = make_search(grid, n, array_spec)
    if isinstance(search, ArraySearch):
        counted = count_array(search.array)
        click.echo(f"array              {search.array.notation}")
        click.echo(f"cells              {search.array.n}")
        click.echo(f"array symmetry     {counted.symmetry}")
        click.echo(f"circuits           {counted.circuits}")
        click.echo(f"up to symmetry     {counted.classes}")
        return
    classes = fixed = 0
    for batch in search.batches():
        classes += len(batch)
        fixed += int((search.group_order // batch.symmetry).sum())
    click.echo(f"panels             {search.n}")
    click.echo(f"fixed circuits     {fixed}")
    click.echo(f"up to symmetry     {classes}")
