"""`hcsearch show`: one design, folding, assembly or pattern in full."""

from __future__ import annotations

import click

from hcsearch.basics.errors import HcsearchError, printable
from hcsearch.cli.cases import scene_options
from hcsearch.cli.options import database_option, examples_epilog


@click.command(
    epilog=examples_epilog(
        "hcsearch show 17:4",
        "hcsearch show hex:0234550132",
        "hcsearch show 17 --html --output design.html",
        "hcsearch show unit-ii --html",
        "hcsearch show strip.fold --html",
        "hcsearch show springs.toml --html",
    )
)
@click.argument("design", metavar="DESIGN[:CREASE]|ASSEMBLY|FILE.toml|FILE.fold")
@database_option
@scene_options
@click.option("--html", "as_html", is_flag=True, help="Write a page with all results, plots, and motions to play.")
@click.option(
    "--output",
    metavar="FILE",
    help="The file of the page.  [default: reports/design-DESIGN.html, reports/assembly-ASSEMBLY.html, "
    "reports/pattern-FILE.html or, of a file .toml, reports/case-FILE.html]",
)
def show(design: str, db: str, scene: str | None, panel: str | None, as_html: bool, output: str | None) -> None:
    """Print a design and its foldings, an assembly of the thesis or a pattern of your own, or write a page.

    A design is named by its id in the database or by the notation of its circuit, which may be in any position, order
    or direction and needs no database. DESIGN:CREASE shows one folding. Creases have the numbers of the canonical
    circuit, which the first line shows.

    For foldings without twist the command prints the degrees of freedom and whether the folded or the flat state is
    proved to be locked, and for a design named by its id the paths and deployments in the database. Status and numbers
    are those in a scene, and so are all results on the page; for a circuit, motions are planned and simulated anew.

    For an assembly, the command prints its properties like `hcsearch assembly`, and the page plays its motion by
    springs. For a pattern of panels, .fold, .cp, .opx or .svg, or a model .urdf, .xml or .mjcf, it prints the
    degrees of freedom and the locks, and the page also plays the planned path; a file that draws a design stands for
    it.

    FILE.toml is a scene that names a folding, an assembly or a pattern, as `hcsearch tune` and `hcsearch drive` write
    it. The command shows what it names, with these sizes, and the page plays its motion with these springs or drives.
    """
    if output and not as_html:
        raise HcsearchError("--output applies to a page: add --html")
    from hcsearch.api import showing

    if as_html:
        click.echo(printable(str(showing.show_page(design, output, db=db, scene=scene, panel=panel))))
        return
    for line in showing.show(design, db=db, scene=scene, panel=panel).lines():
        click.echo(line)
