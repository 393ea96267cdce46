"""`hcsearch atlas`: the data set of all designs with up to n panels."""

from __future__ import annotations

import click

from hcsearch.cli.options import examples_epilog
from hcsearch.cli.progress import SHARE, ProgressMeter
from hcsearch.designs.grid import GRIDS


@click.command(
    epilog=examples_epilog(
        "hcsearch atlas --output atlas", "hcsearch atlas --output hex --grid hex --n 10 --until twist"
    )
)
@click.option("--output", required=True, metavar="DIR", help="The folder to write, empty or of this atlas.")
@click.option("--n", type=int, default=12, show_default=True, help="The greatest number of panels.")
@click.option(
    "--grid",
    "grids",
    type=click.Choice(list(GRIDS)),
    multiple=True,
    help="A grid, repeatable.  [default: all]",
)
@click.option("--until", metavar="STAGE", help="The last stage, as of hcsearch enumerate.  [default: the last one]")
@click.option("--jobs", type=click.IntRange(min=1), metavar="K", help="Number of processes.  [default: one per core]")
def atlas(output: str, n: int, grids: tuple[str, ...], until: str | None, jobs: int | None) -> None:
    """Build the data set of all designs with up to n panels.

    The folder gets Parquet files, an SQLite database, certificates, counts in the form of the OEIS, a description with
    checksums, and a page that searches the designs in a browser without a server. The same versions of the program and
    its libraries write the same bytes. The same command continues an interrupted atlas, and checks a finished one.
    """
    from hcsearch.api.building_atlas import build_atlas
    from hcsearch.system.terminal import bytes_text

    with ProgressMeter(SHARE) as meter:
        built = build_atlas(
            output,
            n=n,
            grids=list(grids) or None,
            until=until,
            jobs=jobs,
            progress=meter,
            announce=lambda sentence: click.echo(sentence, err=True),
        )
    click.echo(f"{built.designs:,} designs, {built.foldings:,} foldings")
    click.echo(f"{built.files:,} files, {bytes_text(built.size)}")
    click.echo(f"SHA-256 of {output}/SHA256SUMS: {built.checksum}")
