"""`hcsearch init`: a scene file to start from."""

from __future__ import annotations

import click

from hcsearch.basics.errors import printable
from hcsearch.cli.options import examples_epilog
from hcsearch.designs.grid import GRIDS


@click.command(
    epilog=examples_epilog(
        "hcsearch init solar.toml --panel 300x12", "hcsearch init solar.toml --grid rectangle --panel 80x40x6"
    )
)
@click.argument("path", metavar="FILE.toml")
@click.option(
    "--panel",
    metavar="LxWxT",
    help="Size of the panels in mm: length, width and thickness, or side and thickness, or with --grid 'across WxT'.  "
    "[default: left open]",
)
@click.option("--grid", type=click.Choice(tuple(GRIDS)), help="The grid of the panels, by which their size is checked.")
def init(path: str, panel: str | None, grid: str | None) -> None:
    """Write a scene file to start from.

    The file has every value of a scene, with its default, its unit and one line. Edit it, and give it to enumerate,
    deploy and other commands with --scene FILE.toml. A file that exists is not replaced.
    """
    from hcsearch.api.initializing import init_scene

    written = init_scene(path, panel=panel, grid=grid)
    click.echo(printable(str(written)))
