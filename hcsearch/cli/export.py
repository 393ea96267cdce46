"""`hcsearch export`: a design, an assembly or the designs of a query as files that other programs read."""

from __future__ import annotations

from typing import Any

import click

from hcsearch.cli.cases import export_options, named_options
from hcsearch.cli.options import FiniteNumber, examples_epilog
from hcsearch.cli.progress import ProgressMeter
from hcsearch.export.formats import EXPORT_FORMATS
from hcsearch.export.settings import (
    MAX_KERF_MM,
    MAX_TIMESTEP_S,
    MIN_TIMESTEP_S,
    SETTING_NAMES,
    SHEET_KINDS,
    SHEET_PROFILES,
)


@click.command(
    epilog=examples_epilog(
        "hcsearch export hex:0234435011:1 --output design.fold",
        "hcsearch export 17:4 --output sheet.dxf --sheet panels --kerf 0.2",
        "hcsearch export thesis-4x4 --motion springs --output motion.csv",
        "hcsearch export 'n=12 deployable' --output sheets.zip --format dxf",
    )
)
@export_options
@click.option(
    "--output",
    required=True,
    metavar="FILE|FOLDER",
    help="The file to write, whose ending sets the format; of a query, a folder, a file .zip, or one file of graphs.",
)
@click.option(
    "--format",
    "format_name",
    type=click.Choice(tuple(EXPORT_FORMATS)),
    help="The format, if the ending does not determine it; of the files in a folder or a .zip.",
)
@click.option(
    "--motion",
    type=click.Choice(("path", "springs")),
    help="The planned path from packed to flat, or the motion by springs.  [default: a proved path if there is one]",
)
@click.option(
    "--state",
    "--at",
    "state",
    metavar="flat|folded|SHARE",
    help="The state of solids and stills; a SHARE of the motion is between 0 (packed) and 1 (flat).",
)
@click.option("--sheet", type=click.Choice(SHEET_KINDS), help="Draw the sheet in one piece, or its panels apart.")
@click.option(
    "--kerf", "kerf_mm", type=FiniteNumber(min=0.0, max=MAX_KERF_MM), metavar="MM", help="The width of a cut."
)
@click.option(
    "--hinge-gap",
    "hinge_gap_mm",
    type=FiniteNumber(min=0.0),
    metavar="MM",
    help="The gap along hinges, for --sheet panels.",
)
@click.option(
    "--profile", type=click.Choice(SHEET_PROFILES), help="Use the colours of laser cutters or of Origami Simulator."
)
@click.option("--part", metavar="PANEL", help="Write one panel of solids, named by its number.  [default: all]")
@click.option("--contact", is_flag=True, default=None, help="Let panels collide in MuJoCo.")
@click.option(
    "--timestep",
    "timestep_s",
    type=FiniteNumber(min=MIN_TIMESTEP_S, max=MAX_TIMESTEP_S),
    metavar="S",
    help="The time step of MuJoCo, s.  [default: the time that deploy simulates / 50000]",
)
def export(name: str, output: str, format_name: str | None, motion: Any, **options: Any) -> None:
    r"""Write a file for another program, or a file for each design of a query.

    The ending of the file sets the format; an option that does not apply to the format is refused.

    A QUERY, as of hcsearch query, has an operator, a space or the name of a column. Each of its designs gets a file
    with the name ID-CREASE, in a folder or a .zip with an index; a file .g6 has all graphs, one a line. The command
    continues an interrupted export to a folder.

    \b
    The endings:
    {formats}
    """
    from hcsearch.api.exporting import save, save_designs
    from hcsearch.subjects.resolve import is_query

    settings = {name: options[name] for name in SETTING_NAMES if options[name] is not None}
    arguments = {"format": format_name, "motion": motion, **named_options(options), **settings}
    if not is_query(name):
        for path in save(name, output, **arguments):
            click.echo(path)
        return
    with ProgressMeter("design") as meter:
        saved = save_designs(name, output, progress=meter, **arguments)
    click.echo(saved.path)


_LINES = (f"    {' '.join(form.endings):11} {form.description}" for form in EXPORT_FORMATS.values())
# lines that are kept as they are follow the character \b, and are indented as the docstring is
export.help = (export.help or "").replace("\\b", "\b").replace("    {formats}", "\n".join(_LINES))
